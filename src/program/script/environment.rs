//! `lampyris.environment`: surroundings.

use std::sync::Arc;

use mlua::{Lua, Table, UserData, UserDataRegistry, Value};

use super::host;
use super::image;
use super::kinds::{Any, Count, Kind, List, Naming, Number, Numbers, SpectrumOrNumber, nested};
use super::members::{Members, functions};
use super::options::{self, Arguments, Range, wrong_type};
use super::record::{Record, options};
use super::spectrum::LuaSpectrum;
use crate::color::Xyz;
use crate::color::upsampling::{ColorGamut, round_trip};
use crate::environment::{
    CeilingPanel, Daylight, Dome, Environment, Picture, Room, Sky, SkyKind, Sun, SunPlace,
    per_lumen, toward,
};
use crate::error::Error;
use crate::geometry::DVec3;
use crate::scene::Background;
use crate::spectrum::daylight::DAYLIGHT_RANGE_K;
use crate::spectrum::{Spectrum, WavelengthGrid};

/// Handle of surroundings.
#[derive(Debug, Clone)]
pub struct LuaEnvironment(pub Arc<Environment>);

const LX: Number = Number(Range::above_zero("lx"));
const AZIMUTH: Number = Number(Range::new(-360.0, 360.0, "degrees"));
const CCT: Number = Number(Range::new(DAYLIGHT_RANGE_K[0], DAYLIGHT_RANGE_K[1], "K"));
pub(super) const LUMINANCE: Number = Number(Range::new(0.0, 1e12, "cd/m²"));

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    functions(lua, module, "environment", |functions| {
        functions.add("load", 2, load)?;
        functions.add("sky", 1, |_, a| sky(a))?;
        functions.add("room", 1, |_, a| room(a))?;
        functions.add("round_trip", 1, |_, a| colors_back(a))
    })
}

options! {
    struct EnvironmentLoadOptions {
        /// right-handed about +Y; at 0 the picture's middle is -Z, behind the lamp
        rotate: f64 = AZIMUTH.or(0.0),
        /// of the file's white (1, 1, 1)
        luminance: Option<f64> = LUMINANCE.optional("the file's; else 179 for Radiance, 1 for others"),
        /// of all of it on a level plane
        illuminance: Option<f64> = LX.optional("what follows from luminance"),
        /// times as bright
        scale: f64 = Number(Range::above_zero("")).or(1.0),
    }
}

fn load(lua: &Lua, mut arguments: Arguments) -> mlua::Result<LuaEnvironment> {
    const OBJECT: &str = "environment.load";
    let path = arguments.text("path")?;
    let given: EnvironmentLoadOptions = arguments.record()?;
    let host = host::of(lua)?;
    let file = image::color_picture(lua, OBJECT, &path)?;
    if file.width != 2 * file.height {
        let (width, height) = (file.width, file.height);
        host.warn(format!("{path}: {width} × {height} pixels, expected twice as wide as high"));
    }
    let (picture, upsampling, paled) =
        Picture::from_colors(file.width, file.height, file.colors())?;
    image::warn_of_paled(&host, &path, paled);
    let environment = Environment::new(Dome::Picture(picture), upsampling.spectra.to_vec())?;
    let environment = environment.turned(given.rotate);
    let environment = match (given.luminance, given.illuminance) {
        (Some(_), Some(_)) => {
            let problem = "give \"luminance\" or \"illuminance\", not both";
            return Err(Error::inconsistent(OBJECT, problem).into());
        }
        (_, Some(lx)) => with_illuminance(environment, OBJECT, lx)?,
        (luminance, None) => environment.scaled(luminance.or(file.cd_m2_of_one).unwrap_or(1.0)),
    };
    Ok(LuaEnvironment(Arc::new(environment.scaled(given.scale))))
}

fn with_illuminance(environment: Environment, object: &str, lx: f64) -> mlua::Result<Environment> {
    let now = environment.illuminance_lx(DVec3::Y);
    if now > 0.0 {
        return Ok(environment.scaled(lx / now));
    }
    Err(Error::inconsistent(object, "its upper half is black: it lights no level plane").into())
}

