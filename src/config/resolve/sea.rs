//! The sea: wind, waves, water, and how its facets scatter.

use std::f64::consts::TAU;

use super::{land, slick};
use crate::config::choices::{
    BraggKind, Choice, ModulationKind, ShadowEdge, SpeckleKind, SpectrumName, SpreadingLaw, SwellKind,
    WithTail,
};
use crate::config::error::{Problem, Warning};
use crate::config::keys::{self, ITU_R_P527, KLEIN_SWIFT, Key, MEISSNER_WENTZ};
use crate::config::section::Section;
use crate::scene::sea::{
    BraggWaves, Breaking, FacetScattering, FarSea, Modulation, PatchPlace, Permittivity, Phases, Realisation,
    Shadowing, Speckle, Splitting, Waves,
};
use crate::scene::water::{
    Development, Dispersion, SpectrumKind, Spreading, Swell, SwellShape, WindGiven, WindStrength,
};
use crate::scene::{Patch, Sea, Water};
use crate::sea::GRAVITY_MPS2;

/// Facets up to which, m, and patches up to which, m^2, waves break unless set: a gale has 0.14 scatterers of
/// breaking waves a square metre.
const BREAKING_FACET_M: f64 = 4.0;
const BREAKING_AREA_M2: f64 = 7e6;

/// Least wind over a far sea, m/s.
const LEAST_WIND_MPS: f64 = 0.3;

/// Time between updates of shadows that is aimed at where none is given, s.
const UPDATE_S: f64 = 0.02;

/// `[sea]`, `[[swell]]`, `[[slick]]`, `[land]`: `Some(None)` without a sea, `None` where something is faulty.
pub(super) fn sea(
    root: &Section<'_>,
    patch: Option<Patch>,
    place: Option<PatchPlace>,
    azimuth_resolution_m: Option<f64>,
    carrier_hz: Option<f64>,
    pri_s: Option<f64>,
    continuous: bool,
) -> Option<Option<Sea>> {
    let has_sea = root.has(&keys::root::SEA);
    let section = root.section(&keys::root::SEA);
    let swell: Vec<Option<Swell>> = root.sections(&keys::root::SWELL).into_iter().map(swell).collect();
    let slicks = slick::slicks(root, patch.as_ref(), place.as_ref());
    let land = land::land(root, carrier_hz);
    if !has_sea {
        root.idle(&[&keys::root::SWELL, &keys::root::SLICK], "there is no [sea]");
        return Some(None);
    }
    let section = section?;
    let wind = wind(&section);
    let spectrum = spectrum(&section);
    let dispersion = dispersion(&section);
    let permittivity = permittivity(&section, carrier_hz);
    let temperature_c = section.number(&keys::sea::TEMPERATURE_C);
    let salinity_psu = section.number(&keys::sea::SALINITY_PSU);
    let realisation = realisation(&section);
    let scattering = section
        .section_or_empty(&keys::sea::SCATTERING)
        .and_then(|section| scattering(section, permittivity, patch.as_ref()));
    let waves = waves(root, &section, scattering.as_ref());
    let shadow = section.section_or_empty(&keys::sea::SHADOW).and_then(|section| shadow(section, pri_s));
    let far = section.section_or_empty(&keys::sea::FAR).and_then(far);
    if let (Some(Some(_)), Some(still)) = (far, wind.as_ref().and_then(still)) {
        section.fault(
            still,
            Problem::BeyondModel {
                model: "sea.far",
                found: "a flat sea".to_owned(),
                allowed: format!("{} m/s or more, or sea.far.enabled = false", keys::figure(LEAST_WIND_MPS)),
            },
        );
    }
    if continuous && matches!(far, Some(Some(_))) {
        let found = "a far sea beside gate = \"continuous\"".to_owned();
        let allowed = "gate = \"windowed\", or sea.far.enabled = false".to_owned();
        section.fault(&keys::sea::FAR, Problem::Type { found, allowed });
    }
    section.finish();
    let water = Water {
        wind: wind?,
        spectrum: spectrum?,
        swell: swell.into_iter().collect::<Option<_>>()?,
        dispersion: dispersion?,
        temperature_c: temperature_c?,
        salinity_psu: salinity_psu?,
    };
    Some(Some(Sea {
        water,
        realisation: realisation?,
        patch: patch?,
        place: place?,
        azimuth_resolution_m: azimuth_resolution_m?,
        waves: waves?,
        scattering: scattering?,
        shadow: shadow?,
        far: far?,
        slicks: slicks?,
        land: land?,
    }))
}

