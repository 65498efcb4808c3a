//! Keys that several tables of the sea have: the water, the wind, the spectrum.

use std::path::PathBuf;
use std::rc::Rc;
use std::str::FromStr;

use clap::Args;
use num_complex::Complex64;

use super::csv::combinations;
use super::sweep::{Sweep, Usual};
use crate::cli::error::{CliError, Refused};
use crate::cli::values::{Unreadable, Word, allowed, one_of, word_of};
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

/// Models of the permittivity of sea water.
const MODELS: [Word<Model>; 3] = [
    ("mw12", "Meissner and Wentz 2012: 1 to 90 GHz", Model::MeissnerWentz2012),
    ("ks77", "Klein and Swift 1977: 1 to 10 GHz", Model::KleinSwift1977),
    ("itu527", "Recommendation ITU-R P.527-6: 1 MHz to 1 THz", Model::ItuRP527),
];
/// Wind profiles.
const PROFILES: [Word<WindProfile>; 2] = [
    ("cardone", "Cardone 1969", WindProfile::Cardone),
    ("wu", "Logarithmic, with the drag of Wu 1982", WindProfile::Wu),
];

/// Kinds of spectra, as they are without further keys.
fn kinds() -> [Word<SpectrumKind>; 6] {
    let (development, spreading) = (Development::default(), Spreading::default());
    let efl = "The paper's: Elfouhaily's with the directional function of Fung and Lee";
    [
        ("elfouhaily", "Elfouhaily et al. 1997", SpectrumKind::Elfouhaily { development }),
        ("fung-lee", "Fung and Lee 1982", SpectrumKind::FungLee),
        ("elfouhaily-fung-lee", efl, SpectrumKind::ElfouhailyFungLee { development }),
        ("pierson-moskowitz", "Pierson and Moskowitz 1964", SpectrumKind::PiersonMoskowitz { spreading }),
        ("jonswap", "JONSWAP", SpectrumKind::Jonswap { fetch_m: FETCH_M, spreading }),
        ("measured", "From a file", SpectrumKind::Measured { path: PathBuf::new(), tail: false }),
    ]
}

/// The water.
#[derive(Clone, Debug, Args)]
pub struct WaterKeys {
    /// Model of the permittivity
    #[arg(long, value_parser = one_of(MODELS), default_value = "mw12")]
    pub(super) model: Model,
    /// Temperatures of the water, degrees Celsius
    #[arg(
        long,
        value_name = "T,...",
        value_delimiter = ',',
        default_value = "20",
        allow_hyphen_values = true
    )]
    temperature_c: Vec<f64>,
    /// Practical salinities (PSS-78), psu
    #[arg(long, value_name = "S,...", value_delimiter = ',', default_value = "35")]
    salinity_psu: Vec<f64>,
}

impl WaterKeys {
    /// How many waters there are: pairs of temperature and salinity.
    pub(super) fn count(&self) -> usize {
        combinations(&[self.temperature_c.len(), self.salinity_psu.len()])
    }

