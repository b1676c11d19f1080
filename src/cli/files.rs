//! Writing files so that whoever looks sees an old one or a finished one, never half of one.
//!
//! [`Outputs`] collects the bytes of all files of a command. Before the work, [`check_file`] and [`check_folder`] find
//! out whether they can be written at all; after it, [`Outputs::commit`] writes every file under a temporary name in
//! its own folder and, once all of them are on the disk, renames them.

use super::failure::{Failure, Result};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Files to be written together.
#[derive(Default)]
pub struct Outputs {
    files: Vec<(PathBuf, Vec<u8>)>,
}

impl Outputs {
    /// Adds a file.
    pub fn add(&mut self, path: impl Into<PathBuf>, bytes: impl Into<Vec<u8>>) {
        self.files.push((path.into(), bytes.into()));
    }

    /// Writes all files, making folders where they are missing, and tells their paths. On failure no file of that name
    /// has been touched, unless a rename itself fails.
    pub fn commit(self) -> Result<Vec<PathBuf>> {
        let mut staged = Vec::with_capacity(self.files.len());
        for (path, bytes) in self.files {
            let mut file = Staged::new(&path)?;
            file.file.write_all(&bytes).map_err(|error| Failure::file(&path, error))?;
            file.sync()?;
            staged.push(file);
        }
        staged.into_iter().map(Staged::rename).collect()
    }
}

/// A file under a temporary name beside the one that it is for; it goes unless it is renamed.
pub struct Staged {
    pub file: File,
    temporary: Temporary,
    target: PathBuf,
    path: PathBuf,
}

impl Staged {
    /// Makes an empty one for `path`, and folders where they are missing.
    pub fn new(path: &Path) -> Result<Self> {
        let target = target_of(path)?;
        let folder = folder_of(&target);
        fs::create_dir_all(folder).map_err(|error| Failure::file(folder, error))?;
        let (file, temporary) = temporary(&target).map_err(|error| Failure::file(path, error))?;
        Ok(Staged { file, temporary, target, path: path.to_owned() })
    }

    /// Where it lies now.
    pub fn place(&self) -> &Path {
        self.temporary.0.as_deref().unwrap_or(&self.target)
    }

    /// Waits until it is on the disk.
    pub fn sync(&self) -> Result {
        self.file.sync_all().map_err(|error| Failure::file(&self.path, error))
    }

    /// Gives it its name, and tells that.
    pub fn rename(self) -> Result<PathBuf> {
        self.temporary.rename(&self.target).map_err(|error| Failure::file(&self.path, error))?;
        Ok(self.path)
    }
}

/// Finds out whether a file of this name can be written: its folder must be there.
pub fn check_file(path: &Path) -> Result {
    if path.as_os_str().is_empty() {
        return Err(Failure::new("the name of the output file is empty"));
    }
    let target = target_of(path)?;
    let folder = folder_of(&target);
    match fs::metadata(folder) {
        Ok(metadata) if metadata.is_dir() => probe(&target).map_err(|error| Failure::file(path, error)),
        Ok(_) => Err(Failure::file(path, format!("{} is not a folder", folder.display()))),
        Err(error) => Err(Failure::file(path, format!("the folder {}: {error}", folder.display()))),
    }
}

/// Finds out whether files can be written into this folder, which need not be there yet.
pub fn check_folder(path: &Path) -> Result {
    if path.as_os_str().is_empty() {
        return Err(Failure::new("the name of the output folder is empty"));
    }
    // The nearest part of the path that is there must be a folder that lets us write.
    for folder in path.ancestors() {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        match fs::metadata(folder) {
            Ok(metadata) if metadata.is_dir() => {
                return probe(&folder.join("probe")).map_err(|error| Failure::file(path, error));
            }
            Ok(_) => return Err(Failure::file(path, format!("{} is not a folder", folder.display()))),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(Failure::file(path, error)),
        }
    }
    Err(Failure::file(path, "there is no such folder"))
}

