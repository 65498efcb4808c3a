//! What a ray meets first among triangles: a tree of boxes.
//!
//! Triangles are split at the median of their centroids along the longest side of the box about them, down to
//! four of them; a ray visits the boxes that it crosses. Whether it crosses a triangle is found by
//! Moller and Trumbore, J. Graphics Tools 2 (1997) 21.
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
/// A ray starts this far off its own triangle, m.
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
        self.follow(from, along, own, |n, far| {
            if found.is_none_or(|(_, least)| far < least) {
                found = Some((n, far));
            }
            false
        });
        found
    }

    /// Whether a ray meets anything.
    pub fn meets(&self, from: DVec3, along: DVec3, own: Option<u32>) -> bool {
        let mut met = false;
        self.follow(from, along, own, |_, _| {
            met = true;
            true
        });
        met
    }

    fn follow(&self, from: DVec3, along: DVec3, own: Option<u32>, mut each: impl FnMut(u32, f64) -> bool) {
        let inverse = along.recip();
        let mut open = [0u32; 64];
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let place = open[count];
            let node = &self.nodes[place as usize];
            let (a, b) = ((node.low - from) * inverse, (node.high - from) * inverse);
            let (enters, leaves) = (a.min(b).max_element(), a.max(b).min_element());
            if leaves < enters.max(0.0) {
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
                let far = crossing(&self.corners[*n as usize], from, along);
                if far.is_some_and(|far| far > OFF_M && each(*n, far)) {
                    return;
                }
            }
        }
    }
}

/// How far along a ray a triangle is.
fn crossing([a, b, c]: &[DVec3; 3], from: DVec3, along: DVec3) -> Option<f64> {
    let (u, v) = (*b - *a, *c - *a);
    let across = along.cross(v);
    let volume = u.dot(across);
    let off = from - *a;
    let p = off.dot(across) / volume;
    let up = off.cross(u);
    let q = along.dot(up) / volume;
    // Written so that no number (a ray along the plane) is no crossing.
    (p >= 0.0 && q >= 0.0 && p + q <= 1.0).then(|| v.dot(up) / volume)
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
            let all = (0..).zip(&corners).filter_map(|(n, own)| Some((n, crossing(own, from, along)?)));
            let nearest = all.filter(|(_, far)| *far > OFF_M).min_by(|a, b| a.1.total_cmp(&b.1));
            assert_eq!(triangles.first(from, along, None), nearest);
            assert_eq!(triangles.meets(from, along, None), nearest.is_some());
            hits += usize::from(nearest.is_some());
        }
        assert!((50..450).contains(&hits), "{hits}");
        assert_eq!(Triangles::new(&[]).first(DVec3::ZERO, DVec3::X, None), None);
    }
}
