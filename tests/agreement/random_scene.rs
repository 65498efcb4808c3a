//! Random legal scenarios: the same seed is the same file, whatever was drawn before.
//!
//! Drones near by, aircraft, coasts, ships' radars, orbits and pairs of these, over all bands, spectra,
//! antennas and options of the sea, on patches so small that all pulses can be compared. Some antennas stand
//! in the patch or pass over it, and look past what lies below them. The window holds the echo of the whole
//! patch, or now and then half of it; of a patch about an antenna sometimes only what is farther away.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::random_ends::{antennas, emitters, more_ends};
use super::random_turns::turning;
use super::random_waveforms::{continuous, dechirp, in_turn, waveform};

pub(super) const LIGHT_MPS: f64 = 299_792_458.0;
/// Keeps draws of slow time apart from those of the rest.
const SLOW_TIME: u64 = 0x510;
/// And those of the amplitudes of facets.
const SPECKLE: u64 = 0x5BEC;
/// And those of echoes that overlap.
const OVERLAP: u64 = 0x0E1A;
/// And those of further transmitters and receivers.
const ENDS: u64 = 0xE4D5;
/// And those of emitters beside.
const EMITTERS: u64 = 0x0E17;
/// And those of kinds of waveforms.
const WAVEFORMS: u64 = 0x3A7E;
/// And those of continuous signals.
const STREAMS: u64 = 0x57EA;
const IN_TURN: u64 = 0x1274;
/// And those of errors between blocks and exact pulses.
const FINE: u64 = 0xF1E;
/// The same of coarse errors, and of narrow beams.
const COARSE: u64 = 0xC0A5E;
const NARROW: u64 = 0x4A660;
/// And those of antennas that scan, and tapers.
const SCAN: u64 = 0x5CA4;

/// And those of targets and ships on tracks.
const TURNS: u64 = 0x7042;
/// And those of the sea beyond the patch.
const FAR: u64 = 0xFA45;

/// Legal winds of the sea, m/s, and sides of facets, m.
const LEGAL_WIND_MPS: [f64; 2] = [0.01, 40.0];
const LEGAL_FACET_M: [f64; 2] = [1e-4, 1e5];

/// Most from one update of the shadows to the next, ms.
const LONGEST_UPDATE_MS: f64 = 60.0;

/// A scenario file.
pub struct RandomScene {
    /// Which kind of scene, for the list.
    pub family: &'static str,
    /// Error that is asked, dB.
    pub asked_db: f64,
    /// The file.
    pub text: String,
}

/// Where an antenna flies: at pulse 0, and how fast.
#[derive(Clone, Copy)]
pub(super) struct Flight {
    pub(super) position_m: [f64; 3],
    pub(super) velocity_mps: [f64; 3],
}

pub(super) struct Draw(pub(super) ChaCha8Rng);

impl Draw {
    pub(super) fn between(&mut self, from: f64, to: f64) -> f64 {
        self.0.random_range(from..to)
    }

    /// Evenly over the logarithm.
    pub(super) fn log(&mut self, from: f64, to: f64) -> f64 {
        self.between(from.ln(), to.ln()).exp()
    }

    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.0.random_bool(share)
    }

    pub(super) fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.0.next_u64() % of.len() as u64) as usize]
    }

    pub(super) fn angle(&mut self) -> f64 {
        self.between(0.0, TAU)
    }
}

/// What a kind of platform does.
pub(super) struct Kind {
    name: &'static str,
    height_m: [f64; 2],
    /// Horizontal distance from the patch, over the height.
    away: [f64; 2],
    speed_mps: [f64; 2],
    carriers_hz: &'static [f64],
    facet_m: [f64; 2],
    prf_hz: [f64; 2],
    pulse_s: [f64; 2],
}

