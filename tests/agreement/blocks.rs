//! Echoes in blocks against the reference, pulse by pulse, in the run that streams.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nereus::config::{self, Run};
use nereus::echo::Fidelity;
use nereus::pipeline::build;
use nereus::pulse::Samples;
use num_complex::Complex64;

/// A scenario of the repository with some keys set, without recordings.
fn scenario(name: &str, settings: &[(&str, &str)]) -> Run {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(name);
    let settings: Vec<_> = settings.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    let mut run = config::load(&path, &settings).unwrap();
    run.sinks.clear();
    run.stream.pace = nereus::transport::Pace::Fast;
    run
}

/// The same run with the reference echo.
fn reference(mut run: Run) -> Run {
    run.fidelity = Fidelity::Reference;
    run
}

/// Samples of some pulses, `[pulse][channel x sample]`.
fn samples(run: &Run, range: std::ops::Range<u64>) -> Vec<Vec<Complex64>> {
    let mut pulses = Vec::new();
    let outcome = build::stream(run, range)
        .unwrap()
        .tap(&Arc::new(AtomicBool::new(false)), |pulse| {
            let widen = |s: &num_complex::Complex32| Complex64::new(s.re.into(), s.im.into());
            let Samples::Cf32(samples) = &pulse.samples else { panic!("a converter") };
            pulses.push(samples.iter().map(widen).collect());
        })
        .unwrap();
    outcome.result.unwrap();
    pulses
}

/// The error as it is defined: the largest over pulses and channels of a pulse's error over the rms of that channel in the
/// reference of the run, dB.
fn worst_db(found: &[Vec<Complex64>], reference: &[Vec<Complex64>]) -> f64 {
    let channel = |pulse: &[Complex64], c: usize| pulse.chunks(pulse.len() / 4).nth(c).unwrap().to_vec();
    let power = |samples: &[Complex64]| samples.iter().map(|s| s.norm_sqr()).sum::<f64>();
    let mut worst_db = f64::NEG_INFINITY;
    for c in 0..4 {
        let rms: f64 = reference.iter().map(|p| power(&channel(p, c))).sum::<f64>() / reference.len() as f64;
        for (a, b) in found.iter().zip(reference) {
            let apart: Vec<_> = channel(a, c).iter().zip(channel(b, c)).map(|(a, b)| a - b).collect();
            if rms > 0.0 {
                worst_db = worst_db.max(10.0 * (power(&apart) / rms).log10());
            }
        }
    }
    worst_db
}

const SMALL: [(&str, &str); 2] = [("scene.patch_size_m", "[64, 64]"), ("stream.threads", "2")];

fn with<'a>(more: &[(&'a str, &'a str)]) -> Vec<(&'a str, &'a str)> {
    [&SMALL[..], more].concat()
}

#[test]
fn blocks_keep_the_error_that_their_nodes_allow() {
    // The beam passes over the patch; two whole blocks and parts of two.
    let range = 236..262;
    let exact = samples(&scenario("mars-1.toml", &with(&[("fidelity.echo", "reference")])), range.clone());
    // Nodes are given, the rest is chosen for an error. The beam passes, so
    // that these pulses are the strongest: relative to them the error is less than to the mean of the run, which the plan takes.
    for (spacing, allowed_db) in [("1", -75.0), ("2", -75.0), ("3", -75.0), ("12", -60.0)] {
        let asked = format!("{allowed_db:?}");
        let settings = [("fidelity.node_pulses", spacing), ("fidelity.error_db", &asked)];
        let run = scenario("mars-1.toml", &with(&settings));
        let error_db = worst_db(&samples(&run, range.clone()), &exact);
        println!("mars-1, 64 x 64, nodes {spacing} pulses apart: worst pulse and channel {error_db:.1} dB");
        assert!(error_db < allowed_db);
    }
}

