//! Antennas that scan: the fast echo against the reference, over all pulses of passes of the beam.

use nereus::bench::accuracy::Judge;

use crate::cases::some_of;
use crate::runs;

/// The scenario of the package with its sea taken away, or made small.
fn settings<'a>(
    rpm: &'a str,
    start_deg: &'a str,
    prf_hz: &'a str,
    duration_s: &'a str,
) -> Vec<(&'a str, &'a str)> {
    let mut all = vec![("radar.prf_hz", prf_hz), ("scene.duration_s", duration_s)];
    for end in ["transmitter.0.pointing.rpm", "receiver.0.pointing.rpm"] {
        all.push((end, rpm));
    }
    for end in ["transmitter.0.pointing.start_deg", "receiver.0.pointing.start_deg"] {
        all.push((end, start_deg));
    }
    all
}

/// Beams that pass over targets within a few pulses, at PRFs at which plans look at every fifth pulse or so.
#[test]
fn targets_are_passed_over_as_they_are() {
    for (rpm, start_deg, prf_hz, duration_s) in some_of([
        ("24.0", "-60.0", "1200.0", "2.5"),
        ("300.0", "0.0", "4000.0", "0.4"),
        ("-24.0", "10.0", "1200.0", "1.0"),
        ("2.0", "60.0", "9000.0", "0.3"),
    ]) {
        let own = settings(rpm, start_deg, prf_hz, duration_s);
        let mut run = runs::scene("configs/scan.toml", &own);
        run.scene.sea = None;
        runs::keeps_the_error(&format!("{rpm} rpm"), &run);
    }
}

/// The same over a sea of few facets, which breaks.
#[test]
fn a_small_sea_is_passed_over_as_it_is() {
    let small = [("scene.patch_size_m", "[48, 48]"), ("fidelity.error_db", "-55")];
    for (rpm, start_deg) in some_of([("24.0", "-4.0"), ("-120.0", "30.0")]) {
        let own = settings(rpm, start_deg, "1200.0", "0.08");
        let run = runs::scene("configs/scan.toml", &[&own[..], &small].concat());
        runs::keeps_the_error(&format!("{rpm} rpm"), &run);
    }
}

/// Near grazing one facet may return most of a pulse: in pulse 224 of this run such a facet turns away, which
/// its cosine between nodes 105 pulses apart shows a pulse late (-55 dB).
#[test]
fn facets_turn_away_at_their_pulse() {
    let run = runs::scene("configs/scan.toml", &settings("24.0", "-25.0", "1200.0", "0.35"));
    let judge = Judge::new(&run, (222..227).collect(), 2, |_| ()).unwrap();
    let (measured_db, plan) = runs::measured(&judge, &run);
    let predicted_db = plan.prediction.total_db();
    println!("predicted {predicted_db:.1}, measured {measured_db:.1} dB");
    assert!(plan.keeps() && plan.chosen.node_pulses > 50, "{:?}", plan.chosen);
    assert!(measured_db <= predicted_db, "{predicted_db} {measured_db}");
}
