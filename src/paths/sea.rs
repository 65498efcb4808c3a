//! The sea of a run: drawn once, illuminated emission by emission.
//!
//! Holds what no pulse changes (surface, wakes, scattering, how visibility is found), finds where the patch
//! lies at a time and how long its echoes take, and visits its facets ([`super::facets`]).

use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

use super::breaking::BreakingPlan;
use super::facets::{CHUNK, Chunk, Reception, Surfaces, motion};
use super::patch_run::PatchRun;
use super::phasors::Phasors;
use super::ships::{Seas, Ships};
use super::visibility::{MOST_ENDS, Mix, Updates, Visibility};
use crate::frames::{Enu, Point, SceneFrame};
use crate::geometry::shadow::{self, Map, half_slope_change_rad};
use crate::motion::pointing::{PhaseCentre, Surroundings};
use crate::paths::emission::TrackFailure;
use crate::pulse::costs::{Costs, Stage};
use crate::radar::fault::{RadarFault, SeaFault, TrackUse};
use crate::scattering::land::LandScattering;
use crate::scattering::lanes::LaneWater;
use crate::scattering::water::{Sight, WaterScattering};
use crate::scene::radar::AntennaMount;
use crate::scene::sea::{Breaking, LightWinds, PatchPlace, Sea, Waves};
use crate::scene::{Land, Patch, Scene, Ship};
use crate::sea::breaking::Law;
use crate::sea::facet_surface::FacetSurface;
use crate::sea::fleet::{self, Fleet};
use crate::sea::land::{Dem, LandError, LandSheet};
use crate::sea::realise::{RealiseError, Realised};
use crate::sea::spectrum::light_wind::that_scatters;
use crate::sea::surface::choppy::Choppy;
use crate::sea::surface::modulation::Strength;
use crate::sea::surface::{Fields, Selection, Surface};
use crate::sea::wake::course::Pose;
use crate::sea::wake::{Wake, WakeError};
use crate::time::TimeTag;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Faster than any water, m/s.
const FASTEST_WATER_MPS: f64 = 100.0;
/// How the sea of a scene is drawn, or had.
pub(crate) type Drawn<'a> = &'a dyn Fn(&Sea) -> Result<Realised, RealiseError>;

/// Rms heights by which waves may stand out of the mean surface, for bounds on delays.
const CREST_RMS: f64 = 8.0;

/// The sea of a run, ready to be illuminated. Immutable, shared by all threads.
pub(super) struct SeaPlan {
    pub patch: Patch,
    place: PatchPlace,
    hold_s: f64,
    /// Time of the last emission, s after pulse 0.
    last_s: f64,
    pub surface: Arc<Surface>,
    pub wakes: Vec<Wake>,
    pub scattering: WaterScattering,
    /// The same for facets side by side.
    pub lanes: LaneWater,
    pub visibility: Option<Visibility>,
    pub breaking: Option<BreakingPlan>,
    pub displacement: bool,
    pub choppy: Option<Choppy>,
    /// How far waves may carry a facet from its grid position, m.
    pub reach_m: f64,
    pub land: Option<LandPlan>,
}

/// The land of a run.
pub(super) struct LandPlan {
    /// With the patch of pulse 0 at hand.
    pub sheet: LandSheet,
    pub scattering: LandScattering,
    /// Highest above the sea, m.
    pub top_m: f64,
}

impl fmt::Debug for SeaPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SeaPlan")
            .field("patch", &self.patch)
            .field("place", &self.place)
            .finish_non_exhaustive()
    }
}

impl LandPlan {
    fn new(scene: &Scene, land: &Land, run: &PatchRun) -> Result<Self, LandError> {
        let patches: Vec<Patch> = run.patches.iter().map(|(_, patch)| *patch).collect();
        let dem = Arc::new(Dem::open(land, scene.frame, scene.seed, &patches)?);
        let top_m = dem.top_m();
        let mut sheet = LandSheet::new(dem);
        patches.first().iter().for_each(|patch| sheet.place(patch));
        Ok(Self { sheet, scattering: LandScattering::new(land), top_m })
    }
}

