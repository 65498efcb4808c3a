//! Laws fitted to the pixels of an image.

use std::io::Write;

use super::{FocusArgs, FocusError, Focused, Ground, Recording};
use crate::cli::speckle::{Speckle, SpeckleSettings};

/// Samples drawn from a law, and most pixels of a test.
const RESAMPLES: usize = 99;
const TEST_PIXELS: usize = 10_000;

/// Statistics of one channel, of pixels that are a resolution cell apart, without looks; nothing unless asked for.
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
    Speckle::of(&powers, ground.pixels, step(args, ground, focused), &settings).map(Some).map_err(fault)
}

/// Pixels to the East and to the North after which the response to a point has fallen: a cell in range or in cross-range, by as much wider
/// as tapers make it.
fn step(args: &FocusArgs, ground: &Ground, focused: &Focused) -> [usize; 2] {
    let Some(support) = focused.support else { return [1, 1] };
    let wide = [args.window, args.aperture].map(|taper| taper.taper().width() / 0.8859);
    [ground.step_x_m, ground.step_y_m].map(|[x, y, _]| {
        let cells = support.cells([x, y]);
        let away = (cells[0].abs() / wide[0]).max(cells[1].abs() / wide[1]);
        // A pixel of exactly a cell is one, in spite of rounding.
        (away.recip() - 1e-3).ceil().clamp(1.0, 32_768.0) as usize
    })
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
