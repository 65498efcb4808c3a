//! Floating targets: how the sea lifts them, and when its crests hide them.
//!
//! At the place `x = x_0 + v t` of a target (or that of its trajectory) the mean surface under it has the
//! height
//!
//! `z(t) = sum over K of 2 Re a(K) W(K) e^{j (K.x_0 - w_e t)}` , `w_e = w(K) - K.v` ,
//! `W(K) = sin(K L/2)/(K L/2)` for `K < 2 pi/L`, else 0
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `a(K)`, `w(K)` | amplitudes and angular frequencies of the waves of the sea, the facets' own | m, rad/s |
//! | `w_e` | frequency with which the target meets a wave | rad/s |
//! | `L` | waterline: waves along a hull of this length average out by `W`, shorter ones altogether | m |
//!
//! Height, rate and acceleration are summed at **time samples**, so close that the fastest of these waves
//! turns by half a radian, and are quintic Hermite in between (off by 4e-7 of a wave at most); so are slopes,
//! `j K` in the sum, and their rates, cubic in between (2e-4). What lifts and tilts a target is the same in
//! the reference and in the fast echo. Its own vertical, by which its aspect is found, is the normal of that
//! mean surface: roll and pitch follow the slope, the heading stays. The height of the target's position is
//! carried on top, above the sea that curves with the earth. Every time sample is found once, by whoever
//! comes first.
//!
//! **Crests**, where waves hide facets ([`crate::geometry::shadow`]): the target has their clearance, over
//! the points of its line of sight a facet apart, and their weight. Waves of that line are those longer than
//! the waterline, unaveraged. Weights are found at both time samples about an instant from the course of the
//! antenna at the first (live navigation knows no later one), and are linear in between.
//!
//! Limits: linear waves; a hull that follows the water at once (no resonance, no damping); no sway with the
//! orbital motion; waves of ships neither lift nor hide it; the crests of the first
//! [`MOST_STEPS`] facets of the line of sight hide it, and those of shorter waves than it do not.

use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

use num_complex::Complex64;

use crate::frames::{Enu, Point, SceneFrame, Vector};
use crate::geometry::shadow::visible;
use crate::motion::pointing::PhaseCentre;
use crate::paths::waves::{Component, Series, components, met, quintic};
use crate::scene::{self, Target, Trajectory};
use crate::sea::surface::Surface;

/// Steps of a line of sight whose heights are found at once, and all of them.
const STEPS: usize = 16;
const MOST_STEPS: usize = 1024;

/// A wave: its wave vector, rad/m, angular frequency, rad/s, amplitude at the origin and pulse 0, m, and what
/// a hull keeps of it.
#[derive(Debug)]
pub(super) struct Wave {
    k: [f64; 2],
    omega: f64,
    amplitude: Complex64,
    share: f64,
}

/// The waves of a surface that a hull of a waterline feels.
pub(super) fn waves(surface: &Surface, waterline_m: f64) -> Arc<[Wave]> {
    let feels = |wave: Component| {
        let half = 0.5 * wave.length * waterline_m;
        let share = if half > 0.0 { half.sin() / half } else { 1.0 };
        let Component { k, omega, amplitude, .. } = wave;
        (half < 0.5 * TAU).then_some(Wave { k, omega, amplitude, share })
    };
    components(surface).filter_map(feels).collect()
}

/// How crests hide targets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crests {
    pub width_rad: f64,
    pub facet_m: f64,
    /// No crest is higher, m.
    pub reach_m: f64,
    pub antennas: usize,
}

/// The surface at a time sample: height, rate, acceleration; slopes East and North, and their rates.
#[derive(Clone, Copy, Debug, Default)]
struct Knot {
    height: [f64; 3],
    slope: [[f64; 2]; 2],
}

/// What lifts one target, and hides it.
#[derive(Debug)]
pub(super) struct Heave {
    waves: Arc<[Wave]>,
    knots: Series<Knot>,
    crests: Option<Crests>,
    /// `[knot][antenna]`: weights at the time sample and at the next.
    weights: Vec<OnceLock<[f64; 2]>>,
    /// East, North at pulse 0 and speed, m/s.
    course: [[f64; 2]; 2],
    /// Where it goes, unless straight on.
    trajectory: Option<Trajectory>,
    /// Above the mean sea, m.
    height_m: f64,
}

