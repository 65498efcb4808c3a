//! Ships that echo by their own mesh: a scatterer path for every panel, and for every pair of planes between
//! which a wave bounces.
//!
//! A panel is put at the delay of its centroid and has the amplitude of
//! [physical optics](crate::scattering::physical_optics). Where the mirror image of a wave in one panel meets
//! another plane of the ship, the path goes by the image of a point `q` of that plane, found with the mesh
//! alone (`bounces`): its delay is `(|x_T - q'| + |q - x_R|)/c`, and what the footprint is off `q` is in the
//! phase of its amplitude. Both change slowly, and go through the nodes of a block as other amplitudes do.
//!
//! What one part of a ship hides of another is found by rays every 0.25 s and cross-faded in between
//! (`sight`): a factor of every pulse, never interpolated otherwise; so is what land hides
//! ([`Hills`](super::hidden::Hills)). A panel echoes where both antennas see it.
//!
//! Limits: one wave between two planes, met where the outline of the first panel falls as a whole; pairs are
//! those met from a few hundred directions; neither crests nor other ships hide a ship,
//! and the sea does not reflect its echo. What ships hide of the sea is in `hulls`.

mod body;
mod bounces;
mod hulls;
mod lanes;
pub(super) mod mesh;
mod motion;
mod pose;
mod shade;
mod sight;

use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use body::Body;

pub(super) use hulls::Hulls;
use lanes::{Batch, WIDTH};
pub(super) use motion::Seas;
use pose::Pose;
use sight::{Knots, Seen};

use crate::frames::{Enu, Point, SceneFrame};
use crate::geometry::light_time::Path;
use crate::motion::pointing::PhaseCentre;
use crate::paths::hidden::Hills;
use crate::scene::Ship;

/// Time from one update of what hides what to the next, s.
const EVERY_S: f64 = 0.25;

/// Scattering matrix, m.
pub(super) type Matrix = [[Complex64; 2]; 2];

/// The ships of a scene whose meshes echo.
#[derive(Clone, Debug)]
pub(super) struct Ships {
    bodies: Arc<[Body]>,
    knots: Arc<Knots>,
    elements: usize,
}

/// Where the antennas and the ships of an emission are.
pub(super) struct Scenery<'a> {
    /// Transmitters first.
    pub centres: &'a [PhaseCentre],
    pub frame: &'a SceneFrame,
    pub elapsed_s: f64,
}

/// A path by an element of a ship.
pub(super) struct Echoing {
    pub element: usize,
    pub pair: usize,
    pub path: Path,
    /// Where the wave meets the ship and where it leaves it.
    pub at: [Point<Enu>; 2],
    /// `None` where nothing returns.
    pub matrix: Option<Matrix>,
}

impl Ships {
    /// Those of a scene with panels, seen by so many transmitters and receivers, on a sea.
    pub fn new(ships: &[Ship], antennas: [usize; 2], seas: Option<Seas<'_>>) -> Self {
        let meshed = ships.iter().filter(|ship| !ship.panels.is_empty());
        let bodies: Arc<[Body]> = meshed.map(|ship| Body::new(ship, seas)).collect();
        let elements = bodies.iter().map(|body| body.elements().len()).sum();
        Self { bodies, knots: Arc::new(Knots::new(antennas, elements)), elements }
    }

    /// The same, with what was found from other tracks forgotten.
    pub fn renewed(&self) -> Self {
        Self { knots: Arc::new(self.knots.renewed()), ..self.clone() }
    }

    /// What hides the sea of a frame; `None` where no ship echoes by its mesh.
    pub fn hulls(&self, frame: SceneFrame) -> Option<Hulls> {
        (!self.is_empty()).then(|| Hulls::new(Arc::clone(&self.bodies), frame))
    }

    /// Scatterer paths of all ships.
    pub fn len(&self) -> usize {
        self.elements
    }

    /// Whether no ship echoes by its mesh.
    pub fn is_empty(&self) -> bool {
        self.elements == 0
    }

    /// Whether waves move the ship of a path, and whether it turns.
    pub fn is_moved(&self, element: usize) -> [bool; 2] {
        let mut after = 0;
        let of = self.bodies.iter().find(|body| {
            after += body.elements().len();
            element < after
        });
        of.map_or([false; 2], |body| [body.sailing().rides(), body.sailing().turns()])
    }

    /// No point of a ship is faster, m/s.
    pub fn fastest_mps(&self) -> f64 {
        self.bodies.iter().map(Body::fastest_mps).fold(0.0, f64::max)
    }

