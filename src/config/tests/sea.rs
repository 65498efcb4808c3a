//! Seas: what the keys mean, and every way to be wrong.

use proptest::prelude::*;

use super::refused::{corrupted, survives};
use super::*;
use crate::scattering::permittivity::Model;
use crate::scene::radar::{Sweep, Waveform};
use crate::scene::sea::{
    Averaging, BraggWaves, Breaking, FacetScattering, LightWinds, Modulation, PatchPlace, Permittivity,
    Phases, Realisation, Shadowing, SlickShape, Speckle, Splitting, Waves,
};
use crate::scene::ship::HullGiven;
use crate::scene::water::{
    Development, Dispersion, SpectrumKind, Spreading, Swell, SwellShape, WindProfile, WindStrength,
};
use crate::scene::{Patch, Sea};
use crate::sea::spectrum::FETCH_RANGE_M;
use crate::sea::{dispersion, spectrum::spreading, surface, wind};

const SEA: &str = include_str!("../../../configs/sea.toml");
const PLAIN_SWELL: &str = "{ significant_height_m = 1, peak_period_s = 10, towards_deg = 0 }";

/// Scenarios that between them read every key of a sea.
pub(super) fn variants() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    let beside = "{ kind = 'beside', platform = 'aircraft', across_m = 3000 }";
    vec![
        (SEA, vec![]),
        (SEA, vec![("land", "{ dem = 'README.md' }")]),
        (SEA, vec![("scene.patch", "follow"), ("scene.patch_follow", beside)]),
        (
            SEA,
            vec![(
                "scene.patch_follow",
                "{ kind = 'point', lat_deg = 1, lon_deg = 2, velocity_mps = [0, 1, 0] }",
            )],
        ),
        (
            SEA,
            vec![("sea.spectrum", "jonswap"), ("sea.spreading", "constant"), ("sea.spreading_exponent", "3")],
        ),
        (
            SEA,
            vec![
                ("sea.spectrum", "measured"),
                ("sea.spectrum_path", "README.md"),
                ("scene.patch_follow", "{ kind = 'point', position_m = [0, 0, 0] }"),
            ],
        ),
        (SEA, vec![("swell.0.shape", "jonswap")]),
        (SEA, vec![("slick.0", "{ corners_m = [[0, 0], [1, 0], [0, 1]] }")]),
    ]
}

fn sea_with(list: &[(&str, &str)]) -> Result<Run, ConfigError> {
    parse(SEA, &in_configs(), &settings(list))
}

pub(super) fn sea_of(list: &[(&str, &str)]) -> Sea {
    sea_with(list).unwrap().scene.sea.unwrap()
}

fn faults(list: &[(&str, &str)]) -> String {
    let error = sea_with(list).unwrap_err();
    let folder = in_configs().parent().unwrap().display().to_string();
    error.faults().iter().map(|fault| format!("{fault}\n").replace(&folder, "configs")).collect()
}

/// The scenario with another `[sea]`, in TOML.
fn with_sea(table: &str) -> Sea {
    sea_of(&[("sea", table)])
}

#[test]
fn ranges_are_those_of_the_laws() {
    let range = |key: &'static keys::Key| match key.kind {
        keys::Kind::Number { min, max, .. } => [min, max],
        _ => panic!("{}", key.name),
    };
    assert_eq!(range(&keys::sea::WIND_MPS), [0.0, wind::MAX_SPEED_MPS]);
    assert_eq!(range(&keys::sea::WIND_HEIGHT_M), wind::HEIGHT_RANGE_M);
    assert_eq!(range(&keys::sea::FETCH_M), FETCH_RANGE_M);
    assert_eq!(range(&keys::sea::DEPTH_M), dispersion::DEPTH_RANGE_M);
    assert_eq!(range(&keys::sea::SPREADING_EXPONENT), [0.0, spreading::MAX_EXPONENT]);
    assert_eq!(range(&keys::scene::FACET_M), surface::grid::FACET_RANGE_M);
    assert_eq!(keys::MOST_FACETS, surface::grid::MAX_FACETS as u64);
    let models = [
        (keys::MEISSNER_WENTZ, Model::MeissnerWentz2012),
        (keys::KLEIN_SWIFT, Model::KleinSwift1977),
        (keys::ITU_R_P527, Model::ItuRP527),
    ];
    let mut widest = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for (listed, model) in models {
        let law = model.range();
        let pair = |(low, high)| [low, high];
        assert_eq!(listed.carrier_hz, pair(law.frequency_hz));
        assert_eq!(listed.temperature_c, pair(law.temperature_c));
        assert_eq!(listed.salinity_psu, pair(law.salinity_gpkg));
        for (widest, one) in widest.iter_mut().zip([listed.temperature_c, listed.salinity_psu]) {
            *widest = [widest[0].min(one[0]), widest[1].max(one[1])];
        }
    }
    assert_eq!([range(&keys::sea::TEMPERATURE_C), range(&keys::sea::SALINITY_PSU)], widest);
}

