//! What holds for a whole run, found at a few dozen of its instants.

use super::sea;
use super::window::Window;
use super::{Illumination, SOUNDINGS, beside};
use crate::radar::emission::Emission;
use crate::radar::fault::{RadarError, RadarFault, TrackUse, mounts};
use crate::scene::radar::{Aim, AimFrom, Pointing};
use crate::scene::sea::PatchPlace;
use crate::scene::{Patch, Sea};

impl Illumination {
    /// The longest delay at a few dozen instants spread over the run, s.
    pub(super) fn longest_delay_s(&self) -> Result<f64, RadarError> {
        let mut emission = Emission::default();
        let mut longest_s = 0f64;
        if self.pulses == 0 {
            return Ok(0.0);
        }
        for index in self.soundings() {
            self.evaluate(index, &mut emission)?;
            let window = Window::new(&self.radar, 0.0, self.pulse_length_s);
            let span = self.delay_span_s(index, &emission, window)?;
            longest_s = longest_s.max(span.map_or(0.0, |(_, most)| most));
        }
        Ok(longest_s)
    }

    /// Where the patch lies at a few dozen instants spread over the run, with their times after pulse 0, s.
    pub(super) fn patches(&self, sea: &Sea) -> Result<Vec<(f64, Patch)>, RadarError> {
        self.soundings()
            .map(|index| {
                let t = self.radar.emissions.emission(self.start, index);
                let patch = sea::patch_at(&sea.patch, &sea.place, &self.surroundings(), t);
                let elapsed_s = self.radar.emissions.interval_s(0, index);
                Ok((elapsed_s, patch.map_err(|failure| self.track_error(index, failure))?))
            })
            .collect()
    }

    /// A few dozen pulses spread over the run, the first and the last among them.
    fn soundings(&self) -> impl Iterator<Item = u64> + use<> {
        let last = self.pulses.saturating_sub(1);
        let count = SOUNDINGS.min(last);
        (0..=count)
            .map(move |sounding| (u128::from(last) * u128::from(sounding) / u128::from(count.max(1))) as u64)
    }

    /// A bound on how fast the patch moves, m/s: 0 where it stays; of a point beside a platform, twice the greatest speed of that
    /// platform at a few dozen instants spread over the run (in a turn the point is faster than the platform).
    pub(super) fn patch_speed_mps(&self, sea: &Sea) -> Result<f64, RadarError> {
        let platform = match &sea.place {
            PatchPlace::Fixed => return Ok(0.0),
            PatchPlace::Follow { aim: Aim::Point { velocity, .. }, .. } => return Ok(velocity.norm()),
            PatchPlace::Follow { aim: Aim::Beside { platform, .. }, .. } => *platform,
        };
        let mut emission = Emission::default();
        let mut fastest_mps = 0f64;
        for index in self.soundings() {
            self.evaluate(index, &mut emission)?;
            fastest_mps = fastest_mps.max(emission.states[platform].velocity.norm());
        }
        Ok(2.0 * fastest_mps)
    }

    /// Whether all tracks reach from the first emission, less what servos look back, to the last plus
    /// `after_s`.
    pub(super) fn check_cover(&self, after_s: f64, faults: &mut Vec<RadarFault>) {
        if self.pulses == 0 {
            return;
        }
        let first = self.start;
        let last = self.radar.emissions.emission(first, self.pulses - 1);
        for (platform, tracks) in self.tracks.iter().enumerate() {
            for (which, track) in [(TrackUse::Truth, &tracks.truth), (TrackUse::Reported, &tracks.reported)] {
                let (from, to) = (first.plus(-self.looks_back_s(platform, which)), last.plus(after_s));
                if let Err(source) = track.covers(from, to) {
                    let platform = self.platforms[platform].clone();
                    faults.push(RadarFault::Track { platform, which, from, to, source });
                }
            }
        }
    }

    /// Whether an antenna is aimed by a report that jumps: gains then jump as well, at any pulse.
    pub fn aim_jumps(&self) -> bool {
        mounts(&self.radar).any(|(_, mount)| match &mount.pointing {
            Pointing::At { aim, aim_from: AimFrom::Reported, .. } => {
                let known = [Some(mount.platform), beside(aim)];
                known.into_iter().flatten().any(|platform| self.tracks[platform].reported.jumps())
            }
            _ => false,
        })
    }

    /// The longest servo lag with which a track is asked, s.
    fn looks_back_s(&self, platform: usize, which: TrackUse) -> f64 {
        mounts(&self.radar)
            .filter_map(|(_, mount)| match &mount.pointing {
                Pointing::At { aim, aim_from, lag_s, .. } => {
                    let asked = mount.platform == platform || beside(aim) == Some(platform);
                    (asked && TrackUse::from(*aim_from) == which).then_some(*lag_s)
                }
                Pointing::Fixed { .. } => None,
            })
            .fold(0.0, f64::max)
    }
}
