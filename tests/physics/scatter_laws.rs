//! Laws that scattering obeys whatever its numbers: reciprocity, energy, invariance, limits.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use nereus::geometry::bistatic::Basis;
use nereus::scattering::fresnel::{reflection, refracted};
use nereus::scattering::kind::clean::Clean;
use nereus::scattering::kind::slick::Slick;
use nereus::scattering::kirchhoff::Specular;
use nereus::scattering::slope_pdf::{MeanSquareSlope, SlopePdf};
use nereus::scattering::spm;
use nereus::scattering::tilt::{NO_ECHO, Path, ScatterMatrix, Tangent};
use nereus::scattering::two_scale::{Medium, Response, Settings, Splitting, TwoScale};
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cases::cases;
use crate::scatter_oracle::Elfouhaily;

pub const EPS: Complex64 = Complex64::new(55.062, -37.514);

pub fn medium(axis: DVec3) -> Medium {
    Medium {
        carrier_hz: 10e9,
        permittivity: EPS,
        wind_12p5_mps: 10.0,
        downwind_rad: 0.4,
        resolved_radpm: PI,
        axis,
    }
}

pub fn spectrum() -> Elfouhaily {
    Elfouhaily { wind_10_mps: 10.0, downwind_rad: 0.4 }
}

pub fn uniform(draws: &mut ChaCha8Rng, from: f64, to: f64) -> f64 {
    from + (to - from) * (draws.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// A direction whose angle from the vertical is within `most_rad`, upwards.
pub fn upwards(draws: &mut ChaCha8Rng, most_rad: f64) -> DVec3 {
    let (sin, cos) = uniform(draws, 0.0, most_rad).sin_cos();
    let (y, x) = uniform(draws, 0.0, TAU).sin_cos();
    DVec3::new(sin * x, sin * y, cos)
}

fn matrices(response: &Response) -> Vec<ScatterMatrix> {
    response.bragg().iter().copied().chain([response.specular]).collect()
}

fn largest(matrix: &ScatterMatrix) -> f64 {
    matrix.iter().flatten().map(|s| s.norm()).fold(0.0, f64::max)
}

#[test]
fn swapping_the_ends_changes_nothing() {
    let mut draws = ChaCha8Rng::seed_from_u64(1);
    let mut worst: f64 = 0.0;
    let settings = Settings { tilt_average: true, gram_charlier: true, ..Settings::default() };
    let sea = TwoScale::new(settings, medium(DVec3::X), Slick::default(), spectrum().as_psi());
    for _ in 0..cases(2000) {
        let (from, to) = (upwards(&mut draws, 1.5), upwards(&mut draws, 1.5));
        let slopes = (uniform(&mut draws, -0.4, 0.4), uniform(&mut draws, -0.4, 0.4));
        let cover = uniform(&mut draws, 0.0, 1.0);
        let there = sea.response(&Path::new(-from, to), slopes, cover);
        let back = sea.response(&Path::new(-to, from), slopes, cover);
        for (a, b) in matrices(&there).iter().zip(&matrices(&back)) {
            let sign = [1.0, -1.0];
            for p in 0..2 {
                for q in 0..2 {
                    let error = (a[p][q] - b[q][p] * (sign[p] * sign[q])).norm();
                    // Relative to the matrix: an entry may vanish by symmetry. About 50 roundings of 1e-16,
                    // times the steepness of spectrum and slope density (up to 1e2).
                    assert!(error <= 1e-12 * largest(a), "{from} {to} {slopes:?}: {a:?} {b:?}");
                    worst = worst.max(error / largest(a).max(f64::MIN_POSITIVE));
                }
            }
        }
    }
    println!("reciprocity: worst {worst:.1e}");
}

#[test]
fn specular_scattering_keeps_the_energy() {
    // Of slopes as small as this (total 0.0143, U10 = 10 m/s on a 1 m grid) the mean of |R|^2 over local
    // angles is within s^2 |R|''/2 of |R(th_i)|^2: below 0.5 %. The half-degree rule adds less than 1e-4.
    let pdf = SlopePdf::new(MeanSquareSlope { up: 0.0083, cross: 0.0060 }, None, 0.0);
    let flat = Tangent::from_slopes(0.0, 0.0, DVec3::X);
    let step = 0.5f64.to_radians();
    for deg in [0.0f64, 15.0, 30.0, 45.0] {
        let (sin_i, cos_i) = deg.to_radians().sin_cos();
        let ki = DVec3::new(sin_i, 0.0, -cos_i);
        let mut power = [0.0; 2];
        for i in 0..180 {
            let (sin, cos) = ((f64::from(i) + 0.5) * step).sin_cos();
            for j in 0..720 {
                let (y, x) = (f64::from(j) * step).sin_cos();
                let path = Path::new(ki, DVec3::new(sin * x, sin * y, cos));
                let Some(mirror) = Specular::new(EPS, &path) else { continue };
                let weight =
                    mirror.weight(&flat, &path, &pdf).powi(2) * sin * step * step / (4.0 * PI * cos_i);
                for (q, total) in power.iter_mut().enumerate() {
                    *total +=
                        weight * (mirror.reflection[0][q].norm_sqr() + mirror.reflection[1][q].norm_sqr());
                }
            }
        }
        let r = reflection(EPS, cos_i);
        for (name, found, fresnel) in [("V", power[0], r.v.norm_sqr()), ("H", power[1], r.h.norm_sqr())] {
            println!("GO energy at {deg} deg, {name}: {found:.4}, Fresnel {fresnel:.4}");
            assert!((found / fresnel - 1.0).abs() < 0.01, "{deg} deg {name}: {found} against {fresnel}");
        }
    }
}

#[test]
fn monostatic_bragg_is_the_textbook_formula() {
    let sea = spectrum();
    let k = medium(DVec3::X).wavenumber_radpm();
    let flat = Tangent::from_slopes(0.0, 0.0, DVec3::X);
    let mut worst: f64 = 0.0;
    for deg in 1..90 {
        for azimuth in [0.0f64, 1.0, 2.5] {
            let (s, c) = f64::from(deg).to_radians().sin_cos();
            let away = DVec3::new(s * azimuth.cos(), s * azimuth.sin(), -c);
            let a = spm::amplitude(EPS, k, &flat, &Path::new(away, -away), |x, y| sea.psi(x, y));
            let r = (EPS - s * s).sqrt();
            let hh = (EPS - 1.0) / ((c + r) * (c + r));
            let vv = (EPS - 1.0) * (EPS * (1.0 + s * s) - s * s) / ((EPS * c + r) * (EPS * c + r));
            let bragg = sea.psi(2.0 * k * s * azimuth.cos(), 2.0 * k * s * azimuth.sin());
            let textbook = |alpha: Complex64| 16.0 * PI * (k * c).powi(4) * alpha.norm_sqr() * bragg;
            for (found, expected) in [(a[0][0], textbook(vv)), (a[1][1], textbook(hh))] {
                let error = (found.norm_sqr() / expected - 1.0).abs();
                // cos^4 amplifies the rounding of the cosine near 89 degrees: 4 * 1e-16 / 0.017, and margins.
                assert!(error < 1e-12, "{deg} deg: {} not {expected}", found.norm_sqr());
                worst = worst.max(error);
            }
            assert!(a[0][1].norm() < 1e-14 * a[0][0].norm(), "no cross-polarisation of a flat facet");
        }
    }
    println!("monostatic Bragg: worst {worst:.1e}");
}

/// Polarisation amplitudes `a[p][q]`, order (v, h), in the bases of the facet. `azimuth` is the cosine and
/// sine of `d`.
pub fn alphas(eps: Complex64, cos_i: f64, cos_s: f64, azimuth: (f64, f64)) -> ScatterMatrix {
    let (cos_d, sin_d) = azimuth;
    let contrast = eps - 1.0;
    let (ri, rs) = (refracted(eps, cos_i), refracted(eps, cos_s));
    let sines = ((1.0 - cos_i * cos_i).max(0.0) * (1.0 - cos_s * cos_s).max(0.0)).sqrt();
    let (tm_i, te_i) = (eps * cos_i + ri, cos_i + ri);
    let (tm_s, te_s) = (eps * cos_s + rs, cos_s + rs);
    [
        [(contrast * (eps * sines - cos_d * ri * rs)) / (tm_i * tm_s), contrast * rs * sin_d / (te_i * tm_s)],
        [contrast * ri * sin_d / (tm_i * te_s), contrast * cos_d / (te_i * te_s)],
    ]
}

/// The printed amplitudes rotated by the bases of facet and vertical, as docs/physics.md section 10.3 writes
/// it.
fn by_local_bases(k: f64, plane: &Tangent, path: &Path, psi: impl Fn(f64, f64) -> f64) -> ScatterMatrix {
    let Some((ci, cs)) = path.local_cosines(plane.normal) else { return NO_ECHO };
    let (kx, ky) = spm::bragg_vector(k, plane, path);
    let Basis { v: vi, h: hi } = Basis::about(path.ki, plane.normal);
    let Basis { v: vs, h: hs } = Basis::about(path.ks, plane.normal);
    let local = alphas(EPS, ci, cs, (hi.dot(hs), plane.normal.dot(hi.cross(hs))));
    let scale = 4.0 * PI.sqrt() * k * k * ci * cs * psi(kx, ky).sqrt();
    let into = |q: DVec3| [vi.dot(q), hi.dot(q)];
    let out = |p: DVec3| [vs.dot(p), hs.dot(p)];
    let entry = |p: DVec3, q: DVec3| {
        let (p, q) = (out(p), into(q));
        let mut sum = Complex64::ZERO;
        for a in 0..2 {
            for b in 0..2 {
                sum += local[a][b] * (p[a] * q[b]);
            }
        }
        sum * scale
    };
    let (Basis { v: iv, h: ih }, Basis { v: sv, h: sh }) = (path.incident, path.scattered);
    [[entry(sv, iv), entry(sv, ih)], [entry(sh, iv), entry(sh, ih)]]
}

#[test]
fn bragg_without_bases_is_bragg_with_bases() {
    let sea = spectrum();
    let k = medium(DVec3::X).wavenumber_radpm();
    let mut draws = ChaCha8Rng::seed_from_u64(2);
    let mut worst: f64 = 0.0;
    for _ in 0..cases(5000) {
        let path = Path::new(-upwards(&mut draws, 1.57), upwards(&mut draws, 1.57));
        let slopes = (uniform(&mut draws, -1.5, 1.5), uniform(&mut draws, -1.5, 1.5));
        let plane = Tangent::from_slopes(slopes.0, slopes.1, DVec3::X);
        let a = spm::amplitude(EPS, k, &plane, &path, |x, y| sea.psi(x, y));
        let b = by_local_bases(k, &plane, &path, |x, y| sea.psi(x, y));
        for (a_pq, b_pq) in a.iter().flatten().zip(b.iter().flatten()) {
            let error = (a_pq - b_pq).norm();
            // Local bases lose digits as a direction nears the normal (1e-16 over the sine, here down to
            // 1e-3), and both forms share the spectrum.
            assert!(error <= 1e-11 * largest(&b), "{path:?} {slopes:?}: {a:?} {b:?}");
            worst = worst.max(error / largest(&b).max(f64::MIN_POSITIVE));
        }
    }
    println!("Bragg, two forms: worst {worst:.1e}");
    assert!((refracted(EPS, 0.3) * refracted(EPS, 0.3) - (EPS - 1.0 + 0.09)).norm() < 1e-13);
}

#[test]
fn turning_the_whole_scene_changes_nothing() {
    let mut draws = ChaCha8Rng::seed_from_u64(3);
    let mut worst: f64 = 0.0;
    let psi = spectrum().as_psi();
    for splitting in [Splitting::Consistent, Splitting::Mars2007] {
        let settings = Settings { splitting, tilt_average: true, gram_charlier: true, ..Settings::default() };
        let still = TwoScale::new(settings, medium(DVec3::X), Slick::default(), psi);
        for _ in 0..cases(20) {
            let turn = DMat3::from_rotation_z(uniform(&mut draws, 0.0, TAU));
            let turned = TwoScale::new(settings, medium(turn * DVec3::X), Slick::default(), psi);
            for _ in 0..50 {
                let (from, to) = (upwards(&mut draws, 1.5), upwards(&mut draws, 1.5));
                let slope = DVec3::new(uniform(&mut draws, -0.4, 0.4), uniform(&mut draws, -0.4, 0.4), 0.0);
                let after = turn * slope;
                let a = still.response(&Path::new(-from, to), (slope.x, slope.y), 0.5);
                let b = turned.response(&Path::new(turn * -from, turn * to), (after.x, after.y), 0.5);
                for (a, b) in matrices(&a).iter().zip(&matrices(&b)) {
                    for (a_pq, b_pq) in a.iter().flatten().zip(b.iter().flatten()) {
                        let error = (a_pq - b_pq).norm();
                        assert!(error <= 1e-9 * largest(a), "{from} {to} {slope}: {a:?} {b:?}");
                        worst = worst.max(error / largest(a).max(f64::MIN_POSITIVE));
                    }
                }
            }
        }
    }
    println!("turned scene: worst {worst:.1e}");
}

#[test]
fn a_film_darkens_the_sea_smoothly() {
    let psi = spectrum().as_psi();
    let down = DVec3::new(0.5f64.sqrt(), 0.0, -0.5f64.sqrt());
    let path = Path::new(down, -down);
    let film = TwoScale::new(Settings::default(), medium(DVec3::X), Slick::default(), psi);
    let open = TwoScale::new(Settings::default(), medium(DVec3::X), Clean, psi);
    let vv = |sea: &dyn Fn(f64) -> Response, cover: f64| sea(cover).sigma0()[0][0];
    let under = |cover: f64| film.response(&path, (0.0, 0.0), cover);
    let clean = |cover: f64| open.response(&path, (0.0, 0.0), cover);
    assert_eq!(under(0.0), clean(0.0), "a facet without film is a clean one");
    assert_eq!(clean(0.0).bragg(), clean(1.0).bragg());
    let mut last = f64::INFINITY;
    for cover in 0..=10 {
        let sigma0 = vv(&under, f64::from(cover) / 10.0);
        assert!(sigma0 < last, "more film, less echo");
        last = sigma0;
    }
    let contrast_db = 10.0 * (vv(&under, 0.0) / last).log10();
    println!("slick contrast at 45 deg, X band: {contrast_db:.1} dB");
    // y(K) at the Bragg wave: elasticity 0.0255 N/m, K = 296.4 rad/m.
    let bragg = 2.0 * medium(DVec3::X).wavenumber_radpm() * 0.5f64.sqrt();
    let expected_db = 10.0 * Slick::default().relative_damping(bragg).log10();
    // The slope density contributes e^-35 here.
    assert!((contrast_db - expected_db).abs() < 1e-6, "{contrast_db} {expected_db}");
}

/// The recommendation against Meissner and Wentz where both hold, and against the practical salinity scale
/// below: sea water of 35 psu at 15 degrees conducts 4.2914 S/m, by definition of the scale.
#[test]
fn permittivity_of_the_recommendation() {
    use nereus::scattering::permittivity::{Model, SeaWater, VACUUM_PERMITTIVITY_FPM};
    let mut worst: (f64, f64) = (0.0, 0.0);
    for (carrier_hz, most) in [(1e9, 0.06), (3e9, 0.03), (10e9, 0.03), (35e9, 0.06), (90e9, 0.06)] {
        for temperature_c in [0.0, 10.0, 20.0, 30.0] {
            for salinity_gpkg in [0.0, 20.0, 35.0] {
                let water = SeaWater { temperature_c, salinity_gpkg };
                let of = |model: Model| model.permittivity(carrier_hz, water).unwrap();
                let (itu, mw) = (of(Model::ItuRP527), of(Model::MeissnerWentz2012));
                let error = (itu - mw).norm() / mw.norm();
                worst = if error > worst.0 { (error, carrier_hz) } else { worst };
                assert!(error < most, "{carrier_hz} {water:?}: {itu} {mw}");
            }
        }
    }
    let standard = SeaWater { temperature_c: 15.0, salinity_gpkg: 35.0 };
    for carrier_hz in [1e6, 10e6, 100e6] {
        let eps = Model::ItuRP527.permittivity(carrier_hz, standard).unwrap();
        // Relaxation adds to the imaginary part what grows with the frequency.
        let relaxed = (eps.re - 5.0) * carrier_hz / 14e9;
        let found_spm = (-eps.im - relaxed) * TAU * VACUUM_PERMITTIVITY_FPM * carrier_hz;
        assert!((found_spm / 4.2914 - 1.0).abs() < 2e-3, "{carrier_hz}: {found_spm} S/m");
        // Static, of 35 psu: 70 to 75 by all that measured it.
        assert!((70.0..75.0).contains(&eps.re), "{eps}");
    }
    let warm = SeaWater { temperature_c: 20.0, salinity_gpkg: 35.0 };
    println!("worst {worst:?}; at 100 MHz {:.1}", Model::ItuRP527.permittivity(100e6, warm).unwrap());
}
