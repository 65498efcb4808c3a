//! The lines of sixteen facets side by side: the numbers of [`BraggLines::lines`] in single precision.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use super::{BraggLines, Mechanism};

/// Facets whose lines are found, and components summed, together.
pub const GROUP: usize = 16;

/// Directions to the receiver less those from the transmitter, `[axis][facet]`.
pub type Looks = [[f32; GROUP]; 3];

/// A line of the facets of a group at an end of the block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct End {
    pub centre_radps: [f32; GROUP],
    /// 1 over where it ends to either side of its middle, s/rad.
    pub inverse: [f32; GROUP],
    pub height: [f32; GROUP],
}

impl End {
    /// No line.
    pub const NONE: Self = Self { centre_radps: [0.0; GROUP], inverse: [1.0; GROUP], height: [0.0; GROUP] };

    /// Largest height.
    #[inline(always)]
    pub fn highest(&self) -> f32 {
        let mut most = 0.0;
        for i in 0..GROUP {
            most = if self.height[i] > most { self.height[i] } else { most };
        }
        most
    }

    /// From where to where it has components, rad/s.
    #[inline(always)]
    pub fn span(&self, i: usize) -> [f32; 2] {
        let end = 1.0 / self.inverse[i];
        [self.centre_radps[i] - end, self.centre_radps[i] + end]
    }
}

impl BraggLines {
    /// Both lines of a mechanism of `count` facets.
    #[inline(always)]
    pub(super) fn of_group(&self, mechanism: Mechanism, looks: &Looks, count: usize, lines: &mut [End; 2]) {
        let k = self.wavenumber_radpm as f32;
        let drift_mps = self.drift_mps.as_vec3();
        let mut q = [[0.0; GROUP]; 3];
        for (q, look) in q.iter_mut().zip(looks) {
            for i in 0..GROUP {
                q[i] = look[i] * k;
            }
        }
        let mut carried_radps = [0.0; GROUP];
        for i in 0..GROUP {
            carried_radps[i] = q[0][i] * drift_mps.x + q[1][i] * drift_mps.y + q[2][i] * drift_mps.z;
        }
        let (mut omega_radps, mut roots) = ([0.0; GROUP], [[1.0; GROUP], [0.0; GROUP]]);
        let deviation_radps = match mechanism {
            Mechanism::Specular => self.widths(&q, &[self.specular_to_radpm as f32; GROUP], &[0.0; GROUP]),
            Mechanism::Bragg => {
                let mut magnitude = [0.0; GROUP];
                for i in 0..GROUP {
                    magnitude[i] = (q[0][i] * q[0][i] + q[1][i] * q[1][i]).sqrt().max(1e-9 * k);
                }
                omega_radps = magnitude;
                self.dispersion.angular_frequencies_rad_s(&mut omega_radps);
                let downwind = [self.downwind[0] as f32, self.downwind[1] as f32];
                self.share.roots_of_group(&q, downwind, &magnitude, &mut roots);
                let mut of_tilts = [0.0; GROUP];
                if self.deviation_radps.is_none() {
                    self.widening(&q, &magnitude, &omega_radps, &mut of_tilts);
                }
                self.widths(&q, &magnitude, &of_tilts)
            }
        };
        let (mut inverse, mut height) = ([0.0; GROUP], [0.0; GROUP]);
        for i in 0..GROUP {
            [inverse[i], height[i]] = self.comb.bell(deviation_radps[i]);
        }
        for ((line, roots), sign) in lines.iter_mut().zip(&roots).zip([1.0, -1.0]) {
            for i in 0..GROUP {
                line.centre_radps[i] = sign * omega_radps[i] + carried_radps[i];
                line.inverse[i] = inverse[i];
                line.height[i] = roots[i] * height[i];
            }
            // Lanes that are not in use are as the first: they ask for no cells of their own.
            for i in count..GROUP {
                (line.centre_radps[i], line.inverse[i]) = (line.centre_radps[0], line.inverse[0]);
                line.height[i] = 0.0;
            }
        }
    }

