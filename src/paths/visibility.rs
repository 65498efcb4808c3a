//! Visibility of facets from every antenna, updated at intervals and cross-faded in between.
//!
//! Updates happen at `t_k = k T` after pulse 0 (`T` the update interval), the last one after the last
//! emission, so that the weights of a pulse depend on its time alone, however long the run. Between two
//! updates the weights of each antenna are interpolated linearly. An update sees the patch as it is placed
//! then, with a margin for where it may be until the next one; facets beyond the margin take the weight of
//! the nearest facet within.
//!
//! What lies beyond the horizon of an antenna on a curved earth is hidden besides ([`horizon`]), each facet
//! by its own height. Ships that echo by their mesh hide what lies behind and under them ([`Hulls`]).

use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::frames::{Earth, Enu, Point};
use crate::geometry::horizon;
use crate::geometry::shadow::{Map, Relief, Settings, Shadow, ShadowError};
use crate::paths::ships::Hulls;
use crate::scattering::two_rays::TwoRays;
use crate::scene::Patch;
use crate::sea::facet_surface::FacetSurface;
use crate::sea::land::LandSheet;
use crate::sea::surface::fields::Real;
use crate::sea::surface::{Fields, Selection, Surface};
use crate::sea::wake::{Wake, WakeError};

/// How visibility is found, for a whole run.
#[derive(Clone, Debug)]
pub(super) struct Visibility {
    /// Whether waves hide each other.
    pub waves: bool,
    pub settings: Settings,
    /// The earth as it hides what lies beyond its horizon, and the height over which facets go down there, m.
    pub earth: Earth,
    pub horizon_edge_m: f64,
    pub update_s: f64,
    /// Rows by which the patch of an update is larger than that of a pulse, on each side.
    pub margin: usize,
    /// Antennas.
    pub ends: usize,
    /// Land among the facets.
    pub land: Option<LandSheet>,
    /// Ships that hide facets.
    pub hulls: Option<Hulls>,
    /// The sea before a facet as a mirror, if it reflects.
    pub two_rays: Option<TwoRays>,
}

/// Weights at one update.
#[derive(Clone, Debug)]
pub(super) struct Update<T: Real = f64> {
    number: Option<u64>,
    patch: Patch,
    /// `[antenna]`: `None` where the geometry cannot shadow.
    illuminated: Vec<bool>,
    weights: Vec<Vec<T>>,
    /// `[antenna]`: outside of it weights are one; `None` where nothing is known of them.
    dimmed: Vec<Option<Area>>,
}

/// The two updates around an instant, and what makes them: in f64, or from heights in f32.
#[derive(Clone)]
pub(super) struct Updates<T: Real = f64> {
    facet_surface: FacetSurface<T>,
    fields: Fields<T>,
    heights_m: Vec<f64>,
    shadow: Shadow<f64>,
    held: [Update; 2],
}

/// Updates that a block shares with the one before or after it, so that workers make each once. What an
/// update holds depends on its number alone, so it is the same whoever makes it, and whether it is found
/// here.
#[derive(Debug, Default)]
pub struct Borders {
    workers: usize,
    held: Vec<Update<f32>>,
}

/// How workers get at the borders they share: known to who runs them.
pub trait ShareBorders: Send + Sync {
    /// Hands them to `each`, one worker at a time.
    fn with(&self, each: &mut dyn FnMut(&mut Borders));
}

impl Borders {
    /// Updates that neighbouring blocks have in common, at most: the one before the second block begins and
    /// the one after the first ends.
    pub(super) const COMMON: u64 = 2;

    /// One more worker takes part.
    pub(super) fn join(&mut self) {
        self.workers += 1;
    }

    /// An update, if it is here.
    pub(super) fn find(&self, number: u64) -> Option<&Update<f32>> {
        self.held.iter().find(|update| update.number == Some(number))
    }

    /// Keeps an update, in place of the oldest one where there are enough for the borders of as many blocks
    /// as workers.
    pub(super) fn keep(&mut self, update: &Update) {
        let places = Self::COMMON as usize * (self.workers + 1);
        let oldest = self.held.iter().enumerate().min_by_key(|(_, own)| own.number).map(|(place, _)| place);
        match oldest {
            _ if self.held.iter().any(|own| own.number == update.number) => {}
            Some(place) if self.held.len() >= places => self.held[place].copy_from(update),
            _ => self.held.push(update.in_single_precision()),
        }
    }
}

/// Weights at an instant: a mix of two updates.
pub(super) struct Mix<'a> {
    before: &'a Update,
    after: &'a Update,
    share: f64,
}

