//! Errors of pixels that waves make alike.
//!
//! Speckle of pixels a cell apart is independent; the power beneath it is not: it follows waves of up to
//! hundreds of metres. Errors that take pixels as independent are then too small. Here the image is cut into
//! blocks, each in turn is left out, and the spread of what is left gives the error (jackknife):
//!
//! ```text
//! error^2 = (G - 1)/G sum_g (1/nu_g - <1/nu_g>)^2,   1/nu_g without block g
//! ```
//!
//! Limits: right where blocks are wider than what makes pixels alike, and to `1/sqrt(2 G)`.

use rayon::prelude::*;

use super::laws::Kind;
use super::likelihood;
use super::sample::Bins;

/// Blocks along a side.
pub const SIDE: usize = 5;

/// Standard error of `1/nu` of the K law that is most likely, over 5 x 5 blocks of an image (row by row);
/// none where a block has fewer than 2 pixels.
pub fn inverse_shape_error(powers: &[f64], pixels: [usize; 2]) -> Option<f64> {
    let [columns, rows] = pixels;
    if columns < 2 * SIDE || rows < 2 * SIDE || powers.len() < columns * rows {
        return None;
    }
    let edges = |length: usize, i: usize| length * i / SIDE;
    let block = |place: usize| {
        let (i, j) = (place % SIDE, place / SIDE);
        let row =
            move |y: usize| &powers[y * columns + edges(columns, i)..y * columns + edges(columns, i + 1)];
        Bins::of((edges(rows, j)..edges(rows, j + 1)).flat_map(row).copied())
    };
    let whole = Bins::of(powers.iter().take(columns * rows).copied());
    let inverses: Vec<f64> = (0..SIDE * SIDE)
        .into_par_iter()
        .map(|place| likelihood::of_bins(&whole.without(&block(place)), Kind::K).law.shape().recip())
        .collect();
    let n = inverses.len() as f64;
    let mean = inverses.iter().sum::<f64>() / n;
    let spread: f64 = inverses.iter().map(|x| (x - mean) * (x - mean)).sum();
    let error = ((n - 1.0) / n * spread).sqrt();
    error.is_finite().then_some(error)
}
