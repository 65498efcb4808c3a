//! Anything is read or refused: files that are no scenarios, damaged ones, any text, any override.

use proptest::prelude::*;

use super::*;

#[test]
fn files_that_are_no_scenarios() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    assert!(matches!(load(&path, &[]), Err(ConfigError::Read { .. })));
    std::fs::write(&path, b"x = \"\xff\"").unwrap();
    assert!(matches!(load(&path, &[]), Err(ConfigError::NotText { offset: 5, .. })));
    std::fs::write(&path, vec![b'#'; LARGEST_FILE as usize + 1]).unwrap();
    assert!(matches!(load(&path, &[]), Err(ConfigError::TooLarge { .. })));
    std::fs::write(&path, "").unwrap();
    // An empty file lacks the five required tables.
    assert_eq!(load(&path, &[]).unwrap_err().faults().len(), 5);
    std::fs::write(&path, "[".repeat(100_000)).unwrap();
    assert!(!load(&path, &[]).unwrap_err().faults().is_empty());
    std::fs::write(&path, format!("a = {}", "[".repeat(100_000))).unwrap();
    assert!(!load(&path, &[]).unwrap_err().faults().is_empty());
    std::fs::write(&path, format!("{} = 1", "a.".repeat(10_000) + "a")).unwrap();
    assert!(!load(&path, &[]).unwrap_err().faults().is_empty());
}

#[cfg(unix)]
#[test]
fn what_is_named_and_is_no_file_is_called_what_it_is() {
    let of = |path: &str| {
        let waveform = format!("{{ kind = 'file', path = '{path}', rate_hz = 5e7 }}");
        faults_of(&[("radar.waveform", &waveform)])
    };
    let allowed = "allowed: a file that exists (relative to the scenario file)";
    for device in ["/dev/zero", "/dev/null"] {
        let found = of(device);
        assert!(
            found.contains(&format!("radar.waveform.path: {device} is a pipe or a device; {allowed}")),
            "{found}"
        );
    }
    assert!(of("/").contains("radar.waveform.path: / is a folder; "), "{}", of("/"));
}

/// A text whose characters from `at` of its length on, `cut` of them, are replaced.
pub(super) fn corrupted(text: &str, at: f64, cut: usize, put: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let start = (at * chars.len() as f64) as usize;
    let end = (start + cut).min(chars.len());
    chars[..start].iter().copied().chain(put.chars()).chain(chars[end..].iter().copied()).collect()
}

/// A refused scenario always has a reason.
pub(super) fn survives(text: &str) {
    if let Err(error) = parse(text, &in_configs(), &[]) {
        assert!(!error.faults().is_empty(), "{text}");
        assert!(!error.to_string().is_empty());
    }
}

proptest! {
    #![proptest_config(crate::rng::cases::proptests(400))]

    #[test]
    fn any_text_is_read_or_refused(text in "(?s).{0,200}") {
        survives(&text);
    }

    #[test]
    fn a_corrupt_scenario_is_read_or_refused(
        which in 0usize..5,
        at in 0.0f64..1.0,
        cut in 0usize..40,
        put in "[a-z0-9_.=\\[\\]{}\"'\\-+#\n ,é]{0,12}",
    ) {
        let text = [COASTAL, CALIBRATION, MONOSTATIC, SPACEBORNE, QUICKSTART][which];
        survives(&corrupted(text, at, cut, &put));
    }

    #[test]
    fn any_override_is_taken_or_refused(key in "[a-z0-9_.]{0,30}", value in "(?s).{0,20}") {
        let set = [(key, value)];
        match parse(COASTAL, &in_configs(), &set) {
            Ok(run) => prop_assert!(parse(&run.text, &in_configs(), &[]).is_ok()),
            Err(error) => prop_assert!(!error.faults().is_empty()),
        }
    }

    #[test]
    fn extreme_numbers_are_read_or_refused(
        index in 0usize..14,
        value in prop_oneof![any::<f64>(), (-12i32..13).prop_map(|e| 10f64.powi(e))],
    ) {
        let key = [
            "radar.carrier_hz", "radar.sample_rate_hz", "radar.prf_hz", "radar.waveform.bandwidth_hz",
            "radar.waveform.pulse_s", "radar.window.start_us", "scene.duration_s", "stream.latency_ms",
            "transmitter.0.power_w", "target.0.rcs_dbsm", "receiver.0.antenna.width_m",
            "radar.losses_db", "platform.0.track.yaw_deg", "radar.pri_us.0",
        ][index];
        let mut set = vec![(key.to_owned(), format!("{value:?}"))];
        let mut text = COASTAL.to_owned();
        if key.starts_with("radar.pri_us") {
            text = text.replace("prf_hz = 222.0", "pri_us = [1000.0, 1.0]");
        }
        set.push(("stream.threads".to_owned(), "1".to_owned()));
        match parse(&text, &in_configs(), &set) {
            Ok(run) => prop_assert!(run.stream.ring_slots >= 2 && run.scene.pulses >= 1),
            Err(error) => prop_assert!(!error.faults().is_empty()),
        }
    }
}

#[test]
fn rain_that_cannot_return_an_echo() {
    let faults = |overrides: &[(&str, &str)]| {
        let error = parse(QUICKSTART, &in_configs(), &settings(overrides)).unwrap_err();
        error.faults().iter().map(|fault| format!("{fault}\n")).collect::<String>()
    };
    let on = ("radar.rain_clutter", "true");
    let dry = faults(&[on]);
    assert!(dry.contains("radar.rain_clutter") && dry.contains("rain_mmph = 0"), "{dry}");
    let high = faults(&[on, ("radar.rain_mmph", "5"), ("radar.carrier_hz", "35e9")]);
    assert!(high.contains("Rayleigh scattering") && high.contains("3.5e10"), "{high}");
    let off = faults(&[("radar.rain_top_m", "2000"), ("radar.rain_spread_mps", "2")]);
    assert!(off.contains("rain_top_m") && off.contains("rain_clutter = false"), "{off}");
    let heights = ["0", "49", "-5"].map(|height| ("radar.rain_top_m", height));
    for (key, value) in heights.into_iter().chain([("radar.rain_spread_mps", "-1")]) {
        let faults = faults(&[on, ("radar.rain_mmph", "5"), (key, value)]);
        assert!(faults.contains(key) && faults.contains("allowed"), "{faults}");
    }
    let meant = faults(&[("radar.rain_cluter", "true")]);
    assert!(meant.contains("rain_clutter"), "{meant}");
}
