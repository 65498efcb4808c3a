//! Kochin function and wave resistance against golden rows, the closed form of Wigley's hull, and Michell's
//! integral.

use nereus::scene::hull::Hull;
use nereus::sea::GRAVITY_MPS2;
use nereus::sea::wake::kochin::{
    Kochin, KochinError, LARGEST_WAVE_NUMBER_RADPM, LEAST_SPEED_MPS, MOST_SPEED_MPS, Transom,
    resistance_coefficient,
};
use num_complex::Complex64;
use proptest::prelude::*;

use crate::quadrature::unit_interval;
use crate::sea_golden::{Judge, rows};

const DENSITY_KGPM3: f64 = 1000.0;

fn wigley([length_m, beam_m, draught_m]: [f64; 3]) -> Hull {
    Hull::wigley(length_m, beam_m, draught_m).unwrap()
}

/// The usual proportions: B/L = 0.1, T/L = 0.0625.
fn standard(length_m: f64) -> Hull {
    wigley([length_m, 0.1 * length_m, 0.0625 * length_m])
}

fn at(hull: &Hull, speed_mps: f64) -> Kochin {
    Kochin::new(hull, speed_mps, Transom::Open).unwrap()
}

/// `Fz` of Wigley's hull in closed form (docs/physics.md section 9.2), by quadrature where the closed form
/// loses digits.
fn depthwise_m(draught_m: f64, k_radpm: f64) -> f64 {
    let at = k_radpm * draught_m;
    if at < 0.5 {
        return unit_interval(4, |s| Complex64::new(draught_m * (1.0 - s * s) * (-at * s).exp(), 0.0)).re;
    }
    let (a, t) = (k_radpm, draught_m);
    1.0 / a - 2.0 / (a.powi(3) * t * t) + (-at).exp() * (2.0 / (a * a * t) + 2.0 / (a.powi(3) * t * t))
}

/// `P` of Wigley's hull.
fn closed_form_m3([length_m, beam_m, draught_m]: [f64; 3], k_radpm: f64, kappa_radpm: f64) -> f64 {
    let u = 0.5 * kappa_radpm * length_m;
    let lengthwise_m = if u < 0.5 {
        unit_interval(4, |s| Complex64::new(length_m * (1.0 - s * s) * (u * s).cos(), 0.0)).re
    } else {
        2.0 * length_m * (u.sin() - u * u.cos()) / u.powi(3)
    };
    0.5 * beam_m * depthwise_m(draught_m, k_radpm) * lengthwise_m
}

#[test]
fn kochin_function_is_the_golden_one() {
    let table = rows("wake_kochin.csv");
    // Near a zero of P the scale is the largest of the hull and speed.
    let key = |row: &crate::sea_golden::Row| ["L", "B", "T", "V"].map(|column| row.get(column));
    let largest = |row, column| {
        let same = table.iter().filter(|other| key(other) == key(row));
        same.map(|other| other.get(column).abs()).fold(0.0, f64::max)
    };
    // The tolerance of the golden file.
    let mut judge = Judge::new("wake_kochin", 1e-9);
    for row in &table {
        let [length_m, beam_m, draught_m, speed_mps] = key(row);
        let ship = at(&wigley([length_m, beam_m, draught_m]), speed_mps);
        let t = row.get("theta_deg").to_radians().tan();
        let (found, amplitude) = (ship.kochin_m3(t), ship.amplitude_m(t));
        let (scale_m3, scale_m) = (largest(row, "P_m3"), largest(row, "A_im_m"));
        judge.compare_at(row, "P_m3", found.re, scale_m3);
        judge.compare_at(row, "Q_m3", found.im, scale_m3);
        judge.compare_at(row, "A_re_m", amplitude.re, scale_m);
        judge.compare_at(row, "A_im_m", amplitude.im, scale_m);
    }
    judge.verdict();
}

