//! Where platforms were, and reported to be, over the whole run, in bounded memory.
//!
//! Points are taken at an interval. When all places are taken, every second point goes and the interval is
//! doubled: the whole run stays in view, ever coarser. Whoever reads along notices by the [`History::epoch`].

use crate::frames::Rotation;
use crate::pulse::{PlatformRecord, Pulse};

/// Shortest interval, s.
const SHORTEST_S: f64 = 0.02;
/// Places for points of all platforms together.
const PLACES: usize = 6000;

/// One platform at a pulse.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// True position, ENU, m.
    pub true_m: [f64; 3],
    /// Reported position, m.
    pub reported_m: [f64; 3],
    /// Reported minus true position, East, North, up, m.
    pub position_m: [f64; 3],
    /// Reported minus true velocity, East, North, up, m/s.
    pub velocity_mps: [f64; 3],
    /// Reported minus true attitude: roll, pitch, heading, degrees within +-180.
    pub attitude_deg: [f64; 3],
    /// Emission minus the epoch of the report, s.
    pub age_s: f64,
}

/// All platforms at a pulse.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instant {
    /// The pulse.
    pub pulse: u64,
    /// Its emission after that of pulse 0, s.
    pub time_s: f64,
    /// The platforms.
    pub platforms: Vec<Sample>,
}

/// Points over the run.
#[derive(Debug)]
pub struct History {
    points: Vec<Instant>,
    most: usize,
    interval_s: f64,
    epoch: u32,
}

impl Sample {
    fn of(truth: &PlatformRecord, reported: &PlatformRecord) -> Self {
        let less = |a: &[f64; 3], b: &[f64; 3]| std::array::from_fn(|axis| a[axis] - b[axis]);
        let angles = |of: &PlatformRecord| {
            let [w, x, y, z] = of.attitude_quat;
            Rotation::<crate::frames::Body, crate::frames::Enu>::from_raw(glam::DQuat::from_xyzw(x, y, z, w))
                .to_yaw_pitch_roll()
                .map(f64::to_degrees)
        };
        let ([yaw, pitch, roll], [true_yaw, true_pitch, true_roll]) = (angles(reported), angles(truth));
        let round = |angle: f64| (angle + 180.0).rem_euclid(360.0) - 180.0;
        Self {
            true_m: truth.position_m,
            reported_m: reported.position_m,
            position_m: less(&reported.position_m, &truth.position_m),
            velocity_mps: less(&reported.velocity_mps, &truth.velocity_mps),
            attitude_deg: [roll - true_roll, pitch - true_pitch, yaw - true_yaw].map(round),
            age_s: reported.age_s,
        }
    }
}

impl Instant {
    /// The platforms of a pulse.
    pub fn of(pulse: &Pulse, time_s: f64) -> Self {
        let platforms = pulse.nav_true.iter().zip(&pulse.nav_reported);
        let platforms = platforms.map(|(truth, reported)| Sample::of(truth, reported)).collect();
        Self { pulse: pulse.index, time_s, platforms }
    }
}

impl History {
    /// Of so many platforms.
    pub fn new(platforms: usize) -> Self {
        let most = (PLACES / platforms.max(1)).clamp(64, 1500);
        Self { points: Vec::with_capacity(most), most, interval_s: SHORTEST_S, epoch: 0 }
    }

    /// Whether a pulse of that time is due.
    pub fn wants(&self, time_s: f64) -> bool {
        self.points
            .last()
            .is_none_or(|last| time_s - last.time_s >= 0.999 * self.interval_s || time_s < last.time_s)
    }

    /// Takes a point.
    pub fn push(&mut self, point: Instant) {
        if self.points.len() == self.most {
            let mut place = 0;
            self.points.retain(|_| {
                place += 1;
                place % 2 == 1
            });
            self.interval_s *= 2.0;
            self.epoch += 1;
        }
        self.points.push(point);
    }

    /// All points, in order.
    pub fn points(&self) -> &[Instant] {
        &self.points
    }

    /// Changes when points have gone.
    pub fn epoch(&self) -> u32 {
        self.epoch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_stays_in_view() {
        let mut history = History::new(4);
        for n in 0..200_000_u32 {
            let time_s = f64::from(n) * 0.005;
            if history.wants(time_s) {
                history.push(Instant { pulse: n.into(), time_s, platforms: Vec::new() });
            }
        }
        let points = history.points();
        assert!((700..=1500).contains(&points.len()), "{}", points.len());
        assert_eq!((points[0].pulse, history.epoch() > 4), (0, true));
        assert!(points.last().unwrap().time_s > 998.0);
        assert!(points.windows(2).all(|pair| pair[1].time_s - pair[0].time_s < 2.1 * history.interval_s));
    }

    #[test]
    fn errors_are_reported_minus_true() {
        let attitude = |yaw: f64, pitch: f64, roll: f64| {
            Rotation::from_yaw_pitch_roll(yaw.to_radians(), pitch.to_radians(), roll.to_radians()).to_wxyz()
        };
        let truth = PlatformRecord { attitude_quat: attitude(359.5, 2.0, -3.0), ..PlatformRecord::default() };
        let reported = PlatformRecord {
            position_m: [1.0, -2.0, 3.0],
            attitude_quat: attitude(0.25, 2.5, -3.125),
            ..PlatformRecord::default()
        };
        let sample = Sample::of(&truth, &reported);
        assert_eq!(sample.position_m, [1.0, -2.0, 3.0]);
        for (got, want) in sample.attitude_deg.iter().zip([-0.125, 0.5, 0.75]) {
            assert!((got - want).abs() < 1e-9, "{got} {want}");
        }
    }
}
