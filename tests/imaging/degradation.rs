//! What wrong navigation makes of a point: predictions against closed forms, and against images.

use nereus::geometry::phase_path::PhasePath;
use nereus::motion::errors::{AxisErrors, Circumstances, ErrorModel, Errors};
use nereus::processor::backproject::{Aperture, fast};
use nereus::processor::degradation::laws::{
    gauss_markov_db, paired_echoes, ramp_cells, step_amplitude, step_peak, white_db,
};
use nereus::processor::degradation::{Degradation, PhaseTerms, Prediction, Response, respond};
use nereus::processor::point_target::Support;
use nereus::processor::range_compress::RangeFilter;
use nereus::processor::taper::Taper;
use nereus::recording::Recording;
use nereus::recording::ground::Ground;
use nereus::time::PulseTimes;
use num_complex::Complex64;

use crate::geometries::{BAND_HZ, C_MPS, CARRIER_HZ, GEOMETRIES, TARGET_M, aperture, compressor, record};

const PULSES: usize = 256;
const PRF_HZ: f64 = 128.0;
/// Two seconds.
const APERTURE_S: f64 = PULSES as f64 / PRF_HZ;
const LAMBDA_M: f64 = C_MPS / CARRIER_HZ;

fn times_s() -> Vec<f64> {
    (0..PULSES).map(|i| i as f64 / PRF_HZ).collect()
}

/// 50 m/s past a point 42 km away: the line of sight turns by 2.4e-3 rad over the aperture, so that closed
/// forms for one that does not turn hold to 1e-5.
fn far(error_m: impl Fn(f64) -> [f64; 3]) -> PhasePath {
    let at = |t: f64| {
        let e = error_m(t);
        [50.0 * (t - 1.0) + e[0], -30e3 + e[1], 30e3 + e[2]]
    };
    PhasePath::new(times_s(), times_s().into_iter().map(at).collect()).unwrap()
}

/// Errors are those of the transmitter, upwards: its path to a point at the origin is longer by cos 45.
const SIGHT: f64 = std::f64::consts::FRAC_1_SQRT_2;

fn degraded<T>(error_m: impl Fn(f64) -> [f64; 3], taper: Taper, then: impl FnOnce(&Degradation) -> T) -> T {
    let (truth, reported, times_s) = (far(|_| [0.0; 3]), far(error_m), times_s());
    let weights: Vec<f64> =
        (0..PULSES).map(|i| taper.weight((i as f64 + 0.5) / PULSES as f64 - 0.5)).collect();
    then(&Degradation {
        carrier_hz: CARRIER_HZ,
        bandwidth_hz: BAND_HZ,
        taper: Taper::Uniform,
        times_s: &times_s,
        weights: &weights,
        truth: [&truth; 2],
        reported: [&reported, &truth],
    })
}

fn predicted(error_m: impl Fn(f64) -> [f64; 3], taper: Taper) -> Prediction {
    degraded(error_m, taper, |degradation| degradation.predict([0.0; 3]).unwrap())
}

/// Error of the transmitter's height that makes such a phase.
fn height_m(phase_rad: f64) -> f64 {
    phase_rad * LAMBDA_M / (std::f64::consts::TAU * SIGHT)
}

#[test]
fn no_error_is_exactly_nothing() {
    let found = predicted(|_| [0.0; 3], Taper::Uniform);
    assert_eq!((found.loss_db, found.shift_cells, found.width_ratio), (0.0, [0.0; 2], [1.0; 2]));
    assert_eq!(found.terms, PhaseTerms::default());
    assert_eq!(found.fitted_m, [0.0; 3]);
    // The phase is that of the place found, which rounding moves by 1e-14 cells.
    assert!(found.phase_rad.abs() < 1e-12, "{}", found.phase_rad);
    // And the point is that of theory: a sinc of both bands.
    for (cut, lobe) in found.response.cuts.iter().zip([-13.26, -13.26]) {
        assert!((cut.width_m / cut.cell_m - 0.8859).abs() < 2e-4, "{}", cut.width_m / cut.cell_m);
        assert!(
            cut.lobes.iter().flatten().all(|found| (found.level_db - lobe).abs() < 0.01),
            "{:?}",
            cut.lobes
        );
    }
}

