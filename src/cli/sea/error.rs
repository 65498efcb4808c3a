//! Why there is no map of the sea.

use std::path::PathBuf;

use thiserror::Error;

use crate::cli::values::OutOfRange;
use crate::plot::canvas::PngError;
use crate::plot::chart::PlotError;
use crate::plot::picture::PictureError;
use crate::recording::field_file::FieldFileError;
use crate::recording::output::OutputError;
use crate::sea::realise::RealiseError;
use crate::sea::surface::StateError;
use crate::sea::wake::WakeError;

/// Why there is no map of the sea.
#[derive(Debug, Error)]
pub enum SeaError {
    /// Point targets alone.
    #[error("{}: the scenario has no [sea]", crate::cli::escape::path(path))]
    NoSea {
        /// The scenario.
        path: PathBuf,
    },
    /// Wind waves alone.
    #[error("{}: the scenario has no [[ship]]", crate::cli::escape::path(path))]
    NoShip {
        /// The scenario.
        path: PathBuf,
    },
    /// A value out of range.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// A channel that the scenario does not have.
    #[error("no channel '{name}'; allowed: {known}")]
    NoChannel {
        /// What was asked.
        name: String,
        /// Those it has.
        known: String,
    },
    /// A pulse that the run does not have.
    #[error("pulse {pulse} is not part of the run; allowed: 0 to {}", pulses.saturating_sub(1))]
    NoPulse {
        /// What was asked.
        pulse: u64,
        /// Pulses of the run.
        pulses: u64,
    },
    /// An HDF5 file asked of a build without HDF5.
    #[error(
        "this build has no HDF5 (feature `hdf5`): {} cannot be made; allowed: --png, --save-state",
        crate::cli::escape::path(out)
    )]
    NoHdf5 {
        /// What was asked.
        out: PathBuf,
    },
    /// Wind, spectrum, grid or saved state.
    #[error(transparent)]
    Realise(#[from] RealiseError),
    /// A time out of range.
    #[error(transparent)]
    Surface(#[from] WakeError),
    /// A file that may not be made, or cannot.
    #[error(transparent)]
    File(#[from] OutputError),
    /// The map or the scatterer paths cannot be written.
    #[error(transparent)]
    Fields(#[from] FieldFileError),
    /// The state cannot be written.
    #[error(transparent)]
    State(#[from] StateError),
    /// The picture cannot be drawn.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The plot cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// The picture cannot be written.
    #[error(transparent)]
    Png(#[from] PngError),
}

impl SeaError {
    /// Exit code: 2 when the input is wrong, 1 otherwise.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::NoSea { .. }
            | Self::NoShip { .. }
            | Self::Range(_)
            | Self::NoChannel { .. }
            | Self::NoPulse { .. }
            | Self::NoHdf5 { .. }
            | Self::Realise(_)
            | Self::Surface(_)
            | Self::Plot(_)
            | Self::Picture(_) => 2,
            Self::File(error) if error.is_wrong_input() => 2,
            Self::File(_) | Self::Fields(_) | Self::State(_) | Self::Png(_) => 1,
        }
    }
}
