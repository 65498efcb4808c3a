//! The sea beyond the patch as scatterer paths: cells that stand for the facets of an area each.
//!
//! At a time the sea is split into squares, halved along x and y in turn until they are about `1/n` of the
//! resolution cell there (a range cell on the ground times the width of the narrower beam, from where
//! antennas were when the slot began). A square holds one cell per slot: a facet of the scattering model at a
//! random place, of the area of the square. Its slopes, the velocity of its water and its roughness are those
//! of the waves there ([`crate::sea::wave_sum`]) when its life is half over; its matrix is that of a facet of
//! the patch, as antennas see it from where they are when the slot begins, times the root of the share of
//! such facets that are seen ([`crate::geometry::shadow::smith`]). So powers, polarisation, Doppler and the
//! stripes of swell have the statistics of facets.
//!
//! A cell runs straight on: with its water, and along the bisector of each pair as fast as one frequency asks
//! that is drawn from the lines of the waves that scatter ([`crate::scattering::bragg`]). All of it follows
//! from the seed, the slot and the numbers of the square alone, and is found once, by lots ([`cells`]), in
//! f32 side by side: reference and fast echo share it. Slots of `SLOT_S` overlap by half: a cell lasts two of
//! them, with the amplitude `sin(pi s)`, so that the powers of both add up to 1 at every time.
//!
//! Where there would be more cells at a pulse than are allowed, squares are larger by a power of two that is
//! the same for all of a slot: the least with which no more than half of them are seen as antennas, beams
//! and window are when it begins. None is left out.
//!
//! Limits: main lobes of the antennas ([`crate::radar::lobe`]); the window's own emission; clean water
//! without wakes, films, land or breakers; linear waves, which stay as they are while a cell lives; the waves
//! of the patch do not run on beyond its edge.

mod cells;
mod gains;
mod squares;
mod stretch;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use super::emission::Emission;
use super::facets::Reception;
use super::kept::{Kept, KeptMany};
use super::list::ScattererPaths;
use super::sea::{SeaFailure, SeaPlan};
use super::{PathGenerator, Workspace};
use crate::frames::{Enu, Point, Vector};
use crate::geometry::horizon;
use crate::geometry::light_time::{LightTime, bistatic};
use crate::radar::antenna::Antenna;
use crate::radar::fault::RadarError;
use crate::radar::lobe::MainLobe;
use crate::radar::window::Window;
use crate::scattering::lanes::LaneWater;
use crate::scattering::tilt::ScatterMatrix;
use crate::scattering::two_rays::TwoRays;
use crate::scene::Scene;
use crate::scene::sea::Phases;
use crate::sea::wave_sum::WaveSum;
use crate::units::SPEED_OF_LIGHT_MPS;
use cells::{AsSeen, Cells, Maker, Matrix, Room};
use squares::{Search, Split, Square, is_on};

/// Pulses of a stretch, at most.
pub(crate) const FAR_PULSES: usize = 64;
/// Half the life of a cell, s.
const SLOT_S: f64 = 1.0;
/// How fast cells move, m/s, at most: nearly forward, lines of a few hertz ask for more.
const FASTEST_MPS: f64 = 10.0;
/// How much larger than wanted squares may be.
const COARSEST: f64 = 1_048_576.0;
/// Slots that are kept.
const KEPT: usize = 24;
/// Lots that are kept, at least, and one for so many cells of a pulse.
const LEAST_LOTS: usize = 1024;
const CELLS_OF_LOT: usize = 16;
/// Pulses of the run at which cells are counted for the forecast.
const COUNTED: u64 = 5;

/// The far sea of a run.
#[derive(Clone, Debug)]
pub(super) struct FarPlan {
    waves: Arc<WaveSum>,
    /// Of all antennas, transmitters first.
    lobes: Vec<MainLobe>,
    range_cell_m: f64,
    /// Wanted in a resolution cell, and those of a pulse, at most.
    cells: f64,
    most: usize,
    texture: bool,
    shadowed: bool,
    two_rays: Option<TwoRays>,
    phases: Phases,
    /// Rms slope of map and facets together.
    all_slope_rms: f64,
    /// Deviation of frequencies where waves do not travel, rad/s.
    forgets_radps: f64,
    /// The scattering model, modulated by these waves.
    lanes: LaneWater,
    slots: Arc<Kept<i64, Slot>>,
    /// Cells by slot and lot.
    lots: Arc<KeptMany<(i64, Square), Cells>>,
    /// Cells of a pulse, mean, and in a resolution cell, the fewest: of some pulses of the run.
    mean: f64,
    in_cell: f64,
    seed: u64,
}

