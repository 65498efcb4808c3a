//! Laws of clutter: what amplitudes are like, which law fits them, and how well.
//!
//! | page | holds |
//! | --- | --- |
//! | [`laws`] | K, Weibull and Rayleigh laws: density, probability, numbers drawn from them |
//! | [`sample`] | powers of pixels that are to be fitted: what is refused, what is counted |
//! | [`moments`], [`likelihood`], [`histogram`] | three ways to fit a law |
//! | [`goodness`] | Kolmogorov-Smirnov distance, its probability by parametric bootstrap |
//! | [`blocks`] | errors of pixels that waves make alike, by leaving out parts of an image |
//! | [`image`] | images of the patch, a pixel a resolution cell |
//! | [`spacing`] | how far apart pixels of an image are independent |
//! | [`trend`] | the mean power over range, to be divided out |
//! | [`regression`] | a shape over azimuth: `a + b cos 2 psi` |
//! | [`empirical`] | shapes of sea clutter as measured: Ward, Baker and Watts; Watts and Wicks |
//!
//! All take powers `I = z^2` of independent samples and fit the law of the amplitude `z`.
//!
//! ```
//! use nereus::clutter::{KLaw, Kind, Law, Sample, likelihood, moments};
//! use nereus::rng::{Room, stream};
//! let law = Law::K(KLaw::new(1.5, 2.0));
//! let mut numbers = stream(1, Room::Bootstrap, 0, 0);
//! let powers: Vec<f64> = (0..20_000).map(|_| law.draw(&mut numbers).powi(2)).collect();
//! let sample = Sample::new(&powers)?;
//! for fit in [moments::fit(&sample, Kind::K), likelihood::fit(&sample, Kind::K)] {
//!     assert!((fit.law.shape() - 1.5).abs() < 5.0 * fit.shape_error);
//! }
//! # Ok::<(), nereus::clutter::SampleFault>(())
//! ```

mod bessel;
pub mod blocks;
pub mod empirical;
pub mod fits;
pub mod goodness;
pub mod histogram;
pub mod image;
pub mod laws;
pub mod likelihood;
pub mod moments;
pub mod regression;
pub mod sample;
pub mod spacing;
pub mod trend;

pub use empirical::sea_shape;
pub use laws::{KLaw, Kind, Law, RayleighLaw, WeibullLaw};
pub use sample::{Sample, SampleFault};

/// A law found from a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The law. That of a K fit has an infinite shape where the sample varies no more than Rayleigh's.
    pub law: Law,
    /// Standard error of the shape, for independent samples; infinite where a K law's shape is, 0 for
    /// Rayleigh's law, which has none.
    pub shape_error: f64,
    /// Standard error of `1/nu` of a K law: it stays finite where the shape does not; 0 for the others.
    pub inverse_error: f64,
    /// Standard error of the mean power over that power.
    pub power_error: f64,
}
