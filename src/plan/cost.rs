//! What settings cost: how often each piece of work is done in a pulse, times what it takes.
//!
//! | piece | how often in a pulse |
//! | --- | --- |
//! | surface | facets x 4 nodes / block |
//! | shadow | facets x antennas x updates in a block / block |
//! | path | facets x pairs x 4 / block |
//! | look | facets x pairs x looks / block |
//! | combine | facets x channels x looks / block |
//! | gain | facets x pairs x gain instants / block |
//! | factor | facets x pairs |
//! | fill | contacts kept x 3 / block |
//! | spread | contacts kept x (1 + w cells of each channel's layer) |
//! | transform | channels x M log2 M |
//!
//! Blocks of a single pulse take the way of the reference's contacts, which has a price of its own. Everything is spent by one worker:
//! `n` workers make `n` times as many pulses, less what they wait for each other's memory.

use crate::echo::synth::Settings;
use crate::echo::synth::{Precision, doppler::Doppler};
use crate::radar::illumination::Illumination;
use crate::radar::illumination::tiles::NODES;
use crate::radar::illumination::tiles::sounding::gain_instants;
use crate::radar::waveform::Waveform;
use crate::scene::Scene;

use super::settle::Settled;

/// Pieces of work.
pub const PIECES: usize = 11;

/// Names of the pieces.
pub const NAMES: [&str; PIECES] = [
    "surface", "shadow", "path", "look", "combine", "gain", "factor", "fill", "spread", "transform", "exact",
];

/// How often each piece of work is done in a pulse, in the order of [`NAMES`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work(pub [f64; PIECES]);

/// What each piece takes, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prices(pub [f64; PIECES]);

impl Prices {
    /// Of a common machine: one core of a 2.5 GHz Xeon with AVX-512.
    pub const TABLE: Self =
        Self([55e-9, 40e-9, 8e-9, 45e-9, 6e-9, 9e-9, 1.2e-9, 14e-9, 1.3e-9, 1.5e-9, 1000e-9]);

    /// Seconds of one worker for a pulse.
    pub fn seconds(&self, work: &Work) -> f64 {
        self.0.iter().zip(work.0).map(|(price, count)| price * count).sum()
    }
}

/// Sizes of a scene that decide about cost.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    facets: f64,
    pairs: f64,
    channels: f64,
    antennas: f64,
    /// From update to update of the shadows, pulses; `None` without shadows.
    update_pulses: Option<f64>,
    cells: f64,
    layers: f64,
    pulses: u64,
}

impl Size {
    /// Of a scene, its echo with some settings.
    pub fn of(scene: &Scene, illumination: &Illumination, settings: &Settings, waveform: &dyn Waveform) -> Self {
        let radar = &scene.radar;
        let shadow = scene.sea.as_ref().and_then(|sea| sea.shadow.as_ref());
        let reach = radar.window.samples + waveform.span_samples(radar.sample_rate_hz) + 64;
        let moments = if settings.doppler == Doppler::Taylor { 2.0 } else { 1.0 };
        Self {
            facets: illumination.facets() as f64,
            pairs: illumination.pairs().len() as f64,
            channels: radar.channels.len() as f64,
            antennas: (radar.transmitters.len() + radar.receivers.len()) as f64,
            update_pulses: shadow.map(|shadow| shadow.update_s * radar.emissions.mean_prf_hz()),
            cells: reach as f64 * settings.oversampling,
            layers: moments,
            pulses: scene.pulses,
        }
    }

    /// What settings ask for in a pulse; `interpolates`: in blocks.
    pub fn work(&self, settled: &Settled, interpolates: bool) -> Work {
        let Self { facets, pairs, channels, antennas, update_pulses, cells, layers, .. } = *self;
        let width = settled.echo.width as f64;
        let wide = if settled.precision == Precision::Double { 2.0 } else { 1.0 };
        let spread = facets * pairs * layers * (4.0 + width * channels / pairs.max(1.0)) * wide;
        let transform = channels * layers * cells * cells.max(2.0).log2() * wide;
        let block = settled.block_pulses().min(self.pulses.max(1));
        if !interpolates || block <= 1 || settled.node_pulses <= 1 {
            let mut work = [0.0; PIECES];
            let shadow = update_pulses.map_or(0.0, |pulses| facets * antennas / pulses.max(1.0));
            (work[1], work[8], work[9], work[10]) = (shadow, spread, transform, facets * pairs);
            return Work(work);
        }
        let pulses = block as f64;
        let per_block = |times: f64| facets * times / pulses;
        let updates = update_pulses.map_or(0.0, |update| (pulses - 1.0) / update.max(1e-9) + 1.5);
        let looks = (3 * settled.looks_per_node + 1) as f64;
        let instants = gain_instants(block as usize, settled.gain_pulses as usize).len() as f64;
        let nodes = NODES as f64;
        Work([
            per_block(nodes),
            per_block(updates * antennas),
            per_block(nodes * pairs),
            per_block(looks * pairs),
            per_block(looks * channels),
            per_block(instants * pairs),
            facets * pairs,
            per_block(3.0 * pairs),
            spread,
            transform,
            0.0,
        ])
    }
}
