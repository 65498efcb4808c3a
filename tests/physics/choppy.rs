//! Choppy waves: a single wave in closed form, skewness beside Tayfun (1980) and Longuet-Higgins (1963), mean
//! level, conserved area, slopes beside chords.

use std::f64::consts::TAU;

use nereus::scene::Patch;
use nereus::scene::sea::{PatchPlace, Realisation, Waves};
use nereus::scene::water::{Development, Dispersion, SpectrumKind, WindProfile};
use nereus::sea::facet_surface::FacetSurface;
use nereus::sea::spectrum::{Spectrum, WaveVector, of_kind};
use nereus::sea::surface::choppy::{Choppy, LEAST_AREA, interaction_radpm};
use nereus::sea::surface::{Averaging, Fields, Grid, Selection, Surface};
use nereus::sea::wind::Wind;
use num_complex::Complex64;

use super::modulation::powers;
use super::radar_scenes::scene;
use super::sea_paths::sea;

/// Waves of the grid with a variance of their own, m^2, each at the point of the plane that it is nearest to.
#[derive(Debug)]
struct Few {
    waves: Vec<([f64; 2], f64)>,
    step: [f64; 2],
}

impl Spectrum for Few {
    fn omnidirectional_m3(&self, _: f64) -> f64 {
        0.0
    }
    fn spreading_per_rad(&self, _: WaveVector) -> f64 {
        0.0
    }
    fn peak_rad_m(&self) -> f64 {
        self.waves[0].0[0].hypot(self.waves[0].0[1])
    }
    fn wave_m4(&self, k: WaveVector) -> f64 {
        let near = |[x, y]: [f64; 2]| {
            (k.x_rad_m - x).abs() < 0.5 * self.step[0] && (k.y_rad_m - y).abs() < 0.5 * self.step[1]
        };
        let found = self.waves.iter().filter(|(at, _)| near(*at)).map(|(_, variance)| variance);
        found.sum::<f64>() / (self.step[0] * self.step[1])
    }
}

/// Waves of numbers of the grid and variances, m^2.
fn few(grid: Grid, waves: &[([i64; 2], f64)], seed: u64) -> Surface {
    let step = grid.wave_number_step_rad_m();
    let waves = waves.iter().map(|&([x, y], variance)| ([x as f64 * step[0], y as f64 * step[1]], variance));
    let spectrum = Few { waves: waves.collect(), step };
    Surface::synthesise(grid, &spectrum, Dispersion::default(), seed, Averaging::Points).unwrap()
}

fn elfouhaily(grid: Grid, wind_mps: f64, seed: u64) -> Surface {
    let wind = Wind::from_speed(wind_mps, 10.0, WindProfile::Cardone, 0.6).unwrap();
    let kind = SpectrumKind::Elfouhaily { development: Development::default() };
    let spectrum = of_kind(&kind, &wind).unwrap();
    Surface::synthesise(grid, spectrum.as_ref(), Dispersion::default(), seed, Averaging::Points).unwrap()
}

/// The facets of a whole grid at a time.
fn fields(surface: &Surface, choppy: Option<Choppy>, time_s: f64) -> (Patch, Fields<f64>) {
    let [x, y] = surface.grid().period_m();
    let facet_m = surface.grid().facet_m();
    let patch = Patch::new([x, y], facet_m, [0.5 * x, 0.5 * y]).unwrap();
    let mut facets = FacetSurface::<f64>::new(surface, Selection::ALL).with_choppy(choppy);
    let mut fields = facets.fields(&patch);
    facets.evaluate(time_s, &patch, &mut fields).unwrap();
    (patch, fields)
}

