//! Plausibility filter: refuses fixes that imply an impossible speed or acceleration.
//!
//! A receiver may send wrong data with a right checksum: a fix 100 km away, a height of zero, the place of
//! another receiver. With `p`, `t` the last believed fix, `v` its velocity (as sent, else from the fix before
//! it, `dt0` earlier), a fix at `p1`, `dt` later is refused when
//!
//! ```text
//! |p1 - p|        > V dt + 2 N                                     V the highest speed
//! |p1 - p - v dt| > A dt (dt + dt0) / 2 + N (1 + 2 dt / dt0)       A the highest acceleration
//! ```
//!
//! with `N` = [`NOISE_M`] or six standard deviations, where the fix states a larger one; with a velocity as
//! sent, `dt0` is 0 and the last term 2 N. What is refused is as if it had never come, so that the motion is
//! extrapolated and pulses say so.
//!
//! A receiver may also come back from somewhere else: [`MotionBounds::reset_fixes`] refused fixes in a row
//! that agree with each other by the same two rules are believed, all of them, and the gate goes by them from
//! then on.
//!
//! Fixes of a file pass the same gate (`plausible`). There the future is known: fewer fixes in a row than
//! `reset_fixes` before the place is another one are refused themselves.

use glam::DVec3;
use serde::Serialize;

use crate::frames::SceneFrame;
use crate::motion::place::{position, to_local_axes};
use crate::nav::Fix;
use crate::nav::live::MotionBounds;
use crate::time::TimeTag;

/// What the position of a sound fix may be off, m: steps of a receiver that changes its satellites.
pub const NOISE_M: f64 = 15.0;
/// Stated standard deviations that count as noise.
const SIGMAS: f64 = 6.0;

/// What becomes of a fix.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict<T> {
    /// It is believed.
    Believed(T),
    /// It is refused.
    Refused,
    /// It is believed with those before it, in the order of time: the platform is elsewhere.
    Jumped(Vec<T>),
}

/// A plausibility filter that fixes of one platform pass. `T` is what stands for a fix.
#[derive(Debug)]
pub struct MotionGate<T> {
    frame: SceneFrame,
    bounds: MotionBounds,
    believed: Option<Known>,
    /// Refused fixes in a row that agree with each other, and the last of them.
    rivals: Vec<T>,
    rival: Option<Known>,
}

/// What a fix states of the motion.
#[derive(Clone, Copy, Debug)]
struct Known {
    time: TimeTag,
    p: DVec3,
    /// Velocity, and the time over which it is a mean, s.
    v: Option<(DVec3, f64)>,
    noise_m: f64,
}

impl<T> MotionGate<T> {
    /// A filter that has seen nothing: it believes the first fix.
    pub fn new(frame: SceneFrame, bounds: MotionBounds) -> Self {
        Self { frame, bounds, believed: None, rivals: Vec::new(), rival: None }
    }

    /// Judges the next fix, for which `of` stands. One without a place in the scene, or not later than the
    /// one before, is for others to judge.
    pub fn judge(&mut self, fix: &Fix, of: T) -> Verdict<T> {
        let Some(p) = position(fix, &self.frame).filter(|p| p.is_finite()) else {
            return Verdict::Believed(of);
        };
        let sigma_m = fix.sigma.position_m.map_or(0.0, |sigma| sigma.into_iter().fold(0.0, f32::max));
        let noise_m = NOISE_M.max(SIGMAS * f64::from(sigma_m).min(1e4));
        let sent = fix.velocity_mps.map(|[east, north]| {
            let up = fix.climb_mps.unwrap_or(0.0);
            (to_local_axes(&fix.place, &self.frame).transpose() * DVec3::new(east, north, up), 0.0)
        });
        let known = Known { time: fix.time, p, v: sent.filter(|(v, _)| v.is_finite()), noise_m };
        let Some(believed) = self.believed else {
            self.believed = Some(known);
            return Verdict::Believed(of);
        };
        if fix.time.since(believed.time) <= 0.0 {
            return Verdict::Believed(of);
        }
        if believed.leads_to(&known, &self.bounds) {
            self.believed = Some(known.after(&believed));
            self.rivals.clear();
            self.rival = None;
            return Verdict::Believed(of);
        }
        let agrees = self
            .rival
            .is_some_and(|rival| fix.time.since(rival.time) > 0.0 && rival.leads_to(&known, &self.bounds));
        if !agrees {
            self.rivals.clear();
        }
        self.rival = Some(match self.rival.filter(|_| agrees) {
            Some(rival) => known.after(&rival),
            None => known,
        });
        self.rivals.push(of);
        if self.rivals.len() < self.bounds.reset_fixes {
            return Verdict::Refused;
        }
        self.believed = self.rival.take();
        Verdict::Jumped(std::mem::take(&mut self.rivals))
    }
}

