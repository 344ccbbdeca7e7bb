//! `image:uncertainty`.

use std::collections::BTreeMap;

use mlua::{Function, Lua, Value};

use super::image::{LuaImage, RegionOptions};
use super::kinds::{Any, Callback, Count, Handle, Kind, Nested, Number, SpectrumOrNumber, any};
use super::options::{self, Range};
use super::quality::QUALITY;
use super::record::{Record, options};
use super::scene::LuaScene;
use super::spectrum::LuaSpectrum;
use crate::error::Error;
use crate::image::{Region, SpectralImage};
use crate::program::fields::Cell;
use crate::program::intensity::{facing_sr, intensity_bands};
use crate::program::results::BUDGET;
use crate::program::uncertainty::{Contribution, InputEffect, Seen, SpectralInput, combine};
use crate::render::{Asked, Quality, mean_spectrum};
use crate::spectrum::Spectrum;
use crate::view::View;

options! {
    struct UncertaintyOptions {
        /// of luminance and chromaticity; the whole image unless one is given
        region: RegionOptions = Nested::new(),
        inputs: Value = Any {
            lua_type: "table<string, UncertainInput>",
            expected: "a table of inputs by name",
        },
        /// `{{"a", "b", r}, …}`: coefficients of fluxes and numbers that are not independent
        correlation: Value = any("{[1]: string, [2]: string, [3]: number}[]").or(Value::Nil),
        /// of the image, for the scenes that are tried
        quality: Asked = QUALITY.or(Asked::Quality(Quality::default())),
    }
}

options! {
    /// An input with a standard uncertainty: a light's flux, a light's spectrum, or what makes a scene.
    struct UncertainInput {
        /// standard uncertainty: of a value in its unit; of a flux or spectrum relative, 0.02 is 2 %
        u: Spectrum = SpectrumOrNumber { expected: "a number or a spectrum", allowed: "0 or more" },
        /// of the scene, from 1; the image has layers = "lights"
        light: Option<usize> = Count::new(1, 100_000).optional(""),
        /// of that light, if it and not the flux is uncertain
        spectrum: Option<LuaSpectrum> = Handle::new("Spectrum", "a spectrum").optional(""),
        /// from the value to the scene; without a value, from a factor of an uncertain spectrum
        scene: Option<Function> = Callback {
            lua_type: "fun(value: number): Scene",
            expected: "a function of the value that returns a scene",
        }.optional(""),
        value: Option<f64> = Number(Range::ANY).optional(""),
        /// of a spectrum's errors: r = exp(−Δλ/this); 0 is independent bands
        correlation: f64 = Number(Range::new(0.0, 1e6, "nm")).or(0.0),
    }
}

/// A picture whose uncertainty is asked for.
struct Asking<'a> {
    image: &'a LuaImage,
    region: Region,
    /// `None` for an image without an intensity: relative, or of an unknown view.
    view: Option<View>,
    quality: Quality,
    seen: Seen,
}

pub(super) fn uncertainty(
    image: &LuaImage,
    lua: &Lua,
    given: UncertaintyOptions,
) -> mlua::Result<Cell> {
    let spectral = image.spectral();
    let region = image.region(&given.region);
    let view = spectral.view.filter(|view| intensity_bands(&empty(spectral), view).is_ok());
    let seen = seen_of(spectral, region, view.as_ref())?;
    let quality =
        Quality { limits: given.quality.limits(), grid: spectral.grid, ..Quality::default() };
    let asking = Asking { image, region, view, quality, seen };
    let mut contributions = Vec::new();
    for (name, value) in inputs(&given.inputs)? {
        let object = format!("image:uncertainty: input \"{name}\"");
        let input = asking.input(lua, &object, UncertainInput::read(&object, value)?)?;
        contributions.push(Contribution::of(&name, &asking.seen, spectral.grid, &input));
    }
    let correlations = correlations(&given.correlation)?;
    let values = asking.seen.quantities(spectral.grid);
    Ok(BUDGET.record(&combine(values, contributions, &correlations)?))
}