/// Buffers of one thread.
#[derive(Clone)]
pub(super) struct Work {
    room: Room,
    stretch: stretch::Buffers,
    /// Both antennas of every pair, `[pulse][pair]`.
    outlooks: Vec<[gains::Outlook; 2]>,
}

impl Work {
    fn new(sea: &SeaPlan, of: &PathGenerator) -> Self {
        Self { room: Room::new(sea), stretch: stretch::Buffers::new(of), outlooks: Vec::new() }
    }
}

/// What holds for a slot.
#[derive(Clone, Debug)]
struct Slot {
    /// Where antennas are when it begins, transmitters first.
    places: Vec<Point<Enu>>,
    /// Of a pulse that is emitted then.
    windows: Vec<Window>,
    /// Area of a cell over that which is wanted.
    coarser: f64,
}

impl FarPlan {
    /// Of a scene that has one; `None` of others.
    fn new(scene: &Scene, plan: &SeaPlan, antennas: &[Antenna], pulse_length_s: f64) -> Option<Self> {
        let sea = scene.sea.as_ref()?;
        let far = sea.far?;
        let bandwidth_hz = scene.radar.waveform.bandwidth_hz().unwrap_or(scene.radar.sample_rate_hz);
        // That of a pulse without modulation.
        let bandwidth_hz = bandwidth_hz.max(pulse_length_s.recip()).min(scene.radar.sample_rate_hz);
        let relaxation_per_s = plan.scattering.relaxation_per_s();
        let (spectrum, dispersion) = (plan.scattering.spectrum(), sea.water.dispersion);
        let waves = WaveSum::new(spectrum, dispersion, sea.patch.facet_m, relaxation_per_s, scene.seed);
        let [up, cross] = plan.scattering.tilt_variances();
        let of_map = [[1.0, 0.0], [0.0, 1.0]].map(|axis| waves.slope_rms(axis).powi(2));
        let forgets_radps = sea.scattering.decorrelation_s.map_or(0.0, |s| std::f64::consts::SQRT_2 / s);
        let two_rays = sea.shadow.as_ref().is_some_and(|shadow| shadow.two_rays);
        Some(Self {
            lobes: antennas.iter().map(MainLobe::of).collect(),
            range_cell_m: 0.5 * SPEED_OF_LIGHT_MPS / bandwidth_hz,
            cells: f64::from(far.cells),
            most: far.most as usize,
            texture: far.texture,
            shadowed: sea.shadow.is_some(),
            two_rays: two_rays.then(|| plan.scattering.two_rays(plan.surface.expected().variance_m2.sqrt())),
            phases: sea.scattering.phases,
            all_slope_rms: (up + cross + of_map[0] + of_map[1]).sqrt(),
            forgets_radps,
            lanes: plan.lanes.modulated_by(waves.strength()),
            slots: Self::no_slots(antennas.len()),
            lots: Self::no_lots(far.most as usize),
            mean: 0.0,
            in_cell: 0.0,
            seed: scene.seed,
            waves: Arc::new(waves),
        })
    }

    fn no_slots(antennas: usize) -> Arc<Kept<i64, Slot>> {
        Arc::new(Kept::new(KEPT, || Slot {
            places: Vec::with_capacity(antennas),
            windows: Vec::with_capacity(antennas),
            coarser: 1.0,
        }))
    }

    fn most_lots(most: usize) -> usize {
        LEAST_LOTS.max(most / CELLS_OF_LOT)
    }

    fn no_lots(most: usize) -> Arc<KeptMany<(i64, Square), Cells>> {
        Arc::new(KeptMany::new(Self::most_lots(most)))
    }

    /// The same sea seen from other tracks.
    pub fn renewed(&self) -> Self {
        Self { slots: Self::no_slots(self.lobes.len()), lots: Self::no_lots(self.most), ..self.clone() }
    }

    /// Amplitude at a time of a slot: 0 at the ends of the life.
    fn envelope(slot: i64, elapsed_s: f64) -> f64 {
        (0.5 * PI * (elapsed_s / SLOT_S - slot as f64)).sin().max(0.0)
    }

    fn middle_s(slot: i64) -> f64 {
        (slot as f64 + 1.0) * SLOT_S
    }

    /// The slots whose cells live at a time after pulse 0.
    fn slots_at(elapsed_s: f64) -> [i64; 2] {
        let last = (elapsed_s / SLOT_S).floor() as i64;
        [last - 1, last]
    }
}

/// The matrix of a cell in f64.
fn of_cell(matrix: &Matrix) -> ScatterMatrix {
    matrix.map(|row| row.map(|[re, im]| Complex64::new(re.into(), im.into())))
}