const KINDS: [Kind; 5] = [
    Kind {
        name: "drone",
        height_m: [10.0, 120.0],
        away: [0.3, 3.0],
        speed_mps: [2.0, 25.0],
        carriers_hz: &[5.4e9, 9.65e9, 16e9, 24e9, 35e9],
        facet_m: [0.1, 0.6],
        prf_hz: [400.0, 4000.0],
        pulse_s: [0.05e-6, 0.4e-6],
    },
    Kind {
        name: "aircraft",
        height_m: [300.0, 6000.0],
        away: [0.3, 3.0],
        speed_mps: [40.0, 250.0],
        carriers_hz: &[1.3e9, 3e9, 5.4e9, 10e9, 16e9],
        facet_m: [0.5, 4.0],
        prf_hz: [100.0, 1500.0],
        pulse_s: [0.2e-6, 3e-6],
    },
    Kind {
        name: "coast",
        height_m: [8.0, 80.0],
        away: [5.0, 30.0],
        speed_mps: [0.0, 1e-9],
        carriers_hz: &[3e9, 9.4e9, 10e9, 16e9],
        facet_m: [0.5, 3.0],
        prf_hz: [500.0, 3000.0],
        pulse_s: [0.1e-6, 1e-6],
    },
    Kind {
        name: "ship",
        height_m: [6.0, 30.0],
        away: [4.0, 25.0],
        speed_mps: [3.0, 18.0],
        carriers_hz: &[3e9, 9.4e9, 10e9],
        facet_m: [0.5, 3.0],
        prf_hz: [500.0, 3000.0],
        pulse_s: [0.1e-6, 1e-6],
    },
    Kind {
        name: "orbit",
        height_m: [400e3, 800e3],
        away: [0.3, 1.0],
        speed_mps: [7300.0, 7700.0],
        carriers_hz: &[1.26e9, 5.4e9, 9.65e9],
        facet_m: [6.0, 30.0],
        prf_hz: [1200.0, 3000.0],
        pulse_s: [2e-6, 15e-6],
    },
];

/// Writes a line of the file.
macro_rules! line {
    ($out:expr, $($arg:tt)*) => { writeln!($out, $($arg)*).unwrap() };
}
pub(super) use line;

/// What is measured from where.
#[derive(Clone, Copy)]
pub(super) struct Geometry {
    pub(super) kind: &'static Kind,
    pub(super) partner: &'static Kind,
    pub(super) bistatic: bool,
    pub(super) carrier_hz: f64,
    facet_m: f64,
    pub(super) size_m: [f64; 2],
    pub(super) prf_hz: f64,
    pub(super) lasts_s: f64,
    pub(super) own: Flight,
    pub(super) other: Flight,
    /// Whether an antenna is above the patch.
    pub(super) above: bool,
}

/// Waveform and receive window.
pub(super) struct Signal {
    pub(super) bandwidth_hz: f64,
    pub(super) rate_hz: f64,
    pub(super) pulse_s: f64,
    pub(super) opens_s: f64,
    pub(super) samples: u64,
}

/// What is drawn from the whole legal range instead of what fits the platform.
#[derive(Clone, Copy)]
struct Extremes {
    wind_mps: Option<f64>,
    facet_m: Option<f64>,
}

impl Extremes {
    /// Of a stream of its own: all else of a seed stays.
    fn drawn(seed: u64) -> Self {
        let mut draw = Draw(ChaCha8Rng::seed_from_u64(!seed));
        let mut some = |share: f64, [from, to]: [f64; 2]| {
            draw.chance(share).then(|| format!("{:.3e}", draw.log(from, to)).parse().unwrap())
        };
        let (wind_mps, facet_m) = (some(0.25, LEGAL_WIND_MPS), some(0.1, LEGAL_FACET_M));
        Self { wind_mps: if draw.chance(0.02) { Some(0.0) } else { wind_mps }, facet_m }
    }
}