#[test]
fn a_single_wave_is_gerstners() {
    let grid = Grid::new(64, 48, 1.0).unwrap();
    for number in [[2, 0], [-1, 2], [0, 3]] {
        let surface = few(grid, &[(number, 0.4)], 3);
        let step = grid.wave_number_step_rad_m();
        let [kx, ky] = [number[0] as f64 * step[0], number[1] as f64 * step[1]];
        let k = kx.hypot(ky);
        let omega = (9.81 * k).sqrt();
        let drawn: Complex64 = surface.amplitude_m().iter().sum();
        let (a, begin) = (2.0 * drawn.norm(), drawn.arg());
        assert!(k * a > 0.05, "nothing to be seen of {number:?}");
        let (patch, of) = fields(&surface, Some(Choppy::of(&surface)), 4.7);
        // Slopes squared over horizontal space, and times the cosine of the phase: above and below the mean
        // level.
        let (mut square, mut upper) = (0.0, 0.0);
        for i in 0..patch.len() {
            let [x, y] = patch.centre_m(patch.key(i));
            let (sin, cos) = (kx * x + ky * y - omega * 4.7 + begin).sin_cos();
            let area = 1.0 - k * a * cos;
            let own = (of.slope[0][i].powi(2) + of.slope[1][i].powi(2)) * of.area[i] / patch.len() as f64;
            (square, upper) = (square + own, upper + own * cos);
            // Trochoid, raised to a mean level of zero: Stokes' second order.
            let expected = [
                (of.height_m[i], a * cos + 0.5 * k * a * a),
                (of.area[i], area),
                (of.slope[0][i], -kx * a * sin / area),
                (of.slope[1][i], -ky * a * sin / area),
                (of.velocity_mps[0][i], kx / k * a * omega * cos),
                (of.velocity_mps[2][i], a * omega * sin),
                (of.acceleration_mps2[2][i], -a * omega * omega * cos),
                (of.displacement_m[0][i], -kx / k * a * sin),
            ];
            for (n, (found, wanted)) in expected.into_iter().enumerate() {
                assert!((found - wanted).abs() < 1e-9, "{number:?} facet {i}, {n}: {found} {wanted}");
            }
        }
        // Integrals of sin^2/(1 - e cos) and sin^2 cos/(1 - e cos), e the steepness; half of e^2 and none of
        // linear waves.
        let e = k * a;
        let root = (1.0 - e * e).sqrt();
        let crests = (1.0 - root - 0.5 * e * e) / e;
        assert!((square - (1.0 - root)).abs() < 1e-12 && (upper - crests).abs() < 1e-12, "{square} {upper}");
        assert!(upper > 0.02 * square, "crests are no steeper than troughs");
    }
}

/// Mean, variance and third central moment of heights with weights.
fn moments(height_m: &[f64], weight: impl Fn(usize) -> f64) -> [f64; 3] {
    let mean = |power: i32, about: f64| {
        let (mut sum, mut all) = (0.0, 0.0);
        for (i, z) in height_m.iter().enumerate() {
            (sum, all) = (sum + weight(i) * (z - about).powi(power), all + weight(i));
        }
        sum / all
    };
    let first = mean(1, 0.0);
    [first, mean(2, first), mean(3, first)]
}

/// What choppy waves add to the skewness of the same linear ones, the mean level over horizontal space, m,
/// and the largest error of the area, over some seeds.
fn added(of: impl Fn(u64) -> Surface, seeds: u64, expected: impl Fn(&Surface) -> f64) -> [f64; 4] {
    let mut ratios = Vec::new();
    let (mut level_m, mut area) = (0.0, 0f64);
    for seed in 0..seeds {
        let surface = of(seed);
        let wanted = expected(&surface);
        // At one time: those of a narrow sea stay what they are for long.
        let (_, plain) = fields(&surface, None, 1000.0);
        let (_, choppy) = fields(&surface, Some(Choppy::of(&surface)), 1000.0);
        let [_, v0, m0] = moments(&plain.height_m, |_| 1.0);
        let [mean, _, m1] = moments(&choppy.height_m, |i| choppy.area[i]);
        // Referred to the variance of the whole sea: a ratio of sample moments is skewed itself.
        let variance = 2.0 * surface.amplitude_m().iter().map(|a| a.norm_sqr()).sum::<f64>();
        ratios.push((m1 - m0) / variance.powf(1.5) / wanted);
        level_m += mean / v0.sqrt() / seeds as f64;
        let sum: f64 = choppy.area.iter().sum();
        let folded = choppy.area.iter().any(|area| *area < LEAST_AREA + 1e-9);
        area = area.max(if folded { 0.0 } else { (sum / choppy.area.len() as f64 - 1.0).abs() });
    }
    let count = ratios.len() as f64;
    let mean = ratios.iter().sum::<f64>() / count;
    let scatter = (ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (count - 1.0) / count).sqrt();
    [mean, scatter, level_m, area]
}

