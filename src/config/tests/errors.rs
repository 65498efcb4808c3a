//! Errors of reports, turbulence and clocks in scenarios.

use super::{COASTAL, Run, coastal_with, faults_of};
use crate::motion::errors::{ATTITUDE, Between, Recorded, VELOCITY};
use crate::motion::gusts::LEVELS_MPS;

type Variant = (&'static str, Vec<(&'static str, &'static str)>);

/// Scenarios that have every key.
pub(super) fn variants() -> Vec<Variant> {
    vec![
        (
            COASTAL,
            vec![
                (
                    "platform.1.errors",
                    "{ dropouts = { per_hour = 1, mean_s = 1 }, position = {}, velocity = {}, attitude = {} }",
                ),
                ("platform.1.turbulence", "{ level = 'light' }"),
                ("transmitter.0.clock", "{}"),
            ],
        ),
        (COASTAL, vec![("receiver.0.clock", "{ preset = 'ocxo' }")]),
    ]
}

fn errors(value: &str) -> Run {
    coastal_with(&[("platform.1.errors", value)]).unwrap()
}

#[test]
fn reports_are_exact_unless_errors_are_set() {
    let run = coastal_with(&[]).unwrap();
    assert!(run.nav.iter().all(|nav| nav.errors.is_none() && nav.gusts.is_none()));
    assert!(run.clocks.clocks.is_empty());
}

#[test]
fn keys_stand_above_presets() {
    let run = errors(
        "{ preset = 'tactical', rate_hz = 0, jitter_s = 0.001, between = 'hold', lever_arm_error_m = [1, 2, 3], \
         dropouts = { per_hour = 6, mean_s = 5, during = 'hold' }, \
         position = { gm_tau_s = 30, step_m = [0, 0, 4], step_at_s = 9, quantisation_m = 0.01 }, \
         attitude = { gm_sigma_deg = [0, 0, 90], sinusoid_amplitude_deg = [180, 0, 0], sinusoid_hz = 2, sinusoid_deg = 90 } }",
    );
    let model = run.nav[1].errors.clone().unwrap();
    assert_eq!((model.recorded, model.rate_hz, model.latency_s), (Recorded::Truth, None, 0.02));
    assert_eq!((model.jitter_s, model.between), (0.001, Between::Hold));
    assert_eq!(model.dropouts.map(|d| (d.per_hour, d.mean_s, d.during)), Some((6.0, 5.0, Between::Hold)));
    assert_eq!(model.lever_arm_error.to_array(), [1.0, 2.0, 3.0]);
    let up = &model.axes[2];
    assert_eq!((up.gm_sigma, up.gm_tau_s, up.step, up.step_at_s), (1.5, 30.0, 4.0, 9.0));
    assert_eq!((model.axes[VELOCITY].gm_sigma, model.axes[VELOCITY].gm_tau_s), (0.03, 100.0));
    let [roll, _, heading] = [0, 1, 2].map(|axis| &model.axes[ATTITUDE + axis]);
    // Half a turn and a quarter of one, in radians.
    assert_eq!((roll.sinusoid, roll.sinusoid_phase_rad), (std::f64::consts::PI, std::f64::consts::FRAC_PI_2));
    assert_eq!(
        (roll.gm_sigma, heading.gm_sigma, heading.gm_tau_s),
        (0.0, std::f64::consts::FRAC_PI_2, 100.0)
    );
    assert_eq!(model.quantisation, [0.01, 0.0, 0.0]);
    let model = errors("{ preset = 'rtk' }").nav[1].errors.clone().unwrap();
    assert_eq!((model.rate_hz, model.latency_s), (Some(10.0), 0.05));
    assert_eq!((model.axes[2].gm_sigma, model.axes[VELOCITY].white), (0.03, 0.03));
}

#[test]
fn a_truth_beside_the_track_must_be_smooth() {
    let table = "{ recorded = 'reported', preset = 'sps', velocity = { bias_mps = [1, 0, 0] }, \
                position = { white_m = [1, 0, 0], gm_sigma_m = [1, 1, 1] } }";
    insta::assert_snapshot!(faults_of(&[("platform.1.errors", table)]), @r#"
    platform.1.errors.preset: not allowed here (recorded = "reported": give position and attitude)
    platform.1.errors.position.white_m: not allowed here (recorded = "reported": the truth must be smooth)
    platform.1.errors.velocity: not allowed here (recorded = "reported": the truth must be smooth)
    "#);
    let run = errors("{ recorded = 'reported', position = { gm_sigma_m = [1, 1, 1] } }");
    assert!(run.nav[1].errors.as_ref().is_some_and(|model| model.check().is_ok()));
}

#[test]
fn faults_of_errors_and_turbulence_are_reported_together() {
    let list = [
        (
            "platform.1.errors",
            "{ preset = 'gps', rate_hz = -1, position = { white_m = [1, -1, 0], bias = 3 } }",
        ),
        ("platform.1.turbulence", "{ level = 'light', wind20_mps = 3, cutoff_hz = 50 }"),
    ];
    insta::assert_snapshot!(faults_of(&list), @r#"
    platform.1.errors.preset: "gps" is not allowed; allowed: "sps", "rtk", "tactical", "navigation"
    platform.1.errors.rate_hz: -1 is out of range; allowed: a number from 0 to 100000 Hz
    platform.1.errors.position.white_m: entry 1, -1, is out of range; allowed: a list of 3 numbers from 0 to 1e6 m
    platform.1.errors.position.bias: unknown key; did you mean bias_m, in m?
    platform.1.turbulence.wind20_mps: level, wind20_mps exclude each other; allowed: one of them
    platform.1.turbulence.cutoff_hz: 50 is out of range; allowed: a number from 0.05 to 5 Hz
    "#);
}

#[test]
fn turbulence_by_level_and_by_wind() {
    let run = coastal_with(&[("platform.1.turbulence", "{ level = 'severe', track_hold_s = 0 }")]).unwrap();
    let gusts = run.nav[1].gusts.unwrap();
    assert_eq!((gusts.wind20_mps, gusts.hold_s, gusts.cutoff_hz), (LEVELS_MPS[2], None, 0.5));
    let run = coastal_with(&[("platform.1.turbulence", "{ wind20_mps = 7, height_m = 90 }")]).unwrap();
    assert_eq!(
        run.nav[1].gusts.map(|g| (g.wind20_mps, g.height_m, g.hold_s)),
        Some((7.0, Some(90.0), Some(30.0)))
    );
}

#[test]
fn clocks_are_owned_or_shared() {
    let own = (
        "transmitter.0.clock",
        "{ offset_s = 1e-6, drift = 2e-9, ageing_per_day = 8.64e-5, preset = 'tcxo' }",
    );
    let run = coastal_with(&[own, ("receiver.0.clock", "{ same_as = 'tx' }")]).unwrap();
    assert_eq!((&run.clocks.transmitters, &run.clocks.receivers), (&vec![Some(0)], &vec![Some(0)]));
    let clock = run.clocks.clocks[0].clock;
    assert_eq!((clock.offset_s, clock.drift, run.clocks.clocks.len()), (1e-6, 2e-9, 1));
    assert!((clock.ageing_per_s / 1e-9 - 1.0).abs() < 1e-15 && clock.noise[1] > 0.0);
    let run = coastal_with(&[("receiver.0.clock", "{ noise_h = [0, 0, 1e-20, 0, 0] }")]).unwrap();
    assert_eq!((&run.clocks.transmitters, &run.clocks.receivers), (&vec![None], &vec![Some(0)]));
    let list = [
        ("transmitter.0.clock", "{ same_as = 'rx' }"),
        ("receiver.0.clock", "{ same_as = 'tx', drift = 1e-9 }"),
    ];
    insta::assert_snapshot!(faults_of(&list), @r#"
    transmitter.0.clock.same_as: there is no antenna with a clock of its own above "rx"; allowed: none are defined
    receiver.0.clock.drift: not allowed here (with same_as)
    receiver.0.clock.same_as: there is no antenna with a clock of its own above "tx"; allowed: none are defined
    "#);
}
