//! Gains of both antennas towards facets side by side.

use glam::DVec3;

use crate::cpu::{Task, Variant};
use crate::frames::Vector;
use crate::geometry::lanes::{End, LANES, Row, WideRow};
use crate::radar::antenna::{Antenna, Axes};
use crate::units::SPEED_OF_LIGHT_MPS;

/// An antenna at an instant.
#[derive(Clone, Copy)]
pub(super) struct Sighted<'a> {
    pub antenna: &'a Antenna,
    pub end: End,
    /// Axes at the emission, and their change in a second.
    pub axes: Axes,
    pub change_per_s: Axes,
}

/// How a pattern is evaluated.
#[derive(Clone, Copy)]
enum Shape {
    Constant(f32),
    /// Peak, and both sides in wavelengths.
    Rectangle { peak: f32, sides: [f32; 2] },
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
            Antenna::Ellipse { .. } | Antenna::Grid(_) => Self::Other,
        }
    }
}

/// Whether the field gain of an antenna is a real number everywhere, so that it can be kept apart from the amplitude.
pub(super) fn is_real(antenna: &Antenna) -> bool {
    !matches!(antenna, Antenna::Grid(_))
}

/// Product of the real field gains of both antennas towards places that move by `velocity dt_s` from where they are given.
pub(super) struct Gains<'a> {
    pub ends: [Sighted<'a>; 2],
    pub position_m: &'a [WideRow; 3],
    pub velocity_mps: &'a [Row; 3],
    pub dt_s: f64,
    pub out: &'a mut Row,
}

impl Gains<'_> {
    pub fn find(self, variant: Variant) {
        self.out.fill(1.0);
        let shapes = self.ends.map(|end| Shape::of(end.antenna));
        let mut direction = [[[0.0f32; LANES]; 3]; 2];
        let mut delay = [0.0f32; LANES];
        variant.run(Directions { of: &self, direction: &mut direction, delay: &mut delay });
        for ((shape, direction), end) in shapes.into_iter().zip(&direction).zip(self.ends) {
            if is_real(end.antenna) {
                match shape {
                    Shape::Constant(gain) => self.out.iter_mut().for_each(|g| *g *= gain),
                    Shape::Rectangle { peak, sides } => {
                        variant.run(Rectangle { peak, sides, direction, out: self.out });
                    }
                    Shape::Other => {
                        for (i, gain) in self.out.iter_mut().enumerate() {
                            let d = DVec3::from_array([0, 1, 2].map(|c| f64::from(direction[c][i])));
                            *gain *= end.antenna.field_gain(Vector::from_raw(d)).re as f32;
                        }
                    }
                }
            }
        }
    }
}

/// Directions of places in the frames of both antennas.
struct Directions<'a, 'b> {
    of: &'a Gains<'b>,
    direction: &'a mut [[Row; 3]; 2],
    delay: &'a mut Row,
}

impl Task for Directions<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { of, direction, delay } = self;
        let [tx, rx] = &of.ends;
        let inverse_c = (1.0 / SPEED_OF_LIGHT_MPS) as f32;
        let dt_s = of.dt_s;
        let (x_t, x_r) = (tx.end.position_m, rx.end.position_m);
        let v_r = rx.end.velocity_mps.map(|v| v as f32);
        let rows = |axes: Axes| [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| a.to_array().map(|c| c as f32));
        let (tx_axes, rx_axes, rx_change) = (rows(tx.axes), rows(rx.axes), rows(rx.change_per_s));
        let [out, back] = direction;
        for i in 0..LANES {
            let p = [0, 1, 2].map(|c| of.position_m[c][i] + f64::from(of.velocity_mps[c][i]) * dt_s);
            let d = [0, 1, 2].map(|c| (p[c] - x_t[c]) as f32);
            let e = [0, 1, 2].map(|c| (p[c] - x_r[c]) as f32);
            let out_m = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            let back_m = (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]).sqrt();
            let after_s = (out_m + back_m) * inverse_c;
            // From where the receiver is when the echo arrives.
            let e = [0, 1, 2].map(|c| e[c] - v_r[c] * after_s);
            let back_m = (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]).sqrt();
            delay[i] = after_s;
            let (inverse_out, inverse_back) = (1.0 / out_m.max(1e-9), 1.0 / back_m.max(1e-9));
            for axis in 0..3 {
                let a = tx_axes[axis];
                out[axis][i] = (d[0] * a[0] + d[1] * a[1] + d[2] * a[2]) * inverse_out;
                let a = [0, 1, 2].map(|c| rx_axes[axis][c] + rx_change[axis][c] * after_s);
                back[axis][i] = (e[0] * a[0] + e[1] * a[1] + e[2] * a[2]) * inverse_back;
            }
        }
    }
}

/// Pattern of a uniformly lit rectangle.
struct Rectangle<'a> {
    peak: f32,
    sides: [f32; 2],
    direction: &'a [Row; 3],
    out: &'a mut Row,
}

impl Task for Rectangle<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { peak, sides, direction, out } = self;
        for i in 0..LANES {
            let gain = peak * sinc(sides[0] * direction[1][i]) * sinc(sides[1] * direction[2][i]);
            out[i] *= if direction[0][i] > 0.0 { gain } else { 0.0 };
        }
    }
}

/// `sin(pi t) / (pi t)`.
#[inline(always)]
fn sinc(t: f32) -> f32 {
    const TO_INTEGER: f32 = 12_582_912.0;
    let shifted = t + TO_INTEGER;
    let r = t - (shifted - TO_INTEGER);
    let odd = f32::from_bits((shifted.to_bits() & 1) << 31);
    let z = r * r;
    // sin(pi r) / r, minimax for |r| <= 1/2.
    let series = 3.141_592_5 + z * (-5.167_703_7 + z * (2.549_985 + z * (-0.597_798 + z * 0.076_780_86)));
    let sine = f32::from_bits((r * series).to_bits() ^ odd.to_bits());
    if t.abs() < 1e-6 { 1.0 } else { sine / (std::f32::consts::PI * t) }
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