#[test]
fn narrow_seas_have_tayfuns_skewness() {
    // Waves of 32 m within 4 %, steepness k sigma = 0.03, one way.
    let grid = Grid::new(8192, 1, 2.0).unwrap();
    let step = grid.wave_number_step_rad_m()[0];
    let middle = (TAU / 32.0 / step).round() as i64;
    let k = middle as f64 * step;
    let sigma = 0.03 / k;
    let waves: Vec<_> =
        (-60..=60).map(|n| ([middle + n, 0], (-0.5 * (n as f64 / 20.0).powi(2)).exp())).collect();
    let all: f64 = waves.iter().map(|(_, v)| v).sum();
    let waves: Vec<_> = waves.iter().map(|&(n, v)| (n, v * sigma * sigma / all)).collect();
    // Tayfun 1980: 3 k sigma.
    let [ratio, scatter, level, area] = added(
        |seed| few(grid, &waves, seed),
        150,
        |surface| {
            let of = |power: i32| -> f64 {
                surface.amplitude_m().iter().map(|a| (2.0 * a.norm_sqr()).powi(power)).sum()
            };
            // A wave alone is Stokes': half as skewed as waves whose heights are drawn.
            3.0 * k * (of(1).powi(2) - 0.5 * of(2)) / of(1).powf(1.5)
        },
    );
    println!("narrow: {ratio:.3} +- {scatter:.3} of Tayfun's, level {level:.1e} sigma, area {area:.1e}");
    assert!((ratio - 1.0).abs() < 3.0 * scatter + 5e-3 && scatter < 0.02, "{ratio} {scatter}");
    assert!(level.abs() < 1e-3 && area < 1e-12, "{level} {area}");
}

/// Longuet-Higgins 1963, (3.7) and (3.8), deep water: skewness from every pair of waves of a surface.
fn longuet_higgins(surface: &Surface) -> f64 {
    let grid = surface.grid();
    let step = grid.wave_number_step_rad_m();
    let mut waves = Vec::new();
    for (i, row) in surface.amplitude_m().chunks_exact(grid.ny()).enumerate() {
        for (j, a) in row.iter().enumerate().filter(|(_, a)| a.norm() > 0.0) {
            let k = [
                grid.wave_index_x(i).unwrap() as f64 * step[0],
                grid.wave_index_y(j).unwrap() as f64 * step[1],
            ];
            waves.push((k, 2.0 * a.norm_sqr()));
        }
    }
    let kernel = |a: [f64; 2], b: [f64; 2]| {
        let (p, q) = (a[0].hypot(a[1]).sqrt(), b[0].hypot(b[1]).sqrt());
        let dot = a[0] * b[0] + a[1] * b[1];
        let b_of = |sign: f64| {
            let square = (p + sign * q).powi(2);
            let length = (a[0] + sign * b[0]).hypot(a[1] + sign * b[1]);
            if square < 1e-18 { 0.0 } else { square * (dot - sign * p * p * q * q) / (square - length) }
        };
        (b_of(-1.0) + b_of(1.0) - dot + (p * p + q * q) * p * q) / (p * q)
    };
    let (mut sum, mut variance) = (0.0, 0.0);
    for (n, (a, of)) in waves.iter().enumerate() {
        variance += of;
        // Of waves of known height: a wave alone has half of what it has in the mean of waves that are drawn.
        sum += 0.5 * of * of * kernel(*a, *a);
        sum += 2.0 * waves[n + 1..].iter().map(|(b, with)| of * with * kernel(*a, *b)).sum::<f64>();
    }
    3.0 * sum / variance.powf(1.5)
}

