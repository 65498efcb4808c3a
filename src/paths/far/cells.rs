//! Cells of a lot as all pairs of antennas see them in a slot: found once, side by side, for all pulses.
//!
//! A cell is a facet of the scattering model ([`crate::scattering::lanes`], of clean water): its slope is
//! that of the waves less the fall of the mean surface, its phasors are its own. Of both mechanisms it is
//! one, drawn by their powers, with the power of both, since each has a Doppler of its own.

use glam::{DVec2, DVec3};
use rand::RngExt;

use super::FASTEST_MPS;
use super::squares::{Found, Split, Square};
use crate::cpu::Variant;
use crate::frames::{Enu, Point};
use crate::geometry::lanes::{LANES, Row};
use crate::geometry::shadow::smith;
use crate::paths::block::OnRays;
use crate::paths::sea::SeaPlan;
use crate::rng::{self, stream};
use crate::scattering::bragg::Mechanism;
use crate::scattering::lanes::Batch;
use crate::scene::sea::Phases;
use crate::sea::wave_sum::{Nearby, Waters, sin_cos_of_turns};

/// Slope of what would reflect a ray, over that of the sea, beyond which nothing specular is looked for.
const STEEPEST: f64 = 7.0;

/// A scattering matrix, `[receive][transmit]`, V before H, real and imaginary part, sqrt(m^2).
pub(super) type Matrix = [[[f32; 2]; 2]; 2];

/// Cells side by side.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    /// Where they are when their life is half over.
    pub places: Vec<Point<Enu>>,
    /// By every pair.
    pub pairs: Vec<AsSeen>,
}

/// The same as a pair of antennas sees them.
#[derive(Clone, Debug, Default)]
pub(super) struct AsSeen {
    /// Of the water, and along the bisector as fast as the frequency of the cell asks, m/s.
    pub velocities_mps: Vec<[f32; 3]>,
    pub matrices: Vec<Matrix>,
}

impl AsSeen {
    fn with_capacity(count: usize) -> Self {
        Self { velocities_mps: Vec::with_capacity(count), matrices: Vec::with_capacity(count) }
    }
}

/// A cell, its place in space and the waves there.
#[derive(Clone, Copy)]
struct Drawn {
    found: Found,
    place: DVec3,
    waters: Waters,
}

/// Room to find cells in.
#[derive(Clone)]
pub(super) struct Room {
    batch: Box<Batch>,
    phasors: Vec<[Row; 2]>,
    drawn: Vec<Drawn>,
}

impl Room {
    pub fn new(sea: &SeaPlan) -> Self {
        let mechanisms = sea.scattering.mechanisms();
        let row = [0.0; LANES];
        Self {
            batch: Batch::boxed(mechanisms),
            phasors: vec![[row; 2]; mechanisms],
            drawn: Vec::with_capacity(LANES),
        }
    }
}

/// Of a cell that so many pairs see, bytes.
pub(super) fn cell_bytes(pairs: usize) -> usize {
    size_of::<Point<Enu>>() + pairs * (size_of::<[f32; 3]>() + size_of::<Matrix>())
}

/// What cells of a slot are found by.
#[derive(Clone, Copy)]
pub(super) struct Maker<'a> {
    pub split: Split<'a>,
    pub sea: &'a SeaPlan,
    /// When lives are half over, after pulse 0.
    pub middle_s: f64,
}

