//! What a worker has at hand whatever its engine: buffers of scatterer paths, a spectrum to fill, and the way
//! from there to samples.

use num_complex::Complex64;

use super::fault::PulseError;
use crate::paths::{PathGenerator, Workspace};
use crate::pipeline::hull_scatterers::ShipTracks;
use crate::pulse::Pulse;
use crate::pulse::costs::{Costs, Stage};
use crate::radar::calibration::{GeneratorScratch, Generators};
use crate::radar::clock::{ChannelClock, RunningClocks};
use crate::radar::dechirp::{Dechirp, DechirpScratch};
use crate::radar::receiver::{Receiver, ReceiverScratch};
use std::sync::Arc;

/// From the spectra of echoes to samples. Immutable, shared by all threads.
#[derive(Clone)]
pub(crate) struct Reception {
    pub receiver: Receiver,
    /// Between the front end's spectra and the receiver's; `None` where these are one.
    pub dechirp: Option<Dechirp>,
    pub ships: ShipTracks,
    pub clocks: Option<Arc<RunningClocks>>,
    pub generators: Option<Generators>,
}

impl Reception {
    /// Bins of the spectra of echoes.
    pub fn echo_bins(&self) -> usize {
        self.dechirp.as_ref().map_or(self.receiver.fft_len(), Dechirp::wide_len)
    }
}

/// What an engine has at hand.
pub(crate) struct Desk<'f> {
    /// Says what is where at a pulse.
    pub paths: &'f PathGenerator,
    /// Its buffers, and what pulses have cost.
    pub memory: Workspace,
    /// Of its channels that carry echoes: what it fills.
    pub spectrum: Vec<Complex64>,
}

impl<'f> Desk<'f> {
    /// For spectra of so many bins.
    pub fn new(paths: &'f PathGenerator, fft_len: usize) -> Self {
        let bins = paths.channel_pairs().len() * fft_len;
        Self { paths, memory: paths.workspace(), spectrum: vec![Complex64::ZERO; bins] }
    }
}

/// Adds what is received besides the radar's own echoes, in one thread.
pub(crate) trait Listen: Send {
    /// Goes by the tracks that are flown.
    fn take_off(&mut self);

    /// Adds what the windows of a pulse receive to the spectra of its channels.
    ///
    /// # Errors
    /// Paths that cannot be followed.
    fn add(
        &mut self,
        pulse: &mut Pulse,
        spectrum: &mut [Complex64],
        costs: &mut Costs,
    ) -> Result<(), PulseError>;
}

/// What one worker has at hand.
pub(crate) struct Kit<'f> {
    /// Of the radar's own echoes.
    pub desk: Desk<'f>,
    /// What is received besides.
    others: Vec<Box<dyn Listen + 'f>>,
    reception: &'f Reception,
    mixer: Option<DechirpScratch>,
    /// Of the receiver, and the levels that it met.
    pub scratch: ReceiverScratch,
    clocks: Vec<ChannelClock>,
    generators: GeneratorScratch,
}

impl<'f> Kit<'f> {
    pub fn new(
        paths: &'f PathGenerator,
        others: Vec<Box<dyn Listen + 'f>>,
        reception: &'f Reception,
    ) -> Self {
        let Reception { receiver, generators, dechirp, .. } = reception;
        let channels = paths.channel_pairs().len();
        Self {
            desk: Desk::new(paths, reception.echo_bins()),
            others,
            reception,
            mixer: dechirp.as_ref().map(Dechirp::scratch),
            scratch: receiver.scratch(),
            clocks: Vec::with_capacity(channels),
            generators: generators.as_ref().map_or_else(GeneratorScratch::default, |of| of.scratch(receiver)),
        }
    }

    /// Goes by the tracks that are flown.
    pub fn take_off(&mut self, paths: &'f PathGenerator) {
        self.desk.paths = paths;
        self.others.iter_mut().for_each(|other| other.take_off());
    }

    /// Finishes a pulse whose record and spectrum are filled.
    ///
    /// # Errors
    /// A track that ends early; what emitters are received by cannot be followed.
    pub fn receive(&mut self, pulse: &mut Pulse) -> Result<(), PulseError> {
        let Self { desk, others, reception, mixer, scratch, clocks, generators } = self;
        let Desk { paths, memory, spectrum } = desk;
        if let Some(by) = reception.receiver.transmitted(pulse.index) {
            spectrum.iter_mut().for_each(|bin| *bin *= by);
        }
        for other in others {
            other.add(pulse, spectrum, &mut memory.costs)?;
        }
        reception.ships.record(pulse);
        if let Some(running) = &reception.clocks {
            // Echoes were made for the window as it is; recorded is what the clocks say.
            paths.record_nominal(pulse)?;
            running.channels(pulse.index, pulse.window_starts_s(), clocks);
        }
        let spectrum = match (&reception.dechirp, mixer) {
            (Some(dechirp), Some(mixer)) => {
                dechirp.place(pulse);
                dechirp.apply(spectrum, pulse, mixer)
            }
            _ => &mut spectrum[..],
        };
        reception.receiver.receive_by(clocks, spectrum, pulse, scratch);
        if let Some(made) = &reception.generators {
            made.fill(&reception.receiver, pulse, generators, scratch);
        }
        memory.costs.lap(Stage::Receive);
        memory.costs.made();
        Ok(())
    }
}