#[test]
fn broad_seas_have_longuet_higgins_skewness() {
    let grid = Grid::new(64, 64, 5.0).unwrap();
    let surface = elfouhaily(grid, 10.0, 1);
    let (every, classes) = (longuet_higgins(&surface), Choppy::of(&surface).skewness());
    println!("every pair {every:.4}, in classes {classes:.4}");
    assert!((classes / every - 1.0).abs() < 0.02, "{classes} {every}");
    // What waves that run one way in a narrow band would have is a third more.
    let [ratio, scatter, level, area] =
        added(|seed| elfouhaily(grid, 10.0, seed), 150, |surface| Choppy::of(surface).skewness());
    println!(
        "broad: {ratio:.3} +- {scatter:.3} of Longuet-Higgins', level {level:.1e} sigma, area {area:.1e}"
    );
    assert!((ratio - 1.0).abs() < 3.0 * scatter + 0.01 && scatter < 0.02, "{ratio} {scatter}");
    assert!(level.abs() < 3e-3 && area < 1e-12, "{level} {area}");
}

#[test]
fn the_interaction_has_its_limits() {
    // One way: the smaller wave number (Stokes where they are the same), along any direction.
    for (a, b) in [(0.1, 0.1), (0.1, 0.3), (2.0, 0.01)] {
        let [x, y] = [0.8, -0.6];
        let found = interaction_radpm([a * x, a * y], [b * x, b * y]);
        assert!((found - a.min(b)).abs() < 1e-9, "{a} {b}: {found}");
    }
    for angle in [0.3f64, 1.0, 2.0, 3.0] {
        let other = [0.2 * angle.cos(), 0.2 * angle.sin()];
        let [there, back] = [interaction_radpm([0.1, 0.0], other), interaction_radpm(other, [0.1, 0.0])];
        let same = interaction_radpm([0.2, 0.0], other);
        // Equal waves: 1 + 2 s^2 - 4 s^2/(2 - c), c and s of half the angle.
        let (s, c) = (0.5 * angle).sin_cos();
        let expected = 0.2 * (1.0 + 2.0 * s * s - 4.0 * s * s / (2.0 - c));
        assert!((there - back).abs() < 1e-15 && there > 0.0 && (same - expected).abs() < 1e-12, "{angle}");
    }
}

#[test]
fn slopes_are_those_of_the_displaced_surface() {
    // Waves of 16 m and more on facets of 0.25 m: chords are off by (k h)^2/6, 1.6e-3 of a slope.
    let grid = Grid::new(256, 256, 0.25).unwrap();
    let waves: Vec<_> = [([4, 0], 0.004), ([3, 2], 0.004), ([1, -2], 0.02), ([-2, 1], 0.01)].to_vec();
    let surface = few(grid, &waves, 9);
    let (patch, of) = fields(&surface, Some(Choppy::of(&surface)), 12.0);
    let (mut worst, mut steepest, mut linear) = (0f64, 0f64, 0f64);
    let (_, plain) = fields(&surface, None, 12.0);
    for iy in 1..255 {
        for ix in 1..255 {
            let i = iy * 256 + ix;
            let slope = [of.slope[0][i], of.slope[1][i]];
            steepest = steepest.max(slope[0].hypot(slope[1]));
            for step in [1, 256] {
                let place = |at: usize| {
                    let [x, y] = patch.centre_m(patch.key(at));
                    [x + of.displacement_m[0][at], y + of.displacement_m[1][at], of.height_m[at]]
                };
                let (a, b) = (place(i - step), place(i + step));
                let [dx, dy, dz] = [0, 1, 2].map(|c| b[c] - a[c]);
                let run = dx.hypot(dy);
                worst = worst.max(((slope[0] * dx + slope[1] * dy - dz) / run).abs());
                linear = linear.max(((plain.slope[0][i] * dx + plain.slope[1][i] * dy - dz) / run).abs());
            }
        }
    }
    println!("slopes up to {steepest:.3}, off chords by {worst:.1e}, linear ones {linear:.1e}");
    assert!(worst < 3e-3 * steepest && linear > 0.05 * steepest, "{worst} {linear}");
}