#[test]
fn defaults_are_those_of_the_descriptions() {
    let sea = with_sea("{ wind_mps = 7, wind_towards_deg = 90 }");
    assert_eq!((sea.waves, sea.scattering), (Waves::default(), FacetScattering::default()));
    // Ten pulses of a radar at 222 Hz; fewer would be nearer to the 20 ms of the description.
    let update_s = 10.0 * (1.0 / 222.0);
    assert_eq!(sea.shadow, Some(Shadowing { update_s, ..Shadowing::default() }));
    assert_eq!(sea.water.spectrum, SpectrumKind::Elfouhaily { development: Development::default() });
    assert_eq!(sea.water.dispersion, Dispersion::default());
    assert_eq!(sea.realisation, Realisation::Drawn { averaging: Averaging::default() });
    assert_eq!((sea.water.temperature_c, sea.water.salinity_psu), (20.0, 35.0));
    assert_eq!(sea.water.wind.profile, WindProfile::default());
    assert_eq!(sea.water.wind.strength, WindStrength::Speed { speed_mps: 7.0, height_m: 10.0 });
    assert_eq!(sea.water.wind.direction_rad, 90f64.to_radians());
    assert_eq!(sea.place, PatchPlace::Fixed);
    assert_eq!(sea.patch, Patch::new([128.0, 128.0], 1.0, [0.0, 0.0]).unwrap());
    let swell = sea_of(&[("swell", &format!("[{PLAIN_SWELL}]"))]).water.swell;
    assert_eq!(
        swell,
        [Swell {
            significant_height_m: 1.0,
            peak_period_s: 10.0,
            direction_rad: 0.0,
            spread_rad: 10f64.to_radians(),
            shape: SwellShape::Gaussian { relative_width: 0.1 },
        }]
    );
    let film = &sea_of(&[("slick.0", "{ corners_m = [[0, 0], [10, 0], [0, 10]] }")]).slicks[0];
    let default = crate::scattering::kind::slick::Slick::default();
    assert_eq!((film.elasticity_npm, film.cover, film.rim_m), (default.elasticity_npm, 1.0, 1.0));
    assert_eq!(film.name, "slick-0");
    // Targets alone need no sea, and none is made up.
    assert_eq!(parse(COASTAL, &in_configs(), &[]).unwrap().scene.sea, None);
}

