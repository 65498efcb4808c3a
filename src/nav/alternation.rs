//! Fixes that alternate between two places: two antennas, or two receivers, in one stream.
//!
//! With `r_k` the distance of fix `k` from the straight line through its neighbours in time, fixes that
//! alternate between two antennas have `r_k` of one length and of alternating direction. In 16 of them,
//! `|sum (-1)^k r_k| / sqrt(16 sum |r_k|^2)` is 1 then; of white noise it is 0.4, of a manoeuvre 0. More than
//! half of all sixteens above 0.8, with an `r_k` of 2 m rms and more, are two antennas.
//!
//! ```
//! use nereus::frames::Geodetic;
//! use nereus::nav::alternation::Alternation;
//! use nereus::nav::{Fix, Place};
//! use nereus::time::TimeTag;
//!
//! let mut alternation = Alternation::default();
//! for k in 0..40 {
//!     let lat_deg = 54.0 + 1e-5 * f64::from(k) + if k % 2 == 0 { 0.0 } else { 1e-4 };
//!     let place = Place::Geodetic(Geodetic::from_deg(lat_deg, 10.0, 20.0));
//!     alternation.push(&Fix::at(TimeTag::new(1_700_000_000 + i64::from(k), 0.0), place));
//! }
//! assert!((alternation.apart_m().unwrap() - 11.1).abs() < 0.2);
//! ```

use glam::DVec3;

use super::{Fix, Place};
use crate::time::TimeTag;

/// Distances that are looked at together.
const TOGETHER: u32 = 16;
/// What alternation has at least, of 1.
const LEAST: f64 = 0.8;
/// Root mean square distance below which nobody cares, m.
const LEAST_M: f64 = 2.0;

/// Looks for alternation in fixes as they come.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alternation {
    /// The last two fixes.
    before: [Option<(TimeTag, DVec3)>; 2],
    /// Distances of this group: how many, their alternating sum and the sum of their squares, m.
    group: (u32, DVec3, f64),
    groups: u32,
    /// Groups that alternate, and the sum of their distances, m.
    alternating: (u32, f64),
}

impl Alternation {
    /// Takes the next fix.
    pub fn push(&mut self, fix: &Fix) {
        let p = match fix.place {
            Place::Geodetic(place) => place.to_ecef().raw(),
            Place::Local(point) => point.raw(),
        };
        if let [Some((t0, p0)), Some((t1, p1))] = self.before {
            let share = t1.since(t0) / fix.time.since(t0);
            if share > 0.0 && share < 1.0 && p.is_finite() {
                self.take(p1 - p0.lerp(p, share));
            }
        }
        self.before = [self.before[1], Some((fix.time, p))];
    }

    fn take(&mut self, r: DVec3) {
        let (count, sum, squares) = &mut self.group;
        *sum += if *count % 2 == 0 { r } else { -r };
        *squares += r.length_squared();
        *count += 1;
        if *count < TOGETHER {
            return;
        }
        let count = f64::from(*count);
        let alternates =
            sum.length() > LEAST * (count * *squares).sqrt() && *squares > count * LEAST_M.powi(2);
        self.groups += 1;
        if alternates {
            self.alternating.0 += 1;
            self.alternating.1 += sum.length() / count;
        }
        self.group = Default::default();
    }

    /// How far the two places are from each other, m; `None` where fixes do not alternate.
    pub fn apart_m(&self) -> Option<f64> {
        let (groups, sum_m) = self.alternating;
        (2 * groups > self.groups).then(|| sum_m / f64::from(groups))
    }
}
