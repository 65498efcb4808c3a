//! The instrument, as described: transmitters, receivers, channels, waveform, windows.

mod band;
mod pointing;
mod signals;
mod waveform;

use std::path::PathBuf;

use super::front_end::FrontEnd;
use crate::frames::{Body, Vector};
use crate::pulse::{Layout, SampleFormat};
use crate::time::PulseTimes;

pub use band::Band;
pub use pointing::{Aim, AimFrom, Encoder, Pointing, Scan, ScanLaw, Steering};
pub use signals::{AfterEnd, CA_CHIPS_HZ, CA_RATE_HZ, Component, Datatype, Fm, IqFile, RawIq};
pub use waveform::{Code, Constellation, Dechirp, DvbT, DvbTMode, Guard, Source, Sweep, Taper, Waveform};

/// The radar: every emission and every receive window of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Radar {
    /// Carrier frequency, Hz.
    pub carrier_hz: f64,
    /// Complex sample rate, Hz.
    pub sample_rate_hz: f64,
    /// What is radiated.
    pub waveform: Waveform,
    /// Dechirp on reception; `None` for none.
    pub dechirp: Option<Dechirp>,
    /// When pulses leave, relative to pulse 0; of continuous reception when its blocks begin.
    pub emissions: PulseTimes,
    /// Of continuous reception, when pulses leave. What is a pulse elsewhere then is a block of samples: one
    /// begins where the one before ends ([`PulseTimes::blocks`]), by [`Gate::Fixed`] at 0.
    pub sent: Option<PulseTimes>,
    /// Which polarisations leave together.
    pub tx_polarisation: TxPolarisation,
    /// When samples are taken.
    pub window: Window,
    /// Losses of the whole system, dB (positive = loss).
    pub losses_db: f64,
    /// One-way atmospheric attenuation, dB per kilometre.
    pub atmosphere_db_per_km: f64,
    /// Rain on all of every path, mm/h.
    pub rain_mmph: f64,
    /// Echo of its drops; `None` for none.
    pub rain_clutter: Option<RainClutter>,
    /// Receiver noise figure, dB; `None` for a noiseless receiver.
    pub noise_figure_db: Option<f64>,
    /// Analogue-to-digital converter; `None` for floating-point samples.
    pub adc: Option<Adc>,
    /// What is wrong between echo and converter.
    pub front_end: FrontEnd,
    /// Whether the direct path from transmitter to receiver is one of the scatterer paths.
    pub direct_path: bool,
    /// Transmitters.
    pub transmitters: Vec<Transmitter>,
    /// Receivers.
    pub receivers: Vec<Receiver>,
    /// What is recorded.
    pub channels: Vec<Channel>,
    /// What else radiates.
    pub emitters: Vec<Emitter>,
}

impl Radar {
    /// A radar without antennas and channels, for a start: noiseless, without a converter, no losses and no
    /// rain on the way, all polarisations together, no direct path.
    pub fn new(
        carrier_hz: f64,
        sample_rate_hz: f64,
        waveform: Waveform,
        emissions: PulseTimes,
        window: Window,
    ) -> Self {
        Self {
            carrier_hz,
            sample_rate_hz,
            waveform,
            dechirp: None,
            emissions,
            sent: None,
            tx_polarisation: TxPolarisation::Simultaneous,
            window,
            losses_db: 0.0,
            atmosphere_db_per_km: 0.0,
            rain_mmph: 0.0,
            rain_clutter: None,
            noise_figure_db: None,
            adc: None,
            front_end: FrontEnd::default(),
            direct_path: false,
            transmitters: Vec::new(),
            receivers: Vec::new(),
            channels: Vec::new(),
            emitters: Vec::new(),
        }
    }

    /// Carrier wavelength, metres.
    pub fn wavelength_m(&self) -> f64 {
        crate::units::SPEED_OF_LIGHT_MPS / self.carrier_hz
    }

    /// When pulses leave, be they received in windows or continuously.
    pub fn sends(&self) -> &PulseTimes {
        self.sent.as_ref().unwrap_or(&self.emissions)
    }

    /// Pulses after which polarisations and waveforms repeat.
    pub fn cycle(&self) -> u64 {
        let (ports, turns) = (self.tx_polarisation.cycle(), self.waveform.turns() as u64);
        let common = (1..=ports).rev().find(|n| ports.is_multiple_of(*n) && turns.is_multiple_of(*n));
        ports * turns / common.unwrap_or(1)
    }

