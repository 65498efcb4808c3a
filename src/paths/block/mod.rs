//! The facets of a block of pulses, tile by tile, in f32.
//!
//! What changes slowly is found at few instants, the **nodes** of the block (first to last pulse, up to
//! [`NODES`]). What changes faster has instants of its own:
//!
//! | quantity | at | in between |
//! | --- | --- | --- |
//! | surface, delay and its rate | nodes | cubic Hermite |
//! | directions, slopes, modulation | nodes | cubic, to scattering epochs and gain instants |
//! | amplitude without gains and shadows | **scattering epochs**: nodes, and up to two instants between | cubic through four |
//! | product of both antennas' gains | every few pulses | six-point Lagrange, here |
//! | visibility | updates of the shadows | linear, here, as everywhere |
//! | facet turned towards both antennas? | every pulse | the cosine's cubic, here |
//!
//! That is for **mainlobe** tiles. A **wake** tile, which short waves of a ship may cross, has more
//! scattering epochs between nodes ([`WAKE_EPOCHS`]), and from each to the next a cubic of its own. A
//! **sidelobe** tile, whose two-way gain stays below what is given for every pair ([`Tiers`]), has nodes at
//! both ends of the block alone, two to four scattering epochs from end to end through which amplitudes and
//! cosines are polynomials, and instants of gain [`sidelobe_gain_pulses`] apart; directions and slopes are
//! straight lines between the ends.
//!
//! So a [`Tile`] has, per pair, delays and rates at the nodes, amplitudes at the scattering epochs, and one
//! **factor** per pulse. The equations are those of the exact scatterer paths of [`super`]; a facet is a lane
//! of [`crate::scattering::lanes`]. The patch is that of the block's first pulse, and kinds of surface are
//! those at each node.
//!
//! **Errors** in f32, on top of those of interpolation: directions 6e-8, hence gains `6e-8 pi a/lambda` (-88
//! dB at `a/lambda` = 133); heights of the surface, of which FFT in f32 leaves some 3e-7 of the rms: a phase
//! of `3e-7 x 2 k cos(theta) x rms`. Antennas of measured pattern have complex gains, which stay with the
//! amplitude.
//!
//! **Words** of this module and of `echo::synth`:
//!
//! | word | meaning |
//! | --- | --- |
//! | run | up to 16 facets of a row, one after the other in memory ([`runs`]); elsewhere that of the program |
//! | place | index: of a facet in its tile, of a node in a block, of a path on the delay grid (in cells) |
//! | share | a fraction; in `echo::synth::grid` the pulses of a block that one thread takes |
//! | tier | mainlobe, sidelobe or wake tile |
//! | part, mechanism | the Bragg or the specular part of the scattering, each turned by a phasor of its own |
//! | bin | a frequency of a transform |

mod bandwidth;
mod factor;
mod gain;
mod instants;
mod illuminate;
mod epoch;
mod forgetting;
mod panels;
mod phasors;
pub mod runs;
pub mod probe;
mod shadows;
mod sighting;
mod slow_time;
mod supports;
mod surface;
mod tile;
mod timing;
mod turning;
mod travelling;
mod wake;

use std::sync::Arc;

use super::sea::{SeaFailure, SeaPlan};
pub use super::visibility::{Borders, ShareBorders};
use super::{PairPlan, PathGenerator, Workspace};
use crate::cpu::Variant;
use crate::geometry::lanes::{LANES, Row};
use crate::paths::emission::Emission;
use crate::pulse::costs::{Costs, Stage};
use crate::radar::fault::RadarError;
use crate::scattering::bragg::block as bragg_block;
use crate::scattering::lanes::{Batch, LandRows};
use crate::scene::Patch;
use crate::sea::surface::{Fields, Selection};

