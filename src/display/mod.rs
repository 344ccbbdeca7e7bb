//! What a person sees on a given monitor: the display model (eq. 5 to 8), exposure, tone, gamut.

mod camera;
mod convolve;
mod curve;
mod exposure;
mod fit;
mod gamut;
mod glare;
mod icc;
mod look;
mod measured;
mod model;
mod profile;
mod table;
mod tone;
mod verify;

pub use camera::PhotoCamera;
pub use curve::{Curve, PQ_MAX_CD_M2, Toe};
pub use exposure::{DUSK_CD_M2, Exposure};
pub use fit::{
    ChannelFit, CurveKind, DisplayFit, DisplayMeasurement, RampLight, RampPatch, WorstLevel,
    fit_display,
};
pub use gamut::{Gamut, GamutMap, GamutReport};
pub use glare::{Glare, GlareReport, apply_glare};
pub use look::{Developed, DisplayImage, Latent, Look};
pub use measured::MeasuredCurve;
pub use model::{CHANNELS, Display, DisplayParameters};
pub use profile::{ProfiledDisplay, display_from_profile, is_icc_profile, read_profile};
pub use table::{read_patches, read_ramps};
pub use tone::{MIDDLE_GRAY, Tone, ToneCurve};
pub use verify::{
    ColorPatch, MisfitCause, PatchError, ROUGH_MEAN, TABLE_3, Verdict, Verification, verify,
};
