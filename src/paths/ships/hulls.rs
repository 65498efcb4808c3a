//! What ships that echo hide of the sea.
//!
//! A facet is hidden from an antenna where the straight line between them meets a ship ([`Shade`]). Only
//! facets in the outline of the box about the mesh, as the antenna throws it on the lowest facet, are asked.
//!
//! Limits: a facet is hidden as its centre is; no diffraction.

use std::sync::Arc;

use glam::DVec3;

use super::body::Body;
use super::pose::Pose;
use super::shade::Shade;
use crate::frames::SceneFrame;
use crate::scene::Patch;

/// How much farther than the patch a shadow is followed: the outline about what is thrown so far is a chord.
const BEYOND: f64 = 1.5;

/// The ships of a scene, as they hide its sea.
#[derive(Clone, Debug)]
pub(in crate::paths) struct Hulls {
    bodies: Arc<[Body]>,
    frame: SceneFrame,
}

impl Hulls {
    pub(super) fn new(bodies: Arc<[Body]>, frame: SceneFrame) -> Self {
        Self { bodies, frame }
    }

    /// Hands over the facets of a patch, by their places in arrays over it, that ships hide from a place at a
    /// time after pulse 0; `heights_m` are theirs in the frame of the scene.
    pub fn hide(
        &self,
        time_s: f64,
        place: DVec3,
        patch: &Patch,
        heights_m: &[f64],
        mut each: impl FnMut(usize),
    ) {
        let lowest_m = heights_m.iter().copied().fold(f64::INFINITY, f64::min);
        for body in self.bodies.iter() {
            let pose = body.sailing().pose(&self.frame, time_s);
            let shade = body.shade();
            let to_body = |at: DVec3| pose.axes.transpose() * (at - pose.origin_m);
            let antenna_m = to_body(place);
            let outline = Outline::of(shade, &pose, place, patch, lowest_m);
            for row in 0..patch.facets[1] {
                let y_m = patch.centre_m([0, patch.first[1] + row as i64])[1];
                for column in outline.columns(patch, y_m) {
                    let index = row * patch.facets[0] + column;
                    let [x_m, _] = patch.centre_m([patch.first[0] + column as i64, 0]);
                    if shade.between(to_body(DVec3::new(x_m, y_m, heights_m[index])), antenna_m) {
                        each(index);
                    }
                }
            }
        }
    }
}

/// Outside of the convex hull of these places nothing is hidden.
struct Outline {
    /// East and North, m: corners of the box, and where they are thrown.
    places_m: [[[f64; 2]; 2]; 8],
    /// Everything may be.
    whole: bool,
}

impl Outline {
    fn of(shade: &Shade, pose: &Pose, place: DVec3, patch: &Patch, lowest_m: f64) -> Self {
        let last = [0, 1].map(|i| patch.first[i] + patch.facets[i] as i64 - 1);
        let ends = [patch.centre_m(patch.first), patch.centre_m(last)];
        let most = |i: usize, at: f64| ends.iter().map(|end| (end[i] - at).abs()).fold(0.0, f64::max);
        let farthest_m = BEYOND * most(0, place.x).hypot(most(1, place.y));
        let off = pose.origin_m - place;
        let whole = off.x.hypot(off.y) < 2.0 * shade.radius_m && off.length() < 8.0 * shade.radius_m;
        let thrown = |corner: &DVec3| {
            let at = pose.origin_m + pose.axes * *corner;
            let way = at - place;
            let most = (farthest_m / way.x.hypot(way.y).max(f64::MIN_POSITIVE)).max(1.0);
            let reach = if way.z < 0.0 { ((lowest_m - place.z) / way.z).clamp(1.0, most) } else { most };
            [[at.x, at.y], [place.x + way.x * reach, place.y + way.y * reach]]
        };
        Self { places_m: shade.corners_m.each_ref().map(thrown), whole }
    }

