//! Fields of the ports of an antenna across a ray.
//!
//! Towards a unit direction `d` from the phase centre an antenna has two real unit vectors, `e_H` and `e_V`,
//! orthogonal to each other and to `d`, with `d x e_H = e_V`. On the boresight of a level antenna they are
//! its axes y (left) and z (up).
//!
//! * **Local-horizontal** (isotropic antennas): `e_H = u x d / |u x d|` with the vertical `u` at the phase
//!   centre ([`crate::frames::Earth::up`]), `e_V = d x e_H`. Neither pointing nor the roll of the platform
//!   counts. Straight up and straight down `e_H` has no limit: it turns once about the vertical with the
//!   azimuth. Exactly there it is North made normal to `d`.
//! * **Ludwig's third definition** (apertures and measured patterns; A. C. Ludwig, IEEE Trans. AP-21, 1973,
//!   p. 116), with theta from the boresight and phi from y about it: `e_H = cos phi  theta^ - sin phi  phi^`,
//!   `e_V = sin phi  theta^ + cos phi  phi^`. It is computed without angles: both are the axes mirrored in
//!   the plane normal to `s = x_a + d`, `e = a - 2 (a.s) s / s^2` for `a = y_a, z_a`, which is
//!   `y_a - (d.y_a) / (1 + d.x_a) (x_a + d)`. Straight back (`s = 0`), its one singular direction, H and V
//!   turn twice with phi; there `s` is taken along `z_a`, the limit in the vertical plane: `y_a` and `-z_a`.
//!   Apertures are dark there.
//!
//! **Ports.** H has the field `e_H`, V `e_V`, R `(e_H - j e_V)/sqrt 2`, L `(e_H + j e_V)/sqrt 2`. A port that
//! leaks has `e_a + eps e_x` for `e_a`, with `e_x` the other port of the pair and `eps = 10^(-isolation/20)`,
//! real; the sum is scaled to unit length, since the port's power is the power that leaves, leak included (20
//! dB of isolation cost the wanted polarisation 0.043 dB).
//!
//! Fields are given in components `(v, h)` of the propagation direction
//! ([`crate::geometry::bistatic::Basis`]). A receiver is described by the field that it would radiate towards
//! the scatterer, `d = -k_s`, in the basis of `k_s`, **without** conjugate: what it receives is
//! `e_r^T S e_t`.
//!
//! ```
//! use glam::{DMat3, DVec3};
//! use nereus::radar::polarisation::PortBasis;
//! // 60 degrees to the left of the boresight V is still up, and H still level.
//! let d = DVec3::new(0.5, 0.75f64.sqrt(), 0.0);
//! let [h, v] = PortBasis::ludwig3(DMat3::IDENTITY).vectors(d);
//! assert!((v - DVec3::Z).length() < 1e-15 && (h - DVec3::new(-d.y, d.x, 0.0)).length() < 1e-15);
//! ```

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DMat3, DVec3};
use num_complex::Complex64;

use crate::geometry::bistatic::Basis;
use crate::scene::radar::{Polarisation, PolarisationBasis, PortErrors};
use crate::units::Decibels;

/// Axes of an antenna frame in ENU (columns x, y, z).
pub type Axes = DMat3;

/// Square of `x_a + d` below which a direction is straight back.
const BACKWARD: f64 = 1e-24;

/// The polarisation basis of an antenna at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PortBasis {
    /// Which definition.
    pub kind: PolarisationBasis,
    /// Ludwig's: the antenna's axes. Local-horizontal: the vertical at the phase centre as axis z, the others
    /// zero.
    pub axes: Axes,
}

impl PortBasis {
    /// Ludwig's third definition about an antenna's axes.
    pub fn ludwig3(axes: Axes) -> Self {
        Self { kind: PolarisationBasis::Ludwig3, axes }
    }

