//! Errors of reports: what is drawn is what was asked, known errors are exact, and which report is at hand.

use nereus::frames::{Point, Rotation, Vector};
use nereus::motion::PlatformNav;
use nereus::motion::errors::preset::Class;
use nereus::motion::errors::{
    ATTITUDE, AXES, Between, Circumstances, Dropouts, ErrorModel, Errors, ErrorsFault, Recorded, VELOCITY,
};
use nereus::motion::{PlatformTracks, Track};
use nereus::nav::TrackSource;
use nereus::pulse::flags;
use nereus::time::{PulseTimes, TimeTag};
use proptest::prelude::*;

/// Samples of every statistic.
const SAMPLES: usize = 100_000;
/// Standard deviations allowed: one in 1.7 million outcomes of a normal statistic lies beyond.
const SIGMAS: f64 = 5.0;

fn of(times: &PulseTimes, pulses: u64) -> Circumstances<'_> {
    Circumstances { seed: 20_240_229, platform: 1, times, pulses, before_s: 0.0 }
}

fn drawn(model: &ErrorModel, axis: usize) -> Vec<f64> {
    let times = PulseTimes::uniform(1.0).unwrap();
    let errors = Errors::new(model, &of(&times, SAMPLES as u64)).unwrap();
    (0..SAMPLES as i64).map(|epoch| errors.value(axis, epoch, epoch as f64)).collect()
}

/// Mean of the squares; the mean itself is known to be zero.
fn power(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64
}

#[test]
fn white_noise_has_its_variance() {
    let mut model = ErrorModel { rate_hz: Some(2.0), ..ErrorModel::default() };
    model.axes[VELOCITY].white = 0.05;
    let values = drawn(&model, VELOCITY);
    // The variance of the mean square of n normal numbers is 2 s^4 / n.
    let ratio = power(&values) / 0.05f64.powi(2);
    assert!((ratio - 1.0).abs() < SIGMAS * (2.0 / SAMPLES as f64).sqrt(), "{ratio}");
    let lag: f64 = values.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / power(&values) / SAMPLES as f64;
    assert!(lag.abs() < SIGMAS / (SAMPLES as f64).sqrt(), "{lag}");
}

#[test]
fn gauss_markov_has_its_variance_and_its_correlation_time() {
    let mut model = ErrorModel { rate_hz: Some(4.0), ..ErrorModel::default() };
    (model.axes[2].gm_sigma, model.axes[2].gm_tau_s) = (3.0, 10.0);
    let values = drawn(&model, 2);
    let phi = (-0.25f64 / 10.0).exp();
    // Squares of a first-order process are correlated as phi^2: n shrinks by (1 - phi^2)/(1 + phi^2).
    let spread = (2.0 / SAMPLES as f64 * (1.0 + phi * phi) / (1.0 - phi * phi)).sqrt();
    let ratio = power(&values) / 9.0;
    assert!((ratio - 1.0).abs() < SIGMAS * spread, "{ratio} {spread}");
    // The estimate of phi has variance (1 - phi^2)/n (Kendall and Stuart), its bias is 1/n.
    let found = values.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (power(&values) * SAMPLES as f64);
    assert!((found - phi).abs() < SIGMAS * ((1.0 - phi * phi) / SAMPLES as f64).sqrt(), "{found} {phi}");
    let tau_s = -0.25 / found.ln();
    // d tau / d phi = tau^2 / (phi dt)
    let tau_spread = 100.0 / (phi * 0.25) * ((1.0 - phi * phi) / SAMPLES as f64).sqrt();
    println!("correlation time {tau_s:.3} s of 10 s, standard deviation {tau_spread:.3} s");
    assert!((tau_s - 10.0).abs() < SIGMAS * tau_spread, "{tau_s}");
}

#[test]
fn a_walk_grows_as_the_root_of_time() {
    let mut model = ErrorModel { rate_hz: Some(2.0), ..ErrorModel::default() };
    model.axes[ATTITUDE].walk = 1e-3;
    let values = drawn(&model, ATTITUDE);
    assert_eq!(values[0], 0.0);
    for lag in [1usize, 100] {
        let steps: Vec<f64> = values.windows(lag + 1).step_by(lag).map(|w| w[lag] - w[0]).collect();
        let ratio = power(&steps) / (1e-6 * 0.5 * lag as f64);
        assert!((ratio - 1.0).abs() < SIGMAS * (2.0 / steps.len() as f64).sqrt(), "{lag}: {ratio}");
    }
}

