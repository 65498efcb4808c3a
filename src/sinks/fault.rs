//! Why a sink cannot be opened or has failed.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::files::FileFault;

/// Why a sink cannot be opened or has failed.
#[derive(Debug, Error)]
pub enum SinkError {
    /// The output is there already.
    #[error("{path}: exists already; choose another name, or overwrite it with --force")]
    Exists {
        /// The output.
        path: PathBuf,
    },
    /// Asked to overwrite something else than an output of the same kind.
    #[error(
        "{path}: not overwritten, because it is no output of this kind (an HDF5 file whose attribute format is nereus, a folder that holds a plain recording and nothing else, a file of the same navigation format)"
    )]
    NotARecording {
        /// What is there.
        path: PathBuf,
    },
    /// Asked to overwrite a recording that is open.
    #[error("{path}: not overwritten, because a run is writing it or a program reads it")]
    InUse {
        /// The recording.
        path: PathBuf,
    },
    /// The output is to be made in something that is no folder.
    #[error("{path}: is no folder; outputs are made in folders that exist")]
    NoFolder {
        /// What is there.
        path: PathBuf,
    },
    /// Two sinks have the same output.
    #[error("{path}: is the output of two sinks; each needs its own")]
    Twice {
        /// The output.
        path: PathBuf,
    },
    /// An output that is complete and not in its place, or that another program has removed or moved.
    #[error(transparent)]
    Lost(FileFault),
    /// The header cannot be recorded.
    #[error("recording header, {field}: {found}; allowed: {allowed}")]
    Header {
        /// Which part.
        field: &'static str,
        /// What it holds.
        found: String,
        /// What it may hold.
        allowed: &'static str,
    },
    /// A segment length that cannot be kept.
    #[error("segment_s = {segment_s}: allowed: a finite length above 0 s")]
    Segment {
        /// What was asked.
        segment_s: f64,
    },
    /// A pulse does not have the sizes announced.
    #[error("pulse {index}: {column} has {found} values where the header announced {expected}")]
    Pulse {
        /// Which pulse.
        index: u64,
        /// Which part of it.
        column: String,
        /// Values found.
        found: usize,
        /// Values announced.
        expected: usize,
    },
    /// The system refused a file operation.
    #[error("{path}: {action}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// A port cannot be opened.
    #[error("{device}: cannot open the port: {source}")]
    Port {
        /// The device.
        device: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// States that cannot be reported, because the scene lies nowhere on Earth.
    #[error("navigation out needs scene.origin_lat_deg, origin_lon_deg and origin_h_m")]
    Nowhere,
    /// The HDF5 library refused.
    #[error("{path}: {action}: {detail}")]
    Hdf5 {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the library said.
        detail: String,
    },
    /// An address of the network.
    #[error("{address}: {action}: {source}; allowed: host:port of a machine that can be reached")]
    Address {
        /// The address.
        address: String,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// Two sinks send to the same address.
    #[error("{address}: two sinks send there, with the same stream identifiers; each needs its own address")]
    SameAddress {
        /// The address.
        address: String,
    },
    /// A size of datagrams that cannot be sent.
    #[error("mtu_bytes = {mtu_bytes}: allowed: 576 to 65535 bytes")]
    Mtu {
        /// What was asked.
        mtu_bytes: usize,
    },
    /// Built without HDF5.
    #[error("{path}: this build has no HDF5 (feature hdf5); use kind = \"plain\"")]
    NoHdf5 {
        /// The file asked for.
        path: PathBuf,
    },
}

impl SinkError {
    /// What the system said of a file.
    pub(crate) fn io(path: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, action, source }
    }
}

impl From<FileFault> for SinkError {
    fn from(fault: FileFault) -> Self {
        match fault {
            FileFault::Exists { path } => Self::Exists { path },
            FileFault::Foreign { path } => Self::NotARecording { path },
            FileFault::InUse { path } => Self::InUse { path },
            FileFault::NoFolder { path } => Self::NoFolder { path },
            fault @ (FileFault::Removed { .. } | FileFault::Moved { .. } | FileFault::Kept { .. }) => {
                Self::Lost(fault)
            }
            FileFault::Io { path, action, source } => Self::Io { path, action, source },
        }
    }
}