/// Each value by itself, small ones too: |P| falls by seven decades within one ship.
#[test]
fn kochin_function_is_the_golden_one_row_by_row() {
    let mut judge = Judge::new("wake_kochin, each by itself", 1e-9);
    for row in &rows("wake_kochin.csv") {
        let [length_m, beam_m, draught_m, speed_mps] = ["L", "B", "T", "V"].map(|column| row.get(column));
        let ship = at(&wigley([length_m, beam_m, draught_m]), speed_mps);
        let t = row.get("theta_deg").to_radians().tan();
        let (sec, k0) = (t.hypot(1.0), ship.transverse_radpm());
        let u = 0.5 * k0 * sec * length_m;
        // Between zeros P goes as 1/u^2. V is printed in 13 digits, good to 5e-13, and the phase u goes as
        // V^-2: the golden value is that of a phase which is off by 1e-12 u.
        let between_m3 = beam_m * depthwise_m(draught_m, k0 * sec * sec) * length_m / (1.0 + u * u);
        let scale_m3 = row.get("P_m3").abs() + 1e-3 * u * between_m3;
        judge.compare_at(row, "P_m3", ship.kochin_m3(t).re, scale_m3);
        let factor = 2.0 / std::f64::consts::PI * k0 * k0 * sec.powi(4);
        judge.compare_at(row, "A_im_m", ship.amplitude_m(t).im, factor * scale_m3);
    }
    judge.verdict();
}

#[test]
fn resistance_is_the_golden_one() {
    // The tolerance of the golden file.
    let mut judge = Judge::new("wake_resistance", 1e-6);
    for row in &rows("wake_resistance.csv") {
        let [length_m, beam_m, draught_m, speed_mps] = ["L", "B", "T", "V"].map(|column| row.get(column));
        let ship = at(&wigley([length_m, beam_m, draught_m]), speed_mps);
        let resistance_n = ship.wave_resistance_n(DENSITY_KGPM3).unwrap();
        judge.compare(row, "Fn", ship.froude());
        judge.compare(row, "Rw_N_rho1000", resistance_n);
        let surface_m2 = row.get("S_wet_m2");
        judge.compare(row, "Cw", resistance_coefficient(resistance_n, speed_mps, DENSITY_KGPM3, surface_m2));
    }
    judge.verdict();
}

/// Wetted surface of Wigley's hull of unit length, from the closed form of its slopes.
fn wetted_surface([_, beam, draught]: [f64; 3]) -> f64 {
    let skin = |x: f64, z: f64| {
        // x and z in half lengths and draughts, 0 to 1; Y_x with 2/L = 2.
        let (dx, dz) = (beam * 2.0 * x * (1.0 - z * z), beam / draught * z * (1.0 - x * x));
        (1.0 + dx * dx + dz * dz).sqrt()
    };
    let row = |x: f64| unit_interval(16, |z| Complex64::new(skin(x, z), 0.0)).re;
    // Both sides; x from 0 to 1/2, twice.
    2.0 * draught * unit_interval(16, |x| Complex64::new(row(x), 0.0)).re
}

fn standard_cw(froude: f64) -> f64 {
    let speed_mps = froude * GRAVITY_MPS2.sqrt();
    let resistance_n = at(&standard(1.0), speed_mps).wave_resistance_n(DENSITY_KGPM3).unwrap();
    resistance_coefficient(resistance_n, speed_mps, DENSITY_KGPM3, wetted_surface([1.0, 0.1, 0.0625]))
}

/// Cw of docs/physics.md section 9.2, three decimals.
#[test]
fn coefficients_of_the_standard_hull() {
    // S/[L(2T + B)] = 0.6613, four decimals.
    assert!((wetted_surface([1.0, 0.1, 0.0625]) / 0.225 - 0.6613).abs() <= 0.5e-4);
    for (froude, thousandths) in [
        (0.20, 0.888),
        (0.25, 1.064),
        (0.267, 0.976),
        (0.289, 1.987),
        (0.30, 2.142),
        (0.316, 1.831),
        (0.35, 1.248),
        (0.40, 2.734),
        (0.408, 3.030),
        (0.50, 4.517),
        (0.60, 3.918),
    ] {
        let found = 1e3 * standard_cw(froude);
        assert!((found - thousandths).abs() <= 0.5e-3 + 1e-9, "Fn {froude}: {found}, {thousandths}");
    }
}

