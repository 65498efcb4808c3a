//! Panels and double bounces of a ship side by side, for blocks of pulses.
//!
//! The equations are those of [`Body::path`](super::body::Body::path), in f64, without branches. Instead of
//! the bases of the scattering matrix it has the fields of the antennas' ports themselves: both components of
//! a transversal field in any basis make up the field, so what a port of unit vector `e_a` receives of
//! another of `e_b` is
//!
//! `S_ab = -j k/sqrt(pi) I e_a.J(e_b)` , `J(e) = r (n.e) - e (n.r)` ,
//!
//! with `r` the direction and `e` the field that meet the last plane: of a double bounce those that the first
//! one reflects. Light time is found by Newton's steps, as [`geometry::lanes`](crate::geometry::lanes) has
//! it.
//!
//! Limits: as those of the scatterer paths, which the reference takes; phases up to some million radians.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use std::f64::consts::PI;

use glam::DVec3;

use super::body::{Body, Element};
use super::pose::Pose;
use crate::cpu::{Task, Variant};
use crate::frames::{Enu, Point};
use crate::geometry::lanes::{End, cross, dot, length, minus, plus, scaled};
use crate::radar::polarisation::{Axes, PortBasis};
use crate::scattering::physical_optics::{facing, simplex_of, sine_cosine};
use crate::scene::radar::PolarisationBasis;
use crate::units::SPEED_OF_LIGHT_MPS as C;

/// Paths side by side: as many as stay in the nearest cache.
pub(in crate::paths) const WIDTH: usize = 32;
/// Lanes that are looped over at least together.
const GROUP: usize = 8;
/// Lengths that are divided by are not below this, m.
const LEAST_M: f64 = 1e-9;
/// Cosine between a reflected ray and the plane that it meets below which nothing is left of it.
const LEAST_DOWN: f64 = 1e-4;
/// Square of the sum of a direction and the boresight below which it is straight back, and sine of the angle
/// to the vertical below which it is vertical ([`PortBasis`], [`Basis`](crate::geometry::bistatic::Basis)).
const BACKWARD: f64 = 1e-24;
const VERTICAL_SINE: f64 = 1e-12;

/// One quantity of all.
pub(in crate::paths) type Lanes = [f64; WIDTH];

#[inline(always)]
fn at(rows: &[Lanes; 3], i: usize) -> [f64; 3] {
    [rows[0][i], rows[1][i], rows[2][i]]
}

#[inline(always)]
fn put(rows: &mut [Lanes; 3], i: usize, value: [f64; 3]) {
    rows[0][i] = value[0];
    rows[1][i] = value[1];
    rows[2][i] = value[2];
}

/// Paths of a ship side by side, over one pair of antennas; those in use come first.
#[derive(Clone)]
pub(in crate::paths) struct Batch {
    pub count: usize,
    /// Whether any of them is a double bounce.
    mirrors: bool,
    /// In the ship's axes: where the path ends and where it goes on from, normals of the first and the last
    /// plane, two corners of the panel from its centroid.
    image_m: [Lanes; 3],
    point_m: [Lanes; 3],
    normals: [[Lanes; 3]; 2],
    corners_m: [[Lanes; 3]; 2],
    /// From the point to the centroid of the panel, and the height of the last plane over it, m.
    off_m: [Lanes; 3],
    gap_m: Lanes,
    area_m2: Lanes,
    /// 1 of double bounces.
    mirror: Lanes,
    pub delay_s: Lanes,
    pub delay_rate: Lanes,
    pub leg_m: [Lanes; 2],
    /// Unit directions at the scatterer.
    pub incident: [Lanes; 3],
    pub scattered: [Lanes; 3],
    /// Unit vectors of the ports H and V of the transmitter and of the receiver.
    ports: [[[Lanes; 3]; 2]; 2],
    /// Real and imaginary part of what a port of the receiver has of one of the transmitter, over `coupled`,
    /// m.
    pub strength: [Lanes; 2],
    /// `[port of the receiver][port of the transmitter]`.
    pub coupled: [[Lanes; 2]; 2],
}

/// A ship and a pair of antennas at an emission.
#[derive(Clone, Copy)]
pub(in crate::paths) struct Instant {
    pub transmitter: End,
    pub receiver: End,
    /// Polarisation bases of both at the emission, and how that of the receiver changes in a second.
    pub bases: [PortBasis; 2],
    pub change_per_s: Axes,
    pub wave_number_rad_m: f64,
}

