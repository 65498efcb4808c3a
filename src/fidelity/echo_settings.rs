//! Settings of the fast echo: what is chosen for a requested error.

use crate::echo::synth::{Precision, Settings};
use crate::paths::block::{NODES, Sidelobe};

/// What the fast echo is set to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EchoSettings {
    /// Pulses from node to node; 1: every pulse by itself.
    pub node_pulses: u64,
    /// Scattering epochs from node to node.
    pub epochs_per_node: usize,
    /// Pulses from gain to gain.
    pub gain_pulses: u64,
    /// Pulses from node to node of the panels of ships; `None` where none echo by their mesh.
    pub panel_pulses: Option<u64>,
    /// Tiles that are evaluated less often, if any are.
    pub sidelobe: Option<Sidelobe>,
    /// Share of the facets in sidelobe tiles, mean over the run.
    pub sidelobe_share: f64,
    /// Share of its power that a tile may lack where it is evaluated at some pulses alone, its supports;
    /// `None`: at every pulse.
    pub between: Option<f64>,
    /// Power of a facet over the mean below which it is left out.
    pub least_power: f64,
    /// Word length.
    pub precision: Precision,
    /// The settings of the echo.
    pub echo: Settings,
}

impl EchoSettings {
    /// Pulses of a block, where a patch that follows is held for some pulses.
    pub fn block_pulses(&self, hold_pulses: Option<u64>) -> u64 {
        if self.precision == Precision::Double { 1 } else { block_length(self.node_pulses, hold_pulses) }
    }

    /// Pulses from one scattering epoch to the next.
    pub fn scatter_pulses(&self) -> u64 {
        self.node_pulses.div_ceil(self.epochs_per_node.max(1) as u64)
    }
}

/// Pulses of a block whose nodes are so many pulses apart.
pub fn block_pulses(spacing: u64) -> u64 {
    (NODES as u64 - 1).saturating_mul(spacing.max(1)).saturating_add(1)
}

/// Pulses of a block whose nodes are about so many pulses apart, where a patch that follows is held for some
/// pulses: a divisor of these.
pub fn block_length(spacing: u64, hold_pulses: Option<u64>) -> u64 {
    let length = if spacing <= 1 { 1 } else { block_pulses(spacing) };
    hold_pulses.map_or(length, |hold| (1..=length).rev().find(|n| hold % n == 0).unwrap_or(1))
}
