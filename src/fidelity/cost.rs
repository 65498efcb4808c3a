//! What settings cost: how often each piece of work is done in a pulse, times what it takes.
//!
//! | piece | how often in a pulse | stage |
//! | --- | --- | --- |
//! | surface | facets x 4 nodes / block | surface |
//! | shadow | facets x antennas x updates in a block / block | shadow |
//! | path | facets x pairs x 4 / block, and those of the block's sample once more | scatterer paths |
//! | epoch | facets x pairs x scattering epochs / block, likewise | scatterer paths |
//! | combine | facets x channels x scattering epochs / block, likewise | scatterer paths |
//! | gain | facets x pairs x gain epochs / block, likewise | scatterer paths |
//! | factor | facets x pairs, likewise | scatterer paths |
//! | fill | scatterer paths kept x 3 / block | spread |
//! | spread | scatterer paths kept x (4 + w cells of each channel) x emissions that a window receives | spread |
//! | transform | channels x M log2 M | transform |
//! | exact | facets x pairs, where every pulse is by itself | scatterer paths |
//! | rest | channels x 2N log2 2N | record, receive |
//! | points | targets, direct paths, and panels of ships, breakers, rain and far sea as far as they cost as much, x pairs | fill, spread |
//! | lines | facets x pairs, and as many as `LINES` in a block, where Bragg waves travel | scatterer paths |
//!
//! Wake tiles have scattering epochs of their own. Sidelobe tiles have 2 nodes, 2 or 3 scattering epochs and
//! fewer gain epochs; the gains of all tiles are found there first, to sort them. A block of a single pulse
//! takes the way of the reference's scatterer paths. Everything is spent by one worker: `n` workers make `n`
//! times as many pulses, as far as they do not wait for each other's memory.

use crate::echo::synth::{Precision, Settings};
use crate::paths::PathGenerator;
use crate::paths::block::{
    NODES, SIDELOBE_NODES, gain_instants, gain_step, sampled_tiles, sidelobe_gain_pulses,
};
use crate::pulse::costs::Stage;
use crate::radar::waveform::Waveform;
use crate::scene::sea::{BraggWaves, FacetScattering, Modulation, Waves};
use crate::scene::{Scene, Sea};

use crate::fidelity::echo_settings::EchoSettings;

/// What a scatterer of a breaking wave takes over a point, of a stretch and by itself, and a point that
/// stands for rain, for which boxes are split on the way to it.
const BREAKER: f64 = 0.015;
const BREAKER_EXACT: f64 = 0.2;
const DROP: f64 = 8.0;
/// What a cell of the far sea takes over a point, of a stretch and by itself.
const FAR_CELL: f64 = 0.05;
const FAR_CELL_EXACT: f64 = 1.0;
/// What a panel of a ship takes over a point at every pulse, at a node, and by itself.
const PANEL: f64 = 0.006;
const PANEL_AT_NODE: f64 = 0.03;
const PANEL_EXACT: f64 = 0.2;
/// Pulses for which turning a facet costs as much as finding its lines and components.
const LINES: f64 = 20.0;
/// The same of finding phasors one by one.
const LINES_EXACT: f64 = 300.0;
/// Pieces of work.
pub const PIECES: usize = 14;

/// How often each piece of work is done in a pulse, in the order of [`CostTable::STAGES`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work(pub [f64; PIECES]);

impl Work {
    /// Whether pulses are made one by one, from exact scatterer paths.
    pub fn is_one_by_one(&self) -> bool {
        self.0[10] > 0.0
    }
}

/// What each piece takes, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostTable(pub [f64; PIECES]);

impl CostTable {
    /// Of a common machine: one core with AVX-512, found from profiles of `mars-1` and `mars-4`.
    pub const TABLE: Self = Self([
        50e-9, 6e-9, 20e-9, 21e-9, 0.8e-9, 1.4e-9, 0.35e-9, 7.5e-9, 0.17e-9, 0.05e-9, 800e-9, 0.1e-9, 5e-6,
        2e-9,
    ]);

    /// Stage in which each piece is spent.
    pub const STAGES: [Stage; PIECES] = [
        Stage::Surface,        // surface
        Stage::Shadow,         // shadow
        Stage::ScattererPaths, // path
        Stage::ScattererPaths, // epoch
        Stage::ScattererPaths, // combine
        Stage::ScattererPaths, // gain
        Stage::ScattererPaths, // factor
        Stage::Spread,         // fill
        Stage::Spread,         // spread
        Stage::Transform,      // transform
        Stage::ScattererPaths, // exact
        Stage::Receive,        // rest
        Stage::Spread,         // points
        Stage::ScattererPaths, // lines
    ];

    /// Seconds of one worker in a stage for a pulse.
    pub fn stage_seconds(&self, work: &Work, stage: Stage) -> f64 {
        let pieces = self.0.iter().zip(work.0).zip(Self::STAGES);
        pieces.filter(|(_, own)| *own == stage).map(|((cost, count), _)| cost * count).sum()
    }

