//! Whether facets turn away from an antenna: few do where it looks down steeply, and then none of a sample.
//!
//! The cosine of the local angle of a facet of slopes `s` under incidence `theta` is about
//! `cos theta + s sin theta`, so near enough normal over the facets. Where its mean lies `k` standard
//! deviations above zero, a share `Q(k)` of them is turned away: `Q(6) = 1e-9`, of a patch of 512 x 512 about
//! one facet in an hour.
//!
//! ```
//! use nereus::fidelity::turning::Cosines;
//! let mut steep = Cosines::default();
//! let mut grazing = Cosines::default();
//! for n in 0..100 {
//!     let slope = 0.2 * (f64::from(n) / 99.0 - 0.5);
//!     steep.add(0.7 + slope);
//!     grazing.add(0.2 + slope);
//! }
//! assert!(!steep.reach_zero() && grazing.reach_zero());
//! ```

/// Standard deviations of the cosine within which facets may turn away.
const TURNING_SIGMAS: f64 = 6.0;

/// Mean and variance of a cosine over facets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cosines {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Cosines {
    /// Adds the cosine of a facet.
    pub fn add(&mut self, cosine: f64) {
        self.count += 1.0;
        self.sum += cosine;
        self.squares += cosine * cosine;
    }

    /// Whether some facet out of very many may have a cosine below zero; no facets, no.
    pub fn reach_zero(&self) -> bool {
        let mean = self.sum / self.count.max(1.0);
        let deviation = (self.squares / self.count.max(1.0) - mean * mean).max(0.0).sqrt();
        self.count > 0.0 && mean <= TURNING_SIGMAS * deviation
    }
}