/// [`Pose`] in arrays.
#[derive(Clone, Copy)]
struct Held {
    origin_m: [f64; 3],
    axes: [[f64; 3]; 3],
    velocity_mps: [f64; 3],
    turning_radps: [f64; 3],
}

impl From<&Pose> for Held {
    fn from(pose: &Pose) -> Self {
        Self {
            origin_m: pose.origin_m.to_array(),
            axes: pose.axes.to_cols_array_2d(),
            velocity_mps: pose.velocity_mps.to_array(),
            turning_radps: pose.turning_radps.to_array(),
        }
    }
}

impl Held {
    #[inline(always)]
    fn in_scene(&self, v: [f64; 3]) -> [f64; 3] {
        plus(plus(scaled(self.axes[0], v[0]), self.axes[1], v[1]), self.axes[2], v[2])
    }

    #[inline(always)]
    fn in_ship(&self, v: [f64; 3]) -> [f64; 3] {
        [dot(self.axes[0], v), dot(self.axes[1], v), dot(self.axes[2], v)]
    }

    /// Where a point of the ship is, and how fast.
    #[inline(always)]
    fn moving(&self, at_m: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let arm = self.in_scene(at_m);
        (plus(self.origin_m, arm, 1.0), plus(self.velocity_mps, cross(self.turning_radps, arm), 1.0))
    }
}

impl Batch {
    /// Empty, on the heap.
    pub fn boxed() -> Box<Self> {
        let (row, vector) = ([0.0; WIDTH], [[0.0; WIDTH]; 3]);
        Box::new(Self {
            count: 0,
            mirrors: false,
            image_m: vector,
            point_m: vector,
            normals: [vector; 2],
            corners_m: [vector; 2],
            off_m: vector,
            gap_m: row,
            area_m2: row,
            mirror: row,
            delay_s: row,
            delay_rate: row,
            leg_m: [row; 2],
            incident: vector,
            scattered: vector,
            ports: [[vector; 2]; 2],
            strength: [row; 2],
            coupled: [[row; 2]; 2],
        })
    }

    /// Takes in elements of a ship, as many as there is room for, and says how many: lanes that fill up the
    /// last group have the last of them.
    pub(super) fn take(&mut self, body: &Body, elements: impl Iterator<Item = Element>) -> usize {
        (self.count, self.mirrors) = (0, false);
        let mut last = None;
        for element in elements.take(WIDTH) {
            self.set(self.count, body, &element);
            self.count += 1;
            last = Some(element);
        }
        for i in self.count..self.lanes() {
            last.iter().for_each(|element| self.set(i, body, element));
        }
        self.count
    }

    fn set(&mut self, i: usize, body: &Body, element: &Element) {
        let (panel, last, at_m, image_m) = body.parts(element);
        let centroid_m = panel.centroid_m();
        let [a, b, _] = panel.corners_m();
        let rows =
            [(&mut self.image_m, image_m), (&mut self.point_m, at_m), (&mut self.off_m, centroid_m - at_m)];
        let [first, second] = &mut self.normals;
        let [from_a, from_b] = &mut self.corners_m;
        let more = [
            (first, panel.normal()),
            (second, last.normal()),
            (from_a, a - centroid_m),
            (from_b, b - centroid_m),
        ];
        for (rows, value) in rows.into_iter().chain(more) {
            put(rows, i, value.to_array());
        }
        self.gap_m[i] = (last.centroid_m() - centroid_m).dot(last.normal());
        self.area_m2[i] = panel.area_m2();
        self.mirror[i] = if element.is_double() { 1.0 } else { 0.0 };
        self.mirrors |= element.is_double();
    }

    /// Delays and directions of all.
    pub fn solve(&mut self, variant: Variant, pose: &Pose, of: &Instant) {
        variant.run(Solve { ship: Held::from(pose), of, batch: self });
    }