impl Visibility {
    /// Whether its maps are legal.
    pub fn check<E: From<WakeError> + From<ShadowError>>(
        &self,
        wakes: &[Wake],
        patch: &Patch,
    ) -> Result<(), E> {
        let grown = patch.grown(self.margin);
        // Refuses what is too large before any memory is taken.
        self.shadow(&grown)?;
        crate::sea::wake::Map::<f32>::new(wakes.to_vec(), &grown, -60.0)?;
        Ok(())
    }

    /// What finds the shadows of a patch.
    pub fn shadow(&self, patch: &Patch) -> Result<Shadow<f64>, ShadowError> {
        Shadow::new(patch.facets, self.settings)
    }

    pub fn updates<T: Real, E: From<WakeError> + From<ShadowError>>(
        &self,
        surface: &Surface,
        wakes: &[Wake],
        patch: &Patch,
    ) -> Result<Updates<T>, E> {
        let grown = patch.grown(self.margin);
        let shadow = self.shadow(&grown)?;
        let facet_surface = FacetSurface::<T>::new(surface, Selection::HEIGHT)
            .with_wakes(wakes, &grown)?
            .with_land(self.land.as_ref());
        let update = self.empty(&grown);
        let heights_m = vec![0.0; grown.len()];
        Ok(Updates {
            fields: facet_surface.fields(&grown),
            facet_surface,
            heights_m,
            shadow,
            held: [update.clone(), update],
        })
    }

    /// Time of an update, s after pulse 0.
    pub fn time_s(&self, number: u64) -> f64 {
        number as f64 * self.update_s
    }

