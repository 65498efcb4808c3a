//! Why a sink cannot be opened or has failed.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::files::FileFault;
use crate::recording::RecordingError;
use crate::recording::crsd::CrsdError;

/// Why a sink cannot be opened or has failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SinkError {
    /// What is there already, or what the system reported.
    #[error(transparent)]
    File(#[from] FileFault),
    /// A recording cannot be made or written.
    #[error(transparent)]
    Recording(RecordingError),
    /// A CRSD file cannot be made or written.
    #[error("CRSD: {0}")]
    Crsd(Box<CrsdError>),
    /// A CRSD file of a run by live navigation.
    #[error(
        "CRSD: live navigation sets the start of the run and may end it, and the file is planned before; \
         allowed: kind = \"hdf5\" or \"plain\", and nereus export crsd when the run has ended"
    )]
    CrsdLive,
    /// Two sinks have the same output.
    #[error("{path}: is the output of two sinks; each needs its own")]
    Twice {
        /// The output.
        path: PathBuf,
    },
    /// A segment length that cannot be kept.
    #[error("segment_s = {segment_s}: allowed: a finite length above 0 s")]
    Segment {
        /// What was asked.
        segment_s: f64,
    },
    /// A port cannot be opened.
    #[error("{device}: cannot open the port: {source}")]
    Port {
        /// The device.
        device: String,
        /// What the system reported.
        source: std::io::Error,
    },
    /// States that cannot be reported, because the scene is not georeferenced.
    #[error("navigation out needs scene.origin_lat_deg, origin_lon_deg and origin_h_m")]
    NoOrigin,
    /// An address of the network.
    #[error("{address}: {action}: {source}; allowed: host:port of a machine that can be reached")]
    Address {
        /// The address.
        address: String,
        /// What was tried.
        action: &'static str,
        /// What the system reported.
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
            Self::Recording(error) => error.is_wrong_input(),
            Self::Crsd(error) => error.is_wrong_input(),
            _ => true,
        }
    }

    /// What the system reported of a file.
    pub(crate) fn io(path: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> Self {
        let fault = FileFault::io(path, action);
        move |source| fault(source).into()
    }
}

impl From<RecordingError> for SinkError {
    fn from(error: RecordingError) -> Self {
        match error {
            RecordingError::File(fault) => Self::File(fault),
            error => Self::Recording(error),
        }
    }
}
