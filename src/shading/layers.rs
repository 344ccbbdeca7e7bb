//! Where light came from: parts of a picture that add up to it.

use super::walk::RayKind;
use crate::spectrum::Bands;

/// How a picture is parted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Layers {
    /// Not at all.
    #[default]
    None,
    /// One layer for each light, and one for background and ambient light.
    Lights,
    /// By the last ray before the light: from the eye, mirrored, transmitted.
    Paths,
}

impl Layers {
    /// Names of the layers of a scene with so many lights, in order.
    pub fn names(self, lights: usize) -> Vec<String> {
        match self {
            Self::None => Vec::new(),
            Self::Lights => {
                let names = (1..=lights).map(|light| format!("light {light}"));
                names.chain(["surroundings".to_owned()]).collect()
            }
            Self::Paths => ["direct", "mirrored", "transmitted"].map(str::to_owned).to_vec(),
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
    /// Background or ambient light.
    Surroundings,
}

impl LayeredSum<'_> {
    /// Adds the same to the whole and to the part that it belongs to.
    pub(super) fn add(&mut self, origin: Origin, kind: RayKind, add: impl Fn(&mut Bands)) {
        add(self.whole);
        let part = match (self.layers, origin) {
            (Layers::None, _) => return,
            (Layers::Lights, Origin::Light(light)) => light,
            (Layers::Lights, Origin::Surroundings) => self.parts.len() - 1,
            (Layers::Paths, _) => match kind {
                RayKind::Camera => 0,
                RayKind::Mirrored => 1,
                RayKind::Transmitted => 2,
            },
        };
        add(&mut self.parts[part]);
    }
}
