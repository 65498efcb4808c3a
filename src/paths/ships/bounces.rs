//! Between which planes of a ship a wave bounces.
//!
//! Rays of a few hundred fixed directions are followed from every panel to the plane that they meet, so the
//! list depends on the mesh alone: neither on the run's length nor on where its antennas are. Where more are
//! met than are kept, those met from the most directions are.

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::TAU;

use glam::DVec3;

use crate::geometry::occlusion::Triangles;
use crate::scattering::physical_optics::{Panel, reflected};

/// Panels whose normals differ by no more, and whose centroids lie no farther off each other's plane, m, are
/// of one plane.
const ONE_PLANE: [f64; 2] = [1e-4, 1e-3];
/// Angles above the horizon from which waves come, degrees, and how many directions about.
const ELEVATIONS_DEG: [f64; 6] = [0.5, 3.0, 8.0, 18.0, 35.0, 60.0];
const BEARINGS: u32 = 48;

/// A panel, one of the plane that its mirror image meets, and the mean place there, m.
pub(super) type Pair = (u32, u32, DVec3);

/// Which plane every panel lies in: a panel of it.
pub(super) fn planes(panels: &[Panel]) -> Vec<u32> {
    let [turned, off_m] = ONE_PLANE;
    let farthest_m = panels.iter().map(|panel| panel.centroid_m().length()).fold(0.0, f64::max);
    // Normals and distances from midship; cells several times as wide as what is joined.
    let within = [turned, turned, turned, off_m + turned * farthest_m];
    let mut known: HashMap<[i64; 4], Vec<u32>> = HashMap::new();
    let mut planes: Vec<u32> = Vec::with_capacity(panels.len());
    for (n, panel) in (0u32..).zip(panels) {
        let [x, y, z] = panel.normal().to_array();
        let place = [x, y, z, panel.normal().dot(panel.centroid_m())];
        let cell = |i: usize, side: f64| ((place[i] + side * within[i]) / (8.0 * within[i])).floor() as i64;
        let joins = |other: &&u32| {
            let other = &panels[**other as usize];
            let apart_m = panel.centroid_m() - other.centroid_m();
            (panel.normal() - other.normal()).length() <= turned && apart_m.dot(other.normal()).abs() <= off_m
        };
        let cells = (0..16).map(|sides| [0, 1, 2, 3].map(|i| cell(i, f64::from(sides >> i & 1) * 2.0 - 1.0)));
        let found = cells.filter_map(|cell| known.get(&cell)).flatten().filter(joins).min().copied();
        planes.push(found.unwrap_or_else(|| {
            known.entry([0, 1, 2, 3].map(|i| cell(i, 0.0))).or_default().push(n);
            n
        }));
    }
    planes
}

/// Where a wave goes on to from a panel: a panel, and the place.
pub(super) fn met(panels: &[Panel], triangles: &Triangles, panel: u32, along: DVec3) -> Option<(u32, DVec3)> {
    let of = &panels[panel as usize];
    if along.dot(of.normal()) >= 0.0 {
        return None;
    }
    let on = reflected(along, of.normal());
    let (second, far_m) = triangles.first(of.centroid_m(), on, Some(panel))?;
    let faces = on.dot(panels[second as usize].normal()) < 0.0;
    faces.then(|| (second, of.centroid_m() + on * far_m))
}

/// All pairs, no more than `most`.
pub(super) fn pairs(panels: &[Panel], planes: &[u32], triangles: &Triangles, most: usize) -> Vec<Pair> {
    let directions: Vec<DVec3> = (0..BEARINGS)
        .flat_map(|bearing| {
            // Off the axes, along which the planes of ships run.
            let (sin, cos) = ((f64::from(bearing) + 0.5) * TAU / f64::from(BEARINGS)).sin_cos();
            ELEVATIONS_DEG.map(|above_deg| {
                let (up, level) = above_deg.to_radians().sin_cos();
                -DVec3::new(level * cos, level * sin, up)
            })
        })
        .collect();
    let of_panel = |panel: u32| {
        let mut found: BTreeMap<u32, (u32, DVec3)> = BTreeMap::new();
        for (second, at_m) in directions.iter().filter_map(|along| met(panels, triangles, panel, *along)) {
            let (count, sum) = found.entry(planes[second as usize]).or_default();
            (*count, *sum) = (*count + 1, *sum + at_m);
        }
        found.into_iter().map(move |(second, (count, sum))| (count, (panel, second, sum / f64::from(count))))
    };
    let mut found: Vec<(u32, Pair)> = (0..panels.len() as u32).flat_map(of_panel).collect();
    if found.len() > most {
        found.sort_by_key(|(count, (panel, second, _))| (std::cmp::Reverse(*count), *panel, *second));
        found.truncate(most);
        found.sort_by_key(|(_, (panel, second, _))| (*panel, *second));
    }
    found.into_iter().map(|(_, pair)| pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Panels of one wall whose normals differ by rounding about any value are of one plane; those a step off
    /// it, or turned, are not.
    #[test]
    fn planes_are_joined_by_tolerance() {
        for turn in 0..200 {
            let at = |x: f64, off: f64| {
                let (sin, cos) = (0.013 * f64::from(turn)).sin_cos();
                let place = |along: f64, up: f64| {
                    // Five figures, as files have them.
                    let rounded = |x: f64| (x * 1e5).round() / 1e5;
                    DVec3::new(
                        rounded(along * cos - (30.0 + off) * sin),
                        rounded(along * sin + (30.0 + off) * cos),
                        up,
                    )
                };
                Panel::new([place(x, 0.0), place(x + 1.0, 0.0), place(x, 1.0)]).unwrap()
            };
            let panels: Vec<Panel> = [(0.0, 0.0), (1.0, 0.0), (5.0, 0.0), (5.0, 0.05), (-4.0, 0.0)]
                .map(|(x, off)| at(x, off))
                .into();
            assert_eq!(planes(&panels), [0, 0, 0, 3, 0], "{turn}");
        }
        let plate = |tilt: f64| Panel::new([DVec3::ZERO, DVec3::X, DVec3::new(0.0, 1.0, tilt)]).unwrap();
        assert_eq!(planes(&[plate(0.0), plate(1e-3), plate(5e-5)]), [0, 1, 0]);
    }
}