/// Grazing incidence with shadows, and a patch that moves under a block.
#[test]
fn blocks_of_grazing_and_following_seas() {
    // At grazing incidence facets turn away from the radar, with a kink in their amplitude: mars-4 has nodes at every pulse.
    // The edges of mars-live are out of sight in a patch of full size, here of larger facets.
    let wide = [("scene.facet_m", "4.0"), ("stream.threads", "2")];
    for (name, settings, range) in
        [("mars-4.toml", &SMALL, 240..264), ("mars-live.toml", &wide, 13_320..13_344)]
    {
        let settings = |echo| [&settings[..], &[("fidelity.echo", echo)]].concat();
        let exact = samples(&reference(scenario(name, &settings("fast"))), range.clone());
        let error_db = worst_db(&samples(&scenario(name, &settings("fast")), range), &exact);
        println!("{name}: worst pulse and channel {error_db:.1} dB");
        assert!(error_db < -60.0);
    }
}

/// A facet that forgets its phase in 10 ms is not interpolated over 13 ms.
#[test]
fn facets_that_forget_are_made_pulse_by_pulse() {
    let settings = |echo| with(&[("fidelity.echo", echo), ("sea.scattering.decorrelation_ms", "10.0")]);
    let exact = samples(&scenario("mars-1.toml", &settings("reference")), 248..252);
    let error_db = worst_db(&samples(&scenario("mars-1.toml", &settings("fast")), 248..252), &exact);
    println!("decorrelating in 10 ms: worst pulse and channel {error_db:.1} dB");
    assert!(error_db < -75.0);
}

#[test]
fn any_part_of_a_run_has_the_same_bits() {
    for name in ["mars-1.toml", "mars-live.toml"] {
        let settings = |threads| with(&[("stream.threads", threads), ("scene.duration_s", "2.0")]);
        let whole = samples(&scenario(name, &settings("1")), 230..262);
        assert!(whole.iter().flatten().any(|s| s.norm_sqr() > 0.0));
        let two = samples(&scenario(name, &settings("2")), 230..262);
        let part = samples(&scenario(name, &settings("3")), 243..257);
        assert!(whole == two, "{name}: 1 and 2 threads");
        assert!(whole[13..27] == part[..], "{name}: a part");
    }
}

#[test]
fn pulses_that_cannot_be_interpolated_are_made_one_by_one() {
    // Alternating polarisations: each pulse is a block.
    let alternating = [("radar.tx_polarisation", "alternating")];
    let exact = samples(
        &scenario("mars-1.toml", &with(&[&alternating[..], &[("fidelity.echo", "reference")]].concat())),
        248..252,
    );
    let fast = samples(&scenario("mars-1.toml", &with(&alternating)), 248..252);
    let error_db = worst_db(&fast, &exact);
    println!("alternating polarisations: worst pulse {error_db:.1} dB");
    assert!(error_db < -75.0);
}

/// At L band the short waves of a ship scatter within facets: the narrow V sails through the patch while blocks are interpolated.
#[test]
fn blocks_follow_the_short_waves_of_a_ship() {
    let settings = |echo, bragg| {
        let ship =
            [("ship.0.position_m", "[200, 0]"), ("ship.0.speed_mps", "9"), ("radar.carrier_hz", "1.3e9")];
        with(&[&ship[..], &[("fidelity.echo", echo), ("ship.0.wake_bragg", bragg)]].concat())
    };
    let exact = samples(&scenario("mars-1.toml", &settings("reference", "true")), 246..258);
    let plain = samples(&scenario("mars-1.toml", &settings("reference", "false")), 246..258);
    let effect_db = worst_db(&plain, &exact);
    let error_db = worst_db(&samples(&scenario("mars-1.toml", &settings("fast", "true")), 246..258), &exact);
    println!("L band: short waves are worth {effect_db:.1} dB, blocks leave {error_db:.1} dB");
    assert!(effect_db > -40.0 && error_db < -60.0);
}
