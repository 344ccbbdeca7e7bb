//! Stand-in until the real image lands.
use crate::spectrum::WavelengthGrid;

#[derive(Debug, Clone)]
pub struct SpectralImage {
    pub width: usize,
    pub height: usize,
    pub grid: WavelengthGrid,
    pub bands: Vec<f32>,
    pub error: Option<Vec<f32>>,
    pub samples: Option<Vec<f32>>,
}
