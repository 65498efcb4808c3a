//! Late, lost and wrong reports, turbulence and clocks in a whole run: bit-identical results for any thread
//! and range, the same in both echoes, and servo and receive window go by the report.

use std::path::Path;

use nereus::config::{self, Run};
use nereus::pipeline::build;
use nereus::pipeline::factory::factory_by;
use nereus::pulse::{Pulse, Samples, flags};

use crate::runs::{self, scene};

const C: f64 = 299_792_458.0;

fn scenario(name: &str, settings: &[(&str, &str)]) -> Run {
    scene(&format!("configs/{name}"), settings)
}

fn pulses(settings: &[(&str, &str)], threads: &str, range: std::ops::Range<u64>) -> Vec<Pulse> {
    runs::pulses("configs/errors.toml", settings, threads, range)
}

#[test]
fn threads_and_ranges_do_not_change_a_bit_of_errors() {
    for echo in ["reference", "fast"] {
        let settings = [("fidelity.echo", echo)];
        let whole = pulses(&settings, "2", 0..700);
        assert_eq!(whole.len(), 700);
        assert!(pulses(&settings, "1", 0..700) == whole, "{echo}: one thread and two threads differ");
        assert!(pulses(&settings, "3", 501..640) == whole[501..640], "{echo}: a range differs");
        let count = |of: &dyn Fn(&Pulse) -> bool| whole.iter().filter(|pulse| of(pulse)).count();
        let lost = count(&|p| p.nav_reported[1].flags & flags::REPORT_DROPOUT != 0);
        let aged = count(&|p| p.nav_reported[1].age_s >= 0.01);
        assert!(lost > 0 && lost < 700 && aged > 600, "{lost} {aged}");
        assert!(whole.iter().all(|p| (p.flags ^ p.nav_reported[1].flags) & flags::REPORT_DROPOUT == 0));
        assert!(whole.iter().all(|p| p.nav_reported[0].age_s == 0.0 && p.clock_x_s.len() == 2));
    }
}

/// Samples of some pulses without noise.
fn samples(run: &Run, of: &[u64]) -> Vec<f64> {
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    let factory = factory_by(&run.scene, tracks, &run.fidelity, &run.clocks).unwrap();
    let (mut slot, mut worker) = (factory.slot(), factory.worker());
    let mut all = Vec::new();
    for &index in of {
        worker.make(index, &mut slot).unwrap();
        let Samples::Cf32(iq) = &slot.samples else { panic!("codes") };
        all.extend(iq.iter().flat_map(|s| [f64::from(s.re), f64::from(s.im)]));
    }
    all
}

#[test]
fn both_echoes_agree_within_the_budget() {
    let made = ["reference", "fast"].map(|echo| {
        let mut run = scenario("errors.toml", &[("fidelity.echo", echo)]);
        run.scene.radar.noise_figure_db = None;
        // Reports jump, and the servo after them; within blocks that is the business of the plan's sample.
        samples(&run, &[0, 20, 45, 111, 333, 500, 666, 800, 887])
    });
    let power = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let apart = power(&mut made[0].iter().zip(&made[1]).map(|(a, b)| a - b));
    let db = 10.0 * (apart / power(&mut made[0].iter().copied())).log10();
    println!("fast against reference with errors, turbulence and clocks: {db:.1} dB");
    assert!(db < -60.0, "{db}");
}

/// A mast that looks at a point 3 km away, and reports another position than its own.
fn misled(errors: &str) -> Pulse {
    let text = format!(
        r#"
        [scene]
        duration_s = 1.0
        [radar]
        carrier_hz = 10e9
        sample_rate_hz = 100e6
        prf_hz = 100.0
        channels = ["VV"]
        waveform = {{ kind = "lfm", bandwidth_hz = 60e6, pulse_s = 0.333e-6 }}
        window = {{ samples = 512, follow = {{ kind = "at", position_m = [0, 3000, 0], lead_us = 2.0 }} }}
        [[platform]]
        name = "mast"
        track = {{ kind = "fixed", position_m = [0, 0, 0] }}
        {errors}
        [[transmitter]]
        name = "tx"
        platform = "mast"
        power_w = 1.0
        antenna = {{ kind = "rectangle", width_m = 1.0, height_m = 0.1 }}
        pointing = {{ kind = "at", position_m = [0, 3000, 0] }}
        [[receiver]]
        name = "rx"
        platform = "mast"
        antenna = {{ kind = "isotropic" }}
        [[target]]
        position_m = [0, 3000, 0]
        rcs_m2 = 1.0
        "#
    );
    let run = config::parse(&text, Path::new("misled.toml"), &[]).unwrap();
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    let factory = factory_by(&run.scene, tracks, &run.fidelity, &run.clocks).unwrap();
    let (mut slot, mut worker) = (factory.slot(), factory.worker());
    worker.make(7, &mut slot).unwrap();
    slot
}

fn energy(pulse: &Pulse) -> f64 {
    let Samples::Cf32(iq) = &pulse.samples else { panic!("codes") };
    iq.iter().map(|s| f64::from(s.norm_sqr())).sum()
}

#[test]
fn servo_and_range_gate_go_by_the_report() {
    let right = misled("");
    assert!((right.window_start_s - (6000.0 / C - 2e-6)).abs() < 1e-15);
    // 100 m nearer than it is: the window opens 200 m earlier.
    let near = misled("errors = { position = { bias_m = [0, 100, 0] } }");
    assert!((near.window_start_s - (5800.0 / C - 2e-6)).abs() < 1e-15);
    assert!((energy(&near) / energy(&right) - 1.0).abs() < 1e-3);
    // A heading that is wrong by half a beam turns the antenna the other way: sinc^2 of a sin(angle)/lambda,
    // a 1 m.
    let turned = misled("errors = { attitude = { bias_deg = [0, 0, 0.75] } }");
    let x = std::f64::consts::PI * 0.75f64.to_radians().sin() / (C / 10e9);
    let wanted = (x.sin() / x).powi(2);
    let found = energy(&turned) / energy(&right);
    // Samples are f32: 1e-6 and sums of 34 of them.
    assert!((found / wanted - 1.0).abs() < 1e-4, "{found} {wanted}");
    // What knows the truth is not misled.
    assert_eq!(right.nav_true, turned.nav_true);
    assert_ne!(right.nav_reported, turned.nav_reported);
}
