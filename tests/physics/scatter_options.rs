//! Laws that the two-scale facet keeps whatever is chosen, and rows of docs/physics.md section 19 about
//! specular points and steep facets.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use nereus::scattering::fresnel::reflection;
use nereus::scattering::kind::clean::Clean;
use nereus::scattering::kind::slick::Slick;
use nereus::scattering::permittivity::{Model, SeaWater};
use nereus::scattering::slope_pdf::{MeanSquareSlope, SlopePdf};
use nereus::scattering::tilt::Path;
use nereus::scattering::two_scale::{Medium, Response, Settings, Splitting, TwoScale};
use nereus::scene::water::WindProfile;
use nereus::sea::spectrum::WaveVector;
use nereus::sea::wind::Wind;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::cases::cases;
use crate::scatter_laws::{EPS, medium, spectrum, uniform, upwards};
use crate::scatter_oracle::Elfouhaily;
use crate::sea_spectrum::every_spectrum;

/// Every choice there is, with a cut of its own and without.
fn every_setting() -> Vec<Settings> {
    let mut all = Vec::new();
    for splitting in [Splitting::Consistent, Splitting::Mars2007] {
        for cut_radpm in [None, Some(120.0)] {
            for tilt_average in [false, true] {
                for gram_charlier in [false, true] {
                    all.push(Settings { splitting, cut_radpm, tilt_average, gram_charlier });
                }
            }
        }
    }
    all
}

fn total(response: &Response) -> f64 {
    response.sigma0().iter().flatten().sum()
}

#[test]
fn the_ends_may_be_swapped_in_every_option() {
    let mut draws = ChaCha8Rng::seed_from_u64(21);
    let mut worst: f64 = 0.0;
    for settings in every_setting() {
        for downwind_rad in [0.0, 0.4, 2.0] {
            let medium = Medium { downwind_rad, ..medium(DVec3::X) };
            let waves = Elfouhaily { downwind_rad, ..spectrum() };
            let sea = TwoScale::new(settings, medium, Slick::default(), waves.as_psi());
            for _ in 0..cases(200) {
                let (from, to) = (upwards(&mut draws, 1.55), upwards(&mut draws, 1.55));
                let slopes = (uniform(&mut draws, -0.8, 0.8), uniform(&mut draws, -0.8, 0.8));
                let cover = uniform(&mut draws, 0.0, 1.0);
                let there = sea.response(&Path::new(-from, to), slopes, cover);
                let back = sea.response(&Path::new(-to, from), slopes, cover);
                let pairs = there.bragg().iter().zip(back.bragg());
                for (a, b) in pairs.chain([(&there.specular, &back.specular)]) {
                    let largest = a.iter().flatten().map(|s| s.norm()).fold(0.0, f64::max);
                    for (p, q, sign) in [(0, 0, 1.0), (0, 1, -1.0), (1, 0, -1.0), (1, 1, 1.0)] {
                        let error = (a[p][q] - b[q][p] * sign).norm();
                        // About 50 roundings of 1e-16, times the steepness of spectrum and slope density (to
                        // 1e2).
                        assert!(error <= 1e-12 * largest, "{settings:?} {from} {to} {slopes:?}: {a:?} {b:?}");
                        worst = worst.max(error / largest.max(f64::MIN_POSITIVE));
                    }
                }
            }
        }
    }
    println!("reciprocity, {} options: worst {worst:.1e}", every_setting().len());
}

