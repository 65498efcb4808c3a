//! Tracks of GPX and KML files.
//!
//! **GPX**: `<trkpt lat lon>` with `<time>` and, if it is known, `<ele>`. Waypoints and routes are no track.
//! **KML**: `<gx:Track>` with as many `<when>` as `<gx:coord>` (longitude, latitude, height), and placemarks
//! with a `<TimeStamp><when>` and a `<Point>`. Times are ISO 8601 with or without an offset.
//!
//! What heights are measured from is said by the source, not by the file. A place without a time, and one
//! that cannot be read, is left and counted; a file in which no place has a time is refused. Heights that are
//! missing are interpolated, and steps of the clock left, as in NMEA logs. Attitudes are not read.
//!
//! Source: GPX 1.1 schema; OGC KML 2.2, and the extension `gx` of Google.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::csv::read_iso;
use super::epoch::{DAY_NS, Epoch};
use super::faults::{FaultKind, Faults, NavError};
use super::{FileSource, recording};
use crate::nav::load_report::LoadReport;
use crate::nav::recording::{MAX_FIXES, Recording};
use crate::time::TimeTag;

/// Nanoseconds of a second.
const SECOND_NS: i64 = 1_000_000_000;

/// A place of a file, as far as it is read.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    lat_deg: Option<f64>,
    lon_deg: Option<f64>,
    height_m: Option<f64>,
    time: Option<TimeTag>,
}

/// What is read of a file.
struct Track<'a> {
    bytes: &'a [u8],
    epochs: Vec<Epoch>,
    malformed: u64,
    timeless: u64,
    hints: Vec<String>,
    faults: Faults,
}

impl<'a> Track<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let (epochs, hints, faults) = Default::default();
        Self { bytes, epochs, malformed: 0, timeless: 0, hints, faults }
    }

    /// Calls with every element that begins, and with every one that ends and the text within it.
    fn read(&mut self, mut see: impl FnMut(&mut Self, Seen<'_>)) {
        if self.bytes.starts_with(b"PK") {
            let error = "it is a zip archive (KMZ); unzip it and give its doc.kml".to_owned();
            return self.faults.push(1, FaultKind::Xml { error });
        }
        let mut reader = Reader::from_reader(self.bytes);
        reader.config_mut().expand_empty_elements = true;
        let mut text = String::new();
        while self.epochs.len() <= MAX_FIXES {
            match reader.read_event() {
                Ok(Event::Start(start)) => {
                    text.clear();
                    see(self, Seen::Begin(&start));
                }
                Ok(Event::Text(part)) => text.push_str(&part.xml10_content()),
                Ok(Event::End(end)) => {
                    let name = end.local_name();
                    see(self, Seen::End(name.as_ref(), text.trim()));
                    text.clear();
                }
                Ok(Event::Eof) => return,
                Ok(_) => {}
                Err(error) => {
                    let at = usize::try_from(reader.error_position()).unwrap_or(usize::MAX);
                    let before = &self.bytes[..at.min(self.bytes.len())];
                    let line = 1 + before.iter().filter(|byte| **byte == b'\n').count() as u64;
                    return self.faults.push(line, FaultKind::Xml { error: error.to_string() });
                }
            }
        }
    }

    /// Keeps a place.
    fn keep(&mut self, place: Place) {
        let (Some(lat_deg), Some(lon_deg)) = (place.lat_deg, place.lon_deg) else {
            self.malformed += 1;
            return;
        };
        let Some(time) = place.time else {
            self.timeless += 1;
            return;
        };
        let mut epoch = Epoch::default();
        let ns = (time.fraction_s() * 1e9).round() as i64;
        epoch.day = Some(time.seconds().div_euclid(DAY_NS / SECOND_NS));
        epoch.time_of_day_ns = time.seconds().rem_euclid(DAY_NS / SECOND_NS) * SECOND_NS + ns;
        epoch.position_deg = Some([lat_deg, lon_deg]);
        epoch.altitude_m = place.height_m;
        epoch.line = self.epochs.len() as u64 + 1;
        self.epochs.push(epoch);
    }

    fn finish(mut self, source: &FileSource, allowed: &'static str) -> Result<Recording, NavError> {
        if self.epochs.is_empty() && self.timeless > 0 {
            self.faults.push(1, FaultKind::Timeless { places: self.timeless, allowed });
        }
        let report = LoadReport {
            path: source.path.display().to_string(),
            lines: self.bytes.iter().filter(|byte| **byte == b'\n').count() as u64 + 1,
            malformed: self.malformed,
            void_positions: self.timeless,
            hints: self.hints,
            ..LoadReport::default()
        };
        recording::of_epochs(self.epochs, report, self.faults, source.datum, source)
    }
}

