//! What can be wrong with a scenario.

use std::fmt;
use std::io;
use std::path::PathBuf;

use thiserror::Error;

pub use super::warning::Warning;
use crate::scene::patch::PatchError;

/// Why a scenario is not a run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read scenario {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file is not a scenario by its size.
    #[error("scenario {} has {bytes} bytes; allowed: at most {allowed}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The bound.
        allowed: u64,
    },
    /// The file is not text.
    #[error("scenario {} is not UTF-8 text (byte {offset})", path.display())]
    NotText {
        /// The file.
        path: PathBuf,
        /// The first offending byte.
        offset: usize,
    },
    /// Every fault of the scenario, in the order of the file.
    #[error("{}", list(path, faults))]
    Faults {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        faults: Vec<Fault>,
    },
}

impl ConfigError {
    /// The faults, where the file could be read.
    pub fn faults(&self) -> &[Fault] {
        match self {
            Self::Faults { faults, .. } => faults,
            _ => &[],
        }
    }
}

/// Faults of syntax that are listed: a file that is no TOML at all has one on every line.
const MOST_SYNTAX: usize = 5;

/// What is wrong with a path where a file is asked for.
fn no_file(path: &std::path::Path) -> String {
    let shown = path.display();
    match path.exists() {
        true if path.is_dir() => format!("{shown} is a folder"),
        true => format!("{shown} is a pipe or a device"),
        false => format!("there is no file {shown}"),
    }
}

fn list(path: &std::path::Path, faults: &[Fault]) -> String {
    let mut text = String::new();
    let mut garbled = 0;
    for fault in faults {
        if matches!(fault.problem, Problem::Syntax { .. }) {
            garbled += 1;
            if garbled > MOST_SYNTAX {
                continue;
            }
        }
        let place = match fault.at {
            At::File { line, column } => format!("{}:{line}:{column}", path.display()),
            At::Override => "--set".to_owned(),
        };
        text.push_str(&format!("{place}: {fault}\n"));
    }
    if garbled > MOST_SYNTAX {
        text.push_str(&format!(
            "{}: not valid TOML in {} more places\n",
            path.display(),
            garbled - MOST_SYNTAX
        ));
    }
    let plural = if faults.len() == 1 { "fault" } else { "faults" };
    text.push_str(&format!("{}: {} {plural}", path.display(), faults.len()));
    text
}

/// Where a value was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum At {
    /// In the scenario, lines and columns from 1.
    File {
        /// Line.
        line: usize,
        /// Column, characters.
        column: usize,
    },
    /// On the command line.
    Override,
}

/// One fault: where, which key, what.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{}{problem}", if key.is_empty() { String::new() } else { format!("{key}: ") })]
pub struct Fault {
    /// Where.
    pub at: At,
    /// Dotted path of the key, entries of arrays by number from 0.
    pub key: String,
    /// What.
    pub problem: Problem,
}

