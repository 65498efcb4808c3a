//! Range-Doppler maps of consecutive pulses.
//!
//! `D(tau, f) = sum_n w_n C_n(tau) e^{-j 2 pi f n / PRF} / sum_n w_n`, `C_n` the compressed window of pulse
//! `n` and `w` Hann's window. Windows of different starts are aligned to whole cells: their carrier phase
//! needs no correction, since delays are absolute. Frequencies are known up to multiples of the PRF.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use num_complex::Complex32;

use super::ranges::Ranges;
use crate::pulse::Pulse;

/// Pulses of a map.
pub const PULSES: usize = 128;
/// Memory of the windows that are held for a map, bytes.
const BYTES: usize = 16 << 20;

/// A range-Doppler map.
#[derive(Clone, Debug, Default)]
pub struct Map {
    /// Number of the map, from 1.
    pub number: u64,
    /// Its channel.
    pub channel: usize,
    /// Its last pulse.
    pub pulse: u64,
    /// Emission of that pulse after that of pulse 0, s.
    pub time_s: f64,
    /// Bistatic delay at which the first column begins, half a cell before its first cell, s.
    pub start_s: f64,
    /// Doppler frequencies covered, from minus half of it, Hz.
    pub span_hz: f64,
    /// Rows: Doppler frequencies, ascending.
    pub rows: usize,
    /// Levels, 0.01 dBW, `[row][column]`.
    pub levels: Vec<i16>,
}

/// Consecutive pulses of a channel.
#[derive(Debug, Default)]
pub struct Burst {
    channel: usize,
    /// Numbers from one pulse to the next: 2 where the channel is radiated every second time.
    step: u64,
    last: Option<u64>,
    /// Emission of the last pulse, s.
    last_s: f64,
    /// Starts of the windows, and the windows, the oldest first; more of these may be left from an earlier
    /// burst.
    starts_s: VecDeque<f64>,
    windows: VecDeque<Vec<Complex32>>,
}

/// Pulses of a map of windows of so many samples.
pub fn pulses(samples: usize) -> usize {
    let fit = BYTES / (samples.max(1) * size_of::<Complex32>());
    let fit = fit.clamp(16, PULSES);
    1 << fit.ilog2()
}

impl Burst {
    /// Forgets all, and goes on with a channel.
    pub fn restart(&mut self, channel: usize) {
        (self.channel, self.step, self.last) = (channel, 0, None);
        self.starts_s.clear();
    }

    /// The channel.
    pub fn channel(&self) -> usize {
        self.channel
    }

    /// Takes a pulse in which the channel is illuminated, and holds no more than so many; what does not
    /// continue the burst begins a new one.
    pub fn take(&mut self, pulse: &Pulse, time_s: f64, most: usize, ranges: &mut Ranges) {
        let step = self.last.map(|last| pulse.index.saturating_sub(last));
        match (self.starts_s.len(), step) {
            (1, Some(step @ 1..=8)) => self.step = step,
            (2.., Some(step)) if step == self.step => {}
            _ => self.starts_s.clear(),
        }
        (self.last, self.last_s) = (Some(pulse.index), time_s);
        if self.starts_s.len() >= most {
            self.starts_s.pop_front();
            self.windows.rotate_left(1);
        }
        let place = self.starts_s.len();
        if self.windows.len() <= place {
            self.windows.push_back(Vec::new());
        }
        self.windows[place].clear();
        self.windows[place].extend_from_slice(ranges.window(pulse, self.channel));
        self.starts_s.push_back(ranges.opens_s(pulse, self.channel));
    }

    /// Whether there are enough pulses for a map.
    pub fn is_full(&self, pulses: usize) -> bool {
        self.starts_s.len() >= pulses
    }

