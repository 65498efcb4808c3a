//! Physical optics of flat triangular panels, perfectly conducting.
//!
//! A plane wave of unit field `e_i` travels along `k_i` and drives the current `J = 2 n x H_i` on a panel
//! that it lights. What the current radiates along `k_s`, as a scattering amplitude referred to the panel's
//! centroid `c` (`|S|^2` is the radar cross section), is
//!
//! `S_pq = -j k/sqrt(pi) p_s . [k_i (n.q_i) - q_i (n.k_i)] I` , `I = integral of e^{j w.(r - c)} dA` ,
//! `w = k (k_s - k_i)` .
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `S_pq` | p received, q sent, order (v, h), in the bases of [`crate::geometry::bistatic`] | m |
//! | `k` | wave number | rad/m |
//! | `n` | unit normal, outwards | |
//! | `A` | area | m^2 |
//! | `phi_l` | `w.(r_l - c)` of the corners; their sum is zero | rad |
//!
//! The integral over a triangle is twice its area times the second divided difference of the exponential at
//! the three phases (Hermite and Genocchi):
//!
//! `I = -2 A E[phi_1, phi_2, phi_3]` , `E[a, b] = j e^{j (a + b)/2} sin((b - a)/2) / ((b - a)/2)` ,
//! `E[a, b, c] = (E[b, c] - E[a, b]) / (c - a)` , `a <= b <= c` .
//!
//! Where the phases lie close together it is taken from its series, so nothing is singular: broadside, an
//! edge along the wave front, a panel of no size.
//!
//! **Two bounces.** A panel reflects the wave as a mirror does, `r = k_i - 2 (n.k_i) n`,
//! `e_r = 2 (n.e_i) n - e_i`, and what falls on another plane is the panel's own outline, carried along `r`
//! ([`Panel::footprint`]): geometrical optics, then physical optics of the footprint.
//!
//! A panel fades from the cosine [`EDGE_COSINE`] of incidence to grazing: physical optics overstates what is
//! nearly edge-on, and nothing may jump as a panel turns away.
//!
//! Sources: Gordon, IEEE Trans. AP-23 (1975) 590 (the integral over a polygon); Knott, Shaeffer, Tuley,
//! "Radar cross section", 2nd ed. (2004), sections 5.4 and 6.2 (the current, plates, cylinders, dihedrals).
//!
//! Limits: panels of some wavelengths and more, far field of each panel (`2 D^2/lambda`), perfect conductors;
//! no edge diffraction, no travelling or creeping waves; not reciprocal where `k_s` is not `-k_i`.
//!
//! ```
//! use glam::DVec3;
//! use nereus::scattering::physical_optics::Panel;
//! let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
//! let panel = Panel::new(corners).unwrap();
//! assert_eq!(panel.normal(), DVec3::Z);
//! assert!((panel.integral(DVec3::ZERO).re - 0.5).abs() < 1e-15);
//! assert!(Panel::new([DVec3::ZERO, DVec3::X, DVec3::X * 2.0]).is_none());
//! ```

use std::f64::consts::PI;

use glam::DVec3;
use num_complex::Complex64;

use crate::geometry::bistatic::Basis;

/// Cosine of the angle to the normal below which panels fade.
pub const EDGE_COSINE: f64 = 0.05;

/// Phases closer together than this, rad, are taken by the series: it leaves some 1e-13.
const CLOSE_RAD: f64 = 0.02;
/// Cosine between a reflected ray and the plane that it meets, at least: nothing is left of its footprint.
const LEAST_DOWN: f64 = 1e-4;
/// Twice the area of a panel over the square of its longest edge, at least.
const LEAST_SHAPE: f64 = 1e-9;

/// A flat triangular panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    centroid_m: DVec3,
    /// From the centroid.
    corners_m: [DVec3; 3],
    normal: DVec3,
    area_m2: f64,
}

impl Panel {
    /// A panel of three corners, counter-clockwise as seen from outside; `None` where they lie in a line, or
    /// are no numbers.
    pub fn new(corners_m: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners_m;
        let across = (b - a).cross(c - a);
        let longest = (b - a).length_squared().max((c - a).length_squared()).max((c - b).length_squared());
        let twice = across.length();
        if !(twice.is_finite() && twice > LEAST_SHAPE * longest) {
            return None;
        }
        let centroid_m = (a + b + c) / 3.0;
        Some(Self {
            centroid_m,
            corners_m: corners_m.map(|corner| corner - centroid_m),
            normal: across / twice,
            area_m2: 0.5 * twice,
        })
    }

