//! The facets of a block of pulses, tile by tile, in f32.
//!
//! What changes slowly is found at few instants, the **nodes** of the block (first to last pulse, up to
//! [`NODES`]). What changes faster has instants of its own:
//!
//! | quantity | at | in between |
//! | --- | --- | --- |
//! | surface, delay and its rate | nodes | cubic Hermite |
//! | directions, slopes | nodes | cubic, to scattering epochs and gain instants |
//! | amplitude without gains and shadows | **scattering epochs**: nodes, and up to two instants between | cubic through four |
//! | product of both antennas' gains | every few pulses | six-point Lagrange, here |
//! | visibility | updates of the shadows | linear, here, as everywhere |
//! | facet turned towards both antennas? | every pulse | the cosine's cubic, here |
//!
//! That is for tiles that are evaluated closely. A **in the sidelobes** one, whose two-way gain stays below
//! what is given for every pair ([`Tiers`]), has nodes at both ends of the block alone, two to four
//! scattering epochs from end to end through which amplitudes and cosines are polynomials, and instants of
//! gain [`sidelobe_gain_pulses`] apart; directions and slopes are straight lines between the ends.
//!
//! So a [`Tile`] has, per pair, delays and rates at the nodes, amplitudes at the scattering epochs, and one
//! **factor** per pulse. The equations are those of the exact scatterer paths of [`super`]; a facet is a lane
//! of [`crate::scattering::lanes`]. The patch is that of the block's first pulse, and kinds of surface are
//! those at each node.
//!
//! **Errors** in f32, beside those of interpolation: directions 6e-8, hence gains `6e-8 pi a/lambda` (-88 dB
//! at `a/lambda` = 133); heights of the surface, of which FFT in f32 leaves some 3e-7 of the rms: a phase of
//! `3e-7 x 2 k cos(theta) x rms`. Antennas of measured pattern have complex gains, which stay with the
//! amplitude.

mod factor;
mod gain;
mod instants;
mod illuminate;
mod epoch;
pub mod runs;
pub mod probe;
mod tile;

use std::ops::RangeInclusive;
use std::sync::Arc;

use num_complex::Complex64;

use super::sea::{SeaFailure, SeaPlan};
pub use super::visibility::{Borders, ShareBorders};
use super::visibility::{MOST_ENDS, Update, Updates};
use super::{PathGenerator, Workspace};
use crate::cpu::Variant;
use crate::frames::{Enu, Point};
use crate::geometry::lanes::{LANES, Row};
use crate::geometry::shadow::Shadow;
use crate::paths::emission::Emission;
use crate::pulse::costs::{Costs, Stage};
use crate::radar::fault::{RadarError, SeaFault};
use crate::radar::window::Window;
use crate::scattering::lanes::Batch;
use crate::scene::Patch;
use crate::sea::facet_surface::FacetSurface;
use crate::sea::surface::fields::Real;
use crate::sea::surface::{Fields, Selection};
use crate::sea::wake::course::Pose;

use epoch::View;
use instants::through;
pub use instants::{
    EPOCH_POINTS, EPOCHS, EPOCHS_PER_NODE, GAIN_POINTS, Instants, NODES, SIDELOBE_NODES, Sidelobe, Tier,
    Tiers, epochs_about, gain_instants, gain_step, gain_weights, nodes_within, sidelobe_gain_pulses,
};
use runs::{Cut, Run};
pub use tile::{CHANNELS_PER_LAYER, Epoch, FEW, Layer, Node, Pair, Tile, lanes_of};

/// Tiles that are evaluated to learn what a block returns.
pub const SAMPLED: usize = 48;

/// Facets of a patch up to which its shadows are those of the reference: on larger ones the heights between
/// nodes do, in f32.
const FEW_FACETS: usize = 1 << 14;

/// Facets met in a block, summed over its pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// In the patch.
    pub facets: u64,
    /// That return anything at all.
    pub illuminated: u64,
    /// Left out because all of them together stay below the budget.
    pub culled: u64,
    /// In tiles that are in the sidelobes.
    pub sidelobe: u64,
}