#[test]
fn wind_and_radar_turn_together_over_level_facets() {
    // The axis of the facets stays that of the map, as in a scene; only radar, wind and waves turn. Of a
    // level facet without sub-facet tilts the local axes are those of the map, so that this is exact.
    let mut draws = ChaCha8Rng::seed_from_u64(22);
    let mut worst: f64 = 0.0;
    for settings in every_setting().into_iter().filter(|settings| !settings.tilt_average) {
        let sea = |downwind_rad: f64| {
            let waves = Elfouhaily { downwind_rad, ..spectrum() };
            let medium = Medium { downwind_rad, ..medium(DVec3::X) };
            TwoScale::new(settings, medium, Slick::default(), waves.as_psi())
        };
        let still = sea(0.4);
        for _ in 0..cases(20) {
            let turn_rad = uniform(&mut draws, 0.0, TAU);
            let turn = glam::DMat3::from_rotation_z(turn_rad);
            let turned = sea(0.4 + turn_rad);
            for _ in 0..50 {
                let (from, to) = (upwards(&mut draws, 1.5), upwards(&mut draws, 1.5));
                let a = still.response(&Path::new(-from, to), (0.0, 0.0), 0.5).sigma0();
                let b = turned.response(&Path::new(turn * -from, turn * to), (0.0, 0.0), 0.5).sigma0();
                let scale = a.iter().flatten().fold(0.0f64, |most, x| most.max(*x));
                for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
                    assert!((a - b).abs() <= 1e-9 * scale, "{settings:?} {turn_rad}: {from} {to}");
                    worst = worst.max((a - b).abs() / scale.max(f64::MIN_POSITIVE));
                }
            }
        }
    }
    println!("turned wind: worst {worst:.1e}");
}

#[test]
fn monostatic_specular_points_are_the_textbook_formula() {
    // Barrick 1968: pi sec^4 |R(0)|^2 p(tan, 0), both polarisations alike; times the damping by small waves.
    for settings in every_setting() {
        let medium = Medium { downwind_rad: 0.0, ..medium(DVec3::X) };
        let waves = Elfouhaily { downwind_rad: 0.0, ..spectrum() };
        let sea = TwoScale::new(settings, medium, Clean, waves.as_psi());
        let moments = sea.moments(0.0);
        for deg in [0.0f64, 3.0, 8.0, 15.0, 22.0] {
            let (sin, cos) = deg.to_radians().sin_cos();
            // The radar looks downwind: the facet that mirrors rises downwind.
            let away = DVec3::new(sin, 0.0, -cos);
            let found = sea.response(&Path::new(away, -away), (0.0, 0.0), 0.0).specular_sigma0();
            let density = sea.slope_pdf(0.0).density(sin / cos, 0.0);
            let k = medium.wavenumber_radpm();
            let calm = (-4.0 * k * k * moments.roughness_m2).exp();
            let textbook = PI * cos.powi(-4) * reflection(EPS, 1.0).v.norm_sqr() * density * calm;
            for found in [found[0][0], found[1][1]] {
                // The Gram-Charlier series is clamped at 0 far out.
                if textbook == 0.0 {
                    assert!(settings.gram_charlier && found == 0.0);
                    continue;
                }
                // The density's exponent, up to 10, multiplies roundings of 1e-15.
                assert!((found / textbook - 1.0).abs() < 1e-12, "{settings:?} {deg}: {found} not {textbook}");
            }
            assert!(found[0][1] + found[1][0] <= 1e-28 * found[0][0]);
        }
    }
}

