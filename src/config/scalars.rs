//! Single values of a scenario: numbers, polarisations, instants, addresses.

use super::document::{Node, Value};
use crate::nav::live::Origin;
use crate::scene::radar::Polarisation;
use crate::time::TimeTag;

/// A number, whole or not.
pub(super) fn plain_number(node: &Node) -> Option<f64> {
    match node.value {
        Value::Number(value) => Some(value),
        Value::Integer(value) => Some(value as f64),
        _ => None,
    }
}

/// `HV`: receive H, transmit V.
pub(super) fn polarisation_pair(text: &str) -> Option<[Polarisation; 2]> {
    let mut letters = text.chars();
    match (letters.next(), letters.next(), letters.next()) {
        (Some(rx), Some(tx), None) => Some([Polarisation::from_letter(rx)?, Polarisation::from_letter(tx)?]),
        _ => None,
    }
}

/// One polarisation.
pub(super) fn polarisation(text: &str) -> Option<Polarisation> {
    let mut letters = text.chars();
    match (letters.next(), letters.next()) {
        (Some(letter), None) => Polarisation::from_letter(letter),
        _ => None,
    }
}

/// Where live navigation comes from; a file is not looked for.
pub(super) fn origin(text: &str, baud: u32) -> Option<Origin> {
    if text.contains('\0') {
        return None;
    }
    if let Some(path) = text.strip_prefix("file:") {
        return (!path.is_empty()).then(|| Origin::File(path.into()));
    }
    let at = |scheme: &str| text.strip_prefix(scheme).and_then(|address| address.parse().ok());
    let is_path = !text.is_empty() && !text.contains("://");
    at("tcp://")
        .map(Origin::TcpConnect)
        .or_else(|| at("tcp-listen://").map(Origin::TcpListen))
        .or_else(|| at("udp://").map(Origin::Udp))
        .or_else(|| is_path.then(|| Origin::Serial { path: text.into(), baud }))
}

/// A UTC time `YYYY-MM-DD[T ]hh:mm:ss[.f][Z]`; other offsets are refused, not converted.
pub(super) fn utc(text: &str) -> Option<TimeTag> {
    let pattern = b"dddd-dd-ddTdd:dd:dd";
    let bytes = text.as_bytes();
    let (whole, rest) = (bytes.get(..pattern.len())?, text.get(pattern.len()..)?);
    let matches = whole.iter().zip(pattern).all(|(byte, wanted)| match wanted {
        b'd' => byte.is_ascii_digit(),
        b'T' => matches!(byte, b'T' | b't' | b' '),
        other => byte == other,
    });
    let rest = rest.strip_suffix(['Z', 'z']).unwrap_or(rest);
    let fraction = match rest.strip_prefix('.') {
        Some(digits) => !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()),
        None => rest.is_empty(),
    };
    let year: u32 = text.get(..4)?.parse().ok()?;
    if !(matches && fraction && (1970..2200).contains(&year)) {
        return None;
    }
    let iso: String = text.chars().map(|c| if matches!(c, ' ' | 't') { 'T' } else { c }).collect();
    TimeTag::from_iso8601(&iso).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times() {
        assert!(utc("2018-05-30T20:15:00.5Z").is_some());
        assert!(utc("2018-05-30 20:15:00").is_some());
        for bad in [
            "2018-05-30T20:15:00+02:00",
            "2018-13-30T20:15:00Z",
            "2018-02-30T20:15:00Z",
            "2018-05-30T24:15:00Z",
            "1969-05-30T20:15:00Z",
            "2018-05-30T20:15:00.",
            "2018-05-30",
            "",
            "2018-05-30T20:15:0\u{e9}Z",
        ] {
            assert!(utc(bad).is_none(), "{bad}");
        }
    }
}
