//! Navigation outputs.

use super::{Ground, Names};
use crate::config::choices::NavFormat;
use crate::config::error::Problem;
use crate::config::keys;
use crate::config::section::Section;
use crate::nav::encode::Sentence;
use crate::sinks::nav::{Messages, NavSettings};
use crate::sinks::port::Device;

/// The keys of `kind = "nav"`.
pub(super) fn nav(section: &Section<'_>, ground: &Ground, platforms: &Names) -> Option<NavSettings> {
    use keys::sink::{BAUD, DEVICE, FORMAT, LATENCY_S, PLATFORM, RATE_HZ, SENTENCES};
    if ground.sound && ground.origin_h_m.is_none() {
        section.fault(&DEVICE, Problem::ReportNeedsOrigin);
    }
    let baud = section.count(&BAUD).and_then(|baud| u32::try_from(baud).ok());
    let device = section.output(&DEVICE).and_then(|text| {
        let device = Device::of(text.to_str().unwrap_or_default(), baud.unwrap_or_default());
        device.map_err(|error| section.fault(&DEVICE, Problem::Device { error: error.to_string() })).ok()
    });
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
    let rate_hz = section.number(&RATE_HZ);
    let latency_s = section.number(&LATENCY_S);
    Some(NavSettings {
        device: device.filter(|_| baud.is_some())?,
        platform: platform?,
        messages: words?,
        rate_hz: rate_hz?,
        latency_s: latency_s?,
        force: false,
    })
}
