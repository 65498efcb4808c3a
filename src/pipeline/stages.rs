//! Physics dressed as a stage: from a pulse number to a finished pulse.
//!
//! ```text
//! tracks -> illumination -> contacts -> reference echo -> spectrum -> receiver -> samples
//! ```
//!
//! A pulse depends on its number alone, so any thread may make any pulse and the bits are the same.

use std::sync::Arc;

use num_complex::{Complex32, Complex64};

use crate::echo::reference::ReferenceEcho;
use crate::pulse::{Layout, Pulse};
use crate::radar::fault::RadarError;
use crate::radar::illumination;
use crate::radar::illumination::Illumination;
use crate::radar::illumination::snapshot::Snapshot;
use crate::radar::receiver::{Receiver, ReceiverScratch};
use crate::radar::waveform::Waveform;
use crate::scattering::contact::Contacts;

/// Makes pulses. Immutable, shared by all threads.
pub struct PulseFactory {
    pub(super) illumination: Illumination,
    pub(super) echo: ReferenceEcho,
    pub(super) receiver: Receiver,
    pub(super) waveform: Arc<dyn Waveform>,
    pub(super) layout: Layout,
}

/// What one thread needs to make pulses without allocating.
pub struct Workspace {
    illumination: illumination::Workspace,
    contacts: Contacts,
    spectrum: Vec<Complex64>,
    receiver: ReceiverScratch,
}

impl PulseFactory {
    /// Sizes of the pulses made.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// An empty slot for a pulse.
    pub fn slot(&self) -> Pulse {
        Pulse::new(&self.layout)
    }

    /// The transmitted pulse after the receive filter; see [`Receiver::replica`].
    pub fn replica(&self) -> Vec<Complex32> {
        self.receiver.replica(&*self.waveform)
    }

    /// Targets whose whole echo lies in the window of a pulse, in the best pair.
    pub fn targets_in_window(&self, pulse: &Pulse) -> usize {
        let targets = self.layout.targets;
        if targets == 0 {
            return 0;
        }
        let opens_s = pulse.window_start_s;
        let closes_s = opens_s + self.layout.samples as f64 / self.echo.sample_rate_hz();
        let whole = |delay_s: &&f64| (opens_s..=closes_s - self.waveform.duration_s()).contains(*delay_s);
        let pairs = pulse.target_delay_s.chunks_exact(targets);
        pairs.map(|delays_s| delays_s.iter().filter(whole).count()).max().unwrap_or(0)
    }

    /// The facets of the sea as a pulse's emission lights them; `None` for a scene without sea.
    pub fn snapshot(&self, index: u64, work: &mut Workspace) -> Result<Option<Snapshot>, RadarError> {
        self.illumination.snapshot(index, &mut work.illumination)
    }

    /// What comes and goes when a following patch moves by one row, dB below all that is heard, found at one pulse.
    /// `None` where the patch stays, or there is no sea.
    pub fn patch_edge_db(&self, index: u64, work: &mut Workspace) -> Result<Option<f64>, RadarError> {
        if !self.illumination.follows() {
            return Ok(None);
        }
        let snapshot = self.snapshot(index, work)?;
        Ok(snapshot.map(|snapshot| snapshot.edge_db(self.illumination.channel_pairs())))
    }

    /// Memory for one thread.
    pub fn workspace(&self) -> Workspace {
        // Every target and the direct path, of this pulse and of two neighbours, and every facet.
        let contacts = 3 * (self.layout.targets + 1) + self.illumination.facets();
        Workspace {
            illumination: self.illumination.workspace(),
            contacts: Contacts::new(self.layout.pairs, self.layout.channels, contacts),
            spectrum: vec![Complex64::ZERO; self.layout.channels * self.echo.fft_len()],
            receiver: self.receiver.scratch(),
        }
    }

    /// Makes pulse `index` in a slot of this factory's layout. Does not allocate once the workspace has
    /// seen the largest contact list. Tracks were checked to cover the run, so an error is a fault of the program or
    /// a pulse that the run does not have.
    pub fn make(&self, index: u64, pulse: &mut Pulse, work: &mut Workspace) -> Result<(), RadarError> {
        self.illumination.pulse(index, &mut work.illumination, &mut work.contacts, pulse)?;
        self.echo.spectrum(&work.contacts, pulse.window_start_s, &mut work.spectrum);
        self.receiver.receive(&mut work.spectrum, pulse, &mut work.receiver);
        Ok(())
    }
}