#[test]
fn a_sinusoid_raises_paired_echoes() {
    // From 1.43 rad on the first pair is higher than the main lobe.
    for beta in [0.2, 0.4446, 1.0, 1.3] {
        for phase in [0.0f64, 1.0] {
            // Nine cells away. Hann's side lobes are zero at whole cells, so that the main lobe leaves the
            // level of the echoes alone.
            let law = paired_echoes(beta, 4.5, APERTURE_S);
            let error = |t: f64| [0.0, 0.0, height_m(beta) * (std::f64::consts::TAU * 4.5 * t + phase).sin()];
            let found = predicted(error, Taper::Hann);
            let cut = &found.response.cuts[1];
            println!("beta {beta}: {law:?}; loss {:.4} dB, {:?}", found.loss_db, cut.lobes);
            // 1e-3 of an amplitude is 0.009 dB; pairs behind the first one add their skirts to it.
            assert!((found.loss_db + law.main_db).abs() < 2e-3, "{} {}", found.loss_db, law.main_db);
            // Skirts of the main lobe and of the second pair pass through zero there, with slopes of J0 and
            // J2 over n (n^2 - 1), against a top that bends by 1.13 J1: that moves the top.
            let moved = (bessel(0, beta) + bessel(2, beta)) / bessel(1, beta) / (9.0 * 80.0) / 1.13;
            for lobe in cut.lobes.iter().flatten() {
                assert!((lobe.level_db - law.level_db).abs() < 0.02, "{lobe:?} {law:?}");
                assert!(
                    (lobe.cells.abs() - law.distance_cells).abs() < 1.2 * moved + 1e-3,
                    "{lobe:?} {moved}"
                );
            }
            assert!(found.shift_cells.iter().all(|cells| cells.abs() < 2e-3), "{:?}", found.shift_cells);
        }
    }
}

/// Bessel function of a small argument by its power series.
fn bessel(order: i32, x: f64) -> f64 {
    let mut term: f64 = (1..=order).map(|k| 0.5 * x / f64::from(k)).product();
    let mut sum = 0.0;
    for k in 1..30 {
        sum += term;
        term *= -0.25 * x * x / f64::from(k * (k + order));
    }
    sum
}

#[test]
fn a_ramp_moves_and_a_bias_moves() {
    for climb_mps in [1e-3, 0.02, -0.3, 2.0] {
        let found = predicted(|t| [0.0, 0.0, climb_mps * (t - 1.0)], Taper::Uniform);
        let law = ramp_cells(climb_mps * SIGHT, APERTURE_S, LAMBDA_M);
        println!(
            "{climb_mps} m/s: {:+.4} cells, law {law:+.4}; loss {:.1e} dB",
            found.shift_cells[1], found.loss_db
        );
        // The path runs through the gate by 0.9 cells at 2 m/s: sinc^2 over the aperture.
        assert!((found.shift_cells[1] / law - 1.0).abs() < 1e-3, "{:?} {law}", found.shift_cells);
        assert!((found.terms.linear_cells / law - 1.0).abs() < 1e-3);
        assert!(found.loss_db.abs() < 1e-3 + 2.0 * climb_mps * climb_mps, "{}", found.loss_db);
    }
    // Both ends moved along the plane move the image by just that, however far.
    for bias_m in [[3.0, 0.0, 0.0], [0.0, -2.0, 0.0], [-40.0, 25.0, 0.0]] {
        let (truth, reported, times_s) = (far(|_| [0.0; 3]), far(|_| bias_m), times_s());
        let degradation = Degradation {
            carrier_hz: CARRIER_HZ,
            bandwidth_hz: BAND_HZ,
            taper: Taper::Uniform,
            times_s: &times_s,
            weights: &[1.0; PULSES],
            truth: [&truth; 2],
            reported: [&reported; 2],
        };
        let found = degradation.predict([0.0; 3]).unwrap();
        let off = (0..3).map(|k| (found.response.place_m[k] - bias_m[k]).abs()).fold(0.0, f64::max);
        println!("bias {bias_m:?}: off by {off:.1e} m, loss {:.1e} dB", found.loss_db);
        assert!(off < 1e-3 && found.loss_db.abs() < 1e-6, "{off} {}", found.loss_db);
    }
    // A constant on one end alone: a length, -e B/c of range.
    let found = predicted(|_| [0.0, 0.0, 1.0], Taper::Uniform);
    let law = -SIGHT * BAND_HZ / C_MPS;
    assert!((found.shift_cells[0] / law - 1.0).abs() < 1e-3 && found.loss_db.abs() < 1e-3, "{found:?}");
}

