//! Tables of reports.

use super::{Collected, Stated};
use crate::nav::csv::{read_iso, read_number};
use crate::nav::faults::{FaultKind, Faults};
use crate::time::TimeTag;

/// Columns that must be there, each with its other names.
const NEEDED: [&[&str]; 6] = [
    &["Time", "BaseDateTime", "base_date_time", "Timestamp", "# Timestamp"],
    &["MMSI"],
    &["Latitude_degrees", "LAT", "Latitude"],
    &["Longitude_degrees", "LON", "Longitude"],
    &["COG_degrees", "COG"],
    &["SOG_knots", "SOG"],
];
const OPTIONAL: [&[&str]; 3] =
    [&["Length_metres", "Length"], &["Beam_metres", "Width"], &["Draught_metres", "Draft", "Draught"]];
/// Any number: what a column allows is asked of its meaning.
const ANY: (f64, f64) = (f64::MIN, f64::MAX);

/// Reads a table.
pub(super) fn read(bytes: &[u8], collected: &mut Collected, faults: &mut Faults) {
    let mut layout: Option<Layout> = None;
    let mut fields = Vec::new();
    for (index, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
        let number = index as u64 + 1;
        let line = line.trim_ascii();
        let Some(layout) = &layout else {
            // The first column of the Danish table begins like a comment.
            split(line, &mut fields);
            let comment = line.starts_with(b"#") && place(&fields, NEEDED[0]).is_none();
            if !line.is_empty() && !comment {
                layout = Layout::from_header(&fields, number, faults);
                if layout.is_none() {
                    return;
                }
            }
            continue;
        };
        if line.is_empty() || line.starts_with(b"#") {
            continue;
        }
        if !collected.has_room(number, faults) {
            return;
        }
        split(line, &mut fields);
        layout.row(&fields, number, collected, faults);
    }
    if layout.is_none() {
        faults.push(1, FaultKind::Empty);
    }
}

/// The fields of a line; a comma between quotes belongs to its field.
fn split<'a>(line: &'a [u8], fields: &mut Vec<&'a [u8]>) {
    fields.clear();
    let mut quoted = false;
    let parts = line.split(|byte| {
        quoted ^= *byte == b'"';
        *byte == b',' && !quoted
    });
    fields.extend(parts.map(|field| {
        let field = field.trim_ascii();
        let inner = field.strip_prefix(b"\"").and_then(|field| field.strip_suffix(b"\""));
        inner.map_or(field, <[u8]>::trim_ascii)
    }));
}

fn place(header: &[&[u8]], names: &[&str]) -> Option<usize> {
    let named = |field: &&[u8]| names.iter().any(|name| field.eq_ignore_ascii_case(name.as_bytes()));
    header.iter().position(named)
}

/// Which field of a row holds what.
struct Layout {
    fields: usize,
    needed: [usize; NEEDED.len()],
    optional: [Option<usize>; OPTIONAL.len()],
}

impl Layout {
    fn from_header(header: &[&[u8]], line: u64, faults: &mut Faults) -> Option<Self> {
        for names in NEEDED.into_iter().chain(OPTIONAL) {
            let named = |field: &&[u8]| names.iter().any(|name| field.eq_ignore_ascii_case(name.as_bytes()));
            if header.iter().copied().filter(|field| named(field)).count() > 1 {
                faults.push(line, FaultKind::RepeatedColumn { name: names[0] });
            }
        }
        let needed = NEEDED.map(|names| place(header, names));
        let lacking = NEEDED.iter().zip(needed).filter(|(_, place)| place.is_none());
        let lacking: Vec<&str> = lacking.map(|(names, _)| names[0]).collect();
        if !lacking.is_empty() {
            faults.push(line, FaultKind::NoAisColumns { missing: lacking.join(", ") });
        }
        if !faults.is_empty() {
            return None;
        }
        let needed = needed.map(|place| place.unwrap_or(0));
        Some(Self { fields: header.len(), needed, optional: OPTIONAL.map(|names| place(header, names)) })
    }

    fn row(&self, fields: &[&[u8]], line: u64, collected: &mut Collected, faults: &mut Faults) {
        if fields.len() != self.fields {
            faults.push(line, FaultKind::FieldCount { found: fields.len(), expected: self.fields });
            return;
        }
        let before = faults.count();
        let time = read_time(fields[self.needed[0]]).map_err(|kind| faults.push(line, kind)).ok();
        let mut number = |place: usize, column: &'static str| {
            let field = fields[place];
            if field.is_empty() {
                return None;
            }
            read_number(field, column, ANY).map_err(|kind| faults.push(line, kind)).ok()
        };
        let mut value = |index: usize| number(self.needed[index], NEEDED[index][0]);
        let stated = Stated {
            mmsi: value(1),
            lat_deg: value(2),
            lon_deg: value(3),
            course_deg: value(4),
            knots: value(5),
        };
        let mut size_m = [None; OPTIONAL.len()];
        for (size, (place, names)) in size_m.iter_mut().zip(self.optional.into_iter().zip(OPTIONAL)) {
            *size = place.and_then(|place| number(place, names[0]));
        }
        if let Some(time) = time.filter(|_| faults.count() == before) {
            let mmsi = stated.mmsi.filter(|mmsi| *mmsi >= 0.0 && *mmsi <= super::MOST_MMSI);
            mmsi.into_iter().for_each(|mmsi| collected.size(mmsi as u32, size_m));
            collected.push(time, &stated);
        }
    }
}

/// A time in ISO 8601, or with the day first: `01/05/2024 12:00:00`.
fn read_time(field: &[u8]) -> Result<TimeTag, FaultKind> {
    match field {
        &[d0, d1, b'/', m0, m1, b'/', y0, y1, y2, y3, ref clock @ ..] => {
            let iso = [&[y0, y1, y2, y3, b'-', m0, m1, b'-', d0, d1], clock].concat();
            read_iso(&iso, NEEDED[0][0])
        }
        _ => read_iso(field, NEEDED[0][0]),
    }
}
