//! Antennas in or over the patch: what lies below them is stronger by many powers of ten than what the window
//! is for, and rings into it through the receive filter.

use nereus::bench::accuracy::Judge;
use nereus::config::Run;
use nereus::pipeline::build;
use nereus::pipeline::factory::factory_by;
use nereus::pulse::Samples;

use crate::runs::{keeps_the_error, measured, scene};

const TOWER: &str = "tests/data/cases/q_fixed337.toml";

/// A mast in a wide patch whose window opens just behind the echo from below it: of the patch's facets a few
/// in the row of the mast alone have specular points, and these ring into the window.
#[test]
fn specular_points_below_a_mast_turn_as_they_do() {
    for north_m in [3.0, 9.0] {
        let track = format!("{{ kind = \"fixed\", position_m = [3.0, {north_m:?}, 10.0], yaw_deg = 337.5 }}");
        let run = scene(
            TOWER,
            &[
                ("scene.patch_size_m", "[96.0, 9216.0]"),
                ("scene.duration_s", "0.05"),
                ("radar.window.samples", "100"),
                ("radar.window.start_us", "0.6"),
                ("platform.0.track", &track),
            ],
        );
        let judge = Judge::new(&run, vec![3, 29, 47, 59], 2, |_| ()).unwrap();
        let (measured_db, plan) = measured(&judge, &run);
        let predicted_db = plan.prediction.total_db();
        println!("mast at {north_m} m: predicted {predicted_db:.1}, measured {measured_db:.1} dB");
        assert!(plan.keeps() && measured_db <= predicted_db, "{predicted_db} {measured_db}");
    }
}

/// Powers of the samples of a pulse without noise, W.
fn powers_w(run: &Run, index: u64) -> Vec<f64> {
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    let factory = factory_by(&run.scene, tracks, &run.fidelity, &run.clocks).unwrap();
    let (mut slot, mut worker) = (factory.slot(), factory.worker());
    worker.make(index, &mut slot).unwrap();
    let Samples::Cf32(iq) = &slot.samples else { panic!("codes") };
    iq.iter().map(|s| f64::from(s.re).powi(2) + f64::from(s.im).powi(2)).collect()
}

/// A patch about a tower and a window to 22 km: behind the patch there is only what the filter rings, less
/// and less to the end.
#[test]
fn nothing_wraps_to_the_end_of_a_window() {
    let track = "{ kind = \"fixed\", position_m = [0.0, 0.0, 30.0], yaw_deg = 337.5 }";
    for echo in ["reference", "fast"] {
        let run = scene(
            "tests/data/cases/wrap.toml",
            &[
                ("scene.patch_size_m", "[360.0, 360.0]"),
                ("scene.duration_s", "0.05"),
                ("platform.0.track", track),
                ("fidelity.echo", echo),
            ],
        );
        let powers_w = powers_w(&run, 20);
        let db = |part: &[f64]| 10.0 * (part.iter().sum::<f64>() / part.len() as f64).log10();
        let [begin, middle, end] = [&powers_w[..100], &powers_w[1800..1900], &powers_w[3650..]].map(db);
        println!("{echo}: {begin:.1} dBW at the begin, {middle:.1} in the middle, {end:.1} at the end");
        // The fast echo rounds to f32 what the filter has from the begin on: 24 bits, 144 dB, of each of some
        // thousand samples.
        let floor = if echo == "fast" { begin - 130.0 } else { f64::NEG_INFINITY };
        assert!(end <= middle.max(floor), "{echo}: {middle} {end}");
    }
}

/// A few dozen drops of rain, in the beams of two fast antennas, off the mean Doppler by more than the sea.
#[test]
fn rain_of_few_drops_errs_no_more_than_predicted() {
    keeps_the_error("rain over a small patch", &scene("tests/data/cases/pred-optimistic-3020.toml", &[]));
}
