//! Batches of facets: means over random phases, frozen and forgotten phases, bad lengths.

use glam::DVec3;
use nereus::scattering::facets::{Facets, LengthError, Phases};
use nereus::scattering::kind::clean::Clean;
use nereus::scattering::kind::slick::Slick;
use nereus::scattering::speckle::Speckle;
use nereus::scattering::tilt::Path;
use nereus::scattering::two_scale::{Settings, TwoScale};
use num_complex::Complex64;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scatter_laws::{EPS, medium, spectrum, uniform, upwards};

struct Batch {
    incident: [Vec<f64>; 3],
    scattered: [Vec<f64>; 3],
    slopes: [Vec<f64>; 2],
    cover: Vec<f64>,
    phasors: Vec<Complex64>,
}

impl Batch {
    fn facets(&self) -> Facets<'_> {
        Facets {
            incident: self.incident.each_ref().map(Vec::as_slice),
            scattered: self.scattered.each_ref().map(Vec::as_slice),
            slope_x: &self.slopes[0],
            slope_y: &self.slopes[1],
            cover: &self.cover,
            phasors: &self.phasors,
            modulation: &[],
            footprint_m2: 0.25,
        }
    }

    fn push(&mut self, path: (DVec3, DVec3), slopes: (f64, f64), cover: f64, phasors: &[Complex64]) {
        for axis in 0..3 {
            self.incident[axis].push(path.0[axis]);
            self.scattered[axis].push(path.1[axis]);
        }
        self.slopes[0].push(slopes.0);
        self.slopes[1].push(slopes.1);
        self.cover.push(cover);
        self.phasors.extend_from_slice(phasors);
    }

    fn new() -> Self {
        Self {
            incident: Default::default(),
            scattered: Default::default(),
            slopes: Default::default(),
            cover: Vec::new(),
            phasors: Vec::new(),
        }
    }
}

fn scatter<K: nereus::scattering::kind::Kind>(
    batch: &Batch,
    sea: &TwoScale<K, impl Fn(f64, f64) -> f64>,
    phases: Phases,
) -> [Vec<Complex64>; 4] {
    let mut out: [Vec<Complex64>; 4] = std::array::from_fn(|_| vec![Complex64::ZERO; batch.facets().len()]);
    batch.facets().scatter(sea, phases, out.each_mut().map(Vec::as_mut_slice)).unwrap();
    out
}

#[test]
fn mean_power_over_phases_is_sigma0_times_area() {
    let settings = Settings { tilt_average: true, ..Settings::default() };
    let sea = TwoScale::new(settings, medium(DVec3::X), Slick::default(), spectrum().as_psi());
    // Specular and Bragg parts of the same order.
    let down = DVec3::new(0.35, 0.0, -(1.0f64 - 0.35 * 0.35).sqrt());
    let (slopes, cover) = ((0.05, -0.1), 0.3);
    let facets = 20_000i64;
    let mut batch = Batch::new();
    let mut phasors = vec![Complex64::ZERO; 1 + sea.tilts()];
    for ix in 0..facets {
        Speckle::Frozen.phasors(11, (ix, -ix), 0.0, &mut phasors);
        batch.push((down, -down), slopes, cover, &phasors);
    }
    let sigma0 = sea.response(&Path::new(down, -down), slopes, cover).sigma0();
    let area_m2 = 0.25 * (1.0f64 + 0.05 * 0.05 + 0.1 * 0.1).sqrt();
    let expected = [sigma0[0][0], sigma0[0][1], sigma0[1][0], sigma0[1][1]].map(|s| s * area_m2);
    let coherent = scatter(&batch, &sea, Phases::PolCoherent);
    let single = scatter(&batch, &sea, Phases::Single);
    let mut worst: f64 = 0.0;
    for ((coherent, single), expected) in coherent.iter().zip(&single).zip(expected) {
        let mean = coherent.iter().map(|s| s.norm_sqr()).sum::<f64>() / facets as f64;
        let error = (mean / expected - 1.0).abs();
        // The power of a sum of random phasors varies by at most its mean: 4 deviations of the mean of N.
        assert!(error < 4.0 / (facets as f64).sqrt(), "{mean} not {expected}");
        worst = worst.max(error);
        for s in single {
            assert!((s.norm_sqr() / expected - 1.0).abs() < 1e-13);
        }
    }
    // One phase for all four in the paper's way.
    let turn = single[0][5] * single[3][5].conj();
    assert!(turn.im.abs() < 1e-14 * turn.re);
    println!("mean power over {facets} phases: worst {worst:.1e}");
}

