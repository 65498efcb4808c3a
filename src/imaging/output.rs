//! A file that is whole or not there.
//!
//! What is there already stays, unless it may be overwritten; then too only a file of the same kind (by its first
//! bytes, or empty) is replaced, and none that another program has locked. The file is written beside its place under
//! the name `.name.<process>.partial` and renamed when it is complete; a failure leaves what was there before.
//!
//! ```
//! use nereus::imaging::output::{FileKind, Output, OutputError};
//! let folder = std::env::temp_dir();
//! let path = folder.join(format!("nereus-output-{}.png", std::process::id()));
//! let output = Output::plan(&path, FileKind::Png, false)?;
//! output.write(|partial| {
//!     std::fs::write(partial, b"\x89PNG\r\n\x1a\n").map_err(OutputError::io(partial, "writing"))
//! })?;
//! assert!(matches!(Output::plan(&path, FileKind::Png, false), Err(OutputError::Exists { .. })));
//! assert!(matches!(Output::plan(&path, FileKind::SeaState, true), Err(OutputError::Foreign { .. })));
//! # std::fs::remove_file(&path).unwrap();
//! # Ok::<(), OutputError>(())
//! ```

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Kinds of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A picture.
    Png,
    /// HDF5.
    Hdf5,
    /// Saved state of a sea.
    SeaState,
    /// Table of settings and what they reach, CSV.
    Settings,
    /// Table of the statistics of speckle, CSV.
    Speckle,
}

impl FileKind {
    fn signature(self) -> [u8; 8] {
        match self {
            Self::Png => *b"\x89PNG\r\n\x1a\n",
            Self::Hdf5 => *b"\x89HDF\r\n\x1a\n",
            Self::SeaState => *b"NEREUSEA",
            Self::Settings => *b"setting,",
            Self::Speckle => *b"psi_deg,",
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Settings => "table of settings",
            Self::Speckle => "table of speckle",
            Self::Png => "PNG picture",
            Self::Hdf5 => "HDF5 file",
            Self::SeaState => "saved sea",
        }
    }
}

/// Why a file cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// It is there already.
    #[error("{path}: exists already; choose another name, or overwrite it with --force", path = path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// Something else is there.
    #[error("{path}: not overwritten, because it is no {kind}", path = path.display())]
    Foreign {
        /// What is there.
        path: PathBuf,
        /// What was to be written.
        kind: &'static str,
    },
    /// Another program has it open.
    #[error("{path}: not overwritten, because another program uses it", path = path.display())]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// Two outputs have one name.
    #[error("{path}: named twice", path = path.display())]
    Twice {
        /// The file.
        path: PathBuf,
    },
    /// The system refused.
    #[error("{path}: {action}: {source}", path = path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: io::Error,
    },
}

impl OutputError {
    /// What the system said of a file.
    pub fn io(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, action, source }
    }

    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            Self::Exists { .. } | Self::Foreign { .. } | Self::InUse { .. } | Self::Twice { .. } => true,
            Self::Io { source, .. } => matches!(
                source.kind(),
                io::ErrorKind::NotFound
                    | io::ErrorKind::NotADirectory
                    | io::ErrorKind::IsADirectory
                    | io::ErrorKind::PermissionDenied
            ),
        }
    }
}

/// A file to be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    path: PathBuf,
    kind: FileKind,
    force: bool,
}

impl Output {
    /// Checks that it may be made; nothing is changed.
    pub fn plan(path: &Path, kind: FileKind, force: bool) -> Result<Self, OutputError> {
        let output = Self { path: path.to_owned(), kind, force };
        output.check()?;
        let folder = output.folder();
        let data = fs::metadata(folder).map_err(OutputError::io(folder, "the folder of the output"))?;
        if !data.is_dir() || path.file_name().is_none() {
            let source = io::Error::from(io::ErrorKind::NotADirectory);
            return Err(OutputError::Io {
                path: folder.to_owned(),
                action: "the folder of the output",
                source,
            });
        }
        Ok(output)
    }

