//! A pulse depends on its number alone.

use std::path::Path;

use nereus::pipeline::build;
use nereus::pulse::Pulse;
use nereus::time::TimeTag;

use crate::runs;

fn pulses(threads: usize, range: std::ops::Range<u64>) -> Vec<Pulse> {
    runs::pulses("configs/calibration.toml", &[], &threads.to_string(), range)
}

#[test]
fn threads_and_ranges_do_not_change_a_bit() {
    let whole = pulses(2, 0..230);
    assert_eq!(whole.len(), 230);
    assert!(whole.iter().any(|p| p.samples.as_bytes().iter().any(|b| *b != 0)));
    assert!(pulses(1, 0..230) == whole, "one thread and two threads differ");
    assert!(pulses(3, 0..230) == whole, "three threads and two threads differ");
    assert!(pulses(2, 100..200) == whole[100..200], "a range differs from that part of the run");
    assert!(whole[0].time > TimeTag::default());
}

/// Neither of its threads nor of the part that is run, though pulses are tried before anything is promised.
#[test]
fn a_plan_depends_on_its_scene_alone() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scenarios/boat.toml");
    let plan = |threads: usize, range: std::ops::Range<u64>| {
        let run = nereus::config::load(&path, &[("stream.threads".to_owned(), threads.to_string())]).unwrap();
        *build::stream(&run, range).unwrap().factory().plan().unwrap()
    };
    let whole = plan(2, 0..70);
    assert!(whole.prediction.dry_run.is_some(), "{whole:?}");
    assert_eq!(plan(1, 0..70), whole);
    assert_eq!(plan(3, 0..70), whole);
    assert_eq!(plan(2, 20..30), whole);
}

/// Whatever made it coarser: a pulse of policy `relax` is the pulse of a run that asks for that error.
#[test]
fn a_class_has_the_bits_of_its_error() {
    let path = "tests/data/scenarios/boat.toml";
    let relaxed = [
        ("stream.policy", "relax"),
        ("stream.pace", "realtime"),
        ("fidelity.error_db", "-70"),
        ("stream.relax_db", "[-50, -25]"),
    ];
    let stream = build::stream(&runs::scene(path, &relaxed), 0..70).unwrap();
    let classes_db = stream.header().error_classes_db().to_vec();
    assert_eq!((classes_db.len(), classes_db[0]), (stream.classes().count(), -70.0), "{classes_db:?}");
    assert!(classes_db.len() > 1 && classes_db.is_sorted(), "{classes_db:?}");
    for class in stream.classes() {
        let error_db = class.plan().unwrap().asked.error_db.to_string();
        let alone = runs::pulses(path, &[("fidelity.error_db", &error_db)], "1", 0..70);
        let (mut worker, mut slot) = (class.worker(), class.slot());
        for (index, alone) in (0..).zip(&alone) {
            worker.make(index, &mut slot).unwrap();
            assert!(slot.samples == alone.samples, "pulse {index} at {error_db} dB");
        }
    }
}