    /// The transmitter-receiver pairs that the channels need, in order of first use. A scatterer path has one
    /// delay per pair.
    pub fn pairs(&self) -> Vec<Pair> {
        let mut pairs = Vec::new();
        for channel in &self.channels {
            let pair = Pair { transmitter: channel.transmitter, receiver: channel.receiver };
            if !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
        pairs
    }

    /// Where an antenna of that name sits, and what it looks like.
    pub fn antenna(&self, name: &str) -> Option<&AntennaMount> {
        let transmitters = self.transmitters.iter().map(|end| (&end.name, &end.antenna));
        let receivers = self.receivers.iter().map(|end| (&end.name, &end.antenna));
        transmitters.chain(receivers).find(|(known, _)| *known == name).map(|(_, antenna)| antenna)
    }

    /// Where the window of a receiver starts: its own gate, or that of all.
    pub fn gate(&self, receiver: usize) -> &Gate {
        self.receivers.get(receiver).and_then(|own| own.gate.as_ref()).unwrap_or(&self.window.gate)
    }

    /// The pair by whose ends the window of every receiver is found, receiver by receiver; a single one where
    /// all receive in the same window, none without channels.
    ///
    /// It is the first of [`Self::pairs`] with a receiver of the same gate on the same platform that hears a
    /// transmitter of the same platform first: antennas of one platform are sampled together. A receiver
    /// without channels has the window of the first pair.
    pub fn window_leads(&self) -> Vec<Pair> {
        let pairs = self.pairs();
        let Some(&first) = pairs.first() else { return Vec::new() };
        // First pair of each receiver, in the order of these.
        let (mut firsts, mut of_receivers) = (Vec::<Pair>::new(), vec![None; self.receivers.len()]);
        for pair in pairs {
            if let Some(own @ None) = of_receivers.get_mut(pair.receiver) {
                *own = Some(pair);
                firsts.push(pair);
            }
        }
        let lead = |own: Option<Pair>| {
            let like = own.and_then(|own| firsts.iter().find(|other| self.share_window(&own, other)));
            like.copied().unwrap_or(first)
        };
        let leads: Vec<Pair> = of_receivers.into_iter().map(lead).collect();
        if leads.iter().all(|lead| *lead == first) { vec![first] } else { leads }
    }

    /// Whether the receivers of two pairs receive in the same window, where it is found by these.
    fn share_window(&self, one: &Pair, other: &Pair) -> bool {
        let gates = [one, other].map(|pair| self.gate(pair.receiver));
        let platforms = [one, other].map(|pair| {
            let sends = self.transmitters.get(pair.transmitter).map(|end| end.antenna.platform);
            [sends, self.receivers.get(pair.receiver).map(|end| end.antenna.platform)]
        });
        let fixed = matches!(gates[0], Gate::Fixed { .. });
        gates[0] == gates[1] && (fixed || platforms[0] == platforms[1])
    }

    /// The window of a receiver among so many: its own, or that of all.
    pub fn window_of(receiver: usize, windows: usize) -> usize {
        if windows > 1 { receiver } else { 0 }
    }

    /// The sizes of a pulse of this radar in a scene with so many platforms and targets, without ships and
    /// clocks.
    pub fn layout(&self, platforms: usize, targets: usize) -> Layout {
        Layout {
            channels: self.channels.len(),
            samples: self.window.samples,
            format: if self.adc.is_some() { SampleFormat::Ci16 } else { SampleFormat::Cf32 },
            platforms,
            antennas: self.transmitters.len() + self.receivers.len(),
            targets,
            pairs: self.pairs().len(),
            windows: match self.window_leads().len() {
                0 | 1 => 0,
                own => own,
            },
            ships: 0,
            clocks: 0,
        }
    }
}

/// Rain that returns an echo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RainClutter {
    /// Height of its top above the sea, m.
    pub top_m: f64,
    /// Rms velocity of drops about their mean, of each component, m/s.
    pub spread_mps: f64,
}

/// A transmitter and a receiver, by their places in [`Radar`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Index of the transmitter.
    pub transmitter: usize,
    /// Index of the receiver.
    pub receiver: usize,
}

/// Polarisation of an antenna port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Polarisation {
    /// Along the first vector of the antenna's basis: horizontal, or +y of the aperture
    /// ([`PolarisationBasis`]).
    H,
    /// Along the second: upward, or +z of the aperture.
    V,
    /// Right-hand circular, `(H - j V)/sqrt 2`.
    R,
    /// Left-hand circular, `(H + j V)/sqrt 2`.
    L,
}

