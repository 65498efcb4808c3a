//! The composite NRCS of docs/physics.md section 10.6 (10 GHz, radar looking upwind, U10 = 10 m/s, cut k/3,
//! all waves below the cut in the slope density, averaged over tilts). Its table is what 13 x 13
//! Gauss-Hermite nodes and a sharp cut give; the library has 3 x 3 nodes and a smooth cut, and docs/sigma0.md
//! states how far each is from the integral.

use std::f64::consts::PI;

use glam::DVec3;
use nereus::scattering::kind::clean::Clean;
use nereus::scattering::kirchhoff::Specular;
use nereus::scattering::permittivity::{Model, SeaWater};
use nereus::scattering::splitting::high_pass;
use nereus::scattering::spm;
use nereus::scattering::tilt::{Path, Tangent};
use nereus::scattering::two_scale::{Medium, Settings, TwoScale};

use crate::scatter_oracle::Elfouhaily;

fn sea(resolved_radpm: f64, tilt_average: bool) -> TwoScale<Clean, impl Fn(f64, f64) -> f64> {
    let water = SeaWater { temperature_c: 20.0, salinity_gpkg: 35.0 };
    let medium = Medium {
        carrier_hz: 10e9,
        permittivity: Model::default().permittivity(10e9, water).unwrap(),
        wind_12p5_mps: 10.0,
        downwind_rad: 0.0,
        resolved_radpm,
        axis: DVec3::X,
    };
    let spectrum = Elfouhaily { wind_10_mps: 10.0, downwind_rad: 0.0 };
    let settings = Settings { tilt_average, ..Settings::default() };
    TwoScale::new(settings, medium, Clean, spectrum.as_psi())
}

fn monostatic(incidence_deg: f64, azimuth_rad: f64) -> Path {
    let (s, c) = incidence_deg.to_radians().sin_cos();
    let away = DVec3::new(-s * azimuth_rad.cos(), -s * azimuth_rad.sin(), -c);
    Path::new(away, -away)
}

fn db(ratio: f64) -> f64 {
    10.0 * ratio.log10()
}

/// Nodes and weights of the n-point Gauss-Hermite rule of a unit Gaussian: the nodes are the zeros of the
/// Hermite polynomial `He_n`, found by halving between those of `He_(n-1)`; the weights are
/// `(n-1)!/(n He_(n-1)^2)`.
fn gauss_hermite(n: u32) -> Vec<(f64, f64)> {
    // He_n over the root of n!, which stays near 1.
    let polynomial = |n: u32, x: f64| {
        let (mut last, mut this) = (0.0, 1.0);
        for i in 0..n {
            (last, this) = (this, (x * this - f64::from(i).sqrt() * last) / f64::from(i + 1).sqrt());
        }
        this
    };
    let mut zeros: Vec<f64> = Vec::new();
    for degree in 1..=n {
        let far = (4.0 * f64::from(degree) + 3.0).sqrt();
        let fence: Vec<f64> = [-far].into_iter().chain(zeros).chain([far]).collect();
        zeros = fence
            .windows(2)
            .map(|pair| {
                let (mut low, mut high) = (pair[0], pair[1]);
                let rising = polynomial(degree, high) > polynomial(degree, low);
                for _ in 0..200 {
                    let middle = 0.5 * (low + high);
                    let above = (polynomial(degree, middle) > 0.0) == rising;
                    *(if above { &mut high } else { &mut low }) = middle;
                }
                0.5 * (low + high)
            })
            .collect();
    }
    zeros.into_iter().map(|x| (x, 1.0 / (f64::from(n) * polynomial(n - 1, x).powi(2)))).collect()
}

/// Trapezoid over 6 deviations of a unit Gaussian.
fn trapezoid(step: f64) -> Vec<(f64, f64)> {
    let half = (6.0 / step).round() as i32;
    (-half..=half)
        .map(|i| {
            let x = f64::from(i) * step;
            (x, step * (-0.5 * x * x).exp() / (2.0 * PI).sqrt())
        })
        .collect()
}

#[test]
fn the_rules_integrate_moments() {
    // Moments of a unit Gaussian: 1, 0, 1, 0, 3, 0, 15. The weights are good to some 1e-15 each.
    for rule in [gauss_hermite(4), gauss_hermite(13), trapezoid(0.1)] {
        for (power, expected) in [1.0, 0.0, 1.0, 0.0, 3.0, 0.0, 15.0].into_iter().enumerate() {
            let found: f64 = rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum();
            // Cut at 6 deviations the sixth moment lacks 6^5 e^-18 = 1e-4.
            let tolerance = if rule.len() > 20 { 2e-4 } else { 1e-12 };
            assert!((found - expected).abs() < tolerance, "{} nodes, moment {power}: {found}", rule.len());
        }
    }
    let three = gauss_hermite(3);
    assert!((three[2].0 - 3f64.sqrt()).abs() < 1e-15 && (three[1].1 - 2.0 / 3.0).abs() < 1e-15);
}

