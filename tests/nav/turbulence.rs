//! Turbulence: variance and spectra of gusts, the answer of the aircraft, smoothness, determinism.

use std::f64::consts::TAU;

use nereus::frames::{Earth, Point, SceneFrame, Vector};
use nereus::motion::errors::Circumstances;
use nereus::motion::gusts::Gusts;
use nereus::motion::track::TurbulenceFault;
use nereus::motion::track::turbulence::{Axis, Chain, strength};
use nereus::motion::{SourceError, Track};
use nereus::time::{PulseTimes, TimeTag};
use nereus::units::FOOT_M;
use proptest::prelude::*;

const SAMPLES: usize = 100_000;
const SIGMAS: f64 = 5.0;

/// The published spectrum |H(j w)|^2, per rad/s and side, of a process of unit-intensity noise.
fn density(axis: &Axis, w: f64) -> f64 {
    let (t, s) = (axis.time_s, axis.sigma_mps);
    let x = (w * t).powi(2);
    if axis.along { s * s * 2.0 * t / (1.0 + x) } else { s * s * t * (1.0 + 3.0 * x) / (1.0 + x).powi(2) }
}

/// Its correlation at a lag: the inverse transform, `s^2 e^(-|x|)` and `s^2 e^(-|x|) (1 - |x|/2)`.
fn correlation(axis: &Axis, lag_s: f64) -> f64 {
    let x = lag_s / axis.time_s;
    axis.sigma_mps.powi(2) * (-x).exp() * if axis.along { 1.0 } else { 1.0 - x / 2.0 }
}

#[test]
fn gusts_have_variance_and_correlation_as_published() {
    for along in [true, false] {
        let axis = Axis { along, sigma_mps: 2.5, time_s: 1.3 };
        // The closed forms are a pair: the spectrum summed is the variance.
        let dw = 1e-3;
        let sum: f64 =
            (0..4_000_000).map(|i| density(&axis, (f64::from(i) + 0.5) * dw) * dw / (TAU / 2.0)).sum();
        assert!((sum / 6.25 - 1.0).abs() < 1e-3, "{sum}");
        // Also at steps far longer than the correlation time, where a sampled filter would be wrong.
        for (dt, seed) in [(0.065, 3), (0.65, 4), (5.0, 5)] {
            let chain = Chain::new(axis, TAU * 0.5, Some(30.0), dt);
            let gusts: Vec<f64> = chain.run(seed, 9, 0, SAMPLES).iter().map(|a| a.gust_mps).collect();
            let n = SAMPLES as f64;
            let found = |lag: usize| gusts.iter().zip(&gusts[lag..]).map(|(a, b)| a * b).sum::<f64>() / n;
            // Bartlett: the spread of an estimate is at most that of the mean square,
            // 2/n sum over lags of the squared correlation.
            let r = |k: usize| correlation(&axis, k as f64 * dt);
            let sum: f64 = (1..2000).map(|k| 2.0 * r(k).powi(2)).sum::<f64>() + r(0).powi(2);
            let spread = (2.0 * sum / n).sqrt();
            for lag in [0, 1, 3, 10, 20] {
                let apart = found(lag) - r(lag);
                assert!(apart.abs() < SIGMAS * spread, "along {along} dt {dt} lag {lag}: {apart} {spread}");
            }
            println!("along {along}, dt {dt} s: variance over s^2 {:.4}", found(0) / 6.25);
        }
    }
}

