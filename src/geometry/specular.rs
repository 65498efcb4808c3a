//! Where the mean sea reflects the ray between two points as a mirror does.
//!
//! The mean surface falls away as `x^2/(2 a)`, `a = k R` the effective radius ([`Earth::drop_m`]). Of two
//! points at heights `h_1`, `h_2` over it, `d` apart along it, the specular point is `r_1` from the first and
//! `r_2 = d - r_1` from the second, where both see it at one grazing angle `psi`:
//!
//! `h_1/r_1 - r_1/(2 a) = h_2/r_2 - r_2/(2 a) = tan psi`
//!
//! `r_1 = d/2 - p sin(xi/3)` , `p = 2/sqrt(3) sqrt(a (h_1 + h_2) + d^2/4)` , `sin xi = 2 a d (h_2 - h_1)/p^3`
//!
//! and a step of Newton's. The reflected ray is as long as the straight one from the first point's **mirror
//! image** in the tangent plane there, `L^2 = R^2 + 4 H_1 H_2` with `R` the distance and `H` the heights over
//! that plane. `L` is stationary about the specular point (Fermat), so that its rate with a fixed plane is
//! the rate with a plane that moves along. A curved surface spreads the rays; the field has the
//! **divergence**
//!
//! `D = (1 + 2 r_1 r_2/(a d sin psi))^(-1/2)` , 1 on a flat earth, 0 at the horizon.
//!
//! Sources: Kerr (ed.), Propagation of Short Radio Waves, MIT Radiation Laboratory Series 13 (1951), 2.12 and
//! 5.4; Blake, Radar Range-Performance Analysis (1980), ch. 6.
//!
//! Limits: one specular point; no diffraction where it comes near the horizon (`D` there is that of
//! geometrical optics). A point below the mean surface counts as on it.
//!
//! ```
//! use nereus::frames::{Earth, Point};
//! use nereus::geometry::specular::Specular;
//! let (mast, buoy) = (Point::new(0.0, 0.0, 30.0), Point::new(800.0, 0.0, 10.0));
//! let found = Specular::of(Earth::Flat, mast, buoy).unwrap();
//! assert!((found.point.to_array()[0] - 600.0).abs() < 1e-9 && found.divergence == 1.0);
//! assert!((found.grazing_sine - 40.0 / 800f64.hypot(40.0)).abs() < 1e-12);
//! ```

use glam::DVec3;

use crate::frames::{Earth, Enu, Point, Vector};
use crate::geometry::horizon;
use crate::motion::pointing::PhaseCentre;
use crate::units::EARTH_RADIUS_M;

/// A mirror between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specular {
    /// Where the ray is reflected.
    pub point: Point<Enu>,
    /// Unit normal of the surface there.
    pub normal: DVec3,
    /// Sine of the grazing angle.
    pub grazing_sine: f64,
    /// What the curve of the earth leaves of the field: 0 to 1.
    pub divergence: f64,
}

impl Specular {
    /// Between an antenna and a target; `None` beyond the horizon.
    pub fn of(earth: Earth, antenna: Point<Enu>, target: Point<Enu>) -> Option<Self> {
        let [of_antenna, of_target] = [antenna, target].map(|point| horizon::height_m(earth, point));
        // The surface sinks with what is below it.
        let sunk_m = of_antenna.min(of_target).min(0.0);
        let (h1, h2, d) = (of_antenna - sunk_m, of_target - sunk_m, horizon::apart_m(antenna, target));
        let radius_m = match earth {
            Earth::Flat => None,
            Earth::Curved { radius_factor } => Some(radius_factor * EARTH_RADIUS_M),
        };
        let r1 = first_leg_m(radius_m, [h1, h2], d);
        let share = if d > 0.0 { r1 / d } else { 0.0 };
        let [[x, y, _], [to_x, to_y, _]] = [antenna, target].map(Point::to_array);
        let (x, y) = (x + (to_x - x) * share, y + (to_y - y) * share);
        let [fall_x, fall_y] = earth.drop_slope(x, y);
        let point = Point::new(x, y, sunk_m - earth.drop_m(x, y));
        let normal = DVec3::new(fall_x, fall_y, 1.0).normalize();
        let over_m = |of: Point<Enu>| normal.dot(of.raw() - point.raw());
        let (first_m, second_m) = (over_m(antenna), over_m(target).max(0.0));
        if first_m.is_nan() || first_m <= 0.0 {
            return None;
        }
        let straight = (target.raw() - antenna.raw()).length_squared();
        let grazing_sine = (first_m + second_m) / (straight + 4.0 * first_m * second_m).sqrt();
        let spread = match radius_m {
            Some(radius_m) if d > 0.0 => 2.0 * r1 * (d - r1) / (radius_m * d * grazing_sine),
            _ => 0.0,
        };
        let divergence = (1.0 + spread).sqrt().recip();
        Some(Self { point, normal, grazing_sine: grazing_sine.min(1.0), divergence })
    }

