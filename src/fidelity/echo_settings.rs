//! Settings of the fast echo: what is chosen for a requested error.

use super::sidelobe::NONE_DB;
use crate::echo::synth::{Precision, Settings};
use crate::paths::block::{Fine, Least, NODES, Sidelobe};

/// What the fast echo is set to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EchoSettings {
    /// Pulses from node to node; 1: every pulse by itself.
    pub node_pulses: u64,
    /// Emissions that a block needs beyond as many as it has pulses.
    pub overlap_pulses: u64,
    /// Scattering epochs from node to node.
    pub epochs_per_node: usize,
    /// The same in wake tiles, if there may be any.
    pub wake_epochs: Option<usize>,
    /// Share of the facets in these.
    pub wake_share: f64,
    /// Pulses from gain to gain.
    pub gain_pulses: u64,
    /// Pulses from node to node of the panels of ships; `None` where none echo by their mesh.
    pub panel_pulses: Option<u64>,
    /// Tiles that are evaluated less often, if any are.
    pub sidelobe: Option<Sidelobe>,
    /// Share of the facets in sidelobe tiles, mean over the run, and in those beyond the beams, left out.
    pub sidelobe_share: f64,
    pub beyond_share: f64,
    /// Share of its power that a tile may lack where it is evaluated at some pulses alone, its supports;
    /// `None`: at every pulse.
    pub between: Option<f64>,
    /// Power over the mean of a facet below which one is left out, or a part of one.
    pub least_power: Least,
    /// Share of the power of the echo above which a facet that turns away is decided at its pulse.
    pub turning: f64,
    /// Word length.
    pub precision: Precision,
    /// What is found as the reference finds it.
    pub fine: Fine,
    /// The settings of the echo.
    pub echo: Settings,
}

impl EchoSettings {
    /// Pulses of a block, where a patch that follows is held for some pulses.
    pub fn block_pulses(&self, hold_pulses: Option<u64>) -> u64 {
        if self.precision == Precision::Double {
            1
        } else {
            block_length(self.node_pulses, self.overlap_pulses, hold_pulses)
        }
    }

    /// Two-way gain below which tiles are left out, if any are, dB.
    pub fn cutoff_db(&self) -> Option<f64> {
        self.sidelobe.map(|sidelobe| sidelobe.cutoff_db).filter(|cutoff_db| *cutoff_db > NONE_DB)
    }

    /// Pulses from one scattering epoch to the next.
    pub fn scatter_pulses(&self) -> u64 {
        self.node_pulses.div_ceil(self.epochs_per_node.max(1) as u64)
    }

    /// Pulses from one scattering epoch to the next in wake tiles, if there may be any.
    pub fn wake_scatter_pulses(&self) -> Option<u64> {
        self.wake_epochs.map(|epochs| self.node_pulses.div_ceil(epochs.max(1) as u64))
    }
}

/// Pulses of a block whose nodes are so many pulses apart.
pub fn block_pulses(spacing: u64) -> u64 {
    (NODES as u64 - 1).saturating_mul(spacing.max(1)).saturating_add(1)
}

/// Pulses of a block whose nodes are about so many pulses apart and that needs `overlap` emissions beyond as
/// many, where a patch that follows is held for some pulses: a divisor of these.
pub fn block_length(spacing: u64, overlap: u64, hold_pulses: Option<u64>) -> u64 {
    if spacing <= 1 {
        return 1;
    }
    let emissions = block_pulses(spacing);
    let length = emissions.saturating_sub(overlap).max(1);
    match hold_pulses {
        // Emissions of before the patch moved on have nodes of their own.
        Some(hold) if hold <= emissions => hold,
        Some(hold) => (1..=length).rev().find(|n| hold % n == 0).unwrap_or(1),
        None => length,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_shorter_by_the_emissions_that_they_need_beyond_their_pulses() {
        assert_eq!([1, 2, 21].map(|spacing| block_length(spacing, 0, None)), [1, 7, 64]);
        assert_eq!([1, 2, 21].map(|spacing| block_length(spacing, 3, None)), [1, 4, 61]);
        assert_eq!(block_length(2, 9, None), 1);
        // Of a patch that stays no longer than a block, emissions of before it moved on are apart.
        assert_eq!([64, 40].map(|hold| block_length(21, 3, Some(hold))), [64, 40]);
        assert_eq!(
            [(128, 0), (128, 3), (126, 1)].map(|(hold, n)| block_length(21, n, Some(hold))),
            [64, 32, 63]
        );
    }
}
