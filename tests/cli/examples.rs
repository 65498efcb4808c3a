//! The programs in `examples/`, one for each job of the README, with few pulses.

#[allow(dead_code)]
#[path = "../../examples/feed_processor.rs"]
mod feed_processor;
#[allow(dead_code)]
#[path = "../../examples/make_recording.rs"]
mod make_recording;
#[allow(dead_code)]
#[path = "../../examples/motion_compensation.rs"]
mod motion_compensation;
#[allow(dead_code)]
#[path = "../../examples/replay_flight.rs"]
mod replay_flight;

#[test]
fn a_processor_is_fed_live() {
    feed_processor::feed(20).unwrap();
}

#[test]
fn a_flight_is_replayed() {
    replay_flight::replay("2018-05-30T18:38:35Z", 3).unwrap();
}

/// A period of the sinusoid is 120 pulses: 20 log10 J0(0.4446) = -0.435 dB, sampled finely enough for a
/// hundredth of it; the aircraft's own way changes the angle by less than 1 in 1000.
#[test]
fn reported_motion_loses_what_theory_expects() {
    let loss_db = motion_compensation::loss_db(120).unwrap();
    assert!((loss_db - 0.435).abs() < 0.01, "{loss_db}");
}

#[test]
fn a_recording_is_made_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let recording = make_recording::record(&folder.path().join("example.plain"), 12).unwrap();
    assert_eq!(recording.pulses(), 12);
    assert!(recording.window(11, 0).iter().any(|sample| sample.norm_sqr() > 0.0));
}

/// The README links a program for each of its four jobs, and none is longer than it takes to read.
#[test]
fn the_readme_links_a_short_program_for_each_job() {
    let root = crate::program::package();
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    for name in ["feed_processor", "make_recording", "motion_compensation", "replay_flight"] {
        assert!(readme.contains(&format!("](examples/{name}.rs)")), "{name}");
        let text = std::fs::read_to_string(root.join(format!("examples/{name}.rs"))).unwrap();
        assert!(text.lines().count() <= 40, "{name}: {} lines", text.lines().count());
    }
}
