//! The moving surface over a patch: what scatters, facet by facet, in the order of the patch.
//!
//! A [`Surface`] repeats with its grid; a patch is a window on it, placed anywhere by the global keys of its
//! facets. Fields of a sheet stand in arrays `[iy][ix]` over the patch. Ships add their waves to those of the
//! wind ([`FacetSurface::with_wakes`]); unlike these, they do not repeat. In f64 or f32.
//!
//! ```
//! use nereus::scene::Patch;
//! use nereus::scene::water::{Dispersion, WindProfile};
//! use nereus::sea::facet_surface::FacetSurface;
//! use nereus::sea::spectrum::FungLee;
//! use nereus::sea::surface::{Averaging, Grid, Selection, Surface};
//! use nereus::sea::wind::Wind;
//! let spectrum = FungLee::new(&Wind::from_speed(6.0, 10.0, WindProfile::Cardone, 0.0)?);
//! let grid = Grid::new(16, 16, 4.0)?;
//! let surface = Surface::synthesise(grid, &spectrum, Dispersion::default(), 1, Averaging::Automatic)?;
//! let patch = Patch::new([64.0, 64.0], 4.0, [1000.0, -36.0])?;
//! let mut sheet = FacetSurface::<f64>::new(&surface, Selection::HEIGHT);
//! let mut fields = sheet.fields(&patch);
//! sheet.evaluate(2.5, &patch, &mut fields)?;
//! let [x, y] = patch.centre_m(patch.key(37));
//! assert!((fields.height_m[37] - surface.at([x, y], 2.5).height_m).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::land::LandSheet;
use super::surface::choppy::Choppy;
use super::surface::fields::Real;
use super::surface::{Evaluator, Fields, Grid, Selection, Surface, SurfaceError};
use super::wake::{Map, Wake, WakeError};
use crate::scene::Patch;

/// Error of the wakes of a sheet over the root sum square of their waves, dB: below the rounding of what
/// follows, in f64 and in f32.
const WAKE_ERROR_DB: [f64; 2] = [-140.0, -95.0];

/// Evaluates a surface over patches; one per thread.
#[derive(Clone)]
pub struct FacetSurface<T: Real = f64> {
    grid: Grid,
    selection: Selection,
    evaluator: Evaluator<T>,
    /// `[iy][ix]` over the grid, for patches of another size; no room is taken before one is met.
    whole: Fields<T>,
    /// Time at which `whole` stands; `None` before it has room.
    time_s: Option<f64>,
    choppy: Option<Choppy>,
    wakes: Option<Wakes<T>>,
    land: Option<LandSheet>,
}

/// Waves of ships over patches of one size.
#[derive(Clone)]
pub(super) struct Wakes<T: Real = f64> {
    map: Map<T>,
    facets: usize,
}

impl<T: Real> FacetSurface<T> {
    /// For a surface, of which the selected fields are wanted.
    pub fn new(surface: &Surface, selection: Selection) -> Self {
        let grid = *surface.grid();
        let (evaluator, whole) = (Evaluator::new(surface), Fields::default());
        Self { grid, selection, evaluator, whole, time_s: None, choppy: None, wakes: None, land: None }
    }

    /// The same with short waves that relax at a rate, 1/s, for the modulation.
    pub fn with_relaxation(mut self, rate_per_s: Option<f64>) -> Self {
        if let Some(rate_per_s) = rate_per_s {
            self.evaluator = self.evaluator.with_relaxation(rate_per_s);
        }
        self
    }

    /// The same with choppy waves, if the sea has them.
    pub fn with_choppy(mut self, choppy: Option<Choppy>) -> Self {
        if choppy.is_some() {
            self.selection = self.selection.choppy();
        }
        self.choppy = choppy;
        self
    }

    /// The same with the waves of ships, over patches of the size of the given one.
    ///
    /// # Errors
    /// Wakes that cannot be prepared for such facets.
    pub fn with_wakes(mut self, wakes: &[Wake], patch: &Patch) -> Result<Self, WakeError> {
        self.wakes = None;
        if wakes.iter().any(|wake| !wake.nodes().is_empty()) {
            self.wakes = Some(Wakes::new(wakes, patch, WAKE_ERROR_DB[usize::from(size_of::<T>() == 4)])?);
        }
        Ok(self)
    }

    /// The same with land in place of water, if there is any.
    pub fn with_land(mut self, land: Option<&LandSheet>) -> Self {
        self.land = land.cloned();
        self
    }

    /// The land of the patch evaluated last.
    pub fn land(&self) -> Option<&LandSheet> {
        self.land.as_ref()
    }

    /// Room for the fields over a patch.
    pub fn fields(&self, patch: &Patch) -> Fields<T> {
        Fields::sized(patch.len(), self.selection)
    }

