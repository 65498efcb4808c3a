//! Pattern files: interpolation against the closed form, faults, arbitrary bytes.

use std::fmt::Write as _;

use nereus::frames::Vector;
use nereus::radar::antenna::Antenna;
use nereus::radar::pattern::{GridPattern, PatternError, PatternFault};
use proptest::prelude::*;

/// The field of a 0.3 m x 0.2 m rectangle on a grid, and how far the interpolation is off between the
/// points, relative to the peak.
fn worst_error(step_deg: f64) -> f64 {
    let exact = Antenna::Rectangle { width_m: 0.3, height_m: 0.2, wavelength_m: 0.03 };
    let direction = |az: f64, el: f64| {
        let ((sin_az, cos_az), (sin_el, cos_el)) = (az.to_radians().sin_cos(), el.to_radians().sin_cos());
        Vector::new(cos_el * cos_az, cos_el * sin_az, sin_el)
    };
    let mut text = String::from("# made by a formula\naz_deg,el_deg,gain_dbi,phase_deg\n");
    let steps = (10.0 / step_deg) as i32;
    // From the last to the first: order does not matter.
    for j in (-steps..=steps).rev() {
        for i in -steps..=steps {
            let (az, el) = (f64::from(i) * step_deg, f64::from(j) * step_deg);
            let g = exact.field_gain(direction(az, el)).re;
            let phase = if g < 0.0 { 180.0 } else { 0.0 };
            writeln!(text, "{az},{el},{},{phase}", (20.0 * g.abs().log10()).max(-300.0)).unwrap();
        }
    }
    let grid = GridPattern::parse(text.as_bytes(), -80.0).unwrap();
    let peak = exact.field_gain(direction(0.0, 0.0)).re;
    let mut worst = 0f64;
    for j in 0..97 {
        for i in 0..101 {
            let (az, el) = (-9.999 + 0.19998 * f64::from(i), -9.999 + 0.20621 * f64::from(j));
            let g = grid.field_gain(az.to_radians(), el.to_radians());
            worst = worst.max((g - exact.field_gain(direction(az, el))).norm() / peak);
        }
    }
    worst
}

#[test]
fn interpolation_is_of_third_order() {
    let (coarse, fine) = (worst_error(0.5), worst_error(0.25));
    println!("pattern: worst error {coarse:.2e} at 0.5 deg, {fine:.2e} at 0.25 deg");
    // The argument of the sinc turns by k = pi a / lambda = 31.4 rad per radian, so 0.27 rad a step h.
    // Catmull-Rom leaves h^3 g''' sqrt(3)/108, about, once per angle; at the rim, where three points
    // are all there is, h^3 g''' / 15. |g'''| of a sinc is at most 0.26: 0.27^3 x 0.26 / 15 = 3.5e-4.
    assert!(coarse < 7e-4 && fine < coarse / 6.0);
}

#[test]
fn outside_the_grid_is_the_floor_and_a_full_turn_closes() {
    let mut text = String::from("az_deg,el_deg,gain_dbi\n");
    for el in [-10, 0, 10] {
        for az in (0..360).step_by(10) {
            writeln!(text, "{az},{el},{}", 3.0 * f64::from(az).to_radians().cos()).unwrap();
        }
    }
    let grid = GridPattern::parse(text.as_bytes(), -40.0).unwrap();
    let at = |az: f64, el: f64| grid.field_gain(az.to_radians(), el.to_radians()).re;
    assert!((at(0.0, 0.0) - 10f64.powf(0.15)).abs() < 1e-12);
    assert!((at(-5.0, 3.0) - at(355.0, 3.0)).abs() < 1e-12);
    assert!((at(-5.0, 3.0) - at(5.0, 3.0)).abs() < 1e-12, "the pattern is even");
    assert!((at(359.999_999, 0.0) - at(0.0, 0.0)).abs() < 1e-6);
    assert!((at(0.0, 10.001) - 0.01).abs() < 1e-15 && at(0.0, 10.0) > 1.0);
}

#[test]
fn all_faults_at_once_with_their_lines() {
    let text =
        "az_deg,el_deg,gain_dbi\n0,0,1\n1,0,nan\n2,0,3\n3,0\n0,1,1\n1,1,1\n1,1,2\n2,1,1e9\n3.4,1,0\n3,1,0\n";
    let faults = GridPattern::parse(text.as_bytes(), -60.0).unwrap_err();
    let listed: Vec<String> = faults.iter().map(ToString::to_string).collect();
    let has = |what: &str| assert!(listed.iter().any(|f| f.contains(what)), "{what} not in {listed:#?}");
    has("line 3: gain_dbi 'nan'");
    has("line 5: 2 fields, 3 wanted");
    has("line 8: az 1 el 1 is given already in line 7");
    has("line 9: gain_dbi '1e9'");
    has("line 10: az_deg 3.4 is not on the regular grid");
    has("grid points are missing");
}

#[test]
fn odd_files() {
    let fault = |text: &[u8]| GridPattern::parse(text, -60.0).unwrap_err();
    assert!(matches!(fault(b"")[..], [PatternFault::TooFew { .. }, PatternFault::TooFew { .. }]));
    assert!(matches!(fault(b"az,el,gain\n1,2,3\n")[..], [PatternFault::Header { line: 1, .. }]));
    assert!(matches!(fault(b"az_deg,el_deg,gain_dbi\n\xff,0,0\n")[0], PatternFault::Csv { .. }));
    // A million values of each axis cannot be a full grid: refused before anything of that size is made.
    let mut text = String::from("az_deg,el_deg,gain_dbi\n");
    for i in 0..3000 {
        writeln!(text, "{},{},0", f64::from(i) * 0.01, f64::from(i) * 0.01).unwrap();
    }
    assert_eq!(fault(text.as_bytes()), [PatternFault::TooMany]);
    let missing = GridPattern::open(std::path::Path::new("no/such/pattern.csv"), -60.0);
    assert!(matches!(missing, Err(PatternError::Read { .. })));
    // A long list of faults is cut, and ends with their number.
    let text = format!("az_deg,el_deg,gain_dbi\n{}", "x,y,z\n".repeat(100));
    assert!(matches!(fault(text.as_bytes()).last(), Some(PatternFault::More(280))));
}

proptest! {
    #![proptest_config(crate::cases::proptests(256))]

    #[test]
    fn any_bytes_are_read_without_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = GridPattern::parse(&bytes, -60.0);
        let mut with_header = b"az_deg,el_deg,gain_dbi\n".to_vec();
        with_header.extend_from_slice(&bytes);
        let _ = GridPattern::parse(&with_header, -60.0);
    }

    #[test]
    fn any_numbers_are_read_without_panic(
        rows in proptest::collection::vec((-400.0..400.0f64, -100.0..100.0f64, -400.0..200.0f64), 0..12),
        az in -10.0..10.0f64, el in -2.0..2.0f64,
    ) {
        let mut text = String::from("az_deg,el_deg,gain_dbi\n");
        for (a, e, g) in rows {
            // Two coarse roundings make grids, holes and repetitions likely.
            writeln!(text, "{},{},{g}", (a / 200.0).round() * 100.0, (e / 50.0).round() * 45.0).unwrap();
        }
        if let Ok(grid) = GridPattern::parse(text.as_bytes(), -60.0) {
            prop_assert!(grid.field_gain(az, el).is_finite());
        }
    }
}
