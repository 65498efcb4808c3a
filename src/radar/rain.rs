//! Rain: specific attenuation, Recommendation ITU-R P.838-3 (2005), and cross section per volume.
//!
//! `gamma = k R^alpha` dB/km one way, `R` the rain rate (mm/h); `k_H`, `alpha_H`, `k_V` and `alpha_V` are
//! sums of Gaussians of `log10 f` (1 to 1000 GHz, the Recommendation's equations 2 and 3). At an elevation
//! `theta` and a tilt `tau` of the polarisation (equations 4 and 5):
//!
//! `k = (k_H + k_V + (k_H - k_V) cos^2(theta) cos(2 tau))/2` ,
//! `alpha = (k_H alpha_H + k_V alpha_V + (k_H alpha_H - k_V alpha_V) cos^2(theta) cos(2 tau))/(2 k)` ,
//!
//! `tau = 45` degrees for circular polarisation, which takes the same at any elevation.
//!
//! ```
//! use nereus::radar::rain::Attenuation;
//! // X band, heavy rain.
//! let Attenuation { h, v, circular } = Attenuation::new(9.4e9, 25.0);
//! assert!((h - 0.589).abs() < 5e-4 && (v - 0.479).abs() < 5e-4 && (circular - 0.533).abs() < 5e-4);
//! assert_eq!(Attenuation::new(9.4e9, 0.0), Attenuation::default());
//! ```

use std::f64::consts::PI;

use crate::scene::radar::Polarisation;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Carriers for which the Recommendation holds, Hz.
pub const CARRIERS_HZ: [f64; 2] = [1e9, 1e12];

/// Carrier up to which drops scatter by Rayleigh's law, Hz.
pub const RAYLEIGH_TO_HZ: f64 = 2e10;

/// `|K|^2` of water, `K = (m^2 - 1)/(m^2 + 2)`.
const DIELECTRIC: f64 = 0.93;

/// Reflectivity factor `Z = 200 R^1.6` of rain of so many mm/h, mm^6/m^3 (Marshall and Palmer 1948).
pub fn reflectivity_factor(rain_mmph: f64) -> f64 {
    200.0 * rain_mmph.max(0.0).powf(1.6)
}

/// Cross section of rain per volume, 1/m, back to where a wave comes from: `pi^5 |K|^2 Z/lambda^4`.
///
/// ```
/// use nereus::radar::rain::volume_reflectivity_per_m;
/// // 10 mm/h at 10 GHz: 39.0 dBZ, -55.5 dB of 1/m.
/// let eta = volume_reflectivity_per_m(10e9, 10.0);
/// assert!((10.0 * eta.log10() + 55.5).abs() < 0.1);
/// ```
pub fn volume_reflectivity_per_m(carrier_hz: f64, rain_mmph: f64) -> f64 {
    let wavelength_m = SPEED_OF_LIGHT_MPS / carrier_hz;
    // mm^6/m^3 are 1e-18 m^3.
    PI.powi(5) * DIELECTRIC * reflectivity_factor(rain_mmph) * 1e-18 / wavelength_m.powi(4)
}

/// Mean fall of what returns the echo, m/s: `3.8 Z^(1/14)` (Rogers 1964).
pub fn fall_mps(rain_mmph: f64) -> f64 {
    3.8 * reflectivity_factor(rain_mmph).powf(1.0 / 14.0)
}

/// A sum of Gaussians `[a, b, c]` of the logarithm of the frequency, and a line.
struct Fit<const N: usize> {
    terms: [[f64; 3]; N],
    slope: f64,
    offset: f64,
}

impl<const N: usize> Fit<N> {
    fn at(&self, log_ghz: f64) -> f64 {
        let terms = self.terms.iter().map(|[a, b, c]| a * (-((log_ghz - b) / c).powi(2)).exp());
        terms.sum::<f64>() + self.slope * log_ghz + self.offset
    }
}

