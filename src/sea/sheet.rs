//! The moving surface over a patch: what scatters, facet by facet, in the order of the patch.
//!
//! A [`Surface`] repeats with its grid; a patch is a window on it, placed anywhere by the global keys of its
//! facets. Fields of a sheet stand in arrays `[iy][ix]` over the patch.
//!
//! ```
//! use nereus::scene::Patch;
//! use nereus::scene::water::{Dispersion, WindProfile};
//! use nereus::sea::sheet::Sheet;
//! use nereus::sea::spectrum::FungLee;
//! use nereus::sea::surface::{Averaging, Grid, Selection, Surface};
//! use nereus::sea::wind::Wind;
//! let spectrum = FungLee::new(&Wind::from_speed(6.0, 10.0, WindProfile::Cardone, 0.0)?);
//! let grid = Grid::new(16, 16, 4.0)?;
//! let surface = Surface::synthesise(grid, &spectrum, Dispersion::default(), 1, Averaging::Automatic)?;
//! let patch = Patch::new([64.0, 64.0], 4.0, [1000.0, -36.0])?;
//! let mut sheet = Sheet::new(&surface, Selection::HEIGHT);
//! let mut fields = sheet.fields(&patch);
//! sheet.evaluate(2.5, &patch, &mut fields)?;
//! let [x, y] = patch.centre_m(patch.key(37));
//! assert!((fields.height_m[37] - surface.at([x, y], 2.5).height_m).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::surface::{Evaluator, Fields, Grid, Selection, Surface, SurfaceError};
use crate::scene::Patch;

/// Evaluates a surface over patches; one per thread.
#[derive(Clone)]
pub struct Sheet {
    grid: Grid,
    selection: Selection,
    evaluator: Evaluator<f64>,
    /// `[iy][ix]` over the grid.
    whole: Fields<f64>,
    /// Time at which `whole` stands.
    time_s: Option<f64>,
}

impl Sheet {
    /// For a surface, of which the selected fields are wanted.
    pub fn new(surface: &Surface, selection: Selection) -> Self {
        let grid = *surface.grid();
        let whole = Fields::new(&grid, selection);
        Self { grid, selection, evaluator: Evaluator::new(surface), whole, time_s: None }
    }

    /// Room for the fields over a patch.
    pub fn fields(&self, patch: &Patch) -> Fields<f64> {
        Fields::sized(patch.len(), self.selection)
    }

    /// Fields at a time in seconds from t = 0, over a patch with the facets of the surface. `out` must have been made
    /// for as many facets.
    pub fn evaluate(
        &mut self,
        time_s: f64,
        patch: &Patch,
        out: &mut Fields<f64>,
    ) -> Result<(), SurfaceError> {
        if self.time_s != Some(time_s) {
            self.time_s = None;
            self.evaluator.evaluate(time_s, &mut self.whole)?;
            self.time_s = Some(time_s);
        }
        let grid = &self.grid;
        for (from, to) in self.whole.columns().into_iter().zip(out.columns_mut()) {
            if to.len() != if from.is_empty() { 0 } else { patch.len() } {
                return Err(SurfaceError::FieldSize { found: to.len(), needed: patch.len() });
            }
            for (iy, row) in to.chunks_exact_mut(patch.facets[0]).enumerate() {
                copy_row(grid, from, [patch.first[0], patch.first[1] + iy as i64], row);
            }
        }
        Ok(())
    }
}

/// Copies a row that begins at a global key, going round the grid as often as it is long.
fn copy_row(grid: &Grid, from: &[f64], key: [i64; 2], row: &mut [f64]) {
    let begin = grid.index([0, key[1]]);
    let line = &from[begin..begin + grid.nx()];
    let mut at = grid.index([key[0], 0]);
    let mut rest = row;
    while !rest.is_empty() {
        let count = rest.len().min(line.len() - at);
        let (now, later) = rest.split_at_mut(count);
        now.copy_from_slice(&line[at..at + count]);
        (rest, at) = (later, 0);
    }
}
