//! No waves ahead of the bow.
//!
//! The integral over free waves alone is symmetric fore and aft: it has waves ahead of the ship that no ship
//! makes. Height z and horizontal displacement D are multiplied by a raised cosine of the distance x astern
//! of midship,
//!
//! `w = 0` for `x <= -L/2`, `(1 + sin(pi x/L))/2` between, `1` for `x >= L/2`,
//!
//! which moves with the ship. A wake may also have an end ([`Window::fading`]): there the window falls from 1
//! to 0 as a raised cosine, far astern, where real waves are lost among others. All else follows from `w z`
//! and `w D` by the product rule, the rate of the window included (`dx/dt = V` at a fixed place,
//! `grad x = -f`):
//!
//! | field | value |
//! | --- | --- |
//! | slope | `w grad z - f w' z` |
//! | velocity | `w u + w' V (D, z)` |
//! | acceleration | `w a + 2 w' V u + w'' V^2 (D, z)` |
//! | rate of the slope | `w grad u_z + w' V grad z - f (w' u_z + w'' V z)` |
//!
//! So D and z stay the time integrals of the velocity everywhere, and one scatterer path serves for delay and
//! Doppler. Limits: the waves are those of the far field, good from about two lengths astern; nearer they are
//! plausible, not exact. `w''` jumps at both ends of the ship, so acceleration and slope rate do, by
//! `pi^2/(2 L^2)` times `V^2 z` and `V z`.
//!
//! ```
//! use nereus::sea::wake::Upstream;
//! let edge = Upstream::RaisedCosine.window(100.0);
//! assert_eq!((edge.at(-50.0).value, edge.at(0.0).value, edge.at(50.0).value), (0.0, 0.5, 1.0));
//! assert_eq!(Upstream::Symmetric.window(100.0).at(-1e3).value, 1.0);
//! ```

use std::f64::consts::{PI, TAU};

use crate::sea::surface::Sample;
use crate::sea::surface::fields::Real;

/// What stands ahead of a ship.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Upstream {
    /// Nothing: a raised cosine over the length of the ship.
    #[default]
    RaisedCosine,
    /// The mirror image, as the integral has it: for checks of the integral.
    Symmetric,
}

impl Upstream {
    /// The window of a ship of a length, m.
    pub fn window(self, length_m: f64) -> Window {
        match self {
            Self::RaisedCosine => Window { half_m: 0.5 * length_m, fade_m: None },
            Self::Symmetric => Window { half_m: f64::NEG_INFINITY, fade_m: None },
        }
    }
}

/// A window on the distance astern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Half length of the ship, m; minus infinity for no window.
    half_m: f64,
    /// Where waves begin to fade and where none are left, m astern of midship.
    fade_m: Option<[f64; 2]>,
}

/// Parts of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// All waves.
    Open,
    /// None, ahead.
    Ahead,
    /// None, astern.
    Astern,
    /// They begin, about the ship.
    Bow,
    /// They fade.
    End,
}

/// A window and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// `w`.
    pub value: f64,
    /// `w'`, 1/m.
    pub rate_per_m: f64,
    /// `w''`, 1/m^2.
    pub bend_per_m2: f64,
}

impl Window {
    /// Half the width of the edge, m; minus infinity without a window.
    pub fn half_m(&self) -> f64 {
        self.half_m
    }

    /// The same with an end: waves fade from one distance astern of midship to another, m, both astern of the
    /// stern.
    pub fn fading(self, fade_m: Option<[f64; 2]>) -> Self {
        Self { fade_m, ..self }
    }

    /// Where waves begin to fade and where none are left, m astern of midship.
    pub fn fade_m(&self) -> Option<[f64; 2]> {
        self.fade_m
    }

    /// At a distance astern of midship, m.
    pub fn at(&self, astern_m: f64) -> Edge {
        self.rounded_at::<f64>(astern_m)
    }

    /// The same with cosines that are as good as numbers of some type: in f32 5e-7.
    #[inline]
    pub fn rounded_at<T: Real>(&self, astern_m: f64) -> Edge {
        match self.part(astern_m) {
            Part::Open => Edge::OPEN,
            Part::Ahead | Part::Astern => Edge::CLOSED,
            Part::Bow => self.bow::<T>(astern_m),
            Part::End => self.end::<T>(astern_m),
        }
    }

    /// Where a distance astern of midship lies.
    #[inline]
    pub fn part(&self, astern_m: f64) -> Part {
        match self.fade_m {
            Some([_, to_m]) if astern_m >= to_m => Part::Astern,
            Some([from_m, _]) if astern_m > from_m => Part::End,
            _ if self.half_m < 0.0 || astern_m >= self.half_m => Part::Open,
            _ if astern_m <= -self.half_m => Part::Ahead,
            _ => Part::Bow,
        }
    }

