//! Any legal recording gives numbers.

use nereus::imaging::backproject::{Aperture, PulseEcho, fast, reference};
use nereus::imaging::ground::Ground;
use nereus::imaging::phase_path::PhasePath;
use nereus::imaging::point_target::{analyse, locate};
use nereus::imaging::range_compress::{Compressor, PulseShape, RangeFilter};
use nereus::imaging::taper::Taper;
use num_complex::Complex32;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn images_are_finite(
        start in prop::array::uniform3(prop_oneof![Just(0.0), -10.0..10.0f64, -1e6..1e6f64]),
        speed in prop::array::uniform3(prop_oneof![Just(0.0), -8e3..8e3f64]),
        other in prop::array::uniform3(prop_oneof![Just(0.0), -1e6..1e6f64]),
        pixel_m in prop_oneof![1e-3..1.0f64, 1.0..1e4f64],
        pulses in 1usize..70,
        interval_s in 1e-5..1.0f64,
        window_start_s in prop_oneof![Just(0.0), -1e-4..1e-2f64],
        samples in 1usize..80,
        flat in any::<bool>(),
        taper in 0usize..4,
    ) {
        let times_s: Vec<f64> = (0..pulses).map(|i| i as f64 * interval_s).collect();
        let line = |from: [f64; 3], v: [f64; 3]| {
            let points = times_s.iter().map(|t| std::array::from_fn(|i| from[i] + v[i] * t)).collect();
            PhasePath::new(times_s.clone(), points).unwrap()
        };
        let (transmitter, receiver) = (line(start, speed), line(other, [0.0; 3]));
        let replica: Vec<Complex32> = (0..9).map(|i| Complex32::cis(0.3 * (i * i) as f32)).collect();
        let shape = PulseShape { replica: &replica, sample_rate_hz: 1e8, bandwidth_hz: 6e7, pulse_s: 9e-8 };
        let filter = if flat { RangeFilter::Flat } else { RangeFilter::Matched };
        let taper = [Taper::Uniform, Taper::Hann, Taper::Taylor, Taper::Kaiser][taper];
        let compressor = Compressor::new(shape, samples, filter, taper, 8).unwrap();
        let window: Vec<Complex32> = (0..samples).map(|i| Complex32::cis(i as f32)).collect();
        let ground = Ground::map([0.0; 3], [7.0 * pixel_m, 5.0 * pixel_m], pixel_m).unwrap();
        let echo = |t: &f64| PulseEcho { emission_s: *t, window_start_s, weight: 1.0, samples: &window };
        let aperture = Aperture {
            carrier_hz: 1e10,
            compressor: &compressor,
            transmitter: &transmitter,
            receiver: &receiver,
            pulses: times_s.iter().map(echo).collect(),
            centre_m: ground.centre_m(),
        };
        prop_assert!(fast(&aperture, &[ground], &|_| ())[0].iter().all(|z| z.is_finite()));
        prop_assert!(reference(&aperture, &ground).iter().all(|z| z.is_finite()));
        for found in analyse(&aperture, &[[0.0; 3]], [taper; 2]).into_iter().flatten() {
            prop_assert!(found.found_m.iter().all(|x| x.is_finite()) && found.phase_rad.is_finite());
        }
        let delays_s: Vec<f64> = (0..pulses).map(|i| if i % 5 == 3 { f64::NAN } else { 1e-6 * i as f64 }).collect();
        if let Some(point) = locate(&transmitter, &receiver, &times_s, &delays_s, [0.0; 3]) {
            prop_assert!(point.iter().all(|x| x.is_finite()));
        }
    }
}
