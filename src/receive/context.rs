//! Contents of context packets: the fields of the first context indicator of VITA 49.2 (section 9), and the
//! extension contexts of `docs/wire.md`.

use serde::Serialize;

use crate::time::TimeTag;

use super::packet::{Class, Malformed, Words};
use super::radar;

pub use super::radar::{
    AntennaDescription, EmitterDescription, PulseDescription, ReplicaPiece, SignalDescription,
};

/// Class identifiers of the extension contexts that are understood.
const OUI: u32 = 0x004e_4552;
const INFORMATION_CLASS: u16 = 1;

/// How a complex sample is packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Format {
    /// Two 32-bit floats.
    Cf32,
    /// Two 16-bit integers.
    Ci16,
}

/// The state of a platform by the standard's ECEF ephemeris; `None` where a value is unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Ephemeris {
    /// ECEF position, metres.
    pub position_m: [Option<f64>; 3],
    /// Turns about z, y, x, degrees.
    pub attitude_deg: [Option<f64>; 3],
    /// ECEF velocity, m/s.
    pub velocity_mps: [Option<f64>; 3],
}

/// Fields of a standard context, as far as they are used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Context {
    /// Bandwidth, Hz.
    pub bandwidth_hz: Option<f64>,
    /// Radio frequency of the intermediate frequency, Hz.
    pub radio_hz: Option<f64>,
    /// Power of a signal of unit amplitude, dBm.
    pub reference_level_dbm: Option<f64>,
    /// Sample rate, Hz.
    pub sample_rate_hz: Option<f64>,
    /// Payload format, where it is one that is understood.
    pub format: Option<Format>,
    /// State of the platform.
    pub ephemeris: Option<Ephemeris>,
}

/// Signed fixed point, 20 bits below the point.
fn hertz(words: &mut Words<'_>) -> Result<f64, Malformed> {
    Ok(words.i64()? as f64 / f64::from(1 << 20))
}

/// Three signed fixed-point numbers.
fn triple(words: &mut Words<'_>, point: u32) -> Result<[Option<f64>; 3], Malformed> {
    let mut values = [None; 3];
    for value in &mut values {
        let word = words.u32()?;
        *value = (word != 0x7fff_ffff).then(|| f64::from(word as i32) / f64::from(1u32 << point));
    }
    Ok(values)
}

/// The two words of the payload format.
fn format(first: u32, second: u32) -> Option<Format> {
    let complex = first >> 29 & 3 == 1;
    // No tags, no repetition, one value a vector; items as wide as their fields, so the packing method is
    // alike.
    let plain = first >> 12 & 0x0fff == 0 && second == 0;
    let widths = (first >> 6 & 63, first & 63);
    match (complex && plain, first >> 24 & 31, widths) {
        (true, 14, (31, 31)) => Some(Format::Cf32),
        (true, 0, (15, 15)) => Some(Format::Ci16),
        _ => None,
    }
}

impl Context {
    /// Reads the payload of a context packet. `None` when its fields have attributes (CIF 7), which is legal
    /// but not understood here.
    ///
    /// # Errors
    /// A payload that ends early, or has values that are not allowed.
    pub fn parse(payload: &[u8]) -> Result<Option<Self>, Malformed> {
        let mut words = Words::new(payload, "context indicators");
        let fields = words.u32()?;
        if fields >> 7 & 1 == 1 {
            return Ok(None);
        }
        for further in [1, 2, 3] {
            if fields >> further & 1 == 1 {
                words.u32()?;
            }
        }
        words.part("context fields");
        let mut context = Self::default();
        for bit in (8..31).rev() {
            if fields >> bit & 1 == 0 {
                continue;
            }
            match bit {
                29 => context.bandwidth_hz = Some(hertz(&mut words)?),
                27 => context.radio_hz = Some(hertz(&mut words)?),
                24 => context.reference_level_dbm = Some(f64::from(words.u32()? as u16 as i16) / 128.0),
                21 => context.sample_rate_hz = Some(hertz(&mut words)?),
                15 => context.format = format(words.u32()?, words.u32()?),
                12 => {
                    words.bytes(16)?;
                    let (position_m, attitude_deg) = (triple(&mut words, 5)?, triple(&mut words, 22)?);
                    let velocity_mps = triple(&mut words, 16)?;
                    context.ephemeris = Some(Ephemeris { position_m, attitude_deg, velocity_mps });
                }
                // One word.
                30 | 23 | 22 | 19 | 18 | 16 | 10 => drop(words.bytes(4)?),
                // Two words.
                28 | 26 | 25 | 20 | 17 => drop(words.bytes(8)?),
                14 | 13 => drop(words.bytes(44)?),
                11 => drop(words.bytes(52)?),
                9 => {
                    words.u32()?;
                    let length = words.u32()? as usize;
                    words.bytes(length.saturating_mul(4))?;
                }
                8 => {
                    let (lists, further) = (words.u32()?, words.u32()?);
                    let tags = 1 + (further >> 15 & 1);
                    let entries =
                        (lists >> 16 & 511) + (lists & 511) + (further >> 16) + tags * (further & 0x7fff);
                    words.bytes(4 * entries as usize)?;
                }
                _ => {}
            }
        }
        Ok(Some(context))
    }
}