    /// Where it will be.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn folder(&self) -> &Path {
        match self.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        }
    }

    fn check(&self) -> Result<(), OutputError> {
        let path = || self.path.clone();
        if fs::symlink_metadata(&self.path).is_err() {
            return Ok(());
        }
        if !self.force {
            return Err(OutputError::Exists { path: path() });
        }
        // A pipe, a device or a folder is not even opened.
        let plain = fs::metadata(&self.path).is_ok_and(|data| data.is_file());
        let Some(mut file) = plain.then(|| fs::File::open(&self.path).ok()).flatten() else {
            return Err(OutputError::Foreign { path: path(), kind: self.kind.name() });
        };
        let mut start = Vec::new();
        let read = file.by_ref().take(8).read_to_end(&mut start);
        if read.is_err() || !(start.is_empty() || start == self.kind.signature()) {
            return Err(OutputError::Foreign { path: path(), kind: self.kind.name() });
        }
        match file.try_lock() {
            Err(fs::TryLockError::WouldBlock) => Err(OutputError::InUse { path: path() }),
            // A system without locks goes without.
            _ => Ok(()),
        }
    }

    /// Has the file written under another name, and gives it its own.
    pub fn write<E: From<OutputError>>(self, fill: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let partial = self.folder().join(format!(".{name}.{}.partial", std::process::id()));
        let _ = fs::remove_file(&partial);
        let done = fill(&partial).and_then(|()| {
            // Somebody may have made the file meanwhile.
            self.check()?;
            fs::rename(&partial, &self.path)
                .map_err(OutputError::io(&self.path, "putting the file in place"))?;
            Ok(())
        });
        if done.is_err() {
            let _ = fs::remove_file(&partial);
        }
        done
    }
}

/// Refuses outputs of the same name.
pub fn apart<'a>(outputs: impl IntoIterator<Item = &'a Output>) -> Result<(), OutputError> {
    let mut seen = Vec::new();
    for output in outputs {
        let folder = fs::canonicalize(output.folder()).unwrap_or_else(|_| output.folder().to_owned());
        let place = folder.join(output.path.file_name().unwrap_or_default());
        if seen.contains(&place) {
            return Err(OutputError::Twice { path: output.path.clone() });
        }
        seen.push(place);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listing(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_failure_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sea.png");
        fs::write(&path, b"\x89PNG\r\n\x1a\nold").unwrap();
        let output = Output::plan(&path, FileKind::Png, true).unwrap();
        let failed = output.clone().write(|partial| {
            fs::write(partial, b"half").unwrap();
            Err(OutputError::Twice { path: partial.to_owned() })
        });
        assert!(failed.is_err());
        assert_eq!(listing(folder.path()), ["sea.png"]);
        assert!(fs::read(&path).unwrap().ends_with(b"old"));
        let done: Result<(), OutputError> = output.write(|partial| {
            fs::write(partial, b"new").unwrap();
            Ok(())
        });
        done.unwrap();
        assert_eq!((listing(folder.path()).len(), fs::read(&path).unwrap().as_slice()), (1, &b"new"[..]));
    }

    #[test]
    fn other_files_are_safe() {
        let folder = tempfile::tempdir().unwrap();
        let plan = |name: &str, force| Output::plan(&folder.path().join(name), FileKind::Hdf5, force);
        fs::write(folder.path().join("thesis.h5"), "chapter 1").unwrap();
        fs::write(folder.path().join("empty.h5"), "").unwrap();
        fs::create_dir(folder.path().join("folder.h5")).unwrap();
        assert!(matches!(plan("thesis.h5", false), Err(OutputError::Exists { .. })));
        assert!(matches!(plan("thesis.h5", true), Err(OutputError::Foreign { .. })));
        assert!(matches!(plan("folder.h5", true), Err(OutputError::Foreign { .. })));
        assert!(matches!(plan("no/such/folder.h5", false), Err(OutputError::Io { .. })));
        assert!(plan("empty.h5", true).is_ok() && plan("..", true).is_err());
        let (a, b) = (plan("a.h5", false).unwrap(), plan("./a.h5", false).unwrap());
        assert!(matches!(apart([&a, &b]), Err(OutputError::Twice { .. })));
        // A file that appears while another is written under its name.
        let late = a.write(|partial| {
            fs::write(partial, "").unwrap();
            fs::write(folder.path().join("a.h5"), "mine").unwrap();
            Ok(())
        });
        assert!(matches!(late, Err(OutputError::Exists { .. })));
        assert_eq!(fs::read(folder.path().join("a.h5")).unwrap(), b"mine");
    }
}