    /// Mean of the corners, m.
    pub fn centroid_m(&self) -> DVec3 {
        self.centroid_m
    }

    /// Unit normal, outwards.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Area, m^2.
    pub fn area_m2(&self) -> f64 {
        self.area_m2
    }

    /// Corners, m.
    pub fn corners_m(&self) -> [DVec3; 3] {
        self.corners_m.map(|corner| self.centroid_m + corner)
    }

    /// Integral of `e^{j w.(r - c)}` over the panel, m^2; `w` in rad/m.
    pub fn integral(&self, w: DVec3) -> Complex64 {
        2.0 * self.area_m2 * simplex(self.corners_m.map(|corner| w.dot(corner)))
    }

    /// What the panel, as a mirror, throws on the plane of another: its outline carried along the reflected
    /// ray. `None` where the other turns away from the ray, or is nearly along it.
    pub fn footprint(&self, other: &Panel, reflected: DVec3) -> Option<Panel> {
        let down = reflected.dot(other.normal);
        if down > -LEAST_DOWN {
            return None;
        }
        let land =
            |corner: DVec3| corner + reflected * ((other.centroid_m - corner).dot(other.normal) / down);
        let [a, b, c] = self.corners_m().map(land);
        // A mirror turns the outline round.
        let panel = Panel::new([a, b, c])?;
        if panel.normal.dot(other.normal) > 0.0 { Some(panel) } else { Panel::new([a, c, b]) }
    }
}

/// Integral of `e^{j t.phi}` over the simplex `t >= 0, t_1 + t_2 + t_3 = 1`, of phases whose sum is zero.
fn simplex(mut phases: [f64; 3]) -> Complex64 {
    phases.sort_by(f64::total_cmp);
    let [a, b, c] = phases;
    let apart = c - a;
    if apart < CLOSE_RAD {
        // Power sums of phases without a mean: the complete homogeneous polynomials are p2/2, p3/3, p2^2/4.
        let p2 = a * a + b * b + c * c;
        let p3 = a * a * a + b * b * b + c * c * c;
        return Complex64::new(0.5 - p2 / 48.0 + p2 * p2 / 2880.0, -p3 / 360.0);
    }
    let first = |from: f64, to: f64| {
        let half = 0.5 * (to - from);
        let share = if half < 1e-4 { 1.0 - half * half / 6.0 } else { half.sin() / half };
        Complex64::cis(0.5 * (from + to)) * share
    };
    Complex64::I * (first(a, b) - first(b, c)) / apart
}

/// The same for loops over many panels: without branches, real and imaginary part.
#[inline(always)]
pub(crate) fn simplex_of([a, b, c]: [f64; 3]) -> [f64; 2] {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    let (low, middle) = if c < low { (c, low) } else { (low, c) };
    let (middle, high) = if high < middle { (high, middle) } else { (middle, high) };
    let apart = high - low;
    let (p2, p3) = (a * a + b * b + c * c, a * a * a + b * b * b + c * c * c);
    let series = [0.5 - p2 / 48.0 + p2 * p2 / 2880.0, -p3 / 360.0];
    // Means of two phases are half the third, as their sum is zero.
    let (first, second) = (share(0.5 * (middle - low)), share(0.5 * (high - middle)));
    let ((sin_high, cos_high), (sin_low, cos_low)) = (sine_cosine(0.5 * high), sine_cosine(0.5 * low));
    let differ = [cos_high * first - cos_low * second, sin_low * second - sin_high * first];
    let close = apart < CLOSE_RAD;
    [if close { series[0] } else { -differ[1] / apart }, if close { series[1] } else { differ[0] / apart }]
}

/// `sin x / x`.
#[inline(always)]
fn share(half: f64) -> f64 {
    let sine = sine_cosine(half).0;
    if half < 1e-4 { 1.0 - half * half / 6.0 } else { sine / half }
}

