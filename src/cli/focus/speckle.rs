//! Laws fitted to the pixels of an image.

use std::io::Write;

use super::{FocusArgs, Focused, Ground, Recording};
use crate::cli::focus::error::FocusError;
use crate::cli::speckle::{Speckle, SpeckleSettings};
use crate::processor::point_target::Support;

/// Samples drawn from a law, and most pixels of a test.
const RESAMPLES: usize = 99;
const TEST_PIXELS: usize = 10_000;
/// Neighbours that are looked at, to either side, and most pixels from one to the next.
const AROUND: i64 = 8;
const MOST_STEP: i64 = 32_768;

/// Statistics of one channel, of pixels that are a resolution cell apart, without looks; nothing unless asked
/// for.
pub(super) fn of(
    args: &FocusArgs,
    recording: &Recording,
    ground: &Ground,
    focused: &Focused,
) -> Result<Option<Speckle>, FocusError> {
    if !args.speckle {
        return Ok(None);
    }
    let header = &recording.header;
    let fault =
        |source| FocusError::Speckle { channel: header.channels[focused.channel].name.clone(), source };
    let powers: Vec<f64> =
        focused.image.iter().map(|z| f64::from(z.re).powi(2) + f64::from(z.im).powi(2)).collect();
    let settings = SpeckleSettings { resamples: RESAMPLES, test_pixels: TEST_PIXELS, seed: header.seed };
    let Some(support) = &focused.support else {
        let channel = header.channels[focused.channel].name.clone();
        return Err(FocusError::NoCells { channel });
    };
    Speckle::of(&powers, ground.pixels, step(args, ground, support), &settings).map(Some).map_err(fault)
}

/// Pixels to the East and to the North after which the response to a point has fallen: a cell in range or in
/// cross-range, by as much wider as tapers make it. No two pixels that are taken lie nearer, whatever way the
/// look goes over the image.
fn step(args: &FocusArgs, ground: &Ground, support: &Support) -> [usize; 2] {
    let wide = [args.window, args.aperture].map(|taper| taper.taper().width() / 0.8859);
    let away = |i: i64, j: i64| {
        let of = |k: usize| i as f64 * ground.step_x_m[k] + j as f64 * ground.step_y_m[k];
        let cells = support.cells([of(0), of(1)]);
        (cells[0].abs() / wide[0]).max(cells[1].abs() / wide[1])
    };
    // A pixel of exactly a cell is one, in spite of rounding.
    let alone = |away: f64| (away.recip() - 1e-3).ceil().clamp(1.0, MOST_STEP as f64) as i64;
    let [mut x, mut y] = [alone(away(1, 0)), alone(away(0, 1))];
    // Across an oblique look neighbours may lie along a cell's diagonal: the closer step grows until none
    // does.
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

/// Lines of a table.
pub(super) fn tell(speckle: &Speckle, out: &mut dyn Write) -> std::io::Result<()> {
    let [x, y] = speckle.step;
    writeln!(
        out,
        "  speckle          {} pixels, every {x} to the East and {y} to the North; contrast {:.3} +- {:.3}; the test takes {} of them",
        speckle.pixels, speckle.contrast, speckle.contrast_error, speckle.test_pixels
    )?;
    for fits in &speckle.laws {
        let shape = if fits.law == "rayleigh" {
            String::new()
        } else {
            let [a, b, c] = [&fits.moments, &fits.likelihood, &fits.histogram].map(ToString::to_string);
            format!("shape by moments {a}, by likelihood {b}, by histogram {c}; ")
        };
        let p = fits.probability.map_or(String::new(), |p| format!(", p = {p:.2}"));
        writeln!(out, "    {:<14} {shape}Kolmogorov-Smirnov {:.4}{p}", fits.law, fits.distance)?;
    }
    Ok(())
}
