//! The turbulent strip: golden widths, its outline, what it does to the spectrum.

use nereus::scattering::kind::turbulent_wake::{RatioError, TurbulentWake, WIND_RATIO};
use nereus::scattering::kind::{Kind, clean::Clean};
use nereus::scattering::slope_pdf::MeanSquareSlope;
use nereus::scene::water::{Development, WindProfile};
use nereus::sea::spectrum::{Elfouhaily, Spectrum, WaveVector};
use nereus::sea::wake::TurbulentStrip;
use nereus::sea::wind::Wind;
use proptest::prelude::*;

use crate::sea_golden::{Judge, rows};

#[test]
fn widths_of_the_golden_table() {
    let mut judge = Judge::new("turbulent_wake_width.csv", 1e-9);
    for row in rows("turbulent_wake_width.csv") {
        let length_m = row.get("L");
        let strip = TurbulentStrip::with(length_m, row.get("B"), row.get("alpha"), 20.0 * length_m).unwrap();
        judge.compare(&row, "W_m", strip.width_m(row.get("x_m")));
    }
    judge.verdict();
}

#[test]
fn the_outline_has_half_the_cover_and_the_edge_a_tenth_of_the_width() {
    let strip = TurbulentStrip::with(100.0, 13.0, 5.0, 2000.0).unwrap();
    for behind_m in [1.0, 40.0, 400.0, 3000.0] {
        let (half_m, decay) = (0.5 * strip.width_m(behind_m), (-behind_m / 2000.0f64).exp());
        let onset = 0.5 - 0.5 * (std::f64::consts::PI * (behind_m / 13.0).min(1.0)).cos();
        let cover = |share: f64| strip.cover([behind_m + 50.0, -share * half_m]) / decay / onset;
        for (share, value) in
            [(0.0, 1.0), (0.899, 1.0), (0.95, 0.5 + 0.125f64.sqrt()), (1.0, 0.5), (1.101, 0.0)]
        {
            assert!((cover(share) - value).abs() < 1e-12, "{behind_m} m, {share}: {}", cover(share));
        }
    }
    // It comes on over a beam: half of it after half a beam, on the centre line.
    assert!((strip.cover([56.5, 0.0]) - 0.5 * (-6.5f64 / 2000.0).exp()).abs() < 1e-12);
    // Nothing abreast of the ship or ahead of it.
    for astern_m in [50.0, 49.0, 0.0, -500.0, f64::NAN] {
        assert_eq!(strip.cover([astern_m, 0.0]), 0.0);
    }
}

#[test]
fn strips_that_are_refused() {
    for (length_m, beam_m, exponent, decay_m) in [
        (0.0, 13.0, 5.0, 100.0),
        (100.0, -1.0, 5.0, 100.0),
        (100.0, f64::NAN, 5.0, 100.0),
        (100.0, 13.0, 3.9, 100.0),
        (100.0, 13.0, 5.0, 0.0),
        (100.0, 13.0, 5.0, f64::INFINITY),
    ] {
        assert!(TurbulentStrip::with(length_m, beam_m, exponent, decay_m).is_err());
    }
    for range in [[0.0, 1.0], [2.0, 1.0], [1.0, 1.0], [1.0, f64::INFINITY], [f64::NAN, 1.0]] {
        assert!(matches!(TurbulentWake::new(range, |_| 0.5), Err(RatioError::Range { .. })));
    }
    assert!(matches!(TurbulentWake::new([1.0, 2.0], |_| -0.1), Err(RatioError::Value { .. })));
}

#[test]
fn the_spectrum_in_the_strip_is_that_of_a_weaker_wind() {
    let sea = |u10_mps: f64| {
        let wind = Wind::from_speed(u10_mps, 10.0, WindProfile::Cardone, 0.0).unwrap();
        Elfouhaily::new(&wind, Development::InverseWaveAge(0.84)).unwrap()
    };
    let (clean, weak) = (sea(10.0), sea(10.0 * WIND_RATIO));
    // Upwind and crosswind together: the mean over direction.
    let mean = |sea: &Elfouhaily, k: f64| {
        sea.wave_m4(WaveVector::new(k, 0.0))
            + sea.wave_m4(WaveVector::new(-k, 0.0))
            + sea.wave_m4(WaveVector::new(0.0, k))
            + sea.wave_m4(WaveVector::new(0.0, -k))
    };
    let ratio = |k: f64| mean(&weak, k) / mean(&clean, k);
    let stirred = TurbulentWake::new([1.0, 1000.0], ratio).unwrap();
    for k in [1.5, 37.0, 209.0, 419.0, 900.0] {
        // 256 values over ln 1000: steps of 0.027, and linear between misses by step^2/8 of the second
        // derivative, which at the capillary end is about 10.
        assert!(
            (stirred.spectrum_factor(k) - ratio(k).min(1.0)).abs() < 1e-3,
            "{k}: {}",
            stirred.spectrum_factor(k)
        );
    }
    assert!(stirred.spectrum_factor(209.0) < 0.5, "X-band Bragg waves are damped");
    assert_eq!(stirred.spectrum_factor(1e-9), stirred.spectrum_factor(1.0));
    // Slopes go from clean to slick with the cover.
    let half = Clean.slopes(8.0).blend(stirred.slopes(8.0), 0.5);
    let mean = 0.5 * (MeanSquareSlope::cox_munk_clean(8.0).up + MeanSquareSlope::cox_munk_slick(8.0).up);
    assert!((half.up - mean).abs() < 1e-15);
}

proptest! {
    #![proptest_config(crate::cases::proptests(256))]

    #[test]
    fn covers_and_factors_are_shares(
        length_log in -3.0..4.0f64, beam_log in -3.0..4.0f64, exponent in 4.0..=5.0f64, decay_log in -3.0..6.0f64,
        x in -1e6..1e6f64, y in -1e6..1e6f64, k in any::<f64>(),
    ) {
        let [length_m, beam_m, decay_m] = [length_log, beam_log, decay_log].map(|e| 10f64.powf(e));
        let strip = TurbulentStrip::with(length_m, beam_m, exponent, decay_m).unwrap();
        for place in [[x, y], [x, y * 1e-4], [x * 1e-3, 0.0]] {
            prop_assert!((0.0..=1.0).contains(&strip.cover(place)));
        }
        let kind = TurbulentWake::new([0.1, 1e3], |k| 2.0 / (1.0 + k)).unwrap();
        prop_assert!((0.0..=1.0).contains(&kind.spectrum_factor(k)));
    }
}
