//! What a pulse is modulated by, as described.

use std::path::PathBuf;

use super::band::Band;
use super::signals::{CA_CHIPS_HZ, CA_RATE_HZ, Fm, IqFile};

/// The transmitted baseband pulse, unit amplitude.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Waveform {
    /// Linear frequency modulation, `exp(j pi mu (t - Tc/2)^2)`, `mu = +-B/Tc`.
    Lfm {
        /// Swept bandwidth B, Hz.
        bandwidth_hz: f64,
        /// Pulse length Tc, s.
        duration_s: f64,
        /// Direction of the sweep.
        sweep: Sweep,
    },
    /// Linear frequency modulation up in the first half of the pulse and down in the second.
    Triangular {
        /// Swept bandwidth B, Hz.
        bandwidth_hz: f64,
        /// Length of both, s.
        duration_s: f64,
    },
    /// Frequency modulation whose power spectrum is a taper.
    Nlfm {
        /// Swept bandwidth B, Hz.
        bandwidth_hz: f64,
        /// Pulse length Tc, s.
        duration_s: f64,
        /// Direction of the sweep.
        sweep: Sweep,
        /// The taper.
        taper: Taper,
    },
    /// A rectangular pulse of the carrier.
    Cw {
        /// Pulse length Tc, s.
        duration_s: f64,
    },
    /// Chips of equal length, each of one phase.
    PhaseCode {
        /// The code.
        code: Code,
        /// Length of a chip, s.
        chip_s: f64,
    },
    /// Complex baseband samples from a file (CSV `re,im`), at `rate_hz`.
    Samples {
        /// The file.
        path: PathBuf,
        /// Rate of the samples, Hz.
        rate_hz: f64,
    },
    /// A pulse whose amplitude falls linearly.
    Drooping {
        /// The pulse without it; never one of these.
        of: Box<Waveform>,
        /// How far its end lies below its begin, dB.
        droop_db: f64,
    },
    /// A pulse whose carrier is another.
    Offset {
        /// The pulse; neither an offset one nor a continuous signal.
        of: Box<Waveform>,
        /// Its carrier less that of the radar, Hz.
        offset_hz: f64,
    },
    /// Emission `k` radiates number `k` of these, modulo how many they are.
    InTurn {
        /// Two and more pulses; none of them in turn or continuous.
        of: Vec<Waveform>,
        /// Whether they are the steps of `kind = "stepped"`.
        stepped: bool,
    },
    /// A continuous signal, of which every emission radiates the next segment.
    Stream {
        /// The signal.
        source: Source,
        /// Interval of the emissions, s.
        interval_s: f64,
    },
}

/// A continuous signal of mean power 1.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Source {
    /// White complex Gaussian noise.
    Noise {
        /// Bandwidth, between points of a quarter of the power density, Hz.
        bandwidth_hz: f64,
        /// What it is drawn by.
        seed: u64,
    },
    /// Terrestrial television.
    DvbT {
        /// Its parameters.
        of: DvbT,
        /// What its data are drawn by.
        seed: u64,
    },
    /// FM broadcast.
    Fm {
        /// Its parameters.
        of: Fm,
        /// What its programme is drawn by.
        seed: u64,
    },
    /// The coarse code of a GPS satellite.
    GpsCa {
        /// Number of the code, 1 to 32.
        prn: u8,
        /// What its data are drawn by.
        seed: u64,
    },
    /// A recording.
    IqFile(IqFile),
}

/// Parameters of a DVB-T signal (EN 300 744).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DvbT {
    /// Width of the channel, Hz: 6, 7 or 8 MHz.
    pub channel_hz: f64,
    /// Carriers.
    pub mode: DvbTMode,
    /// Guard interval.
    pub guard: Guard,
    /// Of the data.
    pub constellation: Constellation,
}

/// Carriers of a DVB-T signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DvbTMode {
    /// 1705 carriers.
    K2,
    /// 6817 carriers.
    K8,
}

/// Guard interval over the rest of a symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Guard {
    /// 1/32.
    Thirtysecond,
    /// 1/16.
    Sixteenth,
    /// 1/8.
    Eighth,
    /// 1/4.
    Quarter,
}

/// Points of a data carrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Constellation {
    /// 4.
    Qpsk,
    /// 16.
    Qam16,
    /// 64.
    Qam64,
}

impl Guard {
    /// Its number in the signalling.
    pub fn number(self) -> u32 {
        match self {
            Self::Thirtysecond => 0,
            Self::Sixteenth => 1,
            Self::Eighth => 2,
            Self::Quarter => 3,
        }
    }
}

