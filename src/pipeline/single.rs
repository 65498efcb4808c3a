//! Pulses one by one, in f64: exact scatterer paths, spread and transformed without a digit lost, for budgets
//! that blocks cannot keep.

use num_complex::Complex64;

use crate::echo::synth::bands::Bands;
use crate::echo::synth::block::{BlockPaths, Node};
use crate::echo::synth::{Grids, Synth, SynthScratch};
use crate::paths::PathGenerator;
use crate::paths::list::ScattererPaths;
use crate::pipeline::block::{Joint, check};
use crate::pipeline::engine::{EchoEngine, EchoWorker, Needs, full_list, receives_one};
use crate::pipeline::fault::PulseError;
use crate::pipeline::joined::{Joined, channel_starts};
use crate::pipeline::kit::Desk;
use crate::pulse::Pulse;
use crate::pulse::costs::Stage;

/// Makes echoes pulse by pulse. Immutable, shared by all threads.
pub(crate) struct SingleEcho {
    synth: Synth<f64>,
    /// Where no two emissions are alike.
    joint: Option<Joint>,
}

struct SingleWorker<'f> {
    synth: &'f Synth<f64>,
    paths: ScattererPaths,
    block: BlockPaths<f64>,
    grids: Grids<f64>,
    scratch: SynthScratch<f64>,
    bands: Option<Bands<f64>>,
    joint: Option<(&'f Joint, Joined)>,
}

impl SingleEcho {
    pub fn new(synth: Synth<f64>) -> Self {
        Self { synth, joint: None }
    }

    /// The same where no two emissions are alike.
    pub fn joining(self, joint: Joint) -> Self {
        Self { joint: Some(joint), ..self }
    }
}

impl EchoEngine for SingleEcho {
    fn fft_len(&self) -> usize {
        self.joint.as_ref().map_or(self.synth.fft_len(), Joint::out_len)
    }

    fn needs(&self) -> Needs {
        Needs { pulse_bytes: self.synth.pulse_bytes(), lists: 1, panel_pulses: 1 }
    }

    fn worker<'f>(&'f self, paths: &PathGenerator) -> Box<dyn EchoWorker + 'f> {
        let synth = &self.synth;
        Box::new(SingleWorker {
            synth,
            paths: full_list(paths),
            block: synth.block(),
            grids: synth.grids(),
            scratch: synth.scratch(),
            bands: synth.settings().band_hz.map(|_| synth.bands()),
            joint: self.joint.as_ref().map(|joint| (joint, joint.joined(synth.fft_len()))),
        })
    }
}

impl EchoWorker for SingleWorker<'_> {
    fn fill(&mut self, index: u64, pulse: &mut Pulse, desk: &mut Desk<'_>) -> Result<(), PulseError> {
        if self.joint.is_some() {
            return self.fill_joint(index, pulse, desk);
        }
        let Self { synth, paths, block, grids, scratch, bands, .. } = self;
        let Desk { paths: generator, memory, spectrum } = desk;
        generator.pulse(index, memory, paths, pulse)?;
        let (starts_s, costs) = (pulse.window_starts_s(), &mut memory.costs);
        let own = synth.in_turn(generator.number_of(index));
        if own.is_some() {
            receives_one(index, paths)?;
        }
        let found = if let (Some(band_hz), Some(bands)) = (synth.settings().band_hz, bands.as_mut()) {
            let found = synth.pulse_in_bands(own, paths, starts_s, band_hz, bands, spectrum)?;
            costs.lap(Stage::Spread);
            check(found)?;
            found
        } else {
            synth.fill_radiated(own, &[Node { pulse: 0, paths }], starts_s.as_chunks::<1>().0, block)?;
            check(block.found())?;
            costs.lap(Stage::Fill);
            synth.spread(block, grids);
            costs.lap(Stage::Spread);
            synth.spectrum(block, grids, 0, scratch, spectrum);
            costs.lap(Stage::Transform);
            block.found()
        };
        costs.accumulated(found.spread);
        Ok(())
    }
}

impl SingleWorker<'_> {
    /// A pulse from the emissions that it receives, each by itself.
    fn fill_joint(&mut self, index: u64, pulse: &mut Pulse, desk: &mut Desk<'_>) -> Result<(), PulseError> {
        let Self { synth, paths, block, grids, scratch, bands, joint } = self;
        let Some((joint, joined)) = joint else { return Ok(()) };
        let Desk { paths: generator, memory, spectrum } = desk;
        let emissions = generator.emissions_of_pulse(index, memory, pulse)?;
        let (starts_s, windows) = (pulse.window_starts_s(), generator.pair_windows());
        let channels = generator.channel_pairs().len();
        joined.clear(channels);
        for emitted in emissions {
            generator.paths_of_emission((index, emitted), starts_s, memory, paths)?;
            let own = joint.waveform.of_emission(generator.number_of(emitted))?;
            let Some(own) = own.filter(|_| !paths.is_empty()) else { continue };
            let offset_s = generator.offset_s(index, emitted);
            let origin_s = [offset_s + joint.span.origin_s];
            let mut bins = vec![Complex64::ZERO; channels * synth.fft_len()];
            let found = if let (Some(band_hz), Some(bands)) = (synth.settings().band_hz, bands.as_mut()) {
                synth.pulse_in_bands(Some(own.as_ref()), paths, &origin_s, band_hz, bands, &mut bins)?
            } else {
                synth.fill_radiated(Some(own.as_ref()), &[Node { pulse: 0, paths }], &[origin_s], block)?;
                synth.spread(block, grids);
                synth.spectrum(block, grids, 0, scratch, &mut bins);
                block.found()
            };
            check(found)?;
            let of_channels = channel_starts(starts_s, &windows, generator.channel_pairs());
            joined.take(&mut Vec::new(), (emitted, offset_s), of_channels, |out| {
                out.copy_from_slice(&bins);
                Ok::<_, PulseError>(())
            })?;
            memory.costs.lap(Stage::Spread);
            memory.costs.accumulated(found.spread);
        }
        for (channel, out) in spectrum.chunks_exact_mut(joint.out_len()).enumerate() {
            joined.spectrum(channel, out);
        }
        memory.costs.lap(Stage::Transform);
        Ok(())
    }
}
