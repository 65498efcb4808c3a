//! Radials of a scanning antenna, for the plan position panel.
//!
//! A turn has as many **spokes** as make each a third of the beam, within [`SPOKES`]. A pulse is detected
//! when the beam has gone on by a third of itself; a radial has the strongest of the pulses of its spoke, and
//! their mean azimuth. So a radial is of one pulse, but where a third of the beam is narrower than the
//! narrowest spoke. A pulse for which there is no time is left out, and the next one of the same third is
//! tried.
//!
//! Cells are no shorter than a sample, and at most [`CELLS`]: each has the greatest power within. A code is
//! the level under the strongest cell of the radial, in steps of 0.5 dB.

use super::budget::Budget;
use crate::processor::ppi::Motion;
use crate::processor::radials::Radials;
use crate::pulse::Pulse;
use crate::recording::header::Header;
use crate::units::Decibels;

/// Most range cells of a radial.
const CELLS: usize = 512;
/// Fewest and most spokes of a turn.
const SPOKES: [f64; 2] = [360.0, 2048.0];
/// Radials of a beam.
const PER_BEAM: f64 = 3.0;
/// Steps of codes in a factor of 2: they are 0.5 dB, `20 log10(2)`.
const STEPS_PER_OCTAVE: f32 = 6.020_6;
/// The greatest code.
const MOST_CODE: u8 = 255;
/// Time from a picture to the next where it is not known, s.
const USUAL_PERIOD_S: f64 = 2.5;
/// Beamwidth where the aperture is not known, degrees.
const USUAL_BEAM_DEG: f64 = 1.0;

/// Powers of a spoke.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Radial {
    /// Number of the radial, from 1.
    pub number: u64,
    /// Its first pulse.
    pub pulse: u64,
    /// Emission of that pulse after that of pulse 0, s.
    pub time_s: f64,
    /// Delay at which its first cell begins, s.
    pub start_s: f64,
    /// Reported azimuth, clockwise from North, 0 to 360 degrees.
    pub azimuth_deg: f64,
    /// Heading that the platform reports, clockwise from North, degrees.
    pub heading_deg: f64,
    /// Level of the greatest code, dBW.
    pub peak_dbw: f64,
    /// Levels of the cells: the greatest code is the peak, 0 is what is 127 dB below it or less.
    pub codes: Vec<u8>,
}

/// Makes radials of pulses.
pub struct Ppi {
    radials: Radials,
    cell_s: f64,
    spokes: u64,
    /// Thirds of a beam in a spoke, or 1.
    looks: u64,
    /// The last third in which a pulse was detected.
    look: Option<u64>,
    begun: Option<Begun>,
    /// Number of the first cell of the radial that is begun, and its powers.
    first: u32,
    strongest_w: Vec<f32>,
    powers_w: Vec<f32>,
}

/// A radial that is not complete.
#[derive(Clone, Copy, Debug)]
struct Begun {
    spoke: u64,
    pulse: u64,
    time_s: f64,
    heading_deg: f64,
    /// Azimuths of its pulses after the begin of the spoke, summed, degrees.
    within_deg: f64,
    pulses: u32,
}

impl Ppi {
    /// Of the first channel of echoes whose receiver scans on the platform of its transmitter; `None` where
    /// there is none, or its pulses cannot be compressed.
    pub fn new(header: &Header) -> Option<Self> {
        let window_s = (header.layout.samples as f64 - 1.0) / header.sample_rate_hz;
        let cell_s = (window_s / CELLS as f64).max(header.sample_rate_hz.recip());
        let radials = Radials::of(header, None, cell_s, false).ok()?;
        let third_deg = radials.beam_deg().unwrap_or(USUAL_BEAM_DEG) / PER_BEAM;
        let spokes = (360.0 / third_deg).ceil().clamp(SPOKES[0], SPOKES[1]);
        let looks = (360.0 / spokes / third_deg).ceil().clamp(1.0, 16.0);
        let cells = radials.cells();
        Some(Self {
            radials,
            cell_s,
            spokes: spokes as u64,
            looks: looks as u64,
            look: None,
            begun: None,
            first: 0,
            strongest_w: Vec::with_capacity(cells),
            powers_w: Vec::with_capacity(cells),
        })
    }

    /// Spokes of a turn.
    pub fn spokes(&self) -> usize {
        self.spokes as usize
    }

    /// Length of a cell, there and back, s.
    pub fn cell_s(&self) -> f64 {
        self.cell_s
    }

    /// Whose pulses they are.
    pub fn radials(&self) -> &Radials {
        &self.radials
    }

    /// Two-way half-power beamwidth, degrees; 1 where it is not known.
    pub fn beam_deg(&self) -> f64 {
        self.radials.beam_deg().unwrap_or(USUAL_BEAM_DEG)
    }

