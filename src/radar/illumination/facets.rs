//! The facets of the sea, as one emission and one receive window meet them.
//!
//! Facet `(ix, iy)` of the patch scatters from the place `x_grid + D + z up` (lowered on a curved Earth), moving with the
//! orbital velocity and acceleration while the pulse is under way; delay, rate, directions and legs come from this one path
//! ([`crate::geometry::light_time`]), so that the carrier phase of a facet is a smooth function of slow time whose
//! derivative is its Doppler. Tilt and area are those of the grid position, with the slope of the mean surface added on a curved Earth. Its amplitude in a channel is
//!
//! `a = K / (R_t R_r)  g_t g_r  v_t v_r  (e_r^T S e_t)`
//!
//! with the radar equation's constant and legs ([`crate::radar::link`]), field gains and polarisations
//! ([`crate::radar::antenna`]), the visibility weights of both ends, and the matrix `S` of
//! [`crate::scattering::water`].
//!
//! Facets are visited in chunks, within a chunk ordered by kind of surface. A facet is passed over where its
//! echo misses the window, where an antenna is dark or hidden, and where it scatters nothing.

use std::fmt;
use std::sync::Arc;

use glam::DMat3;
use num_complex::Complex64;

use super::PairPlan;
use super::visibility::{MOST_ENDS, Updates, Visibility};
use super::window::Window;
use crate::frames::{Enu, Point, Vector};
use crate::geometry::bistatic::Basis;
use crate::geometry::light_time::{LightTime, bistatic_over};
use crate::geometry::shadow::{self, Edge, Map, half_slope_change_rad};
use crate::motion::pointing::{PhaseCentre, Surroundings};
use crate::radar::antenna::{Antenna, Axes, field};
use crate::radar::emission::{Emission, TrackFailure};
use crate::radar::fault::{RadarFault, TrackUse};
use crate::scattering::facets::Facets;
use crate::scattering::water::{Sight, SpectrumPath, WaterScattering};
use crate::scene::radar::{AntennaMount, Polarisation, Radar};
use crate::scene::sea::{PatchPlace, Sea};
use crate::scene::{Patch, Scene};
use crate::sea::realise::{Realised, realise};
use crate::sea::sheet::Sheet;
use crate::sea::surface::{Fields, Selection, Surface, SurfaceError};
use crate::time::TimeTag;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Facets handled side by side.
const CHUNK: usize = 256;
/// Rms heights by which waves may stand out of the mean surface, for bounds on delays.
const CREST_RMS: f64 = 8.0;

/// The sea of a run, ready to be lit. Immutable, shared by all threads.
pub(super) struct SeaPlan {
    pub patch: Patch,
    place: PatchPlace,
    surface: Surface,
    scattering: WaterScattering,
    visibility: Option<Visibility>,
    /// Buffers of the shadows, made once and copied for every thread.
    updates: Option<Updates>,
    displacement: bool,
    /// How far waves may carry a facet from its grid position, m.
    reach_m: f64,
}

impl fmt::Debug for SeaPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SeaPlan")
            .field("patch", &self.patch)
            .field("place", &self.place)
            .finish_non_exhaustive()
    }
}

/// Random phasors of the facets at hand. A facet's place is its key modulo the patch, so that what moves is
/// only what enters.
#[derive(Clone)]
struct Phasors {
    keys: Vec<Option<[i64; 2]>>,
    phasors: Vec<Complex64>,
    mechanisms: usize,
}

/// Buffers of one thread.
#[derive(Clone)]
pub(super) struct SeaWork {
    sheet: Sheet,
    fields: Fields<f64>,
    phasors: Phasors,
    updates: Option<Updates>,
    chunk: Chunk,
}

/// What one transmitter-receiver pair sees of a chunk.
#[derive(Clone, Default)]
pub(super) struct PairColumns {
    pub delay_s: Vec<f64>,
    pub delay_rate: Vec<f64>,
    incident: [Vec<f64>; 3],
    scattered: [Vec<f64>; 3],
    /// Everything of the amplitude but the scattering and the polarisations.
    scale: Vec<Complex64>,
    /// Axes of the receive antenna at reception.
    rx_axes: Vec<Axes>,
}

