//! What holds for a whole run, found at a few dozen of its instants.

use super::sea;
use super::{CHECKED_PULSES, PathGenerator, beside};
use crate::frames::Earth;
use crate::geometry::horizon;
use crate::paths::emission::Emission;
use crate::radar::fault::{RadarError, RadarFault, TrackUse, mounts};
use crate::radar::window::{GUARD_SAMPLES, far_guard_samples};
use crate::scattering::target::Scatterer;
use crate::scene::radar::{Aim, AimFrom, Pointing};
use crate::scene::sea::PatchPlace;
use crate::scene::{Patch, Sea};

/// Share of the distance to the horizon within which a patch is far from it, between the instants that are
/// evaluated too.
const NEAR_HORIZON: f64 = 0.9;

/// Ratio of the delays of the last and the first echo of a window from which on one is far and the other
/// near: 24 dB by the fourth power of distance.
const FAR: f64 = 4.0;

/// A target that the earth hides.
#[derive(Clone, Debug, PartialEq)]
pub struct BeyondHorizon {
    /// Its name.
    pub target: String,
    /// The transmitter or receiver.
    pub antenna: String,
    /// The pulse.
    pub pulse: u64,
    /// How far they are apart, m.
    pub distance_m: f64,
    /// How far they would see each other at their heights, m.
    pub horizon_m: f64,
}

impl PathGenerator {
    /// The longest delay at a few dozen instants spread over the run, s.
    pub(super) fn longest_delay_s(&self) -> Result<f64, RadarError> {
        let mut emission = Emission::default();
        let mut longest_s = 0f64;
        if self.pulses == 0 {
            return Ok(0.0);
        }
        for index in self.checked_pulses() {
            self.evaluate(index, &mut emission)?;
            let span = self.delay_span_s(index, &emission)?;
            longest_s = longest_s.max(span.map_or(0.0, |(_, most)| most));
            if self.fills_window() {
                // Rain and the far sea fill the window.
                longest_s = longest_s.max(self.hull_at(index)?.close_s);
            }
        }
        Ok(longest_s)
    }

    /// How many times as far from an antenna the farthest point of the patch is as the nearest, at either end
    /// of the run; 1 without a sea.
    ///
    /// # Errors
    /// A track that does not cover the run.
    pub fn range_ratio(&self) -> Result<f64, RadarError> {
        let (mut emission, mut ratio) = (Emission::default(), 1f64);
        for index in [0, self.pulses.saturating_sub(1)] {
            let Some(patch) = self.patch_of(index)? else { return Ok(1.0) };
            self.evaluate(index, &mut emission)?;
            let last = [0, 1].map(|i| patch.first[i] + patch.facets[i] as i64 - 1);
            let (low, high) = (patch.centre_m(patch.first), patch.centre_m(last));
            for centre in &emission.centres {
                let p = centre.position.to_array();
                let range_m = |x: f64, y: f64| (p[0] - x).hypot(p[1] - y).hypot(p[2]).max(patch.facet_m);
                let nearest_m = range_m(p[0].clamp(low[0], high[0]), p[1].clamp(low[1], high[1]));
                let corners = [[low[0], low[1]], [low[0], high[1]], [high[0], low[1]], [high[0], high[1]]];
                let farthest_m = corners.iter().map(|[x, y]| range_m(*x, *y)).fold(0.0, f64::max);
                ratio = ratio.max(farthest_m / nearest_m);
            }
        }
        Ok(ratio)
    }

    /// Samples that images of pulses keep from the window, on either side: more where the window holds echoes
    /// from near by and from far away, at any of a few dozen instants spread over the run.
    pub(super) fn find_guard_samples(&self) -> Result<usize, RadarError> {
        let mut emission = Emission::default();
        if self.pulses == 0 {
            return Ok(GUARD_SAMPLES);
        }
        for index in self.checked_pulses() {
            self.evaluate(index, &mut emission)?;
            let window = self.hull_at(index)?;
            let span = self.delay_span_s(index, &emission)?;
            let first_s = window.open_s - window.guard_s - window.pulse_s;
            // A window may hold the next emission's echoes from near by.
            let next_s = self.radar.emissions.interval_s(index, index + 1);
            let in_window = |(nearest_s, _): (f64, f64)| {
                let next = next_s + nearest_s < window.close_s + window.guard_s;
                if next { nearest_s } else { nearest_s.max(first_s) }
            };
            let of_clutter = self.fills_window().then(|| first_s.max(0.0));
            let nearest_s = span.map(in_window).into_iter().chain(of_clutter).fold(f64::INFINITY, f64::min);
            if window.close_s - window.pulse_s > FAR * nearest_s.max(0.0) {
                return Ok(far_guard_samples(self.radar.window.samples));
            }
        }
        Ok(GUARD_SAMPLES)
    }

    /// Samples between the receive window and the image of a pulse in the transform of an echo.
    pub fn guard_samples(&self) -> usize {
        self.guard_samples
    }

    /// Where the patch lies at a few dozen instants spread over the run, with their times after pulse 0, s.
    pub(super) fn patches(&self, sea: &Sea) -> Result<Vec<(f64, Patch)>, RadarError> {
        self.checked_pulses()
            .map(|index| {
                let t = self.radar.emissions.emission(self.start, index);
                let patch = sea::patch_at(&sea.patch, &sea.place, &self.surroundings(), t);
                let elapsed_s = self.radar.emissions.elapsed_s(index);
                Ok((elapsed_s, patch.map_err(|failure| self.track_error(index, failure))?))
            })
            .collect()
    }

