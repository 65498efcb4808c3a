//! The fast way against the reference; threads; alternating polarisation.

use num_complex::Complex32;

use nereus::geometry::phase_path::PhasePath;
use nereus::processor::backproject::{Aperture, PulseEcho, difference_db, fast, reference};
use nereus::processor::range_compress::{Compressor, PulseShape, RangeFilter, interpolation_error_db};
use nereus::processor::taper::Taper;
use nereus::recording::ground::Ground;
use nereus::scene::radar::Band;

use crate::geometries::{BAND_HZ, GEOMETRIES, PHASE_RAD, TARGET_M, aperture, compressor};

#[test]
fn the_fast_way_is_the_reference_to_within_its_interpolation() {
    for geometry in &GEOMETRIES {
        let recording = geometry.record("", [[0.0; 3]; 2]);
        let paths = [recording.true_path("t").unwrap(), recording.true_path("r").unwrap()];
        let compressor = compressor(&recording, RangeFilter::Matched, Taper::Uniform);
        let mut aperture = aperture(&recording, &compressor, [&paths[0], &paths[1]], 0);
        // Every eighth pulse: the reference is slow.
        aperture.pulses = aperture.pulses.iter().copied().step_by(8).collect();
        // Off the middle, and no whole number of runs or tiles.
        let ground = Ground::map([TARGET_M[0] + 9.0, TARGET_M[1] - 7.0, 0.0], [45.0, 33.0], 1.0).unwrap();
        let found = fast(&aperture, &[ground], &|_| ()).remove(0);
        let wanted = reference(&aperture, &ground);
        let found_db = difference_db(&found, &wanted);
        let predicted_db = interpolation_error_db(BAND_HZ, 16.0 * recording.header.sample_rate_hz);
        println!("{}: fast differs by {found_db:.1} dB, interpolation {predicted_db:.1} dB", geometry.name);
        // The band's edges weigh more where the image holds little but side lobes: 2 dB.
        assert!(found_db < predicted_db + 2.0, "{}: {found_db}", geometry.name);
        // Finer cells take the interpolation away, and bring the rest to light: cubics of phase of up to 5e-5
        // turns, -70 dB, far less in most runs.
        let peak = wanted.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let phase = wanted
            .iter()
            .zip(&found)
            .filter(|(w, _)| w.norm() > 0.5 * peak)
            .map(|(w, f)| (num_complex::Complex64::new(f.re.into(), f.im.into()) * w.conj()).arg().abs())
            .fold(0.0, f64::max);
        println!("{}: phase differs by {phase:.1e} rad", geometry.name);
        assert!(phase < 1e-3, "{}: {phase}", geometry.name);
    }
}

