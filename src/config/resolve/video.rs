//! Radar video.

use std::net::{IpAddr, Ipv4Addr};

use super::{Names, address_or};
use crate::config::choices::{Bits, DetectionKind};
use crate::config::error::Problem;
use crate::config::keys::{self, figure};
use crate::config::section::Section;
use crate::processor::ppi::PpiError;
use crate::scene::Radar;
use crate::scene::radar::{Channel, Pointing};
use crate::sinks::asterix::{ADDRESS as PORT, Detection, Settings, Source, check_group};
use crate::units::SPEED_OF_LIGHT_MPS;

/// The keys of `kind = "asterix"`.
pub(super) fn asterix(section: &Section<'_>, radar: Option<&Radar>, platforms: &Names) -> Option<Settings> {
    use keys::sink::{
        BITS, CELL, CELL_M, CHANNEL, DETECTION, DYNAMIC_DB, FULL_DBW, INTERFACE, MTU_BYTES, RADIAL_PULSES,
        SAC, SIC, TTL_HOPS,
    };
    let optional = |key| section.number(key).map(Some).or(if section.has(key) { None } else { Some(None) });
    let to = group(section);
    let interface = match section.has(&INTERFACE) {
        true => section.interface(&INTERFACE),
        false => {
            section.interface(&INTERFACE);
            Some(Ipv4Addr::LOCALHOST)
        }
    };
    let (ttl, mtu_bytes) = (section.count(&TTL_HOPS), section.count(&MTU_BYTES));
    let [sac, sic] = [&SAC, &SIC].map(|key| section.count(key).and_then(|code| u8::try_from(code).ok()));
    let channel = section.name(&CHANNEL);
    let has_channel = channel.is_some() || !section.has(&CHANNEL);
    let cell_m = optional(&CELL_M);
    let (cell, radial_pulses) = (section.choice(&CELL), section.count(&RADIAL_PULSES));
    let bits = section.count(&BITS).and_then(Bits::of);
    let detection = section.choice(&DETECTION);
    let (full_dbw, dynamic_db) = (optional(&FULL_DBW), section.number(&DYNAMIC_DB));
    if detection == Some(DetectionKind::Linear) {
        section.idle(&[&DYNAMIC_DB], "detection = \"linear\"");
    }
    if let Some(radar) = radar {
        check_channel(section, radar, channel.as_deref(), platforms);
        check_cell(section, radar, cell_m.flatten());
    }
    let detection = match detection? {
        DetectionKind::Logarithmic => Detection::Logarithmic { dynamic_db: dynamic_db? },
        DetectionKind::Linear => Detection::Linear,
    };
    Some(Settings {
        address: to?,
        interface: interface?,
        ttl: u32::try_from(ttl?).ok()?,
        mtu_bytes: usize::try_from(mtu_bytes?).ok()?,
        source: Source { sac: sac?, sic: sic? },
        channel: has_channel.then_some(channel)?,
        cell_m: cell_m?,
        cell: cell?,
        radial_pulses: radial_pulses?,
        bits: bits?,
        detection,
        full_dbw: full_dbw?,
    })
}

/// The address; faults one to which nothing may be sent, and keys of a group beside that of a machine.
fn group(section: &Section<'_>) -> Option<String> {
    use keys::sink::{ADDRESS, INTERFACE, TTL_HOPS};
    let address = address_or(section, PORT)?;
    let host = address.rsplit_once(':').map_or("", |(host, _)| host).trim_matches(['[', ']']);
    // That of a name is found when it is looked up.
    let ip = host.parse::<IpAddr>().ok();
    if let Some(Err(allowed)) = ip.map(check_group) {
        let (found, allowed) = (format!("\"{address}\""), allowed.to_owned());
        section.fault(&ADDRESS, Problem::Type { found, allowed });
        return None;
    }
    if ip.is_some_and(|ip| !ip.is_multicast()) {
        section.idle(&[&INTERFACE, &TTL_HOPS], "address is that of a machine, not of a group");
    }
    Some(address)
}

/// Faults a channel of which there is no video, and a radar that has none.
fn check_channel(section: &Section<'_>, radar: &Radar, asked: Option<&str>, platforms: &Names) {
    use keys::sink::{CHANNEL, KIND};
    let (found, allowed) =
        ("\"asterix\"", "pulses received in windows (gate = \"windowed\", no radar.dechirp)");
    let place = match () {
        () if radar.sent.is_some() => Some("beside continuous reception"),
        () if radar.dechirp.is_some() => Some("beside radar.dechirp"),
        () => None,
    };
    if let Some(place) = place {
        section.fault(&KIND, Problem::Live { found, place, allowed });
    }
    let of_name = |channel: &&Channel| asked.is_none_or(|name| channel.name == name);
    let faults: Vec<Option<PpiError>> =
        radar.channels.iter().filter(of_name).map(|channel| unseen(radar, channel, platforms)).collect();
    if faults.iter().any(Option::is_none) || section.has(&CHANNEL) && asked.is_none() {
        return;
    }
    match (faults.into_iter().flatten().next(), asked) {
        (Some(error), _) => section.fault(&CHANNEL, Problem::Refused { error: error.to_string() }),
        (None, Some(name)) => {
            let known: Vec<&str> = radar.channels.iter().map(|channel| channel.name.as_str()).collect();
            let (name, known) = (name.to_owned(), known.join(", "));
            section.fault(&CHANNEL, Problem::NoSuch { name, what: "channel", known });
        }
        (None, None) => {}
    }
}

/// Why there is no plan of a channel.
fn unseen(radar: &Radar, channel: &Channel, platforms: &Names) -> Option<PpiError> {
    let (transmitter, receiver) =
        (radar.transmitters.get(channel.transmitter)?, radar.receivers.get(channel.receiver)?);
    if transmitter.antenna.platform != receiver.antenna.platform {
        let name = |platform: usize| platforms.names.get(platform).cloned().flatten().unwrap_or_default();
        return Some(PpiError::Bistatic {
            channel: channel.name.clone(),
            transmits: name(transmitter.antenna.platform),
            receives: name(receiver.antenna.platform),
        });
    }
    let scans = matches!(receiver.antenna.pointing, Pointing::Scan(_));
    (!scans).then(|| PpiError::StandsStill { channel: channel.name.clone(), receiver: receiver.name.clone() })
}

/// Faults cells that are shorter than half a sample, or longer than the window.
fn check_cell(section: &Section<'_>, radar: &Radar, cell_m: Option<f64>) {
    let sample_m = 0.5 * SPEED_OF_LIGHT_MPS / radar.sample_rate_hz;
    let [least, most] = [0.5 * sample_m, sample_m * (radar.window.samples.max(2) - 1) as f64];
    if let Some(cell_m) = cell_m.filter(|cell_m| !(least..=most).contains(cell_m)) {
        let allowed = format!("from {least:.3} m (half a sample) to {most:.3} m (the receive window)");
        section.fault(&keys::sink::CELL_M, Problem::Range { found: figure(cell_m), allowed });
    }
}
