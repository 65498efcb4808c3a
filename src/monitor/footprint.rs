//! Where an antenna's main lobe meets the sea: the outline of half its gain, one way.
//!
//! The outline is found once per antenna as directions in its own frame; at a pulse they are turned by its
//! true axes and followed down to the plane of the sea at the origin. A ray that points above the horizon, or
//! meets the plane farther than [`FARTHEST`] times as far as the middle does, is cut there: the plan shows
//! where power goes, not how it falls off.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, DVec3};

use crate::frames::Vector;
use crate::pulse::AntennaRecord;
use crate::radar::antenna::Antenna;

/// Directions of an outline.
const DIRECTIONS: usize = 48;
/// How far an outline reaches, in distances of its middle.
const FARTHEST: f64 = 2.5;
/// Narrowest half width that is looked for, rad.
const NARROWEST_RAD: f64 = 1e-5;

/// An outline, as unit vectors in the antenna's frame; empty of an antenna that favours no direction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline(Vec<DVec3>);

/// What is drawn of an antenna.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Footprint {
    /// Where the boresight meets the sea, East and North, m.
    pub middle_m: Option<[f64; 2]>,
    /// Outline, East and North, m.
    pub outline_m: Vec<[f64; 2]>,
}

fn power(antenna: &Antenna, direction: DVec3) -> f64 {
    antenna.field_gain(Vector::from_raw(direction)).norm_sqr()
}

impl Outline {
    /// Of half the gain on the boresight.
    pub fn of(antenna: &Antenna) -> Self {
        let half = 0.5 * power(antenna, DVec3::X);
        let around = |step: usize| {
            let turn = TAU * step as f64 / DIRECTIONS as f64;
            let at = |theta: f64| DVec3::new(theta.cos(), theta.sin() * turn.cos(), theta.sin() * turn.sin());
            let below = |theta: f64| power(antenna, at(theta)) < half;
            let mut outer = NARROWEST_RAD;
            while !below(outer) {
                outer *= 1.1;
                if outer > FRAC_PI_2 {
                    return None;
                }
            }
            let mut inner = outer / 1.1;
            for _ in 0..20 {
                let middle = 0.5 * (inner + outer);
                *(if below(middle) { &mut outer } else { &mut inner }) = middle;
            }
            Some(at(0.5 * (inner + outer)))
        };
        Self((0..DIRECTIONS).map(around).collect::<Option<_>>().unwrap_or_default())
    }

    /// On the sea, for where the antenna is and looks.
    pub fn on_the_sea(&self, antenna: &AntennaRecord) -> Footprint {
        if self.0.is_empty() {
            return Footprint::default();
        }
        let [w, x, y, z] = antenna.boresight_quat;
        let axes = DQuat::from_xyzw(x, y, z, w);
        let from = DVec3::from_array(antenna.phase_centre_m);
        let down = |ray: DVec3| (ray.z < 0.0 && from.z > 0.0).then(|| -from.z / ray.z);
        let level = |ray: DVec3| ray.truncate().length();
        let boresight = axes * DVec3::X;
        let Some(middle) = down(boresight).map(|along| (from + along * boresight).truncate()) else {
            return Footprint::default();
        };
        let most = FARTHEST * (middle - from.truncate()).length().max(from.z);
        let on = |direction: &DVec3| {
            let ray = axes * *direction;
            let cut = most / level(ray).max(1e-9);
            let along = down(ray).map_or(cut, |along| along.min(cut));
            (from + along * ray).truncate().to_array()
        };
        Footprint { middle_m: Some(middle.to_array()), outline_m: self.0.iter().map(on).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radar::antenna::Antenna;

    /// Looking straight down from 1 km: half the gain of a uniform aperture at 0.4429 of wavelength over
    /// width.
    #[test]
    fn the_footprint_below_has_the_width_of_the_beam() {
        let antenna = Antenna::Rectangle { width_m: 2.0, height_m: 0.5, wavelength_m: 0.03 };
        let outline = Outline::of(&antenna);
        assert_eq!(outline.0.len(), DIRECTIONS);
        // x of the antenna down, y to the East: z to the ... South, by the right hand.
        let axes = DQuat::from_mat3(&glam::DMat3::from_cols(-DVec3::Z, DVec3::X, -DVec3::Y));
        let record = AntennaRecord {
            phase_centre_m: [100.0, 200.0, 1000.0],
            boresight_quat: [axes.w, axes.x, axes.y, axes.z],
            ..AntennaRecord::default()
        };
        let footprint = outline.on_the_sea(&record);
        let middle = footprint.middle_m.unwrap();
        assert!((middle[0] - 100.0).abs() < 1e-9 && (middle[1] - 200.0).abs() < 1e-9);
        let east = footprint.outline_m.iter().map(|p| p[0] - 100.0).fold(0.0, f64::max);
        let north = footprint.outline_m.iter().map(|p| p[1] - 200.0).fold(0.0, f64::max);
        let wide = |width_m: f64| 1000.0 * (0.442_946_f64 * 0.03 / width_m).asin().tan();
        assert!((east / wide(2.0) - 1.0).abs() < 1e-3, "{east}");
        assert!((north / wide(0.5) - 1.0).abs() < 1e-3, "{north}");
    }

    #[test]
    fn who_looks_up_or_everywhere_has_none() {
        let everywhere = Outline::of(&Antenna::Isotropic { gain: 1.0 });
        assert_eq!(everywhere, Outline::default());
        let antenna = Antenna::Rectangle { width_m: 2.0, height_m: 0.5, wavelength_m: 0.03 };
        let level = AntennaRecord { phase_centre_m: [0.0, 0.0, 10.0], ..AntennaRecord::default() };
        assert_eq!(Outline::of(&antenna).on_the_sea(&level), Footprint::default());
    }
}
