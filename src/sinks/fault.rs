//! Why a sink cannot be opened or has failed.

use std::net::Ipv4Addr;
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
    /// A port that cannot be listened at.
    #[error(
        "{address}: cannot publish there: {source}; allowed: an address of this machine and ports that no other program uses"
    )]
    Bind {
        /// The address.
        address: String,
        /// What the system reported.
        source: std::io::Error,
    },
    /// More ports than there are above the first.
    #[error("{bind}: {ports} channels need as many ports from there on; allowed: a first port of at most {}", u32::from(u16::MAX) + 1 - u32::from(*.ports))]
    Ports {
        /// First address.
        bind: String,
        /// Ports.
        ports: u16,
    },
    /// Shared memory that somebody else publishes.
    #[error(
        "shared memory service '{service}': another run publishes there; end it, or name another service"
    )]
    ServiceInUse {
        /// Name of the service.
        service: String,
    },
    /// Shared memory that is not there.
    #[error(
        "shared memory service '{service}': needs {needed_mib} MiB, {free_mib} MiB of /dev/shm are free; lower buffer_pulses, or remove what other programs have left there"
    )]
    NoSharedMemory {
        /// Name of the service.
        service: String,
        /// What it takes.
        needed_mib: u64,
        /// What there is.
        free_mib: u64,
    },
    /// Shared memory that cannot be used.
    #[error(
        "shared memory service '{service}': {action}: {error}; end what still uses the service, or name another one"
    )]
    Shm {
        /// Name of the service.
        service: String,
        /// What was tried.
        action: &'static str,
        /// What iceoryx2 reported.
        error: String,
    },
    /// Built without iceoryx2.
    #[error(
        "shared memory service '{service}': this build has no shared memory (feature shm); use kind = \"zmq\", or build with --features shm"
    )]
    NoShm {
        /// Name of the service.
        service: String,
    },
    /// A group to which nothing may be sent.
    #[error("{address}: datagrams cannot go there; allowed: {allowed}")]
    Group {
        /// The address.
        address: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// An interface by which nothing can be sent to a group.
    #[error("interface = {interface}: {source}; allowed: the IPv4 address of an interface of this machine")]
    Interface {
        /// Its address.
        interface: Ipv4Addr,
        /// What the system reported.
        source: std::io::Error,
    },
    /// A video that cannot be made of the pulses.
    #[error("asterix: {found}")]
    Video {
        /// Why, and what is allowed.
        found: String,
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
    /// What cannot be sent as DIFI.
    #[error("profile = \"difi\": {found}; allowed: {allowed}, or profile = \"nereus\" (docs/wire.md)")]
    Difi {
        /// What there is.
        found: String,
        /// What there may be.
        allowed: String,
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
            Self::NoSharedMemory { .. } | Self::Shm { .. } => false,
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