/// Tables 1 and 2 of the Recommendation: logarithms of k, H and V.
const LOG_K: [Fit<4>; 2] = [
    Fit {
        terms: [
            [-5.33980, -0.10008, 1.13098],
            [-0.35351, 1.26970, 0.45400],
            [-0.23789, 0.86036, 0.15354],
            [-0.94158, 0.64552, 0.16817],
        ],
        slope: -0.18961,
        offset: 0.71147,
    },
    Fit {
        terms: [
            [-3.80595, 0.56934, 0.81061],
            [-3.44965, -0.22911, 0.51059],
            [-0.39902, 0.73042, 0.11899],
            [0.50167, 1.07319, 0.27195],
        ],
        slope: -0.16398,
        offset: 0.63297,
    },
];

/// Tables 3 and 4: alpha, H and V.
const ALPHA: [Fit<5>; 2] = [
    Fit {
        terms: [
            [-0.14318, 1.82442, -0.55187],
            [0.29591, 0.77564, 0.19822],
            [0.32177, 0.63773, 0.13164],
            [-5.37610, -0.96230, 1.47828],
            [16.1721, -3.29980, 3.43990],
        ],
        slope: 0.67849,
        offset: -1.95537,
    },
    Fit {
        terms: [
            [-0.07771, 2.33840, -0.76284],
            [0.56727, 0.95545, 0.54039],
            [-0.20238, 1.14520, 0.26809],
            [-48.2991, 0.791669, 0.116226],
            [48.5833, 0.791459, 0.116479],
        ],
        slope: -0.053739,
        offset: 0.83433,
    },
];

/// `k` and `alpha` of H and of V.
fn coefficients(carrier_hz: f64) -> [[f64; 2]; 2] {
    let log_ghz = (carrier_hz.clamp(CARRIERS_HZ[0], CARRIERS_HZ[1]) / 1e9).log10();
    [0, 1].map(|of| [10f64.powf(LOG_K[of].at(log_ghz)), ALPHA[of].at(log_ghz)])
}

/// Attenuation one way on a level path, dB/km, by polarisation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attenuation {
    /// Horizontal.
    pub h: f64,
    /// Vertical.
    pub v: f64,
    /// Right-hand or left-hand circular.
    pub circular: f64,
}

impl Attenuation {
    /// In rain of so many mm/h.
    pub fn new(carrier_hz: f64, rain_mmph: f64) -> Self {
        if rain_mmph <= 0.0 {
            return Self::default();
        }
        let [[k_h, alpha_h], [k_v, alpha_v]] = coefficients(carrier_hz);
        let k = 0.5 * (k_h + k_v);
        Self {
            h: k_h * rain_mmph.powf(alpha_h),
            v: k_v * rain_mmph.powf(alpha_v),
            circular: k * rain_mmph.powf((k_h * alpha_h + k_v * alpha_v) / (2.0 * k)),
        }
    }

    /// Of a port on a path of so great a sine of elevation, to first order in what H and V differ by.
    pub fn of(&self, port: Polarisation, rise: f64) -> f64 {
        let level = match port {
            Polarisation::H => self.h,
            Polarisation::V => self.v,
            Polarisation::R | Polarisation::L => self.circular,
        };
        self.circular + (level - self.circular) * (1.0 - rise * rise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 5 of the Recommendation.
    #[test]
    fn coefficients_are_those_of_the_published_table() {
        let table = [
            (1e9, [[0.0000259, 0.9691], [0.0000308, 0.8592]]),
            (10e9, [[0.01217, 1.2571], [0.01129, 1.2156]]),
            (20e9, [[0.09164, 1.0568], [0.09611, 0.9847]]),
            (35e9, [[0.3374, 0.9047], [0.3224, 0.8761]]),
            (100e9, [[1.3671, 0.6815], [1.3680, 0.6765]]),
        ];
        for (carrier_hz, expected) in table {
            for (found, expected) in coefficients(carrier_hz).iter().flatten().zip(expected.iter().flatten())
            {
                assert!((found / expected - 1.0).abs() < 2e-3, "{carrier_hz}: {found} {expected}");
            }
        }
    }

    #[test]
    fn circular_polarisation_lies_between_the_others() {
        for carrier_hz in [3e9, 9.4e9, 35e9] {
            for rain_mmph in [0.5f64, 5.0, 50.0] {
                let Attenuation { h, v, circular } = Attenuation::new(carrier_hz, rain_mmph);
                assert!(circular > h.min(v) && circular < h.max(v), "{carrier_hz} {rain_mmph}");
            }
        }
    }
}
