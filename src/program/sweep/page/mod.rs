//! `index.html`: the sweep on one page that needs nothing beside it.

mod chart;

use std::fmt::Write;
use std::path::Path;

use serde_json::Value;

use super::contact_sheet;
use super::digest::Digest;
use super::luminance::LuminanceScale;
use super::manifest::{Entry, FileDigest, Manifest};
use crate::error::{Error, Result};
use crate::output;
use crate::program::figure::scale_colors;

const NAME: &str = "index.html";
const SCRIPT: &str = include_str!("page.js");

/// Beyond, the page names the pictures' files instead of holding them.
const MOST_HELD: usize = 500;

/// Writes contact sheet and page; the same manifest and files give the same bytes.
///
/// Errors: [`Error::Io`]; a PNG file that does not read back.
pub(super) fn write(folder: &Path, manifest: &Manifest) -> Result<Vec<FileDigest>> {
    let mut pages = Vec::new();
    if let Some(sheet) = contact_sheet::write(folder, manifest)? {
        pages.push(FileDigest::of(folder, sheet)?);
    }
    output::write_text(&folder.join(NAME), &html(folder, manifest)?)?;
    pages.push(FileDigest::of(folder, NAME)?);
    Ok(pages)
}

fn html(folder: &Path, manifest: &Manifest) -> Result<String> {
    let script = manifest.source.script.as_ref().map_or("sweep", |file| &file.path);
    let title = format!("{} · {} views", escape(script), manifest.views.len());
    let mut links = String::new();
    let mut sections = String::new();
    let is_held = manifest.views.len() <= MOST_HELD;
    for entry in &manifest.views {
        let picture = source(folder, &format!("{}.png", entry.name), is_held)?;
        let luminance = source(folder, &luminance_name(&entry.name), is_held)?;
        links += &link(entry);
        sections += &section(entry, &picture, &luminance)?;
    }
    let last = manifest.views.len().saturating_sub(1);
    // Nothing but this script runs, whatever a manifest may say.
    let script = format!("\n{}{SCRIPT}", color_scale());
    let script_digest = output::base64(&Digest::of_bytes(script.as_bytes()).to_bytes());
    Ok(format!(
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>\
         <meta http-equiv='Content-Security-Policy' content=\"default-src 'none'; \
         img-src data: 'self' file:; style-src 'unsafe-inline'; \
         script-src 'self' file: 'sha256-{script_digest}'\"><meta name='viewport' content='width=device-width'><title>{title}</title>\n\
         <style>\n{}</style></head><body>\n<h1>{title}</h1>\n{}\
         <nav><input type='range' min='0' max='{last}' value='0' aria-label='view'>\
         <output></output></nav>\n<div class='sheet'>\n{links}</div>\n{sections}{}\
         <script src='timings.js'></script>\n<script>{script}</script>\n</body></html>\n",
        include_str!("style.css"),
        provenance(manifest),
        over_angles(&manifest.views)?,
    ))
}

/// Name of the picture of a view's luminance in false color.
pub fn luminance_name(view: &str) -> String {
    format!("{view}_luminance.png")
}

/// Where a picture comes from: the page itself, or the file beside it.
fn source(folder: &Path, name: &str, is_held: bool) -> Result<String> {
    if !is_held {
        return Ok(escape(name));
    }
    let path = folder.join(name);
    let bytes = std::fs::read(&path).map_err(|e| Error::io(&path, e))?;
    Ok(format!("data:image/png;base64,{}", output::base64(&bytes)))
}

/// Text that may stand between tags and in attributes.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            c => escaped.push(c),
        }
    }
    escaped
}

fn provenance(manifest: &Manifest) -> String {
    let source = &manifest.source;
    let mut rows = row("program", &source.program);
    let look = manifest.pictures.get("look").unwrap_or(&Value::Null);
    let text = |value: Option<&Value>| value.and_then(Value::as_str).unwrap_or_default().to_owned();
    rows += &row("display", &text(look.get("display").and_then(|display| display.get("name"))));
    let (tone, gamut) = (text(look.get("tone")), text(look.get("gamut")));
    rows += &row("look", &format!("tone {tone}, gamut {gamut}"));
    rows += &row("exposure", exposure_in_words(manifest, look));
    for file in source.script.iter().chain(&source.inputs) {
        rows += &row(&file.path, &format!("SHA-256 {}", file.digest));
    }
    format!("<details><summary>made from</summary><table>{rows}</table></details>\n")
}