    /// The edge about the ship.
    #[inline(always)]
    pub fn bow<T: Real>(&self, astern_m: f64) -> Edge {
        let scale = 0.5 * PI / self.half_m;
        let [cos, sin] = cos_sin::<T>(scale * astern_m);
        Edge {
            value: 0.5 + 0.5 * sin,
            rate_per_m: 0.5 * scale * cos,
            bend_per_m2: -0.5 * scale * scale * sin,
        }
    }

    /// The edge where waves fade.
    #[inline(always)]
    pub fn end<T: Real>(&self, astern_m: f64) -> Edge {
        let [from_m, to_m] = self.fade_m.unwrap_or([0.0, 1.0]);
        let scale = PI / (to_m - from_m);
        let [cos, sin] = cos_sin::<T>(scale * (astern_m - from_m));
        Edge {
            value: 0.5 + 0.5 * cos,
            rate_per_m: -0.5 * scale * sin,
            bend_per_m2: -0.5 * scale * scale * cos,
        }
    }
}

#[inline(always)]
fn cos_sin<T: Real>(phase_rad: f64) -> [f64; 2] {
    let (cos, sin) = T::cos_sin_of_turns(phase_rad / TAU);
    [cos.widen(), sin.widen()]
}

impl Edge {
    /// No window.
    pub const OPEN: Self = Self { value: 1.0, rate_per_m: 0.0, bend_per_m2: 0.0 };
    /// No waves.
    pub const CLOSED: Self = Self { value: 0.0, rate_per_m: 0.0, bend_per_m2: 0.0 };

    /// The window of a ship of speed V, m/s, with its rates at a fixed place.
    #[inline(always)]
    pub fn moving(&self, speed_mps: f64) -> Moving {
        let bend_per_m_s = self.bend_per_m2 * speed_mps;
        Moving {
            value: self.value,
            rate_per_m: self.rate_per_m,
            rate_per_s: self.rate_per_m * speed_mps,
            bend_per_m_s,
            bend_per_s2: bend_per_m_s * speed_mps,
        }
    }

    /// Waves under the window, for a ship of speed V, m/s, with a unit vector ahead.
    pub fn apply(&self, waves: &Sample, speed_mps: f64, ahead: [f64; 2]) -> Sample {
        self.moving(speed_mps).apply(waves, ahead)
    }
}

/// A window on the distance x astern and on time, and its derivatives by x and by the time at a fixed place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving {
    /// `w`.
    pub value: f64,
    /// By x, 1/m.
    pub rate_per_m: f64,
    /// By time, 1/s.
    pub rate_per_s: f64,
    /// By both, 1/(m s).
    pub bend_per_m_s: f64,
    /// By time twice, 1/s^2.
    pub bend_per_s2: f64,
}

impl Moving {
    /// The product of two.
    #[inline(always)]
    pub fn times(&self, other: &Self) -> Self {
        let (a, b) = (self, other);
        Self {
            value: a.value * b.value,
            rate_per_m: a.rate_per_m * b.value + a.value * b.rate_per_m,
            rate_per_s: a.rate_per_s * b.value + a.value * b.rate_per_s,
            bend_per_m_s: a.bend_per_m_s * b.value
                + a.rate_per_m * b.rate_per_s
                + a.rate_per_s * b.rate_per_m
                + a.value * b.bend_per_m_s,
            bend_per_s2: a.bend_per_s2 * b.value
                + 2.0 * a.rate_per_s * b.rate_per_s
                + a.value * b.bend_per_s2,
        }
    }

    /// Waves under the window, with a unit vector ahead.
    pub fn apply(&self, waves: &Sample, ahead: [f64; 2]) -> Sample {
        let Self { value: w, rate_per_m, rate_per_s: rate, bend_per_m_s: bend, bend_per_s2 } = *self;
        let z = waves.height_m;
        let uz = waves.velocity_mps[2];
        let [dx, dy] = waves.displacement_m;
        let path = [dx, dy, z];
        let mut sample = Sample { height_m: w * z, ..Sample::default() };
        for (axis, along) in path.into_iter().enumerate() {
            let u = waves.velocity_mps[axis];
            sample.velocity_mps[axis] = w * u + rate * along;
            sample.acceleration_mps2[axis] =
                w * waves.acceleration_mps2[axis] + 2.0 * rate * u + bend_per_s2 * along;
        }
        for (axis, f) in ahead.into_iter().enumerate() {
            let s = waves.slope[axis];
            sample.displacement_m[axis] = w * path[axis];
            sample.slope[axis] = w * s - f * rate_per_m * z;
            sample.slope_rate_per_s[axis] =
                w * waves.slope_rate_per_s[axis] + rate * s - f * (rate_per_m * uz + bend * z);
        }
        sample
    }
}