impl Heave {
    /// Of a target among waves, in a run whose last emission is `last_s` after pulse 0.
    pub fn new(
        target: &Target,
        frame: &SceneFrame,
        waves: Arc<[Wave]>,
        crests: Option<Crests>,
        last_s: f64,
    ) -> Self {
        let ([x_m, y_m, z_m], [vx, vy, _]) = (target.position.to_array(), target.velocity.to_array());
        let course = [[x_m, y_m], [vx, vy]];
        let met = |wave: &Wave| match &target.trajectory {
            None => wave.met(course[1]).abs(),
            Some(way) => wave.omega.abs() + wave.k[0].hypot(wave.k[1]) * way.fastest_mps(),
        };
        let fastest = waves.iter().map(met).fold(0.0, f64::max);
        let knots = Series::new(fastest, last_s);
        let ends = crests.map_or(0, |crests| knots.len() * crests.antennas);
        let weights = std::iter::repeat_with(OnceLock::new).take(ends).collect();
        let height_m = z_m + frame.earth().drop_m(x_m, y_m);
        let trajectory = target.trajectory.clone();
        Self { waves, knots, crests, weights, course, trajectory, height_m }
    }

    /// What adds to the phase of a wave vector at a time: its phase at the origin and pulse 0, the frequency
    /// with which it is met, and by how much that grows in a second.
    fn phase(&self, wave: &Wave, time_s: f64, now: Option<&scene::trajectory::Knot>) -> [f64; 3] {
        let along = |[x, y]: [f64; 2]| wave.k[0] * x + wave.k[1] * y;
        let Some(now) = now else {
            let met = wave.met(self.course[1]);
            return [along(self.course[0]) - met * time_s, met, 0.0];
        };
        let level = |[x, y, _]: [f64; 3]| [x, y];
        let met = wave.met(level(now.velocity.to_array()));
        let place = along(level(now.position.to_array()));
        [place - wave.omega * time_s, met, -along(level(now.acceleration.to_array()))]
    }

    fn knot(&self, number: usize) -> Knot {
        self.knots.knot(number, |time_s| {
            let now = self.trajectory.as_ref().map(|way| way.at(time_s));
            self.waves.iter().fold(Knot::default(), |sum, wave| {
                let [z, rate, acceleration] = sum.height;
                let [turned, met, grows] = self.phase(wave, time_s, now.as_ref());
                let lift = wave.share * wave.amplitude * Complex64::cis(turned);
                let slope = |i: usize| {
                    [sum.slope[i][0] - wave.k[i] * lift.im, sum.slope[i][1] + wave.k[i] * met * lift.re]
                };
                Knot {
                    height: [
                        z + lift.re,
                        rate + met * lift.im,
                        acceleration - met * met * lift.re + grows * lift.im,
                    ],
                    slope: [slope(0), slope(1)],
                }
            })
        })
    }

    /// What the waves add at a time after pulse 0: height, m, and its rate, m/s.
    fn lifted(&self, elapsed_s: f64) -> [f64; 2] {
        let (number, s) = self.knots.before(elapsed_s);
        let [before, after] = [number, number + 1].map(|number| self.knot(number).height);
        quintic(self.knots.apart_s(), s, before, after)
    }

    /// Where the target is, and how fast, at a time after pulse 0.
    pub fn at(&self, frame: &SceneFrame, elapsed_s: f64) -> (Point<Enu>, Vector<Enu>) {
        let [[x_m, y_m], [vx, vy]] = self.course;
        let (x_m, y_m, vx, vy) = match &self.trajectory {
            None => (x_m + vx * elapsed_s, y_m + vy * elapsed_s, vx, vy),
            Some(way) => {
                let now = way.at(elapsed_s);
                let ([x_m, y_m, _], [vx, vy, _]) = (now.position.to_array(), now.velocity.to_array());
                (x_m, y_m, vx, vy)
            }
        };
        let ([z_m, rate], earth) = (self.lifted(elapsed_s), frame.earth());
        let [fall_x, fall_y] = earth.drop_slope(x_m, y_m);
        let height_m = self.height_m + z_m - earth.drop_m(x_m, y_m);
        (Point::new(x_m, y_m, height_m), Vector::new(vx, vy, rate - fall_x * vx - fall_y * vy))
    }

