//! Batches of sea facets to scattering matrices.
//!
//! One batch is facets of one surface kind, as a structure of arrays; the result is four arrays, the entries
//! `vv, vh, hv, hh` (p received, q transmitted) of each facet's matrix in sqrt(m^2):
//!
//! * [`Phases::PolCoherent`] (default): `S = sqrt(A_f) [sum_n B_n e^{j phi_n} + G e^{j phi_0}]`, Bragg
//!   matrices `B_n` and specular matrix `G` with their own random phases: co- and cross-polar phases within a
//!   mechanism are physical;
//! * [`Phases::Single`], as the paper: `S_pq = sqrt(A_f sigma0_pq) e^{j phi_0}`, one phase for all four.
//!
//! `A_f = dx dy sqrt(1 + zx^2 + zy^2)` is the area of the facet itself. `E|S_pq|^2 = A_f sigma0_pq` in both.
//! No memory is taken per facet; batches may be cut anywhere and filled by any thread.
//!
//! ```
//! use glam::DVec3;
//! use nereus::scattering::facets::{Facets, Phases};
//! use nereus::scattering::kind::clean::Clean;
//! use nereus::scattering::two_scale::{Medium, Settings, TwoScale};
//! use num_complex::Complex64;
//! let medium = Medium {
//!     carrier_hz: 10e9,
//!     permittivity: Complex64::new(55.062, -37.514),
//!     wind_12p5_mps: 10.0,
//!     downwind_rad: 0.0,
//!     resolved_radpm: std::f64::consts::PI,
//!     axis: DVec3::X,
//! };
//! let psi = |kx: f64, ky: f64| 1e-3 / (kx * kx + ky * ky).powi(2);
//! let sea = TwoScale::new(Settings::default(), medium, Clean, psi);
//! let r = 0.5f64.sqrt();
//! let facets = Facets {
//!     incident: [&[r], &[0.0], &[-r]],
//!     scattered: [&[-r], &[0.0], &[r]],
//!     slope_x: &[0.0],
//!     slope_y: &[0.0],
//!     cover: &[],
//!     phasors: &[Complex64::ONE, Complex64::I],
//!     modulation: &[],
//!     footprint_m2: 1.0,
//! };
//! let (mut vv, mut vh) = ([Complex64::ZERO], [Complex64::ZERO]);
//! let (mut hv, mut hh) = (vv, vh);
//! facets.scatter(&sea, Phases::PolCoherent, [&mut vv, &mut vh, &mut hv, &mut hh])?;
//! assert!(vv[0].norm() > hh[0].norm());
//! # Ok::<(), nereus::scattering::facets::LengthError>(())
//! ```

use glam::DVec3;
use num_complex::Complex64;

use super::kind::Kind;
use super::tilt::{NO_ECHO, Path, ScatterMatrix};
use super::two_scale::TwoScale;

pub use crate::scene::sea::Phases;

/// An array of a batch does not have one entry (or one set of phasors) per facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("facet batch: {array} has {found} entries, {expected} are needed")]
pub struct LengthError {
    /// Which array.
    pub array: &'static str,
    /// Its entries.
    pub found: usize,
    /// What the number of facets asks for.
    pub expected: usize,
}

