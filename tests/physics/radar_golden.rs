//! Golden values: geodesy, light time, apertures. Every row of every file.

use std::path::PathBuf;

use nereus::frames::{Earth, Geodetic, SceneFrame, Vector};
use nereus::geometry::light_time::{LightTime, bistatic};
use nereus::motion::pointing::PhaseCentre;
use nereus::radar::antenna::Antenna;
use nereus::time::PulseTimes;
use nereus::units::SPEED_OF_LIGHT_MPS;

use crate::radar_scenes::{evaluate, point, scene, straight, target};

fn folder() -> PathBuf {
    std::env::var_os("NEREUS_GOLDEN")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/golden"), PathBuf::from)
}

/// Rows of a golden file: the named columns, as text.
fn rows<const N: usize>(file: &str, columns: [&str; N]) -> Vec<[String; N]> {
    let mut reader = csv::Reader::from_path(folder().join(file)).unwrap();
    let header = reader.headers().unwrap().clone();
    let places =
        columns.map(|name| header.iter().position(|h| h == name).unwrap_or_else(|| panic!("{name}")));
    let rows: Vec<_> = reader
        .records()
        .map(|row| row.map(|row| places.map(|place| row[place].to_owned())).unwrap())
        .collect();
    assert!(!rows.is_empty(), "{file} is empty");
    rows
}

fn number(text: &str) -> f64 {
    text.trim().parse().unwrap()
}

#[test]
fn geodesy() {
    let columns = ["lat_deg", "lon_deg", "h_m", "ref_lat_deg", "ref_lon_deg", "ref_h_m", "e_m", "n_m", "u_m"];
    let (mut worst_m, mut worst_back_m) = (0f64, 0f64);
    for row in rows("geodesy.csv", columns) {
        let [lat, lon, h, ref_lat, ref_lon, ref_h, e, n, u] = row.map(|text| number(&text));
        let frame = SceneFrame::at(Geodetic::from_deg(ref_lat, ref_lon, ref_h), Earth::Flat);
        let place = Geodetic::from_deg(lat, lon, h);
        let enu = frame.from_geodetic(place).unwrap();
        worst_m = worst_m.max((enu - point([e, n, u])).norm());
        let back = frame.to_geodetic(enu).unwrap();
        worst_back_m = worst_back_m.max((back.to_ecef() - place.to_ecef()).norm());
    }
    for (lat, lon, h) in
        [(90.0, 0.0, 0.0), (-90.0, 10.0, 35.8e6), (-33.0, 180.0, -100.0), (1e-9, -77.0, 800e3)]
    {
        let place = Geodetic::from_deg(lat, lon, h).to_ecef();
        worst_back_m = worst_back_m.max((place.to_geodetic().to_ecef() - place).norm());
    }
    println!("geodesy: worst {worst_m:.2e} m, there and back {worst_back_m:.2e} m");
    assert!(worst_m < 1e-6 && worst_back_m < 1e-6);
}

