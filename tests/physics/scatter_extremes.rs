//! Extremes of docs/physics.md section 19 that concern scattering: nothing panics, nothing is NaN or
//! infinite.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use nereus::scattering::fresnel::reflection;
use nereus::scattering::kind::clean::Clean;
use nereus::scattering::kind::slick::Slick;
use nereus::scattering::permittivity::{Model, SeaWater};
use nereus::scattering::tilt::Path;
use nereus::scattering::two_scale::{Medium, Response, Settings, Splitting, TwoScale};
use num_complex::Complex64;
use proptest::prelude::*;

use crate::scatter_laws::{EPS, medium, spectrum};
use crate::scatter_oracle::Elfouhaily;

fn finite(response: &Response) -> bool {
    response.bragg().iter().chain([&response.specular]).flatten().flatten().all(|s| s.is_finite())
}

fn zero(response: &Response) -> bool {
    response.sigma0() == [[0.0; 2]; 2]
}

fn inclined(theta_rad: f64, azimuth_rad: f64) -> DVec3 {
    let (s, c) = theta_rad.sin_cos();
    DVec3::new(s * azimuth_rad.cos(), s * azimuth_rad.sin(), c)
}

fn default_sea() -> TwoScale<Clean, impl Fn(f64, f64) -> f64> {
    TwoScale::new(Settings::default(), medium(DVec3::X), Clean, spectrum().as_psi())
}

#[test]
fn grazing_fades_to_exactly_nothing() {
    let sea = default_sea();
    let mut last = f64::INFINITY;
    for depression in [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9] {
        let up = inclined(FRAC_PI_2 - depression, 0.3);
        let response = sea.response(&Path::new(-up, up), (0.0, 0.0), 0.0);
        let vv = response.bragg_sigma0()[0][0];
        assert!(finite(&response) && vv < last && vv > 0.0, "{depression}: {vv}");
        last = vv;
    }
    for theta in [FRAC_PI_2 + 1e-9, 2.0] {
        let up = inclined(theta, 0.3);
        assert!(zero(&sea.response(&Path::new(-up, up), (0.0, 0.0), 0.0)), "beyond the horizon of the facet");
    }
    // A level ray, and a facet that leans away.
    assert!(zero(&sea.response(&Path::new(DVec3::X, DVec3::NEG_X), (0.0, 0.0), 0.0)));
    let up = inclined(1.4, 0.0);
    assert!(
        zero(&sea.response(&Path::new(-up, up), (0.5, 0.0), 0.0)),
        "slope 0.5 faces away from 10 deg grazing"
    );
    assert!(!zero(&sea.response(&Path::new(-up, up), (-0.5, 0.0), 0.0)));
}

