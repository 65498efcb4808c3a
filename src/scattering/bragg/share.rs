//! How many of the waves of a Bragg wave vector run along it, and how many against it.
//!
//! Scattering asks the symmetric spectrum; which of the two lines returns it says the directional one,
//! `share(K) = Psi(K) / [Psi(K) + Psi(-K)]`. It is tabulated over `ln K` and azimuth, both densities averaged
//! over [`WINDOW_RAD`] to either side: two-fold spreadings keep the half of their waves that runs with the
//! wind, and the edge of that half circle is a convention, not a step of the sea.

use std::f64::consts::TAU;

use crate::sea::spectrum::{Spectrum, WaveVector};

/// Half the azimuths that are averaged, rad.
pub const WINDOW_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Rows in a factor e, and most rows.
const ROWS_PER_E: f64 = 8.0;
const MOST_ROWS: usize = 128;
/// Azimuths of a row.
const AZIMUTHS: usize = 144;
/// Azimuths within a window.
const WITHIN: usize = 12;

/// Shares by wave number and azimuth from the wind.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionShare {
    ln_from: f64,
    rows_per_unit: f64,
    rows: Vec<[f32; AZIMUTHS]>,
}

impl DirectionShare {
    /// Of a spectrum between two wave numbers; azimuths count from the downwind unit vector.
    pub fn new(spectrum: &dyn Spectrum, [cos, sin]: [f64; 2], from_radpm: f64, to_radpm: f64) -> Self {
        let ln_from = from_radpm.ln();
        let span = (to_radpm.ln() - ln_from).max(1e-6);
        let steps = ((span * ROWS_PER_E).ceil() as usize).clamp(1, MOST_ROWS);
        let row = |step: usize| {
            let k = (ln_from + span * step as f64 / steps as f64).exp();
            let density = |azimuth: f64| {
                let (s, c) = azimuth.sin_cos();
                let wave = WaveVector::new(k * (cos * c - sin * s), k * (sin * c + cos * s));
                spectrum.wave_m4(wave).max(0.0)
            };
            std::array::from_fn(|place| {
                let azimuth = TAU * place as f64 / AZIMUTHS as f64;
                let (mut with, mut against) = (0.0, 0.0);
                for n in 0..WITHIN {
                    let off = WINDOW_RAD * ((2 * n + 1) as f64 / WITHIN as f64 - 1.0);
                    with += density(azimuth + off);
                    against += density(azimuth + off + 0.5 * TAU);
                }
                let both = with + against;
                if both > 0.0 { (with / both) as f32 } else { 0.5 }
            })
        };
        let rows = (0..=steps).map(row).collect();
        Self { ln_from, rows_per_unit: steps as f64 / span, rows }
    }

    /// Share of the waves that run along a wave vector, given along and across the wind, rad/m: 0 to 1.
    pub fn of(&self, [along, across]: [f64; 2]) -> f64 {
        let last = self.rows.len() - 1;
        let place = (0.5 * (along * along + across * across).ln() - self.ln_from) * self.rows_per_unit;
        let place = if place > 0.0 { place.min(last as f64) } else { 0.0 };
        let row = (place as usize).min(last - 1);
        let turn = (across.atan2(along) / TAU).rem_euclid(1.0) * AZIMUTHS as f64;
        let (column, next) = (turn as usize % AZIMUTHS, (turn as usize + 1) % AZIMUTHS);
        let (down, right) = (place - row as f64, turn - turn.floor());
        let at = |row: usize| {
            let [low, high] = [column, next].map(|column| f64::from(self.rows[row][column]));
            low + right * (high - low)
        };
        let (low, high) = (at(row), at(row + 1));
        low + down * (high - low)
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
                    let found = share.of([k * c, k * s]);
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
            let found = share.of([90.0 * c, 90.0 * s]);
            assert!((found - expected).abs() < 0.01, "{azimuth}: {found} {expected}");
            let opposite = share.of([-90.0 * c, -90.0 * s]);
            assert!((found + opposite - 1.0).abs() < 1e-6);
        }
    }
}