/// What a sample of the facets says of a block and pair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Mean of the delay rate of those that the window receives, weighted by power.
    pub mean_rate: f64,
    /// Mean power of a facet, all channels of the pair, W.
    pub mean_power_w: f64,
    /// The same without those that the window does not receive.
    pub received_power_w: f64,
}

/// Sea of the nodes at hand, and room for tiles; one per thread.
#[derive(Clone)]
pub struct TileWork {
    variant: Variant,
    sheet: FacetSurface<f32>,
    nodes: Vec<NodeWork>,
    timings: Timings,
    /// Per pair: product of the gains of field below which a tile is in the sidelobes; empty where none is.
    sidelobe_below: Vec<f32>,
    /// Facets of the tile at hand.
    runs: Vec<Run>,
    shades: Vec<Shade>,
    spare: Vec<Shade>,
    maker: Option<Maker>,
    /// `[pulse]`: place of the update before in `shades`, and the share of the next.
    shares: Vec<(usize, f32)>,
    phasors: Phasors,
    batch: Box<Batch>,
    view: Box<View>,
    places_m: [[f64; LANES]; 2],
    /// Least and largest of them.
    bounds_m: [[f64; 2]; 2],
    drop_m: [f64; LANES],
    fall: [Row; 2],
    kinds: Vec<(usize, f32)>,
    /// Whether facets that return nothing stay where they are.
    whole: bool,
    /// Facets of the tile that may return something, by their place in it.
    kept: Vec<u16>,
    /// Slopes at every node.
    slopes: [[Row; 2]; NODES],
    /// `[pair][instant]`.
    gain_rows: Vec<Vec<Row>>,
    /// `[update][antenna]`.
    seen: Vec<Row>,
    tile: Tile,
}

/// When what is found of the tiles of a tier.
#[derive(Clone, Default)]
struct Timing {
    instants: Instants,
    /// Nodes of the block that a tile has.
    nodes: [usize; NODES],
    /// Those in use; more keep their room for the next block.
    gains: Vec<GainInstant>,
    gain_places: Vec<usize>,
    /// `[pulse][gain instant]`: first, and weights from there on.
    lagrange: Vec<(usize, [f32; GAIN_POINTS])>,
    epochs: Vec<EpochInstant>,
    /// Weights of the scattering epochs for the cosines, `[pulse]`: first, and weights from there on.
    cosines: Vec<(usize, [f32; EPOCH_POINTS])>,
}

/// Those of both tiers.
#[derive(Clone, Default)]
struct Timings {
    close: Timing,
    sidelobe: Timing,
}

#[derive(Clone)]
struct NodeWork {
    emission: Emission,
    elapsed_s: f64,
    fields: Fields<f32>,
}

#[derive(Clone)]
struct GainInstant {
    emission: Emission,
    /// Of the nodes.
    weights: [f32; NODES],
}

#[derive(Clone)]
struct EpochInstant {
    emission: Emission,
    /// Of the nodes; a scattering epoch at a node takes that alone.
    weights: [f32; NODES],
    poses: Vec<Pose>,
}

/// Weights of one update of the shadows over the patch.
#[derive(Clone, Default)]
struct Shade {
    /// `[antenna]`; empty where all is illuminated.
    weights: Vec<Vec<f32>>,
}

/// What makes updates of the shadows.
#[derive(Clone)]
enum Maker {
    /// Of few facets: those of the reference, since single ones count.
    Few(Box<Updates<f64>>),
    /// Of a patch that stays, whose heights are known from the nodes, or found anew where these lie too far
    /// away.
    Here { shadow: Box<Shadow<f64>>, update: Box<Update>, heights_m: Vec<f64> },
    /// Of one that moves; heights in f32, as those of the nodes.
    Along(Box<Updates<f32>>, Option<Arc<dyn ShareBorders>>),
}

/// Random phasors of the facets at hand, at their key modulo the patch, and in the order of the patch.
#[derive(Clone)]
struct Phasors {
    keys: Vec<Option<[i64; 2]>>,
    /// `[mechanism][place]`.
    kept: Vec<Vec<[f32; 2]>>,
    first: Option<[i64; 2]>,
    /// `[mechanism][real, imaginary][facet]`.
    ordered: Vec<[Vec<f32>; 2]>,
    found: Vec<Complex64>,
}

