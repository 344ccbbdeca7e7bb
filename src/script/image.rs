//! The image that a render returns.

use std::sync::Arc;

use mlua::{Lua, MetaMethod, Table, UserData, UserDataFields, UserDataMethods};

use super::fault;
use super::options::{Arguments, Options};
use super::spectrum::LuaSpectrum;
use crate::image::{Region, SpectralImage};
use crate::render::RenderStats;
use crate::scene::Prepared;
use crate::spectrum::Spectrum;
use crate::view::View;

/// Handle of a rendered image.
#[derive(Debug, Clone)]
pub struct LuaImage(Arc<Rendered>);

#[derive(Debug)]
struct Rendered {
    image: SpectralImage,
    stats: RenderStats,
    build: crate::scene::BuildSeconds,
    view: View,
}

const NAMES: [&str; 7] = ["height", "luminance", "save", "spectrum", "stats", "width", "xyz"];

impl LuaImage {
    pub(super) fn new(
        image: SpectralImage,
        stats: RenderStats,
        prepared: &Prepared,
        view: View,
    ) -> Self {
        Self(Arc::new(Rendered { image, stats, build: prepared.seconds, view }))
    }

    /// `{x =, y =, width = 1, height = 1}`, or the whole image for nil.
    fn region(&self, options: Options) -> mlua::Result<Region> {
        let image = &self.0.image;
        let most = |side: usize| side.max(1) as u64;
        let x = options.count("x", 0, most(image.width))?;
        let y = options.count("y", 0, most(image.height))?;
        let width = options.count("width", 1, most(image.width))?;
        let height = options.count("height", 1, most(image.height))?;
        if (x, y, width, height) == (None, None, None, None) {
            return Ok(Region { x: 0, y: 0, width: image.width, height: image.height });
        }
        Ok(Region {
            x: x.unwrap_or(0) as usize,
            y: y.unwrap_or(0) as usize,
            width: width.unwrap_or(1) as usize,
            height: height.unwrap_or(1) as usize,
        })
    }
}

const REGION_KEYS: [&str; 4] = ["height", "width", "x", "y"];

impl UserData for LuaImage {
    fn add_fields<F: UserDataFields<Self>>(fields: &mut F) {
        fields.add_field_method_get("width", |_, this| Ok(this.0.image.width));
        fields.add_field_method_get("height", |_, this| Ok(this.0.image.height));
        fields.add_field_method_get("stats", |lua, this| stats(lua, &this.0));
    }

    fn add_methods<M: UserDataMethods<Self>>(methods: &mut M) {
        fault::method(methods, "spectrum", |_, this: &Self, a| {
            let region = Arguments::new("image:spectrum", a, 1)?.options(&REGION_KEYS)?;
            let image = &this.0.image;
            let bands = image.mean_bands(this.region(region)?)?;
            let rows = image.grid.wavelengths_nm().zip(bands);
            Ok(LuaSpectrum(Arc::new(Spectrum::from_pairs("image:spectrum", rows)?)))
        });
        fault::method(methods, "xyz", |_, this: &Self, a| {
            let region = Arguments::new("image:xyz", a, 1)?.options(&REGION_KEYS)?;
            let xyz = this.0.image.mean_xyz(this.region(region)?)?;
            Ok((xyz.x, xyz.y, xyz.z))
        });
        fault::method(methods, "luminance", |_, this: &Self, a| {
            let region = Arguments::new("image:luminance", a, 1)?.options(&REGION_KEYS)?;
            Ok(this.0.image.mean_xyz(this.region(region)?)?.y)
        });
        methods.add_meta_method(MetaMethod::ToString, |_, this, ()| {
            let Rendered { image, stats, .. } = this.0.as_ref();
            let (width, height, bands) = (image.width, image.height, image.grid.bands());
            Ok(format!("image: {width} × {height}, {bands} bands, {:.2} s", stats.seconds))
        });
        fault::refuse_unknown_fields(methods, "image", &NAMES);
    }
}

fn stats(lua: &Lua, rendered: &Rendered) -> mlua::Result<Table> {
    let Rendered { stats, build, .. } = rendered;
    let counts = &stats.counts;
    let table = lua.create_table()?;
    table.set("camera_rays", counts.camera_rays)?;
    table.set("mirror_rays", counts.mirror_rays)?;
    table.set("transmitted_rays", counts.transmitted_rays)?;
    table.set("shadow_rays", counts.shadow_rays)?;
    table.set("light_sums", counts.light_sums)?;
    table.set("light_nodes", counts.light_nodes)?;
    table.set("light_samples", counts.light_samples)?;
    table.set("light_error", stats.light_error)?;
    table.set("largest_light_error", stats.largest_light_error)?;
    table.set("seconds", stats.seconds)?;
    table.set("bvh_seconds", build.bvh)?;
    table.set("light_tree_seconds", build.light_trees)?;
    Ok(table)
}