    /// The same with all pieces of a stage dearer by a factor.
    pub fn scaled(mut self, stage: Stage, factor: f64) -> Self {
        for (cost, own) in self.0.iter_mut().zip(Self::STAGES) {
            if own == stage {
                *cost *= factor;
            }
        }
        self
    }

    /// Seconds of one worker for a pulse.
    pub fn seconds(&self, work: &Work) -> f64 {
        self.0.iter().zip(work.0).map(|(cost, count)| cost * count).sum()
    }
}

/// Sizes of a scene that decide about cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    facets: f64,
    points: f64,
    /// Scatterers of breaking waves that are alive.
    breakers: f64,
    /// Cells of the far sea at a pulse.
    far_cells: f64,
    /// Whether they are found by stretches: all gains are real.
    stretches: bool,
    /// Panels and double bounces of ships.
    panels: f64,
    pairs: f64,
    /// Pairs for which facets have lines of travelling waves.
    travelling: f64,
    /// Work of a surface over that of one that modulates nothing.
    surface: f64,
    channels: f64,
    antennas: f64,
    /// From update to update of the shadows, pulses; `None` without shadows.
    update_pulses: Option<f64>,
    /// Pulses for which a patch that follows is held: blocks divide them, and share the updates between them.
    hold_pulses: Option<u64>,
    /// Whether it is a patch that is held.
    holds_patch: bool,
    cells: f64,
    /// Twice the samples of a transform, which set the cost of the rest.
    samples: f64,
    layers: f64,
    /// Share of the facets that is spread.
    kept: f64,
    /// How often facets are handed over.
    parts: f64,
    /// How often they are illuminated, for the sample of a block too.
    again: f64,
    /// Emissions that a window receives, each of them spread.
    received: f64,
    /// Share of the channels that an emission fills.
    filled: f64,
    pulses: u64,
}

impl Size {
    /// Of a scene, its echo with some settings, of whose facets a share is spread.
    pub fn of(
        scene: &Scene,
        generator: &PathGenerator,
        settings: &Settings,
        waveform: &dyn Waveform,
        kept: f64,
    ) -> Self {
        let radar = &scene.radar;
        let shadow = scene.sea.as_ref().and_then(|sea| sea.shadow.as_ref());
        let frozen = |sea: &Sea| {
            let FacetScattering { bragg, decorrelation_s, .. } = &sea.scattering;
            *bragg == BraggWaves::Frozen && decorrelation_s.is_none()
        };
        let (parts, shares) = (generator.parts_of_tiles() as f64, generator.shares_of_pulses());
        let modulates = |sea: &Sea| sea.scattering.modulation != Modulation::Off;
        let [modulates, choppy] =
            [modulates, |sea: &Sea| sea.waves == Waves::Choppy].map(|of| scene.sea.as_ref().is_some_and(of));
        let pairs = generator.pairs().len() as f64;
        let reach =
            radar.window.samples + waveform.span_samples(radar.sample_rate_hz) + 2 * settings.guard_samples;
        let sampled = generator.sampled(sampled_tiles(generator.facets(), generator.scans()));
        let moments = if settings.doppler.has_moments() { 2.0 } else { 1.0 };
        Self {
            facets: generator.facets() as f64,
            breakers: generator.breakers_alive(),
            far_cells: generator.far_cells().map_or(0.0, |(cells, _)| cells),
            stretches: generator.gains_are_real(),
            // Those with an aspect are evaluated for it once more.
            panels: generator.ship_paths() as f64,
            points: generator.target_count() as f64 * if generator.follows_aspects() { 2.0 } else { 1.0 }
                + DROP * generator.drops(),
            pairs,
            travelling: if scene.sea.as_ref().is_none_or(frozen) { 0.0 } else { pairs },
            // Two transforms instead of four, for either.
            surface: 1.0 + [modulates, choppy].map(|of| if of { 0.5 } else { 0.0 }).iter().sum::<f64>(),
            channels: radar.channels.len() as f64,
            antennas: (radar.transmitters.len() + radar.receivers.len()) as f64,
            update_pulses: shadow.map(|shadow| shadow.update_s * radar.emissions.mean_prf_hz()),
            hold_pulses: generator.hold_pulses(),
            holds_patch: generator.holds_patch(),
            cells: reach as f64 * settings.oversampling,
            samples: 2.0 * reach as f64,
            layers: moments,
            kept,
            parts,
            again: parts + sampled,
            received: generator.emissions_received().max(1) as f64,
            filled: shares.iter().sum::<f64>() / shares.len().max(1) as f64,
            pulses: scene.pulses,
        }
    }

    /// The same with so many times the facets, the area and the interval of shadows.
    pub fn scaled(self, [facets, area, update]: [f64; 3]) -> Self {
        let update_pulses = self.update_pulses.map(|pulses| update * pulses);
        Self { facets: facets * self.facets, breakers: area * self.breakers, update_pulses, ..self }
    }

    /// Emissions that a window receives, at most.
    pub fn emissions_received(&self) -> u64 {
        self.received as u64
    }

