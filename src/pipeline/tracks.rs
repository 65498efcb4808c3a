//! From what the scenario says of platforms to the tracks on which they move and report.

use crate::config::Run;
use crate::motion::PlatformNav;
use crate::motion::errors::Circumstances;
use crate::motion::{PlatformTracks, SourceReport, Track};
use crate::nav::TrackSource;
use crate::pipeline::fault::{BuildError, BuildErrors};
use crate::scene::Scene;

/// How a platform's track was made from its source.
#[derive(Clone, Debug)]
pub struct TrackNote {
    /// The platform.
    pub platform: String,
    /// `true` or `reported`.
    pub role: &'static str,
    /// Counts and residuals.
    pub report: SourceReport,
}

/// Loads the tracks of every platform of a scene. Their faults are collected.
///
/// # Errors
/// The faults of all tracks.
pub fn tracks(
    nav: &[PlatformNav],
    scene: &Scene,
) -> Result<(Vec<PlatformTracks>, Vec<TrackNote>), BuildErrors> {
    let Scene { frame, start, radar, .. } = scene;
    let before_s = servo_lag_s(scene);
    let mut tracks = Vec::with_capacity(nav.len());
    let mut notes = Vec::new();
    let mut faults = Vec::new();
    for (place, (source, platform)) in nav.iter().zip(&scene.platforms).enumerate() {
        let mut load = |role: &'static str, source: &TrackSource| -> Option<Track> {
            match Track::from_source(source, frame, *start) {
                Ok((track, report)) => {
                    notes.extend(report.map(|report| TrackNote { platform: platform.clone(), role, report }));
                    Some(track)
                }
                Err(source) => {
                    faults.push(BuildError::Track { platform: platform.clone(), role, source });
                    None
                }
            }
        };
        let truth = load("true", &source.truth);
        let reported = source.reported.as_ref().map(|source| load("reported", source));
        if let Some(truth) = truth {
            let reported = match reported {
                Some(None) => continue,
                Some(reported) => reported,
                None => None,
            };
            let (seed, times, pulses) = (scene.seed, &radar.emissions, scene.pulses);
            let of = Circumstances { seed, platform: place, times, pulses, before_s };
            match PlatformTracks::of(truth, reported, source, frame, &of, *start) {
                Ok(both) => tracks.push(both),
                Err(source) => {
                    faults.push(BuildError::Track { platform: platform.clone(), role: "true", source });
                }
            }
        }
    }
    if faults.is_empty() { Ok((tracks, notes)) } else { Err(BuildErrors(faults)) }
}

/// The tracks of a platform on a track of its own.
pub(super) fn set_tracks(
    track: Track,
    source: &PlatformNav,
    scene: &Scene,
    platform: usize,
) -> Result<PlatformTracks, BuildError> {
    let Scene { frame, start, radar, seed, pulses, .. } = scene;
    let before_s = servo_lag_s(scene);
    let of = Circumstances { seed: *seed, platform, times: &radar.emissions, pulses: *pulses, before_s };
    PlatformTracks::of(track, None, source, frame, &of, *start).map_err(|source| {
        let platform = scene.platforms[platform].clone();
        BuildError::Track { platform, role: "true", source }
    })
}

/// What the tracks of a run follow from.
pub(super) fn flight(run: &Run) -> impl PartialEq {
    let Scene { frame, start, radar, seed, pulses, platforms, .. } = &run.scene;
    (&run.nav, frame, start, &radar.emissions, seed, pulses, platforms, servo_lag_s(&run.scene))
}

/// Longest look-back (lag) of a servo, s.
fn servo_lag_s(scene: &Scene) -> f64 {
    let pointings = scene.radar.transmitters.iter().map(|t| &t.antenna.pointing);
    pointings
        .chain(scene.radar.receivers.iter().map(|r| &r.antenna.pointing))
        .filter_map(|pointing| Some(pointing.steering()?.lag_s))
        .fold(0.0, f64::max)
}
