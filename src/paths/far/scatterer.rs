//! What a cell of the far sea returns: a facet of the model at a random place.

use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex64;
use rand::RngExt;
use rand_distr::StandardNormal;

use super::FarPlan;
use super::squares::Found;
use crate::frames::{Earth, Enu, Point, Vector};
use crate::geometry::shadow::smith;
use crate::paths::sea::SeaPlan;
use crate::scattering::bragg::Mechanism;
use crate::scattering::facets::Facets;
use crate::scattering::tilt::{NO_ECHO, ScatterMatrix};
use crate::scattering::two_scale::TILTS;
use crate::scene::sea::Phases;
use crate::sea::surface::modulation::look;
use crate::sea::wave_sum::{WAVES, Waters};

/// Slope of what would reflect a ray, over that of the sea, beyond which nothing specular is looked for.
const STEEPEST: f64 = 7.0;

/// A cell while it lives.
#[derive(Clone, Debug)]
pub(super) struct Scatterer {
    /// Where it is when its life is half over.
    pub place: Point<Enu>,
    area_m2: f64,
    waters: Waters,
    /// Fall of the mean surface.
    fall: [f64; 2],
    up: DVec3,
    phasors: [Complex64; 1 + TILTS],
    /// Which mechanism and which line it stands for, of 0 to 1, and where in the line, in deviations.
    mechanism: f64,
    line: f64,
    off: f64,
}

/// The same as a pair of antennas sees it: velocity, m/s, and scattering matrix, sqrt(m^2).
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub velocity: Vector<Enu>,
    pub matrix: ScatterMatrix,
}

impl Scatterer {
    /// A cell whose life is half over at a time after pulse 0.
    pub fn new(plan: &FarPlan, found: Found, earth: Earth, middle_s: f64) -> Self {
        let Found { mut rng, place_m: [x, y], area_m2 } = found;
        let mut phasors = [Complex64::ZERO; 1 + TILTS];
        phasors.fill_with(|| Complex64::cis(TAU * rng.random::<f64>()));
        let [mechanism, line] = [(); 2].map(|()| rng.random::<f64>());
        let off = rng.sample(StandardNormal);
        let waters = if plan.texture {
            plan.waves.at([x, y], middle_s, None)
        } else {
            let mut phases = [0.0; WAVES];
            phases.fill_with(|| rng.random());
            plan.waves.at([x, y], middle_s, Some(&phases))
        };
        let place = Point::new(x, y, waters.height_m - earth.drop_m(x, y));
        let (fall, up) = (earth.drop_slope(x, y), earth.up(place).raw());
        Self { place, area_m2, waters, fall, up, phasors, mechanism, line, off }
    }

    /// As antennas at these places see it.
    pub fn seen(&self, plan: &FarPlan, sea: &SeaPlan, [tx, rx]: [Point<Enu>; 2]) -> Seen {
        let incident = (self.place.raw() - tx.raw()).normalize_or_zero();
        let scattered = (rx.raw() - self.place.raw()).normalize_or_zero();
        let q = scattered - incident;
        let (mechanism, matrix) = self.of_mechanism(plan, sea, [incident, scattered]);
        let share = self.seen_share(plan, [-incident, scattered]);
        let omega_radps = self.omega_radps(plan, sea, mechanism, [incident, scattered]);
        let k_radpm = sea.scattering.wavenumber_radpm();
        // q.v is the frequency of the line.
        let own = q * (omega_radps / (k_radpm * q.length_squared().max(f64::MIN_POSITIVE)));
        let mut water = DVec3::from_array(self.waters.velocity_mps);
        if !sea.displacement {
            (water.x, water.y) = (0.0, 0.0);
        }
        Seen {
            velocity: Vector::from_raw(water + own),
            matrix: matrix.map(|row| row.map(|entry| entry * share)),
        }
    }