pub(in crate::paths) use epoch::{OnRays, OntoPorts, Scale, View};
use forgetting::Forgetting;
pub use forgetting::{FACET_BYTES as FORGETTING_BYTES, ROOM_BYTES as FORGETTING_ROOM_BYTES};
pub(in crate::paths) use gain::Sight;
pub use instants::{
    EPOCH_POINTS, EPOCHS, EPOCHS_PER_NODE, GAIN_POINTS, Instants, NODES, Piece, SIDELOBE_NODES, Sidelobe,
    Tier, Tiers, WAKE_EPOCHS, epochs_about, gain_instants, gain_step, gain_weights, nodes_within,
    sidelobe_gain_pulses,
};
pub use panels::PanelWork;
use phasors::Phasors;
use runs::{Cut, Run};
use shadows::{Heights, Maker, ShadowWeights};
pub use slow_time::SlowTime;
pub use supports::{Supports, TAPS};
use surface::NodeSurface;
use tile::compact;
pub use tile::{Epoch, FEW, Layer, Node, Pair, TURNED_LANES, Tile, lanes_of, layers_of};
use timing::Timings;
use travelling::Part;
use turning::Turning;

/// Tiles of a patch of so many facets that are evaluated to learn what a block returns: one in five, as far
/// as that is from 8 to 24. Narrow beams of antennas that scan need more to be met.
pub fn sampled_tiles(facets: usize, scans: bool) -> usize {
    if scans { 48 } else { (facets / (5 * LANES)).clamp(8, 24) }
}

/// What is found as the reference finds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fine {
    /// The surface at nodes: in f64, and rounded at the end.
    pub surface: bool,
    /// Shadows of few facets: from heights that are found anew.
    pub shadows: bool,
}

/// Facets met in a block, summed over its pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// In the patch.
    pub facets: u64,
    /// That return anything at all.
    pub illuminated: u64,
    /// Left out because all of them together stay below the budget.
    pub culled: u64,
    /// In sidelobe tiles.
    pub sidelobe: u64,
    /// In tiles beyond the beams, which are left out.
    pub beyond: u64,
}

/// Power over the mean of a facet below which something is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Least {
    /// A facet.
    pub facet: f64,
    /// A part of one, of those in which it is handed over: its Bragg waves, its specular points. A facet may
    /// return much although one of these is weak.
    pub part: f64,
}

/// What a sample of the facets shows of a block and pair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Mean of the delay rate of those that the window receives, weighted by power.
    pub mean_rate: f64,
    /// Mean power of a facet, all channels of the pair, as the window receives it, W.
    pub received_power_w: f64,
}

/// Sea of the nodes at hand, and room for tiles; one per thread.
#[derive(Clone)]
pub struct TileWork {
    variant: Variant,
    facet_surface: NodeSurface,
    nodes: Vec<NodeWork>,
    timings: Timings,
    /// Per pair: products of the gains of field below which a tile is in the sidelobes, and below which it is
    /// left out; empty where none is.
    sidelobe_below: Vec<[f32; 2]>,
    /// Whether tiles that short waves of ships may cross have scattering epochs of their own.
    wakes: bool,
    /// Facets of the tile at hand.
    runs: Vec<Run>,
    shadow_updates: Vec<ShadowWeights>,
    spare: Vec<ShadowWeights>,
    maker: Option<Maker>,
    /// `[pulse]`: place of the update before in `shadow_updates`, and the share of the next.
    shares: Vec<(usize, f32)>,
    phasors: Phasors,
    batch: Box<Batch>,
    view: Box<View>,
    places_m: [[f64; LANES]; 2],
    /// Global keys of the facets.
    keys: [[i64; 2]; LANES],
    /// What the tile at hand is of, where waves travel.
    part: Part,
    /// Waves of facets that forget their phases.
    forgetting: Forgetting,
    /// Land of the tile at hand.
    land: Box<LandRows>,
    /// Phasors of a group of facets, where waves travel.
    turns: Vec<bragg_block::Phasors>,
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
    /// Modulation at every node; empty without one.
    strains: Vec<[Row; 3]>,
    /// Areas at every node over those of the grid; empty where they are alike.
    areas: Vec<Row>,
    /// `[pair][instant]`.
    gain_rows: Vec<Vec<Row>>,
    turning: Turning,
    /// `[update][antenna]`, and whether any facet of the tile may be hidden.
    seen: Vec<Row>,
    dims: Vec<bool>,
    tile: Tile,
}

