//! The wake of one ship.
//!
//! In the scene frame the waves of [`nodes`] run along `K = kx f + ky p` (f ahead, p to port):
//! `z = Re sum of a_n exp(j K_n.(r - r_ship(t)))`, and since `w = K.f V` a ship on a straight course moves
//! its wake by phases alone: nothing is interpolated. With `e_n` the n-th term:
//!
//! | field | sum |
//! | --- | --- |
//! | height, m | `Re e` |
//! | slope | `-K Im e` |
//! | vertical velocity, m/s | `w Im e` |
//! | horizontal velocity, m/s | `(K/k) w Re e` |
//! | acceleration, m/s^2 | `-w^2 Re e`, `(K/k) w^2 Im e` |
//! | horizontal displacement, m | `-(K/k) Im e` |
//! | rate of the slope, 1/s | `K w Re e` |
//!
//! as the sea has them, then under the window of [`upstream`](super::upstream). Source: thin-ship theory,
//! `docs/physics.md` section 9.1 (Havelock, Michell; Tuck, Lazauskas and Scullen 1999). Limits: linear waves,
//! deep water, far field; no wake ([`Presence`]) of a ship slower than 0.1 m/s, or whose longest wave
//! `2 pi V^2/g` is shorter than four facets, or whose waves the band limit takes away.
//!
//! ```
//! use nereus::sea::wake::{Course, Presence, Reach, Settings, Wake, Wigley};
//! let hull = Wigley { length_m: 100.0, beam_m: 13.0, draught_m: 4.3 };
//! let settings = Settings::new(1.0, Reach::disc(400.0));
//! let make = |speed_mps: f64| {
//!     let course = Course::straight([0.0, 0.0], 0.0, speed_mps);
//!     Wake::new(course, hull.length_m, &settings, |t| hull.amplitude_m(speed_mps, t))
//! };
//! let wake = make(4.5)?;
//! assert_eq!(wake.presence(), Presence::Waves);
//! assert_eq!(wake.at([60.0, 0.0], 0.0)?.height_m, 0.0);
//! assert!(wake.at([-300.0, 0.0], 0.0)?.height_m.abs() < 0.5);
//! assert_eq!(make(1.0)?.presence(), Presence::Unresolved);
//! assert!(make(-1.0).is_err());
//! # Ok::<(), nereus::sea::wake::WakeError>(())
//! ```

use super::fault::{LENGTH_RANGE_M, WakeError};
use std::f64::consts::TAU;

use num_complex::Complex64;

use super::course::{Course, Pose, Reach};
use super::leg::LegWindow;
use super::nodes::{self, Band, Node};
use super::upstream::{Upstream, Window};
use crate::sea::GRAVITY_MPS2;
use crate::sea::surface::Sample;
use crate::sea::surface::grid::FACET_RANGE_M;
use crate::sea::wake::fault::MAX_TIME_S;
use crate::sea::wake::fault::MOST_TURN_RAD;

/// Slowest ship with a wake, m/s.
pub const LEAST_SPEED_MPS: f64 = 0.1;
/// Facets in the longest wave, at least.
pub const LEAST_FACETS_A_WAVE: f64 = 4.0;

/// What a map asks of a wake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Side of a facet, m.
    pub facet_m: f64,
    /// kc, rad/m; `None` for `0.7 pi/dx`.
    pub cutoff_rad_m: Option<f64>,
    /// How far from midship it is asked.
    pub reach: Reach,
    /// What stands ahead of the ship.
    pub upstream: Upstream,
    /// Where waves begin to fade and where none are left, m astern of midship; `None` for a wake without end.
    pub fade_m: Option<[f64; 2]>,
}

impl Settings {
    /// Those of facets of a side, m, with the default band limit, and still water ahead.
    pub fn new(facet_m: f64, reach: Reach) -> Self {
        Self { facet_m, cutoff_rad_m: None, reach, upstream: Upstream::default(), fade_m: None }
    }

    pub(super) fn band(&self) -> Result<Band, WakeError> {
        let facet_m = self.facet_m;
        if !(FACET_RANGE_M[0]..=FACET_RANGE_M[1]).contains(&facet_m) {
            return Err(WakeError::Facet { facet_m });
        }
        match self.cutoff_rad_m {
            Some(cutoff_rad_m) if !(cutoff_rad_m.is_finite() && cutoff_rad_m > 0.0) => {
                Err(WakeError::Cutoff { cutoff_rad_m })
            }
            Some(cutoff_rad_m) => Ok(Band { cutoff_rad_m }),
            None => Ok(Band::of_facets(facet_m)),
        }
    }
}

/// Whether a ship has a wake on a map; if not, callers may want to say why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// It has.
    Waves,
    /// Slower than [`LEAST_SPEED_MPS`].
    Slow,
    /// The longest wave is shorter than [`LEAST_FACETS_A_WAVE`] facets.
    Unresolved,
    /// The band limit leaves less than 1e-6 of the longest wave, and less of all others.
    BandLimited,
}

/// The wake of one ship.
#[derive(Clone, Debug, PartialEq)]
pub struct Wake {
    course: Course,
    window: Window,
    leg: Option<LegWindow>,
    reach: Reach,
    facet_m: f64,
    presence: Presence,
    nodes: Vec<Node>,
}