    /// What is spread in a pulse, by a kernel of a width, and what is transformed.
    fn of_grids(&self, width: usize, amplitude: f64) -> [f64; 2] {
        let Self { facets, pairs, channels, cells, layers, kept, received, filled, .. } = *self;
        let of_path = amplitude + width as f64 * filled * channels / pairs.max(1.0);
        let spread = received * kept * facets * pairs * layers * of_path;
        [spread, filled * channels * layers * cells * cells.max(2.0).log2()]
    }

    /// Seconds of a common machine in which a pulse is spread and transformed.
    pub fn grid_seconds(&self, width: usize) -> [f64; 2] {
        let [spread, transform] = self.of_grids(width, 4.0);
        let CostTable(each) = CostTable::TABLE;
        [each[8] * spread, each[9] * transform]
    }

    /// What settings ask for in a pulse; `interpolates`: in blocks.
    pub fn work(&self, chosen: &EchoSettings, interpolates: bool) -> Work {
        let Self {
            facets,
            points,
            breakers,
            far_cells,
            panels,
            pairs,
            travelling,
            surface,
            channels,
            antennas,
            update_pulses,
            samples,
            kept,
            parts,
            again,
            received,
            ..
        } = *self;
        let wide = if chosen.precision == Precision::Double { 2.0 } else { 1.0 };
        let (sidelobe, beyond) = (chosen.sidelobe_share, chosen.beyond_share.min(chosen.sidelobe_share));
        // Amplitudes through two scattering epochs are straight lines.
        let straight = chosen.sidelobe.is_some_and(|sidelobe| sidelobe.epochs <= 2);
        let amplitude = if straight { 4.0 - 2.0 * sidelobe } else { 4.0 };
        let [spread, transform] = self.of_grids(chosen.echo.width, amplitude).map(|work| wide * work);
        let rest = channels * samples * samples.max(2.0).log2();
        let block = chosen.block_pulses(self.hold_pulses).min(self.pulses.max(1));
        if !interpolates || block <= 1 || chosen.node_pulses <= 1 {
            let mut work = [0.0; PIECES];
            let shadow = update_pulses.map_or(0.0, |pulses| facets * antennas / pulses.max(1.0));
            (work[1], work[8], work[9], work[10]) = (shadow, spread, transform, received * facets * pairs);
            let points =
                points + PANEL_EXACT * panels + BREAKER_EXACT * breakers + FAR_CELL_EXACT * far_cells;
            (work[11], work[12], work[13]) = (rest, points * pairs, LINES_EXACT * facets * travelling);
            return Work(work);
        }
        let pulses = block as f64;
        let per_block = |times: f64| facets * times / pulses;
        let ends = if self.holds_patch { 1.0 } else { 1.5 * update_pulses.unwrap_or(0.0) };
        let updates = update_pulses.map_or(0.0, |update| (pulses - 1.0 + ends) / update.max(1e-9));
        let of_wakes = chosen.wake_epochs.map_or(0.0, |_| chosen.wake_share);
        let of_block = |epochs: usize| (3 * epochs + 1) as f64;
        let epochs = (1.0 - of_wakes) * of_block(chosen.epochs_per_node)
            + of_wakes * of_block(chosen.wake_epochs.unwrap_or(0));
        let step = gain_step(block as usize, chosen.gain_pulses as usize);
        let step_of_sidelobe = gain_step(block as usize, sidelobe_gain_pulses(step));
        let [instants, of_sidelobe] =
            [step, step_of_sidelobe].map(|step| gain_instants(block as usize, step).count() as f64);
        // Of all tiles, to find the sidelobe tiles.
        let sorted = if chosen.sidelobe.is_some() { of_sidelobe } else { 0.0 };
        let either = |close: f64, few: f64| (1.0 - sidelobe) * close + (sidelobe - beyond) * few;
        let few_epochs = chosen.sidelobe.map_or(0.0, |sidelobe| sidelobe.epochs as f64);
        let [nodes, few] = [NODES, SIDELOBE_NODES].map(|n| n as f64);
        let stretches = (pulses / (3 * chosen.panel_pulses.unwrap_or(1) + 1) as f64).ceil();
        let [each_breaker, each_cell] =
            if self.stretches { [BREAKER, FAR_CELL] } else { [BREAKER_EXACT, FAR_CELL_EXACT] };
        let of_panel = PANEL + PANEL_AT_NODE * (nodes * stretches / pulses).min(1.0);
        Work([
            per_block(nodes * surface * if chosen.fine.surface { 2.0 } else { 1.0 }),
            per_block(updates * antennas),
            per_block(again * (either(nodes, few) + beyond * few) * pairs),
            per_block(again * either(epochs, few_epochs) * pairs),
            per_block(again * either(epochs, few_epochs) * channels),
            per_block(again * (either(instants, 0.0) + sorted) * pairs),
            again * facets * (1.0 - beyond) * pairs,
            per_block(parts * either(3.0, 1.0).min(3.0 * kept) * pairs),
            parts * spread,
            transform,
            0.0,
            rest,
            (points + panels * of_panel + each_breaker * breakers + each_cell * far_cells) * pairs,
            again * facets * travelling * (1.0 + LINES / pulses),
        ])
    }
}