/// What was refused among the fixes of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Refusals {
    /// Fixes that no platform within the bounds can have flown to.
    pub implausible: usize,
    /// Places that the platform cannot have reached, but stays at.
    pub jumps: usize,
}

/// Leaves the fixes of a file that the platform cannot have flown to.
pub(crate) fn plausible(fixes: &mut Vec<Fix>, frame: &SceneFrame, bounds: MotionBounds) -> Refusals {
    let mut gate = MotionGate::new(*frame, bounds);
    let mut is_kept = vec![false; fixes.len()];
    let mut jumps = 0;
    // Believed since the platform was elsewhere last.
    let mut since: Vec<usize> = Vec::new();
    for (index, fix) in fixes.iter().enumerate() {
        match gate.judge(fix, index) {
            Verdict::Believed(index) => {
                is_kept[index] = true;
                if since.len() < bounds.reset_fixes {
                    since.push(index);
                }
            }
            Verdict::Refused => {}
            Verdict::Jumped(indices) => {
                if since.len() < bounds.reset_fixes {
                    // Too few to know: they are judged by what came after.
                    let mut back = MotionGate::new(*frame, bounds);
                    let known = indices.iter().rev().chain(since.iter().rev());
                    for (order, index) in known.copied().enumerate() {
                        let verdict = back.judge(&backwards(&fixes[index]), index);
                        is_kept[index] = order < indices.len() || matches!(verdict, Verdict::Believed(_));
                    }
                } else {
                    jumps += 1;
                }
                indices.iter().for_each(|index| is_kept[*index] = true);
                since = indices;
            }
        }
    }
    let mut kept = is_kept.iter();
    fixes.retain(|_| kept.next().copied().unwrap_or(true));
    Refusals { implausible: is_kept.iter().filter(|kept| !**kept).count(), jumps }
}

/// A fix of the same motion in time that runs backwards.
fn backwards(fix: &Fix) -> Fix {
    Fix {
        time: TimeTag::new(-fix.time.seconds(), -fix.time.fraction_s()),
        velocity_mps: fix.velocity_mps.map(|v| v.map(|own| -own)),
        climb_mps: fix.climb_mps.map(|climb_mps| -climb_mps),
        ..*fix
    }
}

impl Known {
    /// Whether a platform within the bounds can be there.
    fn leads_to(&self, next: &Self, bounds: &MotionBounds) -> bool {
        let dt = next.time.since(self.time);
        let noise_m = self.noise_m.max(next.noise_m);
        if (next.p - self.p).length() > bounds.max_speed_mps * dt + 2.0 * noise_m {
            return false;
        }
        let Some((v, before_s)) = self.v else { return true };
        let spread = if before_s > 0.0 { 1.0 + 2.0 * dt / before_s } else { 2.0 };
        let reach_m = 0.5 * bounds.max_acceleration_mps2 * dt * (dt + before_s) + spread * noise_m;
        (next.p - self.p - v * dt).length() <= reach_m
    }

