//! Rain as scatterer paths: points that stand for the drops of a volume each.
//!
//! At a time the space under the rain's top is split into boxes, halved along x, y and z in turn until none
//! is larger than `1/DROPS` of the resolution cell about it (a range cell `c/2B` times the area that the
//! narrower beam lights there, from where antennas were when the slot began). A box holds one point per slot:
//! at a random place, with a random phase and the cross section `eta V` of its volume
//! ([`crate::radar::rain`]). Both follow from the seed, the slot and the numbers of the box alone.
//!
//! A point runs straight on, with the wind, the mean fall and a Gaussian velocity of its own, which is the
//! Doppler spectrum of the rain. Slots of `SLOT_S` overlap by half: a point lasts two of them, with the
//! amplitude `sin(pi s)`, so that the powers of both add up to 1 at every time.
//!
//! Where there would be more than [`MOST`] points at a pulse, boxes are larger by a power of two that is the
//! same for all of a slot: the least with which no more than half of them are seen as antennas, beams and
//! window are when it begins. It follows from that instant alone. A beam that turns into the rain meanwhile
//! sees more until the slot ends; none are left out.
//!
//! Its matrix is that of a Rayleigh scatterer, a dipole along the field that it meets:
//! `sqrt(eta V) e_p . e_q` in the bases of the path, all of it back and none at right angles in the plane of
//! the field.
//!
//! Paths are found exactly and at every pulse by both echoes. Limits: main lobes of the antennas
//! ([`crate::radar::lobe`]); the window's own emission, so that rain beyond the pulse interval does not fold
//! into it; one rate, wind and fall at all heights; drops that are spheres.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;
use rand::RngExt;
use rand_distr::StandardNormal;

use super::facets::Reception;
use super::{PathGenerator, Workspace};
use crate::frames::{Enu, Point, Vector};
use crate::geometry::bistatic::Basis;
use crate::geometry::horizon;
use crate::geometry::light_time::{LightTime, bistatic};
use crate::paths::emission::Emission;
use crate::paths::kept::Kept;
use crate::paths::list::ScattererPaths;
use crate::radar::antenna::Antenna;
use crate::radar::fault::RadarError;
use crate::radar::lobe::MainLobe;
use crate::radar::rain::{fall_mps, volume_reflectivity_per_m};
use crate::radar::window::Window;
use crate::rng::{Room, stream};
use crate::scene::{Radar, Scene};
use crate::sea::wind::Wind;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Half the life of a point, s.
const SLOT_S: f64 = 1.0;
/// Points in a resolution cell that are wanted, and those of a pulse, at most.
pub const DROPS: f64 = 8.0;
pub const MOST: usize = 16_384;
/// How much larger than wanted boxes may be.
const COARSEST: f64 = 1_048_576.0;
/// Slots that are kept.
const KEPT: usize = 24;
/// Pulses of the run at which points are counted for the forecast.
const COUNTED: u64 = 5;
/// Half the side of the space that is split, m, and how often it is: boxes of 2 m.
const HALF_M: f64 = 1_048_576.0;
const DEEPEST: u32 = 60;
/// Deviations of its velocity within which a point is looked for: one of a million is faster.
const WITHIN: f64 = 5.5;
/// What antennas turn while light crosses a box is small beside it, m.
const MARGIN_M: f64 = 0.5;

/// The rain of a run.
#[derive(Clone, Debug)]
pub(super) struct RainPlan {
    /// Cross section per volume, 1/m.
    eta_per_m: f64,
    top_m: f64,
    /// Mean velocity and rms of what is about it, m/s.
    drift_mps: DVec3,
    spread_mps: f64,
    /// Of all antennas, transmitters first.
    lobes: Vec<MainLobe>,
    range_cell_m: f64,
    slots: Arc<Kept<i64, Slot>>,
    /// Points of a pulse, mean, and in a resolution cell, the fewest: of some pulses of the run.
    drops: f64,
    drops_per_cell: f64,
    seed: u64,
}

/// What holds for a slot.
#[derive(Clone, Debug)]
struct Slot {
    /// Where antennas are when it begins, transmitters first.
    places: Vec<Point<Enu>>,
    /// Of a pulse that is emitted then.
    windows: Vec<Window>,
    /// Volume of a point over that which is wanted.
    coarser: f64,
}

/// A box of space that is split: level and numbers along x, y and z.
#[derive(Clone, Copy)]
struct Cell {
    level: u32,
    at: [u32; 3],
}

impl Cell {
    fn side_m(self) -> DVec3 {
        let halved = |axis: u32| 2.0 * HALF_M / f64::from(1u32 << ((self.level + 2 - axis) / 3));
        DVec3::new(halved(0), halved(1), halved(2))
    }

