//! Keys that several tables of the sea have: the water, the wind, the spectrum.

use std::path::PathBuf;
use std::rc::Rc;
use std::str::FromStr;

use clap::{Args, ValueEnum};
use num_complex::Complex64;
use thiserror::Error;

use super::csv::combinations;
use super::error::TableError;
use super::sweep::{Sweep, Usual};
use crate::scattering::permittivity::{Model, SeaWater};
use crate::scene::sea::LightWinds;
use crate::scene::water::{Development, SpectrumKind, Spreading, WindProfile};
use crate::sea::spectrum::{LightWind, Spectrum, of_kind};
use crate::sea::wind::{CALM_BELOW_MPS, Wind};

/// Most seas of a table: each integrates a spectrum, which takes milliseconds.
const MOST_SEAS: usize = 10_000;
/// Friction velocity of the paper's scenes, m/s.
const USTAR_MPS: f64 = 0.36;
/// Height at which a speed holds unless another is given, m.
const HEIGHT_M: f64 = 10.0;
/// Fetch of a JONSWAP sea unless another is given, m.
const FETCH_M: f64 = 100e3;

/// The water.
#[derive(Clone, Debug, Args)]
pub struct WaterKeys {
    /// Model of the permittivity
    #[arg(long, value_enum, default_value_t = PermittivityModel::Mw12)]
    model: PermittivityModel,
    /// Temperatures of the water, degrees Celsius
    #[arg(
        long,
        value_name = "T,...",
        value_delimiter = ',',
        default_value = "20",
        allow_hyphen_values = true
    )]
    temperature_c: Vec<f64>,
    /// Salinities, g/kg
    #[arg(long, value_name = "S,...", value_delimiter = ',', default_value = "35")]
    salinity_psu: Vec<f64>,
}

/// Model of the permittivity of sea water.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PermittivityModel {
    /// Meissner and Wentz 2012: 1 to 90 GHz
    Mw12,
    /// Klein and Swift 1977: 1 to 10 GHz
    Ks77,
}

impl WaterKeys {
    pub(super) fn model(&self) -> Model {
        match self.model {
            PermittivityModel::Mw12 => Model::MeissnerWentz2012,
            PermittivityModel::Ks77 => Model::KleinSwift1977,
        }
    }

    /// Every pair of temperature and salinity.
    pub(super) fn waters(&self) -> Vec<SeaWater> {
        let salinities = |temperature_c| {
            self.salinity_psu.iter().map(move |&salinity_gpkg| SeaWater { temperature_c, salinity_gpkg })
        };
        self.temperature_c.iter().flat_map(|&t| salinities(t)).collect()
    }

    /// Permittivities by carrier, of every water; nothing is printed before all are known to be in range.
    pub(super) fn permittivities(
        &self,
        carriers_hz: &[f64],
        waters: &[SeaWater],
    ) -> Result<Vec<(f64, SeaWater, Complex64)>, TableError> {
        let mut found = Vec::with_capacity(carriers_hz.len() * waters.len());
        for &water in waters {
            for &carrier_hz in carriers_hz {
                found.push((carrier_hz, water, self.model().permittivity(carrier_hz, water)?));
            }
        }
        Ok(found)
    }
}

/// The wind.
#[derive(Clone, Debug, Args)]
pub struct WindKeys {
    /// Friction velocities of the profile, m/s [default: 0.36 when no speed is given]
    #[arg(long, value_name = "U,...", value_delimiter = ',', conflicts_with = "wind_mps")]
    ustar_mps: Vec<f64>,
    /// Wind speeds, m/s
    #[arg(long, value_name = "U,...", value_delimiter = ',')]
    wind_mps: Vec<f64>,
    /// Height at which the speeds hold, m [default: 10]
    #[arg(long, value_name = "Z")]
    wind_height_m: Option<f64>,
    /// Profile that carries the wind to other heights
    #[arg(long, value_enum, default_value_t = Profile::Cardone)]
    profile: Profile,
}

/// Wind profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Profile {
    /// Cardone 1969
    Cardone,
    /// Logarithmic, with the drag of Wu 1982
    Wu,
}

