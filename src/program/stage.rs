//! A scene that is prepared when it is first needed, and then kept.

use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};
use std::time::Instant;

use crate::error::Result;
use crate::light::LightTree;
use crate::program::cache::Cache;
use crate::program::sweep::{self, Digest};
use crate::scene::{Prepared, Scene, plausibility};
use crate::shading;

/// The prepared scenes that a process still has: one that is to be prepared takes over what they
/// have of its meshes and rays.
#[derive(Debug, Clone, Default)]
pub struct InUse(Arc<Mutex<Vec<Weak<Prepared>>>>);

impl InUse {
    /// Those that somebody still holds.
    pub fn all(&self) -> Vec<Arc<Prepared>> {
        let mut list = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        list.retain(|scene| scene.strong_count() > 0);
        list.iter().filter_map(Weak::upgrade).collect()
    }

    fn add(&self, scene: &Arc<Prepared>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(Arc::downgrade(scene));
    }
}

/// A scene with what is worked out of it once: its preparation and its digest.
#[derive(Debug)]
pub struct Stage {
    /// As it was described.
    pub scene: Scene,
    in_use: InUse,
    cache: Cache,
    prepared: OnceLock<Arc<Prepared>>,
    fingerprint: OnceLock<Digest>,
}

impl Stage {
    /// Prepares nothing yet; `in_use` are the others, `cache` has what earlier processes made.
    pub fn new(scene: Scene, in_use: InUse, cache: Cache) -> Self {
        Self { scene, in_use, cache, prepared: OnceLock::new(), fingerprint: OnceLock::new() }
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
        let start = Instant::now();
        // The scene finds them, as long as they are held.
        let lights = self.scene.lights.iter();
        let trees: Vec<Option<LightTree>> =
            lights.map(|light| self.cache.light_tree(&light.rays)).collect();
        let seconds = start.elapsed().as_secs_f64();
        let mut prepared = shading::prepare(self.scene.clone(), &self.in_use.all())?;
        drop(trees);
        prepared.seconds.light_trees += seconds;
        let prepared = Arc::new(prepared);
        self.in_use.add(&prepared);
        plausibility::of_scene(&prepared).into_iter().for_each(warn);
        Ok(Arc::clone(self.prepared.get_or_init(|| prepared)))
    }

    /// Digest of all that a picture depends on, but view and quality.
    pub fn fingerprint(&self) -> &Digest {
        self.fingerprint.get_or_init(|| sweep::of_scene(&self.scene))
    }
}
