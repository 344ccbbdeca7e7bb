//! The image that a render returns.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use mlua::{Lua, MetaMethod, Table, UserData, UserDataRegistry, Value};

use super::environment::LUMINANCE;
use super::host::Host;
use super::kinds::{Choice, Count, Handle, Kind, List, Naming, Nested};
use super::look::PngOptions;
use super::members::{Members, functions};
use super::options::{self, Arguments, Range};
use super::record::options;
use super::spectrum::LuaSpectrum;
use super::uncertainty::uncertainty;
use super::view::MAX_SIDE;
use super::{figure, host};
use crate::color::Photometry;
use crate::display::Look;
use crate::error::Error;
use crate::image::difference::ImageDifference;
use crate::image::homogeneity;
use crate::image::{Region, SpectralImage, XyzImage, weighted_sum};
use crate::output::{self, ColorPicture, ExrBands, HdrColors, Raster};
use crate::program::fields::Cell;
use crate::program::intensity;
use crate::program::memory;
use crate::program::results::{COST, Cost, DEVELOPED, DIFFERENCE, HOMOGENEITY, STATS};
use crate::render::RenderStats;
use crate::scene::{BuildSeconds, Prepared};
use crate::spectrum::{Spectrum, WavelengthGrid};
use crate::view::View;

/// Handle of a rendered image.
#[derive(Debug, Clone)]
pub struct LuaImage(Arc<Rendered>);

#[derive(Debug)]
struct Rendered {
    image: SpectralImage,
    /// `None` for an image that was not rendered by this script.
    run: Option<RenderRun>,
}

/// How a render went.
#[derive(Debug)]
struct RenderRun {
    stats: RenderStats,
    build: BuildSeconds,
    /// On the screen, where there is one.
    number: Option<usize>,
}

const IMAGES: &str = "a list of {image, weight}";

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    functions(lua, module, "image", |functions| {
        functions.add("load", 2, load)?;
        functions.add("sum", 1, sum)
    })
}

options! {
    /// A picture of colors as an image.
    struct ImageLoadOptions {
        /// of the picture's white; the image is then in cd/m²
        luminance: Option<f64> = LUMINANCE.optional("the file's, where it has one"),
    }
}

