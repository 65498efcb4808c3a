//! The synthesised surface against its definition, its statistics and its own motion.

use nereus::scene::water::{Development, Dispersion, Swell, SwellShape, WindProfile};
use nereus::sea::spectrum::moments::Moments;
use nereus::sea::spectrum::{Elfouhaily, SwellTrain};
use nereus::sea::surface::fields::Real;
use nereus::sea::surface::{
    Averaging, Evaluator, Fields, Grid, Pair, Phasors, Sample, Selection, Surface, Transform,
};
use nereus::sea::wind::Wind;
use num_complex::Complex64;

const DEEP: Dispersion = Dispersion { capillary: false, depth_m: None };

fn elfouhaily(u10_mps: f64, direction_rad: f64) -> Elfouhaily {
    let wind = Wind::from_speed(u10_mps, 10.0, WindProfile::Cardone, direction_rad).unwrap();
    Elfouhaily::new(&wind, Development::default()).unwrap()
}

fn sea(grid: [usize; 2], facet_m: f64, dispersion: Dispersion, seed: u64) -> Surface {
    let grid = Grid::new(grid[0], grid[1], facet_m).unwrap();
    Surface::synthesise(grid, &elfouhaily(10.0, 0.5), dispersion, seed, Averaging::Automatic).unwrap()
}

fn fields<T: Real>(surface: &Surface, time_s: f64) -> Fields<T> {
    let mut fields = Fields::new(surface.grid(), Selection::ALL);
    Evaluator::new(surface).evaluate(time_s, &mut fields).unwrap();
    fields
}

/// All thirteen fields with their names.
fn columns<T: Real>(f: &Fields<T>) -> Vec<(&'static str, &[T])> {
    vec![
        ("z", &f.height_m),
        ("zx", &f.slope[0]),
        ("zy", &f.slope[1]),
        ("ux", &f.velocity_mps[0]),
        ("uy", &f.velocity_mps[1]),
        ("uz", &f.velocity_mps[2]),
        ("ax", &f.acceleration_mps2[0]),
        ("ay", &f.acceleration_mps2[1]),
        ("az", &f.acceleration_mps2[2]),
        ("Dx", &f.displacement_m[0]),
        ("Dy", &f.displacement_m[1]),
        ("dzx/dt", &f.slope_rate_per_s[0]),
        ("dzy/dt", &f.slope_rate_per_s[1]),
    ]
}

fn values(s: &Sample) -> [f64; 13] {
    let [ux, uy, uz] = s.velocity_mps;
    let [ax, ay, az] = s.acceleration_mps2;
    let ([zx, zy], [dx, dy], [rx, ry]) = (s.slope, s.displacement_m, s.slope_rate_per_s);
    [s.height_m, zx, zy, ux, uy, uz, ax, ay, az, dx, dy, rx, ry]
}

