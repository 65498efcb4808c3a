//! Laws of clutter amplitude.
//!
//! K law of the amplitude `z` (compound Gaussian: speckle on a gamma-distributed local power), shape `nu`,
//! scale `b`:
//!
//! ```text
//! p(z) = (2 b / G(nu)) (b z / 2)^nu K_{nu-1}(b z),   P(z) = 1 - (2 / G(nu)) (b z / 2)^nu K_nu(b z)
//! <z^2> = 4 nu / b^2,   <I^2>/<I>^2 = 2 (1 + 1/nu),  I = z^2
//! ```
//!
//! Weibull law, shape `c`, scale `a`, and Rayleigh law, which is that of `c = 2` and that of `nu` without
//! end:
//!
//! ```text
//! P(z) = 1 - exp(-(z/a)^c),   <z^2> = a^2 G(1 + 2/c),   <I^2>/<I>^2 = G(1 + 4/c) / G(1 + 2/c)^2
//! P(z) = 1 - exp(-z^2/<z^2>)
//! ```
//!
//! `K_nu` by the trapezoidal rule over the peak of its integral, which converges faster than any power of the
//! step. Above `nu` of some 10 the K law is hardly distinguished from Rayleigh's; an infinite shape is
//! Rayleigh's.
//!
//! A cell in which `N` facets of equal power and random phases meet is no full speckle: its `<I^2>/<I>^2` is
//! lower by `1/N`.
//!
//! Limits: shapes `nu` from 0.01; rounding leaves `2^-52 nu ln nu` of density and tail, 2e-11 at 1e4.
//!
//! Source: K. D. Ward, Electron. Lett. 17, 561 (1981).
//!
//! ```
//! use nereus::clutter::KLaw;
//! let law = KLaw { shape: 0.5, scale: 1.0 };
//! // Shape 1/2 is the exponential law.
//! assert!((law.density(0.3) - (-0.3f64).exp()).abs() < 1e-12);
//! ```

use libm::lgamma;
use rand::Rng;
use rand_distr::{Distribution, Exp1, Gamma};

use super::bessel::ln_bessel_k;

/// Which law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// K law.
    K,
    /// Weibull law.
    Weibull,
    /// Rayleigh law.
    Rayleigh,
}

impl Kind {
    /// All laws.
    pub const ALL: [Self; 3] = [Self::K, Self::Weibull, Self::Rayleigh];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::K => "k",
            Self::Weibull => "weibull",
            Self::Rayleigh => "rayleigh",
        }
    }
}

/// The K law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KLaw {
    /// `nu`, above 0; infinite for Rayleigh's law.
    pub shape: f64,
    /// `b`, over the unit of the amplitude; `b/sqrt(nu) = 2/sqrt(<z^2>)` where the shape is infinite.
    pub scale: f64,
}

/// The Weibull law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeibullLaw {
    /// `c`, above 0.
    pub shape: f64,
    /// `a`, in the unit of the amplitude.
    pub scale: f64,
}

/// The Rayleigh law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayleighLaw {
    /// `<z^2>`.
    pub mean_power: f64,
}

/// Any of them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Law {
    /// K law.
    K(KLaw),
    /// Weibull law.
    Weibull(WeibullLaw),
    /// Rayleigh law.
    Rayleigh(RayleighLaw),
}

impl KLaw {
    /// Of a shape, infinite or not, and a mean power.
    pub fn new(shape: f64, mean_power: f64) -> Self {
        let nu = if shape.is_finite() { shape } else { 1.0 };
        // Powers next to the least that a number holds have no finite inverse.
        Self { shape, scale: 2.0 * nu.sqrt() / mean_power.sqrt() }
    }

    /// `<z^2>`.
    pub fn mean_power(&self) -> f64 {
        let nu = if self.shape.is_finite() { self.shape } else { 1.0 };
        (2.0 * nu.sqrt() / self.scale).powi(2)
    }

    /// Density of an amplitude.
    pub fn density(&self, z: f64) -> f64 {
        let Self { shape, scale } = *self;
        if z <= 0.0 {
            return 0.0;
        }
        let x = scale * z;
        if shape == f64::INFINITY {
            return 0.5 * scale * x * (-0.25 * x * x).exp();
        }
        if x == f64::INFINITY {
            return 0.0;
        }
        let x = x.max(f64::MIN_POSITIVE);
        let ln = (2.0 * scale).ln() - lgamma(shape) + shape * (0.5 * x).ln() + ln_bessel_k(shape - 1.0, x).ln;
        ln.exp()
    }

