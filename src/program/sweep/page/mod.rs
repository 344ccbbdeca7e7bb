//! `index.html`: the sweep on one page that needs nothing beside it.

mod chart;

use std::fmt::Write;
use std::path::Path;

use serde_json::Value;

use super::contact_sheet;
use super::luminance::LuminanceScale;
use super::manifest::{Entry, FileDigest, Manifest};
use crate::error::{Error, Result};
use crate::output;
use crate::program::figure::scale_colors;

const NAME: &str = "index.html";

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
    for entry in &manifest.views {
        let picture = data_uri(folder, &format!("{}.png", entry.name))?;
        let luminance = data_uri(folder, &luminance_name(&entry.name))?;
        links += &link(entry);
        sections += &section(entry, &picture, &luminance);
    }
    let last = manifest.views.len().saturating_sub(1);
    Ok(format!(
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>\
         <meta name='viewport' content='width=device-width'><title>{title}</title>\n\
         <style>\n{}</style></head><body>\n<h1>{title}</h1>\n{}\
         <nav><input type='range' min='0' max='{last}' value='0' aria-label='view'>\
         <output></output></nav>\n<div class='sheet'>\n{links}</div>\n{sections}\
         <script src='timings.js'></script>\n<script>\n{}</script>\n</body></html>\n",
        include_str!("style.css"),
        provenance(manifest),
        include_str!("page.js"),
    ))
}

/// Name of the picture of a view's luminance in false color.
pub fn luminance_name(view: &str) -> String {
    format!("{view}_luminance.png")
}

fn data_uri(folder: &Path, name: &str) -> Result<String> {
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
    let display = manifest.display.get("name").and_then(Value::as_str).unwrap_or_default();
    rows += &row("display", display);
    for file in source.script.iter().chain(&source.inputs) {
        rows += &row(&file.path, &format!("SHA-256 {}", file.digest));
    }
    format!("<details><summary>made from</summary><table>{rows}</table></details>\n")
}

fn row(name: &str, value: &str) -> String {
    format!("<tr><th>{}</th><td>{}</td></tr>", escape(name), escape(value))
}

fn number(value: &Value, keys: &[&str]) -> f64 {
    let found = keys.iter().try_fold(value, |value, key| value.get(key));
    found.and_then(Value::as_f64).unwrap_or_default()
}

/// A view in a few words.
fn title(entry: &Entry) -> String {
    let view = entry.details.get("view").unwrap_or(&Value::Null);
    let (azimuth, elevation) = (number(view, &["azimuth"]), number(view, &["elevation"]));
    format!("{}: azimuth {azimuth}°, elevation {elevation}°", entry.name)
}

/// The page's script puts the picture in, which is in the page once.
fn link(entry: &Entry) -> String {
    let (name, title) = (escape(&entry.name), escape(&title(entry)));
    format!("<a href='#{name}'><img alt=''>{title}</a>\n")
}

fn section(entry: &Entry, picture: &str, luminance: &str) -> String {
    let details = Value::from(entry.details.clone());
    let (name, title) = (escape(&entry.name), escape(&title(entry)));
    let regions: Vec<(&String, &Value)> =
        details.get("regions").and_then(Value::as_object).into_iter().flatten().collect();
    let size = [number(&details, &["view", "width"]), number(&details, &["view", "height"])];
    let mut html = format!(
        "<section id='{name}' data-title='{title}'><h2>{title}</h2>\n<div class='pictures'>\
         <figure><div class='picture'><img alt='{title}' src='{picture}'>{}</div>\
         <figcaption>as the display shows it, exposure {:.4e}</figcaption></figure>\
         <figure><div class='picture'><img alt='luminance' src='{luminance}'></div>{}</figure>\
         </div>\n",
        outlines(&regions, size),
        number(&details, &["exposure"]),
        luminance_legend(&details),
    );
    if !regions.is_empty() {
        let (spectra, colors) = (chart::spectra(&regions), chart::chromaticities(&regions));
        html += &format!("<div class='charts'>{spectra}{colors}</div>{}", readings(&regions));
    }
    html + &facts(&details) + "</section>\n"
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

fn readings(regions: &[(&String, &Value)]) -> String {
    let mut html = "<table><tr><th>region</th><th>luminance</th><th>x</th><th>y</th>\
                    <th>UN R48</th></tr>"
        .to_owned();
    for (at, (name, region)) in regions.iter().enumerate() {
        let xy = region.get("chromaticity").filter(|xy| !xy.is_null());
        let part = |c: usize| {
            xy.and_then(|xy| xy.get(c)?.as_f64()).map_or("–".into(), |v| format!("{v:.4}"))
        };
        let color = region.get("color").and_then(Value::as_str).unwrap_or("none");
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

/// What the colors of a luminance picture mean.
fn luminance_legend(details: &Value) -> String {
    /// As many colors make a smooth band.
    const STOPS: usize = 16;
    let scale = LuminanceScale {
        top: number(details, &["luminance", "top"]) as i32,
        max: number(details, &["luminance", "max"]),
    };
    let absolute = details.get("photometry").and_then(Value::as_str) == Some("absolute");
    let unit = if absolute { " cd/m²" } else { "" };
    let all = scale_colors();
    let stops = (0..STOPS).map(|stop| all[stop * (all.len() - 1) / (STOPS - 1)]);
    let colors: Vec<String> = stops.map(|[r, g, b]| format!("rgb({r},{g},{b})")).collect();
    let decades = scale.decades().map(|exponent| format!("<span>1e{exponent}</span>"));
    format!(
        "<div class='legend' style='background:linear-gradient(to right,{})'></div>\
         <div class='decades'>{}</div><figcaption>{}</figcaption>",
        colors.join(","),
        decades.collect::<String>(),
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