/// The curve that was computed apart, 101 Froude numbers. Its quadrature ends at tan theta = 60; it agrees
/// with a third code within 0.09 percent. 0.5 percent is asked; the two agree far better.
#[test]
fn the_curve_of_resistance_is_that_of_another_code() {
    let path = format!("{}/tests/data/hulls/wigley_michell_cw.csv", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let (mut worst, mut count) = ((0.0, 0.0), 0);
    for line in text.lines().skip(1) {
        let [froude, cw, _] = line.split(',').map(|x| x.parse::<f64>().unwrap()).collect::<Vec<_>>()[..]
        else {
            panic!("{line}")
        };
        let error = (standard_cw(froude) / cw - 1.0).abs();
        assert!(error < 5e-3, "Fn {froude}: {error:e}");
        worst = if error > worst.0 { (error, froude) } else { worst };
        count += 1;
    }
    println!("{count} Froude numbers, worst {:.1e} at {}", worst.0, worst.1);
    assert!(count > 100 && worst.0 < 1e-5);
}

/// `R = 4 rho g^2/(pi V^2) int_0^{pi/2} (I^2 + J^2) sec^3 theta dtheta`, I + jJ the slope form, here with the
/// closed form over the depth, quadrature over the length and the substitution sec theta = cosh u: nothing is
/// shared with the library.
#[test]
fn resistance_is_michells() {
    let (length_m, beam_m, draught_m) = (100.0, 10.0, 6.25);
    for froude in [0.25, 0.316, 0.4] {
        let speed_mps = froude * (GRAVITY_MPS2 * length_m).sqrt();
        let k0 = GRAVITY_MPS2 / (speed_mps * speed_mps);
        let integrand = |u: f64| {
            let (kappa, k) = (k0 * u.cosh(), k0 * u.cosh().powi(2));
            let depthwise = depthwise_m(draught_m, k);
            // Y_x = -4 B x/L^2, x = L s/2; even parts vanish: J alone, twice the half hull.
            let panels = 2 + (0.5 * kappa * length_m / 4.0) as usize;
            let slope =
                unit_interval(panels, |s| Complex64::new(s * (0.5 * kappa * length_m * s).sin(), 0.0)).re;
            let j = depthwise * (-2.0 * beam_m / length_m) * length_m * slope;
            j * j * u.cosh().powi(2)
        };
        // sec^3 dtheta = cosh^2 u du. The integrand falls as exp(-4u): 5e-11 at u = 6.
        let integral = 6.0 * unit_interval(400, |s| Complex64::new(integrand(6.0 * s), 0.0)).re;
        let michell_n = 4.0 * DENSITY_KGPM3 * GRAVITY_MPS2.powi(2)
            / (std::f64::consts::PI * speed_mps * speed_mps)
            * integral;
        let found_n = at(&standard(length_m), speed_mps).wave_resistance_n(DENSITY_KGPM3).unwrap();
        let error = (found_n / michell_n - 1.0).abs();
        println!("Fn {froude}: {found_n:.3} N, Michell {michell_n:.3} N, {error:.1e}");
        // The 8-point rule resolves 10 rad a panel to some percent, which is reached at u = 4.7, where 1e-8
        // is left.
        assert!(error < 1e-8);
    }
}

#[test]
fn any_grid_of_the_parabolic_hull_is_exact() {
    let dimensions_m = [80.0, 9.0, 4.0];
    let [length_m, beam_m, draught_m] = dimensions_m;
    // Uneven panels, nodes off the middle, stations measured from the bow.
    let stations = [0.0, 0.1, 0.15, 0.3, 0.5, 0.55, 0.6, 0.85, 1.0];
    let waterlines = [-1.0, -0.7, -0.3, -0.1, 0.0];
    let half: Vec<f64> = stations
        .iter()
        .flat_map(|x| waterlines.iter().map(move |z| 0.5 * beam_m * 4.0 * x * (1.0 - x) * (1.0 - z * z)))
        .collect();
    let hull = Hull::new(
        &stations.map(|x| length_m * x),
        &waterlines.map(|z| draught_m * z),
        &half,
        Default::default(),
    )
    .unwrap();
    for speed_mps in [0.5, 3.0, 12.0, 60.0] {
        let k0 = GRAVITY_MPS2 / (speed_mps * speed_mps);
        let ship = at(&hull, speed_mps);
        for t in [0.0, 0.2, 0.7, 2.0, 9.0, 60.0_f64] {
            let sec = t.hypot(1.0);
            let expected = closed_form_m3(dimensions_m, k0 * sec * sec, k0 * sec);
            let found = ship.kochin_m3(t);
            // F has 4 eps of its largest, 0.5 B min(T, 1/k), times L; sums over 4 panels.
            let scale = 0.5 * beam_m * draught_m.min(1.0 / (k0 * sec * sec)) * length_m;
            assert!(
                (found - expected).norm() < 64.0 * f64::EPSILON * scale,
                "{speed_mps} {t}: {found} {expected}"
            );
        }
    }
}

/// For a hull whose ends close, the slope form and P + jQ are one thing; with a transom they differ by its
/// term.
#[test]
fn slope_form_and_kochin_function_agree() {
    let closed = standard(100.0);
    let open = Hull::load(std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/hulls/dtmb5415.toml")))
        .unwrap();
    assert!(open.transom_depth_m() > 0.0 && closed.transom_depth_m() == 0.0);
    for (hull, transom) in [(&closed, Transom::Open), (&closed, Transom::Capped), (&open, Transom::Capped)] {
        for speed_mps in [2.0, 4.5, 9.0, 30.0] {
            let ship = Kochin::new(hull, speed_mps, transom).unwrap();
            let k0 = ship.transverse_radpm();
            for t in [0.0, 0.4, 1.0, 3.0, 10.0_f64] {
                let sec = t.hypot(1.0);
                let factor = Complex64::new(0.0, -2.0 / std::f64::consts::PI * k0 * k0 * sec.powi(4));
                // Roundings of F times L, through the factor: F <= Y/k.
                let scale_m = factor.norm() * hull.beam_m() / (k0 * sec * sec) * hull.length_m();
                let (found, expected) = (ship.amplitude_m(t), factor * ship.kochin_m3(t));
                assert!((found - expected).norm() < 1e-14 * scale_m, "{speed_mps} {t}: {found} {expected}");
            }
        }
    }
    let [a, b] = [Transom::Open, Transom::Capped].map(|transom| Kochin::new(&open, 9.0, transom).unwrap());
    assert!((a.amplitude_m(1.0) - b.amplitude_m(1.0)).norm() > 1e-3 * a.amplitude_m(1.0).norm());
}

/// A mirrored hull makes the same waves: |A| is that of the hull run backwards.
#[test]
fn a_hull_sails_backwards_at_the_same_cost() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/hulls/series60.toml");
    let hull = Hull::load(std::path::Path::new(path)).unwrap();
    let stations_m: Vec<f64> = hull.stations_m().iter().rev().map(|x| -x).collect();
    let half_m: Vec<f64> =
        (0..stations_m.len()).rev().flat_map(|i| hull.half_breadths_m(i).iter().copied()).collect();
    let back = Hull::new(&stations_m, hull.waterlines_m(), &half_m, Default::default()).unwrap();
    for t in [0.0, 0.5, 2.0, 7.0] {
        let [ahead, astern] =
            [&hull, &back].map(|hull| Kochin::new(hull, 7.0, Transom::Capped).unwrap().amplitude_m(t));
        // Conjugate, and the sign of the slope.
        assert!((ahead + astern.conj()).norm() < 1e-12 * ahead.norm(), "{t}: {ahead} {astern}");
    }
}

#[test]
fn the_same_form_makes_the_same_waves_at_any_scale() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/hulls/dtmb5415.toml");
    let ship = Hull::load(std::path::Path::new(path)).unwrap();
    let model = ship.scaled_to_length(5.72).unwrap();
    let ratio = ship.length_m() / model.length_m();
    let [large, small] = [(&ship, 9.0), (&model, 9.0 / ratio.sqrt())].map(|(hull, v)| at(hull, v));
    for t in [0.0, 1.0, 10.0] {
        let (a, b) = (large.amplitude_m(t), small.amplitude_m(t) * ratio);
        // kappa L = 164 sec theta: phases are good to that many roundings.
        assert!((a - b).norm() < 1e-12 * 10.0 * (1.0 + t) * a.norm(), "{t}: {a} {b}");
    }
    let [a, b] = [large, small].map(|ship| ship.wave_resistance_n(DENSITY_KGPM3).unwrap());
    assert!((a / b / ratio.powi(3) - 1.0).abs() < 1e-10);
}