options! {
    /// A CIE sky.
    struct SkyOptions {
        /// overcast (Moon and Spencer), clear, or the number of a sky of CIE S 011
        kind: Value = Any {
            lua_type: "\"overcast\"|\"clear\"|integer",
            expected: "\"overcast\", \"clear\", or 1 to 15",
        },
        /// where it stands
        sun: Option<Value> = Any {
            lua_type: "SunOptions",
            expected: "a table of options",
        }.optional("none: skies 2, 4 and 6 to 15 need it"),
        /// luminous, of the air: 1 is clean, 5 hazy
        turbidity: f64 = Number(Range::new(1.0, 20.0, "")).or(2.5),
        /// of sky and sun on a level plane
        illuminance: Option<f64> = LX.optional("by kind and elevation"),
        /// of the sky (CIE daylight)
        cct: Option<f64> = CCT.optional("6500 overcast, 8000, 12000 clear"),
        /// reflectance of the ground below the horizon
        ground: Spectrum = SpectrumOrNumber::new("0 to 1").or(Spectrum::constant(0.0)),
    }
}

options! {
    /// A sun of half a degree.
    struct SunOptions {
        /// above the horizon
        elevation: f64 = Number(Range::new(0.0, 90.0, "degrees")),
        /// as a view's: 0 is behind the viewer of the lamp's front
        azimuth: f64 = AZIMUTH.or(0.0),
        /// facing it; 0 leaves the disc out
        illuminance: Option<f64> = Number(Range::new(0.0, 1e9, "lx"))
            .optional("by turbidity and elevation; 0 for skies 1 to 6"),
        /// of CIE daylight
        cct: Option<f64> = CCT.optional("a spectrum that the air has filtered"),
    }
}

fn sky(mut arguments: Arguments) -> mlua::Result<LuaEnvironment> {
    const OBJECT: &str = "environment.sky";
    let given: SkyOptions = arguments.record()?;
    let sun = match given.sun {
        None => None,
        Some(value) => Some(SunOptions::read(&nested(OBJECT, "\"sun\""), value)?),
    };
    if !(given.ground.min() >= 0.0 && given.ground.max() <= 1.0) {
        let found = format!("{} to {}", given.ground.min(), given.ground.max());
        return Err(Error::out_of_range(OBJECT, "\"ground\"", found, "0 to 1").into());
    }
    let daylight = Daylight {
        kind: sky_kind(OBJECT, &given.kind)?,
        sun: sun.map(|sun| SunPlace {
            azimuth_deg: sun.azimuth,
            elevation_deg: sun.elevation,
            illuminance_lx: sun.illuminance,
            cct_k: sun.cct,
        }),
        turbidity: given.turbidity,
        cct_k: given.cct,
        ground: given.ground,
        illuminance_lx: given.illuminance,
    };
    Ok(LuaEnvironment(Arc::new(daylight.environment()?)))
}

fn sky_kind(object: &str, value: &Value) -> mlua::Result<SkyKind> {
    let expected = "\"overcast\", \"clear\", or a number from 1 to 15";
    if let Value::String(word) = value {
        let kinds = [("overcast", 0), ("clear", 12)];
        let number = options::choice(object, "\"kind\"", &word.to_string_lossy(), &kinds)?;
        return Ok(SkyKind::standard(number).unwrap_or(SkyKind::Overcast));
    }
    if !matches!(value, Value::Integer(_) | Value::Number(_)) {
        return Err(wrong_type(object, "\"kind\"", value, expected).into());
    }
    let number = options::count(object, "\"kind\"", value, 1, 15)?;
    Ok(SkyKind::standard(number as usize).unwrap_or(SkyKind::Overcast))
}

const SIZE: Numbers<2> =
    Numbers { range: Range::above_zero("mm"), expected: "two lengths: along x and z" };