/// The run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunDescription {
    /// Latitude (deg), longitude (deg) and height (m) of the scene's origin; NaN where it is not
    /// georeferenced.
    pub origin: [f64; 3],
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Bandwidth, Hz.
    pub bandwidth_hz: f64,
    /// Length of the waveform, s.
    pub pulse_s: f64,
    /// Mean pulse repetition frequency, Hz.
    pub prf_hz: f64,
    /// Emission of pulse 0: whole UTC seconds and the rest.
    pub start: (i64, f64),
    /// First pulse.
    pub first_pulse: u64,
    /// Pulses of the run.
    pub pulses: u64,
    /// Seed of its random streams.
    pub seed: u64,
    /// Who sends.
    pub software: String,
    /// Antennas, and samples of the replica, that are described; none by a sender that describes no radar.
    pub radar: Option<[u32; 2]>,
    /// Receivers with windows of their own; 0 where all receive in the same.
    pub windows: u32,
    /// Emitters that are described.
    pub emitters: u32,
}

/// A channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelDescription {
    /// Its number, and how many there are.
    pub number: [u32; 2],
    /// Samples of a pulse.
    pub samples: u32,
    /// Converter: value of a code, sqrt(W), and its bits; NaN and 0 without one.
    pub adc: (f64, u32),
    /// Name, transmitter, receiver, polarisations.
    pub names: [String; 4],
    /// Polarisation bases of the transmitter and the receiver; empty from a sender that does not know them.
    pub bases: [String; 2],
}

/// What a platform reported at a pulse, and what else is known of the pulse.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Number of the pulse.
    pub index: u64,
    /// Its flags.
    pub flags: u32,
    /// What was radiated.
    pub tx_pol: u8,
    /// The platform's number, and how many there are.
    pub platform: [u32; 2],
    /// First sample after the emission, s.
    pub window_start_s: f64,
    /// Emission: whole UTC seconds and the rest.
    pub emission: (i64, f64),
    /// Age of the report, s.
    pub age_s: f64,
    /// Flags of the platform.
    pub platform_flags: u32,
    /// Position, ENU of the origin, metres.
    pub position_m: [f64; 3],
    /// Velocity, ENU, m/s.
    pub velocity_mps: [f64; 3],
    /// Body to ENU.
    pub attitude_quat: [f64; 4],
    /// Position, ECEF, metres; NaN where the scene is not georeferenced.
    pub ecef_position_m: [f64; 3],
    /// Velocity, ECEF, m/s.
    pub ecef_velocity_mps: [f64; 3],
    /// Body to ECEF.
    pub ecef_attitude_quat: [f64; 4],
    /// What is added: the first sample of every receiver after the emission, s, where receivers have windows
    /// of their own; azimuth and elevation that the encoder of every antenna that scans reads, degrees;
    /// behind them what later versions add.
    pub additions: Vec<f64>,
}

impl State {
    /// Whether it adds the windows of so many receivers, and what so many encoders read.
    pub(super) fn adds(&self, windows: usize, encoders: usize) -> bool {
        let starts_s = self.additions.get(..windows);
        let read = self.additions.get(windows..windows + 2 * encoders);
        starts_s.is_some_and(|all| all.iter().all(is_near))
            && read.is_some_and(|all| all.iter().all(|deg| deg.is_finite()))
    }

    /// The emission.
    pub fn time(&self) -> TimeTag {
        TimeTag::new(self.emission.0, self.emission.1)
    }
}

/// An extension context.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Extension {
    /// A platform's state.
    State(Box<State>),
    /// A channel.
    Channel(ChannelDescription),
    /// A platform: its number, how many there are, its name.
    Platform([u32; 2], String),
    /// The run.
    Run(Box<RunDescription>),
    /// Waveform and receive filter.
    Signal(Box<SignalDescription>),
    /// A piece of the replica.
    Replica(ReplicaPiece),
    /// An antenna.
    Antenna(Box<AntennaDescription>),
    /// An emitter.
    Emitter(Box<EmitterDescription>),
    /// One of several pulses in turn.
    Pulse(Box<PulseDescription>),
}

