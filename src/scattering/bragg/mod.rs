//! Bragg waves that travel: random phases of facets with the Doppler of the waves that scatter.
//!
//! Of the roughness within a facet those waves scatter whose wave vector is `+K_B` or `-K_B`, `K_B` the part of
//! `q = k (k_s - k_i)` in the plane ([`spm`](super::spm)); `q` points towards the antennas. A wave along
//! `+K_B` comes closer and raises the frequency by `omega(K_B)`, one along `-K_B` lowers it. So a Bragg
//! phasor of a facet is the sum of two **lines**,
//!
//! | line | middle | share of the power |
//! | --- | --- | --- |
//! | advancing | `+omega_B + q.u` | `Psi(K_B) / [Psi(K_B) + Psi(-K_B)]` ([`share`]) |
//! | receding | `-omega_B + q.u` | the rest |
//!
//! with `omega_B^2 = g K + (tau/rho) K^3` in the water's depth and `u` the drift of the water. The orbital
//! motion that the height map resolves is in the path of the facet; that of the waves between facet and Bragg
//! wave widens both lines by `s`, `s^2` the mean square of `q.v` ([`orbital`]). A line of a given middle and
//! width is a sum of components of fixed frequency ([`comb`]): any time may be asked in any order. Specular
//! points have one line at `q.u`, widened by the waves up to the cut.
//!
//! `K_B`, and with it line and width, is that on the mean surface, horizontal, of every sub-facet tilt: the
//! slopes of the map change how much a facet returns, not at which line. Their rms of 0.1 at 45 degrees is a
//! tenth of `K_B` and a twentieth of `omega_B`: 0.2 Hz in L band, 0.6 in X band, where orbital motion has 4
//! and 20 Hz.
//!
//! Limits: linear waves; no modulation of short waves by long ones; films and ships' own short waves have the
//! directions of the wind's; one phase at the start for all pairs of antennas, as frozen phases have.

pub mod comb;
pub mod orbital;
pub mod share;

use glam::DVec3;
use num_complex::Complex64;
use rand::Rng;

use crate::rng::{Room, stream};
use crate::scene::water::Dispersion;
use crate::sea::spectrum::Spectrum;

use super::tilt::Tangent;
use comb::{Comb, Line};
use orbital::SubFacetVelocities;
use share::DirectionShare;

/// Components of equal weight that a facet has at the widest line, all sub-facets together.
const COMPONENTS: f64 = 16.0;
/// Components of equal weight in a line one cell wide.
const COMPONENTS_PER_CELL: f64 = 3.66;
/// Sub-facet tilts of equal weight that nine stand for.
const EQUAL_TILTS: f64 = 4.0;
/// Least width of a cell over the highest Bragg frequency.
const LEAST_STEP: f64 = 0.02;

/// What the lines of a sea depend on.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// The spectrum that scatters.
    pub spectrum: &'a dyn Spectrum,
    /// The water's depth; surface tension counts here in any case.
    pub dispersion: Dispersion,
    /// Downwind unit vector, East and North.
    pub downwind: [f64; 2],
    /// Drift of the water, East and North, m/s.
    pub drift_mps: [f64; 2],
    /// Radar wave number, rad/m.
    pub wavenumber_radpm: f64,
    /// Highest wave number that the map resolves along an axis, rad/m.
    pub resolved_radpm: f64,
    /// Wave number that divides specular points from Bragg scattering, rad/m.
    pub cut_radpm: Option<f64>,
    /// Time in which phasors are forgotten whatever the waves, s.
    pub decorrelation_s: Option<f64>,
    /// Seed of the facets.
    pub seed: u64,
}

/// The lines of a sea.
#[derive(Clone, Debug)]
pub struct BraggLines {
    wavenumber_radpm: f64,
    dispersion: Dispersion,
    share: DirectionShare,
    velocities: SubFacetVelocities,
    drift_mps: DVec3,
    specular_to_radpm: f64,
    deviation_radps: Option<f64>,
    /// Planes of the sub-facets on the mean surface.
    tilts: Vec<Tangent>,
    comb: Comb,
    seed: u64,
}

