//! `nereus import fers`: the radar equation holds for what comes out; what is left out and refused is named.

use std::fs;
use std::path::Path;

use crate::program::{Ended, nereus, package};

fn scene() -> String {
    package().join("configs/fers/bistatic.fersxml").display().to_string()
}

fn import(folder: &Path, more: &[&str]) -> Ended {
    nereus(folder, &[&["import", "fers", &scene(), "scene"][..], more].concat())
}

/// Delays and powers of both targets at pulse 250, by the numbers of the FERS file.
#[cfg(feature = "hdf5")]
#[test]
fn the_scenario_returns_what_the_radar_equation_says_of_the_scene() {
    const C_MPS: f64 = 299_792_458.0;
    let folder = tempfile::tempdir().unwrap();
    let ended = import(folder.path(), &["--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    let left_out: Vec<&str> =
        report["left_out"].as_array().unwrap().iter().filter_map(|own| own.as_str()).collect();
    assert_eq!(left_out.len(), 2, "{left_out:?}");
    assert!(
        left_out[0].contains("line 10: quantisation") && left_out[1].contains("fluctuation"),
        "{left_out:?}"
    );

    let ask = ["snapshot", "scene/scenario.toml", "--pulse", "250", "--paths", "p.h5"];
    let ended = nereus(folder.path(), &ask);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let file = hdf5::File::open(folder.path().join("p.h5")).unwrap();
    let delay_s = file.dataset("delay_s").unwrap().read_raw::<f64>().unwrap();
    let amplitude = file.dataset("amplitude").unwrap().read_raw::<num_complex::Complex64>().unwrap();
    // 2.5 s of the scene's time: the aircraft is at x = -750 m, the boat at its second waypoint.
    let (tx, rx) = ([0.0, 0.0, 50.0], [-750.0, 4000.0, 1500.0]);
    let apart =
        |a: [f64; 3], b: [f64; 3]| -> f64 { (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt() };
    let wavelength_m = C_MPS / 3e9;
    let pi = std::f64::consts::PI;
    for (n, (place, rcs_m2)) in
        [([3000.0, 4000.0, 1500.0], 12.5), ([2100.0, 3100.0, 100.0], 3.0)].into_iter().enumerate()
    {
        let (out_m, back_m) = (apart(tx, place), apart(rx, place));
        let expected_s = (out_m + back_m) / C_MPS;
        // The aircraft flies on at 100 m/s while the pulse is under way.
        let error_s = (delay_s[n] - expected_s).abs();
        assert!(error_s < 1e-14 + 100.0 / C_MPS * expected_s, "{n}: {error_s} s");
        // The horn looks East: the angle off that, in FERS's own formula.
        let cosine = (place[0] - rx[0]) / back_m;
        let x = pi * 0.5 * (1.0 - cosine * cosine).sqrt() / wavelength_m;
        let horn =
            4.0 * pi * (0.5 / wavelength_m).powi(2) * if x == 0.0 { 1.0 } else { (x.sin() / x).powi(2) };
        let power_w = 2000.0 * 0.5 * horn * wavelength_m.powi(2) * rcs_m2
            / ((4.0 * pi).powi(3) * out_m.powi(2) * back_m.powi(2));
        let apart_db = 10.0 * (amplitude[n].norm_sqr() / power_w).log10();
        println!("{n}: {apart_db:.4} dB");
        // Scalars there, fields here: what H of one end is to H of the other, and gains between the points
        // of a table.
        assert!(apart_db.abs() < 0.03, "{n}: {apart_db} dB");
    }
}

#[test]
fn a_radar_that_is_asked_for_is_taken_and_nothing_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let ended = import(folder.path(), &["--radar", "tz"]);
    assert!(ended.code == 2 && ended.stderr.contains("allowed: tx"), "{}", ended.stderr);
    assert!(!folder.path().join("scene").exists());
    fs::create_dir(folder.path().join("scene")).unwrap();
    let ended = import(folder.path(), &["--radar", "tx"]);
    assert!(ended.code != 0 && ended.stderr.contains("must not exist"), "{}", ended.stderr);
    assert_eq!(fs::read_dir(folder.path().join("scene")).unwrap().count(), 0);
}

/// Beside the radar: a radar of another PRF, and a transmitter of CW.
#[test]
fn what_others_radiate_becomes_emitters_or_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let more = r#"<waveform name="tone"><power>1</power><carrier_frequency>3e9</carrier_frequency><cw/></waveform>
        <waveform name="sweep"><power>5</power><carrier_frequency>3e9</carrier_frequency>
          <fmcw_linear_chirp direction="down"><chirp_bandwidth>4e6</chirp_bandwidth>
          <chirp_duration>1e-3</chirp_duration><chirp_period>2e-3</chirp_period></fmcw_linear_chirp></waveform>
        <platform name="others"><motionpath>
          <positionwaypoint><x>9000</x><y>0</y><altitude>5</altitude><time>0</time></positionwaypoint>
        </motionpath><fixedrotation><startazimuth>0</startazimuth><startelevation>0</startelevation>
          <azimuthrate>36</azimuthrate><elevationrate>0</elevationrate></fixedrotation>
          <monostatic name="second" antenna="iso" waveform="pulse" timing="clock"><pulsed_mode><prf>700</prf>
          <window_skip>0</window_skip><window_length>1e-5</window_length></pulsed_mode></monostatic>
          <transmitter name="hum" antenna="iso" waveform="tone" timing="clock"><cw_mode/></transmitter>
          <transmitter name="sweeper" antenna="iso" waveform="sweep" timing="clock"><fmcw_mode/></transmitter>
        </platform></simulation>"#;
    let text = fs::read_to_string(scene()).unwrap().replace("</simulation>", more);
    fs::write(folder.path().join("m.fersxml"), text).unwrap();
    fs::copy(package().join("configs/fers/pulse.csv"), folder.path().join("pulse.csv")).unwrap();
    let ended = nereus(folder.path(), &["import", "fers", "m.fersxml", "scene"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    for named in ["a receiver without the PRF of 'tx'", "a transmitter of CW"] {
        assert!(ended.stderr.contains(named), "{named}: {}", ended.stderr);
    }
    let scenario = fs::read_to_string(folder.path().join("scene/scenario.toml")).unwrap();
    let scenario: toml::Table = scenario.parse().unwrap();
    let emitters = scenario["emitter"].as_array().unwrap();
    let names: Vec<&str> = emitters.iter().filter_map(|own| own["name"].as_str()).collect();
    assert_eq!((names, scenario["receiver"].as_array().unwrap().len()), (vec!["second", "sweeper"], 1));
    // Down from 3 GHz over 4 MHz, by an antenna that turns six times a minute: 72 deg at the start.
    assert_eq!(emitters[1]["carrier_hz"].as_float(), Some(3e9 - 2e6));
    let pointing = &emitters[1]["pointing"];
    assert_eq!((pointing["rpm"].as_float(), pointing["start_deg"].as_float()), (Some(6.0), Some(72.0)));
}

#[test]
fn all_faults_of_a_scene_are_named_with_their_lines() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(scene()).unwrap();
    let wrong = text
        .replace("<rate>20e6</rate>", "<rate>fast</rate>")
        .replace("waveform=\"pulse\"", "waveform=\"pulze\"")
        .replace("<altitude>50</altitude>", "");
    fs::write(folder.path().join("w.fersxml"), wrong).unwrap();
    let ended = nereus(folder.path(), &["import", "fers", "w.fersxml", "scene"]);
    assert_eq!(ended.code, 2);
    for named in
        ["line 8: <rate>: 'fast'", "waveform 'pulze' is not known; allowed: pulse", "<altitude> is missing"]
    {
        assert!(ended.stderr.contains(named), "{named}: {}", ended.stderr);
    }
    fs::write(folder.path().join("x.fersxml"), "<simulation>\n<a></simulation>").unwrap();
    let ended = nereus(folder.path(), &["import", "fers", "x.fersxml", "scene"]);
    assert!(ended.code == 2 && ended.stderr.contains("line 2: is no XML"), "{}", ended.stderr);
}