/// An image of the same kind without pixels.
fn empty(image: &SpectralImage) -> SpectralImage {
    SpectralImage::new(0, 0, image.grid, image.photometry)
}

fn seen_of(image: &SpectralImage, region: Region, view: Option<&View>) -> crate::Result<Seen> {
    let frame = view.map(|view| intensity_bands(image, view)).transpose()?;
    Ok(Seen { region: image.mean_bands(region)?, frame: frame.unwrap_or_default() })
}

fn inputs(value: &Value) -> mlua::Result<BTreeMap<String, Value>> {
    const OBJECT: &str = "image:uncertainty: inputs";
    let Value::Table(table) = value else {
        let expected = "a table of inputs by name";
        return Err(options::wrong_type("image:uncertainty", "\"inputs\"", value, expected).into());
    };
    let named = |pair: mlua::Result<(Value, Value)>| {
        let (name, value) = pair?;
        Ok((options::text(OBJECT, "name", &name)?, value))
    };
    table.pairs().map(named).collect()
}

fn correlations(value: &Value) -> mlua::Result<Vec<(String, String, f64)>> {
    const OBJECT: &str = "image:uncertainty";
    const EXPECTED: &str = "a list of {\"input\", \"input\", coefficient}";
    if value.is_nil() {
        return Ok(Vec::new());
    }
    options::each(OBJECT, "\"correlation\"", value, EXPECTED, |number, entry| {
        let what = format!("\"correlation\" entry {number}");
        let parts = options::list(OBJECT, &what, entry, EXPECTED)?;
        let [a, b, r] = parts.as_slice() else {
            let problem = format!("{what} has {} parts, expected {EXPECTED}", parts.len());
            return Err(Error::inconsistent(OBJECT, problem).into());
        };
        let name = |value| options::text(OBJECT, &what, value);
        let range = Range::new(-1.0, 1.0, "");
        Ok((name(a)?, name(b)?, options::number(OBJECT, &what, r, range)?))
    })
}