/// Cw of the 5415 at 100 m was computed apart, with bilinear tables and an open stern (wetted surface 2991
/// m^2 at full scale): 3.85e-4 at 4.5 m/s and 1.607e-3 at 9 m/s on 801 x 289 points, where halving the grid
/// changes 0.5 and 0.2 percent; that is the tolerance of the fine table. The coarse one has one interval for
/// the bow dome: bilinear it is 4 and 1.3 percent off, and a quadratic through the same points may differ as
/// much again.
#[test]
fn resistance_of_the_5415() {
    let surface_m2 = 2991.0 * (100.0_f64 / 142.0).powi(2);
    for (file, tolerance) in [("dtmb5415", [0.08, 0.026]), ("dtmb5415_fine", [5e-3, 2e-3])] {
        let path = format!("{}/hulls/{file}.toml", env!("CARGO_MANIFEST_DIR"));
        let hull = Hull::load(path.as_ref()).unwrap().scaled_to_length(100.0).unwrap();
        for ((speed_mps, finest), tolerance) in [(4.5, 3.85e-4), (9.0, 1.607e-3)].into_iter().zip(tolerance) {
            let [open, capped] = [Transom::Open, Transom::Capped].map(|transom| {
                let ship = Kochin::new(&hull, speed_mps, transom).unwrap();
                let resistance_n = ship.wave_resistance_n(DENSITY_KGPM3).unwrap();
                resistance_coefficient(resistance_n, speed_mps, DENSITY_KGPM3, surface_m2)
            });
            let error = open / finest - 1.0;
            println!("{file} {speed_mps} m/s: Cw {open:.4e} ({:+.2} %), capped {capped:.4e}", 100.0 * error);
            assert!(error.abs() < tolerance);
            // A step of the stern outdoes the ship (docs/decisions, 13).
            assert!(capped > if speed_mps < 5.0 { 6.0 } else { 1.15 } * open);
        }
    }
}