#[test]
fn nadir_is_the_specular_peak() {
    let sea = default_sea();
    let response = sea.response(&Path::new(DVec3::NEG_Z, DVec3::Z), (0.0, 0.0), 0.0);
    let moments = sea.moments(0.0);
    let k = sea.medium().wavenumber_radpm();
    let calm = (-4.0 * k * k * moments.roughness_m2).exp();
    let peak = reflection(EPS, 1.0).v.norm_sqr() / (2.0 * (moments.slopes.up * moments.slopes.cross).sqrt());
    let sigma0 = response.specular_sigma0();
    assert!(
        (sigma0[0][0] / (peak * calm) - 1.0).abs() < 1e-12
            && (sigma0[1][1] / sigma0[0][0] - 1.0).abs() < 1e-12
    );
    assert_eq!(response.bragg_sigma0(), [[0.0; 2]; 2], "no Bragg wave below the cut");
    // The power is continuous on the way there, whatever the bases do.
    for azimuth in [0.0, 1.0, 2.0] {
        let up = inclined(1e-7, azimuth);
        let near = sea.response(&Path::new(-up, up), (0.0, 0.0), 0.0).specular_sigma0();
        let total = |s: [[f64; 2]; 2]| s.iter().flatten().sum::<f64>();
        // tan^2/(2 s^2) = 1e-14 / 1e-2.
        assert!((total(near) / total(sigma0) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn straight_paths_return_nothing() {
    let sea = default_sea();
    for depression in [0.0, 1e-9, 1e-7] {
        let along = inclined(FRAC_PI_2 + depression, 0.7);
        let on = inclined(FRAC_PI_2 - depression, 0.7);
        let response = sea.response(&Path::new(along, on), (0.0, 0.0), 0.0);
        assert!(finite(&response) && response.bragg_sigma0() == [[0.0; 2]; 2]);
        assert_eq!(response.specular_sigma0(), [[0.0; 2]; 2], "|q| below 1e-6");
    }
    // The forward specular direction: finite, and Bragg waves below the cut do not count twice.
    let response = sea.response(&Path::new(-inclined(1.0, PI), inclined(1.0, 0.0)), (0.0, 0.0), 0.0);
    assert!(finite(&response) && response.bragg_sigma0() == [[0.0; 2]; 2]);
    assert!(response.specular_sigma0()[1][1] > 1.0);
}

#[test]
fn a_medium_like_air_is_invisible() {
    for contrast in [0.0, 1e-300, 1e-16, 1e-12] {
        let mut medium = medium(DVec3::X);
        medium.permittivity = Complex64::new(1.0 + contrast, 0.0);
        let sea = TwoScale::new(Settings::default(), medium, Clean, spectrum().as_psi());
        for theta in [0.0, 0.8, 1.5] {
            let up = inclined(theta, 0.3);
            let response = sea.response(&Path::new(-up, up), (0.01, 0.02), 0.0);
            let total: f64 = response.sigma0().iter().flatten().sum();
            assert!(finite(&response) && total <= 1e-20, "{contrast} at {theta}: {total}");
        }
        let grazing = reflection(medium.permittivity, 0.0);
        assert!(grazing.v.is_finite() && grazing.h.is_finite());
    }
    let lossless = reflection(Complex64::new(80.0, 0.0), 0.5);
    assert!(lossless.v.im == 0.0 && lossless.h.im == 0.0);
}

#[test]
fn a_dead_calm_sea_glints() {
    let mut medium = medium(DVec3::X);
    medium.wind_12p5_mps = 0.0;
    for splitting in [Splitting::Consistent, Splitting::Mars2007] {
        let settings = Settings { splitting, gram_charlier: true, ..Settings::default() };
        let sea = TwoScale::new(settings, medium, Slick::default(), |_, _| 0.0);
        let nadir = sea.response(&Path::new(DVec3::NEG_Z, DVec3::Z), (0.0, 0.0), 0.0);
        assert!(finite(&nadir) && nadir.specular_sigma0()[0][0] > 10.0);
        let up = inclined(0.8, 0.0);
        let oblique = sea.response(&Path::new(-up, up), (0.0, 0.0), 0.0);
        assert!(finite(&oblique) && oblique.bragg_sigma0() == [[0.0; 2]; 2]);
    }
}

#[test]
fn from_l_to_ka() {
    let water = SeaWater { temperature_c: 20.0, salinity_gpkg: 35.0 };
    for carrier_hz in [1.3e9, 5.3e9, 10e9, 35e9] {
        let mut medium = medium(DVec3::X);
        medium.carrier_hz = carrier_hz;
        medium.permittivity = Model::default().permittivity(carrier_hz, water).unwrap();
        let sea = TwoScale::new(Settings::default(), medium, Clean, spectrum().as_psi());
        let cut = sea.cut_radpm().unwrap();
        assert_eq!(cut, (medium.wavenumber_radpm() / 3.0).max(PI));
        let up = inclined(PI / 4.0, 0.0);
        let sigma0 = sea.response(&Path::new(-up, up), (0.0, 0.0), 0.0).sigma0();
        println!(
            "{:>4} GHz, 45 deg: VV {:.1} dB, HH {:.1} dB",
            carrier_hz * 1e-9,
            db(sigma0[0][0]),
            db(sigma0[1][1])
        );
        assert!(sigma0[0][0] > sigma0[1][1] && sigma0[1][1] > 0.0);
    }
}

fn db(ratio: f64) -> f64 {
    10.0 * ratio.log10()
}

#[test]
fn permittivity_outside_its_range_is_refused() {
    let warm = SeaWater { temperature_c: 40.0, salinity_gpkg: 50.0 };
    let faults = Model::MeissnerWentz2012.faults(0.5e9, warm);
    assert_eq!(faults.len(), 3, "all faults at once");
    assert_eq!(
        Model::MeissnerWentz2012.permittivity(10e9, warm).unwrap_err().to_string(),
        "permittivity model Meissner-Wentz 2012: temperature is 40 degrees Celsius, allowed -2 to 34 degrees Celsius"
    );
    assert!(Model::KleinSwift1977.permittivity(f64::NAN, SeaWater { temperature_c: 10.0, ..warm }).is_err());
    assert!(Model::MeissnerWentz2012.extrapolated(35e9, warm).is_finite());
}

/// A direction with the awkward ones made likely.
fn directions() -> impl Strategy<Value = DVec3> {
    prop_oneof![
        4 => (0.0..PI, 0.0..TAU).prop_map(|(theta, azimuth)| inclined(theta, azimuth)),
        1 => Just(DVec3::Z),
        1 => Just(DVec3::X),
        1 => Just(DVec3::Y),
        1 => (-1e-7..1e-7f64, 0.0..TAU).prop_map(|(e, azimuth)| inclined(FRAC_PI_2 + e, azimuth)),
        1 => (0.0..1e-11f64, 0.0..TAU).prop_map(|(e, azimuth)| inclined(e, azimuth)),
    ]
}

proptest! {
    #![proptest_config(crate::cases::proptests(48))]

    #[test]
    fn every_legal_facet_is_finite(
        carrier_hz in 1e9..90e9f64,
        temperature_c in -2.0..34.0f64,
        salinity_gpkg in 0.0..40.0f64,
        wind in prop_oneof![Just(0.0), 0.0..40.0f64],
        downwind_rad in -10.0..10.0f64,
        resolved_radpm in prop_oneof![Just(0.0), 0.05..300.0f64],
        cut_radpm in proptest::option::of(prop_oneof![Just(0.0), 0.0..1e4f64]),
        (mars, tilt_average, gram_charlier) in any::<(bool, bool, bool)>(),
        facets in proptest::collection::vec(
            (directions(), directions(), -5.0..5.0f64, -5.0..5.0f64, 0.0..=1.0f64), 64),
    ) {
        let water = SeaWater { temperature_c, salinity_gpkg };
        let permittivity = Model::MeissnerWentz2012.permittivity(carrier_hz, water).unwrap();
        prop_assert!(permittivity.re >= 1.0 && permittivity.im <= 0.0);
        let medium = Medium {
            carrier_hz,
            permittivity,
            wind_12p5_mps: wind,
            downwind_rad,
            resolved_radpm,
            axis: DVec3::X,
        };
        let splitting = if mars { Splitting::Mars2007 } else { Splitting::Consistent };
        let settings = Settings { splitting, cut_radpm, tilt_average, gram_charlier };
        let spectrum = Elfouhaily { wind_10_mps: wind, downwind_rad };
        // A sea of no wind is flat.
        let psi = |x: f64, y: f64| if wind < 0.3 { 0.0 } else { spectrum.psi(x, y) };
        let sea = TwoScale::new(settings, medium, Slick::default(), psi);
        for (from, to, zx, zy, cover) in facets {
            for path in [Path::new(-from, to), Path::new(-from, from), Path::new(from, from)] {
                let response = sea.response(&path, (zx, zy), cover);
                prop_assert!(finite(&response), "{path:?} {zx} {zy}: {response:?}");
                let normal = DVec3::new(-zx, -zy, 1.0);
                if path.ki.dot(normal) >= 0.0 || path.ks.dot(normal) <= 0.0 {
                    prop_assert!(zero(&response), "neither illuminated nor seen: {path:?} {zx} {zy}");
                }
            }
        }
    }
}