    fn low_m(self, side_m: DVec3) -> DVec3 {
        let [x, y, z] = self.at.map(f64::from);
        DVec3::new(x, y, z) * side_m - DVec3::splat(HALF_M)
    }

    /// One of its halves.
    fn half(self, upper: u32) -> Self {
        let mut at = self.at;
        let axis = (self.level % 3) as usize;
        at[axis] = 2 * at[axis] + upper;
        Self { level: self.level + 1, at }
    }
}

/// What is looked for in a slot at a pulse.
struct Search<'a> {
    plan: &'a RainPlan,
    of: &'a PathGenerator,
    reception: &'a Reception<'a>,
    /// Where antennas were when the slot began.
    places: &'a [Point<Enu>],
    coarser: f64,
    slot: i64,
}

/// A point at a pulse.
struct Drop {
    position: Point<Enu>,
    velocity: Vector<Enu>,
    phasor: Complex64,
    sigma_m2: f64,
}

impl RainPlan {
    /// Of a scene whose rain returns an echo; `None` of others.
    pub fn new(scene: &Scene, antennas: &[Antenna], pulse_length_s: f64) -> Option<Self> {
        let Radar { carrier_hz, rain_mmph, sample_rate_hz, .. } = scene.radar;
        let bandwidth_hz = scene.radar.waveform.bandwidth_hz().unwrap_or(sample_rate_hz);
        // That of a pulse without modulation.
        let bandwidth_hz = bandwidth_hz.max(pulse_length_s.recip()).min(sample_rate_hz);
        let clutter = scene.radar.rain_clutter.filter(|_| rain_mmph > 0.0)?;
        // A wind that is wrong is reported by the sea.
        let wind = scene.sea.as_ref().and_then(|sea| Wind::resolve(&sea.water.wind).ok());
        let (sin, cos) = wind.map_or(0.0, |wind| wind.direction_rad).sin_cos();
        let wind_mps = wind.map_or(0.0, |wind| wind.u10_mps);
        Some(Self {
            eta_per_m: volume_reflectivity_per_m(carrier_hz, rain_mmph),
            top_m: clutter.top_m,
            drift_mps: DVec3::new(wind_mps * cos, wind_mps * sin, -fall_mps(rain_mmph)),
            spread_mps: clutter.spread_mps,
            lobes: antennas.iter().map(MainLobe::of).collect(),
            range_cell_m: 0.5 * SPEED_OF_LIGHT_MPS / bandwidth_hz,
            slots: Self::no_slots(antennas.len()),
            drops: 0.0,
            drops_per_cell: 0.0,
            seed: scene.seed,
        })
    }

    fn no_slots(antennas: usize) -> Arc<Kept<i64, Slot>> {
        Arc::new(Kept::new(KEPT, || Slot {
            places: Vec::with_capacity(antennas),
            windows: Vec::with_capacity(antennas),
            coarser: 1.0,
        }))
    }

    /// The same rain seen from other tracks.
    pub fn renewed(&self) -> Self {
        Self { slots: Self::no_slots(self.lobes.len()), ..self.clone() }
    }

    /// Amplitude at a time of a slot: 0 at the ends of the life.
    fn envelope(slot: i64, elapsed_s: f64) -> f64 {
        (0.5 * PI * (elapsed_s / SLOT_S - slot as f64)).sin().max(0.0)
    }

    fn middle_s(slot: i64) -> f64 {
        (slot as f64 + 1.0) * SLOT_S
    }
}