#[test]
fn the_aircraft_follows_below_its_cut_off() {
    // Variance of displacement rate and acceleration against the spectrum times that of the answer, summed.
    for along in [true, false] {
        let axis = Axis { along, sigma_mps: 1.5, time_s: 2.0 };
        let (cutoff, hold_s, dt) = (TAU * 0.5, 30.0, 0.1);
        let answers = Chain::new(axis, cutoff, Some(hold_s), dt).run(11, 2, 0, 4 * SAMPLES);
        let (mut want, dw) = ([0.0; 3], 1e-3);
        for i in 0..400_000 {
            let w = (f64::from(i) + 0.5) * dw;
            let low = cutoff.powi(4) / ((cutoff.powi(2) - w * w).powi(2) + (1.4 * cutoff * w).powi(2));
            let held = (w * hold_s).powi(2) / (1.0 + (w * hold_s).powi(2));
            let rate = density(&axis, w) * low * held * dw / (TAU / 2.0);
            want[0] += rate / (w * w);
            want[1] += rate;
            want[2] += rate * w * w;
        }
        let n = answers.len() as f64;
        let found = [
            answers.iter().map(|a| a.position_m.powi(2)).sum::<f64>() / n,
            answers.iter().map(|a| a.velocity_mps.powi(2)).sum::<f64>() / n,
            answers.iter().map(|a| a.acceleration_mps2.powi(2)).sum::<f64>() / n,
        ];
        // Correlation times are about T_h, T, 1/w_c: twice as many samples each make one that is independent.
        for (which, time_s) in [hold_s, axis.time_s, 1.0 / cutoff].into_iter().enumerate() {
            let spread = (2.0 * (2.0 * time_s / dt).max(1.0) / n).sqrt();
            let ratio = found[which] / want[which];
            println!("along {along}, derivative {which}: {ratio:.4}, standard deviation {spread:.4}");
            assert!((ratio - 1.0).abs() < SIGMAS * spread, "{which}: {ratio} {spread}");
        }
        // The position is the integral of the velocity, here by trapezoids with end corrections.
        let mut worst = 0f64;
        for w in answers.windows(2).take(10_000) {
            let rise = 0.5 * dt * (w[0].velocity_mps + w[1].velocity_mps)
                + dt * dt / 12.0 * (w[0].acceleration_mps2 - w[1].acceleration_mps2);
            worst = worst.max((w[1].position_m - w[0].position_m - rise).abs());
        }
        // The third derivative jumps as white noise does within a step: s w_c^2 sqrt(2/T) dt^3.5 / 30 at one
        // sigma.
        let bound = 6.0 * 1.5 * cutoff.powi(2) * 3f64.sqrt() * dt.powf(3.5) / 30.0;
        assert!(worst < bound, "{worst:e} {bound:e}");
    }
}

#[test]
fn scales_meet_at_their_borders() {
    let kt = 1852.0 / 3600.0;
    for (wind, high) in [(15.0 * kt, 1.5), (30.0 * kt, 3.0), (45.0 * kt, 6.0)] {
        let top = strength(3000.0 * FOOT_M, wind);
        for axis in 0..3 {
            assert!((top.sigma_mps[axis] - high).abs() < 1e-12 && (top.length_m[axis] - 533.4).abs() < 1e-9);
            for border in [1000.0, 2000.0] {
                let [below, above] = [-1e-6, 1e-6].map(|d| strength((border + d) * FOOT_M, wind));
                assert!((below.sigma_mps[axis] - above.sigma_mps[axis]).abs() < 1e-7);
                assert!((below.length_m[axis] - above.length_m[axis]).abs() < 1e-4);
            }
        }
    }
    // 200 ft, W20 = 20 m/s, by hand: 0.177 + 0.1646 = 0.3416; 200/0.3416^1.2 = 725.8 ft; 2/0.3416^0.4 =
    // 3.074.
    let low = strength(200.0 * FOOT_M, 20.0);
    assert!(
        (low.length_m[0] / FOOT_M - 725.8).abs() < 0.1 && (low.length_m[2] / FOOT_M - 200.0).abs() < 1e-9
    );
    assert!((low.sigma_mps[1] - 3.074).abs() < 1e-3 && low.sigma_mps[2] == 2.0);
}

fn straight(start: TimeTag) -> Track {
    Track::straight(Point::new(0.0, 0.0, 300.0), start, Vector::new(60.0, 80.0, 0.0), None)
}

fn shaken(gusts: &Gusts, pulses: u64, seed: u64) -> (Track, Track, TimeTag) {
    let start = TimeTag::new(1_700_000_000, 0.5);
    let times = PulseTimes::uniform(222.0).unwrap();
    let of = Circumstances { seed, platform: 0, times: &times, pulses, before_s: 0.0 };
    let calm = straight(start);
    let track = calm.in_gusts(gusts, &SceneFrame::plain(Earth::Flat), &of, start).unwrap();
    (calm, track, start)
}

