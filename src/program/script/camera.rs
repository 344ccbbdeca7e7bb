//! `lampyris.camera`.

use mlua::{Lua, Table, UserData, UserDataRegistry};

use super::fault;
use super::kinds::{Kind, Number, Numbers, SpectrumOrNumber, Text};
use super::look::EXPOSURE;
use super::members::{Members, functions};
use super::options::{Arguments, Range};
use super::record::options;
use crate::color::D65_XY;
use crate::display::{Exposure, PhotoCamera};
use crate::spectrum::Spectrum;

/// Handle of a camera.
#[derive(Debug, Clone)]
pub struct LuaCamera(pub PhotoCamera);

options! {
    struct CameraOptions {
        /// response to equal radiant power
        red: Spectrum = CHANNEL,
        green: Spectrum = CHANNEL,
        blue: Spectrum = CHANNEL,
        /// "auto": 99.5 % of the pixels fill no channel
        exposure: Exposure = EXPOSURE.or(Exposure::Auto),
        /// level of a full channel, relative to display white
        full_well: f64 = Number(Range::above_zero("")).or(1.0),
        /// {x, y} that the white balance makes neutral: D65
        white: [f64; 2] = Numbers {
            range: Range::between(0.0, 1.0, ""),
            expected: "a list of 2 numbers",
        }.or(D65_XY),
        name: String = Text("a name").or("camera".to_owned()),
    }
}

const CHANNEL: SpectrumOrNumber = SpectrumOrNumber { expected: "a spectrum", allowed: "" };

/// A table of cameras that can be called to make one.
pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    functions(lua, module, "camera", |functions| {
        functions.add_value("nikon_d5100", LuaCamera(PhotoCamera::nikon_d5100()))?;
        functions.add_value("sigma_sd_merrill", LuaCamera(PhotoCamera::sigma_sd_merrill()))
    })?;
    let call = fault::function(lua, |_, mut a| {
        a.pop_front(); // the table itself
        camera(Arguments::new("camera", a, 1)?)
    })?;
    let meta = module.get::<Table>("camera")?.metatable();
    meta.map_or(Ok(()), |meta| meta.raw_set("__call", call))
}

fn camera(mut arguments: Arguments) -> mlua::Result<LuaCamera> {
    let CameraOptions { red, green, blue, exposure, full_well, white, name } =
        arguments.record()?;
    let camera = PhotoCamera::new(&name, [red, green, blue]);
    let made = PhotoCamera { exposure, full_well, white_xy: white, ..camera };
    made.check()?;
    Ok(LuaCamera(made))
}

impl UserData for LuaCamera {
    fn register(registry: &mut UserDataRegistry<Self>) {
        let mut members = Members::new(registry, "camera");
        members.text(|this| Ok(format!("camera: {}", this.0.name)));
        members.no_others();
    }
}
