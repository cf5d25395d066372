//! The output folder, and writing files so that none is ever found half written.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

/// Suffix of a file that is still being written; it becomes its final name when it is complete.
const PARTIAL: &str = ".part";

/// Files of ours other than the numbered ones.
///
/// `case.json` is not among them: it may be the very case that is being run, and is replaced as a
/// whole once the run has something to show.
const OWN_FILES: [&str; 7] = [
    "series.pvd",
    "probes.csv",
    "probes.svg",
    "profile.svg",
    "front.csv",
    "front.svg",
    "report.json",
];

/// What went wrong with the output, and where.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The folder could not be made.
    #[error("cannot create the output folder {path}: {source}")]
    CreateFolder {
        /// The folder asked for.
        path: PathBuf,
        /// What the system answered.
        source: io::Error,
    },
    /// The folder exists, but no file can be made in it.
    #[error("cannot write into the output folder {path}: {source}")]
    NotWritable {
        /// The folder asked for.
        path: PathBuf,
        /// What the system answered.
        source: io::Error,
    },
    /// A file of an earlier run could not be removed.
    #[error("cannot remove {path}, left by an earlier run: {source}")]
    RemoveStale {
        /// The stale file, or the folder where it cannot be listed.
        path: PathBuf,
        /// What the system answered.
        source: io::Error,
    },
    /// A file could not be written; nothing of it is left under its name.
    #[error("cannot write {path}: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system answered.
        source: io::Error,
    },
}

/// A folder for the files of one run.
///
/// [`Self::create`] makes it and checks that it can be written, before any computing;
/// [`Self::remove_stale`] clears away the files of an earlier run; [`Self::abandon`] undoes
/// `create` where the run did not come about.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// Folders that `create` made, deepest first.
    made: Vec<PathBuf>,
}

