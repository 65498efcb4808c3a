//! Scenarios of files, and the pulses that they make.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nereus::bench::accuracy::Judge;
use nereus::config::{self, Run};
use nereus::fidelity::budget::Plan;
use nereus::pipeline::build::{self, PulseStream};
use nereus::pulse::Pulse;

use crate::cases::{sized, some_of};

/// A scenario of the package, without its sinks: pulses are seen, not recorded.
pub fn scene(path: &str, settings: &[(&str, &str)]) -> Run {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let settings: Vec<_> = settings.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    let mut run = config::load(&path, &settings).unwrap();
    run.sinks.clear();
    run
}

/// The begin of a run over a sea, where there are to be fewer cases.
pub fn shortened(mut run: Run) -> Run {
    if run.scene.sea.is_some() {
        run.scene.pulses = run.scene.pulses.min(sized(u64::MAX, 40));
    }
    run
}

/// The plan of a run.
pub fn plan(run: &Run) -> Plan {
    *build::stream(run, 0..run.scene.pulses).unwrap().factory().plan().unwrap()
}

/// The error of a run's fast echo, dB, and the plan that predicts it.
pub fn measured(judge: &Judge, run: &Run) -> (f64, Plan) {
    let (accuracy, plan) = judge.judge_with_plan(run).unwrap();
    (accuracy.rel_rms_db, plan.unwrap())
}

/// Every pulse that a stream releases.
pub fn kept(stream: PulseStream) -> Vec<Pulse> {
    let mut kept = Vec::new();
    let outcome = stream.tap(&Arc::new(AtomicBool::new(false)), |pulse| kept.push(pulse.clone())).unwrap();
    outcome.result.unwrap();
    kept
}

/// Pulses of a part of a scenario, as fast as so many threads make them.
pub fn pulses(path: &str, settings: &[(&str, &str)], threads: &str, range: Range<u64>) -> Vec<Pulse> {
    let fast = [("stream.threads", threads), ("stream.pace", "\"fast\"")];
    let run = scene(path, &[settings, &fast].concat());
    kept(build::stream(&run, range).unwrap())
}

/// Asserts that the fast echo of a run promises the error that is asked and keeps what it predicts, over all
/// pulses.
pub fn keeps_the_error(what: &str, run: &Run) {
    let run = &shortened(run.clone());
    let judge = Judge::new(run, (0..run.scene.pulses).collect(), 2, |_| ()).unwrap();
    let (measured_db, plan) = measured(&judge, run);
    let predicted_db = plan.prediction.total_db();
    let asked_db = plan.asked.error_db;
    println!("{what}: asked {asked_db}, predicted {predicted_db:.1}, measured {measured_db:.1} dB");
    assert!(plan.keeps(), "{what}: {predicted_db}");
    assert!(measured_db <= predicted_db, "{what}: {predicted_db} {measured_db}");
}

/// The errors asked of a scenario, what is predicted for them, and what is measured over all pulses, dB;
/// asserts that every one is promised and kept as predicted.
pub fn holds(path: &str, settings: &[(&str, &str)], asked: &[f64]) -> Vec<[f64; 3]> {
    let with = |error_db: f64| {
        let error_db = format!("{error_db:?}");
        let fast = [("fidelity.echo", "\"fast\""), ("fidelity.error_db", &error_db)];
        shortened(scene(path, &[settings, &fast].concat()))
    };
    let run = with(-60.0);
    let judge = Judge::new(&run, (0..run.scene.pulses).collect(), 2, |_| ()).unwrap();
    let found = some_of(asked).map(|&error_db| {
        let (measured_db, plan) = measured(&judge, &with(error_db));
        let predicted_db = plan.prediction.total_db();
        println!(
            "{path}: asked {error_db}, predicted {predicted_db:.1}, measured {measured_db:.1} dB; {:?}",
            plan.prediction
        );
        assert!(plan.keeps(), "{path} {error_db}: {predicted_db}");
        assert!(measured_db <= predicted_db, "{path} {error_db}: {predicted_db} {measured_db}");
        [error_db, predicted_db, measured_db]
    });
    found.collect()
}

/// The patch of `configs/sea.toml` runs along with the aircraft.
pub const FOLLOWS: [(&str, &str); 2] = [
    ("scene.patch", "follow"),
    ("scene.patch_follow", "{ kind = \"beside\", platform = \"aircraft\", across_m = 3000.0 }"),
];