    /// What they return, once they are solved.
    pub fn scatter(&mut self, variant: Variant, pose: &Pose, of: &Instant) {
        let bases = of.bases;
        for (end, basis) in bases.iter().enumerate() {
            let batch = &mut *self;
            match basis.kind {
                PolarisationBasis::LocalHorizontal => variant.run(Ports::<true> { end, of, batch }),
                PolarisationBasis::Ludwig3 => variant.run(Ports::<false> { end, of, batch }),
            }
        }
        let (ship, wave_number_rad_m) = (Held::from(pose), of.wave_number_rad_m);
        if self.mirrors {
            variant.run(Scatter::<true> { ship, wave_number_rad_m, batch: self });
        } else {
            variant.run(Scatter::<false> { ship, wave_number_rad_m, batch: self });
        }
    }

    /// Unit directions at the scatterer, inward and outward.
    pub fn directions(&self, i: usize) -> [DVec3; 2] {
        [at(&self.incident, i).into(), at(&self.scattered, i).into()]
    }

    /// Where the wave meets the ship and where it leaves it.
    pub fn meets(&self, pose: &Pose, i: usize) -> [Point<Enu>; 2] {
        let (point, off) = (DVec3::from(at(&self.point_m, i)), DVec3::from(at(&self.off_m, i)));
        [point + off, point].map(|at_m| Point::from_raw(pose.origin_m + pose.axes * at_m))
    }

    #[inline(always)]
    fn lanes(&self) -> usize {
        self.count.next_multiple_of(GROUP).min(WIDTH)
    }
}

/// Light time.
struct Solve<'a> {
    ship: Held,
    of: &'a Instant,
    batch: &'a mut Batch,
}

impl Task for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { ship, of, batch } = self;
        let (x_t, v_t) = (of.transmitter.position_m, of.transmitter.velocity_mps);
        let End { position_m: x_r, velocity_mps: v_r, acceleration_mps2: a_r } = of.receiver;
        for i in 0..batch.lanes() {
            let (image, v_i) = ship.moving(at(&batch.image_m, i));
            let (point, v_s) = ship.moving(at(&batch.point_m, i));
            let d = minus(image, x_t);
            let far = length(d);
            let s = far / (C - dot(d, v_i) / far.max(LEAST_M));
            let d = minus(plus(image, v_i, s), x_t);
            let out_m = length(d);
            let incident = scaled(d, 1.0 / out_m.max(LEAST_M));
            let tx_leg_s = out_m / C;
            let in_flight = plus(point, v_s, tx_leg_s);

            let v_then = plus(v_r, a_r, tx_leg_s);
            let x_then = plus(plus(x_r, v_r, tx_leg_s), a_r, 0.5 * tx_leg_s * tx_leg_s);
            let e = minus(x_then, in_flight);
            let far = length(e);
            let s = far / (C - dot(e, v_then) / far.max(LEAST_M));
            let x_later = plus(plus(x_then, v_then, s), a_r, 0.5 * s * s);
            let v_later = plus(v_then, a_r, s);
            let e = minus(x_later, in_flight);
            let back_m = length(e);
            let scattered = scaled(e, 1.0 / back_m.max(LEAST_M));
            let away = dot(scattered, v_later);
            let rx_leg_s = s + (back_m - C * s) / (C - away);

            let tx_rate = dot(incident, minus(v_i, v_t)) / (C - dot(incident, v_i));
            let rx_rate = (1.0 + tx_rate) * dot(scattered, minus(v_later, v_s)) / (C - away);
            batch.delay_s[i] = tx_leg_s + rx_leg_s;
            batch.delay_rate[i] = tx_rate + rx_rate;
            batch.leg_m[0][i] = out_m;
            batch.leg_m[1][i] = back_m;
            put(&mut batch.incident, i, incident);
            put(&mut batch.scattered, i, scattered);
        }
    }
}

/// Unit vectors of the ports of an antenna, whose basis is level or by Ludwig's third definition.
struct Ports<'a, const LEVEL: bool> {
    end: usize,
    of: &'a Instant,
    batch: &'a mut Batch,
}