/// Facets side by side.
#[derive(Clone, Default)]
pub(super) struct Chunk {
    /// Place in the patch.
    pub index: Vec<usize>,
    slope: [Vec<f64>; 2],
    cover: Vec<f64>,
    phasors: Vec<Complex64>,
    pub pairs: Vec<PairColumns>,
    /// `vv, vh, hv, hh`.
    matrix: [Vec<Complex64>; 4],
    /// `[channel]`.
    pub amplitude: Vec<Vec<Complex64>>,
}

/// The instant and circumstances of an emission.
#[derive(Clone, Copy)]
pub(super) struct Lighting<'a> {
    pub surroundings: Surroundings<'a>,
    pub radar: &'a Radar,
    pub antennas: &'a [Antenna],
    pub plans: &'a [PairPlan],
    pub emission: &'a Emission,
    pub t: TimeTag,
    /// After pulse 0, s.
    pub elapsed_s: f64,
    /// After the emission of the window's own pulse, s.
    pub offset_s: f64,
    pub tx_pol: Option<Polarisation>,
    pub axes_span_s: f64,
    pub window: Window,
}

/// Why the sea cannot be lit at an instant.
#[derive(Debug)]
pub(super) enum SeaFailure {
    Track(TrackFailure),
    Sea(SurfaceError),
    Shadow(shadow::ShadowError),
}

impl From<TrackFailure> for SeaFailure {
    fn from(failure: TrackFailure) -> Self {
        Self::Track(failure)
    }
}

impl From<SurfaceError> for SeaFailure {
    fn from(error: SurfaceError) -> Self {
        Self::Sea(error)
    }
}

impl From<shadow::ShadowError> for SeaFailure {
    fn from(error: shadow::ShadowError) -> Self {
        Self::Shadow(error)
    }
}

impl SeaWork {
    /// Heights of the facets visited last, `[iy][ix]` over their patch, m.
    pub fn heights_m(&self) -> &[f64] {
        &self.fields.height_m
    }
}

impl SeaPlan {
    /// Draws the sea of a scene and prepares its scattering; `last_s` is the time of the last emission after pulse 0.
    pub fn new(
        scene: &Scene,
        sea: &Sea,
        last_s: f64,
        fastest_platform_mps: f64,
        faults: &mut Vec<RadarFault>,
    ) -> Option<Self> {
        let antennas = scene.radar.transmitters.len() + scene.radar.receivers.len();
        if sea.shadow.is_some() && antennas > MOST_ENDS {
            let allowed = "at most 64 antennas where the sea casts shadows";
            faults.push(RadarFault::Value { name: "antennas", value: antennas as f64, allowed });
            return None;
        }
        let realised = realise(sea, scene.seed).map_err(|source| faults.push(source.into())).ok();
        let Realised { wind, spectrum, surface } = realised?;
        let sight = Sight {
            carrier_hz: scene.radar.carrier_hz,
            facet_m: sea.patch.facet_m,
            seed: scene.seed,
            spectrum: SpectrumPath::Exact,
        };
        let scattering = WaterScattering::new(
            &sea.scattering,
            sea.water.temperature_c,
            sea.water.salinity_psu,
            &sea.slicks,
            &wind,
            Arc::from(spectrum),
            sight,
        )
        .map_err(|source| faults.push(source.into()))
        .ok()?;
        let mut plan = Self {
            patch: sea.patch,
            place: sea.place.clone(),
            reach_m: 1.0 + CREST_RMS * surface.expected().variance_m2.sqrt(),
            surface,
            scattering,
            visibility: None,
            updates: None,
            displacement: sea.scattering.displacement,
        };
        if let Some(shadowing) = &sea.shadow {
            let width_rad = match shadowing.width_rad {
                Some(width_rad) => width_rad,
                None => plan.half_slope_change_rad().map_err(|source| faults.push(source)).ok()?,
            };
            let settings =
                shadow::Settings { edge: Edge::Soft { width_rad }, rays_per_facet: shadowing.rays_per_facet };
            let margin = match sea.place {
                PatchPlace::Fixed => 0,
                // A point beside a turning platform moves faster than the platform does: twice as fast is allowed for.
                PatchPlace::Follow { .. } => {
                    (2.0 * fastest_platform_mps * shadowing.update_s / sea.patch.facet_m).ceil() as usize + 1
                }
            };
            let visibility =
                Visibility { settings, update_s: shadowing.update_s, last_s, margin, ends: antennas };
            // Whether its maps are legal shows here and not at the first pulse.
            let updates = visibility.updates(&plan.surface, &plan.patch);
            plan.updates = Some(updates.map_err(|source| faults.push(source.into())).ok()?);
            plan.visibility = Some(visibility);
        }
        Some(plan)
    }

