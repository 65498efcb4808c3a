//! The per-pulse columns of a recording, and how a pulse fills a row. HDF5 and plain recordings hold the same
//! columns under the same paths ([`super::descriptions`]). [`INDEX`] is always last, because it is written
//! after all others.

use bytemuck::cast_slice;

pub use super::descriptions::INDEX;
use super::descriptions::{Content, DESCRIPTIONS, Description, Values};
use super::fault::RecordingError;
use super::header::Header;
pub use super::rows::{Element, Rows};
use crate::pulse::{Pulse, Samples};

/// One column.
#[derive(Clone, Debug)]
pub struct Column {
    /// Where it is in the recording.
    pub path: String,
    /// Type of an element.
    pub element: Element,
    /// Shape of a row; empty for a single value.
    pub shape: Vec<usize>,
    /// What it is.
    pub description: &'static Description,
    /// Number of its platform or antenna.
    at: usize,
    values: fn(&Pulse, usize) -> Values<'_>,
}

/// The columns of a recording; [`INDEX`] last.
pub fn columns(header: &Header) -> Vec<Column> {
    let mut list = Vec::new();
    // All of one platform or antenna, then all of the next.
    for rows in DESCRIPTIONS.chunk_by(|a, b| group(a) == group(b)) {
        let names: Vec<&str> = match group(&rows[0]) {
            Some("nav/<platform") => header.platforms.iter().map(String::as_str).collect(),
            Some("nav/<antenna") => header.antennas().collect(),
            Some(_) => header.clocks.iter().map(String::as_str).collect(),
            None => vec![""],
        };
        for (at, name) in names.into_iter().enumerate() {
            list.extend(rows.iter().filter_map(|description| column(description, header, at, name)));
        }
    }
    list.sort_by_key(|column| column.path == INDEX);
    list
}

/// What stands before the name in the path of a dataset that is there for each name.
fn group(description: &Description) -> Option<&'static str> {
    description.path.split_once('>').map(|(group, _)| group)
}

/// The column of a platform or antenna, if the recording has it.
fn column(description: &'static Description, header: &Header, at: usize, name: &str) -> Option<Column> {
    let Content::Each(element, values) = description.content else { return None };
    let layout = &header.layout;
    let is_there = match description.path {
        "iq" => element == layout.format.into(),
        path => header.truth || !is_truth(path),
    };
    let size = |axis| match axis {
        "channel" => layout.channels,
        "sample" => layout.samples,
        "pair" => layout.pairs,
        "target" => layout.targets,
        "ship" => layout.ships,
        "receiver" => layout.windows,
        "w-x-y-z" => 4,
        "azimuth-elevation" if header.scans(at) => 2,
        "azimuth-elevation" => 0,
        _ => 3,
    };
    let shape: Vec<usize> = description.axes.split(", ").skip(1).map(size).collect();
    let path = match description.path.split_once('<') {
        Some((before, rest)) => rest.split_once('>').map(|(_, after)| format!("{before}{name}{after}"))?,
        None => description.path.to_owned(),
    };
    (is_there && !shape.contains(&0)).then_some(Column { path, element, shape, description, at, values })
}

/// Whether only one who knows the true motion can fill it.
fn is_truth(path: &str) -> bool {
    path.contains("/true/") || path.ends_with(">/phase_centre_m") || path.ends_with(">/boresight_quat")
}

impl Column {
    /// Elements of a row.
    pub fn width(&self) -> usize {
        self.shape.iter().product()
    }

    /// Bytes of a row.
    pub fn row_bytes(&self) -> usize {
        self.width() * self.element.bytes()
    }

    /// Whether recordings of an older program may lack it: whoever needs it reports that.
    pub fn may_be_missing(&self) -> bool {
        self.path.starts_with("nav/")
    }

    /// Appends the row of a pulse that passed [`check`](Self::check).
    pub fn push(&self, pulse: &Pulse, rows: &mut Rows) {
        match ((self.values)(pulse, self.at), rows) {
            (Values::U8(value), Rows::U8(rows)) => rows.push(value),
            (Values::U32(value), Rows::U32(rows)) => rows.push(value),
            (Values::U64(value), Rows::U64(rows)) => rows.push(value),
            (Values::I64(value), Rows::I64(rows)) => rows.push(value),
            (Values::F64(value), Rows::F64(rows)) => rows.push(value),
            (Values::Reals(values), Rows::F64(rows)) => rows.extend_from_slice(values),
            (Values::Samples(Samples::Cf32(samples)), Rows::Cf32(rows)) => rows.extend_from_slice(samples),
            (Values::Samples(Samples::Ci16(samples)), Rows::Ci16(rows)) => {
                rows.extend_from_slice(cast_slice(samples));
            }
            _ => {}
        }
    }

    /// Whether a pulse has the values that this column needs.
    ///
    /// # Errors
    /// It has more or fewer.
    pub fn check(&self, pulse: &Pulse) -> Result<(), RecordingError> {
        let found = match ((self.values)(pulse, self.at), self.element) {
            (Values::Samples(Samples::Cf32(samples)), Element::Cf32) => samples.len(),
            (Values::Samples(Samples::Ci16(samples)), Element::Ci16) => samples.len(),
            (Values::Samples(_), _) => 0,
            (Values::Reals(values), _) => values.len(),
            _ => 1,
        };
        let expected = self.width();
        if found == expected {
            Ok(())
        } else {
            Err(RecordingError::Pulse { index: pulse.index, column: self.path.clone(), found, expected })
        }
    }
}