/// docs/physics.md section 10.6: incidence, VV, HH, VH, dB.
const TABLE: [(f64, f64, f64, f64); 6] = [
    (0.0, 12.9, 12.9, f64::NAN),
    (20.0, 0.8, 0.5, -31.4),
    (30.0, -7.7, -9.6, -32.3),
    (45.0, -13.6, -19.8, -34.6),
    (60.0, -17.0, -28.3, -36.9),
    (80.0, -23.0, -42.1, -42.5),
];

/// How waves are divided at the cut.
#[derive(Clone, Copy, PartialEq)]
enum Cut {
    /// The library's raised cosine over an octave.
    Smooth,
    /// A step.
    Sharp,
}

/// VV, HH and VH of the whole composite in dB, the tilts averaged by a rule.
fn composite(
    sea: &TwoScale<Clean, impl Fn(f64, f64) -> f64>,
    incidence_deg: f64,
    rule: &[(f64, f64)],
    cut: Cut,
    damped: bool,
) -> [f64; 3] {
    let path = monostatic(incidence_deg, 0.0);
    let specular = sea.response(&path, (0.0, 0.0), 0.0).specular_sigma0();
    let mirror = Specular::new(sea.medium().permittivity, &path).unwrap();
    let calm = mirror.roughness(sea.medium().wavenumber_radpm(), sea.moments(0.0).roughness_m2).powi(2);
    let undone = if damped { 1.0 } else { 1.0 / calm };
    let bragg = averaged(sea, &path, rule, cut);
    [(0, 0), (1, 1), (0, 1)].map(|(p, q)| db(bragg[p][q] + specular[p][q] * undone))
}

#[test]
fn composite_nrcs_table() {
    let sea = sea(0.0, true);
    let rule = gauss_hermite(13);
    println!("composite NRCS by 13 x 13 nodes and a sharp cut: found (docs/physics.md section 10.6), dB");
    for (deg, vv, hh, vh) in TABLE {
        let found = composite(&sea, deg, &rule, Cut::Sharp, false);
        println!("{deg:>4}: VV {:.2} ({vv}) HH {:.2} ({hh}) VH {:.2} ({vh})", found[0], found[1], found[2]);
        for (found, expected) in
            found.into_iter().zip([vv, hh, vh]).filter(|(_, expected)| !expected.is_nan())
        {
            // Half the table's last digit.
            assert!((found - expected).abs() <= 0.05, "{deg} deg: {found}, table {expected}");
        }
    }
}

#[test]
fn the_library_averages_by_three_nodes() {
    for resolved_radpm in [0.0, PI] {
        let sea = sea(resolved_radpm, true);
        for deg in [0.0, 10.0, 20.0, 30.0, 45.0, 60.0, 80.0, 89.0] {
            let path = monostatic(deg, 0.3);
            let library = sea.response(&path, (0.0, 0.0), 0.0).bragg_sigma0();
            let expected = averaged(&sea, &path, &gauss_hermite(3), Cut::Smooth);
            for (found, expected) in library.iter().flatten().zip(expected.iter().flatten()) {
                assert!((found - expected).abs() <= 1e-12 * expected, "{deg}: {found} not {expected}");
            }
        }
    }
}

/// Rows of the table below a heading of docs/sigma0.md, numbers only.
fn page_rows(heading: &str) -> Vec<Vec<f64>> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/sigma0.md");
    let text = std::fs::read_to_string(path).unwrap();
    let (_, below) = text.split_once(&format!("## {heading}\n")).unwrap();
    let lines =
        below.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    let cells = |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().parse().ok()).collect();
    let rows: Vec<Vec<f64>> = lines.filter_map(cells).collect();
    assert!(!rows.is_empty(), "{heading}");
    rows
}

/// The page's table of the tilt average: facet (0: the whole sea) and incidence, then VV and HH by 3 x 3
/// nodes, by 13 x 13 nodes with a sharp cut, and of the integral; specular part damped.
#[test]
fn the_page_states_what_three_nodes_cost() {
    let (three, thirteen) = (gauss_hermite(3), gauss_hermite(13));
    // Twice as fine a trapezoid, and 41 Gauss-Hermite nodes, say how well the integral is known.
    let (integral, finer, gauss) = (trapezoid(0.1), trapezoid(0.05), gauss_hermite(41));
    let rows = page_rows("The average over tilts");
    assert!(rows.len() >= 10);
    let mut worst = [0.0f64; 2];
    for row in &rows {
        let &[facet_m, deg, ..] = row.as_slice() else { panic!("{row:?}") };
        let sea = sea(if facet_m > 0.0 { PI / facet_m } else { 0.0 }, true);
        let by = |rule: &[(f64, f64)], cut| composite(&sea, deg, rule, cut, true);
        let exact = by(&integral, Cut::Smooth);
        for (i, other) in [by(&finer, Cut::Smooth), by(&gauss, Cut::Smooth)].into_iter().enumerate() {
            let error = (other[0] - exact[0]).abs().max((other[1] - exact[1]).abs());
            worst[i] = worst[i].max(error);
        }
        let found =
            [by(&three, Cut::Smooth), by(&thirteen, Cut::Sharp), exact].map(|x| [x[0], x[1]]).concat();
        assert_eq!(row.len(), 2 + found.len(), "{row:?}");
        for (printed, found) in row[2..].iter().zip(&found) {
            // Half the page's last digit.
            assert!(
                (printed - found).abs() <= 0.005 + 1e-9,
                "facet {facet_m} m, {deg} deg: {found:.2}, page {printed}"
            );
        }
    }
    println!(
        "the integral over tilts is known to {:.3} dB (trapezoid), {:.3} dB (41 nodes)",
        worst[0], worst[1]
    );
    // The page gives hundredths; what separates the rules is tenths.
    assert!(worst[0] < 0.005 && worst[1] < 0.05);
}

