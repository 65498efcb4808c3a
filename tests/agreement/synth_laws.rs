//! What holds for the fast echo whatever the numbers: bit-identical, variants alike, edges, nothing but
//! finite.

use nereus::echo::synth::block::{BlockPaths, MAX_PULSES, Node};
use nereus::echo::synth::doppler::Doppler;
use nereus::echo::synth::{Settings, Synth, Variant};
use nereus::paths::list::ScattererPaths;
use num_complex::Complex64;
use proptest::prelude::*;

use crate::synth_scenes::{Patch, error_db, patches, spectra};

#[test]
fn shares_do_not_change_a_bit() {
    let patch = &patches()[0];
    let synth = patch.synth::<f32>(&[0, 0, 0, 0], Settings::default());
    let block: BlockPaths<f32> = patch.fill(&synth, 61, |p| patch.paths(300, 1, 4, p));
    let of = |shares: usize| {
        let (mut grids, mut scratch) = (synth.grids(), synth.scratch());
        synth.clear(&block, &mut grids);
        // The last share first, and every share in a thread of its own.
        std::thread::scope(|scope| {
            for mut share in grids.shares(shares).collect::<Vec<_>>().into_iter().rev() {
                let (synth, block) = (&synth, &block);
                scope.spawn(move || synth.spread_share(block, &mut share));
            }
        });
        let mut out = vec![Complex64::ZERO; 4 * synth.fft_len()];
        let mut all = Vec::new();
        for pulse in 0..61 {
            synth.spectrum(&block, &grids, pulse, &mut scratch, &mut out);
            all.extend(out.iter().flat_map(|s| [s.re.to_bits(), s.im.to_bits()]));
        }
        all
    };
    let one = of(1);
    assert!(one.iter().any(|bits| *bits != 0));
    for shares in [2, 3, 7, 61, 1000] {
        assert!(of(shares) == one, "{shares} shares differ from one");
    }
}

#[test]
fn variants_agree() {
    for patch in patches() {
        let of = |variant| {
            let settings = Settings { variant: Some(variant), ..Settings::default() };
            let synth = patch.synth::<f32>(&[0, 0, 0, 0], settings);
            let block = patch.fill(&synth, 64, |p| patch.paths(1000, 1, 4, p));
            spectra(&synth, &block, 4, &[0, 31, 63])
        };
        let portable = of(Variant::Portable);
        for variant in [Variant::Avx2Fma, Variant::Avx512] {
            if !variant.is_available() {
                println!("NOT RUN: this CPU has no {variant}");
                continue;
            }
            for (a, b) in of(variant).iter().zip(&portable) {
                let db = error_db(a, b);
                println!("{}: {variant} against portable {db:.1} dB", patch.name);
                // What DESIGN asks of two backends; they differ by roundings only.
                assert!(db <= -100.0, "{db}");
            }
        }
    }
}

/// A path at a place after the start of the window, samples, and one within.
fn beside_one_within(patch: &Patch, place: f64) -> ScattererPaths {
    let mut paths = ScattererPaths::new(1, 1, 2);
    for place in [place, 100.0] {
        paths.emission_offset_s.push(0.0);
        paths.delay_s[0].push(patch.window_s(0) + place / patch.rate_hz);
        paths.delay_rate[0].push(-1e-7);
        paths.amplitude[0].push(Complex64::ONE);
    }
    paths
}

#[test]
fn paths_at_and_beyond_the_edges_are_those_of_the_reference() {
    let patch = &patches()[0];
    let rate_hz = patch.rate_hz;
    let (window, pulse) = (patch.samples as f64, patch.pulse_s * rate_hz);
    let settings = Settings { width: 8, doppler: Doppler::Shift, ..Settings::default() };
    let synth = patch.synth::<f64>(&[0], settings);
    let reference = patch.reference(&[0]);
    // Places after the window's start, samples. Reach ends at -pulse - 32 and window + 32.
    for place in [
        -pulse - 1e9,
        -pulse - 33.0,
        -pulse - 31.5,
        -pulse,
        -0.25,
        0.0,
        window - 0.01,
        window,
        window + 31.2,
        window + 33.0,
        window + 40.0,
        2.0 * synth.fft_len() as f64,
        1e15,
        f64::INFINITY,
        f64::NAN,
    ] {
        let paths = beside_one_within(patch, place);
        let block = patch.fill(&synth, 1, |_| paths.clone());
        let mut exact = vec![Complex64::ZERO; reference.fft_len()];
        reference.spectrum(&paths, patch.window_s(0), &mut exact);
        let db = error_db(&spectra(&synth, &block, 1, &[0])[0], &exact);
        println!("place {place}: {db:.1} dB");
        assert!(db < synth.predicted_error(&block).total_db() + 3.02, "{place}: {db}");
        // Out of reach, or unseen by this pair: nothing is lost.
        assert_eq!(block.found().unplaced, 0);
    }
}