    /// Midship and no farther point of every ship, m.
    pub fn extents(&self, frame: &SceneFrame, elapsed_s: f64) -> impl Iterator<Item = (DVec3, f64)> {
        self.bodies.iter().map(move |body| (body.sailing().pose(frame, elapsed_s).origin_m, body.radius_m()))
    }

    /// Hands over every path between the antennas of some pairs, `[transmitter, receiver]` as indices of the
    /// centres: element by element the paths of all pairs, until `each` says that it wants no more.
    pub fn visit(
        &self,
        scenery: &Scenery<'_>,
        pairs: &[[usize; 2]],
        wave_number_rad_m: f64,
        mut each: impl FnMut(Echoing) -> bool,
    ) {
        let mut number = 0;
        for body in self.bodies.iter() {
            let pose = body.sailing().pose(scenery.frame, scenery.elapsed_s);
            for element in body.elements() {
                for (pair, ends) in pairs.iter().enumerate() {
                    let ends = ends.map(|end| &scenery.centres[end]);
                    let (path, at, matrix) = body.path(element, &pose, ends, wave_number_rad_m);
                    if !each(Echoing { element: number, pair, path, at, matrix }) {
                        return;
                    }
                }
                number += 1;
            }
        }
    }

    /// Hands over some elements, whose numbers ascend, side by side, with the ship that they are of: as many
    /// as a batch has room for, and their numbers.
    pub fn batches(
        &self,
        frame: &SceneFrame,
        elapsed_s: f64,
        elements: &[u32],
        batch: &mut Batch,
        mut each: impl FnMut(&mut Batch, &Pose, &[u32]),
    ) {
        let (mut rest, mut first) = (elements, 0);
        for body in self.bodies.iter() {
            let after = first + body.elements().len();
            let (own, later) = rest.split_at(rest.partition_point(|n| (*n as usize) < after));
            if !own.is_empty() {
                let pose = body.sailing().pose(frame, elapsed_s);
                for part in own.chunks(WIDTH) {
                    batch.take(body, part.iter().map(|n| body.elements()[*n as usize - first]));
                    each(batch, &pose, part);
                }
            }
            (rest, first) = (later, after);
        }
    }

    /// The time sample of what is seen before a time after pulse 0, and how far it is from there to the next.
    pub fn knot_before(elapsed_s: f64) -> (i64, f64) {
        Knots::before(elapsed_s)
    }

    /// Appends what both antennas of every pair see at a time sample: bits, `[pair][element]`, words of 64
    /// elements.
    ///
    /// # Errors
    /// Those of `centre`.
    pub fn seen_at<E>(
        &self,
        place: (&SceneFrame, Option<&Hills>),
        knot: i64,
        pairs: &[[usize; 2]],
        centre: impl Fn(usize, f64) -> Result<PhaseCentre, E>,
        out: &mut Vec<u64>,
    ) -> Result<(), E> {
        self.knots.at(knot, &self.bodies, place, centre, |seen| {
            for [tx, rx] in pairs {
                let (tx, rx) = (seen.words(*tx), seen.words(*rx));
                out.extend(tx.iter().zip(rx).map(|(tx, rx)| tx & rx));
            }
        })
    }

    /// Appends the share of the field of every element and pair that passes what hides it, land too,
    /// `[element][pair]`. `centre` is where an antenna is at a time after pulse 0.
    ///
    /// # Errors
    /// Those of `centre`.
    pub fn weights<E>(
        &self,
        place: (&SceneFrame, Option<&Hills>),
        elapsed_s: f64,
        pairs: &[[usize; 2]],
        centre: impl Fn(usize, f64) -> Result<PhaseCentre, E>,
        out: &mut Vec<f64>,
    ) -> Result<(), E> {
        if self.is_empty() {
            return Ok(());
        }
        let seen = |seen: &Seen, element: usize, [tx, rx]: [usize; 2]| {
            f64::from(u8::from(seen.has(tx, element) && seen.has(rx, element)))
        };
        let ((number, share), first) = (Knots::before(elapsed_s), out.len());
        self.knots.at(number, &self.bodies, place, &centre, |before| {
            let of = |element| pairs.iter().map(move |pair| seen(before, element, *pair));
            out.extend((0..self.elements).flat_map(of));
        })?;
        self.knots.at(number + 1, &self.bodies, place, &centre, |after| {
            for (element, weights) in out[first..].chunks_exact_mut(pairs.len().max(1)).enumerate() {
                for (weight, pair) in weights.iter_mut().zip(pairs) {
                    *weight += share * (seen(after, element, *pair) - *weight);
                }
            }
        })
    }
}