#[test]
fn every_setting_arrives() {
    let sea = with_sea(
        "{ wind_ustar_mps = 0.36, wind_profile = 'wu', wind_from_deg = 240, spectrum = 'elfouhaily-fung-lee', \
         inverse_wave_age = 1.5, capillary = true, depth_m = 20, waves = 'linear', temperature_c = 4, salinity_psu = 10, \
         permittivity = 'klein-swift', averaging = 'cells', \
         scattering = { splitting = 'mars2007', phases = 'single', speckle = 'gaussian', cut_radpm = 70, gram_charlier = true, light_wind = 'published', \
         breaking = 'off', modulation = 'off', decorrelation_ms = 8, displacement = false }, shadow = { edge = 'sharp', rays_per_facet = 3, update_ms = 5 } }",
    );
    assert_eq!(sea.water.wind.strength, WindStrength::FrictionVelocity { ustar_mps: 0.36 });
    assert_eq!(sea.water.wind.profile, WindProfile::Wu);
    // From west-south-west is towards east-north-east.
    assert_eq!(sea.water.wind.direction_rad, 30f64.to_radians());
    let development = Development::InverseWaveAge(1.5);
    assert_eq!(sea.water.spectrum, SpectrumKind::ElfouhailyFungLee { development });
    assert_eq!(sea.water.dispersion, Dispersion { capillary: true, depth_m: Some(20.0) });
    assert_eq!((sea.water.temperature_c, sea.water.salinity_psu), (4.0, 10.0));
    assert_eq!(sea.realisation, Realisation::Drawn { averaging: Averaging::Cells });
    let scattering = FacetScattering {
        permittivity: Permittivity::KleinSwift,
        splitting: Splitting::Mars2007,
        cut_radpm: Some(70.0),
        tilt_average: false,
        light_wind: LightWinds::AsPublished,
        gram_charlier: true,
        phases: Phases::Single,
        speckle: Speckle::Gaussian { tilt_modes: 3 },
        bragg: BraggWaves::Frozen,
        breaking: Breaking::Off,
        modulation: Modulation::Off,
        decorrelation_s: Some(0.008),
        displacement: false,
    };
    assert_eq!(sea.scattering, scattering);
    assert_eq!(
        sea.shadow,
        Some(Shadowing { width_rad: Some(0.0), rays_per_facet: 3, update_s: 0.005, two_rays: false })
    );

    assert_eq!(sea_of(&[("sea.shadow.enabled", "false"), ("sea.shadow.update_ms", "7")]).shadow, None);
    assert_eq!(sea_of(&[("sea.shadow.width_rad", "0.02")]).shadow.unwrap().width_rad, Some(0.02));
    assert!(sea_of(&[("sea.shadow.two_rays", "true")]).shadow.unwrap().two_rays);
    let bragg = |list: &[(&str, &str)]| sea_of(list).scattering.bragg;
    let travelling = ("sea.scattering.bragg", "travelling");
    assert_eq!(bragg(&[travelling]), BraggWaves::Travelling { drift_share: 0.03, drift_turn_rad: 0.0 });
    assert_eq!(
        bragg(&[travelling, ("sea.scattering.drift_share", "0"), ("sea.scattering.drift_deg", "-90")]),
        BraggWaves::Travelling { drift_share: 0.0, drift_turn_rad: -std::f64::consts::FRAC_PI_2 }
    );
    let modulation = |list: &[(&str, &str)]| sea_of(list).scattering.modulation;
    let relaxation = ("sea.scattering.modulation", "relaxation");
    assert_eq!(modulation(&[("sea.scattering.modulation", "off")]), Modulation::Off);
    assert_eq!(modulation(&[]), Modulation::Relaxation { rate_per_s: None });
    assert_eq!(modulation(&[relaxation]), Modulation::Relaxation { rate_per_s: None });
    assert_eq!(
        modulation(&[relaxation, ("sea.scattering.relaxation_per_s", "0.5")]),
        Modulation::Relaxation { rate_per_s: Some(0.5) }
    );
    assert!(!sea_of(&[("sea.scattering.tilt_average", "false")]).scattering.tilt_average);
    assert!(!sea_of(&[("sea.scattering.splitting", "mars2007")]).scattering.tilt_average);
    let spectrum = |list: &[(&str, &str)]| sea_of(list).water.spectrum;
    assert_eq!(
        spectrum(&[("sea.fetch_m", "50000")]),
        SpectrumKind::Elfouhaily { development: Development::Fetch(50e3) }
    );
    assert_eq!(spectrum(&[("sea.spectrum", "fung-lee")]), SpectrumKind::FungLee);
    assert_eq!(
        spectrum(&[("sea.spectrum", "pierson-moskowitz"), ("sea.spreading", "elfouhaily")]),
        SpectrumKind::PiersonMoskowitz { spreading: Spreading::LikeElfouhaily }
    );
    assert_eq!(
        spectrum(&[
            ("sea.spectrum", "jonswap"),
            ("sea.fetch_m", "1e5"),
            ("sea.spreading", "constant"),
            ("sea.spreading_exponent", "4")
        ]),
        SpectrumKind::Jonswap { fetch_m: 1e5, spreading: Spreading::Constant(4.0) }
    );
    let path = in_configs().with_file_name("README.md");
    assert_eq!(
        spectrum(&[("sea.spectrum", "measured"), ("sea.spectrum_path", "README.md")]),
        SpectrumKind::Measured { path: path.clone(), tail: true }
    );
    assert_eq!(sea_of(&[("sea.state_path", "README.md")]).realisation, Realisation::Saved { path });
    let swell = sea_of(&[("swell.0.shape", "jonswap"), ("swell.0.peak_enhancement", "7")]).water.swell[0];
    assert_eq!(swell.shape, SwellShape::Jonswap { peak_enhancement: 7.0 });
    // The scenario's own: from 290 degrees is towards 110 from North, which is -20 from East.
    assert_eq!(swell.direction_rad, (-20f64).to_radians());
    let film = &sea_of(&[]).slicks[0];
    assert_eq!((film.name.as_str(), film.rim_m), ("oil", 4.0));
    assert_eq!(
        film.shape,
        SlickShape::Ellipse {
            centre_m: [0.0, 0.0],
            half_axes_m: [25.0, 12.0],
            direction_rad: 30f64.to_radians()
        }
    );
}