    /// Room for the slopes alone and what these need.
    pub(crate) fn room_for_slopes(&self, patch: &Patch) -> Fields<T> {
        if self.choppy.is_some() {
            return self.fields(patch);
        }
        let slope = [(); 2].map(|()| vec![T::default(); patch.len()]);
        Fields { slope, ..Fields::default() }
    }

    /// Fields at a time in seconds from t = 0, over a patch with the facets of the surface: those of `out`
    /// that have room. It must be for as many facets, which with ships are those of the patch that they
    /// were given.
    ///
    /// # Errors
    /// Fields of another size, or a time that is out of reach.
    pub fn evaluate(&mut self, time_s: f64, patch: &Patch, out: &mut Fields<T>) -> Result<(), WakeError> {
        self.evaluate_linear(time_s, patch, out)?;
        self.make_choppy(out);
        self.add_wakes(time_s, patch, out)?;
        self.lay_land(patch, out);
        Ok(())
    }

    /// The linear waves of the wind alone.
    ///
    /// # Errors
    /// Those of [`Self::evaluate`].
    pub(crate) fn evaluate_linear(
        &mut self,
        time_s: f64,
        patch: &Patch,
        out: &mut Fields<T>,
    ) -> Result<(), WakeError> {
        let grid = &self.grid;
        if patch.facets == [grid.nx(), grid.ny()] {
            let first = grid.index(patch.first);
            self.evaluator.evaluate_from([first % grid.nx(), first / grid.nx()], time_s, out)?;
        } else {
            if self.time_s.is_none() {
                self.whole = Fields::new(grid, self.selection);
            }
            if self.time_s != Some(time_s) {
                self.time_s = Some(f64::NAN);
                self.evaluator.evaluate(time_s, &mut self.whole)?;
                self.time_s = Some(time_s);
            }
            for (from, to) in self.whole.columns().into_iter().zip(out.columns_mut()) {
                if to.is_empty() {
                    continue;
                }
                if from.is_empty() || to.len() != patch.len() {
                    return Err(SurfaceError::FieldSize { found: to.len(), needed: patch.len() }.into());
                }
                for (iy, row) in to.chunks_exact_mut(patch.facets[0]).enumerate() {
                    let key = [patch.first[0], patch.first[1] + iy as i64];
                    go_round(grid, from, key, row, |to, from| to.copy_from_slice(from));
                }
            }
        }
        Ok(())
    }

    /// Linear waves become choppy ones, if the sea has them.
    pub(crate) fn make_choppy(&self, out: &mut Fields<T>) {
        if let Some(choppy) = &self.choppy {
            choppy.apply(out);
        }
    }

    /// Adds the waves of ships to the fields that have room.
    ///
    /// # Errors
    /// Those of [`Self::evaluate`].
    pub(crate) fn add_wakes(
        &mut self,
        time_s: f64,
        patch: &Patch,
        out: &mut Fields<T>,
    ) -> Result<(), WakeError> {
        self.wakes.as_mut().map_or(Ok(()), |wakes| wakes.add(time_s, patch, out))
    }

    /// Whether ships have waves here.
    pub(crate) fn has_wakes(&self) -> bool {
        self.wakes.is_some()
    }

    /// Land in place of water.
    pub(crate) fn lay_land(&mut self, patch: &Patch, out: &mut Fields<T>) {
        if let Some(land) = &mut self.land {
            land.place(patch);
            land.lay(out);
        }
    }
}

impl<T: Real> Wakes<T> {
    /// For patches of the size of the given one, with an error in dB over the root sum square of the waves.
    pub(super) fn new(wakes: &[Wake], patch: &Patch, error_db: f64) -> Result<Self, WakeError> {
        Ok(Self { map: Map::new(wakes.to_vec(), patch, error_db)?, facets: patch.len() })
    }

    /// Adds all waves at a time, s, to fields in the order of a patch.
    pub(super) fn add(&mut self, time_s: f64, patch: &Patch, out: &mut Fields<T>) -> Result<(), WakeError> {
        if patch.len() != self.facets {
            return Err(SurfaceError::FieldSize { found: patch.len(), needed: self.facets }.into());
        }
        self.map.add(patch.first, time_s, out)
    }
}

/// Hands over a row that begins at a global key piece by piece, going round the grid as often as it is long.
fn go_round<T>(grid: &Grid, from: &[T], key: [i64; 2], row: &mut [T], hand: impl Fn(&mut [T], &[T])) {
    let begin = grid.index([0, key[1]]);
    let line = &from[begin..begin + grid.nx()];
    let mut at = grid.index([key[0], 0]);
    let mut rest = row;
    while !rest.is_empty() {
        let count = rest.len().min(line.len() - at);
        let (now, later) = rest.split_at_mut(count);
        hand(now, &line[at..at + count]);
        (rest, at) = (later, 0);
    }
}
