//! Which side of a mesh is outside.
//!
//! Triangles that share a corner are one part. Along an edge, as many triangles run one way as the other, but
//! for one at a border; a difference of two means that neighbours disagree. A part of area `A` is inside out
//! where
//!
//! `V = 1/3 sum (c - C).n dA < -0.02 A^1.5` ,
//!
//! `c` the centroids, `n` the normals, `C` the mean of the centroids by area: the volume of a closed part; of
//! an open one about what it encloses (a cube without a bottom has 0.08 of `A^1.5`), which a sheet, a dish or
//! a railing does not reach. Such parts face where their corners say.

use std::collections::HashMap;

use glam::DVec3;

use super::{MeshFault, Triangle};

/// Volume over the area to 1.5 above which a part encloses something.
const LEAST_VOLUME: f64 = 0.02;

type Corner = [u64; 3];

fn key(corner: DVec3) -> Corner {
    // Zero has two signs.
    corner.to_array().map(|x| (x + 0.0).to_bits())
}

/// What is wrong with the orientation of triangles.
pub(super) fn faults(triangles: &[Triangle]) -> Vec<MeshFault> {
    let mut edges: HashMap<(Corner, Corner), (i32, usize)> = HashMap::new();
    let mut parts = Parts { parent: (0..triangles.len()).collect() };
    let mut owner: HashMap<Corner, usize> = HashMap::new();
    for (n, triangle) in triangles.iter().enumerate() {
        let keys = triangle.map(key);
        for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (keys[i], keys[j])) {
            let (edge, way) = if from < to { ((from, to), 1) } else { ((to, from), -1) };
            let balance = edges.entry(edge).or_insert((0, n));
            balance.0 += way;
        }
        for corner in keys {
            let other = *owner.entry(corner).or_insert(n);
            parts.join(other, n);
        }
    }
    let mut found = Vec::new();
    let odd: Vec<usize> = edges.values().filter(|(balance, _)| balance.abs() > 1).map(|(_, n)| *n).collect();
    if let Some(first) = odd.iter().min() {
        found.push(MeshFault::Orientation { count: odd.len(), first: first + 1 });
        return found;
    }
    // Area, its moment, sum of centroid times normal and area, sum of normal and area.
    let mut sums: HashMap<usize, (f64, DVec3, f64, DVec3)> = HashMap::new();
    for (n, [a, b, c]) in triangles.iter().enumerate() {
        let (normal, centroid) = (0.5 * (*b - *a).cross(*c - *a), (*a + *b + *c) / 3.0);
        let area = normal.length();
        let sum = sums.entry(parts.root(n)).or_default();
        *sum = (sum.0 + area, sum.1 + area * centroid, sum.2 + centroid.dot(normal), sum.3 + normal);
    }
    let inside_out = |(area, moment, flux, vector): &(f64, DVec3, f64, DVec3)| {
        let volume = (flux - (*moment / *area).dot(*vector)) / 3.0;
        volume < -LEAST_VOLUME * area.powf(1.5)
    };
    let wrong: Vec<usize> = sums.iter().filter(|(_, sum)| inside_out(sum)).map(|(root, _)| *root).collect();
    if let Some(first) = wrong.iter().min() {
        found.push(MeshFault::InsideOut { count: wrong.len(), first: first + 1 });
    }
    found
}

/// Sets that are joined; the root of each is its first triangle.
struct Parts {
    parent: Vec<usize>,
}

impl Parts {
    fn root(&mut self, mut n: usize) -> usize {
        while self.parent[n] != n {
            self.parent[n] = self.parent[self.parent[n]];
            n = self.parent[n];
        }
        n
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b);
    }
}
