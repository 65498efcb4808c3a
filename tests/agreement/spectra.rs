//! The fast echo of seas of every spectrum, against the error that is predicted: all pulses.

use std::fmt::Write;
use std::path::Path;

use nereus::bench::accuracy::Judge;
use nereus::config;

use crate::cases::some_of;
use crate::runs::measured;

/// All pulses of a small patch keep what the plan predicts.
fn keeps(name: &str, settings: &[(&str, &str)]) {
    let small = [("scene.patch_size_m", "[32, 32]"), ("scene.duration_s", "0.1"), ("target", "[]")];
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/sea.toml");
    let settings: Vec<_> =
        small.iter().chain(settings).map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    let mut run = config::load(&path, &settings).unwrap();
    run.sinks.clear();
    let judge = Judge::new(&run, (0..run.scene.pulses).collect(), 2, |_| ()).unwrap();
    let (measured_db, plan) = measured(&judge, &run);
    let predicted_db = plan.prediction.total_db();
    println!("{name}: predicted {predicted_db:.1}, measured {measured_db:.1} dB; {plan:?}");
    assert!(plan.keeps(), "{name}: {predicted_db}");
    assert!(measured_db <= predicted_db, "{name}: {predicted_db} {measured_db}");
}

#[test]
fn jonswap_up_the_wind_and_off_it() {
    let jonswap = [("sea.spectrum", "jonswap"), ("sea.fetch_m", "20000")];
    for from in some_of(["200", "270"]) {
        keeps(&format!("JONSWAP from {from}"), &[&jonswap[..], &[("sea.wind_from_deg", from)]].concat());
    }
}

#[test]
fn pierson_moskowitz_up_the_wind() {
    keeps("PM", &[("sea.spectrum", "pierson-moskowitz"), ("sea.wind_from_deg", "270")]);
}

/// The cusp that the default no longer has, of a sea that is asked for it.
#[test]
fn a_cusp_up_the_wind() {
    let cusp =
        [("sea.spreading", "constant"), ("sea.spreading_exponent", "0.02"), ("sea.wind_from_deg", "270")];
    keeps("cusp", &[&[("sea.spectrum", "pierson-moskowitz")], &cusp[..]].concat());
}

/// Files that reach the Bragg waves of X band: a beam of 3 degrees, and one value in ten of noise about
/// Phillips' law.
#[test]
fn narrow_and_noisy_files() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, psi: &mut dyn FnMut(f64, f64) -> f64| {
        let mut text = "kx_rad_m,ky_rad_m,psi_m4\n".to_owned();
        for i in -110..=110 {
            for j in -110..=110 {
                let (x, y) = (f64::from(i) * 4.0, f64::from(j) * 4.0);
                let k2 = (x * x + y * y).max(4.0);
                writeln!(text, "{x},{y},{:e}", 5e-4 / (k2 * k2) * psi(x, y)).unwrap();
            }
        }
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let narrow = write("narrow.csv", &mut |x, y| 1e-3 + (-0.5 * (y.atan2(x.abs()) / 0.05).powi(2)).exp());
    let mut state = 1u64;
    let noisy = write("noisy.csv", &mut |_, _| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        -(1.0 - (state >> 11) as f64 / 2f64.powi(53)).ln()
    });
    for path in some_of([noisy, narrow]) {
        let file = format!("\"{path}\"");
        keeps(
            &path,
            &[("sea.spectrum", "measured"), ("sea.spectrum_path", &file), ("sea.wind_from_deg", "270")],
        );
    }
}