impl Maker<'_> {
    /// All cells of a lot.
    pub fn lot(&self, lot: Square, room: &mut Room) -> Cells {
        let count = self.split.count(lot);
        let mut cells = Cells {
            places: Vec::with_capacity(count),
            pairs: self.split.of.plans.iter().map(|_| AsSeen::with_capacity(count)).collect(),
        };
        let nearby = self.split.plan.waves.about(lot.middle_m(), self.middle_s);
        self.split.cells(lot, &mut |found| {
            self.add(found, &nearby, room, &mut cells);
            true
        });
        self.finish(room, &mut cells);
        cells
    }

    /// Takes one more, in waves that are known nearby, and finds those taken so far when there is no room.
    pub fn add(&self, found: Found, nearby: &Nearby, room: &mut Room, cells: &mut Cells) {
        if room.drawn.len() == LANES {
            self.finish(room, cells);
        }
        let i = room.drawn.len();
        for ([re, im], turns) in room.phasors.iter_mut().zip(found.turns) {
            (im[i], re[i]) = sin_cos_of_turns(turns);
        }
        let [x, y] = found.place_m;
        let waters = self.waters(&found, nearby);
        let earth = self.split.of.frame.earth();
        let fall = earth.drop_slope(x, y);
        for ((row, own), fall) in room.batch.slope.iter_mut().zip(waters.slope).zip(fall) {
            row[i] = (own - fall) as f32;
        }
        for (row, entry) in room.batch.strain.iter_mut().zip(waters.strain) {
            row[i] = entry as f32;
        }
        let place = DVec3::new(x, y, waters.height_m - earth.drop_m(x, y));
        room.drawn.push(Drawn { found, place, waters });
    }

    fn waters(&self, found: &Found, nearby: &Nearby) -> Waters {
        let plan = self.split.plan;
        if plan.texture {
            return plan.waves.beside(nearby, found.place_m);
        }
        let mut rng = stream(plan.seed, rng::Room::FarWave, found.waves, 1);
        plan.waves.beside(&nearby.with_phases(|| rng.random()), found.place_m)
    }

    /// Finds what was taken, by every pair.
    pub fn finish(&self, room: &mut Room, cells: &mut Cells) {
        if room.drawn.is_empty() {
            return;
        }
        let of = self.split.of;
        cells.places.extend(room.drawn.iter().map(|cell| Point::from_raw(cell.place)));
        cells.pairs.resize_with(of.plans.len(), AsSeen::default);
        for (plan, seen) in of.plans.iter().zip(&mut cells.pairs) {
            let ends = plan.ends(of.radar.transmitters.len());
            self.pair(ends.map(|end| self.split.places[end].raw()), room, seen);
        }
        room.drawn.clear();
    }

    fn pair(&self, [tx, rx]: [DVec3; 2], room: &mut Room, seen: &mut AsSeen) {
        let (variant, plan) = (Variant::fastest(), self.split.plan);
        let Room { batch, phasors, drawn } = room;
        batch.count = drawn.len();
        batch.cover.fill(0.0);
        let ways = |cell: &Drawn| {
            let incident = (cell.place - tx).normalize_or_zero();
            [incident, (rx - cell.place).normalize_or_zero()]
        };
        let mut any_reflects = false;
        for (i, cell) in drawn.iter().enumerate() {
            let [incident, scattered] = ways(cell);
            for c in 0..3 {
                batch.incident[c][i] = incident[c] as f32;
                batch.scattered[c][i] = scattered[c] as f32;
            }
            let q = scattered - incident;
            let fall = self.split.of.frame.earth().drop_slope(cell.place.x, cell.place.y);
            let leans = q.truncate().length() - fall[0].hypot(fall[1]) * q.z.abs();
            any_reflects |= leans < STEEPEST * plan.all_slope_rms * q.z.abs();
        }
        variant.run(OnRays(batch));
        let mut points = None;
        let respond = |batch: &mut Batch, of_points: bool, of_bragg: bool| {
            for (n, (to, own)) in batch.phasor.iter_mut().zip(&*phasors).enumerate() {
                let wanted = if n == 0 { of_points } else { of_bragg };
                *to = if wanted { *own } else { [[0.0; LANES]; 2] };
            }
            batch.respond(variant, &plan.lanes, 0, None);
        };
        if plan.phases != Phases::Single && any_reflects {
            respond(batch, true, false);
            points = Some(batch.matrix);
            respond(batch, false, true);
        } else {
            respond(batch, true, true);
        }
        for (i, cell) in drawn.iter().enumerate() {
            let of_lane = |rows: &[[[Row; 2]; 2]; 2]| -> Matrix {
                rows.each_ref().map(|row| row.each_ref().map(|parts| parts.each_ref().map(|part| part[i])))
            };
            let mut matrix = of_lane(&batch.matrix);
            let (mut mechanism, mut scale) = (Mechanism::Bragg, 1.0);
            if let Some(points) = &points {
                let points = of_lane(points);
                let power = |m: &Matrix| {
                    let of = |entry: [f32; 2]| f64::from(entry[0]).powi(2) + f64::from(entry[1]).powi(2);
                    of(m[0][0]) + of(m[1][1])
                };
                let share = power(&points) / (power(&points) + power(&matrix)).max(f64::MIN_POSITIVE);
                let taken = if cell.found.mechanism < share {
                    (matrix, mechanism) = (points, Mechanism::Specular);
                    share
                } else {
                    1.0 - share
                };
                scale = taken.max(f64::MIN_POSITIVE).sqrt().recip();
            }
            let ways = ways(cell);
            let [sx, sy] = [0, 1].map(|axis| f64::from(batch.slope[axis][i]));
            let turned = batch.cosine[0][i] > 0.0 && batch.cosine[1][i] > 0.0;
            let area_m2 = cell.found.area_m2 * (1.0 + sx * sx + sy * sy).sqrt();
            scale *= if turned { area_m2.sqrt() * self.seen_share(cell, [-ways[0], ways[1]]) } else { 0.0 };
            let scaled = |part: f32| {
                let scaled = (f64::from(part) * scale) as f32;
                if scaled.is_finite() { scaled } else { 0.0 }
            };
            seen.matrices.push(matrix.map(|row| row.map(|entry| entry.map(scaled))));
            seen.velocities_mps.push(self.velocity(cell, mechanism, ways).to_array().map(|c| c as f32));
        }
    }

    /// Root of the share of such cells at this height that antennas in these directions see, and the field
    /// of the ray that the sea reflects, where that interferes.
    fn seen_share(&self, cell: &Drawn, ends: [DVec3; 2]) -> f64 {
        let plan = self.split.plan;
        if !plan.shadowed {
            return 1.0;
        }
        let up = self.split.of.frame.earth().up(Point::from_raw(cell.place)).raw();
        let level = ends.map(|end| (end - up * end.dot(up)).truncate());
        let sines = ends.map(|end| end.dot(up));
        let lambdas = [0, 1].map(|n| {
            let tangent = sines[n] / (1.0 - sines[n] * sines[n]).max(f64::MIN_POSITIVE).sqrt();
            smith::lambda(tangent, plan.waves.slope_rms(level[n].to_array()))
        });
        let towards = level.map(DVec2::normalize_or_zero);
        let fields = plan.two_rays.map_or(1.0, |two_rays| {
            let of = |n: usize| {
                let slope = -(cell.waters.slope[0] * towards[n].x + cell.waters.slope[1] * towards[n].y);
                two_rays.field(cell.waters.height_m, sines[n], slope)
            };
            of(0) * of(1)
        });
        let height = cell.waters.height_m / plan.waves.height_rms_m().max(f64::MIN_POSITIVE);
        smith::seen(lambdas, towards[0].dot(towards[1]), height).sqrt() * fields
    }

    /// With the water, and along the bisector: `q.v` is the frequency drawn within the lines of a mechanism.
    fn velocity(&self, cell: &Drawn, mechanism: Mechanism, [incident, scattered]: [DVec3; 2]) -> DVec3 {
        let (plan, scattering) = (self.split.plan, &self.sea.scattering);
        let omega_radps = scattering.travelling().map_or(plan.forgets_radps * cell.found.off, |lines| {
            let [one, other] = lines.lines(mechanism, incident, scattered);
            let powers = [one, other].map(|line| line.amplitude * line.amplitude);
            let first = cell.found.line * (powers[0] + powers[1]) < powers[0];
            let line = if first { one } else { other };
            line.centre_radps + line.deviation_radps * cell.found.off
        });
        let q = scattered - incident;
        let k_radpm = scattering.wavenumber_radpm();
        let own = q * (omega_radps / (k_radpm * q.length_squared().max(f64::MIN_POSITIVE)));
        let mut water = DVec3::from_array(cell.waters.velocity_mps);
        if !self.sea.displacement {
            (water.x, water.y) = (0.0, 0.0);
        }
        (water + own).clamp_length_max(FASTEST_MPS)
    }
}
