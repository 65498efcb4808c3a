//! Every dataset of a recording: its type, its axes, its unit, its frame, what it is, and which values of a
//! pulse it holds.
//!
//! Writers and readers of both kinds of recordings follow this list. They carry its text: HDF5 as attributes
//! of each dataset, plain folders in `meta.json`. The table in `docs/recording.md` is this one, which a test
//! checks.
//!
//! ```
//! use nereus::recording::descriptions::DESCRIPTIONS;
//! let delay = DESCRIPTIONS.iter().find(|of| of.path == "truth/delay_s").unwrap();
//! assert_eq!((delay.type_name(), delay.unit, delay.axes), ("float64", "s", "pulse, pair, target"));
//! assert!(DESCRIPTIONS.iter().all(|of| !of.description.is_empty()));
//! ```

use serde::Serialize;

use super::header::Header;
use super::rows::Element;
use crate::pulse::{Pulse, Samples};
use Content::{Each, Once};

/// Path of the column that is written last: what it covers is complete.
pub const INDEX: &str = "pulse/index";

/// One dataset.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Description {
    /// Where it is; `<platform>` and `<antenna>` stand for a name.
    #[serde(skip)]
    pub path: &'static str,
    #[serde(skip)]
    pub(super) content: Content,
    /// Axes, the slowest first, separated by commas.
    pub axes: &'static str,
    /// Unit; `1` of a pure number, `none` of texts.
    pub unit: &'static str,
    /// Frame or time scale; `none` where there is none.
    pub frame: &'static str,
    /// What it is.
    pub description: &'static str,
}

/// What a dataset holds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    /// A row for each pulse: the values of the pulse, of the platform or antenna of this number.
    Each(Element, fn(&Pulse, usize) -> Values<'_>),
    /// What is written once, where the header has it: the name of its type.
    Once(&'static str, fn(&Header) -> bool),
}

/// Values of a pulse for one row.
#[derive(Clone, Copy, Debug)]
pub(super) enum Values<'a> {
    U8(u8),
    U32(u32),
    U64(u64),
    I64(i64),
    F64(f64),
    Reals(&'a [f64]),
    Samples(&'a Samples),
}

/// Values of a platform or antenna; none of one that the pulse does not have.
fn of<'a, T>(part: Option<&'a T>, values: fn(&'a T) -> Values<'a>) -> Values<'a> {
    part.map_or(Values::Reals(&[]), values)
}

const fn row(path: &'static str, labels: [&'static str; 4], content: Content) -> Description {
    let [axes, unit, frame, description] = labels;
    Description { path, content, axes, unit, frame, description }
}

const PULSE: &str = "pulse";
const VECTOR: &str = "pulse, East-North-up";
const QUATERNION: &str = "pulse, w-x-y-z";
const ENU: &str = "ENU";
const BODY: &str = "body to ENU";
const NONE: &str = "none";

