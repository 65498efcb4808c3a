//! Land on a patch of sea, from a raster of heights.
//!
//! A facet is land where the mean height of its four corners lies above the sea; it then has that height and
//! the slopes between its corners, and rests: no waves of the wind or of ships reach it. Everything else
//! (light time, shadows and masks, horizon) takes it as a facet like others.
//!
//! A corner's height is the raster's, bilinear, at its latitude and longitude (`scene frame -> ECEF ->
//! WGS-84`), less the height of the sea; cells without data lie at it. Heights and slopes are rounded to f32
//! (3e-5 m at 500 m): both echoes then take the same ones.
//!
//! A facet of land has three random phases, by its global key: those of VV, of HH, and of both cross-polar
//! entries ([`crate::scattering::land`]).
//!
//! **Limits.** Land is seen, and hides facets, within the patch alone; all of the raster hides targets.
//! Nothing on it moves.

pub mod fault;
pub mod geotiff;
pub mod heights;
pub mod projection;
#[cfg(test)]
mod tests;
pub mod vertical;

use std::path::PathBuf;
use std::sync::Arc;

use fault::RasterFault;
use geotiff::Raster;

use super::surface::Fields;
use super::surface::fields::Real;
use crate::frames::SceneFrame;
use crate::inputs::shown;
use crate::rng::{Room, stream};
use crate::scene::Patch;
use crate::scene::land::Land;
use rand::Rng;

/// Points along a side of a patch at which it is looked whether the raster holds it.
const EDGE_POINTS: usize = 33;

/// Why there is no land.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("land.dem {}: {}", shown(path), .faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
pub struct LandError {
    /// The raster.
    pub path: PathBuf,
    /// What is wrong with it.
    pub faults: Vec<RasterFault>,
}

/// Heights above the sea at places of a scene.
#[derive(Debug)]
pub struct Dem {
    raster: Raster,
    frame: SceneFrame,
    sea_level_m: f64,
    seed: u64,
    top_m: f64,
}

impl Dem {
    /// Reads the raster of a land.
    ///
    /// # Errors
    /// All that is wrong with it; patches that it does not cover.
    pub fn open(land: &Land, frame: SceneFrame, seed: u64, patches: &[Patch]) -> Result<Self, LandError> {
        let fail = |faults| LandError { path: land.dem.clone(), faults };
        let origin = if frame.origin().is_none() { vec![RasterFault::NoOrigin] } else { Vec::new() };
        let raster = Raster::read(&land.dem).map_err(|faults| fail([origin.clone(), faults].concat()))?;
        if !origin.is_empty() {
            return Err(fail(origin));
        }
        let top_m = raster.heights.range_m().map_or(0.0, |[_, high_m]| f64::from(high_m).max(0.0));
        let top_m = (top_m - land.sea_level_m).max(0.0);
        let dem = Self { raster, frame, sea_level_m: land.sea_level_m, seed, top_m };
        let worst = patches.iter().map(|patch| dem.outside(patch)).fold(0.0, f64::max);
        if worst > 0.0 {
            let [low, high] = dem.raster.area();
            let fault = RasterFault::Uncovered { share: 100.0 * worst, crs: dem.raster.crs, low, high };
            return Err(fail(vec![fault]));
        }
        Ok(dem)
    }

    /// Highest above the sea, m.
    pub fn top_m(&self) -> f64 {
        self.top_m
    }

    /// Lowest and highest cell with data above the sea, m, and what was done to the values of the file.
    pub fn text(&self) -> String {
        let range = match self.raster.heights.range_m() {
            Some(range_m) => {
                let [low_m, high_m] = range_m.map(|height_m| f64::from(height_m) - self.sea_level_m);
                format!("its cells lie {low_m:.1} to {high_m:.1} m above the sea")
            }
            None => "none of its cells has data".to_owned(),
        };
        self.raster.vertical.text().map_or(range.clone(), |values| format!("{range} (values {values})"))
    }

    /// Share of points along the edge of a patch, its outermost corners among them, that the raster does not
    /// hold.
    fn outside(&self, patch: &Patch) -> f64 {
        let low = patch.centre_m(patch.first).map(|centre_m| centre_m - 0.5 * patch.facet_m);
        let points = (0..EDGE_POINTS).flat_map(|i| {
            let along = i as f64 / (EDGE_POINTS - 1) as f64;
            [[along, 0.0], [along, 1.0], [0.0, along], [1.0, along]]
        });
        let (mut count, mut outside) = (0, 0);
        for share in points {
            let at = |axis: usize| low[axis] + share[axis] * patch.size_m()[axis];
            count += 1;
            outside += usize::from(!self.place([at(0), at(1)]).is_some_and(|place| self.raster.holds(place)));
        }
        f64::from(outside as u32) / f64::from(count)
    }

