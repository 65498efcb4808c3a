//! What a ray meets first among triangles: a tree of boxes.
//!
//! Triangles are split at the median of their centroids along the longest side of the box about them, down to
//! four of them; a ray visits the boxes that it crosses. Whether it crosses a triangle is found by
//! Woop, Benthin and Wald, J. Comput. Graph. Techniques 2 (2013) 65: on which side of an edge a ray passes is
//! the same for both triangles that share it, so none slips through between them.
//!
//! ```
//! use glam::DVec3;
//! use nereus::geometry::occlusion::Triangles;
//! let wall = [DVec3::new(5.0, -1.0, -1.0), DVec3::new(5.0, 3.0, -1.0), DVec3::new(5.0, -1.0, 3.0)];
//! let triangles = Triangles::new(&[wall]);
//! let found = triangles.first(DVec3::ZERO, DVec3::X, None);
//! assert_eq!(found, Some((0, 5.0)));
//! assert_eq!(triangles.first(DVec3::ZERO, DVec3::NEG_X, None), None);
//! assert_eq!(triangles.first(DVec3::ZERO, DVec3::X, Some(0)), None);
//! ```

use glam::DVec3;

/// Triangles of a leaf, at most.
const LEAF: usize = 4;
/// A ray starts this far off its own triangle, m, and boxes are as much larger than what is in them: rays
/// along their sides are within.
const OFF_M: f64 = 1e-6;

#[derive(Clone, Copy, Debug)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// Of a leaf, its triangles; of others, where the second child is (the first follows).
    first: u32,
    count: u32,
}

/// Triangles among which rays are followed.
#[derive(Clone, Debug, Default)]
pub struct Triangles {
    corners: Vec<[DVec3; 3]>,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

impl Triangles {
    /// Of corners, m.
    pub fn new(corners: &[[DVec3; 3]]) -> Self {
        let mut built =
            Self { corners: corners.to_vec(), order: (0..corners.len() as u32).collect(), nodes: Vec::new() };
        if !corners.is_empty() {
            built.split(0, corners.len());
        }
        built
    }

    fn split(&mut self, from: usize, to: usize) {
        let centre = |of: &[DVec3; 3]| of[0] + of[1] + of[2];
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut least, mut most) = (low, high);
        for n in &self.order[from..to] {
            let corners = &self.corners[*n as usize];
            for corner in corners {
                (low, high) = (low.min(*corner), high.max(*corner));
            }
            (least, most) = (least.min(centre(corners)), most.max(centre(corners)));
        }
        let place = self.nodes.len();
        let (low, high) = (low - DVec3::splat(OFF_M), high + DVec3::splat(OFF_M));
        self.nodes.push(Node { low, high, first: from as u32, count: (to - from) as u32 });
        if to - from <= LEAF {
            return;
        }
        let wide = most - least;
        let axis = if wide.x >= wide.y.max(wide.z) {
            0
        } else if wide.y >= wide.z {
            1
        } else {
            2
        };
        let middle = (to - from) / 2;
        let corners = &self.corners;
        let key = |n: &u32| centre(&corners[*n as usize])[axis];
        self.order[from..to].select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
        self.split(from, from + middle);
        let second = self.nodes.len() as u32;
        self.split(from + middle, to);
        (self.nodes[place].first, self.nodes[place].count) = (second, 0);
    }

    /// The first triangle that a ray meets, and how far along; `from` is on the triangle `own`, which it
    /// leaves.
    pub fn first(&self, from: DVec3, along: DVec3, own: Option<u32>) -> Option<(u32, f64)> {
        let mut found: Option<(u32, f64)> = None;
        self.follow((from, along), f64::INFINITY, own, |n, far| {
            if found.is_none_or(|(_, least)| far < least) {
                found = Some((n, far));
            }
            false
        });
        found
    }

    /// Whether a ray meets anything.
    pub fn meets(&self, from: DVec3, along: DVec3, own: Option<u32>) -> bool {
        self.meets_within(from, along, f64::INFINITY, own)
    }

    /// Whether a ray meets anything before it has gone so far.
    pub fn meets_within(&self, from: DVec3, along: DVec3, far_m: f64, own: Option<u32>) -> bool {
        let mut met = false;
        self.follow((from, along), far_m, own, |_, far| {
            met = far < far_m;
            met
        });
        met
    }

    /// Hands over what a ray meets and how far along, and perhaps what lies farther than asked, until `each`
    /// says that it wants no more.
    fn follow(
        &self,
        (from, along): (DVec3, DVec3),
        within_m: f64,
        own: Option<u32>,
        mut each: impl FnMut(u32, f64) -> bool,
    ) {
        let (ray, inverse) = (Ray::new(from, along), along.recip());
        let mut open = [0u32; 64];
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let place = open[count];
            let node = &self.nodes[place as usize];
            let (a, b) = ((node.low - from) * inverse, (node.high - from) * inverse);
            let (enters, leaves) = (a.min(b).max_element(), a.max(b).min_element());
            if leaves < enters.max(0.0) || enters > within_m {
                continue;
            }
            if node.count == 0 {
                // Halves: 2^62 triangles would be needed for a deeper tree.
                open[count] = node.first;
                open[count + 1] = place + 1;
                count += 2;
                continue;
            }
            for n in &self.order[node.first as usize..(node.first + node.count) as usize] {
                if Some(*n) == own {
                    continue;
                }
                let far = ray.crosses(&self.corners[*n as usize]);
                if far.is_some_and(|far| far > OFF_M && each(*n, far)) {
                    return;
                }
            }
        }
    }
}

/// A ray, with the shear that makes it the third axis.
struct Ray {
    from: DVec3,
    /// Axes: the one along which it runs most is the third.
    axes: [usize; 3],
    shear: [f64; 3],
}

