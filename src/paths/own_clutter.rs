//! What returns an echo to a pulse from its own emission alone, all over the beam: rain and the far sea.

use super::{PathGenerator, Workspace};
use crate::paths::drops;
use crate::paths::list::ScattererPaths;
use crate::radar::fault::RadarError;

/// Cells of a sample, nearly.
const SAMPLED_CELLS: f64 = 400.0;

impl PathGenerator {
    /// Points of a pulse for which there is room beforehand: as many as there are unless a beam turns into
    /// it.
    pub fn own_clutter_room(&self) -> usize {
        (if self.rains() { drops::MOST } else { 0 }) + self.far_room()
    }

    /// Of how many cells of the far sea one has a say where a sample is enough: in means and predictions.
    pub fn far_sample(&self) -> usize {
        // Odd, so that it takes both halves of squares.
        self.far_cells().map_or(1, |(cells, _)| (cells / SAMPLED_CELLS) as usize | 1)
    }

    /// Fills `paths` with rain if it is asked for, and with one of so many cells of the far sea, which has
    /// the power of as many; with none of them for 0.
    ///
    /// # Errors
    /// A pulse that the tracks do not cover.
    pub fn some_clutter_at(
        &self,
        index: u64,
        (rain, far_every): (bool, usize),
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        paths.clear();
        if rain {
            self.rain_at(index, workspace, paths)?;
        }
        if far_every > 0 {
            self.far_sea_at((index, far_every), workspace, paths)?;
        }
        Ok(())
    }

    /// Whether it fills the window, whatever else there is.
    pub(super) fn fills_window(&self) -> bool {
        self.scene_has_far_sea || self.radar.rain_clutter.is_some()
    }
}
