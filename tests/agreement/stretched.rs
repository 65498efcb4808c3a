//! Pulses that are stretched by the motion, from scenario to samples: the fast echo keeps what is asked.

use nereus::bench::accuracy::Judge;
use nereus::echo::synth::doppler::Envelope;
use nereus::fidelity::budget::Plan;

use crate::cases::some_of;
use crate::runs::{measured, plan, scene};

/// Measures some pulses against the reference; the plan that made them.
fn keeps(path: &str, error_db: &str, pulses: Vec<u64>) -> Plan {
    let run = scene(path, &[("fidelity.error_db", error_db)]);
    let (measured_db, plan) = measured(&Judge::new(&run, pulses, 2, |_| ()).unwrap(), &run);
    let predicted_db = plan.prediction.total_db();
    println!("{path}: asked {error_db}, predicted {predicted_db:.1}, measured {measured_db:.1} dB; {plan:?}");
    assert!(plan.keeps(), "{path} {error_db}: {predicted_db}");
    assert!(measured_db <= predicted_db, "{path} {error_db}: {predicted_db} {measured_db}");
    plan
}

#[test]
fn sea_and_ship_in_ka_band_from_orbit() {
    for error_db in some_of(["-45.0", "-30.0"]) {
        let plan = keeps("tests/data/scenarios/ka-orbit.toml", error_db, vec![0, 5, 17, 35]);
        assert_eq!(plan.chosen.echo.envelope, Envelope::Stretched);
    }
}

#[test]
fn long_pulse_of_a_jet_takes_bands_of_doppler() {
    for error_db in some_of(["-60.0", "-45.0", "-75.0"]) {
        let plan = keeps("tests/data/scenarios/jet.toml", error_db, (0..22).collect());
        assert_eq!(plan.chosen.echo.envelope, Envelope::Stretched);
        assert!(plan.chosen.echo.band_hz.is_some());
    }
}

#[test]
fn short_pulses_keep_rigid_envelopes() {
    let settings = [("scene.patch_size_m", "[64, 64]"), ("scene.duration_s", "0.3")];
    let run = scene("configs/mars-1.toml", &settings);
    let plan = plan(&run);
    assert_eq!((plan.chosen.echo.envelope, plan.chosen.echo.band_hz), (Envelope::Rigid, None));
}
