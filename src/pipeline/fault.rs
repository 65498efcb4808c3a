//! Why a run cannot be built, or a pulse not made.

use crate::config::ConfigError;
use crate::echo::synth::SynthError;
use crate::fidelity::PlanError;
use crate::motion::changes::ChangeFault;
use crate::motion::track::{SourceError, TrackError};
use crate::nav::live::{FeedError, Origin};
use crate::radar::calibration::CalibrationFault;
use crate::radar::clock::ClockFault;
use crate::radar::fault::RadarError;
use crate::radar::waveform::WaveformError;
use crate::sea::fleet::{FleetError, FleetErrors};
use crate::sea::realise::RealiseError;
use crate::sinks::sink::SinkError;
use crate::time::TimeTag;
use crate::transport::StreamError;
use rayon::ThreadPoolBuildError;
use std::path::PathBuf;
use thiserror::Error;

/// What is allowed of waveforms in turn.
const ONE_IN_TURN: &str = "allowed: gate = \"continuous\" in [radar.window], a lower prf_hz, a window that holds no echo of \
                           another emission";

/// Why a run cannot be started. Each entry is one fault of the input.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BuildError {
    /// A platform's track.
    #[error("platform '{platform}', {role} track: {source}")]
    Track {
        /// The platform.
        platform: String,
        /// `true` or `reported`.
        role: &'static str,
        /// What is wrong.
        source: SourceError,
    },
    /// A run that waits for the clock, and was not ready in time.
    #[error(
        "pulse 0 was due {late_s:.3} s before the run was ready for it (start_utc = \"now\"); allowed: to try again on a machine \
         that is less busy, or a UTC time that lies ahead"
    )]
    StartPassed {
        /// How late it was, s.
        late_s: f64,
    },
    /// A scenario that is read once more, for a later start.
    #[error(transparent)]
    Scenario(Box<ConfigError>),
    /// A track that ends early, met while looking ahead.
    #[error("platform '{platform}', at pulse {pulse}: {source}")]
    Lost {
        /// The platform.
        platform: String,
        /// The pulse.
        pulse: u64,
        /// Why.
        source: TrackError,
    },
    /// A track that does not reach to a time that was asked for.
    #[error("platform '{platform}', {time_s} s after pulse 0: {source}")]
    Away {
        /// The platform.
        platform: String,
        /// The time, s.
        time_s: f64,
        /// Why.
        source: TrackError,
    },
    /// The sea, reported together with faults of other parts.
    #[error("sea: {0}")]
    Sea(#[from] RealiseError),
    /// A ship, reported together with faults of other parts.
    #[error(transparent)]
    Ship(#[from] FleetError),
    /// An emitter whose pulses overlap.
    #[error(
        "emitter '{name}': its pulse of {pulse_s:e} s is longer than its interval of {interval_s:e} s; allowed: no longer than that \
         (prf_hz, pri_us, waveform)"
    )]
    EmitterOverlaps {
        /// The emitter.
        name: String,
        /// Its pulse, s.
        pulse_s: f64,
        /// Its shortest interval, s.
        interval_s: f64,
    },
    /// An emitter of which a window receives too many pulses.
    #[error(
        "emitter '{name}': a window receives {received:.0} of its pulses; allowed: up to {allowed:.0} (a lower prf_hz, longer pri_us, \
         or a smaller radar.window.samples)"
    )]
    EmitterCrowds {
        /// The emitter.
        name: String,
        /// How many.
        received: f64,
        /// At most.
        allowed: f64,
    },
    /// Pulses that leave in turn, of which a window receives several.
    #[error("radar.waveform: windows receive several of the pulses in turn; {ONE_IN_TURN}")]
    SeveralInTurn,
    /// A transmitter that differs from pulse to pulse, of which a window receives several.
    #[error(
        "radar.front_end: tx_level_rms_db and tx_phase_rms_deg change every pulse, and windows receive several; \
         allowed: windows that receive their own pulse alone, or neither key"
    )]
    SeveralUnstable,
    /// An emitter that begins after the run.
    #[error(
        "emitter '{name}': its first pulse leaves {start_s} s after pulse 0, when the last window has closed; allowed: an earlier \
         start_us, or a longer run"
    )]
    EmitterLate {
        /// The emitter.
        name: String,
        /// Its start, s.
        start_s: f64,
    },
    /// The waveform.
    #[error(transparent)]
    Waveform(#[from] WaveformError),
    /// The instrument or its way through the scene.
    #[error(transparent)]
    Radar(#[from] RadarError),
    /// A clock.
    #[error(transparent)]
    Clock(#[from] ClockFault),
    /// The fast echo.
    #[error(transparent)]
    Echo(#[from] SynthError),
    /// Live navigation.
    #[error("platform '{platform}', live navigation: {source}")]
    Live {
        /// The platform.
        platform: String,
        /// What is wrong.
        source: LiveFault,
    },
    /// An antenna in the water.
    #[error(
        "antenna \"{antenna}\" of platform '{platform}' is {depth_m:.2} m below mean sea level at pulse {pulse}; allowed: on or \
         above it (platform.track: position_m is East, North, up; of a file its heights, datum and epoch; scene.origin_h_m, \
         lever_arm_m){}",
        if *swapped { "; latitude and longitude of the track look swapped" } else { "" }
    )]
    BelowSea {
        /// The transmitter or receiver.
        antenna: String,
        /// Its platform.
        platform: String,
        /// Depth, m.
        depth_m: f64,
        /// Where it is deepest.
        pulse: u64,
        /// Whether it would be near the origin with latitude and longitude swapped.
        swapped: bool,
    },
    /// A pulse from a file that lasts too long.
    #[error(
        "the pulse of {}, {pulse_us} us, is longer than the shortest pulse interval, {pri_us} us: two pulses would leave at once; \
         allowed: a lower radar.prf_hz, or a shorter pulse",
        path.display()
    )]
    LongPulse {
        /// The file.
        path: PathBuf,
        /// Its length, us.
        pulse_us: f64,
        /// The shortest interval, us.
        pri_us: f64,
    },
    /// A waveform from a file whose offset moves it out of what is sampled.
    #[error(
        "{} with its offset_hz reaches from {from_hz} to {to_hz} Hz about the carrier; allowed: within {half_hz} Hz of it, half of radar.sample_rate_hz",
        path.display()
    )]
    BeyondBand {
        /// The file.
        path: PathBuf,
        /// Lower end of its band, Hz.
        from_hz: f64,
        /// Upper end, Hz.
        to_hz: f64,
        /// What is sampled to either side, Hz.
        half_hz: f64,
    },
    /// A pulse of the trial.
    #[error(transparent)]
    Pulse(PulseError),
    /// A sink's output.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// Pulses that the run does not have.
    #[error("pulses {from}..{to} are not all in the run; allowed: one or more within 0..{pulses}")]
    Range {
        /// First pulse asked.
        from: u64,
        /// One past the last pulse asked.
        to: u64,
        /// Pulses of the run.
        pulses: u64,
    },
    /// More than the machine has.
    #[error(
        "a sea of {facets} facets takes about {needed_mib} MiB with {threads} threads, {available_mib} MiB are available; \
         allowed: fewer facets (scene.patch_size_m, scene.facet_m) or fewer stream.threads"
    )]
    Memory {
        /// Facets of the patch.
        facets: usize,
        /// Workers, each with a sea of its own.
        threads: usize,
        /// What they need.
        needed_mib: u64,
        /// What is free.
        available_mib: u64,
    },
    /// The same of ships that echo by their mesh.
    #[error(
        "ships that echo by {paths} panels and double bounces take about {needed_mib} MiB with {threads} threads, \
         {available_mib} MiB are available; allowed: larger ship.panel_m, fewer ships with echo or fewer stream.threads"
    )]
    ShipMemory {
        /// Panels and double bounces.
        paths: usize,
        /// Workers.
        threads: usize,
        /// What they need.
        needed_mib: u64,
        /// What is free.
        available_mib: u64,
    },
    /// A calibration channel.
    #[error(transparent)]
    Calibration(#[from] CalibrationFault),
    /// A change of the scenario.
    #[error("event: {0}")]
    Change(#[from] ChangeFault),
    /// The worker threads.
    #[error("worker threads: {0}")]
    Pool(#[from] ThreadPoolBuildError),
    /// The stream.
    #[error(transparent)]
    Stream(#[from] StreamError),
}

/// Every fault found while building a run.
#[derive(Debug, Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct BuildErrors(pub Vec<BuildError>);

impl BuildErrors {
    /// Whether any of them is a fault of what was asked for, rather than of the machine: a full disk, a
    /// system without threads.
    pub fn is_wrong_input(&self) -> bool {
        self.0.iter().any(|error| match error {
            BuildError::Sink(error) => error.is_wrong_input(),
            BuildError::Pool(_) => false,
            BuildError::Stream(error) => !matches!(error, StreamError::Thread { .. }),
            _ => true,
        })
    }
}

impl From<PulseError> for BuildError {
    fn from(error: PulseError) -> Self {
        match error {
            PulseError::Radar(error) => error.into(),
            PulseError::Echo(error) => error.into(),
            PulseError::Waveform(error) => error.into(),
            PulseError::SeveralInTurn { .. } => Self::SeveralInTurn,
            PulseError::Unplaced { .. } => Self::Pulse(error),
        }
    }
}

impl From<PlanError> for BuildError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Radar(error) => error.into(),
            PlanError::Echo(error) => error.into(),
        }
    }
}