/// The scenario of a seed.
pub fn random_scene(seed: u64) -> RandomScene {
    let mut draw = Draw(ChaCha8Rng::seed_from_u64(seed));
    let extremes = Extremes::drawn(seed);
    let mut geometry = Geometry::drawn(&mut draw, extremes);
    let mut signal = Signal::drawn(&mut draw, &geometry);
    overlap(&mut Draw(ChaCha8Rng::seed_from_u64(seed ^ OVERLAP)), &mut geometry, &mut signal);
    let mut kinds = Draw(ChaCha8Rng::seed_from_u64(seed ^ WAVEFORMS));
    let mut streams = Draw(ChaCha8Rng::seed_from_u64(seed ^ STREAMS));
    let dechirp = dechirp(&mut kinds, &geometry, &mut signal);
    let asked_db = draw.one(&[-30.0, -40.0, -45.0, -50.0, -60.0, -60.0, -60.0, -70.0, -75.0, -80.0]);
    let mut fine = Draw(ChaCha8Rng::seed_from_u64(seed ^ FINE));
    let asked_db = if fine.chance(0.08) { fine.one(&[-90.0, -95.0]) } else { asked_db };
    let mut coarse = Draw(ChaCha8Rng::seed_from_u64(seed ^ COARSE));
    let asked_db = if coarse.chance(0.2) { coarse.one(&[-20.0, -25.0, -30.0, -35.0]) } else { asked_db };
    let family = geometry.kind.name;
    let partner = if geometry.bistatic { format!(" and {}", geometry.partner.name) } else { String::new() };
    let mut text = format!("# Random scene {seed}: {family}{partner}.\n");
    scene(&mut draw, &geometry, &mut text);
    // Draws of their own, so that the rest of a scene is what it was without them.
    let [mut slow, mut speckle] =
        [SLOW_TIME, SPECKLE].map(|salt| Draw(ChaCha8Rng::seed_from_u64(seed ^ salt)));
    sea(&mut draw, [&mut slow, &mut speckle], extremes, &mut text);
    far_sea(&mut Draw(ChaCha8Rng::seed_from_u64(seed ^ FAR)), (&geometry, extremes), &mut text);
    on_the_sea(&mut draw, &geometry, &mut text);
    turning(&mut Draw(ChaCha8Rng::seed_from_u64(seed ^ TURNS)), &geometry, &mut text);
    radar(&mut draw, [&mut slow, &mut kinds], (&geometry, &signal, dechirp), &mut text);
    platforms(&mut draw, &geometry, &mut text);
    let mut narrow = Draw(ChaCha8Rng::seed_from_u64(seed ^ NARROW));
    let times = if narrow.chance(0.2) { narrow.log(0.05, 0.5) } else { 1.0 };
    let mut scan = Draw(ChaCha8Rng::seed_from_u64(seed ^ SCAN));
    antennas([&mut draw, &mut scan], &geometry, times, &mut text);
    more_ends(&mut Draw(ChaCha8Rng::seed_from_u64(seed ^ ENDS)), (&geometry, &signal), &mut text);
    let mut beside = Draw(ChaCha8Rng::seed_from_u64(seed ^ EMITTERS));
    emitters([&mut beside, &mut kinds, &mut streams], (&geometry, &signal), &mut text);
    let mut turns = Draw(ChaCha8Rng::seed_from_u64(seed ^ IN_TURN));
    let text = in_turn(&mut turns, (&geometry, &signal), &text).unwrap_or(text);
    let mut text = continuous(&mut streams, (&geometry, &signal), &text).unwrap_or(text);
    line!(text, "[fidelity]\necho = \"fast\"\nerror_db = {asked_db:?}");
    line!(text, "[stream]\npace = \"fast\"\nthreads = 1");
    RandomScene { family, asked_db, text }
}

impl Geometry {
    fn drawn(draw: &mut Draw, extremes: Extremes) -> Self {
        let kind = &KINDS[(draw.0.next_u64() % KINDS.len() as u64) as usize];
        // Some pairs of unlike platforms: a coast receives a boat, an aircraft a satellite.
        let partner = match kind.name {
            "coast" => &KINDS[3],
            "aircraft" => &KINDS[if draw.chance(0.5) { 1 } else { 4 }],
            "drone" => &KINDS[if draw.chance(0.7) { 0 } else { 2 }],
            name => KINDS.iter().find(|other| other.name == name).unwrap(),
        };
        let bistatic = draw.chance(0.45);
        let carrier_hz = draw.one(kind.carriers_hz);
        let facet_m = draw.log(kind.facet_m[0], kind.facet_m[1]);
        let facet_m = extremes.facet_m.unwrap_or((facet_m * 100.0).round() / 100.0);
        let facets = [0, 1].map(|_| draw.one(&[8, 12, 16, 16, 20, 24, 24, 32]));
        let size_m = facets.map(|n| f64::from(n) * facet_m);
        let prf_hz = draw.log(kind.prf_hz[0], kind.prf_hz[1]).round();
        let pulses = draw.0.random_range(20..=80);
        let lasts_s = (f64::from(pulses) - 0.5) / prf_hz;
        let own = Flight::drawn(draw, kind, lasts_s);
        let other = if bistatic { Flight::drawn(draw, partner, lasts_s) } else { own };
        let above = kind.name != "orbit" && draw.chance(0.25);
        let own = if above { own.over(draw, size_m, lasts_s) } else { own };
        let other = if bistatic { other } else { own };
        Self { kind, partner, bistatic, carrier_hz, facet_m, size_m, prf_hz, lasts_s, own, other, above }
    }