impl OutputFolder {
    /// Makes the folder, and its parents, where missing, and checks that files can be written.
    /// Files that are there already are left alone.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, OutputError> {
        let path = path.into();
        let missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let made = path.ancestors().take_while(missing).map(Path::to_path_buf).collect();
        let folder = Self { path, made };
        let checked = folder.make_and_check();
        if checked.is_err() {
            folder.remove_made();
        }
        checked.map(|()| folder)
    }

    fn make_and_check(&self) -> Result<(), OutputError> {
        let path = || self.path.clone();
        fs::create_dir_all(&self.path)
            .map_err(|source| OutputError::CreateFolder { path: path(), source })?;
        let trial = self.path.join(format!(".diffusph-{}{PARTIAL}", std::process::id()));
        fs::write(&trial, b"x")
            .and_then(|()| fs::remove_file(&trial))
            .map_err(|source| OutputError::NotWritable { path: path(), source })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Removes the files that an earlier run left: `particles_NNNN.vtu`, `series.pvd`,
    /// `probes.csv`, `probes.svg`, `profile.svg`, `front.csv`, `front.svg`, `report.json`, and unfinished
    /// ones of the same names. Anything else stays.
    pub fn remove_stale(&self) -> Result<(), OutputError> {
        let failed = |path: &Path, source| OutputError::RemoveStale { path: path.into(), source };
        let entries = fs::read_dir(&self.path).map_err(|e| failed(&self.path, e))?;
        for entry in entries {
            let entry = entry.map_err(|e| failed(&self.path, e))?;
            let is_file = entry.file_type().is_ok_and(|kind| !kind.is_dir());
            if is_file && entry.file_name().to_str().is_some_and(is_own_file) {
                fs::remove_file(entry.path()).map_err(|e| failed(&entry.path(), e))?;
            }
        }
        Ok(())
    }

    /// Writes `value` as indented JSON to the file `name` of the folder.
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<PathBuf, OutputError> {
        let path = self.path.join(name);
        write_whole(&path, |out| {
            serde_json::to_writer_pretty(&mut *out, value)?;
            out.write_all(b"\n")
        })?;
        Ok(path)
    }

    /// Gives the folder up: the folders that [`Self::create`] made are removed again, unless
    /// something has been written to them since.
    pub fn abandon(self) {
        self.remove_made();
    }

    fn remove_made(&self) {
        for folder in &self.made {
            // `remove_dir` refuses a folder that holds anything, which is what keeps files safe.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Whether a file of this name is one that a run writes.
fn is_own_file(name: &str) -> bool {
    let name = name.strip_suffix(PARTIAL).unwrap_or(name);
    let number = name.strip_prefix("particles_").and_then(|rest| rest.strip_suffix(".vtu"));
    let is_number = |text: &str| text.len() >= 4 && text.bytes().all(|b| b.is_ascii_digit());
    number.is_some_and(is_number) || OWN_FILES.contains(&name)
}

/// Writes a file under a temporary name and renames it when it is complete, so that a full disk
/// or an interrupt leaves the old file, or none, but never half of one.
pub(crate) fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    let mut name = OsString::from(path);
    name.push(PARTIAL);
    let partial = PathBuf::from(name);
    let written = File::create(&partial).and_then(|file| {
        let mut out = BufWriter::with_capacity(1 << 16, file);
        write(&mut out)?;
        out.flush()?;
        drop(out);
        fs::rename(&partial, path)
    });
    written.map_err(|source| {
        // The first error is the one worth telling; the partial file may not even exist.
        let _ = fs::remove_file(&partial);
        OutputError::Write { path: path.into(), source }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn removes_own_stale_files_and_nothing_else() {
        let root = tempfile::tempdir().unwrap();
        let own = ["particles_0000.vtu", "particles_12345.vtu", "report.json", "series.pvd.part"];
        let other =
            ["case.json", "notes.txt", "particles_1.vtu", "particles_best.vtu", "report.json.bak"];
        for name in own.iter().chain(&other).chain(&OWN_FILES) {
            fs::write(root.path().join(name), "x").unwrap();
        }
        fs::create_dir(root.path().join("particles_0007.vtu")).unwrap();
        let folder = OutputFolder::create(root.path()).unwrap();
        assert_eq!(names(root.path()).len(), 16, "nothing goes before the caller asks");
        folder.remove_stale().unwrap();
        let mut left = other.to_vec();
        left.insert(2, "particles_0007.vtu");
        assert_eq!(names(root.path()), left);
    }

    #[test]
    fn abandoning_removes_what_was_made_and_only_that() {
        let root = tempfile::tempdir().unwrap();
        let deep = root.path().join("a/b");
        OutputFolder::create(&deep).unwrap().abandon();
        assert!(names(root.path()).is_empty());

        let folder = OutputFolder::create(&deep).unwrap();
        fs::write(deep.join("kept"), "x").unwrap();
        folder.abandon();
        assert_eq!(names(&deep), ["kept"]);

        OutputFolder::create(root.path()).unwrap().abandon();
        assert!(root.path().exists(), "a folder that was there before stays");
    }

    #[test]
    fn says_which_folder_cannot_be_used() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("file");
        fs::write(&file, "x").unwrap();
        for path in [file.clone(), file.join("below")] {
            let error = OutputFolder::create(&path).unwrap_err();
            assert!(error.to_string().contains(path.to_str().unwrap()), "{error}");
        }
        assert_eq!(names(root.path()), ["file"]);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_whole() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("report.json");
        write_whole(&path, |out| out.write_all(b"first")).unwrap();
        let error = write_whole(&path, |out| {
            out.write_all(b"sec")?;
            Err(io::Error::new(io::ErrorKind::StorageFull, "disk full"))
        });
        assert!(error.unwrap_err().to_string().contains("disk full"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "first");
        assert_eq!(names(root.path()), ["report.json"]);
        write_whole(&path, |out| out.write_all(b"second")).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "second");
    }
}