    /// The width of the shadows' edge that the sea itself suggests, from its map at pulse 0.
    fn half_slope_change_rad(&self) -> Result<f64, RadarFault> {
        let mut sheet = Sheet::new(&self.surface, Selection::HEIGHT);
        let mut fields = sheet.fields(&self.patch);
        sheet.evaluate(0.0, &self.patch, &mut fields).map_err(RadarFault::Surface)?;
        let map = Map::new(&fields.height_m, self.patch.facets, self.patch.facet_m, [0.0, 0.0])?;
        Ok(half_slope_change_rad(&map))
    }

    /// Buffers of one thread for a radar with so many pairs and channels.
    pub fn work(&self, pairs: usize, channels: usize) -> SeaWork {
        let selection = Selection {
            slopes: true,
            velocity: true,
            horizontal_acceleration: self.displacement,
            displacement: self.displacement,
            ..Selection::HEIGHT
        };
        let sheet = Sheet::new(&self.surface, selection);
        let mechanisms = self.scattering.mechanisms();
        let facets = self.patch.len();
        SeaWork {
            fields: sheet.fields(&self.patch),
            sheet,
            phasors: Phasors {
                keys: vec![None; facets],
                phasors: vec![Complex64::ZERO; facets * mechanisms],
                mechanisms,
            },
            updates: self.updates.clone(),
            chunk: Chunk::new(pairs, channels, mechanisms),
        }
    }

    /// Whether the patch moves.
    pub fn moves(&self) -> bool {
        matches!(self.place, PatchPlace::Follow { .. })
    }

    /// The patch at a time.
    pub fn patch_at(&self, of: &Surroundings, t: TimeTag) -> Result<Patch, TrackFailure> {
        match &self.place {
            PatchPlace::Fixed => Ok(self.patch),
            PatchPlace::Follow { aim, aim_from } => {
                let (point, _) = of.aim_point(aim, *aim_from, t).map_err(|source| TrackFailure {
                    platform: super::beside(aim).unwrap_or(0),
                    which: TrackUse::from(*aim_from),
                    source,
                })?;
                let [x, y, _] = point.to_array();
                Ok(self.patch.centred_at([x, y]))
            }
        }
    }

    /// Bounds on the delays of all facets of a patch over all pairs, s.
    pub fn delay_span_s(&self, patch: &Patch, lighting: &Lighting) -> Option<(f64, f64)> {
        let transmitters = lighting.radar.transmitters.len();
        let centres = &lighting.emission.centres;
        let side = 0.5 * patch.facet_m + self.reach_m;
        let last = [0, 1].map(|i| patch.first[i] + patch.facets[i] as i64 - 1);
        let (low, high) =
            (patch.centre_m(patch.first).map(|x| x - side), patch.centre_m(last).map(|x| x + side));
        // The mean surface is nowhere higher than where the patch is nearest to the origin, nor lower than in a corner.
        let earth = lighting.surroundings.frame.earth();
        let inner = [0, 1].map(|i| 0f64.clamp(low[i], high[i]));
        let corners = [[low[0], low[1]], [low[0], high[1]], [high[0], low[1]], [high[0], high[1]]];
        let deepest = corners.iter().map(|c| earth.drop_m(c[0], c[1])).fold(0.0, f64::max);
        let (floor, ceiling) = (-deepest - self.reach_m, self.reach_m - earth.drop_m(inner[0], inner[1]));
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
        lighting.plans.iter().fold(None, |span: Option<(f64, f64)>, plan| {
            let tx = centres[plan.pair.transmitter].position.to_array();
            let rx = centres[transmitters + plan.pair.receiver].position.to_array();
            let (least, most) = (nearest_m(tx) + nearest_m(rx), farthest_m(tx, rx));
            let (least, most) = (least / SPEED_OF_LIGHT_MPS, most / SPEED_OF_LIGHT_MPS);
            Some(span.map_or((least, most), |(a, b)| (a.min(least), b.max(most))))
        })
    }