impl Extension {
    /// Reads the body of an extension context; `None` for one of another organisation or kind.
    ///
    /// # Errors
    /// A payload that ends early, or has values that are not allowed.
    pub fn parse(class: Class, body: &[u8]) -> Result<Option<Self>, Malformed> {
        if class.oui != OUI || class.information != INFORMATION_CLASS {
            return Ok(None);
        }
        let mut words = Words::new(body, "extension context");
        Ok(Some(match class.packet {
            1 => Self::State(Box::new(state(&mut words)?)),
            2 => {
                let number = [words.u32()?, words.u32()?];
                let samples = words.u32()?;
                // The format stands in the standard context.
                words.u32()?;
                let adc = (words.f64()?, words.u32()?);
                words.u32()?;
                let names = [words.text()?, words.text()?, words.text()?, words.text()?];
                let bases =
                    if words.is_empty() { Default::default() } else { [words.text()?, words.text()?] };
                Self::Channel(ChannelDescription { number, samples, adc, names, bases })
            }
            3 => Self::Platform([words.u32()?, words.u32()?], words.text()?),
            4 => Self::Run(Box::new(run(&mut words)?)),
            5 => Self::Signal(Box::new(radar::signal(&mut words)?)),
            6 => Self::Replica(radar::replica(words)?),
            7 => Self::Antenna(Box::new(radar::antenna(&mut words)?)),
            8 => Self::Emitter(Box::new(radar::emitter(&mut words)?)),
            9 => Self::Pulse(Box::new(radar::pulse(&mut words)?)),
            _ => return Ok(None),
        }))
    }
}

/// Farthest window from its pulse, s.
const WINDOW_S: f64 = 1e6;
/// Latest second of an instant: some 35,000 years.
const SECONDS: i64 = 1 << 40;

/// Whole seconds and a fraction that can be calculated with.
fn check_instant((seconds, fraction_s): (i64, f64)) -> Result<(), Malformed> {
    if (-SECONDS..=SECONDS).contains(&seconds) && (0.0..1.0).contains(&fraction_s) {
        Ok(())
    } else {
        Err(Malformed::Value("such an instant"))
    }
}

/// Whether a window is one of a pulse.
pub(super) fn is_near(start_s: &f64) -> bool {
    (-WINDOW_S..=WINDOW_S).contains(start_s)
}

fn state(words: &mut Words<'_>) -> Result<State, Malformed> {
    let (index, flags, place) = (words.u64()?, words.u32()?, words.u32()?);
    let window_start_s = words.f64()?;
    let emission = (words.i64()?, words.f64()?);
    let (age_s, platform_flags, platforms) = (words.f64()?, words.u32()?, words.u32()?);
    check_instant(emission)?;
    let mut state = State {
        index,
        flags,
        tx_pol: (place >> 24) as u8,
        platform: [place & 0xffff, platforms],
        window_start_s,
        emission,
        age_s,
        platform_flags,
        position_m: words.f64s()?,
        velocity_mps: words.f64s()?,
        attitude_quat: words.f64s()?,
        ecef_position_m: words.f64s()?,
        ecef_velocity_mps: words.f64s()?,
        ecef_attitude_quat: words.f64s()?,
        additions: Vec::new(),
    };
    // As many as the run says; later versions may add more.
    while let (true, Ok(value)) = (state.additions.len() < 3 * radar::ANTENNAS as usize, words.f64()) {
        state.additions.push(value);
    }
    if !is_near(&window_start_s) {
        return Err(Malformed::Value("a window so far from its pulse"));
    }
    Ok(state)
}

fn run(words: &mut Words<'_>) -> Result<RunDescription, Malformed> {
    let origin = words.f64s()?;
    let [carrier_hz, sample_rate_hz, bandwidth_hz, pulse_s, prf_hz] = words.f64s()?;
    let start = (words.i64()?, words.f64()?);
    let (first_pulse, pulses, seed) = (words.u64()?, words.u64()?, words.u64()?);
    let software = words.text()?;
    let described = if words.is_empty() { None } else { Some([words.u32()?, words.u32()?]) };
    if described.is_some_and(|[antennas, replica]| antennas > radar::ANTENNAS || replica > radar::REPLICA) {
        return Err(Malformed::Value("so many antennas, or so long a replica,"));
    }
    let [windows, emitters] = if words.is_empty() { [0; 2] } else { [words.u32()?, words.u32()?] };
    if windows.max(emitters) > radar::ANTENNAS {
        return Err(Malformed::Value("so many receive windows or emitters"));
    }
    let sane = |value: f64| value.is_finite() && value > 0.0;
    check_instant(start)?;
    // Within what can be counted: samples of a window, pulses of a run.
    let fast = [carrier_hz, sample_rate_hz].into_iter().all(|value| sane(value) && value <= 1e12);
    if !fast || !sane(prf_hz) || !(1e-6..=1e9).contains(&prf_hz) {
        return Err(Malformed::Value("a frequency out of range"));
    }
    Ok(RunDescription {
        origin,
        carrier_hz,
        sample_rate_hz,
        bandwidth_hz,
        pulse_s,
        prf_hz,
        start,
        first_pulse,
        pulses,
        seed,
        software,
        radar: described,
        windows,
        emitters,
    })
}