/// Sine and cosine up to some million radians, to 2e-15.
#[inline(always)]
pub(crate) fn sine_cosine(x: f64) -> (f64, f64) {
    /// Adding it rounds to whole numbers, the last bit of which is then that of the sum.
    const TO_INTEGER: f64 = 6_755_399_441_055_744.0;
    /// Pi in two parts, the first of 33 bits: its products with 20 more are exact.
    const HALF_TURN: [f64; 2] = [3.141_592_653_468_251_2, 1.215_420_101_301_238_5e-10];
    let shifted = x * std::f64::consts::FRAC_1_PI + TO_INTEGER;
    let turns = shifted - TO_INTEGER;
    let odd = (shifted.to_bits() & 1) << 63;
    let r = (x - turns * HALF_TURN[0]) - turns * HALF_TURN[1];
    let z = r * r;
    // Taylor, up to r^19/19! and r^20/20!, a quarter of a turn to either side.
    let sine = -1.0 / 121_645_100_408_832_000.0;
    let sine = sine * z + 1.0 / 355_687_428_096_000.0;
    let sine = sine * z - 1.0 / 1_307_674_368_000.0;
    let sine = sine * z + 1.0 / 6_227_020_800.0;
    let sine = sine * z - 1.0 / 39_916_800.0;
    let sine = sine * z + 1.0 / 362_880.0;
    let sine = sine * z - 1.0 / 5040.0;
    let sine = sine * z + 1.0 / 120.0;
    let sine = sine * z - 1.0 / 6.0;
    let sine = (sine * z + 1.0) * r;
    let cosine = 1.0 / 2_432_902_008_176_640_000.0;
    let cosine = cosine * z - 1.0 / 6_402_373_705_728_000.0;
    let cosine = cosine * z + 1.0 / 20_922_789_888_000.0;
    let cosine = cosine * z - 1.0 / 87_178_291_200.0;
    let cosine = cosine * z + 1.0 / 479_001_600.0;
    let cosine = cosine * z - 1.0 / 3_628_800.0;
    let cosine = cosine * z + 1.0 / 40_320.0;
    let cosine = cosine * z - 1.0 / 720.0;
    let cosine = cosine * z + 1.0 / 24.0;
    let cosine = (cosine * z - 0.5) * z + 1.0;
    (f64::from_bits(sine.to_bits() ^ odd), f64::from_bits(cosine.to_bits() ^ odd))
}