impl PathGenerator {
    /// Whether there is a sea beyond the patch.
    pub fn has_far_sea(&self) -> bool {
        self.far.is_some()
    }

    /// Cells of the far sea at a pulse, mean, and in a resolution cell, the fewest; `None` without it.
    pub fn far_cells(&self) -> Option<(f64, f64)> {
        self.far.as_ref().map(|far| (far.mean, far.in_cell))
    }

    /// What cells that are kept take, at most, bytes.
    pub fn far_bytes(&self) -> u64 {
        let lot = squares::LOT_CELLS as usize * cells::cell_bytes(self.pairs.len());
        self.far.as_ref().map_or(0, |far| (FarPlan::most_lots(far.most) * lot) as u64)
    }

    /// Cells of a pulse for which there is room beforehand.
    pub(super) fn far_room(&self) -> usize {
        self.far.as_ref().map_or(0, |far| far.most)
    }

    /// Plans the far sea of a scene whose tracks are known, and counts the cells of some pulses.
    pub(super) fn plan_far_sea(&mut self, scene: &Scene) -> Result<(), RadarError> {
        let of = self.sea.as_ref();
        self.far = of.and_then(|sea| FarPlan::new(scene, sea, &self.antennas, self.pulse_length_s));
        let Some(plan) = self.far.clone() else { return Ok(()) };
        let mut workspace = self.workspace();
        let mut paths = ScattererPaths::new(self.pairs.len(), self.radar.channels.len(), 0);
        let (last, mut sum, mut fewest) = (self.pulses.saturating_sub(1), 0, plan.cells);
        for n in 0..COUNTED {
            let index = (u128::from(last) * u128::from(n) / u128::from(COUNTED - 1)) as u64;
            paths.clear();
            self.far_sea_at((index, 1), &mut workspace, &mut paths)?;
            sum += paths.len();
            let Workspace { other, places, .. } = &mut workspace;
            let mut in_cell = 0.0;
            for slot in FarPlan::slots_at(self.radar.emissions.elapsed_s(index)) {
                in_cell += plan.cells / 2.0 / self.begin_far_slot(&plan, (index, slot), other, places)?;
            }
            fewest = fewest.min(in_cell);
        }
        if let Some(far) = &mut self.far {
            (far.mean, far.in_cell) = (sum as f64 / COUNTED as f64, fewest);
        }
        Ok(())
    }

    /// What holds for a slot of a pulse: fills in where antennas are when it begins, and returns how coarse
    /// it is. `standing` is overwritten where it is not known.
    fn begin_far_slot(
        &self,
        plan: &FarPlan,
        (index, slot): (u64, i64),
        standing: &mut Emission,
        places: &mut Vec<Point<Enu>>,
    ) -> Result<f64, RadarError> {
        let find = |found: &mut Slot| {
            let Some(sea) = &self.sea else { return Ok(()) };
            let begin_s = (slot as f64 * SLOT_S).max(0.0);
            let t = self.start.plus(begin_s);
            let stands = standing.stand(&self.circumstances(), t);
            stands.map_err(|failure| self.track_error(index, failure))?;
            found.windows.clear();
            for window in 0..self.windows() {
                let opens_s = self.nominal_start_s(window, index, t)?;
                found.windows.push(Window::new(&self.radar, opens_s, self.pulse_length_s));
            }
            found.places.clear();
            found.places.extend(standing.centres.iter().map(|centre| centre.position));
            let reception =
                Reception { t, elapsed_s: begin_s, ..self.reception(index, index, standing, &found.windows) };
            let patch = sea.patch_at(&reception.surroundings, begin_s);
            let patch = &patch.map_err(|failure| self.track_error(index, failure))?;
            let fits = |coarser: f64| {
                let split = Split { plan, of: self, places: &found.places, coarser, slot };
                let search = Search { split, reception: &reception, patch, about: [0.0; 2] };
                let mut count = 0;
                search.seen_cells(&mut |_| {
                    count += 1;
                    count <= plan.most / 2
                })
            };
            // From coarse to fine: all that is counted is twice what is left at most.
            let mut coarser = COARSEST;
            while coarser > 1.0 && fits(0.5 * coarser) {
                coarser *= 0.5;
            }
            found.coarser = coarser;
            Ok(())
        };
        plan.slots.with(slot, find, |found| {
            places.clone_from(&found.places);
            found.coarser
        })
    }

