//! Gains, main lobes and horizons towards cells side by side, in f32: what multiplies their amplitudes from
//! pulse to pulse.
//!
//! Places count from the antenna in the middle of a stretch: 20 km away they are rounded to a millimetre,
//! directions to 1e-7.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use glam::DVec3;

use crate::cpu::{Task, Variant};
use crate::frames::{Enu, Point};
use crate::geometry::horizon;
use crate::geometry::lanes::{LANES, Row, WideRow, lanes_for};
use crate::paths::block::Sight;
use crate::paths::emission::Emission;
use crate::paths::{PairPlan, PathGenerator};
use crate::radar::lobe::MainLobe;
use crate::radar::polarisation::Axes;

/// An antenna at a pulse, from where it is in the middle of a stretch.
#[derive(Clone, Copy)]
pub(super) struct Outlook {
    antenna: usize,
    at: [f32; 3],
    /// What it moves and turns in a second; a transmitter stays as it is at the emission.
    moves_mps: [f32; 3],
    axes: [[f32; 3]; 3],
    change_per_s: [[f32; 3]; 3],
    sight: Sight,
}

fn rows(axes: Axes) -> [[f32; 3]; 3] {
    [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.to_array().map(|c| c as f32))
}

impl Outlook {
    /// Of the antennas of a pair at an emission, and at that in the middle of a stretch.
    pub fn of_pair(of: &PathGenerator, plan: &PairPlan, emission: &Emission, middle: &Emission) -> [Self; 2] {
        let ends = plan.ends(of.radar.transmitters.len());
        [(ends[0], false), (ends[1], true)].map(|(antenna, receives)| {
            Self::of(of, emission, antenna, receives, middle.centres[antenna].position.raw())
        })
    }

    /// Of an antenna; `receives` if echoes come later.
    fn of(of: &PathGenerator, emission: &Emission, antenna: usize, receives: bool, from: DVec3) -> Self {
        let centre = &emission.centres[antenna];
        let (axes, change) = of.axes_of(emission, antenna);
        let round = |v: DVec3| v.to_array().map(|c| c as f32);
        Self {
            antenna,
            at: round(centre.position.raw() - from),
            moves_mps: if receives { round(centre.velocity.raw()) } else { [0.0; 3] },
            axes: rows(axes),
            change_per_s: if receives { rows(change) } else { [[0.0; 3]; 3] },
            sight: Sight::of(&of.antennas[antenna], centre.position.raw(), axes),
        }
    }

    /// Largest angle that it turns in a time, nearly, rad.
    pub fn turned_rad(&self, for_s: f64) -> f64 {
        let fastest = self.change_per_s.as_flattened().iter().fold(0.0, |most: f32, c| most.max(c.abs()));
        2.0 * f64::from(fastest) * for_s
    }

    /// Multiplies by the field gains of cells in its main lobe, and by 0 elsewhere.
    pub fn weigh(&self, of: &PathGenerator, lobe: &MainLobe, cells: Towards<'_>, out: &mut Row) {
        let variant = Variant::fastest();
        let mut direction = [[0.0; LANES]; 3];
        let count = cells.count;
        variant.run(Directions { of: self, cells, direction: &mut direction, length_m: &mut [0.0; LANES] });
        self.sight.weigh(&of.antennas[self.antenna], variant, count, &direction, out);
        lobe.keep(variant, count, &direction, 0.0, out);
    }

    /// Multiplies by 0 where the main lobe is farther away than an angle, and finds lengths of ways, m.
    pub fn keep(
        &self,
        lobe: &MainLobe,
        (count, places): (usize, &[Row; 3]),
        slack_rad: impl FnOnce(&Row) -> f64,
        length_m: &mut Row,
        out: &mut Row,
    ) {
        let variant = Variant::fastest();
        let mut direction = [[0.0; LANES]; 3];
        let cells = Towards { count, places, moves: None, delay_s: None };
        variant.run(Directions { of: self, cells, direction: &mut direction, length_m });
        lobe.keep(variant, count, &direction, slack_rad(length_m), out);
    }
}

/// Cells that are looked at.
#[derive(Clone, Copy)]
pub(super) struct Towards<'a> {
    pub count: usize,
    /// From where the antenna is in the middle of the stretch, m.
    pub places: &'a [Row; 3],
    /// Velocities, m/s, and for how long they move, s.
    pub moves: Option<(&'a [Row; 3], f32)>,
    /// When their echoes arrive, for a receiver.
    pub delay_s: Option<&'a Row>,
}

/// Unit directions in the frame of an antenna.
struct Directions<'a> {
    of: &'a Outlook,
    cells: Towards<'a>,
    direction: &'a mut [Row; 3],
    length_m: &'a mut Row,
}

impl Task for Directions<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { of, cells: Towards { count, places, moves, delay_s }, direction, length_m } = self;
        const STILL: Row = [0.0; LANES];
        let (velocities, for_s) = moves.unwrap_or((&[STILL; 3], 0.0));
        let delay_s = delay_s.unwrap_or(&STILL);
        let (at, leaves, axes, change) = (&of.at, &of.moves_mps, &of.axes, &of.change_per_s);
        for i in 0..lanes_for(count) {
            let later_s = delay_s[i];
            let x = places[0][i] + velocities[0][i] * for_s - at[0] - leaves[0] * later_s;
            let y = places[1][i] + velocities[1][i] * for_s - at[1] - leaves[1] * later_s;
            let z = places[2][i] + velocities[2][i] * for_s - at[2] - leaves[2] * later_s;
            let length = (x * x + y * y + z * z).sqrt();
            let inverse = 1.0 / length.max(1e-9);
            let (x, y, z) = (x * inverse, y * inverse, z * inverse);
            length_m[i] = length;
            for axis in 0..3 {
                let (a, b) = (&axes[axis], &change[axis]);
                let now = x * a[0] + y * a[1] + z * a[2];
                let more = x * b[0] + y * b[1] + z * b[2];
                direction[axis][i] = now + more * later_s;
            }
        }
    }
}

/// What passes over the horizon at the first and the last pulse of a stretch; linear in between.
pub(super) struct Passes([Row; 2]);

impl Passes {
    /// From two places of an antenna; `None` where all passes.
    pub fn new(
        of: &PathGenerator,
        ends: [Point<Enu>; 2],
        places: &[WideRow; 3],
        count: usize,
    ) -> Option<Self> {
        let earth = of.frame.hiding_earth();
        let mut passes = Self([[1.0; LANES]; 2]);
        let mut whole = true;
        for (row, end) in passes.0.iter_mut().zip(ends) {
            for i in 0..count {
                let place = Point::new(places[0][i], places[1][i], places[2][i]);
                let clearance_m = horizon::clearance_m(earth, end, place);
                row[i] = horizon::weight(clearance_m, horizon::POINT_EDGE_M) as f32;
                whole &= row[i] == 1.0;
            }
        }
        (!whole).then_some(passes)
    }

    /// Multiplies by what passes at a share of the time from the first to the last pulse.
    pub fn weigh(&self, share: f32, out: &mut Row) {
        let [first, last] = &self.0;
        for i in 0..LANES {
            out[i] *= first[i] + share * (last[i] - first[i]);
        }
    }
}
