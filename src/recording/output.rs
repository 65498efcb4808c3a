//! A file that is whole or not there.
//!
//! One that is complete and cannot be put in its place stays beside it, and the error names it.
//!
//! The rule is that of [`crate::files`]: what is there already stays, unless it may be overwritten; then too
//! only a file of the same kind is exchanged for the new one when that is complete, and none that another
//! program has locked. HDF5 files say by their attribute `format` that this program made them, pictures and
//! tables begin as those of their kind; an empty file holds nothing that is lost.
//!
//! ```
//! use nereus::recording::output::{FileKind, Output, OutputError};
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

use crate::files::{self, Draft, FileFault, Holding};

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

    /// Whether what is there is a file of this kind, or empty.
    fn recognise(self, path: &Path) -> Option<Holding> {
        // A pipe, a device or a folder is not even opened.
        fs::symlink_metadata(path).ok().filter(|data| data.is_file())?;
        let mut start = Vec::new();
        fs::File::open(path).ok()?.take(8).read_to_end(&mut start).ok()?;
        let is_ours = start.is_empty()
            || start == self.signature() && (self != Self::Hdf5 || format(path).starts_with(b"nereus"));
        is_ours.then_some(Holding::File)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Settings => "table of settings",
            Self::Speckle => "table of speckle",
            Self::Png => "PNG picture",
            Self::Hdf5 => "HDF5 file of this program",
            Self::SeaState => "saved sea",
        }
    }
}

/// What an HDF5 file says it is.
#[cfg(feature = "hdf5")]
fn format(path: &Path) -> Vec<u8> {
    crate::sinks::hdf5::file::format_of(path).unwrap_or_default()
}

/// Nothing that this build could have made.
#[cfg(not(feature = "hdf5"))]
fn format(_: &Path) -> Vec<u8> {
    Vec::new()
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
    /// It is complete and not in its place.
    #[error(transparent)]
    Lost(FileFault),
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
            Self::Lost(_) => false,
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
        files::preflight(path, force, &|path| kind.recognise(path)).map_err(|fault| output.fault(fault))?;
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

    /// What the system or the rule for outputs said.
    fn fault(&self, fault: FileFault) -> OutputError {
        match fault {
            FileFault::Exists { path } => OutputError::Exists { path },
            FileFault::Foreign { path } => OutputError::Foreign { path, kind: self.kind.name() },
            FileFault::InUse { path } => OutputError::InUse { path },
            fault @ (FileFault::Removed { .. } | FileFault::Moved { .. } | FileFault::Kept { .. }) => {
                OutputError::Lost(fault)
            }
            FileFault::NoFolder { path } => OutputError::Io {
                path,
                action: "the folder of the output",
                source: io::ErrorKind::NotADirectory.into(),
            },
            FileFault::Io { path, action, source } => OutputError::Io { path, action, source },
        }
    }

    /// Has the file written under another name, and gives it its own.
    pub fn write<E: From<OutputError>>(self, fill: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
        let mut draft = Draft::named(&self.path);
        let filled = fill(draft.path());
        if filled.is_err() {
            // Half a file, or none.
            let _ = draft.made(Holding::File);
            draft.abandon();
            return filled;
        }
        let recognise = |path: &Path| self.kind.recognise(path);
        let done = draft.made(Holding::File).and_then(|()| draft.finish(self.force, &recognise));
        done.map(|_| ()).map_err(|fault| self.fault(fault).into())
    }
}

/// Refuses outputs of the same name.
pub fn apart<'a>(outputs: impl IntoIterator<Item = &'a Output>) -> Result<(), OutputError> {
    let mut seen = Vec::new();
    for output in outputs {
        let place = files::spelling(&output.path);
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
        let Err(OutputError::Lost(FileFault::Kept { why, at, .. })) = late else { panic!("{late:?}") };
        assert!(matches!(*why, FileFault::Exists { .. }) && at.exists());
        assert_eq!(fs::read(folder.path().join("a.h5")).unwrap(), b"mine");
    }
}
