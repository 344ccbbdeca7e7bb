//! What a file holds, in words: EXR images, ray files, meshes, spectrum tables, manifests.

use std::path::Path;

use crate::columns::{Table, TableChoice};
use crate::display::{self, ProfiledDisplay};
use crate::error::{Error, Place, Result};
use crate::geometry::import::{self, MeshFile, MeshReading};
use crate::input;
use crate::output;
use crate::program::results::{MESH, NamedMesh, START_SURFACE};
use crate::program::sweep::Manifest;
use crate::source::Starts;
use crate::source::photometric;
use crate::source::rayfile::{self, RayFile, SpectrumSource};
use crate::spectrum::Spectrum;

/// Bytes that tell what a file is.
const START: u64 = 4096;

/// A description of several lines, the first of which starts with the path.
///
/// EXR files and manifests are told by their first bytes, meshes by them or by their name; the
/// rest are rays, or else a spectrum.
/// Errors: a file of none of these kinds, or a broken one.
pub fn describe(path: &Path) -> Result<String> {
    let start = input::head(path, START)?;
    let name = path.display();
    if start.is_empty() {
        return Err(Error::bad_file(path, Place::File, "is empty"));
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let lines = match (start.as_slice(), extension.to_ascii_lowercase().as_str()) {
        ([0x76, 0x2f, 0x31, 0x01, ..], _) => exr(path)?,
        ([b'{', ..], "json") => manifest(path)?,
        (start, _) if import::is_mesh(path, start) => mesh(path)?,
        (start, _) if display::is_icc_profile(start) => profile(path)?,
        (start, _) if photometric::is_photometric(start) => photometric(path)?,
        _ => rays_or_table(path)?,
    };
    Ok(format!("{name}: {}", lines.join("\n  ")))
}

fn rays_or_table(path: &Path) -> Result<Vec<String>> {
    let not_rays = match rayfile::read(path) {
        Ok(file) => return Ok(rays(&file)),
        Err(error) => error,
    };
    match Table::read(path).and_then(|read| table(&read)) {
        Ok(lines) => Ok(lines),
        Err(no_table) => {
            let problem = format!("holds neither rays ({not_rays}) nor a table ({no_table})");
            Err(Error::bad_file(path, Place::File, problem))
        }
    }
}

/// A monitor's profile.
fn profile(path: &Path) -> Result<Vec<String>> {
    let ProfiledDisplay { display, notes } = display::read_profile(path, None)?;
    let white = display.white();
    let [x, y] = white.chromaticity().unwrap_or_default();
    let mut lines = vec![format!("ICC profile of a display: {}", display.name())];
    lines.push(format!("white {:.1} cd/m² at ({x:.4}, {y:.4})", white.y));
    lines.extend(notes);
    Ok(lines)
}

/// What a photometric file holds.
fn photometric(path: &Path) -> Result<Vec<String>> {
    let file = photometric::read(path)?;
    let [planes, tilts] = file.solid.size();
    let mut lines = vec![format!(
        "{} file, type {}, {planes} × {tilts} angles",
        file.format,
        file.solid.angle_type()
    )];
    lines.push(format!("luminous flux: {:.4} lm by its intensities", file.solid.flux_lm()));
    lines.extend(file.lamp_flux_lm.map(|flux| format!("flux of its lamps: {flux} lm")));
    lines.push(format!("largest intensity: {} cd", file.solid.peak_cd()));
    lines.push(format!(
        "luminous opening: {} mm, good beyond {} mm",
        file.opening_mm,
        file.good_beyond_mm()
    ));
    lines.extend(file.description.iter().map(|(name, text)| format!("{name}: {text}")));
    lines.extend(file.warnings.iter().map(|warning| format!("warning: {warning}")));
    Ok(lines)
}

fn exr(path: &Path) -> Result<Vec<String>> {
    let info = output::read_exr_info(path)?;
    let mut lines = vec![format!(
        "EXR image, {} × {}, {} channels",
        info.width,
        info.height,
        info.channels.len()
    )];
    let bands = &info.wavelengths_nm;
    if let (Some(first), Some(last)) = (bands.first(), bands.last()) {
        lines.push(format!("spectrum: {} bands, {first} to {last} nm", bands.len()));
    }
    let rest = info.channels.iter().filter(|name| !name.starts_with("S0."));
    lines.push(format!("channels: {}", rest.cloned().collect::<Vec<_>>().join(" ")));
    lines.extend(info.attributes.iter().map(|(key, value)| format!("{key}: {value}")));
    Ok(lines)
}

fn manifest(path: &Path) -> Result<Vec<String>> {
    let manifest = Manifest::read(path)?;
    let state = if manifest.is_complete { "finished" } else { "unfinished" };
    let mut lines = vec![format!("{state} sweep of {} views", manifest.views.len())];
    lines.push(format!("made by {}", manifest.source.program));
    let files = manifest.source.script.iter().chain(&manifest.source.inputs);
    lines.extend(files.map(|file| format!("from {}, SHA-256 {}", file.path, file.digest)));
    Ok(lines)
}

fn mesh(path: &Path) -> Result<Vec<String>> {
    let file = import::load(path, &MeshReading::default())?;
    let MeshFile { mesh, format, .. } = &file;
    let mut lines = vec![
        format!("{format} mesh, {} triangles", mesh.triangles.len()),
        format!("{} vertices, those at one place counted once", mesh.positions.len()),
    ];
    let others = [
        file.unit_warning(),
        file.size_warning(),
        file.inside_out_warning(),
        file.normals_warning(),
    ];
    let warnings: Vec<String> =
        file.warnings.iter().cloned().chain(others.into_iter().flatten()).collect();
    lines.extend(MESH.lines(&NamedMesh::from(file)));
    lines.extend(warnings.iter().map(|warning| format!("warning: {warning}")));
    Ok(lines)
}

/// What a table was taken for, and what it holds.
fn table(table: &Table) -> Result<Vec<String>> {
    let mut lines = table.reading.lines();
    let names: Vec<&str> = table.names.iter().map(String::as_str).collect();
    if !names.is_empty() && names.len() <= 16 {
        lines.push(format!("columns: {}", names.join(", ")));
    }
    if table.is_scatter() {
        let scatter = table.scatter(None)?;
        let (count, incidence) = (scatter.points.len(), scatter.incidence_deg);
        lines.push(format!("{count} points in the plane of incidence at {incidence}°"));
        return Ok(lines);
    }
    match table.curve(&TableChoice::default()) {
        Ok(curve) => {
            lines.extend(curve.notes.iter().cloned());
            lines.extend(spectrum(&Spectrum::from(curve)));
        }
        Err(error) if table.row_count() == 0 => return Err(error),
        Err(error) => {
            lines.push(format!("{} rows, no spectrum: {error}", table.row_count()));
        }
    }
    Ok(lines)
}

fn spectrum(spectrum: &Spectrum) -> Vec<String> {
    let lambda_nm = spectrum.wavelengths_nm();
    let (first, last) = (lambda_nm[0], lambda_nm[lambda_nm.len() - 1]); // never empty
    let mut lines = vec![
        format!("as spectrum: {} rows, {first} to {last} nm", lambda_nm.len()),
        format!("values {} to {}", spectrum.min(), spectrum.max()),
    ];
    if spectrum.partial_range_nm().is_some() {
        lines.push("covers a part of 380 to 780 nm only".to_owned());
    }
    if let Some([x, y]) = spectrum.xyz().chromaticity() {
        lines.push(format!("as light: chromaticity x = {x:.4}, y = {y:.4}"));
    }
    lines
}

fn rays(file: &RayFile) -> Vec<String> {
    let count = file.samples.len();
    let unit = file.flux_unit;
    let mut lines = vec![format!("ray file ({}), {count} rays", file.format)];
    lines.push(format!("flux of the rays: {} {unit}", file.flux_sum));
    lines.extend(file.header_flux.map(|flux| format!("flux of the header: {flux} {unit}")));
    lines.extend(file.flux_lm.map(|flux_lm| format!("luminous flux: {flux_lm} lm")));
    lines.push(match &file.spectrum_source {
        SpectrumSource::None => "spectrum: none".to_owned(),
        SpectrumSource::Line { nm } => format!("spectrum: one wavelength, {nm} nm"),
        SpectrumSource::PerRay { min_nm, max_nm } => {
            format!("spectrum: a wavelength a ray, {min_nm} to {max_nm} nm")
        }
        SpectrumSource::Table => "spectrum: a table".to_owned(),
        SpectrumSource::Mixture { tables } => format!("spectrum: {tables} tables"),
    });
    let starts = Starts::of(&file.samples);
    let surface =
        starts.surface.map(|fit| START_SURFACE.record(&(fit, starts.inner_source.is_none())));
    lines.push(match surface {
        Some(surface) => format!("start_surface: {surface}"),
        None => "start_surface: no point, plane, sphere or cylinder".to_owned(),
    });
    lines.extend(starts.lines());
    lines.extend(file.description.iter().map(|(name, text)| format!("{name}: {text}")));
    lines.extend(file.warnings.iter().map(|warning| format!("warning: {warning}")));
    lines
}
