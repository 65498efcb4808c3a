//! The front end of the receiver, and droop: what arrives, and every way to be wrong.

use super::*;
use crate::scene::front_end::{Jitter, Stc};
use crate::scene::radar::Waveform;

/// Scenarios that between them read every key.
pub(super) fn variants() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    vec![(COASTAL, vec![("radar.front_end", "{}")])]
}

#[test]
fn every_setting_arrives() {
    let table = "{ iq_gain_db = 0.5, iq_phase_deg = 90e-1, offset_dbw = -100, offset_phase_deg = 90, \
                 stc_full_us = 20, stc_exponent = 3, blanking = true, recovery_us = 2, jitter_rms_s = 1e-12, \
                 jitter_if_hz = 7e7 }";
    let run = coastal_with(&[("radar.front_end", table), ("radar.waveform.droop_db", "1.5")]).unwrap();
    let of = run.scene.radar.front_end;
    assert_eq!((of.iq_gain_db, of.iq_phase_rad), (0.5, 9f64.to_radians()));
    assert!((of.offset[1] - 1e-5).abs() < 1e-18 && of.offset[0].abs() < 1e-20, "{:?}", of.offset);
    assert_eq!(of.stc, Some(Stc { full_s: 20.0 / 1e6, exponent: 3.0, depth_db: 60.0 }));
    assert_eq!(of.jitter, Some(Jitter { rms_s: 1e-12, intermediate_hz: 7e7 }));
    assert_eq!(of.blanked_s, Some(2.0 / 1e6));
    let Waveform::Drooping { of, droop_db } = run.scene.radar.waveform else { panic!("it does not droop") };
    assert_eq!((of.kind(), droop_db), ("lfm", 1.5));
    assert!(coastal_with(&[]).unwrap().scene.radar.front_end.is_ideal());
}

#[test]
fn faults_are_named() {
    let has = |table: &str, wanted: &str| {
        let found = faults_of(&[("radar.front_end", table)]);
        assert!(found.contains(wanted), "{found}");
    };
    has("{ iq_gain_db = 30 }", "radar.front_end.iq_gain_db: 30 is out of range");
    has("{ offset_phase_deg = 3 }", "there is no offset_dbw");
    has("{ stc_depth_db = 3 }", "there is no stc_full_us");
    has("{ recovery_us = 3 }", "blanking = false");
    has("{ jitter_if_hz = 1e6 }", "jitter_rms_s = 0");
    has(
        "{ jitter_rms_s = 1e-6 }",
        "turn the highest frequency, 5e7 Hz, by 314.16 rad; allowed: at most 0.3 rad",
    );
    has("{ blanked = true }", "radar.front_end.blanked");
    let droop = |settings: &[(&str, &str)], wanted: &str| {
        let found = faults_of(settings);
        assert!(found.contains(wanted), "{found}");
    };
    droop(&[("radar.waveform.droop_db", "-1")], "radar.waveform.droop_db: -1 is out of range");
    droop(
        &[("radar.waveform", "{ kind = 'noise', bandwidth_hz = 1e6, droop_db = 1 }")],
        "droop of kind = \"noise\"",
    );
    droop(
        &[("radar.front_end", "{ blanking = true }"), ("radar.dechirp", "{ delay_us = 20 }")],
        "dechirp beside stc_full_us or blanking in [radar.front_end]",
    );
}
