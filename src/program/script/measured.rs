//! Ray sets as measured light: how narrow their rays are, the surface that they come from, and what
//! its table holds.

use mlua::Value;

use super::figure::LuaFigure;
use super::host::Host;
use super::kinds::{Custom, Kind, Number, Vector};
use super::light::LuaLight;
use super::options::{self, Range};
use super::record::{Record, options};
use crate::color::Xyz;
use crate::error::Error;
use crate::geometry::DVec3;
use crate::image::XyzImage;
use crate::light::RaySet;
use crate::light::rayset::EXPONENT_RANGE;
use crate::program::figure::{FalseColor, Panel, RasterPanel, Scale, false_color};
use crate::source::Emitter;
use crate::source::directions::measured_exponent;
use crate::source::emitter::{Radiance, RadianceTable, Shape, fitted_shape, measured_emitter};

/// How narrow the lobes of a set's rays are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Directions {
    Exponent(f64),
    /// At which blur and noise of the set balance.
    Measured,
}

pub(super) const EXPONENT: Range = Range::new(EXPONENT_RANGE[0], EXPONENT_RANGE[1], "");

pub(super) const DIRECTIONS: Custom<Directions> = Custom {
    lua_type: "\"lambert\"|\"measured\"|number",
    allowed: "1 to 30000",
    read: |object, what, value| {
        if !value.is_string() {
            return options::number(object, what, value, EXPONENT).map(Directions::Exponent);
        }
        let words = [("lambert", Directions::Exponent(1.0)), ("measured", Directions::Measured)];
        options::choice(object, what, &options::text(object, what, value)?, &words)
    },
    shown: |_| String::new(),
};

impl Directions {
    pub(super) fn of(self, rays: RaySet) -> mlua::Result<RaySet> {
        let exponent = match self {
            Self::Exponent(exponent) => exponent,
            Self::Measured => measured_exponent(&rays.samples),
        };
        Ok(rays.with_exponent(exponent)?)
    }
}

/// The surface that a set's rays come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum EmitterOption {
    Fit,
    Given(Shape),
}

pub(super) const EMITTER: Custom<EmitterOption> = Custom {
    lua_type: "\"fit\"|EmitterShape",
    allowed: "",
    read: |object, what, value| {
        if value.is_string() {
            let word = options::text(object, what, value)?;
            return options::choice(object, what, &word, &[("fit", EmitterOption::Fit)]);
        }
        EmitterShape::read(OBJECT, value.clone())?.shape().map(EmitterOption::Given)
    },
    shown: |_| String::new(),
};

const OBJECT: &str = "rayset: emitter";

impl EmitterOption {
    /// The set with the surface, and samples drawn from the surface's table.
    pub(super) fn of(self, light: LuaLight, seed: u64, host: &Host) -> mlua::Result<LuaLight> {
        /// More than this share of a set that misses its emitter is told.
        const MOST_LOST: f64 = 0.005;
        let shape = match self {
            Self::Fit => fitted_shape(&light.rays.samples)?,
            Self::Given(shape) => shape,
        };
        let (rays, surface) = measured_emitter(&light.rays, shape, seed)?;
        let light = LuaLight { rays, surface: Some(surface), ..light };
        if let Some(table) = table_of(&light).filter(|table| table.lost() > MOST_LOST) {
            host.warn(format!(
                "{OBJECT}: {:.1} % of the flux does not leave the surface outward, and is shared out \
                 over the rest",
                100.0 * table.lost()
            ));
        }
        Ok(light)
    }
}

options! {
    /// The surface that a set's rays come from, in the set's own coordinates: one of these.
    struct EmitterShape {
        cylinder: Option<CylinderShape> = CYLINDER.optional("none"),
        sphere: Option<SphereShape> = SPHERE.optional("none"),
        disc: Option<DiscShape> = DISC.optional("none"),
        plane: Option<PlaneShape> = PLANE.optional("none"),
    }
}

options! {
    /// A cylinder's side.
    struct CylinderShape {
        center: DVec3 = Vector("mm").or(DVec3::ZERO),
        axis: DVec3 = Vector("").or(DVec3::Z),
        radius: f64 = LENGTH,
        length: f64 = LENGTH,
    }
}

options! {
    /// A sphere.
    struct SphereShape {
        center: DVec3 = Vector("mm").or(DVec3::ZERO),
        radius: f64 = LENGTH,
    }
}

