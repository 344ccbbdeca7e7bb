//! What a running script knows of its surroundings: folders, output, warnings, Ctrl-C.

use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use mlua::Lua;

use crate::error::{Error, Result};

/// What the command line says.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Everything written goes under this folder.
    pub out: PathBuf,
    /// No progress on standard error.
    pub quiet: bool,
    /// The script's own arguments.
    pub arguments: Vec<String>,
    /// Set by Ctrl-C.
    pub interrupted: Arc<AtomicBool>,
}

/// The surroundings of one script.
#[derive(Debug, Clone)]
pub struct Host {
    pub script: PathBuf,
    pub settings: Settings,
    warnings: Arc<Mutex<Vec<(String, u32)>>>,
}

impl Host {
    pub fn new(script: &Path, settings: Settings) -> Self {
        Self { script: script.to_owned(), settings, warnings: Arc::default() }
    }

    pub fn is_interrupted(&self) -> bool {
        self.settings.interrupted.load(Ordering::Relaxed)
    }

    pub fn script_folder(&self) -> &Path {
        self.script.parent().unwrap_or(Path::new(""))
    }

    /// Where a file to be read lies: the script's folder first, then the working directory.
    pub fn input(&self, path: &str) -> PathBuf {
        let beside_script = self.script_folder().join(path);
        if beside_script.exists() { beside_script } else { PathBuf::from(path) }
    }

    /// Where a file is to be written, its folder made.
    ///
    /// Errors: a path that leaves the output folder, also through a symbolic link; a folder that
    /// cannot be made.
    pub fn output(&self, path: &str) -> Result<PathBuf> {
        let refused = || {
            let out = self.settings.out.display();
            Error::out_of_range("output", "path", format!("\"{path}\""), format!("below {out}/"))
        };
        let relative = Path::new(path);
        let stays = relative.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if !stays || relative.file_name().is_none() {
            return Err(refused());
        }
        let target = self.settings.out.join(relative);
        let folder = target.parent().unwrap_or(&self.settings.out);
        let io = |e| Error::io(folder, e);
        // The deepest folder that exists decides before anything is made.
        let existing = folder.ancestors().find(|f| f.exists()).unwrap_or(Path::new("."));
        if self.settings.out.exists() {
            let root = self.settings.out.canonicalize().map_err(io)?;
            if existing.starts_with(&self.settings.out)
                && !existing.canonicalize().map_err(io)?.starts_with(&root)
            {
                return Err(refused());
            }
        }
        std::fs::create_dir_all(folder).map_err(io)?;
        Ok(target)
    }

    /// Notes something that silently changes the picture; the same text is printed once, counted.
    pub fn warn(&self, text: impl Into<String>) {
        let text = text.into();
        let mut warnings = self.warnings.lock().unwrap_or_else(|e| e.into_inner());
        match warnings.iter_mut().find(|(known, _)| *known == text) {
            Some((_, count)) => *count += 1,
            None => warnings.push((text, 1)),
        }
    }

    pub fn print_warnings(&self) {
        let warnings = self.warnings.lock().unwrap_or_else(|e| e.into_inner());
        for (text, count) in warnings.iter() {
            let times = if *count > 1 { format!(" ({count} times)") } else { String::new() };
            eprintln!("warning: {text}{times}");
        }
    }
}

/// The host of a state.
pub(super) fn of(lua: &Lua) -> mlua::Result<Host> {
    let host = lua.app_data_ref::<Host>();
    host.map(|host| host.clone()).ok_or_else(|| mlua::Error::runtime("state without a host"))
}