options! {
    /// A room with the lamp in its middle.
    struct RoomOptions {
        /// along x and z
        size: [f64; 2] = SIZE.or([8000.0, 12000.0]),
        /// of the ceiling over the lamp
        above: f64 = Number(Range::above_zero("mm")).or(2500.0),
        /// of the floor under the lamp
        below: f64 = Number(Range::above_zero("mm")).or(1000.0),
        /// luminous rectangles in the ceiling: rows along z
        rows: usize = Count::new(0, 1000).or(3),
        /// along x
        columns: usize = Count::new(0, 1000).or(2),
        /// of each rectangle, along x and z
        panel: [f64; 2] = SIZE.or([1500.0, 1500.0]),
        /// rectangles of their own, beside those in rows
        panels: Vec<Value> = List {
            entry: Any { lua_type: "PanelOptions", expected: "a table of options" },
            expected: "a list of {center =, size =, luminance =}",
            naming: Naming::Key,
        }.or(Vec::new()),
        /// of the rectangles
        luminance: f64 = LUMINANCE.or(3000.0),
        ceiling: f64 = LUMINANCE.or(120.0),
        walls: f64 = LUMINANCE.or(80.0),
        floor: f64 = LUMINANCE.or(30.0),
        /// of all (CIE daylight)
        cct: f64 = CCT.or(5000.0),
        /// of the rectangles, in place of daylight
        spectrum: Option<Spectrum> = SpectrumOrNumber::new("").optional("daylight of cct"),
        /// on a level plane: scales everything
        illuminance: Option<f64> = LX.optional("what follows"),
        /// right-handed about +Y
        rotate: f64 = AZIMUTH.or(0.0),
    }
}

options! {
    /// A luminous rectangle in a room's ceiling.
    struct PanelOptions {
        /// along x and z
        size: [f64; 2] = SIZE,
        luminance: f64 = LUMINANCE,
        /// x and z
        center: [f64; 2] = Numbers {
            range: Range::ANY,
            expected: "two lengths: along x and z",
        }.or([0.0, 0.0]),
    }
}

fn room(mut arguments: Arguments) -> mlua::Result<LuaEnvironment> {
    const OBJECT: &str = "environment.room";
    let given: RoomOptions = arguments.record()?;
    let mut panels = in_rows(&given);
    for (at, value) in (1..).zip(given.panels) {
        let PanelOptions { center, size, luminance } =
            PanelOptions::read(&format!("{OBJECT}: panel {at}"), value)?;
        panels.push(CeilingPanel { center, size, luminance });
    }
    let room = Room {
        size: given.size,
        above_mm: given.above,
        below_mm: given.below,
        panels,
        ceiling: given.ceiling,
        walls: given.walls,
        floor: given.floor,
    };
    let daylight = Spectrum::daylight(given.cct);
    let spectra = vec![given.spectrum.unwrap_or_else(|| daylight.clone()), daylight];
    let environment = Environment::new(Dome::Room(room), spectra)?.turned(given.rotate);
    let environment = match given.illuminance {
        Some(lx) => with_illuminance(environment, OBJECT, lx)?,
        None => environment,
    };
    Ok(LuaEnvironment(Arc::new(environment)))
}

/// Evenly over the ceiling.
fn in_rows(given: &RoomOptions) -> Vec<CeilingPanel> {
    let place =
        |at: usize, count: usize, length: f64| ((at as f64 + 0.5) / count as f64 - 0.5) * length;
    let rows = (0..given.rows).flat_map(|row| (0..given.columns).map(move |column| (column, row)));
    rows.map(|(column, row)| CeilingPanel {
        center: [
            place(column, given.columns, given.size[0]),
            place(row, given.rows, given.size[1]),
        ],
        size: given.panel,
        luminance: given.luminance,
    })
    .collect()
}

/// ΔE00 of colors that became spectra and colors again: mean and largest.
fn colors_back(mut arguments: Arguments) -> mlua::Result<(f64, f64)> {
    let name = arguments.text("gamut")?;
    let gamuts = [("srgb", ColorGamut::Rec709), ("p3", ColorGamut::P3)];
    let gamut = options::choice("environment.round_trip", "gamut", &name, &gamuts)?;
    let [mean, largest] = round_trip(gamut, 17);
    Ok((mean, largest))
}

/// What a scene's `background` may be.
pub(super) struct BackgroundKind;

impl Kind for BackgroundKind {
    type Read = Background;

    fn read(&self, object: &str, what: &str, value: &Value) -> mlua::Result<Background> {
        if let Value::UserData(data) = value
            && let Ok(environment) = data.borrow::<LuaEnvironment>()
        {
            return Ok(Background::Environment(Arc::clone(&environment.0)));
        }
        options::spectrum(object, what, value).map(Background::Even)
    }