    /// Appends the far sea that an emission illuminates and its window receives: one of so many cells, with
    /// the power of as many.
    pub(super) fn append_far_sea(
        &self,
        (index, every): (u64, usize),
        reception: &Reception,
        (standing, places, amplitude): (&mut Emission, &mut Vec<Point<Enu>>, &mut [Complex64]),
        room: &mut Option<Work>,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        let (Some(plan), Some(sea)) = (&self.far, &self.sea) else { return Ok(()) };
        let elapsed_s = reception.elapsed_s;
        let room = &mut room.get_or_insert_with(|| Work::new(sea, self)).room;
        let patch = sea.patch_at(&reception.surroundings, elapsed_s);
        let patch = &patch.map_err(|failure| self.sea_error(index, SeaFailure::from(failure)))?;
        for slot in FarPlan::slots_at(elapsed_s) {
            let coarser = self.begin_far_slot(plan, (index, slot), standing, places)?;
            let split = Split { plan, of: self, places, coarser, slot };
            let search = Search { split, reception, patch, about: [0.0; 2] };
            let (envelope, middle_s) = (FarPlan::envelope(slot, elapsed_s), FarPlan::middle_s(slot));
            let maker = Maker { split, sea, middle_s };
            let first = paths.len();
            let mut append = |cells: &Cells| {
                for (i, place) in cells.places.iter().enumerate() {
                    let [x, y, _] = place.to_array();
                    if !is_on(patch, [x, y]) {
                        let at = (elapsed_s - middle_s, envelope);
                        self.append_cell(&search, (cells, i, at), amplitude, paths);
                    }
                }
            };
            if every == 1 {
                search.lots(Square::ALL, &mut |lot| {
                    plan.lots.with((slot, lot), || maker.lot(lot, room), &mut append);
                    true
                });
                continue;
            }
            // Those of a sample are not kept.
            let (mut number, mut cells) = (0, Cells::default());
            search.seen_cells(&mut |found| {
                number += 1;
                if number % every == 0 {
                    let nearby = plan.waves.about(found.place_m, middle_s);
                    maker.add(found, &nearby, room, &mut cells);
                }
                true
            });
            maker.finish(room, &mut cells);
            append(&cells);
            paths.turn(first, Complex64::from((every as f64).sqrt()));
        }
        Ok(())
    }

    /// Appends a cell if any pair sees it.
    fn append_cell(
        &self,
        search: &Search,
        (cells, i, (from_middle_s, envelope)): (&Cells, usize, (f64, f64)),
        amplitude: &mut [Complex64],
        paths: &mut ScattererPaths,
    ) {
        let reception = search.reception;
        let Reception { emission, tx_pol, offset_s, .. } = *reception;
        let (earth, transmitters) = (self.frame.hiding_earth(), self.radar.transmitters.len());
        amplitude.fill(Complex64::ZERO);
        let pairs = || self.plans.iter().zip(&cells.pairs);
        let moved = |seen: &AsSeen| {
            let velocity = Vector::from_raw(DVec3::from_array(seen.velocities_mps[i].map(f64::from)));
            (cells.places[i] + velocity * from_middle_s, velocity)
        };
        if !pairs().any(|(plan, seen)| search.is_seen_by(plan, moved(seen).0, 0.0)) {
            return;
        }
        for (pair, (plan, seen)) in pairs().enumerate() {
            let ends = plan.ends(transmitters);
            let [tx, rx] = ends.map(|end| &emission.centres[end]);
            let (position, velocity) = moved(seen);
            let path = bistatic(LightTime::Exact, tx, position, velocity, rx);
            paths.delay_s[pair].push(path.delay_s);
            paths.delay_rate[pair].push(path.delay_rate);
            let touches = reception.window(plan).touches(offset_s + path.delay_s);
            if !(touches && plan.receives(tx_pol) && search.is_seen_by(plan, position, 0.0)) {
                continue;
            }
            let passes = [tx, rx].map(|end| {
                let clearance_m = horizon::clearance_m(earth, end.position, cells.places[i]);
                horizon::weight(clearance_m, horizon::POINT_EDGE_M)
            });
            let scale = plan.link.scattered_over(&path) * passes[0] * passes[1] * envelope;
            if scale > 0.0 {
                let matrix = of_cell(&seen.matrices[i]);
                self.amplitudes(plan, (&path, None), Some(&matrix), scale, tx_pol, emission, amplitude);
            }
        }
        paths.finish(offset_s, amplitude);
    }

    /// Appends the far sea of a pulse: one of so many cells, with the power of as many.
    pub(super) fn far_sea_at(
        &self,
        (index, every): (u64, usize),
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        if self.far.is_none() {
            return Ok(());
        }
        let Workspace { own, other, amplitude, places, windows, far, .. } = workspace;
        self.evaluate(index, own)?;
        self.windows_at(index, windows)?;
        let reception = self.reception_of_all(index, own, windows);
        self.append_far_sea((index, every), &reception, (other, places, amplitude), far, paths)
    }
}
