//! Hull descriptions: a TOML file beside an offset table.
//!
//! | key | unit | meaning |
//! | --- | --- | --- |
//! | `name` | | required |
//! | `offsets` | | required: the offset table ([`table`]), a path from this file's folder |
//! | `source`, `licence` | | where the table comes from; for people |
//! | `draught_m` | m | draught of the particulars, where a dome or keel reaches below it |
//! | `[stated]` | | published particulars, each optional: `length_m` `beam_m` `draught_m` `volume_m3` `wetted_surface_m2` `block` `midship` `waterplane` `lcb_percent`, as in [`Particulars`] |
//! | `stated.tolerance_percent` | % | how far the table may be from them, 0.001 to 20, usually 1; beyond it the file is refused |
//! | `[[scatterer]]` | | `name`, `forward_m`, `starboard_m`, `up_m` from midship at the waterline, `rcs_m2` |
//!
//! Unknown keys are refused, and all faults of both files are reported at once.
//!
//! ```
//! let punt = std::env::temp_dir().join(format!("nereus-doc-{}", std::process::id()));
//! std::fs::create_dir_all(&punt)?;
//! std::fs::write(punt.join("punt.csv"), "x_m/z_m,-2,-1,0\n0,0,0,0\n5,0,0.75,1\n10,0,0,0\n")?;
//! let toml = "name = 'punt'\noffsets = 'punt.csv'\n[stated]\nblock = 0.5\nvolume = 3\n";
//! std::fs::write(punt.join("punt.toml"), toml)?;
//! let faults = nereus::scene::hull::Hull::load(&punt.join("punt.toml")).unwrap_err().to_string();
//! // 2/3 along and 2/3 down.
//! assert!(faults.contains("line 4: block is stated as 0.5, the table gives 0.444444"), "{faults}");
//! assert!(faults.contains("line 5: unknown key stated.volume"));
//! # std::fs::remove_dir_all(&punt)?;
//! # Ok::<(), std::io::Error>(())
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::fault::{HullError, HullFault, Place, What};
use super::particulars::QUANTITIES;
use super::table::{self, quote};
use super::{Facts, Hull, Particulars, Scatterer, Stated, check};
use crate::frames::Point;
use crate::inputs;
use crate::scene::hull::limits::MOST_BYTES;

const KEYS: [&str; 7] = ["name", "offsets", "source", "licence", "draught_m", "stated", "scatterer"];
const SCATTERER_KEYS: [&str; 5] = ["name", "forward_m", "starboard_m", "up_m", "rcs_m2"];
const TOLERANCE: &str = "tolerance_percent";
const POSITIVE: &str = "a number above 0";

/// Reads a description and its table, or a table alone.
pub(super) fn load(path: &Path) -> Result<Hull, HullError> {
    let mut faults = Vec::new();
    let (text, bad) =
        contents(path).map_err(|error| HullError::Read { path: path.to_owned(), kind: error.kind() })?;
    let fault = |what| HullFault { place: Place::Line { path: path.to_owned(), line: 1 }, what };
    faults.extend(bad.map(fault));
    let alone = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
    let name = path.display().to_string();
    if !faults.is_empty() {
        return Err(HullError::faulty(&name, faults));
    }
    let hull = if alone {
        let stem = path.file_stem().map_or(String::new(), |stem| stem.to_string_lossy().into_owned());
        table::read(path, &text, &mut faults)
            .map(|table| table.hull(Facts { name: stem, ..Facts::default() }))
    } else {
        Description::read(path, &text, &mut faults).hull(path, &mut faults)
    };
    // Those of the description first, each file in the order of its lines.
    faults.sort_by_key(|fault| match &fault.place {
        Place::Line { path: file, line } => (file != path, *line),
        _ => (true, 0),
    });
    match hull {
        Some(hull) if faults.is_empty() => Ok(hull),
        _ => Err(HullError::faulty(&name, faults)),
    }
}

/// The text of a file, or what is wrong with it as a text.
fn contents(path: &Path) -> std::io::Result<(String, Option<What>)> {
    let bytes = inputs::read(path, MOST_BYTES)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Ok((String::new(), Some(What::Long)));
    }
    Ok(String::from_utf8(bytes).map_or((String::new(), Some(What::Encoding)), |text| (text, None)))
}

