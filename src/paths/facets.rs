//! The facets of the sea, as one emission and one receive window meet them.
//!
//! Facet `(ix, iy)` of the patch scatters from the place `x_grid + D + z up` (lowered on a curved Earth),
//! moving with the orbital velocity and acceleration while the pulse is under way; delay, rate, directions
//! and legs come from this one path ([`crate::geometry::light_time`]), so that the carrier phase of a facet
//! is a smooth function of slow time whose derivative is its Doppler. Tilt and area are those of the grid
//! position, with the slope of the mean surface added on a curved Earth; choppy waves have areas and tilts of
//! their own ([`crate::sea::surface::choppy`]). Its amplitude in a channel is
//!
//! `a = K / (R_t R_r)  g_t g_r  v_t v_r  (e_r^T S e_t)`
//!
//! with the radar equation's constant and legs ([`crate::radar::link`]), field gains and polarisations
//! ([`crate::radar::antenna`], [`crate::radar::polarisation`]), the visibility weights of both ends, and the
//! matrix `S` of [`crate::scattering::water`].
//!
//! Facets are visited in chunks, within a chunk ordered by kind of surface. A facet is passed over where its
//! echo misses the window, where an antenna radiates nothing or is hidden, and where it scatters nothing.

use glam::{DMat3, DVec3};
use num_complex::Complex64;

use super::PairPlan;
use crate::frames::{Point, Vector};
use crate::geometry::bistatic::Basis;
use crate::geometry::light_time::{LightTime, bistatic_over};
use crate::motion::pointing::{PhaseCentre, Surroundings};
use crate::paths::emission::Emission;
use crate::radar::antenna::Antenna;
use crate::radar::polarisation::{PortBasis, field};
use crate::radar::window::Window;
use crate::scattering::facets::Facets;
use crate::scattering::land::LandScattering;
use crate::scattering::water::WaterScattering;
use crate::scene::Patch;
use crate::scene::radar::{Polarisation, Radar};
use crate::sea::land::LandSheet;
use crate::sea::surface::Fields;
use crate::sea::surface::modulation::look;
use crate::sea::wake::course::Pose;
use crate::time::TimeTag;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Facets handled side by side.
pub(super) const CHUNK: usize = 256;

/// What the facets of a chunk are.
#[derive(Clone, Copy)]
pub(super) enum Surfaces<'a> {
    /// Water of a kind, with ships at these poses.
    Water(&'a WaterScattering, &'a [Pose], usize),
    /// Land.
    Land(&'a LandScattering, &'a LandSheet),
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
    /// Lengths of both legs, m.
    legs_m: Vec<[f64; 2]>,
    /// Polarisation basis of the receive antenna at reception.
    rx_bases: Vec<PortBasis>,
}

/// Facets side by side.
#[derive(Clone, Default)]
pub(super) struct Chunk {
    /// Place in the patch.
    pub index: Vec<usize>,
    slope: [Vec<f64>; 2],
    cover: Vec<f64>,
    /// Modulation by the waves of the map, xx, yy, xy; empty without one.
    strain: Vec<[f64; 3]>,
    /// Factors of the pair at hand.
    modulation: Vec<f64>,
    phasors: Vec<Complex64>,
    /// Those of the pair at hand, where waves travel.
    of_pair: Vec<Complex64>,
    pub pairs: Vec<PairColumns>,
    /// `vv, vh, hv, hh`.
    matrix: [Vec<Complex64>; 4],
    /// `[channel]`.
    pub amplitude: Vec<Vec<Complex64>>,
}

/// The instant and circumstances of an emission.
#[derive(Clone, Copy)]
pub(super) struct Reception<'a> {
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
    /// One for all pairs, or one for each receiver; none: everything is received.
    pub windows: &'a [Window],
}

impl Reception<'_> {
    /// The window of a pair.
    pub fn window(&self, plan: &PairPlan) -> Window {
        self.windows.get(plan.window).copied().unwrap_or(Window::UNBOUNDED)
    }
}