impl Default for Ships {
    fn default() -> Self {
        Self::new(&[], [0; 2], None)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::frames::Earth;
    use crate::rng::cases::some_of;
    use crate::scene::mesh::{Triangle, divided};
    use crate::scene::ship::HullGiven;
    use crate::units::SPEED_OF_LIGHT_MPS;

    const WAVE_NUMBER: f64 = TAU / 0.03;

    fn ship(panels: Vec<Triangle>) -> Ship {
        Ship {
            name: "body".to_owned(),
            hull: HullGiven::Wigley { beam_m: 1.0, draught_m: 1.0 },
            length_m: None,
            position_m: [0.0, 0.0],
            heading_rad: 0.0,
            speed_mps: 0.0,
            kelvin: None,
            turbulent: None,
            echo: false,
            mesh: Default::default(),
            trajectory: None,
            panels: panels.into(),
        }
    }

    /// A rectangle of sides `u` and `v` at a corner.
    fn wall(at: DVec3, u: DVec3, v: DVec3, panel_m: f64) -> Vec<Triangle> {
        divided(vec![[at, at + u, at + u + v], [at, at + u + v, at + v]], panel_m).unwrap()
    }

    /// What a monostatic radar in a direction receives, far away: `[vv, hh]`.
    fn seen(panels: Vec<Triangle>, towards: DVec3) -> ([Complex64; 2], Ships) {
        let frame = SceneFrame::plain(Earth::Flat);
        let place = towards.normalize() * 1e6;
        let ships = Ships::new(&[ship(panels)], [1, 1], None);
        let end = PhaseCentre::at_rest(Point::from_raw(place));
        let mut weights = Vec::new();
        ships.weights((&frame, None), 0.0, &[[0, 1]], |_, _| Ok::<_, ()>(end), &mut weights).unwrap();
        let scenery = Scenery { centres: &[end, end], frame: &frame, elapsed_s: 0.0 };
        let mut sum = [Complex64::ZERO; 2];
        ships.visit(&scenery, &[[0, 1]], WAVE_NUMBER, |Echoing { element, path, matrix, .. }| {
            if let Some(matrix) = matrix {
                let off_m = path.delay_s * SPEED_OF_LIGHT_MPS - 2e6;
                let turned = Complex64::cis(-WAVE_NUMBER * off_m) * weights[element];
                sum = [sum[0] + matrix[0][0] * turned, sum[1] + matrix[1][1] * turned];
            }
            true
        });
        (sum, ships)
    }

    /// `4 pi (2 a b sin t)^2/lambda^2`, `t` from the nearer wall, up to 45 degrees, where it is
    /// `8 pi a^2 b^2/lambda^2`: Knott, Shaeffer, Tuley, section 6.3.
    #[test]
    fn a_dihedral_has_its_double_bounce() {
        let (a, b) = (1.0, 0.8);
        for degrees in some_of([30.0f64, 45.0, 58.0]) {
            let mut panels = wall(DVec3::ZERO, DVec3::Z * b, DVec3::X * a, 0.06);
            panels.extend(wall(DVec3::ZERO, DVec3::Y * a, DVec3::Z * b, 0.06));
            let t = degrees.to_radians();
            let single = panels.len();
            let (sum, ships) = seen(panels, DVec3::new(t.cos(), t.sin(), 0.0));
            assert!(ships.len() > single, "{}", ships.len());
            let nearer = t.sin().min(t.cos());
            let wanted = 10.0 * (4.0 * PI * (2.0 * a * b * nearer / 0.03f64).powi(2)).log10();
            for s in sum {
                let found = 20.0 * s.norm().log10();
                assert!((found - wanted).abs() < 0.5, "{degrees}: {found} {wanted}");
            }
            // Two reflections turn v and h alike; one, and a plate, turn them apart.
            assert!((sum[0] / sum[1]).re > 0.9, "{sum:?}");
        }
    }

    /// Of two plates, one behind the other, the farther is hidden.
    #[test]
    fn what_is_hidden_does_not_echo() {
        let plate = |x: f64| wall(DVec3::new(x, -0.5, -0.5), DVec3::Y, DVec3::Z, 0.2);
        let (alone, _) = seen(plate(0.0), DVec3::X);
        let wanted = 2.0 * PI.sqrt() / 0.03;
        assert!((alone[0].norm() / wanted - 1.0).abs() < 1e-6, "{alone:?} {wanted}");
        let mut both = plate(0.0);
        both.extend(plate(-3.0));
        assert_eq!(seen(both, DVec3::X).0, alone);
        assert_eq!(seen(plate(0.0), DVec3::NEG_X).0, [Complex64::ZERO; 2]);
    }
}