impl Search<'_> {
    /// Volume of the box of a point about a place, m^3.
    fn wanted_m3(&self, place: DVec3) -> f64 {
        let transmitters = self.of.radar.transmitters.len();
        let area_m2 = |end: usize| {
            let (range_m, sr) =
                (place.distance(self.places[end].raw()), self.plan.lobes[end].solid_angle_sr());
            (sr * range_m * range_m).min(sr.sqrt() * range_m * self.plan.top_m)
        };
        let least = self
            .of
            .pairs
            .iter()
            .map(|pair| area_m2(pair.transmitter).min(area_m2(transmitters + pair.receiver)));
        // Of both slots that overlap.
        let share = 2.0 / DROPS * self.coarser * self.plan.range_cell_m;
        share * least.fold(f64::INFINITY, f64::min)
    }

    /// Whether rain may stand between two heights over a rectangle.
    fn is_wet(&self, low: DVec3, high: DVec3) -> bool {
        let earth = self.of.frame.earth();
        let nearest = |axis: usize| 0f64.clamp(low[axis], high[axis]);
        let farthest = |axis: usize| if low[axis] + high[axis] > 0.0 { high[axis] } else { low[axis] };
        let least_m = low.z + earth.drop_m(nearest(0), nearest(1));
        let most_m = high.z + earth.drop_m(farthest(0), farthest(1));
        most_m > 0.0 && least_m < self.plan.top_m
    }

    /// Whether any pair sees a sphere about a place.
    fn is_seen(&self, place: DVec3, radius_m: f64) -> bool {
        let Reception { emission, offset_s, axes_span_s, .. } = *self.reception;
        let transmitters = self.of.radar.transmitters.len();
        self.of.plans.iter().any(|plan| {
            let ends = plan.ends(transmitters);
            let way = |end: usize| place - emission.centres[end].position.raw();
            let ways = [way(ends[0]), way(ends[1])];
            let lengths_m = [ways[0].length(), ways[1].length()];
            let delay_s = (lengths_m[0] + lengths_m[1]) / SPEED_OF_LIGHT_MPS;
            let slack_s = 2.0 * radius_m / SPEED_OF_LIGHT_MPS;
            let (begin_s, window) = (offset_s + delay_s, self.reception.window(plan));
            window.touches_within(begin_s, slack_s)
                && (0..2).all(|at| {
                    let axes = emission.axes_after(ends[at], delay_s, axes_span_s);
                    let length_m = lengths_m[at];
                    let slack_rad = if length_m > radius_m { (radius_m / length_m).asin() } else { PI };
                    self.plan.lobes[ends[at]].holds(axes.transpose() * ways[at], slack_rad)
                })
        })
    }

    /// Hands over the points of a box that may be seen; `false` once no more are wanted.
    fn visit(&self, cell: Cell, each: &mut impl FnMut(&Drop) -> bool) -> bool {
        let side_m = cell.side_m();
        let low = cell.low_m(side_m);
        let high = low + side_m;
        if !self.is_wet(low, high) {
            return true;
        }
        let from_middle_s = self.reception.elapsed_s - RainPlan::middle_s(self.slot);
        let middle = 0.5 * (low + high);
        let margin_m = MARGIN_M + WITHIN * self.plan.spread_mps * from_middle_s.abs();
        let radius_m = 0.5 * side_m.length() + margin_m;
        if !self.is_seen(middle + self.plan.drift_mps * from_middle_s, radius_m) {
            return true;
        }
        let volume_m3 = side_m.x * side_m.y * side_m.z;
        if cell.level < DEEPEST && volume_m3 > std::f64::consts::SQRT_2 * self.wanted_m3(middle) {
            return (0..2).all(|upper| self.visit(cell.half(upper), each));
        }
        let [x, y, z] = cell.at.map(u64::from);
        let part = (self.slot as u64) << 8 | u64::from(cell.level);
        let mut rng = stream(self.plan.seed, Room::RainDrop, x << 42 | y << 21 | z, part);
        let [x, y, z, turns] = [(); 4].map(|()| rng.random::<f64>());
        let place = low + side_m * DVec3::new(x, y, z);
        // Where its life is half over decides, so that none appears or goes while it is seen.
        let height_m = place.z + self.of.frame.earth().drop_m(place.x, place.y);
        if !(0.0..self.plan.top_m).contains(&height_m) {
            return true;
        }
        let own: [f64; 3] = [(); 3].map(|()| rng.sample(StandardNormal));
        let velocity = self.plan.drift_mps + self.plan.spread_mps * DVec3::from_array(own);
        let position = place + velocity * from_middle_s;
        if !self.is_seen(position, 0.0) {
            return true;
        }
        let envelope = RainPlan::envelope(self.slot, self.reception.elapsed_s);
        each(&Drop {
            position: Point::from_raw(position),
            velocity: Vector::from_raw(velocity),
            phasor: Complex64::cis(TAU * turns),
            sigma_m2: self.plan.eta_per_m * volume_m3 * envelope * envelope,
        })
    }
}

impl PathGenerator {
    /// Whether rain returns an echo.
    pub fn rains(&self) -> bool {
        self.rain.is_some()
    }

    /// Points that stand for rain at a pulse, mean; 0 where it returns nothing.
    pub fn drops(&self) -> f64 {
        self.rain.as_ref().map_or(0.0, |rain| rain.drops)
    }

    /// Points that stand for rain in a resolution cell: fewer than are wanted where there would be too many.
    pub fn drops_per_cell(&self) -> f64 {
        self.rain.as_ref().map_or(0.0, |rain| rain.drops_per_cell)
    }

