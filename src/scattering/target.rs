//! Point targets as scatterers.
//!
//! A target moves on a straight line, `x(t) = x_0 + v t`, and has a constant scattering matrix `S[p][q]` (sqrt(m^2), p
//! received, q transmitted, order (v, h)) in the bases of [`crate::geometry::bistatic`]; `|S_pq|^2` is its radar cross section.

use crate::geometry::light_time::Mover;
use crate::scene::Target;

/// Local motion of a target, `since_start_s` after pulse 0.
///
/// ```
/// use nereus::frames::{Point, Vector};
/// use nereus::scattering::target::mover;
/// use nereus::scene::Target;
/// let buoy = Target { name: "buoy".into(), position: Point::new(0.0, 0.0, 1.0), velocity: Vector::new(2.0, 0.0, 0.0),
///     scattering: Target::sphere(10.0) };
/// assert_eq!(mover(&buoy, 3.0).position_m.to_array(), [6.0, 0.0, 1.0]);
/// ```
pub fn mover(target: &Target, since_start_s: f64) -> Mover {
    let velocity_mps = target.velocity.raw();
    Mover {
        position_m: target.position.raw() + velocity_mps * since_start_s,
        velocity_mps,
        ..Mover::default()
    }
}
