//! Laws of clutter: `kdist`, `ward_baker_watts`, every row; fits of synthetic samples and their errors;
//! goodness; extremes.

use std::path::PathBuf;

use nereus::clutter::{
    Fit, KLaw, Kind, Law, Sample, SampleFault, blocks, goodness, histogram, likelihood, moments, regression,
    sea_shape, trend,
};
use nereus::rng::{Room, stream};
use proptest::prelude::*;
use rand_distr::{Distribution, Exp1, StandardNormal};
use rayon::prelude::*;

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
    // Rayleigh's law over a gamma law of the power P of mean 1 and variance 1/nu: the n-th derivative over P,
    // times P^n, is (-1)^n n! L_n(u) of the law itself, u = z^2, L_n Laguerre's polynomial; the moments are
    // 1/nu, 2/nu^2, 3/nu^2 + 6/nu^3, 20/nu^3, 15/nu^3.
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
            // The law itself is the integral of the density; to first order 1 - P = e^-u (1 + u (u - 2)/(2
            // nu)). Left out: the integral of (3 + 2) e^{-u/2}/nu^2, ten times e^{-u/2}/nu^2, and a fifth of
            // that.
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
    let sample = Sample::new(&[1.0, 3.0, 2.0, 2.0]).unwrap();
    for fit in [moments::fit, likelihood::fit] {
        let law = fit(&sample, Kind::K).law;
        assert!(law.shape() == f64::INFINITY && (law.mean_power() / 2.0 - 1.0).abs() < 1e-12, "{law:?}");
    }
    let law = KLaw::new(f64::INFINITY, 2.0);
    // The median of z^2 is ln 2 of the mean.
    assert!((law.probability(f64::sqrt(2.0 * std::f64::consts::LN_2)) - 0.5).abs() < 1e-15);
}