    /// Probability that an amplitude is not larger.
    pub fn probability(&self, z: f64) -> f64 {
        let Self { shape, scale } = *self;
        if z <= 0.0 {
            return 0.0;
        }
        let x = scale * z;
        if shape == f64::INFINITY {
            return -(-0.25 * x * x).exp_m1();
        }
        if x == f64::INFINITY {
            return 1.0;
        }
        let x = x.max(f64::MIN_POSITIVE);
        let ln = std::f64::consts::LN_2 - lgamma(shape) + shape * (0.5 * x).ln() + ln_bessel_k(shape, x).ln;
        (1.0 - ln.exp()).clamp(0.0, 1.0)
    }
}

impl WeibullLaw {
    /// Of a shape and a mean power.
    pub fn new(shape: f64, mean_power: f64) -> Self {
        Self { shape, scale: (0.5 * (mean_power.ln() - lgamma(1.0 + 2.0 / shape))).exp() }
    }

    /// `<z^2>`.
    pub fn mean_power(&self) -> f64 {
        (2.0 * self.scale.ln() + lgamma(1.0 + 2.0 / self.shape)).exp()
    }

    /// `(z/a)^c`.
    fn rise(&self, z: f64) -> f64 {
        (z / self.scale).powf(self.shape)
    }

    /// Density of an amplitude.
    pub fn density(&self, z: f64) -> f64 {
        if z <= 0.0 || z == f64::INFINITY {
            return 0.0;
        }
        let rise = self.rise(z);
        if rise > 745.0 { 0.0 } else { self.shape / z * rise * (-rise).exp() }
    }

    /// Probability that an amplitude is not larger.
    pub fn probability(&self, z: f64) -> f64 {
        if z <= 0.0 { 0.0 } else { -(-self.rise(z)).exp_m1() }
    }
}

impl Law {
    /// A law of a shape (Rayleigh's has none) and a mean power.
    pub fn new(kind: Kind, shape: f64, mean_power: f64) -> Self {
        match kind {
            Kind::K => Self::K(KLaw::new(shape, mean_power)),
            Kind::Weibull => Self::Weibull(WeibullLaw::new(shape, mean_power)),
            Kind::Rayleigh => Self::Rayleigh(RayleighLaw { mean_power }),
        }
    }

    /// Which law it is.
    pub fn kind(&self) -> Kind {
        match self {
            Self::K(_) => Kind::K,
            Self::Weibull(_) => Kind::Weibull,
            Self::Rayleigh(_) => Kind::Rayleigh,
        }
    }

    /// `nu` of a K law, `c` of Weibull's, 2 for Rayleigh's.
    pub fn shape(&self) -> f64 {
        match self {
            Self::K(law) => law.shape,
            Self::Weibull(law) => law.shape,
            Self::Rayleigh(_) => 2.0,
        }
    }

    /// `<z^2>`.
    pub fn mean_power(&self) -> f64 {
        match self {
            Self::K(law) => law.mean_power(),
            Self::Weibull(law) => law.mean_power(),
            Self::Rayleigh(law) => law.mean_power,
        }
    }

    /// Rayleigh's law as a K law.
    fn plain(mean_power: f64) -> KLaw {
        KLaw::new(f64::INFINITY, mean_power)
    }

    /// Density of an amplitude.
    pub fn density(&self, z: f64) -> f64 {
        match self {
            Self::K(law) => law.density(z),
            Self::Weibull(law) => law.density(z),
            Self::Rayleigh(law) => Self::plain(law.mean_power).density(z),
        }
    }

    /// Probability that an amplitude is not larger.
    pub fn probability(&self, z: f64) -> f64 {
        match self {
            Self::K(law) => law.probability(z),
            Self::Weibull(law) => law.probability(z),
            Self::Rayleigh(law) => Self::plain(law.mean_power).probability(z),
        }
    }

    /// An amplitude drawn from it.
    pub fn draw(&self, numbers: &mut impl Rng) -> f64 {
        let speckle: f64 = Exp1.sample(numbers);
        match self {
            Self::K(law) => {
                let power = law.mean_power();
                // No gamma law of an infinite shape, nor of one that is no number.
                let texture = Gamma::new(law.shape, 1.0 / law.shape).map_or(1.0, |law| law.sample(numbers));
                (power * speckle * texture).sqrt()
            }
            Self::Weibull(law) => law.scale * speckle.powf(1.0 / law.shape),
            Self::Rayleigh(law) => (law.mean_power * speckle).sqrt(),
        }
    }
}
