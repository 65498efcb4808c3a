//! Bragg waves in light wind: what the sea returns grows with the wind, and the dark wake is dark in every
//! band.

use glam::DVec3;
use nereus::scattering::kind::clean::Clean;
use nereus::scattering::kind::turbulent_wake::{TurbulentWake, WIND_RATIO};
use nereus::scattering::permittivity::{Model, SeaWater};
use nereus::scattering::tilt::Path;
use nereus::scattering::two_scale::{Medium, Settings, TwoScale};
use nereus::scene::water::{Development, SpectrumKind, WindProfile};
use nereus::sea::spectrum::light_wind::threshold_mps;
use nereus::sea::spectrum::{LightWind, Spectrum, WaveVector, of_kind};
use nereus::sea::wind::Wind;

use crate::cases::sized;

const BANDS: [(&str, f64); 4] = [("L", 1.3e9), ("C", 5.3e9), ("X", 10e9), ("Ka", 35e9)];

fn elfouhaily() -> SpectrumKind {
    SpectrumKind::Elfouhaily { development: Development::default() }
}

fn wind(u10_mps: f64) -> Wind {
    Wind::from_speed(u10_mps, 10.0, WindProfile::Cardone, 0.0).unwrap()
}

fn medium(carrier_hz: f64, wind: &Wind, facet_m: f64) -> Medium {
    let water = SeaWater { temperature_c: 20.0, salinity_gpkg: 35.0 };
    Medium {
        carrier_hz,
        permittivity: Model::default().permittivity(carrier_hz, water).unwrap(),
        wind_12p5_mps: wind.u12_5_mps,
        downwind_rad: 0.0,
        resolved_radpm: std::f64::consts::PI / facet_m,
        axis: DVec3::X,
    }
}

/// Looking back at an incidence, so many degrees from upwind.
fn path(incidence_deg: f64, aspect_deg: f64) -> Path {
    let ((s, c), azimuth_rad) = (incidence_deg.to_radians().sin_cos(), aspect_deg.to_radians());
    let away = DVec3::new(-s * azimuth_rad.cos(), -s * azimuth_rad.sin(), -c);
    Path::new(away, -away)
}

/// Looks at every band, facets of two sizes, incidences and aspects: name, carrier, facet, path.
fn looks() -> Vec<(String, f64, f64, Path)> {
    let angles = [(30.0, 0.0), (45.0, 0.0), (45.0, 90.0), (60.0, 45.0), (75.0, 0.0), (75.0, 90.0)];
    let mut looks = Vec::new();
    for (band, carrier_hz) in BANDS {
        for facet_m in [0.5, 2.0] {
            for (incidence_deg, aspect_deg) in angles {
                let name = format!("{band}, {facet_m} m, {incidence_deg} deg, {aspect_deg} deg off upwind");
                looks.push((name, carrier_hz, facet_m, path(incidence_deg, aspect_deg)));
            }
        }
    }
    looks
}

/// As published it rises by up to 8 dB as the wind falls (X band, VV, 45 degrees: -25.4 dB at 3 m/s, -17.9 at
/// 0.31).
#[test]
fn more_wind_never_returns_less() {
    let looks = looks();
    let settings = Settings { tilt_average: true, ..Settings::default() };
    for kind in [elfouhaily(), SpectrumKind::ElfouhailyFungLee { development: Development::default() }] {
        let mut last = vec![[f64::NEG_INFINITY; 2]; looks.len()];
        let mut u10_mps = 0.31;
        while u10_mps < 15.0 {
            let wind = wind(u10_mps);
            let spectrum = LightWind::new(&kind, &wind).unwrap();
            let psi = |x: f64, y: f64| spectrum.symmetric_m4(WaveVector::new(x, y));
            let mut sea = None;
            for ((name, carrier_hz, facet_m, path), last) in looks.iter().zip(&mut last) {
                let medium = medium(*carrier_hz, &wind, *facet_m);
                let sea = match &mut sea {
                    Some((of, sea)) if *of == medium => sea,
                    other => &mut other.insert((medium, TwoScale::new(settings, medium, Clean, &psi))).1,
                };
                let sigma0 = sea.response(path, (0.0, 0.0), 0.0).sigma0();
                let found = [sigma0[0][0], sigma0[1][1]].map(|ratio| 10.0 * ratio.log10());
                for (channel, (found, last)) in ["VV", "HH"].iter().zip(found.iter().zip(&*last)) {
                    // A hundredth: nodes of the table of factors.
                    assert!(
                        *found > last - 0.01,
                        "{kind:?} {name}, {channel}, {u10_mps:.2} m/s: {found:.2} after {last:.2} dB"
                    );
                }
                *last = found;
            }
            u10_mps *= sized(1.12, 1.3);
        }
    }
}

#[test]
fn a_fresh_breeze_is_as_published() {
    // From 20 rad/m on, above 8 m/s and above twice the threshold of all waves.
    for u10_mps in [8.0, 9.4, 14.0, 20.0] {
        let wind = wind(u10_mps);
        let [published, sea] =
            [of_kind(&elfouhaily(), &wind).unwrap(), Box::new(LightWind::new(&elfouhaily(), &wind).unwrap())];
        for i in 0..60 {
            let (k, azimuth) = (20.0 * 1.06f64.powi(i), f64::from(i));
            let at = WaveVector::polar(k, azimuth);
            let ratio = sea.symmetric_m4(at) / published.symmetric_m4(at);
            assert!((ratio - 1.0).abs() < 1e-3, "{u10_mps} m/s, {k} rad/m: {ratio}");
        }
    }
    // Plant's growth against viscosity: u*^2 = 100 nu K c.
    assert!((threshold_mps(300.0) - (100.0 * 1.05e-6 * 300.0 * 0.2327f64).sqrt()).abs() < 1e-4);
    assert_eq!(threshold_mps(370.0), threshold_mps(1500.0));
}

/// Prints the table of docs/sigma0.md: clean water over the middle of a dark wake, VV, 45 degrees, upwind,
/// dB.
#[test]
fn the_dark_wake_is_dark_in_every_band() {
    for u10_mps in [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0] {
        let mut row = format!("| {u10_mps} |");
        for (band, carrier_hz) in BANDS {
            let [outside, inside] = [u10_mps, WIND_RATIO * u10_mps].map(|u10_mps| {
                Box::new(LightWind::new(&elfouhaily(), &wind(u10_mps)).unwrap()) as Box<dyn Spectrum>
            });
            let medium = medium(carrier_hz, &wind(u10_mps), 1.0);
            let range = [0.5, 2.0 * medium.wavenumber_radpm()];
            let ratio =
                |k: f64| inside.omnidirectional_m3(k) / outside.omnidirectional_m3(k).max(f64::MIN_POSITIVE);
            let strip = TurbulentWake::new(range, ratio).unwrap();
            let settings = Settings { tilt_average: true, ..Settings::default() };
            let sea =
                TwoScale::new(settings, medium, strip, |x, y| outside.symmetric_m4(WaveVector::new(x, y)));
            let [clean, dark] =
                [0.0, 1.0].map(|cover| sea.response(&path(45.0, 0.0), (0.0, 0.0), cover).sigma0()[0][0]);
            let contrast_db = 10.0 * (clean / dark).log10();
            assert!(contrast_db > 0.5, "{band}, {u10_mps} m/s: {contrast_db:.2} dB");
            row += &format!(" {contrast_db:.1} |");
        }
        println!("{row}");
    }
}