#[test]
fn a_shaken_track_is_smooth_and_a_function_of_time() {
    let (calm, long, start) = shaken(&Gusts::of_wind(15.4), 22_200, 1);
    let (_, short, _) = shaken(&Gusts::of_wind(15.4), 222, 1);
    let (_, other, _) = shaken(&Gusts::of_wind(15.4), 222, 2);
    for k in -50..100 {
        let t = start.plus(f64::from(k) * 0.01);
        assert_eq!(long.state(t).unwrap(), short.state(t).unwrap());
        assert_ne!(long.state(t).unwrap(), other.state(t).unwrap());
    }
    let (mut moved, mut tilted) = (0f64, 0f64);
    for k in 0..2000 {
        let t = start.plus(f64::from(k) * 0.049_37);
        let state = long.state(t).unwrap();
        let h = 1e-4;
        let [before, after] = [-h, h].map(|d| long.state(t.plus(d)).unwrap());
        // Jerk of gusts that are followed: below w_c^2 times a gust of 10 m/s, 100 m/s^3; times h^2/6 and h.
        let slope = (after.position - before.position) * (0.5 / h);
        assert!((slope - state.velocity).norm() < 1e-6, "{:?}", slope - state.velocity);
        let bend = (after.velocity - before.velocity) * (0.5 / h);
        assert!((bend - state.acceleration).norm() < 0.05, "{:?}", bend - state.acceleration);
        let step = (after.position - before.position).norm();
        assert!((step - 2.0 * h * state.velocity.norm()).abs() < 1e-6);
        let nose = |s: &nereus::motion::State| s.attitude * Vector::new(1.0, 0.0, 0.0);
        let turning = (nose(&after) - nose(&before)) * (0.5 / h);
        assert!((turning - state.angular_rate.cross(nose(&state))).norm() < 1e-4);
        moved = moved.max((state.position - calm.state(t).unwrap().position).norm());
        let [yaw, pitch, roll] = state.attitude.to_yaw_pitch_roll();
        tilted = tilted.max(pitch.abs()).max(roll.abs()).max((yaw - 60f64.atan2(80.0)).abs());
    }
    println!("moved by up to {moved:.2} m, tilted by up to {:.2} deg", tilted.to_degrees());
    assert!(moved > 0.5 && tilted > 0.3f64.to_radians());
}

#[test]
fn a_platform_that_stands_and_runs_that_do_not_end_are_refused() {
    let start = TimeTag::default();
    let times = PulseTimes::uniform(222.0).unwrap();
    let frame = SceneFrame::plain(Earth::Flat);
    let of = |pulses| Circumstances { seed: 1, platform: 0, times: &times, pulses, before_s: 0.0 };
    let mast = Track::fixed(
        Point::new(0.0, 0.0, 15.0),
        nereus::frames::Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0),
    );
    let error = mast.in_gusts(&Gusts::of_wind(10.0), &frame, &of(10), start).unwrap_err();
    assert!(matches!(error, SourceError::Turbulence(TurbulenceFault::Slow { .. })), "{error}");
    let error = straight(start).in_gusts(&Gusts::of_wind(10.0), &frame, &of(1 << 40), start).unwrap_err();
    assert!(matches!(error, SourceError::Turbulence(TurbulenceFault::TooLong { .. })), "{error}");
}

proptest! {
    #![proptest_config(crate::cases::proptests(32))]

    #[test]
    fn every_legal_gust_is_finite(
        wind in 0.0f64..100.0, height in 0.0f64..1e5, airspeed in 5.0f64..1e4, cutoff in 0.05f64..5.0,
        hold in 0.0f64..1e5, gain in 0.0f64..10.0, seed: u64,
    ) {
        let gusts = Gusts {
            wind20_mps: wind, height_m: Some(height), airspeed_mps: Some(airspeed), cutoff_hz: cutoff,
            velocity_gain: gain, attitude_gain: gain, hold_s: Some(hold).filter(|h| *h > 1.0),
        };
        let start = TimeTag::default();
        let times = PulseTimes::uniform(222.0).unwrap();
        let of = Circumstances { seed, platform: 0, times: &times, pulses: 222, before_s: 0.0 };
        match straight(start).in_gusts(&gusts, &SceneFrame::plain(Earth::Flat), &of, start) {
            Ok(track) => for k in 0..20 {
                let s = track.state(start.plus(f64::from(k) * 0.05)).unwrap();
                let q = s.attitude.to_wxyz();
                for x in s.position.to_array().iter().chain(&s.velocity.to_array()).chain(&s.acceleration.to_array())
                    .chain(&s.angular_rate.to_array()).chain(&q) {
                    prop_assert!(x.is_finite());
                }
            },
            Err(error) => {
                let too_long = matches!(error, SourceError::Turbulence(TurbulenceFault::TooLong { .. }));
                prop_assert!(too_long);
            }
        }
    }
}
