//! What breaks of a sea: candidates of [`crate::sea::breaking`] on the resolved surface.
//!
//! Candidates are drawn cell by cell and slot by slot of time; the surface in the middle of a slot decides
//! which of them break, and how high they ride. What breaks in the slots about a pulse is found once for all
//! threads; it depends on neither them nor the order in which pulses are made. Where the patch follows, it is
//! found over a **region** that holds the patch wherever this begins in a square a quarter as long, so that a
//! patch that moves on by a facet finds what it needs; a pulse takes those on its own patch.

use std::sync::Arc;

use super::kept::{Kept, OneAtATime};
use crate::radar::fault::SeaFault;
use crate::scene::Patch;
use crate::sea::breaking::{Breaker, CELL_M, Law, SLOT_S};
use crate::sea::land::{Dem, LandSheet};
use crate::sea::surface::{Evaluator, Fields, Grid, Selection, Surface, SurfaceError};

/// Regions of a slot whose breakers are kept, and slots whose surface is where the patch moves: as many as a
/// life may span, and threads that make other pulses; regions fewer where they hold more than so many in all.
const KEPT: std::ops::RangeInclusive<usize> = 6..=24;
const MOST_KEPT: f64 = 4e6;
const SURFACES: usize = 4;
/// Scatterers for which there is room beforehand, at most.
const ROOM: f64 = 65_536.0;
/// Side of the squares in which a patch that follows may begin without another region: its own over this, and
/// at least so many metres.
const PER_SIDE: usize = 4;
const LEAST_SIDE_M: f64 = 2.0 * CELL_M;
/// Scatterers that may be alive at a time in the mean, and area of a patch, m^2.
const MOST_ALIVE: f64 = 1e6;
const MOST_AREA_M2: f64 = 4e9;

/// A breaker on the surface that it was found on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Riding {
    pub breaker: Breaker,
    /// The facet on which its wave was found.
    key: [i64; 2],
    pub height_m: f64,
}

/// The breaking waves of a run.
pub(super) struct BreakingPlan {
    law: Law,
    patch_m2: f64,
    /// Standard deviation of the vertical acceleration; 0 of a flat sea.
    deviation_mps2: f64,
    land: Option<Arc<Dem>>,
    /// Sides of the squares in which patches of one region begin, facets.
    sides: [i64; 2],
    /// Scatterers of a slot in a region, mean, and regions of a slot that are kept.
    of_slot: f64,
    kept_slots: usize,
    grid: Grid,
    evaluator: OneAtATime<Evaluator<f32>>,
    /// The waves of the whole grid in the middle of a slot.
    surfaces: Kept<i64, Fields<f32>>,
    /// What breaks in a slot on the region of a square.
    found: Kept<(i64, [i64; 2]), Vec<Riding>>,
}

/// Variance of the vertical acceleration of a surface: the sum of `2 |a|^2 w^4`.
fn acceleration_variance(surface: &Surface) -> f64 {
    let (grid, dispersion) = (surface.grid(), surface.dispersion());
    let step = grid.wave_number_step_rad_m();
    let mut variance = 0.0;
    for (i, row) in surface.amplitude_m().chunks_exact(grid.ny()).enumerate() {
        for (j, amplitude) in row.iter().enumerate() {
            if let (Some(mx), Some(my)) = (grid.wave_index_x(i), grid.wave_index_y(j)) {
                let length = (mx as f64 * step[0]).hypot(my as f64 * step[1]);
                variance += 2.0 * amplitude.norm_sqr() * dispersion.angular_frequency_rad_s(length).powi(4);
            }
        }
    }
    variance
}