impl Wake {
    /// For a ship of a length, m, whose free waves have the amplitude A, m, as a function of
    /// `tan theta >= 0`.
    ///
    /// # Errors
    /// A length, a course or an amplitude out of range.
    pub fn new(
        course: Course,
        length_m: f64,
        settings: &Settings,
        amplitude_m: impl Fn(f64) -> Complex64,
    ) -> Result<Self, WakeError> {
        course.check()?;
        if !(LENGTH_RANGE_M[0]..=LENGTH_RANGE_M[1]).contains(&length_m) {
            return Err(WakeError::Length { length_m });
        }
        let band = settings.band()?;
        let (speed_mps, reach) = (course.speed_mps, settings.reach);
        let Reach { along_m, across_m } = reach;
        if !((0.0..f64::INFINITY).contains(&along_m) && (0.0..f64::INFINITY).contains(&across_m)) {
            return Err(WakeError::Reach { along_m, across_m });
        }
        let none = |presence| Self {
            course,
            window: settings.upstream.window(length_m).fading(settings.fade_m),
            leg: None,
            reach,
            facet_m: settings.facet_m,
            presence,
            nodes: Vec::new(),
        };
        if speed_mps < LEAST_SPEED_MPS {
            return Ok(none(Presence::Slow));
        }
        let k0 = GRAVITY_MPS2 / (speed_mps * speed_mps);
        if TAU / k0 < LEAST_FACETS_A_WAVE * settings.facet_m {
            return Ok(none(Presence::Unresolved));
        }
        let Some(most) = band.most_tan_theta(k0) else {
            return Ok(none(Presence::BandLimited));
        };
        let turn_rad = course.turn_rate_radps.abs() * along_m / speed_mps;
        if turn_rad > MOST_TURN_RAD {
            return Err(WakeError::Turn { turn_rad, along_m });
        }
        let with_ship = Reach { along_m: along_m + 0.5 * length_m, across_m };
        let nodes = nodes::nodes(speed_mps, k0, most, band, with_ship, amplitude_m)?;
        Ok(Self { nodes, ..none(Presence::Waves) })
    }

    /// The same of a ship that sails a leg of its way on this course: with waves that it made there alone.
    pub fn of_leg(self, leg: Option<LegWindow>) -> Self {
        Self { leg, ..self }
    }

    /// When its waves were made; `None`: all the time.
    pub fn leg(&self) -> Option<LegWindow> {
        self.leg
    }

    /// Whether there are waves.
    pub fn presence(&self) -> Presence {
        self.presence
    }

    /// The ship's course.
    pub fn course(&self) -> &Course {
        &self.course
    }

    /// Its waves; none without presence.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Side of the facets it is made for, m.
    pub fn facet_m(&self) -> f64 {
        self.facet_m
    }

    pub(super) fn window(&self) -> Window {
        self.window
    }

    pub(super) fn pose(&self, time_s: f64) -> Result<Pose, WakeError> {
        if time_s.is_nan() || time_s.abs() > MAX_TIME_S {
            return Err(WakeError::Time { time_s });
        }
        Ok(self.course.pose(time_s))
    }

    pub(super) fn check_reach(&self, [astern_m, starboard_m]: [f64; 2]) -> Result<(), WakeError> {
        let Reach { along_m, across_m } = self.reach;
        if astern_m.abs() <= along_m && starboard_m.abs() <= across_m {
            return Ok(());
        }
        Err(WakeError::BeyondReach { astern_m, starboard_m, along_m, across_m })
    }

    /// All fields at one place and time, summed wave by wave: slow, for checks and references.
    pub fn at(&self, position_m: [f64; 2], time_s: f64) -> Result<Sample, WakeError> {
        let pose = self.pose(time_s)?;
        let place = pose.astern_starboard_m(position_m);
        let edge = self.window.at(place[0]);
        if self.nodes.is_empty() || edge.value == 0.0 {
            return Ok(Sample::default());
        }
        self.check_reach(place)?;
        let [cos, sin] = pose.ahead;
        let mut sample = Sample::default();
        for node in &self.nodes {
            let phase = -(node.ahead_rad_m * place[0] + node.port_rad_m * place[1]);
            let wave = node.amplitude_m * Complex64::cis(phase);
            let (z, quadrature) = (wave.re, wave.im);
            let omega = node.omega_rad_s;
            sample.height_m += z;
            sample.velocity_mps[2] += omega * quadrature;
            sample.acceleration_mps2[2] -= omega * omega * z;
            let components = [
                node.ahead_rad_m * cos - node.port_rad_m * sin,
                node.ahead_rad_m * sin + node.port_rad_m * cos,
            ];
            for (axis, component) in components.into_iter().enumerate() {
                let unit = component / node.k_rad_m;
                sample.slope[axis] -= component * quadrature;
                sample.slope_rate_per_s[axis] += component * omega * z;
                sample.velocity_mps[axis] += unit * omega * z;
                sample.acceleration_mps2[axis] += unit * omega * omega * quadrature;
                sample.displacement_m[axis] -= unit * quadrature;
            }
        }
        let speed_mps = self.course.speed_mps;
        let edge = match &self.leg {
            None => edge.moving(speed_mps),
            Some(leg) => leg.under(&edge, time_s, place[0], speed_mps),
        };
        Ok(edge.apply(&sample, pose.ahead))
    }
}