impl Constellation {
    /// Its number in the signalling.
    pub fn number(self) -> u32 {
        match self {
            Self::Qpsk => 0,
            Self::Qam16 => 1,
            Self::Qam64 => 2,
        }
    }

    /// Levels of each part of a point.
    pub fn levels(self) -> u32 {
        2 << self.number()
    }
}

impl DvbT {
    /// Samples a second.
    pub fn rate_hz(&self) -> f64 {
        self.channel_hz * 8.0 / 7.0
    }

    /// Samples of a symbol without its guard.
    pub fn samples(&self) -> usize {
        match self.mode {
            DvbTMode::K2 => 2048,
            DvbTMode::K8 => 8192,
        }
    }

    /// Samples of the guard.
    pub fn guard_samples(&self) -> usize {
        self.samples() >> (5 - self.guard.number())
    }

    /// Carriers.
    pub fn carriers(&self) -> usize {
        match self.mode {
            DvbTMode::K2 => 1705,
            DvbTMode::K8 => 6817,
        }
    }

    /// From below the lowest carrier to above the highest, Hz.
    pub fn occupied_hz(&self) -> f64 {
        self.rate_hz() * self.carriers() as f64 / self.samples() as f64
    }
}

impl Source {
    /// What scenarios call it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Noise { .. } => "noise",
            Self::DvbT { .. } => "dvb-t",
            Self::Fm { .. } => "fm",
            Self::GpsCa { .. } => "gps-l1-ca",
            Self::IqFile(_) => "iq-file",
        }
    }

    /// Samples a second; `None` where a file says so.
    pub fn rate_hz(&self) -> Option<f64> {
        match self {
            Self::Noise { bandwidth_hz, .. } => Some(*bandwidth_hz),
            Self::DvbT { of, .. } => Some(of.rate_hz()),
            Self::Fm { of, .. } => Some(of.rate_hz()),
            Self::GpsCa { .. } => Some(CA_RATE_HZ),
            Self::IqFile(file) => file.raw.map(|raw| raw.rate_hz),
        }
    }

    /// Occupied bandwidth, Hz; `None` where a file has it.
    pub fn bandwidth_hz(&self) -> Option<f64> {
        match self {
            Self::Noise { bandwidth_hz, .. } => Some(*bandwidth_hz),
            Self::DvbT { of, .. } => Some(of.occupied_hz()),
            Self::Fm { of, .. } => Some(of.occupied_hz()),
            Self::GpsCa { .. } => Some(CA_CHIPS_HZ),
            Self::IqFile(_) => None,
        }
    }
}

impl Waveform {
    /// Length of the pulse, s, of pulses in turn the longest; `None` where a file has it, and of a continuous
    /// signal. Files among pulses in turn are left out.
    pub fn duration_s(&self) -> Option<f64> {
        match self {
            Self::Lfm { duration_s, .. }
            | Self::Triangular { duration_s, .. }
            | Self::Nlfm { duration_s, .. }
            | Self::Cw { duration_s } => Some(*duration_s),
            Self::PhaseCode { code, chip_s } => Some(code.chips() as f64 * chip_s),
            Self::Drooping { of, .. } | Self::Offset { of, .. } => of.duration_s(),
            Self::InTurn { of, .. } => of.iter().filter_map(Self::duration_s).reduce(f64::max),
            Self::Samples { .. } | Self::Stream { .. } => None,
        }
    }

    /// The band about the carrier; `None` where a file has it. Files among pulses in turn are left out.
    pub fn band(&self) -> Option<Band> {
        match self {
            Self::Offset { of, offset_hz } => of.band().map(|band| band.shifted(*offset_hz)),
            Self::InTurn { of, .. } => of.iter().filter_map(Self::band).reduce(Band::with),
            other => other.bandwidth_hz().map(|hz| Band::about(0.0, hz)),
        }
    }

    /// How far above that of the radar the carrier is, Hz.
    pub fn offset_hz(&self) -> f64 {
        if let Self::Offset { offset_hz, .. } = self { *offset_hz } else { 0.0 }
    }

    /// Bandwidth, Hz: swept, `1/Tc` of a plain pulse, one over a chip of a code, of pulses in turn from the
    /// lower end of all bands to the upper; `None` where a file has it.
    pub fn bandwidth_hz(&self) -> Option<f64> {
        match self {
            Self::Lfm { bandwidth_hz, .. }
            | Self::Triangular { bandwidth_hz, .. }
            | Self::Nlfm { bandwidth_hz, .. } => Some(*bandwidth_hz),
            Self::Cw { duration_s } => Some(duration_s.recip()),
            Self::PhaseCode { chip_s, .. } => Some(chip_s.recip()),
            Self::Drooping { of, .. } | Self::Offset { of, .. } => of.bandwidth_hz(),
            Self::InTurn { .. } => self.band().map(Band::width_hz),
            Self::Stream { source, .. } => source.bandwidth_hz(),
            Self::Samples { .. } => None,
        }
    }