#[test]
fn speeds_at_the_ends() {
    let hull = standard(100.0);
    for speed_mps in [0.0, 1e-300, 0.05, 0.0999] {
        let ship = at(&hull, speed_mps);
        assert!(ship.is_still());
        assert_eq!(ship.amplitude_m(0.0), Complex64::ZERO);
        assert_eq!(ship.kochin_m3(0.3), Complex64::ZERO);
        assert_eq!(ship.wave_resistance_n(DENSITY_KGPM3), Ok(0.0));
        assert_eq!(resistance_coefficient(0.0, speed_mps, DENSITY_KGPM3, 1e3), 0.0);
    }
    assert!(at(&hull, LEAST_SPEED_MPS).amplitude_m(0.0).norm() > 0.0);
    for speed_mps in [-1e-9, -4.5, 100.1, f64::NAN, f64::INFINITY] {
        let error = Kochin::new(&hull, speed_mps, Transom::Open).unwrap_err();
        assert!(error.to_string().ends_with("m/s: allowed are 0 to 100 m/s"), "{error}");
    }
    let ship = at(&hull, 4.5);
    for density in [0.0, -1.0, f64::NAN, 2e4] {
        assert!(matches!(ship.wave_resistance_n(density), Err(KochinError::Density { .. })));
    }
    // A Froude number of 0.003: refused, not computed for minutes.
    let slow = at(&hull, LEAST_SPEED_MPS).wave_resistance_n(DENSITY_KGPM3);
    assert!(matches!(slow, Err(KochinError::Slow { .. })), "{slow:?}");
}