    /// Visits the facets that one emission lights in a window, chunk by chunk.
    pub fn visit(
        &self,
        lighting: &Lighting,
        work: &mut SeaWork,
        mut each: impl FnMut(&Chunk),
    ) -> Result<(), SeaFailure> {
        let SeaWork { sheet, fields, phasors, updates, chunk } = work;
        let patch = self.patch_at(&lighting.surroundings, lighting.t)?;
        sheet.evaluate(lighting.elapsed_s, &patch, fields)?;
        phasors.prepare(&self.scattering, &patch, lighting.elapsed_s);
        let earth = lighting.surroundings.frame.earth();
        let mix = match (&self.visibility, updates) {
            (Some(visibility), Some(updates)) => Some(visibility.at(
                updates,
                lighting.elapsed_s,
                |elapsed_s, places| self.scenery(lighting, elapsed_s, places),
                |[x, y]| earth.drop_m(x, y),
            )?),
            _ => None,
        };
        let footprint_m2 = patch.facet_m * patch.facet_m;
        let transmitters = lighting.radar.transmitters.len();
        let mut first = 0;
        while first < patch.len() {
            let end = (first + CHUNK).min(patch.len());
            for kind in 0..self.scattering.kinds() {
                chunk.clear();
                for index in first..end {
                    let key = patch.key(index);
                    let place_m = patch.centre_m(key);
                    let cover = if self.scattering.kinds() > 1 {
                        let (its_kind, cover) = self.scattering.kind_at(place_m);
                        if its_kind != kind {
                            continue;
                        }
                        cover
                    } else {
                        0.0
                    };
                    let scatterer = motion(fields, index, place_m, earth.drop_m(place_m[0], place_m[1]));
                    let visible = |antenna: usize| mix.as_ref().map_or(1.0, |mix| mix.weight(antenna, key));
                    if !chunk.see(lighting, transmitters, &scatterer, visible) {
                        continue;
                    }
                    chunk.index.push(index);
                    let mean_slope = earth.drop_slope(place_m[0], place_m[1]);
                    chunk.slope[0].push(fields.slope[0][index] - mean_slope[0]);
                    chunk.slope[1].push(fields.slope[1][index] - mean_slope[1]);
                    chunk.cover.push(cover);
                    chunk.phasors.extend_from_slice(phasors.of(&patch, key));
                }
                if !chunk.index.is_empty() {
                    chunk.scatter(lighting, &self.scattering, kind, footprint_m2);
                    each(chunk);
                }
            }
            first = end;
        }
        Ok(())
    }

    /// Patch and antennas at a time after pulse 0.
    fn scenery(
        &self,
        lighting: &Lighting,
        elapsed_s: f64,
        places: &mut [Point<Enu>],
    ) -> Result<Patch, SeaFailure> {
        let t = lighting.surroundings.start.plus(elapsed_s);
        let transmitters = lighting.radar.transmitters.iter().map(|tx| &tx.antenna);
        let mounts = transmitters.chain(lighting.radar.receivers.iter().map(|rx| &rx.antenna));
        for (mount, place) in mounts.zip(places) {
            let AntennaMount { platform, lever_arm, .. } = *mount;
            let state = lighting.surroundings.tracks[platform].truth.state(t).map_err(|source| {
                SeaFailure::Track(TrackFailure { platform, which: TrackUse::Truth, source })
            })?;
            *place = PhaseCentre::of(&state, lever_arm).position;
        }
        Ok(self.patch_at(&lighting.surroundings, t)?)
    }
}

/// Motion of a facet about the instant of the fields; `drop_m` is how far the mean surface lies below the plane there.
fn motion(fields: &Fields<f64>, index: usize, [x, y]: [f64; 2], drop_m: f64) -> PhaseCentre {
    let at = |column: &Vec<f64>| column[index];
    let z = at(&fields.height_m) - drop_m;
    let [u, v, w] = fields.velocity_mps.each_ref().map(at);
    let [_, _, rising] = fields.acceleration_mps2.each_ref();
    if fields.displacement_m[0].is_empty() {
        return PhaseCentre {
            position: Point::new(x, y, z),
            velocity: Vector::new(0.0, 0.0, w),
            acceleration: Vector::new(0.0, 0.0, at(rising)),
        };
    }
    let [dx, dy] = fields.displacement_m.each_ref().map(at);
    let [ax, ay, az] = fields.acceleration_mps2.each_ref().map(at);
    PhaseCentre {
        position: Point::new(x + dx, y + dy, z),
        velocity: Vector::new(u, v, w),
        acceleration: Vector::new(ax, ay, az),
    }
}

