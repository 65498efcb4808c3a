//! Why a recording cannot be made, written or read.

use std::ops::Range;
use std::path::PathBuf;

use crate::files::FileFault;
use crate::geometry::phase_path::PhasePathError;
use crate::inputs::one_line;

/// What is being done when a recording cannot be read.
pub(crate) const READING: &str = "reading the recording";

/// Why a recording cannot be made, written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// What is there already, or what the system reported.
    #[error(transparent)]
    File(#[from] FileFault),
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
    /// A pulse does not have the sizes of the header.
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
    /// The HDF5 library refused.
    #[error("{}: {action}: {detail}", path.display())]
    Hdf5 {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the library reported.
        detail: String,
    },
    /// An HDF5 file asked of a build without HDF5.
    #[error("{}: this build has no HDF5 (feature `hdf5`) and reads plain folders only", path.display())]
    NoHdf5 {
        /// The file.
        path: PathBuf,
    },
    /// Not a recording of this program.
    #[error("{}: {}", path.display(), one_line(detail))]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        detail: String,
    },
    /// No pulse asked for is there.
    #[error("{}: holds pulses {first}..{end}, none of {}..{}", path.display(), asked.start, asked.end)]
    NoPulses {
        /// The recording.
        path: PathBuf,
        /// First pulse there.
        first: u64,
        /// One past the last.
        end: u64,
        /// Pulses asked for.
        asked: Range<u64>,
    },
    /// Samples that do not fit in memory.
    #[error(
        "{}: {channels} channels of {pulses} pulses are {needed_mib} MiB of samples, {available_mib} MiB are free; \
         fewer channels or pulses (--channel, --pulses)",
        path.display()
    )]
    Memory {
        /// The recording.
        path: PathBuf,
        /// Channels asked for.
        channels: usize,
        /// Pulses asked for.
        pulses: usize,
        /// What their samples take.
        needed_mib: u64,
        /// What may be taken.
        available_mib: u64,
    },
    /// A column that is not there.
    #[error("{}: /{} is not in the recording", path.display(), one_line(column))]
    Missing {
        /// The recording.
        path: PathBuf,
        /// The column.
        column: String,
    },
    /// Positions or times that are none.
    #[error("{}: {source}", path.display())]
    Path {
        /// The recording.
        path: PathBuf,
        /// What is wrong.
        source: PhasePathError,
    },
}

impl RecordingError {
    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            Self::File(fault) => fault.is_wrong_input(),
            Self::Hdf5 { .. } => false,
            _ => true,
        }
    }
}
