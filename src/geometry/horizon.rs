//! The horizon of the mean sea: what the curve of the earth hides.
//!
//! The mean surface falls away as `x^2/(2 k R)` ([`Earth::drop_m`]), rays are straight (`k R`, the effective
//! radius, bends them). A ray from A to B, `d` apart along the plane and at heights `h_A`, `h_B` over that
//! surface, is at `(1 - s) h_A + s h_B - s (1 - s) d^2/(2 k R)` over it on its way (`s` from 0 to 1). It is
//! free everywhere if
//!
//! ```text
//! d <= D_A + D_B ,   D = sqrt(2 k R h)
//! ```
//!
//! **Clearance** of B from A is its height over the ray that grazes the surface at A's horizon,
//! `c = h_B - (d - D_A)^2/(2 k R)` (m; infinite before that horizon). **Weight**, on the amplitude, one way:
//! 1 for `c >= 0`, 0 for `c <= -e`, `smoothstep(1 + c/e)` between; `e` is the height over which B goes down.
//! Heights below the mean surface count as 0: within the horizon the waves hide each other
//! ([`shadow`](super::shadow)), beyond it what hides is the earth.
//!
//! Limits: geometrical optics. No diffraction beyond the horizon (at X band the field falls off over some ten
//! metres of height at 60 km), no ducts, no waves on the horizon's line but those of the map of
//! [`shadow`](super::shadow).
//!
//! ```
//! use nereus::frames::{Earth, Point};
//! use nereus::geometry::horizon;
//! let earth = Earth::Curved { radius_factor: 4.0 / 3.0 };
//! // A mast of 35 m sees the water to 24.4 km, and 100 m of height to 65.6 km.
//! assert!((horizon::distance_m(earth, [35.0, 0.0]) - 24_385.0).abs() < 1.0);
//! assert!((horizon::distance_m(earth, [35.0, 100.0]) - 65_603.0).abs() < 1.0);
//! let at = |x_m: f64, height_m: f64| Point::new(x_m, 0.0, height_m - earth.drop_m(x_m, 0.0));
//! let mast = at(0.0, 35.0);
//! assert!(horizon::clearance_m(earth, mast, at(60e3, 100.0)) > 0.0);
//! assert!(horizon::clearance_m(earth, mast, at(60e3, 0.0)) < -70.0);
//! ```

use crate::frames::{Earth, Enu, Point};
use crate::units::EARTH_RADIUS_M;

/// Height over which a target, or the antenna at the other end of a direct path, goes down behind the
/// horizon, m: smooth for pulses, sharp for a scene.
pub const POINT_EDGE_M: f64 = 1.0;

/// `2 k R`, m; `None` for a flat earth.
fn diameter_m(earth: Earth) -> Option<f64> {
    match earth {
        Earth::Flat => None,
        Earth::Curved { radius_factor } => Some(2.0 * radius_factor * EARTH_RADIUS_M),
    }
}

/// Height over the mean surface, m.
pub fn height_m(earth: Earth, point: Point<Enu>) -> f64 {
    let [x_m, y_m, z_m] = point.to_array();
    z_m + earth.drop_m(x_m, y_m)
}

/// Farthest that two points at these heights (m) see each other, m along the plane; infinite on a flat earth.
pub fn distance_m(earth: Earth, heights_m: [f64; 2]) -> f64 {
    diameter_m(earth).map_or(f64::INFINITY, |diameter_m| {
        heights_m.into_iter().map(|height_m| (diameter_m * height_m.max(0.0)).sqrt()).sum()
    })
}

/// How far apart two points are along the plane, m.
pub fn apart_m(from: Point<Enu>, to: Point<Enu>) -> f64 {
    let [[x, y, _], [x1, y1, _]] = [from, to].map(Point::to_array);
    (x1 - x).hypot(y1 - y)
}

/// Height of a point over the grazing ray from another, m; infinite before its horizon.
pub fn clearance_m(earth: Earth, from: Point<Enu>, to: Point<Enu>) -> f64 {
    let Some(diameter_m) = diameter_m(earth) else { return f64::INFINITY };
    let beyond_m = apart_m(from, to) - distance_m(earth, [height_m(earth, from), 0.0]);
    if beyond_m <= 0.0 {
        return f64::INFINITY;
    }
    height_m(earth, to).max(0.0) - beyond_m * beyond_m / diameter_m
}

