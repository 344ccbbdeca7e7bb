//! What is said of options outside of the program: the Lua language server's annotations and the
//! manual's option tables, both written from the records' rows.

use super::record::{OptionRow, Record};
use crate::error::Error;
use crate::program::fields::{Field, Fields};
use crate::program::results;

/// A record as the annotations and the manual show it.
struct Class {
    name: &'static str,
    rows: Vec<OptionRow>,
}

fn class<R: Record>() -> Class {
    Class { name: R::CLASS, rows: R::rows() }
}

fn results<T>(fields: &Fields<T>) -> Class {
    Class { name: fields.class, rows: fields.fields.iter().map(result_row).collect() }
}

fn result_row<T>(field: &Field<T>) -> OptionRow {
    OptionRow {
        key: field.name,
        lua_type: field.lua_type.trim_end_matches('?').to_owned(),
        is_required: !field.lua_type.ends_with('?'),
        allowed: String::new(),
        default: String::new(),
        sentence: field.sentence.to_owned(),
    }
}

/// Every record that scripts read.
const RESULTS: &[fn() -> Class] = &[
    || results(&results::CHANNEL),
    || results(&results::COST),
    || results(&results::BUDGET),
    || results(&results::CONTRIBUTION),
    || results(&results::DEVELOPED),
    || results(&results::DIFFERENCE),
    || results(&results::HOMOGENEITY),
    || results(&results::LIGHT_CHECK),
    || results(&results::LOBE),
    || results(&results::LOBE_FIT),
    || results(&results::MESH),
    || results(&results::NOISE_SHARE),
    || results(&results::PATCH),
    || results(&results::PATH),
    || results(&results::POINT),
    || results(&results::RAY),
    || results(&results::START_SURFACE),
    || results(&results::STATS),
    || results(&results::SWEPT),
    || results(&results::TARGET),
    || results(&results::VERIFICATION),
];

/// Every record that scripts may write.
const RECORDS: &[fn() -> Class] = &[
    class::<super::camera::CameraOptions>,
    class::<super::display::PqOptions>,
    class::<super::display::DisplayLoadOptions>,
    class::<super::display::DisplayNewOptions>,
    class::<super::display_fit::DisplayFitOptions>,
    class::<super::display_fit::DisplayRampsOptions>,
    class::<super::emitter::CylinderOptions>,
    class::<super::emitter::EmitterOptions>,
    class::<super::emitter::FilamentOptions>,
    class::<super::emitter::BulbOptions>,
    class::<super::figure::FigureOptions>,
    class::<super::figure::ChartPanel>,
    class::<super::figure::FigureAxis>,
    class::<super::figure::FigureSeries>,
    class::<super::figure::SegmentsPanel>,
    class::<super::figure::PicturePanel>,
    class::<super::figure::FalseColorOptions>,
    class::<super::grid_check::GridCheckOptions>,
    class::<super::image::RegionOptions>,
    class::<super::image::HomogeneityOptions>,
    class::<super::image::ExrOptions>,
    class::<super::image::HdrOptions>,
    class::<super::image::JpegOptions>,
    class::<super::image::TiffOptions>,
    class::<super::light::RaysetLoadOptions>,
    class::<super::light::StartOptions>,
    class::<super::light::RaysetNewOptions>,
    class::<super::light::RaysetNoiseOptions>,
    class::<super::light::RaysetHalvesOptions>,
    class::<super::image::ImageLoadOptions>,
    class::<super::environment::EnvironmentLoadOptions>,
    class::<super::environment::PanelOptions>,
    class::<super::environment::RoomOptions>,
    class::<super::environment::SkyOptions>,
    class::<super::environment::SunOptions>,
    class::<super::emitter::Glass>,
    class::<super::measured::CylinderShape>,
    class::<super::measured::DiscShape>,
    class::<super::measured::EmitterShape>,
    class::<super::measured::PlaneShape>,
    class::<super::measured::SphereShape>,
    class::<super::lobe_fit::LobeFitOptions>,
    class::<super::look::PngOptions>,
    class::<super::look::LookOptions>,
    class::<super::look::GlareOptions>,
    class::<super::look::ExposureOptions>,
    class::<super::material::MaterialOptions>,
    class::<super::mesh::MeshLoadOptions>,
    class::<super::mesh::MeshNewOptions>,
    class::<super::mesh::MeshSurfaceOptions>,
    class::<super::mesh::Transform>,
    class::<super::mesh::Rotation>,
    class::<super::mesh::SectionOptions>,
    class::<super::paths::PathOptions>,
    class::<super::photometry::GridOptions>,
    class::<super::photometry::GridSaveOptions>,
    class::<super::quality::QualityOptions>,
    class::<super::quality::AdaptiveSamples>,
    class::<super::scene::SceneOptions>,
    class::<super::scene::SceneObject>,
    class::<super::scene::LightErrorOptions>,
    class::<super::spectrum::SpectrumLoadOptions>,
    class::<super::study::Spread>,
    class::<super::study::StudyOptions>,
    class::<super::sweep::SweepOptions>,
    class::<super::sweep::SweepView>,
    class::<super::uncertainty::UncertainInput>,
    class::<super::uncertainty::UncertaintyOptions>,
    class::<super::view::ViewOptions>,
];

fn all() -> Vec<Class> {
    RECORDS.iter().chain(RESULTS).map(|class| class()).collect()
}