/// What is wrong, with the value and what is allowed.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum Problem {
    /// Not TOML.
    #[error("not valid TOML: {message}")]
    Syntax {
        /// What the parser reports.
        message: String,
    },
    /// A key that no table of this kind has.
    #[error("unknown key{hint}")]
    Unknown {
        /// What may have been meant.
        hint: Hint,
    },
    /// A key of this table that is not allowed together with the others.
    #[error("not allowed here ({when})")]
    Idle {
        /// Why.
        when: String,
    },
    /// A value of another type.
    #[error("{found} is not allowed; allowed: {allowed}")]
    Type {
        /// What was written.
        found: String,
        /// What is allowed.
        allowed: String,
    },
    /// A value out of range.
    #[error("{found} is out of range; allowed: {allowed}")]
    Range {
        /// What was written.
        found: String,
        /// What is allowed.
        allowed: String,
    },
    /// A required key.
    #[error("is missing; required: {allowed}")]
    Missing {
        /// What is allowed.
        allowed: String,
    },
    /// None of several keys.
    #[error("one of {keys} is required")]
    NoneOf {
        /// The keys.
        keys: String,
    },
    /// Several of which one is wanted.
    #[error("{keys} exclude each other; allowed: one of them")]
    Several {
        /// The keys.
        keys: String,
    },
    /// Keys that stand together or not at all.
    #[error("stands alone; allowed: {keys} together, or none of them")]
    Alone {
        /// The keys.
        keys: String,
    },
    /// A name given twice.
    #[error("\"{name}\" is already the name of another {what}; allowed: unique names")]
    Duplicate {
        /// The name.
        name: String,
        /// Of what.
        what: &'static str,
    },
    /// A name that nothing has.
    #[error("there is no {what} \"{name}\"; allowed: {known}")]
    NoSuch {
        /// The name.
        name: String,
        /// What was looked for.
        what: &'static str,
        /// The names there are.
        known: String,
    },
    /// A missing file.
    #[error("{}; allowed: a file that exists (relative to the scenario file)", no_file(path))]
    NoFile {
        /// Where it was looked for.
        path: PathBuf,
    },
    /// Neither a file nor the word that stands for one.
    #[error("{}; allowed: {allowed}", no_file(path))]
    NoFileOr {
        /// Where it was looked for.
        path: PathBuf,
        /// What is allowed.
        allowed: String,
    },
    /// Latitude and longitude in a scene that is not georeferenced.
    #[error(
        "a geodetic position needs scene.origin_lat_deg, origin_lon_deg and origin_h_m; allowed here: position_m"
    )]
    NeedsOrigin,
    /// More bandwidth than can be sampled.
    #[error(
        "{bandwidth_hz:e} Hz exceeds the sample rate (radar.sample_rate_hz); allowed: up to {sample_rate_hz:e} Hz"
    )]
    Bandwidth {
        /// Bandwidth.
        bandwidth_hz: f64,
        /// Sample rate.
        sample_rate_hz: f64,
    },
    /// An emitter of whose band nothing is received.
    #[error(
        "its band begins {begins_hz:e} Hz off the carrier of [radar]; allowed: within half of radar.sample_rate_hz, {half_hz:e} Hz"
    )]
    OutOfBand {
        /// Where the nearer edge of its band lies.
        begins_hz: f64,
        /// Half the sample rate.
        half_hz: f64,
    },
    /// A window that cannot hold one pulse.
    #[error(
        "{samples} samples ({window_s:e} s) are shorter than the pulse ({pulse_s:e} s); allowed: at least {least}"
    )]
    ShortWindow {
        /// Samples of the window.
        samples: u64,
        /// Its length.
        window_s: f64,
        /// Pulse length.
        pulse_s: f64,
        /// Fewest samples.
        least: u64,
    },
    /// Pulses that overlap.
    #[error(
        "{pri_us} us between pulses are shorter than the pulse of {pulse_us} us: two pulses would leave at once; \
         allowed: at least {pulse_us} us"
    )]
    ShortInterval {
        /// The shortest interval, us.
        pri_us: f64,
        /// Pulse length, us.
        pulse_us: f64,
    },
    /// A target in the water.
    #[error("lies {depth_m:.3} m below the sea; allowed: a height of 0 m or more above mean sea level")]
    BelowSea {
        /// Depth, m.
        depth_m: f64,
    },
    /// A channel whose polarisation is never radiated.
    #[error(
        "channel \"{channel}\" needs transmit polarisation {letter}, which tx_sequence never sends; allowed: a sequence with {letter}"
    )]
    NeverSent {
        /// The channel.
        channel: String,
        /// The polarisation.
        letter: char,
    },
    /// A channel between ends that have nothing to do with each other.
    #[error(
        "receiver \"{receiver}\" does not hear transmitter \"{transmitter}\"; allowed: {heard} (its key hears)"
    )]
    Unheard {
        /// The receiver.
        receiver: String,
        /// The transmitter.
        transmitter: String,
        /// What it hears.
        heard: String,
    },
    /// A pulse that fills the memory.
    #[error(
        "one pulse takes {bytes} bytes ({channels} channels of {samples} samples); allowed: at most {allowed}"
    )]
    PulseSize {
        /// Bytes of a pulse.
        bytes: u128,
        /// Channels.
        channels: usize,
        /// Samples per channel.
        samples: u64,
        /// The bound.
        allowed: u128,
    },
    /// Too many of something.
    #[error("{count} {what}; allowed: at most {allowed}")]
    TooMany {
        /// How many.
        count: u64,
        /// Of what.
        what: &'static str,
        /// The bound.
        allowed: u64,
    },
    /// Facets that do not make a patch.
    #[error("{fault}; allowed: {allowed}")]
    Patch {
        /// What is wrong.
        fault: PatchError,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A model used where it does not hold.
    #[error("\"{model}\" does not hold at {found}; allowed: {allowed}")]
    BeyondModel {
        /// The model.
        model: &'static str,
        /// Where it is used.
        found: String,
        /// Where it holds.
        allowed: String,
    },
    /// Corners of a polygon on one line.
    #[error("the corners enclose no area; allowed: corners of a polygon, in turn")]
    NoArea,
    /// A hull from a formula without a length.
    #[error("is missing; required with hull = \"wigley\": {allowed}")]
    NeedsLength {
        /// What is allowed.
        allowed: String,
    },
    /// Something that live navigation does not allow.
    #[error("{found} is not allowed {place}; allowed: {allowed}")]
    Live {
        /// What was written.
        found: &'static str,
        /// Beside what, or where.
        place: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Live navigation without a start time.
    #[error("is missing; required with live navigation: \"live\", or the UTC time at which pulse 0 leaves")]
    LiveNeedsStart,
    /// Live navigation in a scene that is not georeferenced.
    #[error("live navigation needs scene.origin_lat_deg, origin_lon_deg and origin_h_m")]
    LiveNeedsOrigin,
    /// A recorded track of latitudes and longitudes in a scene that is not georeferenced.
    #[error(
        "holds latitudes and longitudes, which need scene.origin_lat_deg, origin_lon_deg and origin_h_m; \
         allowed without them: a CSV file of x_m, y_m, z_m"
    )]
    TrackNeedsOrigin,
    /// Recorded tracks without a start time.
    #[error("is missing; required with a recorded track: a UTC time within the recording")]
    NeedsStart,
    /// A log that cannot be used.
    #[error("{error}")]
    Log {
        /// What is wrong with it.
        error: String,
    },
    /// A port that is none.
    #[error("{error}")]
    Device {
        /// What is wrong with it.
        error: String,
    },
    /// More ports than there are from the first one on.
    #[error("\"{bind}\" is the first of {ports} ports, one per channel; allowed: a first port of at most {}", 65_536 - u32::from(*.ports))]
    Ports {
        /// As written.
        bind: String,
        /// Ports.
        ports: u16,
    },
    /// Refused by another module.
    #[error("{error}")]
    Refused {
        /// What is wrong with it.
        error: String,
    },
    /// Navigation out in a scene that is not georeferenced.
    #[error("navigation out needs scene.origin_lat_deg, origin_lon_deg and origin_h_m")]
    ReportNeedsOrigin,
    /// Positions of a log in a scene that is not georeferenced.
    #[error("positions of a log need scene.origin_lat_deg, origin_lon_deg and origin_h_m")]
    LogNeedsOrigin,
    /// A log from which no ship sails.
    #[error(
        "no vessel is under way: of {vessels} in {log}, {why}; allowed: a start_utc within the log, or wider limits{}",
        if *swapped { "; with latitude and longitude swapped, vessels would be near" } else { "" }
    )]
    NobodySails {
        /// The log.
        log: String,
        /// Vessels looked at.
        vessels: usize,
        /// How many were left out why.
        why: String,
        /// Whether latitudes and longitudes look swapped.
        swapped: bool,
    },
    /// An override of a key that does not exist.
    #[error("no such entry: {reason}")]
    Lost {
        /// Why.
        reason: String,
    },
}

/// What may have been meant by an unknown key.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Hint {
    /// No idea; the keys there are.
    Known(String),
    /// A key like it.
    Like(&'static str),
    /// The same quantity in another unit.
    Unit {
        /// The key.
        key: &'static str,
        /// Its unit.
        unit: &'static str,
    },
    /// The key of another table.
    Elsewhere {
        /// The table.
        table: &'static str,
    },
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Known(keys) => write!(f, "; allowed: {keys}"),
            Self::Like(key) => write!(f, "; did you mean {key}?"),
            Self::Unit { key, unit } => write!(f, "; did you mean {key}, in {unit}?"),
            Self::Elsewhere { table } => write!(f, "; it belongs to {table}"),
        }
    }
}