/// Facets of one kind.
#[derive(Clone, Copy, Debug)]
pub struct Facets<'a> {
    /// Unit direction transmitter to facet: x, y, z.
    pub incident: [&'a [f64]; 3],
    /// Unit direction facet to receiver: x, y, z.
    pub scattered: [&'a [f64]; 3],
    /// Slope of the height map along x.
    pub slope_x: &'a [f64],
    /// Slope of the height map along y.
    pub slope_y: &'a [f64],
    /// Share of each facet that the kind covers, 0 to 1; empty for 1 everywhere.
    pub cover: &'a [f64],
    /// Random phasors, those of a facet side by side (see [`speckle`](super::speckle)):
    /// `1 + TwoScale::tilts()` per facet for [`Phases::PolCoherent`], of which [`Phases::Single`] uses the
    /// first.
    pub phasors: &'a [Complex64],
    /// Factor on the density of the Bragg waves of each facet; empty for 1 everywhere.
    pub modulation: &'a [f64],
    /// Horizontal area `dx dy` of a facet, m^2.
    pub footprint_m2: f64,
}

impl Facets<'_> {
    /// Number of facets.
    pub fn len(&self) -> usize {
        self.slope_x.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.slope_x.is_empty()
    }

    /// Writes the matrices, sqrt(m^2), into `out` in the order `vv, vh, hv, hh`.
    ///
    /// # Errors
    /// An array whose length does not fit the number of facets.
    pub fn scatter<K: Kind, F: Fn(f64, f64) -> f64>(
        &self,
        sea: &TwoScale<K, F>,
        phases: Phases,
        out: [&mut [Complex64]; 4],
    ) -> Result<(), LengthError> {
        self.scatter_beside(sea, phases, |_, _, _| 0.0, out)
    }

    /// The same with waves besides those of the wind: `beside(i, kx, ky)` is their symmetrised spectrum on
    /// facet `i`, m^4, at a wave vector on the axes of the medium.
    ///
    /// # Errors
    /// An array whose length does not fit the number of facets.
    pub fn scatter_beside<K: Kind, F: Fn(f64, f64) -> f64>(
        &self,
        sea: &TwoScale<K, F>,
        phases: Phases,
        beside: impl Fn(usize, f64, f64) -> f64,
        out: [&mut [Complex64]; 4],
    ) -> Result<(), LengthError> {
        let mechanisms = 1 + sea.tilts();
        self.check(mechanisms, &out)?;
        let [vv, vh, hv, hh] = out;
        for (i, phasors) in self.phasors.chunks_exact(mechanisms).enumerate() {
            let path = Path::new(self.direction(self.incident, i), self.direction(self.scattered, i));
            let slopes = (self.slope_x[i], self.slope_y[i]);
            let cover = self.cover.get(i).copied().unwrap_or(1.0);
            let area_m2 = self.footprint_m2 * (1.0 + slopes.0 * slopes.0 + slopes.1 * slopes.1).sqrt();
            let root = area_m2.sqrt();
            let mut matrix = NO_ECHO;
            let raise = self.modulation.get(i);
            match phases {
                Phases::PolCoherent => {
                    let beside = |kx: f64, ky: f64| beside(i, kx, ky);
                    sea.visit_beside(&path, slopes, cover, beside, |mechanism, part| match raise {
                        Some(raise) if mechanism > 0 => {
                            add(&mut matrix, part, phasors[mechanism] * raise.sqrt());
                        }
                        _ => add(&mut matrix, part, phasors[mechanism]),
                    });
                }
                Phases::Single => {
                    let beside = |kx: f64, ky: f64| beside(i, kx, ky);
                    let response = sea.response_beside(&path, slopes, cover, beside);
                    let mut sigma0 = response.sigma0();
                    if let Some(raise) = raise {
                        let more = response.bragg_sigma0().map(|row| row.map(|s| s * (raise - 1.0)));
                        for (sigma0, more) in sigma0.as_flattened_mut().iter_mut().zip(more.as_flattened()) {
                            *sigma0 = (*sigma0 + more).max(0.0);
                        }
                    }
                    matrix = sigma0.map(|row| row.map(|s| phasors[0] * s.sqrt()));
                }
            }
            vv[i] = matrix[0][0] * root;
            vh[i] = matrix[0][1] * root;
            hv[i] = matrix[1][0] * root;
            hh[i] = matrix[1][1] * root;
        }
        Ok(())
    }

    fn direction(&self, components: [&[f64]; 3], i: usize) -> DVec3 {
        DVec3::new(components[0][i], components[1][i], components[2][i])
    }

    fn check(&self, mechanisms: usize, out: &[&mut [Complex64]; 4]) -> Result<(), LengthError> {
        let n = self.len();
        let cover = if self.cover.is_empty() { n } else { self.cover.len() };
        let modulation = if self.modulation.is_empty() { n } else { self.modulation.len() };
        let [vv, vh, hv, hh] = out.each_ref().map(|entry| entry.len());
        let [ix, iy, iz] = self.incident.map(<[f64]>::len);
        let [sx, sy, sz] = self.scattered.map(<[f64]>::len);
        let lengths = [
            ("incident x", ix, n),
            ("incident y", iy, n),
            ("incident z", iz, n),
            ("scattered x", sx, n),
            ("scattered y", sy, n),
            ("scattered z", sz, n),
            ("slope_y", self.slope_y.len(), n),
            ("cover", cover, n),
            ("modulation", modulation, n),
            ("phasors", self.phasors.len(), n * mechanisms),
            ("output vv", vv, n),
            ("output vh", vh, n),
            ("output hv", hv, n),
            ("output hh", hh, n),
        ];
        match lengths.into_iter().find(|&(_, found, expected)| found != expected) {
            Some((array, found, expected)) => Err(LengthError { array, found, expected }),
            None => Ok(()),
        }
    }
}

#[inline]
fn add(sum: &mut ScatterMatrix, part: &ScatterMatrix, phasor: Complex64) {
    for (row, other) in sum.iter_mut().zip(part) {
        for (entry, s) in row.iter_mut().zip(other) {
            *entry += s * phasor;
        }
    }
}
