//! Pictures of images that were rendered before, from their EXR files.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::display::{Developed, Look};
use crate::error::{Error, Result};
use crate::output;

/// Develops each EXR file into a PNG file of its name, in `folder` or else beside it; several at
/// once. The results are in the order of `files`.
///
/// Errors: two files that would become one; each file's own, in its place.
pub fn develop_files(
    files: &[PathBuf],
    look: &Look,
    folder: Option<&Path>,
) -> Result<Vec<Result<(PathBuf, Developed)>>> {
    if let Some(folder) = folder {
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
    }
    let targets: Vec<PathBuf> = files.iter().map(|file| target(file, folder)).collect();
    let mut seen = BTreeSet::new();
    if let Some(twice) = targets.iter().find(|target| !seen.insert(*target)) {
        let problem = format!("two files would become {}", twice.display());
        return Err(Error::inconsistent("develop", problem));
    }
    let each = files.par_iter().zip(targets).map(|(file, target)| {
        let image = output::read_exr(file)?;
        let developed = output::develop_png(&target, &image, look)?;
        Ok((target, developed))
    });
    Ok(each.collect())
}

fn target(file: &Path, folder: Option<&Path>) -> PathBuf {
    let beside = file.with_extension("png");
    match (folder, beside.file_name()) {
        (Some(folder), Some(name)) => folder.join(name),
        _ => beside,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Photometry;
    use crate::image::SpectralImage;
    use crate::output::scratch::ScratchFolder;
    use crate::spectrum::WavelengthGrid;

    #[test]
    fn files_become_the_pictures_of_their_first_run() {
        let scratch = ScratchFolder::new();
        let mut image = SpectralImage::new(4, 2, WavelengthGrid::Step20, Photometry::Relative);
        image.bands.iter_mut().enumerate().for_each(|(at, value)| *value = at as f32);
        image.metadata.insert("script".to_owned(), "lamp.lua".to_owned());
        let [first, exr] = ["first.png", "i.exr"].map(|name| scratch.path(name));
        output::develop_png(&first, &image, &Look::paper()).unwrap();
        output::write_exr(&exr, &image).unwrap();
        let missing = scratch.path("missing.exr");
        let folder = scratch.path("again");
        let files = [exr.clone(), missing];
        let results = develop_files(&files, &Look::paper(), Some(&folder)).unwrap();
        let (path, _) = results[0].as_ref().unwrap();
        assert_eq!(*path, folder.join("i.png"));
        assert!(std::fs::read(path).unwrap() == std::fs::read(&first).unwrap());
        assert!(results[1].as_ref().unwrap_err().to_string().contains("missing.exr"));
        let message = develop_files(&[exr.clone(), exr], &Look::paper(), None).unwrap_err();
        assert!(message.to_string().starts_with("develop: two files would become"));
    }
}