#[derive(Clone)]
struct NodeWork {
    emission: Emission,
    elapsed_s: f64,
    fields: Fields<f32>,
}

impl PathGenerator {
    /// Room for tiles; `None` for a scene without sea. Workers of one run may share the borders of their
    /// blocks.
    pub fn tile_work(
        &self,
        variant: Variant,
        borders: Option<Arc<dyn ShareBorders>>,
        fine: Fine,
    ) -> Option<Box<TileWork>> {
        let sea = self.sea.as_ref()?;
        let interval_s = self.radar.emissions.mean_pri_s();
        sea.tile_work(variant, &self.groups_of_pairs(), interval_s, borders, fine).map(Box::new)
    }

    /// Groups of the channels of every pair, by their transmit polarisation.
    pub(in crate::paths) fn groups_of_pairs(&self) -> Vec<Vec<u8>> {
        let of = &self.radar.tx_polarisation;
        let groups = |plan: &PairPlan| plan.channels.iter().map(|(_, tx, _)| of.group(Some(*tx))).collect();
        self.plans.iter().map(groups).collect()
    }

    /// Makes the sea of a block ready: its surface at the nodes, shadows, antennas. Returns what a sample of
    /// its facets shows, per pair.
    ///
    /// # Errors
    /// Tracks that do not cover the block; a sea or shadows that cannot be found at its nodes.
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
        let instants = &tiers.mainlobe;
        let first = instants.first;
        let costs = &mut workspace.costs;
        costs.lap(Stage::Record);
        sea.prepare(patch, work).map_err(|failure| self.sea_error(first, failure))?;
        costs.lap(Stage::Surface);
        work.weigh_shadows(self, sea, instants, patch, Heights::Exact)
            .map_err(|failure| self.sea_error(first, failure))?;
        costs.lap(Stage::Shadow);
        let hearing = &mut workspace.hearing;
        self.hearing_in(first + (instants.pulses / 2) as u64, hearing)?;
        let mut facets = 0;
        work.part = Part::Still;
        // Runs of a sample lie too far apart for that.
        let wakes = std::mem::take(&mut work.wakes);
        for runs in Cut::of(patch.facets).sample(sampled_tiles(patch.len(), self.scans())) {
            facets += work.take(runs);
            self.evaluate_tile(sea, patch, work);
            for (number, (pair, sample)) in work.tile.pairs.iter().zip(&mut *samples).enumerate() {
                pair.add_to(sample, work.tile.count, |delay_s| hearing.share(number, delay_s));
            }
        }
        work.wakes = wakes;
        for sample in samples {
            if sample.received_power_w > 0.0 {
                sample.mean_rate /= sample.received_power_w;
            }
            sample.received_power_w /= facets.max(1) as f64;
        }
        costs.lap(Stage::ScattererPaths);
        Ok(())
    }

    /// Hands over the tiles of the block that was opened, facets that return nothing left out, and those
    /// whose power is at every pulse less than so much of the sample's mean.
    pub fn visit_tiles(
        &self,
        patch: &Patch,
        samples: &[Sample],
        least: Least,
        work: &mut TileWork,
        costs: &mut Costs,
        mut each: impl FnMut(&Tile),
    ) -> Tally {
        let mut tally = Tally::default();
        let Some(sea) = &self.sea else { return tally };
        let mut again = Tally::default();
        work.turning.set_least(samples.iter().map(|sample| sample.received_power_w), patch.len());
        for runs in Cut::of(patch.facets).tiles(self.recedes_northward(patch, work)) {
            let facets = work.take(runs) as u64;
            tally.facets += facets;
            let (mut part, mut tally) = (Some(sea.first_part()), &mut tally);
            while let Some(own) = part {
                work.part = own;
                if !self.evaluate_tile(sea, patch, work) {
                    tally.beyond += facets;
                    break;
                }
                part = sea.part_after(own, || work.tile.reflects((samples, least.part)));
                let is_whole = own == sea.first_part() && part.is_none();
                if work.tile.tier == Tier::Sidelobe {
                    tally.sidelobe += facets;
                }
                work.thin_out((samples, if is_whole { least.facet } else { least.part }), tally);
                // What is left out need not be turned.
                (0..self.plans.len()).for_each(|pair| self.turn(sea, pair, work));
                costs.lap(Stage::ScattererPaths);
                if work.tile.count > 0 {
                    each(&work.tile);
                    costs.lap(Stage::Spread);
                }
                tally = &mut again;
            }
        }
        work.part = Part::Still;
        work.turning.rest();
        tally
    }
}

