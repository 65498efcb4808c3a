//! One pulse whose scatterer paths are taken in bands of Doppler, each with a replica of its own.
//!
//! Where Doppler or stretch off the mean of a pulse cost more than is allowed ([`super::doppler`]), scatterer
//! paths are sorted by `f0 r` into bands of a given width, pair by pair, and each band is spread and
//! transformed about its own mean: no scatterer path is farther off it than the width of the band. Slow (a
//! fill and a transform for each band that holds anything), but as exact as the bands are narrow.

use num_complex::Complex64;

use super::block::{BlockPaths, Fill, Node};
use super::{Grids, Scalar, Synth, SynthError, SynthScratch};
use crate::paths::list::ScattererPaths;
use crate::radar::waveform::Waveform;

/// Room to work; one per thread.
#[derive(Debug)]
pub struct Bands<T: Scalar> {
    /// Band and scatterer path.
    order: Vec<(i64, usize)>,
    part: ScattererPaths,
    block: BlockPaths<T>,
    grids: Grids<T>,
    scratch: SynthScratch<T>,
    spectrum: Vec<Complex64>,
}

impl<T: Scalar> Synth<T> {
    /// Room for [`Synth::pulse_in_bands`].
    pub fn bands(&self) -> Bands<T> {
        Bands {
            order: Vec::new(),
            part: ScattererPaths::new(self.pairs, self.channels, 0),
            block: self.block(),
            grids: self.grids(),
            scratch: self.scratch(),
            spectrum: vec![Complex64::ZERO; self.channels * self.fft_len],
        }
    }

    /// `S[k]` of every channel of a pulse, as [`Synth::spectrum`], from its scatterer paths in bands
    /// `band_hz` wide, in windows that start so long after the emission, s; where it radiates something of
    /// its own, of that.
    ///
    /// # Errors
    /// A window that is not finite, or scatterer paths that lack pairs or channels.
    pub fn pulse_in_bands(
        &self,
        own: Option<&dyn Waveform>,
        paths: &ScattererPaths,
        starts_s: &[f64],
        band_hz: f64,
        work: &mut Bands<T>,
        out: &mut [Complex64],
    ) -> Result<Fill, SynthError> {
        let Bands { order, part, block, grids, scratch, spectrum } = work;
        out.fill(Complex64::ZERO);
        let mut found = Fill::default();
        for pair in 0..self.pairs {
            let of_pair = || self.layers.iter().filter(|layer| layer.pair == pair && !layer.moment);
            let contributes = |n: usize| {
                let mut channels = of_pair().flat_map(|layer| &layer.channels);
                channels.any(|channel| paths.amplitude[*channel][n] != Complex64::ZERO)
            };
            order.clear();
            let rates = paths.delay_rate[pair].iter().enumerate().filter(|(n, _)| contributes(*n));
            order.extend(rates.map(|(n, rate)| ((self.carrier_hz * rate / band_hz).floor() as i64, n)));
            order.sort_unstable();
            for band in order.chunk_by(|a, b| a.0 == b.0) {
                part.clear();
                for (_, n) in band {
                    part.emission_offset_s.push(paths.emission_offset_s[*n]);
                    for other in 0..self.pairs {
                        part.delay_s[other].push(paths.delay_s[other][*n]);
                        part.delay_rate[other].push(paths.delay_rate[other][*n]);
                    }
                    part.amplitude.iter_mut().for_each(|column| column.push(Complex64::ZERO));
                    for channel in of_pair().flat_map(|layer| &layer.channels) {
                        if let Some(last) = part.amplitude[*channel].last_mut() {
                            *last = paths.amplitude[*channel][*n];
                        }
                    }
                }
                let (node, windows_s) = ([Node { pulse: 0, paths: part }], starts_s.as_chunks::<1>().0);
                self.fill_radiated(own, &node, windows_s, block)?;
                let fill = block.found();
                found.spread += fill.spread;
                found.unplaced += fill.unplaced;
                found.residual_hz = found.residual_hz.max(fill.residual_hz);
                found.drift_cells = found.drift_cells.max(fill.drift_cells);
                self.spread(block, grids);
                self.spectrum(block, grids, 0, scratch, spectrum);
                out.iter_mut().zip(&*spectrum).for_each(|(sum, own)| *sum += own);
            }
        }
        Ok(found)
    }
}