/// A direction given as where to, from East counter-clockwise, or where from, from North clockwise; radians.
fn direction_rad(section: &Section<'_>, towards: &'static Key, from: &'static Key) -> Option<f64> {
    let written = section.exactly_one(&[towards, from]);
    let (towards_deg, from_deg) = (section.number(towards), section.number(from));
    written?;
    towards_deg.or(from_deg.map(|from_deg| 270.0 - from_deg)).map(f64::to_radians)
}

fn wind(section: &Section<'_>) -> Option<WindGiven> {
    use keys::sea::{WIND_FROM_DEG, WIND_HEIGHT_M, WIND_MPS, WIND_PROFILE, WIND_TOWARDS_DEG, WIND_USTAR_MPS};
    let written = section.exactly_one(&[&WIND_USTAR_MPS, &WIND_MPS]);
    let (ustar_mps, speed_mps) = (section.number(&WIND_USTAR_MPS), section.number(&WIND_MPS));
    if section.has(&WIND_USTAR_MPS) {
        section.idle(&[&WIND_HEIGHT_M], "together with wind_ustar_mps");
    }
    let height_m = section.number(&WIND_HEIGHT_M);
    let profile = section.choice(&WIND_PROFILE);
    let direction_rad = direction_rad(section, &WIND_TOWARDS_DEG, &WIND_FROM_DEG);
    written?;
    let strength = match (ustar_mps, speed_mps) {
        (Some(ustar_mps), _) => WindStrength::FrictionVelocity { ustar_mps },
        (None, Some(speed_mps)) => WindStrength::Speed { speed_mps, height_m: height_m? },
        (None, None) => return None,
    };
    Some(WindGiven { strength, profile: profile?, direction_rad: direction_rad? })
}