    /// Every combination of a carrier and a water with its permittivity; nothing is printed before all are
    /// known to be in range.
    pub(super) fn media(&self, carriers_hz: &[f64]) -> Result<Vec<(f64, SeaWater, Complex64)>, CliError> {
        let mut found = Vec::with_capacity(combinations(&[carriers_hz.len(), self.count()]));
        for &temperature_c in &self.temperature_c {
            for &salinity_gpkg in &self.salinity_psu {
                for &carrier_hz in carriers_hz {
                    let water = SeaWater { temperature_c, salinity_gpkg };
                    found.push((carrier_hz, water, self.model.permittivity(carrier_hz, water)?));
                }
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
    #[arg(long, value_parser = one_of(PROFILES), default_value = "cardone")]
    profile: WindProfile,
}

impl WindKeys {
    /// The winds that were listed, blowing towards +x.
    pub(super) fn winds(&self) -> Result<Vec<Wind>, CliError> {
        if !self.wind_mps.is_empty() {
            return self.at_speeds(&self.wind_mps);
        }
        if self.wind_height_m.is_some() {
            return Err(Refused::HeightAlone.into());
        }
        let listed = if self.ustar_mps.is_empty() { &[USTAR_MPS][..] } else { &self.ustar_mps };
        let wind = |&ustar_mps| Wind::from_friction_velocity(ustar_mps, self.profile, 0.0);
        Ok(listed.iter().map(wind).collect::<Result<_, _>>()?)
    }

    /// The winds that were listed, or those of a sweep of the speed.
    pub(super) fn listed_or_swept(&self, sweep: Sweep) -> Result<Vec<Wind>, CliError> {
        let Some(sweep_key) = sweep.given() else { return self.winds() };
        if !self.ustar_mps.is_empty() {
            return Err(Refused::Both { key: "--ustar-mps", sweep_key }.into());
        }
        let usual = Usual::steps(1.0, 25.0, 1.0);
        self.at_speeds(&sweep.or_list("--wind-mps", &self.wind_mps, usual)?)
    }

    fn at_speeds(&self, speeds_mps: &[f64]) -> Result<Vec<Wind>, CliError> {
        let height_m = self.wind_height_m.unwrap_or(HEIGHT_M);
        let wind = |&speed_mps| Wind::from_speed(speed_mps, height_m, self.profile, 0.0);
        Ok(speeds_mps.iter().map(wind).collect::<Result<_, _>>()?)
    }
}

/// Refuses more seas than can be prepared in minutes, given how many values each of their keys has.
pub(super) fn bound_seas(values: &[usize]) -> Result<(), Refused> {
    let seas = combinations(values);
    if seas <= MOST_SEAS { Ok(()) } else { Err(Refused::Seas { seas, most: MOST_SEAS }) }
}

/// Refuses winds that raise no waves, for laws that need some.
pub(super) fn refuse_calm(winds: &[Wind]) -> Result<(), Refused> {
    match winds.iter().find(|wind| wind.is_calm()) {
        Some(wind) => Err(Refused::Calm { u10_mps: wind.u10_mps, least_mps: CALM_BELOW_MPS }),
        None => Ok(()),
    }
}

/// The spectrum.
#[derive(Clone, Debug, Args)]
pub struct SpectrumKeys {
    /// Spectrum; scenarios have elfouhaily unless they say otherwise
    #[arg(long, value_parser = one_of(kinds()), default_value = "elfouhaily-fung-lee")]
    kind: SpectrumKind,
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

/// A wind, and the spectrum of its sea.
type WindSea<'a> = (&'a Wind, Rc<dyn Spectrum>);

/// `--spreading`: a law, or an exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpreadingKey(Spreading);

impl FromStr for SpreadingKey {
    type Err = Unreadable;

    fn from_str(text: &str) -> Result<Self, Unreadable> {
        let law = match text {
            "mitsuyasu" => Some(Spreading::Mitsuyasu),
            "elfouhaily" => Some(Spreading::LikeElfouhaily),
            number => number.parse().ok().map(Spreading::Constant),
        };
        let what = "mitsuyasu, elfouhaily, or the exponent s of cos^2s(phi/2) such as 10";
        allowed(law.map(Self), what)
    }
}

impl SpectrumKeys {
    /// What scatters in each wind: the tail of a measured spectrum with it, and Bragg waves in light wind as
    /// runs have them, if so asked.
    pub(super) fn that_scatter(
        &self,
        winds: &[Wind],
        light_wind: LightWinds,
    ) -> Result<Vec<Rc<dyn Spectrum>>, CliError> {
        bound_seas(&[winds.len()])?;
        let kind = match self.described()? {
            SpectrumKind::Measured { path, .. } => SpectrumKind::Measured { path, tail: true },
            kind => kind,
        };
        let of_wind = |wind: &Wind| -> Result<Rc<dyn Spectrum>, CliError> {
            Ok(match (&kind, light_wind) {
                (SpectrumKind::Measured { .. }, _) | (_, LightWinds::AsPublished) => {
                    of_kind(&kind, wind)?.into()
                }
                (kind, LightWinds::Threshold) => Rc::new(LightWind::new(kind, wind)?),
            })
        };
        winds.iter().map(of_wind).collect()
    }

    /// Each wind with the spectrum of its sea (a measured one is read once), for a table of so many values of
    /// its other keys.
    pub(super) fn spectra<'a>(
        &self,
        winds: &'a [Wind],
        others: &[usize],
    ) -> Result<Vec<WindSea<'a>>, CliError> {
        super::csv::bound(&[&[winds.len()], others].concat())?;
        bound_seas(&[winds.len()])?;
        let kind = self.described()?;
        let mut spectra: Vec<WindSea> = Vec::with_capacity(winds.len());
        for wind in winds {
            let spectrum = match spectra.last() {
                Some((_, read)) if matches!(kind, SpectrumKind::Measured { .. }) => Rc::clone(read),
                _ => of_kind(&kind, wind)?.into(),
            };
            spectra.push((wind, spectrum));
        }
        Ok(spectra)
    }

    /// The spectrum described, every key that was given having a meaning.
    fn described(&self) -> Result<SpectrumKind, Refused> {
        let mut kind = self.kind.clone();
        let has_age =
            matches!(kind, SpectrumKind::Elfouhaily { .. } | SpectrumKind::ElfouhailyFungLee { .. });
        let has_fetch = has_age || matches!(kind, SpectrumKind::Jonswap { .. });
        let has_spreading =
            matches!(kind, SpectrumKind::PiersonMoskowitz { .. } | SpectrumKind::Jonswap { .. });
        let has_file = matches!(kind, SpectrumKind::Measured { .. });
        match &mut kind {
            SpectrumKind::Elfouhaily { development } | SpectrumKind::ElfouhailyFungLee { development } => {
                let of_age = self.inverse_wave_age.map(Development::InverseWaveAge);
                *development = of_age.or(self.fetch_m.map(Development::Fetch)).unwrap_or(*development);
            }
            SpectrumKind::PiersonMoskowitz { spreading } => {
                *spreading = self.spreading.map_or(*spreading, |SpreadingKey(given)| given);
            }
            SpectrumKind::Jonswap { fetch_m, spreading } => {
                *fetch_m = self.fetch_m.unwrap_or(*fetch_m);
                *spreading = self.spreading.map_or(*spreading, |SpreadingKey(given)| given);
            }
            SpectrumKind::Measured { path, .. } => {
                *path = self.spectrum_path.clone().unwrap_or_default();
            }
            SpectrumKind::FungLee => {}
        }
        let (elfouhaily, jonswap) =
            ("elfouhaily, elfouhaily-fung-lee", "elfouhaily, elfouhaily-fung-lee, jonswap");
        for (key, given, means, allowed) in [
            ("--inverse-wave-age", self.inverse_wave_age.is_some(), has_age, elfouhaily),
            ("--fetch-m", self.fetch_m.is_some(), has_fetch, jonswap),
            ("--spreading", self.spreading.is_some(), has_spreading, "pierson-moskowitz, jonswap"),
            ("--spectrum-path", self.spectrum_path.is_some(), has_file, "measured"),
        ] {
            if given && !means {
                return Err(Refused::Foreign { key, kind: word_of(&kinds(), &self.kind), allowed });
            }
        }
        if has_file && self.spectrum_path.is_none() { Err(Refused::NoFile) } else { Ok(kind) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A new kind must be named here to compile.
    #[test]
    fn every_spectrum_has_a_word() {
        let known = |kind: &SpectrumKind| match kind {
            SpectrumKind::Elfouhaily { .. } => 0,
            SpectrumKind::FungLee => 1,
            SpectrumKind::ElfouhailyFungLee { .. } => 2,
            SpectrumKind::PiersonMoskowitz { .. } => 3,
            SpectrumKind::Jonswap { .. } => 4,
            SpectrumKind::Measured { .. } => 5,
        };
        let numbers = kinds().map(|(_, _, kind)| known(&kind));
        assert_eq!(numbers, [0, 1, 2, 3, 4, 5]);
        for (word, _, kind) in kinds() {
            assert_eq!(word_of(&kinds(), &kind), word);
        }
    }
}
