//! What a hit sees of a light.

use crate::geometry::DVec3;

/// What a hit sees of the places of a light.
#[derive(Clone, Copy)]
pub struct Visibility<'a> {
    /// Whether the segment from the hit to a place is free.
    pub place: &'a dyn Fn(DVec3) -> bool,
    /// What is known of all places of the light in a ball.
    pub ball: &'a dyn Fn(DVec3, f64) -> Sight,
}

impl<'a> Visibility<'a> {
    /// Of a light that can only be asked place by place.
    pub fn of_places(place: &'a dyn Fn(DVec3) -> bool) -> Self {
        Self { place, ball: &|_, _| Sight::Unknown }
    }
}

/// What is known of many places at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    /// None is hidden.
    Seen,
    /// None is seen.
    Hidden,
    /// Only asking place by place tells.
    Unknown,
}