fn spectrum(section: &Section<'_>) -> Option<SpectrumKind> {
    use keys::sea::{
        FETCH_M, INVERSE_WAVE_AGE, SPECTRUM, SPECTRUM_PATH, SPECTRUM_TAIL, SPREADING, SPREADING_EXPONENT,
    };
    let growth = [&INVERSE_WAVE_AGE, &FETCH_M];
    let spread = [&SPREADING, &SPREADING_EXPONENT];
    let Some(kind) = section.choice::<SpectrumName>(&SPECTRUM) else {
        // It is not known which of these belong here: they are read, for faults of their own, where they are
        // written.
        for key in growth.into_iter().filter(|key| section.has(key)) {
            section.number(key);
        }
        section.choice::<SpreadingLaw>(&SPREADING);
        if section.has(&SPREADING_EXPONENT) {
            section.number(&SPREADING_EXPONENT);
        }
        if section.has(&SPECTRUM_PATH) {
            section.file(&SPECTRUM_PATH);
        }
        section.choice::<WithTail>(&SPECTRUM_TAIL);
        return None;
    };
    let when = format!("spectrum = \"{}\"", kind.word());
    let idle = |keys: &[&'static Key]| section.idle(keys, &when);
    if kind != SpectrumName::Measured {
        idle(&[&SPECTRUM_PATH, &SPECTRUM_TAIL]);
    }
    match kind {
        SpectrumName::Elfouhaily => {
            idle(&spread);
            Some(SpectrumKind::Elfouhaily { development: development(section)? })
        }
        SpectrumName::ElfouhailyFungLee => {
            idle(&spread);
            Some(SpectrumKind::ElfouhailyFungLee { development: development(section)? })
        }
        SpectrumName::FungLee => {
            idle(&growth);
            idle(&spread);
            Some(SpectrumKind::FungLee)
        }
        SpectrumName::PiersonMoskowitz => {
            idle(&growth);
            Some(SpectrumKind::PiersonMoskowitz { spreading: spreading(section)? })
        }
        SpectrumName::Jonswap => {
            idle(&[&INVERSE_WAVE_AGE]);
            let fetch_m = section.number(&FETCH_M);
            if !section.has(&FETCH_M) {
                section.fault(&FETCH_M, Problem::Missing { allowed: FETCH_M.kind.allowed() });
            }
            let spreading = spreading(section);
            Some(SpectrumKind::Jonswap { fetch_m: fetch_m?, spreading: spreading? })
        }
        SpectrumName::Measured => {
            idle(&growth);
            idle(&spread);
            let tail = section.choice(&SPECTRUM_TAIL);
            let path = section.file(&SPECTRUM_PATH)?;
            tail.map(|WithTail(tail)| SpectrumKind::Measured { path, tail })
        }
    }
}

fn development(section: &Section<'_>) -> Option<Development> {
    use keys::sea::{FETCH_M, INVERSE_WAVE_AGE};
    section.at_most_one(&[&INVERSE_WAVE_AGE, &FETCH_M]);
    let (age, fetch_m) = (section.number(&INVERSE_WAVE_AGE), section.number(&FETCH_M));
    if section.has(&FETCH_M) { fetch_m.map(Development::Fetch) } else { age.map(Development::InverseWaveAge) }
}

fn spreading(section: &Section<'_>) -> Option<Spreading> {
    use keys::sea::{SPREADING, SPREADING_EXPONENT};
    let fixed = |law: SpreadingLaw, spreading| {
        section.idle(&[&SPREADING_EXPONENT], &format!("spreading = \"{}\"", law.word()));
        Some(spreading)
    };
    match section.choice(&SPREADING) {
        Some(SpreadingLaw::Constant) => section.number(&SPREADING_EXPONENT).map(Spreading::Constant),
        Some(law @ SpreadingLaw::Elfouhaily) => fixed(law, Spreading::LikeElfouhaily),
        Some(law @ SpreadingLaw::Mitsuyasu) => fixed(law, Spreading::Mitsuyasu),
        None => {
            if section.has(&SPREADING_EXPONENT) {
                section.number(&SPREADING_EXPONENT);
            }
            None
        }
    }
}

fn dispersion(section: &Section<'_>) -> Option<Dispersion> {
    use keys::sea::{CAPILLARY, DEPTH_M};
    let capillary = section.flag(&CAPILLARY);
    let depth_m = section.number(&DEPTH_M);
    if section.has(&DEPTH_M) && depth_m.is_none() {
        return None;
    }
    Some(Dispersion { capillary: capillary?, depth_m })
}

/// Whether waves are choppy: unless set, wherever nothing asks for what choppy waves cannot do.
fn waves(root: &Section<'_>, section: &Section<'_>, scattering: Option<&FacetScattering>) -> Option<Waves> {
    use keys::sea::{DEPTH_M, WAVES};
    let moves = scattering.is_none_or(|scattering| scattering.displacement);
    let floats = root.any_has_flag(&keys::root::TARGET, &keys::target::FLOATING);
    let suits = moves && !floats && !section.has(&DEPTH_M);
    if section.choice_or(&WAVES, if suits { Waves::Choppy } else { Waves::Linear })? == Waves::Linear {
        return Some(Waves::Linear);
    }
    section.idle(&[&DEPTH_M], "waves = \"choppy\", which is for deep water only");
    if !moves {
        let error = "crests are sharp because facets follow the horizontal motion; allowed: waves = \"linear\", or \
                     scattering.displacement = true";
        section.fault(&WAVES, Problem::Refused { error: error.to_owned() });
    }
    Some(Waves::Choppy)
}

fn permittivity(section: &Section<'_>, carrier_hz: Option<f64>) -> Option<Permittivity> {
    use keys::sea::{PERMITTIVITY, SALINITY_PSU, TEMPERATURE_C};
    let model = section.choice(&PERMITTIVITY)?;
    let range = match model {
        Permittivity::MeissnerWentz => MEISSNER_WENTZ,
        Permittivity::KleinSwift => KLEIN_SWIFT,
        Permittivity::ItuRP527 => ITU_R_P527,
    };
    let check = |key: &'static Key, what: &str, unit: &str, value: Option<f64>, [low, high]: [f64; 2]| {
        if let Some(value) = value.filter(|value| !(low..=high).contains(value)) {
            let found = format!("{what} = {} {unit}", keys::figure(value));
            let mut allowed = format!("{} to {} {unit}", keys::figure(low), keys::figure(high));
            let [least, most] = ITU_R_P527.carrier_hz;
            if unit == "Hz" && (least..=most).contains(&value) {
                allowed.push_str(&format!(", or permittivity = \"{}\"", ITU_R_P527.model));
            }
            section.fault(key, Problem::BeyondModel { model: range.model, found, allowed });
        }
    };
    check(&PERMITTIVITY, "radar.carrier_hz", "Hz", carrier_hz, range.carrier_hz);
    // What lies outside the key's own range has its own fault.
    let within = |key: &'static Key| section.peek(key);
    check(&TEMPERATURE_C, "temperature_c", "C", within(&TEMPERATURE_C), range.temperature_c);
    check(&SALINITY_PSU, "salinity_psu", "psu", within(&SALINITY_PSU), range.salinity_psu);
    Some(model)
}