/// An image as it was saved, or a picture of colors (a photograph) with spectra that have them.
fn load(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaImage> {
    const OBJECT: &str = "image.load";
    let path = arguments.text("path")?;
    let given: ImageLoadOptions = arguments.record()?;
    let host = host::of(lua)?;
    let file = host.input(&path)?;
    let exr_bands = output::exr_band_count(&file)?;
    if exr_bands.is_some_and(|bands| bands > 0) {
        if given.luminance.is_some() {
            let problem = "\"luminance\" is for pictures of colors, and this file holds spectra";
            return Err(Error::inconsistent(OBJECT, problem).into());
        }
        host::reserve_for_file(lua, OBJECT, &file)?;
        return Ok(LuaImage::of(output::read_exr(&file)?));
    }
    let picture = color_picture(lua, OBJECT, &path)?;
    let bytes =
        picture.pixels.len().saturating_mul(size_of::<f32>() * WavelengthGrid::Step5.bands());
    host::reserve(lua, OBJECT, bytes, "a smaller picture")?;
    let white_cd_m2 = given.luminance.or(picture.cd_m2_of_one);
    let photometry = white_cd_m2.map_or(Photometry::Relative, |_| Photometry::Absolute);
    let factor = white_cd_m2.unwrap_or(1.0);
    let colors = picture.colors().map(|color| color * factor);
    let (mut image, paled) =
        SpectralImage::from_colors(picture.width, picture.height, colors, photometry);
    warn_of_paled(&host, &path, paled);
    if exr_bands.is_some() {
        host.warn(format!("{path}: has colors and no bands: smooth spectra stand for them"));
    }
    image
        .metadata
        .insert("colors".to_owned(), "spectra were made from a picture's colors".to_owned());
    Ok(LuaImage::of(image))
}

/// A picture of colors, once there is room for it.
pub(super) fn color_picture(lua: &Lua, object: &str, path: &str) -> mlua::Result<ColorPicture> {
    /// Digits of 16 bits and floats, as they are decoded.
    const DECODED: usize = 3 * (size_of::<u16>() + size_of::<f32>());
    let file = host::of(lua)?.input(path)?;
    host::reserve_for_file(lua, object, &file)?;
    if let Some([width, height]) = output::declared_size(&file)? {
        let bytes = width.saturating_mul(height).saturating_mul(DECODED);
        host::reserve(lua, object, bytes, "a smaller picture")?;
    }
    Ok(output::read_color_picture(&file)?)
}

pub(super) fn warn_of_paled(host: &Host, path: &str, share: f64) {
    if share > 0.0 {
        let percent = 100.0 * share;
        host.warn(format!("{path}: {percent:.2} % of the pixels lie outside of P3, and are paled"));
    }
}

/// `{ { a, 0.3 }, b, … }`: an image alone has the weight 1.
fn sum(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaImage> {
    const OBJECT: &str = "image.sum";
    let entries = options::list(OBJECT, "argument 1", &arguments.value(), IMAGES)?;
    let term = |(at, entry): (usize, &Value)| -> mlua::Result<(f64, LuaImage)> {
        let what = format!("entry {at}");
        let (image, weight) = match entry {
            Value::Table(_) => {
                match options::list(OBJECT, &what, entry, "{image, weight}")?.as_slice() {
                    [image] => (image.clone(), 1.0),
                    [image, weight] => {
                        (image.clone(), options::number(OBJECT, &what, weight, Range::ANY)?)
                    }
                    parts => {
                        let problem =
                            format!("{what} has {} parts, expected {{image, weight}}", parts.len());
                        return Err(Error::inconsistent(OBJECT, problem).into());
                    }
                }
            }
            image => (image.clone(), 1.0),
        };
        Ok((weight, options::handle(OBJECT, &what, &image, "an image")?))
    };
    let terms = (1..).zip(&entries).map(term).collect::<mlua::Result<Vec<_>>>()?;
    weighted(lua, &terms)
}

fn weighted(lua: &Lua, terms: &[(f64, LuaImage)]) -> mlua::Result<LuaImage> {
    let terms: Vec<_> = terms.iter().map(|(weight, i)| (*weight, &i.0.image)).collect();
    let bytes = terms.first().map_or(0, |(_, image)| {
        (image.width * image.height).saturating_mul(size_of::<f32>() * image.grid.bands())
    });
    host::reserve(lua, "image.sum", bytes, "fewer pixels would fit")?;
    Ok(LuaImage::of(weighted_sum(&terms)?))
}

options! {
    /// A part of an image.
    struct RegionOptions {
        /// 0-based from the left
        x: Option<usize> = Count::new(0, MAX_SIDE).optional("0"),
        /// 0-based from the top
        y: Option<usize> = Count::new(0, MAX_SIDE).optional("0"),
        width: Option<usize> = Count::new(1, MAX_SIDE).of("pixels").optional("1"),
        height: Option<usize> = Count::new(1, MAX_SIDE).of("pixels").optional("1"),
    }
}

impl RegionOptions {
    /// One pixel unless more is given.
    pub(super) fn region(&self) -> Region {
        let Self { x, y, width, height } = *self;
        Region {
            x: x.unwrap_or(0),
            y: y.unwrap_or(0),
            width: width.unwrap_or(1),
            height: height.unwrap_or(1),
        }
    }
}

impl LuaImage {
    pub(super) fn new(
        image: SpectralImage,
        stats: RenderStats,
        prepared: &Prepared,
        number: Option<usize>,
    ) -> Self {
        let run = Some(RenderRun { stats, build: prepared.seconds, number });
        Self(Arc::new(Rendered { image, run }))
    }

    /// An image that no render of this script has made.
    fn of(image: SpectralImage) -> Self {
        Self(Arc::new(Rendered { image, run: None }))
    }

    /// Errors: nobody knows from where the image was seen.
    fn view(&self, object: &str) -> mlua::Result<View> {
        let problem = "the image does not say from where it was seen";
        self.0.image.view.ok_or_else(|| Error::inconsistent(object, problem).into())
    }

    pub(super) fn xyz_image(&self) -> XyzImage {
        self.0.image.to_xyz()
    }

    pub(super) fn spectral(&self) -> &SpectralImage {
        &self.0.image
    }

    /// Camera rays that the image took; one a pixel where nobody knows.
    pub(super) fn camera_rays(&self) -> u64 {
        let pixels = (self.0.image.width * self.0.image.height) as u64;
        self.0.run.as_ref().map_or(pixels, |run| run.stats.counts.camera_rays)
    }

    pub(super) fn photometry(&self) -> Photometry {
        self.0.image.photometry
    }

    /// Y of every pixel.
    pub(super) fn luminances(&self) -> Vec<f64> {
        self.xyz_image().pixels.iter().map(|color| color.y).collect()
    }

    /// The whole image where nothing of it is given.
    pub(super) fn region(&self, given: &RegionOptions) -> Region {
        match given {
            RegionOptions { x: None, y: None, width: None, height: None } => {
                let SpectralImage { width, height, .. } = self.0.image;
                Region { x: 0, y: 0, width, height }
            }
            given => given.region(),
        }
    }

    /// The region that a method is called with.
    fn region_of(&self, mut arguments: Arguments) -> mlua::Result<Region> {
        Ok(self.region(&arguments.record()?))
    }

    /// What its render did and cost.
    fn stats(&self) -> Cell {
        let Some(RenderRun { stats, build, .. }) = &self.0.run else {
            return Cell::Nothing;
        };
        let RenderStats { seconds, expected_seconds, .. } = *stats;
        let cost =
            Cost { seconds, expected_seconds, build: *build, peak_memory_mb: memory::peak_mb() };
        Cell::Record([STATS.cells(stats), COST.cells(&cost)].concat())
    }
}

impl LuaImage {
    /// The layers as images of their own, by name.
    fn layers(&self) -> BTreeMap<String, LuaImage> {
        let image = &self.0.image;
        let layers = image.layers.iter();
        layers.map(|layer| (layer.name.clone(), LuaImage::of(image.layer(layer)))).collect()
    }

    /// cd; warns of a lamp that the picture cuts off.
    fn intensity(&self, host: &Host) -> mlua::Result<f64> {
        let view = self.view("image:intensity")?;
        warn_of_cut_off(host, &self.0.image, &view);
        Ok(intensity::intensity(&self.0.image, &view)?.y)
    }

    /// Y of a region's pixels, row by row.
    fn luminances_of(&self, region: Region) -> mlua::Result<Vec<f64>> {
        region.check(self.0.image.width, self.0.image.height)?;
        let image = self.xyz_image();
        let luminance = |(x, y): (usize, usize)| image.pixels[y * image.width + x].y;
        Ok(region.pixels().map(luminance).collect())
    }
}

impl fmt::Display for Rendered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { image, run } = self;
        let (width, height, bands) = (image.width, image.height, image.grid.bands());
        write!(f, "image: {width} × {height}, {bands} bands")?;
        run.as_ref().map_or(Ok(()), |run| write!(f, ", {:.2} s", run.stats.seconds))
    }
}

