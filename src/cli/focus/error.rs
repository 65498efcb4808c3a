//! Why a recording cannot be focused.

use std::path::{Path, PathBuf};

use crate::cli::escape;
use crate::clutter::SampleFault;
use crate::inputs::one_line;
use crate::processor::focus;
use crate::recording::RecordingError;
use crate::recording::field_file::FieldFileError;
use crate::recording::output::OutputError;

/// Why a recording cannot be focused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FocusError {
    /// It cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// It cannot be focused.
    #[error("{}: {source}", escape::path(path))]
    Focus {
        /// The recording.
        path: PathBuf,
        /// Why.
        source: focus::FocusError,
    },
    /// A channel that is not there.
    #[error("channel {} is not in the recording; allowed: {allowed}", one_line(name))]
    Channel {
        /// What was asked.
        name: String,
        /// What there is.
        allowed: String,
    },
    /// A channel that carries no echo.
    #[error(
        "channel {} is a calibration channel ({}) and carries no echo; allowed: {allowed}",
        one_line(name),
        one_line(kind)
    )]
    Calibration {
        /// What was asked.
        name: String,
        /// `tone` or `loopback`.
        kind: String,
        /// Channels of echoes.
        allowed: String,
    },
    /// A value out of range.
    #[error("--{key} {found}: allowed: {allowed}")]
    Value {
        /// The key.
        key: &'static str,
        /// What was given.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// More looks than pixels.
    #[error(
        "--looks {looks}: allowed: up to the shorter side of the image, which has {columns} x {rows} pixels"
    )]
    Looks {
        /// As asked.
        looks: usize,
        /// Pixels to the East.
        columns: usize,
        /// Pixels to the North.
        rows: usize,
    },
    /// A recording to compare with that is of something else.
    #[error(
        "--against {}: its {what} differ; allowed: a recording of the same radar, pulses and targets",
        escape::path(path)
    )]
    Against {
        /// The recording.
        path: PathBuf,
        /// What is not the same.
        what: &'static str,
    },
    /// An image without resolution cells.
    #[error(
        "--speckle, channel {}: no cross-range, so that a resolution cell has no length; allowed: more pulses, from an end that moves",
        one_line(channel)
    )]
    NoCells {
        /// The channel.
        channel: String,
    },
    /// More outputs than can be made.
    #[error("--out {}: allowed: one name that ends in .png and one that ends in .h5", escape::path(path))]
    Several {
        /// What was given beyond that.
        path: PathBuf,
    },
    /// Pixels that no law can be fitted to.
    #[error("--speckle, channel {}: {source}", one_line(channel))]
    Speckle {
        /// The channel.
        channel: String,
        /// What is wrong.
        source: SampleFault,
    },
    /// An output that is neither picture nor HDF5.
    #[error("--out {}: allowed: a name that ends in .png or .h5", escape::path(path))]
    Kind {
        /// What was given.
        path: PathBuf,
    },
    /// An output cannot be made.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The complex image cannot be written.
    #[error(transparent)]
    Image(#[from] FieldFileError),
}

impl FocusError {
    /// Why a recording cannot be focused, with its name where the reason does not bear it.
    pub(super) fn at(path: &Path) -> impl Fn(focus::FocusError) -> Self {
        move |source| match source {
            focus::FocusError::Recording(error) => Self::Recording(error),
            source => Self::Focus { path: path.to_owned(), source },
        }
    }

    /// Exit code: 2 when the input is wrong, 1 otherwise.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Output(error) if !error.is_wrong_input() => 1,
            Self::Image(FieldFileError::Hdf5 { .. }) => 1,
            _ => 2,
        }
    }
}
