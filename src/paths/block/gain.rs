//! Gains of both antennas towards facets side by side.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use glam::DVec3;

use super::instants::NODES;
use super::tile::Node;
use crate::cpu::{Task, Variant};
use crate::frames::Vector;
use crate::geometry::lanes::{GROUP, LANES, Row, group, group_mut, lanes_for};
use crate::radar::antenna::Antenna;
use crate::radar::polarisation::Axes;
use crate::radar::taper::{SideTaper, TERMS};
use crate::units::SINE_OF_HALF_TURNS;

/// An antenna at an instant.
#[derive(Clone, Copy)]
pub(super) struct Sighted<'a> {
    pub antenna: &'a Antenna,
    /// Axes at the emission, and their change in a second.
    pub axes: Axes,
    pub change_per_s: Axes,
}

/// How a pattern is evaluated.
#[derive(Clone, Copy)]
enum Shape {
    Constant(f32),
    /// Peak, and both sides in wavelengths.
    Rectangle {
        peak: f32,
        sides: [f32; 2],
    },
    /// Peak, both sides in wavelengths, and what they are tapered by.
    Tapered {
        peak: f32,
        sides: [f32; 2],
        tapers: [Taper; 2],
    },
    /// Facet by facet.
    Other,
}

impl Shape {
    fn of(antenna: &Antenna) -> Self {
        match *antenna {
            Antenna::Isotropic { gain } => Self::Constant(gain as f32),
            Antenna::Rectangle { width_m, height_m, wavelength_m } => Self::Rectangle {
                peak: ((4.0 * std::f64::consts::PI * width_m * height_m).sqrt() / wavelength_m) as f32,
                sides: [(width_m / wavelength_m) as f32, (height_m / wavelength_m) as f32],
            },
            Antenna::Tapered { peak, sides, tapers } => Self::Tapered {
                peak: peak as f32,
                sides: sides.map(|side| side as f32),
                tapers: tapers.each_ref().map(Taper::of),
            },
            Antenna::Ellipse { .. } | Antenna::Grid(_) => Self::Other,
        }
    }

    /// Multiplies by the real field gain in unit directions in the frame of the antenna.
    fn weigh(self, antenna: &Antenna, variant: Variant, count: usize, direction: &[Row; 3], out: &mut Row) {
        match self {
            Self::Constant(gain) => out.iter_mut().for_each(|g| *g *= gain),
            Self::Rectangle { peak, sides } => {
                variant.run(Rectangle { count, peak, sides, direction, out });
            }
            Self::Tapered { peak, sides, tapers } => {
                variant.run(Tapered { count, peak, sides, tapers: &tapers, direction, out });
            }
            Self::Other => {
                for (i, gain) in out.iter_mut().enumerate().take(count) {
                    let d = DVec3::from_array([0, 1, 2].map(|c| f64::from(direction[c][i])));
                    *gain *= antenna.field_gain(Vector::from_raw(d)).re as f32;
                }
            }
        }
    }
}

/// An antenna at an instant, for directions one by one.
#[derive(Clone, Copy)]
pub(in crate::paths) struct Sight {
    pub position: DVec3,
    /// From the scene to the antenna.
    turn: Axes,
    shape: Shape,
}

impl Sight {
    pub fn of(antenna: &Antenna, position: DVec3, axes: Axes) -> Self {
        Self { position, turn: axes.transpose(), shape: Shape::of(antenna) }
    }

    /// The same antenna a while later, where it turns so much in a second.
    pub fn later(&self, change_per_s: Axes, by_s: f64) -> Self {
        Self { turn: self.turn + change_per_s.transpose() * by_s, ..*self }
    }

    /// Multiplies by the real field gains in unit directions in the frame of the antenna.
    pub fn weigh(
        &self,
        antenna: &Antenna,
        variant: Variant,
        count: usize,
        direction: &[Row; 3],
        out: &mut Row,
    ) {
        self.shape.weigh(antenna, variant, count, direction, out);
    }

    /// A direction from the antenna in its frame; its longer side, wavelengths, where the pattern is one of a
    /// rectangle or has no lobes.
    pub fn lobes_towards(&self, direction: DVec3) -> Option<(DVec3, f64)> {
        let side = match self.shape {
            Shape::Constant(_) => 0.0,
            Shape::Rectangle { sides: [a, b], .. } | Shape::Tapered { sides: [a, b], .. } => a.max(b),
            Shape::Other => return None,
        };
        Some((self.turn * direction, side.into()))
    }

