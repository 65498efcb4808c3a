//! Video of a channel, for sinks that send it: azimuths and powers of radials.
//!
//! Azimuth and powers of a pulse are those of [`Radials`]. A radial reaches from half the mean step between
//! pulses before its first pulse to as much behind its last; of a sector that step is that within a sweep.
//!
//! A radial holds so many pulses, counted from pulse 0 among those that left in the polarisation of the
//! channel; the mean of their powers.

use crate::processor::radials::Radials;
use crate::pulse::Pulse;
use crate::recording::header::Header;
use crate::sinks::asterix::{CellTime, CellValue, Detection, Radial, Settings, Video};
use crate::sinks::sink::SinkError;
use crate::units::{BOLTZMANN_J_PER_K, Decibels, NOISE_TEMPERATURE_K, SPEED_OF_LIGHT_MPS};

/// Level of the greatest code above the noise, dB, of logarithmic codes.
const HEADROOM_DB: f64 = 70.0;
/// The noise in linear codes.
const NOISE_CODES: f64 = 4.0;

/// Level of the greatest code, dBW: as asked, or by the noise that a receiver of a figure (that of an ideal
/// one where there is no noise) leaves behind the compression of a pulse, `k T0 F / T`.
pub(super) fn full_dbw(settings: &Settings, noise_figure_db: Option<f64>, pulse_s: f64) -> f64 {
    let noise_w = BOLTZMANN_J_PER_K * NOISE_TEMPERATURE_K / pulse_s;
    let noise_dbw = Decibels::from_power_ratio(noise_w).0 + noise_figure_db.unwrap_or(0.0);
    settings.full_dbw.unwrap_or_else(|| match settings.detection {
        Detection::Logarithmic { .. } => noise_dbw + HEADROOM_DB,
        Detection::Linear => {
            let codes = (1u32 << settings.bits.count()) - 1;
            noise_dbw + 20.0 * (f64::from(codes) / NOISE_CODES).log10()
        }
    })
}

/// The video that settings ask of a run.
///
/// # Errors
/// A channel that there is not, or one that does not scan; pulses that are not compressed.
pub(super) fn video(settings: &Settings, header: &Header) -> Result<Box<dyn Video>, SinkError> {
    let cell_s = settings.cell_m.map_or(header.sample_rate_hz.recip(), |m| 2.0 * m / SPEED_OF_LIGHT_MPS);
    let cell_time = CellTime::nearest(cell_s);
    let mean = settings.cell == CellValue::Mean;
    let radials = Radials::of(header, settings.channel.as_deref(), cell_time.seconds(), mean)
        .map_err(|error| SinkError::Video { found: error.to_string() })?;
    let cells = radials.cells();
    Ok(Box::new(RadarVideo {
        half_step_deg: 0.5 * radials.rate_deg_per_s().abs() / header.prf_hz,
        radial_pulses: settings.radial_pulses.max(1),
        cell_time,
        radials,
        powers_w: Vec::with_capacity(cells),
        last: None,
        stride: u64::MAX,
        sent: None,
        begun: None,
        radial: Radial { powers_w: Vec::with_capacity(cells), ..Radial::default() },
    }))
}

/// Makes radials of the pulses of a channel.
struct RadarVideo {
    half_step_deg: f64,
    radial_pulses: u64,
    cell_time: CellTime,
    radials: Radials,
    /// Of the pulse at hand.
    powers_w: Vec<f32>,
    /// Index of the last pulse in the polarisation of the channel, and its number among these.
    last: Option<(u64, u64)>,
    /// Pulses from one of these to the next.
    stride: u64,
    /// Number of the last radial given.
    sent: Option<u64>,
    begun: Option<Begun>,
    radial: Radial,
}

/// A radial that is not complete.
#[derive(Clone, Copy)]
struct Begun {
    number: u64,
    pulses: u32,
    /// Azimuths of its first and last pulse, degrees.
    azimuths_deg: [f64; 2],
}

impl RadarVideo {
    /// Number of a pulse among those in the polarisation of the channel; pulses that never came count.
    fn number_of(&mut self, pulse: &Pulse) -> u64 {
        if pulse.tx_pol == 0 {
            self.stride = 1;
        }
        let number = match self.last {
            None if self.stride == 1 => pulse.index,
            None => 0,
            Some((index, number)) => {
                let passed = pulse.index.saturating_sub(index).max(1);
                self.stride = self.stride.min(passed);
                number + passed / self.stride
            }
        };
        self.last = Some((pulse.index, number));
        number
    }

    /// Adds the powers at hand to the radial.
    fn add(&mut self, first: u32) {
        let radial = &mut self.radial;
        if radial.powers_w.is_empty() {
            radial.first = first;
            radial.powers_w.extend(&self.powers_w);
            return;
        }
        // Where a window moves within a radial, cells that its first pulse has not are left out.
        let off = i64::from(first) - i64::from(radial.first);
        for (place, power_w) in (off..).zip(&self.powers_w) {
            if let Some(sum) = usize::try_from(place).ok().and_then(|place| radial.powers_w.get_mut(place)) {
                *sum += power_w;
            }
        }
    }
}

impl Video for RadarVideo {
    fn channel(&self) -> &str {
        self.radials.name()
    }

    fn cell_time(&self) -> CellTime {
        self.cell_time
    }

    fn cells(&self) -> usize {
        self.radials.cells()
    }

    fn take(&mut self, pulse: &Pulse, done: &mut dyn FnMut(&Radial)) {
        if !self.radials.is_illuminated(pulse) {
            return;
        }
        let Some(azimuth_deg) = self.radials.azimuth_deg(pulse) else { return };
        let number = self.number_of(pulse);
        let (radial, place) = (number / self.radial_pulses, number % self.radial_pulses);
        if self.begun.is_some_and(|begun| begun.number != radial) {
            self.finish(done);
        }
        let first = self.radials.detect(pulse, &mut self.powers_w);
        let begun = match self.begun {
            Some(Begun { pulses, azimuths_deg: [from, _], .. }) => {
                Begun { number: radial, pulses: pulses + 1, azimuths_deg: [from, azimuth_deg] }
            }
            None => {
                self.radial.time = pulse.time;
                self.radial.powers_w.clear();
                Begun { number: radial, pulses: 1, azimuths_deg: [azimuth_deg; 2] }
            }
        };
        self.begun = Some(begun);
        self.add(first);
        if place + 1 == self.radial_pulses {
            self.finish(done);
        }
    }

    fn finish(&mut self, done: &mut dyn FnMut(&Radial)) {
        let Some(Begun { number, pulses, azimuths_deg: [from, to] }) = self.begun.take() else { return };
        let radial = &mut self.radial;
        let turned = (to - from + 180.0).rem_euclid(360.0) - 180.0;
        let edges = [from.min(from + turned), from.max(from + turned)];
        radial.azimuths_deg = [edges[0] - self.half_step_deg, edges[1] + self.half_step_deg];
        let share = 1.0 / pulses as f32;
        radial.powers_w.iter_mut().for_each(|power_w| *power_w *= share);
        radial.missed = self.sent.map_or(0, |sent| number.saturating_sub(sent + 1));
        self.sent = Some(number);
        done(radial);
    }
}
