//! A smooth function from equidistant values.

use num_complex::Complex64;

use crate::radar::phasor::phasor;

/// Points of an interpolation.
pub(super) const POINTS: usize = 12;
/// Entries per resolution of a spectrum, `1/Tc`.
pub(super) const OVERSAMPLING: usize = 16;

/// `(-1)^i binomial(11, i)`: barycentric weights of 12 equidistant points.
const WEIGHTS: [f64; POINTS] =
    [1.0, -11.0, 55.0, -165.0, 330.0, -462.0, 462.0, -330.0, 165.0, -55.0, 11.0, -1.0];

/// A function between its values in `table`, by Lagrange interpolation over [`POINTS`] of them.
///
/// `place` counts entries and has `POINTS / 2` of them on either side. A function whose fastest part turns by
/// `h` per entry is off by at most `(h^12 / 12!) prod (m - 1/2)^2, m = 1..6`. 0 outside.
pub(super) fn at(table: &[Complex64], place: f64) -> Complex64 {
    let first = place as usize + 1 - POINTS / 2;
    let t = place - first as f64;
    let Some(points) = table.get(first..first + POINTS) else { return Complex64::ZERO };
    let (mut above, mut below) = (Complex64::ZERO, 0.0);
    for (i, (value, weight)) in points.iter().zip(&WEIGHTS).enumerate() {
        let distance = t - i as f64;
        if distance == 0.0 {
            above = *value;
            below = 1.0;
            break;
        }
        let share = weight / distance;
        above += value * share;
        below += share;
    }
    above / below
}

/// The table of a sum over samples `p_j`, for [`at`], and how many of its entries fall on one `rate`:
/// `sum p_j e^{-j 2 pi (m/cells) (j - middle)} / rate`, `m = -cells/2 - POINTS/2 ..= cells/2 + POINTS/2`.
pub(super) fn of_sum(samples: &[Complex64], rate_hz: f64) -> (usize, Vec<Complex64>) {
    let len = samples.len();
    let middle = 0.5 * (len as f64 - 1.0);
    // Even, so that +-rate/2 falls on a cell.
    let cells = (OVERSAMPLING * len).next_multiple_of(2);
    let mut spectrum = samples.to_vec();
    spectrum.resize(cells, Complex64::ZERO);
    nereus_fft::forward(cells).process(&mut spectrum);
    let margin = (POINTS / 2) as i64;
    let half = (cells / 2) as i64;
    let entry = |m: i64| {
        let bin = m.rem_euclid(cells as i64) as usize;
        spectrum[bin] * phasor(m as f64 * middle / cells as f64) / rate_hz
    };
    (cells, (-half - margin..=half + margin).map(entry).collect())
}