    /// Real field gain in a direction from the antenna, within 1e-6 of the peak.
    pub fn gain(&self, antenna: &Antenna, direction: DVec3) -> f64 {
        let d = self.turn * direction;
        match self.shape {
            Shape::Constant(gain) => gain.into(),
            Shape::Rectangle { .. } if d.x <= 0.0 => 0.0,
            Shape::Rectangle { peak, sides } => {
                (peak * sinc(sides[0] * d.y as f32) * sinc(sides[1] * d.z as f32)).into()
            }
            Shape::Tapered { .. } | Shape::Other => antenna.field_gain(Vector::from_raw(d)).re,
        }
    }
}

/// Product of the real field gains of both antennas towards facets, whose directions are interpolated between
/// nodes.
pub(super) struct Gains<'a> {
    /// Facets.
    pub count: usize,
    /// Transmitter, receiver.
    pub ends: [Sighted<'a>; 2],
    pub nodes: &'a [Node],
    /// Of the nodes.
    pub weights: &'a [f32],
    pub out: &'a mut Row,
}

impl Gains<'_> {
    pub fn find(self, variant: Variant) {
        let Self { count, ends, nodes, weights, out } = self;
        out.fill(1.0);
        for (end, sighted) in ends.iter().enumerate() {
            if !sighted.antenna.is_real() {
                continue;
            }
            let shape = Shape::of(sighted.antenna);
            let mut direction = [[0.0f32; LANES]; 3];
            if !matches!(shape, Shape::Constant(_)) {
                variant.run(Directions { count, end, sighted, nodes, weights, direction: &mut direction });
            }
            shape.weigh(sighted.antenna, variant, count, &direction, out);
        }
    }
}

/// Directions towards facets in the frame of an antenna.
struct Directions<'a> {
    count: usize,
    end: usize,
    sighted: &'a Sighted<'a>,
    nodes: &'a [Node],
    weights: &'a [f32],
    direction: &'a mut [Row; 3],
}

impl Task for Directions<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { count, end, sighted, nodes, weights, direction } = self;
        // From the receiver the facet lies against the way of the echo.
        let sign = if end == 0 { 1.0 } else { -1.0 };
        let rows =
            |axes: Axes| [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| a.to_array().map(|c| c as f32));
        let (axes, change) = (rows(sighted.axes), rows(sighted.change_per_s));
        let turns = end == 1 && change.as_flattened().iter().any(|c| *c != 0.0);
        let Some(last) = nodes.last() else { return };
        // All four nodes at once: a sum that is carried from node to node does not stay in registers.
        let nodes: [&Node; NODES] = std::array::from_fn(|n| nodes.get(n).unwrap_or(last));
        let weights: [f32; NODES] = std::array::from_fn(|n| sign * weights.get(n).copied().unwrap_or(0.0));
        let from = nodes.map(|node| if end == 0 { &node.paths.incident } else { &node.paths.scattered });
        for g in 0..lanes_for(count) / GROUP {
            let mut along = [[0.0f32; GROUP]; 3];
            for axis in 0..3 {
                let (a, b) = (group(&from[0][axis], g), group(&from[1][axis], g));
                let (c, d) = (group(&from[2][axis], g), group(&from[3][axis], g));
                for i in 0..GROUP {
                    along[axis][i] =
                        weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i] + weights[3] * d[i];
                }
            }
            let mut delay_s = [0.0f32; GROUP];
            if turns {
                for (to, from) in delay_s.iter_mut().zip(&nodes[0].paths.delay_s.as_chunks::<GROUP>().0[g]) {
                    *to = *from as f32;
                }
            }
            for axis in 0..3 {
                let (a, b) = (axes[axis], change[axis]);
                let mut out = [0.0f32; GROUP];
                for i in 0..GROUP {
                    out[i] = along[0][i] * a[0] + along[1][i] * a[1] + along[2][i] * a[2];
                }
                if turns {
                    for i in 0..GROUP {
                        let more = along[0][i] * b[0] + along[1][i] * b[1] + along[2][i] * b[2];
                        out[i] += more * delay_s[i];
                    }
                }
                *group_mut(&mut direction[axis], g) = out;
            }
        }
    }
}

/// Pattern of a uniformly illuminated rectangle.
struct Rectangle<'a> {
    count: usize,
    peak: f32,
    sides: [f32; 2],
    direction: &'a [Row; 3],
    out: &'a mut Row,
}

