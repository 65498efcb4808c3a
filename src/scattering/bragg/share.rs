//! How many of the waves of a Bragg wave vector run along it, and how many against it.
//!
//! Scattering asks the symmetric spectrum; which of the two lines returns it says the directional one,
//! `share(K) = Psi(K) / [Psi(K) + Psi(-K)]`. Both densities are means over 15 degrees (5 rms) to either side,
//! weighted by `(1 - x^2)^3`: two-fold spreadings keep the half of their waves that runs with the wind, and
//! the edge of that half circle is a convention, not a step of the sea. The weights make the root of the
//! share smooth where it ends, so that the fast echo may take it as straight over a block. Roots are
//! tabulated over wave number and azimuth.

use std::f64::consts::TAU;

use super::group::{GROUP, Looks};
use super::{octaves, octaves_f32, of_octaves};
use crate::sea::spectrum::{Spectrum, WaveVector};

/// Rows in an octave, and most rows.
const ROWS_PER_OCTAVE: f64 = 6.0;
const MOST_ROWS: usize = 128;
/// Azimuths of a row, and of half a window.
const AZIMUTHS: usize = 720;
const WITHIN: usize = 30;

/// Shares by wave number and azimuth from the wind.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionShare {
    octaves_from: f64,
    rows_per_octave: f64,
    /// `[row][quarters]`: roots along and against.
    rows: Vec<[[f32; 2]; AZIMUTHS]>,
}

impl DirectionShare {
    /// Of a spectrum between two wave numbers; azimuths count from the downwind unit vector.
    pub fn new(spectrum: &dyn Spectrum, [cos, sin]: [f64; 2], from_radpm: f64, to_radpm: f64) -> Self {
        let octaves_from = octaves(from_radpm);
        let span = (octaves(to_radpm) - octaves_from).max(1e-6);
        let steps = ((span * ROWS_PER_OCTAVE).ceil() as usize).clamp(1, MOST_ROWS);
        let mut rows = Vec::with_capacity(steps + 1);
        for step in 0..=steps {
            let k = of_octaves(octaves_from + span * step as f64 / steps as f64);
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
            let mean = |azimuth: f64| {
                let place = (azimuth / TAU).rem_euclid(1.0) * AZIMUTHS as f64;
                let (low, right) = (place as usize, place.fract());
                let at = |place: usize| means[place % AZIMUTHS];
                at(low) + right * (at(low + 1) - at(low))
            };
            rows.push(std::array::from_fn(|place| {
                let azimuth = of_quarters(4.0 * place as f64 / AZIMUTHS as f64);
                let (with, against) = (mean(azimuth), mean(azimuth + 0.5 * TAU));
                let root = |own: f64| (own / (with + against)).sqrt() as f32;
                if with + against > 0.0 {
                    [root(with), root(against)]
                } else {
                    [std::f32::consts::FRAC_1_SQRT_2; 2]
                }
            }));
        }
        Self { octaves_from, rows_per_octave: steps as f64 / span, rows }
    }

    /// Roots of the shares of the waves that run along a wave vector and against it, given along and across
    /// the wind, rad/m.
    #[inline]
    pub fn roots(&self, [along, across]: [f64; 2], magnitude: f64) -> [f64; 2] {
        let last = self.rows.len() - 1;
        let place = (octaves(magnitude) - self.octaves_from) * self.rows_per_octave;
        let place = if place > 0.0 { place.min(last as f64) } else { 0.0 };
        let turn = quarters(along, across) * (0.25 * AZIMUTHS as f64);
        let (row, column) = ((place as usize).min(last - 1), (turn as usize).min(AZIMUTHS - 1));
        self.at(row, column, (place - row as f64) as f32, (turn - column as f64) as f32).map(f64::from)
    }

    /// The same of a group of facets, given their wave vectors, the unit vector downwind and the wave
    /// numbers.
    #[inline(always)]
    pub(super) fn roots_of_group(
        &self,
        [x, y, _]: &Looks,
        [cos, sin]: [f32; 2],
        magnitude: &[f32; GROUP],
        [with, against]: &mut [[f32; GROUP]; 2],
    ) {
        let last = self.rows.len() - 1;
        let (octaves_from, rows_per_octave) = (self.octaves_from as f32, self.rows_per_octave as f32);
        let (mut places, mut turns) = ([0.0; GROUP], [0.0; GROUP]);
        for i in 0..GROUP {
            let place = (octaves_f32(magnitude[i]) - octaves_from) * rows_per_octave;
            places[i] = if place > 0.0 { place.min(last as f32) } else { 0.0 };
            let (along, across) = (cos * x[i] + sin * y[i], cos * y[i] - sin * x[i]);
            turns[i] = quarters_f32(along, across) * (0.25 * AZIMUTHS as f32);
        }
        for i in 0..GROUP {
            let (row, column) = ((places[i] as usize).min(last - 1), (turns[i] as usize).min(AZIMUTHS - 1));
            [with[i], against[i]] = self.at(row, column, places[i] - row as f32, turns[i] - column as f32);
        }
    }

    /// Between rows and columns of the table.
    #[inline(always)]
    fn at(&self, row: usize, column: usize, down: f32, right: f32) -> [f32; 2] {
        let next = if column + 1 < AZIMUTHS { column + 1 } else { 0 };
        let [a, b] = [&self.rows[row], &self.rows[row + 1]].map(|row| [row[column], row[next]]);
        [0, 1].map(|way| {
            let [[a0, a1], [b0, b1]] = [a, b].map(|row| row.map(|roots| roots[way]));
            let (a, b) = (a0 + right * (a1 - a0), b0 + right * (b1 - b0));
            a + down * (b - a)
        })
    }
}

/// Near the azimuth of a vector in quarters of a turn, 0 to 4: straight on a square, for it costs less than
/// an angle.
#[inline(always)]
fn quarters(x: f64, y: f64) -> f64 {
    let up = y / (x.abs() + y.abs()).max(f64::MIN_POSITIVE);
    if x < 0.0 {
        2.0 - up
    } else if y < 0.0 {
        4.0 + up
    } else {
        up
    }
}

/// The same in single precision.
#[inline(always)]
fn quarters_f32(x: f32, y: f32) -> f32 {
    let up = y / (x.abs() + y.abs()).max(f32::MIN_POSITIVE);
    if x < 0.0 {
        2.0 - up
    } else if y < 0.0 {
        4.0 + up
    } else {
        up
    }
}

/// Azimuth of some quarters, rad.
fn of_quarters(quarters: f64) -> f64 {
    let (corner, up) = (quarters.floor(), quarters.fract());
    0.25 * TAU * corner + up.atan2(1.0 - up)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarters_are_azimuths() {
        for n in 0..400 {
            let (sin, cos) = (TAU * f64::from(n) / 400.0).sin_cos();
            let off =
                (of_quarters(quarters(3.0 * cos, 3.0 * sin)) / TAU - f64::from(n) / 400.0).rem_euclid(1.0);
            assert!(off.min(1.0 - off) < 1e-12, "{n}: {off}");
        }
    }
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
                    let found = share.roots([k * c, k * s], k)[0].powi(2);
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
            let [found, opposite] = share.roots([90.0 * c, 90.0 * s], 90.0).map(|root| root * root);
            assert!((found - expected).abs() < 0.01, "{azimuth}: {found} {expected}");
            assert!((found + opposite - 1.0).abs() < 1e-4);
        }
    }
}