impl<const LEVEL: bool> Task for Ports<'_, LEVEL> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { end, of, batch } = self;
        let now = of.bases[end].axes.to_cols_array_2d();
        // The transmitter sends at once.
        let share = if end == 0 { 0.0 } else { 1.0 };
        let change = of.change_per_s.to_cols_array_2d();
        for i in 0..batch.lanes() {
            let after_s = share * batch.delay_s[i];
            let x = plus(now[0], change[0], after_s);
            let y = plus(now[1], change[1], after_s);
            let z = plus(now[2], change[2], after_s);
            let d = if end == 0 { at(&batch.incident, i) } else { scaled(at(&batch.scattered, i), -1.0) };
            let (h, v) = if LEVEL {
                let level = cross(z, d);
                let sine = length(level);
                let upright = sine < VERTICAL_SINE;
                let north = [-d[0] * d[1], 1.0 - d[1] * d[1], -d[2] * d[1]];
                let h = [
                    if upright { north[0] } else { level[0] },
                    if upright { north[1] } else { level[1] },
                    if upright { north[2] } else { level[2] },
                ];
                let h = scaled(h, 1.0 / length(h).max(LEAST_M));
                (h, cross(d, h))
            } else {
                let s = plus(x, d, 1.0);
                let back = dot(s, s) <= BACKWARD;
                let s = [
                    if back { z[0] } else { s[0] },
                    if back { z[1] } else { s[1] },
                    if back { z[2] } else { s[2] },
                ];
                let scale = 2.0 / dot(s, s);
                (plus(y, s, -scale * dot(y, s)), plus(z, s, -scale * dot(z, s)))
            };
            put(&mut batch.ports[end][0], i, h);
            put(&mut batch.ports[end][1], i, v);
        }
    }
}

/// Physical optics; `MIRRORS`: some are double bounces.
struct Scatter<'a, const MIRRORS: bool> {
    ship: Held,
    wave_number_rad_m: f64,
    batch: &'a mut Batch,
}

impl<const MIRRORS: bool> Task for Scatter<'_, MIRRORS> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { ship, wave_number_rad_m, batch } = self;
        let factor = -wave_number_rad_m / PI.sqrt();
        for i in 0..batch.lanes() {
            let mirror = if MIRRORS { batch.mirror[i] } else { 0.0 };
            let (incident, scattered) = (at(&batch.incident, i), at(&batch.scattered, i));
            let (first, last) = (at(&batch.normals[0], i), at(&batch.normals[1], i));
            let (first_in_scene, last_in_scene) = (ship.in_scene(first), ship.in_scene(last));
            let along = dot(incident, first_in_scene);
            let on = plus(incident, first_in_scene, -2.0 * mirror * along);
            let down = dot(on, last_in_scene);
            let again = if MIRRORS && mirror > 0.0 { facing(-down) } else { 1.0 };
            let fades = facing(-along) * facing(dot(scattered, last_in_scene)) * again;
            // Where it is nothing nothing is left.
            let by = if down <= -LEAST_DOWN { 1.0 / down } else { 0.0 };

            let w = ship.in_ship(scaled(minus(scattered, on), wave_number_rad_m));
            let (mut a, mut b) = (dot(w, at(&batch.corners_m[0], i)), dot(w, at(&batch.corners_m[1], i)));
            let mut area_m2 = if down <= -LEAST_DOWN { batch.area_m2[i] } else { 0.0 };
            let (mut sine, mut cosine) = (0.0, 1.0);
            if MIRRORS {
                // The outline is carried along the reflected ray to the last plane.
                let slide = dot(w, ship.in_ship(on)) * by * mirror;
                a -= slide * dot(at(&batch.corners_m[0], i), last);
                b -= slide * dot(at(&batch.corners_m[1], i), last);
                area_m2 = if mirror > 0.0 { area_m2 * along * by } else { area_m2 };
                (sine, cosine) = sine_cosine(dot(w, at(&batch.off_m, i)) + slide * batch.gap_m[i]);
            }
            let [re, im] = simplex_of([a, b, -(a + b)]);
            let scale = 2.0 * factor * area_m2 * fades;
            // Times j.
            batch.strength[0][i] = -scale * (re * sine + im * cosine);
            batch.strength[1][i] = scale * (re * cosine - im * sine);

            for of_t in 0..2 {
                let field = at(&batch.ports[0][of_t], i);
                let reflected = plus(field, first_in_scene, -2.0 * mirror * dot(first_in_scene, field));
                let field = scaled(reflected, 1.0 - 2.0 * mirror);
                let current = plus(scaled(on, dot(last_in_scene, field)), field, -down);
                batch.coupled[0][of_t][i] = dot(at(&batch.ports[1][0], i), current);
                batch.coupled[1][of_t][i] = dot(at(&batch.ports[1][1], i), current);
            }
        }
    }
}
