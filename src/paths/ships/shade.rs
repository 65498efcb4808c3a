//! What of one ship hides the sea: its mesh, and its walls below the waterline.
//!
//! The side of the hull is taken straight down from the waterline, so that no line passes under a hull that
//! waves have lifted, and what lies under its waterplane is hidden from everywhere.

use glam::DVec3;

use crate::geometry::occlusion::Triangles;
use crate::scattering::physical_optics::Panel;

/// Corners nearer to the waterline are on it, m.
const ON_WATERLINE_M: f64 = 1e-6;

/// What of one ship hides the sea, in its own axes.
#[derive(Debug)]
pub(super) struct Shade {
    triangles: Triangles,
    /// The box about its panels.
    pub corners_m: [DVec3; 8],
    pub radius_m: f64,
}

impl Shade {
    pub fn new(panels: &[Panel]) -> Self {
        let mut corners: Vec<[DVec3; 3]> = panels.iter().map(Panel::corners_m).collect();
        let all = || corners.iter().flatten().copied();
        let (low, high) =
            (all().fold(DVec3::INFINITY, DVec3::min), all().fold(DVec3::NEG_INFINITY, DVec3::max));
        let radius_m = all().map(DVec3::length).fold(0.0, f64::max);
        let down = DVec3::new(0.0, 0.0, -radius_m);
        let edges = corners.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        let on = |at: &DVec3| at.z.abs() < ON_WATERLINE_M;
        let walls: Vec<_> = edges
            .filter(|ends| ends.iter().all(on))
            .flat_map(|[a, b]| [[a, b, b + down], [a, b + down, a + down]])
            .collect();
        corners.extend(walls);
        let corner = |n: usize| {
            let of = |axis: usize| if n >> axis & 1 == 1 { high[axis] } else { low[axis] };
            DVec3::new(of(0), of(1), of(2))
        };
        Self { triangles: Triangles::new(&corners), corners_m: std::array::from_fn(corner), radius_m }
    }

    /// Whether it stands between two places, in its own axes.
    pub fn between(&self, from_m: DVec3, to_m: DVec3) -> bool {
        let way = to_m - from_m;
        let far_m = way.length();
        self.triangles.meets_within(from_m, way / far_m, far_m, None)
    }
}
