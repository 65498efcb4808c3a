//! A ship in its own axes: its panels, and the paths that it returns.

use glam::{DMat3, DVec3};
use num_complex::Complex64;

use super::Matrix;
use super::bounces::{self, met};
use super::motion::Seas;
use super::pose::{Pose, Sailing};
use super::shade::Shade;
use crate::frames::{Enu, Point, Vector};
use crate::geometry::bistatic::Basis;
use crate::geometry::light_time::{LightTime, Path, bistatic_between};
use crate::geometry::occlusion::Triangles;
use crate::motion::pointing::PhaseCentre;
use crate::scattering::physical_optics::{Panel, facing, matrix, matrix_after_mirror, reflected};
use crate::scene::Ship;

/// Cosine of the angle from the normal below which a panel will not face an antenna within a block.
const DARK_COSINE: f64 = -0.2;
/// Pairs of planes over panels, at most.
const MOST_BOUNCES: usize = 2;

/// Something on a ship that returns one path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    panel: u32,
    /// Of two bounces: a panel of the second plane, the point on it, and its image in the first panel.
    second: Option<(u32, DVec3, DVec3)>,
}

impl Element {
    /// Whether the wave bounces twice.
    pub fn is_double(&self) -> bool {
        self.second.is_some()
    }
}

/// A ship.
#[derive(Debug)]
pub(super) struct Body {
    panels: Vec<Panel>,
    /// Which plane a panel lies in: a panel of it.
    planes: Vec<u32>,
    triangles: Triangles,
    elements: Vec<Element>,
    sailing: Sailing,
    radius_m: f64,
    shade: Shade,
}

/// A point of a body under way.
fn moving(pose: &Pose, at_m: DVec3) -> PhaseCentre {
    let arm = pose.axes * at_m;
    PhaseCentre {
        position: Point::from_raw(pose.origin_m + arm),
        velocity: Vector::from_raw(pose.velocity_mps + pose.turning_radps.cross(arm)),
        acceleration: Vector::ZERO,
    }
}

impl Body {
    pub fn new(ship: &Ship, seas: Option<Seas<'_>>) -> Self {
        let panels: Vec<Panel> = ship.panels.iter().filter_map(|corners| Panel::new(*corners)).collect();
        let corners: Vec<_> = panels.iter().map(Panel::corners_m).collect();
        let radius_m = corners.iter().flatten().map(|corner| corner.length()).fold(0.0, f64::max);
        let (planes, triangles) = (bounces::planes(&panels), Triangles::new(&corners));
        let twice = bounces::pairs(&panels, &planes, &triangles, MOST_BOUNCES * panels.len());
        let once = (0..panels.len() as u32).map(|panel| Element { panel, second: None });
        let twice = twice.into_iter().map(|(panel, second, at_m)| {
            let of = &panels[panel as usize];
            let image_m = at_m - 2.0 * (at_m - of.centroid_m()).dot(of.normal()) * of.normal();
            Element { panel, second: Some((second, at_m, image_m)) }
        });
        let elements = once.chain(twice).collect();
        let shade = Shade::new(&panels);
        Self { shade, panels, planes, triangles, elements, sailing: Sailing::of(ship, seas), radius_m }
    }

    pub fn elements(&self) -> &[Element] {
        &self.elements
    }

    pub fn sailing(&self) -> &Sailing {
        &self.sailing
    }

    /// What of it hides the sea.
    pub fn shade(&self) -> &Shade {
        &self.shade
    }

    /// No point of it is farther from midship, m.
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// No point of it is faster, m/s.
    pub fn fastest_mps(&self) -> f64 {
        self.sailing.fastest_mps(self.radius_m)
    }