    /// Least and greatest delay of the corners and the middle at both ends and in the middle of the run, with
    /// room for waves, s.
    pub(super) fn delays_s(&self) -> [f64; 2] {
        let mut places = vec![[-0.5, -0.5], [-0.5, 0.5], [0.5, -0.5], [0.5, 0.5], [0.0, 0.0]];
        // What lies nearest to either antenna at these times.
        for (flight, t_s) in [&self.own, &self.other].iter().flat_map(|of| [0.0, 0.5, 1.0].map(|s| (*of, s)))
        {
            let at = |i: usize| flight.position_m[i] + flight.velocity_mps[i] * t_s * self.lasts_s;
            places.push([0, 1].map(|i| (at(i) / self.size_m[i]).clamp(-0.5, 0.5)));
        }
        let (mut nearest_s, mut farthest_s) = (f64::INFINITY, 0.0f64);
        for t_s in [0.0, 0.5 * self.lasts_s, self.lasts_s] {
            for corner in &places {
                let leg = |flight: &Flight| {
                    let place = [corner[0] * self.size_m[0], corner[1] * self.size_m[1], 0.0];
                    let d = [0, 1, 2].map(|i| flight.position_m[i] + flight.velocity_mps[i] * t_s - place[i]);
                    d.iter().map(|x| x * x).sum::<f64>().sqrt()
                };
                let delay_s = (leg(&self.own) + leg(&self.other)) / LIGHT_MPS;
                (nearest_s, farthest_s) = (nearest_s.min(delay_s), farthest_s.max(delay_s));
            }
        }
        let waves_s = (6.0f64).min(0.3 * self.own.position_m[2]) / LIGHT_MPS;
        [(nearest_s - waves_s).max(0.0), farthest_s + waves_s]
    }
}

impl Flight {
    /// Abreast of the patch about the middle of the run.
    pub(super) fn drawn(draw: &mut Draw, kind: &Kind, lasts_s: f64) -> Self {
        let height_m = draw.log(kind.height_m[0], kind.height_m[1]);
        let away_m = height_m * draw.log(kind.away[0], kind.away[1]);
        let (bearing, speed_mps) = (draw.angle(), draw.between(kind.speed_mps[0], kind.speed_mps[1]));
        let course = if draw.chance(0.6) { bearing + 0.25 * TAU } else { draw.angle() };
        let climb_mps = if draw.chance(0.2) { 0.05 * speed_mps } else { 0.0 };
        let velocity_mps = if kind.name == "coast" {
            [0.0; 3]
        } else {
            [speed_mps * course.cos(), speed_mps * course.sin(), climb_mps]
        };
        let back_s = 0.5 * lasts_s;
        let at = [away_m * bearing.cos(), away_m * bearing.sin(), height_m];
        Self { position_m: [0, 1, 2].map(|i| at[i] - velocity_mps[i] * back_s), velocity_mps }
    }
}

impl Flight {
    /// The same over a place in the patch about the middle of the run.
    fn over(self, draw: &mut Draw, size_m: [f64; 2], lasts_s: f64) -> Self {
        let at = size_m.map(|side_m| draw.between(-0.5, 0.5) * side_m);
        let back_m = self.velocity_mps.map(|mps| 0.5 * mps * lasts_s);
        let height_m = self.position_m[2];
        Self { position_m: [at[0] - back_m[0], at[1] - back_m[1], height_m], ..self }
    }
}