    /// The update before an instant (s after pulse 0), and how far the instant lies towards the next: 0 to 1.
    pub fn share(&self, elapsed_s: f64) -> (u64, f64) {
        let number = (elapsed_s.max(0.0) / self.update_s).floor() as u64;
        let (from_s, to_s) = (self.time_s(number), self.time_s(number + 1));
        (number, ((elapsed_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0))
    }

    /// Updates about so many seconds, at most.
    pub fn most_updates(&self, lasts_s: f64) -> usize {
        // Rounding makes no update.
        (lasts_s / self.update_s - 1e-6).ceil().max(0.0) as usize + 2
    }

    /// Makes an update, unless it is held. `scenery` gives the patch and the place of every antenna at a
    /// time; the mean surface is that of `earth`.
    pub fn update<'a, T: Real, E: From<WakeError> + From<ShadowError>>(
        &self,
        updates: &'a mut Updates<T>,
        wanted: u64,
        mut scenery: impl FnMut(f64, &mut [Point<Enu>]) -> Result<Patch, E>,
        earth: Earth,
    ) -> Result<&'a Update, E> {
        let Updates { facet_surface, fields, heights_m, shadow, held } = updates;
        // Even and odd updates have a place each, so the pair needed next always keeps the one at hand.
        let update = &mut held[(wanted % 2) as usize];
        if update.number == Some(wanted) {
            return Ok(update);
        }
        update.number = None;
        let time_s = self.time_s(wanted);
        let mut places = [Point::new(0.0, 0.0, 0.0); MOST_ENDS];
        let places = &mut places[..self.ends];
        update.patch = scenery(time_s, places)?.grown(self.margin);
        if !self.waves
            && self.hulls.is_none()
            && self.two_rays.is_none()
            && places.iter().all(|place| self.within_horizon(*place, &update.patch))
        {
            update.illuminated.fill(true);
            update.number = Some(wanted);
            return Ok(update);
        }
        facet_surface.evaluate(time_s, &update.patch, fields)?;
        heights_m.iter_mut().zip(&fields.height_m).for_each(|(to, from)| *to = from.widen());
        self.weigh(shadow, time_s, heights_m, earth, places, update)?;
        update.number = Some(wanted);
        Ok(update)
    }

    /// The weights at an update from the heights of its patch, m, which are lowered; nothing is held.
    pub fn weigh_heights<E: From<ShadowError>>(
        &self,
        shadow: &mut Shadow<f64>,
        (time_s, patch): (f64, &Patch),
        heights_m: &mut [f64],
        places: &[Point<Enu>],
        earth: Earth,
        update: &mut Update,
    ) -> Result<(), E> {
        update.patch = *patch;
        self.weigh(shadow, time_s, heights_m, earth, places, update)?;
        Ok(())
    }

    fn weigh(
        &self,
        shadow: &mut Shadow<f64>,
        time_s: f64,
        heights_m: &mut [f64],
        earth: Earth,
        places: &[Point<Enu>],
        update: &mut Update,
    ) -> Result<(), ShadowError> {
        let patch = update.patch;
        let rows = heights_m.chunks_exact_mut(patch.facets[0]).enumerate();
        for (row, heights_m) in rows.filter(|_| earth != Earth::Flat) {
            for (column, z) in heights_m.iter_mut().enumerate() {
                let key = [patch.first[0] + column as i64, patch.first[1] + row as i64];
                let [x_m, y_m] = patch.centre_m(key);
                *z -= earth.drop_m(x_m, y_m);
            }
        }
        let map = Map::new(heights_m, patch.facets, patch.facet_m, patch.centre_m(patch.first))?;
        let relief = Relief::of(&map);
        for antenna in 0..places.len() {
            // Antennas at one place see the same.
            if let Some(twin) = places[..antenna].iter().position(|place| *place == places[antenna]) {
                update.see_as(antenna, twin);
                continue;
            }
            let place = places[antenna];
            let waves = self.waves && !relief.cannot_shadow(&map, place, self.settings);
            let beyond = !self.within_horizon(place, &patch);
            let mut whole = !waves && !beyond && self.two_rays.is_none();
            let (weights, dimmed) = (&mut update.weights[antenna], &mut update.dimmed[antenna]);
            if !whole {
                *dimmed = None;
            }
            if waves {
                shadow.weights(&map, place, weights)?;
            } else if !whole {
                weights.fill(1.0);
            }
            if beyond {
                self.set_behind_earth(place, &patch, heights_m, weights);
            }
            if let Some(two_rays) = &self.two_rays {
                self.add_reflected(two_rays, place, (&patch, &*heights_m), earth, weights);
            }
            if let Some(hulls) = &self.hulls {
                let width = patch.facets[0];
                let mut area = whole.then(|| Area::brighten(weights, dimmed.take(), width));
                hulls.hide(time_s, place.raw(), &patch, heights_m, |facet| {
                    whole = false;
                    weights[facet] = 0.0;
                    if let Some(area) = &mut area {
                        area.add(facet, width);
                    }
                });
                *dimmed = area;
            }
            update.illuminated[antenna] = whole;
        }
        Ok(())
    }

    /// Whether no facet of a patch lies beyond the horizon of a place.
    fn within_horizon(&self, place: Point<Enu>, patch: &Patch) -> bool {
        let last = [0, 1].map(|i| patch.first[i] + patch.facets[i] as i64 - 1);
        horizon::holds(self.earth, place, [patch.centre_m(patch.first), patch.centre_m(last)], 1.0)
    }

    /// Takes from the weights of facets (of these heights in the scene's frame, m) what the earth hides from
    /// a place.
    fn set_behind_earth(&self, place: Point<Enu>, patch: &Patch, heights_m: &[f64], weights: &mut [f64]) {
        let columns = patch.facets[0];
        let rows = heights_m.chunks_exact(columns).zip(weights.chunks_exact_mut(columns)).enumerate();
        for (row, (heights_m, weights)) in rows {
            for (column, (z_m, weight)) in heights_m.iter().zip(weights).enumerate() {
                let key = [patch.first[0] + column as i64, patch.first[1] + row as i64];
                let [x_m, y_m] = patch.centre_m(key);
                let clearance_m = horizon::clearance_m(self.earth, place, Point::new(x_m, y_m, *z_m));
                *weight *= horizon::weight(clearance_m, self.horizon_edge_m);
            }
        }
    }

    /// Multiplies the weights of facets (of these heights in the scene's frame, m) by the field at them over
    /// that of the straight ray from a place. Land reflects nothing.
    fn add_reflected(
        &self,
        two_rays: &TwoRays,
        place: Point<Enu>,
        (patch, heights_m): (&Patch, &[f64]),
        earth: Earth,
        weights: &mut [f64],
    ) {
        let [columns, rows] = patch.facets;
        let dem = self.land.as_ref().map(LandSheet::dem);
        for (index, weight) in weights.iter_mut().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let (column, row) = (index % columns, index / columns);
            let key = [patch.first[0] + column as i64, patch.first[1] + row as i64];
            if dem.as_ref().is_some_and(|dem| dem.is_land(key, patch.facet_m)) {
                continue;
            }
            let [x_m, y_m] = patch.centre_m(key);
            let ray = place.raw() - DVec3::new(x_m, y_m, heights_m[index]);
            let level = ray.truncate().normalize_or_zero();
            // Slope of the heights towards the antenna, between both neighbours; at the edge from the facet.
            let between = |before: usize, after: usize, facets: usize| {
                (heights_m[after] - heights_m[before]) / (facets.max(1) as f64 * patch.facet_m)
            };
            let [left, right] = [column.saturating_sub(1), (column + 1).min(columns - 1)];
            let [below, above] = [row.saturating_sub(1), (row + 1).min(rows - 1)];
            let rise = DVec2::new(
                between(row * columns + left, row * columns + right, right - left),
                between(below * columns + column, above * columns + column, above - below),
            );
            // Of the mean surface on a curved earth, over a metre to either side.
            let before_m = earth.drop_m(x_m - level.x, y_m - level.y);
            let mean_rise = 0.5 * (before_m - earth.drop_m(x_m + level.x, y_m + level.y));
            let height_m = heights_m[index] + earth.drop_m(x_m, y_m);
            let sine = ray.z / ray.length() - mean_rise;
            *weight *= two_rays.field(height_m, sine, mean_rise - rise.dot(level));
        }
    }

    /// An update of a patch, to be filled.
    pub fn empty(&self, patch: &Patch) -> Update {
        Update {
            number: None,
            patch: *patch,
            illuminated: vec![false; self.ends],
            weights: vec![vec![0.0; patch.len()]; self.ends],
            dimmed: vec![None; self.ends],
        }
    }

    /// The weights `elapsed_s` after pulse 0; see [`Self::update`].
    pub fn at<'a, E: From<WakeError> + From<ShadowError>>(
        &self,
        updates: &'a mut Updates,
        elapsed_s: f64,
        mut scenery: impl FnMut(f64, &mut [Point<Enu>]) -> Result<Patch, E>,
        earth: Earth,
    ) -> Result<Mix<'a>, E> {
        let (number, share) = self.share(elapsed_s);
        for wanted in [number, number + 1] {
            self.update(updates, wanted, &mut scenery, earth)?;
        }
        let [even, odd] = &updates.held;
        let (before, after) = if number.is_multiple_of(2) { (even, odd) } else { (odd, even) };
        Ok(Mix { before, after, share })
    }
}

