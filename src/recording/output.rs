//! A file that is whole or not there.
//!
//! One that is complete and cannot be put in its place stays beside it, and the error names it.
//!
//! The rule is that of [`crate::files`]: what is there already stays, unless it may be overwritten; then too
//! only a file of the same kind is exchanged for the new one when that is complete, and none that another
//! program has locked. The attribute `format` of HDF5 files names this program, pictures and
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
//! let refused = Output::plan(&path, FileKind::Png, false).unwrap_err();
//! assert!(refused.to_string().contains("exists already"));
//! let refused = Output::plan(&path, FileKind::SeaState, true).unwrap_err();
//! assert!(refused.to_string().ends_with("because it is no saved sea"));
//! # std::fs::remove_file(&path).unwrap();
//! # Ok::<(), OutputError>(())
//! ```

use std::io;
use std::path::{Path, PathBuf};

use crate::files::{self, Draft, FileFault, Holding, Recognised};
use crate::inputs;

/// Kinds of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
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
    /// CRSD.
    Crsd,
    /// Manual page, roff.
    ManualPage,
}

impl FileKind {
    fn signature(self) -> [u8; 8] {
        match self {
            Self::Png => *b"\x89PNG\r\n\x1a\n",
            Self::Hdf5 => *b"\x89HDF\r\n\x1a\n",
            Self::SeaState => *b"NEREUSEA",
            Self::Settings => *b"setting,",
            Self::Speckle => *b"psi_deg,",
            Self::Crsd => *b"CRSDsar/",
            Self::ManualPage => *b".ie \\n(.",
        }
    }

    /// Whether what is there is a file of this kind, or empty.
    fn recognise(self, path: &Path) -> Recognised {
        let is_ours = inputs::beginning(path, 8)
            .is_some_and(|start| start.is_empty() || start == self.signature() && self.is_ours(path));
        is_ours.then_some(Holding::File).ok_or(self.name())
    }

    /// Whether a file with this signature is one of this program, where others make files of the kind that
    /// cannot be made again.
    fn is_ours(self, path: &Path) -> bool {
        match self {
            Self::Hdf5 => format(path).starts_with(b"nereus"),
            Self::Crsd => {
                let start = inputs::beginning(path, 4096).unwrap_or_default();
                String::from_utf8_lossy(&start).contains("<ProductName>nereus ")
            }
            Self::ManualPage => {
                let start = inputs::beginning(path, 256).unwrap_or_default();
                String::from_utf8_lossy(&start).contains(".TH nereus")
            }
            _ => true,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Settings => "table of settings",
            Self::Speckle => "table of speckle",
            Self::Crsd => "CRSD file of this program",
            Self::Png => "PNG picture",
            Self::Hdf5 => "HDF5 file of this program",
            Self::SeaState => "saved sea",
            Self::ManualPage => "manual page of this program",
        }
    }
}

/// What a new CRSD file may replace.
pub(crate) fn recognise_crsd(path: &Path) -> Recognised {
    FileKind::Crsd.recognise(path)
}

/// The attribute `format` of an HDF5 file.
#[cfg(feature = "hdf5")]
fn format(path: &Path) -> Vec<u8> {
    crate::recording::hdf5::file::format_of(path).unwrap_or_default()
}

/// Nothing that this build could have made.
#[cfg(not(feature = "hdf5"))]
fn format(_: &Path) -> Vec<u8> {
    Vec::new()
}

/// Why a file cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// What is there already, or what the system reported.
    #[error(transparent)]
    File(#[from] FileFault),
    /// Two outputs have one name.
    #[error("{path}: named twice", path = path.display())]
    Twice {
        /// The file.
        path: PathBuf,
    },
}

impl OutputError {
    /// What the system reported of a file.
    pub fn io(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Self {
        let fault = FileFault::io(path, action);
        move |source| fault(source).into()
    }

    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            Self::File(fault) => fault.is_wrong_input(),
            Self::Twice { .. } => true,
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
    ///
    /// # Errors
    /// What is there already and may not be replaced, and a folder that is missing.
    pub fn plan(path: &Path, kind: FileKind, force: bool) -> Result<Self, OutputError> {
        files::preflight(path, force, &|path| kind.recognise(path))?;
        if path.file_name().is_none() {
            return Err(FileFault::NoFolder { path: path.to_owned() }.into());
        }
        Ok(Self { path: path.to_owned(), kind, force })
    }

    /// Where it will be.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Has the file written under another name, and gives it its own.
    ///
    /// # Errors
    /// What `fill` reports, and a file that cannot be put in its place.
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
        done.map(|_| ()).map_err(|fault| OutputError::File(fault).into())
    }
}

/// Refuses outputs of the same name.
///
/// # Errors
/// The first that has the place of another.
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
    use std::fs;

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
        assert!(matches!(plan("thesis.h5", false), Err(OutputError::File(FileFault::Exists { .. }))));
        assert!(matches!(plan("thesis.h5", true), Err(OutputError::File(FileFault::Foreign { .. }))));
        assert!(matches!(plan("folder.h5", true), Err(OutputError::File(FileFault::Foreign { .. }))));
        assert!(matches!(plan("no/such/folder.h5", false), Err(OutputError::File(FileFault::Io { .. }))));
        assert!(plan("empty.h5", true).is_ok() && plan("..", true).is_err());
        let (a, b) = (plan("a.h5", false).unwrap(), plan("./a.h5", false).unwrap());
        assert!(matches!(apart([&a, &b]), Err(OutputError::Twice { .. })));
        // A file that appears while another is written under its name.
        let late = a.write(|partial| {
            fs::write(partial, "").unwrap();
            fs::write(folder.path().join("a.h5"), "mine").unwrap();
            Ok(())
        });
        let Err(OutputError::File(FileFault::Kept { why, at, .. })) = late else { panic!("{late:?}") };
        assert!(matches!(*why, FileFault::Exists { .. }) && at.exists());
        assert_eq!(fs::read(folder.path().join("a.h5")).unwrap(), b"mine");
    }
}