impl BreakingPlan {
    /// Of a law, over a surface and the patch that is modelled of it; nothing breaks on land.
    pub fn new(
        law: Law,
        surface: &Surface,
        (patch, follows): (&Patch, bool),
        land: Option<&LandSheet>,
    ) -> Result<Self, SeaFault> {
        let patch_m2 = patch.len() as f64 * patch.facet_m * patch.facet_m;
        let alive = law.alive_per_m2() * patch_m2;
        if alive > MOST_ALIVE || patch_m2 > MOST_AREA_M2 {
            return Err(SeaFault::Breakers { alive, most: MOST_ALIVE, patch_m2, most_m2: MOST_AREA_M2 });
        }
        let least = (LEAST_SIDE_M / patch.facet_m).ceil() as usize;
        let side = |facets: usize| (facets / PER_SIDE).max(least) as i64;
        let sides = if follows { patch.facets.map(side) } else { [1; 2] };
        let of_slot = law.births_per_m2_s() * SLOT_S * region(patch, sides, [0; 2]).len() as f64;
        let of_slot = of_slot * patch.facet_m * patch.facet_m;
        let kept_slots = ((MOST_KEPT / of_slot) as usize).clamp(*KEPT.start(), *KEPT.end());
        let room = room(of_slot);
        Ok(Self {
            law,
            patch_m2,
            deviation_mps2: acceleration_variance(surface).sqrt(),
            land: land.map(LandSheet::dem),
            sides,
            grid: *surface.grid(),
            evaluator: OneAtATime::new(Evaluator::new(surface)),
            surfaces: Kept::new(if follows { SURFACES } else { 1 }, || {
                Fields::new(surface.grid(), Selection::HEIGHT)
            }),
            of_slot,
            kept_slots,
            found: Kept::new(kept_slots, || Vec::with_capacity(room)),
        })
    }

    /// How far a scatterer may be from where its wave was found, m.
    pub fn reach_m(&self) -> f64 {
        self.law.reach().1
    }

    /// Scatterers that are alive at a time, mean.
    pub fn alive(&self) -> f64 {
        self.law.alive_per_m2() * self.patch_m2
    }

    /// Scatterers that are alive at any instant of so many seconds, mean.
    pub fn within(&self, lasts_s: f64) -> f64 {
        self.alive() + self.law.births_per_m2_s() * self.patch_m2 * lasts_s
    }

    /// Scatterers for which there is room beforehand: those that are alive at any instant of so many seconds.
    pub fn room(&self, lasts_s: f64) -> usize {
        room(self.within(lasts_s))
    }

    /// About what all slots that are kept take, bytes.
    pub fn kept_bytes(&self) -> u64 {
        (self.kept_slots as f64 * self.of_slot) as u64 * size_of::<Riding>() as u64
    }

    /// What breaks in a slot on a region.
    fn find(&self, slot: i64, region: &Patch, found: &mut Vec<Riding>) -> Result<(), SurfaceError> {
        let evaluate = |fields: &mut Fields<f32>| {
            self.evaluator.with(|evaluator| evaluator.evaluate((slot as f64 + 0.5) * SLOT_S, fields))
        };
        let facet_m = region.facet_m;
        let cell = |key: i64, side: f64| ((key as f64 + side) * facet_m / CELL_M).floor() as i64;
        let ([x_first, y_first], [x_last, y_last]) = (region.first, last(region));
        found.clear();
        self.surfaces.with(slot, evaluate, |fields| {
            let rising = &fields.acceleration_mps2[2];
            for y in cell(y_first, -0.5)..=cell(y_last, 0.5) {
                for x in cell(x_first, -0.5)..=cell(x_last, 0.5) {
                    self.law.candidates([x, y], slot, |wave| {
                        let key = key_of(wave.place_m, facet_m);
                        if !holds(region, key) {
                            return;
                        }
                        let facet = self.grid.index(key);
                        let downwards = (self.deviation_mps2 > 0.0)
                            .then(|| -f64::from(rising[facet]) / self.deviation_mps2);
                        if !wave.breaks(downwards) {
                            return;
                        }
                        let height_m = f64::from(fields.height_m[facet]);
                        self.law.scatterers(wave, |breaker| {
                            let own = key_of(breaker.place_m, facet_m);
                            if !self.land.as_ref().is_some_and(|dem| dem.is_land(own, facet_m)) {
                                found.push(Riding { breaker, key, height_m });
                            }
                        });
                    });
                }
            }
        })
    }