    /// Columns of the patch within, in the row at a place north.
    fn columns(&self, patch: &Patch, y_m: f64) -> std::ops::Range<usize> {
        if self.whole {
            return 0..patch.facets[0];
        }
        let half_m = 0.5 * patch.facet_m;
        let (low_m, high_m) = (y_m - half_m, y_m + half_m);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        let places_m = self.places_m.as_flattened();
        for (n, a) in places_m.iter().enumerate() {
            for b in &places_m[n..] {
                let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
                if a[1] > high_m || b[1] < low_m {
                    continue;
                }
                let at = |y: f64| {
                    let share = if b[1] > a[1] { ((y - a[1]) / (b[1] - a[1])).clamp(0.0, 1.0) } else { 0.0 };
                    a[0] + share * (b[0] - a[0])
                };
                for x in [at(low_m), at(high_m), if b[1] > a[1] { at(low_m) } else { b[0] }] {
                    (least, most) = (least.min(x), most.max(x));
                }
            }
        }
        if least > most {
            return 0..0;
        }
        // Casts saturate.
        let column = |x: f64| x / patch.facet_m - patch.first[0] as f64;
        let first = (column(least) - 0.5).floor().max(0.0) as usize;
        let after = (column(most) + 1.5).ceil().max(0.0) as usize;
        first.min(patch.facets[0])..after.min(patch.facets[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Earth;
    use crate::paths::ships::Ships;
    use crate::rng::cases::some_of;
    use crate::scene::Ship;
    use crate::scene::mesh::divided;
    use crate::scene::ship::HullGiven;

    /// Without a bottom, as hulls are: 20 m long, 8 m broad, 5 m high.
    fn hulls(heading_rad: f64) -> Hulls {
        let at = |n: usize| {
            let side = |bit: usize, half: f64| if n >> bit & 1 == 1 { half } else { -half };
            DVec3::new(side(0, 10.0), side(1, 4.0), if n >> 2 & 1 == 1 { 5.0 } else { 0.0 })
        };
        let faces = [[0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5], [4, 5, 7, 6]];
        let panels = faces
            .iter()
            .flat_map(|[a, b, c, d]| [[at(*a), at(*b), at(*c)], [at(*a), at(*c), at(*d)]])
            .collect();
        let ship = Ship {
            name: "box".to_owned(),
            hull: HullGiven::Wigley { beam_m: 8.0, draught_m: 3.0 },
            length_m: Some(20.0),
            // Lines of sight run along edges of panels.
            position_m: [3.0, -2.0],
            heading_rad,
            speed_mps: 4.0,
            kelvin: None,
            turbulent: None,
            echo: false,
            mesh: Default::default(),
            trajectory: None,
            panels: divided(panels, 3.0).unwrap().into(),
        };
        let frame = SceneFrame::plain(Earth::Flat);
        Ships::new(&[ship], [1, 1], None).hulls(frame).unwrap()
    }

    fn hidden(hulls: &Hulls, place: DVec3, patch: &Patch, height_m: f64) -> Vec<[f64; 2]> {
        let (heights_m, mut found) = (vec![height_m; patch.len()], Vec::new());
        hulls.hide(0.0, place, patch, &heights_m, |index| found.push(patch.centre_m(patch.key(index))));
        found
    }

    /// The shadow of a box on calm water: its waterplane, and behind it `h/tan` of the grazing angle, within
    /// a facet; heights of the water move its end, and nothing shines under the hull.
    #[test]
    fn a_shadow_is_as_long_as_the_grazing_angle_asks() {
        let (hulls, patch) = (hulls(0.0), Patch::new([400.0, 300.0], 1.0, [0.0, 0.0]).unwrap());
        for (grazing_deg, height_m) in
            some_of([(10.0, -1.0), (3.0f64, 0.0), (10.0, 0.7), (10.0, 0.0), (40.0, 0.0)])
        {
            // From the South, far away: behind is North.
            let (sin, cos) = grazing_deg.to_radians().sin_cos();
            let found = hidden(&hulls, DVec3::new(3.0, -1e6 * cos, 1e6 * sin), &patch, height_m);
            let length_m = (5.0 - height_m) * cos / sin;
            // Midship at (3, -2), bow to the East.
            let north_m = [-6.0, 2.0 + length_m];
            let (mut inside, mut wrong) = (0, 0);
            for index in 0..patch.len() {
                let [x, y] = patch.centre_m(patch.key(index));
                let within = |slack: f64| {
                    (x - 3.0).abs() < 10.0 + slack && y > north_m[0] - slack && y < north_m[1] + slack
                };
                inside += usize::from(within(0.0));
                let is = found.contains(&[x, y]);
                wrong += usize::from(is != within(0.0) && (!within(0.6) || within(-0.6)));
            }
            assert_eq!(wrong, 0, "{grazing_deg} {height_m}");
            assert!(
                inside > 150 && found.len().abs_diff(inside) < 2 * (20 + length_m as usize),
                "{grazing_deg}"
            );
        }
    }

    /// The outline leaves nothing out: the same facets as with every one asked, from all sides, low and high.
    #[test]
    fn no_facet_is_left_out() {
        let patch = Patch::new([160.0, 120.0], 2.0, [10.0, 5.0]).unwrap();
        for (n, heading_rad) in [0.0, 0.4, 2.1].into_iter().enumerate() {
            let hulls = hulls(heading_rad);
            for bearing in 0..8 {
                let (sin, cos) = (f64::from(bearing) * 0.8 + 0.1).sin_cos();
                for (far_m, high_m) in [(70.0, 3.0), (150.0, 6.0), (2000.0, 30.0), (60.0, 200.0), (5.0, 30.0)]
                {
                    let place = DVec3::new(3.0 + far_m * cos, -2.0 + far_m * sin, high_m);
                    let height = |index: usize| 0.8 * (index as f64 * 0.7 + n as f64).sin();
                    let heights_m: Vec<f64> = (0..patch.len()).map(height).collect();
                    let mut found = Vec::new();
                    hulls.hide(0.0, place, &patch, &heights_m, |index| found.push(index));
                    let body = &hulls.bodies[0];
                    let pose = body.sailing().pose(&hulls.frame, 0.0);
                    let own = |at: DVec3| pose.axes.transpose() * (at - pose.origin_m);
                    let all: Vec<usize> = (0..patch.len())
                        .filter(|index| {
                            let [x, y] = patch.centre_m(patch.key(*index));
                            let at = DVec3::new(x, y, heights_m[*index]);
                            body.shade().between(own(at), own(place))
                        })
                        .collect();
                    assert_eq!(found, all, "{heading_rad} {bearing} {far_m}");
                    assert!(found.len() >= 30);
                }
            }
        }
    }
}