/// A fraction of a cell within and beyond the reach, which ends before the last cell, or after it where the
/// transform has no room to spare.
#[test]
fn an_exact_reach_ends_where_that_of_the_reference_does() {
    let short = patches()[0].clone();
    let full = Patch { samples: 402, pulse_s: 0.338e-6, ..short.clone() };
    for (patch, spare) in [(&short, 2), (&full, 0)] {
        let settings = Settings { width: 7, doppler: Doppler::Shift, ..Settings::default() };
        let synth = patch.synth::<f32>(&[0], settings).with_exact_reach();
        let reference = patch.reference(&[0]);
        let pulse = patch.pulse_s * patch.rate_hz;
        assert_eq!(reference.fft_len() - patch.samples - pulse.ceil() as usize - 64, spare);
        let edges = [-pulse - 32.0, patch.samples as f64 + 32.0];
        for (edge, inside) in edges.into_iter().zip([1.0, -1.0]) {
            for off in [0.02, 0.1, 0.24, 0.3, 0.49, -0.02, -0.1, -0.24, -0.3, -0.49] {
                let place = edge + inside * off;
                let paths = beside_one_within(patch, place);
                let block = patch.fill(&synth, 1, |_| paths.clone());
                let mut exact = vec![Complex64::ZERO; reference.fft_len()];
                reference.spectrum(&paths, patch.window_s(0), &mut exact);
                let db = error_db(&spectra(&synth, &block, 1, &[0])[0], &exact);
                println!("{} samples, place {place}: {db:.1} dB", patch.samples);
                assert!(db < synth.predicted_error(&block).total_db() + 3.02, "{place}: {db}");
            }
        }
    }
}

#[test]
fn a_path_may_cross_the_whole_window_within_a_block() {
    // 4000 samples in 64 pulses, through a window of 400: in reach for eight of them or so.
    let patch = &patches()[0];
    let at = |pulse: usize| {
        let mut paths = ScattererPaths::new(1, 1, 1);
        let place_s = (pulse as f64 - 32.3) * 62.5 / patch.rate_hz;
        paths.emission_offset_s.push(0.0);
        paths.delay_s[0].push(patch.window_s(pulse) + 200.0 / patch.rate_hz + place_s);
        paths.delay_rate[0].push(0.0);
        paths.amplitude[0].push(Complex64::ONE);
        paths
    };
    let settings = Settings { width: 7, ..Settings::default() };
    let synth = patch.synth::<f32>(&[0], settings);
    let block = patch.fill(&synth, 64, at);
    let pulses: Vec<usize> = (0..64).collect();
    let reference = patch.reference(&[0]);
    let mut within = 0;
    for (pulse, fast) in spectra(&synth, &block, 1, &pulses).iter().enumerate() {
        let mut exact = vec![Complex64::ZERO; reference.fft_len()];
        reference.spectrum(&at(pulse), patch.window_s(pulse), &mut exact);
        if exact.iter().all(|s| *s == Complex64::ZERO) {
            assert!(fast.iter().all(|s| *s == Complex64::ZERO), "pulse {pulse}");
        } else {
            within += 1;
            let db = error_db(fast, &exact);
            let allowed = synth.predicted_error(&block).total_db() + 3.02;
            assert!(db < allowed, "pulse {pulse}: {db} dB for {allowed}");
        }
    }
    assert!((6..=12).contains(&within), "{within}");
}

