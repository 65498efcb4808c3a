//! How finely, and over what length, a sea must be sampled.
//!
//! * A patch should hold the half-power band `[K1, K2]` of the actual spectrum in steps of at most
//!   `alpha (K2 - K1)`: `Lmin = 2 pi / [alpha (K2 - K1)]`, alpha = 0.25. Indicative: a warning, not a rule.
//! * Facets per metre by Rayleigh's criterion: waves shorter than `2 pi/K_R` are lower than
//!   `h_R = lambda/(8 cos theta)` (crest to trough, `h(K) = 4 sigma` of the waves beyond K), with the two
//!   asymptotes of Fung and Lee's capillary spectrum, which meet at `Kc = Km 3^(1/(p-1))`:
//!   `h_c = 4 sqrt[2 a0 Km sqrt 3/(9(p-1))]`, `X = h_R^2 (p-1)/(32 a0 Km)`,
//!   `K_R = Km X^(2/(3(1-p)))` for `h_R <= h_c`, else `Km (X + 2 sqrt 3/9)^(2/(1-p))`; facets/m = `K_R/pi`.
//! * Speckle needs at least [`LEAST_FACETS_PER_CELL`] facets of random phase in a resolution cell, or one of
//!   Gaussian amplitude; none may be longer than the cell.
//!
//! ```
//! use nereus::scene::water::WindProfile;
//! use nereus::sea::spectrum::{sampling, FungLee};
//! use nereus::sea::wind::Wind;
//! let sea = FungLee::new(&Wind::from_speed(10.0, 19.5, WindProfile::Cardone, 0.0)?);
//! assert!((sampling::least_length_m(&sea, sampling::BAND_STEP) - 328.4).abs() < 0.1);
//! # Ok::<(), nereus::sea::wind::WindError>(())
//! ```

use super::Spectrum;
use super::fung_lee::{CAPILLARY_SCALE_RAD_M, Capillary};
use crate::scene::sea::Speckle;
use crate::units::SPEED_OF_LIGHT_MPS;

/// The usual step of wave number, in half-power bandwidths.
pub const BAND_STEP: f64 = 0.25;
/// Facets of random phase in a resolution cell below which its speckle is not Rayleigh's.
pub const LEAST_FACETS_PER_CELL: f64 = 6.0;
/// Facets along the wave at the peak of the spectrum, at least, where their size is chosen.
pub const FACETS_PER_PEAK_WAVE: f64 = 12.0;

/// Least length of a patch, m, whose wave-number step is `band_step` half-power bandwidths; 0 for a
/// spectrum that is zero throughout.
pub fn least_length_m(spectrum: &dyn Spectrum, band_step: f64) -> f64 {
    let [low, high] = spectrum.half_power_band_rad_m();
    if high > low { std::f64::consts::TAU / (band_step * (high - low)) } else { 0.0 }
}

/// Longest facet, m, of which a resolution cell of these sides holds enough, whatever is one scatterer.
pub fn longest_facet_m(cell_m: [f64; 2], speckle: Speckle) -> f64 {
    let within_m = cell_m[0].min(cell_m[1]);
    match speckle {
        Speckle::RandomPhase => (cell_m[0] * cell_m[1] / LEAST_FACETS_PER_CELL).sqrt().min(within_m),
        Speckle::Gaussian { .. } => within_m,
    }
}

/// Facets in a resolution cell.
pub fn facets_per_cell(facet_m: f64, cell_m: [f64; 2]) -> f64 {
    cell_m[0] * cell_m[1] / (facet_m * facet_m)
}

/// Facet density by Rayleigh's criterion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetDensity {
    /// Height below which a surface is smooth, m.
    pub rayleigh_height_m: f64,
    /// Height of the waves beyond the joint of the asymptotes, m.
    pub joint_height_m: f64,
    /// Wave number beyond which waves are that low, rad/m.
    pub wave_number_rad_m: f64,
    /// Facets per metre.
    pub facets_per_m: f64,
}

impl FacetDensity {
    /// For Cardone's friction velocity (m/s, positive), a carrier (Hz) and an incidence angle (radians
    /// from the vertical; at and beyond the horizon any surface is smooth).
    pub fn rayleigh(ustar_mps: f64, carrier_hz: f64, incidence_rad: f64) -> Self {
        let Capillary { p, a0_m3 } = Capillary::new(ustar_mps);
        let km = CAPILLARY_SCALE_RAD_M;
        let root3 = 3f64.sqrt();
        let cos = incidence_rad.cos().max(0.0);
        let rayleigh_height_m = SPEED_OF_LIGHT_MPS / carrier_hz / (8.0 * cos);
        let joint_height_m = 4.0 * (2.0 * a0_m3 * km * root3 / (9.0 * (p - 1.0))).sqrt();
        let x = rayleigh_height_m * rayleigh_height_m * (p - 1.0) / (32.0 * a0_m3 * km);
        let ratio = if rayleigh_height_m <= joint_height_m {
            x.powf(2.0 / (3.0 * (1.0 - p)))
        } else {
            (x + 2.0 * root3 / 9.0).powf(2.0 / (1.0 - p))
        };
        let wave_number_rad_m = km * ratio;
        Self {
            rayleigh_height_m,
            joint_height_m,
            wave_number_rad_m,
            facets_per_m: wave_number_rad_m / std::f64::consts::PI,
        }
    }
}
