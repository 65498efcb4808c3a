//! The contacts of a pulse as a node of a block: always the same ones, in the same order, so that what lies between two
//! nodes can be interpolated.
//!
//! Every facet of a patch in the order of its places, then the targets, then the direct path; those that are dark, hidden or far
//! from the window have zero amplitude or a delay that the echo leaves out, but they are there.

use num_complex::Complex64;

use super::facets::Lighting;
use super::window::Window;
use super::{Illumination, Workspace};
use crate::pulse::costs::Stage;
use crate::pulse::{Pulse, flags};
use crate::radar::fault::RadarError;
use crate::scattering::contact::Contacts;
use crate::scene::Patch;
use crate::scene::radar::TxPolarisation;

impl Illumination {
    /// Whether the windows of some pulses hear nothing but their own emissions, in all polarisations and at equal intervals,
    /// from facets that keep their phases and that no update of the shadows bends: then their contacts can be interpolated.
    pub fn hears_itself(&self, pulses: &[u64], workspace: &mut Workspace) -> Result<bool, RadarError> {
        let even = self.radar.emissions.is_uniform();
        let forgets = self.sea.as_ref().is_some_and(|sea| sea.forgets());
        if forgets || !even || !matches!(self.radar.tx_polarisation, TxPolarisation::Simultaneous) {
            return Ok(false);
        }
        for &index in pulses {
            self.evaluate(index, &mut workspace.own)?;
            let window = Window::new(&self.radar, self.window_start_of(index)?, self.pulse_length_s);
            let audible = self.audible(index, &workspace.own, &window)?;
            if audible.start < index || audible.end > index + 1 {
                return Ok(false);
            }
        }
        let (Some(&first), Some(&last)) = (pulses.first(), pulses.last()) else { return Ok(true) };
        let Workspace { own, sea: work, costs, .. } = workspace;
        let (Some(sea), Some(work)) = (&self.sea, work) else { return Ok(true) };
        self.evaluate(first, own)?;
        let lighting = self.lighting(first, first, own, Window::UNBOUNDED);
        let to_s = self.radar.emissions.interval_s(0, last);
        costs.lap(Stage::Record);
        let straight = sea.weights_run_straight(&lighting, to_s, work);
        costs.lap(Stage::Shadow);
        straight.map_err(|failure| self.sea_error(first, failure))
    }

    /// Start of the window of a pulse after its emission, s.
    pub fn window_start_of(&self, index: u64) -> Result<f64, RadarError> {
        self.window_start_s(index, self.radar.emissions.emission(self.start, index))
    }

    /// The patch at a pulse; `None` for a scene without sea.
    pub fn patch_of(&self, index: u64) -> Result<Option<Patch>, RadarError> {
        let Some(sea) = &self.sea else { return Ok(None) };
        let t = self.radar.emissions.emission(self.start, index);
        let patch = sea.patch_at(&self.surroundings(), t);
        Ok(Some(patch.map_err(|failure| self.track_error(index, failure))?))
    }

    /// Index, time, window start, navigation, phase centres and target truth of a pulse, without its contacts;
    /// see [`Self::pulse`].
    pub fn record(
        &self,
        index: u64,
        workspace: &mut Workspace,
        record: &mut Pulse,
    ) -> Result<(), RadarError> {
        if index >= self.pulses {
            return Err(RadarError::NoSuchPulse { index, pulses: self.pulses });
        }
        let Workspace { own, amplitude, costs, .. } = workspace;
        self.evaluate(index, own)?;
        self.fill_record(index, own, record)?;
        let window = Window::new(&self.radar, record.window_start_s, self.pulse_length_s);
        let lighting = self.lighting(index, index, own, window);
        for (contact, paths) in own.paths.chunks_exact(self.pairs.len().max(1)).enumerate() {
            if self.weigh(&lighting, contact, paths, amplitude) {
                record.flags |= flags::OUTSIDE_WINDOW;
            }
        }
        costs.lap(Stage::Record);
        Ok(())
    }

    /// Everything that the emission of a pulse lights, over a given patch.
    pub fn node(
        &self,
        index: u64,
        patch: Option<&Patch>,
        workspace: &mut Workspace,
        contacts: &mut Contacts,
    ) -> Result<(), RadarError> {
        if index >= self.pulses {
            return Err(RadarError::NoSuchPulse { index, pulses: self.pulses });
        }
        let Workspace { own, amplitude, sea: work, costs, .. } = workspace;
        contacts.clear();
        self.evaluate(index, own)?;
        let lighting = self.lighting(index, index, own, Window::UNBOUNDED);
        if let (Some(sea), Some(work), Some(patch)) = (&self.sea, work, patch) {
            contacts.resize(patch.len());
            let mut lit = 0;
            sea.visit_all(&lighting, patch, work, costs, |chunk| {
                for (place, &facet) in chunk.index.iter().enumerate() {
                    for (pair, columns) in chunk.pairs.iter().enumerate() {
                        contacts.delay_s[pair][facet] = columns.delay_s[place];
                        contacts.delay_rate[pair][facet] = columns.delay_rate[place];
                    }
                    for (column, amplitude) in contacts.amplitude.iter_mut().zip(&chunk.amplitude) {
                        column[facet] = amplitude[place];
                    }
                    lit += usize::from(chunk.amplitude.iter().any(|a| a[place] != Complex64::ZERO));
                }
            })
            .map_err(|failure| self.sea_error(index, failure))?;
            costs.looked_at(patch.len(), lit, 0);
        }
        self.append_every(&lighting, amplitude, contacts);
        costs.lap(Stage::Contacts);
        Ok(())
    }

    /// Appends targets and direct paths whether they sound or not.
    fn append_every(&self, lighting: &Lighting, amplitude: &mut [Complex64], contacts: &mut Contacts) {
        for (contact, paths) in lighting.emission.paths.chunks_exact(self.pairs.len().max(1)).enumerate() {
            self.weigh(lighting, contact, paths, amplitude);
            contacts.push(lighting.offset_s, paths.iter().map(|p| (p.delay_s, p.delay_rate)), amplitude);
        }
    }
}