/// Share of the field that passes, 0 to 1, of a clearance, m, for an edge of `edge_m`.
pub fn weight(clearance_m: f64, edge_m: f64) -> f64 {
    if clearance_m >= 0.0 {
        return 1.0;
    }
    let s = 1.0 + clearance_m / edge_m;
    // Also without an edge, and for what is no number.
    if s > 0.0 { s * s * (3.0 - 2.0 * s) } else { 0.0 }
}

/// Whether all of a rectangle of the mean surface (its lower and upper corner, m) lies within `share` of the
/// distance to the horizon of a point.
pub fn holds(earth: Earth, from: Point<Enu>, [low, high]: [[f64; 2]; 2], share: f64) -> bool {
    let [x, y, _] = from.to_array();
    let farthest_m = |at: f64, axis: usize| (at - low[axis]).abs().max((high[axis] - at).abs());
    farthest_m(x, 0).hypot(farthest_m(y, 1)) <= share * distance_m(earth, [height_m(earth, from), 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH: Earth = Earth::Curved { radius_factor: 4.0 / 3.0 };

    fn at(x_m: f64, y_m: f64, height_m: f64) -> Point<Enu> {
        Point::new(x_m, y_m, height_m - EARTH.drop_m(x_m, y_m))
    }

    /// Least height of the ray over the mean surface, by steps.
    fn least_m(a: Point<Enu>, b: Point<Enu>) -> f64 {
        let step = |i: i32| {
            let s = f64::from(i) / 10_000.0;
            height_m(EARTH, Point::from_raw(a.raw() * (1.0 - s) + b.raw() * s))
        };
        (0..=10_000).map(step).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn clearance_is_where_the_ray_meets_the_surface() {
        for (x, y) in [(0.0, 0.0), (30e3, -20e3), (-50e3, 5e3)] {
            for height in [0.0, 15.0, 35.0, 3000.0] {
                for (range, other) in [(10e3, 0.0), (24e3, 0.5), (60e3, 100.0), (60e3, 30.0), (300e3, 2000.0)]
                {
                    let (a, b) = (at(x, y, height), at(x + 0.6 * range, y - 0.8 * range, other));
                    let (there, back) = (clearance_m(EARTH, a, b), clearance_m(EARTH, b, a));
                    assert_eq!(there >= 0.0, back >= 0.0, "{x} {y} {height} {range} {other}");
                    // Steps of 1e-4 of the way miss the lowest place by range^2 1e-8/(8 k R).
                    let (least, missed) = (least_m(a, b), range * range * 1e-8 / 6e7);
                    assert_eq!(
                        there >= 0.0,
                        least >= -missed - 1e-9,
                        "{x} {y} {height} {range} {other} {least}"
                    );
                    let most = distance_m(EARTH, [height, other]);
                    assert_eq!(there >= 0.0, range <= most, "{height} {range} {other} {most}");
                }
            }
        }
    }

    #[test]
    fn weights_fall_smoothly_and_a_flat_earth_hides_nothing() {
        let weights: Vec<f64> = [1.0, 0.0, -0.25, -0.5, -0.75, -1.0, -9.0].map(|c| weight(c, 1.0)).to_vec();
        assert_eq!(weights, [1.0, 1.0, 0.84375, 0.5, 0.15625, 0.0, 0.0]);
        assert_eq!([weight(0.0, 0.0), weight(-1e-9, 0.0)], [1.0, 0.0]);
        assert_eq!([weight(f64::INFINITY, 1.0), weight(f64::NAN, 1.0)], [1.0, 0.0]);
        assert_eq!(clearance_m(Earth::Flat, at(0.0, 0.0, 1.0), at(1e6, 0.0, 0.0)), f64::INFINITY);
        let corners = [[20e3, -3e3], [24e3, 3e3]];
        assert!(holds(EARTH, at(0.0, 0.0, 35.0), corners, 1.0));
        assert!(!holds(EARTH, at(0.0, 0.0, 35.0), corners, 0.9));
        assert!(!holds(EARTH, at(0.0, 0.0, -5.0), corners, 1.0));
    }
}
