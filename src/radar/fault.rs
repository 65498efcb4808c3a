//! What can be wrong with a scene's radar, found before the first pulse and reported all at once.
//!
//! [`RadarError::Faults`] lists every [`RadarFault`] of a scene: references to what is not there, numbers
//! out of range, pattern files, tracks that do not cover the run. Once a scene is accepted only a pulse
//! outside the run or a live track that fails can still be an error.
//!
//! ```
//! use nereus::radar::fault::{RadarError, RadarFault};
//! let error = RadarError::Faults(vec![RadarFault::NoPolarisation]);
//! assert!(error.to_string().contains("at least one wanted"));
//! ```

use thiserror::Error;

use crate::geometry::shadow::ShadowError;
use crate::motion::track::TrackError;
use crate::radar::pattern::PatternError;
use crate::scattering::water::WaterError;
use crate::scene::radar::{Aim, AimFrom, AntennaMount, Gate, TxPolarisation};
use crate::scene::sea::PatchPlace;
use crate::scene::{Radar, Scene};
use crate::sea::fleet::FleetError;
use crate::sea::land::LandError;
use crate::sea::realise::RealiseError;
use crate::sea::wake::WakeError;
use crate::time::TimeTag;

/// Why the scatterer paths of a scene cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RadarError {
    /// The scene does not hang together.
    #[error("the radar cannot be built:{}", listed(.0))]
    Faults(Vec<RadarFault>),
    /// A pulse outside the run.
    #[error("pulse {index} is not in the run: 0 to {} wanted", pulses.saturating_sub(1))]
    NoSuchPulse {
        /// What was asked.
        index: u64,
        /// Pulses in the run.
        pulses: u64,
    },
    /// A track fails at a pulse.
    #[error("pulse {index}: platform '{platform}', {which} track: {source}")]
    Track {
        /// The pulse.
        index: u64,
        /// The platform.
        platform: String,
        /// Which of its tracks.
        which: TrackUse,
        /// Why.
        source: TrackError,
    },
    /// The sea fails at a pulse.
    #[error("pulse {index}: sea: {source}")]
    Sea {
        /// The pulse.
        index: u64,
        /// Why.
        source: WakeError,
    },
    /// Its shadows fail at a pulse.
    #[error("pulse {index}: shadows of the sea: {source}")]
    Shadow {
        /// The pulse.
        index: u64,
        /// Why.
        source: ShadowError,
    },
}

/// Three digits are enough.
fn figure(value: f64) -> String {
    if value >= 100.0 { format!("{value:.0}") } else { format!("{value:.3}") }
}

/// A hint where the dates of a track are 1024 weeks off, or twice that: GPS weeks begin again after so many.
fn rolled_over(from: TimeTag, to: TimeTag, first: TimeTag, last: TimeTag) -> String {
    const ROLLOVER_S: f64 = 1024.0 * 604_800.0;
    let covers = |shift_s: f64| from.since(first.plus(shift_s)) >= 0.0 && last.plus(shift_s).since(to) >= 0.0;
    match [1.0, 2.0].into_iter().find(|times| covers(times * ROLLOVER_S)) {
        Some(times) => format!(
            "; its dates are {} weeks early, as those of a receiver whose GPS week has rolled over: \
             track.date gives the right one",
            1024.0 * times
        ),
        None => String::new(),
    }
}

/// Why a track does not cover what is needed, which is said once.
fn uncovered(from: TimeTag, to: TimeTag, source: &TrackError) -> String {
    match source {
        TrackError::Uncovered { first, last, .. } if from.since(*last) > 0.0 || first.since(to) > 0.0 => {
            let side = if from.since(*last) > 0.0 { "ends before" } else { "begins after" };
            let weeks = rolled_over(from, to, *first, *last);
            format!(
                "covers {first} to {last}, which {side} the run, {from} to {to}; allowed: a scene.start_utc within the track{weeks}"
            )
        }
        TrackError::Uncovered { .. } => format!("{source}; scene.start_utc and duration_s have to suit it"),
        source => format!("needed from {from} to {to}: {source}"),
    }
}

fn listed(faults: &[RadarFault]) -> String {
    faults.iter().map(|fault| format!("\n  {fault}")).collect()
}

