//! Where pulses go.

use std::path::PathBuf;

/// A place where pulses go.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// What kind of sink.
    pub kind: Kind,
    /// Pulses that may wait for this sink before they are dropped (in real time) or hold up the run.
    pub queue_pulses: usize,
}

/// Kinds of sinks.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// HDF5 recording.
    Hdf5 {
        /// The file.
        path: PathBuf,
        /// Start a new file every so many seconds of emission time.
        segment_s: Option<f64>,
        /// Overwrite an existing file.
        force: bool,
    },
    /// A folder of plain binary and text files; needs no system library.
    Plain {
        /// The folder.
        path: PathBuf,
        /// Overwrite an existing folder.
        force: bool,
    },
    /// Counts pulses and forgets them.
    Null,
}
