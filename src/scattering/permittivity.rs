//! Relative permittivity of sea water.
//!
//! Three models, all with the time convention `exp(+j w t)` (so `Im eps <= 0`):
//!
//! * **Meissner and Wentz 2012** (default), double Debye,
//!   `eps = (e0-e1)/(1+j f/n1) + (e1-e2)/(1+j f/n2) + e2 - j sigma/(2 pi eps0 f)`;
//!   IEEE TGRS 42, 1836 (2004) and 50, 3004 (2012). 1 to 90 GHz, -2 to 34 degrees Celsius, 0 to 40 psu.
//! * **Klein and Swift 1977**, single Debye,
//!   `eps = 4.9 + (es-4.9)/(1+j w tau) - j sigma/(w eps0)`;
//!   IEEE TAP 25, 104. 1 to 10 GHz, 0 to 30 degrees Celsius, 4 to 35 psu (the span of its measurements).
//! * **ITU-R P.527-6**, double Debye with the static permittivity and the relaxation of Liebe,
//!   the salt of Meissner and Wentz 2004, and the conductivity of the practical salinity scale. A band of
//!   broadcast and HF radars: 1 MHz to 1 THz, here from -2 to 34 degrees Celsius, 0 to 40 psu. Below its
//!   relaxations (some 17 GHz) what it says is the static permittivity and the conductivity alone.
//!
//! `T` is the temperature in degrees Celsius, `S` the practical salinity, `f` the frequency, `n1`, `n2` the
//! relaxation frequencies (GHz), `sigma` the conductivity (S/m).
//!
//! Outside its range a model gives a [`PermittivityError`]; [`Model::extrapolated`] evaluates the formula
//! regardless, for those who know what they ask.
//!
//! ```
//! use nereus::scattering::permittivity::{Model, SeaWater};
//! let water = SeaWater { temperature_c: 20.0, salinity_gpkg: 35.0 };
//! let eps = Model::MeissnerWentz2012.permittivity(10e9, water)?;
//! assert!((eps.re - 55.062).abs() < 1e-3 && (eps.im + 37.514).abs() < 1e-3);
//! assert!(Model::KleinSwift1977.permittivity(35e9, water).is_err());
//! # Ok::<(), nereus::scattering::permittivity::PermittivityError>(())
//! ```

use std::f64::consts::TAU;
use std::fmt;

use num_complex::Complex64;

/// Permittivity of vacuum, F/m.
pub const VACUUM_PERMITTIVITY_FPM: f64 = 8.854_187_812_8e-12;

/// A model of the permittivity of sea water.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// Meissner and Wentz 2012, double Debye.
    #[default]
    MeissnerWentz2012,
    /// Klein and Swift 1977, single Debye.
    KleinSwift1977,
    /// Recommendation ITU-R P.527-6, double Debye.
    ItuRP527,
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::MeissnerWentz2012 => "Meissner-Wentz 2012",
            Self::KleinSwift1977 => "Klein-Swift 1977",
            Self::ItuRP527 => "ITU-R P.527-6",
        })
    }
}

/// State of the water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeaWater {
    /// Temperature, degrees Celsius.
    pub temperature_c: f64,
    /// Practical salinity, psu.
    pub salinity_gpkg: f64,
}

/// A quantity lies outside the range in which a model is known to hold.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("permittivity model {model}: {quantity} is {value} {unit}, allowed {min} to {max} {unit}")]
pub struct PermittivityError {
    /// Which model.
    pub model: Model,
    /// Which quantity.
    pub quantity: &'static str,
    /// Its value.
    pub value: f64,
    /// Least allowed value.
    pub min: f64,
    /// Greatest allowed value.
    pub max: f64,
    /// Unit of the three values.
    pub unit: &'static str,
}

/// Where a model holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least and greatest frequency, Hz.
    pub frequency_hz: (f64, f64),
    /// Least and greatest temperature, degrees Celsius.
    pub temperature_c: (f64, f64),
    /// Least and greatest practical salinity, psu.
    pub salinity_gpkg: (f64, f64),
}