impl Asking<'_> {
    fn input(&self, lua: &Lua, object: &str, given: UncertainInput) -> mlua::Result<InputEffect> {
        if given.u.min() < 0.0 {
            return Err(Error::out_of_range(object, "\"u\"", given.u.min(), "0 or more").into());
        }
        let spectral = || SpectralInput {
            relative: given.u.on_grid(self.quality.grid),
            correlation_nm: given.correlation,
        };
        match (given.light, &given.spectrum, &given.scene, given.value) {
            (Some(light), None, None, None) => {
                let light = self.light(object, light)?;
                Ok(InputEffect::Flux { light, relative: number_of(object, &given.u)? })
            }
            (Some(light), Some(spectrum), None, None) => Ok(InputEffect::LightSpectrum {
                light: self.light(object, light)?,
                spectrum: spectrum.0.light_on_grid(self.quality.grid),
                input: spectral(),
            }),
            (None, None, Some(scene), Some(value)) => {
                let apart = 3f64.sqrt() * number_of(object, &given.u)?;
                let tried = [value - apart, value, value + apart];
                let [low, middle, high] = self.tried(lua, object, scene, tried)?;
                let light = [low, high].map(|tried| self.moved(&tried, &middle));
                Ok(InputEffect::Tried { light })
            }
            (None, None, Some(scene), None) => Ok(InputEffect::Spectrum {
                slope: self.slope(&self.tried(lua, object, scene, FACTORS)?),
                input: spectral(),
            }),
            _ => {
                let problem = "expected one of {light, u}, {light, spectrum, u}, {scene, value, u}, \
                               and {scene, u} for a spectrum";
                Err(Error::inconsistent(object, problem).into())
            }
        }
    }

    /// What of the picture is a light's.
    fn light(&self, object: &str, number: usize) -> mlua::Result<Seen> {
        let image = self.image.spectral();
        let layer = image.layers.iter().find(|layer| layer.name == format!("light {number}"));
        let layer = layer.ok_or_else(|| {
            let problem = match image.layers.len() {
                0 => "the image has no layers: render it with layers = \"lights\"".to_owned(),
                _ => format!("the image has no layer \"light {number}\""),
            };
            Error::inconsistent(object, problem)
        })?;
        Ok(seen_of(&image.layer(layer), self.region, self.view.as_ref())?)
    }

    /// What scenes show by few rays, the same for each.
    fn tried(
        &self,
        lua: &Lua,
        object: &str,
        make: &Function,
        values: [f64; 3],
    ) -> mlua::Result<[Seen; 3]> {
        let no_view = || {
            let problem = "the image does not say from where it was seen";
            Error::inconsistent(object, problem)
        };
        let view = self.image.spectral().view.ok_or_else(no_view)?;
        let [a, b, c] = values.map(|value| -> mlua::Result<Seen> {
            let scene: LuaScene =
                options::handle(object, "\"scene\"'s result", &make.call(value)?, "a scene")?;
            let prepared = scene.prepared(lua)?;
            let mean = |region: Region, weight: &(dyn Fn([f64; 2]) -> f64 + Sync)| {
                let rays = (region, self.rays(region));
                mean_spectrum(&prepared, &view, &self.quality, rays, weight)
            };
            let camera = view.camera();
            let whole = Region { x: 0, y: 0, width: view.width, height: view.height };
            let scale = view.pixels() as f64 * (view.distance_mm * 1e-3).powi(2);
            let frame = self.view.map(|_| mean(whole, &|at| scale * facing_sr(&camera, at)));
            Ok(Seen {
                region: mean(self.region, &|_| 1.0)?,
                frame: frame.transpose()?.unwrap_or_default(),
            })
        });
        Ok([a?, b?, c?])
    }

    /// Three scenes with region and frame of each take a twentieth of the picture's rays, if that is
    /// enough of them, and not more than tell all of a small region.
    fn rays(&self, region: Region) -> u32 {
        const FEWEST: u64 = 1000;
        const A_PIXEL: u64 = 64;
        let share = self.image.camera_rays() / (20 * 3 * 2);
        let all = (region.width * region.height) as u64 * A_PIXEL;
        share.max(FEWEST).min(all).min(u64::from(u32::MAX)) as u32
    }

    /// The picture's own light, changed as few rays say: their own noise is in both.
    fn moved(&self, tried: &Seen, middle: &Seen) -> Seen {
        self.with(|seen, at, of| {
            let (tried, middle) = (of(tried)[at], of(middle)[at]);
            if middle > 0.0 { seen * tried / middle } else { seen + tried }
        })
    }

    /// Derivative by the factor at 1, from values at [`FACTORS`], relative to the picture's own light.
    fn slope(&self, [far, near, whole]: &[Seen; 3]) -> Seen {
        let step = FACTORS[2] - FACTORS[1];
        self.with(|seen, at, of| {
            let [far, near, whole] = [far, near, whole].map(|tried| of(tried)[at]);
            let slope = (3.0 * whole - 4.0 * near + far) / (2.0 * step);
            if whole > 0.0 { seen * slope / whole } else { 0.0 }
        })
    }

    fn with(&self, f: impl Fn(f64, usize, fn(&Seen) -> &[f64]) -> f64) -> Seen {
        let part = |of: fn(&Seen) -> &[f64]| {
            (0..).zip(of(&self.seen)).map(|(at, &seen)| f(seen, at, of)).collect()
        };
        Seen { region: part(|seen| &seen.region), frame: part(|seen| &seen.frame) }
    }
}

/// Factors of a spectrum: none above 1, where a reflectance may end.
const FACTORS: [f64; 3] = [0.98, 0.99, 1.0];

/// Errors: a spectrum where one number is meant.
fn number_of(object: &str, u: &Spectrum) -> mlua::Result<f64> {
    if u.min() == u.max() {
        return Ok(u.min());
    }
    let problem = "\"u\" is a spectrum, expected a number for a flux or a value";
    Err(Error::inconsistent(object, problem).into())
}