#[test]
fn blocks_that_make_no_sense_are_refused() {
    let patch = &patches()[0];
    let synth = patch.synth::<f32>(&[0, 0], Settings::default());
    let mut block = synth.block();
    let (two, three) = (patch.paths(2, 1, 2, 0), patch.paths(3, 1, 2, 0));
    let narrow = patch.paths(2, 1, 1, 0);
    let node = |pulse, paths| Node { pulse, paths };
    let mut fault = |nodes: &[Node<'_>], windows: &[f64]| synth.fill(nodes, windows, &mut block).unwrap_err();
    let faults = [
        fault(&[node(0, &two)], &[]),
        fault(&[node(0, &two)], &[1e-5; MAX_PULSES + 1]),
        fault(&[node(0, &two)], &[f64::NAN]),
        fault(&[], &[1e-5]),
        fault(&[node(1, &two)], &[1e-5]),
        fault(&[node(1, &two), node(1, &two)], &[1e-5; 2]),
        fault(&[node(0, &two), node(1, &three)], &[1e-5; 2]),
        fault(&[node(0, &narrow)], &[1e-5]),
    ]
    .map(|f| f.to_string());
    let expected = [
        "a block of 0 pulses is not allowed: 1 to 1024",
        "a block of 1025 pulses is not allowed: 1 to 1024",
        "window start NaN s is not finite",
        "0 nodes of a block are not allowed: 1 to 4",
        "node at pulse 1 is not allowed: once each, below 1",
        "node at pulse 1 is not allowed: once each, below 2",
        "paths of the node at pulse 1 differ from those of the first in number, pairs or channels",
        "paths of the node at pulse 0 differ from those of the first in number, pairs or channels",
    ];
    assert_eq!(faults, expected);
}

/// Any delay or rate, mostly near the window.
fn anything(near: f64) -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -4.0 * near..4.0 * near,
        1 => prop::num::f64::ANY,
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(0.0),
    ]
}

const DOPPLERS: [Doppler; 4] = [Doppler::Mean, Doppler::Shift, Doppler::Taylor, Doppler::ShiftTaylor];

proptest! {
    #![proptest_config(crate::cases::proptests(96))]

    #[test]
    fn nothing_but_finite_comes_out(
        paths in prop::collection::vec(
            (anything(1e-5), anything(1e-5), anything(1e-4), -1e9..1e9f64, anything(1e-2)), 1..40),
        pulses in 1usize..=64,
        start_s in -1.0..1.0f64,
        step_s in prop_oneof![Just(0.0), -1e-6..1e-6, -1e3..1e3],
        doppler in prop::sample::select(DOPPLERS.to_vec()),
        width in 2usize..=8,
    ) {
        let patch = &patches()[0];
        let settings = Settings { width, doppler, ..Settings::default() };
        let synth: Synth<f32> = patch.synth(&[0, 0, 1], settings);
        let list = |last: bool| {
            let mut list = ScattererPaths::new(2, 3, paths.len());
            for &(near, far, rate, level, offset) in &paths {
                list.emission_offset_s.push(if offset.is_finite() { offset.clamp(-1.0, 1.0) } else { 0.0 });
                list.delay_s[0].push(start_s + near);
                list.delay_s[1].push(start_s + if last { far } else { near });
                list.delay_rate.iter_mut().for_each(|r| r.push(rate));
                list.amplitude.iter_mut().for_each(|a| a.push(Complex64::new(level, -level)));
            }
            list
        };
        let (first, last) = (list(false), list(true));
        let mut nodes = vec![Node { pulse: 0, paths: &first }];
        if pulses > 1 {
            nodes.push(Node { pulse: pulses - 1, paths: &last });
        }
        let windows: Vec<f64> = (0..pulses).map(|p| start_s + step_s * p as f64).collect();
        let mut block = synth.block();
        synth.fill(&nodes, &windows, &mut block).unwrap();
        let all: Vec<usize> = (0..pulses).collect();
        for out in spectra(&synth, &block, 3, &all) {
            prop_assert!(out.iter().all(|s| s.is_finite()));
        }
        prop_assert!(!synth.predicted_error(&block).total_db().is_nan());
    }
}