#[test]
fn echo_delays() {
    let text = std::fs::read_to_string(folder().join("echo_scene.json")).unwrap();
    let golden: serde_json::Value = serde_json::from_str(&text).unwrap();
    let value = |key: &str| golden[key].as_f64().unwrap();
    let triple = |v: &serde_json::Value| [0, 1, 2].map(|i| v[i].as_f64().unwrap());
    let (f0, prf) = (value("f0"), value("prf"));
    let mut scene = scene();
    scene.radar.carrier_hz = f0;
    scene.radar.emissions = PulseTimes::uniform(prf).unwrap();
    scene.targets =
        golden["scat"].as_array().unwrap().iter().map(|s| target(triple(&s[0]), triple(&s[1]))).collect();
    let last = golden["pulses"].as_array().unwrap().iter().map(|p| p.as_u64().unwrap()).max().unwrap();
    scene.pulses = scene.pulses.max(last + 1);
    let tracks = vec![
        straight(&scene, triple(&golden["tx"]), triple(&golden["vtx"])),
        straight(&scene, triple(&golden["rx"]), triple(&golden["vrx"])),
    ];
    let generator = nereus::paths::PathGenerator::new(&scene, value("Tc"), tracks.clone()).unwrap();
    let columns = [
        "pulse",
        "scatterer",
        "tau_exact_s",
        "tau_tx_leg_s",
        "dtau_dt",
        "tau_stop_and_go_s",
        "doppler_hz",
        "phase_f0tau_rad_mod2pi",
    ];
    let mut worst = [0f64; 6];
    for row in rows("echo_delays.csv", columns) {
        let (pulse, k): (u64, usize) = (row[0].parse().unwrap(), row[1].parse().unwrap());
        let [tau, leg, rate, stop, doppler, phase] = [2, 3, 4, 5, 6, 7].map(|i| number(&row[i]));
        let t = scene.radar.emissions.emission(scene.start, pulse);
        let elapsed_s = scene.radar.emissions.interval_s(0, pulse);
        let end = |i: usize| PhaseCentre::of(&tracks[i].truth.state(t).unwrap(), Vector::ZERO);
        let (tx, rx, s) = (end(0), end(1), &scene.targets[k]);
        let at = s.position + s.velocity * elapsed_s;
        let path = bistatic(LightTime::Exact, &tx, at, s.velocity, &rx);
        let standing = bistatic(LightTime::StopAndGo, &tx, at, s.velocity, &rx);
        let turn = std::f64::consts::TAU;
        // Without the rounding of the product.
        let cycles = f0 * path.delay_s;
        let cycles = cycles.fract() + f0.mul_add(path.delay_s, -cycles);
        let phase_error = (cycles * turn - phase).rem_euclid(turn);
        // The record of the whole way gives the same.
        let (_, record) = evaluate(&scene, &generator, pulse);
        assert_eq!(record.target_delay_s[k], path.delay_s);
        assert_eq!(record.target_doppler_hz[k], path.doppler_hz(f0));
        let errors = [
            (path.delay_s - tau).abs(),
            (path.tx_leg_s - leg).abs(),
            (path.delay_rate - rate).abs(),
            (standing.delay_s - stop).abs(),
            (path.doppler_hz(f0) - doppler).abs(),
            phase_error.min(turn - phase_error),
        ];
        worst = std::array::from_fn(|i| worst[i].max(errors[i]));
        // The file's rate is a central difference, stated to about 1e-9; the difference is one of
        // terms as large as speeds over c. One ulp of tau over a step of 1e-4 s comes on top (it
        // matters from space).
        let speeds = tx.velocity.norm() + rx.velocity.norm() + 2.0 * s.velocity.norm();
        let allowed = 1e-9 * speeds / SPEED_OF_LIGHT_MPS + tau * f64::EPSILON / 1e-4;
        assert!(
            errors[2] <= allowed,
            "pulse {pulse} scatterer {k}: rate off by {:e}, {allowed:e}",
            errors[2]
        );
        assert!(errors[4] <= allowed * f0, "pulse {pulse} scatterer {k}: Doppler off by {:e} Hz", errors[4]);
    }
    let [tau, leg, rate, stop, doppler, phase] = worst;
    println!(
        "echo_delays: tau {tau:.2e} s, leg {leg:.2e} s, rate {rate:.2e}, stop-and-go {stop:.2e} s, \
         Doppler {doppler:.2e} Hz, phase {phase:.2e} rad"
    );
    assert!(tau <= 1e-17 && leg <= 1e-17 && stop <= 1e-17 && phase <= 1e-6);
}

#[test]
fn antenna() {
    let mut worst = (0f64, 0f64);
    let mut count = 0;
    for row in rows("antenna.csv", ["shape", "a_m", "b_m", "f_hz", "u", "v", "gain_lin"]) {
        let [width_m, height_m, f_hz, u, v, gain] = [1, 2, 3, 4, 5, 6].map(|i| number(&row[i]));
        let wavelength_m = SPEED_OF_LIGHT_MPS / f_hz;
        let antenna = match row[0].as_str() {
            "rect" => Antenna::Rectangle { width_m, height_m, wavelength_m },
            "ell" => Antenna::Ellipse { width_m, height_m, wavelength_m },
            other => panic!("unknown shape {other}"),
        };
        let direction = Vector::new((1.0 - u * u - v * v).max(0.0).sqrt().max(1e-9), u, v);
        let peak = antenna.field_gain(Vector::new(1.0, 0.0, 0.0)).norm_sqr();
        let ours = antenna.field_gain(direction).norm_sqr();
        let error = (ours - gain).abs();
        worst = (worst.0.max(error / peak), worst.1.max(error / gain.max(1e-300)));
        // 1e-9 of the value; in a null, where the value itself is a rounding, of 1e-6 of the peak.
        assert!(error <= 1e-9 * gain.max(1e-6 * peak), "{row:?}: {ours:e}");
        count += 1;
    }
    println!("antenna: {count} rows, worst {:.2e} of the peak, {:.2e} of the value", worst.0, worst.1);
}
