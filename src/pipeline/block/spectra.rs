//! From the grids of a block to the spectrum of a pulse.

use num_complex::Complex64;

use super::{BlockEcho, BlockWork, check};
use crate::pipeline::engine::receives_one;
use crate::pipeline::fault::PulseError;
use crate::pipeline::kit::Desk;
use crate::pulse::Pulse;
use crate::pulse::costs::Stage;

/// What takes the grids of the block at hand to spectra, by the pulses that leave in turn.
#[derive(Default)]
pub(super) struct Turned {
    replicas: Vec<(u64, Vec<Vec<Complex64>>)>,
    /// How many of them are of the block at hand.
    known: usize,
}

impl Turned {
    /// Forgets those of another block; their memory stays.
    pub(super) fn forget(&mut self) {
        self.known = 0;
    }

    fn of(&mut self, turn: u64, fill: impl FnOnce(&mut Vec<Vec<Complex64>>)) -> &[Vec<Complex64>] {
        let place = self.replicas[..self.known].iter().position(|(own, _)| *own == turn);
        let place = place.unwrap_or_else(|| {
            if self.known == self.replicas.len() {
                self.replicas.push((turn, Vec::new()));
            }
            let (own, replicas) = &mut self.replicas[self.known];
            *own = turn;
            fill(replicas);
            self.known += 1;
            self.known - 1
        });
        &self.replicas[place].1
    }
}

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
        let replicas = of_turns.of(number % self.synth.turns(), |replicas| {
            self.synth.replicas_of(own, frame.mean_hz(), replicas);
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
