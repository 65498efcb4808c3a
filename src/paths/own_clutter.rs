//! What returns an echo to a pulse from its own emission alone, all over the beam: rain and the far sea.

use super::{PathGenerator, Workspace};
use crate::paths::drops;
use crate::paths::list::ScattererPaths;
use crate::radar::fault::RadarError;

impl PathGenerator {
    /// Points of it at a pulse, mean.
    pub fn own_clutter_points(&self) -> f64 {
        self.drops() + self.far_cells().map_or(0.0, |(cells, _)| cells)
    }

    /// Points of a pulse for which there is room beforehand: as many as there are unless a beam turns into
    /// it.
    pub fn own_clutter_room(&self) -> usize {
        (if self.rains() { drops::MOST } else { 0 }) + self.far_room()
    }

    /// Fills `paths` with it.
    ///
    /// # Errors
    /// A pulse that the tracks do not cover.
    pub fn own_clutter_at(
        &self,
        index: u64,
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        self.some_clutter_at(index, (true, 1), workspace, paths)
    }

    /// The same of rain if it is asked for, and of one of so many cells of the far sea, with the power of as
    /// many; of none of them for 0.
    ///
    /// # Errors
    /// Those of [`Self::own_clutter_at`].
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
