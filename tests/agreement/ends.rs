//! Shadows at the end of a run, and in blocks that are short beside their updates.

use std::path::Path;

use nereus::bench::accuracy::Judge;
use nereus::config::{self, Run};
use nereus::echo::Fidelity;
use nereus::pipeline::changing;
use nereus::pulse::Pulse;

/// Coast at 12 m, boat at 9 m and 13 m/s, 64 x 64 facets of 2 m, 2 kHz: updates of the shadows are 40 pulses
/// apart.
fn coast(settings: &[(&str, &str)]) -> Run {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scenarios/boat.toml");
    let settings: Vec<_> = settings.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    config::load(&path, &settings).unwrap()
}

/// The worst of some pulses, dB.
fn worst_db(settings: &[(&str, &str)], pulses: std::ops::Range<u64>) -> f64 {
    let run = coast(settings);
    let judge = Judge::new(&run, pulses.collect(), 1, |_| ()).unwrap();
    judge.judge(&run).unwrap().rel_rms_db
}

/// The last block of 16 pulses has six. Before, the update after the last emission was moved to it, and
/// heights there were those of a cubic far beyond its nodes: -36.7 dB.
#[test]
fn the_end_of_a_run_keeps_its_error() {
    let found_db = worst_db(&[("fidelity.node_pulses", "5"), ("fidelity.scatter_pulses", "5")], 60..70);
    assert!(found_db <= -60.0, "{found_db}");
}

/// Blocks of 7 pulses, some of which lie a third of an update away from any: -51.8 dB before, at any pulse.
#[test]
fn short_blocks_keep_their_error() {
    let found_db = worst_db(&[("fidelity.node_pulses", "2"), ("fidelity.scatter_pulses", "2")], 14..28);
    assert!(found_db <= -60.0, "{found_db}");
}

/// The same on a patch so large that heights at updates come from the nodes, where these are near.
#[test]
fn large_patches_keep_their_error_at_the_end() {
    let settings = [
        ("scene.patch_size_m", "[512.0, 256.0]"),
        ("scene.duration_s", "0.0325"),
        ("radar.window.samples", "112"),
        ("radar.channels", "[\"VV\"]"),
        ("fidelity.node_pulses", "21"),
    ];
    let found_db = worst_db(&settings, 63..65);
    assert!(found_db <= -60.0, "{found_db}");
}

#[test]
fn a_pulse_does_not_know_how_long_its_run_is() {
    let of = |duration_s: &str, fidelity: &Fidelity| -> Pulse {
        let run = coast(&[("scene.duration_s", duration_s)]);
        let factory = changing::factory(&run, fidelity).unwrap();
        let (mut slot, mut worker) = (factory.slot(), factory.worker());
        worker.make(69, &mut slot).unwrap();
        slot
    };
    let [short, long] = ["0.035", "0.15"].map(|duration_s| of(duration_s, &Fidelity::Reference));
    assert!(short.samples.as_bytes().iter().any(|byte| *byte != 0));
    assert!(short.samples == long.samples, "pulse 69 of 70 is not pulse 69 of 300");
}

/// Pulses of a block are made at once: those asked for again, before others or after another block are alike.
#[test]
fn a_pulse_does_not_know_what_its_worker_made_before() {
    let run = coast(&[("scene.patch_size_m", "[32.0, 32.0]"), ("fidelity.node_pulses", "4")]);
    let factory = changing::factory(&run, &run.fidelity).unwrap();
    assert_eq!(factory.block_pulses(), 13);
    let mut worker = factory.worker();
    let [mut again, mut alone] = [factory.slot(), factory.slot()];
    for index in [5, 6, 6, 2, 12, 13, 69, 68, 0] {
        worker.make(index, &mut again).unwrap();
        factory.worker().make(index, &mut alone).unwrap();
        assert!(alone.samples.as_bytes().iter().any(|byte| *byte != 0));
        assert!(again.index == index && again.samples == alone.samples, "pulse {index}");
    }
}