fn exposure_in_words(manifest: &Manifest, look: &Value) -> &'static str {
    let is_one = manifest.pictures.get("exposure").and_then(Value::as_str) == Some("one");
    match (look.get("exposure").and_then(Value::as_str), is_one) {
        (Some("auto"), true) => "one for all views: that of the brightest",
        (Some("auto"), false) => "each view has its own",
        _ => "given, the same for all views",
    }
}

/// Luminance, and where there is one intensity, over the angle that changes most.
fn over_angles(views: &[Entry]) -> Result<String> {
    let angle = |entry: &Entry, key: &str| {
        entry.details.get("view").map_or(0.0, |view| number(view, &[key]))
    };
    let extent = |key: &str| {
        let angles = views.iter().map(|entry| angle(entry, key));
        angles.clone().fold(f64::MIN, f64::max) - angles.fold(f64::MAX, f64::min)
    };
    let key = if extent("azimuth") >= extent("elevation") { "azimuth" } else { "elevation" };
    if views.len() < 2 || extent(key) <= 0.0 {
        return Ok(String::new());
    }
    let details = Value::from(views[0].details.clone());
    let unit = luminance_unit(&details);
    let quantities = [
        (format!("largest luminance{unit}"), &["luminance", "max"][..]),
        (format!("mean luminance{unit}"), &["luminance", "mean"]),
        ("intensity (cd)".to_owned(), &["intensity"]),
    ];
    let mut charts = String::new();
    for (label, keys) in quantities {
        let value = |entry: &Entry| {
            let details = Value::from(entry.details.clone());
            let found = keys.iter().try_fold(&details, |value, key| value.get(key));
            found.and_then(Value::as_f64).map(|value| [angle(entry, key), value])
        };
        let mut points: Vec<[f64; 2]> = views.iter().filter_map(value).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        if !points.is_empty() {
            charts += &chart::over_angle(&label, &format!("{key} (°)"), points)?;
        }
    }
    Ok(format!("<h2>over the angle</h2><div class='charts'>{charts}</div>\n"))
}

/// In brackets, or nothing for relative light.
fn luminance_unit(details: &Value) -> &'static str {
    match details.get("photometry").and_then(Value::as_str) {
        Some("absolute") => " (cd/m²)",
        _ => " (relative)",
    }
}

/// The colors of luminance for the page's script.
fn color_scale() -> String {
    format!("const lampyrisColors = {:?};\n", scale_colors())
}

fn row(name: &str, value: &str) -> String {
    format!("<tr><th>{}</th><td>{}</td></tr>", escape(name), escape(value))
}

fn number(value: &Value, keys: &[&str]) -> f64 {
    let found = keys.iter().try_fold(value, |value, key| value.get(key));
    found.and_then(Value::as_f64).unwrap_or_default()
}

/// A view in a few words.
pub(super) fn title(entry: &Entry) -> String {
    let view = entry.details.get("view").unwrap_or(&Value::Null);
    let (azimuth, elevation) = (number(view, &["azimuth"]), number(view, &["elevation"]));
    format!("{}: azimuth {azimuth}°, elevation {elevation}°", entry.name)
}

/// The page's script puts the picture in, which is in the page once.
fn link(entry: &Entry) -> String {
    let (name, title) = (escape(&entry.name), escape(&title(entry)));
    format!("<a href='#{name}'><img alt='' loading='lazy'>{title}</a>\n")
}

fn section(entry: &Entry, picture: &str, luminance: &str) -> Result<String> {
    let details = Value::from(entry.details.clone());
    let (name, title) = (escape(&entry.name), escape(&title(entry)));
    let regions: Vec<(&String, &Value)> =
        details.get("regions").and_then(Value::as_object).into_iter().flatten().collect();
    let size = [number(&details, &["view", "width"]), number(&details, &["view", "height"])];
    let unit = if luminance_unit(&details) == " (cd/m²)" { " cd/m²" } else { "" };
    let [low, high] = luminance_scale(&details).range;
    let mut html = format!(
        "<section id='{name}' data-title='{title}'><h2>{title}</h2>\n<div class='pictures'>\
         <figure><div class='picture'><img alt='{title}' loading='lazy' src='{picture}'>{}</div>\
         <figcaption>as the display shows it, exposure {:.4e} \
         (cd/m² of the display for 1{})</figcaption></figure>\
         <figure><div class='picture luminance' data-low='{low}' data-high='{high}' \
         data-unit='{unit}'><img alt='luminance' loading='lazy' src='{luminance}'></div>{}\
         <p class='reading'>luminance under the pointer: –</p></figure>\
         </div>\n",
        outlines(&regions, size),
        number(&details, &["exposure"]),
        if unit.is_empty() { " of the image's relative unit" } else { unit },
        luminance_legend(&details),
    );
    if !regions.is_empty() {
        let (spectra, colors) = (chart::spectra(&regions)?, chart::chromaticities(&regions)?);
        html += &format!(
            "<div class='charts'>{spectra}{colors}</div>{}",
            readings(&regions, luminance_unit(&details))
        );
    }
    Ok(html + &facts(&details) + "</section>\n")
}