/// Motion of a facet about the instant of the fields; `drop_m` is how far the mean surface lies below the
/// plane there.
pub(super) fn motion(fields: &Fields<f64>, index: usize, [x, y]: [f64; 2], drop_m: f64) -> PhaseCentre {
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

impl PairColumns {
    fn clear(&mut self) {
        let Self { delay_s, delay_rate, incident, scattered, scale, legs_m, rx_bases } = self;
        delay_s.clear();
        delay_rate.clear();
        incident.iter_mut().chain(scattered).for_each(Vec::clear);
        scale.clear();
        legs_m.clear();
        rx_bases.clear();
    }

    /// Unit directions to and from a facet.
    fn directions(&self, i: usize) -> [DVec3; 2] {
        [&self.incident, &self.scattered].map(|d| DVec3::new(d[0][i], d[1][i], d[2][i]))
    }

    fn reserve(&mut self) {
        let Self { delay_s, delay_rate, incident, scattered, scale, legs_m, rx_bases } = self;
        [delay_s, delay_rate].into_iter().chain(incident).chain(scattered).for_each(|c| c.reserve(CHUNK));
        scale.reserve(CHUNK);
        legs_m.reserve(CHUNK);
        rx_bases.reserve(CHUNK);
    }
}

impl Chunk {
    pub fn new(pairs: usize, channels: usize, mechanisms: usize) -> Self {
        let zeros = || vec![Complex64::ZERO; CHUNK];
        let mut chunk = Self {
            index: Vec::with_capacity(CHUNK),
            slope: [Vec::with_capacity(CHUNK), Vec::with_capacity(CHUNK)],
            cover: Vec::with_capacity(CHUNK),
            strain: Vec::with_capacity(CHUNK),
            modulation: Vec::with_capacity(CHUNK),
            phasors: Vec::with_capacity(CHUNK * mechanisms),
            of_pair: Vec::with_capacity(CHUNK * mechanisms),
            pairs: vec![PairColumns::default(); pairs],
            matrix: [zeros(), zeros(), zeros(), zeros()],
            amplitude: vec![zeros(); channels],
        };
        chunk.pairs.iter_mut().for_each(PairColumns::reserve);
        chunk
    }

    pub fn clear(&mut self) {
        self.index.clear();
        self.slope.iter_mut().for_each(Vec::clear);
        self.cover.clear();
        self.strain.clear();
        self.phasors.clear();
        self.pairs.iter_mut().for_each(PairColumns::clear);
    }

    /// Takes in the paths of a facet over every pair; of one that no pair receives nothing is kept. Says
    /// whether it was kept.
    pub fn see(
        &mut self,
        reception: &Reception,
        transmitters: usize,
        scatterer: &PhaseCentre,
        visible: impl Fn(usize) -> f64,
    ) -> bool {
        let mut kept = false;
        for (plan, columns) in reception.plans.iter().zip(&mut self.pairs) {
            let (tx, rx) = (plan.pair.transmitter, transmitters + plan.pair.receiver);
            let centres = &reception.emission.centres;
            let path = bistatic_over(LightTime::Exact, &centres[tx], scatterer, &centres[rx]);
            let mut scale = Complex64::ZERO;
            let rx_axes = reception.emission.axes_after(rx, path.delay_s, reception.axes_span_s);
            let within = reception.window(plan).touches(reception.offset_s + path.delay_s);
            if plan.receives(reception.tx_pol) && within {
                let seen = visible(tx) * visible(rx);
                let range = |leg_s: f64| leg_s * SPEED_OF_LIGHT_MPS;
                let link = plan.link.scattered(range(path.tx_leg_s), range(path.rx_leg_s));
                if seen > 0.0 && link > 0.0 {
                    let gain = |antenna: usize, axes: &DMat3, d: DVec3| {
                        reception.antennas[antenna].field_gain(Vector::from_raw(axes.transpose() * d))
                    };
                    let tx_axes = reception.emission.axes(tx);
                    scale = gain(tx, &tx_axes, path.incident)
                        * gain(rx, &rx_axes, -path.scattered)
                        * (link * seen);
                }
            }
            kept |= scale != Complex64::ZERO;
            columns.delay_s.push(path.delay_s);
            columns.delay_rate.push(path.delay_rate);
            for (column, d) in columns.incident.iter_mut().zip(path.incident.to_array()) {
                column.push(d);
            }
            for (column, d) in columns.scattered.iter_mut().zip(path.scattered.to_array()) {
                column.push(d);
            }
            columns.scale.push(scale);
            columns.legs_m.push([path.tx_leg_s, path.rx_leg_s].map(|leg_s| leg_s * SPEED_OF_LIGHT_MPS));
            let span_s = reception.axes_span_s;
            columns.rx_bases.push(reception.emission.basis_after(rx, path.delay_s, span_s));
        }
        if !kept {
            for columns in &mut self.pairs {
                columns.delay_s.pop();
                columns.delay_rate.pop();
                columns.incident.iter_mut().chain(&mut columns.scattered).for_each(|c| {
                    c.pop();
                });
                columns.scale.pop();
                columns.legs_m.pop();
                columns.rx_bases.pop();
            }
        }
        kept
    }

    /// Takes in the rest of a facet whose paths are in: its place in the patch, its tilt, what modulates
    /// it, the share its kind covers, its random phasors.
    pub fn take(
        &mut self,
        index: usize,
        slope: [f64; 2],
        strain: Option<[f64; 3]>,
        cover: f64,
        phasors: &[Complex64],
    ) {
        self.strain.extend(strain);
        self.index.push(index);
        self.slope.iter_mut().zip(slope).for_each(|(column, slope)| column.push(slope));
        self.cover.push(cover);
        self.phasors.extend_from_slice(phasors);
    }

    /// The facet taken in last has an area, over that of the grid.
    pub fn stretch_last(&mut self, area: f64) {
        let scales = self.pairs.iter_mut().filter_map(|columns| columns.scale.last_mut());
        scales.for_each(|scale| *scale *= area.sqrt());
    }

    /// Matrices of the water over a pair; says whether they are sound.
    fn scatter_water(
        &mut self,
        (water, poses, kind): (&WaterScattering, &[Pose], usize),
        pair: usize,
        elapsed_s: f64,
        patch: &Patch,
    ) -> bool {
        let columns = &self.pairs[pair];
        let phasors = match water.travelling() {
            None => &self.phasors,
            Some(_) => {
                self.of_pair.clone_from(&self.phasors);
                for (i, own) in self.of_pair.chunks_exact_mut(water.mechanisms()).enumerate() {
                    let key = patch.key(self.index[i]);
                    water.travel(key, columns.directions(i).into(), elapsed_s, own);
                }
                &self.of_pair
            }
        };
        let strength = water.strength();
        self.modulation.clear();
        self.modulation.extend(self.strain.iter().enumerate().map(|(i, tensor)| {
            let [incident, scattered] = columns.directions(i);
            let q = scattered - incident;
            strength.factor(*tensor, look([q.x, q.y]))
        }));
        let facets = Facets {
            incident: columns.incident.each_ref().map(Vec::as_slice),
            scattered: columns.scattered.each_ref().map(Vec::as_slice),
            slope_x: &self.slope[0],
            slope_y: &self.slope[1],
            cover: &self.cover,
            phasors,
            modulation: &self.modulation,
            footprint_m2: patch.facet_m * patch.facet_m,
        };
        let [vv, vh, hv, hh] = &mut self.matrix;
        let place_m = |i: usize| patch.centre_m(patch.key(self.index[i]));
        water.scatter_at(kind, &facets, place_m, poses, [vv, vh, hv, hh]).is_ok()
    }

    /// Matrices of the land over a pair.
    fn scatter_land(&mut self, land: &LandScattering, sheet: &LandSheet, pair: usize, patch: &Patch) {
        let columns = &self.pairs[pair];
        for (i, &index) in self.index.iter().enumerate() {
            let phasors = sheet
                .phasors()
                .each_ref()
                .map(|[re, im]| Complex64::new(f64::from(re[index]), f64::from(im[index])));
            let slope = [self.slope[0][i], self.slope[1][i]];
            let footprint_m2 = patch.facet_m * patch.facet_m;
            let matrix = land.matrix(columns.directions(i), slope, footprint_m2, phasors);
            for (column, entry) in self.matrix.iter_mut().zip(matrix.as_flattened()) {
                column[i] = *entry;
            }
        }
    }

    /// Amplitudes of all facets of the chunk, which are of one kind.
    pub fn scatter(&mut self, reception: &Reception, surface: Surfaces<'_>, patch: &Patch) {
        let count = self.index.len();
        for column in &mut self.amplitude {
            column.resize(count, Complex64::ZERO);
            column.fill(Complex64::ZERO);
        }
        for (pair, plan) in reception.plans.iter().enumerate() {
            for entry in &mut self.matrix {
                entry.resize(count, Complex64::ZERO);
            }
            match surface {
                Surfaces::Land(land, sheet) => self.scatter_land(land, sheet, pair, patch),
                Surfaces::Water(water, poses, kind) => {
                    if !self.scatter_water((water, poses, kind), pair, reception.elapsed_s, patch) {
                        debug_assert!(false, "columns of a chunk differ in length");
                        continue;
                    }
                }
            }
            let columns = &self.pairs[pair];
            let [vv, vh, hv, hh] = &self.matrix;
            let (tx, rx) = (plan.pair.transmitter, plan.pair.receiver);
            let tx_basis = reception.emission.basis(tx);
            let tx_errors = reception.radar.transmitters[tx].antenna.ports;
            let rx_errors = reception.radar.receivers[rx].antenna.ports;
            for i in 0..count {
                let scale = columns.scale[i];
                if scale == Complex64::ZERO {
                    continue;
                }
                let [incident, scattered] = columns.directions(i);
                let (basis_in, basis_out) = (Basis::of(incident), Basis::of(scattered));
                let mut e_t = Ports::new(|port| field(&tx_basis, port, tx_errors, incident, &basis_in));
                let mut e_r =
                    Ports::new(|port| field(&columns.rx_bases[i], port, rx_errors, -scattered, &basis_out));
                for &(channel, tx_port, rx_port) in &plan.channels {
                    if reception.tx_pol.is_some_and(|port| port != tx_port) {
                        continue;
                    }
                    let (t, r) = (e_t.of(tx_port), e_r.of(rx_port));
                    let received =
                        r[0] * (vv[i] * t[0] + vh[i] * t[1]) + r[1] * (hv[i] * t[0] + hh[i] * t[1]);
                    let (legs_m, rises) = (columns.legs_m[i], [incident.z, scattered.z]);
                    let rain = plan.link.in_rain([tx_port, rx_port], legs_m, rises);
                    self.amplitude[channel][i] = scale * received * rain;
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
