//! Bragg waves that travel: random phases of facets with the Doppler of the waves that scatter.
//!
//! Of the roughness within a facet those waves scatter whose wave vector is `+K_B` or `-K_B`, `K_B` the part
//! of `q = k (k_s - k_i)` in the plane ([`spm`](super::spm)); `q` points towards the antennas. A wave along
//! `+K_B` comes closer and raises the frequency by `omega(K_B)`, one along `-K_B` lowers it. So the Bragg
//! phasor of a facet turns as the sum of two **lines**,
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
//! points have one line at `q.u`, widened by the waves up to the cutoff.
//!
//! All Bragg matrices of a facet are turned by the same phasor: their phases towards each other are those of
//! [`speckle`](super::speckle). Tilts within the facet add `(d omega/dK)^2 q_z^2 K^T S K/K^2` to `s^2`, `S`
//! the covariance of their slopes. `K_B` is that on the mean surface: the slopes of the map change how much a
//! facet returns, not at which line. Their rms of 0.1 at 45 degrees is a tenth of `K_B` and a twentieth of
//! `omega_B`: 0.2 Hz in L band, 0.6 in X band, where orbital motion has 4 and 20 Hz.
//!
//! Limits: linear waves; no modulation of short waves by long ones within a facet; films and ships' own short
//! waves have the directions of the wind's; one phase at the start for all pairs of antennas, as frozen
//! phases have.

pub mod block;
pub mod comb;
pub mod group;
pub mod orbital;
pub mod share;

use glam::DVec3;
use num_complex::Complex64;
use rand::Rng;

use crate::rng::{Room, stream};
use crate::scene::water::Dispersion;
use crate::sea::spectrum::Spectrum;

use comb::{Comb, Line, mixed};
use orbital::SubFacetVelocities;
use share::DirectionShare;

/// Components of equal weight that a facet has in the widest line. The facets of a resolution cell have many
/// together, and a few for each keep powers of facets near those of frozen phases.
const COMPONENTS: f64 = 4.0;
/// The same of a facet of Gaussian amplitude, which may be alone in its cell: its mean power over a long time
/// is random by one over their number.
const GAUSSIAN_COMPONENTS: f64 = 12.0;
/// Components of equal weight in a line of a deviation of one cell.
const COMPONENTS_PER_CELL: f64 = 3.66;
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
    /// Whether facets are of Gaussian amplitude.
    pub gaussian: bool,
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
    downwind: [f64; 2],
    /// Covariance of the slopes of sub-facets: xx, xy, yy.
    tilts: [f64; 3],
    comb: Comb,
    seed: u64,
}

/// What a facet turns with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mechanism {
    /// Specular points.
    Specular,
    /// Bragg waves of all sub-facets.
    Bragg,
}

impl Mechanism {
    /// Number of its first line.
    fn number(self) -> u32 {
        match self {
            Self::Specular => 0,
            Self::Bragg => 2,
        }
    }
}

impl BraggLines {
    /// For sub-facets of these variances of slopes along and across the wind (none for no average).
    pub fn new(setting: &Setting<'_>, [up, cross]: [f64; 2]) -> Self {
        let k = setting.wavenumber_radpm;
        let dispersion = Dispersion { capillary: true, ..setting.dispersion };
        let [cos, sin] = setting.downwind;
        let from_radpm = setting.cut_radpm.map_or(1e-2 * k, |cut| cut.min(k) / std::f64::consts::SQRT_2);
        let velocities =
            SubFacetVelocities::new(setting.spectrum, dispersion, setting.resolved_radpm, 2.0 * k);
        let deviation_radps = setting.decorrelation_s.map(|time_s| std::f64::consts::SQRT_2 / time_s);
        let widest_radps = deviation_radps.unwrap_or(2.0 * k * velocities.largest_rms_mps());
        let components = if setting.gaussian { GAUSSIAN_COMPONENTS } else { COMPONENTS };
        let least_radps = COMPONENTS / components * LEAST_STEP * dispersion.angular_frequency_rad_s(2.0 * k);
        let step_radps = (COMPONENTS_PER_CELL * widest_radps / components).max(least_radps);
        let [east, north] = setting.drift_mps;
        let comb = Comb::new(step_radps);
        Self {
            wavenumber_radpm: k,
            dispersion,
            share: DirectionShare::new(setting.spectrum, setting.downwind, from_radpm, 2.0 * k),
            velocities,
            drift_mps: DVec3::new(east, north, 0.0),
            specular_to_radpm: setting.cut_radpm.unwrap_or(2.0 * k),
            deviation_radps,
            downwind: setting.downwind,
            tilts: [
                cos * cos * up + sin * sin * cross,
                cos * sin * (up - cross),
                sin * sin * up + cos * cos * cross,
            ],
            comb: if setting.gaussian { comb.gaussian() } else { comb },
            seed: stream(setting.seed, Room::FacetBragg, 0, 0).next_u64(),
        }
    }