/// What the reader of a file meets.
enum Seen<'a> {
    /// An element begins.
    Begin(&'a BytesStart<'a>),
    /// An element ends: its name without prefix, and its text.
    End(&'a str, &'a str),
}

fn number(text: &str, [min, max]: [f64; 2]) -> Option<f64> {
    text.trim().parse().ok().filter(|value| (min..=max).contains(value))
}

fn height(text: &str) -> Option<f64> {
    number(text, [-1e8, 1e8])
}

fn time(text: &str) -> Option<TimeTag> {
    read_iso(text.as_bytes(), "time").ok()
}

/// An attribute of an element.
fn attribute(start: &BytesStart<'_>, name: &str, range: [f64; 2]) -> Option<f64> {
    let value = start.try_get_attribute(name).ok()??;
    number(value.value.as_ref(), range)
}

/// Longitude, latitude and height, separated by commas or blanks.
fn coordinates(text: &str) -> Place {
    let mut parts = text.split([',', ' ', '\t', '\n', '\r']).filter(|part| !part.is_empty());
    let mut next = |range| number(parts.next()?, range);
    Place {
        lon_deg: next([-180.0, 180.0]),
        lat_deg: next([-90.0, 90.0]),
        height_m: next([-1e8, 1e8]),
        time: None,
    }
}

/// Reads the track of a GPX file.
///
/// # Errors
/// What is no XML, and a track without times.
pub fn gpx(bytes: &[u8], source: &FileSource) -> Result<Recording, NavError> {
    let mut track = Track::new(bytes);
    let mut open: Option<Place> = None;
    track.read(|track, seen| match seen {
        Seen::Begin(start) if start.local_name().as_ref() == "trkpt" => {
            let lat_deg = attribute(start, "lat", [-90.0, 90.0]);
            let lon_deg = attribute(start, "lon", [-180.0, 180.0]);
            open = Some(Place { lat_deg, lon_deg, ..Place::default() });
        }
        Seen::Begin(_) => {}
        Seen::End(name, text) => match (name, &mut open) {
            ("ele", Some(place)) => place.height_m = height(text),
            ("time", Some(place)) => place.time = time(text),
            ("trkpt", Some(place)) => {
                track.keep(*place);
                open = None;
            }
            _ => {}
        },
    });
    track.finish(source, "a <time> in every <trkpt>")
}

/// Reads the tracks of a KML file.
///
/// # Errors
/// What is no XML, places without times, and lists of different lengths.
pub fn kml(bytes: &[u8], source: &FileSource) -> Result<Recording, NavError> {
    let mut track = Track::new(bytes);
    let (mut whens, mut coords): (Vec<Option<TimeTag>>, Vec<Place>) = Default::default();
    let (mut stamp, mut point): (Option<TimeTag>, Option<Place>) = (None, None);
    let mut within: [bool; 2] = [false; 2];
    track.read(|track, seen| {
        let (name, text) = match seen {
            Seen::Begin(start) => {
                match start.local_name().as_ref() {
                    "Placemark" => (stamp, point) = (None, None),
                    "Track" => within[0] = true,
                    "Point" => within[1] = true,
                    _ => {}
                }
                return;
            }
            Seen::End(name, text) => (name, text),
        };
        match name {
            "when" if within[0] => whens.push(time(text)),
            "when" => stamp = time(text),
            "coord" if within[0] => coords.push(coordinates(text)),
            "coordinates" if within[1] => point = Some(coordinates(text)),
            "coordinates" => track.timeless += text.split_whitespace().count() as u64,
            "altitudeMode" if text == "relativeToGround" && track.hints.is_empty() => {
                track.hints.push(
                    "altitudeMode relativeToGround: heights are above the ground, not above the datum"
                        .to_owned(),
                );
            }
            "Point" => within[1] = false,
            "Track" => {
                if whens.len() != coords.len() {
                    let kind = FaultKind::Unpaired { whens: whens.len(), places: coords.len() };
                    track.faults.push(1, kind);
                }
                for (time, place) in whens.drain(..).zip(coords.drain(..)) {
                    track.keep(Place { time, ..place });
                }
                within[0] = false;
            }
            "Placemark" => {
                if let Some(place) = point.take() {
                    track.keep(Place { time: stamp.take(), ..place });
                }
            }
            _ => {}
        }
    });
    track.finish(source, "<gx:Track> with <when>, or placemarks with <TimeStamp> and <Point>")
}