#[test]
fn a_step_splits_the_main_lobe() {
    for phase in [0.3, 1.482, -1.482, 2.5] {
        let found = predicted(
            |t| [0.0, 0.0, if t < 1.0 - 0.5 / PRF_HZ { 0.0 } else { height_m(phase) }],
            Taper::Uniform,
        );
        let (peak, level_db) = step_peak(phase);
        // The middle between the half-power points of the closed form.
        let half = 10f64.powf(0.05 * level_db) * 0.5f64.sqrt();
        let edge = |side: f64| {
            let (mut inside, mut outside) = (peak, peak + side);
            for _ in 0..60 {
                let middle = 0.5 * (inside + outside);
                if step_amplitude(phase, middle) > half { inside = middle } else { outside = middle }
            }
            inside
        };
        let law = 0.5 * (edge(-1.0) + edge(1.0));
        println!(
            "{phase} rad: loss {:.4} dB, law {:.4}; {:+.4} cells, law {law:+.4} (top {peak:+.4})",
            found.loss_db, -level_db, found.shift_cells[1]
        );
        assert!((found.loss_db + level_db).abs() < 5e-3, "{} {level_db}", found.loss_db);
        assert!((found.shift_cells[1] - law).abs() < 2e-3, "{:?} {law}", found.shift_cells);
        assert!(
            (found.terms.mean_cells + phase * BAND_HZ / CARRIER_HZ / (2.0 * std::f64::consts::TAU)).abs()
                < 1e-4
        );
    }
}

#[test]
fn a_bend_is_a_quadratic_phase() {
    // Quadratic phase of q at the ends: |int_0^1 e^{j q x^2} dx|, by its power series.
    for q in [0.5, 1.0, std::f64::consts::FRAC_PI_2] {
        let (mut sum, mut term) = (Complex64::ZERO, Complex64::ONE);
        for k in 0..40 {
            sum += term / f64::from(2 * k + 1);
            term *= Complex64::new(0.0, q) / f64::from(k + 1);
        }
        let found = predicted(|t| [0.0, 0.0, height_m(q) * (t - 1.0 + 0.5 / PRF_HZ).powi(2)], Taper::Uniform);
        println!(
            "{q:.3} rad: {:.4} dB, series {:.4}; {:?}",
            found.loss_db,
            -20.0 * sum.norm().log10(),
            found.terms
        );
        assert!((found.loss_db + 20.0 * sum.norm().log10()).abs() < 2e-3);
        assert!((found.terms.quadratic_rad / q - 1.0).abs() < 1e-3 && found.terms.rest_rad < 1e-3 * q);
    }
}

