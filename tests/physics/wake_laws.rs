//! What every wake must obey, read from maps: Kelvin's angle and wavelength, the energy left behind, motion.

use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

use nereus::scene::Patch;
use nereus::sea::GRAVITY_MPS2;
use nereus::sea::wake::nodes::Band;
use nereus::sea::wake::{Course, Reach, Settings, Upstream, Wake, Wigley};
use num_complex::Complex64;

use crate::wake_map::{SHIP, all, map_of, wake};

/// A ship at the origin that heads east, at a speed, on a patch; band limit kc or the default.
fn eastward(speed_mps: f64, patch: &Patch, cutoff_rad_m: Option<f64>, upstream: Upstream) -> Wake {
    let course = Course::straight([0.0, 0.0], 0.0, speed_mps);
    let reach = Reach::of(patch, &course, [0.0, 0.0]).unwrap();
    wake(SHIP, course, &Settings { cutoff_rad_m, upstream, ..Settings::new(patch.facet_m, reach) })
}

/// Slope and intercept of the straight line through points.
fn line_through(points: &[[f64; 2]]) -> [f64; 2] {
    let n = points.len() as f64;
    let mean = [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / n);
    let (mut xx, mut xy) = (0.0, 0.0);
    for [x, y] in points {
        xx += (x - mean[0]).powi(2);
        xy += (x - mean[0]) * (y - mean[1]);
    }
    [xy / xx, mean[1] - xy / xx * mean[0]]
}

#[test]
fn the_cusp_lies_at_kelvins_angle() {
    let speed_mps = 9.0;
    let patch = Patch { facets: [1024, 512], facet_m: 4.0, first: [-1100, -20] };
    let wake = eastward(speed_mps, &patch, None, Upstream::RaisedCosine);
    let fields = map_of::<f64>(vec![wake], &patch, -100.0, 0.0);
    // Height and vertical velocity are in quadrature, and there is one frequency at the cusp: V k0 sqrt(1.5).
    let omega = GRAVITY_MPS2 / speed_mps * 1.5f64.sqrt();
    let mut points = Vec::new();
    for ix in (-1100i64..-300).step_by(5) {
        let envelope = |iy: i64| {
            let i = patch.nearest_index([ix, iy]);
            fields.height_m[i].hypot(fields.velocity_mps[2][i] / omega)
        };
        // From outside inwards, the first crest of the envelope.
        let crest = (0..480).rev().find(|&iy| {
            envelope(iy) > 0.02 && envelope(iy) >= envelope(iy - 1) && envelope(iy) > envelope(iy + 1)
        });
        let iy = crest.unwrap();
        let [left, top, right] = [iy - 1, iy, iy + 1].map(envelope);
        let offset = 0.5 * (left - right) / (left - 2.0 * top + right);
        let x = -ix as f64;
        // Airy: the crest lies inside the cusp line by a share of x that falls as x^(-2/3).
        points.push([x.powf(-2.0 / 3.0), (iy as f64 + offset) / x]);
    }
    let angle_deg = line_through(&points)[1].atan().to_degrees();
    println!("cusp line at {angle_deg:.3} deg over {} cuts, asin(1/3) = 19.471", points.len());
    assert!((angle_deg - 19.471).abs() < 0.5, "{angle_deg}");
}

#[test]
fn transverse_waves_have_kelvins_length() {
    for speed_mps in [4.5, 9.0] {
        let facet_m = speed_mps * speed_mps / 81.0;
        let patch = Patch { facets: [4000, 1], facet_m, first: [-4400, 0] };
        let wake = eastward(speed_mps, &patch, None, Upstream::RaisedCosine);
        let fields = map_of::<f64>(vec![wake], &patch, -100.0, 0.0);
        let height = |ix: i64| fields.height_m[patch.nearest_index([ix, 0])];
        let upward: Vec<f64> = (-4400..-401)
            .filter(|&ix| height(ix) <= 0.0 && height(ix + 1) > 0.0)
            .map(|ix| facet_m * (ix as f64 - height(ix) / (height(ix + 1) - height(ix))))
            .collect();
        let length_m = (upward[upward.len() - 1] - upward[0]) / (upward.len() - 1) as f64;
        let kelvin_m = TAU * speed_mps * speed_mps / GRAVITY_MPS2;
        println!("{speed_mps} m/s: transverse waves {length_m:.3} m, 2 pi V^2/g = {kelvin_m:.3} m");
        assert!((length_m / kelvin_m - 1.0).abs() < 0.01);
    }
}