impl PathGenerator {
    /// Room for tiles; `None` for a scene without sea. Workers of one run may share the borders of their
    /// blocks.
    pub fn tile_work(
        &self,
        variant: Variant,
        borders: Option<Arc<dyn ShareBorders>>,
    ) -> Option<Box<TileWork>> {
        let sea = self.sea.as_ref()?;
        let channels: Vec<usize> = self.plans.iter().map(|plan| plan.channels.len()).collect();
        let interval_s = self.radar.emissions.interval_s(0, 1);
        sea.tile_work(variant, &channels, interval_s, borders).map(Box::new)
    }

    /// Makes the sea of a block ready: its surface at the nodes, shadows, antennas. Returns what a sample of
    /// its facets says, per pair.
    pub fn open_block(
        &self,
        tiers: &Tiers,
        patch: &Patch,
        workspace: &mut Workspace,
        work: &mut TileWork,
        samples: &mut Vec<Sample>,
    ) -> Result<(), RadarError> {
        samples.clear();
        samples.resize(self.pairs.len(), Sample::default());
        let Some(sea) = &self.sea else { return Ok(()) };
        work.time(self, tiers)?;
        let instants = &tiers.close;
        let first = instants.first;
        let costs = &mut workspace.costs;
        costs.lap(Stage::Record);
        sea.prepare(self, first, patch, work).map_err(|failure| self.sea_error(first, failure))?;
        costs.lap(Stage::Surface);
        work.shade(self, sea, instants, patch, Heights::Exact)
            .map_err(|failure| self.sea_error(first, failure))?;
        costs.lap(Stage::Shadow);
        let opens_s = self.window_start_of(first + (instants.pulses / 2) as u64)?;
        let window = Window::new(&self.radar, opens_s, self.pulse_length_s);
        let mut facets = 0;
        for runs in Cut::of(patch.facets).sample(SAMPLED) {
            facets += work.take(runs);
            self.light_tile(sea, patch, work);
            for (pair, sample) in work.tile.pairs.iter().zip(&mut *samples) {
                pair.add_to(sample, work.tile.count, &window);
            }
        }
        for sample in samples {
            if sample.received_power_w > 0.0 {
                sample.mean_rate /= sample.received_power_w;
            }
            sample.mean_power_w /= facets.max(1) as f64;
            sample.received_power_w /= facets.max(1) as f64;
        }
        costs.lap(Stage::ScattererPaths);
        Ok(())
    }

    /// Hands over the tiles of the block that was opened, facets that return nothing left out, and those
    /// whose power is at every pulse less than `least` of the sample's mean.
    pub fn visit_tiles(
        &self,
        patch: &Patch,
        samples: &[Sample],
        least: f64,
        work: &mut TileWork,
        costs: &mut Costs,
        mut each: impl FnMut(&Tile),
    ) -> Tally {
        let mut tally = Tally::default();
        let Some(sea) = &self.sea else { return tally };
        for runs in Cut::of(patch.facets).tiles() {
            let facets = work.take(runs) as u64;
            tally.facets += facets;
            self.light_tile(sea, patch, work);
            if work.tile.tier == Tier::Sidelobe {
                tally.sidelobe += facets;
            }
            work.tile.thin_out(work.variant, samples, least, &mut tally);
            costs.lap(Stage::ScattererPaths);
            if work.tile.count > 0 {
                each(&work.tile);
                costs.lap(Stage::Spread);
            }
        }
        tally
    }
}