    /// Time from a picture to the next, s: of a turn, or of a sweep and the one back; of a beam that jumps,
    /// a usual one.
    pub fn period_s(&self) -> f64 {
        let way_deg = match self.radials.motion() {
            Motion::Rotation { .. } => 360.0,
            Motion::Sector { width_rad } => 2.0 * width_rad.to_degrees(),
            Motion::Steps => return USUAL_PERIOD_S,
        };
        way_deg / self.radials.rate_deg_per_s().abs().max(f64::MIN_POSITIVE)
    }

    /// Takes a pulse, as far as there is time for it; the radial before, where the beam has left its spoke.
    pub fn take(&mut self, pulse: &Pulse, time_s: f64, budget: &mut Budget) -> Option<Radial> {
        if !self.radials.is_illuminated(pulse) {
            return None;
        }
        let azimuth_deg = self.radials.azimuth_deg(pulse).filter(|azimuth_deg| azimuth_deg.is_finite())?;
        let turn = azimuth_deg.rem_euclid(360.0) / 360.0;
        let all = self.spokes * self.looks;
        let look = ((turn * all as f64) as u64).min(all - 1);
        if self.look == Some(look) {
            return None;
        }
        let spoke = look / self.looks;
        let (done, first) = budget.spend(|| {
            let is_left = self.begun.is_some_and(|begun| begun.spoke != spoke);
            let done = if is_left { self.finish() } else { None };
            (done, self.radials.detect(pulse, &mut self.powers_w))
        })?;
        self.look = Some(look);
        let heading_deg = self.radials.heading_deg(pulse);
        let begun = self.begun.get_or_insert(Begun {
            spoke,
            pulse: pulse.index,
            time_s,
            heading_deg,
            within_deg: 0.0,
            pulses: 0,
        });
        begun.within_deg += 360.0 * (turn - spoke as f64 / self.spokes as f64);
        begun.pulses += 1;
        if begun.pulses == 1 {
            self.first = first;
            std::mem::swap(&mut self.strongest_w, &mut self.powers_w);
        } else {
            self.strengthen(first);
        }
        done
    }

    /// Leaves the radial that is begun.
    pub fn forget(&mut self) {
        (self.begun, self.look) = (None, None);
    }

    /// Takes the powers at hand into the radial where they are greater.
    fn strengthen(&mut self, first: u32) {
        // Where a window moves within a radial, cells that its first pulse has not are left out.
        let off = i64::from(first) - i64::from(self.first);
        for (place, power_w) in (off..).zip(&self.powers_w) {
            let cell = usize::try_from(place).ok().and_then(|place| self.strongest_w.get_mut(place));
            if let Some(cell) = cell {
                *cell = cell.max(*power_w);
            }
        }
    }