    /// A direction after the reflection.
    pub fn turned(&self, direction: DVec3) -> DVec3 {
        direction - 2.0 * self.normal * self.normal.dot(direction)
    }

    /// The mirror image of an antenna.
    pub fn image(&self, of: &PhaseCentre) -> PhaseCentre {
        let place = self.point.raw() + self.turned(of.position.raw() - self.point.raw());
        PhaseCentre {
            position: Point::from_raw(place),
            velocity: Vector::from_raw(self.turned(of.velocity.raw())),
            acceleration: Vector::from_raw(self.turned(of.acceleration.raw())),
        }
    }
}

/// How far the specular point is from the first of two points at heights over the surface, m.
fn first_leg_m(radius_m: Option<f64>, [h1, h2]: [f64; 2], d: f64) -> f64 {
    let Some(a) = radius_m else {
        return if h1 + h2 > 0.0 { d * h1 / (h1 + h2) } else { 0.5 * d };
    };
    let p = 2.0 / 3f64.sqrt() * (a * (h1 + h2) + 0.25 * d * d).sqrt();
    if p == 0.0 {
        return 0.0;
    }
    let sine = (2.0 * a * d * (h2 - h1) / p.powi(3)).clamp(-1.0, 1.0);
    let mut r = (0.5 * d - p * (sine.asin() / 3.0).sin()).clamp(0.0, d);
    for _ in 0..2 {
        let off = 2.0 * a * (h1 * d - (h1 + h2) * r) + r * (d - r) * (d - 2.0 * r);
        let slope = 6.0 * r * (r - d) + d * d - 2.0 * a * (h1 + h2);
        let next = r - off / slope;
        if (0.0..=d).contains(&next) {
            r = next;
        }
    }
    r
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::light_time::{LightTime, bistatic};

    const EARTH: Earth = Earth::Curved { radius_factor: 4.0 / 3.0 };

    fn at(earth: Earth, x_m: f64, y_m: f64, height_m: f64) -> Point<Enu> {
        Point::new(x_m, y_m, height_m - earth.drop_m(x_m, y_m))
    }

    const CASES: [[f64; 3]; 6] = [
        [3e3, 30.0, 2.0],
        [20e3, 30.0, 5.0],
        [20e3, 15.0, 300.0],
        [800.0, 3000.0, 10.0],
        [100e3, 3000.0, 20.0],
        [30e3, 30.0, 30.0],
    ];

    #[test]
    fn the_reflected_ray_is_the_shortest_by_the_surface() {
        for [d, h1, h2] in CASES {
            for earth in [EARTH, Earth::Flat] {
                let (a, b) = (at(earth, 2e3, -4e3, h1), at(earth, 2e3 + 0.6 * d, -4e3 - 0.8 * d, h2));
                let by = |share: f64| {
                    let [from, to] = [a.raw(), b.raw()];
                    let (x, y) = (from.x + (to.x - from.x) * share, from.y + (to.y - from.y) * share);
                    let over = at(earth, x, y, 0.0).raw();
                    (over - from).length() + (to - over).length()
                };
                // Golden section: a length is flat about its least, so 1e-8 of the way is all there is.
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..80 {
                    let [one, two] = [0.381_966, 0.618_034].map(|cut| low + (high - low) * cut);
                    if by(one) < by(two) { high = two } else { low = one }
                }
                let found = Specular::of(earth, a, b).unwrap();
                let end = found.image(&PhaseCentre::at_rest(a)).position.raw();
                let mirrored = (b.raw() - end).length();
                assert!((mirrored - by(low)).abs() < 1e-9 * d, "{d} {h1} {h2}: {mirrored} {}", by(low));
                let reached = horizon::apart_m(a, found.point) / d;
                assert!((reached - low).abs() < 1e-3, "{d} {h1} {h2}: {reached} {low}");
            }
        }
    }

    /// Two rays a little apart in elevation, traced to the surface and on to the target.
    #[test]
    fn divergence_is_the_spread_of_traced_rays() {
        for [d, h1, h2] in CASES {
            let found = Specular::of(EARTH, at(EARTH, 0.0, 0.0, h1), at(EARTH, d, 0.0, h2)).unwrap();
            // Height at the target of a ray that falls by `slope`, on a surface of that curve.
            let landed = |slope: f64, a: f64| {
                let r = a * (slope - (slope * slope - 2.0 * h1 / a).sqrt());
                // The normal turns by r/a: the ray by twice as much.
                let up = (slope.atan() - 2.0 * (r / a).atan()).tan();
                h1 - slope * r + up * (d - r)
            };
            let [x, _, z] = found.point.to_array();
            let (slope, a) = ((h1 - z) / x, 4.0 / 3.0 * EARTH_RADIUS_M);
            let h = 1e-5 * slope;
            let spread = (landed(slope + h, a) - landed(slope - h, a)) / (2.0 * h);
            let traced = (d / spread).sqrt();
            println!("{d} {h1} {h2}: divergence {:.4}, traced {traced:.4}", found.divergence);
            // Rays stay low over all of these but the steep one, where there is nothing to spread them.
            assert!((found.divergence / traced - 1.0).abs() < 0.02, "{d} {h1} {h2}");
        }
    }

    #[test]
    fn a_point_on_the_water_meets_its_mirror_image_and_the_horizon_ends_it() {
        for height in [0.0, -0.5] {
            let (a, b) = (at(EARTH, 0.0, 0.0, 30.0), at(EARTH, 5e3, 0.0, height));
            let found = Specular::of(EARTH, a, b).unwrap();
            let image = found.image(&PhaseCentre::at_rest(a)).position.raw();
            let (longer, straight) = ((b.raw() - image).length(), (b.raw() - a.raw()).length());
            assert!((longer - straight).abs() < 1e-6 && found.divergence > 0.999, "{longer} {straight}");
        }
        let most_m = horizon::distance_m(EARTH, [30.0, 5.0]);
        let over = |d: f64| Specular::of(EARTH, at(EARTH, 0.0, 0.0, 30.0), at(EARTH, d, 0.0, 5.0));
        assert!(over(0.9999 * most_m).unwrap().divergence < 0.1);
        assert_eq!(over(1.0001 * most_m), None);
        let end = at(EARTH, 0.0, 0.0, 30.0);
        assert!(Specular::of(EARTH, end, at(EARTH, 0.0, 0.0, 3.0)).unwrap().grazing_sine == 1.0);
        assert_eq!(
            Specular::of(Earth::Flat, at(Earth::Flat, 0.0, 0.0, 0.0), Point::new(9.0, 0.0, 0.0)),
            None
        );
    }

    /// Both ends move: against a difference of delays whose specular points are found again.
    #[test]
    fn the_rate_of_the_reflected_path_is_that_of_its_delay() {
        let end = |s: f64| PhaseCentre {
            position: at(EARTH, 200.0 * s, 0.0, 3000.0) + Vector::new(0.0, 0.0, 10.0 * s),
            velocity: Vector::new(200.0, 0.0, 10.0 - 200.0 * EARTH.drop_slope(200.0 * s, 0.0)[0]),
            acceleration: Vector::ZERO,
        };
        let velocity = Vector::new(-5.0, 3.0, 0.5);
        let path = |s: f64| {
            let (tx, place) = (end(s), Point::new(30e3, 0.0, -40.0) + velocity * s);
            let image = Specular::of(EARTH, tx.position, place).unwrap().image(&tx);
            bistatic(LightTime::Exact, &image, place, velocity, &tx)
        };
        let h = 0.05;
        let slope = (path(h).delay_s - path(-h).delay_s) / (2.0 * h);
        // 1 m/s and a stationary length: of the rate, 1.3e-6, nine digits.
        assert!((slope - path(0.0).delay_rate).abs() < 1e-14, "{slope} {}", path(0.0).delay_rate);
    }
}
