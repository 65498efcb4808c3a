//! Radar cross sections that depend on the aspect.
//!
//! A file has the monostatic cross section over azimuth and elevation of the radar as the target sees it:
//! azimuth `A` from the bow, positive to starboard, elevation `E` above the horizontal of its place. With
//! `u_t`, `u_r` the unit vectors from the target to both antennas it is read at their bisector:
//!
//! `b = (u_t + u_r) / |u_t + u_r|` , `A = atan2(b.s, b.f)` , `E = asin(b.z)`
//!
//! | symbol | meaning |
//! | --- | --- |
//! | `f`, `s`, `z` | forward, to starboard, up; `f = n cos psi + e sin psi`, `s = e cos psi - n sin psi` |
//! | `psi` | heading, clockwise from North `n` towards East `e` |
//!
//! What is interpolated is `sqrt(sigma)`, by the cubics of [`crate::radar::pattern`]; never below zero. The
//! matrix is that of a sphere of this cross section.
//!
//! Source: Crispin, Goodrich, Siegel, University of Michigan 2591-1-H (1959), and Kell, Proc. IEEE 53 (1965)
//! 983: the bistatic cross section is the monostatic one at the bisector, of a frequency lower by
//! `cos(beta/2)`, `beta` the bistatic angle. A table holds one frequency, so this factor is left out: lobes
//! are too narrow by it (1.5 % at 20 degrees).
//!
//! Limits: smooth convex bodies, `beta` well below 180 degrees (the forward lobe is not in a monostatic
//! table); no phase, hence no glint and no change of sign from lobe to lobe; targets that do not float stay
//! level ([`super::heave`] tilts the others).

use std::collections::HashMap;
use std::path::Path as FilePath;
use std::sync::Arc;

use glam::DVec3;

use crate::frames::{Enu, Vector};
use crate::geometry::light_time::Path;
use crate::radar::fault::RadarFault;
use crate::radar::pattern::{GridPattern, Quantity};
use crate::scene::Target;

/// The aspect of one target.
#[derive(Clone, Debug)]
pub(super) struct Aspect {
    table: Arc<GridPattern>,
    /// `None`: along the velocity.
    heading_rad: Option<f64>,
    mean_m2: f64,
}

impl Aspect {
    /// Cross section over the mean of the table, along a path; `up` is the vertical of the target's place,
    /// and it moves at the velocity.
    pub fn over_mean(&self, up: DVec3, velocity: Vector<Enu>, path: &Path) -> f64 {
        // Straight through the target there is no bisector.
        let towards = (path.scattered - path.incident).normalize_or(-path.incident);
        let north = (DVec3::Y - up * up.y).normalize_or(DVec3::Y);
        let east = north.cross(up);
        let [vx, vy, _] = velocity.to_array();
        let (sin, cos) = self.heading_rad.unwrap_or_else(|| vx.atan2(vy)).sin_cos();
        let (ahead, starboard) = (north * cos + east * sin, east * cos - north * sin);
        let azimuth_rad = towards.dot(starboard).atan2(towards.dot(ahead));
        let elevation_rad = towards.dot(up).clamp(-1.0, 1.0).asin();
        self.table.field_gain(azimuth_rad, elevation_rad).re.max(0.0).powi(2) / self.mean_m2
    }
}

/// Reads the files of targets, each once, and gives these targets the matrix of their mean; empty where none
/// has a file.
pub(super) fn open(targets: &mut [Target], faults: &mut Vec<RadarFault>) -> Vec<Option<Aspect>> {
    if targets.iter().all(|target| target.aspect.is_none()) {
        return Vec::new();
    }
    let mut tables: HashMap<(std::path::PathBuf, u64), Option<Arc<GridPattern>>> = HashMap::new();
    let mut read = |name: &str, path: &FilePath, floor_dbsm: f64| {
        let table = tables.entry((path.to_owned(), floor_dbsm.to_bits()));
        let opened = || match GridPattern::open_as(Quantity::CrossSection, path, floor_dbsm) {
            Ok(table) => Some(Arc::new(table)),
            Err(source) => {
                faults.push(RadarFault::Aspect { target: name.to_owned(), source });
                None
            }
        };
        table.or_insert_with(opened).clone()
    };
    let of = |target: &mut Target| {
        let aspect = target.aspect.as_ref()?;
        let table = read(&target.name, &aspect.path, aspect.floor_dbsm)?;
        let (heading_rad, mean_m2) = (aspect.heading_rad, table.mean_power());
        target.scattering = Target::sphere(mean_m2);
        Some(Aspect { table, heading_rad, mean_m2 })
    };
    targets.iter_mut().map(of).collect()
}