    /// The map of all pulses held, at a mean PRF; the burst begins again.
    pub fn map(&mut self, ranges: &Ranges, prf_hz: f64) -> Map {
        let rows = self.starts_s.len();
        let first_s = self.starts_s[0];
        let shift = |start_s: f64| ((start_s - first_s) / ranges.cell_s()).round() as isize;
        let mut lines: Vec<Vec<Complex32>> = Vec::with_capacity(rows);
        let taper = |n: usize| (0.5 - 0.5 * (TAU * (n as f64 + 0.5) / rows as f64).cos()) as f32;
        let sum: f32 = (0..rows).map(taper).sum();
        let last = self.last.unwrap_or(0);
        let number = |n: usize| last.saturating_sub((rows - 1 - n) as u64 * self.step);
        for n in 0..rows {
            let cells = ranges.compress(&self.windows[n], number(n));
            let by = shift(self.starts_s[n]);
            let weight = taper(n) / sum;
            let of = |cell: usize| {
                let from = cell as isize - by;
                usize::try_from(from).ok().and_then(|from| cells.get(from)).copied().unwrap_or_default()
                    * weight
            };
            lines.push((0..cells.len()).map(of).collect());
        }
        let cells = lines.first().map_or(0, Vec::len);
        let transform = nereus_fft::forward(rows);
        let mut powers = vec![0f32; rows * cells];
        let mut column = vec![Complex32::ZERO; rows];
        for cell in 0..cells {
            column.iter_mut().zip(&lines).for_each(|(to, line)| *to = line[cell]);
            transform.process(&mut column);
            for (bin, value) in column.iter().enumerate() {
                // From minus half the PRF upwards.
                powers[(bin + rows / 2) % rows * cells + cell] = value.norm_sqr();
            }
        }
        let levels =
            powers.chunks_exact(cells.max(1)).flat_map(|row| ranges.peaks(row.iter().copied())).collect();
        self.starts_s.clear();
        Map {
            pulse: self.last.unwrap_or_default(),
            time_s: self.last_s,
            rows,
            levels,
            start_s: first_s - 0.5 * ranges.cell_s(),
            span_hz: prf_hz / self.step.max(1) as f64,
            channel: self.channel,
            ..Map::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pulse::{Layout, Samples};
    use crate::recording::header::Header;

    /// A target of 30 Hz stands in the row of 30 Hz and in the column of its delay, though the window moves.
    #[test]
    fn a_target_stands_at_its_doppler_and_delay() {
        let header = Header {
            sample_rate_hz: 100e6,
            bandwidth_hz: 100e6,
            pulse_s: 1e-8,
            replica: vec![Complex32::ONE],
            layout: Layout { channels: 1, samples: 400, ..Layout::default() },
            ..Header::default()
        };
        let mut ranges = Ranges::new(&header).unwrap();
        let mut burst = Burst::default();
        let prf_hz = 256.0;
        // The map is of the last 64 of them.
        for n in 0..80_u64 {
            let mut pulse = Pulse::new(&header.layout);
            pulse.index = n;
            let drift = (n / 20) as usize;
            pulse.window_start_s = 1e-5 + drift as f64 / 100e6;
            let Samples::Cf32(values) = &mut pulse.samples else { panic!() };
            values[200 - drift] = Complex32::from_polar(1e-3, (TAU * 30.0 * n as f64 / prf_hz) as f32);
            burst.take(&pulse, n as f64, 64, &mut ranges);
        }
        assert!(burst.is_full(64) && !burst.is_full(65));
        let map = burst.map(&ranges, prf_hz);
        let columns = ranges.columns();
        assert_eq!((map.rows, map.levels.len(), map.span_hz, map.pulse), (64, 64 * columns, prf_hz, 79));
        let peak = (0..map.levels.len()).max_by_key(|place| map.levels[*place]).unwrap();
        let doppler_hz = (peak / columns) as f64 / 64.0 * map.span_hz - 0.5 * map.span_hz;
        assert!((doppler_hz - 30.0).abs() <= 0.5 * prf_hz / 64.0, "{doppler_hz}");
        // The middle of a column is that of its cells.
        let delay_s = map.start_s + ((peak % columns) as f64 + 0.5) * ranges.column_s();
        assert!((delay_s - (1e-5 + 200.0 / 100e6)).abs() <= 0.5 * ranges.column_s(), "{delay_s}");
        // Hann's window lies half a bin beside the middle of the row at most: 1.42 dB.
        assert!((f64::from(map.levels[peak]) * 0.01 + 60.0).abs() < 1.5, "{}", map.levels[peak]);
    }

    #[test]
    fn a_gap_begins_a_new_burst() {
        let header = Header {
            sample_rate_hz: 1e6,
            bandwidth_hz: 1e6,
            replica: vec![Complex32::ONE],
            layout: Layout { channels: 1, samples: 4, ..Layout::default() },
            ..Header::default()
        };
        let mut ranges = Ranges::new(&header).unwrap();
        let mut burst = Burst::default();
        let mut pulse = Pulse::new(&header.layout);
        for index in [0, 2, 4, 6, 7] {
            pulse.index = index;
            burst.take(&pulse, 0.0, 128, &mut ranges);
        }
        assert_eq!((burst.starts_s.len(), pulses(400), pulses(1 << 17), pulses(1 << 24)), (1, 128, 16, 16));
    }
}
