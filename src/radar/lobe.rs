//! The main lobe of an antenna: where it is looked for what fills space.
//!
//! | pattern | main lobe |
//! | --- | --- |
//! | rectangle `a` x `b` | direction cosines `|u| <= lambda/a`, `|v| <= lambda/b` in front: to the first nulls |
//! | tapered rectangle | likewise, to its own first nulls |
//! | ellipse | `(a u)^2 + (b v)^2 <= (1.2197 lambda)^2` in front: to the first null |
//! | measured | the cone about its peak that holds all points of the grid within 20 dB of it |
//! | isotropic; measured with a floor within 20 dB | everything |

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use std::f64::consts::PI;

use glam::DVec3;

use super::antenna::Antenna;
use crate::cpu::{Task, Variant};
use crate::geometry::lanes::{Row, lanes_for};

/// First zero of `J1(pi x)`.
const FIRST_NULL: f64 = 1.219_669_891_266_504_4;
/// Power under the peak that ends the lobe of a measured pattern.
const LEAST: f64 = 0.01;

/// Directions of a main lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MainLobe {
    shape: Shape,
    solid_angle_sr: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    All,
    /// Largest direction cosines along y and z.
    Rectangle([f64; 2]),
    /// The same, of the axes of an ellipse.
    Ellipse([f64; 2]),
    /// About a direction, cosine and size of the half angle.
    Cone(DVec3, f64),
}

impl MainLobe {
    /// Of an antenna.
    pub fn of(antenna: &Antenna) -> Self {
        let aperture = |width_m: f64, height_m: f64, wavelength_m: f64, null: f64| {
            [width_m, height_m].map(|side_m| null * wavelength_m / side_m)
        };
        let (shape, solid_angle_sr) = match antenna {
            Antenna::Isotropic { .. } => (Shape::All, 4.0 * PI),
            Antenna::Rectangle { width_m, height_m, wavelength_m } => (
                Shape::Rectangle(aperture(*width_m, *height_m, *wavelength_m, 1.0)),
                wavelength_m * wavelength_m / (width_m * height_m),
            ),
            Antenna::Tapered { peak, sides, tapers } => {
                (Shape::Rectangle([0, 1].map(|n| tapers[n].null() / sides[n])), 4.0 * PI / (peak * peak))
            }
            Antenna::Ellipse { width_m, height_m, wavelength_m } => (
                Shape::Ellipse(aperture(*width_m, *height_m, *wavelength_m, FIRST_NULL)),
                wavelength_m * wavelength_m / (0.25 * PI * width_m * height_m),
            ),
            Antenna::Grid(pattern) => {
                let (points, floor) = pattern.points();
                let points: Vec<(DVec3, f64)> = points
                    .map(|([az, el], gain)| {
                        let ((sin_az, cos_az), (sin_el, cos_el)) = (az.sin_cos(), el.sin_cos());
                        (DVec3::new(cos_az * cos_el, sin_az * cos_el, sin_el), gain)
                    })
                    .collect();
                let peak =
                    points.iter().fold((DVec3::X, 0.0), |peak, own| if own.1 > peak.1 { *own } else { peak });
                let widest = points
                    .iter()
                    .filter(|(_, gain)| *gain >= LEAST * peak.1)
                    .map(|(at, _)| at.angle_between(peak.0))
                    .fold(0.0, f64::max);
                if floor >= LEAST * peak.1 {
                    (Shape::All, 4.0 * PI)
                } else {
                    (Shape::Cone(peak.0, widest), 4.0 * PI / peak.1)
                }
            }
        };
        Self { shape, solid_angle_sr: solid_angle_sr.clamp(1e-9, 4.0 * PI) }
    }

    /// Solid angle of the beam, `4 pi` over the peak of its gain, sr; of an isotropic antenna `4 pi`.
    pub fn solid_angle_sr(&self) -> f64 {
        self.solid_angle_sr
    }

    /// Width of the beam between half powers, nearly, along the narrower of its axes, rad: from the middle to
    /// the first null of an aperture, half the cone of a measured one.
    pub fn width_rad(&self) -> f64 {
        match self.shape {
            Shape::All => 2.0 * PI,
            Shape::Rectangle([u, v]) | Shape::Ellipse([u, v]) => u.min(v),
            Shape::Cone(_, half_rad) => half_rad,
        }
    }

    /// Whether a direction in the antenna frame, of any length, lies in it or within an angle of it.
    pub fn holds(&self, direction: DVec3, slack_rad: f64) -> bool {
        let Some(d) = direction.try_normalize() else { return true };
        // A cosine changes by no more than the angle.
        match self.shape {
            Shape::All => true,
            Shape::Rectangle([u, v]) => {
                d.x > -slack_rad && d.y.abs() <= u + slack_rad && d.z.abs() <= v + slack_rad
            }
            Shape::Ellipse([u, v]) => {
                // Wider than what lies within the angle of the ellipse; larger semi-axes would be narrower.
                let [y, z] = [d.y, d.z].map(|at| (at.abs() - slack_rad).max(0.0));
                d.x > -slack_rad && (y / u).hypot(z / v) <= 1.0
            }
            Shape::Cone(axis, half_rad) => d.angle_between(axis) <= half_rad + slack_rad,
        }
    }

