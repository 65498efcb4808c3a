//! Every key of a scenario, once: name, unit, range, default, meaning.
//!
//! The reader checks values against this list, faults quote it, and `docs/scenario.md` is written from
//! it ([`super::manual`]), so none of the three can say something else.

/// One table of a scenario.
#[derive(Debug)]
pub struct Table {
    /// As written, with brackets: `[radar.window]`.
    pub heading: &'static str,
    /// What it describes.
    pub about: &'static str,
    /// Its keys.
    pub keys: &'static [&'static Key],
}

/// One key.
#[derive(Debug)]
pub struct Key {
    /// As written, the unit at its end.
    pub name: &'static str,
    /// What its value may be.
    pub kind: Kind,
    /// What its absence means.
    pub absent: Absent,
    /// What it means.
    pub about: &'static str,
}

/// What a value may be.
#[derive(Debug)]
pub enum Kind {
    /// A finite number, both ends of the range included unless `above`.
    Number {
        /// Unit; empty for a plain number.
        unit: &'static str,
        /// Smallest value.
        min: f64,
        /// Greatest value.
        max: f64,
        /// Whether the smallest value itself is excluded.
        above: bool,
        /// A word that may stand in its place.
        or: Option<&'static str>,
    },
    /// A list of numbers.
    Numbers {
        /// Unit; empty for plain numbers.
        unit: &'static str,
        /// Fewest entries.
        least: usize,
        /// Most entries.
        most: usize,
        /// Smallest value of an entry.
        min: f64,
        /// Greatest value of an entry.
        max: f64,
    },
    /// A list of points, each a pair of numbers.
    Points {
        /// Unit.
        unit: &'static str,
        /// Fewest points.
        least: usize,
        /// Most points.
        most: usize,
        /// Greatest coordinate either way.
        limit: f64,
    },
    /// A whole number.
    Count {
        /// Smallest value.
        min: u64,
        /// Greatest value.
        max: u64,
    },
    /// One of some whole numbers.
    OneOf(&'static [u64]),
    /// `true` or `false`.
    Flag,
    /// One of some words, which this lists.
    Choice(fn() -> Vec<&'static str>),
    /// A list of words.
    Words {
        /// Fewest entries.
        least: usize,
        /// Most entries.
        most: usize,
        /// What an entry may be.
        entry: &'static str,
    },
    /// Polarisation pair, receive then transmit.
    PolarisationPair,
    /// A line of text.
    Line,
    /// A name: letters, digits, `_`, `-`, `.`, at most 64 of them.
    Name,
    /// An instant, UTC.
    Time,
    /// A day.
    Date,
    /// An instant, UTC, or a word: each with where it is allowed.
    TimeOr(&'static [(&'static str, &'static str)]),
    /// A file that exists, relative to the scenario file.
    File,
    /// A file or folder to be made, relative to the working directory.
    Output,
    /// Where live navigation comes from: a port, an address, a file relative to the scenario file.
    Origin,
    /// Host and port of the network.
    Address,
    /// An interface of this machine, by its IPv4 address.
    Interface,
    /// A file that exists, or one word.
    FileOr(&'static str),
    /// A table of its own.
    Section(&'static Table),
    /// A table of its own, or whether there is one.
    Switched(&'static Table),
    /// An array of tables.
    Sections(&'static Table),
}

/// What the absence of a key means.
#[derive(Debug)]
pub enum Absent {
    /// A fault.
    Required,
    /// This number.
    Number(f64),
    /// This whole number.
    Count(u64),
    /// This flag.
    Flag(bool),
    /// This word.
    Word(&'static str),
    /// A list of zeros.
    Zeros,
    /// Something that is not a value, in words.
    Means(&'static str),
}

use super::choices::*;
use Absent::{Count, Flag, Means, Required, Word, Zeros};
use Kind::{
    Choice, Date, File, FileOr, Name, Output, PolarisationPair, Section, Sections, Switched, Time, TimeOr,
    Words,
};

const fn number(unit: &'static str, min: f64, max: f64) -> Kind {
    Kind::Number { unit, min, max, above: false, or: None }
}
const fn above(unit: &'static str, min: f64, max: f64) -> Kind {
    Kind::Number { unit, min, max, above: true, or: None }
}
const fn number_or(word: &'static str, unit: &'static str, min: f64, max: f64) -> Kind {
    Kind::Number { unit, min, max, above: false, or: Some(word) }
}
const fn vector(unit: &'static str, entries: usize, limit: f64) -> Kind {
    Kind::Numbers { unit, least: entries, most: entries, min: -limit, max: limit }
}
const fn sizes(unit: &'static str, limit: f64) -> Kind {
    Kind::Numbers { unit, least: 3, most: 3, min: 0.0, max: limit }
}
const fn count(min: u64, max: u64) -> Kind {
    Kind::Count { min, max }
}
const fn default(value: f64) -> Absent {
    Absent::Number(value)
}

/// Farthest coordinate, m: beyond geostationary orbit.
const FAR_M: f64 = 1e8;
/// Greatest speed, m/s: above escape velocity.
const FAST_MPS: f64 = 2e4;
/// Most pulse repetition intervals in a sequence.
const MOST_PRI: usize = 65_536;
/// Most pulses of a waveform that leave in turn.
pub(super) const MOST_TURNS: u64 = 1024;
/// Most targets of a scene.
pub(super) const MOST_TARGETS: u64 = 100_000;
/// Most targets that float: the waves under each take some MiB.
pub(super) const MOST_FLOATING: u64 = 64;
/// Most ships of a scene.
pub(super) const MOST_SHIPS: u64 = 1000;

/// Most facets of a patch of sea.
pub(super) const MOST_FACETS: u64 = 1 << 26;

/// Where a model of the permittivity holds.
#[derive(Clone, Copy)]
pub(super) struct ModelRange {
    /// As written.
    pub(super) model: &'static str,
    pub(super) carrier_hz: [f64; 2],
    pub(super) temperature_c: [f64; 2],
    pub(super) salinity_psu: [f64; 2],
}

pub(super) const MEISSNER_WENTZ: ModelRange = ModelRange {
    model: "meissner-wentz",
    carrier_hz: [1e9, 90e9],
    temperature_c: [-2.0, 34.0],
    salinity_psu: [0.0, 40.0],
};
pub(super) const KLEIN_SWIFT: ModelRange = ModelRange {
    model: "klein-swift",
    carrier_hz: [1e9, 10e9],
    temperature_c: [0.0, 30.0],
    salinity_psu: [4.0, 35.0],
};

pub(super) const ITU_R_P527: ModelRange = ModelRange {
    model: "itu-r-p527",
    carrier_hz: [1e6, 1e12],
    temperature_c: [-2.0, 34.0],
    salinity_psu: [0.0, 40.0],
};

macro_rules! tables {
    ($($module:ident $heading:literal $about_table:literal {
        $($key:ident $name:literal, $kind:expr, $absent:expr, $about:literal;)*
    })*) => {
        $(
            #[doc = concat!("Keys of `", $heading, "`.")]
            #[allow(unused_imports)]
            pub mod $module {
                use super::*;
                $(
                    #[doc = concat!("The key `", $name, "`.")]
                    pub static $key: Key = Key { name: $name, kind: $kind, absent: $absent, about: $about };
                )*
                /// The table.
                pub static TABLE: Table = Table { heading: $heading, about: $about_table, keys: &[$(&$key),*] };
            }
        )*
    };
}

mod antennas;
mod instrument;
mod platforms;
mod running;
mod targets;
mod top;
mod vessels;
mod water;

pub use antennas::*;
pub use instrument::*;
pub use platforms::*;
pub use running::*;
pub use targets::*;
pub use top::*;
pub use vessels::*;
pub use water::*;

/// Every table, in the order of the manual.
pub static TABLES: &[&Table] = &[
    &root::TABLE,
    &scene::TABLE,
    &patch_follow::TABLE,
    &radar::TABLE,
    &waveform::TABLE,
    &dechirp::TABLE,
    &window::TABLE,
    &follow::TABLE,
    &front_end::TABLE,
    &adc::TABLE,
    &channel::TABLE,
    &calibration::TABLE,
    &platform::TABLE,
    &errors::TABLE,
    &dropouts::TABLE,
    &error_m::TABLE,
    &error_mps::TABLE,
    &error_deg::TABLE,
    &turbulence::TABLE,
    &track::TABLE,
    &smoothing::TABLE,
    &transmitter::TABLE,
    &receiver::TABLE,
    &array::TABLE,
    &own_window::TABLE,
    &emitter::TABLE,
    &antenna::TABLE,
    &clock::TABLE,
    &pointing::TABLE,
    &sea::TABLE,
    &scattering::TABLE,
    &shadow::TABLE,
    &far::TABLE,
    &swell::TABLE,
    &slick::TABLE,
    &land::TABLE,
    &ship::TABLE,
    &ais::TABLE,
    &way::TABLE,
    &turbulent::TABLE,
    &target::TABLE,
    &target_grid::TABLE,
    &event::TABLE,
    &fidelity::TABLE,
    &stream::TABLE,
    &sink::TABLE,
];

impl Kind {
    /// What is allowed, in words.
    pub fn allowed(&self) -> String {
        let of = |unit: &str| if unit.is_empty() { String::new() } else { format!(" {unit}") };
        match self {
            Self::Number { unit, min, max, above, or } => {
                let (min, max) = (figure(*min), figure(*max));
                let range =
                    if *above { format!("above {min}, up to {max}") } else { format!("from {min} to {max}") };
                let word = or.map_or(String::new(), |word| format!(", or \"{word}\""));
                format!("a number {range}{}{word}", of(unit))
            }
            Self::Numbers { unit, least, most, min, max } => {
                let entries = if least == most { format!("{least}") } else { format!("{least} to {most}") };
                format!("a list of {entries} numbers from {} to {}{}", figure(*min), figure(*max), of(unit))
            }
            Self::Points { unit, least, most, limit } => {
                let limit = figure(*limit);
                format!("a list of {least} to {most} pairs [x, y] from -{limit} to {limit}{}", of(unit))
            }
            Self::Count { min, max } if *max == u64::MAX => format!("a whole number from {min} to 2^64 - 1"),
            Self::Count { min, max } => format!("a whole number from {min} to {max}"),
            Self::OneOf(numbers) => {
                let numbers: Vec<String> = numbers.iter().map(u64::to_string).collect();
                numbers.join(" or ")
            }
            Self::Interface => {
                "the IPv4 address of an interface of this machine, such as \"192.168.1.2\"".to_owned()
            }
            Self::Flag => "true or false".to_owned(),
            Self::Choice(words) => {
                let words: Vec<String> = words().iter().map(|w| format!("\"{w}\"")).collect();
                words.join(", ")
            }
            Self::Words { least, most, entry } => format!("a list of {least} to {most} texts, each {entry}"),
            Self::PolarisationPair => {
                "two letters, receive then transmit polarisation, each H, V, R or L".to_owned()
            }
            Self::Name => {
                "a name of 1 to 64 letters, digits, '_', '-', '.', not starting with '.'".to_owned()
            }
            Self::Line => "a text of one line".to_owned(),
            Self::Date => "a date such as \"2024-05-01\"".to_owned(),
            Self::Time => "a UTC time from 1970 to 2200 such as \"2018-05-30T20:15:00.5Z\"".to_owned(),
            Self::File => "a file that exists (relative to the scenario file)".to_owned(),
            Self::TimeOr(words) => {
                let words = words.iter().map(|(word, place)| format!(", or \"{word}\" {place}"));
                Self::Time.allowed() + &words.collect::<String>()
            }
            Self::Output => "a path (relative to the working directory)".to_owned(),
            Self::Origin => {
                "the path of a serial port, tcp://ADDRESS:PORT, tcp-listen://ADDRESS:PORT or udp://ADDRESS:PORT such as \
                 udp://127.0.0.1:5001, or file:PATH (relative to the scenario file)"
                    .to_owned()
            }
            Self::Address => {
                "host:port with a port from 1 to 65535, such as \"127.0.0.1:4991\" or \"[::1]:4991\""
                    .to_owned()
            }
            Self::FileOr(word) => {
                format!("\"{word}\", or a file that exists (relative to the scenario file)")
            }
            Self::Section(table) => format!("a table {}", table.heading),
            Self::Switched(table) => format!("a table {}, true or false", table.heading),
            Self::Sections(table) => format!("an array of tables {}", table.heading),
        }
    }

    /// The unit, where there is one.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Number { unit, .. } | Self::Numbers { unit, .. } | Self::Points { unit, .. } => unit,
            _ => "",
        }
    }
}

impl Absent {
    /// For the manual.
    pub fn text(&self) -> String {
        match self {
            Self::Required => "required".to_owned(),
            Self::Number(value) => figure(*value),
            Self::Count(value) => value.to_string(),
            Self::Flag(value) => value.to_string(),
            Self::Word(word) => format!("\"{word}\""),
            Self::Zeros => "zeros".to_owned(),
            Self::Means(words) => (*words).to_owned(),
        }
    }
}

/// A number as one would write it in a scenario.
pub(in crate::config) fn figure(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) { format!("{value:e}") } else { format!("{value}") }
}