/// Resistance, N, from a cut across the wake: the energy of each transverse wave number, from height and
/// slope.
fn resistance_by_cut_n(speed_mps: f64, height_m: &[f64], slope_astern: &[f64], dy_m: f64) -> f64 {
    let n = height_m.len();
    let transform = |field: &[f64]| {
        let mut values: Vec<Complex64> = field.iter().map(|&v| Complex64::new(v, 0.0)).collect();
        nereus_fft::forward(n).process(&mut values);
        values
    };
    let (height, slope) = (transform(height_m), transform(slope_astern));
    let k0 = GRAVITY_MPS2 / (speed_mps * speed_mps);
    let mut sum = 0.0;
    for i in 0..n {
        let m = if 2 * i < n { i as f64 } else { i as f64 - n as f64 };
        let ky = m * TAU / (n as f64 * dy_m);
        // ky = k0 t sqrt(1 + t^2), kx = k0 sqrt(1 + t^2).
        let sec2 = 0.5 + (0.25 + (ky / k0).powi(2)).sqrt();
        let kx2 = k0 * k0 * sec2;
        sum += 0.5 * (height[i].norm_sqr() + slope[i].norm_sqr() / kx2) * (1.0 - 0.5 / sec2);
    }
    // Parseval: the sum over y is 1/n of that over wave numbers.
    1000.0 * GRAVITY_MPS2 * sum * dy_m / n as f64
}

/// `(pi/2) rho V^2` times the integral of `|A W|^2 cos^3 theta`, N, over fine steps of t.
fn resistance_by_amplitude_n(hull: Wigley, speed_mps: f64, band: Option<Band>) -> f64 {
    let k0 = GRAVITY_MPS2 / (speed_mps * speed_mps);
    let most = band.map_or(60.0, |band| band.most_tan_theta(k0).unwrap());
    let steps = 200_000;
    let h = most / f64::from(steps);
    let mut sum = 0.0;
    for i in 0..=steps {
        let t = h * f64::from(i);
        let sec2 = 1.0 + t * t;
        let w = band.map_or(1.0, |band| band.weight(k0 * sec2));
        let share = if i == 0 || i == steps { 0.5 } else { 1.0 };
        sum += share * (hull.amplitude_m(speed_mps, t) * w).norm_sqr() * sec2.powf(-2.5);
    }
    0.5 * PI * 1000.0 * speed_mps * speed_mps * 2.0 * sum * h
}

#[test]
fn a_cut_across_the_wake_carries_the_resistance() {
    for speed_mps in [4.5, 9.0] {
        // Waves to 2.4 kc = 1.7 rad/m: facets of 1 m sample height and slope alike.
        let cutoff_rad_m = 0.7;
        let patch = Patch { facets: [1, 2048], facet_m: 1.0, first: [-1500, -1024] };
        let wake = eastward(speed_mps, &patch, Some(cutoff_rad_m), Upstream::Symmetric);
        let fields = map_of::<f64>(vec![wake], &patch, -140.0, 0.0);
        let cut = |field: &[f64]| -> Vec<f64> {
            (-1024..1024).map(|iy| field[patch.nearest_index([-1500, iy])]).collect()
        };
        let by_cut = resistance_by_cut_n(speed_mps, &cut(&fields.height_m), &cut(&fields.slope[0]), 1.0);
        let by_amplitude = resistance_by_amplitude_n(SHIP, speed_mps, Some(Band { cutoff_rad_m }));
        println!("{speed_mps} m/s: resistance {by_cut:.2} N by the cut, {by_amplitude:.2} N by |A|^2");
        assert!((by_cut / by_amplitude - 1.0).abs() < 1e-3);
    }
    // The judge itself against the golden resistance, which has no band limit.
    for row in crate::sea_golden::rows("wake_resistance.csv") {
        let hull = Wigley { length_m: row.get("L"), beam_m: row.get("B"), draught_m: row.get("T") };
        let ours = resistance_by_amplitude_n(hull, row.get("V"), None);
        // Beyond t = 60 there is less than 1e-6 of it: |A|^2 is bounded, cos^3 dtheta falls as t^-5.
        assert!((ours / row.get("Rw_N_rho1000") - 1.0).abs() < 2e-6, "{ours}");
    }
}