impl WindKeys {
    /// The winds that were listed, each blowing towards the given direction.
    pub(super) fn winds(&self, downwind_rad: f64) -> Result<Vec<Wind>, TableError> {
        let profile = self.profile();
        if !self.wind_mps.is_empty() {
            return self.at_speeds(&self.wind_mps, downwind_rad);
        }
        if self.wind_height_m.is_some() {
            return Err(TableError::HeightAlone);
        }
        let listed = if self.ustar_mps.is_empty() { &[USTAR_MPS][..] } else { &self.ustar_mps };
        let wind = |&ustar_mps| Wind::from_friction_velocity(ustar_mps, profile, downwind_rad);
        Ok(listed.iter().map(wind).collect::<Result<_, _>>()?)
    }

    /// The winds that were listed, or those of a sweep of the speed; blowing towards +x.
    pub(super) fn listed_or_swept(&self, sweep: Sweep) -> Result<Vec<Wind>, TableError> {
        let Some(sweep_key) = sweep.given() else { return self.winds(0.0) };
        if !self.ustar_mps.is_empty() {
            return Err(TableError::Both { key: "--ustar-mps", sweep_key });
        }
        let usual = Usual::steps(1.0, 25.0, 1.0);
        self.at_speeds(&sweep.or_list("--wind-mps", &self.wind_mps, usual)?, 0.0)
    }

    fn at_speeds(&self, speeds_mps: &[f64], downwind_rad: f64) -> Result<Vec<Wind>, TableError> {
        let height_m = self.wind_height_m.unwrap_or(HEIGHT_M);
        let wind = |&speed_mps| Wind::from_speed(speed_mps, height_m, self.profile(), downwind_rad);
        Ok(speeds_mps.iter().map(wind).collect::<Result<_, _>>()?)
    }

    fn profile(&self) -> WindProfile {
        match self.profile {
            Profile::Cardone => WindProfile::Cardone,
            Profile::Wu => WindProfile::Wu,
        }
    }
}

/// Refuses more seas than can be prepared in minutes, given how many values each of their keys has.
pub(super) fn bound_seas(values: &[usize]) -> Result<(), TableError> {
    let seas = combinations(values);
    if seas <= MOST_SEAS { Ok(()) } else { Err(TableError::Seas { seas, most: MOST_SEAS }) }
}

/// Refuses winds that raise no waves, for laws that need some.
pub(super) fn refuse_calm(winds: &[Wind]) -> Result<(), TableError> {
    match winds.iter().find(|wind| wind.is_calm()) {
        Some(wind) => Err(TableError::Calm { u10_mps: wind.u10_mps, least_mps: CALM_BELOW_MPS }),
        None => Ok(()),
    }
}

/// The spectrum.
#[derive(Clone, Debug, Args)]
pub struct SpectrumKeys {
    /// Spectrum
    #[arg(long, value_enum, default_value_t = Kind::ElfouhailyFungLee)]
    kind: Kind,
    /// Inverse wave age of an Elfouhaily sea, 0.84 (fully developed, the default) to 5
    #[arg(long, value_name = "X", conflicts_with = "fetch_m")]
    inverse_wave_age: Option<f64>,
    /// Fetch of an Elfouhaily or JONSWAP sea, m [JONSWAP's default: 100000]
    #[arg(long, value_name = "X")]
    fetch_m: Option<f64>,
    /// Spreading of a Pierson-Moskowitz or JONSWAP sea: mitsuyasu (default), elfouhaily, or the exponent s of
    /// cos^2s(phi/2)
    #[arg(long, value_name = "WHICH")]
    spreading: Option<SpreadingKey>,
    /// File of a measured spectrum; downwind is its +x
    #[arg(long, value_name = "FILE")]
    spectrum_path: Option<PathBuf>,
}

/// Kind of spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Elfouhaily et al. 1997
    Elfouhaily,
    /// Fung and Lee 1982
    FungLee,
    /// The paper's: Elfouhaily's with the directional function of Fung and Lee
    ElfouhailyFungLee,
    /// Pierson and Moskowitz 1964
    PiersonMoskowitz,
    /// JONSWAP
    Jonswap,
    /// From a file
    Measured,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Elfouhaily => "elfouhaily",
            Self::FungLee => "fung-lee",
            Self::ElfouhailyFungLee => "elfouhaily-fung-lee",
            Self::PiersonMoskowitz => "pierson-moskowitz",
            Self::Jonswap => "jonswap",
            Self::Measured => "measured",
        }
    }
}

/// `--spreading`: a law, or an exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpreadingKey(Spreading);

/// Not a spreading.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: mitsuyasu, elfouhaily, or the exponent s of cos^2s(phi/2) such as 10")]
pub struct NotASpreading;