/// Content of a description, as far as it could be read.
struct Description {
    facts: Facts,
    offsets: Option<(String, usize)>,
    /// Lines of the draught and of the stated particulars.
    draught_line: usize,
    stated_lines: [usize; 9],
}

/// Turns byte offsets into lines and notes faults there.
struct Notes<'a> {
    path: &'a Path,
    text: &'a str,
    /// Where lines begin.
    starts: Vec<usize>,
    faults: &'a mut Vec<HullFault>,
}

impl Notes<'_> {
    fn line(&self, offset: usize) -> usize {
        self.starts.partition_point(|start| *start <= offset).max(1)
    }

    fn push(&mut self, line: usize, what: What) {
        self.faults.push(HullFault { place: Place::Line { path: self.path.to_owned(), line }, what });
    }

    fn refuse(&mut self, key: &str, value: &Spanned<DeValue<'_>>, allowed: &'static str) {
        let (line, written) = (self.line(value.span().start), self.text.get(value.span()).unwrap_or(""));
        let value = quote(written);
        self.push(line, What::Value { key: key.to_owned(), value, allowed });
    }

    fn unknown(&mut self, prefix: &str, table: &DeTable<'_>, known: &[&str]) {
        for key in table.keys().filter(|key| !known.contains(&key.get_ref().as_ref())) {
            let line = self.line(key.span().start);
            let key = format!("{prefix}{}", quote(key.get_ref()));
            self.push(line, What::UnknownKey { key, allowed: known.join(", ") });
        }
    }

    fn text(&mut self, key: &str, value: &Spanned<DeValue<'_>>) -> Option<String> {
        match value.get_ref() {
            DeValue::String(text) if !text.trim().is_empty() => Some(text.clone().into_owned()),
            _ => {
                self.refuse(key, value, "a text");
                None
            }
        }
    }

    fn number(
        &mut self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        [least, most]: [f64; 2],
        allowed: &'static str,
    ) -> Option<f64> {
        let number = match value.get_ref() {
            DeValue::Integer(digits) => {
                i64::from_str_radix(digits.as_str(), digits.radix()).ok().map(|number| number as f64)
            }
            DeValue::Float(digits) => digits.as_str().parse().ok(),
            _ => None,
        };
        let number = number.filter(|number| (least..=most).contains(number));
        if number.is_none() {
            self.refuse(key, value, allowed);
        }
        number
    }
}

type Entries<'t, 'a> = BTreeMap<&'t str, &'t Spanned<DeValue<'a>>>;

fn entries<'t, 'a>(table: &'t DeTable<'a>) -> Entries<'t, 'a> {
    table.iter().map(|(key, value)| (key.get_ref().as_ref(), value)).collect()
}

impl Description {
    fn read(path: &Path, text: &str, faults: &mut Vec<HullFault>) -> Self {
        let (table, errors) = DeTable::parse_recoverable(text);
        let feeds = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at + 1);
        let starts = std::iter::once(0).chain(feeds).collect();
        let mut notes = Notes { path, text, starts, faults };
        for error in &errors {
            let line = notes.line(error.span().unwrap_or_default().start);
            notes.push(line, What::Syntax { message: error.message().trim().replace('\n', " ") });
        }
        let table = table.get_ref();
        notes.unknown("", table, &KEYS);
        let found = entries(table);
        for key in ["source", "licence"] {
            found.get(key).and_then(|value| notes.text(key, value));
        }
        let mut required = |key: &str, allowed| match found.get(key) {
            Some(value) => notes.text(key, value).map(|text| (text, notes.line(value.span().start))),
            None => {
                notes.push(1, What::MissingKey { key: key.to_owned(), allowed });
                None
            }
        };
        let name = required("name", "a text");
        let offsets = required("offsets", "the path of an offset table, from the folder of this file");
        let positive = [f64::MIN_POSITIVE, f64::MAX];
        let draught = found.get("draught_m");
        let draught_m = draught.and_then(|value| notes.number("draught_m", value, positive, POSITIVE));
        let draught_line = draught.map_or(1, |value| notes.line(value.span().start));
        let (stated, stated_lines) =
            found.get("stated").map_or_else(Default::default, |value| stated(value, &mut notes));
        let scatterers = found.get("scatterer").map_or_else(Vec::new, |value| scatterers(value, &mut notes));
        let name = name.map_or(String::new(), |(name, _)| name);
        Self { facts: Facts { name, draught_m, stated, scatterers }, offsets, draught_line, stated_lines }
    }

    /// The hull, if its table is right; the faults report what is wrong.
    fn hull(self, path: &Path, faults: &mut Vec<HullFault>) -> Option<Hull> {
        let at = |line, what| HullFault { place: Place::Line { path: path.to_owned(), line }, what };
        let (offsets, line) = self.offsets?;
        let beside = path.parent().unwrap_or(Path::new("")).join(offsets);
        let text = match contents(&beside) {
            Ok((text, None)) => text,
            Ok((_, Some(what))) => {
                faults.push(HullFault { place: Place::Line { path: beside, line: 1 }, what });
                return None;
            }
            Err(error) => {
                faults.push(at(line, What::Unreadable { path: beside, kind: error.kind() }));
                return None;
            }
        };
        let hull = table::read(&beside, &text, faults)?.hull(self.facts);
        if let Some(what) = check::draught(&hull) {
            faults.push(at(self.draught_line, what));
            return None;
        }
        for (index, what) in hull.stated.disagreements(&Particulars::of(&hull)) {
            faults.push(at(self.stated_lines[index], what));
        }
        Some(hull)
    }
}

