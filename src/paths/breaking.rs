//! What breaks of a sea: candidates of [`crate::sea::breaking`] on the resolved surface.
//!
//! Candidates are drawn cell by cell and slot by slot of time; the surface in the middle of a slot decides which
//! of them break, and how high they ride. What breaks in the slots about a pulse is found once for all threads;
//! it depends on neither them nor the order in which pulses are made.

use std::collections::VecDeque;
use std::sync::Arc;

use super::kept::OneAtATime;
use crate::radar::fault::SeaFault;
use crate::scene::Patch;
use crate::sea::breaking::{Breaker, CELL_M, Law, SLOT_S};
use crate::sea::land::LandSheet;
use crate::sea::surface::{Evaluator, Fields, Grid, Selection, Surface, SurfaceError};

/// Slots and patches whose breakers are kept, and slots whose surface is where the patch moves: as many as a
/// life may span, and threads that make other pulses.
const KEPT: usize = 64;
const SURFACES: usize = 4;
/// Breakers that may be alive at a time in the mean, and area of a patch, m^2.
const MOST_ALIVE: f64 = 1e6;
const MOST_AREA_M2: f64 = 4e9;

/// A breaker on the surface that it was found on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Riding {
    pub breaker: Breaker,
    pub height_m: f64,
}

/// The breaking waves of a run.
pub(super) struct BreakingPlan {
    law: Law,
    patch_m2: f64,
    /// Standard deviation of the vertical acceleration; 0 of a flat sea.
    deviation_mps2: f64,
    memory: OneAtATime<Memory>,
}

/// What is needed to find them, and was found last.
struct Memory {
    evaluator: Evaluator<f32>,
    grid: Grid,
    /// Slot, and the waves of the whole grid in its middle; the latest last.
    surfaces: VecDeque<(i64, Fields<f32>)>,
    land: Option<LandSheet>,
    /// Slot, first facet of the patch, what breaks; the latest last.
    kept: VecDeque<(i64, [i64; 2], Arc<[Riding]>)>,
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
        let room = || (i64::MIN, Fields::new(surface.grid(), Selection::HEIGHT));
        let memory = OneAtATime::new(Memory {
            evaluator: Evaluator::new(surface),
            grid: *surface.grid(),
            surfaces: (0..if follows { SURFACES } else { 1 }).map(|_| room()).collect(),
            land: land.cloned(),
            kept: VecDeque::with_capacity(KEPT),
        });
        Ok(Self { law, patch_m2, deviation_mps2: acceleration_variance(surface).sqrt(), memory })
    }

    /// How far a breaker may be from where it was found, m.
    pub fn reach_m(&self) -> f64 {
        self.law.reach().1
    }

    /// Breakers that are alive at a time, mean.
    pub fn alive(&self) -> f64 {
        self.law.alive_per_m2() * self.patch_m2
    }

    /// What breaks on a patch in a slot.
    fn slot(&self, slot: i64, patch: &Patch) -> Result<Arc<[Riding]>, SurfaceError> {
        self.memory.with(|memory| self.find(memory, slot, patch))
    }

    /// The same with what is needed for it.
    fn find(&self, memory: &mut Memory, slot: i64, patch: &Patch) -> Result<Arc<[Riding]>, SurfaceError> {
        // Surfaces bear the number of their slot once they are evaluated: a thread that fails leaves nothing
        // wrong.
        let Memory { evaluator, grid, surfaces, land, kept } = memory;
        if let Some((.., found)) = kept.iter().find(|(of, first, _)| *of == slot && *first == patch.first) {
            return Ok(Arc::clone(found));
        }
        if !surfaces.iter().any(|(of, _)| *of == slot)
            && let Some((of, fields)) = surfaces.front_mut()
        {
            *of = i64::MIN;
            evaluator.evaluate((slot as f64 + 0.5) * SLOT_S, fields)?;
            *of = slot;
            surfaces.rotate_left(1);
        }
        let Some((_, fields)) = surfaces.iter().find(|(of, _)| *of == slot) else { return Ok([].into()) };
        let rising = &fields.acceleration_mps2[2];
        let land = land.as_mut().map_or(&[][..], |sheet| {
            sheet.place(patch);
            sheet.land()
        });
        let (mut found, facet_m) = (Vec::new(), patch.facet_m);
        let last = [0, 1].map(|i| patch.first[i] + patch.facets[i] as i64 - 1);
        let cell = |key: i64, side: f64| ((key as f64 + side) * facet_m / CELL_M).floor() as i64;
        for y in cell(patch.first[1], -0.5)..=cell(last[1], 0.5) {
            for x in cell(patch.first[0], -0.5)..=cell(last[0], 0.5) {
                self.law.candidates([x, y], slot, |breaker| {
                    let key = breaker.place_m.map(|at| (at / facet_m).round() as i64);
                    if (0..2).any(|i| !(patch.first[i]..=last[i]).contains(&key[i])) {
                        return;
                    }
                    if land.get(patch.nearest_index(key)).is_some_and(|land| *land > 0.0) {
                        return;
                    }
                    let facet = grid.index(key);
                    let downwards =
                        (self.deviation_mps2 > 0.0).then(|| -f64::from(rising[facet]) / self.deviation_mps2);
                    if breaker.breaks(downwards) {
                        found.push(Riding { breaker, height_m: f64::from(fields.height_m[facet]) });
                    }
                });
            }
        }
        let found: Arc<[Riding]> = found.into();
        if kept.len() >= KEPT {
            kept.pop_front();
        }
        kept.push_back((slot, patch.first, Arc::clone(&found)));
        Ok(found)
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
        for slot in slot(from_s - life_s)..=slot(to_s) {
            let riding = self.slot(slot, patch)?;
            riding.iter().filter(|riding| riding.breaker.lives(from_s, to_s)).for_each(&mut each);
        }
        Ok(())
    }
}
