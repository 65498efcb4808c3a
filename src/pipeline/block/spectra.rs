//! From the grids of a block to the spectrum of a pulse.

use num_complex::Complex64;

use super::{BlockEcho, BlockWork, check};
use crate::pipeline::engine::receives_one;
use crate::pipeline::fault::PulseError;
use crate::pipeline::kit::Desk;
use crate::pulse::Pulse;
use crate::pulse::costs::Stage;

impl BlockEcho {
    /// The spectra of a pulse of the block at hand, by its index and by the number of its emission: of what
    /// that radiated.
    pub(super) fn spectrum_of(
        &self,
        (index, number): (u64, u64),
        spectrum: &mut [Complex64],
        work: &mut BlockWork,
    ) {
        let BlockWork { made, frame, grids, scratch, of_turns, .. } = work;
        let at = (index - made.start) as usize;
        let Some(own) = self.synth.in_turn(number) else {
            return self.synth.spectrum_in(frame, grids, at, scratch, spectrum);
        };
        let replicas = of_turns.entry(number % self.synth.turns()).or_insert_with(|| {
            let mut replicas = Vec::new();
            self.synth.replicas_of(own, frame.mean_hz(), &mut replicas);
            replicas
        });
        self.synth.spectrum_by(replicas, (frame, at), grids, scratch, spectrum);
    }

    /// A pulse by itself, in bands of Doppler.
    ///
    /// # Errors
    /// A track that ends early, or paths that cannot be followed.
    pub(super) fn fill_in_bands(
        &self,
        (index, pulse): (u64, &mut Pulse),
        band_hz: f64,
        desk: &mut Desk<'_>,
        work: &mut BlockWork,
    ) -> Result<(), PulseError> {
        let Desk { paths: generator, memory, spectrum } = desk;
        let (paths, Some(bands)) = (&mut work.nodes[0], &mut work.bands) else { return Ok(()) };
        generator.pulse(index, memory, paths, pulse)?;
        let own = self.synth.in_turn(generator.number_of(index));
        if own.is_some() {
            receives_one(index, paths)?;
        }
        let starts_s = pulse.window_starts_s();
        let found = self.synth.pulse_in_bands(own, paths, starts_s, band_hz, bands, spectrum)?;
        check(found)?;
        memory.costs.lap(Stage::Spread);
        memory.costs.accumulated(found.spread);
        Ok(())
    }
}
