//! Meshes of ships: triangles by which hull and superstructure echo.
//!
//! Axes are those of the ship: x forward of midship, y to port, z up from the design waterline, metres.
//! Triangles run counter-clockwise as seen from outside.
//!
//! The hull above the waterline follows from its offset table, which ends there: sides straight up from the
//! design waterline to the freeboard, a deck, and a transom (or a blunt bow) where the table does not close.
//! Between stations the waterline is that of the table ([`crate::scene::hull`]). What stands on it comes from
//! a file ([`mod@file`]), scaled with the hull. No edge of what is made is longer than asked: an echo is put
//! at the delay of its triangle's centroid, and a curve is as round as its panels are small.
//!
//! ```
//! use nereus::scene::hull::Hull;
//! use nereus::scene::mesh;
//! let hull = Hull::wigley(100.0, 10.0, 6.25)?;
//! let triangles = mesh::of_hull(&hull, 5.0, 2.0)?;
//! let highest = triangles.iter().flatten().map(|corner| corner.z).fold(0.0, f64::max);
//! assert_eq!(highest, 5.0);
//! assert!(triangles.len() > 1000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod fault;
pub mod file;
mod orientation;

use glam::DVec3;

pub use fault::{MeshError, MeshFault};

use crate::scene::hull::Hull;

/// Most panels of a ship.
pub const MOST_PANELS: usize = 100_000;
/// Most panels of all ships of a scene.
pub const MOST_OF_SCENE: usize = 200_000;
/// Longest file, bytes.
pub const MOST_BYTES: u64 = 1 << 26;
/// Most triangles of a file.
pub const MOST_TRIANGLES: usize = 100_000;
/// Farthest corner from midship, m.
pub const MOST_M: f64 = 1000.0;
/// Freeboard over the length of a hull, unless it is given.
pub const FREEBOARD_RATIO: f64 = 0.05;

/// Corners of a triangle, m.
pub type Triangle = [DVec3; 3];

/// The hull above its design waterline.
///
/// # Errors
/// More panels than [`MOST_PANELS`].
pub fn of_hull(hull: &Hull, freeboard_m: f64, panel_m: f64) -> Result<Vec<Triangle>, MeshError> {
    let line = waterline(hull, panel_m);
    let mut made = Vec::new();
    let mut quad = |corners: [DVec3; 4], outwards: DVec3| {
        let [a, b, c, d] = corners;
        for triangle in [[a, b, c], [a, c, d]] {
            let across = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
            if across.dot(outwards) > 0.0 {
                made.push(triangle);
            } else if across.dot(outwards) < 0.0 {
                made.push([triangle[0], triangle[2], triangle[1]]);
            }
        }
    };
    let at = |[x, y]: [f64; 2], side: f64, z: f64| DVec3::new(x, side * y, z);
    for ends in line.windows(2) {
        let &[fore, aft] = ends else { continue };
        for side in [1.0, -1.0] {
            let along = [at(fore, side, 0.0), at(aft, side, 0.0)];
            let [e, f] = along.map(|low| low + DVec3::Z * freeboard_m);
            quad([along[0], along[1], f, e], DVec3::Y * side);
            let middle = [DVec3::new(fore[0], 0.0, freeboard_m), DVec3::new(aft[0], 0.0, freeboard_m)];
            quad([middle[0], middle[1], f, e], DVec3::Z);
        }
    }
    for (end, outwards) in [(line.first(), DVec3::X), (line.last(), DVec3::NEG_X)] {
        if let Some(end) = end {
            let [a, b] = [1.0, -1.0].map(|side| at(*end, side, 0.0));
            let [c, d] = [-1.0, 1.0].map(|side| at(*end, side, freeboard_m));
            quad([a, b, c, d], outwards);
        }
    }
    divided(made, panel_m).ok_or(MeshError::TooMany { panel_m })
}

