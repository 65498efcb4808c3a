//! Messages on ports: what platforms report, and what is reported of targets.

use super::{Ground, Names};
use crate::config::choices::{AimFrom, NavFormat};
use crate::config::error::Problem;
use crate::config::keys;
use crate::config::section::Section;
use crate::nav::encode::Sentence;
use crate::sinks::nav::{Messages, NavSettings, TargetSentence, TargetSettings};
use crate::sinks::port::Device;

/// The keys of `kind = "nav"`.
pub(super) fn nav(section: &Section<'_>, ground: &Ground, platforms: &Names) -> Option<NavSettings> {
    use keys::sink::{FORMAT, LATENCY_S, PLATFORM, SENTENCES};
    let device = device(section, ground);
    let platform = platforms.find_or_only(section, &PLATFORM);
    let words = match section.choice(&FORMAT) {
        Some(NavFormat::InspvaxAscii) => Some(Messages::InspvaxAscii),
        Some(NavFormat::InspvaxBinary) => Some(Messages::InspvaxBinary),
        Some(NavFormat::Nmea) if section.has(&SENTENCES) => {
            let named = |text: &str| Sentence::named(text).map(Sentence::name);
            section.words(&SENTENCES, named).map(Messages::Nmea)
        }
        Some(NavFormat::Nmea) => {
            section.words(&SENTENCES, |_| Some(""));
            Some(Messages::Nmea(vec!["GGA", "RMC"]))
        }
        None => None,
    };
    let rate_hz = rate_hz(section, 5.0);
    let latency_s = section.number(&LATENCY_S);
    Some(NavSettings {
        device: device?,
        platform: platform?,
        messages: words?,
        rate_hz: rate_hz?,
        latency_s: latency_s?,
        force: false,
    })
}

/// The keys of `kind = "targets"`.
pub(super) fn targets(section: &Section<'_>, ground: &Ground, platforms: &Names) -> Option<TargetSettings> {
    use keys::sink::{LATENCY_S, OWN_SHIP, PLATFORM, TARGET_SENTENCES};
    let device = device(section, ground);
    let platform = platforms.find_or_only(section, &PLATFORM);
    let written = section.words(&TARGET_SENTENCES, TargetSentence::named);
    let sentences = match section.has(&TARGET_SENTENCES) {
        true => written,
        false => Some(vec![TargetSentence::Ttm, TargetSentence::Tll, TargetSentence::Vdm]),
    };
    let own_ship: Option<AimFrom> = section.choice(&OWN_SHIP);
    let rate_hz = rate_hz(section, 1.0);
    let latency_s = section.number(&LATENCY_S);
    Some(TargetSettings {
        device: device?,
        platform: platform?,
        sentences: sentences?,
        from_truth: own_ship? == AimFrom::True,
        rate_hz: rate_hz?,
        latency_s: latency_s?,
        force: false,
    })
}

/// The port, in a scene that lies somewhere on Earth.
fn device(section: &Section<'_>, ground: &Ground) -> Option<Device> {
    use keys::sink::{BAUD, DEVICE};
    if ground.sound && ground.origin_h_m.is_none() {
        section.fault(&DEVICE, Problem::ReportNeedsOrigin);
    }
    let baud = section.count(&BAUD).and_then(|baud| u32::try_from(baud).ok());
    let device = section.output(&DEVICE).and_then(|text| {
        let device = Device::of(text.to_str().unwrap_or_default(), baud.unwrap_or_default());
        device.map_err(|error| section.fault(&DEVICE, Problem::Device { error: error.to_string() })).ok()
    });
    device.filter(|_| baud.is_some())
}

/// Messages a second; the default depends on the kind.
fn rate_hz(section: &Section<'_>, absent: f64) -> Option<f64> {
    let written = section.number(&keys::sink::RATE_HZ);
    if section.has(&keys::sink::RATE_HZ) { written } else { Some(absent) }
}