impl Polarisation {
    /// How many there are.
    pub const COUNT: usize = 4;

    /// The letter used in channel names.
    pub fn letter(self) -> char {
        match self {
            Self::H => 'H',
            Self::V => 'V',
            Self::R => 'R',
            Self::L => 'L',
        }
    }

    /// From the letter used in channel names.
    pub fn from_letter(letter: char) -> Option<Self> {
        match letter {
            'H' => Some(Self::H),
            'V' => Some(Self::V),
            'R' => Some(Self::R),
            'L' => Some(Self::L),
            _ => None,
        }
    }

    /// The code of `/pulse/tx_pol`.
    pub fn code(self) -> u8 {
        match self {
            Self::H => 1,
            Self::V => 2,
            Self::R => 3,
            Self::L => 4,
        }
    }
}

/// Which polarisations leave together.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TxPolarisation {
    /// Every pulse leaves in all polarisations that the channels need (ideally separable).
    Simultaneous,
    /// Pulse `n` leaves in polarisation `sequence[n % len]` only.
    Alternating(Vec<Polarisation>),
}

impl TxPolarisation {
    /// The only polarisation of pulse `n`, or `None` when all leave together.
    pub fn of_pulse(&self, n: u64) -> Option<Polarisation> {
        match self {
            Self::Simultaneous => None,
            Self::Alternating(sequence) => Some(sequence[(n % sequence.len() as u64) as usize]),
        }
    }

    /// Pulses after which polarisations repeat.
    pub fn cycle(&self) -> u64 {
        match self {
            Self::Simultaneous => 1,
            Self::Alternating(sequence) => sequence.len().max(1) as u64,
        }
    }

    /// The group of channels that a polarisation of [`Self::of_pulse`] fills: a channel is filled by pulses
    /// of the group of its own transmit polarisation alone. All are of group 0 where all leave together.
    pub fn group(&self, port: Option<Polarisation>) -> u8 {
        match (self, port) {
            (Self::Alternating(sequence), Some(port)) if sequence.contains(&port) => port.code(),
            (Self::Alternating(_), _) => u8::MAX,
            (Self::Simultaneous, _) => 0,
        }
    }

    /// Share of the pulses that fill channels of a transmit polarisation.
    pub fn share(&self, port: Polarisation) -> f64 {
        match self {
            Self::Simultaneous => 1.0,
            Self::Alternating(sequence) => {
                sequence.iter().filter(|own| **own == port).count() as f64 / sequence.len().max(1) as f64
            }
        }
    }
}

/// The receive window of every pulse.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Complex samples, of every receiver.
    pub samples: usize,
    /// Where it starts, unless a receiver has a gate of its own.
    pub gate: Gate,
}

/// Where a receive window starts.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Gate {
    /// A fixed time after the emission, s.
    Fixed {
        /// Start after emission, s.
        start_s: f64,
    },
    /// `lead_s` before the echo from the aim point would begin, computed from the reported (or true) tracks
    /// of the receiver and of the first transmitter that it hears ([`Radar::window_leads`]).
    Follow {
        /// The ground point.
        aim: Aim,
        /// How much earlier the window opens, s.
        lead_s: f64,
        /// Which tracks steer the opening of the receive window.
        aim_from: AimFrom,
    },
}

/// A transmitter: one antenna on a platform, all polarisations.
#[derive(Clone, Debug, PartialEq)]
pub struct Transmitter {
    /// Name, unique among antennas.
    pub name: String,
    /// Peak power per polarisation, W.
    pub power_w: f64,
    /// Its antenna.
    pub antenna: AntennaMount,
}

/// An emitter beside the transmitters of a radar. Whatever receivers take of it is added to their channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Emitter {
    /// Name, power of its one polarisation, antenna.
    pub transmitter: Transmitter,
    /// Carrier frequency, Hz.
    pub carrier_hz: f64,
    /// What it radiates.
    pub waveform: Waveform,
    /// When its pulses leave, before or after pulse 0 of the radar, until the last window closes.
    pub emissions: PulseTimes,
    /// Polarisation of all of them.
    pub polarisation: Polarisation,
    /// Receivers that take it, by their places in [`Radar`].
    pub receivers: Vec<usize>,
    /// Whether the direct path is received.
    pub direct_path: bool,
    /// Whether sea, ships and targets return it.
    pub echo: bool,
}

