//! Any legal recording gives numbers.

use nereus::geometry::phase_path::PhasePath;
use nereus::processor::backproject::{Aperture, PulseEcho, fast, reference};
use nereus::processor::point_target::{analyse, locate};
use nereus::processor::range_compress::{Compressor, PulseShape, RangeFilter};
use nereus::processor::taper::Taper;
use nereus::recording::ground::Ground;
use nereus::scene::radar::Band;
use num_complex::Complex32;
use proptest::prelude::*;

/// Most samples of a window.
const MOST_SAMPLES: usize = 80;
const RATE_HZ: f64 = 1e8;

/// What one case is made of.
#[derive(Clone, Debug)]
struct Case {
    start: [f64; 3],
    speed: [f64; 3],
    other: [f64; 3],
    pixel_m: f64,
    pulses: usize,
    interval_s: f64,
    start_of_window: Start,
    samples: usize,
    flat: bool,
    taper: usize,
}

/// When windows open.
#[derive(Clone, Copy, Debug)]
enum Start {
    /// The middle of the image is received in the first pulse, at this part of the window.
    Received(f64),
    /// Anywhere, s.
    Wild(f64),
}

fn cases() -> impl Strategy<Value = Case> {
    let start = prop::array::uniform3(prop_oneof![Just(0.0), -10.0..10.0f64, -1e6..1e6f64]);
    let speed = prop::array::uniform3(prop_oneof![Just(0.0), -8e3..8e3f64]);
    let other = prop::array::uniform3(prop_oneof![Just(0.0), -1e6..1e6f64]);
    let wild = prop_oneof![Just(0.0), -1e-4..1e-2f64].prop_map(Start::Wild);
    let start_of_window = prop_oneof![3 => (0.01..0.99f64).prop_map(Start::Received), 1 => wild];
    let pixel_m = prop_oneof![1e-3..1.0f64, 1.0..1e4f64];
    let ends = (start, speed, other, pixel_m);
    let pulses = (1usize..70, 1e-5..1.0f64, start_of_window, 1..MOST_SAMPLES);
    (ends, pulses, any::<bool>(), 0usize..4).prop_map(|(ends, pulses, flat, taper)| Case {
        start: ends.0,
        speed: ends.1,
        other: ends.2,
        pixel_m: ends.3,
        pulses: pulses.0,
        interval_s: pulses.1,
        start_of_window: pulses.2,
        samples: pulses.3,
        flat,
        taper,
    })
}

#[test]
fn images_are_finite() {
    let hit = std::cell::Cell::new(0);
    let config = ProptestConfig { source_file: Some(file!()), ..crate::cases::proptests(48) };
    let least = config.cases as usize * 9 / 48;
    proptest::test_runner::TestRunner::new(config)
        .run(&cases(), |case| {
            hit.set(hit.get() + image(&case)?);
            Ok(())
        })
        .unwrap();
    // In three cases of four the middle of the image lies within the receive windows: 36 of 48, with a
    // standard deviation of 3: nine of them less.
    println!("{} pixels were hit", hit.get());
    assert!(hit.get() >= least, "{}", hit.get());
}

/// Makes the image of a case; pixels that are not zero.
fn image(case: &Case) -> Result<usize, TestCaseError> {
    let times_s: Vec<f64> = (0..case.pulses).map(|i| i as f64 * case.interval_s).collect();
    let line = |from: [f64; 3], v: [f64; 3]| {
        let points = times_s.iter().map(|t| std::array::from_fn(|i| from[i] + v[i] * t)).collect();
        PhasePath::new(times_s.clone(), points).unwrap()
    };
    let (transmitter, receiver) = (line(case.start, case.speed), line(case.other, [0.0; 3]));
    let replica: Vec<Complex32> = (0..9).map(|i| Complex32::cis(0.3 * (i * i) as f32)).collect();
    let shape = PulseShape {
        replica: &replica,
        turns: 1,
        sample_rate_hz: RATE_HZ,
        band: Band::about(0.0, 6e7),
        pulse_s: 9e-8,
    };
    let filter = if case.flat { RangeFilter::Flat } else { RangeFilter::Matched };
    let taper = [Taper::Uniform, Taper::Hann, Taper::Taylor, Taper::Kaiser][case.taper];
    let compressor = Compressor::new(shape, case.samples, filter, taper, 8).unwrap();
    let window: Vec<Complex32> = (0..case.samples).map(|i| Complex32::cis(i as f32)).collect();
    let ground = Ground::map([0.0; 3], [7.0 * case.pixel_m, 5.0 * case.pixel_m], case.pixel_m).unwrap();
    let echo =
        |t: &f64| PulseEcho { emission_s: *t, number: 0, window_start_s: 0.0, weight: 1.0, samples: &window };
    let mut aperture = Aperture {
        carrier_hz: 1e10,
        compressor: &compressor,
        transmitter: &transmitter,
        receiver: &receiver,
        pulses: times_s.iter().map(echo).collect(),
        centre_m: ground.centre_m(),
        gate: None,
    };
    let window_start_s = match case.start_of_window {
        Start::Received(part) => {
            let middle_s = aperture.delay_s(&aperture.pulses[0], ground.centre_m());
            middle_s - part * (case.samples - 1) as f64 / RATE_HZ
        }
        Start::Wild(start_s) => start_s,
    };
    aperture.pulses.iter_mut().for_each(|pulse| pulse.window_start_s = window_start_s);
    let (made, wanted) = (fast(&aperture, &[ground], &|_| ()).remove(0), reference(&aperture, &ground));
    prop_assert!(made.iter().all(|z| z.is_finite()));
    prop_assert!(wanted.iter().all(|z| z.is_finite()));
    // A window of one sample has no place between samples. Seven by five pixels: the middle is one of them.
    if matches!(case.start_of_window, Start::Received(_)) && case.samples > 1 {
        let middle = 2 * 7 + 3;
        prop_assert!(made[middle] != Complex32::ZERO && wanted[middle].norm() > 0.0);
    }
    for found in analyse(&aperture, &[[0.0; 3].into()], [taper; 2]).into_iter().flatten() {
        prop_assert!(found.found_m.iter().all(|x| x.is_finite()) && found.phase_rad.is_finite());
    }
    let delays_s: Vec<f64> =
        (0..case.pulses).map(|i| if i % 5 == 3 { f64::NAN } else { 1e-6 * i as f64 }).collect();
    if let Some(point) = locate(&transmitter, &receiver, &times_s, &delays_s, [0.0; 3]) {
        prop_assert!(point.iter().all(|x| x.is_finite()));
    }
    Ok(made.iter().filter(|z| **z != Complex32::ZERO).count())
}