    /// The same with the velocity from the fix before, where it has none.
    fn after(self, before: &Self) -> Self {
        let dt = self.time.since(before.time);
        Self { v: self.v.or(Some(((self.p - before.p) / dt, dt))), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Earth, Point};
    use crate::nav::Place;

    fn fix(time_s: f64, east_m: f64) -> Fix {
        Fix::at(TimeTag::new(1_000_000, time_s), Place::Local(Point::new(east_m, 0.0, 300.0)))
    }

    fn gate(bounds: MotionBounds) -> MotionGate<f64> {
        MotionGate::new(SceneFrame::plain(Earth::Flat), bounds)
    }

    #[test]
    fn one_fix_far_away_is_refused() {
        for rate_hz in [1.0, 5.0, 20.0] {
            for bounds in
                [MotionBounds::SHIP, MotionBounds::GROUND, MotionBounds::AIRCRAFT, MotionBounds::SPACECRAFT]
            {
                let mut gate = gate(bounds);
                for k in 0..40 {
                    let time_s = f64::from(k) / rate_hz;
                    let away_m = if k == 20 { 1e5 } else { 0.0 };
                    let verdict = gate.judge(&fix(time_s, 15.0 * time_s + away_m), time_s);
                    let expected = if k == 20 { Verdict::Refused } else { Verdict::Believed(time_s) };
                    assert_eq!(verdict, expected, "{rate_hz} Hz, {bounds:?}, fix {k}");
                }
            }
        }
    }

    #[test]
    fn wrong_fixes_of_a_file_are_left_wherever_they_stand() {
        let frame = SceneFrame::plain(Earth::Flat);
        for (wrong, jumps) in
            [(vec![0], 0), (vec![20], 0), (vec![39], 0), (vec![0, 1, 2], 0), (vec![19, 20, 30], 0)]
        {
            let mut fixes: Vec<Fix> = (0..40)
                .map(|k| fix(f64::from(k), 15.0 * f64::from(k) + if wrong.contains(&k) { 2e3 } else { 0.0 }))
                .collect();
            let bounds = MotionBounds { max_acceleration_mps2: 20.0, ..MotionBounds::SPACECRAFT };
            let refused = plausible(&mut fixes, &frame, bounds);
            assert_eq!(refused, Refusals { implausible: wrong.len(), jumps }, "{wrong:?}");
            assert_eq!(fixes.len(), 40 - wrong.len());
        }
        // Elsewhere for good.
        let mut fixes: Vec<Fix> =
            (0..40).map(|k| fix(f64::from(k), if k < 20 { 0.0 } else { 1e5 })).collect();
        assert_eq!(plausible(&mut fixes, &frame, MotionBounds::SHIP), Refusals { implausible: 0, jumps: 1 });
        assert_eq!(fixes.len(), 40);
    }

    #[test]
    fn a_manoeuvre_with_noise_passes() {
        // An aircraft at 200 m/s that turns with 6 g, its fixes off by up to 10 m, some of them missing.
        let mut gate: MotionGate<i32> =
            MotionGate::new(SceneFrame::plain(Earth::Flat), MotionBounds::AIRCRAFT);
        for k in (0..400).filter(|k| k % 17 != 3) {
            let time_s = 0.05 * f64::from(k);
            let (turn, radius_m) = (0.3 * time_s, 200.0 / 0.3);
            let noise_m = 10.0 * (7.3 * f64::from(k)).sin();
            let mut fix = fix(time_s, radius_m * turn.sin() + noise_m);
            fix.place =
                Place::Local(Point::new(radius_m * turn.sin() + noise_m, radius_m * turn.cos(), 300.0));
            assert_eq!(gate.judge(&fix, k), Verdict::Believed(k), "{time_s} s");
        }
    }

    #[test]
    fn a_platform_that_is_elsewhere_is_believed_in_the_end() {
        let mut gate = gate(MotionBounds::AIRCRAFT);
        for k in 0..10 {
            let time_s = f64::from(k);
            assert_eq!(gate.judge(&fix(time_s, 50.0 * time_s), time_s), Verdict::Believed(time_s));
        }
        // Elsewhere, but nowhere twice.
        for k in 10..16 {
            let east_m = f64::from(k) * 1e5;
            assert_eq!(gate.judge(&fix(f64::from(k), east_m), f64::from(k)), Verdict::Refused);
        }
        for k in 16..20 {
            assert_eq!(
                gate.judge(&fix(f64::from(k), 9e6 + 50.0 * f64::from(k)), f64::from(k)),
                Verdict::Refused
            );
        }
        let verdict = gate.judge(&fix(20.0, 9e6 + 1000.0), 20.0);
        assert_eq!(verdict, Verdict::Jumped(vec![16.0, 17.0, 18.0, 19.0, 20.0]));
        assert_eq!(gate.judge(&fix(21.0, 9e6 + 1050.0), 21.0), Verdict::Believed(21.0));
        assert_eq!(gate.judge(&fix(22.0, 1100.0), 22.0), Verdict::Refused);
    }
}