#[test]
fn biases_are_drawn_once_and_differ() {
    let mut model = ErrorModel::default();
    (model.axes[0].bias, model.axes[0].bias_sigma, model.axes[1].bias_sigma) = (7.0, 2.0, 2.0);
    let times = PulseTimes::uniform(100.0).unwrap();
    let mut square = 0.0;
    for platform in 0..500 {
        let errors = Errors::new(&model, &Circumstances { platform, ..of(&times, 10) }).unwrap();
        assert_eq!(errors.value(0, 0, 0.0), errors.value(0, 9, 0.09));
        let [a, b] = [errors.value(0, 0, 0.0) - 7.0, errors.value(1, 0, 0.0)];
        assert_ne!(a, b);
        square += (a * a + b * b) / 1000.0;
    }
    assert!((square / 4.0 - 1.0).abs() < SIGMAS * (2.0f64 / 1000.0).sqrt(), "{square}");
}

#[test]
fn dropouts_come_as_often_and_last_as_long_as_asked() {
    let dropouts = Dropouts { per_hour: 180.0, mean_s: 4.0, during: Between::Hold };
    let model = ErrorModel { rate_hz: Some(10.0), dropouts: Some(dropouts), ..ErrorModel::default() };
    let times = PulseTimes::uniform(1.0).unwrap();
    let errors = Errors::new(&model, &of(&times, 100_000)).unwrap();
    let lost: Vec<bool> = (0..1_000_000).map(|k| errors.latest(f64::from(k) * 0.1).dropout).collect();
    assert!(!lost[0]);
    let falls = lost.windows(2).filter(|w| !w[0] && w[1]).count() as f64;
    let (down, up) =
        (lost.iter().filter(|l| **l).count() as f64, lost.iter().filter(|l| !**l).count() as f64);
    // Chances of a step: 1 - e^(-dt r), e^(-dt/m). Runs are geometric: their number is near Poisson, the mean
    // of n lengths spreads by sqrt(1 - p)/(p sqrt(n)).
    let fall = -(-0.1f64 * 0.05).exp_m1();
    assert!((falls - fall * up).abs() < SIGMAS * (fall * up).sqrt(), "{falls} {}", fall * up);
    let back = -(-0.1f64 / 4.0).exp_m1();
    let length = down / falls;
    assert!((length - 1.0 / back).abs() < SIGMAS / back / falls.sqrt(), "{length} {}", 1.0 / back);
}

/// A straight flight and what it reports.
fn flight(model: &ErrorModel, prf_hz: f64, pulses: u64) -> (PlatformTracks, PulseTimes, TimeTag) {
    let start = TimeTag::new(1_700_000_000, 0.25);
    let track = Track::straight(Point::new(1e4, -2e4, 3000.0), start, Vector::new(120.0, -60.0, 1.0), None);
    let times = PulseTimes::uniform(prf_hz).unwrap();
    let reported = track.with_errors(model, &of(&times, pulses), start).unwrap();
    (PlatformTracks { truth: track, reported }, times, start)
}

#[test]
fn sinusoid_step_and_ramp_are_exact() {
    let mut model = ErrorModel::default();
    let east = &mut model.axes[0];
    (east.sinusoid, east.sinusoid_hz, east.sinusoid_phase_rad) = (2.5, 0.3, 0.7);
    (model.axes[1].step, model.axes[1].step_at_s) = (-12.0, 3600.5);
    model.axes[2].ramp = 0.01;
    let heading = &mut model.axes[ATTITUDE + 2];
    (heading.sinusoid, heading.sinusoid_hz) = (0.02, 1.5);
    let (tracks, times, start) = flight(&model, 222.0, 2_000_000);
    let (mut worst_m, mut worst_mps, mut worst_rad) = (0f64, 0f64, 0f64);
    for n in (0..2_000_000u64).step_by(997) {
        let t = times.emission(start, n);
        let t_s = n as f64 / 222.0;
        let (truth, reported_now) = (tracks.truth.state(t).unwrap(), tracks.reported.report(t).unwrap());
        assert_eq!((reported_now.age_s, reported_now.flags), (0.0, 0));
        let w = std::f64::consts::TAU * 0.3;
        let step = if t_s >= 3600.5 { -12.0 } else { 0.0 };
        let wanted = [2.5 * (w * t_s + 0.7).sin(), step, 0.01 * t_s];
        let moving = [2.5 * w * (w * t_s + 0.7).cos(), 0.0, 0.01];
        let offset = (reported_now.state.position - truth.position).to_array();
        let drift = (reported_now.state.velocity - truth.velocity).to_array();
        let yaw = reported_now.state.attitude.to_yaw_pitch_roll()[0] - truth.attitude.to_yaw_pitch_roll()[0];
        for axis in 0..3 {
            worst_m = worst_m.max((offset[axis] - wanted[axis]).abs());
            worst_mps = worst_mps.max((drift[axis] - moving[axis]).abs());
        }
        worst_rad = worst_rad.max((yaw - 0.02 * (std::f64::consts::TAU * 1.5 * t_s).sin()).abs());
    }
    println!("worst {worst_m:e} m, {worst_mps:e} m/s, {worst_rad:e} rad");
    // Positions of 1e6 m are held to 1.2e-10 m.
    assert!(worst_m < 1e-9 && worst_mps < 1e-9 && worst_rad < 1e-9);
}