/// Buffers of one thread.
#[derive(Clone)]
pub(super) struct SeaWork {
    facet_surface: FacetSurface,
    fields: Fields<f64>,
    phasors: Phasors,
    pub updates: Option<Updates>,
    poses: Vec<Pose>,
    chunk: Chunk,
}

/// Why the sea cannot be illuminated at an instant.
#[derive(Debug)]
pub(super) enum SeaFailure {
    Track(TrackFailure),
    Sea(WakeError),
    Shadow(shadow::ShadowError),
}

impl From<TrackFailure> for SeaFailure {
    fn from(failure: TrackFailure) -> Self {
        Self::Track(failure)
    }
}

impl From<WakeError> for SeaFailure {
    fn from(error: WakeError) -> Self {
        Self::Sea(error)
    }
}

impl From<shadow::ShadowError> for SeaFailure {
    fn from(error: shadow::ShadowError) -> Self {
        Self::Shadow(error)
    }
}

/// A patch at a time, given where it is at pulse 0.
pub(super) fn patch_at(
    patch: &Patch,
    place: &PatchPlace,
    of: &Surroundings,
    t: TimeTag,
) -> Result<Patch, TrackFailure> {
    match place {
        PatchPlace::Fixed => Ok(*patch),
        PatchPlace::Follow { aim, aim_from } => {
            let (point, _) = of.aim_point(aim, *aim_from, t).map_err(|source| TrackFailure {
                platform: super::beside(aim).unwrap_or(0),
                which: TrackUse::from(*aim_from),
                source,
            })?;
            let [x, y, _] = point.to_array();
            Ok(patch.centred_at([x, y]))
        }
    }
}

/// A bound on the height of ships' waves: every wave at its crest, m.
fn crest_m(wakes: &[Wake]) -> f64 {
    let of_wake = |wake: &Wake| wake.nodes().iter().map(|node| node.amplitude_m.norm()).sum::<f64>();
    // Legs of a ship follow each other; at a corner waves of two of them may stand at full height.
    let follows = |a: &Wake, b: &Wake| match (a.leg(), b.leg()) {
        (Some(a), Some(b)) => a.end_s.is_some() && a.end_s == b.begin_s,
        _ => false,
    };
    let highest = |ship: &[Wake]| {
        let of_two = ship.windows(2).map(|two| two.iter().map(of_wake).sum());
        of_two.chain(ship.iter().map(of_wake)).fold(0.0, f64::max)
    };
    wakes.chunk_by(follows).map(highest).sum()
}

impl SeaWork {
    /// Heights of the facets visited last, `[iy][ix]` over their patch, m.
    pub fn heights_m(&self) -> &[f64] {
        &self.fields.height_m
    }
}

impl SeaPlan {
    /// Takes the sea of a scene as it is drawn, and prepares its scattering.
    pub fn new(
        scene: &Scene,
        sea: &Sea,
        drawn: Drawn<'_>,
        run: &PatchRun,
        faults: &mut Vec<RadarFault>,
    ) -> Option<Self> {
        let realised = drawn(sea).map_err(|source| faults.push(SeaFault::from(source).into())).ok();
        let margin = run.margin(sea).map_err(|fault| faults.push(fault.into())).ok()?;
        let mut patches: Vec<_> = run.patches.iter().map(|(t, patch)| (*t, patch.grown(margin))).collect();
        // Updates of the shadows, none before pulse 0, come before the first emission and after the last: so
        // wakes must reach where ships are at these times.
        if let (Some(shadow), Some(&first), Some(&last)) =
            (run.shadowing(sea), patches.first(), patches.last())
        {
            let before_s = (first.0.max(0.0) / shadow.update_s).floor() * shadow.update_s;
            if before_s != first.0 {
                patches.insert(0, (before_s, first.1));
            }
            patches.push((last.0.max(0.0) + shadow.update_s, last.1));
        }
        let fleet = Fleet::muster_between(&scene.ships, &patches, run.patch_mps, run.hold_s)
            .map_err(|errors| faults.extend(errors.0.into_iter().map(|error| SeaFault::from(error).into())))
            .ok();
        Self::build(scene, sea, realised?, fleet?, run, margin)
            .map_err(|fault| faults.push(fault.into()))
            .ok()
    }

