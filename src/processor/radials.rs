//! Reported azimuth and detected powers of each pulse of a scanning antenna, as fast as pulses come.
//!
//! | quantity | how |
//! | --- | --- |
//! | azimuth | what the encoder reads, plus the heading that the platform reports where it counts from the nose |
//! | powers | those of the cells of a [`Detector`]: matched filter, Taylor taper, peak or mean of a cell, W |
//!
//! The channel is one that has a plan position picture ([`super::ppi`]): its transmitter and receiver are on
//! one platform, and its receiver scans. Radar video and the live page are made of these.

use glam::DQuat;
use num_complex::Complex32;

use super::ppi::{Motion, PpiError, Sight};
use super::range_compress::PulseShape;
use super::video::Detector;
use crate::frames::Rotation;
use crate::pulse::{Pulse, Samples};
use crate::recording::header::Header;
use crate::scene::radar::Polarisation;

/// Reads and detects the pulses of one channel.
pub struct Radials {
    name: String,
    channel: usize,
    receiver: usize,
    /// Place of its antenna among all.
    antenna: usize,
    platform: Option<usize>,
    /// Whether azimuths count from North.
    is_level: bool,
    motion: Motion,
    rate_deg_per_s: f64,
    beam_deg: Option<f64>,
    /// Transmit polarisation of the channel.
    polarisation: Option<Polarisation>,
    /// Of codes, sqrt(W).
    step: f32,
    samples: usize,
    detector: Detector,
}

impl Radials {
    /// Of the channel asked for, or the first of echoes whose receiver scans on the platform of its
    /// transmitter; in cells of a length, s, with the peak or the mean of each.
    ///
    /// # Errors
    /// No such channel, one that is bistatic or does not scan, and pulses that cannot be compressed.
    pub fn of(header: &Header, channel: Option<&str>, cell_s: f64, mean: bool) -> Result<Self, PpiError> {
        let (channel, sight) = Sight::of(header, channel)?;
        let row = &header.channels[channel];
        let shape = PulseShape::of(header);
        let detector = Detector::new(shape, header.layout.samples, cell_s, mean)?;
        let receiver = header.receiver_of(channel).unwrap_or(0);
        Ok(Self {
            name: row.name.clone(),
            channel,
            receiver,
            antenna: header.transmitters.len() + receiver,
            platform: header.platforms.iter().position(|name| *name == sight.platform),
            is_level: sight.is_level,
            motion: sight.motion,
            rate_deg_per_s: sight.rate_deg_per_s,
            beam_deg: sight.beam_rad.map(f64::to_degrees),
            polarisation: row.polarisations.chars().nth(1).and_then(Polarisation::from_letter),
            step: header.adc.map_or(1.0, |adc| adc.step as f32),
            samples: header.layout.samples,
            detector,
        })
    }

    /// Name of the channel.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Place of the receiving antenna among all.
    pub fn antenna(&self) -> usize {
        self.antenna
    }

    /// How the receiving antenna scans.
    pub fn motion(&self) -> Motion {
        self.motion
    }

    /// Its rate, clockwise, deg/s; of a sector that within a sweep.
    pub fn rate_deg_per_s(&self) -> f64 {
        self.rate_deg_per_s
    }

    /// Two-way half-power beamwidth, degrees, where the apertures are known.
    pub fn beam_deg(&self) -> Option<f64> {
        self.beam_deg
    }

    /// Cells of a window, at most.
    pub fn cells(&self) -> usize {
        self.detector.cells()
    }

    /// Whether a pulse left in the polarisation of the channel.
    pub fn is_illuminated(&self, pulse: &Pulse) -> bool {
        pulse.tx_pol == 0 || self.polarisation.is_none_or(|port| port.code() == pulse.tx_pol)
    }

    /// Heading that the platform reports at a pulse, clockwise from North, degrees; 0 where it reports none.
    pub fn heading_deg(&self, pulse: &Pulse) -> f64 {
        let record = self.platform.and_then(|platform| pulse.nav_reported.get(platform));
        record.map_or(0.0, |record| {
            let [w, x, y, z] = record.attitude_quat;
            Rotation::from_raw(DQuat::from_xyzw(x, y, z, w)).to_yaw_pitch_roll()[0].to_degrees()
        })
    }

    /// Reported azimuth of a pulse from North, degrees, not reduced to a turn; `None` where no encoder was
    /// read.
    pub fn azimuth_deg(&self, pulse: &Pulse) -> Option<f64> {
        let [azimuth_deg, _] = pulse.antennas.get(self.antenna)?.encoder_deg?;
        Some(if self.is_level { azimuth_deg } else { azimuth_deg + self.heading_deg(pulse) })
    }

    /// Puts the powers of the cells of a pulse in place of those in `powers_w`, W; the number of the first.
    pub fn detect(&mut self, pulse: &Pulse, powers_w: &mut Vec<f32>) -> u32 {
        let opens = (pulse.index, pulse.window_start_of(self.receiver));
        let range = self.channel * self.samples..(self.channel + 1) * self.samples;
        let Self { detector, step, .. } = self;
        match &pulse.samples {
            Samples::Cf32(all) => {
                let window = all.get(range).unwrap_or_default();
                detector.detect(window.iter().copied(), opens, powers_w)
            }
            Samples::Ci16(codes) => {
                let volts = |code: i16| (f32::from(code) + 0.5) * *step;
                let window = codes.get(range).unwrap_or_default().iter();
                detector.detect(window.map(|[i, q]| Complex32::new(volts(*i), volts(*q))), opens, powers_w)
            }
        }
    }
}
