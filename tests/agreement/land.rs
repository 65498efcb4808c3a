//! Land on the patch: what it returns by the radar equation, what it hides by plane geometry, and that both
//! echoes agree.

use std::fs;
use std::path::Path;

use nereus::config::{self, Run};
use nereus::paths::list::ScattererPaths;
use nereus::pipeline::build;
use nereus::pipeline::factory::factory_by;

use crate::cases::{sized, some_of};
use crate::dem;
use crate::runs::{keeps_the_error, plan};

const ISLAND: &str = include_str!("../data/scenarios/island.toml");
pub const C_MPS: f64 = 299_792_458.0;
const CENTRE_M: [f64; 2] = [2000.0, 0.0];

fn load(folder: &Path, settings: &[(&str, &str)]) -> Run {
    let path = folder.join("island.toml");
    fs::write(&path, ISLAND).unwrap();
    let settings: Vec<_> = settings.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    config::load(&path, &settings).unwrap()
}

/// The scenario with a raster of 5 m cells, large enough for the patch wherever it goes.
pub fn scene(settings: &[(&str, &str)], height_m: impl Fn([f64; 2]) -> f64) -> Run {
    let folder = tempfile::tempdir().unwrap();
    dem::around(&folder.path().join("island.tif"), CENTRE_M, 100, 5.0, height_m);
    let run = load(folder.path(), settings);
    // The raster is read when a run is built; the folder lives as long as the tests.
    std::mem::forget(folder);
    run
}

/// A hill of 40 m with a coast some 55 m from its top.
pub fn hill([x, y]: [f64; 2]) -> f64 {
    let square = (x - CENTRE_M[0]).powi(2) + (y - CENTRE_M[1]).powi(2);
    50.0 * (-square / (2.0 * 45f64.powi(2))).exp() - 10.0 - 15.0 * (x / 23.0).sin() * (y / 31.0).cos()
}

fn paths(run: &Run) -> ScattererPaths {
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    factory_by(&run.scene, tracks, &run.fidelity, &run.clocks).unwrap().scatterer_paths(0).unwrap().1
}

/// A patch that stays.
pub const FIXED: (&str, &str) = ("scene.patch_centre_m", "[2000.0, 0.0]");
pub const AT_REST: (&str, &str) =
    ("platform.0.track", "{ kind = \"fixed\", position_m = [0.0, 0.0, 300.0] }");

#[test]
fn a_plateau_returns_what_the_radar_equation_asks() {
    // All of the patch at 20 m; gamma -12 dB, HH 1 dB above, cross-polarisation 7 dB below.
    let settings = [
        AT_REST,
        FIXED,
        ("land.gamma_db", "-12.0"),
        ("land.hh_over_vv_db", "1.0"),
        ("land.cross_over_vv_db", "-7.0"),
    ];
    let paths = paths(&scene(&settings, |_| 20.0));
    assert_eq!(paths.len(), 64 * 64);
    let wavelength_m = C_MPS / 10e9;
    let mut expected_w = 0.0;
    for ix in -32..32 {
        for iy in -32..32 {
            let [x, y] = [CENTRE_M[0] + 4.0 * f64::from(ix), CENTRE_M[1] + 4.0 * f64::from(iy)];
            let range_m = x.hypot(y).hypot(280.0);
            let sigma_m2 = 10f64.powf(-1.2) * (280.0 / range_m) * 16.0;
            expected_w += 1000.0 * 1e6 * wavelength_m.powi(2) * sigma_m2
                / ((4.0 * std::f64::consts::PI).powi(3) * range_m.powi(4));
        }
    }
    let returned = |channel: usize| {
        let power_w: f64 = paths.amplitude[channel].iter().map(|a| a.norm_sqr()).sum();
        10.0 * (power_w / expected_w).log10()
    };
    let found = [0, 1, 2].map(returned);
    println!("HH, VV, HV over the radar equation: {found:?} dB");
    // The law's fall-off at a grazing angle of 8 degrees is 0.09 dB; an isotropic antenna mixes the two by
    // the few degrees between its vertical and that of the path.
    for (found, expected) in found.into_iter().zip([1.0, 0.0, -7.0]) {
        assert!((found - expected).abs() < 0.2, "{found} {expected}");
    }
    assert!(paths.delay_rate[0].iter().all(|rate| *rate == 0.0), "land rests");
    let nearest_s = paths.delay_s[0].iter().copied().fold(f64::INFINITY, f64::min);
    let expected_s = 2.0 * (CENTRE_M[0] - 128.0).hypot(280.0) / C_MPS;
    assert!((nearest_s - expected_s).abs() < 1e-12, "{nearest_s} {expected_s}");
}