#[test]
fn a_long_cut_of_the_wigley_hull() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/hulls/wigley_michell_wavecut.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let hull = Wigley { length_m: 100.0, beam_m: 10.0, draught_m: 6.25 };
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|v| v.parse().unwrap()).collect()).collect();
    let largest = rows.iter().fold(0.0f64, |m, row| m.max(row[3].abs()));
    let mut worst = 0.0f64;
    let mut wakes: Vec<(f64, Wake)> = Vec::new();
    for row in &rows {
        let speed_mps = row[0] * (GRAVITY_MPS2 * 100.0).sqrt();
        if wakes.last().is_none_or(|(froude, _)| *froude != row[0]) {
            let course = Course::straight([0.0, 0.0], 0.0, speed_mps);
            // The table has no band limit. Waves at its innermost places are as short as 5 cm, but low.
            let settings = Settings {
                cutoff_rad_m: Some(600.0),
                upstream: Upstream::Symmetric,
                ..Settings::new(0.25, Reach { along_m: 551.0, across_m: 51.0 })
            };
            wakes.push((row[0], wake(hull, course, &settings)));
        }
        let at = wakes[wakes.len() - 1].1.at([-100.0 * row[1], -100.0 * row[2]], 0.0).unwrap();
        worst = worst.max((at.height_m / 100.0 - row[3]).abs());
    }
    println!("Wigley wave cut: worst {:.1e} of the largest height, {} places", worst / largest, rows.len());
    assert!(worst / largest < 1e-3);
}

#[test]
fn a_map_moves_with_its_ship() {
    // 9 m/s for a ninth of a second: one facet.
    let patch = Patch::new([200.0, 120.0], 1.0, [-40.0, 10.0]).unwrap();
    let course = Course::straight([20.0, 3.0], 0.0, 9.0);
    let reach = Reach::of(&patch, &course, [0.0, 1.0]).unwrap();
    let wake = wake(SHIP, course, &Settings::new(1.0, reach));
    let before = map_of::<f64>(vec![wake.clone()], &patch, -200.0, 0.2);
    let after = map_of::<f64>(vec![wake], &patch, -200.0, 0.2 + 1.0 / 9.0);
    for ((name, before), (_, after)) in all(&before).into_iter().zip(all(&after)) {
        let largest = before.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for iy in -50..70 {
            for ix in -140..59 {
                let change = after[patch.nearest_index([ix + 1, iy])] - before[patch.nearest_index([ix, iy])];
                // Both maps are within -190 dB of the sum (see `maps_agree_with_the_direct_sum`).
                assert!(change.abs() < 2.0 * 3.2e-10 * largest, "{name} at {ix}, {iy}: {change:e}");
            }
        }
    }
}

#[test]
fn a_patch_that_follows_sees_the_same_water() {
    let patch = Patch::new([64.0, 64.0], 1.0, [-40.0, 10.0]).unwrap();
    let course = Course::straight([20.0, 3.0], 0.4, 9.0);
    let wake = wake(SHIP, course, &Settings::new(1.0, Reach::disc(300.0)));
    let here = map_of::<f64>(vec![wake.clone()], &patch, -200.0, 0.2);
    let moved = Patch { first: [patch.first[0] + 17, patch.first[1] - 9], ..patch };
    let there = map_of::<f64>(vec![wake], &moved, -200.0, 0.2);
    for ix in moved.first[0]..patch.first[0] + 64 {
        for iy in patch.first[1]..moved.first[1] + 64 {
            let [here, there] = [(&patch, &here), (&moved, &there)]
                .map(|(patch, fields)| fields.height_m[patch.nearest_index([ix, iy])]);
            assert!((here - there).abs() < 1e-9);
        }
    }
}