/// Names of the intermediates that `--dump` writes once.
const DUMPED: [&str; 5] = ["shade.png", "id.png", "color.png", "texture.png", "coverage.json"];
/// Names of those that it writes for every paint; from the second paint on, `_2` and so on follows the stem.
const DUMPED_PER_PAINT: [(&str, &str); 3] = [("trajectory", ".png"), ("trajectory", ".csv"), ("blocks", ".json")];

/// Finds out whether an output would get the name of an intermediate.
pub fn check_apart(output: &Path, dump: &Path) -> Result {
    let name = output.file_name().unwrap_or_default().to_string_lossy();
    let same_folder = match (fs::canonicalize(folder_of(output)), fs::canonicalize(dump)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    };
    if same_folder && is_dumped(&name) {
        return Err(Failure::file(output, "--dump writes a file of this name; choose another name or folder"));
    }
    Ok(())
}

/// Whether `--dump` may write a file of this name; how many paints there are is not known yet.
fn is_dumped(name: &str) -> bool {
    DUMPED.contains(&name)
        || DUMPED_PER_PAINT.iter().any(|(stem, extension)| {
            let suffix = name.strip_prefix(stem).and_then(|rest| rest.strip_suffix(extension));
            suffix.is_some_and(|suffix| suffix.is_empty() || suffix.strip_prefix('_').is_some_and(is_further_number))
        })
}

/// Whether this is how a number from 2 on is written.
fn is_further_number(text: &str) -> bool {
    text.parse::<u32>().is_ok_and(|number| number >= 2 && number.to_string() == text)
}

/// The file that a rename has to replace: where a link leads, or the path itself.
fn target_of(path: &Path) -> Result<PathBuf> {
    match fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => Err(Failure::file(path, "is a folder, not a file")),
        // A rename would put a file in the place of a device or a pipe.
        Ok(metadata) if !metadata.is_file() => Err(Failure::file(path, "is not a regular file")),
        Ok(_) if path.is_symlink() => fs::canonicalize(path).map_err(|error| Failure::file(path, error)),
        // Above all a name that is too long.
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(Failure::file(path, error)),
        _ if path.file_name().is_none() => Err(Failure::file(path, "is not the name of a file")),
        _ => Ok(path.to_owned()),
    }
}

fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn probe(target: &Path) -> io::Result<()> {
    temporary(target).map(drop)
}

/// A file that is deleted unless it is renamed.
struct Temporary(Option<PathBuf>);

impl Temporary {
    fn rename(mut self, target: &Path) -> io::Result<()> {
        if let Some(path) = &self.0 {
            fs::rename(path, target)?;
        }
        self.0 = None;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(path) = &self.0 {
            // Nothing can be done about a temporary file that will not go.
            let _ = fs::remove_file(path);
        }
    }
}

/// Makes a new file beside `target`.
fn temporary(target: &Path) -> io::Result<(File, Temporary)> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    loop {
        // Not made of the target's name, which may be as long as a name can be.
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = folder_of(target).join(format!(".impasto-{}-{count}.tmp", std::process::id()));
        match OpenOptions::new().read(true).write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((file, Temporary(Some(path)))),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_that_a_dump_may_write_are_refused() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let dumped = ["shade.png", "id.png", "color.png", "texture.png", "trajectory.png", "trajectory_2.csv"];
        for name in dumped.into_iter().chain(["trajectory.csv", "trajectory_12.png", "blocks.json", "blocks_3.json"]) {
            let failure = check_apart(&dir.path().join(name), dir.path()).expect_err(name);
            assert!(failure.0.contains("--dump"), "{}", failure.0);
            assert!(check_apart(&dir.path().join("..").join(name), dir.path()).is_ok(), "{name} in another folder");
        }
        let free = ["id_card.png", "id_2.png", "shade.bmp", "texture.jpg", "blocks.png", "trajectory_.png"];
        for name in free.into_iter().chain(["trajectory_1.png", "trajectory_02.png", "trajectory_2b.png", "out.png"]) {
            assert!(check_apart(&dir.path().join(name), dir.path()).is_ok(), "{name}");
        }
    }
}