/// docs/physics.md section 19, "receiver through the specular point".
#[test]
fn the_receiver_passes_through_the_specular_point() {
    let medium = Medium { resolved_radpm: 0.0, downwind_rad: 0.0, ..medium(DVec3::X) };
    let waves = Elfouhaily { wind_10_mps: 10.0, downwind_rad: 0.0 };
    // At nadir: 12.9 dB with the slopes below the cut (damping undone), 10.7 dB "order" with those of Cox and
    // Munk.
    let peak_db = |splitting| {
        let settings = Settings { splitting, ..Settings::default() };
        let sea = TwoScale::new(settings, medium, Clean, waves.as_psi());
        let k = medium.wavenumber_radpm();
        let damping = (4.0 * k * k * sea.moments(0.0).roughness_m2).exp();
        let nadir = Path::new(DVec3::NEG_Z, DVec3::Z);
        10.0 * (sea.response(&nadir, (0.0, 0.0), 0.0).specular_sigma0()[0][0] * damping).log10()
    };
    let (consistent_db, paper_db) = (peak_db(Splitting::Consistent), peak_db(Splitting::Mars2007));
    println!("specular peak at nadir: {consistent_db:.2} dB (12.9), Cox-Munk {paper_db:.2} dB (10.7)");
    // Half the last digit; the second figure is of order: the digit itself.
    assert!((consistent_db - 12.9).abs() <= 0.05 && (paper_db - 10.7).abs() <= 0.1);

    // Across the specular direction of a transmitter at 50 degrees, in steps of 0.01 degrees: what the radar
    // sees changes smoothly and peaks there.
    for settings in every_setting().into_iter().filter(|s| s.splitting == Splitting::Consistent) {
        let sea = TwoScale::new(settings, medium, Clean, waves.as_psi());
        let ki = DVec3::new(50f64.to_radians().sin(), 0.0, -(50f64.to_radians().cos()));
        let at = |deg: f64, across_deg: f64| {
            let (sin, cos) = deg.to_radians().sin_cos();
            let (y, x) = across_deg.to_radians().sin_cos();
            total(&sea.response(&Path::new(ki, DVec3::new(sin * x, sin * y, cos)), (0.0, 0.0), 0.0))
        };
        let mut last = at(48.0, 0.0);
        for i in 1..=400 {
            let here = at(48.0 + 0.01 * f64::from(i), 0.0);
            // d(ln p) = z dz / s^2: slopes of at most 0.02, steps of 1e-4 rad (half for the slope), s^2 of
            // 0.01 and more, give 1e-4; the secant and the reflection change by less than 1e-3 of the step
            // each.
            assert!((here / last - 1.0).abs() < 5e-4, "{settings:?} at {i}: {here} after {last}");
            last = here;
        }
        let peak = at(50.0, 0.0);
        assert!(peak.is_finite() && peak > at(50.0, 8.0) && peak > at(50.0, -8.0) && peak > at(40.0, 0.0));
        // The Bragg wave there has no length: below the cut, nothing.
        let mirror = Path::new(ki, DVec3::new(ki.x, 0.0, -ki.z));
        if !settings.tilt_average {
            assert_eq!(sea.response(&mirror, (0.0, 0.0), 0.0).bragg_sigma0(), [[0.0; 2]; 2]);
        }
    }
}

/// docs/physics.md section 19, "slopes of 1 and more".
#[test]
fn facets_steeper_than_45_degrees_are_facets() {
    // Seen along its own normal a facet is a mirror, however steep it is: the specular part is that of a
    // level one at nadir.
    for splitting in [Splitting::Consistent, Splitting::Mars2007] {
        let settings = Settings { splitting, ..Settings::default() };
        let sea = TwoScale::new(settings, medium(DVec3::X), Clean, spectrum().as_psi());
        let nadir = sea.response(&Path::new(DVec3::NEG_Z, DVec3::Z), (0.0, 0.0), 0.0).specular_sigma0();
        for slope in [1.0, 1.5, 3.0, 10.0] {
            for azimuth in [0.0f64, 1.0, 2.5] {
                let (zx, zy) = (slope * azimuth.cos(), slope * azimuth.sin());
                let normal = DVec3::new(-zx, -zy, 1.0).normalize();
                let found = sea.response(&Path::new(-normal, normal), (zx, zy), 0.0).specular_sigma0();
                for p in 0..2 {
                    // The slope that mirrors is a rounding residue, 1e-15, of a density 0.1 wide.
                    assert!((found[p][p] / nadir[p][p] - 1.0).abs() < 1e-12, "slope {slope} at {azimuth}");
                }
                let behind = sea.response(&Path::new(normal, -normal), (zx, zy), 0.0);
                assert_eq!(total(&behind), 0.0);
            }
        }
    }
}