#[test]
fn fields_are_derivatives_of_height_and_displacement() {
    // Also under the window: the ship is on the map. Central differences over dt and over dx miss by
    // dt^2/6 of the third derivative: 2.5 rad/s and 1.7 rad/m at most here (kc = 0.7).
    let (dt, dx) = (1e-3, 1e-3);
    let course = Course::straight([0.0, 0.0], 0.5, 9.0);
    let settings = Settings { cutoff_rad_m: Some(0.7), ..Settings::new(1.0, Reach::disc(200.0)) };
    let wake = wake(SHIP, course, &settings);
    let at = |position_m: [f64; 2], time_s: f64| wake.at(position_m, time_s).unwrap();
    let mut checked = 0;
    for ix in -12..5 {
        for iy in -6..7 {
            let [x, y] = [10.0 * f64::from(ix) + 0.3, 9.0 * f64::from(iy) + 0.7];
            let here = at([x, y], 1.0);
            let [early, late] = [at([x, y], 1.0 - dt), at([x, y], 1.0 + dt)];
            // The largest rates: w^3 = 70/s^3 of a height of 1 m, and k^3 = 5/m^3; rounding 1e-16/dt.
            let close = |a: f64, b: f64, what: &str| {
                assert!((a - b).abs() < 20.0 * dt * dt + 1e-12, "{what} at {x}, {y}: {a} {b}");
            };
            let rate = |early: f64, late: f64| (late - early) / (2.0 * dt);
            close(here.velocity_mps[2], rate(early.height_m, late.height_m), "vertical velocity");
            for axis in 0..3 {
                let both = [&early, &late].map(|sample| sample.velocity_mps[axis]);
                // w'' jumps at the ends of the ship, by pi^2 V^2 z/(2 L^2): differences across it are no
                // judge.
                let astern =
                    -(x - 9.0 * 0.5f64.cos()) * 0.5f64.cos() - (y - 9.0 * 0.5f64.sin()) * 0.5f64.sin();
                if (astern.abs() - 50.0).abs() > 0.1 {
                    close(here.acceleration_mps2[axis], rate(both[0], both[1]), "acceleration");
                    checked += 1;
                }
            }
            for axis in 0..2 {
                close(
                    here.velocity_mps[axis],
                    rate(early.displacement_m[axis], late.displacement_m[axis]),
                    "horizontal velocity",
                );
                close(here.slope_rate_per_s[axis], rate(early.slope[axis], late.slope[axis]), "slope rate");
                let mut ends = [[x, y]; 2];
                ends[0][axis] -= dx;
                ends[1][axis] += dx;
                let [low, high] = ends.map(|end| at(end, 1.0).height_m);
                close(here.slope[axis], (high - low) / (2.0 * dx), "slope");
            }
        }
    }
    assert!(checked > 600);
}

#[test]
fn nothing_stands_ahead_of_the_bow() {
    let patch = Patch::new([400.0, 100.0], 2.0, [100.0, 0.0]).unwrap();
    let wake = eastward(9.0, &patch, None, Upstream::RaisedCosine);
    let fields = map_of::<f64>(vec![wake], &patch, -100.0, 0.0);
    for (name, field) in all(&fields) {
        for iy in patch.first[1]..patch.first[1] + 50 {
            for ix in 25..patch.first[0] + 200 {
                assert_eq!(field[patch.nearest_index([ix, iy])], 0.0, "{name} at {ix}, {iy}");
            }
        }
        assert!(field.iter().any(|v| *v != 0.0), "{name}");
    }
}
