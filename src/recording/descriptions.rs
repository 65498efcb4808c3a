//! What every dataset of a recording is, in words: its axes, its unit, its frame.
//!
//! Both kinds of recordings carry these words: HDF5 as attributes of each dataset, plain folders in
//! `meta.json`. Their table in `docs/recording.md` is this one, which a test checks.
//!
//! ```
//! use nereus::recording::descriptions::{DESCRIPTIONS, named};
//! let delay = named("truth/delay_s").unwrap();
//! assert_eq!((delay.unit, delay.axes), ("s", "pulse, pair, target"));
//! assert!(DESCRIPTIONS.iter().all(|of| !of.description.is_empty()));
//! ```

use serde::Serialize;

use super::columns::{Column, Element};
use super::header::Header;

/// The words for one dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Description {
    /// Where it is; `<platform>` and `<antenna>` stand for a name.
    #[serde(skip)]
    pub path: &'static str,
    /// Type of an element, by numpy's name where it has one.
    #[serde(skip)]
    pub element: &'static str,
    /// Axes, the slowest first, separated by commas.
    pub axes: &'static str,
    /// Unit; `1` of a pure number, `none` of texts.
    pub unit: &'static str,
    /// Frame or time scale; `none` where there is none.
    pub frame: &'static str,
    /// What it is.
    pub description: &'static str,
}

const fn row(path: &'static str, rest: [&'static str; 5]) -> Description {
    let [element, axes, unit, frame, description] = rest;
    Description { path, element, axes, unit, frame, description }
}

const F64: &str = "float64";
const TEXT: &str = "text";
const TABLE: &str = "table";
const PULSE: &str = "pulse";
const VECTOR: &str = "pulse, East-North-up";
const QUATERNION: &str = "pulse, w-x-y-z";
const ENU: &str = "ENU";
const BODY: &str = "body to ENU";
const NONE: &str = "none";