/// What is left of a panel that is turned by so much: 0 to 1.
#[inline(always)]
pub fn facing(cosine: f64) -> f64 {
    let s = (cosine / EDGE_COSINE).clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

/// The direction in which a mirror of unit normal reflects a wave.
pub fn reflected(incident: DVec3, normal: DVec3) -> DVec3 {
    incident - 2.0 * normal.dot(incident) * normal
}

/// The field that a perfectly conducting mirror reflects.
fn mirrored(field: DVec3, normal: DVec3) -> DVec3 {
    2.0 * normal.dot(field) * normal - field
}

/// Scattering matrix `S[p][q]` of a unit integral, 1/m: p received along `basis_out`, q sent along
/// `basis_in`; times [`Panel::integral`] it is that of the panel.
pub fn matrix(
    wave_number_rad_m: f64,
    incident: DVec3,
    normal: DVec3,
    basis_in: &Basis,
    basis_out: &Basis,
) -> [[Complex64; 2]; 2] {
    radiated(wave_number_rad_m, incident, normal, [basis_in.v, basis_in.h], basis_out)
}

/// The same after a mirror of normal `first`, from which the wave goes on to a panel of normal `second`.
pub fn matrix_after_mirror(
    wave_number_rad_m: f64,
    incident: DVec3,
    [first, second]: [DVec3; 2],
    basis_in: &Basis,
    basis_out: &Basis,
) -> [[Complex64; 2]; 2] {
    let fields = [mirrored(basis_in.v, first), mirrored(basis_in.h, first)];
    radiated(wave_number_rad_m, reflected(incident, first), second, fields, basis_out)
}

fn radiated(
    wave_number_rad_m: f64,
    incident: DVec3,
    normal: DVec3,
    fields: [DVec3; 2],
    out: &Basis,
) -> [[Complex64; 2]; 2] {
    let factor = -wave_number_rad_m / PI.sqrt();
    let down = normal.dot(incident);
    let currents = fields.map(|field| incident * normal.dot(field) - field * down);
    [out.v, out.h].map(|p| currents.map(|current| Complex64::new(0.0, factor * p.dot(current))))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;

    /// The integral by brute force: many small parts, each at its centroid.
    fn by_sum(panel: &Panel, w: DVec3, parts: usize) -> Complex64 {
        let [a, b, c] = panel.corners_m();
        let (u, v) = ((b - a) / parts as f64, (c - a) / parts as f64);
        let mut sum = Complex64::ZERO;
        for i in 0..parts {
            for j in 0..parts - i {
                let corner = a + u * i as f64 + v * j as f64;
                let mut add = |at: DVec3| sum += Complex64::cis(w.dot(at - panel.centroid_m()));
                add(corner + (u + v) / 3.0);
                if i + j + 1 < parts {
                    add(corner + (u + v) * (2.0 / 3.0));
                }
            }
        }
        sum * (panel.area_m2() / (parts * parts) as f64)
    }

    #[test]
    fn the_integral_is_that_of_small_parts() {
        let panel =
            Panel::new([DVec3::new(0.3, 0.1, 0.2), DVec3::new(1.1, -0.2, 0.4), DVec3::new(0.6, 0.9, -0.3)])
                .unwrap();
        let edge = panel.corners_m()[1] - panel.corners_m()[0];
        let along = edge.any_orthonormal_vector();
        for w in [
            DVec3::ZERO,
            panel.normal() * 40.0,
            DVec3::new(3.0, -2.0, 5.0),
            along * 30.0,
            DVec3::new(1e-3, 2e-3, 0.0),
            DVec3::new(0.02, 0.01, 0.0),
        ] {
            // Centroids leave (w h)^2/36 of parts of side h: 30 x 1.4/400, 4e-4 at most.
            let (found, sum) = (panel.integral(w), by_sum(&panel, w, 400));
            assert!((found - sum).norm() < 4e-4 * panel.area_m2(), "{w}: {found} {sum}");
        }
    }

    proptest! {
        #![proptest_config(crate::rng::cases::proptests(256))]

        /// Near every removable singularity the form meets its series: no cancellation, no jump.
        #[test]
        fn divided_differences_meet_their_series(a in -1.0..1.0f64, b in -1.0..1.0f64, size in -9.0..0.5f64) {
            let scale = 10f64.powf(size);
            let (a, b) = (a * scale, b * scale);
            let found = simplex([a, b, -a - b]);
            // The power series to 40 terms, of complete homogeneous polynomials.
            let c = -a - b;
            let (mut sum, mut factor) = (Complex64::ZERO, Complex64::new(0.5, 0.0));
            for n in 0..40 {
                let mut h = 0.0;
                for i in 0..=n {
                    for j in 0..=n - i {
                        h += a.powi(i) * b.powi(j) * c.powi(n - i - j);
                    }
                }
                sum += factor * h;
                factor *= Complex64::I / f64::from(n + 3);
            }
            prop_assert!((found - sum).norm() < 1e-11, "{found} {sum}");
        }

        /// Without branches it is the same, up to the phases of large panels.
        #[test]
        fn forms_for_loops_are_the_same(a in -1.0..1.0f64, b in -1.0..1.0f64, size in -9.0..5.0f64) {
            let scale = 10f64.powf(size);
            let (a, b) = (a * scale, b * scale);
            let phases = [a, b, -a - b];
            let (found, wanted) = (simplex_of(phases), simplex(phases));
            // Either form divides a difference of two phasors, each off by a few roundings and by that of its
            // phase.
            let largest = phases.iter().fold(0.0f64, |most, p| most.max(p.abs()));
            let slack = 8.0 * f64::EPSILON * (1.0 + largest) / largest.max(CLOSE_RAD);
            prop_assert!((Complex64::new(found[0], found[1]) - wanted).norm() < slack, "{found:?} {wanted}");
            let (sine, cosine) = sine_cosine(a);
            prop_assert!((sine - a.sin()).abs() < 2e-15 && (cosine - a.cos()).abs() < 2e-15, "{a}");
        }
    }

    fn monostatic(panels: &[Panel], wave_number: f64, incident: DVec3) -> [f64; 2] {
        let (basis_in, basis_out) = (Basis::of(incident), Basis::of(-incident));
        let mut sum = [Complex64::ZERO; 2];
        for panel in panels {
            let fades = facing(-panel.normal().dot(incident));
            if fades > 0.0 {
                let w = -2.0 * wave_number * incident;
                let phase = Complex64::cis(w.dot(panel.centroid_m()));
                let s = matrix(wave_number, incident, panel.normal(), &basis_in, &basis_out);
                let integral = panel.integral(w) * phase * fades;
                sum = [sum[0] + s[0][0] * integral, sum[1] + s[1][1] * integral];
            }
        }
        sum.map(|s| 10.0 * s.norm_sqr().log10())
    }

    /// A rectangle about the origin, of two panels.
    fn plate(a: f64, b: f64) -> Vec<Panel> {
        let at = |x: f64, y: f64| DVec3::new(0.0, 0.5 * a * x, 0.5 * b * y);
        let corners = [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)];
        [[0, 1, 2], [0, 2, 3]].iter().filter_map(|i| Panel::new(i.map(|i| corners[i]))).collect()
    }

    /// `4 pi A^2/lambda^2` broadside, `cos^2 t sinc^2(k a sin t)` of it at an angle: Knott, Shaeffer, Tuley
    /// eq. 6.7 (principal planes).
    #[test]
    fn a_plate_has_its_closed_form() {
        let (a, b, wave_number) = (0.5, 0.4, TAU / 0.03);
        let panels = plate(a, b);
        for degrees in [0.0f64, 0.7, 3.1, 11.0, 30.0, 60.0, 80.0] {
            let t = degrees.to_radians();
            let incident = -DVec3::new(t.cos(), t.sin(), 0.0);
            let u = wave_number * a * t.sin();
            let share = if u == 0.0 { 1.0 } else { u.sin() / u };
            let amplitude = wave_number * a * b / PI.sqrt() * t.cos() * share;
            for found in monostatic(&panels, wave_number, incident) {
                assert!((found - 20.0 * amplitude.abs().log10()).abs() < 1e-6, "{degrees}: {found}");
            }
        }
        let broadside = 10.0 * (4.0 * PI * (a * b / 0.03f64).powi(2)).log10();
        assert!((monostatic(&panels, wave_number, DVec3::NEG_X)[0] - broadside).abs() < 1e-9);
    }

    /// `pi a^2` of a sphere of `ka` = 60, whatever the direction.
    #[test]
    fn a_sphere_has_its_geometric_cross_section() {
        let (radius, rows) = (1.0, 220);
        let at = |i: usize, j: usize| {
            let (t, p) = (PI * i as f64 / rows as f64, PI * j as f64 / rows as f64);
            radius * DVec3::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos())
        };
        let mut panels = Vec::new();
        for i in 0..rows {
            for j in 0..2 * rows {
                let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                panels.extend([[0, 1, 2], [0, 2, 3]].iter().filter_map(|n| Panel::new(n.map(|n| quad[n]))));
            }
        }
        let wanted = 10.0 * PI.log10();
        for incident in
            [DVec3::X, DVec3::new(-1.0, 2.0, -0.7).normalize(), DVec3::new(0.1, 0.0, -1.0).normalize()]
        {
            for found in monostatic(&panels, 60.0, incident) {
                assert!((found - wanted).abs() < 0.5, "{incident}: {found}, {wanted}");
            }
        }
    }

    /// `2 pi a L^2/lambda` of a cylinder, broadside (Knott, Shaeffer, Tuley, table 6.1).
    #[test]
    fn a_cylinder_has_its_broadside_cross_section() {
        let (radius, length, wavelength, columns) = (0.5, 2.0, 0.03, 720);
        let at = |i: usize, z: f64| {
            let p = TAU * i as f64 / f64::from(columns);
            DVec3::new(radius * p.cos(), radius * p.sin(), z)
        };
        let mut panels = Vec::new();
        for i in 0..columns as usize {
            let quad = [at(i, 0.0), at(i + 1, 0.0), at(i + 1, length), at(i, length)];
            panels.extend([[0, 1, 2], [0, 2, 3]].iter().filter_map(|n| Panel::new(n.map(|n| quad[n]))));
        }
        let wanted = 10.0 * (TAU * radius * length * length / wavelength).log10();
        for incident in [DVec3::X, DVec3::new(0.3, -0.9, 0.0).normalize()] {
            for found in monostatic(&panels, TAU / wavelength, incident) {
                assert!((found - wanted).abs() < 0.5, "{found} {wanted}");
            }
        }
    }

    #[test]
    fn panels_that_are_none_are_refused() {
        for bad in [f64::NAN, f64::INFINITY, 1e200] {
            assert!(Panel::new([DVec3::ZERO, DVec3::X * bad, DVec3::Y * bad]).is_none(), "{bad}");
        }
        assert!(Panel::new([DVec3::ONE; 3]).is_none());
    }
}