impl SeaPlan {
    fn tile_work(
        &self,
        variant: Variant,
        channels: &[usize],
        interval_s: f64,
        borders: Option<Arc<dyn ShareBorders>>,
    ) -> Option<TileWork> {
        let selection = Selection {
            slopes: true,
            velocity: true,
            displacement: self.displacement,
            vertical_acceleration: false,
            ..Selection::HEIGHT
        };
        // The wakes are legal: the plan was built with them.
        let sheet = FacetSurface::new(&self.surface, selection).with_wakes(&self.wakes, &self.patch).ok()?;
        let maker = match &self.visibility {
            None => None,
            Some(visibility) if self.patch.len() <= FEW_FACETS => {
                let updates = visibility.updates::<f64, SeaFault>(&self.surface, &self.wakes, &self.patch);
                Some(Maker::Few(Box::new(updates.ok()?)))
            }
            Some(visibility) if visibility.margin == 0 => Some(Maker::Here {
                shadow: Box::new(visibility.shadow(&self.patch).ok()?),
                update: Box::new(visibility.empty(&self.patch)),
                heights_m: vec![0.0; self.patch.len()],
            }),
            Some(visibility) => {
                let updates = visibility.updates::<f32, SeaFault>(&self.surface, &self.wakes, &self.patch);
                if let Some(borders) = &borders {
                    borders.with(&mut Borders::join);
                }
                Some(Maker::Along(Box::new(updates.ok()?), borders))
            }
        };
        let facets = self.patch.len();
        let mechanisms = self.scattering.mechanisms();
        let node =
            NodeWork { emission: Emission::default(), elapsed_s: 0.0, fields: sheet.fields(&self.patch) };
        Some(TileWork {
            variant,
            sheet,
            nodes: vec![node; NODES],
            timings: Timings::default(),
            sidelobe_below: Vec::with_capacity(channels.len()),
            runs: Vec::with_capacity(LANES),
            view: View::boxed(),
            shades: Vec::new(),
            spare: Vec::new(),
            maker,
            shares: Vec::new(),
            phasors: Phasors::new(facets, mechanisms),
            batch: Batch::boxed(mechanisms),
            places_m: [[0.0; LANES]; 2],
            bounds_m: [[0.0; 2]; 2],
            drop_m: [0.0; LANES],
            fall: [[0.0; LANES]; 2],
            kinds: Vec::with_capacity(LANES),
            whole: false,
            kept: Vec::with_capacity(LANES),
            slopes: [[[0.0; LANES]; 2]; NODES],
            gain_rows: vec![Vec::new(); channels.len()],
            seen: Vec::new(),
            tile: Tile {
                count: 0,
                tier: Tier::Close,
                instants: Instants::default(),
                interval_s,
                pairs: channels.iter().map(|&channels| Pair::new(channels)).collect(),
            },
        })
    }

    /// The surface and the ships at every node, and phasors of the patch.
    fn prepare(
        &self,
        generator: &PathGenerator,
        first: u64,
        patch: &Patch,
        work: &mut TileWork,
    ) -> Result<(), SeaFailure> {
        let TileWork { sheet, nodes, phasors, .. } = work;
        for node in nodes {
            sheet.evaluate(node.elapsed_s, patch, &mut node.fields)?;
        }
        let elapsed_s = generator.radar.emissions.interval_s(0, first);
        phasors.prepare(self, patch, elapsed_s);
        Ok(())
    }
}

impl Shade {
    fn take_from<T: Real>(&mut self, update: &Update<T>, patch: &Patch) {
        for (antenna, weights) in self.weights.iter_mut().enumerate() {
            weights.clear();
            if !update.sees_all(antenna) {
                update.weights_over(antenna, patch, weights);
            }
        }
    }
}

impl Phasors {
    fn new(facets: usize, mechanisms: usize) -> Self {
        Self {
            keys: vec![None; facets],
            kept: vec![vec![[0.0; 2]; facets]; mechanisms],
            first: None,
            ordered: vec![[vec![0.0; facets], vec![0.0; facets]]; mechanisms],
            found: vec![Complex64::ZERO; mechanisms],
        }
    }

