//! The error that is measured, against the same figure worked out apart from two recorded streams.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nereus::bench::accuracy::{Judge, noiseless, sample};
use nereus::config::{self, Run};
use nereus::echo::Fidelity;
use nereus::pipeline::build;
use nereus::pulse::Samples;
use nereus::transport::Pace;

use crate::cases::sized;
use crate::runs::plan;

fn sea(settings: &[(&str, &str)]) -> Run {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/sea.toml");
    let settings: Vec<_> = settings.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    let mut run = config::load(&path, &settings).unwrap();
    run.sinks.clear();
    run.stream.pace = Pace::Fast;
    run
}

/// Samples of some pulses of a whole run, without noise.
fn streamed(run: &Run, pulses: &[u64]) -> Vec<Vec<[f64; 2]>> {
    let mut found = Vec::new();
    let run = noiseless(run);
    let ended = build::stream(&run, 0..run.scene.pulses)
        .unwrap()
        .tap(&Arc::new(AtomicBool::new(false)), |pulse| {
            let Samples::Cf32(samples) = &pulse.samples else { panic!("a converter") };
            if pulses.contains(&pulse.index) {
                found.push(samples.iter().map(|s| [s.re, s.im].map(f64::from)).collect());
            }
        })
        .unwrap();
    ended.result.unwrap();
    found
}

#[test]
fn the_measured_error_is_that_of_the_stream() {
    // With noise and a converter, which the figure must not see.
    let run = sea(&[
        ("scene.patch_size_m", sized("[24, 24]", "[16, 16]")),
        ("fidelity.error_db", "-40.0"),
        ("radar.noise_figure_db", "30"),
        ("radar.adc", "{ bits = 4, full_scale_dbw = -180.0 }"),
    ]);
    let pulses = sample(run.scene.seed, run.scene.pulses, 13, 16);
    let judge = Judge::new(&run, pulses.clone(), 2, |_| ()).unwrap();
    let (measured, judged) = judge.judge_with_plan(&run).unwrap();
    assert_eq!(judged.unwrap(), plan(&run), "noise and converter change the plan");
    let fast = streamed(&run, &pulses);
    let all: Vec<u64> = (0..run.scene.pulses).collect();
    let whole = streamed(&Run { fidelity: Fidelity::Reference, ..run }, &all);
    let exact: Vec<_> = pulses.iter().map(|index| whole[*index as usize].clone()).collect();
    let mut worst = (0.0, 0, 0);
    for channel in 0..4 {
        let norm = |pulse: &[[f64; 2]], from: Option<&Vec<[f64; 2]>>| -> f64 {
            let len = pulse.len() / 4;
            let range = channel * len..(channel + 1) * len;
            range
                .map(|i| {
                    let [re, im] = from.map_or([0.0; 2], |from| from[i]);
                    (pulse[i][0] - re).powi(2) + (pulse[i][1] - im).powi(2)
                })
                .sum::<f64>()
        };
        let mean = whole.iter().map(|pulse| norm(pulse, None)).sum::<f64>() / whole.len() as f64;
        for ((a, b), index) in fast.iter().zip(&exact).zip(&pulses) {
            let ratio = norm(a, Some(b)) / mean;
            if ratio > worst.0 {
                worst = (ratio, *index, channel);
            }
        }
    }
    let worst_db = 10.0 * worst.0.log10();
    println!("measured {:.3} dB, from streams {worst_db:.3} dB", measured.rel_rms_db);
    // The same errors, over the mean power of 64 pulses instead of all of them.
    assert!((measured.rel_rms_db - worst_db).abs() < 0.3, "{measured:?} {worst:?}");
    assert_eq!((measured.worst_pulse, measured.worst_channel), (worst.1, worst.2));
    // An error that can be seen at all.
    assert!((-90.0..-30.0).contains(&worst_db), "{worst_db}");
}