    /// Hands over what is alive on a patch at any instant between two times after pulse 0.
    pub fn each(
        &self,
        patch: &Patch,
        [from_s, to_s]: [f64; 2],
        mut each: impl FnMut(&Riding),
    ) -> Result<(), SurfaceError> {
        let slot = |time_s: f64| (time_s / SLOT_S).floor() as i64;
        let (life_s, _) = self.law.reach();
        let square = [0, 1].map(|i| patch.first[i].div_euclid(self.sides[i]));
        for slot in slot(from_s - life_s)..=slot(to_s) {
            let find = |found: &mut Vec<_>| self.find(slot, &region(patch, self.sides, square), found);
            self.found.with((slot, square), find, |found| {
                let alive =
                    |Riding { breaker, key, .. }: &&Riding| breaker.lives(from_s, to_s) && holds(patch, *key);
                found.iter().filter(alive).for_each(&mut each);
            })?;
        }
        Ok(())
    }
}

/// Room for twice the mean number of breakers, because it varies with the longest waves, and a margin.
fn room(mean: f64) -> usize {
    (2.0 * mean + 1024.0).min(ROOM) as usize
}

/// All that patches hold which begin in a square.
fn region(patch: &Patch, sides: [i64; 2], square: [i64; 2]) -> Patch {
    let first = [0, 1].map(|i| square[i] * sides[i]);
    let facets = [0, 1].map(|i| patch.facets[i] + sides[i] as usize - 1);
    Patch { first, facets, ..*patch }
}

/// The facet at a place.
fn key_of(place_m: [f64; 2], facet_m: f64) -> [i64; 2] {
    place_m.map(|at| (at / facet_m).round() as i64)
}

fn last(patch: &Patch) -> [i64; 2] {
    [0, 1].map(|i| patch.first[i] + patch.facets[i] as i64 - 1)
}

fn holds(patch: &Patch, key: [i64; 2]) -> bool {
    let last = last(patch);
    (0..2).all(|i| (patch.first[i]..=last[i]).contains(&key[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::water::{Development, Dispersion, WindProfile};
    use crate::sea::spectrum::Elfouhaily;
    use crate::sea::surface::{Averaging, Grid};
    use crate::sea::wind::Wind;

    /// A patch that follows, a facet further at each step, has the breakers of a patch that lies where it
    /// does, in their order, and few regions are looked at.
    #[test]
    fn a_patch_that_moves_finds_the_breakers_of_one_that_stays() {
        let wind = Wind::from_speed(14.0, 10.0, WindProfile::Cardone, 0.2).unwrap();
        let spectrum = Elfouhaily::new(&wind, Development::InverseWaveAge(0.84)).unwrap();
        let grid = Grid::new(64, 64, 2.0).unwrap();
        let surface =
            Surface::synthesise(grid, &spectrum, Dispersion::default(), 3, Averaging::Points).unwrap();
        let patch = Patch::new([128.0, 96.0], 2.0, [7.0, -300.0]).unwrap();
        let law = Law::new(14.0, 0.2, 3).unwrap();
        let plan = |of: &Patch, follows| BreakingPlan::new(law, &surface, (of, follows), None).unwrap();
        let on = |plan: &BreakingPlan, patch: &Patch| {
            let mut found = Vec::new();
            let each = |riding: &Riding| {
                if riding.breaker.envelope(20.3) > 0.0 {
                    found.push((riding.breaker, riding.height_m));
                }
            };
            plan.each(patch, [20.3; 2], each).unwrap();
            found
        };
        let follows = plan(&patch, true);
        let (moves, mut count) = (60i64, 0);
        for n in (0..moves).chain([3, 58]) {
            let here = Patch { first: [patch.first[0] + n, patch.first[1] + n / 2], ..patch };
            let found = on(&follows, &here);
            assert!(found == on(&plan(&here, false), &here), "{n}");
            count += found.len();
        }
        let regions = follows.found.len();
        println!("{count} breakers in {moves} places, {regions} regions");
        // Two or three slots, and a quarter of the way of a patch at a time, but at least 32 facets.
        assert!(count > 2000 && regions <= 3 * 4, "{count} {regions}");
    }
}
