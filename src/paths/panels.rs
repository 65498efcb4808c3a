//! Scatterer paths of the panels of ships.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::PathGenerator;
use super::emission::{Emission, TrackFailure};
use super::facets::Reception;
use super::ships::mesh::MeshWork;
use super::ships::{Echoing, Scenery};
use crate::cpu::Variant;
use crate::geometry::light_time::Path;
use crate::paths::list::ScattererPaths;
use crate::radar::fault::RadarError;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Buffers for the panels of ships.
#[derive(Clone, Default)]
pub(super) struct ShipWork {
    /// `[element][pair]`.
    weights: Vec<f64>,
    /// Of an element.
    of_pairs: Vec<Path>,
    /// For panels by lists; made when it is first asked for.
    mesh: Option<Box<MeshWork>>,
}

impl ShipWork {
    /// Buffers for panels by lists.
    pub fn mesh(&mut self) -> &mut MeshWork {
        self.mesh.get_or_insert_with(|| Box::new(MeshWork::new(Variant::fastest())))
    }
}

impl PathGenerator {
    /// Buffers with room for all panels.
    pub(super) fn ship_work(&self) -> ShipWork {
        let pairs = self.pairs.len();
        ShipWork {
            weights: Vec::with_capacity(self.ships.len() * pairs),
            of_pairs: Vec::with_capacity(pairs),
            mesh: None,
        }
    }

    /// Paths of ships that echo by their mesh.
    pub fn ship_paths(&self) -> usize {
        self.ships.len()
    }

    /// Delays of targets, widened by those of ships, s.
    pub(super) fn with_ships(
        &self,
        span_s: Option<(f64, f64)>,
        emission: &Emission,
        elapsed_s: f64,
        ends: &[[usize; 2]],
    ) -> Option<(f64, f64)> {
        self.ship_spans_s(emission, elapsed_s, ends).fold(span_s, |span_s, [least, most]| {
            Some(span_s.map_or((least, most), |(a, b)| (least.min(a), most.max(b))))
        })
    }

    /// Bounds on the delays of every ship over pairs of such antennas, s.
    fn ship_spans_s(
        &self,
        emission: &Emission,
        elapsed_s: f64,
        ends: &[[usize; 2]],
    ) -> impl Iterator<Item = [f64; 2]> {
        self.ships.extents(&self.frame, elapsed_s).flat_map(move |(midship_m, radius_m)| {
            ends.iter().map(move |ends| {
                let leg_m = |end: &usize| (emission.centres[*end].position.raw() - midship_m).length();
                let (straight_m, slack_m) = (ends.iter().map(leg_m).sum::<f64>(), 4.0 * radius_m);
                [straight_m - slack_m, straight_m + slack_m]
                    .map(|length_m| length_m.max(0.0) / SPEED_OF_LIGHT_MPS)
            })
        })
    }

    /// Whether what a ship returns of an emission lies partly or wholly outside the window.
    pub(super) fn ships_reach_outside(
        &self,
        emitted: u64,
        reception: &Reception,
        ShipWork { weights, .. }: &mut ShipWork,
    ) -> Result<bool, RadarError> {
        let Reception { emission, elapsed_s, offset_s, tx_pol, windows, .. } = *reception;
        let mut spans_s = self.ship_spans_s(emission, elapsed_s, &self.ends).flatten();
        if spans_s.all(|delay_s| windows.iter().all(|window| window.holds(offset_s + delay_s))) {
            return Ok(false);
        }
        weights.clear();
        self.ship_weights(emitted, elapsed_s, weights)?;
        let mut outside = false;
        let scenery = Scenery { centres: &emission.centres, frame: &self.frame, elapsed_s };
        self.ships.visit(&scenery, &self.ends, TAU / self.radar.wavelength_m(), |found| {
            let Echoing { element, pair, path, at, matrix } = found;
            let plan = &self.plans[pair];
            outside |= !reception.window(plan).holds(offset_s + path.delay_s)
                && matrix.is_some()
                && plan.receives(tx_pol)
                && weights[element * self.ends.len() + pair] > 0.0
                && self.passes_horizon_of_ship(plan, emission, at) > 0.0;
            !outside
        });
        Ok(outside)
    }

    /// Appends the panels of ships of one emission.
    pub(super) fn append_ships(
        &self,
        emitted: u64,
        reception: &Reception,
        (ShipWork { weights, of_pairs, .. }, amplitude): (&mut ShipWork, &mut [Complex64]),
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        if self.ships.is_empty() {
            return Ok(());
        }
        weights.clear();
        self.ship_weights(emitted, reception.elapsed_s, weights)?;
        let weight = |element: usize, pair: usize| weights[element * self.pairs.len() + pair];
        self.visit_panels(reception, weight, (of_pairs, amplitude), |of_pairs, amplitude| {
            if amplitude.iter().any(|a| *a != Complex64::ZERO) {
                paths.push(reception.offset_s, of_pairs.iter().map(|p| (p.delay_s, p.delay_rate)), amplitude);
            }
        });
        Ok(())
    }

    /// Hands over the paths of every element, by pair, and its amplitudes, by channel.
    fn visit_panels(
        &self,
        reception: &Reception,
        weight: impl Fn(usize, usize) -> f64,
        (of_pairs, amplitude): (&mut Vec<Path>, &mut [Complex64]),
        mut each: impl FnMut(&[Path], &[Complex64]),
    ) {
        if self.ships.is_empty() {
            return;
        }
        let Reception { emission, elapsed_s, offset_s, tx_pol, .. } = *reception;
        let scenery = Scenery { centres: &emission.centres, frame: &self.frame, elapsed_s };
        self.ships.visit(&scenery, &self.ends, TAU / self.radar.wavelength_m(), |found| {
            let Echoing { element, pair, path, at, matrix } = found;
            if pair == 0 {
                of_pairs.clear();
                amplitude.fill(Complex64::ZERO);
            }
            of_pairs.push(path);
            let plan = &self.plans[pair];
            if let Some(matrix) = matrix.filter(|_| plan.receives(tx_pol)) {
                let range = |leg_s: f64| leg_s * SPEED_OF_LIGHT_MPS;
                let scale = weight(element, pair)
                    * plan.link.scattered(range(path.tx_leg_s), range(path.rx_leg_s))
                    * self.passes_horizon_of_ship(plan, emission, at);
                if scale != 0.0 && reception.window(plan).touches(offset_s + path.delay_s) {
                    self.amplitudes(plan, (&path, None), Some(&matrix), scale, tx_pol, emission, amplitude);
                }
            }
            if pair + 1 == self.ends.len() {
                each(of_pairs, amplitude);
            }
            true
        });
    }

    /// Appends the share of the field of every element and pair that passes what hides it.
    pub(super) fn ship_weights(
        &self,
        index: u64,
        elapsed_s: f64,
        out: &mut Vec<f64>,
    ) -> Result<(), RadarError> {
        let centre = |antenna: usize, time_s: f64| self.antenna_at(antenna, time_s);
        self.ships
            .weights((&self.frame, self.hills.as_deref()), elapsed_s, &self.ends, centre, out)
            .map_err(|failure: TrackFailure| self.track_error(index, failure))
    }
}
