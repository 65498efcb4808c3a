//! Why a tool for navigation ends early.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::files::FileFault;
use crate::nav::NavError;
use crate::nav::encode::EncodeError;
use crate::nav::pcap::CaptureError;
use crate::sinks::port::NotADevice;

/// Why a tool for navigation ends early.
#[derive(Debug, Error)]
pub enum NavToolError {
    /// The recording cannot be read.
    #[error(transparent)]
    Nav(#[from] NavError),
    /// The capture cannot be read.
    #[error("{}: {source}", crate::cli::escape::path(path))]
    Capture {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: CaptureError,
    },
    /// An SBET has no week of its own.
    #[error(
        "{}: an SBET says neither date nor week; needed: --gps-week, such as 2000 (from 2018-05-06)",
        crate::cli::escape::path(path)
    )]
    Week {
        /// The file.
        path: PathBuf,
    },
    /// A capture without navigation.
    #[error("{}: no stream of this capture holds a message that is read", crate::cli::escape::path(path))]
    Silent {
        /// The file.
        path: PathBuf,
    },
    /// Positions that lie nowhere on Earth.
    #[error(
        "{}: positions are in the frame of a scene (x_m, y_m, z_m); allowed: lat_deg, lon_deg, height_m",
        crate::cli::escape::path(path)
    )]
    Local {
        /// The file.
        path: PathBuf,
    },
    /// A state that the format cannot tell.
    #[error("fix {number} at {time}: {source}")]
    Encode {
        /// Which fix, from 1.
        number: usize,
        /// When.
        time: String,
        /// Why.
        source: EncodeError,
    },
    /// A name that says nothing of the format.
    #[error(
        "{}: its name says no format; allowed: .csv, .nmea, .inspvax, or --to",
        crate::cli::escape::path(path)
    )]
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
        /// What the system says.
        source: io::Error,
    },
    /// The output cannot be written.
    #[error("{}: cannot write: {source}", crate::cli::escape::path(path))]
    Write {
        /// The output.
        path: PathBuf,
        /// What the system says.
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
        /// What the system says.
        source: io::Error,
    },
    /// A line that no run takes.
    #[error("a line of {bytes} bytes; allowed: at most 256, without control characters")]
    Line {
        /// Its length.
        bytes: usize,
    },
    /// No run answers.
    #[error(
        "{}: {source}; allowed: the socket of a run under way (nereus run --control)",
        crate::cli::escape::path(path)
    )]
    Control {
        /// The socket.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The run does not take the line.
    #[error("{told}")]
    Refused {
        /// Why.
        told: String,
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
