//! Faults of the HDF5 library and of files that it reads.

use std::path::Path;

use thiserror::Error;

use crate::recording::fault::RecordingError;

/// What the library reported; becomes an error that names the file.
#[derive(Debug, Error)]
pub(crate) enum Fault {
    /// A text of this program.
    #[error("{0}")]
    Text(String),
    /// The library's error stack.
    #[error("{}", one_line(.0))]
    Library(#[from] ::hdf5::Error),
}

/// One line: what was tried and, where the system reported why (`No space left on device`), that.
fn one_line(error: &::hdf5::Error) -> String {
    let text = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    let reason = text.split_once("error message = '").and_then(|(_, rest)| rest.split('\'').next());
    match (reason, text.split(": time = ").next()) {
        (Some(reason), Some(tried)) => format!("{tried}: {reason}"),
        _ => text,
    }
}

impl Fault {
    pub(crate) fn at(path: &Path, action: &'static str) -> impl FnOnce(Self) -> RecordingError {
        let path = path.to_owned();
        move |fault| RecordingError::Hdf5 { path, action, detail: fault.to_string() }
    }
}
