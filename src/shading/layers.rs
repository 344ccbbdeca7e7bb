//! Where light came from: parts of a picture that add up to it.

use super::walk::RayKind;
use crate::scene::Prepared;
use crate::spectrum::Bands;

/// How a picture is parted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Layers {
    /// Not at all.
    #[default]
    None,
    /// One layer for each light, with the light that surfaces pass on of it, and one for background
    /// and ambient light. Light passed on of several lights at once has a layer of its own.
    Lights,
    /// By the last ray before the light: from the eye, mirrored, transmitted. Light that surfaces
    /// passed on has a layer of its own.
    Paths,
}

impl Layers {
    /// Names of a scene's layers, in order.
    pub fn names(self, prepared: &Prepared) -> Vec<String> {
        let bounced = |there: bool| there.then(|| "bounced".to_owned());
        match self {
            Self::None => Vec::new(),
            Self::Lights => {
                let lights = (1..=prepared.own_lights()).map(|light| format!("light {light}"));
                let of_several = bounced(prepared.came_of.contains(&None));
                lights.chain(of_several).chain(["surroundings".to_owned()]).collect()
            }
            Self::Paths => {
                let kinds = ["direct", "mirrored", "transmitted"].map(str::to_owned);
                kinds.into_iter().chain(bounced(prepared.interreflection.is_some())).collect()
            }
        }
    }
}

/// A sample's spectrum, whole and by layers.
#[derive(Debug)]
pub struct LayeredSum<'a> {
    /// All light.
    pub whole: &'a mut Bands,
    /// As many as [`Layers::names`].
    pub parts: &'a mut [Bands],
    /// What the parts are.
    pub layers: Layers,
}

/// What light comes from.
#[derive(Debug, Clone, Copy)]
pub(super) enum Origin {
    Light(usize),
    /// Passed on by surfaces: of one light, or of several.
    Bounced(Option<usize>),
    /// Background or ambient light.
    Surroundings,
}

impl Origin {
    /// What one of the prepared lights is.
    pub(super) fn of_light(prepared: &Prepared, light: usize) -> Self {
        match light.checked_sub(prepared.own_lights()) {
            None => Self::Light(light),
            Some(bounced) => Self::Bounced(prepared.came_of[bounced]),
        }
    }
}

impl LayeredSum<'_> {
    /// Adds the same to the whole and to the part that it belongs to.
    pub(super) fn add(&mut self, origin: Origin, kind: RayKind, add: impl Fn(&mut Bands)) {
        add(self.whole);
        let part = match (self.layers, origin) {
            (Layers::None, _) => return,
            (Layers::Lights, Origin::Light(light) | Origin::Bounced(Some(light))) => light,
            (Layers::Lights, Origin::Surroundings) => self.parts.len() - 1,
            (Layers::Lights, Origin::Bounced(None)) => self.parts.len() - 2,
            (Layers::Paths, Origin::Bounced(_)) => 3,
            (Layers::Paths, _) => match kind {
                RayKind::Camera => 0,
                RayKind::Mirrored => 1,
                RayKind::Transmitted => 2,
            },
        };
        add(&mut self.parts[part]);
    }
}
