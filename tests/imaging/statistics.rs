//! `kdist`, `ward_baker_watts`: every row; shapes of synthetic samples.

use std::path::PathBuf;

use nereus::imaging::statistics::{KLaw, sea_shape};
use nereus::rng::{Room, stream};
use proptest::prelude::*;
use rand_distr::{Distribution, Exp1, Gamma};

fn rows(name: &str) -> Vec<Vec<String>> {
    let folder = std::env::var_os("NEREUS_GOLDEN")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/golden"), PathBuf::from);
    let mut reader = csv::Reader::from_path(folder.join(name)).unwrap();
    let rows: Vec<Vec<String>> =
        reader.records().map(|r| r.unwrap().iter().map(|v| v.trim().to_owned()).collect()).collect();
    assert!(rows.len() > 20);
    rows
}

#[test]
fn the_k_law_is_that_of_the_golden_rows() {
    for row in rows("kdist.csv") {
        let v: Vec<f64> = row.iter().map(|v| v.parse().unwrap()).collect();
        let law = KLaw { shape: v[0], scale: v[1] };
        // 12 digits are printed, of z and b too; 1 - x leaves 1e-14 of small probabilities.
        for (found, wanted) in [(law.density(v[2]), v[3]), (law.probability(v[2]), v[4])] {
            assert!((found - wanted).abs() < 1e-9 * wanted + 2e-14, "{row:?}: {found}");
        }
    }
}

#[test]
fn large_shapes_are_rayleigh_and_its_first_corrections() {
    // Rayleigh's law over a gamma law of the power P of mean 1 and variance 1/nu: the n-th derivative over P, times P^n, is
    // (-1)^n n! L_n(u) of the law itself, u = z^2, L_n Laguerre's polynomial; the moments are 1/nu, 2/nu^2, 3/nu^2 + 6/nu^3, 20/nu^3, 15/nu^3.
    let laguerre = |u: f64| {
        let mut l = [1.0, 1.0 - u, 0.0, 0.0, 0.0];
        for n in 1..4 {
            let k = n as f64;
            l[n + 1] = ((2.0 * k + 1.0 - u) * l[n] - k * l[n - 1]) / (k + 1.0);
        }
        l
    };
    for shape in [1e3, 1e4, 1e5, 1e6, 1e8] {
        let law = KLaw { shape, scale: 2.0 * f64::sqrt(shape) };
        for z in [1e-6, 1e-3, 0.03, 0.3, 0.8, 1.0, 1.7, 2.5, 3.5] {
            let u = z * z;
            let l = laguerre(u);
            let correction = l[2] / shape + (3.0 * l[4] - 2.0 * l[3]) / (shape * shape);
            let wanted = 2.0 * z * (-u).exp() * (1.0 + correction);
            // |L_n| < e^{u/2}: (6 + 20 + 15)/nu^3 are left out, and a tenth of that. Rounding: 2^-52 nu ln nu, a few times.
            let within = 45.0 * (0.5 * u).exp() / shape.powi(3) + 1e-15 * shape * shape.ln() + 1e-13;
            let found = law.density(z);
            assert!((found / wanted - 1.0).abs() < within, "{shape} {z}: {found} {wanted}");
            // The law itself is the integral of the density; to first order 1 - P = e^-u (1 + u (u - 2)/(2 nu)).
            // Left out: the integral of (3 + 2) e^{-u/2}/nu^2, ten times e^{-u/2}/nu^2, and a fifth of that.
            let tail = (-u).exp() * (1.0 + u * (u - 2.0) / (2.0 * shape));
            let within = 12.0 * (0.5 * u).exp() / shape.powi(2) + 1e-15 * shape * shape.ln() + 1e-13;
            let found = 1.0 - law.probability(z);
            assert!((found - tail).abs() < within * tail + 1e-15, "{shape} {z}: {found} {tail}");
        }
    }
}