impl Phasors {
    fn place(&self, patch: &Patch, key: [i64; 2]) -> usize {
        let [nx, ny] = patch.facets;
        key[1].rem_euclid(ny as i64) as usize * nx + key[0].rem_euclid(nx as i64) as usize
    }

    fn of(&self, patch: &Patch, key: [i64; 2]) -> &[Complex64] {
        let place = self.place(patch, key) * self.mechanisms;
        &self.phasors[place..place + self.mechanisms]
    }

    fn prepare(&mut self, scattering: &WaterScattering, patch: &Patch, t_s: f64) {
        for index in 0..patch.len() {
            let key = patch.key(index);
            let place = self.place(patch, key);
            if self.keys[place] != Some(key) || scattering.decorrelates() {
                self.keys[place] = Some(key);
                let begin = place * self.mechanisms;
                scattering.phasors(key, t_s, &mut self.phasors[begin..begin + self.mechanisms]);
            }
        }
    }
}

impl PairColumns {
    fn clear(&mut self) {
        let Self { delay_s, delay_rate, incident, scattered, scale, rx_axes } = self;
        delay_s.clear();
        delay_rate.clear();
        incident.iter_mut().chain(scattered).for_each(Vec::clear);
        scale.clear();
        rx_axes.clear();
    }

    fn reserve(&mut self) {
        let Self { delay_s, delay_rate, incident, scattered, scale, rx_axes } = self;
        [delay_s, delay_rate].into_iter().chain(incident).chain(scattered).for_each(|c| c.reserve(CHUNK));
        scale.reserve(CHUNK);
        rx_axes.reserve(CHUNK);
    }
}

impl Chunk {
    fn new(pairs: usize, channels: usize, mechanisms: usize) -> Self {
        let zeros = || vec![Complex64::ZERO; CHUNK];
        let mut chunk = Self {
            index: Vec::with_capacity(CHUNK),
            slope: [Vec::with_capacity(CHUNK), Vec::with_capacity(CHUNK)],
            cover: Vec::with_capacity(CHUNK),
            phasors: Vec::with_capacity(CHUNK * mechanisms),
            pairs: vec![PairColumns::default(); pairs],
            matrix: [zeros(), zeros(), zeros(), zeros()],
            amplitude: vec![zeros(); channels],
        };
        chunk.pairs.iter_mut().for_each(PairColumns::reserve);
        chunk
    }

    fn clear(&mut self) {
        self.index.clear();
        self.slope.iter_mut().for_each(Vec::clear);
        self.cover.clear();
        self.phasors.clear();
        self.pairs.iter_mut().for_each(PairColumns::clear);
    }

    /// Takes in the paths of a facet over every pair; of one that no pair hears nothing is kept.
    fn see(
        &mut self,
        lighting: &Lighting,
        transmitters: usize,
        scatterer: &PhaseCentre,
        visible: impl Fn(usize) -> f64,
    ) -> bool {
        let mut heard = false;
        for (plan, columns) in lighting.plans.iter().zip(&mut self.pairs) {
            let (tx, rx) = (plan.pair.transmitter, transmitters + plan.pair.receiver);
            let centres = &lighting.emission.centres;
            let path = bistatic_over(LightTime::Exact, &centres[tx], scatterer, &centres[rx]);
            let mut scale = Complex64::ZERO;
            let rx_axes = lighting.emission.axes_after(rx, path.delay_s, lighting.axes_span_s);
            if plan.hears(lighting.tx_pol) && lighting.window.touches(lighting.offset_s + path.delay_s) {
                let seen = visible(tx) * visible(rx);
                let range = |leg_s: f64| leg_s * SPEED_OF_LIGHT_MPS;
                let link = plan.link.scattered(range(path.tx_leg_s), range(path.rx_leg_s));
                if seen > 0.0 && link > 0.0 {
                    let gain = |antenna: usize, axes: &DMat3, d: glam::DVec3| {
                        lighting.antennas[antenna].field_gain(Vector::from_raw(axes.transpose() * d))
                    };
                    let tx_axes = lighting.emission.axes(tx);
                    scale = gain(tx, &tx_axes, path.incident)
                        * gain(rx, &rx_axes, -path.scattered)
                        * (link * seen);
                }
            }
            heard |= scale != Complex64::ZERO;
            columns.delay_s.push(path.delay_s);
            columns.delay_rate.push(path.delay_rate);
            for (column, d) in columns.incident.iter_mut().zip(path.incident.to_array()) {
                column.push(d);
            }
            for (column, d) in columns.scattered.iter_mut().zip(path.scattered.to_array()) {
                column.push(d);
            }
            columns.scale.push(scale);
            columns.rx_axes.push(rx_axes);
        }
        if !heard {
            for columns in &mut self.pairs {
                columns.delay_s.pop();
                columns.delay_rate.pop();
                columns.incident.iter_mut().chain(&mut columns.scattered).for_each(|c| {
                    c.pop();
                });
                columns.scale.pop();
                columns.rx_axes.pop();
            }
        }
        heard
    }