fn stated(value: &Spanned<DeValue<'_>>, notes: &mut Notes<'_>) -> (Stated, [usize; 9]) {
    let (mut stated, mut lines) = (Stated::default(), [1; 9]);
    let DeValue::Table(table) = value.get_ref() else {
        notes.refuse("stated", value, "a table [stated]");
        return (stated, lines);
    };
    let known: Vec<&str> = QUANTITIES.into_iter().chain([TOLERANCE]).collect();
    notes.unknown("stated.", table, &known);
    let found = entries(table);
    for (index, quantity) in QUANTITIES.into_iter().enumerate() {
        let Some(value) = found.get(quantity) else { continue };
        lines[index] = notes.line(value.span().start);
        let (range, allowed) = if quantity == "lcb_percent" {
            ([-50.0, 50.0], "-50 to 50, percent of the length forward of midship")
        } else {
            ([f64::MIN_POSITIVE, f64::MAX], POSITIVE)
        };
        stated.values[index] = notes.number(&format!("stated.{quantity}"), value, range, allowed);
    }
    if let Some(value) = found.get(TOLERANCE)
        && let Some(percent) =
            notes.number(&format!("stated.{TOLERANCE}"), value, [0.001, 20.0], "a number from 0.001 to 20")
    {
        stated.tolerance_percent = percent;
    }
    (stated, lines)
}

fn scatterers(value: &Spanned<DeValue<'_>>, notes: &mut Notes<'_>) -> Vec<Scatterer> {
    let mut read: Vec<Scatterer> = Vec::new();
    let mut names = BTreeSet::new();
    let DeValue::Array(items) = value.get_ref() else {
        notes.refuse("scatterer", value, "tables [[scatterer]]");
        return read;
    };
    for item in items.iter() {
        let DeValue::Table(table) = item.get_ref() else {
            notes.refuse("scatterer", item, "tables [[scatterer]]");
            continue;
        };
        notes.unknown("scatterer.", table, &SCATTERER_KEYS);
        let line = notes.line(item.span().start);
        let found = entries(table);
        let mut given = |key: &'static str, allowed| {
            let value = found.get(key).copied();
            if value.is_none() {
                notes.push(line, What::MissingKey { key: format!("scatterer.{key}"), allowed });
            }
            value
        };
        let far = "a number from -2000 to 2000 m";
        let name = given("name", "a text");
        let place = ["forward_m", "starboard_m", "up_m"].map(|key| (key, given(key, far)));
        let sections = "a number from 0 to 1e9 m^2";
        let rcs = given("rcs_m2", sections);
        let name = name.and_then(|value| notes.text("scatterer.name", value));
        let place = place
            .map(|(key, value)| notes.number(&format!("scatterer.{key}"), value?, [-2000.0, 2000.0], far));
        let rcs_m2 = rcs.and_then(|value| notes.number("scatterer.rcs_m2", value, [0.0, 1e9], sections));
        let (Some(name), [Some(forward), Some(starboard), Some(up)], Some(rcs_m2)) = (name, place, rcs_m2)
        else {
            continue;
        };
        if !names.insert(name.clone()) {
            notes.push(line, What::Twice { name: quote(&name) });
            continue;
        }
        read.push(Scatterer { name, position: Point::new(forward, starboard, -up), rcs_m2 });
    }
    read
}