impl Signal {
    /// A few to some tens of cells over the patch, and a window that is not too long.
    fn drawn(draw: &mut Draw, geometry: &Geometry) -> Self {
        let [nearest_s, farthest_s] = geometry.delays_s();
        let span_s = farthest_s - nearest_s;
        let cells = draw.log(3.0, 60.0);
        let longer_m = geometry.size_m[0].max(geometry.size_m[1]);
        let bandwidth_hz = (cells / (longer_m / LIGHT_MPS)).clamp(2e6, 400e6);
        let rate_hz = (bandwidth_hz * draw.between(1.15, 2.0)).min(1500.0 / span_s).max(1.1 * bandwidth_hz);
        let [shortest_s, longest_s] = geometry.kind.pulse_s;
        let pulse_s = draw
            .log(shortest_s, longest_s)
            .max(4.0 / bandwidth_hz)
            .min(0.3 / geometry.prf_hz)
            .min(3000.0 / rate_hz);
        let whole = draw.chance(0.85);
        let later_s = if geometry.above && draw.chance(0.5) { draw.between(0.0, 0.8) * span_s } else { 0.0 };
        let span_s = if whole { span_s - later_s } else { 0.5 * (span_s - later_s) };
        let samples = ((span_s + pulse_s) * rate_hz).ceil() as u64 + 8;
        Self { bandwidth_hz, rate_hz, pulse_s, opens_s: nearest_s + later_s, samples }
    }
}

/// Now and then as many pulses so close to each other that echoes of the patch last for about an interval, or
/// two, and come up to three late.
fn overlap(draw: &mut Draw, geometry: &mut Geometry, signal: &mut Signal) {
    if !draw.chance(0.2) {
        return;
    }
    // No window is shorter than its pulse, where intervals differ by a third as well.
    let least_s = 1.5 * signal.pulse_s + 64.0 / signal.rate_hz;
    let window_s = signal.samples as f64 / signal.rate_hz;
    let interval_s = (draw.log(0.4, 1.6) * window_s).max(least_s).min(1.0 / geometry.prf_hz);
    let prf_hz = (1.0 / interval_s).round();
    geometry.lasts_s *= geometry.prf_hz / prf_hz;
    geometry.prf_hz = prf_hz;
    // Windows do not overlap.
    signal.samples = signal.samples.min((0.98 * signal.rate_hz / prf_hz) as u64);
    let late = (signal.opens_s * prf_hz).floor().min(3.0);
    signal.opens_s -= (draw.between(0.0, late + 1.0)).floor().min(late) / prf_hz;
}

fn scene(draw: &mut Draw, geometry: &Geometry, out: &mut String) {
    let Geometry { lasts_s, size_m, facet_m, own, .. } = geometry;
    line!(out, "[scene]\nduration_s = {lasts_s:?}\nseed = {}\nearth = \"flat\"", draw.0.next_u64() >> 40);
    line!(out, "patch_size_m = {size_m:?}\nfacet_m = {facet_m:?}");
    let [x, y, _] = own.velocity_mps;
    // Between two updates of its shadows a patch may move by 64 facets, some of them while it is held.
    let moves = 1e-3 * LONGEST_UPDATE_MS * x.hypot(y) / facet_m;
    if own.velocity_mps != [0.0; 3] && draw.chance(0.15) && moves < 32.0 {
        line!(out, "patch = \"follow\"");
        line!(
            out,
            "patch_follow = {{ kind = \"point\", position_m = [0.0, 0.0, 0.0], velocity_mps = [{x:?}, {y:?}, 0.0] }}"
        );
    }
}

