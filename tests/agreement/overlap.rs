//! Several emissions in the air at once: blocks against the reference, pulse by pulse.

use std::ops::Range;

use nereus::fidelity::budget::Plan;
use nereus::pipeline::build;

use crate::blocks::{samples, scenario, worst_db};
use crate::cases::{sized, some_of};

type Settings<'a> = &'a [(&'a str, &'a str)];

/// A short run over a small patch, its beam on it, asked for -40 dB.
const SHORT: Settings<'_> = &[
    ("scene.patch_size_m", "[32, 32]"),
    ("ship", "[]"),
    ("scene.duration_s", "0.1"),
    ("platform.0.track.position_m", "[-1, -3000, 3000]"),
    // Doppler within pulses of half a millisecond stays below what is asked.
    ("platform.0.track.velocity_mps", "[20, 0, 0]"),
    ("fidelity.error_db", "-40"),
];
/// Pulses as long as the interval, in windows as long: each receives the pulse before, too.
const FULL_DUTY: Settings<'_> = &[
    ("radar.prf_hz", "2000"),
    ("radar.sample_rate_hz", "2e6"),
    ("radar.waveform.bandwidth_hz", "1.5e6"),
    ("radar.waveform.pulse_s", "500e-6"),
    ("radar.window.samples", "1000"),
    ("radar.window.start_us", "0"),
];
/// Echoes that come two intervals late.
const AMBIGUOUS: Settings<'_> = &[
    ("radar.prf_hz", "100e3"),
    ("scene.duration_s", "0.01"),
    ("radar.window.samples", "384"),
    ("radar.window.start_us", "7.5"),
];
/// Windows that hold the end of their own echoes and the begin of the next, at intervals that differ, of
/// polarisations that alternate.
const STAGGERED: Settings<'_> = &[
    ("radar.pri_us", "[480, 520, 510]"),
    ("radar.tx_polarisation", "alternating"),
    ("radar.sample_rate_hz", "2e6"),
    ("radar.waveform.bandwidth_hz", "1.5e6"),
    ("radar.waveform.pulse_s", "300e-6"),
    ("radar.window.samples", "940"),
    ("radar.window.start_us", "100"),
];
/// A patch that moves on while echoes of before are in the air.
const FOLLOWS: Settings<'_> = &[
    ("scene.patch", "follow"),
    ("scene.patch_follow", r#"{ kind = "point", position_m = [0, 0, 0], velocity_mps = [100, 0, 0] }"#),
];
/// A target that moves, with another cross section at every emission.
const TARGET: Settings<'_> =
    &[("target", r#"[{ position_m = [3, 4, 1], velocity_mps = [4, -7, 0], rcs_dbsm = 10, swerling = 2 }]"#)];

fn settings<'a>(more: &[Settings<'a>], own: Settings<'a>) -> Vec<(&'a str, &'a str)> {
    [&[SHORT], more, &[own]].concat().concat()
}

/// The plan of a run, and its worst error over some pulses, dB.
fn measured(more: &[Settings<'_>], range: Range<u64>) -> (Plan, f64) {
    let run = scenario("mars-1.toml", &settings(more, &[]));
    let plan = *build::stream(&run, range.clone()).unwrap().factory().plan().unwrap();
    let exact = scenario("mars-1.toml", &settings(more, &[("fidelity.echo", "reference")]));
    (plan, worst_db(&samples(&run, range.clone()), &samples(&exact, range)))
}

#[test]
fn emissions_that_overlap_are_made_in_blocks() {
    for (name, more, range) in some_of([
        ("full duty", &[FULL_DUTY][..], 0..sized(160, 80)),
        ("echoes two intervals late", &[AMBIGUOUS], 0..sized(160, 80)),
        ("stagger, alternation and overlap", &[STAGGERED, TARGET], 0..sized(160, 80)),
        ("full duty, a patch that follows", &[FULL_DUTY, FOLLOWS], 0..sized(160, 80)),
        ("the end of a run", &[FULL_DUTY, TARGET], 120..200),
    ]) {
        let (plan, error_db) = measured(more, range);
        let predicted_db = plan.prediction.total_db();
        println!(
            "{name}: nodes {} pulses apart, {} more emissions, predicted {predicted_db:.1}, worst pulse {error_db:.1} dB",
            plan.chosen.node_pulses, plan.chosen.overlap_pulses
        );
        assert!(plan.chosen.node_pulses > 1, "{name}: {:?}", plan.chosen);
        assert!(plan.keeps() && error_db < -40.0, "{name}: {error_db}");
    }
}

#[test]
fn any_part_of_a_run_that_overlaps_has_the_same_bits() {
    for more in some_of([&[FULL_DUTY, TARGET][..], &[STAGGERED], &[AMBIGUOUS], &[FULL_DUTY, FOLLOWS]]) {
        let of = |threads, range: Range<u64>| {
            samples(&scenario("mars-1.toml", &settings(more, &[("stream.threads", threads)])), range)
        };
        let whole = of("1", 0..140);
        assert!(whole.iter().flatten().any(|s| s.norm_sqr() > 0.0));
        assert!(whole == of("2", 0..140), "{more:?}: 1 and 2 threads");
        assert!(whole[50..90] == of("3", 50..90)[..], "{more:?}: a part");
    }
}