    /// Lets it rain in a scene whose tracks are known, and counts the points of some pulses.
    pub(super) fn let_it_rain(&mut self, scene: &Scene) -> Result<(), RadarError> {
        self.rain = RainPlan::new(scene, &self.antennas, self.pulse_length_s);
        let Some(plan) = self.rain.clone().filter(|_| self.pulses > 0) else { return Ok(()) };
        let mut workspace = self.workspace();
        let mut paths = ScattererPaths::new(self.pairs.len(), self.radar.channels.len(), 0);
        let (last, mut sum, mut fewest) = (self.pulses.saturating_sub(1), 0, DROPS);
        for n in 0..COUNTED {
            let index = (u128::from(last) * u128::from(n) / u128::from(COUNTED - 1)) as u64;
            self.rain_at(index, &mut workspace, &mut paths)?;
            sum += paths.len();
            let Workspace { other, places, .. } = &mut workspace;
            let slots = Self::slots_at(self.radar.emissions.elapsed_s(index));
            let mut in_cell = 0.0;
            for slot in slots {
                in_cell += DROPS / 2.0 / self.begin_slot(&plan, (index, slot), other, places)?;
            }
            fewest = fewest.min(in_cell);
        }
        if let Some(rain) = &mut self.rain {
            (rain.drops, rain.drops_per_cell) = (sum as f64 / COUNTED as f64, fewest);
        }
        Ok(())
    }

    /// The slots whose points live at a time after pulse 0.
    fn slots_at(elapsed_s: f64) -> [i64; 2] {
        let last = (elapsed_s / SLOT_S).floor() as i64;
        [last - 1, last]
    }

    /// What holds for a slot of a pulse: fills in where antennas are when it begins, and returns how coarse
    /// it is.
    /// `standing` is overwritten where it is not known.
    fn begin_slot(
        &self,
        plan: &RainPlan,
        (index, slot): (u64, i64),
        standing: &mut Emission,
        places: &mut Vec<Point<Enu>>,
    ) -> Result<f64, RadarError> {
        let find = |found: &mut Slot| {
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
            let fits = |coarser: f64| {
                let search =
                    Search { plan, of: self, reception: &reception, places: &found.places, coarser, slot };
                let mut count = 0;
                search.visit(Cell { level: 0, at: [0; 3] }, &mut |_| {
                    count += 1;
                    count <= MOST / 2
                });
                count <= MOST / 2
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

    /// Appends the rain that an emission illuminates and its window receives.
    pub(super) fn append_rain(
        &self,
        index: u64,
        reception: &Reception,
        (standing, places, amplitude): (&mut Emission, &mut Vec<Point<Enu>>, &mut [Complex64]),
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        let Some(plan) = &self.rain else { return Ok(()) };
        for slot in Self::slots_at(reception.elapsed_s) {
            let coarser = self.begin_slot(plan, (index, slot), standing, places)?;
            let search = Search { plan, of: self, reception, places, coarser, slot };
            search.visit(Cell { level: 0, at: [0; 3] }, &mut |drop| {
                self.append_drop(reception, drop, amplitude, paths);
                true
            });
        }
        Ok(())
    }

    fn append_drop(
        &self,
        reception: &Reception,
        drop: &Drop,
        amplitude: &mut [Complex64],
        paths: &mut ScattererPaths,
    ) {
        let Reception { emission, tx_pol, offset_s, .. } = *reception;
        let (earth, transmitters) = (self.frame.hiding_earth(), self.radar.transmitters.len());
        amplitude.fill(Complex64::ZERO);
        for (pair, plan) in self.plans.iter().enumerate() {
            let ends = [plan.pair.transmitter, transmitters + plan.pair.receiver];
            let [tx, rx] = ends.map(|end| &emission.centres[end]);
            let path = bistatic(LightTime::Exact, tx, drop.position, drop.velocity, rx);
            paths.delay_s[pair].push(path.delay_s);
            paths.delay_rate[pair].push(path.delay_rate);
            if !(reception.window(plan).touches(offset_s + path.delay_s) && plan.receives(tx_pol)) {
                continue;
            }
            let legs_m = [path.tx_leg_s, path.rx_leg_s].map(|leg_s| leg_s * SPEED_OF_LIGHT_MPS);
            let seen = [tx, rx].map(|end| {
                let clearance_m = horizon::clearance_m(earth, end.position, drop.position);
                horizon::weight(clearance_m, horizon::POINT_EDGE_M)
            });
            let scale = plan.link.scattered(legs_m[0], legs_m[1]) * seen[0] * seen[1];
            if scale == 0.0 {
                continue;
            }
            let (sent, received) = (Basis::of(path.incident), Basis::of(path.scattered));
            let of = drop.phasor * drop.sigma_m2.sqrt();
            let matrix = [received.v, received.h].map(|e| [sent.v, sent.h].map(|own| of * e.dot(own)));
            self.amplitudes(plan, (&path, None), Some(&matrix), scale, tx_pol, emission, amplitude);
        }
        paths.finish(offset_s, amplitude);
    }

    /// Appends the rain of a pulse.
    pub(super) fn rain_at(
        &self,
        index: u64,
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        if self.rain.is_none() {
            return Ok(());
        }
        let Workspace { own, other, amplitude, places, windows, .. } = workspace;
        self.evaluate(index, own)?;
        self.windows_at(index, windows)?;
        let reception = self.reception_of_all(index, own, windows);
        self.append_rain(index, &reception, (other, places, amplitude), paths)
    }
}