fn realisation(section: &Section<'_>) -> Option<Realisation> {
    use keys::sea::{AVERAGING, STATE_PATH};
    if section.has(&STATE_PATH) {
        section.idle(&[&AVERAGING], "together with state_path");
        return section.file(&STATE_PATH).map(|path| Realisation::Saved { path });
    }
    section.file(&STATE_PATH);
    section.choice(&AVERAGING).map(|averaging| Realisation::Drawn { averaging })
}

fn scattering(
    section: Section<'_>,
    permittivity: Option<Permittivity>,
    patch: Option<&Patch>,
) -> Option<FacetScattering> {
    use keys::scattering::{
        BRAGG, BREAKING, CUT_RADPM, DECORRELATION_MS, DISPLACEMENT, DRIFT_DEG, DRIFT_SHARE, GRAM_CHARLIER,
        LIGHT_WIND, MODULATION, PHASES, RELAXATION_PER_S, SPECKLE, SPLITTING, TILT_AVERAGE, TILT_MODES,
    };
    let splitting = section.choice(&SPLITTING);
    let phases = section.choice(&PHASES);
    let cut_radpm = section.number(&CUT_RADPM);
    let decorrelation_ms = section.number(&DECORRELATION_MS);
    let sound = |key, value: Option<f64>| !section.has(key) || value.is_some();
    let relaxation_per_s = section.number(&RELAXATION_PER_S);
    let sound = sound(&CUT_RADPM, cut_radpm)
        && sound(&DECORRELATION_MS, decorrelation_ms)
        && sound(&RELAXATION_PER_S, relaxation_per_s);
    let modulation = section.choice(&MODULATION);
    if modulation == Some(ModulationKind::Off) {
        section.idle(&[&RELAXATION_PER_S], "modulation = \"off\"");
    }
    let speckle = section.choice(&SPECKLE);
    let tilt_modes = section.count(&TILT_MODES);
    if speckle == Some(SpeckleKind::RandomPhase) {
        section.idle(&[&TILT_MODES], "speckle = \"random-phase\"");
    }
    // One phase cannot turn with two lines.
    let single = phases == Some(Phases::Single);
    let bragg = section.choice_or(&BRAGG, if single { BraggKind::Frozen } else { BraggKind::Travelling });
    let [drift_share, drift_deg] = [&DRIFT_SHARE, &DRIFT_DEG].map(|key| section.number(key));
    if bragg == Some(BraggKind::Frozen) {
        let why = if section.has(&BRAGG) { "bragg = \"frozen\"" } else { "phases = \"single\"" };
        section.idle(&[&DRIFT_SHARE, &DRIFT_DEG], why);
    }
    if bragg == Some(BraggKind::Travelling) && single {
        section.idle(
            &[&BRAGG],
            "phases = \"single\": one phase for waves of both lines; set phases = \"polcoherent\"",
        );
    }
    // In any wind no more than are allowed, and hardly more than facets.
    let few = patch.is_none_or(|patch| {
        let area_m2 = patch.len() as f64 * patch.facet_m * patch.facet_m;
        patch.facet_m <= BREAKING_FACET_M && area_m2 <= BREAKING_AREA_M2
    });
    let breaking = section.choice_or(&BREAKING, if few { Breaking::Whitecaps } else { Breaking::Off });
    let light_wind = section.choice(&LIGHT_WIND);
    let [gram_charlier, displacement] = [&GRAM_CHARLIER, &DISPLACEMENT].map(|key| section.flag(key));
    // The paper's slope density already holds the tilts.
    let tilt_average = section.flag_or(&TILT_AVERAGE, splitting != Some(Splitting::Mars2007));
    if splitting == Some(Splitting::Mars2007) && tilt_average == Some(true) {
        section.idle(&[&TILT_AVERAGE], "splitting = \"mars2007\"");
    }
    if speckle == Some(SpeckleKind::Gaussian) && (tilt_average == Some(false) || single) {
        section.idle(&[&TILT_MODES], if single { "phases = \"single\"" } else { "tilt_average = false" });
    }
    section.finish();
    if !sound {
        return None;
    }
    Some(FacetScattering {
        permittivity: permittivity?,
        splitting: splitting?,
        cut_radpm,
        tilt_average: tilt_average?,
        light_wind: light_wind?,
        gram_charlier: gram_charlier?,
        phases: phases?,
        speckle: match speckle? {
            SpeckleKind::RandomPhase => Speckle::RandomPhase,
            SpeckleKind::Gaussian => Speckle::Gaussian { tilt_modes: tilt_modes? as usize },
        },
        bragg: match bragg? {
            BraggKind::Travelling => {
                BraggWaves::Travelling { drift_share: drift_share?, drift_turn_rad: drift_deg?.to_radians() }
            }
            BraggKind::Frozen => BraggWaves::Frozen,
        },
        breaking: breaking?,
        modulation: match modulation? {
            ModulationKind::Relaxation => Modulation::Relaxation { rate_per_s: relaxation_per_s },
            ModulationKind::Off => Modulation::Off,
        },
        decorrelation_s: decorrelation_ms.map(|ms| ms / 1e3),
        displacement: displacement?,
    })
}