impl UserData for LuaImage {
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "image");
        members.field("width", |_, this| Ok(this.0.image.width));
        members.field("height", |_, this| Ok(this.0.image.height));
        members.field("layers", |_, this| Ok(this.layers()));
        members.field("stats", |_, this| Ok(this.stats()));
        members.method("spectrum", 1, |_, this, a| {
            let image = &this.0.image;
            let bands = image.mean_bands(this.region_of(a)?)?;
            let rows = image.grid.wavelengths_nm().zip(bands);
            Ok(LuaSpectrum(Arc::new(Spectrum::from_pairs("image:spectrum", rows)?)))
        });
        members.method("xyz", 1, |_, this, a| {
            let xyz = this.0.image.mean_xyz(this.region_of(a)?)?;
            Ok((xyz.x, xyz.y, xyz.z))
        });
        members
            .method("luminance", 1, |_, this, a| Ok(this.0.image.mean_xyz(this.region_of(a)?)?.y));
        members.method("intensity", 0, |lua, this, _| this.intensity(&host::of(lua)?));
        members.method("luminances", 1, |_, this, a| this.luminances_of(this.region_of(a)?));
        members.method("compare", 1, |_, this, mut arguments| {
            let reference: Self = arguments.handle("argument 1", "an image")?;
            let difference = ImageDifference::between(&this.0.image, &reference.0.image)?;
            Ok(DIFFERENCE.record(&difference))
        });
        members.method("homogeneity", 1, |_, this, mut a| this.homogeneity(a.record()?));
        members.method("uncertainty", 1, |lua, this, mut a| uncertainty(this, lua, a.record()?));
        members.method("false_color", 1, |_, this, mut a| {
            figure::false_color_figure(this, a.record()?)
        });
        members.method("save", 2, |lua, this, a| save(lua, &this.0, a));
        members.text(|this| Ok(this.0.to_string()));
        members.operator(MetaMethod::Add, |lua, [a, b]| {
            let image =
                |value: &Value| options::handle("image + image", "operand", value, "an image");
            weighted(lua, &[(1.0, image(&a)?), (1.0, image(&b)?)])
        });
        members.operator(MetaMethod::Mul, |lua, [a, b]| {
            const OBJECT: &str = "number * image";
            let (image, weight) = if a.is_userdata() { (a, b) } else { (b, a) };
            let weight = options::number(OBJECT, "operand", &weight, Range::ANY)?;
            weighted(lua, &[(weight, options::handle(OBJECT, "operand", &image, "an image")?)])
        });
        members.no_others();
    }
}

options! {
    struct HomogeneityOptions {
        /// the whole image unless one is given
        region: RegionOptions = Nested::new(),
        /// columns and rows of cells
        grid: Option<Vec<usize>> = List {
            entry: Count::new(1, MAX_SIDE),
            expected: "{columns, rows}",
            naming: Naming::Key,
        }.optional("one a pixel"),
        /// pictures with rayset:halves, two for each split: they tell the noise of the rays
        halves: Vec<LuaImage> = List {
            entry: Handle::new("Image", "an image"),
            expected: "a list of images",
            naming: Naming::Entry,
        }.or(Vec::new()),
    }
}

