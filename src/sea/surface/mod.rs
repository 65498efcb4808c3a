//! One realisation of the sea, at any time.
//!
//! On a periodic grid of `nx x ny` facets of side `dx`, `dKx = 2 pi/(nx dx)`, every wave vector K of the
//! plane has a complex amplitude, drawn once:
//!
//! `a(K) = sqrt(Psi(K) dKx dKy / 2) xi(K)`, `E|xi|^2 = 1`, Psi in the wave convention. Then with
//! `E(K, t) = a(K) exp(-j w t)` and `F(K, t) = conj E(-K, t)`:
//!
//! | field | spectrum |
//! | --- | --- |
//! | height z, m | `H = E + F` |
//! | slope | `j K H` |
//! | vertical velocity, m/s | `-j w (E - F)` |
//! | horizontal velocity, m/s | `(K/\|K\|) w q (E - F)` |
//! | acceleration, m/s^2 | `-w^2 H` and `-j (K/\|K\|) w^2 q H` |
//! | horizontal displacement D, m | `j (K/\|K\|) q H`, the time integral of the horizontal velocity |
//! | rate of the slope, 1/s | `K w (E - F)` |
//! | gradient of D | `-(K K/\|K\|) q H` |
//!
//! `z(x, t) = sum of H exp(j K.x)`: waves travel along +K, the field is real, its expected variance is
//! exactly the sum of `Psi dKx dKy`. `q = coth(K d)` (1 in deep water). The zero and Nyquist wave numbers
//! carry nothing. Gaussian numbers are keyed by (seed, index of Kx, index of Ky): a grid with more facets
//! over the same length has the same long waves. Psi is taken at grid points, or averaged over the cells
//! between them, which is needed, and chosen, when the peak lies within six steps of the origin.
//!
//! Facet `(ix, iy)` is at `(ix dx, iy dx)` of the scene frame for any integers: the map repeats
//! ([`Grid::index`]). Fields belong to the undisplaced (grid) position; a scatterer is at
//! `x_grid + D + z up`.
//!
//! Any time is evaluated from t = 0 with phases reduced in f64: nothing drifts. f32 fields are within -120 dB
//! of the f64 ones (relative to the rms of the height, or of the larger component of a vector). Limits:
//! linear waves; at most 2^26 facets;
//! |t| up to 1e9 s. [`choppy`] makes waves of second order of them.
//!
//! ```
//! use nereus::scene::water::{Dispersion, Spreading, WindProfile};
//! use nereus::sea::spectrum::PiersonMoskowitz;
//! use nereus::sea::surface::{Averaging, Evaluator, Fields, Grid, Selection, Surface};
//! use nereus::sea::wind::Wind;
//! let wind = Wind::from_speed(8.0, 19.5, WindProfile::Cardone, 0.0)?;
//! let spectrum = PiersonMoskowitz::new(&wind, Spreading::default())?;
//! let grid = Grid::new(32, 32, 8.0)?;
//! let surface = Surface::synthesise(grid, &spectrum, Dispersion::default(), 1, Averaging::Automatic)?;
//! let mut fields = Fields::<f64>::new(&grid, Selection::ALL);
//! Evaluator::new(&surface).evaluate(3.0, &mut fields)?;
//! let at = surface.at([5.0 * 8.0, 7.0 * 8.0], 3.0);
//! assert!((fields.height_m[grid.index([5, 7 + 32])] - at.height_m).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod choppy;
pub mod evaluator;
pub mod fields;
pub mod grid;
pub mod modulation;
pub mod phasors;
pub mod state;
pub mod transform;

use num_complex::Complex64;
use rand::Rng;

use crate::rng::{Room, stream};
use crate::scene::water::Dispersion;
use crate::sea::dispersion::DepthError;
use crate::sea::spectrum::{Spectrum, WaveVector};

pub use crate::scene::sea::Averaging;
pub use evaluator::Evaluator;
pub use fields::{Fields, Sample, Selection};
pub use grid::Grid;
pub use phasors::Phasors;
pub use state::StateError;
pub use transform::{Pair, Transform};

/// What is wrong with a surface.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// Too few or too many facets.
    #[error(
        "sea map of {nx} x {ny} facets: allowed are 1 to {} a side, {} in all",
        grid::MAX_SIDE,
        grid::MAX_FACETS
    )]
    Facets {
        /// Along x.
        nx: usize,
        /// Along y.
        ny: usize,
    },
    /// Facet size out of range.
    #[error("facet of {facet_m} m: allowed are {} to {} m", grid::FACET_RANGE_M[0], grid::FACET_RANGE_M[1])]
    FacetSize {
        /// The size given, m.
        facet_m: f64,
    },
    /// Water depth out of range.
    #[error(transparent)]
    Depth(#[from] DepthError),
    /// Fields made for another grid.
    #[error("fields hold {found} facets, the surface has {needed}")]
    FieldSize {
        /// Facets of the fields.
        found: usize,
        /// Facets of the surface.
        needed: usize,
    },
    /// Time out of range.
    #[error("sea at {time_s} s: allowed are times within {} s of t = 0", evaluator::MAX_TIME_S)]
    Time {
        /// The time asked, s.
        time_s: f64,
    },
}