/// Swell, a slick, a ship, a target.
fn on_the_sea(draw: &mut Draw, geometry: &Geometry, out: &mut String) {
    let size_m = geometry.size_m;
    if draw.chance(0.3) {
        line!(
            out,
            "[[swell]]\nsignificant_height_m = {:?}\npeak_period_s = {:?}\nfrom_deg = {:?}",
            draw.between(0.2, 2.5),
            draw.between(4.0, 12.0),
            draw.between(0.0, 360.0)
        );
    }
    if draw.chance(0.12) {
        line!(
            out,
            "[[slick]]\ncentre_m = [0.0, 0.0]\nhalf_axes_m = [{:?}, {:?}]",
            (0.3 * size_m[0]).max(0.001),
            (0.2 * size_m[1]).max(0.001)
        );
    }
    if draw.chance(0.12) {
        let length_m = draw.log(4.0, 60.0).min(size_m[0]).max(0.05);
        line!(
            out,
            "[[ship]]\nhull = \"wigley\"\nlength_m = {length_m:?}\nbeam_m = {:?}\ndraught_m = {:?}\nposition_m = [{:?}, {:?}]\nheading_deg = {:?}\nspeed_mps = {:?}",
            0.13 * length_m,
            0.05 * length_m,
            0.2 * size_m[0],
            0.1 * size_m[1],
            draw.between(0.0, 360.0),
            (0.35 * (9.81 * length_m).sqrt()).min(12.0)
        );
    }
    if draw.chance(0.2) {
        line!(
            out,
            "[[target]]\nposition_m = [{:?}, {:?}, {:?}]\nvelocity_mps = [{:?}, 0.0, 0.0]\nrcs_dbsm = {:?}",
            draw.between(-0.4, 0.4) * size_m[0],
            draw.between(-0.4, 0.4) * size_m[1],
            draw.between(0.0, 2.0),
            draw.between(-8.0, 8.0),
            draw.between(-30.0, 20.0)
        );
    }
}

/// Intervals that differ, polarisations that alternate.
fn rhythm(draw: &mut Draw, prf_hz: f64, out: &mut String) {
    if draw.chance(0.25) {
        let most = draw.log(0.01, 0.3);
        let mut intervals = draw.one(&[2, 3, 5, 16]);
        let mut pri_us = Vec::new();
        while intervals > 0 {
            pri_us.push((1e6 / prf_hz * (1.0 + draw.between(-most, most)) * 100.0).round() / 100.0);
            intervals -= 1;
        }
        line!(out, "pri_us = {pri_us:?}");
    } else {
        line!(out, "prf_hz = {prf_hz:?}");
    }
    if draw.chance(0.2) {
        line!(out, "tx_polarisation = \"alternating\"");
    }
}

fn radar(
    draw: &mut Draw,
    [slow, kinds]: [&mut Draw; 2],
    (geometry, signal, dechirp): (&Geometry, &Signal, Option<f64>),
    out: &mut String,
) {
    let Geometry { carrier_hz, prf_hz, bistatic, .. } = geometry;
    let Signal { bandwidth_hz, rate_hz, pulse_s, opens_s, samples } = signal;
    line!(out, "[radar]\ncarrier_hz = {carrier_hz:?}\nsample_rate_hz = {rate_hz:?}");
    rhythm(slow, *prf_hz, out);
    let channels = draw.one(&[
        "[\"HH\"]",
        "[\"VV\"]",
        "[\"HH\", \"VV\"]",
        "[\"HH\", \"HV\", \"VH\", \"VV\"]",
        "[\"HH\", \"HV\", \"VH\", \"VV\"]",
        "[\"HH\", \"HV\", \"VV\"]",
        "[\"RR\", \"RL\"]",
    ]);
    line!(out, "channels = {channels}");
    if *bistatic && draw.chance(0.1) {
        line!(out, "direct_path = true");
    }
    if draw.chance(0.1) && channels.contains("VV") && !out.contains("tx_polarisation") {
        line!(out, "tx_polarisation = \"alternating\"");
    }
    // Up to where drops scatter by Rayleigh's law.
    if geometry.kind.name != "orbit" && *carrier_hz < 2e10 && draw.chance(0.06) {
        let (rain_mmph, top_m) = (draw.log(0.5, 20.0), draw.between(300.0, 4000.0));
        line!(out, "rain_mmph = {rain_mmph:?}\nrain_clutter = true\nrain_top_m = {top_m:?}");
    }
    let sweep = draw.one(&["up", "down"]);
    let sweep = format!("bandwidth_hz = {bandwidth_hz:?}\npulse_s = {pulse_s:?}\nsweep = \"{sweep}\"");
    let keys = match dechirp {
        Some(_) => vec!["kind = \"lfm\"".to_owned(), sweep],
        None => waveform(kinds, sweep, *bandwidth_hz, *pulse_s),
    };
    line!(out, "[radar.waveform]\n{}", keys.join("\n"));
    dechirp.iter().for_each(|delay_s| line!(out, "[radar.dechirp]\ndelay_us = {:?}", 1e6 * delay_s));
    line!(out, "[radar.window]\nsamples = {samples}\nstart_us = {:?}", 1e6 * opens_s);
}

