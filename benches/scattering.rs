//! Cost of facets to scattering matrices, four channels, one core: `cargo bench --bench scattering`.
//! Criterion's elements are facets, so its throughput is facets per second (1000/Melem/s = ns per facet).
#![allow(missing_docs)]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use nereus::scattering::facets::{Facets, Phases};
use nereus::scattering::kind::Kind;
use nereus::scattering::kind::clean::Clean;
use nereus::scattering::kind::slick::Slick;
use nereus::scattering::speckle::Speckle;
use nereus::scattering::two_scale::{Medium, Settings, TwoScale};
use num_complex::Complex64;

const SIDE: usize = 64;

/// Elfouhaily et al. 1997 at 10 m/s, written plainly: the cost of a spectrum that is not tabulated.
fn psi(kx: f64, ky: f64) -> f64 {
    let (g, km, cm, u, omega_c): (f64, f64, f64, f64, f64) = (9.81, 370.0, 0.23, 10.0, 0.84);
    let k = kx.hypot(ky);
    let friction = u * ((0.8 + 0.065 * u) * 1e-3).sqrt();
    let speed = |k: f64| (g / k * (1.0 + (k / km) * (k / km))).sqrt();
    let kp = g / (u * u) * omega_c * omega_c;
    let (c, cp) = (speed(k), speed(kp));
    let omega = u / cp;
    let s = 0.08 * (1.0 + 4.0 / (omega_c * omega_c * omega_c));
    let root = (k / kp).sqrt() - 1.0;
    let l = (-1.25 * (kp / k) * (kp / k)).exp();
    let j = 1.7f64.powf((-root * root / (2.0 * s * s)).exp());
    let bl = 0.5 * 6e-3 * omega.sqrt() * cp / c * l * j * (-omega / 10f64.sqrt() * root).exp();
    let am = 0.01 * (1.0 + 3.0 * (friction / cm).ln());
    let bh = 0.5 * am * cm / c * l * (-0.25 * (k / km - 1.0) * (k / km - 1.0)).exp();
    let delta =
        (2f64.ln() / 4.0 + 4.0 * (c / cp).powf(2.5) + 0.13 * friction / cm * (cm / c).powf(2.5)).tanh();
    let cos2 = (kx * kx - ky * ky) / (k * k);
    (bl + bh) / (k * k * k * k) * (1.0 + delta * cos2) / std::f64::consts::TAU
}

/// A patch seen from 4.2 km at 45 degrees, with wave-like slopes.
struct Patch {
    incident: [Vec<f64>; 3],
    slopes: [Vec<f64>; 2],
    cover: Vec<f64>,
    phasors: Vec<Complex64>,
}

impl Patch {
    fn new(cover: f64, mechanisms: usize) -> Self {
        let mut patch = Self {
            incident: Default::default(),
            slopes: Default::default(),
            cover: vec![cover; SIDE * SIDE],
            phasors: vec![Complex64::ZERO; SIDE * SIDE * mechanisms],
        };
        let radar = DVec3::new(-3000.0, 0.0, 3000.0);
        for iy in 0..SIDE {
            for ix in 0..SIDE {
                let (x, y) = (ix as f64, iy as f64);
                let k = (DVec3::new(x, y, 0.0) - radar).normalize();
                for (component, value) in patch.incident.iter_mut().zip(k.to_array()) {
                    component.push(value);
                }
                patch.slopes[0].push(0.1 * (0.7 * x + 0.2 * y).sin());
                patch.slopes[1].push(0.08 * (0.3 * x - 0.5 * y).cos());
            }
        }
        for (i, phasors) in patch.phasors.chunks_exact_mut(mechanisms).enumerate() {
            Speckle::Frozen.phasors(1, ((i % SIDE) as i64, (i / SIDE) as i64), 0.0, phasors);
        }
        patch
    }
}

fn run<K: Kind>(c: &mut Criterion, name: &str, cover: f64, sea: &TwoScale<K, impl Fn(f64, f64) -> f64>) {
    let patch = Patch::new(cover, 1 + sea.tilts());
    let scattered = patch.incident.each_ref().map(|v| v.iter().map(|x| -x).collect::<Vec<_>>());
    let mut out: [Vec<Complex64>; 4] = std::array::from_fn(|_| vec![Complex64::ZERO; SIDE * SIDE]);
    let facets = Facets {
        incident: patch.incident.each_ref().map(Vec::as_slice),
        scattered: scattered.each_ref().map(Vec::as_slice),
        slope_x: &patch.slopes[0],
        slope_y: &patch.slopes[1],
        cover: &patch.cover,
        phasors: &patch.phasors,
        modulation: &[],
        footprint_m2: 1.0,
    };
    let mut group = c.benchmark_group("facets");
    group.throughput(Throughput::Elements((SIDE * SIDE) as u64));
    group.bench_function(BenchmarkId::from_parameter(name), |b| {
        b.iter(|| {
            let done = facets.scatter(sea, Phases::PolCoherent, out.each_mut().map(Vec::as_mut_slice));
            black_box(done.is_ok())
        });
    });
    group.finish();
}

fn facets(c: &mut Criterion) {
    let medium = Medium {
        carrier_hz: 10e9,
        permittivity: Complex64::new(55.062, -37.514),
        wind_12p5_mps: 10.0,
        downwind_rad: 0.0,
        resolved_radpm: std::f64::consts::PI,
        axis: DVec3::X,
    };
    let plain = Settings::default();
    let tilted = Settings { tilt_average: true, ..plain };
    run(c, "clean", 0.0, &TwoScale::new(plain, medium, Clean, psi));
    run(c, "slick", 0.5, &TwoScale::new(plain, medium, Slick::default(), psi));
    run(c, "nine tilts", 0.0, &TwoScale::new(tilted, medium, Clean, psi));
    c.bench_function("frozen phases of a facet", |b| {
        let mut phasors = [Complex64::ZERO; 2];
        b.iter(|| Speckle::Frozen.phasors(1, black_box((3, -4)), 0.0, &mut phasors));
    });
    c.bench_function("prepare a sea", |b| {
        b.iter(|| TwoScale::new(plain, medium, Clean, psi).cut_radpm());
    });
}

criterion_group!(benches, facets);
criterion_main!(benches);