    /// The same of unit directions side by side, in f32: multiplies by 0 where it does not.
    pub fn keep(&self, variant: Variant, count: usize, direction: &[Row; 3], slack_rad: f64, out: &mut Row) {
        let slack_rad = slack_rad as f32;
        match self.shape {
            Shape::All => {}
            Shape::Rectangle(sides) => {
                let most = sides.map(|side| side as f32 + slack_rad);
                variant.run(KeepRectangle { count, direction, most, slack_rad, out });
            }
            Shape::Ellipse(sides) => {
                let sides = sides.map(|side| side as f32);
                variant.run(KeepEllipse { count, direction, sides, slack_rad, out });
            }
            Shape::Cone(axis, half_rad) => {
                let cosine = (half_rad + f64::from(slack_rad)).min(PI).cos() as f32;
                let axis = axis.to_array().map(|c| c as f32);
                variant.run(KeepCone { count, direction, axis, cosine, out });
            }
        }
    }
}

struct KeepRectangle<'a> {
    count: usize,
    direction: &'a [Row; 3],
    most: [f32; 2],
    slack_rad: f32,
    out: &'a mut Row,
}

impl Task for KeepRectangle<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { count, direction: [x, y, z], most: [u, v], slack_rad, out } = self;
        for i in 0..lanes_for(count) {
            let held = (x[i] > -slack_rad) & (y[i].abs() <= u) & (z[i].abs() <= v);
            out[i] = if held { out[i] } else { 0.0 };
        }
    }
}

struct KeepEllipse<'a> {
    count: usize,
    direction: &'a [Row; 3],
    sides: [f32; 2],
    slack_rad: f32,
    out: &'a mut Row,
}

impl Task for KeepEllipse<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { count, direction: [x, y, z], sides: [u, v], slack_rad, out } = self;
        for i in 0..lanes_for(count) {
            let a = (y[i].abs() - slack_rad).max(0.0) / u;
            let b = (z[i].abs() - slack_rad).max(0.0) / v;
            let held = (x[i] > -slack_rad) & (a * a + b * b <= 1.0);
            out[i] = if held { out[i] } else { 0.0 };
        }
    }
}

struct KeepCone<'a> {
    count: usize,
    direction: &'a [Row; 3],
    axis: [f32; 3],
    cosine: f32,
    out: &'a mut Row,
}

impl Task for KeepCone<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { count, direction: [x, y, z], axis, cosine, out } = self;
        for i in 0..lanes_for(count) {
            let held = x[i] * axis[0] + y[i] * axis[1] + z[i] * axis[2] >= cosine;
            out[i] = if held { out[i] } else { 0.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::lanes::LANES;

    #[test]
    fn apertures_end_at_their_first_nulls() {
        let wavelength_m = 0.03;
        let at = |y: f64, z: f64| DVec3::new((1.0 - y * y - z * z).sqrt(), y, z);
        let lobe = MainLobe::of(&Antenna::Rectangle { width_m: 3.0, height_m: 0.3, wavelength_m });
        assert!(lobe.holds(at(0.0099, 0.099), 0.0) && !lobe.holds(at(0.0101, 0.0), 0.0));
        assert!(!lobe.holds(at(0.0, 0.101), 0.0) && lobe.holds(at(0.0, 0.101), 0.002));
        assert!(!lobe.holds(DVec3::NEG_X, 0.1));
        let antenna = Antenna::Ellipse { width_m: 3.0, height_m: 3.0, wavelength_m };
        let lobe = MainLobe::of(&antenna);
        let null = at(0.0, 0.012_196_7);
        assert!(antenna.field_gain(crate::frames::Vector::from_raw(null)).norm() < 1e-2);
        assert!(lobe.holds(at(0.0, 0.01219), 0.0) && !lobe.holds(at(0.0, 0.01221), 0.0));
        assert!(MainLobe::of(&Antenna::Isotropic { gain: 3.0 }).holds(DVec3::NEG_X, 0.0));
    }

    /// Side by side directions are kept as one by one, but for those within rounding of an edge.
    #[test]
    fn directions_side_by_side_are_kept_alike() {
        let wavelength_m = 0.03;
        let cone = MainLobe { shape: Shape::Cone(DVec3::new(0.8, 0.6, 0.0), 0.3), solid_angle_sr: 1.0 };
        let lobes = [
            MainLobe::of(&Antenna::Rectangle { width_m: 0.3, height_m: 0.1, wavelength_m }),
            MainLobe::of(&Antenna::Ellipse { width_m: 0.3, height_m: 0.1, wavelength_m }),
            MainLobe::of(&Antenna::Isotropic { gain: 1.0 }),
            cone,
        ];
        for (lobe, slack_rad) in lobes.iter().flat_map(|lobe| [(lobe, 0.0), (lobe, 0.05)]) {
            let mut direction = [[0.0; LANES]; 3];
            let mut held = 0;
            for i in 0..LANES {
                let (a, b) = ((i as f64 * 0.618).fract() * 6.0 - 3.0, (i as f64 / 256.0 - 0.5) * 2.0);
                let d = DVec3::new(a.cos() * b.cos(), a.sin() * b.cos(), b.sin());
                (0..3).for_each(|c| direction[c][i] = d[c] as f32);
                held += usize::from(lobe.holds(d, slack_rad));
            }
            let mut out = [2.0; LANES];
            lobe.keep(Variant::fastest(), LANES, &direction, slack_rad, &mut out);
            for (i, out) in out.into_iter().enumerate() {
                let d = DVec3::from_array([0, 1, 2].map(|c| f64::from(direction[c][i])));
                assert_eq!(out, if lobe.holds(d, slack_rad) { 2.0 } else { 0.0 }, "{lobe:?} {d}");
            }
            assert!(held > 0);
        }
    }
}
