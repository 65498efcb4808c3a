//! Contacts to samples.
//!
//! [`mod@reference`] is written from the equation and judges the rest; [`mod@synth`] is fast. [`Fidelity`] says which one a run
//! takes.

pub mod reference;
pub mod synth;

/// How echoes are made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Fidelity {
    /// Every pulse from its own contacts, in f64, by [`mod@reference`]: slow, and without error of its own.
    #[default]
    Reference,
    /// Blocks of pulses: contacts at nodes, the rest interpolated, all of it in f32 by [`mod@synth`].
    Fast {
        /// Pulses from node to node.
        node_pulses: u64,
        /// Pulses from gain to gain.
        gain_pulses: u64,
        /// Pulses from scattering to scattering: as the nodes, or half or a third of it.
        scatter_pulses: u64,
        /// The knobs of the echo.
        settings: synth::Settings,
    },
}
