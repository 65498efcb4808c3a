//! One pulse under way, from synthesis to sink.
//!
//! A [`Pulse`] is a slot: allocated once, with the sizes of a [`Layout`], and then only overwritten. What
//! making pulses costs is counted in [`costs`], what a converter is fed with in [`converter`]; what was
//! changed while a run went on is in [`log`].

#[doc(hidden)]
pub mod converter;
#[doc(hidden)]
pub mod costs;
#[doc(hidden)]
pub mod gathered;
pub mod log;

use std::time::Instant;

use num_complex::Complex32;

use crate::time::TimeTag;

/// Bits of [`Pulse::flags`] (`/pulse/flags` of a recording).
pub mod flags {
    /// Released more than one PRI after its deadline (or after a slip of the schedule).
    pub const LATE: u32 = 1;
    /// At least one pulse before this one was dropped.
    pub const AFTER_GAP: u32 = 1 << 1;
    /// At least one sample of the pulse saturated the ADC.
    pub const ADC_SATURATED: u32 = 1 << 2;
    /// At least one scatterer path's echo fell partly or wholly outside the receive window.
    pub const OUTSIDE_WINDOW: u32 = 1 << 3;
    /// The true motion of a platform rests on navigation that had to be extrapolated.
    pub const NAV_EXTRAPOLATED: u32 = 1 << 4;
    /// The true motion of a platform rests on navigation older than may be extrapolated.
    pub const NAV_STALE: u32 = 1 << 5;
    /// A platform reported nothing new: its report is held or extrapolated over a dropout.
    pub const REPORT_DROPOUT: u32 = 1 << 6;
    /// Bits of the error class of the pulse: 0 as `fidelity.error_db` asks, `n` as the `n`-th of the errors
    /// to which policy `relax` goes.
    pub const ERROR_CLASS: u32 = MOST_CLASS << CLASS_AT;
    /// The coarsest class that there is room for.
    pub const MOST_CLASS: u32 = 7;
    const CLASS_AT: u32 = 8;

    /// The error class of a pulse with these flags.
    pub const fn error_class(flags: u32) -> usize {
        ((flags & ERROR_CLASS) >> CLASS_AT) as usize
    }

    /// The bits of an error class, [`MOST_CLASS`] at most.
    pub const fn of_error_class(class: usize) -> u32 {
        (class as u32) << CLASS_AT & ERROR_CLASS
    }
}

/// Sizes of every field of a pulse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// Channels recorded.
    pub channels: usize,
    /// Complex samples per channel.
    pub samples: usize,
    /// How a sample is held.
    pub format: SampleFormat,
    /// Platforms in the navigation record.
    pub platforms: usize,
    /// Antennas: transmitters first, then receivers.
    pub antennas: usize,
    /// Targets in the truth record.
    pub targets: usize,
    /// Transmitter-receiver pairs in the truth record.
    pub pairs: usize,
    /// Receivers with windows of their own; 0 where all receive in the same.
    pub windows: usize,
    /// Ships in the truth record.
    pub ships: usize,
    /// Clocks in the truth record.
    pub clocks: usize,
}

/// How a complex sample is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SampleFormat {
    /// Two f32, sqrt(W).
    #[default]
    Cf32,
    /// Two i16, ADC codes.
    Ci16,
}

/// The samples of a pulse, `[channel][sample]` flattened.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// sqrt(W) at the receiver input.
    Cf32(Vec<Complex32>),
    /// ADC codes, in-phase then quadrature.
    Ci16(Vec<[i16; 2]>),
}

impl Samples {
    /// The samples as bytes in native order.
    pub fn as_bytes(&self) -> &[u8] {
        match self {
            Self::Cf32(v) => bytemuck::cast_slice(v),
            Self::Ci16(v) => bytemuck::cast_slice(v),
        }
    }
}