    fn build(
        scene: &Scene,
        sea: &Sea,
        realised: Realised,
        fleet: Fleet,
        run: &PatchRun,
        margin: usize,
    ) -> Result<Self, SeaFault> {
        let last_s = run.patches.last().map_or(0.0, |&(time_s, _)| time_s);
        let antennas = scene.radar.transmitters.len() + scene.radar.receivers.len();
        let shadowing = run.shadowing(sea);
        if shadowing.is_some() && antennas > MOST_ENDS {
            return Err(SeaFault::Antennas { antennas, most: MOST_ENDS });
        }
        let land = match &sea.land {
            Some(land) => Some(LandPlan::new(scene, land, run)?),
            None => None,
        };
        let Realised { wind, spectrum, surface } = realised;
        let carrier_hz = scene.radar.carrier_hz;
        let sight = Sight { carrier_hz, seed: scene.seed };
        let Fleet { wakes, strips } = fleet;
        let shortest_radpm = 2.0 * TAU * carrier_hz / SPEED_OF_LIGHT_MPS;
        let short_waves = fleet::short_waves(&scene.ships, sea.patch.facet_m, shortest_radpm)?;
        let spectrum = match sea.scattering.light_wind {
            LightWinds::Threshold => {
                that_scatters(&sea.water, &wind).map_err(RealiseError::from)?.map_or(spectrum, Arc::from)
            }
            LightWinds::AsPublished => spectrum,
        };
        let scattering =
            WaterScattering::new(sea, &wind, spectrum, &strips, sight)?.with_short_waves(short_waves);
        let law = match sea.scattering.breaking {
            Breaking::Whitecaps => Law::new(wind.u10_mps, wind.direction_rad, scene.seed),
            Breaking::Off => None,
        };
        let breaking = law
            .map(|law| {
                let follows = sea.place != PatchPlace::Fixed;
                BreakingPlan::new(law, &surface, (&sea.patch, follows), land.as_ref().map(|land| &land.sheet))
            })
            .transpose()?;
        let scattering = match scattering.relaxation_per_s() {
            Some(rate_per_s) => scattering.with_strength(Strength::of(&surface, rate_per_s)),
            None => scattering,
        };
        let choppy = (sea.waves == Waves::Choppy).then(|| Choppy::of(&surface));
        let raised_m = choppy.map_or(0.0, |choppy| choppy.most_m(CREST_RMS));
        let mut plan = Self {
            patch: sea.patch,
            place: sea.place.clone(),
            hold_s: run.hold_s,
            last_s,
            reach_m: 1.0 + CREST_RMS * surface.expected().variance_m2.sqrt() + crest_m(&wakes) + raised_m,
            surface,
            wakes,
            lanes: scattering.lanes(),
            scattering,
            visibility: None,
            breaking,
            displacement: sea.scattering.displacement,
            choppy,
            land,
        };
        if let Some(shadowing) = &shadowing {
            let width_rad = match shadowing.width_rad {
                Some(width_rad) => width_rad,
                None => {
                    plan.half_slope_change_rad(run.patches.first().map_or(&sea.patch, |(_, patch)| patch))?
                }
            };
            let settings = shadow::Settings { width_rad, rays_per_facet: shadowing.rays_per_facet };
            let visibility = Visibility {
                waves: sea.shadow.is_some(),
                settings,
                earth: scene.frame.hiding_earth(),
                horizon_edge_m: width_rad * sea.patch.facet_m,
                update_s: shadowing.update_s,
                margin,
                ends: antennas,
                land: plan.land.as_ref().map(|land| land.sheet.clone()),
                hulls: None,
                two_rays: shadowing
                    .two_rays
                    .then(|| plan.scattering.two_rays(plan.surface.expected().variance_m2.sqrt())),
            };
            // Whether its maps are legal shows here and not at the first pulse.
            visibility.check::<SeaFault>(&plan.wakes, &plan.patch)?;
            plan.visibility = Some(visibility);
        }
        FacetSurface::<f32>::new(&plan.surface, Selection::HEIGHT).with_wakes(&plan.wakes, &plan.patch)?;
        Ok(plan)
    }

