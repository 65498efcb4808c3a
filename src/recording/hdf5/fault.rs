//! What the HDF5 library, or a file that it reads, has against it.

use std::path::Path;

use thiserror::Error;

use crate::recording::fault::RecordingError;

/// What the library said; becomes an error that names the file.
#[derive(Debug, Error)]
pub(crate) enum Fault {
    /// A text that says it all.
    #[error("{0}")]
    Text(String),
    /// The library's error stack.
    #[error("{}", one_line(.0))]
    Library(#[from] ::hdf5::Error),
}

/// One line: what was tried and, where the system said why (`No space left on device`), that.
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
