//! Antenna patterns of FERS, as antennas of a scenario.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;

/// Points of a table along azimuth and along elevation, on either side of the boresight.
const POINTS: i32 = 60;
/// How far a table reaches, in widths of the main lobe, and the gain beyond it, dBi.
const WIDTHS: f64 = 10.0;
const FLOOR_DBI: f64 = -200.0;

/// A pattern: gain over that of an isotropic antenna by the angles off the boresight, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pattern {
    Isotropic {
        gain: f64,
    },
    /// Of a circular aperture of uniform illumination.
    Circle {
        diameter_m: f64,
    },
    /// `gain |sin(b theta)/(b theta)|^power`.
    Sinc {
        gain: f64,
        per_rad: f64,
        power: f64,
    },
    /// `gain sinc^2(pi a sin(theta)/lambda)`, the same around the boresight.
    Horn {
        gain: f64,
        wavelengths: f64,
    },
    /// `gain (2 J_1(x)/x)^2`, `x = pi a sin(theta)/lambda`.
    Dish {
        gain: f64,
        wavelengths: f64,
    },
    /// `gain exp(-a az^2 - b el^2)`.
    Gaussian {
        gain: f64,
        per_rad2: [f64; 2],
    },
}

impl Pattern {
    /// Gain at an azimuth and an elevation.
    pub fn gain(&self, az_rad: f64, el_rad: f64) -> f64 {
        let cosine = az_rad.cos() * el_rad.cos();
        let theta_rad = cosine.clamp(-1.0, 1.0).acos();
        match *self {
            Self::Isotropic { gain } => gain,
            Self::Circle { .. } => f64::NAN,
            Self::Sinc { gain, per_rad, power } => gain * sinc(per_rad * theta_rad).abs().powf(power),
            Self::Horn { gain, wavelengths } => gain * sinc(PI * wavelengths * theta_rad.sin()).powi(2),
            Self::Dish { gain, wavelengths } => {
                let x = PI * wavelengths * theta_rad.sin();
                gain * if x.abs() < 1e-6 { 1.0 } else { (2.0 * libm::j1(x) / x).powi(2) }
            }
            Self::Gaussian { gain, per_rad2: [a, b] } => {
                gain * (-a * az_rad * az_rad - b * el_rad * el_rad).exp()
            }
        }
    }

    /// The value of the key `antenna`; `file` is the name of [`Self::table`].
    pub fn toml(&self, file: &str) -> String {
        match self {
            Self::Isotropic { gain } => {
                format!("{{ kind = \"isotropic\", gain_dbi = {:?} }}", 10.0 * gain.log10())
            }
            Self::Circle { diameter_m } => format!("{{ kind = \"circle\", diameter_m = {diameter_m:?} }}"),
            _ => format!("{{ kind = \"file\", path = \"{file}\", floor_dbi = {FLOOR_DBI:?} }}"),
        }
    }

    /// Its gains as a table, CSV, where it needs one.
    pub fn table(&self) -> Option<String> {
        let [az_rad, el_rad] = self.widths_rad()?.map(|width| (WIDTHS * width).min(FRAC_PI_2));
        let mut text = "az_deg,el_deg,gain_dbi\n".to_owned();
        for el in -POINTS..=POINTS {
            for az in -POINTS..=POINTS {
                let [az, el] =
                    [az_rad * f64::from(az), el_rad * f64::from(el)].map(|rad| rad / f64::from(POINTS));
                let gain_dbi = (10.0 * self.gain(az, el).log10()).max(FLOOR_DBI);
                // Writing to a String cannot fail.
                let _ = writeln!(text, "{:.6},{:.6},{gain_dbi:.4}", az.to_degrees(), el.to_degrees());
            }
        }
        Some(text)
    }

    /// From the boresight to the first null, or to where a Gaussian is e^-1, along azimuth and elevation.
    fn widths_rad(&self) -> Option<[f64; 2]> {
        Some(match *self {
            Self::Isotropic { .. } | Self::Circle { .. } => return None,
            Self::Sinc { per_rad, .. } => [PI / per_rad.abs().max(1e-6); 2],
            Self::Horn { wavelengths, .. } | Self::Dish { wavelengths, .. } => {
                [1.0 / wavelengths.max(1e-6); 2]
            }
            Self::Gaussian { per_rad2, .. } => per_rad2.map(|per_rad2| 0.5 / per_rad2.abs().max(1e-6).sqrt()),
        })
    }
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.sin() / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_are_those_of_the_formulas() {
        let horn = Pattern::Horn { gain: 100.0, wavelengths: 2.0 };
        // At sin(theta) = 1/4 sinc(pi/2)^2 = 4/pi^2.
        assert!((horn.gain(0.25f64.asin(), 0.0) - 400.0 / (PI * PI)).abs() < 1e-9);
        // The first null of a circular aperture: 1.2197 wavelengths over its diameter.
        let dish = Pattern::Dish { gain: 1.0, wavelengths: 10.0 };
        assert!(dish.gain(0.0, 0.121_966_989f64.asin()) < 1e-12);
        let gaussian = Pattern::Gaussian { gain: 2.0, per_rad2: [4.0, 1.0] };
        assert!((gaussian.gain(0.5, 0.0) - 2.0 * (-1.0f64).exp()).abs() < 1e-12);
        assert!(gaussian.table().unwrap().lines().count() == 121 * 121 + 1);
        let isotropic = Pattern::Isotropic { gain: 0.5 };
        assert_eq!((isotropic.table(), isotropic.toml("").contains("-3.01")), (None, true));
    }
}