#[test]
fn late_in_a_long_window_an_image_is_as_good_as_early() {
    const RATE_HZ: f64 = 1e8;
    let samples = 100_000;
    let times_s: Vec<f64> = (0..3).map(|i| f64::from(i) / 500.0).collect();
    let path = |from: [f64; 3]| {
        let points = times_s.iter().map(|t| [from[0] + 200.0 * t, from[1], from[2]]).collect();
        PhasePath::new(times_s.clone(), points).unwrap()
    };
    let (transmitter, receiver) = (path([0.0, -5000.0, 3000.0]), path([100.0, -4000.0, 3100.0]));
    let replica: Vec<Complex32> = (0..100)
        .map(|i| f64::from(i) / RATE_HZ - 0.5e-6)
        .map(|t| Complex32::cis((std::f64::consts::PI * BAND_HZ / 1e-6 * t * t) as f32))
        .collect();
    let shape = PulseShape {
        replica: &replica,
        turns: 1,
        sample_rate_hz: RATE_HZ,
        band: Band::about(0.0, BAND_HZ),
        pulse_s: 1e-6,
    };
    let compressor = Compressor::new(shape, samples, RangeFilter::Flat, Taper::Uniform, 16).unwrap();
    let ground = Ground::map([0.0; 3], [17.0, 5.0], 1.0).unwrap();
    for first in [300, 99_000] {
        let mut window = vec![Complex32::ZERO; samples];
        window[first..first + replica.len()].copy_from_slice(&replica);
        let mut aperture = Aperture {
            carrier_hz: 1e10,
            compressor: &compressor,
            transmitter: &transmitter,
            receiver: &receiver,
            pulses: Vec::new(),
            centre_m: [0.0; 3],
            gate: None,
        };
        let echo = |t: &f64| PulseEcho {
            emission_s: *t,
            number: 0,
            window_start_s: 0.0,
            weight: 1.0,
            samples: &window,
        };
        aperture.pulses = times_s.iter().map(echo).collect();
        for i in 0..aperture.pulses.len() {
            let delay_s = aperture.delay_s(&aperture.pulses[i], [0.0; 3]);
            aperture.pulses[i].window_start_s = delay_s - first as f64 / RATE_HZ;
        }
        let found = fast(&aperture, &[ground], &|_| ()).remove(0);
        let found_db = difference_db(&found, &reference(&aperture, &ground));
        let predicted_db = interpolation_error_db(BAND_HZ, 16.0 * RATE_HZ);
        println!("sample {first}: fast differs by {found_db:.1} dB, interpolation {predicted_db:.1} dB");
        // As above. Cells counted from the window's start in f32, 1.6e6 of them, are whole eighths: off by
        // 1/28 cell rms, 2 pi 17 MHz / (28 x 1.6 GHz) = -52 dB.
        assert!(found_db < predicted_db + 2.0, "{first}: {found_db}");
    }
}

#[test]
fn one_thread_and_three_give_the_same_bits() {
    let geometry = &GEOMETRIES[2];
    let recording = geometry.record("", [[0.0; 3]; 2]);
    let paths = [recording.true_path("t").unwrap(), recording.true_path("r").unwrap()];
    let compressor = compressor(&recording, RangeFilter::Matched, Taper::Uniform);
    let aperture = aperture(&recording, &compressor, [&paths[0], &paths[1]], 3);
    let ground = Ground::map([0.0; 3], [150.0, 70.0], 1.0).unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fast(&aperture, &[ground], &|_| ())).remove(0)
    };
    let bits = |image: &[Complex32]| -> Vec<[u32; 2]> {
        image.iter().map(|z| [z.re.to_bits(), z.im.to_bits()]).collect()
    };
    assert_eq!(bits(&with(1)), bits(&with(3)));
}

#[test]
fn of_alternating_polarisations_each_channel_takes_its_own_pulses() {
    let geometry = &GEOMETRIES[0];
    let recording = geometry.record("tx_polarisation = \"alternating\"", [[0.0; 3]; 2]);
    let paths = [recording.true_path("t").unwrap(), recording.true_path("r").unwrap()];
    let compressor = compressor(&recording, RangeFilter::Matched, Taper::Uniform);
    let whole = geometry.record("", [[0.0; 3]; 2]);
    for channel in 0..4 {
        let own = aperture(&recording, &compressor, [&paths[0], &paths[1]], channel);
        assert_eq!(own.pulses.len() as u64, geometry.pulses / 2);
        let all = aperture(&whole, &compressor, [&paths[0], &paths[1]], channel);
        let point = Ground::line(TARGET_M, [0.0; 3], 1);
        let [a, b] = [&own, &all].map(|aperture| fast(aperture, &[point], &|_| ())[0][0]);
        // The same echo from half the pulses. Nothing is lost to pulses that carry none.
        assert!((a / b - Complex32::ONE).norm() < 2e-3, "{channel}: {a} {b}");
        let off = (f64::from(a.arg()) - PHASE_RAD).rem_euclid(std::f64::consts::PI);
        assert!(!(0.01..std::f64::consts::PI - 0.01).contains(&off), "{channel}: {off}");
    }
}
