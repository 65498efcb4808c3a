//! What the pixels of one channel are like: all fits of all laws, and how good they are.

use std::fmt;

use serde::Serialize;

use super::spacing::independent_step;
use crate::clutter::goodness::{self, Goodness};
use crate::clutter::{Fit, Kind, Sample, SampleFault, blocks, histogram, likelihood, moments};
use crate::processor::focus::Image;
use crate::processor::taper::Taper;

/// Why no laws are fitted to the pixels of an image.
#[derive(Debug, thiserror::Error)]
pub enum SpeckleError {
    /// An image without resolution cells.
    #[error(
        "no cross-range, so that a resolution cell has no length; allowed: more pulses, from an end that moves"
    )]
    NoCells,
    /// Pixels that no law can be fitted to.
    #[error(transparent)]
    Sample(#[from] SampleFault),
}

/// How much is tested.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpeckleSettings {
    /// Samples drawn from each law.
    pub(crate) resamples: usize,
    /// Most pixels of a test.
    pub(crate) test_pixels: usize,
    /// Of their numbers.
    pub(crate) seed: u64,
}

/// A shape and its standard error; nothing where it is infinite.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Shape {
    pub(crate) shape: Option<f64>,
    pub(crate) error: Option<f64>,
    /// Standard error of `1/nu` of a K law.
    pub(crate) inverse_error: Option<f64>,
}

impl Shape {
    fn of(fit: &Fit) -> Self {
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        Self {
            shape: finite(fit.law.shape()),
            error: finite(fit.shape_error),
            inverse_error: finite(fit.inverse_error).filter(|_| fit.law.kind() == Kind::K),
        }
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match (self.shape, self.error) {
            (Some(nu), Some(error)) => write!(f, "{nu:6.3} +- {error:5.3}"),
            _ => write!(f, "{:>15}", "infinite"),
        }
    }
}

/// One law.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LawFits {
    pub(crate) law: &'static str,
    pub(crate) moments: Shape,
    pub(crate) likelihood: Shape,
    pub(crate) histogram: Shape,
    pub(crate) distance: f64,
    pub(crate) probability: Option<f64>,
}

/// Statistics of one channel.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Speckle {
    /// Pixels fitted, and those without any power, which are left out.
    pub(crate) pixels: usize,
    pub(crate) silent: usize,
    /// Every so many pixels along x and y were taken.
    pub(crate) step: [usize; 2],
    pub(crate) mean_power_dbw: f64,
    pub(crate) contrast: f64,
    pub(crate) contrast_error: f64,
    /// Standard error of `1/nu` (likelihood) by blocks that are left out.
    pub(crate) inverse_block_error: Option<f64>,
    /// Pixels of the test.
    pub(crate) test_pixels: usize,
    pub(crate) laws: Vec<LawFits>,
}

/// Every so many pixels along x and y.
fn every(powers: &[f64], columns: usize, [along_x, along_y]: [usize; 2]) -> (Vec<f64>, [usize; 2]) {
    let rows: Vec<&[f64]> = powers.chunks_exact(columns.max(1)).step_by(along_y.max(1)).collect();
    let taken: Vec<f64> = rows.iter().flat_map(|row| row.iter().step_by(along_x.max(1))).copied().collect();
    (taken, [columns.div_ceil(along_x.max(1)), rows.len()])
}

impl Speckle {
    /// Of an image, row by row, of which every `step`-th pixel along x and y is independent as far as speckle
    /// goes.
    pub(crate) fn of(
        powers: &[f64],
        pixels: [usize; 2],
        step: [usize; 2],
        settings: &SpeckleSettings,
    ) -> Result<Self, SampleFault> {
        let (powers, pixels) = every(powers, pixels[0], step);
        let sample = Sample::new(&powers)?;
        // Wider apart for the test: its law of distances wants pixels that waves do not make alike.
        let apart = (powers.len() as f64 / settings.test_pixels as f64).sqrt().ceil() as usize;
        let (few, _) = every(&powers, pixels[0], [apart, apart]);
        // Few pixels may all be without power by chance.
        let tested = Sample::new(&few).or_else(|_| Sample::new(&powers))?;
        let law = |kind: Kind| {
            let Goodness { distance, probability, .. } =
                goodness::test(&tested, kind, settings.resamples, settings.seed);
            LawFits {
                law: kind.name(),
                moments: Shape::of(&moments::fit(&sample, kind)),
                likelihood: Shape::of(&likelihood::fit(&sample, kind)),
                histogram: Shape::of(&histogram::fit(&sample, kind)),
                distance,
                probability,
            }
        };
        Ok(Self {
            pixels: sample.len(),
            silent: sample.zeros(),
            step,
            mean_power_dbw: 10.0 * sample.mean_power().log10(),
            contrast: sample.contrast(),
            contrast_error: sample.contrast_error(),
            inverse_block_error: blocks::inverse_shape_error(&powers, pixels),
            test_pixels: tested.len(),
            laws: Kind::ALL.map(law).into(),
        })
    }

    /// Of the pixels of an image that are a resolution cell apart, made with such tapers over the band and
    /// over the pulses.
    pub(crate) fn of_image(
        image: &Image,
        tapers: [Taper; 2],
        settings: &SpeckleSettings,
    ) -> Result<Self, SpeckleError> {
        let powers: Vec<f64> =
            image.values.iter().map(|z| f64::from(z.re).powi(2) + f64::from(z.im).powi(2)).collect();
        let support = image.support.ok_or(SpeckleError::NoCells)?;
        let step = independent_step(&image.ground, &support, tapers);
        Ok(Self::of(&powers, image.ground.pixels, step, settings)?)
    }

    /// The fits of a law.
    pub(crate) fn law(&self, kind: Kind) -> Option<&LawFits> {
        self.laws.iter().find(|fits| fits.law == kind.name())
    }
}
