//! Why a sink cannot be opened or has failed.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::files::FileFault;

/// Why a sink cannot be opened or has failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SinkError {
    /// What is there already, or what the system reported.
    #[error(transparent)]
    File(#[from] FileFault),
    /// Two sinks have the same output.
    #[error("{path}: is the output of two sinks; each needs its own")]
    Twice {
        /// The output.
        path: PathBuf,
    },
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
    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            Self::File(fault) => fault.is_wrong_input(),
            Self::Hdf5 { .. } => false,
            _ => true,
        }
    }

    /// What the system reported of a file.
    pub(crate) fn io(path: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> Self {
        let fault = FileFault::io(path, action);
        move |source| fault(source).into()
    }
}