/// The options and fields of the records whose names hold `part`, a paragraph each.
///
/// Errors: no such record.
pub fn describe_options(part: &str) -> Result<String, Error> {
    let classes = all();
    let is_meant = |class: &&Class| class.name.to_lowercase().contains(&part.to_lowercase());
    let found: Vec<String> = classes.iter().filter(is_meant).map(Class::paragraph).collect();
    if found.is_empty() {
        let names: Vec<&str> = classes.iter().map(|class| class.name).collect();
        let value = format!("\"{part}\"");
        return Err(Error::out_of_range("options", "name", value, names.join(", ")));
    }
    Ok(found.join("\n"))
}

impl Class {
    fn paragraph(&self) -> String {
        let rows = self.rows.iter().map(|row| format!("  {}\n", line(row)));
        format!("{}\n{}", self.name, rows.collect::<String>())
    }
}

/// Key, type, and what is said of them.
fn line(row: &OptionRow) -> String {
    let OptionRow { key, lua_type, allowed, sentence, .. } = row;
    let mark = if row.is_required { "" } else { "?" };
    let default = match row.default.as_str() {
        "" => String::new(),
        default => format!("default {default}"),
    };
    let parts = [sentence, allowed, &default].map(String::as_str);
    let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    format!("{key}{mark} {lua_type}  {}", parts.join("; ")).trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::{Path, PathBuf};
    use std::{env, fs};

    use super::*;

    impl Class {
        /// Its fields in `scripts/library/lampyris.lua`.
        fn annotation(&self) -> String {
            self.rows.iter().map(|row| format!("---@field {}\n", line(row))).collect()
        }

        /// Its table in the manual.
        fn table(&self) -> String {
            let head = "| option | type | allowed | default | |\n|---|---|---|---|---|\n";
            format!("{head}{}", self.rows.iter().map(table_line).collect::<String>())
        }
    }

    fn table_line(row: &OptionRow) -> String {
        let default = match (row.is_required, row.default.as_str()) {
            (true, _) => "required".to_owned(),
            (false, "") => String::new(),
            (false, default) => format!("`{default}`"),
        };
        let lua_type = row.lua_type.replace('|', "\\|");
        let OptionRow { key, allowed, sentence, .. } = row;
        format!("| `{key}` | {lua_type} | {allowed} | {default} | {sentence} |\n")
    }

    fn path(below: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join(below)
    }

    /// `text` with what stands between a line `start` and a line `end` replaced.
    fn replaced(text: &str, start: &str, end: &str, new: &str) -> Option<String> {
        let (before, rest) = text.split_once(start)?;
        let (_, after) = rest.split_once(end)?;
        Some(format!("{before}{start}{new}{end}{after}"))
    }

    /// `text` with the class's block replaced: the fields that follow its line.
    fn with_class(text: &str, class: &Class) -> Option<String> {
        let starts = ["\n", ":"].map(|end| format!("---@class {}{end}", class.name));
        let at = starts.iter().find_map(|start| text.find(start))?;
        let line = text[at..].find('\n')? + 1;
        let (before, rest) = text.split_at(at + line);
        let fields = rest.split_inclusive('\n').take_while(|line| line.starts_with("---@field "));
        let after = &rest[fields.map(str::len).sum()..];
        Some(format!("{before}{}{after}", class.annotation()))
    }

    /// `text` with the class's table replaced, where it has one.
    fn with_table(text: &str, class: &Class) -> String {
        let start = format!("<!-- options of {} -->\n", class.name);
        replaced(text, &start, "<!-- end -->", &class.table()).unwrap_or_else(|| text.to_owned())
    }

    /// Errors: a file that differs; with `MAKE_REF` it is written, and differs in this run only.
    fn check(path: &Path, found: &str, expected: &str) -> Result<(), String> {
        if found == expected {
            return Ok(());
        }
        if env::var_os("MAKE_REF").is_some() {
            fs::write(path, expected).unwrap();
        }
        let first = found.lines().zip(expected.lines()).find(|(found, expected)| found != expected);
        let name = path.display();
        Err(format!("{name} is not in step, MAKE_REF=1 writes it anew; first: {first:?}"))
    }

    #[test]
    fn the_annotations_are_in_step() {
        let library = path("scripts/library/lampyris.lua");
        let found = fs::read_to_string(&library).unwrap();
        let expected = all().iter().fold(found.clone(), |text, class| {
            let new = with_class(&text, class);
            new.unwrap_or_else(|| panic!("no ---@class {} in {}", class.name, library.display()))
        });
        check(&library, &found, &expected).unwrap();
    }

    #[test]
    fn the_manual_is_in_step() {
        let pages = fs::read_dir(path("docs")).unwrap().map(|entry| entry.unwrap().path());
        let pages = pages.filter(|page| page.extension().is_some_and(|kind| kind == "md"));
        let faults = pages.filter_map(|page| {
            let found = fs::read_to_string(&page).unwrap();
            let expected = all().iter().fold(found.clone(), |text, class| with_table(&text, class));
            check(&page, &found, &expected).err()
        });
        assert_eq!(faults.collect::<Vec<_>>(), Vec::<String>::new());
    }

    #[test]
    fn what_manifests_say_of_options_has_their_names() {
        let names = |class: Class| -> BTreeSet<&str> { class.rows.iter().map(|r| r.key).collect() };
        let view = names(class::<super::super::view::ViewOptions>());
        assert_eq!(names(results(&results::VIEW)), view);
        let quality = names(class::<super::super::quality::QualityOptions>());
        assert_eq!(names(results(&results::ASKED)), quality);
        let region = names(class::<super::super::image::RegionOptions>());
        assert!(names(results(&results::READING)).is_superset(&region));
    }
}
