//! The main lobe of an antenna: where it is looked for what fills space.
//!
//! | pattern | main lobe |
//! | --- | --- |
//! | rectangle `a` x `b` | direction cosines `|u| <= lambda/a`, `|v| <= lambda/b` in front: to the first nulls |
//! | tapered rectangle | likewise, to its own first nulls |
//! | ellipse | `(a u)^2 + (b v)^2 <= (1.2197 lambda)^2` in front: to the first null |
//! | measured | the cone about its peak that holds all points of the grid within 20 dB of it |
//! | isotropic; measured with a floor within 20 dB | everything |

use std::f64::consts::PI;

use glam::DVec3;

use super::antenna::Antenna;

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
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
