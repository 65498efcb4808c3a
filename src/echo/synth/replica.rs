//! What takes grids to spectra: the pulse that was radiated, the receive filter, the kernel.

use num_complex::Complex64;

use super::block::{BlockPaths, Frame, Node};
use super::doppler::{self, Correction};
use super::scalar::Scalar;
use super::{Bin, Layer, Settings, Synth, SynthError};
use crate::radar::waveform::{Frequencies, Waveform};
use crate::units::in_turn;

/// Bins whose spectra are found together.
const TOGETHER: usize = 64;

impl<T: Scalar> Synth<T> {
    /// `P H / phihat` of every layer about its pair's mean Doppler, with the place of the grid's first cell.
    pub(super) fn fill_replicas(&self, frame: &mut Frame) {
        self.replicas_of(self.waveform.as_ref(), &frame.mean_hz, &mut frame.replicas);
    }

    /// What an emission radiates where several pulses leave in turn.
    pub fn in_turn(&self, emission: u64) -> Option<&dyn Waveform> {
        in_turn(self.waveform.in_turn(), emission).map(AsRef::as_ref)
    }

    /// How many pulses leave in turn; 0 where all are alike.
    pub fn turns(&self) -> u64 {
        self.waveform.in_turn().len() as u64
    }

    /// What the replicas of a pulse take, bytes.
    pub fn replica_bytes(&self) -> u64 {
        (self.layers.len() * self.bins.len() * size_of::<Complex64>()) as u64
    }

    /// As [`Self::fill_in`], where something of its own was radiated.
    ///
    /// # Errors
    /// Those of [`Self::fill_in`].
    pub fn fill_radiated<W: AsRef<[f64]>>(
        &self,
        own: Option<&dyn Waveform>,
        nodes: &[Node<'_>],
        windows_s: &[W],
        block: &mut BlockPaths<T>,
    ) -> Result<(), SynthError> {
        let Some(own) = own else { return self.fill_in(nodes, windows_s, block) };
        self.fill_without_replicas(nodes, windows_s, block)?;
        let Frame { mean_hz, replicas, .. } = &mut block.frame;
        self.replicas_of(own, mean_hz, replicas);
        Ok(())
    }

    /// What takes grids to spectra where this is radiated, `[layer][bin]`, about these mean Dopplers of the
    /// pairs, Hz.
    pub fn replicas_of(&self, waveform: &dyn Waveform, mean_hz: &[f64], out: &mut Vec<Vec<Complex64>>) {
        let correction = self.correction();
        out.resize_with(self.layers.len(), Vec::new);
        for (layer, replica) in self.layers.iter().zip(out) {
            let mean_hz = mean_hz.get(layer.pair).copied().unwrap_or(0.0);
            let at = |bin: &Bin| self.read_at(bin, mean_hz);
            replica.clear();
            replica.resize(self.bins.len(), Complex64::ZERO);
            if layer.moment {
                // Amplitudes are times the length of a pulse.
                let of = |bin: &Bin| correction.moment(waveform, (bin.f_hz, at(bin).0), mean_hz);
                let lasts_s = self.waveform.duration_s();
                replica.iter_mut().zip(&self.bins).for_each(|(pulse, bin)| *pulse = of(bin) / lasts_s);
            } else {
                for (bins, pulse) in self.bins.chunks(TOGETHER).zip(replica.chunks_mut(TOGETHER)) {
                    let mut f_hz = [0.0; TOGETHER];
                    f_hz.iter_mut().zip(bins).for_each(|(f_hz, bin)| *f_hz = at(bin).0);
                    waveform.spectra(&f_hz[..bins.len()], pulse);
                }
            }
            for (pulse, bin) in replica.iter_mut().zip(&self.bins) {
                *pulse = *pulse * bin.origin * (at(bin).1 * bin.gain);
            }
        }
    }

    /// Frequencies that [`Self::replicas_at`] reads at, of every layer, about these mean Dopplers of the
    /// pairs, Hz.
    pub fn frequencies(&self, mean_hz: &[f64]) -> Vec<Frequencies> {
        let of = |layer: &Layer| {
            let mean_hz = mean_hz.get(layer.pair).copied().unwrap_or(0.0);
            Frequencies::new(self.bins.iter().map(|bin| self.read_at(bin, mean_hz).0).collect())
        };
        self.layers.iter().map(of).collect()
    }

    /// What these may take, bytes.
    pub fn frequency_bytes(&self) -> u64 {
        (self.layers.len() * self.bins.len() * Frequencies::BYTES) as u64
    }

    /// As [`Self::replicas_of`] about the same mean Dopplers, of one of many waveforms.
    pub fn replicas_at(
        &self,
        waveform: &dyn Waveform,
        (mean_hz, frequencies): (&[f64], &mut [Frequencies]),
        out: &mut Vec<Vec<Complex64>>,
    ) {
        if self.layers.iter().any(|layer| layer.moment) {
            return self.replicas_of(waveform, mean_hz, out);
        }
        out.resize_with(self.layers.len(), Vec::new);
        for ((layer, at), replica) in self.layers.iter().zip(frequencies).zip(out) {
            let mean_hz = mean_hz.get(layer.pair).copied().unwrap_or(0.0);
            let stretch = self.bins.first().map_or(1.0, |bin| self.read_at(bin, mean_hz).1);
            replica.resize(self.bins.len(), Complex64::ZERO);
            waveform.spectra_at(at, replica);
            for (pulse, bin) in replica.iter_mut().zip(&self.bins) {
                *pulse = *pulse * bin.origin * (stretch * bin.gain);
            }
        }
    }

    /// Where the pulse is read for a bin, Hz, and its stretch.
    fn read_at(&self, bin: &Bin, mean_hz: f64) -> (f64, f64) {
        doppler::stretched(self.settings.envelope, self.carrier_hz, bin.f_hz, mean_hz)
    }

    /// What Doppler off the mean adds to phase and place.
    pub(super) fn correction(&self) -> Correction {
        let Settings { doppler, envelope, .. } = self.settings;
        Correction::new(doppler, envelope, self.waveform.as_ref(), self.carrier_hz)
    }
}