    /// Amplitudes of all facets of the chunk, which are of one kind.
    fn scatter(&mut self, lighting: &Lighting, water: &WaterScattering, kind: usize, footprint_m2: f64) {
        let count = self.index.len();
        for column in &mut self.amplitude {
            column.resize(count, Complex64::ZERO);
            column.fill(Complex64::ZERO);
        }
        for (plan, columns) in lighting.plans.iter().zip(&self.pairs) {
            let facets = Facets {
                incident: columns.incident.each_ref().map(Vec::as_slice),
                scattered: columns.scattered.each_ref().map(Vec::as_slice),
                slope_x: &self.slope[0],
                slope_y: &self.slope[1],
                cover: &self.cover,
                phasors: &self.phasors,
                footprint_m2,
            };
            for entry in &mut self.matrix {
                entry.resize(count, Complex64::ZERO);
            }
            let [vv, vh, hv, hh] = &mut self.matrix;
            if water.scatter(kind, &facets, [vv, vh, hv, hh]).is_err() {
                debug_assert!(false, "columns of a chunk differ in length");
                continue;
            }
            let (tx, rx) = (plan.pair.transmitter, plan.pair.receiver);
            let tx_axes = lighting.emission.axes(tx);
            let tx_leak = lighting.radar.transmitters[tx].antenna.cross_pol_isolation_db;
            let rx_leak = lighting.radar.receivers[rx].antenna.cross_pol_isolation_db;
            for i in 0..count {
                let scale = columns.scale[i];
                if scale == Complex64::ZERO {
                    continue;
                }
                let direction = |d: &[Vec<f64>; 3]| glam::DVec3::new(d[0][i], d[1][i], d[2][i]);
                let (incident, scattered) = (direction(&columns.incident), direction(&columns.scattered));
                let (basis_in, basis_out) = (Basis::of(incident), Basis::of(scattered));
                let mut e_t = Ports::new(|port| field(&tx_axes, port, tx_leak, incident, &basis_in));
                let mut e_r =
                    Ports::new(|port| field(&columns.rx_axes[i], port, rx_leak, scattered, &basis_out));
                for &(channel, tx_port, rx_port) in &plan.channels {
                    if lighting.tx_pol.is_some_and(|port| port != tx_port) {
                        continue;
                    }
                    let (t, r) = (e_t.of(tx_port), e_r.of(rx_port));
                    let heard = r[0] * (vv[i] * t[0] + vh[i] * t[1]) + r[1] * (hv[i] * t[0] + hh[i] * t[1]);
                    self.amplitude[channel][i] = scale * heard;
                }
            }
        }
    }
}

/// Field components of the ports of one antenna, each found once.
struct Ports<F> {
    find: F,
    found: [Option<[Complex64; 2]>; 4],
}

impl<F: Fn(Polarisation) -> [Complex64; 2]> Ports<F> {
    fn new(find: F) -> Self {
        Self { find, found: [None; 4] }
    }

    fn of(&mut self, port: Polarisation) -> [Complex64; 2] {
        let place = usize::from(port.code() - 1);
        *self.found[place].get_or_insert_with(|| (self.find)(port))
    }
}