impl PathGenerator {
    /// Whether delays grow more to the North than to the East in the middle of a patch: tiles one after the
    /// other to the East then lie in the same cells, which stay in the cache.
    fn recedes_northward(&self, patch: &Patch, work: &TileWork) -> bool {
        let (Some(plan), Some(node)) = (self.plans.first(), work.nodes.first()) else { return false };
        let middle = [0, 1].map(|i| patch.facet_m * (patch.first[i] as f64 + 0.5 * patch.facets[i] as f64));
        let from = |end: usize| {
            let centre = node.emission.centres[end].position.raw();
            let away = (middle[0] - centre.x, middle[1] - centre.y);
            let distance_m = away.0.hypot(away.1).hypot(centre.z).max(f64::MIN_POSITIVE);
            [away.0 / distance_m, away.1 / distance_m]
        };
        let [a, b] = plan.ends(self.radar.transmitters.len()).map(from);
        (a[1] + b[1]).abs() > (a[0] + b[0]).abs()
    }
}

impl SeaPlan {
    fn tile_work(
        &self,
        variant: Variant,
        channels: &[Vec<u8>],
        interval_s: f64,
        borders: Option<Arc<dyn ShareBorders>>,
        fine: Fine,
    ) -> Option<TileWork> {
        let selection = Selection {
            slopes: true,
            velocity: true,
            displacement: self.displacement,
            vertical_acceleration: false,
            modulation: self.lanes.is_modulated(),
            ..Selection::HEIGHT
        };
        // The wakes are legal: the plan was built with them.
        let facet_surface = NodeSurface::of(self, selection, fine.surface)?;
        let maker = Maker::of(self, borders, fine.shadows)?;
        let facets = self.patch.len();
        let mechanisms = self.scattering.mechanisms();
        let node = NodeWork {
            emission: Emission::default(),
            elapsed_s: 0.0,
            fields: facet_surface.fields(&self.patch),
        };
        Some(TileWork {
            variant,
            facet_surface,
            nodes: vec![node; NODES],
            timings: Timings::default(),
            sidelobe_below: Vec::with_capacity(channels.len()),
            wakes: false,
            runs: Vec::with_capacity(LANES),
            view: View::boxed(),
            shadow_updates: Vec::new(),
            spare: Vec::new(),
            maker,
            shares: Vec::new(),
            phasors: Phasors::new(facets, mechanisms),
            batch: Batch::boxed(mechanisms),
            places_m: [[0.0; LANES]; 2],
            keys: [[0; 2]; LANES],
            part: Part::Still,
            forgetting: Forgetting::default(),
            land: LandRows::boxed(),
            turns: Vec::new(),
            bounds_m: [[0.0; 2]; 2],
            drop_m: [0.0; LANES],
            fall: [[0.0; LANES]; 2],
            kinds: Vec::with_capacity(LANES),
            whole: false,
            kept: Vec::with_capacity(LANES),
            slopes: [[[0.0; LANES]; 2]; NODES],
            strains: vec![[[0.0; LANES]; 3]; if selection.modulation { NODES } else { 0 }],
            areas: vec![[0.0; LANES]; if self.choppy.is_some() { NODES } else { 0 }],
            gain_rows: vec![Vec::new(); channels.len()],
            turning: Turning::default(),
            seen: Vec::new(),
            dims: Vec::new(),
            tile: Tile::new(interval_s, channels),
        })
    }

