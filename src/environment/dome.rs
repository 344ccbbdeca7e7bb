//! What is seen in a direction: the kinds of surroundings.

use glam::DVec3;

use super::patch::Cells;
use super::picture::Picture;
use super::room::Room;
use super::sky::Sky;

/// Most spectra that surroundings are mixed from.
pub const CHANNELS: usize = 3;

/// Luminances of the surroundings' spectra, cd/m²; unused ones are 0.
pub type Luminances = [f64; CHANNELS];

/// Luminance by direction, in the surroundings' own coordinates.
#[derive(Debug, Clone, PartialEq)]
pub enum Dome {
    /// A latitude–longitude picture.
    Picture(Picture),
    /// A sky over an even ground.
    Sky(Sky),
    /// A room with luminous panels.
    Room(Room),
}

impl Dome {
    /// What a ray sees: `direction` is that of `place`.
    pub(super) fn luminances(&self, place: [f64; 2], direction: DVec3) -> Luminances {
        match self {
            Dome::Picture(picture) => picture.luminances(place),
            Dome::Sky(sky) => sky.luminances(direction),
            Dome::Room(room) => room.luminances(direction),
        }
    }

    /// Cells fine enough that four looks into each tell what lobes see of it.
    pub(super) fn cells(&self) -> Cells {
        match self {
            Dome::Picture(picture) => picture.cells(),
            Dome::Sky(_) => Cells { columns: 360, rows: 180 },
            Dome::Room(_) => Cells { columns: 1440, rows: 720 },
        }
    }
}
