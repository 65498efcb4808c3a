//! Why a tool for navigation ends early.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::files::FileFault;
use crate::inputs::shown;
use crate::nav::encode::EncodeError;
use crate::nav::inspection::InspectionError;
use crate::sinks::port::NotADevice;

/// Why a tool for navigation ends early.
#[derive(Debug, Error)]
pub enum NavToolError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recorded(#[from] InspectionError),
    /// Positions that are not georeferenced.
    #[error(
        "{}: positions are in the frame of a scene (x_m, y_m, z_m); allowed: lat_deg, lon_deg, height_m",
        shown(path)
    )]
    Local {
        /// The file.
        path: PathBuf,
    },
    /// A state that the format cannot hold.
    #[error("fix {number} at {time}: {source}")]
    Encode {
        /// Which fix, from 1.
        number: usize,
        /// When.
        time: String,
        /// Why.
        source: EncodeError,
    },
    /// A name without a known format.
    #[error("{}: its name gives no format; allowed: .csv, .nmea, .inspvax, or --to", shown(path))]
    Target {
        /// The output.
        path: PathBuf,
    },
    /// The output cannot be made.
    #[error(transparent)]
    Output(#[from] FileFault),
    /// A file does not take the messages.
    #[error("{device}: writing: {source}")]
    Unwritten {
        /// The device.
        device: String,
        /// The system's error.
        source: io::Error,
    },
    /// The output cannot be written.
    #[error("{}: cannot write: {source}", shown(path))]
    Write {
        /// The output.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Not a device.
    #[error(transparent)]
    Device(#[from] NotADevice),
    /// A port that cannot be opened.
    #[error("{device}: cannot open the port: {source}")]
    Port {
        /// The device.
        device: String,
        /// The system's error.
        source: io::Error,
    },
    /// A line that no run takes.
    #[error("a line of {bytes} bytes; allowed: at most 256, without control characters")]
    Line {
        /// Its length.
        bytes: usize,
    },
    /// No run answers.
    #[error("{}: {source}; allowed: the socket of a run under way (nereus run --control)", shown(path))]
    Control {
        /// The socket.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The run does not take the line.
    #[error("{answer}")]
    Refused {
        /// Why.
        answer: String,
    },
    /// A number that makes no sense.
    #[error("--{key} {value}: allowed: {allowed}")]
    Range {
        /// The option.
        key: &'static str,
        /// As given.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
}

impl NavToolError {
    /// Exit code: 2 when the input is wrong, 1 otherwise.
    pub fn exit_code(&self) -> u8 {
        if matches!(
            self,
            Self::Output(
                FileFault::Io { .. }
                    | FileFault::Removed { .. }
                    | FileFault::Moved { .. }
                    | FileFault::Kept { .. }
            ) | Self::Unwritten { .. }
                | Self::Write { .. }
                | Self::Port { .. }
                | Self::Control { .. }
                | Self::Refused { .. }
        ) {
            1
        } else {
            2
        }
    }
}
