//! Why a command ends early.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use super::nav::NavToolError;
use super::sea::SeaError;
use super::table::TableError;
use super::values::OutOfRange;
use crate::bench::clutter::ClutterError;
use crate::bench::speed::SpeedError;
use crate::cli::examine::error::ExamineError;
use crate::cli::focus::error::FocusError;
use crate::config::ConfigError;
#[cfg(feature = "monitor")]
use crate::monitor::{MonitorFault, replay::ReplayError};
use crate::pipeline::build::RunFailure;
use crate::pipeline::control_lines::ControlFault;
use crate::pipeline::fault::BuildErrors;
use crate::radar::pattern::PatternError;
use crate::receive::ReceiveError;
use crate::recording::RecordingError;
use crate::recording::crsd::ExportError;
#[cfg(feature = "hdf5")]
use crate::recording::merge::MergeError;
use crate::recording::shard::Shard;

/// Why a command ends early.
#[derive(Debug, Error)]
pub enum CliError {
    /// The scenario is wrong.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Standard output cannot be written.
    #[error("cannot write to standard output: {0}")]
    Output(#[source] io::Error),
    /// The run cannot be built: tracks, patterns, waveform, outputs.
    #[error(transparent)]
    Build(#[from] BuildErrors),
    /// The run failed.
    #[error("{0}")]
    Run(Box<RunFailure>),
    /// Recordings cannot be joined.
    #[cfg(feature = "hdf5")]
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// A recording that is not read.
    #[error(transparent)]
    Examine(#[from] ExamineError),
    /// A recording that cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Joining asked of a build without HDF5.
    #[cfg(not(feature = "hdf5"))]
    #[error("`nereus merge` joins HDF5 recordings, and this build has no HDF5 (feature `hdf5`)")]
    MergeNeedsHdf5,
    /// An antenna pattern.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// No handler for Ctrl-C.
    #[error("cannot listen for Ctrl-C: {0}")]
    Signal(#[source] ctrlc::Error),
    /// `--out` with several recordings.
    #[error(
        "--out {} does not say which of {recordings} recordings; allowed with one, else --set sink.<n>.path=...",
        super::escape::path(out)
    )]
    WhichSink {
        /// What was asked.
        out: PathBuf,
        /// Recordings of the scenario.
        recordings: usize,
    },
    /// Shards without a pulse.
    #[error("--shard {shard}: the run has {pulses} pulses; allowed: at most as many shards")]
    MoreShardsThanPulses {
        /// What was asked.
        shard: Shard,
        /// Pulses of the run.
        pulses: u64,
    },
    /// An HDF5 file asked of a build without HDF5.
    #[error(
        "this build has no HDF5 (feature `hdf5`): --out {} cannot be an HDF5 file; allowed: a folder",
        super::escape::path(out)
    )]
    NoHdf5 {
        /// What was asked.
        out: PathBuf,
    },
    /// No control.
    #[error(transparent)]
    Control(#[from] ControlFault),
    /// No live page.
    #[cfg(feature = "monitor")]
    #[error(transparent)]
    Monitor(#[from] MonitorFault),
    /// A live page asked of a build without it.
    #[cfg(not(feature = "monitor"))]
    #[error(
        "this build has no monitor (feature `monitor`): --monitor, stream.monitor and `nereus monitor` need it"
    )]
    NoMonitor,
    /// Control by a page that there is not.
    #[error(
        "--monitor-control has no page to act through; allowed: together with --monitor ADDR or stream.monitor"
    )]
    ControlWithoutMonitor,
    /// A value out of range.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// The keys of a table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// Recorded navigation.
    #[error(transparent)]
    Nav(#[from] NavToolError),
    /// No map of the sea.
    #[error(transparent)]
    Sea(#[from] SeaError),
    /// No image of a recording.
    #[error(transparent)]
    Focus(#[from] FocusError),
    /// A recording that is not whole.
    #[error("{}: not whole: {faults} {}", super::escape::path(path), if *faults == 1 { "fault" } else { "faults" })]
    NotWhole {
        /// The recording.
        path: PathBuf,
        /// Faults found.
        faults: u64,
    },
    /// A recording that cannot be exported.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// No statistics of speckle.
    #[error(transparent)]
    Clutter(#[from] ClutterError),
    /// Nothing can be received.
    #[error(transparent)]
    Receive(#[from] ReceiveError),
    /// No figures.
    #[error(transparent)]
    Speed(#[from] SpeedError),
}

impl CliError {
    /// Exit code: 2 when the input is wrong, 1 otherwise.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Recording(RecordingError::File(fault)) if !fault.is_wrong_input() => 1,
            Self::Clutter(ClutterError::Run(SpeedError::Run(_))) => 1,
            Self::Config(_)
            | Self::Build(_)
            | Self::Pattern(_)
            | Self::WhichSink { .. }
            | Self::MoreShardsThanPulses { .. }
            | Self::NoHdf5 { .. }
            | Self::Control(_)
            | Self::ControlWithoutMonitor
            | Self::Examine(_)
            | Self::Recording(_)
            | Self::Range(_)
            | Self::Table(_)
            | Self::Clutter(_) => 2,
            Self::Sea(error) => error.exit_code(),
            // A full disk is not wrong input, nor is a socket that breaks.
            Self::Receive(ReceiveError::Record(error)) if !error.is_wrong_input() => 1,
            Self::Receive(ReceiveError::Socket { .. }) => 1,
            Self::Receive(_) => 2,
            Self::Nav(error) => error.exit_code(),
            Self::Focus(error) => error.exit_code(),
            Self::Speed(SpeedError::Build(_)) => 2,
            Self::Speed(SpeedError::Run(_)) => 1,
            Self::Export(error) => {
                if error.is_wrong_input() {
                    2
                } else {
                    1
                }
            }
            Self::NotWhole { .. } | Self::Output(_) | Self::Run(_) | Self::Signal(_) => 1,
            #[cfg(feature = "monitor")]
            Self::Monitor(_) => 2,
            #[cfg(not(feature = "monitor"))]
            Self::NoMonitor => 2,
            #[cfg(not(feature = "hdf5"))]
            Self::MergeNeedsHdf5 => 2,
            // A full disk is not wrong input.
            #[cfg(feature = "hdf5")]
            Self::Merge(MergeError::Recording(error)) if !error.is_wrong_input() => 1,
            #[cfg(feature = "hdf5")]
            Self::Merge(_) => 2,
        }
    }
}

#[cfg(feature = "monitor")]
impl From<ReplayError> for CliError {
    fn from(error: ReplayError) -> Self {
        match error {
            ReplayError::Recording(error) => error.into(),
            ReplayError::Monitor(fault) => fault.into(),
        }
    }
}