impl Model {
    /// Where the model holds.
    pub fn range(self) -> Range {
        match self {
            Self::MeissnerWentz2012 => {
                Range { frequency_hz: (1e9, 90e9), temperature_c: (-2.0, 34.0), salinity_gpkg: (0.0, 40.0) }
            }
            Self::KleinSwift1977 => {
                Range { frequency_hz: (1e9, 10e9), temperature_c: (0.0, 30.0), salinity_gpkg: (4.0, 35.0) }
            }
            Self::ItuRP527 => {
                Range { frequency_hz: (1e6, 1e12), temperature_c: (-2.0, 34.0), salinity_gpkg: (0.0, 40.0) }
            }
        }
    }

    /// Every quantity that is outside the range of the model.
    pub fn faults(self, frequency_hz: f64, water: SeaWater) -> Vec<PermittivityError> {
        let range = self.range();
        let rows = [
            (
                "frequency",
                frequency_hz * 1e-9,
                range.frequency_hz.0 * 1e-9,
                range.frequency_hz.1 * 1e-9,
                "GHz",
            ),
            (
                "temperature",
                water.temperature_c,
                range.temperature_c.0,
                range.temperature_c.1,
                "degrees Celsius",
            ),
            ("salinity", water.salinity_gpkg, range.salinity_gpkg.0, range.salinity_gpkg.1, "psu"),
        ];
        rows.into_iter()
            .filter(|&(_, value, min, max, _)| !(min..=max).contains(&value))
            .map(|(quantity, value, min, max, unit)| PermittivityError {
                model: self,
                quantity,
                value,
                min,
                max,
                unit,
            })
            .collect()
    }

    /// Relative permittivity at `frequency_hz`.
    ///
    /// # Errors
    /// The first quantity that is outside [`Self::range`].
    pub fn permittivity(self, frequency_hz: f64, water: SeaWater) -> Result<Complex64, PermittivityError> {
        match self.faults(frequency_hz, water).first() {
            Some(&fault) => Err(fault),
            None => Ok(self.extrapolated(frequency_hz, water)),
        }
    }

    /// The bare formula, whatever the arguments: no claim is made outside [`Self::range`].
    pub fn extrapolated(self, frequency_hz: f64, water: SeaWater) -> Complex64 {
        match self {
            Self::MeissnerWentz2012 => meissner_wentz(frequency_hz, water),
            Self::KleinSwift1977 => klein_swift(frequency_hz, water),
            Self::ItuRP527 => itu_r_p527(frequency_hz, water),
        }
    }
}

fn meissner_wentz(frequency_hz: f64, water: SeaWater) -> Complex64 {
    let SeaWater { temperature_c: t, salinity_gpkg: s } = water;
    let f_ghz = frequency_hz * 1e-9;
    let (t2, t3, t4) = (t * t, t * t * t, t * t * t * t);
    // Pure water.
    let e0 = (3.70886e4 - 82.168 * t) / (421.854 + t);
    let e1 = 5.7230 + 2.2379e-2 * t - 7.1237e-4 * t2;
    let n1 = (45.0 + t) / (5.0478 - 7.0315e-2 * t + 6.0059e-4 * t2);
    let e2 = 3.6143 + 2.8841e-2 * t;
    let n2 = (45.0 + t) / (0.13652 + 1.4825e-3 * t + 2.4166e-4 * t2);
    let sigma_spm = conductivity_spm(water);
    // Salt. The T^3 coefficient of n1 is positive in the printed table: a misprint.
    let e0 = e0 * (-3.3330e-3 * s + 4.74868e-6 * s * s).exp();
    let e1 = e1 * (-6.28908e-3 * s + 1.76032e-4 * s * s - 9.22144e-5 * s * t).exp();
    let n1 = n1
        * if t <= 30.0 {
            1.0 + s * (2.3232e-3 - 7.9208e-5 * t + 3.6764e-6 * t2 - 3.5594e-7 * t3 + 8.9795e-9 * t4)
        } else {
            1.0 + s * (9.1873715e-4 + 1.5012396e-4 * (t - 30.0))
        };
    let n2 = n2 * (1.0 + s * (-1.99723e-2 + 9.0588e-5 * (t + 30.0)));
    let e2 = e2 * (1.0 + s * (-2.04265e-3 + 1.57883e-4 * t));

    (e0 - e1) / Complex64::new(1.0, f_ghz / n1) + (e1 - e2) / Complex64::new(1.0, f_ghz / n2)
        - Complex64::new(-e2, sigma_spm / (TAU * VACUUM_PERMITTIVITY_FPM * frequency_hz))
}