#[test]
fn a_cut_batch_gives_the_same_bits() {
    let sea = TwoScale::new(Settings::default(), medium(DVec3::X), Clean, spectrum().as_psi());
    let mut draws = ChaCha8Rng::seed_from_u64(5);
    let mut batch = Batch::new();
    let mut phasors = [Complex64::ZERO; 2];
    for i in 0..100 {
        Speckle::Frozen.phasors(1, (i, i * i), 0.0, &mut phasors);
        let slopes = (uniform(&mut draws, -0.3, 0.3), uniform(&mut draws, -0.3, 0.3));
        batch.push((-upwards(&mut draws, 1.5), upwards(&mut draws, 1.5)), slopes, 0.0, &phasors);
    }
    let whole = scatter(&batch, &sea, Phases::PolCoherent);
    let all = batch.facets();
    let mut parts: [Vec<Complex64>; 4] = std::array::from_fn(|_| vec![Complex64::ZERO; 100]);
    for from in [0, 37] {
        let to = if from == 0 { 37 } else { 100 };
        let part = Facets {
            incident: all.incident.map(|v| &v[from..to]),
            scattered: all.scattered.map(|v| &v[from..to]),
            slope_x: &all.slope_x[from..to],
            slope_y: &all.slope_y[from..to],
            cover: &all.cover[from..to],
            phasors: &all.phasors[2 * from..2 * to],
            modulation: &[],
            ..all
        };
        part.scatter(&sea, Phases::PolCoherent, parts.each_mut().map(|v| &mut v[from..to])).unwrap();
    }
    assert_eq!(whole, parts);
}

#[test]
fn forgetting_follows_its_law() {
    let tau_s = 7e-3;
    let speckle = Speckle::Decorrelating { time_s: tau_s };
    let facets = 20_000i64;
    let at = |facet: i64, t_s: f64| {
        let mut one = [Complex64::ZERO; 1];
        speckle.phasors(3, (facet, 5), t_s, &mut one);
        one[0]
    };
    for lag in [0.0, 0.5, 1.0, 2.0] {
        let mut covariance = Complex64::ZERO;
        for facet in 0..facets {
            // An hour into a run: no drift.
            covariance += at(facet, 3600.0 + lag * tau_s) * at(facet, 3600.0).conj() / facets as f64;
        }
        let expected = (-lag * lag).exp();
        println!("decorrelation at {lag} tau: {:.4} ({expected:.4})", covariance.re);
        // |gamma|^2 varies by its mean; 4 deviations of the mean of N.
        assert!((covariance - expected).norm() < 4.0 * 2f64.sqrt() / (facets as f64).sqrt());
    }
}

#[test]
fn wrong_lengths_are_named() {
    let sea = TwoScale::new(Settings::default(), medium(DVec3::X), Clean, spectrum().as_psi());
    let mut batch = Batch::new();
    batch.push((DVec3::NEG_Z, DVec3::Z), (0.0, 0.0), 1.0, &[Complex64::ONE]);
    let mut out = [[Complex64::ZERO; 1]; 4];
    let [a, b, c, d] = &mut out;
    let error = batch.facets().scatter(&sea, Phases::Single, [a, b, c, d]).unwrap_err();
    assert_eq!(error, LengthError { array: "phasors", found: 1, expected: 2 });
    assert_eq!(error.to_string(), "facet batch: phasors has 1 entries, 2 are needed");
    let empty = Batch::new();
    assert!(empty.facets().is_empty());
    assert_eq!(scatter(&empty, &sea, Phases::Single), <[Vec<Complex64>; 4]>::default());
    assert_eq!(EPS, sea.medium().permittivity);
}
