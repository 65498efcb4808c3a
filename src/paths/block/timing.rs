//! The emissions at which the tiles of a block are evaluated, and the weights of what lies between.

use super::instants::{
    EPOCH_POINTS, GAIN_POINTS, Instants, NODES, Tier, epochs_about, gain_instants, gain_weights, left_at,
    through,
};
use super::slow_time::SlowTime;
use crate::paths::PathGenerator;
use crate::paths::emission::Emission;
use crate::radar::fault::RadarError;
use crate::sea::wake::course::Pose;

/// When what is found of the tiles of a tier.
#[derive(Clone, Default)]
pub(super) struct Timing {
    pub instants: Instants,
    /// Nodes of the block that a tile has.
    pub nodes: [usize; NODES],
    /// Those in use; more keep their room for the next block.
    pub gains: Vec<GainInstant>,
    pub gain_places: Vec<usize>,
    /// `[pulse][gain instant]`: first, and weights from there on.
    pub lagrange: Vec<(usize, [f32; GAIN_POINTS])>,
    pub epochs: Vec<EpochInstant>,
    /// Weights of the scattering epochs for the cosines, `[pulse]`: first, and weights from there on.
    pub cosines: Vec<(usize, [f32; EPOCH_POINTS])>,
    /// By pulse, what a polynomial through the nodes leaves ([`left_at`]).
    pub left: Vec<(usize, f32)>,
}

/// Those of all tiers.
#[derive(Clone, Default)]
pub(super) struct Timings {
    pub mainlobe: Timing,
    pub sidelobe: Timing,
    pub wake: Timing,
}

#[derive(Clone)]
pub(super) struct GainInstant {
    pub emission: Emission,
    /// Of the nodes.
    pub weights: [f32; NODES],
}

#[derive(Clone)]
pub(super) struct EpochInstant {
    pub emission: Emission,
    /// Of the nodes; a scattering epoch at a node takes that alone.
    pub weights: [f32; NODES],
    pub poses: Vec<Pose>,
}

impl Timings {
    pub fn of(&self, tier: Tier) -> &Timing {
        match tier {
            Tier::Mainlobe => &self.mainlobe,
            Tier::Sidelobe => &self.sidelobe,
            Tier::Wake => &self.wake,
        }
    }
}

impl Timing {
    /// For instants whose nodes are among those of the block at `places`.
    pub fn set(
        &mut self,
        of: &PathGenerator,
        instants: &Instants,
        places: &[usize],
        slow: &SlowTime,
    ) -> Result<(), RadarError> {
        let own = &instants.nodes[..instants.node_count];
        self.instants = *instants;
        for (to, node) in self.nodes.iter_mut().zip(own) {
            *to = places.iter().position(|place| place == node).unwrap_or(0);
        }
        self.gain_places.clear();
        self.gain_places.extend(gain_instants(instants.pulses, instants.gain_pulses));
        for (n, &place) in self.gain_places.iter().enumerate() {
            let weights = through(own, place, slow);
            if n == self.gains.len() {
                self.gains.push(GainInstant { emission: Emission::default(), weights });
            }
            let gain = &mut self.gains[n];
            gain.weights = weights;
            of.evaluate(instants.first + place as u64, &mut gain.emission)?;
        }
        let epochs = &instants.epochs[..instants.epoch_count];
        for (n, &place) in epochs.iter().enumerate() {
            let weights = through(own, place, slow);
            if n == self.epochs.len() {
                self.epochs.push(EpochInstant { emission: Emission::default(), weights, poses: Vec::new() });
            }
            let epoch = &mut self.epochs[n];
            epoch.weights = weights;
            of.evaluate(instants.first + place as u64, &mut epoch.emission)?;
            if let Some(sea) = &of.sea {
                let elapsed_s = of.radar.emissions.elapsed_s(instants.first + place as u64);
                sea.scattering.poses(elapsed_s, &mut epoch.poses);
            }
        }
        self.lagrange.clear();
        self.cosines.clear();
        self.left.clear();
        for pulse in 0..instants.pulses {
            self.lagrange.push(gain_weights(&self.gain_places, pulse, slow));
            let first = epochs_about(epochs, pulse..=pulse);
            let points = EPOCH_POINTS.min(epochs.len());
            self.left.push(left_at(own, pulse, slow));
            self.cosines.push((first, through(&epochs[first..first + points], pulse, slow)));
        }
        Ok(())
    }

    /// Gain instants that a pulse's gain is found from.
    pub fn gain_points(&self) -> usize {
        GAIN_POINTS.min(self.gain_places.len())
    }
}