    fn place(&self, [x_m, y_m]: [f64; 2]) -> Option<[f64; 2]> {
        let at = self.frame.to_geodetic(self.frame.above_sea(x_m, y_m, 0.0))?;
        Some(self.raster.place(self.raster.crs.of([at.lat_rad, at.lon_rad])))
    }

    /// Height above the sea at a place of the scene, m; below it 0 or less, and beyond the raster 0.
    pub fn height_m(&self, place_m: [f64; 2]) -> f64 {
        let Some(place) = self.place(place_m).filter(|place| self.raster.holds(*place)) else { return 0.0 };
        // Cells without data are sea: a coast beside them slopes to it as to cells of water.
        self.raster.at(place, self.sea_level_m) - self.sea_level_m
    }

    /// Whether a facet of a side is land: the mean of its corners lies above the sea.
    pub fn is_land(&self, [x, y]: [i64; 2], facet_m: f64) -> bool {
        let corner = |key: i64| key as f64 * facet_m - 0.5 * facet_m;
        let height_m = |right: i64, up: i64| self.height_m([corner(x + right), corner(y + up)]);
        0.25 * (height_m(0, 0) + height_m(1, 0) + height_m(0, 1) + height_m(1, 1)) > 0.0
    }

    /// Random phasors of a facet.
    fn phasors(&self, key: [i64; 2]) -> [[f32; 2]; 3] {
        let mut random = stream(self.seed, Room::LandPhase, key[0] as u64, key[1] as u64);
        std::array::from_fn(|_| {
            let turns = (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
            let (cos, sin) = crate::units::cos_sin_of_turns(turns);
            [cos, sin]
        })
    }
}

/// What the facets of a patch are, in its order.
#[derive(Clone, Debug, Default)]
struct Columns {
    /// 1 for land, 0 for sea.
    land: Vec<f32>,
    height_m: Vec<f32>,
    slope: [Vec<f32>; 2],
    /// Real and imaginary parts of the phasors of VV, HH and cross-polarisation.
    phasor: [[Vec<f32>; 2]; 3],
}

impl Columns {
    fn resize(&mut self, facets: usize) {
        let Self { land, height_m, slope, phasor } = self;
        [land, height_m].into_iter().chain(slope).chain(phasor.as_flattened_mut()).for_each(|column| {
            column.clear();
            column.resize(facets, 0.0);
        });
    }
}

/// The land of the patch at hand. What a facet is follows from its global key alone.
#[derive(Clone, Debug)]
pub struct LandSheet {
    dem: Arc<Dem>,
    patch: Option<Patch>,
    columns: Arc<Columns>,
    spare: Option<Arc<Columns>>,
    /// Heights of the corners of a row, below and above.
    corners: [Vec<f64>; 2],
}

impl LandSheet {
    /// Of a raster; no patch is at hand yet.
    pub fn new(dem: Arc<Dem>) -> Self {
        Self { dem, patch: None, columns: Arc::default(), spare: None, corners: Default::default() }
    }

    /// The heights that it is taken from.
    pub fn dem(&self) -> Arc<Dem> {
        Arc::clone(&self.dem)
    }

    /// Takes a patch to hand. What it shares with the one before is not looked up again.
    pub fn place(&mut self, patch: &Patch) {
        if self.patch == Some(*patch) {
            return;
        }
        let before = self.patch.take();
        let mut next = self.spare.take().unwrap_or_default();
        if Arc::get_mut(&mut next).is_none() {
            next = Arc::default();
        }
        if let Some(columns) = Arc::get_mut(&mut next) {
            columns.resize(patch.len());
            for row in 0..patch.facets[1] {
                self.fill(before.as_ref(), patch, row, columns);
            }
        }
        self.spare = Some(std::mem::replace(&mut self.columns, next));
        self.patch = Some(*patch);
    }