    /// How the mean surface tilts the target at a time after pulse 0: slopes East and North.
    pub fn tilt(&self, elapsed_s: f64) -> [f64; 2] {
        let (h, (number, s)) = (self.knots.apart_s(), self.knots.before(elapsed_s));
        let [before, after] = [number, number + 1].map(|number| self.knot(number).slope);
        [0, 1].map(|i| {
            let ([p0, m0], [p1, m1]) = (before[i], after[i]);
            let (d, e) = (p1 - p0 - h * m0, h * (m1 - m0));
            p0 + s * (h * m0 + s * (3.0 * d - e + s * (e - 2.0 * d)))
        })
    }

    /// Whether crests may hide it.
    pub fn hides(&self) -> bool {
        self.crests.is_some()
    }

    /// Share of the field between it and an antenna that passes the crests at a time after pulse 0;
    /// `centre` says where the antenna is at such a time.
    pub fn weight<E>(
        &self,
        frame: &SceneFrame,
        elapsed_s: f64,
        antenna: usize,
        centre: impl FnOnce(f64) -> Result<PhaseCentre, E>,
    ) -> Result<f64, E> {
        let Some(crests) = self.crests else { return Ok(1.0) };
        let (number, share) = self.knots.before(elapsed_s);
        let kept = self.weights.get(number * crests.antennas + antenna);
        let [before, after] = match kept.and_then(OnceLock::get) {
            Some(ends) => *ends,
            None => {
                let time_s = number as f64 * self.knots.apart_s();
                let PhaseCentre { position, velocity, .. } = centre(time_s)?;
                let then = position + velocity * self.knots.apart_s();
                let ends = [(time_s, position), (time_s + self.knots.apart_s(), then)];
                let ends = ends.map(|(time_s, from)| {
                    visible(self.clearance_m(crests, frame, time_s, from), crests.width_rad, crests.facet_m)
                });
                kept.map_or(ends, |kept| *kept.get_or_init(|| ends))
            }
        };
        Ok(before + share * (after - before))
    }

    /// Height of the target above the line from an antenna over the highest crest before it, m.
    fn clearance_m(&self, crests: Crests, frame: &SceneFrame, time_s: f64, from: Point<Enu>) -> f64 {
        let earth = frame.earth();
        let [x_m, y_m, z_m] = self.at(frame, time_s).0.to_array();
        let [from_x, from_y, from_z] = from.to_array();
        let (east, north) = (from_x - x_m, from_y - y_m);
        let apart_m = east.hypot(north);
        let step = [east, north].map(|along| along / apart_m * crests.facet_m);
        let over = |height_m: f64, left_m: f64| z_m - from_z - apart_m * (height_m - from_z) / left_m;
        let enough_m = crests.width_rad * crests.facet_m;
        let mut least_m = f64::INFINITY;
        for first in (1..MOST_STEPS).step_by(STEPS) {
            let heights_m = self.heights_m(time_s, [x_m, y_m], step, first);
            for (n, height_m) in (first..).zip(heights_m) {
                let left_m = apart_m - n as f64 * crests.facet_m;
                // The last point of the line of sight is a facet before the antenna; a place that is not a
                // number has none.
                if left_m.is_nan() || left_m <= crests.facet_m {
                    return least_m;
                }
                let place = [x_m + n as f64 * step[0], y_m + n as f64 * step[1]];
                least_m = least_m.min(over(height_m - earth.drop_m(place[0], place[1]), left_m));
            }
            // Nothing beyond stands as high as what is found, or takes anything from a weight of 1.
            let beyond_m = over(crests.reach_m, apart_m - (first + STEPS) as f64 * crests.facet_m);
            if from_z > crests.reach_m && beyond_m >= least_m.min(enough_m) {
                break;
            }
        }
        least_m
    }

    /// Heights of the waves at some steps of a line from a place, from step `first` on, m.
    fn heights_m(&self, time_s: f64, from_m: [f64; 2], step: [f64; 2], first: usize) -> [f64; STEPS] {
        let begin = [0, 1].map(|i| from_m[i] + first as f64 * step[i]);
        let mut heights_m = [0.0; STEPS];
        for Wave { k, omega, amplitude, .. } in self.waves.iter() {
            let mut wave = amplitude * Complex64::cis(k[0] * begin[0] + k[1] * begin[1] - omega * time_s);
            let turn = Complex64::cis(k[0] * step[0] + k[1] * step[1]);
            for height_m in &mut heights_m {
                *height_m += wave.re;
                wave *= turn;
            }
        }
        heights_m
    }
}

impl Wave {
    /// Frequency with which something that moves meets it, rad/s.
    fn met(&self, velocity_mps: [f64; 2]) -> f64 {
        met(self.omega, self.k, velocity_mps)
    }
}
