//! Offset tables as comma-separated values.
//!
//! ```text
//! # lines that begin with a hash are comments
//! x_m/z_m, -2,  -1,  0
//! 0,       0,   0,   0.1
//! 5,       0.4, 0.9, 1
//! 10,      0,   0,   0
//! ```
//!
//! The first row has the waterlines, m up from the design waterline: from the keel to 0. Every other row is a
//! station, from bow to stern: where it is, m from anywhere, then its half-breadths at the waterlines, m.
//! Where there is no hull the half-breadth is 0; an empty field is a fault. Both counts are odd, for the
//! reason given in [`hull`](super).
//!
//! Limits: 16 MiB; counts and sizes of [`hull`](super).
//!
//! ```
//! use nereus::scene::hull::table;
//! let hull = table::parse("punt", "x_m/z_m,-2,-1,0\n0,0,0,0.1\n5,0.4,0.9,1\n10,0,0,0\n")?;
//! assert_eq!((hull.length_m(), hull.beam_m(), hull.stations_m()[0]), (10.0, 2.0, -5.0));
//! let faults = table::parse("punt", "x_m/z_m,-2,-1,0\n0,0,,0\n5,0,-1,1\n4,0,0,0\n").unwrap_err().to_string();
//! assert!(faults.contains("line 2: nothing in column 3") && faults.contains("line 4: station 4 m follows 5 m"));
//! # Ok::<(), nereus::scene::hull::HullError>(())
//! ```

use std::path::Path;

use super::fault::{HullError, HullFault, Place, What};
use super::{Facts, Hull, check};

const HEADER: &str = "x_m/z_m";
/// Characters of a foreign text that are repeated.
const QUOTED: usize = 40;

/// Reads a table from text.
///
/// # Errors
/// All faults of the table, each with its line.
pub fn parse(name: &str, text: &str) -> Result<Hull, HullError> {
    let mut faults = Vec::new();
    let table = read(Path::new(name), text, &mut faults);
    match table {
        Some(table) if faults.is_empty() => {
            Ok(table.hull(Facts { name: name.to_owned(), ..Facts::default() }))
        }
        _ => Err(HullError::faulty(name, faults)),
    }
}

/// A table that was found to be right.
#[derive(Debug)]
pub(super) struct Table {
    stations_m: Vec<f64>,
    waterlines_m: Vec<f64>,
    half_breadths_m: Vec<f64>,
}

impl Table {
    pub(super) fn hull(&self, facts: Facts) -> Hull {
        Hull::assembled(&self.stations_m, &self.waterlines_m, &self.half_breadths_m, facts)
    }
}

/// Reads a table; faults are noted, in the order of lines.
pub(super) fn read(path: &Path, text: &str, faults: &mut Vec<HullFault>) -> Option<Table> {
    let mut found = Vec::new();
    let mut push = |line, what| {
        found.push((line, HullFault { place: Place::Line { path: path.to_owned(), line }, what }));
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().enumerate().map(|(i, content)| (i + 1, content.trim()));
    let mut rows = lines.by_ref().filter(|(_, content)| !content.is_empty() && !content.starts_with('#'));
    let last_line = text.lines().count().max(1);

    let (header_line, header) = rows.next().unwrap_or((last_line, ""));
    let mut names = header.split(',').map(str::trim);
    let mut waterlines_m = Vec::new();
    if names.next() == Some(HEADER) {
        for (i, field) in names.enumerate() {
            waterlines_m.push(number(field, i + 2, header_line, &mut push));
        }
    }
    if waterlines_m.is_empty() {
        push(header_line, What::Header);
    }
    let (mut stations_m, mut half_breadths_m, mut station_lines) = (Vec::new(), Vec::new(), Vec::new());
    for (line, content) in rows {
        if waterlines_m.is_empty() || stations_m.len() > super::limits::MOST_STATIONS {
            break;
        }
        station_lines.push(line);
        let fields: Vec<&str> = content.split(',').map(str::trim).collect();
        stations_m.push(number(fields[0], 1, line, &mut push));
        let needed = waterlines_m.len() + 1;
        if fields.len() == needed {
            let row = fields.iter().enumerate().skip(1);
            half_breadths_m.extend(row.map(|(i, field)| number(field, i + 1, line, &mut push)));
        } else {
            push(line, What::Fields { found: fields.len(), needed });
            half_breadths_m.resize(stations_m.len() * waterlines_m.len(), f64::NAN);
        }
    }
    if !waterlines_m.is_empty() {
        for fault in check::offsets(&stations_m, &waterlines_m, &half_breadths_m) {
            let line = match fault.place {
                Place::Station(index) => station_lines[index],
                Place::Waterline(_) => header_line,
                _ => last_line,
            };
            push(line, fault.what);
        }
    }
    let right = found.is_empty();
    found.sort_by_key(|(line, _)| *line);
    faults.extend(found.into_iter().map(|(_, fault)| fault));
    right.then_some(Table { stations_m, waterlines_m, half_breadths_m })
}

/// The number in a field; not-a-number, and a fault, where there is none.
fn number(field: &str, column: usize, line: usize, push: &mut impl FnMut(usize, What)) -> f64 {
    match field.parse::<f64>() {
        Ok(value) if value.is_finite() => return value,
        _ if field.is_empty() => push(line, What::Hole { column }),
        _ => push(line, What::Number { column, text: quote(field) }),
    }
    f64::NAN
}

/// A piece of foreign text, short and printable.
pub(super) fn quote(text: &str) -> String {
    let mut quoted: String = text
        .chars()
        .take(QUOTED)
        .map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c })
        .collect();
    if text.chars().count() > QUOTED {
        quoted.push_str("...");
    }
    quoted
}