    /// Local-horizontal, under the vertical (a unit vector) at the phase centre.
    pub fn local_horizontal(up: DVec3) -> Self {
        let axes = Axes::from_cols(DVec3::ZERO, DVec3::ZERO, up);
        Self { kind: PolarisationBasis::LocalHorizontal, axes }
    }

    /// The basis of an antenna, about its axes or under the vertical (a unit vector) at its phase centre.
    pub fn of(kind: PolarisationBasis, axes: Axes, up: DVec3) -> Self {
        match kind {
            PolarisationBasis::Ludwig3 => Self::ludwig3(axes),
            PolarisationBasis::LocalHorizontal => Self::local_horizontal(up),
        }
    }

    /// Unit vectors of H and V across a unit direction from the antenna.
    pub fn vectors(&self, d: DVec3) -> [DVec3; 2] {
        match self.kind {
            PolarisationBasis::LocalHorizontal => {
                let Basis { v, h } = Basis::about(d, self.axes.z_axis);
                [h, -v]
            }
            PolarisationBasis::Ludwig3 => {
                let s = self.axes.x_axis + d;
                let s = if s.length_squared() > BACKWARD { s } else { self.axes.z_axis };
                let scale = 2.0 / s.length_squared();
                let turned = |a: DVec3| a - s * (scale * a.dot(s));
                [turned(self.axes.y_axis), turned(self.axes.z_axis)]
            }
        }
    }
}

/// Shares of H and V in the field of a port; their squares sum to 1, times its gain.
pub fn port_shares(port: Polarisation, errors: PortErrors) -> [Complex64; 2] {
    let leak = errors.isolation_db.map_or(0.0, |db| Decibels(-db).amplitude_ratio());
    let circular =
        |h: f64, v: f64| [Complex64::new(h * FRAC_1_SQRT_2, 0.0), Complex64::new(0.0, v * FRAC_1_SQRT_2)];
    let shares = match port {
        Polarisation::H => [1.0.into(), leak.into()],
        Polarisation::V => [leak.into(), 1.0.into()],
        Polarisation::R => circular(1.0 + leak, leak - 1.0),
        Polarisation::L => circular(1.0 + leak, 1.0 - leak),
    };
    let length = (1.0 + leak * leak).sqrt();
    let shares = [shares[0] / length, shares[1] / length];
    if errors.gain_db == 0.0 && errors.phase_rad == 0.0 {
        return shares;
    }
    let factor = Complex64::from_polar(Decibels(errors.gain_db).amplitude_ratio(), errors.phase_rad);
    shares.map(|share| share * factor)
}