#[test]
fn late_reports_are_those_that_have_arrived() {
    let dropouts = Dropouts { per_hour: 3600.0, mean_s: 0.7, during: Between::Hold };
    let mut model = ErrorModel {
        rate_hz: Some(7.0),
        latency_s: 0.31,
        jitter_s: 0.2,
        dropouts: Some(dropouts),
        ..ErrorModel::default()
    };
    model.axes[0].white = 1.0;
    let (tracks, times, start) = flight(&model, 50.0, 3000);
    let mut seen = [0u32; 3];
    let mut held: Option<(f64, f64)> = None;
    for n in 0..3000 {
        let t = times.emission(start, n);
        let reported_now = tracks.reported.report(t).unwrap();
        let lost = reported_now.flags & flags::REPORT_DROPOUT != 0;
        // The epoch is a whole number of sevenths of a second, not after the pulse.
        let epoch = (n as f64 / 50.0 - reported_now.age_s) * 7.0;
        assert!(
            (epoch - epoch.round()).abs() < 1e-6 && reported_now.age_s >= 0.0,
            "{n}: {}",
            reported_now.age_s
        );
        let along =
            reported_now.state.position - tracks.truth.state(t.plus(-reported_now.age_s)).unwrap().position;
        let [east, north, _] = along.to_array();
        if lost {
            // Held: where it was, but for the white error East.
            assert!(north.abs() < 1e-6, "{n}: {north}");
            seen[0] += 1;
        } else {
            assert!((north + 60.0 * reported_now.age_s).abs() < 1e-6, "{n}: {north} {}", reported_now.age_s);
            seen[1] += 1;
        }
        let white = east - if lost { 0.0 } else { 120.0 * reported_now.age_s };
        // One report has one error, whatever pulse it is used for.
        if let Some((before, error)) = held
            && before == epoch.round()
        {
            assert!((white - error).abs() < 1e-6);
            seen[2] += 1;
        }
        held = Some((epoch.round(), white));
    }
    assert!(seen.iter().all(|n| *n > 100), "{seen:?}");
}

#[test]
fn a_report_without_rate_is_one_of_an_earlier_pulse() {
    let model = ErrorModel { latency_s: 0.011, ..ErrorModel::default() };
    let (tracks, times, start) = flight(&model, 222.0, 100);
    for n in 0..100 {
        let age_s = tracks.reported.report(times.emission(start, n)).unwrap().age_s;
        // The first whole number of intervals above 11 ms is three: 13.5 ms.
        assert!((age_s - 3.0 / 222.0).abs() < 1e-12, "{n}: {age_s}");
    }
    // Intervals in turn: 2, 5, 3 ms; nothing older than needed.
    let times = PulseTimes::sequence(&[2e-3, 5e-3, 3e-3]).unwrap();
    let track = Track::fixed(Point::new(0.0, 0.0, 0.0), Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0));
    let model = ErrorModel { latency_s: 2.5e-3, ..ErrorModel::default() };
    let reported = track.with_errors(&model, &of(&times, 100), start).unwrap();
    for (n, age_s) in [(30, 3e-3), (31, 5e-3), (32, 5e-3), (33, 3e-3)] {
        let found = reported.report(times.emission(start, n)).unwrap().age_s;
        assert!((found - age_s).abs() < 1e-12, "{n}: {found}");
    }
}