/// Places along the design waterline from bow to stern: forward of midship and half-breadth, m.
fn waterline(hull: &Hull, panel_m: f64) -> Vec<[f64; 2]> {
    let stations = hull.stations_m();
    let breadth = |i: usize| hull.half_breadths_m(i).last().copied().unwrap_or(0.0);
    let mut line = Vec::new();
    for first in (0..stations.len().saturating_sub(2)).step_by(2) {
        let (x, y) = ([0, 1, 2].map(|i| stations[first + i]), [0, 1, 2].map(|i| breadth(first + i)));
        let parabola = |at: f64| {
            let of = |i: usize, j: usize, k: usize| {
                y[i] * (at - x[j]) * (at - x[k]) / ((x[i] - x[j]) * (x[i] - x[k]))
            };
            (of(0, 1, 2) + of(1, 0, 2) + of(2, 0, 1)).max(0.0)
        };
        for part in 0..2 {
            // Edges of the side are the diagonals of its quads, so half the panel along the waterline will
            // do.
            let wide_m = x[part + 1] - x[part];
            let count = (wide_m / panel_m).ceil().clamp(1.0, MOST_PANELS as f64);
            let places = (0..count as usize).map(|n| x[part] + wide_m * n as f64 / count);
            line.extend(places.map(|at| [-at, parabola(at)]));
        }
    }
    if let Some(last) = stations.len().checked_sub(1) {
        line.push([-stations[last], breadth(last)]);
    }
    line
}

/// Lowest and highest coordinates of triangles along each axis, m; `None` of none.
pub fn extents_m(of: &[Triangle]) -> Option<[[f64; 2]; 3]> {
    let corners = || of.iter().flatten();
    let low = corners().copied().reduce(DVec3::min)?.to_array();
    let high = corners().copied().reduce(DVec3::max)?.to_array();
    Some([0, 1, 2].map(|axis| [low[axis], high[axis]]))
}

/// Triangles without an edge longer than asked; `None` of more than [`MOST_PANELS`].
pub fn divided(mut open: Vec<Triangle>, panel_m: f64) -> Option<Vec<Triangle>> {
    let mut done = Vec::new();
    open.reverse();
    while let Some([a, b, c]) = open.pop() {
        let edges = [(b - a).length(), (c - b).length(), (a - c).length()];
        let longest = edges.iter().copied().fold(0.0, f64::max);
        if longest <= panel_m {
            done.push([a, b, c]);
        } else {
            // The longest edge is halved: neighbours halve it alike.
            let [a, b, c] = if longest == edges[0] {
                [a, b, c]
            } else if longest == edges[1] {
                [b, c, a]
            } else {
                [c, a, b]
            };
            let middle = 0.5 * (a + b);
            open.extend([[middle, b, c], [a, middle, c]]);
        }
        if done.len() + open.len() > MOST_PANELS {
            return None;
        }
    }
    Some(done)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(of: &[Triangle], count: impl Fn(DVec3) -> bool) -> f64 {
        of.iter()
            .map(|[a, b, c]| (*b - *a).cross(*c - *a))
            .filter(|across| count(across.normalize()))
            .map(|across| 0.5 * across.length())
            .sum()
    }

    /// A Wigley hull: its deck is two thirds of length times beam, its sides face outwards and close.
    #[test]
    fn a_hull_is_closed_but_for_its_bottom() {
        let hull = Hull::wigley(100.0, 10.0, 6.25).unwrap();
        let mesh = of_hull(&hull, 5.0, 1.0).unwrap();
        let deck = area(&mesh, |n| n.z > 0.99);
        assert!((deck - 2.0 / 3.0 * 1000.0).abs() < 0.2, "{deck}");
        // The vectors of a closed surface add up to nothing: the bottom is missing.
        let sum: DVec3 = mesh.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a)).sum();
        assert!((sum - DVec3::Z * deck).length() < 1e-9, "{sum}");
        let longest = mesh.iter().flat_map(|[a, b, c]| [(*b - *a), (*c - *b), (*a - *c)]);
        assert!(longest.map(DVec3::length).fold(0.0, f64::max) <= 1.0);
        for [a, b, c] in &mesh {
            let across = (*b - *a).cross(*c - *a);
            assert!(across.z > 0.0 || across.y * (a.y + b.y + c.y) > 0.0);
        }
    }

    #[test]
    fn too_many_panels_are_refused() {
        let hull = Hull::wigley(1000.0, 100.0, 60.0).unwrap();
        let text = of_hull(&hull, 50.0, 0.05).unwrap_err().to_string();
        assert!(text.contains("more than 100000 panels"), "{text}");
    }
}
