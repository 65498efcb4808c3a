//! What lies in shared memory for a pulse: the header, the reported states, the samples.
//!
//! Both are `repr(C)`, in the byte order of the machine; `docs/formats.md` has every byte.

use iceoryx2::prelude::ZeroCopySend;

use crate::pulse::{PlatformRecord, Pulse, SampleFormat};
use crate::recording::header::Header;

/// Words of 8 bytes that the state of a platform takes.
pub const STATE_WORDS: usize = 12;

/// What is known of a pulse, apart from its samples. 80 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("NereusPulse")]
#[repr(C)]
pub struct PulseHeader {
    /// Version of this layout.
    pub version: u32,
    /// Bits of [`crate::pulse::flags`].
    pub flags: u32,
    /// How many were published before this one in this run.
    pub sequence: u64,
    /// Number of the pulse.
    pub index: u64,
    /// Emission, whole nanoseconds since 1970, UTC.
    pub time_ns: i64,
    /// The rest of it, ns.
    pub time_frac_ns: f64,
    /// First sample after the emission, s: of all channels, or of the first.
    pub window_start_s: f64,
    /// sqrt(W) a code: sample = (code + 1/2) step; 1 where samples are not codes.
    pub adc_step: f64,
    /// Number of the run: key `source` of its description.
    pub source: u64,
    /// Channels.
    pub channels: u32,
    /// Complex samples a channel.
    pub samples: u32,
    /// Platforms.
    pub platforms: u32,
    /// 0: two f32 a sample; 1: two i16.
    pub sample_format: u8,
    /// What was radiated, see [`Pulse::tx_pol`].
    pub tx_pol: u8,
    /// 1: the run has ended, `sequence` pulses were published; there are no samples.
    pub end: u8,
    /// Receivers whose windows follow the samples; 0 where all have the same.
    pub windows: u8,
}

impl PulseHeader {
    /// What all pulses of a run have in common.
    pub(super) fn of_run(header: &Header, source: u64) -> Self {
        let size = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        Self {
            version: header.version(),
            windows: u8::try_from(header.layout.windows).unwrap_or(u8::MAX),
            adc_step: header.adc.map_or(1.0, |adc| adc.step),
            source,
            channels: size(header.layout.channels),
            samples: size(header.layout.samples),
            platforms: size(header.layout.platforms),
            sample_format: match header.layout.format {
                SampleFormat::Cf32 => 0,
                SampleFormat::Ci16 => 1,
            },
            ..Self::default()
        }
    }

    /// The same with what a pulse has of its own.
    pub(super) fn of_pulse(self, pulse: &Pulse, sequence: u64) -> Self {
        let (time_ns, time_frac_ns) = pulse.time.to_unix_ns();
        Self {
            flags: pulse.flags,
            sequence,
            index: pulse.index,
            time_ns,
            time_frac_ns,
            window_start_s: pulse.window_start_s,
            tx_pol: pulse.tx_pol,
            ..self
        }
    }

    /// How samples are held.
    pub fn format(&self) -> Option<SampleFormat> {
        match self.sample_format {
            0 => Some(SampleFormat::Cf32),
            1 => Some(SampleFormat::Ci16),
            _ => None,
        }
    }

    /// Words of 8 bytes behind this header: states, then samples, then starts of windows.
    pub fn words(&self) -> Option<usize> {
        if self.end != 0 {
            return Some(0);
        }
        let bytes = match self.format()? {
            SampleFormat::Cf32 => 8,
            SampleFormat::Ci16 => 4,
        };
        let samples = (self.channels as usize).checked_mul(self.samples as usize)?.checked_mul(bytes)?;
        let behind = samples.div_ceil(8).checked_add(usize::from(self.windows))?;
        (self.platforms as usize).checked_mul(STATE_WORDS)?.checked_add(behind)
    }
}

/// A state as words: position, velocity, attitude, age, then the flags.
pub(super) fn words_of(record: &PlatformRecord) -> [u64; STATE_WORDS] {
    let [x, y, z] = record.position_m;
    let [u, v, w] = record.velocity_mps;
    let [a, b, c, d] = record.attitude_quat;
    let [x, y, z, u, v, w, a, b, c, d, age] = [x, y, z, u, v, w, a, b, c, d, record.age_s].map(f64::to_bits);
    let flags = u64::from_ne_bytes(bytemuck::cast([record.flags, 0]));
    [x, y, z, u, v, w, a, b, c, d, age, flags]
}

/// The state that words hold.
pub(crate) fn state_of(words: &[u64; STATE_WORDS]) -> PlatformRecord {
    let real = |place: usize| f64::from_bits(words[place]);
    let [flags, _]: [u32; 2] = bytemuck::cast(words[11]);
    PlatformRecord {
        position_m: std::array::from_fn(real),
        velocity_mps: std::array::from_fn(|axis| real(3 + axis)),
        attitude_quat: std::array::from_fn(|part| real(6 + part)),
        age_s: real(10),
        flags,
    }
}