/// The regions, drawn over the picture.
fn outlines(regions: &[(&String, &Value)], [width, height]: [f64; 2]) -> String {
    let rectangles = regions.iter().enumerate().map(|(at, (_, region))| {
        let side = |key| number(region, &[key]);
        let color = chart::color(at);
        let (x, y, w, h) = (side("x"), side("y"), side("width"), side("height"));
        format!("<rect x='{x}' y='{y}' width='{w}' height='{h}' stroke='{color}'/>")
    });
    let rectangles: String = rectangles.collect();
    format!("<svg viewBox='0 0 {width} {height}' preserveAspectRatio='none'>{rectangles}</svg>")
}

fn readings(regions: &[(&String, &Value)], unit: &str) -> String {
    let mut html = format!(
        "<table><tr><th>region</th><th>luminance{unit}</th><th>x</th><th>y</th>\
         <th>UN R48</th></tr>"
    );
    for (at, (name, region)) in regions.iter().enumerate() {
        let xy = region.get("chromaticity").filter(|xy| !xy.is_null());
        let part = |c: usize| {
            xy.and_then(|xy| xy.get(c)?.as_f64()).map_or("–".into(), |v| format!("{v:.4}"))
        };
        let color = escape(region.get("color").and_then(Value::as_str).unwrap_or("none"));
        let _ = write!(
            html,
            "<tr><td><span class='key' style='background:{}'></span>{}</td><td>{:.4e}</td>\
             <td>{}</td><td>{}</td><td>{color}</td></tr>",
            chart::color(at),
            escape(name),
            number(region, &["luminance"]),
            part(0),
            part(1),
        );
    }
    html + "</table>"
}

/// Quality, statistics and seconds.
fn facts(details: &Value) -> String {
    let mut rows = "<tr><th>time</th><td class='seconds'>–</td></tr>".to_owned();
    for part in ["view", "quality", "stats"] {
        let fields = details.get(part).and_then(Value::as_object).into_iter().flatten();
        let texts: Vec<String> = fields.map(|(key, value)| format!("{key} {value}")).collect();
        rows += &row(part, &texts.join(", "));
    }
    format!("<table>{rows}</table>")
}

fn luminance_scale(details: &Value) -> LuminanceScale {
    let range = details.get("false_color");
    let end = |at: usize| range.and_then(|range| range.get(at)?.as_f64());
    let range = end(0).zip(end(1)).map_or(LuminanceScale::BLACK, |(low, high)| [low, high]);
    LuminanceScale { range, max: number(details, &["luminance", "max"]) }
}

/// What the colors of a luminance picture mean.
fn luminance_legend(details: &Value) -> String {
    /// As many colors make a smooth band.
    const STOPS: usize = 16;
    let scale = luminance_scale(details);
    let absolute = details.get("photometry").and_then(Value::as_str) == Some("absolute");
    let unit = if absolute { " cd/m²" } else { "" };
    let all = scale_colors();
    let stops = (0..STOPS).map(|stop| all[stop * (all.len() - 1) / (STOPS - 1)]);
    let colors: Vec<String> = stops.map(|[r, g, b]| format!("rgb({r},{g},{b})")).collect();
    let marks = scale.marks().map(|luminance| format!("<span>{luminance:.2e}</span>"));
    format!(
        "<div class='legend' style='background:linear-gradient(to right,{})'></div>\
         <div class='decades'>{}</div><figcaption>{}</figcaption>",
        colors.join(","),
        marks.concat(),
        scale.text(unit)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_break_out_of_the_page() {
        assert_eq!(escape("<b a='x'>\"&"), "&lt;b a=&#39;x&#39;&gt;&quot;&amp;");
    }
}