impl Update {
    fn in_single_precision(&self) -> Update<f32> {
        let weights = self.weights.iter().map(|own| own.iter().map(|weight| *weight as f32).collect());
        Update {
            number: self.number,
            patch: self.patch,
            illuminated: self.illuminated.clone(),
            weights: weights.collect(),
            dimmed: self.dimmed.clone(),
        }
    }

    /// An antenna sees what one before it sees.
    fn see_as(&mut self, antenna: usize, twin: usize) {
        self.illuminated[antenna] = self.illuminated[twin];
        let (before, from) = self.weights.split_at_mut(antenna);
        match (&self.dimmed[twin], &self.dimmed[antenna]) {
            (Some(area), Some(held)) => {
                let width = self.patch.facets[0];
                area.copy(&before[twin], (held, &mut from[0]), width, (1.0, |weight| weight));
            }
            _ => from[0].copy_from_slice(&before[twin]),
        }
        self.dimmed[antenna] = self.dimmed[twin].clone();
    }

    /// Weight of the facet with a global key from an antenna, 0 to 1, or to 2 with two rays.
    pub fn weight(&self, antenna: usize, key: [i64; 2]) -> f64 {
        if self.illuminated[antenna] { 1.0 } else { self.weights[antenna][self.patch.nearest_index(key)] }
    }
}

impl Update<f32> {
    /// Becomes another one of the same size.
    fn copy_from(&mut self, other: &Update) {
        (self.number, self.patch) = (other.number, other.patch);
        self.illuminated.copy_from_slice(&other.illuminated);
        self.dimmed.clone_from_slice(&other.dimmed);
        for (to, from) in self.weights.iter_mut().zip(&other.weights) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = *from as f32);
        }
    }
}

impl<T: Real> Update<T> {
    /// Weights of all facets of a patch from an antenna, in its order, and outside of which area they are
    /// one; what is there already is of another update.
    pub fn copy_over(&self, antenna: usize, patch: &Patch, (out, held): (&mut Vec<f32>, &mut Option<Area>)) {
        let area = self.dimmed[antenna].as_ref().filter(|_| self.patch == *patch);
        match (area, &held) {
            (Some(area), Some(held)) if out.len() == patch.len() => {
                let convert = |weight: T| weight.widen() as f32;
                area.copy(&self.weights[antenna], (held, out), patch.facets[0], (1.0, convert));
            }
            _ => self.weights_over(antenna, patch, out),
        }
        *held = area.cloned();
    }