/// Every dataset that a recording may have.
#[rustfmt::skip]
pub static DESCRIPTIONS: [Description; 36] = [
    row("iq", ["pulse, channel, sample", "sqrt(W)", NONE,
        "samples at the receiver's port, complex baseband"],
        Each(Element::Cf32, |pulse, _| Values::Samples(&pulse.samples))),
    row("iq", ["pulse, channel, sample", "code", NONE, "ADC counts: (code + 1/2) adc_step is in sqrt(W)"],
        Each(Element::Ci16, |pulse, _| Values::Samples(&pulse.samples))),
    row("pulse/index", [PULSE, "1", NONE,
        "number of the pulse in the run; written last, so its length is the number of complete pulses"],
        Each(Element::U64, |pulse, _| Values::U64(pulse.index))),
    row("pulse/time_ns", [PULSE, "ns", "UTC since 1970", "emission of the pulse, rounded down"],
        Each(Element::I64, |pulse, _| Values::I64(pulse.time.to_unix_ns().0))),
    row("pulse/time_frac_ns", [PULSE, "ns", "UTC since 1970", "emission minus time_ns, in [0, 1)"],
        Each(Element::F64, |pulse, _| Values::F64(pulse.time.to_unix_ns().1))),
    row("pulse/window_start_s", [PULSE, "s", "the radar's clocks", "first sample minus emission"],
        Each(Element::F64, |pulse, _| Values::F64(pulse.window_start_s))),
    row("pulse/receiver_window_start_s", ["pulse, receiver", "s", "the radar's clocks",
        "the same of the window of every receiver, where these differ"],
        Each(Element::F64, |pulse, _| Values::Reals(&pulse.receiver_window_start_s))),
    row("pulse/flags", [PULSE, "bits", NONE,
        "1 late, 2 after a gap, 4 ADC saturated, 8 echo of a target or direct path outside the window, \
         16 true motion extrapolated, 32 navigation stale, 64 report dropped out; bits 8 to 10: error class (0: as asked)"],
        Each(Element::U32, |pulse, _| Values::U32(pulse.flags))),
    row("pulse/tx_pol", [PULSE, "code", NONE,
        "what was radiated: 0 all ports at once, 1 H, 2 V, 3 right circular, 4 left circular"],
        Each(Element::U8, |pulse, _| Values::U8(pulse.tx_pol))),
    row("nav/<platform>/true/position_m", [VECTOR, "m", ENU, "true position at the emission"],
        Each(Element::F64, |pulse, at| of(pulse.nav_true.get(at), |row| Values::Reals(&row.position_m)))),
    row("nav/<platform>/true/velocity_mps", [VECTOR, "m/s", ENU, "true velocity at the emission"],
        Each(Element::F64, |pulse, at| of(pulse.nav_true.get(at), |row| Values::Reals(&row.velocity_mps)))),
    row("nav/<platform>/true/attitude_quat", [QUATERNION, "1", BODY, "true attitude at the emission"],
        Each(Element::F64, |pulse, at| of(pulse.nav_true.get(at), |row| Values::Reals(&row.attitude_quat)))),
    row("nav/<platform>/true/age_s", [PULSE, "s", NONE,
        "emission minus the last fix of live navigation where that had to be extrapolated, else 0"],
        Each(Element::F64, |pulse, at| of(pulse.nav_true.get(at), |row| Values::F64(row.age_s)))),
    row("nav/<platform>/true/flags", [PULSE, "bits", NONE,
        "bits 16 and 32 of pulse/flags that this platform sets"],
        Each(Element::U32, |pulse, at| of(pulse.nav_true.get(at), |row| Values::U32(row.flags)))),
    row("nav/<platform>/reported/position_m", [VECTOR, "m", ENU, "position as reported for the emission"],
        Each(Element::F64, |pulse, at| of(pulse.nav_reported.get(at), |row| Values::Reals(&row.position_m)))),
    row("nav/<platform>/reported/velocity_mps", [VECTOR, "m/s", ENU,
        "velocity as reported for the emission"],
        Each(Element::F64, |pulse, at| of(pulse.nav_reported.get(at), |row| Values::Reals(&row.velocity_mps)))),
    row("nav/<platform>/reported/attitude_quat", [QUATERNION, "1", BODY,
        "attitude as reported for the emission"],
        Each(Element::F64, |pulse, at| of(pulse.nav_reported.get(at), |row| Values::Reals(&row.attitude_quat)))),
    row("nav/<platform>/reported/age_s", [PULSE, "s", NONE, "emission minus the epoch of the report"],
        Each(Element::F64, |pulse, at| of(pulse.nav_reported.get(at), |row| Values::F64(row.age_s)))),
    row("nav/<platform>/reported/flags", [PULSE, "bits", NONE,
        "bits of pulse/flags that this platform's report sets"],
        Each(Element::U32, |pulse, at| of(pulse.nav_reported.get(at), |row| Values::U32(row.flags)))),
    row("nav/<antenna>/phase_centre_m", [VECTOR, "m", ENU, "true phase centre at the emission"],
        Each(Element::F64, |pulse, at| of(pulse.antennas.get(at), |row| Values::Reals(&row.phase_centre_m)))),
    row("nav/<antenna>/boresight_quat", [QUATERNION, "1", "antenna to ENU",
        "true axes of the antenna at the emission"],
        Each(Element::F64, |pulse, at| of(pulse.antennas.get(at), |row| Values::Reals(&row.boresight_quat)))),
    row("nav/<antenna>/reported_phase_centre_m", [VECTOR, "m", ENU,
        "phase centre by the reported position and attitude and the lever arm as designed"],
        Each(Element::F64, |pulse, at| of(pulse.antennas.get(at), |row| Values::Reals(&row.reported_phase_centre_m)))),
    row("nav/<antenna>/encoder_deg", ["pulse, azimuth-elevation", "deg", "the pedestal's",
        "reading of the encoder of an antenna that scans: from North and the horizontal plane, or from nose and deck (look)"],
        Each(Element::F64, |pulse, at| of(pulse.antennas.get(at), |row| Values::Reals(row.encoder_deg.as_slice().as_flattened())))),
    row("truth/delay_s", ["pulse, pair, target", "s", NONE,
        "propagation delay transmitter-target-receiver, whether or not it is illuminated"],
        Each(Element::F64, |pulse, _| Values::Reals(&pulse.target_delay_s))),
    row("truth/doppler_hz", ["pulse, pair, target", "Hz", NONE,
        "Doppler of that path, positive when closing"],
        Each(Element::F64, |pulse, _| Values::Reals(&pulse.target_doppler_hz))),
    row("truth/ship_position_m", ["pulse, ship, East-North-up", "m", ENU,
        "midship at the waterline at the emission"],
        Each(Element::F64, |pulse, _| Values::Reals(pulse.ship_position_m.as_flattened()))),
    row("truth/ship_velocity_mps", ["pulse, ship, East-North-up", "m/s", ENU,
        "velocity of the ship at the emission"],
        Each(Element::F64, |pulse, _| Values::Reals(pulse.ship_velocity_mps.as_flattened()))),
    row("truth/ship_heading_deg", ["pulse, ship", "deg", "clockwise from North",
        "heading of the ship, from 0 to 360"],
        Each(Element::F64, |pulse, _| Values::Reals(&pulse.ship_heading_deg))),
    row("truth/clock/<antenna>/x_s", [PULSE, "s", NONE,
        "reading of the antenna's clock minus time, at the emission"],
        Each(Element::F64, |pulse, at| of(pulse.clock_x_s.get(at), |x_s| Values::F64(*x_s)))),
    row("truth/targets", ["target", NONE, NONE, "names of the targets"],
        Once("text", |header| !header.targets.is_empty())),
    row("truth/ships", ["ship", NONE, NONE, "names of the ships"],
        Once("text", |header| !header.ships.is_empty())),
    row("truth/clocks", ["clock", NONE, NONE, "names of the antennas whose clocks have errors"],
        Once("text", |header| !header.clocks.is_empty())),
    row("truth/pairs", ["pair", NONE, NONE, "transmitter and receiver of each pair"],
        Once("table", |header| !header.pairs.is_empty())),
    row("truth/changes", ["change", "time_ns: ns", "time_ns: UTC since 1970",
        "changes of reports: first pulse that has it, its emission rounded down, platform, change, source"],
        Once("table", |header| header.changes.is_some())),
    row("channel", ["channel", NONE, NONE,
        "name, transmitter, receiver, polarisations (received, then transmitted; or tone, loopback)"],
        Once("table", |_| true)),
    row("replica", ["sample", "1", NONE, "transmitted pulse after the receive filter at sample_rate_hz; of waveforms in turn one after the other"],
        Once("complex64", |_| true)),
];

impl Description {
    /// Type of an element, by numpy's name where it has one.
    pub fn type_name(&self) -> &'static str {
        match self.content {
            Each(element, _) => element.name(),
            Once(name, _) => name,
        }
    }
}

/// The datasets of a recording that are no columns: those of its header.
pub fn of_header(header: &Header) -> impl Iterator<Item = &'static Description> {
    DESCRIPTIONS.iter().filter(|of| matches!(of.content, Once(_, is_there) if is_there(header)))
}