/// docs/physics.md section 19, "facet under an antenna": the bases at nadir are a convention, the power is
/// not.
#[test]
fn nadir_does_not_depend_on_the_convention_of_its_bases() {
    for settings in every_setting().into_iter().filter(|s| s.splitting == Splitting::Consistent) {
        let sea = TwoScale::new(settings, medium(DVec3::X), Clean, spectrum().as_psi());
        for slopes in [(0.0, 0.0), (0.1, -0.2)] {
            let nadir = total(&sea.response(&Path::new(DVec3::NEG_Z, DVec3::Z), slopes, 0.0));
            for azimuth in [0.0f64, 0.7, 2.0, 4.0] {
                for tilt in [1e-13, 1e-11, 1e-9] {
                    let up = DVec3::new(tilt * azimuth.cos(), tilt * azimuth.sin(), 1.0).normalize();
                    let near = total(&sea.response(&Path::new(-up, up), slopes, 0.0));
                    // Slope densities and spectrum change by less than 1e2 of the tilt; roundings.
                    assert!(
                        (near / nadir - 1.0).abs() < 1e3 * tilt + 1e-12,
                        "{settings:?} {slopes:?} {tilt}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_density_below_the_cut_is_that_of_its_moments() {
    let sea = TwoScale::new(Settings::default(), medium(DVec3::X), Clean, spectrum().as_psi());
    let MeanSquareSlope { up, cross } = sea.moments(0.0).slopes;
    let (sin, cos) = medium(DVec3::X).downwind_rad.sin_cos();
    let expected = SlopePdf::along(MeanSquareSlope { up, cross }, None, cos, sin);
    assert_eq!(sea.slope_pdf(0.0), expected);
}

proptest! {
    #![proptest_config(crate::cases::proptests(64))]

    /// Every spectrum that the library has, every wind, water, carrier and choice.
    #[test]
    fn every_sea_of_the_library_scatters_finitely(
        carrier_hz in 1e9..=90e9f64,
        temperature_c in -2.0..=34.0f64,
        salinity_gpkg in 0.0..=40.0f64,
        u10_mps in prop_oneof![Just(0.0), Just(40.0), 0.0..=40.0f64],
        direction_rad in -7.0..7.0f64,
        which in 0usize..11,
        facet_m in prop_oneof![Just(None), (1e-3..1e4f64).prop_map(Some)],
        settings in prop::sample::select(every_setting()),
        facets in prop::collection::vec(
            (0.0..=FRAC_PI_2_AND_MORE, 0.0..TAU, 0.0..=FRAC_PI_2_AND_MORE, 0.0..TAU, -5.0..5.0f64, -5.0..5.0f64, 0.0..=1.0f64), 32),
    ) {
        let wind = Wind::from_speed(u10_mps, 10.0, WindProfile::Cardone, direction_rad).unwrap();
        let (name, waves) = every_spectrum(&wind).swap_remove(which);
        let water = SeaWater { temperature_c, salinity_gpkg };
        let medium = Medium {
            carrier_hz,
            permittivity: Model::default().permittivity(carrier_hz, water).unwrap(),
            wind_12p5_mps: wind.u12_5_mps,
            downwind_rad: direction_rad,
            resolved_radpm: facet_m.map_or(0.0, |facet_m| PI / facet_m),
            axis: DVec3::X,
        };
        let psi = |kx: f64, ky: f64| waves.symmetric_m4(WaveVector::new(kx, ky));
        let sea = TwoScale::new(settings, medium, Slick::default(), psi);
        for (theta_i, phi_i, theta_s, phi_s, zx, zy, cover) in facets {
            let direction = |theta: f64, phi: f64| {
                DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
            };
            let (from, to) = (direction(theta_i, phi_i), direction(theta_s, phi_s));
            for path in [Path::new(-from, to), Path::new(-from, from)] {
                for slopes in [(zx, zy), (0.0, 0.0)] {
                    let response = sea.response(&path, slopes, cover);
                    let sigma0 = response.sigma0();
                    prop_assert!(
                        sigma0.iter().flatten().all(|s| s.is_finite() && *s >= 0.0),
                        "{} {:?} {:?}: {:?}", name, settings, path, sigma0
                    );
                }
            }
        }
    }
}

/// Somewhat beyond the horizon, rad.
const FRAC_PI_2_AND_MORE: f64 = 1.8;