    fn weights_over(&self, antenna: usize, patch: &Patch, out: &mut Vec<f32>) {
        out.clear();
        let own = &self.weights[antenna];
        let [width, first_x] = [patch.facets[0] as i64, patch.first[0]];
        // Columns beyond the update's patch on either side take its edges.
        let before = (self.patch.first[0] - first_x).clamp(0, width);
        let end = (self.patch.first[0] + self.patch.facets[0] as i64 - first_x).clamp(before, width);
        for row in 0..patch.facets[1] as i64 {
            let at = |column: i64| self.patch.nearest_index([first_x + column, patch.first[1] + row]);
            out.extend((0..before).map(|column| own[at(column)].widen() as f32));
            if before < end {
                let from = at(before);
                out.extend(
                    own[from..from + (end - before) as usize].iter().map(|weight| weight.widen() as f32),
                );
            }
            out.extend((end..width).map(|column| own[at(column)].widen() as f32));
        }
    }

    /// Whether an antenna sees every facet whole.
    pub fn sees_all(&self, antenna: usize) -> bool {
        self.illuminated[antenna]
    }
}

/// Most antennas whose shadows are followed.
pub(super) const MOST_ENDS: usize = 64;

impl Mix<'_> {
    /// Weight of the facet with a global key from an antenna, 0 to 1.
    pub fn weight(&self, antenna: usize, key: [i64; 2]) -> f64 {
        let before = self.before.weight(antenna, key);
        before + self.share * (self.after.weight(antenna, key) - before)
    }
}

/// Rows and columns of the facets of a patch: outside of it weights are one, and stay so from update to
/// update.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::paths) struct Area {
    rows: Range<usize>,
    columns: Range<usize>,
}

impl Area {
    /// Grows about a facet of a patch so many facets wide.
    pub fn add(&mut self, index: usize, width: usize) {
        for (range, at) in [(&mut self.rows, index / width), (&mut self.columns, index % width)] {
            *range = if range.start == range.end {
                at..at + 1
            } else {
                range.start.min(at)..range.end.max(at + 1)
            };
        }
    }

    /// Whether it has any of some neighbours in a row.
    pub fn touches(&self, first: usize, count: usize, width: usize) -> bool {
        let (row, column) = (first / width, first % width);
        self.rows.contains(&row) && column < self.columns.end && self.columns.start < column + count
    }

    /// Its facets, row by row.
    fn facets(&self, width: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let columns = self.columns.clone();
        self.rows.clone().map(move |row| row * width + columns.start..row * width + columns.end)
    }

    /// Makes all weights one that are not, and says where they were: nowhere, now.
    pub fn brighten(weights: &mut [f64], held: Option<Self>, width: usize) -> Self {
        match held {
            Some(area) => area.facets(width).for_each(|facets| weights[facets].fill(1.0)),
            None => weights.fill(1.0),
        }
        Self::default()
    }

    /// Makes weights those of others, of which and of their own those outside of the areas are one.
    pub fn copy<S: Copy, T: Copy>(
        &self,
        from: &[S],
        (held, to): (&Self, &mut [T]),
        width: usize,
        (one, convert): (T, impl Fn(S) -> T),
    ) {
        held.facets(width).for_each(|facets| to[facets].fill(one));
        for facets in self.facets(width) {
            let own = to[facets.clone()].iter_mut().zip(&from[facets]);
            own.for_each(|(to, from)| *to = convert(*from));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights that are changed where areas say are those that are written anew.
    #[test]
    fn areas_hold_what_is_not_one() {
        let (width, facets) = (7, 35);
        let (mut weights, mut held) = (vec![0.3; facets], None);
        let (mut copied, mut of_copy) = (vec![1.0f32; facets], Area::default());
        for dark in [vec![8, 16, 17], vec![], vec![34, 0], vec![10]] {
            let mut area = Area::brighten(&mut weights, held.take(), width);
            for facet in &dark {
                weights[*facet] = 0.0;
                area.add(*facet, width);
            }
            area.copy(&weights, (&of_copy, &mut copied), width, (1.0, |weight| weight as f32));
            for (n, (own, copy)) in weights.iter().zip(&copied).enumerate() {
                let wanted = if dark.contains(&n) { 0.0 } else { 1.0 };
                assert!(*own == wanted && f64::from(*copy) == wanted, "{dark:?} {n}");
                assert!(area.touches(n, 1, width) || wanted == 1.0);
            }
            assert_eq!(area.touches(0, facets.min(width), width), dark.iter().any(|n| *n < width));
            (of_copy, held) = (area.clone(), Some(area));
        }
    }
}
