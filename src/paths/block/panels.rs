//! Panels of ships through some pulses of a block.
//!
//! Those that are seen at any of the pulses are evaluated at the nodes, without the gains of their antennas:
//! what is left turns with the panel alone. Gains are found at every pulse, from directions that are
//! interpolated between the nodes, as those of facets are, and multiply the amplitude together with the share
//! that is not hidden. Gains that are complex stay with the amplitude.

use std::ops::Range;

use super::gain::{Gains, Sighted};
use super::instants::{NODES, through};
use super::slow_time::SlowTime;
use super::tile::Node;
use crate::cpu::Variant;
use crate::geometry::lanes::{LANES, Paths, Row};
use crate::paths::PathGenerator;
use crate::paths::emission::Emission;
use crate::paths::list::ScattererPaths;
use crate::paths::ships::mesh::{MeshWork, With};
use crate::radar::fault::RadarError;
use crate::radar::polarisation::Axes;

/// Buffers for the panels of a block, and what multiplies their amplitudes; one per thread.
#[derive(Clone)]
pub struct PanelWork {
    mesh: MeshWork,
    /// When the pulses are.
    slow: SlowTime,
    /// At the nodes.
    emissions: Vec<Emission>,
    own: Emission,
    /// `[pulse][antenna]`: axes, and their change in a second.
    axes: Vec<(Axes, Axes)>,
    /// Panels that are seen.
    seen: Vec<u32>,
    /// `[pair][node]`: directions.
    directions: Vec<Vec<Node>>,
    /// Gains, and what is seen at both time samples about a pulse.
    rows: Box<[Row; 3]>,
    /// `[pair]`: what multiplies the amplitudes, `[pulse][path]`.
    factors: Vec<Vec<f32>>,
}

impl PanelWork {
    /// What multiplies the amplitudes of a pair, `[pulse][path]`.
    pub fn factors(&self, pair: usize) -> &[f32] {
        &self.factors[pair]
    }
}

impl PathGenerator {
    /// Room for the panels of so many pulses; `None` where no ship echoes by its mesh.
    pub fn panel_work(&self, variant: Variant, pulses: usize) -> Option<Box<PanelWork>> {
        if self.ships.is_empty() {
            return None;
        }
        let (pairs, antennas) = (self.pairs.len(), self.antennas.len());
        let directions = || (0..NODES).map(|_| Node { paths: Paths::boxed() }).collect();
        Some(Box::new(PanelWork {
            mesh: MeshWork::new(variant),
            slow: SlowTime::default(),
            emissions: vec![Emission::default(); NODES],
            own: Emission::default(),
            axes: Vec::with_capacity(pulses * antennas),
            seen: Vec::with_capacity(self.ships.len()),
            directions: (0..pairs).map(|_| directions()).collect(),
            rows: Box::new([[0.0; LANES]; 3]),
            factors: (0..pairs).map(|_| Vec::with_capacity(pulses * self.ships.len())).collect(),
        }))
    }

    /// Paths of the panels that are seen at some pulses, at nodes among these (counted from the first), and
    /// what multiplies them at each pulse.
    ///
    /// # Errors
    /// Pulses that the tracks do not cover.
    pub fn panels(
        &self,
        pulses: Range<u64>,
        at: &[usize],
        work: &mut PanelWork,
        nodes: &mut [ScattererPaths],
    ) -> Result<(), RadarError> {
        let PanelWork { mesh, slow, emissions, own, axes, seen, factors, .. } = work;
        self.slow_time(pulses.start, (pulses.end - pulses.start) as usize, slow);
        nodes.iter_mut().for_each(ScattererPaths::clear);
        self.see_ships(pulses.clone(), &mut mesh.sight)?;
        mesh.sight.seen(seen);
        axes.clear();
        for index in pulses.clone() {
            self.evaluate(index, own)?;
            axes.extend((0..self.antennas.len()).map(|antenna| self.axes_of(own, antenna)));
        }
        for (emission, place) in emissions.iter_mut().zip(at) {
            self.evaluate(pulses.start + *place as u64, emission)?;
        }
        let count = axes.len() / self.antennas.len().max(1);
        for factors in factors.iter_mut() {
            factors.clear();
            factors.resize(count * seen.len(), 0.0);
        }
        for chunk in 0..seen.len().div_ceil(LANES) {
            let part = &work.seen[chunk * LANES..work.seen.len().min((chunk + 1) * LANES)];
            for (node, (emission, place)) in work.emissions.iter().zip(at).enumerate() {
                let index = pulses.start + *place as u64;
                let reception = self.reception_of_all(index, emission, &[]);
                let (mesh, paths) = (&mut work.mesh, &mut nodes[node]);
                self.append_panels(
                    &reception,
                    part,
                    With::ComplexGains,
                    mesh,
                    paths,
                    |pair, batch, before| {
                        let Paths { delay_s, incident, scattered, .. } =
                            &mut *work.directions[pair][node].paths;
                        delay_s[before..before + batch.count].copy_from_slice(&batch.delay_s[..batch.count]);
                        let to = incident.iter_mut().chain(scattered);
                        for (to, from) in to.zip(batch.incident.iter().chain(&batch.scattered)) {
                            let to = &mut to[before..before + batch.count];
                            to.iter_mut().zip(from).for_each(|(to, from)| *to = *from as f32);
                        }
                    },
                );
            }
            for pair in 0..self.plans.len() {
                self.weigh_panels(pair, at, (chunk * LANES, count), work);
            }
        }
        Ok(())
    }

    /// Factors over a pair of the panels from the first of a chunk on, at so many pulses.
    fn weigh_panels(&self, pair: usize, at: &[usize], (first, pulses): (usize, usize), work: &mut PanelWork) {
        let PanelWork { mesh, slow, axes, seen, directions, rows, factors, .. } = work;
        let part = &seen[first..seen.len().min(first + LANES)];
        let (count, antennas) = (part.len(), self.antennas.len());
        let plan = &self.plans[pair];
        let ends = plan.ends(self.radar.transmitters.len());
        let nodes = &directions[pair][..at.len()];
        let [gains, before, after] = &mut **rows;
        let mut held = usize::MAX;
        for pulse in 0..pulses {
            let (knot, share) = mesh.sight.about(pulse);
            if held != knot {
                held = knot;
                for (n, element) in part.iter().enumerate() {
                    before[n] = mesh.sight.sees(knot, pair, *element) as f32;
                    after[n] = mesh.sight.sees(knot + 1, pair, *element) as f32;
                }
            }
            let ends = ends.map(|antenna| {
                let (axes, change_per_s) = axes[pulse * antennas + antenna];
                Sighted { antenna: &self.antennas[antenna], axes, change_per_s }
            });
            let weights: [f32; NODES] = through(at, pulse, slow);
            Gains { count, ends, nodes, weights: &weights, out: gains }.find(mesh.variant);
            let to = &mut factors[pair][pulse * seen.len() + first..][..count];
            let seen = gains.iter().zip(&*before).zip(&*after);
            for (to, ((gain, before), after)) in to.iter_mut().zip(seen) {
                *to = gain * (before + share as f32 * (after - before));
            }
        }
    }
}
