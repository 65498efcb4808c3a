//! Range lines: compressed windows, as levels in columns.
//!
//! A column holds the peak of the cells that fall into it, so that a point target never vanishes between two
//! columns. Levels are hundredths of a decibel over 1 W in 16 bits: -327.67 to 327.67 dBW.

use num_complex::Complex32;

use crate::processor::range_compress::{Compressor, PulseShape, RangeFilter};
use crate::processor::taper::Taper;
use crate::pulse::{Pulse, Samples};
use crate::recording::header::Header;

/// Most columns of a row.
const MOST_COLUMNS: usize = 1024;
/// Cells that a window of few samples is given.
const WANTED_CELLS: usize = 2048;

/// A range line as it is shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Number of the row in its channel, from 1.
    pub number: u64,
    /// Its pulse.
    pub pulse: u64,
    /// Emission of the pulse after that of pulse 0, s.
    pub time_s: f64,
    /// Bistatic delay at which the first column begins, half a cell before its first cell, s.
    pub start_s: f64,
    /// Level of each column, 0.01 dBW.
    pub levels: Vec<i16>,
}

/// Compresses windows.
pub struct Ranges {
    compressor: Compressor,
    /// Cells in a column.
    cells: usize,
    columns: usize,
    step: f32,
    codes: bool,
    window: Vec<Complex32>,
    /// Receiver of each channel.
    receivers: Vec<usize>,
}

impl Ranges {
    /// Of the pulses of a run; `None` where they cannot be compressed (there is no replica, as in what was
    /// received over the wire).
    pub fn new(header: &Header) -> Option<Self> {
        let samples = header.layout.samples;
        let shape = PulseShape::of(header);
        let oversampling = (WANTED_CELLS / samples.max(1)).clamp(2, 8);
        let compressor =
            Compressor::new(shape, samples, RangeFilter::Matched, Taper::Uniform, oversampling).ok()?;
        let cells = compressor.cells().div_ceil(MOST_COLUMNS);
        Some(Self {
            columns: compressor.cells().div_ceil(cells),
            cells,
            compressor,
            step: header.adc.map_or(1.0, |adc| adc.step) as f32,
            codes: header.adc.is_some(),
            window: Vec::with_capacity(samples),
            receivers: (0..header.channels.len().max(header.layout.channels))
                .map(|channel| header.receiver_of(channel).unwrap_or(0))
                .collect(),
        })
    }

    /// Start of the window of a channel after the emission of a pulse, s.
    pub fn opens_s(&self, pulse: &Pulse, channel: usize) -> f64 {
        pulse.window_start_of(self.receivers.get(channel).copied().unwrap_or(0))
    }

    /// Columns of a row.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Delay from a column to the next, s.
    pub fn column_s(&self) -> f64 {
        self.cells as f64 / self.compressor.cell_rate_hz()
    }

    /// Delay from a cell to the next, s.
    pub fn cell_s(&self) -> f64 {
        1.0 / self.compressor.cell_rate_hz()
    }

    /// The window of a channel, sqrt(W).
    pub fn window(&mut self, pulse: &Pulse, channel: usize) -> &[Complex32] {
        let samples = self.compressor.samples();
        let place = channel * samples..(channel + 1) * samples;
        self.window.clear();
        match &pulse.samples {
            Samples::Cf32(values) => self.window.extend_from_slice(values.get(place).unwrap_or_default()),
            // Mid-rise: a code stands for the middle of its step.
            Samples::Ci16(codes) => {
                let half = if self.codes { 0.5 } else { 0.0 };
                let level = |code: i16| (f32::from(code) + half) * self.step;
                let codes = codes.get(place).unwrap_or_default();
                self.window.extend(codes.iter().map(|[re, im]| Complex32::new(level(*re), level(*im))));
            }
        }
        &self.window
    }

    /// Compresses the window of a pulse, by its number, into cells.
    pub fn compress(&self, window: &[Complex32], number: u64) -> Vec<Complex32> {
        self.compressor.compress(window, number, 0.0)
    }

    /// Levels of the columns of a channel.
    pub fn levels(&mut self, pulse: &Pulse, channel: usize) -> Vec<i16> {
        self.window(pulse, channel);
        let cells = self.compressor.compress(&self.window, pulse.index, 0.0);
        self.peaks(cells.iter().map(Complex32::norm_sqr))
    }

    /// Peak of every column of the powers of cells.
    pub fn peaks(&self, powers: impl Iterator<Item = f32>) -> Vec<i16> {
        let mut peaks = vec![0f32; self.columns];
        for (cell, power) in powers.enumerate() {
            if let Some(peak) = peaks.get_mut(cell / self.cells) {
                *peak = peak.max(power);
            }
        }
        peaks.into_iter().map(level).collect()
    }
}

/// A power in W as hundredths of a dBW; the least level for none.
fn level(power: f32) -> i16 {
    let level = 1000.0 * f64::from(power).log10();
    // A cast of what is no number or below the range would be 0 or -32768.
    if level.is_nan() { -i16::MAX } else { level.round().clamp(-32767.0, 32767.0) as i16 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pulse::Layout;

    fn header(samples: usize) -> Header {
        let replica = (0..100).map(|i| {
            let u = (f64::from(i) - 50.0) / 100e6;
            Complex32::from_polar(1.0, (std::f64::consts::PI * 60e6 / 1e-6 * u * u) as f32)
        });
        Header {
            sample_rate_hz: 100e6,
            bandwidth_hz: 60e6,
            pulse_s: 1e-6,
            replica: replica.collect(),
            layout: Layout { channels: 2, samples, ..Layout::default() },
            ..Header::default()
        }
    }

    /// A pulse that begins at sample 700 with 0.1 sqrt(W) peaks there, at -20 dBW, in its own channel alone.
    #[test]
    fn a_peak_stands_in_the_column_of_its_delay() {
        for samples in [900, 3000] {
            let header = header(samples);
            let mut ranges = Ranges::new(&header).unwrap();
            let mut pulse = Pulse::new(&header.layout);
            let Samples::Cf32(values) = &mut pulse.samples else { panic!() };
            for (to, q) in values[samples + 700..].iter_mut().zip(&header.replica) {
                *to = 0.1 * q;
            }
            let levels = ranges.levels(&pulse, 1);
            assert!(levels.len() <= MOST_COLUMNS && levels.len() == ranges.columns());
            let peak = (0..levels.len()).max_by_key(|column| levels[*column]).unwrap();
            assert_eq!(peak, (700.0 / 100e6 / ranges.column_s() + 1e-9) as usize);
            assert!((levels[peak] + 2000).abs() < 10, "{}", levels[peak]);
            assert!(ranges.levels(&pulse, 0).iter().all(|level| *level == -i16::MAX));
        }
    }

    #[test]
    fn what_has_no_replica_has_no_ranges() {
        assert!(Ranges::new(&Header { replica: Vec::new(), ..header(100) }).is_none());
    }
}
