//! Pulses one by one, in f64: exact scatterer paths, spread and transformed without a digit lost, for budgets
//! that blocks cannot keep.

use crate::echo::synth::bands::Bands;
use crate::echo::synth::block::{BlockPaths, Node};
use crate::echo::synth::{Grids, Synth, SynthScratch};
use crate::paths::PathGenerator;
use crate::paths::list::ScattererPaths;
use crate::pipeline::block::check;
use crate::pipeline::engine::{EchoEngine, EchoWorker, Needs, full_list};
use crate::pipeline::fault::PulseError;
use crate::pipeline::kit::Desk;
use crate::pulse::Pulse;
use crate::pulse::costs::Stage;

/// Makes echoes pulse by pulse. Immutable, shared by all threads.
pub(crate) struct SingleEcho {
    synth: Synth<f64>,
}

struct SingleWorker<'f> {
    synth: &'f Synth<f64>,
    paths: ScattererPaths,
    block: BlockPaths<f64>,
    grids: Grids<f64>,
    scratch: SynthScratch<f64>,
    bands: Option<Bands<f64>>,
}

impl SingleEcho {
    pub fn new(synth: Synth<f64>) -> Self {
        Self { synth }
    }
}

impl EchoEngine for SingleEcho {
    fn fft_len(&self) -> usize {
        self.synth.fft_len()
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
        })
    }
}

impl EchoWorker for SingleWorker<'_> {
    fn fill(&mut self, index: u64, pulse: &mut Pulse, desk: &mut Desk<'_>) -> Result<(), PulseError> {
        let Self { synth, paths, block, grids, scratch, bands } = self;
        let Desk { paths: generator, memory, spectrum } = desk;
        generator.pulse(index, memory, paths, pulse)?;
        let (starts_s, costs) = (pulse.window_starts_s(), &mut memory.costs);
        let found = if let (Some(band_hz), Some(bands)) = (synth.settings().band_hz, bands.as_mut()) {
            let found = synth.pulse_in_bands(paths, starts_s, band_hz, bands, spectrum)?;
            costs.lap(Stage::Spread);
            check(found)?;
            found
        } else {
            synth.fill_in(&[Node { pulse: 0, paths }], starts_s.as_chunks::<1>().0, block)?;
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
