//! Laws fitted to the pixels of an image.

use std::io::Write;

use super::FocusArgs;
use crate::cli::focus::error::FocusError;
use crate::clutter::fits::{Speckle, SpeckleSettings};
use crate::clutter::spacing::independent_step;
use crate::processor::focus::Image;

/// Samples drawn from a law, and most pixels of a test.
const RESAMPLES: usize = 99;
const TEST_PIXELS: usize = 10_000;

/// Statistics of one channel, of pixels that are a resolution cell apart, without looks.
pub(super) fn of(args: &FocusArgs, seed: u64, image: &Image) -> Result<Speckle, FocusError> {
    let channel = || image.channel.clone();
    let powers: Vec<f64> =
        image.values.iter().map(|z| f64::from(z.re).powi(2) + f64::from(z.im).powi(2)).collect();
    let settings = SpeckleSettings { resamples: RESAMPLES, test_pixels: TEST_PIXELS, seed };
    let support = image.support.ok_or_else(|| FocusError::NoCells { channel: channel() })?;
    let step = independent_step(&image.ground, &support, [args.window.taper(), args.aperture.taper()]);
    Speckle::of(&powers, image.ground.pixels, step, &settings)
        .map_err(|source| FocusError::Speckle { channel: channel(), source })
}

/// Lines of a table.
pub(super) fn write(speckle: &Speckle, out: &mut dyn Write) -> std::io::Result<()> {
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