#[test]
fn a_ridge_hides_the_sea_behind_it() {
    // A ridge across the line of sight, 15 m high and 12 m wide at the top, 40 m before the middle. From 300
    // m its shadow on the sea is 15/285 of the distance: 103 m.
    let ridge = |[x, _]: [f64; 2]| if (x - 1960.0).abs() < 8.0 { 15.0 } else { -1.0 };
    let calm = [AT_REST, FIXED, ("sea.wind_mps", "3.0"), ("scene.patch_size_m", "[256.0, 64.0]")];
    let run = scene(&calm, ridge);
    let with = paths(&run);
    let delay_s = |x: f64| 2.0 * x.hypot(300.0) / C_MPS;
    let power = |paths: &ScattererPaths, from_m: f64, to_m: f64| -> f64 {
        let within = |delay: &f64| (delay_s(from_m)..delay_s(to_m)).contains(delay);
        let of = paths.delay_s[0].iter().zip(&paths.amplitude[1]);
        of.filter(|(delay, _)| within(delay)).map(|(_, a)| a.norm_sqr()).sum()
    };
    let without = paths(&scene(&calm, |_| -1.0));
    let share = |from_m: f64, to_m: f64| power(&with, from_m, to_m) / power(&without, from_m, to_m);
    let [before, within, beyond] = [share(1880.0, 1940.0), share(1985.0, 2050.0), share(2080.0, 2120.0)];
    println!("of the open sea before, in the shadow, beyond: {before:.3} {within:.2e} {beyond:.3}");
    assert!((before - 1.0).abs() < 0.02 && within < 1e-3 && (beyond - 1.0).abs() < 0.1);
    // The ridge itself.
    assert!(share(1940.0, 1960.0) > 3.0);
}

#[test]
fn rain_takes_its_decibels_of_every_path() {
    let run = |rain: &str| paths(&scene(&[AT_REST, FIXED, ("radar.rain_mmph", rain)], hill));
    let (dry, wet) = (run("0.0"), run("25.0"));
    assert!(dry.len() == wet.len() && dry.len() > 1000);
    // k and alpha of H and V at 10 GHz, ITU-R P.838-3, table 5; VV from 300 m over facets at some 15 m.
    let [h, v] = [[0.01217, 1.2571], [0.01129, 1.2156]];
    let tilt = -(1.0 - (285f64 / 2000.0).powi(2));
    let k = 0.5 * (h[0] + v[0] + (h[0] - v[0]) * tilt);
    let db_a_km =
        k * 25f64.powf((h[0] * h[1] + v[0] * v[1] + (h[0] * h[1] - v[0] * v[1]) * tilt) / (2.0 * k));
    let found = dry.amplitude[1].iter().zip(&wet.amplitude[1]).zip(&dry.delay_s[0]);
    let worst = found.filter(|((dry, _), _)| dry.norm() > 0.0).map(|((dry, wet), delay_s)| {
        let expected_db = db_a_km * delay_s * C_MPS / 1e3;
        (20.0 * (dry.norm() / wet.norm()).log10() - expected_db).abs()
    });
    let worst = worst.fold(0.0, f64::max);
    println!("{db_a_km:.4} dB/km, worst {worst:.1e} dB off");
    assert!(worst < 5e-3, "{worst}");
}

#[test]
fn an_island_is_the_same_in_both_echoes() {
    let cases: [&[(&str, &str)]; 4] = [
        &[FIXED],
        // Land as weak as the sea, so that both count, in rain.
        &[
            FIXED,
            ("sea.scattering.bragg", "\"travelling\""),
            ("land.gamma_db", "-38.0"),
            ("radar.rain_mmph", "40.0"),
        ],
        &[FIXED, ("sea.scattering.phases", "\"single\"")],
        &[
            ("scene.patch", "\"follow\""),
            ("scene.patch_follow", "{ kind = \"beside\", platform = \"aircraft\", across_m = 2000.0 }"),
        ],
    ];
    for settings in some_of(cases) {
        // Both tiers of interpolation once.
        let asked: &[&str] = if settings.len() == 1 { &["-60.0", "-45.0"] } else { &["-60.0"] };
        for error_db in some_of(asked) {
            let fast = [("fidelity.echo", "\"fast\""), ("fidelity.error_db", error_db)];
            println!("{settings:?}");
            keeps_the_error("land", &scene(&[settings, &fast].concat(), hill));
        }
    }
}