    /// One row of a patch: what the one before had, and the rest from the raster.
    fn fill(&mut self, before: Option<&Patch>, patch: &Patch, row: usize, columns: &mut Columns) {
        let (width, key_y) = (patch.facets[0], patch.first[1] + row as i64);
        let kept = before.filter(|old| old.facet_m == patch.facet_m).and_then(|old| {
            let row = usize::try_from(key_y - old.first[1]).ok().filter(|row| *row < old.facets[1])?;
            let from = patch.first[0].max(old.first[0]);
            let to = (patch.first[0] + width as i64).min(old.first[0] + old.facets[0] as i64);
            let at = row * old.facets[0] + usize::try_from(from - old.first[0]).ok()?;
            (from < to).then_some(((from - patch.first[0]) as usize..(to - patch.first[0]) as usize, at))
        });
        let (kept, at) = kept.unwrap_or((0..0, 0));
        let begin = row * width;
        if !kept.is_empty() {
            let to = begin + kept.start..begin + kept.end;
            let from = at..at + kept.len();
            let old = &*self.columns;
            columns.land[to.clone()].copy_from_slice(&old.land[from.clone()]);
            columns.height_m[to.clone()].copy_from_slice(&old.height_m[from.clone()]);
            let slopes = columns.slope.iter_mut().zip(&old.slope);
            let phasors = columns.phasor.as_flattened_mut().iter_mut().zip(old.phasor.as_flattened());
            for (new, old) in slopes.chain(phasors) {
                new[to.clone()].copy_from_slice(&old[from.clone()]);
            }
        }
        for range in [0..kept.start, kept.end..width] {
            self.look_up(patch, key_y, range, begin, columns);
        }
    }

    /// Facets of a row from the raster.
    fn look_up(
        &mut self,
        patch: &Patch,
        key_y: i64,
        range: std::ops::Range<usize>,
        begin: usize,
        columns: &mut Columns,
    ) {
        if range.is_empty() {
            return;
        }
        let half_m = 0.5 * patch.facet_m;
        for (corners, up) in self.corners.iter_mut().zip([0, 1]) {
            let [_, y_m] = patch.centre_m([0, key_y + up]);
            corners.clear();
            corners.extend((range.start..=range.end).map(|column| {
                let [x_m, _] = patch.centre_m([patch.first[0] + column as i64, 0]);
                self.dem.height_m([x_m - half_m, y_m - half_m])
            }));
        }
        for (place, column) in range.enumerate() {
            let [south_west, south_east] = [self.corners[0][place], self.corners[0][place + 1]];
            let [north_west, north_east] = [self.corners[1][place], self.corners[1][place + 1]];
            let height_m = 0.25 * (south_west + south_east + north_west + north_east);
            if height_m <= 0.0 {
                continue;
            }
            let index = begin + column;
            columns.land[index] = 1.0;
            columns.height_m[index] = height_m as f32;
            let rise = [
                south_east + north_east - south_west - north_west,
                north_west + north_east - south_west - south_east,
            ];
            for (slope, rise) in columns.slope.iter_mut().zip(rise) {
                slope[index] = (0.5 * rise / patch.facet_m) as f32;
            }
            let phasors = self.dem.phasors([patch.first[0] + column as i64, key_y]);
            for (to, phasor) in columns.phasor.iter_mut().zip(phasors) {
                (to[0][index], to[1][index]) = (phasor[0], phasor[1]);
            }
        }
    }

    /// Lays the land over fields of the patch at hand.
    pub fn lay<T: Real>(&self, out: &mut Fields<T>) {
        let Fields {
            height_m,
            slope,
            velocity_mps,
            acceleration_mps2,
            displacement_m,
            slope_rate_per_s,
            modulation,
            stretch: _,
            area,
        } = out;
        let of = |index: usize| T::round_from(f64::from(self.columns.height_m[index]));
        let [east, north] = &self.columns.slope;
        for (index, _) in self.columns.land.iter().enumerate().filter(|(_, land)| **land > 0.0) {
            if let Some(height_m) = height_m.get_mut(index) {
                *height_m = of(index);
            }
            for (slope, own) in slope.iter_mut().zip([east, north]) {
                if let Some(slope) = slope.get_mut(index) {
                    *slope = T::round_from(f64::from(own[index]));
                }
            }
            // Land does not give way.
            if let Some(area) = area.get_mut(index) {
                *area = T::one();
            }
            let horizontal = displacement_m.iter_mut().chain(slope_rate_per_s.iter_mut());
            let horizontal = horizontal.chain(modulation.iter_mut());
            let moving = velocity_mps.iter_mut().chain(acceleration_mps2.iter_mut()).chain(horizontal);
            moving.filter_map(|column| column.get_mut(index)).for_each(|value| *value = T::default());
        }
    }

    /// 1 for land, 0 for sea, by the facets of the patch at hand.
    pub fn land(&self) -> &[f32] {
        &self.columns.land
    }

    /// Real and imaginary parts of the phasors of VV, HH and cross-polarisation, by facet.
    pub fn phasors(&self) -> &[[Vec<f32>; 2]; 3] {
        &self.columns.phasor
    }
}