/// Conductivity by the practical salinity scale, as Stogryn et al. 1995 have it, S/m.
fn conductivity_spm(water: SeaWater) -> f64 {
    let SeaWater { temperature_c: t, salinity_gpkg: s } = water;
    let (t2, t3, t4) = (t * t, t * t * t, t * t * t * t);
    let sigma35 = 2.903602 + 8.607e-2 * t + 4.738817e-4 * t2 - 2.991e-6 * t3 + 4.3047e-9 * t4;
    let r15 = s * (37.5109 + 5.45216 * s + 1.4409e-2 * s * s) / (1004.75 + 182.283 * s + s * s);
    let alpha0 = (6.9431 + 3.2841 * s - 9.9486e-2 * s * s) / (84.850 + 69.024 * s + s * s);
    let alpha1 = 49.843 - 0.2276 * s + 1.98e-3 * s * s;
    sigma35 * r15 * (1.0 + (t - 15.0) * alpha0 / (alpha1 + t))
}

fn itu_r_p527(frequency_hz: f64, water: SeaWater) -> Complex64 {
    let SeaWater { temperature_c: t, salinity_gpkg: s } = water;
    let f_ghz = frequency_hz * 1e-9;
    // Pure water.
    let theta = 300.0 / (t + 273.15) - 1.0;
    let e0 = 77.66 + 103.3 * theta;
    let (e1, e2) = (0.0671 * e0, 3.52 - 7.52 * theta);
    let n1 = 20.20 - 146.4 * theta + 316.0 * theta * theta;
    let n2 = 39.8 * n1;
    // Salt.
    let e0 = e0 * (-3.56417e-3 * s + 4.74868e-6 * s * s + 1.15574e-5 * t * s).exp();
    let e1 = e1 * (-6.28908e-3 * s + 1.76032e-4 * s * s - 9.22144e-5 * t * s).exp();
    let n1 = n1 * (1.0 + s * (2.39357e-3 - 3.13530e-5 * t + 2.52477e-7 * t * t));
    let n2 = n2 * (1.0 + s * (-1.99723e-2 + 1.81176e-4 * t));
    let e2 = e2 * (1.0 + s * (-2.04265e-3 + 1.57883e-4 * t));
    let conduction = conductivity_spm(water) / (TAU * VACUUM_PERMITTIVITY_FPM * frequency_hz);
    (e0 - e1) / Complex64::new(1.0, f_ghz / n1) + (e1 - e2) / Complex64::new(1.0, f_ghz / n2)
        - Complex64::new(-e2, conduction)
}

fn klein_swift(frequency_hz: f64, water: SeaWater) -> Complex64 {
    let SeaWater { temperature_c: t, salinity_gpkg: s } = water;
    let omega_radps = TAU * frequency_hz;
    let (t2, t3) = (t * t, t * t * t);
    let (s2, s3) = (s * s, s * s * s);
    let e_static = (87.134 - 0.1949 * t - 1.276e-2 * t2 + 2.491e-4 * t3)
        * (1.0 + 1.613e-5 * s * t - 3.656e-3 * s + 3.210e-5 * s2 - 4.232e-7 * s3);
    let tau_s = (1.768e-11 - 6.086e-13 * t + 1.104e-14 * t2 - 8.111e-17 * t3)
        * (1.0 + 2.282e-5 * s * t - 7.638e-4 * s - 7.760e-6 * s2 + 1.105e-8 * s3);
    let d = 25.0 - t;
    let beta = 2.033e-2 + 1.266e-4 * d + 2.464e-6 * d * d - s * (1.849e-5 - 2.551e-7 * d + 2.551e-8 * d * d);
    let sigma_spm = s * (0.182521 - 1.46192e-3 * s + 2.09324e-5 * s2 - 1.28205e-7 * s3) * (-d * beta).exp();
    let e_infinite = 4.9;
    (e_static - e_infinite) / Complex64::new(1.0, omega_radps * tau_s)
        - Complex64::new(-e_infinite, sigma_spm / (omega_radps * VACUUM_PERMITTIVITY_FPM))
}
