//! From cells to pixels.

use crate::plot::ticks::LARGEST;

/// What a pixel shows of the cells that it covers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reduction {
    /// Their mean, by area.
    #[default]
    Mean,
    /// In decibels: that of their mean power.
    MeanPower,
    /// The cell in the middle of the pixel.
    Nearest,
}

/// Pixels `[iy][ix]` of a map. A pixel has no value where more than half of it is masked.
pub(super) fn resample(
    values: &[f64],
    cells: [usize; 2],
    pixels: [usize; 2],
    reduction: Reduction,
) -> Vec<f64> {
    let parts = [0, 1].map(|axis| parts(cells[axis], pixels[axis], reduction));
    let mut out = Vec::with_capacity(pixels[0] * pixels[1]);
    for rows in &parts[1] {
        for columns in &parts[0] {
            let covered = || {
                rows.iter().flat_map(move |(iy, down)| {
                    columns.iter().map(move |(ix, across)| (values[iy * cells[0] + ix], down * across))
                })
            };
            out.push(if reduction == Reduction::MeanPower { mean_power(covered) } else { mean(covered()) });
        }
    }
    out
}

/// For every pixel along an axis the cells that it covers, and how much of the pixel each is.
fn parts(cells: usize, pixels: usize, reduction: Reduction) -> Vec<Vec<(usize, f64)>> {
    let ratio = cells as f64 / pixels as f64;
    (0..pixels)
        .map(|pixel| {
            if cells <= pixels || reduction == Reduction::Nearest {
                return vec![((((pixel as f64 + 0.5) * ratio) as usize).min(cells - 1), 1.0)];
            }
            let (from, to) = (pixel as f64 * ratio, (pixel as f64 + 1.0) * ratio);
            (from as usize..(to.ceil() as usize).min(cells))
                .map(|cell| (cell, (to.min(cell as f64 + 1.0) - from.max(cell as f64)) / ratio))
                .filter(|(_, share)| *share > 1e-9)
                .collect()
        })
        .collect()
}

/// Mean of the finite values; if none, the first infinite one.
fn mean(covered: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut sum, mut weight, mut masked) = (0.0, 0.0, 0.0);
    let mut infinite = None;
    for (value, share) in covered {
        if value.is_nan() {
            masked += share;
        } else if value.abs() > LARGEST {
            infinite.get_or_insert(value.signum() * f64::INFINITY);
        } else {
            sum += share * value;
            weight += share;
        }
    }
    match infinite {
        _ if masked > 0.5 => f64::NAN,
        _ if weight > 0.0 => sum / weight,
        Some(value) => value,
        None => f64::NAN,
    }
}

/// Decibels of the mean power.
fn mean_power<I: Iterator<Item = (f64, f64)>>(covered: impl Fn() -> I) -> f64 {
    let top = covered().map(|(value, _)| value).fold(f64::NEG_INFINITY, f64::max);
    let masked: f64 = covered().filter(|(value, _)| value.is_nan()).map(|(_, share)| share).sum();
    if masked > 0.5 {
        return f64::NAN;
    }
    if top.is_infinite() {
        return top;
    }
    let seen = || covered().filter(|(value, _)| !value.is_nan());
    let weight: f64 = seen().map(|(_, share)| share).sum();
    let power: f64 = seen().map(|(value, share)| share * 10f64.powf((value - top) / 10.0)).sum();
    top + 10.0 * (power / weight).log10()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn small_maps_are_repeated_and_single_cells_stay() {
        let pixels = resample(&[1.0, 2.0, f64::NAN, 4.0], [2, 2], [4, 2], Reduction::Mean);
        assert_eq!(pixels[..4], [1.0, 1.0, 2.0, 2.0]);
        assert!(pixels[4].is_nan() && pixels[7] == 4.0);
    }

    #[test]
    fn powers_add_and_masks_need_half() {
        let mean = |values: &[f64]| resample(values, [values.len(), 1], [1, 1], Reduction::MeanPower)[0];
        assert!((mean(&[0.0, 10.0]) - 10.0 * 5.5f64.log10()).abs() < 1e-12);
        assert!((mean(&[-2000.0, f64::NEG_INFINITY]) + 2000.0 - 10.0 * 0.5f64.log10()).abs() < 1e-9);
        assert_eq!(mean(&[f64::NEG_INFINITY; 3]), f64::NEG_INFINITY);
        assert!((mean(&[7.0, f64::NAN]) - 7.0).abs() < 1e-12);
        assert!(mean(&[f64::NAN, f64::NAN, 1.0]).is_nan());
    }

    proptest! {
        /// Conservation: the mean of the pixels is that of the cells.
        #[test]
        fn the_mean_is_kept(
            values in prop::collection::vec(-1.0..1.0f64, 35..600),
            columns in 5usize..35,
            across in 1usize..6,
            down in 1usize..4,
        ) {
            let rows = (values.len() / columns).max(1);
            prop_assume!(rows >= down);
            let values = &values[..rows * columns];
            let pixels = resample(values, [columns, rows], [across, down], Reduction::Mean);
            let of = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
            // Parts of cells below 1e-9 of a pixel are left out (at most two a side), the rest is rounding.
            prop_assert!((of(&pixels) - of(values)).abs() < 1e-8);
        }
    }
}