/// One fault of a scene.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RadarFault {
    /// Tracks and platforms do not match.
    #[error("{tracks} tracks for {platforms} platforms")]
    Tracks {
        /// Tracks given.
        tracks: usize,
        /// Platforms of the scene.
        platforms: usize,
    },
    /// Something refers to what is not there.
    #[error("{place}: {what} {index} does not exist ({count} in the scene)")]
    Missing {
        /// Where the reference stands.
        place: String,
        /// What it refers to.
        what: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A number out of range.
    #[error("{name} = {value} is not allowed: {allowed}")]
    Value {
        /// What.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// An alternating sequence without entries.
    #[error("transmit polarisations alternate in an empty sequence: at least one wanted")]
    NoPolarisation,
    /// A pattern file is wrong.
    #[error("antenna '{antenna}': {source}")]
    Pattern {
        /// The antenna.
        antenna: String,
        /// Why.
        source: PatternError,
    },
    /// A file of radar cross sections is wrong.
    #[error("target '{target}': {source}")]
    Aspect {
        /// The first target that names it.
        target: String,
        /// Why.
        source: PatternError,
    },
    /// The sea.
    #[error("sea: {0}")]
    Sea(#[from] SeaFault),
    /// A track does not cover the run.
    #[error("platform '{platform}', {which} track: {}", uncovered(*from, *to, source))]
    Track {
        /// The platform.
        platform: String,
        /// Which of its tracks.
        which: TrackUse,
        /// First instant needed.
        from: TimeTag,
        /// Last instant needed.
        to: TimeTag,
        /// Why it does not.
        source: TrackError,
    },
}

/// Why a scene's sea cannot be illuminated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SeaFault {
    /// It cannot be drawn.
    #[error(transparent)]
    Realise(#[from] RealiseError),
    /// It cannot be evaluated.
    #[error(transparent)]
    Surface(#[from] WakeError),
    /// A ship cannot sail.
    #[error(transparent)]
    Fleet(#[from] FleetError),
    /// Its water cannot scatter.
    #[error(transparent)]
    Water(#[from] WaterError),
    /// It has no land.
    #[error(transparent)]
    Land(#[from] LandError),
    /// It cannot cast shadows.
    #[error(transparent)]
    Shadow(#[from] ShadowError),
    /// A patch that moves too far between updates.
    #[error(
        "the patch that follows moves by {rows} facets between two updates of its shadows (and within a block of pulses): \
         at most {most}, its own length, are allowed; sea.shadow.update_ms below {} ms, or a larger patch",
        figure(*update_ms)
    )]
    SlowUpdates {
        /// Facets that it moves.
        rows: usize,
        /// Facets along its longer side.
        most: usize,
        /// Time between updates that would do, ms.
        update_ms: f64,
    },
    /// More antennas than its shadows are followed for.
    #[error("shadows are followed for at most {most} antennas, the scene has {antennas}")]
    Antennas {
        /// Antennas of the scene.
        antennas: usize,
        /// Most.
        most: usize,
    },
    /// More scatterers of breaking waves than are followed.
    #[error(
        "sea.scattering.breaking = \"whitecaps\": {alive:.0} scatterers of breaking waves are alive at a time on a patch of \
         {patch_m2:.2e} m^2; at most {most:.0} and {most_m2:.0e} m^2 are allowed; a smaller patch, or breaking = \"off\""
    )]
    Breakers {
        /// That are alive at a time, mean.
        alive: f64,
        /// Most.
        most: f64,
        /// Area of the patch, m^2.
        patch_m2: f64,
        /// Largest, m^2.
        most_m2: f64,
    },
}

/// Which of the two tracks of a platform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackUse {
    /// What happens.
    Truth,
    /// What the platform reports.
    Reported,
}

impl From<AimFrom> for TrackUse {
    fn from(aim_from: AimFrom) -> Self {
        match aim_from {
            AimFrom::Reported => Self::Reported,
            AimFrom::True => Self::Truth,
        }
    }
}

impl std::fmt::Display for TrackUse {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Truth => "true",
            Self::Reported => "reported",
        })
    }
}

/// Names and mounts of all antennas, transmitters first.
pub(crate) fn mounts(radar: &Radar) -> impl Iterator<Item = (&str, &AntennaMount)> {
    let transmitters = radar.transmitters.iter().map(|t| (t.name.as_str(), &t.antenna));
    transmitters.chain(radar.receivers.iter().map(|r| (r.name.as_str(), &r.antenna)))
}

pub(crate) fn check_numbers(radar: &Radar, pulse_length_s: f64, faults: &mut Vec<RadarFault>) {
    let positive = "a finite number above 0";
    let numbers = [
        ("carrier (Hz)", radar.carrier_hz),
        ("sample rate (Hz)", radar.sample_rate_hz),
        ("pulse length (s)", pulse_length_s),
    ];
    for (name, value) in numbers {
        if !(value.is_finite() && value > 0.0) {
            faults.push(RadarFault::Value { name, value, allowed: positive });
        }
    }
    if matches!(&radar.tx_polarisation, TxPolarisation::Alternating(sequence) if sequence.is_empty()) {
        faults.push(RadarFault::NoPolarisation);
    }
}

pub(crate) fn check_references(scene: &Scene, tracks: usize, faults: &mut Vec<RadarFault>) {
    let (radar, platforms) = (&scene.radar, scene.platforms.len());
    if tracks != platforms {
        faults.push(RadarFault::Tracks { tracks, platforms });
    }
    let mut check = |place: &dyn Fn() -> String, what, index, count| {
        if index >= count {
            faults.push(RadarFault::Missing { place: place(), what, index, count });
        }
    };
    for channel in &radar.channels {
        let place = || format!("channel '{}'", channel.name);
        check(&place, "transmitter", channel.transmitter, radar.transmitters.len());
        check(&place, "receiver", channel.receiver, radar.receivers.len());
    }
    for (name, mount) in mounts(radar) {
        let place = || format!("antenna '{name}'");
        check(&place, "platform", mount.platform, platforms);
        if let Some(Aim::Beside { platform, .. }) = mount.pointing.steering().and_then(|by| by.aim) {
            check(&place, "platform", *platform, platforms);
        }
    }
    let own = radar.receivers.iter().filter_map(|end| Some((Some(&end.name), end.gate.as_ref()?)));
    for (receiver, gate) in std::iter::once((None, &radar.window.gate)).chain(own) {
        if let Gate::Follow { aim: Aim::Beside { platform, .. }, .. } = gate {
            let place =
                || receiver.map_or("window".to_owned(), |name| format!("window of receiver '{name}'"));
            check(&place, "platform", *platform, platforms);
        }
    }
    if let Some(PatchPlace::Follow { aim: Aim::Beside { platform, .. }, .. }) =
        scene.sea.as_ref().map(|sea| &sea.place)
    {
        check(&|| "patch".to_owned(), "platform", *platform, platforms);
    }
}