/// Mean power at the place expected over seeds, and its standard error, of errors as reports have them.
fn ensemble(axis: AxisErrors, seeds: u64) -> (f64, f64) {
    let times = PulseTimes::uniform(PRF_HZ).unwrap();
    let model = ErrorModel {
        axes: std::array::from_fn(|i| if i == 2 { axis } else { AxisErrors::default() }),
        ..ErrorModel::default()
    };
    let power = |seed: u64| {
        let of = Circumstances { seed, platform: 0, times: &times, pulses: PULSES as u64, before_s: 0.0 };
        let errors = Errors::new(&model, &of).unwrap();
        let error = |t: f64| [0.0, 0.0, errors.value(2, (t * PRF_HZ).round() as i64, t)];
        degraded(error, Taper::Uniform, |degradation| degradation.amplitude([0.0; 3], [0.0; 3]).norm_sqr())
    };
    let powers: Vec<f64> = (0..seeds).map(power).collect();
    let n = seeds as f64;
    let mean = powers.iter().sum::<f64>() / n;
    let variance = powers.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

#[test]
fn noise_costs_on_average_what_its_covariance_predicts() {
    for (sigma, tau_s) in [(0.4446, 0.2), (1.0, 0.05), (1.0, 2.0)] {
        let axis = AxisErrors { gm_sigma: height_m(sigma), gm_tau_s: tau_s, ..AxisErrors::default() };
        let (mean, error) = ensemble(axis, 300);
        let law = 10f64.powf(0.1 * gauss_markov_db(sigma, tau_s, APERTURE_S));
        println!("Gauss-Markov {sigma} rad, {tau_s} s: {mean:.4} +- {error:.4}, law {law:.4}");
        assert!((mean - law).abs() < 3.0 * error && error < 0.03, "{mean} {error} {law}");
        // Another correlation time is another law.
        let other = 10f64.powf(0.1 * gauss_markov_db(sigma, 10.0 * tau_s, APERTURE_S));
        assert!((mean - other).abs() > 3.0 * error, "{mean} {error} {other}");
    }
    for sigma in [0.3, 1.0] {
        let (mean, error) = ensemble(AxisErrors { white: height_m(sigma), ..AxisErrors::default() }, 300);
        let coherent = 10f64.powf(0.1 * white_db(sigma));
        // Of M pulses the rest adds up as power.
        let law = coherent + (1.0 - coherent) / PULSES as f64;
        println!("white {sigma} rad: {mean:.4} +- {error:.4}, law {law:.4}");
        assert!((mean - law).abs() < 3.0 * error && error < 0.01, "{mean} {error} {law}");
    }
}

#[test]
fn short_and_long_correlation_have_their_limits() {
    // Long: one phase for all, nothing lost. Short: white, 2 tau/T of power for every rad^2 remain.
    assert!(gauss_markov_db(1.0, 1e6, 1.0).abs() < 1e-5);
    assert!((gauss_markov_db(1.0, 1e-6, 1.0) - white_db(1.0)).abs() < 1e-4);
    // First order in sigma^2: -2 sigma^2 (1/2 - (r - 1 + e^-r)/r^2), r = T/tau.
    let (sigma, r): (f64, f64) = (1e-3, 10.0);
    let law =
        -10.0 * std::f64::consts::LOG10_E * sigma * sigma * (1.0 - 2.0 * (r - 1.0 + (-r).exp()) / (r * r));
    assert!((gauss_markov_db(sigma, 0.1, 1.0) / law - 1.0).abs() < 1e-5);
}

#[test]
fn what_cannot_be_predicted_is_not() {
    // One pulse has no cross-range.
    let path = PhasePath::new(vec![0.0], vec![[0.0, -3000.0, 3000.0]]).unwrap();
    let degradation = Degradation {
        carrier_hz: CARRIER_HZ,
        bandwidth_hz: BAND_HZ,
        taper: Taper::Uniform,
        times_s: &[0.0],
        weights: &[1.0],
        truth: [&path; 2],
        reported: [&path; 2],
    };
    assert_eq!(degradation.predict([0.0; 3]), None);
    assert_eq!(Degradation { times_s: &[], weights: &[], ..degradation }.predict([0.0; 3]), None);
    assert_eq!(PhaseTerms::of(&[], CARRIER_HZ, BAND_HZ), PhaseTerms::default());
    // A report that is no number makes no path.
    let refused = PhasePath::new(vec![0.0, 1.0], vec![[0.0; 3], [f64::NAN, 0.0, 0.0]]).unwrap_err();
    assert!(refused.to_string().contains("row 1 of the recording"), "{refused}");
    // Kilometres of error: a place, or none; never no number.
    for bias_m in [1e3, 1e5, 1e8] {
        if let Some(found) = degraded(
            |t| [bias_m * t, bias_m, -bias_m],
            Taper::Uniform,
            |degradation| degradation.predict([0.0; 3]),
        ) {
            assert!(
                found.loss_db.is_finite() && found.shift_cells.iter().all(|x| x.is_finite()),
                "{found:?}"
            );
        }
    }
    // Noise of many radians leaves no main lobe, or a poor one.
    let wild = degraded(
        |t| [0.0, 0.0, (1e4 * t * t).sin()],
        Taper::Uniform,
        |degradation| degradation.predict([0.0; 3]),
    );
    assert!(wild.is_none_or(|found| found.loss_db > 6.0));
}

struct Measured {
    loss_db: f64,
    shift_cells: [f64; 2],
    wrong: Response,
    phase_rad: f64,
}

fn measure(recording: &Recording, name: &str) -> (Prediction, Measured) {
    let truth = [recording.true_path("t").unwrap(), recording.true_path("r").unwrap()];
    let reported = ["t", "r"].map(|antenna| recording.reported_path(antenna).unwrap());
    let compressor = compressor(recording, RangeFilter::Flat, Taper::Taylor);
    let weigh = |mut aperture: Aperture<'_>| -> Vec<f64> {
        let count = aperture.pulses.len() as f64;
        for (i, pulse) in aperture.pulses.iter_mut().enumerate() {
            pulse.weight = Taper::Taylor.weight((i as f64 + 0.5) / count - 0.5);
        }
        aperture.pulses.iter().map(|pulse| pulse.weight).collect()
    };
    let weights = weigh(aperture(recording, &compressor, [&truth[0], &truth[1]], 3));
    let [by_truth, by_report] = [&truth, &reported].map(|paths| {
        let mut aperture = aperture(recording, &compressor, [&paths[0], &paths[1]], 3);
        for (pulse, weight) in aperture.pulses.iter_mut().zip(&weights) {
            pulse.weight = *weight;
        }
        aperture
    });
    let times_s: Vec<f64> = recording.emission_s.iter().map(|t| t + compressor.middle_s()).collect();
    let degradation = Degradation {
        carrier_hz: CARRIER_HZ,
        bandwidth_hz: BAND_HZ,
        taper: Taper::Taylor,
        times_s: &times_s,
        weights: &weights,
        truth: [&truth[0], &truth[1]],
        reported: [&reported[0], &reported[1]],
    };
    let prediction = degradation.predict(TARGET_M).unwrap_or_else(|| panic!("{name}: nothing predicted"));
    let images = |aperture: &Aperture, grounds: &[Ground]| -> Vec<Vec<Complex64>> {
        let wide = |z: &num_complex::Complex32| Complex64::new(z.re.into(), z.im.into());
        fast(aperture, grounds, &|_| ()).iter().map(|image| image.iter().map(wide).collect()).collect()
    };
    let cells = Support::of(&by_truth, TARGET_M).unwrap();
    let right = respond(&|grounds| images(&by_truth, grounds), &cells, TARGET_M).unwrap();
    let support = Support::of(&by_report, prediction.fitted_m).unwrap();
    let wrong = respond(&|grounds| images(&by_report, grounds), &support, prediction.fitted_m).unwrap();
    let at =
        |aperture: &Aperture, place: [f64; 3]| images(aperture, &[Ground::line(place, [0.0; 3], 1)])[0][0];
    let turned = at(&by_report, prediction.response.place_m) * at(&by_truth, TARGET_M).conj();
    let moved: [f64; 2] = std::array::from_fn(|k| wrong.place_m[k] - right.place_m[k]);
    let measured = Measured {
        loss_db: -20.0 * (wrong.amplitude / right.amplitude).log10(),
        shift_cells: cells.cells(moved),
        wrong,
        phase_rad: turned.arg(),
    };
    (prediction, measured)
}