    fn finish(&mut self) -> Option<Radial> {
        let begun = self.begun.take()?;
        let azimuth_deg =
            360.0 * begun.spoke as f64 / self.spokes as f64 + begun.within_deg / f64::from(begun.pulses);
        // A window of zeros has no level; one below all that is received stands for it.
        let peak_w = self.strongest_w.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
        let steps = |power_w: f32| power_w.log2() * STEPS_PER_OCTAVE;
        let peak = steps(peak_w);
        // A cast makes 0 of what is below the range or no number.
        let code = |power_w: &f32| (f32::from(MOST_CODE) - (peak - steps(*power_w))).round() as u8;
        Some(Radial {
            number: 0,
            pulse: begun.pulse,
            time_s: begun.time_s,
            start_s: (f64::from(self.first) - 0.5) * self.cell_s,
            azimuth_deg,
            heading_deg: begun.heading_deg,
            peak_dbw: Decibels::from_power_ratio(f64::from(peak_w)).0,
            codes: self.strongest_w.iter().map(code).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex32;

    use super::*;
    use crate::pulse::{Layout, Samples};
    use crate::recording::header::ChannelRow;
    use crate::recording::instrument::{AntennaRow, Instrument, Look};

    /// A radar that turns, of one channel and an aperture.
    fn header(width_m: f64, look: Look) -> Header {
        let antenna = |name: &str| AntennaRow {
            name: name.to_owned(),
            platform: "mast".to_owned(),
            pattern: "rectangle".to_owned(),
            aperture_m: Some([width_m, 0.1]),
            look: look.clone(),
            ..AntennaRow::default()
        };
        Header {
            carrier_hz: 10e9,
            sample_rate_hz: 1e6,
            bandwidth_hz: 1e6,
            prf_hz: 1000.0,
            pulse_s: 1e-6,
            replica: vec![Complex32::ONE],
            layout: Layout { channels: 1, samples: 64, platforms: 1, antennas: 2, ..Layout::default() },
            channels: vec![ChannelRow {
                name: "HH".to_owned(),
                transmitter: "t".to_owned(),
                receiver: "r".to_owned(),
                polarisations: "HH".to_owned(),
                ..ChannelRow::default()
            }],
            platforms: vec!["mast".to_owned()],
            transmitters: vec!["t".to_owned()],
            receivers: vec!["r".to_owned()],
            instrument: Some(Instrument {
                antennas: vec![antenna("t"), antenna("r")],
                ..Instrument::default()
            }),
            ..Header::default()
        }
    }

    fn scan() -> Look {
        Look::Scan { level: true, rate_deg_per_s: 100.0, sector_deg: [0.0; 2], elevation_deg: 0.0 }
    }

    /// Pulses every so many degrees from 0 on; one has a target at sample 40.
    fn radials(
        ppi: &mut Ppi,
        header: &Header,
        step_deg: f64,
        target: u64,
        budget: &mut Budget,
    ) -> Vec<Radial> {
        let mut pulse = Pulse::new(&header.layout);
        let mut found = Vec::new();
        while pulse.index as f64 * step_deg < 20.0 {
            pulse.antennas[1].encoder_deg = Some([pulse.index as f64 * step_deg, 0.0]);
            pulse.window_start_s = 1e-5;
            let Samples::Cf32(values) = &mut pulse.samples else { panic!() };
            values.fill(Complex32::ZERO);
            values[40] = Complex32::new(if pulse.index == target { 1e-3 } else { 1e-6 }, 0.0);
            found.extend(ppi.take(&pulse, pulse.index as f64 * 1e-3, budget));
            pulse.index += 1;
        }
        found
    }

    /// 10 m of aperture: a beam of 0.107 degrees, narrower than three of the narrowest spokes. The radial of
    /// its spoke has the target, at its delay and level, though other pulses of the spoke do not.
    #[test]
    fn a_narrow_beam_is_not_lost_between_radials() {
        let header = header(10.0, scan());
        let mut ppi = Ppi::new(&header).unwrap();
        assert_eq!((ppi.spokes(), ppi.looks), (2048, 5));
        let all = radials(&mut ppi, &header, 0.01, 777, &mut Budget::of(1.0, 10.0));
        // Ends of 20 degrees of 2048 spokes a turn.
        assert!((all.len() as i64 - 20 * 2048 / 360).abs() <= 1, "{}", all.len());
        let best = all.iter().max_by(|a, b| a.peak_dbw.total_cmp(&b.peak_dbw)).unwrap();
        // A pulse for every fifth of the spoke: this one is among them by the choice of its number.
        assert!((best.azimuth_deg - 7.77).abs() < 180.0 / 2048.0, "{best:?}");
        assert!((best.peak_dbw + 60.0).abs() < 1.0, "{}", best.peak_dbw);
        let cell = best.codes.iter().position(|code| *code == MOST_CODE).unwrap();
        let delay_s = best.start_s + (cell as f64 + 0.5) * ppi.cell_s();
        assert!((delay_s - 50e-6).abs() < 0.51 * ppi.cell_s(), "{delay_s}");
        // The others are 60 dB weaker.
        assert_eq!(all.iter().filter(|radial| radial.peak_dbw > -100.0).count(), 1);
    }

    /// Where there is time for a pulse now and then, radials are fewer, and right.
    #[test]
    fn without_time_radials_are_left_out() {
        let header = header(1.0, scan());
        let mut ppi = Ppi::new(&header).unwrap();
        assert!(radials(&mut ppi, &header, 0.1, 0, &mut Budget::of(0.0, 0.0)).is_empty());
        assert!(radials(&mut ppi, &header, 0.1, 1000, &mut Budget::of(0.0, 1e-9)).is_empty());
        let once = ppi.finish().unwrap();
        assert!(once.azimuth_deg.abs() < 0.1 && once.pulse == 0, "{once:?}");
        assert!(radials(&mut ppi, &header, 0.1, 1000, &mut Budget::of(0.0, 1e-9)).is_empty());
        ppi.forget();
        assert!(ppi.finish().is_none());
    }

    #[test]
    fn what_does_not_scan_has_no_radials() {
        assert!(Ppi::new(&header(1.0, Look::default())).is_none());
        let dechirped =
            Instrument { dechirp_s: Some(1e-5), ..header(1.0, scan()).instrument.unwrap_or_default() };
        assert!(Ppi::new(&Header { instrument: Some(dechirped), ..header(1.0, scan()) }).is_none());
        let whole = Ppi::new(&header(1.0, scan())).unwrap();
        assert!((whole.period_s() - 3.6).abs() < 1e-9);
        let sector =
            Look::Scan { level: true, rate_deg_per_s: 20.0, sector_deg: [-30.0, 30.0], elevation_deg: 0.0 };
        assert!((Ppi::new(&header(1.0, sector)).unwrap().period_s() - 6.0).abs() < 1e-9);
    }
}
