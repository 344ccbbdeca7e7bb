//! The sum over a RAYSET at a hit, exactly or within a stated error (eq. 9).

use crate::light::RaySet;
use crate::light::sum::{HitQuery, LightSum, Visibility, reference_sum};

/// A RAYSET prepared for sums at many hits.
#[derive(Debug, Clone)]
pub struct LightTree {
    set: RaySet,
}

impl LightTree {
    pub fn build(set: &RaySet) -> LightTree {
        LightTree { set: set.clone() }
    }

    /// Eq. 9 at a hit.
    ///
    /// `light_error`: largest error relative to each of the two sums; 0 for the exact sum.
    pub fn sum(
        &self,
        query: &HitQuery,
        _light_error: f64,
        visible: Option<Visibility>,
    ) -> LightSum {
        reference_sum(&self.set, query, visible)
    }

    pub fn len(&self) -> usize {
        self.set.samples.len()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