    fn prepare(&mut self, sea: &SeaPlan, patch: &Patch, t_s: f64) {
        if self.first == Some(patch.first) {
            return;
        }
        self.first = Some(patch.first);
        let [nx, ny] = patch.facets;
        for iy in 0..ny {
            let key_y = patch.first[1] + iy as i64;
            let row = key_y.rem_euclid(ny as i64) as usize * nx;
            let first_column = patch.first[0].rem_euclid(nx as i64) as usize;
            for ix in 0..nx {
                let key = [patch.first[0] + ix as i64, key_y];
                let place = row + (first_column + ix) % nx;
                if self.keys[place] != Some(key) {
                    self.keys[place] = Some(key);
                    sea.scattering.phasors(key, t_s, &mut self.found);
                    for (column, phasor) in self.kept.iter_mut().zip(&self.found) {
                        column[place] = [phasor.re as f32, phasor.im as f32];
                    }
                }
                let index = iy * nx + ix;
                for (ordered, kept) in self.ordered.iter_mut().zip(&self.kept) {
                    ordered[0][index] = kept[place][0];
                    ordered[1][index] = kept[place][1];
                }
            }
        }
    }
}

impl Timings {
    fn of(&self, tier: Tier) -> &Timing {
        match tier {
            Tier::Close => &self.close,
            Tier::Sidelobe => &self.sidelobe,
        }
    }
}

impl Timing {
    /// For instants whose nodes are among those of the block at `places`.
    fn set(&mut self, of: &PathGenerator, instants: &Instants, places: &[usize]) -> Result<(), RadarError> {
        let own = &instants.nodes[..instants.node_count];
        self.instants = *instants;
        for (to, node) in self.nodes.iter_mut().zip(own) {
            *to = places.iter().position(|place| place == node).unwrap_or(0);
        }
        self.gain_places.clear();
        self.gain_places.extend(gain_instants(instants.pulses, instants.gain_pulses));
        for (n, &place) in self.gain_places.iter().enumerate() {
            let weights = through(own, place);
            if n == self.gains.len() {
                self.gains.push(GainInstant { emission: Emission::default(), weights });
            }
            let gain = &mut self.gains[n];
            gain.weights = weights;
            of.evaluate(instants.first + place as u64, &mut gain.emission)?;
        }
        let epochs = &instants.epochs[..instants.epoch_count];
        for (n, &place) in epochs.iter().enumerate() {
            let weights = through(own, place);
            if n == self.epochs.len() {
                self.epochs.push(EpochInstant { emission: Emission::default(), weights, poses: Vec::new() });
            }
            let epoch = &mut self.epochs[n];
            epoch.weights = weights;
            of.evaluate(instants.first + place as u64, &mut epoch.emission)?;
            if let Some(sea) = &of.sea {
                let elapsed_s = of.radar.emissions.interval_s(0, instants.first + place as u64);
                sea.scattering.poses(elapsed_s, &mut epoch.poses);
            }
        }
        self.lagrange.clear();
        self.cosines.clear();
        for pulse in 0..instants.pulses {
            self.lagrange.push(gain_weights(&self.gain_places, pulse));
            let first = epochs_about(epochs, pulse..=pulse);
            let points = EPOCH_POINTS.min(epochs.len());
            self.cosines.push((first, through(&epochs[first..first + points], pulse)));
        }
        Ok(())
    }

    /// Gain instants that a pulse's gain is found from.
    fn gain_points(&self) -> usize {
        GAIN_POINTS.min(self.gain_places.len())
    }
}

impl TileWork {
    /// Facets of the tile to be illuminated; returns how many.
    fn take(&mut self, runs: impl Iterator<Item = Run>) -> usize {
        self.runs.clear();
        self.runs.extend(runs);
        self.runs.iter().map(|run| run.count).sum()
    }