    /// The width of the shadows' edge that the sea itself suggests, from its map at pulse 0.
    fn half_slope_change_rad(&self, patch: &Patch) -> Result<f64, SeaFault> {
        let mut facet_surface =
            FacetSurface::<f64>::new(&self.surface, Selection::HEIGHT).with_wakes(&self.wakes, patch)?;
        let mut fields = facet_surface.fields(patch);
        facet_surface.evaluate(0.0, patch, &mut fields)?;
        let map = Map::new(&fields.height_m, patch.facets, patch.facet_m, [0.0, 0.0])?;
        Ok(half_slope_change_rad(&map))
    }

    /// Buffers of one thread for a radar with so many pairs and channels.
    pub fn work(&self, pairs: usize, channels: usize) -> Option<SeaWork> {
        // That they are legal was found out when the plan was made.
        let facet_surface = FacetSurface::<f64>::new(&self.surface, self.selection())
            .with_relaxation(self.scattering.relaxation_per_s())
            .with_choppy(self.choppy)
            .with_wakes(&self.wakes, &self.patch)
            .ok()?
            .with_land(self.land.as_ref().map(|land| &land.sheet));
        let updates = match &self.visibility {
            Some(visibility) => {
                Some(visibility.updates::<f64, SeaFault>(&self.surface, &self.wakes, &self.patch).ok()?)
            }
            None => None,
        };
        let mechanisms = self.scattering.mechanisms();
        let mut poses = Vec::new();
        self.scattering.poses(0.0, &mut poses);
        Some(SeaWork {
            fields: facet_surface.fields(&self.patch),
            facet_surface,
            phasors: Phasors::new(self.patch.len(), mechanisms),
            updates,
            poses,
            chunk: Chunk::new(pairs, channels, mechanisms),
        })
    }

    /// What the paths and tilts of facets ask of the surface.
    fn selection(&self) -> Selection {
        Selection {
            slopes: true,
            velocity: true,
            horizontal_acceleration: self.displacement,
            displacement: self.displacement,
            modulation: self.scattering.relaxation_per_s().is_some(),
            ..Selection::HEIGHT
        }
    }

    /// The ships of its scene, which ride its waves and hide what is behind them.
    pub fn with_ships(mut self, ships: &[Ship], antennas: [usize; 2], frame: SceneFrame) -> (Self, Ships) {
        let seas = Seas { surface: &self.surface, last_s: self.last_s };
        let ships = Ships::new(ships, antennas, Some(seas));
        if let Some(visibility) = &mut self.visibility {
            visibility.hulls = ships.hulls(frame);
        }
        (self, ships)
    }

    /// Whether the patch moves.
    pub fn moves(&self) -> bool {
        matches!(self.place, PatchPlace::Follow { .. })
    }

    /// When the patch of a time (s after pulse 0) was placed.
    pub fn placed_s(&self, elapsed_s: f64) -> f64 {
        if self.hold_s.is_finite() { (elapsed_s / self.hold_s + 1e-9).floor() * self.hold_s } else { 0.0 }
    }

    /// The patch at a time, s after pulse 0: where it was placed last.
    pub fn patch_at(&self, of: &Surroundings, elapsed_s: f64) -> Result<Patch, TrackFailure> {
        patch_at(&self.patch, &self.place, of, of.start.plus(self.placed_s(elapsed_s.max(0.0))))
    }

