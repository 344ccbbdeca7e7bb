//! The two ways to ask for a picture.

use super::{Quality, RenderStats, Watch, render, render_to_target};
use crate::error::Result;
use crate::image::SpectralImage;
use crate::scene::Prepared;
use crate::shading::TraceLimits;
use crate::view::View;

/// What a user asks of a picture: how it is made, or how good it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Asked {
    /// How it is made: [`render`] takes it.
    Quality(Quality),
    /// Relative rms error of luminance over lit pixels: [`render_to_target`] takes it.
    TargetError(f64),
}

impl Asked {
    /// Where the trees of rays end; with a target error, where they do unless it asks for more.
    pub fn limits(&self) -> TraceLimits {
        match self {
            Self::Quality(quality) => quality.limits,
            Self::TargetError(_) => Quality::default().limits,
        }
    }

    /// Takes the picture; errors as [`render`].
    pub fn render(
        &self,
        prepared: &Prepared,
        view: &View,
        watch: &dyn Watch,
    ) -> Result<(SpectralImage, RenderStats)> {
        match self {
            Self::Quality(quality) => render(prepared, view, quality, watch),
            Self::TargetError(target) => render_to_target(prepared, view, *target, watch),
        }
    }
}