/// Where a platform is, or reports to be, at the emission of a pulse (ENU of the scene's origin).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlatformRecord {
    /// Position, metres.
    pub position_m: [f64; 3],
    /// Velocity, m/s.
    pub velocity_mps: [f64; 3],
    /// Body (FRD) to ENU, Hamilton, scalar first.
    pub attitude_quat: [f64; 4],
    /// Emission minus the epoch of the navigation that this rests on, s.
    pub age_s: f64,
    /// The bits of [`flags`] that concern this platform.
    pub flags: u32,
}

impl Default for PlatformRecord {
    fn default() -> Self {
        Self {
            position_m: [0.0; 3],
            velocity_mps: [0.0; 3],
            attitude_quat: [1.0, 0.0, 0.0, 0.0],
            age_s: 0.0,
            flags: 0,
        }
    }
}

/// Where an antenna is and looks at the emission of a pulse (ENU of the scene's origin).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntennaRecord {
    /// True phase centre, metres.
    pub phase_centre_m: [f64; 3],
    /// True axes (x the boresight, z the antenna's up) to ENU, Hamilton, scalar first.
    pub boresight_quat: [f64; 4],
    /// Phase centre by reported position and attitude of the platform and the lever arm as designed, metres.
    pub reported_phase_centre_m: [f64; 3],
    /// Azimuth and elevation that the encoder of its pedestal reads, degrees; `None` where it does not scan.
    pub encoder_deg: Option<[f64; 2]>,
}

impl Default for AntennaRecord {
    fn default() -> Self {
        Self {
            phase_centre_m: [0.0; 3],
            boresight_quat: [1.0, 0.0, 0.0, 0.0],
            reported_phase_centre_m: [0.0; 3],
            encoder_deg: None,
        }
    }
}

/// One pulse: what every sink receives.
#[derive(Clone, Debug, PartialEq)]
pub struct Pulse {
    /// Number of the pulse, from 0 at the start of the run.
    pub index: u64,
    /// Exact emission time, UTC.
    pub time: TimeTag,
    /// First sample after the emission, seconds (not on any sample grid): of all receivers, or of that of
    /// the first channel.
    pub window_start_s: f64,
    /// The same of every receiver; empty where all have the same.
    pub receiver_window_start_s: Vec<f64>,
    /// See [`flags`].
    pub flags: u32,
    /// What was radiated: 0 all ports at once, 1 H, 2 V, 3 right, 4 left circular.
    pub tx_pol: u8,
    /// IQ, `[channel][sample]`.
    pub samples: Samples,
    /// True state per platform.
    pub nav_true: Vec<PlatformRecord>,
    /// Reported state per platform.
    pub nav_reported: Vec<PlatformRecord>,
    /// Antennas: transmitters, then receivers.
    pub antennas: Vec<AntennaRecord>,
    /// Truth: `[pair][target]` delay, seconds (NaN if the target has no such echo).
    pub target_delay_s: Vec<f64>,
    /// Truth: `[pair][target]` Doppler, Hz, positive when closing.
    pub target_doppler_hz: Vec<f64>,
    /// Truth: midship at the waterline of each ship at the emission, ENU metres.
    pub ship_position_m: Vec<[f64; 3]>,
    /// Truth: velocity of each ship, ENU m/s.
    pub ship_velocity_mps: Vec<[f64; 3]>,
    /// Truth: heading of each ship, clockwise from the North of the scene, 0 to 360 degrees.
    pub ship_heading_deg: Vec<f64>,
    /// Truth: reading less time of each clock at the emission, s.
    pub clock_x_s: Vec<f64>,
    /// When the last fix of live navigation up to the emission had come (of several platforms the earliest).
    pub nav_arrived: Option<Instant>,
}

impl Pulse {
    /// An empty slot.
    pub fn new(layout: &Layout) -> Self {
        let mut pulse = Self::reserved(layout);
        pulse.fit(layout);
        pulse
    }