impl Task for Rectangle<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { count, peak, sides, direction, out } = self;
        let n = lanes_for(count);
        for i in 0..n {
            let gain = peak * sinc(sides[0] * direction[1][i]) * sinc(sides[1] * direction[2][i]);
            out[i] *= if direction[0][i] > 0.0 { gain } else { 0.0 };
        }
    }
}

/// A taper along a side in f32: [`SideTaper`].
#[derive(Clone, Copy)]
struct Taper {
    /// `2 F_m (-1)^m`, and how many.
    terms: [f32; TERMS],
    count: usize,
    is_cosine: bool,
}

impl Taper {
    fn of(taper: &SideTaper) -> Self {
        let terms = taper.terms().map_or([0.0; TERMS], |terms| terms.map(|term| term as f32));
        let count = terms.iter().take_while(|term| **term != 0.0).count();
        Self { terms, count, is_cosine: taper.terms().is_none() }
    }

    /// Multiplies by what is left of the field at `t`, a group of facets side by side.
    #[inline(always)]
    fn weigh(&self, t: &[f32; GROUP], out: &mut [f32; GROUP]) {
        if self.is_cosine {
            for i in 0..GROUP {
                let t = t[i].abs();
                out[i] *= std::f32::consts::FRAC_PI_2 * sinc(0.5 - t) / (1.0 + 2.0 * t);
            }
            return;
        }
        let (mut sine, mut sum) = ([0.0; GROUP], [0.0; GROUP]);
        for i in 0..GROUP {
            sine[i] = sine_of_half_turns(t[i].abs());
            sum[i] = over(sine[i], t[i].abs());
        }
        for m in 0..self.count {
            let (own, term) = ((m + 1) as f32, self.terms[m]);
            // At t = m the sine is that of t - m with the sign of (-1)^m.
            let sign = if m % 2 == 0 { -1.0 } else { 1.0 };
            for i in 0..GROUP {
                let t = t[i].abs();
                sum[i] += term * sign * t / (t + own) * over(sign * sine[i], t - own);
            }
        }
        for i in 0..GROUP {
            out[i] *= sum[i];
        }
    }
}

/// Pattern of a tapered rectangle.
struct Tapered<'a> {
    count: usize,
    peak: f32,
    sides: [f32; 2],
    tapers: &'a [Taper; 2],
    direction: &'a [Row; 3],
    out: &'a mut Row,
}

impl Task for Tapered<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { count, peak, sides, tapers, direction, out } = self;
        for g in 0..lanes_for(count) / GROUP {
            let (ahead, mut gain) = (group(&direction[0], g), [peak; GROUP]);
            for (axis, taper) in tapers.iter().enumerate() {
                let d = group(&direction[axis + 1], g);
                let mut t = [0.0; GROUP];
                for i in 0..GROUP {
                    t[i] = sides[axis] * d[i];
                }
                taper.weigh(&t, &mut gain);
            }
            let out = group_mut(out, g);
            for i in 0..GROUP {
                out[i] *= if ahead[i] > 0.0 { gain[i] } else { 0.0 };
            }
        }
    }
}

/// `sin(pi t)`.
#[inline(always)]
fn sine_of_half_turns(t: f32) -> f32 {
    const TO_INTEGER: f32 = 12_582_912.0;
    let shifted = t + TO_INTEGER;
    let r = t - (shifted - TO_INTEGER);
    let odd = f32::from_bits((shifted.to_bits() & 1) << 31);
    let z = r * r;
    let c = SINE_OF_HALF_TURNS;
    let series = c[0] + z * (c[1] + z * (c[2] + z * (c[3] + z * c[4])));
    f32::from_bits((r * series).to_bits() ^ odd.to_bits())
}

/// `sine / (pi t)`, 1 at its zero.
#[inline(always)]
fn over(sine: f32, t: f32) -> f32 {
    if t.abs() < 1e-6 { 1.0 } else { sine / (std::f32::consts::PI * t) }
}

/// `sin(pi t) / (pi t)`.
#[inline(always)]
fn sinc(t: f32) -> f32 {
    over(sine_of_half_turns(t), t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sincs() {
        for i in -40_000..=40_000 {
            let t = i as f32 / 300.7;
            let x = std::f64::consts::PI * f64::from(t);
            let exact = if x == 0.0 { 1.0 } else { x.sin() / x };
            // Ten roundings of 2^-24, relative to the envelope.
            let slack = 10.0 * 2f64.powi(-24) / x.abs().max(1.0);
            assert!((f64::from(sinc(t)) - exact).abs() < slack, "{t}");
        }
    }
}