proptest! {
    #![proptest_config(crate::cases::proptests(256))]

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

/// A method, by name.
type Method = (&'static str, fn(&Sample, Kind) -> Fit);
const METHODS: [Method; 3] =
    [("moments", moments::fit), ("likelihood", likelihood::fit), ("histogram", histogram::fit)];

fn powers(law: &Law, count: usize, seed: u64, part: u64) -> Vec<f64> {
    // Any of the program's streams will do; the seed is the test's.
    let mut numbers = stream(seed, Room::SampledPulses, 0, part);
    (0..count).map(|_| law.draw(&mut numbers).powi(2)).collect()
}

/// Deviations of the shape (of `1/nu` of a K law) and of the logarithm of the mean power over their stated
/// errors, `[trial]`.
fn deviations(
    law: &Law,
    count: usize,
    trials: u64,
    seed: u64,
    fit: fn(&Sample, Kind) -> Fit,
) -> Vec<[f64; 2]> {
    (0..trials)
        .into_par_iter()
        .map(|trial| {
            let fit = fit(&Sample::new(&powers(law, count, seed, trial)).unwrap(), law.kind());
            let form = match law.kind() {
                Kind::K => (fit.law.shape().recip() - law.shape().recip()) / fit.inverse_error,
                _ => (fit.law.shape() - law.shape()) / fit.shape_error.max(1e-300),
            };
            [form, (fit.law.mean_power() / law.mean_power()).ln() / fit.power_error]
        })
        .collect()
}

fn mean_and_rms(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    [mean, (values.map(|x| x * x).sum::<f64>() / n).sqrt()]
}

#[test]
fn parameters_come_back_and_the_stated_errors_are_those_of_many_seeds() {
    let trials = 100;
    for (kind, shape) in [
        (Kind::K, 0.5),
        (Kind::K, 1.5),
        (Kind::K, 5.0),
        (Kind::Weibull, 0.8),
        (Kind::Weibull, 1.7),
        (Kind::Rayleigh, 2.0),
    ] {
        // Powers of the order of an echo.
        let law = Law::new(kind, shape, 3e-15);
        for (name, fit) in METHODS.into_iter().skip(1) {
            let found = deviations(&law, 4000, trials, 77, fit);
            for (axis, what) in ["shape", "power"].into_iter().enumerate() {
                let [mean, rms] = mean_and_rms(found.iter().map(|d| d[axis]));
                println!(
                    "{law:?} by {name}: {what} off by {mean:+.2} in the mean, {rms:.2} rms, of its error"
                );
                if kind == Kind::Rayleigh && axis == 0 {
                    assert_eq!(rms, 0.0, "{law:?}");
                    continue;
                }
                // The rms of 100 is known to 7 %, the mean to 0.1; a bias of second order is 1/sqrt(4000) of
                // an error, a few times.
                assert!((0.8..1.2).contains(&rms), "{law:?} {name} {what}: {rms}");
                assert!(mean.abs() < 0.4, "{law:?} {name} {what}: {mean}");
            }
        }
    }
}

#[test]
fn shapes_by_moments_come_back_within_their_error() {
    for (kind, shape) in [(Kind::K, 0.7), (Kind::K, 1.5), (Kind::K, 4.0), (Kind::Weibull, 1.1)] {
        let law = Law::new(kind, shape, 3e-15);
        let found = deviations(&law, 50_000, 40, 78, moments::fit);
        let [mean, rms] = mean_and_rms(found.iter().map(|d| d[0]));
        println!("{law:?}: {mean:+.2} in the mean, {rms:.2} rms");
        // 1, to sqrt(1/2n) = 11 %; heavy tails make the fourth moment of a sample, and with it the error, too
        // small at times: 1.5.
        assert!((0.7..1.5).contains(&rms) && found.iter().all(|d| d[0].abs() < 5.0), "{law:?}: {rms}");
        let [mean, rms] = mean_and_rms(found.iter().map(|d| d[1]));
        assert!((0.7..1.3).contains(&rms) && mean.abs() < 0.6, "{law:?}: {mean} {rms}");
    }
}

/// 500 powers that any language can make: quantiles of `E^1.7`, E exponential.
fn quantiles() -> Sample {
    let powers: Vec<f64> =
        (0..500).map(|i| -(-(f64::from(i) + 0.5) / 500.0).ln_1p()).map(|e| e.powf(1.7)).collect();
    Sample::new(&powers).unwrap()
}

#[test]
fn fits_are_those_of_another_program() {
    // By scipy 1.x: Nelder and Mead on the likelihood of every power (special.kve), and on the squared
    // distance of the same histogram; errors from the products of numerical scores; roots by brentq. Bins of
    // 0.02 of ln z: 2e-5 of curvature each, far below a thousandth of an error.
    let sample = quantiles();
    let close = |found: f64, wanted: f64, within: f64| {
        assert!((found / wanted - 1.0).abs() < within, "{found} {wanted}")
    };
    assert!((sample.contrast() - 4.109821414955206).abs() < 1e-9);
    let k = likelihood::fit(&sample, Kind::K);
    close(k.law.shape(), 0.6899849522362236, 1e-3);
    close(k.law.mean_power(), 1.5987955830990581, 1e-3);
    close(k.shape_error, 0.051943860083647424, 1e-2);
    close(k.power_error, 0.08867324936330229, 1e-2);
    let weibull = likelihood::fit(&sample, Kind::Weibull);
    let Law::Weibull(law) = weibull.law else { panic!() };
    close(law.shape, 1.1782544050997372, 1e-4);
    close(law.scale, 0.9999539302776375, 1e-4);
    close(moments::fit(&sample, Kind::K).law.shape(), 0.9479475304512738, 1e-9);
    close(moments::fit(&sample, Kind::Weibull).law.shape(), 1.197050273046665, 1e-9);
    let k = histogram::fit(&sample, Kind::K);
    close(k.law.shape(), 0.6604195485666549, 1e-4);
    close(k.law.mean_power(), 1.7697113917765082, 1e-4);
    let weibull = histogram::fit(&sample, Kind::Weibull);
    close(weibull.law.shape(), 1.1754959656903046, 1e-4);
    close(weibull.law.mean_power(), 1.5489501844069562, 1e-4);
    let law = Law::new(Kind::K, 0.6899849522362236, 1.5987955830990581);
    assert!((goodness::distance(&sample, &law) - 0.013454437115258289).abs() < 1e-7);
}

#[test]
fn probabilities_of_the_distance_are_even_where_the_law_is_true() {
    for (kind, shape, trials, resamples) in
        [(Kind::K, 1.0, 50, 9), (Kind::Weibull, 1.3, 120, 39), (Kind::Rayleigh, 2.0, 120, 39)]
    {
        let law = Law::new(kind, shape, 2.0);
        let mut found: Vec<f64> = (0..trials)
            .map(|trial| {
                let sample = Sample::new(&powers(&law, 200, 79, trial)).unwrap();
                goodness::test(&sample, kind, resamples, 1000 + trial).probability.unwrap()
            })
            .collect();
        found.sort_by(f64::total_cmp);
        let n = trials as f64;
        // Even numbers from 1/(1 + B) to 1: the share up to p is p, but for steps of 1/(1 + B).
        let apart = found.iter().enumerate().map(|(i, p)| (p - (i + 1) as f64 / n).abs()).fold(0.0, f64::max);
        println!("{kind:?}: {apart:.3} from even");
        // 1.63/sqrt(n) is passed by one in a hundred.
        assert!(apart < 1.63 / n.sqrt() + 1.0 / (1.0 + resamples as f64), "{kind:?}: {found:?}");
    }
}

#[test]
fn what_is_not_a_law_is_refused_and_what_is_comes_out_the_same_again() {
    let spiky = Sample::new(&powers(&Law::new(Kind::K, 1.0, 1.0), 1000, 80, 0)).unwrap();
    let rayleigh = goodness::test(&spiky, Kind::Rayleigh, 99, 5);
    assert_eq!(rayleigh.probability, Some(0.01));
    assert!(rayleigh.distance > 0.08, "{rayleigh:?}");
    let k = goodness::test(&spiky, Kind::K, 19, 5);
    assert!(k.probability.unwrap() > 0.05 && k.distance < 0.04, "{k:?}");
    assert_eq!(k, goodness::test(&spiky, Kind::K, 19, 5));
    assert_eq!(goodness::test(&spiky, Kind::K, 0, 5).probability, None);
}

#[test]
fn shapes_over_azimuth_come_back_within_their_errors() {
    let psi_rad: Vec<f64> = (0..12).map(|i| f64::from(i) * std::f64::consts::PI / 6.0).collect();
    let mut deviations = Vec::new();
    for trial in 0..200 {
        let mut numbers = stream(81, Room::SampledPulses, 0, trial);
        let value = |psi: &f64| {
            let noise: f64 = StandardNormal.sample(&mut numbers);
            2.0 - 0.5 * (2.0 * psi).cos() + 0.2 * noise
        };
        let values: Vec<f64> = psi_rad.iter().map(value).collect();
        let fit = regression::cosine(&psi_rad, &values).unwrap();
        deviations.push([(fit.mean - 2.0) / fit.mean_error, (fit.amplitude + 0.5) / fit.amplitude_error]);
    }
    for axis in 0..2 {
        let [mean, rms] = mean_and_rms(deviations.iter().map(|d| d[axis]));
        // Student's law of 10 degrees of freedom: rms sqrt(10/8) = 1.118, to 6 %; mean to 0.08.
        assert!((rms - 1.118).abs() < 0.2 && mean.abs() < 0.25, "{mean} {rms}");
    }
    // A line of constants, one azimuth, too few numbers.
    assert!(
        regression::cosine(&[0.0, std::f64::consts::PI, std::f64::consts::TAU], &[1.0, 2.0, 3.0]).is_none()
    );
    assert!(regression::cosine(&[0.0, 1.0], &[1.0, 2.0]).is_none());
    assert!(regression::cosine(&[0.0, 1.0, 2.0], &[1.0, f64::INFINITY, 2.0]).is_none());
}

#[test]
fn extremes_are_reported_or_refused() {
    let refused = |powers: &[f64]| Sample::new(powers).unwrap_err();
    assert!(matches!(refused(&[1.0, f64::NAN]), SampleFault::Power { pixel: 1, .. }));
    assert!(matches!(refused(&[1.0, 2.0, -1.0]), SampleFault::Power { pixel: 2, .. }));
    assert!(matches!(refused(&[f64::INFINITY, 2.0]), SampleFault::Power { pixel: 0, .. }));
    assert_eq!(refused(&[0.0; 10]), SampleFault::Few { samples: 0 });
    assert_eq!(refused(&[0.0, 3.0]), SampleFault::Few { samples: 1 });
    assert_eq!(refused(&[]), SampleFault::Few { samples: 0 });
    let mut cases: Vec<Vec<f64>> = vec![
        vec![2.0; 100],
        vec![1e-300, 1e300],
        vec![1.0, 1.0 + 1e-15],
        vec![5e-324, 5e-324, 1e-323],
        [vec![1e-18; 5000], vec![1e6]].concat(),
    ];
    cases.push(powers(&Law::new(Kind::K, 0.05, 1.0), 3000, 82, 0));
    cases.push(powers(&Law::new(Kind::K, f64::INFINITY, 1.0), 3000, 82, 1));
    for (case, powers) in cases.iter().enumerate() {
        let sample = Sample::new(powers).unwrap();
        for kind in Kind::ALL {
            for (name, fit) in METHODS {
                let fit = fit(&sample, kind);
                let power = fit.law.mean_power();
                assert!(
                    fit.law.shape() > 0.0 && power > 0.0 && power < f64::INFINITY,
                    "{case} {name}: {fit:?}"
                );
                assert!(
                    fit.shape_error >= 0.0 && fit.power_error >= 0.0 && fit.inverse_error >= 0.0,
                    "{case} {name}: {fit:?}"
                );
            }
            let tested = goodness::test(&sample, kind, 1, 1);
            assert!(
                (0.0..=1.0).contains(&tested.distance) && tested.probability.is_some(),
                "{case}: {tested:?}"
            );
        }
    }
    let zeros = Sample::new(&[0.0, 1.0, 2.0, 0.0]).unwrap();
    assert_eq!((zeros.len(), zeros.zeros(), zeros.mean_power()), (2, 2, 1.5));
    // Very spiky, and not at all.
    let spiky = likelihood::fit(&Sample::new(&cases[5]).unwrap(), Kind::K);
    assert!(
        (spiky.law.shape() - 0.05).abs() < 4.0 * spiky.shape_error && spiky.shape_error < 0.005,
        "{spiky:?}"
    );
    for (name, fit) in METHODS {
        let even = fit(&Sample::new(&cases[6]).unwrap(), Kind::K);
        assert!(even.law.shape().recip() < 4.0 * even.inverse_error, "{name}: {even:?}");
    }
}

#[test]
fn few_facets_in_a_cell_lower_the_contrast() {
    // Sums of N phasors of equal power: 2 - 1/N, exactly.
    for facets in [1, 3, 10] {
        let mut numbers = stream(83, Room::SampledPulses, 0, facets);
        let mut power = |_| {
            let (mut re, mut im) = (0.0, 0.0);
            for _ in 0..facets {
                let (a, b): (f64, f64) =
                    (StandardNormal.sample(&mut numbers), StandardNormal.sample(&mut numbers));
                let length = a.hypot(b);
                (re, im) = (re + a / length, im + b / length);
            }
            re * re + im * im
        };
        let sample = Sample::new(&(0..40_000).map(&mut power).collect::<Vec<f64>>()).unwrap();
        let wanted = 2.0 - 1.0 / facets as f64;
        assert!(
            (sample.contrast() - wanted).abs() < 4.0 * sample.contrast_error() + 1e-12,
            "{facets}: {}",
            sample.contrast()
        );
    }
}

#[test]
fn blocks_give_the_error_of_pixels_that_are_alike() {
    let mut numbers = stream(84, Room::SampledPulses, 0, 0);
    let (columns, rows) = (200, 150);
    let image = |numbers: &mut _, wave: f64| -> Vec<f64> {
        let speckle = |i: usize| {
            let speckle: f64 = Exp1.sample(numbers);
            speckle * (1.0 + wave * (0.1 * (i % columns) as f64).sin() * (0.013 * (i / columns) as f64).sin())
        };
        (0..columns * rows).map(speckle).collect()
    };
    // Spread of 1/nu over images, against the error that each gives itself.
    for (wave, least) in [(0.9, 0.5), (0.0, 0.0)] {
        let errors: Vec<[f64; 2]> = (0..12)
            .map(|_| {
                let powers = image(&mut numbers, wave);
                let fit = likelihood::fit(&Sample::new(&powers).unwrap(), Kind::K);
                [fit.inverse_error, blocks::inverse_shape_error(&powers, [columns, rows]).unwrap()]
            })
            .collect();
        let [alone, blocks] = [0, 1].map(|i| errors.iter().map(|t| t[i]).sum::<f64>() / errors.len() as f64);
        println!("wave {wave}: {alone:.5} of independent pixels, {blocks:.5} by blocks");
        if least > 0.0 {
            // The wave makes some blocks smooth and others spiky: the error from pixels alone is far too
            // small.
            assert!(blocks > 2.0 * alone, "{alone} {blocks}");
        }
    }
    // Independent pixels of a K law: both ways agree, to 1/sqrt(2 x 25) each and 1/sqrt(8) less for eight
    // images.
    let ratios: f64 = (0..8)
        .map(|trial| {
            let powers = powers(&Law::new(Kind::K, 1.5, 1.0), 100 * 100, 85, trial);
            let fit = likelihood::fit(&Sample::new(&powers).unwrap(), Kind::K);
            blocks::inverse_shape_error(&powers, [100, 100]).unwrap() / fit.inverse_error / 8.0
        })
        .sum();
    assert!((0.8..1.2).contains(&ratios), "{ratios}");
    assert!(blocks::inverse_shape_error(&[1.0; 50], [5, 10]).is_none());
}

#[test]
fn the_fall_over_range_is_taken_out() {
    let ranges_m: Vec<f64> = (0..300).map(|j| 2400.0 + 4.0 * f64::from(j)).collect();
    let mut powers: Vec<f64> = ranges_m
        .iter()
        .flat_map(|r| [1.0, 3.0].map(|p| p * 1e-15 * (r / 3000.0).powi(-4) * (-r / 900.0).exp()))
        .collect();
    let before = Sample::new(&powers).unwrap().contrast();
    let span_db = trend::remove(&mut powers, 2, &ranges_m).unwrap();
    // e^{-r/900} is no power of the range: the parabola leaves less than a hundredth.
    assert!((Sample::new(&powers).unwrap().contrast() - 1.25).abs() < 0.01 && before > 1.5);
    let wanted = 40.0 * (3596.0f64 / 2400.0).log10() + 10.0 * (1196.0 / 900.0) / std::f64::consts::LN_10;
    assert!((span_db / wanted - 1.0).abs() < 0.02, "{span_db} {wanted}");
    let mut alone = [1.0, 2.0, 3.0];
    assert!(trend::remove(&mut alone, 1, &[1.0, 2.0, 3.0]).is_none() && alone == [1.0, 2.0, 3.0]);
    assert!(trend::remove(&mut [0.0; 40], 4, &[5.0; 10]).is_none());
}