#[test]
fn an_error_is_a_function_of_its_epoch_alone() {
    let model = ErrorModel {
        jitter_s: 0.01,
        dropouts: Some(Dropouts { per_hour: 600.0, mean_s: 1.0, during: Between::Extrapolate }),
        ..Class::Tactical.model()
    };
    let times = PulseTimes::uniform(200.0).unwrap();
    let long = Errors::new(&model, &Circumstances { before_s: 5.0, ..of(&times, 40_000) }).unwrap();
    let short = Errors::new(&model, &of(&times, 4000)).unwrap();
    for k in (0..2000).rev() {
        for axis in 0..AXES {
            assert_eq!(long.value(axis, k, k as f64 / 100.0), short.value(axis, k, k as f64 / 100.0));
        }
        assert_eq!(long.latest(k as f64 / 100.0), short.latest(k as f64 / 100.0));
    }
    // Another seed, another platform: other numbers.
    let other = Errors::new(&model, &Circumstances { platform: 0, ..of(&times, 4000) }).unwrap();
    assert_ne!(other.value(0, 7, 0.0), short.value(0, 7, 0.0));
}

#[test]
fn quantised_reports_are_whole_steps_and_lever_arms_turn_with_the_body() {
    let model = ErrorModel { quantisation: [0.5, 0.25, 0.01], ..ErrorModel::default() };
    let (tracks, times, start) = flight(&model, 10.0, 100);
    for n in 0..100 {
        let reported_now = tracks.reported.state(times.emission(start, n)).unwrap();
        let whole = |x: f64, step: f64| assert!((x / step - (x / step).round()).abs() < 1e-9, "{x} {step}");
        reported_now.position.to_array().iter().for_each(|x| whole(*x, 0.5));
        reported_now.velocity.to_array().iter().for_each(|x| whole(*x, 0.25));
        reported_now.attitude.to_yaw_pitch_roll().iter().for_each(|x| whole(*x, 0.01));
    }
    let model = ErrorModel { lever_arm_error: Vector::new(2.0, 0.0, 0.0), ..ErrorModel::default() };
    let (tracks, _, start) = flight(&model, 10.0, 100);
    let offset = tracks.reported.state(start).unwrap().position - tracks.truth.state(start).unwrap().position;
    // Forward is along the velocity.
    let ahead = Vector::new(120.0, -60.0, 1.0);
    assert!((offset.dot(ahead) / ahead.norm() - 2.0).abs() < 1e-9 && (offset.norm() - 2.0).abs() < 1e-9);
}

fn nav(errors: ErrorModel) -> PlatformNav {
    let place = nereus::nav::Place::Local(Point::new(0.0, 0.0, 0.0));
    let attitude = Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0);
    PlatformNav {
        truth: TrackSource::Fixed { place, attitude },
        reported: None,
        errors: Some(errors),
        gusts: None,
    }
}

#[test]
fn a_recorded_report_leaves_the_truth_beside_it() {
    let mut model = ErrorModel { recorded: Recorded::Reported, ..ErrorModel::default() };
    (model.axes[0].sinusoid, model.axes[0].sinusoid_hz) = (2.0, 0.5);
    (model.axes[1].gm_sigma, model.axes[1].gm_tau_s, model.axes[1].bias) = (0.5, 20.0, 3.0);
    model.axes[ATTITUDE].sinusoid = 0.05;
    model.axes[ATTITUDE].sinusoid_hz = 0.2;
    let times = PulseTimes::uniform(222.0).unwrap();
    let start = TimeTag::new(1_700_000_000, 0.0);
    let track = Track::straight(Point::new(0.0, 0.0, 3000.0), start, Vector::new(0.0, 100.0, 0.0), None);
    let frame = nereus::frames::SceneFrame::plain(nereus::frames::Earth::Flat);
    let of = of(&times, 22_200);
    let both = PlatformTracks::of(track.clone(), None, &nav(model), &frame, &of, start).unwrap();
    let mut north = Vec::new();
    for n in (0..22_200).step_by(111) {
        // Between nodes, where third derivatives do not jump.
        let t = times.emission(start, n).plus(0.217);
        let t_s = n as f64 / 222.0 + 0.217;
        assert_eq!(both.reported.state(t).unwrap(), track.state(t).unwrap());
        let (reported_now, truth) = (track.state(t).unwrap(), both.truth.state(t).unwrap());
        let error = reported_now.position - truth.position;
        let wanted = 2.0 * (std::f64::consts::TAU * 0.5 * t_s).sin();
        assert!((error.to_array()[0] - wanted).abs() < 1e-9, "{error:?}");
        north.push(error.to_array()[1] - 3.0);
        // Velocity, acceleration and angular rate are derivatives of what is there: third derivatives times
        // h^2/6, and rounding of 1e4 m over h.
        let h = 1e-3;
        let [before, after] = [-h, h].map(|d| both.truth.state(t.plus(d)).unwrap());
        let slope = (after.position - before.position) * (0.5 / h);
        assert!((slope - truth.velocity).norm() < 1e-4, "{:?}", slope - truth.velocity);
        let bend = (after.velocity - before.velocity) * (0.5 / h);
        assert!((bend - truth.acceleration).norm() < 1e-3);
        let roll = |s: &nereus::motion::State| s.attitude.to_yaw_pitch_roll()[2];
        let rolling = (roll(&after) - roll(&before)) * (0.5 / h);
        let along = truth.angular_rate.dot(truth.attitude * Vector::new(1.0, 0.0, 0.0));
        assert!((rolling - along).abs() < 1e-6, "{rolling} {along}");
    }
    // Twenty correlation times: the deviation is there, of the size asked.
    let rms = (north.iter().map(|x| x * x).sum::<f64>() / north.len() as f64).sqrt();
    assert!((0.1..1.5).contains(&rms), "{rms}");
}