#[test]
fn waves_across_the_track_are_none() {
    let ship = at(&standard(100.0), 4.5);
    let k0 = ship.transverse_radpm();
    let last = (LARGEST_WAVE_NUMBER_RADPM / k0 - 1.0).sqrt();
    assert!(ship.amplitude_m(0.999 * last).norm() > 0.0);
    for t in [1.001 * last, std::f64::consts::FRAC_PI_2.tan(), 1e200, f64::MAX, f64::INFINITY, f64::NAN] {
        assert_eq!(ship.amplitude_m(t), Complex64::ZERO, "{t}");
        assert_eq!(ship.amplitude_m(-t), Complex64::ZERO, "{t}");
    }
    // Where the bow is a wedge of half angle Y_x, |A| is about 2 Y_x/(pi k0) of it, then and for all shorter
    // waves: bow and stern of the standard hull give twice 2 * 0.2/(pi k0) at most.
    for t in [1e2, 1e4, 1e6] {
        let most_m = 2.0 * 2.0 * 0.2 / (std::f64::consts::PI * k0);
        assert!(ship.amplitude_m(t).norm() < 1.001 * most_m, "{t}");
    }
}

proptest! {
    #![proptest_config(crate::cases::proptests(64))]

    #[test]
    fn any_hull_at_any_speed_is_finite(
        length_m in prop_oneof![0.05..1.0f64, 1.0..1000.0f64, Just(0.1), Just(500.0)],
        beam in 1e-3..0.9f64,
        draught in 1e-3..0.9f64,
        speed_mps in prop_oneof![0.0..MOST_SPEED_MPS, 0.0..1.0f64, Just(LEAST_SPEED_MPS), Just(MOST_SPEED_MPS)],
        tangents in prop::collection::vec(prop_oneof![-10.0..10.0f64, (-20.0..300.0f64).prop_map(|p| 10f64.powf(p))], 8),
        bumps in prop::collection::vec(0.0..1.0f64, 25),
        capped in any::<bool>(),
    ) {
        let transom = if capped { Transom::Capped } else { Transom::Open };
        let wigley = Hull::wigley(length_m, beam * length_m, draught * length_m).unwrap();
        // Any half-breadths at all, blunt at both ends.
        let stations: Vec<f64> = (0..5).map(|i| length_m * f64::from(i) / 4.0).collect();
        let waterlines: Vec<f64> = (0..5).map(|j| draught * length_m * (f64::from(j) / 4.0 - 1.0)).collect();
        let half: Vec<f64> = bumps.iter().map(|y| (0.3 + 0.7 * y) * beam * length_m / 2.0).collect();
        let rough = Hull::new(&stations, &waterlines, &half, Default::default()).unwrap();
        for hull in [&wigley, &rough] {
            let ship = Kochin::new(hull, speed_mps, transom).unwrap();
            for &t in &tangents {
                prop_assert!(ship.amplitude_m(t).is_finite(), "{}", t);
                prop_assert!(ship.kochin_m3(t).is_finite(), "{}", t);
            }
            // Slow ones take long without optimisation, and say so themselves when they are too slow.
            if ship.froude() > 0.15 || ship.is_still() {
                let resistance_n = ship.wave_resistance_n(DENSITY_KGPM3).unwrap();
                prop_assert!(resistance_n.is_finite() && resistance_n >= 0.0);
            }
        }
    }
}
