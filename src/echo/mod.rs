//! Scatterer paths to samples.
//!
//! [`mod@reference`] is written from the equation, and the rest is compared with it; [`mod@synth`] is fast.
//! [`Fidelity`] selects which one a run takes.

pub mod reference;
pub mod synth;

/// How echoes are made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Fidelity {
    /// Every pulse from its own scatterer paths, in f64, by [`mod@reference`]: slow, and without error of its
    /// own.
    #[default]
    Reference,
    /// By [`mod@synth`], with what was asked; the rest is chosen for the scene.
    Fast(Asked),
}

/// What is asked of the fast echo. Settings that are `None` are chosen so that the error is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Asked {
    /// Error against the reference that is allowed, worst pulse and channel, dB.
    pub error_db: f64,
    /// Pulses from node to node; 1: every pulse by itself, from exact scatterer paths.
    pub node_pulses: Option<u64>,
    /// Pulses from scattering to scattering: as the nodes, or about half or a third of it.
    pub scatter_pulses: Option<u64>,
    /// Pulses from gain to gain.
    pub gain_pulses: Option<u64>,
    /// Pulses from node to node of the panels of ships.
    pub panel_pulses: Option<u64>,
    /// Two-way gain of every antenna pair over its peak below which tiles are evaluated less often, dB.
    pub sidelobe_db: Option<f64>,
    /// Two-way gain of every antenna pair over its peak below which tiles are left out, dB.
    pub cutoff_db: Option<f64>,
    /// Cells that each scatterer path is spread over.
    pub kernel_width: Option<usize>,
    /// Doppler within a pulse.
    pub doppler: Option<synth::doppler::Doppler>,
    /// Which instructions; `None` takes the fastest that this CPU has.
    pub variant: Option<synth::Variant>,
}

impl Asked {
    /// An error and nothing else.
    pub fn error_db(error_db: f64) -> Self {
        Self {
            error_db,
            node_pulses: None,
            scatter_pulses: None,
            gain_pulses: None,
            panel_pulses: None,
            sidelobe_db: None,
            cutoff_db: None,
            kernel_width: None,
            doppler: None,
            variant: None,
        }
    }
}

impl Default for Asked {
    fn default() -> Self {
        Self::error_db(-60.0)
    }
}