    /// Where its mesh ends, stern and bow, m ahead of midship.
    pub fn ends_m(&self) -> [f64; 2] {
        let ahead = self.shade.corners_m.map(|corner| corner.x);
        [ahead.into_iter().fold(f64::INFINITY, f64::min), ahead.into_iter().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Where a wave meets an element, or, on its way to a receiver, leaves it, in the ship's axes, m.
    pub fn at_m(&self, element: &Element, sends: bool) -> DVec3 {
        match element.second {
            Some((_, at_m, _)) if !sends => at_m,
            _ => self.panels[element.panel as usize].centroid_m(),
        }
    }

    /// Whether an antenna at a place sees an element, in the ship's axes; `sends`: a transmitter.
    pub fn sees(&self, element: &Element, from_m: DVec3, sends: bool) -> bool {
        let free = |panel: u32, at_m: DVec3| {
            let towards = (from_m - at_m).normalize_or_zero();
            towards.dot(self.panels[panel as usize].normal()) > 0.0
                && !self.triangles.meets(at_m, towards, Some(panel))
        };
        let first = self.panels[element.panel as usize].centroid_m();
        match element.second {
            None => free(element.panel, first),
            Some((second, ..)) if sends => {
                let along = (first - from_m).normalize_or_zero();
                free(element.panel, first)
                    && met(&self.panels, &self.triangles, element.panel, along)
                        .is_some_and(|(met, _)| self.planes[met as usize] == second)
            }
            Some((second, at_m, _)) => free(second, at_m),
        }
    }

    /// The panel of an element, one of the plane that its wave meets last, where it goes on from there, and
    /// where the way to it ends.
    pub fn parts(&self, element: &Element) -> (&Panel, &Panel, DVec3, DVec3) {
        let panel = &self.panels[element.panel as usize];
        element
            .second
            .map_or((panel, panel, panel.centroid_m(), panel.centroid_m()), |(second, at_m, image_m)| {
                (panel, &self.panels[second as usize], at_m, image_m)
            })
    }

    /// The path of an element between two antennas, where it meets the ship and leaves it, and its matrix.
    pub fn path(
        &self,
        element: &Element,
        pose: &Pose,
        [tx, rx]: [&PhaseCentre; 2],
        wave_number_rad_m: f64,
    ) -> (Path, [Point<Enu>; 2], Option<Matrix>) {
        let (panel, last, at_m, image_m) = self.parts(element);
        let (image, scatterer) = (moving(pose, image_m), moving(pose, at_m));
        let ends = [moving(pose, panel.centroid_m()).position, scatterer.position];
        let turned = |antenna: &PhaseCentre, at: Point<Enu>, of: &Panel| {
            (antenna.position - at).raw().normalize_or_zero().dot(pose.axes * of.normal()) < DARK_COSINE
        };
        let dark = turned(tx, ends[0], panel) || turned(rx, ends[1], last);
        let method = if dark { LightTime::StopAndGo } else { LightTime::Exact };
        let path = bistatic_between(method, tx, [&image, &scatterer], rx);
        let matrix = if dark { None } else { self.matrix(element, &pose.axes, &path, wave_number_rad_m) };
        (path, ends, matrix)
    }

    fn matrix(&self, element: &Element, axes: &DMat3, path: &Path, wave_number_rad_m: f64) -> Option<Matrix> {
        let panel = &self.panels[element.panel as usize];
        let to_body = axes.transpose();
        let [incident, scattered] = [path.incident, path.scattered].map(|direction| to_body * direction);
        let fades = facing(-incident.dot(panel.normal()));
        if fades == 0.0 {
            return None;
        }
        let bases = || {
            [path.incident, path.scattered].map(|direction| {
                let Basis { v, h } = Basis::of(direction);
                Basis { v: to_body * v, h: to_body * h }
            })
        };
        let (integral, unit) = match element.second {
            None => {
                let fades = fades * facing(scattered.dot(panel.normal()));
                if fades == 0.0 {
                    return None;
                }
                let [from, to] = bases();
                let unit = matrix(wave_number_rad_m, incident, panel.normal(), &from, &to);
                (panel.integral(wave_number_rad_m * (scattered - incident)) * fades, unit)
            }
            Some((second, at_m, _)) => {
                let second = &self.panels[second as usize];
                let fades = fades * facing(scattered.dot(second.normal()));
                let on = reflected(incident, panel.normal());
                let fades = fades * facing(-on.dot(second.normal()));
                if fades == 0.0 {
                    return None;
                }
                let footprint = panel.footprint(second, on)?;
                let [from, to] = bases();
                let normals = [panel.normal(), second.normal()];
                let unit = matrix_after_mirror(wave_number_rad_m, incident, normals, &from, &to);
                let w = wave_number_rad_m * (scattered - on);
                let off = Complex64::cis(w.dot(footprint.centroid_m() - at_m));
                (footprint.integral(w) * off * fades, unit)
            }
        };
        Some(unit.map(|row| row.map(|value| value * integral)))
    }
}