#[test]
fn folds_are_limited() {
    // Far steeper than water: facets would turn over.
    let grid = Grid::new(32, 32, 1.0).unwrap();
    let surface = few(grid, &[([4, 0], 0.5), ([3, 3], 0.5), ([0, 5], 0.5)], 2);
    let (_, of) = fields(&surface, Some(Choppy::of(&surface)), 0.0);
    let folded = of.area.iter().filter(|area| **area < LEAST_AREA + 1e-9).count();
    assert!(folded > 10 && of.area.iter().all(|area| *area >= LEAST_AREA - 1e-9), "{folded}");
    assert!(of.slope.iter().flatten().all(|slope| slope.is_finite()));
    // Those of a sea in a fresh gale, on facets of 1 m: next to none.
    let surface = elfouhaily(Grid::new(256, 256, 1.0).unwrap(), 15.0, 4);
    let (_, of) = fields(&surface, Some(Choppy::of(&surface)), 0.0);
    let folded = of.area.iter().filter(|area| **area < LEAST_AREA + 1e-9).count();
    println!("{folded} of {} facets folded at 15 m/s", of.area.len());
    assert!(folded < 10, "{folded}");
}

#[test]
fn facets_return_by_their_area() {
    // One wave that runs across the line of sight: tilts hardly matter, and areas do.
    let mut water = sea(24, 2.0, 0.0);
    let grid = Grid::new(24, 24, 2.0).unwrap();
    let surface = few(grid, &[([0, 2], 0.2)], 5);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("one.sea");
    surface.save(&mut std::fs::File::create(&path).unwrap()).unwrap();
    water.realisation = Realisation::Saved { path };
    assert_eq!(water.place, PatchPlace::Fixed);
    let linear = powers(water.clone(), 40);
    water.waves = Waves::Choppy;
    let patch = water.patch;
    let choppy = powers(water, 40);
    assert_eq!((linear.len(), choppy.len()), (576, 576));
    let t_s = 40.0 / scene().radar.emissions.mean_prf_hz();
    let mut sheet =
        FacetSurface::<f64>::new(&surface, Selection::HEIGHT).with_choppy(Some(Choppy::of(&surface)));
    let mut of = sheet.fields(&patch);
    sheet.evaluate(t_s, &patch, &mut of).unwrap();
    let (mut worst, mut least) = (0f64, 1f64);
    for i in 0..576 {
        worst = worst.max((choppy[i] / linear[i] / of.area[i] - 1.0).abs());
        least = least.min(of.area[i]);
    }
    // Crests that crowd are as many as troughs that spread: of the area, and so of the mean power.
    let mean = of.area.iter().sum::<f64>() / 576.0;
    println!("areas from {least:.3}, {mean:.6} in the mean, powers off them by {worst:.1e}");
    assert!(least < 0.95 && worst < 0.01 && (mean - 1.0).abs() < 1e-3, "{least} {worst} {mean}");
}

/// Waves of light wind on coarse facets are lower than an atom, down to where their squares are no numbers.
#[test]
fn all_winds_over_all_facets_have_finite_crests() {
    let steps = |from: f64, to: f64, count: u32| {
        (0..count).map(move |n| from * (to / from).powf(f64::from(n) / f64::from(count - 1)))
    };
    let legal = steps(0.3, 40.0, 40).flat_map(|wind_mps| steps(1e-4, 1e5, 46).map(move |f| (wind_mps, f)));
    let (mut least, mut flat) = (f64::INFINITY, 0);
    for (wind_mps, facet_m) in legal.chain([(0.3, 1.0), (1.5, 30.0), (0.3, 1.2), (1.5, 26.0)]) {
        let wind = Wind::from_speed(wind_mps, 10.0, WindProfile::Cardone, 0.4).unwrap();
        let kind = SpectrumKind::Elfouhaily { development: Development::default() };
        let spectrum = of_kind(&kind, &wind).unwrap();
        let grid = Grid::new(16, 16, facet_m).unwrap();
        let surface =
            Surface::synthesise(grid, spectrum.as_ref(), Dispersion::default(), 1, Averaging::Points)
                .unwrap();
        let found = Choppy::of(&surface);
        let numbers = [found.level_radpm, found.offset_m, found.variance_m2, found.skewness()];
        assert!(numbers.iter().all(|x| x.is_finite()), "{wind_mps} m/s, {facet_m} m: {found:?}");
        if found.variance_m2 > 0.0 {
            least = least.min(found.variance_m2);
        } else {
            flat += 1;
        }
    }
    println!("{flat} are flat; the lowest of the others has {least:e} m^2");
    assert!(flat > 0 && least < 1e-20, "{flat} {least}");
}