/// Every dataset that a recording may have.
#[rustfmt::skip]
pub static DESCRIPTIONS: [Description; 34] = [
    row("iq", ["complex64", "pulse, channel, sample", "sqrt(W)", NONE, "samples at the receiver's port, complex baseband"]),
    row("iq", ["{r, i} of int16", "pulse, channel, sample", "code", NONE,
        "ADC counts: (code + 1/2) adc_step is in sqrt(W)"]),
    row("pulse/index", ["uint64", PULSE, "1", NONE,
        "number of the pulse in the run; written last, so its length is the number of complete pulses"]),
    row("pulse/time_ns", ["int64", PULSE, "ns", "UTC since 1970", "emission of the pulse, rounded down"]),
    row("pulse/time_frac_ns", [F64, PULSE, "ns", "UTC since 1970", "emission minus time_ns, in [0, 1)"]),
    row("pulse/window_start_s", [F64, PULSE, "s", "the radar's clocks", "first sample minus emission"]),
    row("pulse/flags", ["uint32", PULSE, "bits", NONE,
        "1 late, 2 after a gap, 4 ADC saturated, 8 echo of a target or direct path outside the window, \
         16 true motion extrapolated, 32 navigation stale, 64 report dropped out"]),
    row("pulse/tx_pol", ["uint8", PULSE, "code", NONE,
        "what was radiated: 0 all ports at once, 1 H, 2 V, 3 right circular, 4 left circular"]),
    row("nav/<platform>/true/position_m", [F64, VECTOR, "m", ENU, "true position at the emission"]),
    row("nav/<platform>/true/velocity_mps", [F64, VECTOR, "m/s", ENU, "true velocity at the emission"]),
    row("nav/<platform>/true/attitude_quat", [F64, QUATERNION, "1", BODY, "true attitude at the emission"]),
    row("nav/<platform>/true/age_s", [F64, PULSE, "s", NONE,
        "emission minus the last fix of live navigation where that had to be extrapolated, else 0"]),
    row("nav/<platform>/true/flags", ["uint32", PULSE, "bits", NONE, "bits 16 and 32 of pulse/flags that this platform sets"]),
    row("nav/<platform>/reported/position_m", [F64, VECTOR, "m", ENU, "position as reported for the emission"]),
    row("nav/<platform>/reported/velocity_mps", [F64, VECTOR, "m/s", ENU, "velocity as reported for the emission"]),
    row("nav/<platform>/reported/attitude_quat", [F64, QUATERNION, "1", BODY, "attitude as reported for the emission"]),
    row("nav/<platform>/reported/age_s", [F64, PULSE, "s", NONE, "emission minus the epoch of the report"]),
    row("nav/<platform>/reported/flags", ["uint32", PULSE, "bits", NONE, "bits of pulse/flags that this platform's report sets"]),
    row("nav/<antenna>/phase_centre_m", [F64, VECTOR, "m", ENU, "true phase centre at the emission"]),
    row("nav/<antenna>/boresight_quat", [F64, QUATERNION, "1", "antenna to ENU", "true axes of the antenna at the emission"]),
    row("nav/<antenna>/reported_phase_centre_m", [F64, VECTOR, "m", ENU,
        "phase centre by the reported position and attitude and the lever arm as designed"]),
    row("truth/delay_s", [F64, "pulse, pair, target", "s", NONE,
        "propagation delay transmitter-target-receiver, whether or not it is illuminated"]),
    row("truth/doppler_hz", [F64, "pulse, pair, target", "Hz", NONE, "Doppler of that path, positive when closing"]),
    row("truth/ship_position_m", [F64, "pulse, ship, East-North-up", "m", ENU, "midship at the waterline at the emission"]),
    row("truth/ship_velocity_mps", [F64, "pulse, ship, East-North-up", "m/s", ENU, "velocity of the ship at the emission"]),
    row("truth/ship_heading_deg", [F64, "pulse, ship", "deg", "clockwise from North", "heading of the ship, from 0 to 360"]),
    row("truth/clock/<antenna>/x_s", [F64, PULSE, "s", NONE, "reading of the antenna's clock minus time, at the emission"]),
    row("truth/targets", [TEXT, "target", NONE, NONE, "names of the targets"]),
    row("truth/ships", [TEXT, "ship", NONE, NONE, "names of the ships"]),
    row("truth/clocks", [TEXT, "clock", NONE, NONE, "names of the antennas whose clocks are wrong"]),
    row("truth/pairs", [TABLE, "pair", NONE, NONE, "transmitter and receiver of each pair"]),
    row("truth/changes", [TABLE, "change", "time_ns: ns", "time_ns: UTC since 1970",
        "changes of reports: first pulse that has it, its emission rounded down, platform, change, source"]),
    row("channel", [TABLE, "channel", NONE, NONE,
        "name, transmitter, receiver, polarisations (received, then transmitted; or tone, loopback)"]),
    row("replica", ["complex64", "sample", "1", NONE, "transmitted pulse after the receive filter at sample_rate_hz"]),
];

/// Whether a path fits a pattern: `<...>` stands for one name.
fn fits(pattern: &str, path: &str) -> bool {
    pattern.split('/').count() == path.split('/').count()
        && pattern.split('/').zip(path.split('/')).all(|(part, name)| part.starts_with('<') || part == name)
}

/// The words for a per-pulse column.
pub fn of_column(column: &Column) -> Option<&'static Description> {
    DESCRIPTIONS.iter().find(|of| of.element == element(column.element) && fits(of.path, &column.path))
}

/// The words for a dataset that is there once.
pub fn named(path: &str) -> Option<&'static Description> {
    DESCRIPTIONS.iter().find(|of| of.path == path)
}

/// The words for the datasets of a recording that are no columns: those of its header.
pub fn of_header(header: &Header) -> impl Iterator<Item = &'static Description> {
    let there = [
        ("replica", true),
        ("channel", true),
        ("truth/targets", !header.targets.is_empty()),
        ("truth/ships", !header.ships.is_empty()),
        ("truth/clocks", !header.clocks.is_empty()),
        ("truth/pairs", !header.pairs.is_empty()),
        ("truth/changes", header.changes.is_some()),
    ];
    there.into_iter().filter(|(_, there)| *there).filter_map(|(path, _)| named(path))
}

/// A type as the table has it.
fn element(element: Element) -> &'static str {
    match element {
        Element::U8 => "uint8",
        Element::U32 => "uint32",
        Element::U64 => "uint64",
        Element::I64 => "int64",
        Element::F64 => F64,
        Element::Cf32 => "complex64",
        Element::Ci16 => "{r, i} of int16",
    }
}
