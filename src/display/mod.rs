//! What a person sees on a given monitor: the display model (eq. 5 to 8), exposure, tone, gamut.

mod curve;
mod exposure;
mod gamut;
mod icc;
mod model;
mod present;
mod tone;

pub use curve::{Curve, Toe};
pub use exposure::{AUTO_PERCENT, Exposure};
pub use gamut::{Gamut, GamutMap, GamutReport};
pub use model::{CHANNELS, Display, DisplayParameters};
pub use present::{DisplayImage, Rendition, present};
pub use tone::{MIDDLE_GRAY, Tone};
