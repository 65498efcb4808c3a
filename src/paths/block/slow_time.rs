//! When the pulses of a block are.

use crate::paths::PathGenerator;

/// Slow time of the pulses of a block: mean intervals from its first pulse. Where all intervals are equal it
/// is the number of the pulse.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SlowTime {
    /// Of every pulse; empty where all intervals are equal.
    at: Vec<f64>,
}

impl SlowTime {
    /// Of a pulse.
    #[inline]
    pub fn at(&self, pulse: usize) -> f64 {
        self.at.get(pulse).copied().unwrap_or(pulse as f64)
    }

    /// Of every pulse; empty where all intervals are equal.
    pub fn uneven(&self) -> &[f64] {
        &self.at
    }

    /// Of pulses at these times.
    #[cfg(test)]
    pub(super) fn of(at: Vec<f64>) -> Self {
        Self { at }
    }

    /// Makes all intervals equal.
    pub fn level(&mut self) {
        self.at.clear();
    }
}

impl PathGenerator {
    /// Finds the slow time of so many pulses from `first` on.
    pub fn slow_time(&self, first: u64, pulses: usize, out: &mut SlowTime) {
        out.at.clear();
        let emissions = &self.radar.emissions;
        if !emissions.is_uniform() {
            let per_interval = 1.0 / emissions.mean_pri_s();
            let of = |index: u64| emissions.interval_s(first, index) * per_interval;
            out.at.extend((first..).take(pulses).map(of));
        }
    }

    /// The group of every channel by its transmit polarisation: a pulse fills those of its own alone.
    pub fn channel_groups(&self) -> Vec<u8> {
        let of = &self.radar.tx_polarisation;
        self.radar.channels.iter().map(|channel| of.group(Some(channel.tx))).collect()
    }

    /// The groups that some pulses fill; none where every pulse fills all channels.
    pub fn pulse_groups(&self, first: u64, pulses: usize, out: &mut Vec<u8>) {
        out.clear();
        let of = &self.radar.tx_polarisation;
        if of.of_pulse(first).is_some() {
            out.extend((first..).take(pulses).map(|index| of.group(of.of_pulse(index))));
        }
    }

    /// Share of the pulses that fill each channel.
    pub fn shares_of_pulses(&self) -> Vec<f64> {
        self.radar.channels.iter().map(|channel| self.radar.tx_polarisation.share(channel.tx)).collect()
    }
}