#[test]
fn a_part_of_a_run_is_bit_identical() {
    let follow = [
        ("scene.patch", "\"follow\""),
        ("scene.patch_follow", "{ kind = \"beside\", platform = \"aircraft\", across_m = 2000.0 }"),
    ];
    let run = scene(&follow, hill);
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    let at = |pulses: &[u64]| {
        let factory = factory_by(&run.scene, tracks.clone(), &run.fidelity, &run.clocks).unwrap();
        pulses.iter().map(|pulse| factory.scatterer_paths(*pulse).unwrap().1.amplitude).next_back().unwrap()
    };
    assert_eq!(at(&[0, 10, 20, 30]), at(&[30]));
}

#[test]
fn nothing_breaks_on_land() {
    let count = |breaking, height_m: f64| {
        let settings = [AT_REST, FIXED, ("sea.wind_mps", "15"), ("sea.scattering.breaking", breaking)];
        paths(&scene(&settings, |_| height_m)).len()
    };
    assert_eq!(count("whitecaps", 20.0), count("off", 20.0));
    assert!(count("whitecaps", -20.0) > count("off", -20.0));
}

/// Something strong behind the hill, as the aircraft sees it.
const IN_THE_LEE: &str = "[{ name = \"mast\", position_m = [2070.0, 5.0, 1.0], rcs_m2 = 1e6 }]";

const FAST: [(&str, &str); 2] = [("fidelity.echo", "\"fast\""), ("fidelity.error_db", "-60.0")];

#[test]
fn what_land_hides_is_not_in_the_predicted_error() {
    let patch = ("scene.patch_size_m", sized("[256, 256]", "[192, 192]"));
    let fast = [patch, FIXED, FAST[0], FAST[1]];
    let with = |target| scene(&[&fast[..], &[("target", target)]].concat(), hill);
    let (without, hidden) = (plan(&scene(&fast, hill)), plan(&with(IN_THE_LEE)));
    let [without_db, hidden_db] = [without, hidden].map(|plan| plan.prediction.total_db());
    println!("predicted without {without_db:.2} dB, with what is hidden {hidden_db:.2} dB");
    assert!((hidden_db - without_db).abs() < 0.1);
    keeps_the_error("in the lee", &with(IN_THE_LEE));
}

/// On the edge of the shadow, which moves over it.
#[test]
fn what_land_uncovers_is_in_the_predicted_error() {
    let edge = "[{ name = \"mast\", position_m = [2070.0, 60.0, 9.0], velocity_mps = [0.0, 30.0, 0.0], rcs_m2 = 1e4 }]";
    keeps_the_error("at the edge", &scene(&[FIXED, FAST[0], FAST[1], ("target", edge)], hill));
}

#[test]
fn land_hides_ships() {
    let ship = "[{ name = 'tug', hull = 'wigley', beam_m = 5.0, draught_m = 2.0, length_m = 20.0, position_m = [2080.0, 0.0], speed_mps = 0.0, heading_deg = 40.0, \
                wake = false, turbulent = false, echo = true, panel_m = 2.0 }]";
    let power_w = |ship: &str, height_m: fn([f64; 2]) -> f64| {
        let plain = [
            ("sea.waves", "linear"),
            ("sea.scattering.modulation", "off"),
            ("sea.scattering.breaking", "off"),
        ];
        let settings = [&[AT_REST, FIXED, ("sea.wind_mps", "3.0"), ("ship", ship)][..], &plain].concat();
        let paths = paths(&scene(&settings, height_m));
        let delays_s = [2060.0f64, 2100.0].map(|x| 2.0 * x.hypot(300.0) / C_MPS);
        let of = paths.delay_s[0].iter().zip(&paths.amplitude[0]);
        let within = of.filter(|(delay_s, _)| (delays_s[0]..delays_s[1]).contains(*delay_s));
        within.map(|(_, a)| a.norm_sqr()).sum::<f64>()
    };
    let open = |_: [f64; 2]| -1.0;
    let [lit, sea, hidden, lee] =
        [power_w(ship, open), power_w("[]", open), power_w(ship, hill), power_w("[]", hill)];
    println!(
        "on the open sea {lit:.2e} W, the sea alone {sea:.2e}; behind the hill {hidden:.3e} and {lee:.3e}"
    );
    // The sea about the ship is one draw of some hundred facets: the ship is to stand out of it, not by how
    // much.
    assert!(lit > 3.0 * sea && hidden <= lee * (1.0 + 1e-9));
}
