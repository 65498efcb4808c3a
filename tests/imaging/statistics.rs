//! `kdist`, `ward_baker_watts`: every row; shapes of synthetic samples.

use std::path::PathBuf;

use nereus::imaging::statistics::{KLaw, sea_shape};
use nereus::rng::{Room, stream};
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
