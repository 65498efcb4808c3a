//! The neck between what is emulated and how it is computed: states of scatterers in, pulses out.
//!
//! An [`EchoEngine`] cuts a run into segments, pulses that it makes at once, by their numbers alone. Whoever
//! makes pulses asks for whole segments where it can, and for parts where it must: the bits are the same.

use std::ops::Range;
use std::sync::Arc;

use num_complex::Complex64;

use super::fault::PulseError;
use super::kit::{Desk, Kit};
use crate::echo::reference::ReferenceEcho;
use crate::fidelity::echo_settings::EchoSettings;
use crate::paths::PathGenerator;
use crate::paths::list::ScattererPaths;
use crate::pulse::Pulse;
use crate::pulse::costs::Stage;
use crate::radar::waveform::Waveform;

/// Slots of pulses that follow each other.
pub(crate) type Slots<'p> = &'p mut dyn Iterator<Item = &'p mut Pulse>;

/// From states of scatterers to pulses. Immutable, shared by all threads.
pub(crate) trait EchoEngine: Send + Sync {
    /// Bins of the spectrum of a channel.
    fn fft_len(&self) -> usize;

    /// Pulses of a segment.
    fn segment_pulses(&self) -> u64 {
        1
    }

    /// The segment that holds a pulse. The last one of a run may reach beyond it.
    fn segment_of(&self, index: u64) -> Range<u64> {
        let first = index - index % self.segment_pulses();
        first..first.saturating_add(self.segment_pulses())
    }

    /// What its workers take of memory.
    fn needs(&self) -> Needs {
        Needs { pulse_bytes: 0, lists: 1, panel_pulses: 1 }
    }

    /// Grids of one worker, bytes.
    fn grid_bytes(&self) -> u64 {
        self.segment_pulses().saturating_mul(self.needs().pulse_bytes)
    }

    /// The same with other nodes; `None` where it has none, or cannot have these.
    fn with_nodes(&self, _chosen: &EchoSettings) -> Option<Arc<dyn EchoEngine>> {
        None
    }

    /// What makes pulses for one thread, of paths much like these.
    fn worker<'f>(&'f self, paths: &PathGenerator) -> Box<dyn EchoWorker + 'f>;
}

/// An engine with the memory of one thread.
pub(crate) trait EchoWorker: Send {
    /// Makes pulses of a segment, the whole of it or a part, in as many slots: fills the record of each and
    /// the spectrum of its echo, and has it received.
    ///
    /// # Errors
    /// Those of [`Self::fill`].
    fn make(&mut self, pulses: Range<u64>, slots: Slots<'_>, kit: &mut Kit<'_>) -> Result<(), PulseError> {
        for (index, pulse) in pulses.zip(slots) {
            self.fill(index, pulse, &mut kit.desk)?;
            kit.receive(pulse)?;
        }
        Ok(())
    }

    /// Fills the record of a pulse and the spectrum of its echo; of an emitter's only the spectrum, in the
    /// windows of the record.
    ///
    /// # Errors
    /// A pulse that the run does not have, a track that ends early, paths that cannot be followed.
    fn fill(&mut self, index: u64, pulse: &mut Pulse, desk: &mut Desk<'_>) -> Result<(), PulseError>;
}

/// What a worker of an engine takes of memory.
pub(crate) struct Needs {
    /// Grids of a pulse, bytes; 0 without grids.
    pub pulse_bytes: u64,
    /// Lists of scatterer paths.
    pub lists: usize,
    /// Pulses whose panels of ships are found together.
    pub panel_pulses: usize,
}

/// A list with room for so many paths.
pub(crate) fn path_list(paths: &PathGenerator, capacity: usize) -> ScattererPaths {
    ScattererPaths::new(paths.pairs().len(), paths.channel_pairs().len(), capacity)
}

/// A list with room for every facet, target and direct path, of a pulse and of two neighbours.
pub(crate) fn full_list(paths: &PathGenerator) -> ScattererPaths {
    path_list(paths, point_paths(paths) + paths.facets())
}

/// Most paths of targets and the direct path, of a pulse and of two neighbours.
pub(crate) fn point_paths(paths: &PathGenerator) -> usize {
    3 * (paths.target_count() + 1)
}

/// Refuses paths of other emissions than a pulse's own, whose waveform is another.
pub(super) fn receives_one(pulse: u64, paths: &ScattererPaths) -> Result<(), PulseError> {
    match paths.emission_offset_s.iter().any(|offset_s| *offset_s != 0.0) {
        true => Err(PulseError::SeveralInTurn { pulse }),
        false => Ok(()),
    }
}

impl EchoEngine for ReferenceEcho {
    fn fft_len(&self) -> usize {
        self.fft_len()
    }

    fn worker<'f>(&'f self, paths: &PathGenerator) -> Box<dyn EchoWorker + 'f> {
        Box::new(ReferenceWorker { echo: self, paths: full_list(paths) })
    }
}

struct ReferenceWorker<'f> {
    echo: &'f ReferenceEcho,
    paths: ScattererPaths,
}

impl EchoWorker for ReferenceWorker<'_> {
    fn fill(&mut self, index: u64, pulse: &mut Pulse, desk: &mut Desk<'_>) -> Result<(), PulseError> {
        let Desk { paths: generator, memory, spectrum } = desk;
        generator.pulse(index, memory, &mut self.paths, pulse)?;
        if !self.echo.waveform().is_one() {
            receives_one(index, &self.paths)?;
        }
        let number = generator.number_of(index);
        self.echo.spectrum_of(number, &self.paths, pulse.window_starts_s(), spectrum)?;
        memory.costs.lap(Stage::Spread);
        memory.costs.accumulated(self.paths.len() * generator.pairs().len());
        Ok(())
    }
}

/// The reference of a train of which no two emissions are alike.
pub(crate) struct JointReference {
    pub echo: ReferenceEcho,
    pub waveform: Arc<dyn Waveform>,
}

struct JointReferenceWorker<'f> {
    of: &'f JointReference,
    paths: ScattererPaths,
}

impl EchoEngine for JointReference {
    fn fft_len(&self) -> usize {
        self.echo.fft_len()
    }

    fn worker<'f>(&'f self, paths: &PathGenerator) -> Box<dyn EchoWorker + 'f> {
        Box::new(JointReferenceWorker { of: self, paths: full_list(paths) })
    }
}

impl EchoWorker for JointReferenceWorker<'_> {
    fn fill(&mut self, index: u64, pulse: &mut Pulse, desk: &mut Desk<'_>) -> Result<(), PulseError> {
        let Self { of: JointReference { echo, waveform }, paths } = self;
        let Desk { paths: generator, memory, spectrum } = desk;
        spectrum.fill(Complex64::ZERO);
        for emitted in generator.emissions_of_pulse(index, memory, pulse)? {
            let starts_s = pulse.window_starts_s();
            generator.paths_of_emission((index, emitted), starts_s, memory, paths)?;
            if let Some(own) = waveform.of_emission(generator.number_of(emitted))? {
                echo.add_spectrum(own.as_ref(), paths, starts_s, spectrum);
            }
            memory.costs.lap(Stage::Spread);
            memory.costs.accumulated(paths.len() * generator.pairs().len());
        }
        Ok(())
    }
}