impl<E: Into<BuildError>> From<E> for BuildErrors {
    fn from(error: E) -> Self {
        Self(vec![error.into()])
    }
}

impl From<FleetErrors> for BuildErrors {
    fn from(errors: FleetErrors) -> Self {
        Self(errors.0.into_iter().map(BuildError::Ship).collect())
    }
}

/// Why a pulse cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PulseError {
    /// Its scatterer paths.
    #[error(transparent)]
    Radar(#[from] RadarError),
    /// Its echo.
    #[error(transparent)]
    Echo(#[from] SynthError),
    /// Scatterer paths that cannot be followed from node to node.
    #[error(
        "{unplaced} paths cannot be followed through a block of pulses (no delay at a node, or one that changes by a \
         million cells); allowed: fidelity.echo = \"reference\""
    )]
    Unplaced {
        /// How many.
        unplaced: usize,
    },
    /// What it is an echo of.
    #[error(transparent)]
    Waveform(#[from] WaveformError),
    /// A window that receives several of the pulses that leave in turn.
    #[error(
        "the window of pulse {pulse} receives other pulses of waveforms in turn besides its own; {ONE_IN_TURN}"
    )]
    SeveralInTurn {
        /// The pulse.
        pulse: u64,
    },
}

/// Why a run cannot use its live navigation.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LiveFault {
    /// The source.
    #[error(transparent)]
    Feed(#[from] FeedError),
    /// Nothing usable came.
    #[error(
        "no navigation from {origin} within {timeout_s} s ({good} messages, {unusable} fixes that cannot be used); \
         allowed: a sender of GGA, RMC, PASHR or INSPVAX, or a longer track.timeout_s"
    )]
    Silent {
        /// Where it was to come from.
        origin: Origin,
        /// How long was waited.
        timeout_s: f64,
        /// Messages read.
        good: u64,
        /// Fixes that were left.
        unusable: u64,
    },
    /// It begins after the run.
    #[error(
        "navigation from {origin} begins at {begins}, after the first pulse at {first}; \
         allowed: a later scene.start_utc, or \"live\""
    )]
    Begun {
        /// Where it comes from.
        origin: Origin,
        /// Its begin.
        begins: TimeTag,
        /// The first pulse.
        first: TimeTag,
    },
    /// A schedule that cannot be kept with live navigation.
    #[error(
        "live navigation goes on in real time: {what}; allowed: pace = \"realtime\" with policy \"stop\" or \"drop\""
    )]
    Schedule {
        /// What is asked.
        what: &'static str,
    },
    /// Something that must know the whole flight.
    #[error("{what} must know the whole flight; allowed: a recorded track, or live navigation without it")]
    Beforehand {
        /// What.
        what: &'static str,
    },
}
