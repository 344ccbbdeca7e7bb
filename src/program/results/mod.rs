//! The fields of every record that scripts and manifests read.

mod fitted;
mod geometry;
mod pictures;
mod rendering;

pub use fitted::{CHANNEL, LOBE, LOBE_FIT, PATCH, POINT, VERIFICATION};
pub use geometry::{MESH, NamedMesh, RAY, START_SURFACE, WorldRay};
pub use pictures::{
    BUDGET, CONTRIBUTION, DEVELOPED, DIFFERENCE, HOMOGENEITY, NOISE_SHARE, READING, SWEPT,
};
pub use rendering::{ASKED, COST, Cost, LIGHT_CHECK, PATH, STATS, TARGET, VIEW};