    /// How fast the frequency of a linear sweep changes, Hz/s, up or down; `None` of all others.
    pub fn steepness_hz_per_s(&self) -> Option<f64> {
        match self {
            Self::Lfm { bandwidth_hz, duration_s, .. } => Some(bandwidth_hz / duration_s),
            Self::Triangular { bandwidth_hz, duration_s } => Some(2.0 * bandwidth_hz / duration_s),
            Self::Drooping { of, .. } => of.steepness_hz_per_s(),
            _ => None,
        }
    }

    /// The pulses in turn; of all others itself.
    pub fn pulses(&self) -> &[Self] {
        if let Self::InTurn { of, .. } = self { of } else { std::slice::from_ref(self) }
    }

    /// How many pulses there are in turn; 1 of all others.
    pub fn turns(&self) -> usize {
        self.pulses().len()
    }

    /// The pulse without droop, wherever its carrier is.
    pub fn level(&self) -> &Self {
        match self {
            Self::Drooping { of, .. } | Self::Offset { of, .. } => of.level(),
            other => other,
        }
    }

    /// The kind as recordings and streams name it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Lfm { .. } => "lfm",
            Self::Triangular { .. } => "triangular",
            Self::Nlfm { .. } => "nlfm",
            Self::Cw { .. } => "cw",
            Self::PhaseCode { .. } => "phase-code",
            Self::Drooping { of, .. } | Self::Offset { of, .. } => of.kind(),
            Self::InTurn { stepped, .. } => {
                if *stepped {
                    "stepped"
                } else {
                    "in-turn"
                }
            }
            Self::Samples { .. } => "samples",
            Self::Stream { source, .. } => source.name(),
        }
    }
}

/// What is received is multiplied by the conjugate of the waveform, so much later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dechirp {
    /// Delay of the reference after the emission, s.
    pub delay_s: f64,
}

/// Direction of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Sweep {
    /// Frequency rises.
    Up,
    /// Frequency falls.
    Down,
}

/// The power spectrum of a nonlinear sweep over its band.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Taper {
    /// `0.54 + 0.46 cos(2 pi f/B)`.
    Hamming,
    /// Taylor's, of the least order for which it falls from the middle to the edges.
    Taylor {
        /// Side lobes below the peak of the compressed pulse, dB.
        sidelobe_db: f64,
    },
}

/// A phase code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Code {
    /// Two phases, all side lobes of one chip.
    Barker {
        /// 2, 3, 4, 5, 7, 11 or 13.
        chips: usize,
    },
    /// `M` groups of `M` chips, each group a step of frequency higher.
    Frank {
        /// `M`, 2 or more.
        phases: usize,
    },
    /// Phases of a linear sweep from the carrier on.
    P3 {
        /// 2 or more.
        chips: usize,
    },
    /// Phases of a linear sweep about the carrier.
    P4 {
        /// 2 or more.
        chips: usize,
    },
    /// Two phases, by a shift register of greatest period.
    MSequence {
        /// Stages of the register, 2 to 16.
        register: u32,
    },
    /// Two phases, one of a pair whose autocorrelations add up to that of a single chip.
    Golay {
        /// A power of two, 2 or more.
        chips: usize,
        /// Whether it is the second of the pair.
        second: bool,
    },
}

impl Code {
    /// Chips that a code may have at most.
    pub const MOST_CHIPS: usize = 1 << 16;

    /// How many chips it has.
    pub fn chips(&self) -> usize {
        match self {
            Self::Barker { chips } | Self::P3 { chips } | Self::P4 { chips } | Self::Golay { chips, .. } => {
                *chips
            }
            Self::Frank { phases } => phases.saturating_mul(*phases),
            Self::MSequence { register } => {
                1usize.checked_shl(*register).map_or(usize::MAX, |n| n.wrapping_sub(1))
            }
        }
    }

    /// What scenarios call it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Barker { .. } => "barker",
            Self::Frank { .. } => "frank",
            Self::P3 { .. } => "p3",
            Self::P4 { .. } => "p4",
            Self::MSequence { .. } => "m-sequence",
            Self::Golay { second: false, .. } => "golay-a",
            Self::Golay { second: true, .. } => "golay-b",
        }
    }
}