    /// Bounds on the delays of all facets of a patch over all pairs, s.
    pub fn delay_span_s(&self, patch: &Patch, reception: &Reception) -> Option<(f64, f64)> {
        let transmitters = reception.radar.transmitters.len();
        let centres = &reception.emission.centres;
        let running_m = self.breaking.as_ref().map_or(0.0, BreakingPlan::reach_m);
        let side = 0.5 * patch.facet_m + self.reach_m.max(running_m);
        let last = [0, 1].map(|i| patch.first[i] + patch.facets[i] as i64 - 1);
        let (low, high) =
            (patch.centre_m(patch.first).map(|x| x - side), patch.centre_m(last).map(|x| x + side));
        // The mean surface is nowhere higher than where the patch is nearest to the origin, nor lower than in
        // a corner.
        let earth = reception.surroundings.frame.earth();
        let inner = [0, 1].map(|i| 0f64.clamp(low[i], high[i]));
        let corners = [[low[0], low[1]], [low[0], high[1]], [high[0], low[1]], [high[0], high[1]]];
        let deepest = corners.iter().map(|c| earth.drop_m(c[0], c[1])).fold(0.0, f64::max);
        let top_m = self.reach_m.max(self.land.as_ref().map_or(0.0, |land| land.top_m));
        let (floor, ceiling) = (-deepest - self.reach_m, top_m - earth.drop_m(inner[0], inner[1]));
        let nearest_m = |p: [f64; 3]| {
            let d = [
                p[0] - p[0].clamp(low[0], high[0]),
                p[1] - p[1].clamp(low[1], high[1]),
                p[2] - p[2].clamp(floor, ceiling),
            ];
            d[0].hypot(d[1]).hypot(d[2])
        };
        // The sum of two distances is convex, so it is greatest in a corner of the box.
        let farthest_m = |tx: [f64; 3], rx: [f64; 3]| {
            let leg = |p: [f64; 3], c: [f64; 2], z: f64| (p[0] - c[0]).hypot(p[1] - c[1]).hypot(p[2] - z);
            let both = |c: [f64; 2], z: f64| leg(tx, c, z) + leg(rx, c, z);
            corners.iter().flat_map(|&c| [both(c, floor), both(c, ceiling)]).fold(0.0, f64::max)
        };
        reception.plans.iter().fold(None, |span: Option<(f64, f64)>, plan| {
            let tx = centres[plan.pair.transmitter].position.to_array();
            let rx = centres[transmitters + plan.pair.receiver].position.to_array();
            let (least, most) = (nearest_m(tx) + nearest_m(rx), farthest_m(tx, rx));
            let (least, most) = (least / SPEED_OF_LIGHT_MPS, most / SPEED_OF_LIGHT_MPS);
            // While the pulse is under way the receiver moves, and the water.
            let receiver_mps = centres[transmitters + plan.pair.receiver].velocity.norm();
            let change_s = (receiver_mps + FASTEST_WATER_MPS) / SPEED_OF_LIGHT_MPS * most;
            let (least, most) = (least - change_s, most + change_s);
            Some(span.map_or((least, most), |(a, b)| (a.min(least), b.max(most))))
        })
    }

    /// Visits the facets that one emission illuminates in a window, chunk by chunk.
    pub fn visit(
        &self,
        reception: &Reception,
        work: &mut SeaWork,
        costs: &mut Costs,
        each: impl FnMut(&Chunk),
    ) -> Result<(), SeaFailure> {
        let patch = self.patch_at(&reception.surroundings, reception.elapsed_s)?;
        self.illuminate(reception, &patch, work, costs, each)
    }

    fn illuminate(
        &self,
        reception: &Reception,
        patch: &Patch,
        work: &mut SeaWork,
        costs: &mut Costs,
        mut each: impl FnMut(&Chunk),
    ) -> Result<(), SeaFailure> {
        let SeaWork { facet_surface, fields, phasors, updates, poses, chunk, .. } = work;
        costs.lap(Stage::ScattererPaths);
        facet_surface.evaluate(reception.elapsed_s, patch, fields)?;
        costs.lap(Stage::Surface);
        self.scattering.poses(reception.elapsed_s, poses);
        phasors.prepare(&self.scattering, patch, reception.elapsed_s);
        costs.lap(Stage::ScattererPaths);
        let earth = reception.surroundings.frame.earth();
        let mix = self.mix(reception, updates)?;
        costs.lap(Stage::Shadow);
        let transmitters = reception.radar.transmitters.len();
        let mut first = 0;
        while first < patch.len() {
            let end = (first + CHUNK).min(patch.len());
            let mut kinds = [(0, 0.0); CHUNK];
            if self.scattering.kinds() > 1 {
                for (place, index) in (first..end).enumerate() {
                    kinds[place] = self.scattering.kind_at(patch.centre_m(patch.key(index)), poses);
                }
            }
            // Land is a kind of its own, after those of the water.
            let (water_kinds, mut land_kinds) = (self.scattering.kinds(), 0);
            if let Some(land) = facet_surface.land() {
                for (kind, land) in kinds.iter_mut().zip(&land.land()[first..end]) {
                    if *land > 0.0 {
                        (*kind, land_kinds) = ((water_kinds, 0.0), 1);
                    }
                }
            }
            for kind in 0..water_kinds + land_kinds {
                chunk.clear();
                for (index, &(its_kind, cover)) in (first..end).zip(&kinds) {
                    if its_kind != kind {
                        continue;
                    }
                    let key = patch.key(index);
                    let place_m = patch.centre_m(key);
                    let scatterer = motion(fields, index, place_m, earth.drop_m(place_m[0], place_m[1]));
                    let visible = |antenna: usize| mix.as_ref().map_or(1.0, |mix| mix.weight(antenna, key));
                    if !chunk.see(reception, transmitters, &scatterer, visible) {
                        continue;
                    }
                    let fall = earth.drop_slope(place_m[0], place_m[1]);
                    let slope = [fields.slope[0][index] - fall[0], fields.slope[1][index] - fall[1]];
                    let [xx, yy, xy] = &fields.modulation;
                    let strain = (!xx.is_empty()).then(|| [xx[index], yy[index], xy[index]]);
                    chunk.take(index, slope, strain, cover, phasors.of(patch, key));
                    if let Some(&area) = fields.area.get(index) {
                        chunk.stretch_last(area);
                    }
                }
                if !chunk.index.is_empty() {
                    let land = facet_surface.land().filter(|_| kind == water_kinds);
                    let surface = match (land, &self.land) {
                        (Some(sheet), Some(LandPlan { scattering, .. })) => Surfaces::Land(scattering, sheet),
                        _ => Surfaces::Water(&self.scattering, poses, kind),
                    };
                    chunk.scatter(reception, surface, patch);
                    each(chunk);
                }
            }
            first = end;
        }
        costs.lap(Stage::ScattererPaths);
        Ok(())
    }