    /// Matrix of one of both mechanisms, drawn by their powers, with the power of both.
    fn of_mechanism(
        &self,
        plan: &FarPlan,
        sea: &SeaPlan,
        directions: [DVec3; 2],
    ) -> (Mechanism, ScatterMatrix) {
        let count = sea.scattering.mechanisms().min(self.phasors.len());
        let q = directions[1] - directions[0];
        let leans = q.truncate().length() - self.fall[0].hypot(self.fall[1]) * q.z.abs();
        let reflects = leans < STEEPEST * plan.all_slope_rms * q.z.abs();
        if plan.phases == Phases::Single || !reflects {
            return (Mechanism::Bragg, self.matrix(plan, sea, directions, &self.phasors[..count]));
        }
        let (mut of_bragg, mut of_points) = (self.phasors, [Complex64::ZERO; 1 + TILTS]);
        of_bragg[0] = Complex64::ZERO;
        of_points[0] = self.phasors[0];
        let [bragg, points] =
            [of_bragg, of_points].map(|phasors| self.matrix(plan, sea, directions, &phasors[..count]));
        let power = |m: &ScatterMatrix| m[0][0].norm_sqr() + m[1][1].norm_sqr();
        let of_points = power(&points) / (power(&points) + power(&bragg)).max(f64::MIN_POSITIVE);
        let scaled = |matrix: ScatterMatrix, share: f64| {
            let scale = share.max(f64::MIN_POSITIVE).sqrt().recip();
            matrix.map(|row| row.map(|entry| entry * scale))
        };
        if self.mechanism < of_points {
            (Mechanism::Specular, scaled(points, of_points))
        } else {
            (Mechanism::Bragg, scaled(bragg, 1.0 - of_points))
        }
    }

    fn matrix(
        &self,
        plan: &FarPlan,
        sea: &SeaPlan,
        [incident, scattered]: [DVec3; 2],
        phasors: &[Complex64],
    ) -> ScatterMatrix {
        let q = scattered - incident;
        let raise = plan.waves.strength().factor(self.waters.strain, look([q.x, q.y]));
        let modulation: &[f64] = if sea.scattering.relaxation_per_s().is_some() { &[raise] } else { &[] };
        let [incident, scattered] = [incident, scattered].map(|way| way.to_array());
        let slope = [0, 1].map(|i| self.waters.slope[i] - self.fall[i]);
        let facets = Facets {
            incident: incident.each_ref().map(std::slice::from_ref),
            scattered: scattered.each_ref().map(std::slice::from_ref),
            slope_x: &slope[..1],
            slope_y: &slope[1..],
            cover: &[],
            phasors,
            modulation,
            footprint_m2: self.area_m2,
        };
        let mut out = [Complex64::ZERO; 4];
        let [vv, vh, hv, hh] = out.each_mut().map(std::slice::from_mut);
        // Arrays of one have one entry each.
        if sea.scattering.scatter(0, &facets, [vv, vh, hv, hh]).is_err() {
            return NO_ECHO;
        }
        let [vv, vh, hv, hh] = out;
        [[vv, vh], [hv, hh]]
    }

    /// Root of the share of such cells at this height that antennas in these directions see, and the field
    /// of the ray that the sea reflects, where that interferes.
    fn seen_share(&self, plan: &FarPlan, ends: [DVec3; 2]) -> f64 {
        if !plan.shadowed {
            return 1.0;
        }
        let level = ends.map(|end| (end - self.up * end.dot(self.up)).truncate());
        let sines = ends.map(|end| end.dot(self.up));
        let lambdas = [0, 1].map(|n| {
            let tangent = sines[n] / (1.0 - sines[n] * sines[n]).max(f64::MIN_POSITIVE).sqrt();
            smith::lambda(tangent, plan.waves.slope_rms(level[n].to_array()))
        });
        let common = level[0].normalize_or_zero().dot(level[1].normalize_or_zero());
        let fields = plan.two_rays.map_or(1.0, |two_rays| {
            let of = |n: usize| {
                let towards = level[n].normalize_or_zero();
                let slope = -(self.waters.slope[0] * towards.x + self.waters.slope[1] * towards.y);
                two_rays.field(self.waters.height_m, sines[n], slope)
            };
            of(0) * of(1)
        });
        let height = self.waters.height_m / plan.waves.height_rms_m().max(f64::MIN_POSITIVE);
        smith::seen(lambdas, common, height).sqrt() * fields
    }

    /// Frequency of the cell within the lines of a mechanism, rad/s.
    fn omega_radps(
        &self,
        plan: &FarPlan,
        sea: &SeaPlan,
        mechanism: Mechanism,
        [incident, scattered]: [DVec3; 2],
    ) -> f64 {
        let Some(lines) = sea.scattering.travelling() else { return plan.forgets_radps * self.off };
        let [one, other] = lines.lines(mechanism, incident, scattered);
        let powers = [one, other].map(|line| line.amplitude * line.amplitude);
        let first = self.line * (powers[0] + powers[1]) < powers[0];
        let line = if first { one } else { other };
        line.centre_radps + line.deviation_radps * self.off
    }
}