    /// Emissions of nodes, scattering epochs and gain instants, and the weights of interpolation.
    fn time(&mut self, of: &PathGenerator, tiers: &Tiers) -> Result<(), RadarError> {
        let close = &tiers.close;
        let places = &close.nodes[..close.node_count];
        self.nodes.truncate(places.len().max(1));
        while self.nodes.len() < places.len() {
            let last = self.nodes[0].clone();
            self.nodes.push(last);
        }
        for (node, &place) in self.nodes.iter_mut().zip(places) {
            of.evaluate(close.first + place as u64, &mut node.emission)?;
            node.elapsed_s = of.radar.emissions.interval_s(0, close.first + place as u64);
        }
        self.timings.close.set(of, close, places)?;
        self.sidelobe_below.clear();
        if let Some(sidelobe) = &tiers.sidelobe {
            self.timings.sidelobe.set(of, sidelobe, places)?;
            let share = 10f64.powf(tiers.below_db / 20.0);
            self.sidelobe_below.extend((0..of.plans.len()).map(|pair| (share * of.peak_gain(pair)) as f32));
        }
        let Timings { close: at_close, sidelobe: at_sidelobe } = &self.timings;
        let instants_of_gain = at_close.gain_places.len().max(at_sidelobe.gain_places.len());
        for rows in &mut self.gain_rows {
            rows.resize(instants_of_gain.max(rows.len()), [0.0; LANES]);
        }
        for pair in &mut self.tile.pairs {
            pair.resize(
                places.len(),
                close.epoch_count.max(tiers.of(Tier::Sidelobe).epoch_count),
                close.pulses,
            );
        }
        Ok(())
    }

    /// Weights of the shadows at every update about the block.
    fn shade(
        &mut self,
        of: &PathGenerator,
        sea: &SeaPlan,
        instants: &Instants,
        patch: &Patch,
        heights: Heights,
    ) -> Result<(), SeaFailure> {
        self.shares.clear();
        let (Some(visibility), Some(maker)) = (&sea.visibility, &mut self.maker) else {
            self.shades.clear();
            self.shares.resize(instants.pulses, (0, 0.0));
            return Ok(());
        };
        let emissions = &of.radar.emissions;
        let at = |pulse: usize| visibility.share(emissions.interval_s(0, instants.first + pulse as u64));
        let span = span_of(at(0), at(instants.pulses - 1));
        let (lowest, highest) = (*span.start(), *span.end());
        let count = (highest - lowest + 1) as usize;
        // Those not in use keep their room for the next block.
        while self.shades.len() > count {
            self.spare.extend(self.shades.pop());
        }
        // Another block as long may have more updates: room for them is made with the first one.
        let lasts_s = emissions.interval_s(instants.first, instants.first + instants.pulses as u64 - 1);
        let most = visibility.most_updates(lasts_s).max(count);
        self.shades.reserve(most.saturating_sub(self.shades.len()));
        self.spare.reserve(most.saturating_sub(self.spare.len()));
        self.seen.reserve((most * visibility.ends).saturating_sub(self.seen.len()));
        while self.shades.len() + self.spare.len() < most {
            let room = || Vec::with_capacity(patch.len());
            self.spare.push(Shade { weights: std::iter::repeat_with(room).take(visibility.ends).collect() });
        }
        while self.shades.len() < count {
            self.shades.push(self.spare.pop().unwrap_or_default());
        }
        let earth = of.frame.earth();
        let lower = |[x, y]: [f64; 2]| earth.drop_m(x, y);
        // Of the first pulse, which is a node and a gain instant.
        let Some(GainInstant { emission, .. }) = self.timings.close.gains.first() else { return Ok(()) };
        let lighting = of.lighting(instants.first, instants.first, emission, Window::UNBOUNDED);
        for (shade, number) in self.shades.iter_mut().zip(span) {
            shade.weights.resize_with(visibility.ends, Vec::new);
            match maker {
                Maker::Few(updates) => {
                    let scenery =
                        |elapsed_s: f64, places: &mut [Point<Enu>]| sea.scenery(&lighting, elapsed_s, places);
                    shade.take_from(visibility.update(updates, number, scenery, lower)?, patch);
                }
                Maker::Here { shadow, update, heights_m } => {
                    let time_s = visibility.time_s(number);
                    let mut places = [Point::new(0.0, 0.0, 0.0); MOST_ENDS];
                    let places = &mut places[..visibility.ends];
                    sea.scenery(&lighting, time_s, places)?;
                    if is_near(&self.nodes, time_s) {
                        rise(&self.nodes, time_s, heights_m);
                    } else if heights == Heights::Near {
                        rise(&self.nodes[..1], time_s, heights_m);
                    } else {
                        // Few blocks need it: the room of a node does, which is made ready again.
                        let NodeWork { elapsed_s, fields, .. } = &mut self.nodes[0];
                        self.sheet.evaluate(time_s, patch, fields)?;
                        let from = fields.height_m.iter().copied().map(f64::from);
                        heights_m.iter_mut().zip(from).for_each(|(to, from)| *to = from);
                        self.sheet.evaluate(*elapsed_s, patch, fields)?;
                    }
                    visibility
                        .weigh_heights::<SeaFailure>(shadow, patch, heights_m, places, lower, update)?;
                    shade.take_from(update, patch);
                }
                Maker::Along(updates, borders) => {
                    let at_border = number < lowest + Borders::COMMON || number + Borders::COMMON > highest;
                    let borders = borders.as_deref().filter(|_| at_border);
                    let mut found = false;
                    if let Some(borders) = borders {
                        borders.with(&mut |kept| {
                            found = kept.find(number).map(|own| shade.take_from(own, patch)).is_some();
                        });
                    }
                    if found {
                        continue;
                    }
                    let scenery =
                        |elapsed_s: f64, places: &mut [Point<Enu>]| sea.scenery(&lighting, elapsed_s, places);
                    let update = visibility.update(updates, number, scenery, lower)?;
                    shade.take_from(update, patch);
                    if let Some(borders) = borders {
                        borders.with(&mut |kept| kept.keep(update));
                    }
                }
            }
        }
        for pulse in 0..instants.pulses {
            let (number, share) = at(pulse);
            self.shares.push(((number - lowest) as usize, share as f32));
        }
        Ok(())
    }
}

