//! A measured spectrum without Bragg waves: the wind's follow it, joined, unless they are not wanted.

use std::fmt::Write;
use std::path::PathBuf;

use nereus::scene::water::{SpectrumKind, WindProfile};
use nereus::sea::spectrum::{Elfouhaily, Measured, Spectrum, Tailed, WaveVector, of_kind};
use nereus::sea::wind::Wind;

/// Last wave number of the buoy, rad/m: waves of 5 m.
const LAST_RADPM: f64 = 1.25;

/// A buoy's sea: swell and wind sea of this level over Elfouhaily's, about +x.
fn buoy(level: f64, wind: &Wind) -> String {
    let sea = Elfouhaily::new(wind, Default::default()).unwrap();
    let mut text = "kx_rad_m,ky_rad_m,psi_m4\n".to_owned();
    for i in -25..=25 {
        for j in -25..=25 {
            let (x, y) = (f64::from(i) * 0.05, f64::from(j) * 0.05);
            writeln!(text, "{x:.2},{y:.2},{:e}", level * sea.wave_m4(WaveVector::new(x, y))).unwrap();
        }
    }
    text
}

fn wind() -> Wind {
    Wind::from_speed(8.0, 10.0, WindProfile::Cardone, 0.0).unwrap()
}

#[test]
fn the_wind_follows_the_file() {
    let wind = wind();
    for level in [0.5, 1.0, 2.0, 100.0] {
        let measured = Measured::parse(buoy(level, &wind).as_bytes()).unwrap();
        let sea = Tailed::new(measured.clone(), &wind).unwrap();
        assert!((sea.last_rad_m() - LAST_RADPM).abs() < 1e-9);
        // Within the file it is the file's.
        for k in [WaveVector::new(0.3, 0.1), WaveVector::new(1.2, -0.2), WaveVector::new(-0.5, 0.0)] {
            assert_eq!(sea.wave_m4(k), measured.wave_m4(k));
        }
        // Beyond it starts at the file's level (held to ten times) and ends at Elfouhaily's.
        let wind_sea = Elfouhaily::new(&wind, Default::default()).unwrap();
        let ratio = |k: f64| sea.omnidirectional_m3(k) / wind_sea.omnidirectional_m3(k);
        // Values between nodes are chords of a steep curve: some percent too high.
        let share = (1.8f64 / LAST_RADPM).ln() / 4f64.ln();
        let expected = level.min(10.0).powf(0.5 + 0.5 * (std::f64::consts::PI * share).cos());
        assert!((ratio(1.8) / expected - 1.0).abs() < 0.1, "{level}: {}", ratio(1.8));
        for k in [30.0, 300.0] {
            assert!((ratio(k) - 1.0).abs() < 0.05, "{level}, {k}: {}", ratio(k));
        }
        // Radars have their Bragg waves, which the file alone has not.
        let bragg = WaveVector::new(296.0, 0.0);
        assert!(measured.symmetric_m4(bragg) == 0.0 && sea.symmetric_m4(bragg) > 0.0);
    }
}

#[test]
fn directions_integrate_to_the_whole() {
    let wind = wind();
    let sea = Tailed::new(Measured::parse(buoy(1.0, &wind).as_bytes()).unwrap(), &wind).unwrap();
    for k in [0.5, 1.2, 1.5, 1.9, 10.0, 300.0] {
        let step = std::f64::consts::TAU / 4096.0;
        let at = |i: u32| sea.wave_m4(WaveVector::polar(k, (f64::from(i) + 0.5) * step));
        let sum = k * step * (0..4096).map(at).sum::<f64>();
        assert!((sum / sea.omnidirectional_m3(k) - 1.0).abs() < 0.02, "{k}");
    }
}

#[test]
fn it_can_be_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("buoy.csv");
    std::fs::write(&path, buoy(1.0, &wind())).unwrap();
    let bragg = WaveVector::new(296.0, 0.0);
    let of = |tail| {
        of_kind(&SpectrumKind::Measured { path: path.clone(), tail }, &wind()).unwrap().symmetric_m4(bragg)
    };
    assert!(of(false) == 0.0 && of(true) > 0.0);
}
