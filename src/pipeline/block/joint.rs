//! Blocks of a continuous signal: grids are those of emissions, which windows then receive a part of.

use std::ops::Range;
use std::sync::Arc;

use num_complex::Complex64;

use super::{BlockEcho, BlockWork};
use crate::paths::{PathGenerator, Workspace};
use crate::pipeline::joined::{Echo, Joined, Span, channel_starts};
use crate::pulse::Pulse;
use crate::pulse::costs::Stage;
use crate::radar::waveform::{Frequencies, Waveform, WaveformError};
use crate::scene::radar::Radar;

/// What is radiated by a train of which no two emissions are alike, and who receives it.
#[derive(Clone)]
pub(crate) struct Joint {
    pub waveform: Arc<dyn Waveform>,
    pub span: Span,
    pub sample_rate_hz: f64,
    pub window_samples: usize,
}

impl Joint {
    /// For a radar with these delays, s.
    pub fn new(waveform: &Arc<dyn Waveform>, radar: &Radar, delays_s: (f64, f64)) -> Self {
        let (sample_rate_hz, window_samples) = (radar.sample_rate_hz, radar.window.samples);
        let span = Span::new(delays_s, waveform.as_ref(), sample_rate_hz);
        Self { waveform: Arc::clone(waveform), span, sample_rate_hz, window_samples }
    }

    /// Bins of the spectrum of a window.
    pub fn out_len(&self) -> usize {
        Joined::out_len(self.window_samples)
    }

    /// What joins spectra of so many bins.
    pub fn joined(&self, len: usize) -> Joined {
        Joined::new(self.span, self.sample_rate_hz, self.window_samples, len)
    }
}

/// Echoes of emissions of the block at hand.
pub(super) struct JointWork {
    joined: Joined,
    echoes: Vec<Echo>,
    /// Emissions that have grids.
    gridded: Range<u64>,
    /// What is radiated by emissions in a row, from one on.
    radiated: (u64, Vec<Arc<dyn Waveform>>),
    replicas: Vec<Vec<Complex64>>,
    /// Mean Doppler of the pairs in the block at hand, Hz, and what its spectra are read at.
    read_at: Option<(Vec<f64>, Vec<Frequencies>)>,
}

impl JointWork {
    pub fn new(joint: &Joint, len: usize) -> Self {
        Self {
            joined: joint.joined(len),
            echoes: Vec::new(),
            gridded: 0..0,
            radiated: (0, Vec::new()),
            replicas: Vec::new(),
            read_at: None,
        }
    }

    /// Begins another block, whose grids are those of these emissions.
    pub fn begin(&mut self, gridded: Range<u64>) {
        self.joined.keep(&mut self.echoes, &(0..0));
        self.radiated.1.clear();
        self.gridded = gridded;
    }

    /// First emission that has grids.
    pub fn first(&self) -> u64 {
        self.gridded.start
    }
}

/// What an emission radiates, found with those that follow it up to one.
fn radiated<'r>(
    (first, known): &'r mut (u64, Vec<Arc<dyn Waveform>>),
    waveform: &dyn Waveform,
    emission: u64,
    end: u64,
) -> Result<Option<&'r dyn Waveform>, WaveformError> {
    if !(*first..first.saturating_add(known.len() as u64)).contains(&emission) {
        (*first, *known) = (emission, waveform.of_emissions(emission..end.max(emission.saturating_add(1)))?);
    }
    Ok(known.get((emission - *first) as usize).map(AsRef::as_ref))
}

impl BlockEcho {
    /// The spectra of a pulse from the grids of the emissions that it receives.
    ///
    /// # Errors
    /// A signal that can no longer be read.
    pub(super) fn join(
        &self,
        (index, pulse): (u64, &Pulse),
        generator: &PathGenerator,
        memory: &mut Workspace,
        spectrum: &mut [Complex64],
        work: &mut BlockWork,
    ) -> Result<(), WaveformError> {
        let BlockWork { made, received, frame, grids, scratch, joint: own, spread, .. } = work;
        let (Some(joint), Some(own)) = (&self.joint, own) else { return Ok(()) };
        let emissions = received.of_pulses().get((index - made.start) as usize).cloned().unwrap_or(0..0);
        let (starts_s, windows) = (pulse.window_starts_s(), generator.pair_windows());
        let (channels, out_len) = (generator.channel_pairs().len(), joint.out_len());
        let JointWork { joined, echoes, gridded, radiated: known, replicas, read_at } = &mut **own;
        read_at.take_if(|(mean_hz, _)| mean_hz != frame.mean_hz());
        let (mean_hz, frequencies) = read_at
            .get_or_insert_with(|| (frame.mean_hz().to_vec(), self.synth.frequencies(frame.mean_hz())));
        joined.clear(channels);
        joined.keep(echoes, &emissions);
        for emitted in emissions {
            let offset_s = generator.offset_s(index, emitted);
            let of_channels = channel_starts(starts_s, &windows, generator.channel_pairs());
            joined.take(echoes, (emitted, offset_s), of_channels, |bins| {
                let [number, end] = [emitted, gridded.end].map(|of| generator.number_of(of));
                if let Some(waveform) = radiated(known, joint.waveform.as_ref(), number, end)? {
                    self.synth.replicas_at(waveform, (mean_hz, frequencies), replicas);
                }
                let of = (&*frame, (emitted - gridded.start) as usize);
                self.synth.spectrum_by(replicas, of, grids, scratch, bins);
                Ok::<_, WaveformError>(())
            })?;
        }
        for (channel, out) in spectrum.chunks_exact_mut(out_len).enumerate() {
            joined.spectrum(channel, out);
        }
        memory.costs.lap(Stage::Transform);
        memory.costs.accumulated(*spread);
        Ok(())
    }
}