/// A receiver: one antenna on a platform, all polarisations.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiver {
    /// Name, unique among antennas.
    pub name: String,
    /// Its antenna.
    pub antenna: AntennaMount,
    /// Where its window starts; `None`: as [`Radar::window`] says.
    pub gate: Option<Gate>,
}

/// An antenna: where it sits, what it looks like, where it points.
#[derive(Clone, Debug, PartialEq)]
pub struct AntennaMount {
    /// Index of the platform that carries it.
    pub platform: usize,
    /// Phase centre in the body frame (forward, starboard, down), m.
    pub lever_arm: Vector<Body>,
    /// From the middle of an array to this element of it, body frame, m: all elements aim from the middle, so
    /// that they stay parallel. Zero of a single antenna.
    pub of_array: Vector<Body>,
    /// Gain pattern.
    pub pattern: Pattern,
    /// Where it points.
    pub pointing: Pointing,
    /// What is wrong with its ports.
    pub ports: PortErrors,
}

/// What is wrong with the ports of an antenna, alike in all directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PortErrors {
    /// Leakage of the orthogonal port, dB below the wanted one; `None` for ideal ports.
    pub isolation_db: Option<f64>,
    /// Gain of the signal before the receiver's noise, dB.
    pub gain_db: f64,
    /// Its phase, rad.
    pub phase_rad: f64,
}

/// A gain pattern.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Pattern {
    /// Equal gain everywhere.
    Isotropic {
        /// Gain, dBi.
        gain_dbi: f64,
    },
    /// Uniformly illuminated rectangle: width along +y, height along +z.
    Rectangle {
        /// Width a, m.
        width_m: f64,
        /// Height b, m.
        height_m: f64,
    },
    /// Rectangle whose illumination falls towards the edges.
    Tapered {
        /// Width a, m.
        width_m: f64,
        /// Height b, m.
        height_m: f64,
        /// Along the width, along the height.
        tapers: [ApertureTaper; 2],
    },
    /// Uniformly illuminated ellipse with the given full axes (a circle when they are equal).
    Ellipse {
        /// Width a, m.
        width_m: f64,
        /// Height b, m.
        height_m: f64,
    },
    /// Measured pattern from a CSV file (`az_deg,el_deg,gain_dbi[,phase_deg]` on a regular grid).
    File {
        /// The file.
        path: PathBuf,
        /// Gain outside the grid, dBi.
        floor_dbi: f64,
    },
}

/// How the illumination of an aperture falls from its middle to its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ApertureTaper {
    /// Not at all.
    Uniform,
    /// As a cosine, to nothing.
    Cosine,
    /// As a raised cosine, to 0.08 of the middle.
    Hamming,
    /// So that all side lobes near the beam are alike.
    Taylor {
        /// These, dB below the peak.
        sidelobe_db: f64,
    },
}

/// How the ports H and V of an antenna lie across a ray; `docs/polarisation.md` draws both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PolarisationBasis {
    /// H is horizontal at the phase centre, V completes it: an isotropic antenna, whatever its pointing.
    LocalHorizontal,
    /// Ludwig's third definition about the boresight: apertures and measured patterns.
    Ludwig3,
}

impl PolarisationBasis {
    /// That of an antenna with a pattern.
    pub fn of(pattern: &Pattern) -> Self {
        match pattern {
            Pattern::Isotropic { .. } => Self::LocalHorizontal,
            Pattern::Rectangle { .. }
            | Pattern::Tapered { .. }
            | Pattern::Ellipse { .. }
            | Pattern::File { .. } => Self::Ludwig3,
        }
    }

    /// The name in recordings and on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::LocalHorizontal => "local-horizontal",
            Self::Ludwig3 => "ludwig-3",
        }
    }
}

/// Analogue-to-digital converter, mid-rise, I and Q separately, saturating.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adc {
    /// Bits, 1 to 16.
    pub bits: u32,
    /// Amplitude of full scale, sqrt(W).
    pub full_scale: f64,
}

impl Adc {
    /// Width of one code, sqrt(W): `2 A_fs / 2^bits`.
    pub fn step(&self) -> f64 {
        2.0 * self.full_scale / f64::from(1u32 << self.bits)
    }
}

/// What is recorded: one row of `/channel`.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name: receive then transmit polarisation (`HV`), with antenna names where there are several.
    pub name: String,
    /// Index of the transmitter.
    pub transmitter: usize,
    /// Index of the receiver.
    pub receiver: usize,
    /// Transmit polarisation.
    pub tx: Polarisation,
    /// Receive polarisation.
    pub rx: Polarisation,
}