    fn lua_type(&self) -> String {
        "Spectrum|number|Environment".to_owned()
    }

    fn expected(&self) -> String {
        "a spectrum, a number or an environment".to_owned()
    }

    fn allowed(&self) -> String {
        "0 or more".to_owned()
    }

    fn shown(&self, value: &Background) -> String {
        match value {
            Background::Even(spectrum) => spectrum.values()[0].to_string(),
            Background::Environment(_) => String::new(),
        }
    }
}

impl LuaEnvironment {
    /// On a plane with this normal, sun included.
    fn illuminance(&self, normal: Option<DVec3>) -> mlua::Result<f64> {
        let normal = normal.unwrap_or(DVec3::Y).try_normalize().ok_or_else(|| {
            Error::out_of_range("environment:illuminance", "normal", "{0, 0, 0}", "a direction")
        })?;
        let sun = self
            .0
            .sun()
            .map_or(0.0, |sun: &Sun| sun.illuminance_lx * sun.direction.dot(normal).max(0.0));
        Ok(self.0.illuminance_lx(normal) + sun)
    }

    /// Spectral radiance in a direction.
    fn bands(&self, azimuth_deg: f64, elevation_deg: f64) -> mlua::Result<Vec<f64>> {
        let grid = WavelengthGrid::Step5;
        let (dome, sun) = self.0.seen(toward(azimuth_deg, elevation_deg));
        let spectra = self.0.spectra().iter().zip(dome);
        let sun = self.0.sun().map(|given| (&given.spectrum, sun));
        let mut bands = vec![0.0; grid.bands()];
        for (spectrum, luminance) in spectra.chain(sun) {
            let unit = per_lumen(spectrum, grid)?;
            bands.iter_mut().zip(unit).for_each(|(sum, value)| *sum += luminance * value);
        }
        Ok(bands)
    }

    fn seen(&self, mut arguments: Arguments) -> mlua::Result<Vec<f64>> {
        let mut angle = |what| arguments.number(what, Range::new(-360.0, 360.0, "degrees"));
        self.bands(angle("azimuth")?, angle("elevation")?)
    }
}

/// What surrounds the scene, in words.
fn kind_of(dome: &Dome) -> String {
    match dome {
        Dome::Picture(picture) => {
            format!("picture, {} × {} pixels", picture.width(), picture.height())
        }
        Dome::Sky(Sky { kind: SkyKind::Overcast, .. }) => "overcast sky".to_owned(),
        Dome::Sky(Sky { kind: SkyKind::Standard(sky), .. }) => {
            format!("sky {} of CIE S 011", sky.number)
        }
        Dome::Room(room) => format!("room, {} panels", room.panels.len()),
    }
}

impl UserData for LuaEnvironment {
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "environment");
        members.method("illuminance", 1, |_, this, mut a| {
            const OBJECT: &str = "environment:illuminance";
            let normal = match a.value() {
                Value::Nil => None,
                value => Some(options::vector(OBJECT, "normal", &value)?),
            };
            this.illuminance(normal)
        });
        members.method("xyz", 2, |_, this, a| {
            let bands = this.seen(a)?;
            let Xyz { x, y, z } = Xyz::from_bands(WavelengthGrid::Step5, &bands);
            Ok((x, y, z))
        });
        members.method("spectrum", 2, |_, this, a| {
            const OBJECT: &str = "environment:spectrum";
            let bands = this.seen(a)?;
            let rows = WavelengthGrid::Step5.wavelengths_nm().zip(bands);
            Ok(LuaSpectrum(Arc::new(Spectrum::from_pairs(OBJECT, rows)?)))
        });
        members.text(|this| {
            let kind = kind_of(this.0.dome());
            let sun = this.0.sun().map_or_else(String::new, |sun| {
                let elevation = sun.direction.y.asin().to_degrees();
                format!(", sun of {:.0} lx at {elevation:.1}°", sun.illuminance_lx)
            });
            let lx = this.illuminance(None)?;
            Ok(format!("environment: {kind}{sun}, {lx:.0} lx on a level plane"))
        });
        members.no_others();
    }
}