/// Bragg sigma0 averaged over tilts by the product of a rule with itself.
fn averaged(
    sea: &TwoScale<Clean, impl Fn(f64, f64) -> f64>,
    path: &Path,
    rule: &[(f64, f64)],
    cut: Cut,
) -> [[f64; 2]; 2] {
    let k = sea.medium().wavenumber_radpm();
    let cut_radpm = sea.cut_radpm().unwrap();
    let spectrum = Elfouhaily { wind_10_mps: 10.0, downwind_rad: 0.0 };
    let slopes = sea.moments(0.0).slopes;
    let psi = |kx: f64, ky: f64| match cut {
        Cut::Smooth => high_pass(kx.hypot(ky), cut_radpm) * spectrum.psi(kx, ky),
        Cut::Sharp if kx.hypot(ky) > cut_radpm => spectrum.psi(kx, ky),
        Cut::Sharp => 0.0,
    };
    let mut sum = [[0.0; 2]; 2];
    for &(u, wu) in rule {
        for &(c, wc) in rule {
            let (zx, zy) = (u * slopes.up.sqrt(), c * slopes.cross.sqrt());
            let plane = Tangent::from_slopes(zx, zy, DVec3::X);
            let a = spm::amplitude(sea.medium().permittivity, k, &plane, path, psi);
            let weight = wu * wc * (1.0 + zx * zx + zy * zy).sqrt();
            for (row, a_row) in sum.iter_mut().zip(&a) {
                for (total, a) in row.iter_mut().zip(a_row) {
                    *total += weight * a.norm_sqr();
                }
            }
        }
    }
    sum
}

#[test]
fn small_waves_weaken_the_specular_part() {
    let sea = sea(0.0, true);
    let at_nadir = db(sea.response(&monostatic(0.0, 0.0), (0.0, 0.0), 0.0).sigma0()[0][0]);
    println!("with damping, 0 deg: {at_nadir:.2} dB (12.3)");
    // Half the last digit; the tilted Bragg part is 3 % of it and known to a third of that (0.04 dB).
    assert!((at_nadir - 12.3).abs() < 0.09, "{at_nadir}");
}

#[test]
fn pure_bragg_at_45_degrees() {
    let sea = sea(0.0, false);
    for (azimuth, vv, hh) in [(0.0, -14.05, -22.2), (PI / 2.0, -17.36, -25.5)] {
        let bragg = sea.response(&monostatic(45.0, azimuth), (0.0, 0.0), 0.0).bragg_sigma0();
        println!("pure Bragg at azimuth {azimuth:.2}: VV {:.2} HH {:.2}", db(bragg[0][0]), db(bragg[1][1]));
        // Half the last digit printed.
        assert!((db(bragg[0][0]) - vv).abs() <= 0.005 && (db(bragg[1][1]) - hh).abs() <= 0.05);
    }
}

#[test]
fn unresolved_slopes_of_a_metre_grid() {
    let sea = sea(PI, false);
    let slopes = sea.moments(0.0).slopes;
    println!("unresolved slope variance, 1 m grid: {:.5} (0.0143)", slopes.total());
    assert!((slopes.total() - 0.0143).abs() <= 0.00005, "{slopes:?}");
    // Integrated a second time: the omnidirectional spectrum, trapezoid in log K, 20000 points.
    let spectrum = Elfouhaily { wind_10_mps: 10.0, downwind_rad: 0.0 };
    let cut = sea.cut_radpm().unwrap();
    let (steps, span) = (20_000, (cut / PI).ln());
    let (mut up, mut cross) = (0.0, 0.0);
    for i in 0..=steps {
        let k = PI * (span * f64::from(i) / f64::from(steps)).exp();
        let (s, delta) = spectrum.omnidirectional(k);
        let ends = if i == 0 || i == steps { 0.5 } else { 1.0 };
        let share = k.powi(3) * s * span / f64::from(steps) * ends;
        up += share * (0.5 + 0.25 * delta);
        cross += share * (0.5 - 0.25 * delta);
    }
    // Trapezoid with 20000 points and Simpson with 200: both below 1e-7.
    assert!((slopes.up / up - 1.0).abs() < 1e-6 && (slopes.cross / cross - 1.0).abs() < 1e-6);
}