/// How heights are found that lie beyond the nodes.
#[derive(Clone, Copy, PartialEq)]
enum Heights {
    /// As at the nodes.
    Exact,
    /// On straight lines from the first node: for an estimate.
    Near,
}

/// Whether the nodes tell the heights at a time: from one interval before the first to one after the last.
fn is_near(nodes: &[NodeWork], time_s: f64) -> bool {
    let times_s = |n: usize| nodes[n.min(nodes.len() - 1)].elapsed_s;
    let last = nodes.len().saturating_sub(1);
    let [first_s, last_s] = [times_s(0), times_s(last)];
    let (before_s, after_s) = (times_s(1) - first_s, last_s - times_s(last.saturating_sub(1)));
    (first_s - before_s..=last_s + after_s).contains(&time_s)
}

/// Heights at a time by the Hermite cubic of the two nodes about it, or nearest to it, m. One interval beyond
/// the last node the waves of the shortest periods lose some 1e-6 m.
fn rise(nodes: &[NodeWork], time_s: f64, out: &mut [f64]) {
    let after = nodes.iter().position(|node| node.elapsed_s >= time_s).unwrap_or(nodes.len() - 1);
    let (first, second) = (&nodes[after.max(1) - 1], &nodes[after.max(1).min(nodes.len() - 1)]);
    let span_s = second.elapsed_s - first.elapsed_s;
    let from = time_s - first.elapsed_s;
    let s = if span_s > 0.0 { from / span_s } else { 0.0 };
    // Weights of both heights and both speeds; one node alone: a straight line.
    let (w, v) = if span_s > 0.0 {
        let (s2, s3) = (s * s, s * s * s);
        ([1.0 - 3.0 * s2 + 2.0 * s3, 3.0 * s2 - 2.0 * s3], [(s - 2.0 * s2 + s3) * span_s, (s3 - s2) * span_s])
    } else {
        ([1.0, 0.0], [from, 0.0])
    };
    let first = first.fields.height_m.iter().zip(&first.fields.velocity_mps[2]);
    let second = second.fields.height_m.iter().zip(&second.fields.velocity_mps[2]);
    for (out, ((z0, v0), (z1, v1))) in out.iter_mut().zip(first.zip(second)) {
        let [z0, v0, z1, v1] = [*z0, *v0, *z1, *v1].map(f64::from);
        *out = w[0] * z0 + w[1] * z1 + v[0] * v0 + v[1] * v1;
    }
}

fn span_of((first, _): (u64, f64), (last, share): (u64, f64)) -> RangeInclusive<u64> {
    first..=if share > 0.0 { last + 1 } else { last }
}