impl LuaImage {
    fn homogeneity(&self, given: HomogeneityOptions) -> mlua::Result<Cell> {
        let cells = given.grid.map(|grid| match grid[..] {
            [columns, rows] => Ok([columns, rows]),
            _ => {
                let problem =
                    format!("\"grid\" has {} entries, expected {{columns, rows}}", grid.len());
                Err(Error::inconsistent("image:homogeneity", problem))
            }
        });
        let halves: Vec<&SpectralImage> = given.halves.iter().map(Self::spectral).collect();
        let region = self.region(&given.region);
        let found = homogeneity::homogeneity(&self.0.image, region, cells.transpose()?, &halves)?;
        Ok(HOMOGENEITY.record(&found))
    }
}

options! {
    struct ExrOptions {
        /// of which float reads back bit for bit
        bands: ExrBands = Choice(&[
            ("float", ExrBands::Float),
            ("half", ExrBands::Half),
            ("pxr24", ExrBands::Pxr24),
            ("none", ExrBands::None),
        ]).or(ExrBands::Float),
    }
}

/// The kind of file follows from the path's ending.
fn save(lua: &Lua, rendered: &Rendered, mut arguments: Arguments) -> mlua::Result<Cell> {
    let path = arguments.text("path")?;
    let host = host::of(lua)?;
    let target = host.output(&path)?;
    match target.extension().and_then(|e| e.to_str()) {
        Some("exr") => {
            let ExrOptions { bands } = arguments.record()?;
            output::write_exr_as(&target, &rendered.image, bands)?;
            Ok(Cell::Record(Vec::new()))
        }
        Some("hdr") => {
            let HdrOptions { colors } = arguments.record()?;
            output::write_hdr(&target, &rendered.image, colors)?;
            Ok(Cell::Record(Vec::new()))
        }
        Some("png") => {
            let look = arguments.record::<PngOptions>()?.look()?;
            save_picture(&host, &path, rendered, &look, |raster| output::write_png(&target, raster))
        }
        Some("jpg" | "jpeg") => {
            let JpegOptions { quality, png } = arguments.record()?;
            let write = |raster: &Raster| output::write_jpeg(&target, raster, quality);
            save_picture(&host, &path, rendered, &png.look()?, write)
        }
        Some("tif" | "tiff") => {
            let TiffOptions { samples, png } = arguments.record()?;
            if samples == TiffSamples::Float {
                output::write_float_tiff(&target, &rendered.image)?;
                return Ok(Cell::Record(Vec::new()));
            }
            let write = |raster: &Raster| output::write_tiff(&target, raster);
            save_picture(&host, &path, rendered, &png.look_of_bits(16)?, write)
        }
        _ => {
            let found = format!("\"{path}\"");
            let allowed = "names ending in .exr, .hdr, .jpg, .png or .tif";
            Err(Error::out_of_range("image:save", "path", found, allowed).into())
        }
    }
}

options! {
    struct HdrOptions {
        /// Radiance's RGB, to which more saturated colors are toned down; or tristimulus values
        colors: HdrColors =
            Choice(&[("rgbe", HdrColors::Rgbe), ("xyze", HdrColors::Xyze)]).or(HdrColors::Rgbe),
    }
}

options! {
    struct JpegOptions {
        quality: u8 = Count::new(1, 100).or(95),
        ..png: PngOptions,
    }
}

options! {
    struct TiffOptions {
        /// digits, of 16 bits unless more is said; or linear Rec. 709 of the light
        samples: TiffSamples = Choice(&[
            ("integer", TiffSamples::Integer),
            ("float", TiffSamples::Float),
        ]).or(TiffSamples::Integer),
        ..png: PngOptions,
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TiffSamples {
    Integer,
    Float,
}

/// A picture as a display shows it.
fn save_picture(
    host: &Host,
    path: &str,
    rendered: &Rendered,
    look: &Look,
    write: impl FnOnce(&Raster) -> crate::Result<()>,
) -> mlua::Result<Cell> {
    let (shown, raster) = output::develop_raster(&rendered.image, look)?;
    write(&raster)?;
    if let Some(screen) = &host.settings.screen {
        screen.saved(rendered.run.as_ref().and_then(|run| run.number), path, look, &raster);
    }
    host.note_clipped(look, &shown.picture.gamut, 1);
    Ok(DEVELOPED.record(&shown))
}

/// Light beyond the image is not in its intensity.
pub(super) fn warn_of_cut_off(host: &Host, image: &SpectralImage, view: &View) {
    if intensity::is_cut_off(image) {
        host.warn(format!("intensity: light reaches the border of the image ({view})"));
    }
}