    /// What tilts of sub-facets add to the square of a deviation, (rad/s)^2.
    #[inline(always)]
    fn widening(
        &self,
        [x, y, z]: &Looks,
        magnitude: &[f32; GROUP],
        omega_radps: &[f32; GROUP],
        out: &mut [f32; GROUP],
    ) {
        let mut tilts = [0.0; 3];
        for i in 0..3 {
            tilts[i] = self.tilts[i] as f32;
        }
        let [xx, xy, yy] = tilts;
        let mut group_mps = *magnitude;
        self.dispersion.group_speeds_mps(omega_radps, &mut group_mps);
        for i in 0..GROUP {
            let tilted = (x[i] * x[i] * xx + 2.0 * x[i] * y[i] * xy + y[i] * y[i] * yy)
                / (magnitude[i] * magnitude[i]);
            let change_mps = group_mps[i] * z[i];
            out[i] = change_mps * change_mps * tilted;
        }
    }

    /// Rms deviations, rad/s, of the waves up to a wave number, and what else adds to their squares.
    #[inline(always)]
    fn widths(&self, q: &Looks, to_radpm: &[f32; GROUP], more: &[f32; GROUP]) -> [f32; GROUP] {
        if let Some(own) = self.deviation_radps {
            return [own as f32; GROUP];
        }
        let mut out = [0.0; GROUP];
        self.velocities.mean_squares(q, to_radpm, &mut out);
        for i in 0..GROUP {
            out[i] = (out[i] + more[i]).sqrt();
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::super::comb::Line;
    use super::super::tests::lines;
    use super::*;

    #[test]
    fn a_group_has_the_lines_of_its_facets() {
        let own = lines(100.0, 1.0, [0.05, 0.02], [0.01, 0.005]);
        let given = BraggLines { deviation_radps: Some(7.0), ..own.clone() };
        let mut shallow = own.clone();
        shallow.dispersion.depth_m = Some(0.02);
        for lines in [own, given, shallow] {
            for turn in 0..24 {
                let look = |n: usize| {
                    let azimuth = 0.25 * turn as f64 + 0.01 * n as f64;
                    // From level to straight down.
                    let down = 0.13 * n as f64;
                    DVec3::new(2.0 * azimuth.cos(), 2.0 * azimuth.sin(), down * down).normalize() * 1.9
                };
                let mut looks = [[0.0; GROUP]; 3];
                for n in 0..13 {
                    let at = if n == 12 { DVec3::new(0.0, 0.0, 2.0) } else { look(n) };
                    let at = at.as_vec3();
                    (looks[0][n], looks[1][n], looks[2][n]) = (at.x, at.y, at.z);
                }
                for mechanism in [Mechanism::Specular, Mechanism::Bragg] {
                    let mut ends = [End::NONE; 2];
                    lines.of_group(mechanism, &looks, 13, &mut ends);
                    for n in 0..13 {
                        let look = Vec3::new(looks[0][n], looks[1][n], looks[2][n]).as_dvec3();
                        let expected = lines.lines(mechanism, DVec3::ZERO, look);
                        for (end, line) in ends.iter().zip(expected) {
                            let near = |own: f32, other: f64, of: f64| {
                                let off = (f64::from(own) - other).abs();
                                assert!(off < 3e-5 * of, "{n}: {own} {other}");
                            };
                            let end_radps = lines.comb.end_radps(line.deviation_radps);
                            let most = lines.comb.height(Line { amplitude: 1.0, ..line });
                            near(end.height[n], lines.comb.height(line), most);
                            // Specular points have one line; the other has no height.
                            if line.amplitude != 0.0 {
                                near(end.centre_radps[n], line.centre_radps, end_radps);
                                near(end.inverse[n] * end_radps as f32, 1.0, 1.0);
                            }
                        }
                    }
                    assert!(ends.iter().all(|end| end.height[13..].iter().all(|height| *height == 0.0)));
                }
            }
        }
    }
}
