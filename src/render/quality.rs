//! What a user trades for speed: camera rays a pixel, limits of the trees of rays, bands.

use std::fmt;

use crate::shading::{Layers, TraceLimits};
use crate::spectrum::WavelengthGrid;

/// How a picture is made: what a user trades for speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Camera rays a pixel.
    pub samples: Samples,
    /// Where the trees of rays end, and how exact sums over light samples are.
    pub limits: TraceLimits,
    /// Bands of the picture.
    pub grid: WavelengthGrid,
    /// Parts that the picture keeps apart.
    pub layers: Layers,
}

impl Default for Quality {
    fn default() -> Self {
        Self {
            samples: Samples::Fixed(4),
            limits: TraceLimits::default(),
            grid: WavelengthGrid::Step5,
            layers: Layers::None,
        }
    }
}

/// How many camera rays each pixel gets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Samples {
    /// The same number, from 1 on; a single one goes through the pixel's center.
    Fixed(u32),
    /// From `min` on, until the standard error of the pixel's luminance relative to
    /// max(pixel, image mean) is below `error`, or `max` is reached.
    Adaptive {
        /// Camera rays that every pixel gets, from 2 on.
        min: u32,
        /// Camera rays that no pixel exceeds.
        max: u32,
        /// Relative standard error, above 0.
        error: f64,
    },
    /// Until the estimated rms error of luminance over lit pixels, relative to each, is below
    /// `error`, or pixels that have `max` are too many for that; most where they help most.
    Lit {
        /// Camera rays that no pixel exceeds.
        max: u32,
        /// Relative rms error over lit pixels, above 0.
        error: f64,
    },
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.samples {
            Samples::Fixed(count) => write!(f, "samples {count}")?,
            Samples::Adaptive { min, max, error } => {
                write!(f, "samples {min} to {max} for error {error}")?;
            }
            Samples::Lit { max, error } => {
                write!(f, "samples up to {max} for error {error} over lit pixels")?;
            }
        }
        let TraceLimits { max_depth, min_throughput, light_error, dispersion } = self.limits;
        let max_depth = match max_depth {
            TraceLimits::ANY_DEPTH => "auto".to_owned(),
            depth => depth.to_string(),
        };
        let step_nm = self.grid.step_nm();
        write!(
            f,
            ", max_depth {max_depth}, min_throughput {min_throughput}, light_error {light_error}, \
             wavelength_step {step_nm}"
        )?;
        if dispersion > 1 {
            write!(f, ", dispersion {dispersion}")?;
        }
        match self.layers {
            Layers::None => Ok(()),
            Layers::Lights => write!(f, ", layers lights"),
            Layers::Paths => write!(f, ", layers paths"),
        }
    }
}
