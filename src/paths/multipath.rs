//! Targets over a sea that reflects: three more paths each.
//!
//! A ray between antenna and target also goes by the specular point of the mean sea
//! ([`crate::geometry::specular`]): with the transmitter's and the receiver's ray there are four ways, each a
//! scatterer path with a delay, a rate and directions of its own. The reflected field is, in the bases of
//! [`crate::geometry::bistatic`] about the ray before and after,
//!
//! `[v, h] -> D rho [R_v v, R_h h]`
//!
//! with Fresnel's coefficients at the grazing angle ([`crate::scattering::fresnel`]), the roughness factor
//! `rho` ([`crate::scattering::roughness`]) and the divergence `D`. The matrix of the target is the same for
//! all four; its aspect, the crests and the horizon before it are those of the straight rays.
//!
//! Limits: the coherent field of the mean sea; bases about the vertical of the scene where the ray is
//! reflected (a turn of 1e-3 rad at 10 km); nothing between sea and sea, ships or the direct path.

use glam::DVec3;
use num_complex::Complex64;

use crate::frames::{Earth, Enu, Point, Vector};
use crate::geometry::light_time::{LightTime, Path, bistatic};
use crate::geometry::specular::Specular;
use crate::motion::pointing::PhaseCentre;
use crate::scattering::fresnel::reflection;
use crate::scattering::roughness::coherent;
use crate::scene::Target;

/// Which rays of a path are reflected: the transmitter's, the receiver's.
const WAYS: [[bool; 2]; 3] = [[true, false], [false, true], [true, true]];

/// The sea as a mirror.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mirror {
    pub earth: Earth,
    pub permittivity: Complex64,
    pub height_rms_m: f64,
    pub wave_number_rad_m: f64,
}

/// A path of a target by the mirror.
#[derive(Clone, Copy, Debug)]
pub(super) struct Image {
    pub target: usize,
    ways: [bool; 2],
}

/// What the mirror does to one path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounce {
    /// Direction of the ray at the transmitter, and at the receiver.
    pub at_antennas: [DVec3; 2],
    /// What it leaves of `[v, h]`, of either ray.
    pub leaves: [[Complex64; 2]; 2],
}

/// The images of all targets over a sea that reflects.
pub(super) fn images(targets: &[Target]) -> Vec<Image> {
    let reflected = targets.iter().enumerate().filter(|(_, target)| target.multipath);
    reflected.flat_map(|(target, _)| WAYS.map(|ways| Image { target, ways })).collect()
}

impl Mirror {
    /// The path of an image between two antennas, of a target at a place and with a velocity.
    pub fn path(
        &self,
        image: &Image,
        [tx, rx]: [&PhaseCentre; 2],
        position: Point<Enu>,
        velocity: Vector<Enu>,
    ) -> (Path, Bounce) {
        let by = |end: &PhaseCentre, way: bool| way.then(|| Specular::of(self.earth, end.position, position));
        let [by_tx, by_rx] = [by(tx, image.ways[0]), by(rx, image.ways[1])];
        let end = |end: &PhaseCentre, by: Option<Option<Specular>>| match by.flatten() {
            Some(specular) => specular.image(end),
            None => *end,
        };
        let path = bistatic(LightTime::Exact, &end(tx, by_tx), position, velocity, &end(rx, by_rx));
        let at = |direction: DVec3, by: Option<Option<Specular>>| match by.flatten() {
            Some(specular) => specular.turned(direction),
            None => direction,
        };
        let at_antennas = [at(path.incident, by_tx), at(path.scattered, by_rx)];
        (path, Bounce { at_antennas, leaves: [self.leaves(by_tx), self.leaves(by_rx)] })
    }

    /// What is left of `[v, h]` of a ray: all of a straight one, nothing beyond the horizon.
    fn leaves(&self, by: Option<Option<Specular>>) -> [Complex64; 2] {
        let Some(specular) = by else { return [Complex64::ONE; 2] };
        let Some(Specular { grazing_sine, divergence, .. }) = specular else { return [Complex64::ZERO; 2] };
        let share = divergence * coherent(self.wave_number_rad_m, self.height_rms_m, grazing_sine);
        let of = reflection(self.permittivity, grazing_sine);
        [of.v * share, of.h * share]
    }
}