#[test]
fn images_are_as_predicted_for_every_kind_of_error() {
    let kinds = [
        ("sinusoid", 0, "position = { sinusoid_m = [0.0, 0.0, 1.5e-3], sinusoid_hz = 25.0 }"),
        ("step", 0, "position = { step_m = [0.0, 0.0, 5e-3], step_at_s = 0.119 }"),
        ("ramp", 0, "position = { ramp_mps = [0.3, 0.0, 0.15] }"),
        ("bias", 0, "position = { bias_m = [3.0, -5.0, 2.0] }"),
        ("white", 0, "position = { white_m = [0.0, 0.0, 2e-3] }"),
        ("Gauss-Markov", 0, "position = { gm_sigma_m = [1e-3, 1e-3, 2e-3], gm_tau_s = 0.03 }"),
        (
            "late and seldom",
            0,
            "rate_hz = 50.0\nlatency_s = 0.02\nvelocity = { white_mps = [0.0, 0.0, 0.08] }",
        ),
        ("lever arm", 0, "lever_arm_error_m = [0.5, 1.0, 0.3]"),
        ("transmitter", 3, "position = { bias_m = [3.0, 4.0, 1.0] }"),
        ("many cells", 0, "position = { bias_m = [0.0, 30.0, 0.0], ramp_mps = [0.0, 0.0, 4.0] }"),
    ];
    for (name, geometry, errors) in kinds {
        let geometry = &GEOMETRIES[geometry];
        let plain = geometry.scenario("", [[0.0; 3]; 2]);
        let with = format!("\n[platform.errors]\n{errors}\n");
        // One aircraft carries both ends; on the coast only the transmitter is uncertain.
        let scenario = if name == "transmitter" {
            plain.replace("\n[[platform]]\nname = \"b\"", &format!("{with}[[platform]]\nname = \"b\""))
        } else {
            plain
                .replace("\n[[platform]]\nname = \"b\"", &format!("{with}[[platform]]\nname = \"b\""))
                .replace("\n[[transmitter]]", &format!("{with}[[transmitter]]"))
        };
        assert_ne!(scenario, plain);
        let recording = record(&scenario);
        let (predicted, found) = measure(&recording, name);
        let (p, m) = (&predicted.response.cuts[1], &found.wrong.cuts[1]);
        println!(
            "{name}: loss {:.4} {:.4} dB; range {:+.4} {:+.4}, cross-range {:+.4} {:+.4} cells; widths {:.4} {:.4} m; {:?} {:?}; {:+.4} {:+.4} rad",
            predicted.loss_db,
            found.loss_db,
            predicted.shift_cells[0],
            found.shift_cells[0],
            predicted.shift_cells[1],
            found.shift_cells[1],
            p.width_m,
            m.width_m,
            p.highest(),
            m.highest(),
            predicted.phase_rad,
            found.phase_rad
        );
        // What was asked: 0.1 dB, a fiftieth of a cell, 0.3 dB and a twentieth of a cell.
        assert!((predicted.loss_db - found.loss_db).abs() < 0.1, "{name}");
        for (a, b) in predicted.shift_cells.iter().zip(found.shift_cells) {
            assert!((a - b).abs() < 0.02, "{name}: {a} {b}");
        }
        assert!((p.width_m / m.width_m - 1.0).abs() < 0.01, "{name}");
        let (a, b) = (p.highest().unwrap(), m.highest().unwrap());
        assert!(
            (a.level_db - b.level_db).abs() < 0.3 && (a.cells.abs() - b.cells.abs()).abs() < 0.05,
            "{name}: {a:?} {b:?}"
        );
        let turned = (predicted.phase_rad - found.phase_rad).rem_euclid(std::f64::consts::TAU);
        assert!(turned.min(std::f64::consts::TAU - turned) < 0.05, "{name}: {turned}");
        // Errors do something, or the test is none.
        let moved = predicted.shift_cells.iter().map(|x| x.abs()).fold(0.0, f64::max);
        assert!(predicted.loss_db > 0.1 || moved > 0.1, "{name}: {} {moved}", predicted.loss_db);
    }
}
