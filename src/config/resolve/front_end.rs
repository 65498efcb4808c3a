//! What is wrong between echo and converter.

use std::f64::consts::TAU;

use crate::config::error::Problem;
use crate::config::keys::front_end as k;
use crate::config::section::Section;
use crate::scene::front_end::{Agc, FrontEnd, Instability, Jitter, Stc};
use crate::units::Decibels;

/// Turn of the highest frequency by the jitter, rad: first order holds to a few percent of it.
const MOST_TURN_RAD: f64 = 0.3;

/// `[radar.front_end]` of a radar with a sample rate.
pub(super) fn front_end(section: Section<'_>, sample_rate_hz: Option<f64>) -> Option<FrontEnd> {
    let (gain_db, phase_deg) = (section.number(&k::IQ_GAIN_DB), section.number(&k::IQ_PHASE_DEG));
    let (offset_dbw, turned_deg) = (section.number(&k::OFFSET_DBW), section.number(&k::OFFSET_PHASE_DEG));
    if !section.has(&k::OFFSET_DBW) {
        section.idle(&[&k::OFFSET_PHASE_DEG], "there is no offset_dbw");
    }
    let full_us = section.number(&k::STC_FULL_US);
    let (exponent, depth_db) = (section.number(&k::STC_EXPONENT), section.number(&k::STC_DEPTH_DB));
    if !section.has(&k::STC_FULL_US) {
        section.idle(&[&k::STC_EXPONENT, &k::STC_DEPTH_DB], "there is no stc_full_us");
    }
    let (blanking, recovery_us) = (section.flag(&k::BLANKING), section.number(&k::RECOVERY_US));
    if blanking == Some(false) {
        section.idle(&[&k::RECOVERY_US], "blanking = false");
    }
    let level_dbw = section.number(&k::AGC_LEVEL_DBW);
    let [attack_us, release_us, agc_depth_db] =
        [&k::AGC_ATTACK_US, &k::AGC_RELEASE_US, &k::AGC_DEPTH_DB].map(|key| section.number(key));
    if !section.has(&k::AGC_LEVEL_DBW) {
        section.idle(&[&k::AGC_ATTACK_US, &k::AGC_RELEASE_US, &k::AGC_DEPTH_DB], "there is no agc_level_dbw");
    }
    let (level_db, turned_rms_deg) =
        (section.number(&k::TX_LEVEL_RMS_DB), section.number(&k::TX_PHASE_RMS_DEG));
    let (rms_s, intermediate_hz) = (section.number(&k::JITTER_RMS_S), section.number(&k::JITTER_IF_HZ));
    if rms_s == Some(0.0) {
        section.idle(&[&k::JITTER_IF_HZ], "jitter_rms_s = 0");
    }
    if let (Some(rms_s), Some(intermediate_hz), Some(rate_hz)) = (rms_s, intermediate_hz, sample_rate_hz) {
        let highest_hz = intermediate_hz + 0.5 * rate_hz;
        let turn_rad = TAU * highest_hz * rms_s;
        if turn_rad > MOST_TURN_RAD {
            let error = format!(
                "{rms_s:e} s turn the highest frequency, {highest_hz:e} Hz, by {turn_rad:.2} rad; allowed: at \
                 most {MOST_TURN_RAD} rad, {:.2e} s",
                MOST_TURN_RAD / (TAU * highest_hz)
            );
            section.fault(&k::JITTER_RMS_S, Problem::Refused { error });
        }
    }
    let has = |key| section.has(key);
    let (offsets, controls, holds) = (has(&k::OFFSET_DBW), has(&k::STC_FULL_US), has(&k::AGC_LEVEL_DBW));
    section.finish();
    let offset = if offsets {
        let (sin, cos) = turned_deg?.to_radians().sin_cos();
        let amplitude = Decibels(offset_dbw?).power_ratio().sqrt();
        [amplitude * cos, amplitude * sin]
    } else {
        [0.0; 2]
    };
    let stc = if controls {
        Some(Stc { full_s: full_us? / 1e6, exponent: exponent?, depth_db: depth_db? })
    } else {
        None
    };
    let agc = if holds {
        Some(Agc {
            level_w: Decibels(level_dbw?).power_ratio(),
            attack_s: attack_us? / 1e6,
            release_s: release_us? / 1e6,
            depth_db: agc_depth_db?,
        })
    } else {
        None
    };
    let instability = Instability { level_db: level_db?, phase_rad: turned_rms_deg?.to_radians() };
    let is_stable = instability.level_db == 0.0 && instability.phase_rad == 0.0;
    let (rms_s, intermediate_hz) = (rms_s?, intermediate_hz?);
    Some(FrontEnd {
        iq_gain_db: gain_db?,
        iq_phase_rad: phase_deg?.to_radians(),
        offset,
        stc,
        agc,
        instability: (!is_stable).then_some(instability),
        jitter: (rms_s > 0.0).then_some(Jitter { rms_s, intermediate_hz }),
        blanked_s: if blanking? { Some(recovery_us? / 1e6) } else { None },
    })
}