/// `Some(None)` where nothing is hidden.
fn shadow(section: Section<'_>, pri_s: Option<f64>) -> Option<Option<Shadowing>> {
    use keys::shadow::{EDGE, ENABLED, RAYS_PER_FACET, TWO_RAYS, UPDATE_MS, WIDTH_RAD};
    let enabled = section.flag(&ENABLED);
    let edge = section.choice(&EDGE);
    let width_rad = section.number(&WIDTH_RAD);
    let sound = !section.has(&WIDTH_RAD) || width_rad.is_some();
    if edge == Some(ShadowEdge::Sharp) {
        section.idle(&[&WIDTH_RAD], "edge = \"sharp\"");
    }
    let rays = section.count(&RAYS_PER_FACET);
    // Ten pulses are a block of the fast echo: no update lies within one.
    let steps = |pri_s: f64| (UPDATE_S / (10.0 * pri_s)).round().max(1.0) * 10.0 * pri_s;
    let update_s = match section.number(&UPDATE_MS) {
        Some(update_ms) => update_ms / 1e3,
        None => pri_s.map_or(UPDATE_S, steps),
    };
    let two_rays = section.flag(&TWO_RAYS);
    if enabled == Some(false) {
        section.idle(&[&TWO_RAYS], "enabled = false");
    }
    section.finish();
    let width_rad = match edge? {
        ShadowEdge::Soft => width_rad,
        ShadowEdge::Sharp => Some(0.0),
    };
    let rays_per_facet = usize::try_from(rays?).ok()?;
    let shadowing = Shadowing { width_rad, rays_per_facet, update_s, two_rays: two_rays? };
    sound.then_some(enabled?.then_some(shadowing))
}

