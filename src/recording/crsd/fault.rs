//! Why there is no CRSD file.

use std::path::PathBuf;

use crate::files::FileFault;
use crate::inputs::one_line;
use crate::radar::pattern::PatternError;
use crate::recording::RecordingError;
use crate::recording::output::OutputError;

/// Why there is no CRSD file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CrsdError {
    /// A recording that cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The file cannot be made or put in its place.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The file of a measured pattern.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// A scene without a place on Earth.
    #[error(
        "the scene has no place on Earth, and positions of CRSD are Earth-centred; \
         allowed: a scenario with origin_lat_deg, origin_lon_deg and origin_h_m in [scene]"
    )]
    NoOrigin,
    /// What came over the wire.
    #[error(
        "was received over the wire, which carries neither powers nor losses nor where antennas truly look; \
         allowed: the recording of the run that sent it"
    )]
    Received,
    /// Blocks of samples in place of pulses.
    #[error(
        "CRSD has a receive window for every pulse, and this is received without a gap (radar.window.gate = \"continuous\"); \
         allowed: gate = \"windowed\", or another format"
    )]
    Continuous,
    /// Tones in place of pulses.
    #[error("echoes are dechirped (radar.dechirp); allowed for CRSD: no dechirp, or another format")]
    Dechirped,
    /// A scenario that does not describe the recording.
    #[error("the scenario in the recording has no {what} {}", one_line(name))]
    Undescribed {
        /// What is missing.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// Nothing but calibration channels.
    #[error("no channel of echoes")]
    NoEchoes,
    /// A channel that is not there.
    #[error("no channel of echoes is called {}; allowed: {}", one_line(name), one_line(allowed))]
    Channel {
        /// As asked.
        name: String,
        /// Those of echoes.
        allowed: String,
    },
    /// Transmitters or receivers on several platforms.
    #[error(
        "{end}s on {}: a CRSD file has one {end}ing platform; allowed: channels of one pair (--channel, or channels)",
        one_line(platforms)
    )]
    Platforms {
        /// `transmitt` or `receiv`, as the word begins.
        end: &'static str,
        /// Their names.
        platforms: String,
    },
    /// Receivers with windows of their own.
    #[error(
        "channels {} have receive windows of their own, and all channels of a CRSD file have the same; \
         allowed: channels of one receiver (--channel, or channels)",
        one_line(&channels.join(" and "))
    )]
    Windows {
        /// Two of them.
        channels: [String; 2],
    },
    /// A waveform that is no linear sweep.
    #[error(
        "the waveform is {}{}; allowed for CRSD: linear frequency modulation (radar.waveform.kind = \"lfm\"){}",
        if *kind == "samples" { "read from a file" } else { kind },
        if *droops { " and droops" } else { "" },
        if *droops { ", without droop (radar.waveform.droop_db = 0)" } else { "" }
    )]
    Waveform {
        /// Its kind.
        kind: &'static str,
        /// Whether its amplitude falls from its begin to its end.
        droops: bool,
    },
    /// The transmitted pulse is missing.
    #[error("has no replica of finite samples, which range compression needs; allowed: a whole recording")]
    Replica,
    /// Too few pulses in the polarisation of a channel.
    #[error(
        "channel {}: {pulses} of the pulses left in its polarisation; allowed for CRSD: 2 or more",
        one_line(channel)
    )]
    FewPulses {
        /// The channel.
        channel: String,
        /// Its pulses.
        pulses: u64,
    },
    /// Windows of a channel that overlap.
    #[error(
        "the receive window of pulse {pulse} begins {apart_s:.9} s after the one before it in channel {}, \
         and windows are {window_s:.9} s long; allowed for CRSD: windows that do not overlap",
        one_line(channel)
    )]
    Overlap {
        /// The later pulse.
        pulse: u64,
        /// The channel.
        channel: String,
        /// From opening to opening, s.
        apart_s: f64,
        /// Length of a window, s.
        window_s: f64,
    },
    /// A value that is no number.
    #[error("pulse {pulse}: {what} is no finite number")]
    NotFinite {
        /// The pulse.
        pulse: u64,
        /// Where.
        what: String,
    },
    /// More pulses than were planned.
    #[error("pulse {pulse}: one more than the {planned} that the file has room for")]
    Room {
        /// The pulse.
        pulse: u64,
        /// Pulses planned.
        planned: u64,
    },
}

impl CrsdError {
    /// What the system reported of a file.
    pub(super) fn io(path: &std::path::Path, action: &'static str) -> impl FnOnce(std::io::Error) -> Self {
        let fault = FileFault::io(path, action);
        move |source| Self::Output(fault(source).into())
    }

    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            Self::Recording(error) => error.is_wrong_input(),
            Self::Output(error) => error.is_wrong_input(),
            Self::Room { .. } => false,
            _ => true,
        }
    }

    /// With the recording that it is about, where it does not name it.
    pub fn of(self, path: &std::path::Path) -> ExportError {
        match self {
            Self::Recording(_) | Self::Output(_) | Self::Pattern(_) => ExportError::Named(self),
            _ => ExportError::Of { path: path.to_owned(), error: self },
        }
    }
}

/// Why a recording is not exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// A fault that names its file.
    #[error(transparent)]
    Named(CrsdError),
    /// A fault of a recording.
    #[error("{}: {error}", one_line(&path.display().to_string()))]
    Of {
        /// The recording.
        path: PathBuf,
        /// What is wrong.
        error: CrsdError,
    },
    /// The scenario in the recording is not read.
    #[error("{}: the scenario in the recording cannot be read, and CRSD needs its antennas and errors:\n{detail}", one_line(&path.display().to_string()))]
    Scenario {
        /// The recording.
        path: PathBuf,
        /// Its faults.
        detail: String,
    },
}

impl ExportError {
    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            Self::Named(error) | Self::Of { error, .. } => error.is_wrong_input(),
            Self::Scenario { .. } => true,
        }
    }
}