/// Components `(v, h)` in the basis of a propagation direction of the field of a port towards a unit
/// direction `d` from the antenna, unit length. The propagation direction is `d` of a transmitter, `-d` of a
/// receiver.
pub fn field(
    antenna: &PortBasis,
    port: Polarisation,
    errors: PortErrors,
    d: DVec3,
    basis: &Basis,
) -> [Complex64; 2] {
    let [c_h, c_v] = port_shares(port, errors);
    let [e_h, e_v] = antenna.vectors(d);
    let along = |p: DVec3| c_h * p.dot(e_h) + c_v * p.dot(e_v);
    [along(basis.v), along(basis.h)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const PORTS: [Polarisation; 4] = [Polarisation::H, Polarisation::V, Polarisation::R, Polarisation::L];

    /// Directions of a sphere, poles and the far side included.
    fn directions() -> impl Iterator<Item = DVec3> {
        (0..=36).flat_map(|i| {
            (0..24).map(move |j| {
                let (theta, phi) = (f64::from(i) * 5f64.to_radians(), f64::from(j) * 15f64.to_radians());
                let (sine, cosine) = theta.sin_cos();
                DVec3::new(cosine, sine * phi.cos(), sine * phi.sin())
            })
        })
    }

    fn bases() -> [PortBasis; 3] {
        let turned = Axes::from_rotation_z(0.4) * Axes::from_rotation_y(-0.3) * Axes::from_rotation_x(1.1);
        [
            PortBasis::ludwig3(Axes::IDENTITY),
            PortBasis::ludwig3(turned),
            PortBasis::local_horizontal(DVec3::Z),
        ]
    }

    #[test]
    fn a_leaking_port_keeps_its_power() {
        let k = DVec3::X;
        let basis = Basis::of(k);
        let antenna = PortBasis::ludwig3(Axes::IDENTITY);
        for port in PORTS {
            let clean = field(&antenna, port, PortErrors::default(), k, &basis);
            let leaky = field(
                &antenna,
                port,
                PortErrors { isolation_db: Some(20.0), ..PortErrors::default() },
                k,
                &basis,
            );
            let power = |e: [Complex64; 2]| e[0].norm_sqr() + e[1].norm_sqr();
            let wanted = (clean[0].conj() * leaky[0] + clean[1].conj() * leaky[1]).norm();
            assert!((power(clean) - 1.0).abs() < 1e-15 && (power(leaky) - 1.0).abs() < 1e-15);
            // 1 / sqrt(1 + 0.01) of the amplitude is left in the wanted polarisation.
            assert!((wanted - 1.01f64.sqrt().recip()).abs() < 1e-15, "{port:?}: {wanted}");
        }
    }

    #[test]
    fn fields_are_orthonormal_towards_every_direction() {
        for (n, basis) in bases().iter().enumerate() {
            let mut worst = 0.0f64;
            for d in directions() {
                let [h, v] = basis.vectors(d);
                assert!(h.is_finite() && v.is_finite(), "{n}: {d}");
                for error in [h.dot(d), v.dot(d), h.dot(v), h.length() - 1.0, v.length() - 1.0] {
                    worst = worst.max(error.abs());
                }
                assert!((d.cross(h) - v).length() < 1e-6, "{n}: {d}: {h}, {v}");
            }
            // Beside the backward direction `s` loses digits, its direction with them; elsewhere a few
            // roundings.
            assert!(worst < 1e-7, "{n}: {worst:e}");
        }
    }

    /// The definition by angles, and what is computed instead.
    #[test]
    fn ludwig_s_third_definition() {
        let antenna = PortBasis::ludwig3(Axes::IDENTITY);
        let mut worst = 0.0f64;
        for i in 1..180 {
            for j in 0..72 {
                let (theta, phi) = (f64::from(i).to_radians(), (5.0 * f64::from(j)).to_radians());
                let (st, ct, sp, cp) = (theta.sin(), theta.cos(), phi.sin(), phi.cos());
                let d = DVec3::new(ct, st * cp, st * sp);
                let of_theta = DVec3::new(-st, ct * cp, ct * sp);
                let of_phi = DVec3::new(0.0, -sp, cp);
                let [h, v] = antenna.vectors(d);
                worst = worst.max((h - (of_theta * cp - of_phi * sp)).length());
                worst = worst.max((v - (of_theta * sp + of_phi * cp)).length());
            }
        }
        // s is 0.017 a degree from straight back: 2^-53 over it, twice.
        assert!(worst < 1e-13, "{worst:e}");
    }

    #[test]
    fn an_isotropic_antenna_is_level_all_around() {
        let up = DVec3::new(0.03, -0.1, 1.0).normalize();
        let antenna = PortBasis::local_horizontal(up);
        for d in directions() {
            let [h, v] = antenna.vectors(d);
            if d.cross(up).length() > 1e-9 {
                assert!(h.dot(up).abs() < 1e-9 && v.dot(up) > 0.0, "{d}: {h}, {v}");
            }
        }
        for d in [up, -up] {
            let [h, v] = antenna.vectors(d);
            assert!((h.length() - 1.0).abs() < 1e-15 && (d.cross(h) - v).length() < 1e-15);
        }
    }
}
