//! Calibration channels.

use super::Names;
use crate::config::choices::SignalKind;
use crate::config::error::Problem;
use crate::config::keys::{self, Key};
use crate::config::section::Section;
use crate::scene::calibration::{Calibration, Signal};
use crate::scene::radar::Channel;
use crate::units::Decibels;

/// Most of them.
const MOST: u64 = 16;

/// What signals must fit into; `None` of what is faulty or not known yet.
pub(super) struct Limits<'a> {
    pub channels: Option<&'a [Channel]>,
    pub window_s: Option<f64>,
    pub pulse_s: Option<f64>,
    pub sample_rate_hz: Option<f64>,
}

/// `[[radar.calibration]]`.
pub(super) fn calibration(
    radar: &Section<'_>,
    transmitters: &Names,
    receivers: &Names,
    limits: &Limits<'_>,
) -> Option<Vec<Calibration>> {
    use keys::radar::CALIBRATION;
    let sections = radar.sections(&CALIBRATION);
    let count = sections.len() as u64;
    if count > MOST {
        radar.fault(&CALIBRATION, Problem::TooMany { count, what: "calibration channels", allowed: MOST });
    }
    let mut names = Names::new("channel");
    for channel in limits.channels.unwrap_or_default() {
        names.push(Some(channel.name.clone()));
    }
    let list: Vec<Option<Calibration>> = sections
        .into_iter()
        .map(|section| one(section, &mut names, transmitters, receivers, limits))
        .collect();
    list.into_iter().collect()
}

fn one(
    section: Section<'_>,
    names: &mut Names,
    transmitters: &Names,
    receivers: &Names,
    limits: &Limits<'_>,
) -> Option<Calibration> {
    use keys::calibration as k;
    names.take(&section, &k::NAME, &[]);
    let name = names.last();
    let kind = section.choice(&k::KIND);
    let receiver = receivers.find_among(&section, &k::RECEIVER);
    let power_dbw = section.number(&k::POWER_DBW);
    let phase_deg = section.number(&k::PHASE_DEG);
    let noise = section.flag(&k::NOISE);
    let outside = |key: &'static Key, least: f64, most: f64, unit: &str| {
        let error = format!("allowed: from {least} to {most} {unit}");
        section.fault(key, Problem::Refused { error });
    };
    let signal = match kind {
        Some(SignalKind::Tone) => {
            let offset_hz = section.number(&k::OFFSET_HZ);
            if let (Some(offset_hz), Some(fs)) = (offset_hz, limits.sample_rate_hz)
                && offset_hz.abs() > 0.5 * fs
            {
                outside(&k::OFFSET_HZ, -0.5 * fs, 0.5 * fs, "Hz, half the sample rate");
            }
            offset_hz.map(|offset_hz| Signal::Tone { offset_hz })
        }
        Some(SignalKind::Loopback) => {
            let transmitter = transmitters.find_among(&section, &k::TRANSMITTER);
            let delay_s = section.number(&k::DELAY_S);
            if let (Some(delay_s), Some(window_s), Some(pulse_s)) = (delay_s, limits.window_s, limits.pulse_s)
                && delay_s > window_s - pulse_s
                && window_s >= pulse_s
            {
                outside(&k::DELAY_S, 0.0, window_s - pulse_s, "s, so that the whole pulse is in the window");
            }
            transmitter.zip(delay_s).map(|(transmitter, delay_s)| Signal::Loopback { transmitter, delay_s })
        }
        None => None,
    };
    section.finish();
    Some(Calibration {
        name: name?,
        receiver: receiver?,
        power_w: Decibels(power_dbw?).power_ratio(),
        phase_rad: phase_deg?.to_radians(),
        noise: noise?,
        signal: signal?,
    })
}
