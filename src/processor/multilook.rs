//! Fewer, smoother pixels, and how bright the brightest may be shown.
//!
//! Looks are means of power over `n x n` neighbouring pixels: speckle falls as `1/sqrt(n^2)` while pixels are
//! no closer than the resolution. A [`percentile`] of 98 % sets the upper end of the scale, as in the paper.
//!
//! ```
//! use nereus::processor::multilook::{multilook, percentile};
//! let (power, pixels) = multilook(&[1.0, 3.0, 5.0, 7.0, 100.0, 100.0], [3, 2], 2);
//! assert_eq!((power, pixels), (vec![(1.0 + 3.0 + 7.0 + 100.0) / 4.0], [1, 1]));
//! assert_eq!(percentile(&[4.0, 1.0, 3.0, 2.0, f64::NAN], 50.0), Some(2.0));
//! ```

/// Means of power over `looks` by `looks` pixels; what does not fill a block at the far edges is left out.
/// `pixels` are along x and y; looks beyond the shorter side are taken as that side.
pub fn multilook(power: &[f64], pixels: [usize; 2], looks: usize) -> (Vec<f64>, [usize; 2]) {
    let looks = looks.max(1).min(pixels[0].max(1)).min(pixels[1].max(1));
    let blocks = pixels.map(|n| n / looks);
    let mean = |bx: usize, by: usize| {
        let sum: f64 = (0..looks)
            .flat_map(|y| (0..looks).map(move |x| (bx * looks + x, by * looks + y)))
            .map(|(x, y)| power.get(y * pixels[0] + x).copied().unwrap_or(f64::NAN))
            .sum();
        sum / (looks * looks) as f64
    };
    let out = (0..blocks[1]).flat_map(|by| (0..blocks[0]).map(move |bx| (bx, by)));
    (out.map(|(bx, by)| mean(bx, by)).collect(), blocks)
}

/// Mean and peak of powers, and their contrast `<I^2>/<I>^2`: 2 for speckle, 0 without power.
pub fn levels(power: &[f64]) -> [f64; 3] {
    let mean = |order: i32| power.iter().map(|p| p.powi(order)).sum::<f64>() / power.len().max(1) as f64;
    // Powers of 1e-15 W squared are no numbers of f32, but of f64.
    let contrast = if mean(1) > 0.0 { mean(2) / mean(1).powi(2) } else { 0.0 };
    [mean(1), power.iter().copied().fold(0.0, f64::max), contrast]
}

/// The value that `percent` of the finite values do not exceed; none if there is no finite value.
pub fn percentile(values: &[f64], percent: f64) -> Option<f64> {
    let mut finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    if finite.is_empty() {
        return None;
    }
    let rank = (percent.clamp(0.0, 100.0) / 100.0 * finite.len() as f64).ceil() as usize;
    let at = rank.saturating_sub(1).min(finite.len() - 1);
    let (_, value, _) = finite.select_nth_unstable_by(at, f64::total_cmp);
    Some(*value)
}
