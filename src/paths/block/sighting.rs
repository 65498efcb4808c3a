//! Where the facets of a tile lie, and how much the antennas look at them: its tier, or that it is left out.

use super::TileWork;
use super::epoch::Solve;
use super::gain::{Gains, Sighted};
use super::instants::Tier;
use super::runs::Gather;
use crate::frames::Vector;
use crate::geometry::lanes::{End, LANES};
use crate::paths::PathGenerator;
use crate::paths::sea::SeaPlan;

impl TileWork {
    /// The tile at hand is of a tier.
    fn choose(&mut self, tier: Tier) {
        let instants = self.timings.of(tier).instants;
        (self.tile.tier, self.tile.instants) = (tier, instants);
        for pair in &mut self.tile.pairs {
            (pair.node_count, pair.epoch_count) = (instants.node_count, instants.epoch_count);
        }
    }
}

impl PathGenerator {
    /// Paths and gains: at the few instants of a sidelobe tile first, where tiles may be in the sidelobes,
    /// and at all where this one is not. `false` of a tile beyond the beams.
    pub(super) fn sight(&self, sea: &SeaPlan, work: &mut TileWork) -> bool {
        let mut ends_known = false;
        let mut tier = Tier::Mainlobe;
        if !work.sidelobe_below.is_empty() {
            work.choose(Tier::Sidelobe);
            for place in 0..work.timings.sidelobe.instants.node_count {
                self.find_paths(place, work);
            }
            let [in_sidelobes, beyond] = self.beyond_the_beams(work);
            if beyond {
                return false;
            }
            if self.is_wake(sea, work) {
                tier = Tier::Wake;
            } else if in_sidelobes {
                return true;
            }
            // The last node of all is known by now.
            let (second, last) = (
                work.timings.sidelobe.instants.node_count - 1,
                work.timings.mainlobe.instants.node_count - 1,
            );
            work.slopes.swap(second, last);
            if !work.strains.is_empty() {
                work.strains.swap(second, last);
            }
            if !work.areas.is_empty() {
                work.areas.swap(second, last);
            }
            work.tile.pairs.iter_mut().for_each(|pair| pair.nodes.swap(second, last));
            ends_known = true;
        }
        work.choose(tier);
        let nodes = work.timings.mainlobe.instants.node_count;
        for place in if ends_known { 1..nodes - 1 } else { 0..nodes } {
            self.find_paths(place, work);
        }
        if !ends_known && self.is_wake(sea, work) {
            work.choose(Tier::Wake);
        }
        for pair in 0..self.plans.len() {
            self.gains(pair, f32::INFINITY, work);
        }
        true
    }

    /// Whether the gains of every pair are those of a sidelobe tile, and of one that is left out.
    fn beyond_the_beams(&self, work: &mut TileWork) -> [bool; 2] {
        let mut both = [true; 2];
        for pair in 0..self.plans.len() {
            let Some(&below) = work.sidelobe_below.get(pair) else { return [false; 2] };
            let limit = below[0].max(below[1]);
            let largest = self.gains(pair, limit, work);
            both = [0, 1].map(|n| both[n] && largest < below[n]);
            if both == [false; 2] {
                break;
            }
        }
        both
    }

    /// Largest product of the gains of field of a pair, without antennas whose gains stay with the amplitude.
    pub(super) fn peak_gain(&self, pair: usize) -> f64 {
        let of = &self.plans[pair].pair;
        let ahead = Vector::from_raw(glam::DVec3::X);
        [of.transmitter, self.radar.transmitters.len() + of.receiver]
            .iter()
            .map(|antenna| &self.antennas[*antenna])
            .filter(|antenna| antenna.is_real())
            .map(|antenna| antenna.field_gain(ahead).re.abs())
            .product()
    }

    /// Slopes at a node of the tile, and places and paths over every pair.
    fn find_paths(&self, place: usize, work: &mut TileWork) {
        let of_block = work.timing().nodes[place];
        let TileWork { variant, nodes, runs, places_m, drop_m, fall, slopes, strains, areas, tile, .. } =
            work;
        let node = &nodes[of_block];
        let fields = &node.fields;
        for ((slope, from), fall) in slopes[place].iter_mut().zip(&fields.slope).zip(&*fall) {
            variant.run(Gather { runs, from, to: slope });
            slope.iter_mut().zip(fall).for_each(|(slope, fall)| *slope -= fall);
        }
        for (strain, from) in strains.get_mut(place).into_iter().flatten().zip(&fields.modulation) {
            variant.run(Gather { runs, from, to: strain });
        }
        if let Some(area) = areas.get_mut(place) {
            variant.run(Gather { runs, from: &fields.area, to: area });
        }
        let displaced = !fields.displacement_m[0].is_empty();
        let mut rise_m = [0.0f32; LANES];
        for (pair, plan) in tile.pairs.iter_mut().zip(&self.plans) {
            let paths = &mut *pair.nodes[place].paths;
            for (axis, places_m) in places_m.iter().enumerate() {
                paths.position_m[axis] = *places_m;
                if displaced {
                    variant.run(Gather { runs, from: &fields.displacement_m[axis], to: &mut rise_m });
                    for (to, from) in paths.position_m[axis].iter_mut().zip(&rise_m) {
                        *to += f64::from(*from);
                    }
                    variant.run(Gather {
                        runs,
                        from: &fields.velocity_mps[axis],
                        to: &mut paths.velocity_mps[axis],
                    });
                } else {
                    paths.velocity_mps[axis].fill(0.0);
                }
            }
            variant.run(Gather { runs, from: &fields.height_m, to: &mut rise_m });
            for (to, (from, drop_m)) in paths.position_m[2].iter_mut().zip(rise_m.iter().zip(&*drop_m)) {
                *to = f64::from(*from) - drop_m;
            }
            variant.run(Gather { runs, from: &fields.velocity_mps[2], to: &mut paths.velocity_mps[2] });
            let centres = &node.emission.centres;
            let rx = self.radar.transmitters.len() + plan.pair.receiver;
            let ends = [End::from(&centres[plan.pair.transmitter]), End::from(&centres[rx])];
            variant.run(Solve { count: tile.count, ends, paths });
        }
    }

    /// Products of gains at every gain instant, or up to the first at which one is not below a limit; returns
    /// the largest where there is a limit.
    fn gains(&self, pair: usize, limit: f32, work: &mut TileWork) -> f32 {
        let TileWork { variant, timings, gain_rows, tile, .. } = work;
        let timing = timings.of(tile.tier);
        let plan = &self.plans[pair];
        let [tx, rx] = plan.ends(self.radar.transmitters.len());
        let in_use = timing.gain_places.len();
        let mut largest = 0.0f32;
        for (instant, out) in timing.gains[..in_use].iter().zip(&mut gain_rows[pair]) {
            let now = |antenna: usize| {
                let (axes, change_per_s) = self.axes_of(&instant.emission, antenna);
                Sighted { antenna: &self.antennas[antenna], axes, change_per_s }
            };
            let (nodes, weights, count) = (tile.pairs[pair].nodes(), &instant.weights, tile.count);
            Gains { count, ends: [now(tx), now(rx)], nodes, weights, out }.find(*variant);
            if limit < f32::INFINITY {
                largest = out[..count].iter().fold(largest, |most, gain| most.max(gain.abs()));
                if largest >= limit {
                    break;
                }
            }
        }
        largest
    }
}
