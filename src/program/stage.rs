//! A scene that is prepared when it is first needed, and then kept.

use std::sync::{Arc, OnceLock};

use crate::error::Result;
use crate::program::sweep::{self, Digest};
use crate::scene::{Prepared, Scene, plausibility};
use crate::shading;

/// A scene with what is worked out of it once: its preparation and its digest.
#[derive(Debug)]
pub struct Stage {
    /// As it was described.
    pub scene: Scene,
    prepared: OnceLock<Arc<Prepared>>,
    fingerprint: OnceLock<Digest>,
}

impl Stage {
    /// Prepares nothing yet.
    pub fn new(scene: Scene) -> Self {
        Self { scene, prepared: OnceLock::new(), fingerprint: OnceLock::new() }
    }

    /// Whether [`Self::prepared`] has been called.
    pub fn is_prepared(&self) -> bool {
        self.prepared.get().is_some()
    }

    /// The scene ready to be rendered; the first call prepares it, and warns of what looks
    /// unintended.
    ///
    /// Errors: as [`Scene::prepare`].
    pub fn prepared(&self, warn: &dyn Fn(String)) -> Result<Arc<Prepared>> {
        if let Some(prepared) = self.prepared.get() {
            return Ok(Arc::clone(prepared));
        }
        let prepared = Arc::new(shading::prepare(self.scene.clone())?);
        plausibility::of_scene(&prepared).into_iter().for_each(warn);
        Ok(Arc::clone(self.prepared.get_or_init(|| prepared)))
    }

    /// Digest of all that a picture depends on, but view and quality.
    pub fn fingerprint(&self) -> &Digest {
        self.fingerprint.get_or_init(|| sweep::of_scene(&self.scene))
    }
}