type Change = fn(&mut ErrorModel);

#[test]
fn jumps_of_the_truth_are_refused() {
    let jumpy: [(&str, Change); 5] = [
        ("white noise", |m| m.axes[0].white = 1.0),
        ("a step", |m| m.axes[0].step = 1.0),
        ("quantisation", |m| m.quantisation[0] = 1.0),
        ("an error of the lever arm", |m| m.lever_arm_error = Vector::new(1.0, 0.0, 0.0)),
        ("an error of the velocity (it follows from the position)", |m| m.axes[VELOCITY].bias = 1.0),
    ];
    for (reported, change) in jumpy {
        let mut model = ErrorModel { recorded: Recorded::Reported, ..ErrorModel::default() };
        change(&mut model);
        assert_eq!(model.check(), Err(ErrorsFault::NotSmooth { what: reported }));
    }
}

#[test]
fn series_have_a_limit() {
    let times = PulseTimes::uniform(1e6).unwrap();
    let mut model = ErrorModel::default();
    model.axes[0].white = 1.0;
    let error = Errors::new(&model, &of(&times, 100_000_000)).unwrap_err();
    assert!(matches!(error, ErrorsFault::TooLong { values: 100_000_004, .. }), "{error}");
    // Known errors alone take nothing, at any rate.
    model.axes[0] = nereus::motion::errors::AxisErrors { bias: 1.0, ..Default::default() };
    assert!(Errors::new(&model, &of(&times, u64::MAX / 2)).is_ok());
}

proptest! {
    #![proptest_config(crate::cases::proptests(24))]

    #[test]
    fn every_legal_report_is_finite(
        seed: u64, rate in 0.0f64..1e3, latency in 0.0f64..60.0, jitter in 0.0f64..10.0,
        per_hour in 0.0f64..1e6, mean_s in 1e-6f64..1e6, sigma in 0.0f64..1e6, tau in 1e-9f64..1e7, hz in 0.0f64..1e4,
        bias in -360f64..360.0, pitch in -1.6f64..1.6, n in 0u64..50,
    ) {
        let dropouts = Dropouts { per_hour, mean_s, during: Between::Hold };
        let mut model = ErrorModel {
            rate_hz: (rate > 0.01).then_some(rate), latency_s: latency, jitter_s: jitter, dropouts: Some(dropouts),
            ..ErrorModel::default()
        };
        for axis in &mut model.axes {
            (axis.gm_sigma, axis.gm_tau_s, axis.walk, axis.white) = (sigma, tau, sigma, sigma);
            (axis.sinusoid, axis.sinusoid_hz, axis.bias, axis.step, axis.ramp) = (sigma, hz, bias, bias, bias);
        }
        let times = PulseTimes::uniform(10.0).unwrap();
        let start = TimeTag::new(1_700_000_000, 0.0);
        let base = Track::straight(
            Point::new(1e8, -1e8, 1e8), start, Vector::new(2e4, 0.0, 0.0),
            Some(Rotation::from_yaw_pitch_roll(3.0, pitch, -3.0)),
        );
        let of = Circumstances { seed, platform: 3, times: &times, pulses: 50, before_s: 100.0 };
        let reported = base.with_errors(&model, &of, start).unwrap();
        for t in [times.emission(start, n), start.plus(-100.0), start.plus(1e6)] {
            let reported_now = reported.report(t).unwrap();
            let s = reported_now.state;
            prop_assert!(reported_now.age_s.is_finite() && reported_now.age_s >= 0.0);
            let q = s.attitude.to_wxyz();
            for x in s.position.to_array().iter().chain(&s.velocity.to_array()).chain(&s.angular_rate.to_array()).chain(&q) {
                prop_assert!(x.is_finite());
            }
        }
    }
}