    /// Whether the patch comes near the horizon of an antenna, at any of a few dozen instants spread over the
    /// run.
    pub(super) fn nears_horizon(&self, sea: &Sea) -> Result<bool, RadarError> {
        let earth = self.frame.hiding_earth();
        if earth == Earth::Flat {
            return Ok(false);
        }
        let mut emission = Emission::default();
        let patches = self.patches(sea)?;
        for (index, (_, patch)) in self.checked_pulses().zip(patches) {
            self.evaluate(index, &mut emission)?;
            let last = [0, 1].map(|i| patch.first[i] + patch.facets[i] as i64 - 1);
            let corners = [patch.centre_m(patch.first), patch.centre_m(last)];
            if !emission.centres.iter().all(|c| horizon::holds(earth, c.position, corners, NEAR_HORIZON)) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Targets that the earth hides from an antenna at a pulse.
    ///
    /// # Errors
    /// A track that does not cover the pulse.
    pub fn beyond_horizon(&self, index: u64) -> Result<Vec<BeyondHorizon>, RadarError> {
        let earth = self.frame.hiding_earth();
        let mut hidden = Vec::new();
        if earth == Earth::Flat || index >= self.pulses {
            return Ok(hidden);
        }
        let mut emission = Emission::default();
        self.evaluate(index, &mut emission)?;
        let elapsed_s = self.radar.emissions.elapsed_s(index);
        for target in &self.targets {
            let at = Scatterer::at(target, elapsed_s).position;
            for ((antenna, _), centre) in mounts(&self.radar).zip(&emission.centres) {
                let from = centre.position;
                if horizon::clearance_m(earth, from, at) < 0.0 {
                    let heights_m = [from, at].map(|point| horizon::height_m(earth, point));
                    hidden.push(BeyondHorizon {
                        target: target.name.clone(),
                        antenna: antenna.to_owned(),
                        pulse: index,
                        distance_m: horizon::apart_m(from, at),
                        horizon_m: horizon::distance_m(earth, heights_m),
                    });
                }
            }
        }
        Ok(hidden)
    }

    /// A few dozen pulses spread over the run, the first and the last among them.
    pub(super) fn checked_pulses(&self) -> impl Iterator<Item = u64> + use<> {
        let last = self.pulses.saturating_sub(1);
        let count = CHECKED_PULSES.min(last);
        (0..=count).map(move |step| (u128::from(last) * u128::from(step) / u128::from(count.max(1))) as u64)
    }

    /// A bound on how fast the patch moves, m/s: 0 where it stays; of a point beside a platform, twice the
    /// greatest speed of that platform at a few dozen instants spread over the run (in a turn the point is
    /// faster than the platform).
    pub(super) fn patch_speed_mps(&self, sea: &Sea) -> Result<f64, RadarError> {
        let platform = match &sea.place {
            PatchPlace::Fixed => return Ok(0.0),
            PatchPlace::Follow { aim: Aim::Point { velocity, .. }, .. } => return Ok(velocity.norm()),
            PatchPlace::Follow { aim: Aim::Beside { platform, .. }, .. } => *platform,
        };
        let mut emission = Emission::default();
        let mut fastest_mps = 0f64;
        for index in self.checked_pulses() {
            self.evaluate(index, &mut emission)?;
            fastest_mps = fastest_mps.max(emission.states[platform].velocity.norm());
        }
        Ok(2.0 * fastest_mps)
    }

    /// Whether all tracks reach from the first emission, less the servo lag, to the last plus
    /// `after_s`.
    pub(super) fn check_cover(&self, after_s: f64, faults: &mut Vec<RadarFault>) {
        if self.pulses == 0 {
            return;
        }
        let [first, last] = [0, self.pulses - 1].map(|n| self.radar.emissions.emission(self.start, n));
        for (platform, tracks) in self.tracks.iter().enumerate() {
            let mut known = None;
            for (which, track) in [(TrackUse::Truth, &tracks.truth), (TrackUse::Reported, &tracks.reported)] {
                let (from, to) = (first.plus(-self.looks_back_s(platform, which)), last.plus(after_s));
                if let Err(source) = track.covers(from, to) {
                    // A report is mostly made from the track, and lacks the same.
                    if known.as_ref() == Some(&source) {
                        continue;
                    }
                    known = Some(source.clone());
                    let platform = self.platforms[platform].clone();
                    faults.push(RadarFault::Track { platform, which, from, to, source });
                }
            }
        }
    }

    /// Whether an antenna scans.
    pub fn scans(&self) -> bool {
        mounts(&self.radar).any(|(_, mount)| matches!(mount.pointing, Pointing::Scan(_)))
    }

    /// Whether an antenna is aimed by a report that jumps: gains then jump as well, at any pulse.
    pub fn aim_jumps(&self) -> bool {
        mounts(&self.radar).any(|(_, mount)| {
            let by = mount.pointing.steering().filter(|by| by.from == AimFrom::Reported);
            let known = by.map(|by| [Some(mount.platform), by.aim.and_then(beside)]);
            known.into_iter().flatten().flatten().any(|platform| self.tracks[platform].reported.jumps())
        })
    }

    /// The longest servo lag with which a track is asked, s.
    fn looks_back_s(&self, platform: usize, which: TrackUse) -> f64 {
        mounts(&self.radar)
            .filter_map(|(_, mount)| {
                let by = mount.pointing.steering()?;
                let asked = mount.platform == platform || by.aim.and_then(beside) == Some(platform);
                (asked && TrackUse::from(by.from) == which).then_some(by.lag_s)
            })
            .fold(0.0, f64::max)
    }
}