fn rms<T: Real>(values: &[T]) -> f64 {
    (values.iter().map(|v| v.widen().powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

fn variance<T: Real>(values: &[T]) -> f64 {
    rms(values).powi(2)
}

/// Largest difference over the rms of a field, or of the largest component of the same vector: a sea of
/// one row has no slope across, and its two components go through one transform.
fn worst(surface: &Surface, found: &Fields<f64>, time_s: f64, keys: &[[i64; 2]]) -> f64 {
    let facet_m = surface.grid().facet_m();
    let columns = columns(found);
    let rms: Vec<f64> = columns.iter().map(|(_, column)| rms(column)).collect();
    let mut scale = rms.clone();
    for vector in [1..3, 3..6, 6..9, 9..11, 11..13] {
        let largest = rms[vector.clone()].iter().copied().fold(0.0, f64::max);
        scale[vector].fill(largest);
    }
    let mut worst = 0.0f64;
    for key in keys {
        let direct = values(&surface.at(key.map(|i| i as f64 * facet_m), time_s));
        for (((name, column), direct), scale) in columns.iter().zip(direct).zip(&scale) {
            let error = (column[surface.grid().index(*key)] - direct).abs() / scale;
            assert!(!error.is_nan(), "{name}");
            worst = worst.max(error);
        }
    }
    worst
}

#[test]
fn transforms_equal_the_sum_of_waves() {
    let tension = Dispersion { capillary: true, depth_m: None };
    let shallow = Dispersion { capillary: false, depth_m: Some(7.0) };
    let both = Dispersion { capillary: true, depth_m: Some(7.0) };
    // Even, odd, unequal, prime, and of one row.
    for (size, dispersion) in [
        ([32, 32], DEEP),
        ([33, 20], tension),
        ([16, 45], shallow),
        ([37, 29], both),
        ([64, 1], DEEP),
        ([2, 31], DEEP),
        ([7, 8], both),
    ] {
        let surface = sea(size, 3.0, dispersion, 5);
        for time_s in [0.0, 17.3, -4.0, 86_400.0] {
            let found = fields::<f64>(&surface, time_s);
            let keys = [[0, 0], [1, 0], [0, 1], [5, 11], [-3, 7], [1000, -1001]];
            let error = worst(&surface, &found, time_s, &keys);
            println!("{size:?} t = {time_s}: {error:.1e}");
            // Phases reach w t = 6e5 rad after a day: rounded to 2^-53 of that, 7e-11 rad in the worst
            // wave; at short times the sum of 1e3 waves in f64.
            assert!(error < if time_s.abs() < 100.0 { 1e-11 } else { 2e-9 }, "{size:?} {time_s}");
        }
    }
}

#[test]
fn f32_fields_are_within_minus_120_db() {
    let shelf = Dispersion { capillary: true, depth_m: Some(40.0) };
    // Facets of 5 mm too: there accelerations are thousands of times the heights.
    let scenes = [1.0, 0.005].map(|facet_m| sea([256, 256], facet_m, shelf, 11));
    let times_s = [0.0, 3600.0 + 1.0 / 222.0, 10.0 * 3600.0];
    for (surface, time_s) in scenes.iter().flat_map(|s| times_s.map(|t| (s, t))) {
        let narrow = fields::<f32>(surface, time_s);
        let wide = fields::<f64>(surface, time_s);
        let mut worst_db = f64::NEG_INFINITY;
        for ((name, a), (_, b)) in columns(&narrow).into_iter().zip(columns(&wide)) {
            let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a.widen() - b).collect();
            let db = 20.0 * (rms(&difference) / rms(b)).log10();
            assert!(db <= -120.0, "{name} at {time_s}: {db:.1} dB");
            worst_db = worst_db.max(db);
        }
        println!("{} m, t = {time_s}: worst {worst_db:.1} dB", surface.grid().facet_m());
    }
}

/// H built from the amplitudes as docs/physics.md section 7.2 prints it, over the full plane: the transform
/// is real.
#[test]
fn the_full_complex_transform_is_real_and_equal() {
    let (nx, ny) = (64, 48);
    let surface = sea([nx, ny], 4.0, DEEP, 3);
    let grid = surface.grid();
    let [dkx, dky] = grid.wave_number_step_rad_m();
    let time_s = 9.0;
    let a = surface.amplitude_m();
    let mut plane = vec![Complex64::ZERO; nx * ny];
    for i in 0..nx {
        for j in 0..ny {
            let (Some(mx), Some(my)) = (grid.wave_index_x(i), grid.wave_index_y(j)) else { continue };
            let omega = (9.81 * (mx as f64 * dkx).hypot(my as f64 * dky)).sqrt();
            let opposite = a[(nx - i) % nx * ny + (ny - j) % ny];
            let turn = Complex64::cis(-omega * time_s);
            plane[j * nx + i] = a[i * ny + j] * turn + opposite.conj() * turn.conj();
        }
    }
    let (along_x, along_y) = (nereus_fft::inverse(nx), nereus_fft::inverse(ny));
    along_x.process(&mut plane);
    for ix in 0..nx {
        let mut column: Vec<Complex64> = (0..ny).map(|iy| plane[iy * nx + ix]).collect();
        along_y.process(&mut column);
        for (iy, value) in column.into_iter().enumerate() {
            plane[iy * nx + ix] = value;
        }
    }
    let heights = fields::<f64>(&surface, time_s).height_m;
    let scale = rms(&heights);
    let imaginary = plane.iter().map(|z| z.im.abs()).fold(0.0, f64::max) / scale;
    let difference = plane.iter().zip(&heights).map(|(z, h)| (z.re - h).abs()).fold(0.0, f64::max) / scale;
    println!("imaginary part {imaginary:.1e}, difference {difference:.1e} of the rms");
    assert!(imaginary < 1e-13 && difference < 1e-13);
}

#[test]
fn variance_and_slopes_over_twenty_seeds() {
    // 2048 m: the peak is spread over some 500 waves, so that the mean of 20 maps is good to about 1 %.
    let (mut height, mut slopes) = (0.0, [0.0; 2]);
    let mut expected = Default::default();
    for seed in 0..20 {
        let surface = sea([256, 256], 8.0, DEEP, 100 + seed);
        expected = surface.expected();
        let found = fields::<f64>(&surface, 0.0);
        height += variance(&found.height_m) / 20.0;
        for (sum, slope) in slopes.iter_mut().zip(&found.slope) {
            *sum += variance(slope) / 20.0;
        }
    }
    let ratio = height / expected.variance_m2;
    let slope_ratio = [0, 1].map(|i| slopes[i] / expected.slope_variance[i]);
    println!("variance over expected: {ratio:.4}; slopes: {slope_ratio:.4?}");
    assert!((ratio - 1.0).abs() < 0.05);
    assert!(slope_ratio.iter().all(|r| (r - 1.0).abs() < 0.05));
}

#[test]
fn what_a_grid_holds_is_what_the_spectrum_has() {
    // docs/physics.md section 7.1: 512 m at U10 = 10 m/s: Hs 2.602 m; slopes resolved on 1 m facets .01202 /
    // .00717 (downwind and crosswind).
    let grid = Grid::new(512, 512, 1.0).unwrap();
    let spectrum = elfouhaily(10.0, 0.0);
    let surface = Surface::synthesise(grid, &spectrum, DEEP, 1, Averaging::Points).unwrap();
    let expected = surface.expected();
    let points_m = 4.0 * expected.variance_m2.sqrt();
    println!("points: Hs {points_m:.4} m, slopes {:.5?}", expected.slope_variance);
    assert!((points_m - 2.602).abs() < 6e-4);
    assert!((expected.slope_variance[0] - 0.01202).abs() < 6e-6);
    assert!((expected.slope_variance[1] - 0.00717).abs() < 6e-6);
    // Means over cells: the variance of the square band, exactly, however coarse the grid.
    for length_m in [512.0, 200.0, 100.0] {
        let grid = Grid::new(128, 128, length_m / 128.0).unwrap();
        let surface = Surface::synthesise(grid, &spectrum, DEEP, 1, Averaging::Automatic).unwrap();
        let half_step = std::f64::consts::PI / length_m;
        // Between the circles inscribed in and around the missing square about K = 0; the outer edge of
        // the grid holds less than 0.3 %.
        let band = |low| Moments::of(&spectrum, [low, 128.0 * std::f64::consts::PI / length_m]).variance_m2;
        let (most, least) = (band(half_step), band(half_step * 2f64.sqrt()));
        let held = surface.expected().variance_m2;
        println!("{length_m} m: {least:.5} <= {held:.5} <= {most:.5}");
        assert!(held < most * 1.003 && held > least * 0.997);
    }
}

#[test]
fn finer_facets_show_the_same_long_waves() {
    let coarse = sea([64, 64], 8.0, DEEP, 21);
    let fine = sea([128, 256], 4.0, DEEP, 21);
    // Another length is another sea; the same length along x alone shares only the rows of Ky = 0.
    let same = sea([128, 128], 4.0, DEEP, 21);
    let mut shared = 0;
    for i in 0..64 {
        for j in 0..64 {
            let (Some(mx), Some(my)) = (coarse.grid().wave_index_x(i), coarse.grid().wave_index_y(j)) else {
                continue;
            };
            let place = |m: i64| m.rem_euclid(128) as usize;
            let a = coarse.amplitude_m()[i * 64 + j];
            assert_eq!(a, same.amplitude_m()[place(mx) * 128 + place(my)]);
            shared += usize::from(a != Complex64::ZERO);
        }
    }
    println!("{shared} waves shared");
    assert!(shared > 1900);
    assert_ne!(fine.amplitude_m()[1], coarse.amplitude_m()[1]);
    assert_ne!(sea([64, 64], 8.0, DEEP, 22).amplitude_m(), coarse.amplitude_m());
}

/// Frequency and direction of every strong wave, from two height maps alone.
#[test]
fn dispersion_measured_from_two_maps() {
    let tension = Dispersion { capillary: true, depth_m: None };
    let shallow = Dispersion { capillary: false, depth_m: Some(5.0) };
    // Facets of 5 mm for the surface tension: wave numbers to 600 rad/m.
    for (dispersion, facet_m, step_s) in [(DEEP, 4.0, 0.05), (shallow, 4.0, 0.05), (tension, 0.005, 0.001)] {
        let n = 64;
        let surface = sea([n, n], facet_m, dispersion, 8);
        let before = fields::<f64>(&surface, 100.0).height_m;
        let after = fields::<f64>(&surface, 100.0 + step_s).height_m;
        let dk = surface.grid().wave_number_step_rad_m()[0];
        let (mut worst, mut measured) = (0.0f64, 0);
        for (mx, my) in (-20..=20).flat_map(|mx| (-20..=20).map(move |my| (mx, my))) {
            let (kx, ky) = (f64::from(mx) * dk, f64::from(my) * dk);
            // Waves of this sea run within a quarter turn of 0.5 rad; cells within half a diagonal of that
            // border hold some of both ways.
            if kx * 0.5f64.cos() + ky * 0.5f64.sin() <= 0.75 * dk {
                continue;
            }
            let project = |map: &[f64]| -> Complex64 {
                let turn = |i: usize| {
                    let phase = f64::from(mx) * (i % n) as f64 + f64::from(my) * (i / n) as f64;
                    Complex64::cis(-std::f64::consts::TAU / n as f64 * phase)
                };
                map.iter().enumerate().map(|(i, z)| z * turn(i)).sum()
            };
            let advance = (project(&after) / project(&before)).arg();
            let omega = -advance / step_s;
            let k = kx.hypot(ky);
            let gravity = 9.81 * k;
            let law = gravity
                * dispersion.depth_m.map_or(1.0, |d: f64| (k * d).tanh())
                * if dispersion.capillary { 1.0 + (k / 370.0).powi(2) } else { 1.0 };
            worst = worst.max((omega / law.sqrt() - 1.0).abs());
            measured += 1;
        }
        println!("{dispersion:?}: {measured} waves, worst error of frequency {worst:.1e}");
        // Weak waves beside strong ones: 1e-16 of the strongest against amplitudes down to 1e-7 of it.
        assert!(worst < 1e-7 && measured > 700);
    }
}

#[test]
fn rates_are_the_time_derivatives() {
    let surface = sea([64, 64], 2.0, Dispersion { capillary: true, depth_m: Some(12.0) }, 4);
    let (time_s, step_s) = (42.0, 1e-3);
    let [before, now, after] = [-step_s, 0.0, step_s].map(|dt| fields::<f64>(&surface, time_s + dt));
    let derivative = |name: &str, a: &[f64], b: &[f64], rate: &[f64]| {
        let difference: Vec<f64> =
            a.iter().zip(b).zip(rate).map(|((a, b), r)| (b - a) / (2.0 * step_s) - r).collect();
        let error = rms(&difference) / rms(rate);
        println!("{name}: {error:.1e}");
        // Central difference: (w dt)^2/6 with w at most 5 rad/s on these facets, 4e-6.
        assert!(error < 4.2e-6, "{name}: {error:e}");
    };
    derivative("dz/dt", &before.height_m, &after.height_m, &now.velocity_mps[2]);
    for axis in 0..2 {
        derivative(
            "dD/dt",
            &before.displacement_m[axis],
            &after.displacement_m[axis],
            &now.velocity_mps[axis],
        );
        derivative("d slope/dt", &before.slope[axis], &after.slope[axis], &now.slope_rate_per_s[axis]);
    }
    for axis in 0..3 {
        let (a, b) = (&before.velocity_mps[axis], &after.velocity_mps[axis]);
        derivative("du/dt", a, b, &now.acceleration_mps2[axis]);
    }
}

#[test]
fn only_what_is_asked_is_computed_and_it_is_the_same() {
    let surface = sea([40, 24], 2.0, DEEP, 9);
    let all = fields::<f32>(&surface, 5.0);
    let mut evaluator = Evaluator::<f32>::new(&surface);
    for selection in [
        Selection::HEIGHT,
        Selection { slopes: true, ..Selection::HEIGHT },
        Selection { horizontal_acceleration: true, velocity: true, ..Selection::HEIGHT },
        Selection { displacement: true, slope_rate: true, ..Selection::HEIGHT },
    ] {
        let mut some = Fields::new(surface.grid(), selection);
        evaluator.evaluate(-77.0, &mut some).unwrap();
        evaluator.evaluate(5.0, &mut some).unwrap();
        for ((name, a), (_, b)) in columns(&some).into_iter().zip(columns(&all)) {
            assert!(a.is_empty() || a == b, "{name}");
        }
        assert!(!some.height_m.is_empty());
    }
    let mut other = Fields::new(&Grid::new(40, 25, 2.0).unwrap(), Selection::HEIGHT);
    let error = evaluator.evaluate(0.0, &mut other).unwrap_err();
    assert_eq!(error.to_string(), "fields hold 1000 facets, the surface has 960");
    let error = evaluator.evaluate(f64::NAN, &mut other).unwrap_err();
    assert_eq!(error.to_string(), "sea at NaN s: allowed are times within 1000000000 s of t = 0");
}

#[test]
fn pairs_may_be_transformed_on_threads_of_their_own() {
    let surface = sea([48, 40], 2.0, DEEP, 13);
    let one = fields::<f32>(&surface, 8.0);
    let mut phasors = Phasors::new(&surface);
    phasors.turn_to(8.0);
    let pairs = [
        (Pair::Height, &one.height_m, &one.acceleration_mps2[2]),
        (Pair::Slope, &one.slope[0], &one.slope[1]),
        (Pair::HorizontalVelocity, &one.velocity_mps[0], &one.velocity_mps[1]),
        (Pair::HorizontalAcceleration, &one.acceleration_mps2[0], &one.acceleration_mps2[1]),
        (Pair::Displacement, &one.displacement_m[0], &one.displacement_m[1]),
        (Pair::SlopeRate, &one.slope_rate_per_s[0], &one.slope_rate_per_s[1]),
    ];
    std::thread::scope(|scope| {
        for (pair, first, second) in pairs {
            let (surface, phasors) = (&surface, &phasors);
            scope.spawn(move || {
                let mut found = [vec![0.0; first.len()], vec![0.0; first.len()]];
                let [a, b] = &mut found;
                Transform::new(surface).run(phasors, pair, a, b);
                assert!(found[0] == *first && found[1] == *second, "{pair:?}");
            });
        }
    });
}

#[test]
fn a_narrow_swell_keeps_its_height_period_and_direction() {
    for (shape, direction_rad, depth_m) in [
        (SwellShape::Gaussian { relative_width: 0.02 }, 2.2f64, None),
        (SwellShape::Gaussian { relative_width: 0.1 }, -0.4, Some(10.0)),
        (SwellShape::Jonswap { peak_enhancement: 8.0 }, 0.0, None),
    ] {
        let dispersion = Dispersion { capillary: false, depth_m };
        let swell =
            Swell { significant_height_m: 2.0, peak_period_s: 8.0, direction_rad, spread_rad: 0.12, shape };
        let train = SwellTrain::new(&swell, dispersion).unwrap();
        let grid = Grid::new(128, 128, 4.0).unwrap();
        let surface = Surface::synthesise(grid, &train, dispersion, 6, Averaging::Automatic).unwrap();
        let height_m = 4.0 * surface.expected().variance_m2.sqrt();
        // The mean direction and frequency of the energy drawn.
        let dk = grid.wave_number_step_rad_m();
        let (mut east, mut north, mut omega, mut total) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..128 {
            for j in 0..128 {
                let (Some(mx), Some(my)) = (grid.wave_index_x(i), grid.wave_index_y(j)) else { continue };
                let energy = surface.amplitude_m()[i * 128 + j].norm_sqr();
                let (kx, ky) = (mx as f64 * dk[0], my as f64 * dk[1]);
                let k = kx.hypot(ky);
                if energy > 0.0 {
                    east += energy * kx / k;
                    north += energy * ky / k;
                    omega += energy * dispersion.angular_frequency_rad_s(k);
                    total += energy;
                }
            }
        }
        let period_s = std::f64::consts::TAU * total / omega;
        let off_rad = (Complex64::new(east, north) * Complex64::cis(-direction_rad)).arg();
        println!("{shape:?}: Hs {height_m:.4} m, mean period {period_s:.2} s, off by {off_rad:.3} rad");
        // JONSWAP falls as (w/wp)^-5: beyond the Nyquist number of 4 m facets, w/wp = 3.5, lie
        // 3.5^-4/4 = 1.6e-3 of a total of 0.5, so 1.6e-3 of the height; of a Gaussian nothing.
        assert!((height_m - 2.0).abs() < 0.01);
        // JONSWAP's mean period is 0.87 of its peak period at gamma 8; one draw of some tens of waves
        // scatters by the spread over the root of their number.
        assert!((0.84..1.05).contains(&(period_s / 8.0)) && off_rad.abs() < 0.06);
    }
}

#[test]
fn a_state_comes_back_and_no_other_bytes_do() {
    let surface = sea([10, 9], 5.0, Dispersion { capillary: true, depth_m: Some(3.0) }, u64::MAX);
    let mut file = Vec::new();
    surface.save(&mut file).unwrap();
    assert_eq!(Surface::load(&mut file.as_slice()).unwrap(), surface);
    for length in 0..file.len() {
        assert!(Surface::load(&mut &file[..length]).is_err(), "{length} bytes");
    }
    for at in 0..file.len() {
        for bit in [0x01, 0x80] {
            let mut damaged = file.clone();
            damaged[at] ^= bit;
            assert!(Surface::load(&mut damaged.as_slice()).is_err(), "byte {at}");
        }
    }
    file.push(0);
    let error = Surface::load(&mut file.as_slice()).unwrap_err();
    assert_eq!(error.to_string(), "sea state: bytes follow after the end");
}