options! {
    /// A disc.
    struct DiscShape {
        center: DVec3 = Vector("mm").or(DVec3::ZERO),
        /// to the side where it shines
        normal: DVec3 = Vector("").or(DVec3::Z),
        radius: f64 = LENGTH,
    }
}

options! {
    /// A rectangle.
    struct PlaneShape {
        center: DVec3 = Vector("mm").or(DVec3::ZERO),
        /// to the side where it shines
        normal: DVec3 = Vector("").or(DVec3::Z),
        /// along the width; what of it is across the normal counts
        across: DVec3 = Vector("").or(DVec3::X),
        width: f64 = LENGTH,
        height: f64 = LENGTH,
    }
}

const LENGTH: Number = Number(Range::above_zero("mm"));

const fn nested<R>(
    lua_type: &'static str,
    read: fn(&str, &str, &Value) -> mlua::Result<R>,
) -> Custom<R> {
    Custom { lua_type, allowed: "", read, shown: |_| String::new() }
}

const CYLINDER: Custom<CylinderShape> =
    nested("CylinderShape", |_, _, value| CylinderShape::read(OBJECT, value.clone()));
const SPHERE: Custom<SphereShape> =
    nested("SphereShape", |_, _, value| SphereShape::read(OBJECT, value.clone()));
const DISC: Custom<DiscShape> =
    nested("DiscShape", |_, _, value| DiscShape::read(OBJECT, value.clone()));
const PLANE: Custom<PlaneShape> =
    nested("PlaneShape", |_, _, value| PlaneShape::read(OBJECT, value.clone()));

impl EmitterShape {
    fn shape(self) -> mlua::Result<Shape> {
        let shape = match (self.cylinder, self.sphere, self.disc, self.plane) {
            (Some(c), None, None, None) => {
                let axis = unit("axis", c.axis)?;
                Shape::Cylinder { center: c.center, axis, radius_mm: c.radius, length_mm: c.length }
            }
            (None, Some(s), None, None) => Shape::Sphere { center: s.center, radius_mm: s.radius },
            (None, None, Some(d), None) => {
                let normal = unit("normal", d.normal)?;
                Shape::Disc { center: d.center, normal, radius_mm: d.radius }
            }
            (None, None, None, Some(p)) => {
                let normal = unit("normal", p.normal)?;
                let across = unit("across", p.across.reject_from_normalized(normal))?;
                let (width_mm, height_mm) = (p.width, p.height);
                Shape::Rectangle { center: p.center, normal, across, width_mm, height_mm }
            }
            _ => {
                let problem = "expected \"fit\", or one of cylinder, sphere, disc, plane";
                return Err(Error::inconsistent(OBJECT, problem).into());
            }
        };
        Ok(shape)
    }
}

fn unit(key: &str, vector: DVec3) -> mlua::Result<DVec3> {
    let unit = vector.try_normalize();
    unit.ok_or_else(|| Error::out_of_range(OBJECT, key, vector, "any direction").into())
}

/// The table of a measured emitter.
pub(super) fn table_of(light: &LuaLight) -> Option<&RadianceTable> {
    match &light.surface {
        Some(Emitter { radiance: Radiance::Measured(table), .. }) => Some(table),
        _ => None,
    }
}

/// What an emitter's table holds: mean luminance by place and by direction.
pub(super) fn plot_luminance(light: &LuaLight) -> mlua::Result<LuaFigure> {
    const SIDE: usize = 128;
    let Some(table) = table_of(light) else {
        let problem = "has no table of luminance: load it with emitter = \"fit\", or a surface";
        return Err(Error::inconsistent("rayset", problem).into());
    };
    let scale = light.rays.scale();
    let unit = 1e6 * light.rays.flux_lm / (scale * scale);
    let options = FalseColor { scale: Scale::Linear, ..FalseColor::default() };
    let panel = |title: &str, luminances: Vec<f64>| {
        let pixels = luminances.iter().map(|l| Xyz::new(0.0, l * unit, 0.0)).collect();
        let panel = false_color(&XyzImage { width: SIDE, height: SIDE, pixels }, &options)?;
        Ok::<_, Error>(Panel::Raster(RasterPanel { title: title.to_owned(), ..panel }))
    };
    let places = panel("by place (u, v)", table.by_place(SIDE))?;
    let ways = panel("by direction", table.by_direction(SIDE))?;
    Ok(LuaFigure::of_panels(vec![places, ways]))
}