    /// The lines of a mechanism for unit directions from the transmitter and to the receiver.
    #[inline]
    pub fn lines(&self, mechanism: Mechanism, incident: DVec3, scattered: DVec3) -> [Line; 2] {
        let q = (scattered - incident) * self.wavenumber_radpm;
        let carried_radps = q.dot(self.drift_mps);
        if mechanism == Mechanism::Specular {
            let deviation_radps = self
                .deviation_radps
                .unwrap_or_else(|| self.velocities.mean_square(q, self.specular_to_radpm).sqrt());
            return [Line { amplitude: 1.0, centre_radps: carried_radps, deviation_radps }, Line::default()];
        }
        let magnitude = (q.x * q.x + q.y * q.y).sqrt().max(1e-9 * self.wavenumber_radpm);
        let omega_radps = self.dispersion.angular_frequency_rad_s(magnitude);
        let deviation_radps = self.deviation_radps.unwrap_or_else(|| {
            let [xx, xy, yy] = self.tilts;
            let tilted = (q.x * q.x * xx + 2.0 * q.x * q.y * xy + q.y * q.y * yy) / (magnitude * magnitude);
            let change_mps = self.dispersion.group_speed_mps(magnitude) * q.z;
            (self.velocities.mean_square(q, magnitude) + change_mps * change_mps * tilted).sqrt()
        });
        let [cos, sin] = self.downwind;
        let roots = self.share.roots([cos * q.x + sin * q.y, cos * q.y - sin * q.x], magnitude);
        let line = |amplitude: f64, omega_radps: f64| Line {
            amplitude,
            centre_radps: omega_radps + carried_radps,
            deviation_radps,
        };
        [line(roots[0], omega_radps), line(roots[1], -omega_radps)]
    }

    /// How far the lines of a mechanism reach off the Doppler of their facet, rad/s.
    pub fn reach_radps(&self, mechanism: Mechanism, incident: DVec3, scattered: DVec3) -> f64 {
        let reach = |line: Line| line.centre_radps.abs() + self.comb.end_radps(line.deviation_radps);
        let lines = self.lines(mechanism, incident, scattered).into_iter();
        lines.filter(|line| line.amplitude != 0.0).map(reach).fold(0.0, f64::max)
    }

    /// Random number of a mode of the facet with a global key; only Gaussian facets have more than one.
    #[inline(always)]
    fn number_of(&self, key: [i64; 2], mode: usize) -> u64 {
        let own = mixed(mixed(self.seed, key[0].cast_unsigned()), key[1].cast_unsigned());
        if mode == 0 { own } else { mixed(own, mode as u64) }
    }

    /// What turns a part of the facet with a global key, `t_s` after pulse 0, for unit directions from the
    /// transmitter and to the receiver: specular points, or a mode of the Bragg waves.
    pub fn phasor(
        &self,
        (mechanism, mode): (Mechanism, usize),
        key: [i64; 2],
        (incident, scattered): (DVec3, DVec3),
        t_s: f64,
    ) -> Complex64 {
        let facet = self.number_of(key, mode);
        let [first, second] = self.lines(mechanism, incident, scattered);
        let of = |line, number| self.comb.phasor(facet, number, line, t_s);
        of(first, mechanism.number()) + of(second, mechanism.number() + 1)
    }
}

/// Near the logarithm of a number above 0 to the base 2: exponent and mantissa as a double has them. Tables
/// lie even in it, for it costs less than a logarithm.
#[inline(always)]
fn octaves(x: f64) -> f64 {
    x.to_bits() as f64 * (1.0 / (1u64 << 52) as f64) - 1023.0
}

/// The same in single precision.
#[inline(always)]
fn octaves_f32(x: f32) -> f32 {
    (x.to_bits().cast_signed() - 1.0f32.to_bits().cast_signed()) as f32 * (1.0 / (1u32 << 23) as f32)
}

/// The number of some octaves.
fn of_octaves(octaves: f64) -> f64 {
    octaves.floor().exp2() * (1.0 + octaves - octaves.floor())
}

#[cfg(test)]
mod tests;