impl BraggLines {
    /// For sub-facets of these slopes along and across the wind (one without slopes for no average).
    pub fn new(setting: &Setting<'_>, tilts: &[[f64; 2]]) -> Self {
        let k = setting.wavenumber_radpm;
        let dispersion = Dispersion { capillary: true, ..setting.dispersion };
        let [cos, sin] = setting.downwind;
        let axis = DVec3::new(cos, sin, 0.0);
        let plane = |[along, across]: &[f64; 2]| {
            Tangent::from_slopes(cos * along - sin * across, sin * along + cos * across, axis)
        };
        let from_radpm = setting.cut_radpm.map_or(1e-2 * k, |cut| cut.min(k) / std::f64::consts::SQRT_2);
        let velocities =
            SubFacetVelocities::new(setting.spectrum, dispersion, setting.resolved_radpm, 2.0 * k);
        let deviation_radps = setting.decorrelation_s.map(|time_s| std::f64::consts::SQRT_2 / time_s);
        let widest_radps = deviation_radps.unwrap_or(2.0 * k * velocities.largest_rms_mps());
        let wanted = if tilts.len() > 1 { COMPONENTS / EQUAL_TILTS } else { COMPONENTS };
        let least_radps = LEAST_STEP * dispersion.angular_frequency_rad_s(2.0 * k);
        let step_radps = (COMPONENTS_PER_CELL * widest_radps / wanted).max(least_radps);
        let [east, north] = setting.drift_mps;
        Self {
            wavenumber_radpm: k,
            dispersion,
            share: DirectionShare::new(setting.spectrum, setting.downwind, from_radpm, 2.0 * k),
            velocities,
            drift_mps: DVec3::new(east, north, 0.0),
            specular_to_radpm: setting.cut_radpm.unwrap_or(2.0 * k),
            deviation_radps,
            tilts: tilts.iter().map(plane).collect(),
            comb: Comb::new(step_radps),
            seed: setting.seed,
        }
    }

    /// Width of the cells that components of fixed frequency are drawn from, rad/s: a line is off by a part
    /// of that.
    pub fn step_radps(&self) -> f64 {
        self.comb.step_radps()
    }

    /// The lines of a mechanism (0 specular, 1 onwards the Bragg matrices) for unit directions from the
    /// transmitter and to the receiver.
    pub fn lines(&self, mechanism: usize, incident: DVec3, scattered: DVec3) -> [Line; 2] {
        let q = (scattered - incident) * self.wavenumber_radpm;
        self.of_vector(mechanism, q)
    }

    fn of_vector(&self, mechanism: usize, q: DVec3) -> [Line; 2] {
        let carried_radps = q.dot(self.drift_mps);
        let deviation_radps = |to_radpm: f64| {
            self.deviation_radps.unwrap_or_else(|| self.velocities.mean_square(q, to_radpm).sqrt())
        };
        let Some(plane) = mechanism.checked_sub(1).and_then(|tilt| self.tilts.get(tilt)) else {
            let deviation_radps = deviation_radps(self.specular_to_radpm);
            return [Line { share: 1.0, centre_radps: carried_radps, deviation_radps }, Line::default()];
        };
        let k_b = [q.dot(plane.e_x), q.dot(plane.e_y)];
        let magnitude = k_b[0].hypot(k_b[1]);
        let omega_radps = self.dispersion.angular_frequency_rad_s(magnitude);
        let (share, deviation_radps) = (self.share.of(k_b), deviation_radps(magnitude));
        [(share, omega_radps), (1.0 - share, -omega_radps)].map(|(share, omega_radps)| Line {
            share,
            centre_radps: omega_radps + carried_radps,
            deviation_radps,
        })
    }

    /// Phasors of the mechanisms of the facet with a global key, `t_s` after pulse 0, for unit directions
    /// from the transmitter and to the receiver.
    pub fn phasors(
        &self,
        key: [i64; 2],
        (incident, scattered): (DVec3, DVec3),
        t_s: f64,
        out: &mut [Complex64],
    ) {
        let address = key.map(i64::cast_unsigned);
        let facet = stream(self.seed, Room::FacetBragg, address[0], address[1]).next_u64();
        let q = (scattered - incident) * self.wavenumber_radpm;
        for (mechanism, phasor) in out.iter_mut().enumerate() {
            let number = 2 * mechanism as u64;
            let [advancing, receding] = self.of_vector(mechanism, q);
            *phasor = self.comb.phasor(facet, number, advancing, t_s)
                + self.comb.phasor(facet, number + 1, receding, t_s);
        }
    }
}

#[cfg(test)]
mod tests;