/// Expected moments of what a grid holds of a spectrum: sums over its wave numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Expected {
    /// Variance of the height, m^2.
    pub variance_m2: f64,
    /// Variances of the slopes along x and y.
    pub slope_variance: [f64; 2],
}

/// One realisation of the sea on a periodic grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    grid: Grid,
    dispersion: Dispersion,
    seed: u64,
    expected: Expected,
    /// `[kx][ky]`: amplitudes a(K), m.
    amplitude_m: Vec<Complex64>,
}

impl Surface {
    /// Draws the amplitudes of a sea.
    ///
    /// # Errors
    /// A depth out of range.
    pub fn synthesise(
        grid: Grid,
        spectrum: &dyn Spectrum,
        dispersion: Dispersion,
        seed: u64,
        averaging: Averaging,
    ) -> Result<Self, SurfaceError> {
        dispersion.check()?;
        let dk = grid.wave_number_step_rad_m();
        let cells = match averaging {
            Averaging::Automatic => spectrum.needs_cell_means(dk[0].max(dk[1])),
            Averaging::Points => false,
            Averaging::Cells => true,
        };
        let area = dk[0] * dk[1];
        let mut expected = Expected::default();
        let mut amplitude_m = vec![Complex64::ZERO; grid.len()];
        for (i, row) in amplitude_m.chunks_exact_mut(grid.ny()).enumerate() {
            for (j, amplitude) in row.iter_mut().enumerate() {
                let (Some(mx), Some(my)) = (grid.wave_index_x(i), grid.wave_index_y(j)) else {
                    continue;
                };
                if (mx, my) == (0, 0) {
                    continue;
                }
                let k = WaveVector::new(mx as f64 * dk[0], my as f64 * dk[1]);
                let psi_m4 = if cells { spectrum.cell_mean_m4(k, dk) } else { spectrum.wave_m4(k) };
                let variance_m2 = psi_m4 * area;
                if variance_m2 > 0.0 {
                    *amplitude = (0.5 * variance_m2).sqrt() * gaussian(seed, mx, my);
                    expected.variance_m2 += variance_m2;
                    expected.slope_variance[0] += k.x_rad_m * k.x_rad_m * variance_m2;
                    expected.slope_variance[1] += k.y_rad_m * k.y_rad_m * variance_m2;
                }
            }
        }
        Ok(Self { grid, dispersion, seed, expected, amplitude_m })
    }

    /// Its grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// How its waves travel.
    pub fn dispersion(&self) -> Dispersion {
        self.dispersion
    }

    /// The seed it was drawn from.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Moments expected over all seeds.
    pub fn expected(&self) -> Expected {
        self.expected
    }

    /// Amplitudes a(K), m, `[kx][ky]` in the order of [`Grid::wave_index_x`] and [`Grid::wave_index_y`].
    pub fn amplitude_m(&self) -> &[Complex64] {
        &self.amplitude_m
    }

    /// Whether the surface is exactly flat.
    pub fn is_flat(&self) -> bool {
        self.amplitude_m.iter().all(|a| *a == Complex64::ZERO)
    }

    /// All fields at one place and time, summed wave by wave in f64: slow, for checks and references.
    pub fn at(&self, position_m: [f64; 2], time_s: f64) -> Sample {
        let dk = self.grid.wave_number_step_rad_m();
        let mut sample = Sample::default();
        for (i, row) in self.amplitude_m.chunks_exact(self.grid.ny()).enumerate() {
            for (j, amplitude) in row.iter().enumerate() {
                let (Some(mx), Some(my)) = (self.grid.wave_index_x(i), self.grid.wave_index_y(j)) else {
                    continue;
                };
                if *amplitude == Complex64::ZERO {
                    continue;
                }
                let [kx, ky] = [mx as f64 * dk[0], my as f64 * dk[1]];
                let k = kx.hypot(ky);
                let omega = self.dispersion.angular_frequency_rad_s(k);
                let q = self.dispersion.excursion_ratio(k) / k;
                let phase = kx * position_m[0] + ky * position_m[1] - omega * time_s;
                // F is the conjugate of the sum at -K, so every wave counts twice its real part.
                let wave = 2.0 * amplitude * Complex64::cis(phase);
                let (z, quadrature) = (wave.re, wave.im);
                sample.height_m += z;
                sample.velocity_mps[2] += omega * quadrature;
                sample.acceleration_mps2[2] -= omega * omega * z;
                for (axis, component) in [kx, ky].into_iter().enumerate() {
                    sample.slope[axis] -= component * quadrature;
                    sample.slope_rate_per_s[axis] += component * omega * z;
                    sample.velocity_mps[axis] += component * q * omega * z;
                    sample.acceleration_mps2[axis] += component * q * omega * omega * quadrature;
                    sample.displacement_m[axis] -= component * q * quadrature;
                }
            }
        }
        sample
    }
}

/// Circular complex Gaussian of unit variance, the same for a seed and a pair of wave-number indices.
fn gaussian(seed: u64, mx: i64, my: i64) -> Complex64 {
    let mut numbers = stream(seed, Room::SeaWave, mx as u64, my as u64);
    // (0, 1] and [0, 1) in steps of 2^-53; the first never zero.
    let mut uniform = || (numbers.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64);
    let radius = (-(1.0 - uniform()).ln()).sqrt();
    Complex64::from_polar(radius, std::f64::consts::TAU * uniform())
}