#[test]
fn a_patch_follows_what_the_receiver_looks_at_or_what_is_named() {
    let follows = |list: &[(&str, &str)]| {
        let mut all = vec![("scene.patch", "follow")];
        all.extend(list);
        sea_of(&all).place
    };
    let aim = Aim::Beside { platform: 0, along_m: 0.0, across_m: 3000.0 };
    assert_eq!(follows(&[]), PatchPlace::Follow { aim: aim.clone(), aim_from: AimFrom::Reported });
    let beside = "{ kind = 'beside', platform = 'aircraft', across_m = -10, aim_from = 'true' }";
    let aim = Aim::Beside { platform: 0, along_m: 0.0, across_m: -10.0 };
    let named = follows(&[("scene.patch_follow", beside)]);
    assert_eq!(named, PatchPlace::Follow { aim, aim_from: AimFrom::True });
    let point = "{ kind = 'point', position_m = [1, 2, 0], velocity_mps = [3, 4, 0] }";
    let PatchPlace::Follow { aim: Aim::Point { position, velocity }, .. } =
        follows(&[("scene.patch_follow", point)])
    else {
        panic!()
    };
    assert_eq!((position.to_array(), velocity.to_array()), ([1.0, 2.0, 0.0], [3.0, 4.0, 0.0]));
    insta::assert_snapshot!(faults(&[("scene.patch", "follow"), ("receiver.0.pointing", "{ kind = 'fixed' }")]), @r#"scene.patch_follow: is missing; required: a table [scene.patch_follow], as the first receiver aims at no point"#);
    insta::assert_snapshot!(faults(&[("scene.patch", "follow"), ("scene.patch_centre_m", "[1, 1]"), ("scene.patch_follow", "{ kind = 'beside', platform = 'ship', across_m = 1 }")]), @r#"
scene.patch_follow.platform: there is no platform "ship"; allowed: aircraft
scene.patch_centre_m: not allowed here (patch = "follow")
"#);
    insta::assert_snapshot!(faults(&[("scene.patch_follow", beside)]), @r#"scene.patch_follow: not allowed here (patch = "fixed")"#);
}

#[test]
fn patches_that_are_none() {
    insta::assert_snapshot!(faults(&[("scene.facet_m", "200")]), @r#"
scene.facet_m: facet of 200 m is larger than the patch of 128 m along x; allowed: a facet that fits into both sides
scene.facet_m: facet of 200 m is larger than the patch of 128 m along y; allowed: a facet that fits into both sides
"#);
    insta::assert_snapshot!(faults(&[("scene.facet_m", "3"), ("scene.patch_size_m", "[128, 130]")]), @r#"
scene.patch_size_m: patch of 128 m along x is not a multiple of the facet of 3 m; allowed: whole facets along both sides
scene.patch_size_m: patch of 130 m along y is not a multiple of the facet of 3 m; allowed: whole facets along both sides
"#);
    insta::assert_snapshot!(faults(&[("scene.facet_m", "100"), ("scene.patch_size_m", "[50, 250]")]), @r#"
scene.facet_m: facet of 100 m is larger than the patch of 50 m along x; allowed: a facet that fits into both sides
scene.patch_size_m: patch of 250 m along y is not a multiple of the facet of 100 m; allowed: whole facets along both sides
"#);
    insta::assert_snapshot!(faults(&[("scene.facet_m", "0"), ("scene.patch_size_m", "[-1, 250]")]), @r#"
scene.patch_size_m: entry 0, -1, is out of range; allowed: a list of 2 numbers from 1e-4 to 1e8 m
scene.facet_m: 0 is out of range; allowed: a number from 1e-4 to 100000 m, or "auto"
"#);
    insta::assert_snapshot!(faults(&[("scene.facet_m", "1e-3"), ("scene.patch_size_m", "[1e6, 1e6]")]), @r#"
scene.patch_size_m: 1000000000 facets along x; allowed: at most 1048576
scene.patch_size_m: 1000000000 facets along y; allowed: at most 1048576
"#);
    insta::assert_snapshot!(faults(&[("scene.patch_size_m", "[16384, 16384]")]), @r#"scene.patch_size_m: 268435456 facets; allowed: at most 67108864"#);
    let far = [
        ("scene.facet_m", "1e-4"),
        ("scene.patch_size_m", "[0.01, 0.01]"),
        ("scene.patch_centre_m", "[1e8, 0]"),
    ];
    assert!(sea_with(&far).is_ok());
    assert!(sea_with(&[("scene.facet_m", "0.1"), ("scene.patch_size_m", "[0.3, 0.7]")]).is_ok());
    // Keys without their sea, and a sea without its keys.
    let lost = SEA.replace("[sea]", "[sea_]").replace("[sea.shadow]", "[sea_.shadow]");
    let error = parse(&lost, Path::new("lost.toml"), &[]).unwrap_err();
    insta::assert_snapshot!(error.to_string(), @r#"
lost.toml:8:1: scene.patch_size_m: not allowed here (there is no [sea])
lost.toml:9:1: scene.facet_m: not allowed here (there is no [sea])
lost.toml:11:2: sea_: unknown key; did you mean sea?
lost.toml:19:3: swell: not allowed here (there is no [sea])
lost.toml:24:3: slick: not allowed here (there is no [sea])
lost.toml: 5 faults
"#);
    let bare = SEA.replace("patch_size_m = [128.0, 128.0]", "").replace("facet_m = 1.0", "");
    let error = parse(&bare, Path::new("bare.toml"), &[]).unwrap_err();
    insta::assert_snapshot!(error.to_string(), @r#"
bare.toml:5:2: scene.patch_size_m: is missing; required: a list of 2 numbers from 1e-4 to 1e8 m
bare.toml:5:2: scene.facet_m: is missing; required: a number from 1e-4 to 100000 m, or "auto"
bare.toml: 2 faults
"#);
}

#[test]
fn seas_that_are_none() {
    insta::assert_snapshot!(faults(&[("sea.wind_mps", "-1")]), @r#"sea.wind_mps: -1 is out of range; allowed: a number from 0 to 40 m/s"#);
    insta::assert_snapshot!(faults(&[("sea.wind_mps", "40.1"), ("sea.wind_height_m", "0.5")]), @r#"
sea.wind_mps: 40.1 is out of range; allowed: a number from 0 to 40 m/s
sea.wind_height_m: 0.5 is out of range; allowed: a number from 1 to 100 m
"#);
    insta::assert_snapshot!(faults(&[("sea.wind_ustar_mps", "0.3"), ("sea.wind_towards_deg", "3")]), @r#"
sea.wind_mps: wind_ustar_mps, wind_mps exclude each other; allowed: one of them
sea.wind_from_deg: wind_towards_deg, wind_from_deg exclude each other; allowed: one of them
"#);
    insta::assert_snapshot!(faults(&[("sea", "{ }")]), @r#"
sea: one of wind_ustar_mps, wind_mps is required
sea: one of wind_towards_deg, wind_from_deg is required
"#);
    insta::assert_snapshot!(faults(&[("sea", "{ wind_ustar_mps = 3.1, wind_height_m = 10, wind_towards_deg = 0 }")]), @r#"
sea.wind_ustar_mps: 3.1 is out of range; allowed: a number from 0 to 3 m/s
sea.wind_height_m: not allowed here (together with wind_ustar_mps)
"#);
    insta::assert_snapshot!(faults(&[("sea", "7")]), @r#"sea: 7 is not allowed; allowed: a table [sea]"#);
    insta::assert_snapshot!(faults(&[("sea.temperature_c", "35"), ("sea.salinity_psu", "-1")]), @r#"
sea.temperature_c: 35 is out of range; allowed: a number from -2 to 34 C
sea.salinity_psu: -1 is out of range; allowed: a number from 0 to 40 psu
"#);
    insta::assert_snapshot!(faults(&[("sea.permittivity", "klein-swift"), ("sea.temperature_c", "-1"), ("sea.salinity_psu", "36"), ("radar.carrier_hz", "35e9")]), @r#"
sea.permittivity: "klein-swift" does not hold at radar.carrier_hz = 3.5e10 Hz; allowed: 1e9 to 1e10 Hz, or permittivity = "itu-r-p527"
sea.temperature_c: "klein-swift" does not hold at temperature_c = -1 C; allowed: 0 to 30 C
sea.salinity_psu: "klein-swift" does not hold at salinity_psu = 36 psu; allowed: 4 to 35 psu
"#);
    insta::assert_snapshot!(faults(&[("radar.carrier_hz", "95e9"), ("radar.prf_hz", "-1")]), @r#"
sea.permittivity: "meissner-wentz" does not hold at radar.carrier_hz = 9.5e10 Hz; allowed: 1e9 to 9e10 Hz, or permittivity = "itu-r-p527"
radar.prf_hz: -1 is out of range; allowed: a number from 0.001 to 1e9 Hz
"#);
    // The same carrier is nobody's business without water.
    assert!(coastal_with(&[("radar.carrier_hz", "95e9")]).is_ok());
    insta::assert_snapshot!(faults(&[("sea.depth_m", "0"), ("sea.state_path", "nowhere.bin"), ("sea.averaging", "cells")]), @r#"
sea.depth_m: 0 is out of range; allowed: a number from 0.1 to 100000 m
sea.averaging: not allowed here (together with state_path)
sea.state_path: there is no file configs/nowhere.bin; allowed: a file that exists (relative to the scenario file)
"#);
    insta::assert_snapshot!(faults(&[("sea.scattering.cut_radpm", "0"), ("sea.scattering.decorrelation_ms", "-3"), ("sea.scattering.splitting", "mars"), ("sea.scattering.phase", "single")]), @r#"
sea.scattering.splitting: "mars" is not allowed; allowed: "consistent", "mars2007"
sea.scattering.cut_radpm: 0 is out of range; allowed: a number above 0, up to 1e6 rad/m
sea.scattering.decorrelation_ms: -3 is out of range; allowed: a number above 0, up to 1e9 ms
sea.scattering.phase: unknown key; did you mean phases?
"#);
    insta::assert_snapshot!(faults(&[("sea.scattering.bragg", "frozen"), ("sea.scattering.drift_share", "0.02"), ("sea.scattering.drift_deg", "200")]), @r#"
sea.scattering.drift_deg: 200 is out of range; allowed: a number from -180 to 180 deg
sea.scattering.drift_share: not allowed here (bragg = "frozen")
sea.scattering.drift_deg: not allowed here (bragg = "frozen")
"#);
    insta::assert_snapshot!(faults(&[("sea.scattering.bragg", "travelling"), ("sea.scattering.phases", "single")]), @r#"sea.scattering.bragg: not allowed here (phases = "single": one phase for waves of both lines; set phases = "polcoherent")"#);
    insta::assert_snapshot!(faults(&[("sea.scattering.modulation", "off"), ("sea.scattering.relaxation_per_s", "0")]), @r#"
sea.scattering.relaxation_per_s: 0 is out of range; allowed: a number from 0.01 to 1000 1/s
sea.scattering.relaxation_per_s: not allowed here (modulation = "off")
"#);
    insta::assert_snapshot!(faults(&[("sea.scattering.splitting", "mars2007"), ("sea.scattering.tilt_average", "true")]), @r#"sea.scattering.tilt_average: not allowed here (splitting = "mars2007")"#);
    insta::assert_snapshot!(faults(&[("sea.shadow.edge", "sharp"), ("sea.shadow.width_rad", "0.1"), ("sea.shadow.rays_per_facet", "0"), ("sea.shadow.update_ms", "0")]), @r#"
sea.shadow.width_rad: not allowed here (edge = "sharp")
sea.shadow.rays_per_facet: 0 is out of range; allowed: a whole number from 1 to 64
sea.shadow.update_ms: 0 is out of range; allowed: a number from 0.1 to 10000 ms
"#);
}

#[test]
fn keys_of_another_spectrum() {
    insta::assert_snapshot!(faults(&[("sea.spectrum", "fung-lee"), ("sea.fetch_m", "1e5"), ("sea.spreading", "mitsuyasu")]), @r#"
sea.fetch_m: not allowed here (spectrum = "fung-lee")
sea.spreading: not allowed here (spectrum = "fung-lee")
"#);
    insta::assert_snapshot!(faults(&[("sea.fetch_m", "1e5"), ("sea.inverse_wave_age", "2")]), @r#"sea.fetch_m: inverse_wave_age, fetch_m exclude each other; allowed: one of them"#);
    insta::assert_snapshot!(faults(&[("sea.fetch_m", "10"), ("sea.spreading_exponent", "2"), ("sea.spectrum_path", "README.md")]), @r#"
sea.spectrum_path: not allowed here (spectrum = "elfouhaily")
sea.spreading_exponent: not allowed here (spectrum = "elfouhaily")
sea.fetch_m: 10 is out of range; allowed: a number from 100 to 1e7 m
"#);
    insta::assert_snapshot!(faults(&[("sea.spectrum", "jonswap"), ("sea.inverse_wave_age", "2"), ("sea.spreading_exponent", "2")]), @r#"
sea.fetch_m: is missing; required: a number from 100 to 1e7 m
sea.inverse_wave_age: not allowed here (spectrum = "jonswap")
sea.spreading_exponent: not allowed here (spreading = "mitsuyasu")
"#);
    insta::assert_snapshot!(faults(&[("sea.spectrum", "pierson-moskowitz"), ("sea.fetch_m", "1e5"), ("sea.spreading", "constant")]), @r#"
sea.spreading_exponent: is missing; required: a number from 0 to 1000
sea.fetch_m: not allowed here (spectrum = "pierson-moskowitz")
"#);
    insta::assert_snapshot!(faults(&[("sea.spectrum", "measured"), ("sea.inverse_wave_age", "1")]), @r#"
sea.spectrum_path: is missing; required: a file that exists (relative to the scenario file)
sea.inverse_wave_age: not allowed here (spectrum = "measured")
"#);
    insta::assert_snapshot!(faults(&[("sea.spectrum", "measured"), ("sea.spectrum_path", "nowhere.csv")]), @r#"sea.spectrum_path: there is no file configs/nowhere.csv; allowed: a file that exists (relative to the scenario file)"#);
    insta::assert_snapshot!(faults(&[("sea.spectrum", "elfouhaly"), ("sea.fetch_m", "10"), ("sea.spreading_exponent", "-2")]), @r#"
sea.spectrum: "elfouhaly" is not allowed; allowed: "elfouhaily", "elfouhaily-fung-lee", "fung-lee", "pierson-moskowitz", "jonswap", "measured"
sea.fetch_m: 10 is out of range; allowed: a number from 100 to 1e7 m
sea.spreading_exponent: -2 is out of range; allowed: a number from 0 to 1000
"#);
}

#[test]
fn swells_and_slicks_that_are_none() {
    insta::assert_snapshot!(faults(&[("swell", "[{ significant_height_m = 31, peak_period_s = 0.5, spread_deg = 90, shape = 'jonswap', relative_width = 0.1 }]")]), @r#"
swell.0.significant_height_m: 31 is out of range; allowed: a number from 0 to 30 m
swell.0.peak_period_s: 0.5 is out of range; allowed: a number from 1 to 40 s
swell.0: one of towards_deg, from_deg is required
swell.0.spread_deg: 90 is out of range; allowed: a number from 3 to 80 deg
swell.0.relative_width: not allowed here (shape = "jonswap")
swell.0.peak_enhancement: is missing; required: a number from 1 to 50
"#);
    insta::assert_snapshot!(faults(&[("swell.0.towards_deg", "10"), ("swell.0.peak_enhancement", "5"), ("swell.0.relative_width", "0.5")]), @r#"
swell.0.from_deg: towards_deg, from_deg exclude each other; allowed: one of them
swell.0.peak_enhancement: not allowed here (shape = "gaussian")
swell.0.relative_width: 0.5 is out of range; allowed: a number from 0.01 to 0.3
"#);
    insta::assert_snapshot!(faults(&[("slick.0.corners_m", "[[0, 0], [1, 0], [0, 1]]"), ("slick.0.cover", "1.5")]), @r#"
slick.0.corners_m: centre_m, corners_m exclude each other; allowed: one of them
slick.0.cover: 1.5 is out of range; allowed: a number from 0 to 1
"#);
    insta::assert_snapshot!(faults(&[("slick", "[{ name = 'a', corners_m = [[0, 0], [1, 1]], half_axes_m = [1, 1], elasticity_npm = -1 }, { name = 'a', centre_m = [0, 0], half_axes_m = [0, 5], rim_m = -1 }, { }]")]), @r#"
slick.0.corners_m: [[0, 0], [1, 1]] is not allowed; allowed: a list of 3 to 1000 pairs [x, y] from -1e8 to 1e8 m
slick.0.half_axes_m: not allowed here (together with corners_m)
slick.0.elasticity_npm: -1 is out of range; allowed: a number from 0 to 1 N/m
slick.1.name: "a" is already the name of another slick; allowed: unique names
slick.1.half_axes_m: entry 0, 0, is out of range; allowed: a list of 2 numbers from 0.001 to 1e8 m
slick.1.rim_m: -1 is out of range; allowed: a number from 0 to 100000 m
slick.2: one of centre_m, corners_m is required
"#);
    insta::assert_snapshot!(faults(&[("slick", "[{ corners_m = [[0, 0], [1, 1], [3, 3], [2, 2]] }, { corners_m = [[0, 0], [1, 1, 1], [3, 4]] }, { corners_m = [[0, 0], [nan, 1], [3, 4]] }]")]), @r#"
slick.0.corners_m: the corners enclose no area; allowed: corners of a polygon, in turn
slick.1.corners_m: [[0, 0], [1, 1, 1], [3, 4]] is not allowed; allowed: a list of 3 to 1000 pairs [x, y] from -1e8 to 1e8 m
slick.2.corners_m: entry 1, [NaN, 1.0], is out of range; allowed: a list of 3 to 1000 pairs [x, y] from -1e8 to 1e8 m
"#);
}

#[test]
fn slicks_beyond_the_patch_give_a_warning() {
    let warned = |list: &[(&str, &str)]| {
        let run = sea_with(list).unwrap();
        of_scene(&run).iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(warned(&[]), "");
    insta::assert_snapshot!(warned(&[("slick.0.centre_m", "[200, 0]")]), @r#"slick "oil" lies outside the patch of sea: no facet has it"#);
    insta::assert_snapshot!(warned(&[("slick.0.centre_m", "[50, 0]")]), @r#"slick "oil" reaches beyond the patch of sea: only what lies inside is modelled"#);
    // The patch reaches from -64.5 to 63.5 m: along its edge nothing is cut.
    assert_eq!(
        warned(&[("slick.0", "{ corners_m = [[-64, -64], [64, -64], [64, 64], [-64, 64]], rim_m = 0 }")]),
        ""
    );
    // A patch that moves may come to any slick.
    assert_eq!(warned(&[("slick.0.centre_m", "[5000, 0]"), ("scene.patch", "follow")]), "");
}

#[test]
fn presets_are_the_configurations_of_the_paper() {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder =
        std::env::var_os("NEREUS_GOLDEN").map_or_else(|| manifest.join("tests/data/golden"), PathBuf::from);
    let golden: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("configs.json")).unwrap()).unwrap();
    let figure = |table: &str, key: &str| golden[table][key].as_f64().unwrap();
    for (index, configuration) in golden["configurations"].as_array().unwrap().iter().enumerate() {
        let run = load(&manifest.join(format!("configs/mars-{}.toml", index + 1)), &[]).unwrap();
        let (scene, radar) = (&run.scene, &run.scene.radar);
        assert_eq!(run.warnings.iter().filter(|w| !matches!(w, Warning::NoHdf5 { .. })).count(), 0);
        assert_eq!(scene.pulses as f64, figure("radar", "n_pulses"));
        assert_eq!(radar.carrier_hz, figure("radar", "f0_hz"));
        assert_eq!(radar.sample_rate_hz, figure("radar", "fs_hz"));
        assert_eq!(radar.emissions.mean_prf_hz(), figure("radar", "prf_hz"));
        assert_eq!(radar.losses_db, figure("radar", "losses_db"));
        assert_eq!(radar.transmitters[0].power_w, figure("radar", "peak_power_w"));
        let Waveform::Lfm { bandwidth_hz, duration_s, sweep: Sweep::Up } = radar.waveform else { panic!() };
        assert_eq!(bandwidth_hz, figure("radar", "bandwidth_hz"));
        assert_eq!(duration_s, figure("radar", "pulse_s"));
        let antenna = &golden["radar"]["antenna"];
        let [width_m, height_m] = ["width_m", "height_m"].map(|key| antenna[key].as_f64().unwrap());
        for mount in [&radar.transmitters[0].antenna, &radar.receivers[0].antenna] {
            assert_eq!(mount.pattern, Pattern::Rectangle { width_m, height_m });
        }
        let ends =
            [("tx", radar.transmitters[0].antenna.platform), ("rx", radar.receivers[0].antenna.platform)];
        for (end, platform) in ends {
            let vector = |key: &str| {
                let entries = configuration[end][key].as_array().unwrap().iter();
                entries.map(|value| value.as_f64().unwrap()).collect::<Vec<f64>>()
            };
            let (place, moves) = match &run.nav[platform].truth {
                TrackSource::Straight { place, velocity, .. } => (place, velocity.to_array()),
                TrackSource::Fixed { place, .. } => (place, [0.0; 3]),
                TrackSource::File(_) | TrackSource::Live(_) => panic!(),
            };
            let Place::Local(start) = place else { panic!() };
            assert_eq!(start.to_array().to_vec(), vector("start"));
            assert_eq!(moves.to_vec(), vector("velocity"));
        }
        let sea = scene.sea.as_ref().unwrap();
        let facets = golden["environment"]["dem"]["n"].as_u64().unwrap() as usize;
        assert_eq!(sea.patch.facets, [facets; 2]);
        assert_eq!(sea.patch.facet_m, golden["environment"]["dem"]["dx_m"].as_f64().unwrap());
        assert_eq!(sea.water.temperature_c, figure("environment", "T_c"));
        assert_eq!(sea.water.salinity_psu, figure("environment", "S_psu"));
        let ustar_mps = figure("environment", "ustar_m_s");
        assert_eq!(sea.water.wind.strength, WindStrength::FrictionVelocity { ustar_mps });
        assert_eq!(sea.water.wind.direction_rad, figure("environment", "wind_dir_deg").to_radians());
        let development = Development::InverseWaveAge(0.84);
        assert_eq!(sea.water.spectrum, SpectrumKind::ElfouhailyFungLee { development });
        // Middle of the patch and heading along the flight are inferred there too.
        let [ship] = &scene.ships[..] else { panic!("one ship") };
        let stated = &golden["environment"]["ship"];
        assert_eq!(
            (ship.length_m, ship.position_m, ship.heading_rad),
            (stated["L_m"].as_f64(), [0.0; 2], 0.0)
        );
        assert_eq!(Some(ship.speed_mps), stated["V_m_s"].as_f64());
        assert!(matches!(&ship.hull, HullGiven::File(path) if path.ends_with("dtmb5415.toml")));
    }
}

proptest! {
    #![proptest_config(crate::rng::cases::proptests(300))]

    #[test]
    fn a_corrupt_sea_is_read_or_refused(
        at in 0.0f64..1.0,
        cut in 0usize..40,
        put in "[a-z0-9_.=\\[\\]{}\"'\\-+#\n ,é]{0,12}",
    ) {
        survives(&corrupted(SEA, at, cut, &put));
    }

    #[test]
    fn extreme_numbers_of_a_sea_are_read_or_refused(
        index in 0usize..16,
        value in prop_oneof![any::<f64>(), (-12i32..13).prop_map(|e| 10f64.powi(e))],
    ) {
        let key = [
            "scene.facet_m", "scene.patch_size_m.0", "scene.patch_centre_m", "sea.wind_mps", "sea.wind_from_deg",
            "sea.wind_height_m", "sea.fetch_m", "sea.depth_m", "sea.temperature_c", "sea.salinity_psu",
            "sea.scattering.cut_radpm", "sea.shadow.width_rad", "sea.shadow.update_ms", "swell.0.peak_period_s",
            "slick.0.half_axes_m.1", "slick.0.centre_m.0",
        ][index];
        let value = if key.ends_with("centre_m") { format!("[{value:?}, 0]") } else { format!("{value:?}") };
        match parse(SEA, &in_configs(), &[(key.to_owned(), value)]) {
            Ok(run) => prop_assert!(!run.scene.sea.unwrap().patch.is_empty()),
            Err(error) => prop_assert!(!error.faults().is_empty()),
        }
    }
}

#[test]
fn land_needs_a_sea_and_one_gamma() {
    let faults = |overrides: &[(&str, &str)]| {
        let error = parse(SEA, &in_configs(), &settings(overrides)).unwrap_err();
        error.faults().iter().map(|fault| format!("{fault}\n")).collect::<String>()
    };
    let both = faults(&[("land", "{ dem = 'README.md', gamma_db = -12, terrain = 'urban' }")]);
    assert!(both.contains("land.terrain") && both.contains("together with gamma_db"), "{both}");
    let rain = faults(&[("radar.carrier_hz", "400e6"), ("radar.rain_mmph", "5")]);
    assert!(rain.contains("radar.rain_mmph") && rain.contains("ITU-R P.838-3"), "{rain}");
}
