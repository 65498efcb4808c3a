//! Arrays of receivers against geometry: delays, phases and errors of every element.

use std::f64::consts::TAU;
use std::path::Path;

use nereus::config::{self, Run};
use nereus::pipeline::build;
use nereus::pulse::{Pulse, Samples};
use num_complex::Complex64;

use crate::runs;
use crate::two_platforms::C;

const TARGET_M: [f64; 3] = [800.0, 2400.0, 20.0];
const MAST_M: [f64; 3] = [10.0, -30.0, 40.0];
const SPACING_M: f64 = 0.35;
const GAINS_DB: [f64; 4] = [0.0, 1.0, -2.0, 0.5];
const PHASES_DEG: [f64; 4] = [0.0, 30.0, -75.0, 140.0];

fn run(echo: &str, array: &str) -> Run {
    let text = format!(
        r#"
        [scene]
        duration_s = 0.02
        seed = 3
        [radar]
        carrier_hz = 9.4e9
        sample_rate_hz = 40e6
        prf_hz = 500.0
        channels = ["HH"]
        waveform = {{ kind = "cw", pulse_s = 1e-6 }}
        window = {{ samples = 128, start_us = 16.0 }}
        [[platform]]
        name = "mast"
        track = {{ kind = "fixed", position_m = {MAST_M:?} }}
        [[transmitter]]
        name = "tx"
        platform = "mast"
        power_w = 100.0
        antenna = {{ kind = "isotropic" }}
        [[receiver]]
        name = "rx"
        platform = "mast"
        lever_arm_m = [1.0, 2.0, -3.0]
        antenna = {{ kind = "isotropic" }}
        {array}
        [[target]]
        position_m = {TARGET_M:?}
        rcs_m2 = 10
        [fidelity]
        echo = "{echo}"
        error_db = -80
        [stream]
        pace = "fast"
        "#
    );
    config::parse(&text, &Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.toml"), &[]).unwrap()
}

fn channels(pulse: &Pulse, count: usize) -> Vec<Vec<Complex64>> {
    let Samples::Cf32(all) = &pulse.samples else { panic!("a converter") };
    let own = all.chunks_exact(all.len() / count);
    own.map(|own| own.iter().map(|s| Complex64::new(s.re.into(), s.im.into())).collect()).collect()
}

/// A target's echo in element `n` beside that in element 0: the phase of the difference of distances, gain
/// and phase as written; forward is North, starboard East.
#[test]
fn elements_differ_by_geometry_and_errors() {
    let array = format!(
        "array = {{ elements = 4, spacing_m = [0.0, {SPACING_M:?}, 0.0], gains_db = {GAINS_DB:?}, \
         phases_deg = {PHASES_DEG:?} }}\ngain_db = -3.0\nphase_deg = 10.0"
    );
    for echo in ["fast", "reference"] {
        let run = run(echo, &array);
        let names: Vec<&str> =
            run.scene.radar.receivers.iter().map(|receiver| receiver.name.as_str()).collect();
        assert_eq!(names, ["rx-0", "rx-1", "rx-2", "rx-3"]);
        let pulses = runs::kept(build::stream(&run, 0..run.scene.pulses).unwrap());
        let of = channels(&pulses[3], 4);
        // The middle of the pulse, where nothing depends on the time.
        let most = of[0].iter().map(|s| s.norm()).fold(0.0, f64::max);
        let on: Vec<usize> = (0..128).filter(|i| of[0][*i].norm() > 0.5 * most).collect();
        let middle = (on[0] + on[on.len() - 1]) / 2;
        let leg_m = |element: usize| {
            let along_m = (element as f64 - 1.5) * SPACING_M;
            let at = [MAST_M[0] + 2.0 + along_m, MAST_M[1] + 1.0, MAST_M[2] + 3.0];
            (0..3).map(|axis| (TARGET_M[axis] - at[axis]).powi(2)).sum::<f64>().sqrt()
        };
        for element in 1..4 {
            let turns = -9.4e9 * (leg_m(element) - leg_m(0)) / C;
            let wanted = Complex64::from_polar(
                10f64.powf((GAINS_DB[element] - GAINS_DB[0]) / 20.0),
                TAU * turns + (PHASES_DEG[element] - PHASES_DEG[0]).to_radians(),
            );
            let found = of[element][middle] / of[0][middle];
            let off = (found - wanted).norm() / wanted.norm();
            assert!(off < 2e-3, "{echo} {element}: {found} {wanted}");
        }
    }
}

/// An array of errors of 0 has the bits of as many receivers written one by one, and a gain scales a channel.
#[test]
fn an_array_is_its_receivers() {
    let array = run("fast", "array = { elements = 2, spacing_m = [0.0, 0.0, 0.5] }");
    let one = |n: usize, down_m: f64, more: &str| {
        let own = run(
            "fast",
            &format!(
                "{more}\n[[platform]]\nname = \"unused{n}\"\ntrack = {{ kind = \"fixed\", position_m = [0, 0, 1] }}"
            ),
        );
        let mut own = own;
        own.scene.radar.receivers[0].antenna.lever_arm = nereus::frames::Vector::new(1.0, 2.0, down_m);
        runs::kept(build::stream(&own, 0..own.scene.pulses).unwrap())
    };
    let both = runs::kept(build::stream(&array, 0..array.scene.pulses).unwrap());
    let alone = [one(0, -3.25, ""), one(1, -2.75, "")];
    for (n, pulse) in both.iter().enumerate() {
        let own = channels(pulse, 2);
        for element in 0..2 {
            let wanted = &channels(&alone[element][n], 1)[0];
            let strongest = wanted.iter().map(|s| s.norm()).fold(0.0, f64::max);
            let off = own[element].iter().zip(wanted).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(off < 1e-4 * strongest, "pulse {n}, element {element}: {}", off / strongest);
        }
    }
    let louder = one(2, -3.25, "gain_db = 20.0");
    let (a, b) = (&channels(&louder[2], 1)[0], &channels(&alone[0][2], 1)[0]);
    let off = a.iter().zip(b).map(|(a, b)| (a - b * 10.0).norm()).fold(0.0, f64::max);
    assert!(off < 1e-5 * a.iter().map(|s| s.norm()).fold(0.0, f64::max), "{off}");
}

/// Elements of an array that is aimed are parallel: all aim from its middle.
#[test]
fn elements_aim_alike() {
    let aimed = format!(
        "pointing = {{ kind = \"at\", position_m = {TARGET_M:?} }}\n\
         array = {{ elements = 32, spacing_m = [0.0, 1.0, 0.0] }}"
    );
    let run = run("reference", &aimed);
    let pulses = runs::kept(build::stream(&run, 0..1).unwrap());
    let looks: Vec<_> = pulses[0].antennas[1..].iter().map(|antenna| antenna.boresight_quat).collect();
    assert_eq!(looks.len(), 32);
    assert!(looks.iter().all(|look| *look == looks[0]), "{looks:?}");
}