fn platforms(draw: &mut Draw, geometry: &Geometry, out: &mut String) {
    let flights = [geometry.own, geometry.other];
    for (n, flight) in flights.iter().enumerate().take(if geometry.bistatic { 2 } else { 1 }) {
        line!(out, "[[platform]]\nname = \"p{n}\"");
        if flight.velocity_mps == [0.0; 3] {
            line!(out, "track = {{ kind = \"fixed\", position_m = {:?} }}", flight.position_m);
            continue;
        }
        line!(
            out,
            "track = {{ kind = \"straight\", position_m = {:?}, velocity_mps = {:?} }}",
            flight.position_m,
            flight.velocity_mps
        );
        if draw.chance(0.12) {
            line!(out, "errors = {{ preset = \"{}\" }}", draw.one(&["sps", "rtk", "tactical", "navigation"]));
        }
        if geometry.kind.name == "aircraft" && flight.position_m[2] < 1e4 && draw.chance(0.2) {
            line!(out, "turbulence = {{ level = \"{}\" }}", draw.one(&["light", "moderate"]));
        }
    }
}

fn sea(draw: &mut Draw, [slow, speckle]: [&mut Draw; 2], extremes: Extremes, out: &mut String) {
    let spectrum = draw.one(&[
        "elfouhaily",
        "elfouhaily",
        "elfouhaily-fung-lee",
        "fung-lee",
        "pierson-moskowitz",
        "jonswap",
    ]);
    let mut line = |text: String| writeln!(out, "{text}").unwrap();
    line("[sea]".to_owned());
    let (wind_mps, from_deg) = (draw.log(2.0, 18.0), draw.between(0.0, 360.0));
    let wind_mps = extremes.wind_mps.unwrap_or(wind_mps);
    line(format!("wind_mps = {wind_mps:?}\nwind_from_deg = {from_deg:?}"));
    line(format!("spectrum = \"{spectrum}\""));
    if spectrum == "jonswap" {
        line(format!("fetch_m = {:?}", draw.log(2e3, 2e5)));
    }
    if matches!(spectrum, "jonswap" | "pierson-moskowitz") {
        line(format!("spreading = \"{}\"", draw.one(&["mitsuyasu", "elfouhaily"])));
    }
    line("[sea.scattering]".to_owned());
    let paper = draw.chance(0.2);
    if paper {
        line("splitting = \"mars2007\"".to_owned());
    } else if draw.chance(0.35) {
        line("tilt_average = true".to_owned());
    }
    let single = draw.chance(0.25);
    if single {
        line("phases = \"single\"".to_owned());
    }
    if speckle.chance(0.25) {
        line("speckle = \"gaussian\"".to_owned());
        if !(paper || single) && speckle.chance(0.5) {
            line(format!("tilt_modes = {}", speckle.one(&[1u8, 6, 9])));
        }
    }
    if draw.chance(0.1) {
        line("gram_charlier = true".to_owned());
    }
    if draw.chance(0.15) {
        line("displacement = false".to_owned());
    }
    if slow.chance(0.2) {
        line(format!("bragg = \"frozen\"\ndecorrelation_ms = {:?}", slow.log(2.0, 500.0)));
    }
    line("[sea.shadow]".to_owned());
    if draw.chance(0.12) {
        line("enabled = false".to_owned());
    } else {
        if draw.chance(0.12) {
            line("edge = \"sharp\"".to_owned());
        }
        if draw.chance(0.4) {
            line(format!("update_ms = {:?}", draw.log(2.0, LONGEST_UPDATE_MS)));
        }
    }
}

/// The sea beyond the patch, of few cells, which reach off any mean Doppler the farthest.
fn far_sea(draw: &mut Draw, (geometry, extremes): (&Geometry, Extremes), out: &mut String) {
    let still = extremes.wind_mps.is_some_and(|wind_mps| wind_mps < 0.3);
    if geometry.kind.name == "orbit" || still || !draw.chance(0.1) {
        return;
    }
    let (cells, most) = (draw.one(&[1, 2, 4]), draw.log(256.0, 4000.0) as u32);
    line!(
        out,
        "[sea.far]\nenabled = true\ncells = {cells}\nmost_cells = {most}\ntexture = {}",
        draw.chance(0.7)
    );
}