impl FromStr for SpreadingKey {
    type Err = NotASpreading;

    fn from_str(text: &str) -> Result<Self, NotASpreading> {
        Ok(Self(match text {
            "mitsuyasu" => Spreading::Mitsuyasu,
            "elfouhaily" => Spreading::LikeElfouhaily,
            number => Spreading::Constant(number.parse().map_err(|_| NotASpreading)?),
        }))
    }
}

impl SpectrumKeys {
    /// What scatters in each wind: the tail of a measured spectrum with it, and Bragg waves in light wind as
    /// runs have them, if so asked.
    pub(super) fn that_scatter(
        &self,
        winds: &[Wind],
        light_wind: LightWinds,
    ) -> Result<Vec<Rc<dyn Spectrum>>, TableError> {
        bound_seas(&[winds.len()])?;
        let kind = match self.described()? {
            SpectrumKind::Measured { path, .. } => SpectrumKind::Measured { path, tail: true },
            kind => kind,
        };
        let of_wind = |wind: &Wind| -> Result<Rc<dyn Spectrum>, TableError> {
            Ok(match (&kind, light_wind) {
                (SpectrumKind::Measured { .. }, _) | (_, LightWinds::AsPublished) => {
                    of_kind(&kind, wind)?.into()
                }
                (kind, LightWinds::Threshold) => Rc::new(LightWind::new(kind, wind)?),
            })
        };
        winds.iter().map(of_wind).collect()
    }

    /// The spectrum of each wind (a measured one is read once).
    pub(super) fn spectra(&self, winds: &[Wind]) -> Result<Vec<Rc<dyn Spectrum>>, TableError> {
        bound_seas(&[winds.len()])?;
        let kind = self.described()?;
        let mut spectra: Vec<Rc<dyn Spectrum>> = Vec::with_capacity(winds.len());
        for wind in winds {
            let spectrum = match spectra.last() {
                Some(read) if self.kind == Kind::Measured => Rc::clone(read),
                _ => of_kind(&kind, wind)?.into(),
            };
            spectra.push(spectrum);
        }
        Ok(spectra)
    }

    /// The spectrum described, every key that was given having a meaning.
    fn described(&self) -> Result<SpectrumKind, TableError> {
        let kind = self.kind;
        let elfouhaily = matches!(kind, Kind::Elfouhaily | Kind::ElfouhailyFungLee);
        let jonswap = kind == Kind::Jonswap;
        let cosine_power = matches!(kind, Kind::PiersonMoskowitz | Kind::Jonswap);
        for (key, given, means, allowed) in [
            (
                "--inverse-wave-age",
                self.inverse_wave_age.is_some(),
                elfouhaily,
                "elfouhaily, elfouhaily-fung-lee",
            ),
            (
                "--fetch-m",
                self.fetch_m.is_some(),
                elfouhaily || jonswap,
                "elfouhaily, elfouhaily-fung-lee, jonswap",
            ),
            ("--spreading", self.spreading.is_some(), cosine_power, "pierson-moskowitz, jonswap"),
            ("--spectrum-path", self.spectrum_path.is_some(), kind == Kind::Measured, "measured"),
        ] {
            if given && !means {
                return Err(TableError::Foreign { key, kind: kind.name(), allowed });
            }
        }
        let development = match (self.inverse_wave_age, self.fetch_m) {
            (Some(age), _) => Development::InverseWaveAge(age),
            (None, Some(fetch_m)) => Development::Fetch(fetch_m),
            (None, None) => Development::default(),
        };
        let spreading = self.spreading.map_or(Spreading::default(), |SpreadingKey(spreading)| spreading);
        Ok(match kind {
            Kind::Elfouhaily => SpectrumKind::Elfouhaily { development },
            Kind::FungLee => SpectrumKind::FungLee,
            Kind::ElfouhailyFungLee => SpectrumKind::ElfouhailyFungLee { development },
            Kind::PiersonMoskowitz => SpectrumKind::PiersonMoskowitz { spreading },
            Kind::Jonswap => SpectrumKind::Jonswap { fetch_m: self.fetch_m.unwrap_or(FETCH_M), spreading },
            Kind::Measured => {
                let path = self.spectrum_path.clone().ok_or(TableError::NoFile)?;
                SpectrumKind::Measured { path, tail: false }
            }
        })
    }
}
