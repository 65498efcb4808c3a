//! Antenna patterns as arrays of gain and phase over direction cosines.
//!
//! The frame of an antenna in CRSD has its boresight along z; here x of CRSD is our y (horizontal aperture
//! axis) and y of CRSD our z (vertical). Gains are relative to the boresight (dB), phases too (cycles);
//! directions outside the unit circle have no data. The gain along the boresight itself is in the radiant
//! intensity of pulses and in the reference irradiance of channels.

use std::f64::consts::TAU;

use crate::frames::Vector;
use crate::radar::antenna::Antenna;
use crate::scene::radar::Pattern;

/// Cells of an array between a null of an aperture and the next.
const CELLS: f64 = 16.0;
/// Side lobes of an aperture that an array reaches to.
const LOBES: f64 = 8.0;
/// Most cells from the boresight to the rim.
const MOST: f64 = 256.0;
/// Least gain, dB below the boresight.
const LEAST_DB: f64 = -200.0;

/// Gain and phase over direction cosines.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GainArray {
    /// Rows (along x) and columns (along y), odd: the boresight is in the middle.
    pub size: [usize; 2],
    /// Distance of rows and columns.
    pub step: [f64; 2],
    /// Gain (dB) and phase (cycles), row by row.
    pub values: Vec<[f32; 2]>,
    /// Power gain along the boresight.
    pub peak: f64,
}

impl GainArray {
    /// Of an antenna.
    pub fn of(antenna: &Antenna, pattern: &Pattern, wavelength_m: f64) -> Self {
        let (sides, steps): (Vec<usize>, Vec<f64>) = match *pattern {
            Pattern::Isotropic { .. } => {
                let peak = antenna.field_gain(Vector::new(1.0, 0.0, 0.0)).norm_sqr();
                return Self { peak, ..Self::flat() };
            }
            Pattern::Rectangle { width_m, height_m }
            | Pattern::Tapered { width_m, height_m, .. }
            | Pattern::Ellipse { width_m, height_m } => {
                [width_m, height_m].map(|side_m| aperture(wavelength_m / side_m)).into_iter().unzip()
            }
            Pattern::File { .. } => [(MOST as usize, 1.0 / MOST); 2].into_iter().unzip(),
        };
        let ahead = antenna.field_gain(Vector::new(1.0, 0.0, 0.0));
        let size = [2 * sides[0] + 1, 2 * sides[1] + 1];
        let mut values = Vec::with_capacity(size[0] * size[1]);
        for row in 0..size[0] {
            for column in 0..size[1] {
                let u = (row as f64 - sides[0] as f64) * steps[0];
                let v = (column as f64 - sides[1] as f64) * steps[1];
                values.push(match 1.0 - u * u - v * v {
                    rest if rest < 0.0 => [f32::NAN; 2],
                    rest => {
                        let ratio = antenna.field_gain(Vector::new(rest.sqrt().max(1e-9), u, v)) / ahead;
                        let gain_db = (20.0 * ratio.norm().log10()).max(LEAST_DB);
                        [gain_db as f32, (ratio.arg() / TAU) as f32]
                    }
                });
            }
        }
        Self { size, step: [steps[0], steps[1]], values, peak: ahead.norm_sqr() }
    }

    /// An element that is the same everywhere.
    pub fn flat() -> Self {
        Self { size: [3, 3], step: [1.0; 2], values: vec![[0.0; 2]; 9], peak: 1.0 }
    }

    /// Direction cosine of the first row or column.
    pub fn first(&self, axis: usize) -> f64 {
        -((self.size[axis] / 2) as f64) * self.step[axis]
    }

    /// Whether some directions have no data.
    pub fn has_gaps(&self) -> bool {
        self.values.iter().any(|[gain, _]| gain.is_nan())
    }
}

/// Cells from the boresight to the rim, and their distance, of an aperture whose nulls lie `null` apart.
fn aperture(null: f64) -> (usize, f64) {
    let reach = (LOBES * null).min(1.0);
    let cells = (reach * CELLS / null).ceil().clamp(2.0, MOST);
    (cells as usize, reach / cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_aperture_has_its_first_sidelobe() {
        let pattern = Pattern::Rectangle { width_m: 4.0, height_m: 0.05 };
        let antenna = Antenna::open(&pattern, 0.03).unwrap();
        let array = GainArray::of(&antenna, &pattern, 0.03);
        assert_eq!(array.size[0], 2 * 128 + 1);
        let at = |row: usize, column: usize| array.values[row * array.size[1] + column];
        let [row, column] = array.size.map(|n| n / 2);
        assert_eq!(at(row, column), [0.0, 0.0]);
        // 1.43 nulls away: -13.26 dB, and the field turns its sign.
        let [gain_db, phase] = at(row + 23, column);
        assert!((gain_db + 13.26).abs() < 0.1 && (phase.abs() - 0.5).abs() < 1e-6, "{gain_db} {phase}");
        assert!((array.first(0) + 8.0 * 0.03 / 4.0).abs() < 1e-12 && array.has_gaps());
    }
}