    /// Gives a [reserved](Self::reserved) slot its samples, zero. It does not allocate, and does nothing to a
    /// slot that has them.
    pub fn fit(&mut self, layout: &Layout) {
        let len = layout.channels * layout.samples;
        match &mut self.samples {
            Samples::Cf32(samples) if samples.len() != len => samples.resize(len, Complex32::ZERO),
            Samples::Ci16(samples) if samples.len() != len => samples.resize(len, [0; 2]),
            Samples::Cf32(_) | Samples::Ci16(_) => {}
        }
    }

    /// A slot whose samples have an address but no memory yet: the system gives that when they are first
    /// written, by [`fit`](Self::fit).
    pub fn reserved(layout: &Layout) -> Self {
        let len = layout.channels * layout.samples;
        Self {
            index: 0,
            time: TimeTag::default(),
            window_start_s: 0.0,
            receiver_window_start_s: vec![0.0; layout.windows],
            flags: 0,
            tx_pol: 0,
            samples: match layout.format {
                SampleFormat::Cf32 => Samples::Cf32(Vec::with_capacity(len)),
                SampleFormat::Ci16 => Samples::Ci16(Vec::with_capacity(len)),
            },
            nav_true: vec![PlatformRecord::default(); layout.platforms],
            nav_reported: vec![PlatformRecord::default(); layout.platforms],
            antennas: vec![AntennaRecord::default(); layout.antennas],
            target_delay_s: vec![0.0; layout.targets * layout.pairs],
            target_doppler_hz: vec![0.0; layout.targets * layout.pairs],
            ship_position_m: vec![[0.0; 3]; layout.ships],
            ship_velocity_mps: vec![[0.0; 3]; layout.ships],
            ship_heading_deg: vec![0.0; layout.ships],
            clock_x_s: vec![0.0; layout.clocks],
            nav_arrived: None,
        }
    }

    /// Start of the window of a receiver after the emission, s.
    pub fn window_start_of(&self, receiver: usize) -> f64 {
        self.receiver_window_start_s.get(receiver).copied().unwrap_or(self.window_start_s)
    }

    /// Starts of all windows after the emission, s: one for all receivers, or one for each.
    pub fn window_starts_s(&self) -> &[f64] {
        match self.receiver_window_start_s.as_slice() {
            [] => std::slice::from_ref(&self.window_start_s),
            each => each,
        }
    }

    /// Overwrites this slot with another of the same layout, without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.index = other.index;
        self.time = other.time;
        self.window_start_s = other.window_start_s;
        self.receiver_window_start_s.clone_from(&other.receiver_window_start_s);
        self.flags = other.flags;
        self.tx_pol = other.tx_pol;
        match (&mut self.samples, &other.samples) {
            (Samples::Cf32(to), Samples::Cf32(from)) => to.clone_from(from),
            (Samples::Ci16(to), Samples::Ci16(from)) => to.clone_from(from),
            (to, from) => to.clone_from(from),
        }
        self.nav_true.clone_from(&other.nav_true);
        self.nav_reported.clone_from(&other.nav_reported);
        self.antennas.clone_from(&other.antennas);
        self.target_delay_s.clone_from(&other.target_delay_s);
        self.target_doppler_hz.clone_from(&other.target_doppler_hz);
        self.ship_position_m.clone_from(&other.ship_position_m);
        self.ship_velocity_mps.clone_from(&other.ship_velocity_mps);
        self.ship_heading_deg.clone_from(&other.ship_heading_deg);
        self.clock_x_s.clone_from(&other.clock_x_s);
        self.nav_arrived = other.nav_arrived;
    }
}

impl Layout {
    /// Bytes one slot takes.
    pub fn slot_bytes(&self) -> usize {
        let sample = match self.format {
            SampleFormat::Cf32 => 8,
            SampleFormat::Ci16 => 4,
        };
        std::mem::size_of::<Pulse>()
            + self.channels * self.samples * sample
            + 2 * self.platforms * std::mem::size_of::<PlatformRecord>()
            + self.antennas * std::mem::size_of::<AntennaRecord>()
            + 16 * self.targets * self.pairs
            + 8 * self.windows
            + 56 * self.ships
            + 8 * self.clocks
    }
}
