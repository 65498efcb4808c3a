//! The mean power over range, to be divided out.
//!
//! Power falls with range, and the grazing angle changes along a swath: that is a texture of the geometry,
//! not of the sea. Its logarithm is taken as a parabola in the logarithm of the range, by least squares over
//! the mean powers of the rows of an image. `R^-4` is exactly that.

use glam::{DMat3, DVec3};

/// Divides the trend out of an image (row by row, each row at one range, m) and returns its span over the
/// rows, dB; none, and nothing is done, where fewer than 4 rows have power.
pub fn remove(powers: &mut [f64], columns: usize, ranges_m: &[f64]) -> Option<f64> {
    if columns == 0 {
        return None;
    }
    let middle = ranges_m.iter().sum::<f64>() / ranges_m.len().max(1) as f64;
    let place = |range_m: f64| (range_m / middle).ln();
    let (mut matrix, mut right, mut rows) = (DMat3::ZERO, DVec3::ZERO, 0);
    for (row, range_m) in powers.chunks_exact(columns).zip(ranges_m) {
        let with_power = row.iter().filter(|power| **power > 0.0).count();
        let mean = row.iter().sum::<f64>() / with_power.max(1) as f64;
        let x = place(*range_m);
        if mean > 0.0 && mean.is_finite() && x.is_finite() {
            let terms = DVec3::new(1.0, x, x * x);
            matrix += DMat3::from_cols(terms * terms.x, terms * terms.y, terms * terms.z);
            right += terms * mean.ln();
            rows += 1;
        }
    }
    // Scaled so that a narrow swath is not taken for a singular one.
    let scale = DVec3::new(
        1.0,
        (matrix.y_axis.y / f64::from(rows.max(1))).sqrt(),
        (matrix.z_axis.z / f64::from(rows.max(1))).sqrt(),
    );
    if rows < 4 || !(scale.y > 0.0 && scale.z > 0.0) {
        return None;
    }
    let by = DMat3::from_diagonal(scale.recip());
    let found = by * ((by * matrix * by).inverse() * (by * right));
    if !found.is_finite() {
        return None;
    }
    let trend = |range_m: f64| {
        let x = place(range_m);
        found.y * x + found.z * x * x
    };
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (row, range_m) in powers.chunks_exact_mut(columns).zip(ranges_m) {
        let ln = trend(*range_m);
        if ln.is_finite() {
            (low, high) = (low.min(ln), high.max(ln));
            row.iter_mut().for_each(|power| *power *= (-ln).exp());
        }
    }
    Some((high - low) * 10.0 / std::f64::consts::LN_10)
}
