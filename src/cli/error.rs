//! Why a command ends early.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::config::ConfigError;
use crate::pipeline::build::{BuildErrors, RunFailure};
use crate::radar::pattern::PatternError;
#[cfg(feature = "hdf5")]
use crate::sinks::merge::MergeError;
#[cfg(feature = "hdf5")]
use crate::sinks::sink::SinkError;

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
    #[error("--out {} does not say which of {recordings} recordings; allowed with one, else --set sink.<n>.path=...", out.display())]
    WhichSink {
        /// What was asked.
        out: PathBuf,
        /// Recordings of the scenario.
        recordings: usize,
    },
    /// An HDF5 file asked of a build without HDF5.
    #[error("this build has no HDF5 (feature `hdf5`): --out {} cannot be an HDF5 file; allowed: a folder", out.display())]
    NoHdf5 {
        /// What was asked.
        out: PathBuf,
    },
    /// A table without rows, or without end.
    #[error(
        "--from-deg {from_deg} --to-deg {to_deg} --step-deg {step_deg}: allowed: from -90 to 90, from below to, a step that gives at most {most} rows"
    )]
    Sweep {
        /// First angle.
        from_deg: f64,
        /// Last angle.
        to_deg: f64,
        /// Step.
        step_deg: f64,
        /// Most rows.
        most: usize,
    },
    /// A size that is missing or not positive and finite.
    #[error("{option} {value} is not allowed; allowed: a number above 0")]
    Size {
        /// The option.
        option: &'static str,
        /// What was given.
        value: String,
    },
    /// A gain that is not a number.
    #[error("--gain-dbi {value} is not allowed; allowed: a finite number")]
    Gain {
        /// What was given.
        value: f64,
    },
}

impl CliError {
    /// Exit code: 2 when the input is wrong, 1 otherwise.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Config(_)
            | Self::Build(_)
            | Self::Pattern(_)
            | Self::WhichSink { .. }
            | Self::NoHdf5 { .. }
            | Self::Sweep { .. }
            | Self::Size { .. }
            | Self::Gain { .. } => 2,
            Self::Output(_) | Self::Run(_) | Self::Signal(_) => 1,
            #[cfg(not(feature = "hdf5"))]
            Self::MergeNeedsHdf5 => 2,
            // A full disk is not wrong input.
            #[cfg(feature = "hdf5")]
            Self::Merge(MergeError::File(SinkError::Io { .. } | SinkError::Hdf5 { .. })) => 1,
            #[cfg(feature = "hdf5")]
            Self::Merge(_) => 2,
        }
    }
}
