//! Random phases of facets: frozen, or forgotten with time.
//!
//! A facet larger than the wavelength returns an amplitude whose phase is that of the unresolved waves in it:
//! uniform, independent between facets and between scattering mechanisms, and the same for all polarisations
//! of a mechanism. It is fixed by the seed and the facet's global grid numbers `(ix, iy)`, so a facet that
//! leaves the patch and returns is the same facet.
//!
//! Mechanisms are numbered: 0 specular, 1 onwards the Bragg matrices of
//! [`Response::bragg`](super::two_scale::Response::bragg).
//!
//! [`Speckle::Frozen`]: unit phasors `exp(j phi)`. [`Speckle::Decorrelating`]: a stationary process of unit
//! power, nearly complex Gaussian, whose covariance is `exp(-(t/tau)^2)`:
//! `gamma(t) = M^{-1/2} sum_m exp(j (w_m t + phi_m))`, the `w_m` drawn once per facet from a Gaussian of
//! deviation `sqrt(2)/tau`. It needs no state: any time may be asked in any order. (Typical `tau` at X band:
//! 5 to 10 ms.)
//!
//! ```
//! use nereus::scattering::speckle::Speckle;
//! use num_complex::Complex64;
//! let mut once = [Complex64::ZERO; 2];
//! let mut again = once;
//! Speckle::Frozen.phasors(7, (-3, 12), 0.0, &mut once);
//! Speckle::Frozen.phasors(7, (-3, 12), 99.0, &mut again);
//! assert!(once == again && (once[0].norm() - 1.0).abs() < 1e-15 && once[0] != once[1]);
//! ```

use std::f64::consts::TAU;

use num_complex::Complex64;
use rand::Rng;

use crate::rng::{Room, stream};

/// Waves of a decorrelating phasor.
pub const WAVES: usize = 16;
/// Words of the stream that the waves of a mechanism take.
const WORDS: u128 = 4 * WAVES as u128;

/// One of them: angular frequency, rad/s, and phase at pulse 0, turns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wave {
    /// Angular frequency, rad/s.
    pub omega_radps: f64,
    /// Phase at pulse 0, turns.
    pub turns: f64,
}

/// How long a facet remembers its phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Speckle {
    /// For ever.
    #[default]
    Frozen,
    /// Gaussian loss of memory.
    Decorrelating {
        /// Time after which the covariance is 1/e, s.
        time_s: f64,
    },
}

impl Speckle {
    /// Phasors of the mechanisms of facet `(ix, iy)` at `t_s` seconds after pulse 0.
    pub fn phasors(self, seed: u64, facet: (i64, i64), t_s: f64, out: &mut [Complex64]) {
        let address = (facet.0.cast_unsigned(), facet.1.cast_unsigned());
        match self {
            Self::Frozen => {
                let mut draws = stream(seed, Room::FacetPhase, address.0, address.1);
                out.fill_with(|| cis_turns(unit(draws.next_u64())));
            }
            Self::Decorrelating { time_s } => {
                let mut draws = stream(seed, Room::FacetDecorrelation, address.0, address.1);
                let scale = 1.0 / (WAVES as f64).sqrt();
                out.fill_with(|| {
                    let mut sum = Complex64::ZERO;
                    for Wave { omega_radps, turns } in drawn(&mut draws, time_s) {
                        sum += cis_turns((omega_radps * t_s / TAU).fract() + turns);
                    }
                    sum * scale
                });
            }
        }
    }

    /// The same of complex Gaussian law where they are frozen; those that decorrelate are so nearly.
    pub fn gaussian_phasors(self, seed: u64, facet: (i64, i64), t_s: f64, out: &mut [Complex64]) {
        if self != Self::Frozen {
            return self.phasors(seed, facet, t_s, out);
        }
        let mut draws = stream(seed, Room::FacetPhase, facet.0.cast_unsigned(), facet.1.cast_unsigned());
        out.fill_with(|| {
            let power = -(1.0 - unit(draws.next_u64())).ln();
            cis_turns(unit(draws.next_u64())) * power.sqrt()
        });
    }

    /// Rms angular frequency, rad/s.
    pub fn deviation_radps(self) -> f64 {
        match self {
            Self::Frozen => 0.0,
            Self::Decorrelating { time_s } => std::f64::consts::SQRT_2 / time_s,
        }
    }

    /// The waves of a decorrelating phasor of a mechanism of facet `(ix, iy)`; of a frozen one, waves that
    /// stand.
    pub fn waves(self, seed: u64, facet: (i64, i64), mechanism: usize) -> [Wave; WAVES] {
        let Self::Decorrelating { time_s } = self else { return [Wave::default(); WAVES] };
        let address = (facet.0.cast_unsigned(), facet.1.cast_unsigned());
        let mut draws = stream(seed, Room::FacetDecorrelation, address.0, address.1);
        draws.set_word_pos(mechanism as u128 * WORDS);
        drawn(&mut draws, time_s)
    }
}

/// The next waves of a stream.
fn drawn(draws: &mut impl Rng, time_s: f64) -> [Wave; WAVES] {
    let deviation_radps = std::f64::consts::SQRT_2 / time_s;
    let mut waves = [Wave::default(); WAVES];
    for two in waves.as_chunks_mut::<2>().0 {
        // Box and Muller: two Gaussian frequencies from two uniform numbers.
        let radius = (-2.0 * (1.0 - unit(draws.next_u64())).ln()).sqrt() * deviation_radps;
        let (sin, cos) = (TAU * unit(draws.next_u64())).sin_cos();
        for (wave, omega_radps) in two.iter_mut().zip([radius * cos, radius * sin]) {
            *wave = Wave { omega_radps, turns: unit(draws.next_u64()) };
        }
    }
    waves
}

/// The top 53 bits as a number in [0, 1).
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

fn cis_turns(turns: f64) -> Complex64 {
    let (sin, cos) = (TAU * turns).sin_cos();
    Complex64::new(cos, sin)
}