impl Ray {
    fn new(from: DVec3, along: DVec3) -> Self {
        let size = along.abs();
        let third = if size.x >= size.y.max(size.z) {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let axes = [(third + 1) % 3, (third + 2) % 3, third];
        let main = along[third];
        Self { from, axes, shear: [along[axes[0]] / main, along[axes[1]] / main, main.recip()] }
    }

    /// A corner, off the ray and along it: triangles that share it have the same.
    #[inline(always)]
    fn sheared(&self, corner: DVec3) -> [f64; 3] {
        let ([x, y, z], [shear_x, shear_y, shear_z]) = (self.axes, self.shear);
        let off = corner - self.from;
        [off[x] - shear_x * off[z], off[y] - shear_y * off[z], shear_z * off[z]]
    }

    /// How far along a triangle is.
    #[inline(always)]
    fn crosses(&self, corners: &[DVec3; 3]) -> Option<f64> {
        let (a, b, c) = (self.sheared(corners[0]), self.sheared(corners[1]), self.sheared(corners[2]));
        // Of an edge that is run the other way about the sign is the other, to the last bit.
        let (u, v) = (c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0]);
        let w = b[0] * a[1] - b[1] * a[0];
        let whole = u + v + w;
        let within = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        // Where it is nothing the ray runs along the plane.
        (within && whole != 0.0).then(|| (u * a[2] + v * b[2] + w * c[2]) / whole)
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::rng::{Room, stream};

    /// The tree finds what trying every triangle finds.
    #[test]
    fn trees_find_what_trying_all_finds() {
        let mut numbers = stream(7, Room::TargetFluctuation, 0, 0);
        let mut at =
            |scale: f64| DVec3::from_array([(); 3].map(|()| scale * (numbers.random::<f64>() - 0.5)));
        let corners: Vec<[DVec3; 3]> = (0..500)
            .map(|_| {
                let place = at(10.0);
                [(); 3].map(|()| place + at(1.0))
            })
            .collect();
        let triangles = Triangles::new(&corners);
        let mut hits = 0;
        for _ in 0..500 {
            let (from, along) = (at(12.0), at(1.0).normalize());
            let ray = Ray::new(from, along);
            let all = (0..).zip(&corners).filter_map(|(n, own)| Some((n, ray.crosses(own)?)));
            let nearest = all.filter(|(_, far)| *far > OFF_M).min_by(|a, b| a.1.total_cmp(&b.1));
            assert_eq!(triangles.first(from, along, None), nearest);
            assert_eq!(triangles.meets(from, along, None), nearest.is_some());
            for share in [0.3, 0.999, 1.001, 4.0] {
                let far_m = share * nearest.map_or(5.0, |(_, far)| far);
                let met = nearest.is_some_and(|(_, far)| far < far_m);
                assert_eq!(triangles.meets_within(from, along, far_m, None), met);
            }
            hits += usize::from(nearest.is_some());
        }
        assert!((50..450).contains(&hits), "{hits}");
        assert_eq!(Triangles::new(&[]).first(DVec3::ZERO, DVec3::X, None), None);
    }

    /// No ray slips through between triangles: a fan about a point that rays aim at, and at its edges.
    #[test]
    fn edges_and_corners_let_no_ray_through() {
        let mut numbers = stream(9, Room::TargetFluctuation, 0, 0);
        let mut at =
            |scale: f64| DVec3::from_array([(); 3].map(|()| scale * (numbers.random::<f64>() - 0.5)));
        for _ in 0..300 {
            // A ring about the middle, in the plane across a direction.
            let (middle, along) = (at(20.0), at(1.0).normalize());
            let (u, v) = along.any_orthonormal_pair();
            let rim: Vec<DVec3> = (0..7)
                .map(|n| {
                    let (sin, cos) = (f64::from(n) * std::f64::consts::TAU / 7.0).sin_cos();
                    middle + (1.3 * u + 0.1 * along) * cos + v * sin
                })
                .collect();
            let fan: Vec<[DVec3; 3]> = (0..7).map(|n| [middle, rim[n], rim[(n + 1) % 7]]).collect();
            let triangles = Triangles::new(&fan);
            let from = middle - 40.0 * along + at(10.0);
            for spoke in &rim {
                for share in [0.0, 0.3, 0.9] {
                    let to = middle + (*spoke - middle) * share;
                    assert!(triangles.meets(from, (to - from).normalize(), None), "{from} {to}");
                }
            }
        }
    }

    /// Rays along the axes of a mesh that has its edges there, as a ship's have on its centre line.
    #[test]
    fn rays_along_the_sides_of_boxes_meet_what_is_there() {
        let (low, high) = (DVec3::new(2.0, -1.0, 0.0), DVec3::new(2.0, 1.0, 3.0));
        let corner = |y: f64, z: f64| DVec3::new(2.0, y, z);
        // A wall of two, and the same again above.
        let wall = |z: f64| {
            [
                [corner(low.y, z), corner(high.y, z), corner(high.y, z + 3.0)],
                [corner(low.y, z), corner(high.y, z + 3.0), corner(low.y, z + 3.0)],
            ]
        };
        let triangles = Triangles::new(&[wall(0.0), wall(3.0)].concat());
        for y in [-1.0, -0.5, 0.0, 1.0] {
            for z in [0.0, 1.5, 3.0, 4.5, 6.0] {
                assert!(triangles.meets(DVec3::new(-7.0, y, z), DVec3::X, None), "{y} {z}");
            }
        }
        assert!(!triangles.meets(DVec3::new(-7.0, 0.0, 6.1), DVec3::X, None));
    }
}
