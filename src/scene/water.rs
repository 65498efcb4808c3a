//! The water, as described: wind, spectrum, swell, depth, temperature, salinity.
//!
//! Plain settings; the module `sea` knows what they mean and checks their ranges.

use std::path::PathBuf;

/// The sea of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Water {
    /// The wind that raises the wind sea.
    pub wind: WindGiven,
    /// Spectrum of the wind sea (or of everything, when measured).
    pub spectrum: SpectrumKind,
    /// Swell trains added to it.
    pub swell: Vec<Swell>,
    /// How waves travel.
    pub dispersion: Dispersion,
    /// Water temperature, degrees Celsius.
    pub temperature_c: f64,
    /// Practical salinity (PSS-78), psu.
    pub salinity_psu: f64,
}

impl Water {
    /// Deep water of 20 degrees Celsius and 35 psu, without swell.
    pub fn new(wind: WindGiven, spectrum: SpectrumKind) -> Self {
        Self {
            wind,
            spectrum,
            swell: Vec::new(),
            dispersion: Dispersion::default(),
            temperature_c: 20.0,
            salinity_psu: 35.0,
        }
    }
}

/// Wind as the user knows it: one strength, one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindGiven {
    /// How strong.
    pub strength: WindStrength,
    /// The profile that carries it to other heights.
    pub profile: WindProfile,
    /// Direction the wind blows **towards**, from +x counter-clockwise, radians.
    pub direction_rad: f64,
}

/// Strength of the wind.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum WindStrength {
    /// Friction velocity u*, m/s.
    FrictionVelocity {
        /// u*, m/s.
        ustar_mps: f64,
    },
    /// Mean speed at a height.
    Speed {
        /// Speed, m/s.
        speed_mps: f64,
        /// Height above the mean sea surface, m.
        height_m: f64,
    },
}

/// Neutral wind profile over the sea.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum WindProfile {
    /// Cardone 1969, as used by Pierson and Stacy 1973.
    #[default]
    Cardone,
    /// Logarithmic, with the drag coefficient of Wu 1982.
    Wu,
}

/// Spectrum of the sea.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SpectrumKind {
    /// Elfouhaily et al. 1997, with its own spreading.
    Elfouhaily {
        /// How developed the sea is.
        development: Development,
    },
    /// Fung and Lee 1982, with its directional function. A spectrum for backscatter, not for energy.
    FungLee,
    /// Elfouhaily's omnidirectional spectrum with the directional function of Fung and Lee.
    ElfouhailyFungLee {
        /// How developed the sea is.
        development: Development,
    },
    /// Pierson and Moskowitz 1964.
    PiersonMoskowitz {
        /// Directional spreading.
        spreading: Spreading,
    },
    /// JONSWAP (Hasselmann et al. 1973), in deep water.
    Jonswap {
        /// Fetch, m.
        fetch_m: f64,
        /// Directional spreading.
        spreading: Spreading,
    },
    /// A measured 2-D spectrum from a CSV file (columns and limits: `sea::spectrum::measured`).
    Measured {
        /// The file.
        path: PathBuf,
        /// Whether the wind's waves follow beyond its last wave number.
        tail: bool,
    },
}

/// How developed a wind sea is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Development {
    /// Inverse wave age `Omega_c`: 0.84 fully developed, up to 5 very young.
    InverseWaveAge(f64),
    /// Fetch, m.
    Fetch(f64),
}

impl Default for Development {
    fn default() -> Self {
        Self::InverseWaveAge(0.84)
    }
}

/// Directional spreading `cos^2s(phi/2)` about the wind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Spreading {
    /// The same exponent s for all waves.
    Constant(f64),
    /// Mitsuyasu et al. 1975: narrowest at the peak, broad for short waves.
    #[default]
    Mitsuyasu,
    /// The exponent that gives the symmetrised spectrum the same upwind to crosswind ratio as
    /// Elfouhaily's.
    LikeElfouhaily,
}

/// One swell train.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swell {
    /// Significant height, m.
    pub significant_height_m: f64,
    /// Peak period, s.
    pub peak_period_s: f64,
    /// Direction it travels **towards**, from +x counter-clockwise, radians.
    pub direction_rad: f64,
    /// Directional spread (circular standard deviation), radians.
    pub spread_rad: f64,
    /// Shape in frequency.
    pub shape: SwellShape,
}

/// Shape of a swell in frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SwellShape {
    /// Gaussian.
    Gaussian {
        /// Standard deviation over peak frequency.
        relative_width: f64,
    },
    /// JONSWAP shape.
    Jonswap {
        /// Peak enhancement gamma (swell: about 5 to 20).
        peak_enhancement: f64,
    },
}

/// How waves travel: deep-water gravity waves by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dispersion {
    /// Whether surface tension counts (km = 370 rad/m).
    pub capillary: bool,
    /// Water depth, m; `None` for deep water.
    pub depth_m: Option<f64>,
}