    /// The surface and the ships at every node, and phasors of the patch.
    fn prepare(&self, patch: &Patch, work: &mut TileWork) -> Result<(), SeaFailure> {
        let TileWork { facet_surface, nodes, phasors, .. } = work;
        for node in nodes {
            facet_surface.evaluate(node.elapsed_s, patch, &mut node.fields)?;
        }
        phasors.prepare(self, patch);
        Ok(())
    }
}

impl TileWork {
    /// Facets of the tile to be illuminated; returns how many.
    fn take(&mut self, runs: impl Iterator<Item = Run>) -> usize {
        self.runs.clear();
        self.runs.extend(runs);
        self.runs.iter().map(|run| run.count).sum()
    }

    /// Leaves out facets of the tile that add nothing to the echo.
    fn thin_out(&mut self, samples: (&[Sample], f64), tally: &mut Tally) {
        let Self { variant, tile, kept, keys, land, .. } = self;
        if tile.thin_out(*variant, samples, tally, kept) {
            compact(keys, kept);
            if land.count > 0 {
                land.rows_mut().for_each(|row| compact(row, kept));
                land.land[kept.len()..].fill(0.0);
            }
        }
    }

    /// Emissions of nodes, scattering epochs and gain instants, and the weights of interpolation.
    fn time(&mut self, of: &PathGenerator, tiers: &Tiers) -> Result<(), RadarError> {
        let mainlobe = &tiers.mainlobe;
        let places = &mainlobe.nodes[..mainlobe.node_count];
        self.nodes.truncate(places.len().max(1));
        while self.nodes.len() < places.len() {
            let last = self.nodes[0].clone();
            self.nodes.push(last);
        }
        for (node, &place) in self.nodes.iter_mut().zip(places) {
            of.evaluate(mainlobe.first + place as u64, &mut node.emission)?;
            node.elapsed_s = of.radar.emissions.elapsed_s(mainlobe.first + place as u64);
        }
        of.slow_time(mainlobe.first, mainlobe.pulses, &mut self.tile.slow);
        self.timings.mainlobe.set(of, mainlobe, places, &self.tile.slow)?;
        self.turning.least = tiers.turning;
        match tiers.between {
            Some(loss) => self.tile.supports.set(mainlobe.pulses, loss, &self.tile.slow),
            None => self.tile.supports.clear(),
        }
        self.sidelobe_below.clear();
        if let Some(sidelobe) = &tiers.sidelobe {
            self.timings.sidelobe.set(of, sidelobe, places, &self.tile.slow)?;
            let shares = [tiers.below_db, tiers.cutoff_db].map(|gain_db| 10f64.powf(gain_db / 20.0));
            let below = |pair: usize| shares.map(|share| (share * of.peak_gain(pair)) as f32);
            self.sidelobe_below.extend((0..of.plans.len()).map(below));
        }
        self.wakes = tiers.wake.is_some();
        if let Some(wake) = &tiers.wake {
            self.timings.wake.set(of, wake, places, &self.tile.slow)?;
        }
        let Timings { mainlobe: at_mainlobe, sidelobe: at_sidelobe, .. } = &self.timings;
        let instants_of_gain = at_mainlobe.gain_places.len().max(at_sidelobe.gain_places.len());
        for rows in &mut self.gain_rows {
            rows.resize(instants_of_gain.max(rows.len()), [0.0; LANES]);
        }
        for pair in &mut self.tile.pairs {
            pair.resize(places.len(), tiers.epochs(), mainlobe.pulses);
        }
        Ok(())
    }
}