    /// The visibility of facets at an emission, where anything hides them.
    fn mix<'a>(
        &'a self,
        reception: &Reception,
        updates: &'a mut Option<Updates>,
    ) -> Result<Option<Mix<'a>>, SeaFailure> {
        let (Some(visibility), Some(updates)) = (&self.visibility, updates) else { return Ok(None) };
        let earth = reception.surroundings.frame.earth();
        let scenery = |elapsed_s, places: &mut [Point<Enu>]| self.scenery(reception, elapsed_s, places);
        visibility.at(updates, reception.elapsed_s, scenery, earth).map(Some)
    }

    /// The patch of an emission that was visited, and the visibility of its facets.
    pub fn seen<'a>(
        &'a self,
        reception: &Reception,
        work: &'a mut SeaWork,
    ) -> Result<(Patch, Option<Mix<'a>>), SeaFailure> {
        let mix = self.mix(reception, &mut work.updates)?;
        Ok((self.patch_at(&reception.surroundings, reception.elapsed_s)?, mix))
    }

    /// Patch and antennas at a time after pulse 0. A track that ends before goes straight on from the last
    /// emission: the update of the shadows after it is asked for, and a recorded track need not reach so far.
    pub fn scenery(
        &self,
        reception: &Reception,
        elapsed_s: f64,
        places: &mut [Point<Enu>],
    ) -> Result<Patch, SeaFailure> {
        let of = &reception.surroundings;
        let transmitters = reception.radar.transmitters.iter().map(|tx| &tx.antenna);
        let mounts = transmitters.chain(reception.radar.receivers.iter().map(|rx| &rx.antenna));
        for (mount, place) in mounts.zip(places) {
            let AntennaMount { platform, lever_arm, .. } = *mount;
            let truth = &of.tracks[platform].truth;
            let beyond_s = elapsed_s - self.last_s;
            let (state, on_s) = match truth.state(of.start.plus(elapsed_s)) {
                Err(_) if beyond_s > 0.0 => (truth.state(of.start.plus(self.last_s)), beyond_s),
                state => (state, 0.0),
            };
            let state = state.map_err(|source| {
                SeaFailure::Track(TrackFailure { platform, which: TrackUse::Truth, source })
            })?;
            let centre = PhaseCentre::of(&state, lever_arm);
            *place = if on_s > 0.0 { centre.position + centre.velocity * on_s } else { centre.position };
        }
        match self.patch_at(of, elapsed_s) {
            Err(_) if elapsed_s > self.last_s => Ok(self.patch_at(of, self.last_s)?),
            patch => Ok(patch?),
        }
    }
}
