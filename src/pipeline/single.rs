//! Pulses one by one, in f64: exact scatterer paths, spread and transformed without a digit lost, for budgets
//! that blocks cannot keep.

use num_complex::Complex64;

use crate::echo::synth::bands::Bands;
use crate::echo::synth::block::{BlockPaths, Node};
use crate::echo::synth::{Grids, Synth, SynthScratch};
use crate::paths::list::ScattererPaths;
use crate::paths::{PathGenerator, Workspace};
use crate::pipeline::block::check;
use crate::pipeline::fault::PulseError;
use crate::pulse::Pulse;
use crate::pulse::costs::Stage;

/// Makes echoes pulse by pulse. Immutable, shared by all threads.
pub(crate) struct SingleEcho {
    synth: Synth<f64>,
}

/// Memory of one thread.
pub(crate) struct SingleWork {
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

    pub fn fft_len(&self) -> usize {
        self.synth.fft_len()
    }

    pub fn work(&self, paths: ScattererPaths) -> SingleWork {
        SingleWork {
            paths,
            block: self.synth.block(),
            grids: self.synth.grids(),
            scratch: self.synth.scratch(),
            bands: self.synth.settings().band_hz.map(|_| self.synth.bands()),
        }
    }

    /// Fills the record of a pulse and the spectrum of its echo.
    ///
    /// # Errors
    /// A track that ends early, or paths that cannot be placed on the grid.
    pub fn make(
        &self,
        generator: &PathGenerator,
        index: u64,
        pulse: &mut Pulse,
        memory: &mut Workspace,
        work: &mut SingleWork,
        spectrum: &mut [Complex64],
    ) -> Result<(), PulseError> {
        let SingleWork { paths, block, grids, scratch, bands } = work;
        generator.pulse(index, memory, paths, pulse)?;
        if let (Some(band_hz), Some(bands)) = (self.synth.settings().band_hz, bands) {
            let starts_s = pulse.window_starts_s();
            let found = self.synth.pulse_in_bands(paths, starts_s, band_hz, bands, spectrum)?;
            memory.costs.lap(Stage::Spread);
            memory.costs.accumulated(found.spread);
            return check(found);
        }
        let starts_s = pulse.window_starts_s().as_chunks::<1>().0;
        self.synth.fill_in(&[Node { pulse: 0, paths }], starts_s, block)?;
        check(block.found())?;
        memory.costs.lap(Stage::Fill);
        self.synth.spread(block, grids);
        memory.costs.lap(Stage::Spread);
        self.synth.spectrum(block, grids, 0, scratch, spectrum);
        memory.costs.lap(Stage::Transform);
        memory.costs.accumulated(block.found().spread);
        Ok(())
    }
}
