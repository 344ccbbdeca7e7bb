//! What a running script shows to somebody who watches: pictures while they are made, and what it
//! prints.

mod refine;
mod tev;

use std::collections::HashMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::{Value, json};

use crate::display::Look;
use crate::image::SpectralImage;
use crate::output;

pub use refine::render;
use tev::Tev;

/// Pictures and text of one script, over all its runs.
#[derive(Debug, Default)]
pub struct Screen {
    state: Mutex<ScreenState>,
    changed: Condvar,
    tev: Mutex<Tev>,
}

#[derive(Debug, Default)]
struct ScreenState {
    /// One more for each change.
    version: u64,
    run: u64,
    /// Renders of this run so far.
    renders: usize,
    status: Status,
    text: String,
    pictures: Vec<ShownPicture>,
    /// As what the script saved each render last.
    looks: HashMap<usize, Looks>,
}

#[derive(Debug, Default)]
struct Looks {
    run: u64,
    named: Vec<(String, Look)>,
}

/// How the run goes.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Status {
    /// It goes on.
    #[default]
    Running,
    /// All is done.
    Done,
    /// The script or its input failed: the message.
    Failed(String),
}

#[derive(Debug)]
struct ShownPicture {
    /// Its number in the run; `None` for one that was not rendered, but loaded.
    render: Option<usize>,
    name: String,
    /// Pixels of a row and rows of the whole picture.
    size: [usize; 2],
    /// Pixels of the whole picture, along a side, to one that is shown.
    shrink: usize,
    png: Arc<[u8]>,
    version: u64,
    run: u64,
}

/// Text that is kept, bytes: more is nobody's to read.
const MOST_TEXT: usize = 200_000;

impl Screen {
    fn state(&self) -> MutexGuard<'_, ScreenState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut ScreenState)) {
        let mut state = self.state();
        state.version += 1;
        change(&mut state);
        self.changed.notify_all();
    }

    /// The script runs from its start; what is shown stays until it is replaced.
    pub fn begin_run(&self) {
        self.tev.lock().unwrap_or_else(PoisonError::into_inner).connect();
        self.change(|state| {
            state.run += 1;
            state.renders = 0;
            state.status = Status::Running;
            state.text.clear();
        });
    }

    /// The run has ended: what it has not shown again is gone, unless it failed.
    pub fn end_run(&self, status: Status) {
        self.change(|state| {
            let run = state.run;
            if status == Status::Done {
                state.pictures.retain(|picture| picture.run == run);
                state.looks.retain(|_, looks| looks.run == run);
            }
            state.status = status;
        });
    }

    /// Adds to the text.
    pub fn print(&self, text: &str) {
        self.change(|state| {
            state.text.push_str(text);
            let surplus = state.text.len().saturating_sub(MOST_TEXT);
            let cut = (surplus..).find(|&at| state.text.is_char_boundary(at));
            state.text.drain(..cut.unwrap_or(0));
        });
    }

    /// The number of the render that begins now.
    fn next_render(&self) -> usize {
        let mut state = self.state();
        state.renders += 1;
        state.renders
    }

    /// Shows a render, as the script saved it in its last run; `shrink` is how much smaller it is
    /// than the picture that it will be.
    fn show(&self, render: usize, image: &SpectralImage, size: [usize; 2], shrink: usize) {
        let looks = self.state().looks.get(&render).map(|looks| looks.named.clone());
        let looks = looks.unwrap_or_else(|| vec![(format!("render {render}"), Look::default())]);
        for (name, look) in looks {
            // What cannot be shown will be told when the script saves it.
            if let Ok((_, raster)) = output::develop_raster(image, &look) {
                self.put(Some(render), &name, size, shrink, &raster);
            }
        }
        let mut tev = self.tev.lock().unwrap_or_else(PoisonError::into_inner);
        tev.send(&format!("lampyris: render {render}"), image, size, shrink);
    }

    /// Shows a picture that the script saves, and remembers as what.
    pub fn saved(&self, render: Option<usize>, name: &str, look: &Look, raster: &output::Raster) {
        if let Some(render) = render {
            let mut state = self.state();
            let ScreenState { run, looks, pictures, .. } = &mut *state;
            let looks = looks.entry(render).or_default();
            if looks.run != *run {
                *looks = Looks { run: *run, named: Vec::new() };
            }
            looks.named.retain(|(known, _)| known != name);
            looks.named.push((name.to_owned(), look.clone()));
            let is_saved = |shown: &str| looks.named.iter().any(|(name, _)| name == shown);
            pictures.retain(|shown| shown.render != Some(render) || is_saved(&shown.name));
        }
        self.put(render, name, [raster.width, raster.height], 1, raster);
    }

    fn put(
        &self,
        render: Option<usize>,
        name: &str,
        size: [usize; 2],
        shrink: usize,
        raster: &output::Raster,
    ) {
        let mut png = Vec::new();
        if output::encode_png(&mut png, raster).is_err() {
            return; // of no pixels
        }
        self.change(|state| {
            let (version, run) = (state.version, state.run);
            let name = name.to_owned();
            let picture =
                ShownPicture { render, name, size, shrink, png: png.into(), version, run };
            let same = |p: &&mut ShownPicture| p.render == render && p.name == picture.name;
            match state.pictures.iter_mut().find(same) {
                Some(place) => *place = picture,
                None => state.pictures.push(picture),
            }
        });
    }

    /// What there is to see, once it is newer than `version`, or after `patience`.
    pub fn wait_for_news(&self, version: u64, patience: Duration) -> Value {
        let state = self.state();
        let is_old = |state: &mut ScreenState| state.version <= version;
        let waited = self.changed.wait_timeout_while(state, patience, is_old);
        waited.unwrap_or_else(PoisonError::into_inner).0.to_json()
    }

    /// The PNG file of a picture that is shown.
    pub fn picture(&self, version: u64) -> Option<Arc<[u8]>> {
        let state = self.state();
        let picture = state.pictures.iter().find(|picture| picture.version == version)?;
        Some(Arc::clone(&picture.png))
    }
}

impl ScreenState {
    fn to_json(&self) -> Value {
        let picture = |p: &ShownPicture| {
            json!({
                "name": p.name, "width": p.size[0], "height": p.size[1], "shrink": p.shrink,
                "version": p.version, "is_from_this_run": p.run == self.run,
            })
        };
        let (status, message) = match &self.status {
            Status::Running => ("running", ""),
            Status::Done => ("done", ""),
            Status::Failed(message) => ("failed", message.as_str()),
        };
        json!({
            "version": self.version,
            "run": self.run,
            "status": status,
            "message": message,
            "text": self.text,
            "pictures": self.pictures.iter().map(picture).collect::<Vec<_>>(),
        })
    }
}