/// The key of a wind that raises no waves.
fn still(wind: &WindGiven) -> Option<&'static Key> {
    match wind.strength {
        WindStrength::Speed { speed_mps, .. } => (speed_mps < LEAST_WIND_MPS).then_some(&keys::sea::WIND_MPS),
        WindStrength::FrictionVelocity { ustar_mps } => {
            (ustar_mps == 0.0).then_some(&keys::sea::WIND_USTAR_MPS)
        }
    }
}

/// `Some(None)` where the sea ends with the patch.
fn far(section: Section<'_>) -> Option<Option<FarSea>> {
    use keys::far::{CELLS, ENABLED, MOST_CELLS, TEXTURE};
    let enabled = section.flag(&ENABLED);
    let [cells, most] = [&CELLS, &MOST_CELLS].map(|key| section.count(key));
    let texture = section.flag(&TEXTURE);
    if enabled == Some(false) {
        section.idle(&[&CELLS, &MOST_CELLS, &TEXTURE], "enabled = false");
    }
    section.finish();
    let far =
        FarSea { cells: u32::try_from(cells?).ok()?, most: u32::try_from(most?).ok()?, texture: texture? };
    Some(enabled?.then_some(far))
}

/// Significant height over the length of the waves at the peak of the steepest seas.
const STEEPEST: f64 = 0.07;

fn swell(section: Section<'_>) -> Option<Swell> {
    use keys::swell::{
        FROM_DEG, PEAK_ENHANCEMENT, PEAK_PERIOD_S, RELATIVE_WIDTH, SHAPE, SIGNIFICANT_HEIGHT_M, SPREAD_DEG,
        TOWARDS_DEG,
    };
    let significant_height_m = section.number(&SIGNIFICANT_HEIGHT_M);
    let peak_period_s = section.number(&PEAK_PERIOD_S);
    if let Some((height_m, period_s)) = significant_height_m.zip(peak_period_s) {
        let length_m = GRAVITY_MPS2 * period_s * period_s / TAU;
        let allowed_m = STEEPEST * length_m;
        if height_m > allowed_m {
            let key = section.path_of(SIGNIFICANT_HEIGHT_M.name);
            section.reader().warn(Warning::SteepSwell { key, height_m, length_m, allowed_m });
        }
    }
    let direction_rad = direction_rad(&section, &TOWARDS_DEG, &FROM_DEG);
    let spread_deg = section.number(&SPREAD_DEG);
    let shape = match section.choice(&SHAPE) {
        Some(SwellKind::Jonswap) => {
            section.idle(&[&RELATIVE_WIDTH], "shape = \"jonswap\"");
            let peak_enhancement = section.number(&PEAK_ENHANCEMENT);
            peak_enhancement.map(|peak_enhancement| SwellShape::Jonswap { peak_enhancement })
        }
        Some(SwellKind::Gaussian) => {
            section.idle(&[&PEAK_ENHANCEMENT], "shape = \"gaussian\"");
            let relative_width = section.number(&RELATIVE_WIDTH);
            relative_width.map(|relative_width| SwellShape::Gaussian { relative_width })
        }
        None => {
            for key in [&RELATIVE_WIDTH, &PEAK_ENHANCEMENT].into_iter().filter(|key| section.has(key)) {
                section.number(key);
            }
            None
        }
    };
    section.finish();
    Some(Swell {
        significant_height_m: significant_height_m?,
        peak_period_s: peak_period_s?,
        direction_rad: direction_rad?,
        spread_rad: spread_deg?.to_radians(),
        shape: shape?,
    })
}