#[test]
fn an_infinite_shape_is_rayleigh() {
    let power = 3e-15;
    let law = KLaw { shape: f64::INFINITY, scale: 2.0 / f64::sqrt(power) };
    for z in [1e-9, 3e-8, 5e-8, 2e-7] {
        let u = z * z / power;
        assert!((law.density(z) / (2.0 * z / power * (-u).exp()) - 1.0).abs() < 1e-14);
        assert!((law.probability(z) / -(-u).exp_m1() - 1.0).abs() < 1e-14);
    }
    // Powers that vary less than Rayleigh's: their law keeps the mean.
    let fit = KLaw::by_moments(&[1.0, 3.0, 2.0, 2.0]).unwrap();
    assert_eq!((fit.law.shape, fit.law.scale), (f64::INFINITY, 2.0 / f64::sqrt(2.0)));
    // The median of z^2 is ln 2 of the mean.
    assert!((fit.law.probability(f64::sqrt(2.0 * std::f64::consts::LN_2)) - 0.5).abs() < 1e-15);
}

proptest! {
    #[test]
    fn any_law_gives_numbers(shape in -2.0..9.0f64, scale in -200.0..200.0f64, z in -320.0..308.0f64) {
        let law = KLaw { shape: 10f64.powf(shape), scale: 10f64.powf(scale) };
        for z in [10f64.powf(z), 10f64.powf(z / 300.0) / law.scale, f64::INFINITY] {
            let (density, probability) = (law.density(z), law.probability(z));
            prop_assert!(density >= 0.0 && (0.0..=1.0).contains(&probability), "{law:?} {z}: {density} {probability}");
            // Shapes below 1/2 have a pole at zero.
            prop_assert!(density.is_finite() || z < 1e-100, "{law:?} {z}: {density}");
        }
    }
}

#[test]
fn shapes_of_sea_clutter_are_those_of_the_golden_rows() {
    for row in rows("ward_baker_watts.csv") {
        let v = |i: usize| row[i].parse::<f64>().unwrap();
        let found = sea_shape(v(0), [v(1), v(2)], v(3).to_radians(), row[4] == "VV");
        assert!((found / v(5) - 1.0).abs() < 1e-9, "{row:?}: {found}");
    }
}

#[test]
fn shapes_of_samples_come_back_within_their_error() {
    let samples = 100_000;
    let mut normalised = Vec::new();
    for (i, shape) in [0.7, 1.5, 4.0].into_iter().enumerate() {
        for trial in 0..20 {
            // Any of the program's streams will do; the seed is this test's.
            let mut numbers = stream(77, Room::SampledPulses, i as u64, trial);
            let texture = Gamma::new(shape, 3e-15 / shape).unwrap();
            let powers: Vec<f64> = (0..samples)
                .map(|_| {
                    let speckle: f64 = Exp1.sample(&mut numbers);
                    speckle * texture.sample(&mut numbers)
                })
                .collect();
            let fit = KLaw::by_moments(&powers).unwrap();
            normalised.push((fit.contrast - 2.0 * (1.0 + 1.0 / shape)) / fit.contrast_error);
            assert!((fit.law.shape - shape).abs() < 5.0 * fit.shape_error, "{shape}: {fit:?}");
            // <z^2> = 4 nu / b^2.
            let power: f64 = 4.0 * fit.law.shape / fit.law.scale.powi(2);
            assert!((power / 3e-15 - 1.0).abs() < 0.05, "{fit:?}");
        }
    }
    let n = normalised.len() as f64;
    let rms = (normalised.iter().map(|x| x * x).sum::<f64>() / n).sqrt();
    println!("deviation over stated error: {rms:.2} rms of {n}");
    // 1, to sqrt(1/2n) = 9 %; heavy tails make the fourth moment of a sample, and with it the error, too small at times: 1.5.
    assert!((0.7..1.5).contains(&rms), "{rms}");
}
