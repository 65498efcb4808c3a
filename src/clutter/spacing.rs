//! How far apart pixels are independent.

use crate::processor::point_target::Support;
use crate::processor::taper::Taper;
use crate::recording::ground::Ground;

/// Neighbours that are looked at, to either side, and most pixels from one to the next.
const AROUND: i64 = 8;
const MOST_STEP: i64 = 32_768;

/// Pixels to the East and to the North after which the response to a point has fallen: a cell in range or in
/// cross-range, by as much wider as the tapers over the band and over the pulses make it. No two pixels that
/// are taken lie nearer, whatever way the line of sight goes over the image.
pub fn independent_step(ground: &Ground, support: &Support, tapers: [Taper; 2]) -> [usize; 2] {
    let wide = tapers.map(|taper| taper.width() / 0.8859);
    let away = |i: i64, j: i64| {
        let of = |k: usize| i as f64 * ground.step_x_m[k] + j as f64 * ground.step_y_m[k];
        let cells = support.cells([of(0), of(1)]);
        (cells[0].abs() / wide[0]).max(cells[1].abs() / wide[1])
    };
    // A pixel of exactly a cell is one, in spite of rounding.
    let alone = |away: f64| (away.recip() - 1e-3).ceil().clamp(1.0, MOST_STEP as f64) as i64;
    let [mut x, mut y] = [alone(away(1, 0)), alone(away(0, 1))];
    // Across an oblique line of sight neighbours may lie along a cell's diagonal: the closer step grows until
    // none does.
    let near = |x: i64, y: i64| {
        (-AROUND..=AROUND)
            .flat_map(|i| (0..=AROUND).map(move |j| (i, j)))
            .any(|(i, j)| (i, j) != (0, 0) && away(i * x, j * y) < 1.0 - 1e-3)
    };
    while near(x, y) && x.max(y) < MOST_STEP {
        if x <= y { x += 1 } else { y += 1 }
    }
    [x as usize, y as usize]
}
