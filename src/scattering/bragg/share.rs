//! How many of the waves of a Bragg wave vector run along it, and how many against it.
//!
//! Scattering asks the symmetric spectrum; which of the two lines returns it says the directional one,
//! `share(K) = Psi(K) / [Psi(K) + Psi(-K)]`. Both densities are means over [`WINDOW_RAD`] to either side,
//! weighted by `(1 - x^2)^3`: two-fold spreadings keep the half of their waves that runs with the wind, and
//! the edge of that half circle is a convention, not a step of the sea. The weights make the root of the share
//! smooth where it ends, so that the fast echo may take it as straight over a block. Roots are tabulated over
//! `ln K` and azimuth.

use std::f64::consts::TAU;

use crate::sea::spectrum::{Spectrum, WaveVector};

/// Half the azimuths that are averaged, rad: 5 degrees rms.
pub const WINDOW_RAD: f64 = TAU * WITHIN as f64 / AZIMUTHS as f64;
/// Rows in a factor e, and most rows.
const ROWS_PER_E: f64 = 8.0;
const MOST_ROWS: usize = 128;
/// Azimuths of a row, and of half a window.
const AZIMUTHS: usize = 720;
const WITHIN: usize = 30;

/// Shares by wave number and azimuth from the wind.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionShare {
    ln_from: f64,
    rows_per_unit: f64,
    /// `[row][azimuth]`: roots.
    rows: Vec<f32>,
}

impl DirectionShare {
    /// Of a spectrum between two wave numbers; azimuths count from the downwind unit vector.
    pub fn new(spectrum: &dyn Spectrum, [cos, sin]: [f64; 2], from_radpm: f64, to_radpm: f64) -> Self {
        let ln_from = from_radpm.ln();
        let span = (to_radpm.ln() - ln_from).max(1e-6);
        let steps = ((span * ROWS_PER_E).ceil() as usize).clamp(1, MOST_ROWS);
        let mut rows = Vec::with_capacity((steps + 1) * AZIMUTHS);
        for step in 0..=steps {
            let k = (ln_from + span * step as f64 / steps as f64).exp();
            // Between the azimuths of the row, so that both sides of an edge count the same.
            let density = |place: usize| {
                let (s, c) = (TAU * (place as f64 + 0.5) / AZIMUTHS as f64).sin_cos();
                let wave = WaveVector::new(k * (cos * c - sin * s), k * (sin * c + cos * s));
                spectrum.wave_m4(wave).max(0.0)
            };
            let densities: Vec<f64> = (0..AZIMUTHS).map(density).collect();
            let about = |place: usize| -> f64 {
                let of = |n: usize| {
                    let x = (n as f64 + 0.5) / WITHIN as f64 - 1.0;
                    (1.0 - x * x).powi(3) * densities[(place + n + AZIMUTHS - WITHIN) % AZIMUTHS]
                };
                (0..2 * WITHIN).map(of).sum()
            };
            let means: Vec<f64> = (0..AZIMUTHS).map(about).collect();
            rows.extend((0..AZIMUTHS).map(|place| {
                let (with, against) = (means[place], means[(place + AZIMUTHS / 2) % AZIMUTHS]);
                let both = with + against;
                if both > 0.0 { (with / both).sqrt() as f32 } else { std::f32::consts::FRAC_1_SQRT_2 }
            }));
        }
        Self { ln_from, rows_per_unit: steps as f64 / span, rows }
    }

    /// Roots of the shares of the waves that run along a wave vector and against it, given along and across
    /// the wind, rad/m.
    pub fn roots(&self, [along, across]: [f64; 2]) -> [f64; 2] {
        let last = self.rows.len() / AZIMUTHS - 1;
        let place = (0.5 * (along * along + across * across).ln() - self.ln_from) * self.rows_per_unit;
        let place = if place > 0.0 { place.min(last as f64) } else { 0.0 };
        let row = (place as usize).min(last - 1);
        let turn = (across.atan2(along) / TAU + 1.0) * AZIMUTHS as f64;
        let (column, down) = (turn as usize, place - row as f64);
        let right = turn - column as f64;
        [0, AZIMUTHS / 2].map(|turned| {
            let at = |row: usize, column: usize| {
                let column = (column + turned) % AZIMUTHS;
                self.rows.get(row * AZIMUTHS + column).map_or(0.0, |root| f64::from(*root))
            };
            let of = |row: usize| {
                let low = at(row, column);
                low + right * (at(row, column + 1) - low)
            };
            let low = of(row);
            low + down * (of(row + 1) - low)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::water::{Development, SpectrumKind, Spreading, WindProfile};
    use crate::sea::spectrum::of_kind;
    use crate::sea::wind::Wind;

    fn wind(direction_rad: f64) -> Wind {
        Wind::from_speed(6.0, 10.0, WindProfile::Cardone, direction_rad).unwrap()
    }

    #[test]
    fn a_half_circle_is_one_line_upwind_and_two_across() {
        for direction_rad in [0.0f64, 1.1, -2.5] {
            let kind = SpectrumKind::Elfouhaily { development: Development::default() };
            let spectrum = of_kind(&kind, &wind(direction_rad)).unwrap();
            let (sin, cos) = direction_rad.sin_cos();
            let share = DirectionShare::new(spectrum.as_ref(), [cos, sin], 10.0, 400.0);
            for k in [10.0, 47.0, 300.0] {
                for (azimuth_deg, expected) in
                    [(0.0f64, 1.0), (75.0, 1.0), (90.0, 0.5), (105.0, 0.0), (180.0, 0.0), (270.0, 0.5)]
                {
                    let (s, c) = azimuth_deg.to_radians().sin_cos();
                    let found = share.roots([k * c, k * s])[0].powi(2);
                    assert!((found - expected).abs() < 0.01, "{direction_rad} {k} {azimuth_deg}: {found}");
                }
            }
        }
    }

    /// `cos^2s(phi/2)` has the ratio `tan^2s(phi/2)`: the window leaves 1 % of it.
    #[test]
    fn a_power_of_the_cosine_is_as_it_is() {
        let kind = SpectrumKind::PiersonMoskowitz { spreading: Spreading::Constant(2.0) };
        let spectrum = of_kind(&kind, &wind(0.4)).unwrap();
        let (sin, cos) = 0.4f64.sin_cos();
        let share = DirectionShare::new(spectrum.as_ref(), [cos, sin], 10.0, 400.0);
        for azimuth in [0.1f64, 0.8, 1.4, 2.0, -1.2] {
            let (s, c) = azimuth.sin_cos();
            let expected = 1.0 / (1.0 + (0.5 * azimuth).tan().powi(4));
            let [found, opposite] = share.roots([90.0 * c, 90.0 * s]).map(|root| root * root);
            assert!((found - expected).abs() < 0.01, "{azimuth}: {found} {expected}");
            assert!((found + opposite - 1.0).abs() < 1e-4);
        }
    }
}
