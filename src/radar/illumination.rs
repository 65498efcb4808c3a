//! What a receive window gets: every path of every emission whose echo falls into it.
//!
//! For pulse `n` the platforms are put where they are at its exact emission time, antennas point as their servos make them,
//! the window opens, and each target and the direct path become a contact per transmitter-receiver pair:
//! exact light time and its rate ([`crate::geometry::light_time`]), amplitude by the radar equation
//! ([`super::link`]) with the gains and polarisations of that instant.
//!
//! Emissions and windows are separate sequences. The window of pulse `n` opens `window_start` after emission `n`, which may
//! be more than one PRI (several pulses in the air). It sums every emission `e` of the run (the transmitter is silent before
//! pulse 0 and after the last one) with an echo in it. The geometry of an echo is that of its own emission; so is its
//! transmit polarisation: a channel hears only emissions that carry its own.
//!
//! An echo belongs to the window when `[arrival, arrival + Tc]` touches the window widened by
//! [`RINGING_SAMPLES`] on both sides (what the receive filter rings). Orientation of a receive antenna is that
//! at the emission: during the flight it turns less than 5e-5 rad from orbit, 2e-6 rad in an aircraft.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex64;
use thiserror::Error;

use super::antenna::{Antenna, field_components, port_axis};
use super::filter::RINGING_SAMPLES;
use super::link::{Link, received};
use super::pattern::PatternError;
use crate::frames::{Antenna as AntennaFrame, Body, Enu, Rotation, Vector};
use crate::geometry::light_time::{Mover, Path, bistatic, direct};
use crate::motion::pointing::{PhaseCentre, aim_point, mount, phase_centre, servo, servo_bias};
use crate::motion::{PlatformTracks, State, Track, TrackError};
use crate::pulse::{PlatformRecord, Pulse, flags};
use crate::scattering::contact::Contacts;
use crate::scattering::target;
use crate::scene::Scene;
use crate::scene::radar::{Aim, AimFrom, AntennaMount, Gate, Pair, Pointing, Polarisation};
use crate::time::TimeTag;

/// Bound on `|d tau/dt|` used to look for echoes of other emissions: 150 km/s on both ends.
const FASTEST_RATE: f64 = 1e-3;

/// One fault of an instrument or of its way through the scene.
#[derive(Debug, Error)]
pub enum RadarFault {
    /// A pattern file.
    #[error("antenna '{antenna}': {source}")]
    Pattern {
        /// The antenna.
        antenna: String,
        /// What is wrong.
        source: PatternError,
    },
    /// A track does not cover the run.
    #[error("platform '{platform}', {role} track: {source}")]
    Coverage {
        /// The platform.
        platform: String,
        /// `true` or `reported`.
        role: &'static str,
        /// What is missing.
        source: TrackError,
    },
    /// Tracks and platforms do not match.
    #[error("{found} tracks for {expected} platforms; allowed: one each")]
    Tracks {
        /// Tracks given.
        found: usize,
        /// Platforms of the scene.
        expected: usize,
    },
}

/// Everything wrong with an instrument.
#[derive(Debug, Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct RadarError(pub Vec<RadarFault>);

/// An antenna, ready.
#[derive(Clone, Debug)]
struct Instrument {
    platform: usize,
    lever_arm: Vector<Body>,
    antenna: Antenna,
    pointing: Look,
    isolation_db: Option<f64>,
}

#[derive(Clone, Debug)]
enum Look {
    Mounted(Rotation<AntennaFrame, Body>),
    Servo { aim: Aim, aim_from: AimFrom, lag_s: f64, bias: Rotation<AntennaFrame, AntennaFrame> },
}

/// A channel, by the places of its parts.
#[derive(Clone, Copy, Debug)]
struct Row {
    pair: usize,
    tx: Polarisation,
    tx_axis: [Complex64; 2],
    rx_axis: [Complex64; 2],
}

/// An antenna at an emission.
#[derive(Clone, Copy, Debug)]
struct End {
    motion: Mover,
    /// ENU to antenna.
    inward: Rotation<Enu, AntennaFrame>,
    y_a: DVec3,
    z_a: DVec3,
}

/// The radar in its scene. Immutable, shared by all threads.
#[derive(Clone, Debug)]
pub struct Illumination {
    scene: Scene,
    tracks: Vec<PlatformTracks>,
    transmitters: Vec<Instrument>,
    powers_w: Vec<f64>,
    receivers: Vec<Instrument>,
    pairs: Vec<Pair>,
    rows: Vec<Row>,
    channel_pairs: Vec<usize>,
    link: Link,
    pulse_length_s: f64,
}

/// What a thread needs to evaluate pulses without allocating.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    transmitters: Vec<End>,
    receivers: Vec<End>,
    paths: Vec<Path>,
}

/// The receive window relative to an emission.
#[derive(Clone, Copy, Debug)]
struct Window {
    start_s: f64,
    end_s: f64,
    /// Widening on both sides.
    guard_s: f64,
}

impl Window {
    fn touches(&self, arrival_s: f64, length_s: f64) -> bool {
        arrival_s + length_s >= self.start_s - self.guard_s && arrival_s <= self.end_s + self.guard_s
    }

    fn holds(&self, arrival_s: f64, length_s: f64) -> bool {
        arrival_s >= self.start_s && arrival_s + length_s <= self.end_s
    }
}

impl Illumination {
    /// Reads the pattern files and checks that the tracks cover the run. All faults at once.
    pub fn new(scene: &Scene, tracks: Vec<PlatformTracks>, pulse_length_s: f64) -> Result<Self, RadarError> {
        let radar = &scene.radar;
        let mut faults = Vec::new();
        if tracks.len() != scene.platforms.len() {
            let (found, expected) = (tracks.len(), scene.platforms.len());
            return Err(RadarError(vec![RadarFault::Tracks { found, expected }]));
        }
        let wavelength_m = radar.wavelength_m();
        let mut ready = |name: &str, mounted: &AntennaMount| match Instrument::new(mounted, wavelength_m) {
            Ok(instrument) => Some(instrument),
            Err(source) => {
                faults.push(RadarFault::Pattern { antenna: name.to_owned(), source });
                None
            }
        };
        let transmitters: Vec<_> =
            radar.transmitters.iter().filter_map(|t| ready(&t.name, &t.antenna)).collect();
        let receivers: Vec<_> = radar.receivers.iter().filter_map(|r| ready(&r.name, &r.antenna)).collect();
        let longest_lag_s =
            transmitters.iter().chain(&receivers).map(|i| i.pointing.lag_s()).fold(0.0, f64::max);
        let from = scene.start.plus(-longest_lag_s);
        let to = radar.emissions.emission(scene.start, scene.pulses.saturating_sub(1));
        for (platform, tracks) in scene.platforms.iter().zip(&tracks) {
            for (role, track) in [("true", &tracks.truth), ("reported", &tracks.reported)] {
                if let Err(source) = track.covers(from, to) {
                    faults.push(RadarFault::Coverage { platform: platform.clone(), role, source });
                }
            }
        }
        if !faults.is_empty() {
            return Err(RadarError(faults));
        }
        let pairs = radar.pairs();
        let rows: Vec<Row> = radar
            .channels
            .iter()
            .filter_map(|channel| {
                let pair = Pair { transmitter: channel.transmitter, receiver: channel.receiver };
                Some(Row {
                    pair: pairs.iter().position(|p| *p == pair)?,
                    tx: channel.tx,
                    tx_axis: port_axis(channel.tx, transmitters[channel.transmitter].isolation_db),
                    rx_axis: port_axis(channel.rx, receivers[channel.receiver].isolation_db),
                })
            })
            .collect();
        Ok(Self {
            channel_pairs: rows.iter().map(|row| row.pair).collect(),
            powers_w: radar.transmitters.iter().map(|t| t.power_w).collect(),
            link: Link::new(radar),
            scene: scene.clone(),
            tracks,
            transmitters,
            receivers,
            pairs,
            rows,
            pulse_length_s,
        })
    }

    /// Pair of each channel.
    pub fn channel_pairs(&self) -> &[usize] {
        &self.channel_pairs
    }

    /// Memory for one thread.
    pub fn scratch(&self) -> Scratch {
        Scratch {
            transmitters: Vec::with_capacity(self.transmitters.len()),
            receivers: Vec::with_capacity(self.receivers.len()),
            paths: Vec::with_capacity(self.pairs.len()),
        }
    }

    /// Fills the record of pulse `index` (all but its samples) and the contacts of its receive window. The
    /// flags are set anew.
    pub fn pulse(&self, index: u64, contacts: &mut Contacts, record: &mut Pulse, scratch: &mut Scratch) {
        let radar = &self.scene.radar;
        let time = self.emission(index);
        record.index = index;
        record.time = time;
        record.flags = 0;
        record.tx_pol = radar.tx_polarisation.of_pulse(index).map_or(0, Polarisation::code);
        for (tracks, (truth, reported)) in
            self.tracks.iter().zip(record.nav_true.iter_mut().zip(&mut record.nav_reported))
        {
            *truth = platform_record(&state(&tracks.truth, time));
            *reported = platform_record(&state(&tracks.reported, time));
        }
        record.window_start_s = self.window_start_s(time);
        let rate_hz = radar.sample_rate_hz;
        let window = Window {
            start_s: record.window_start_s,
            end_s: record.window_start_s + radar.window.samples as f64 / rate_hz,
            guard_s: RINGING_SAMPLES as f64 / rate_hz,
        };

        contacts.clear();
        self.place_ends(time, scratch);
        for (centre, end) in
            record.phase_centre_m.iter_mut().zip(scratch.transmitters.iter().chain(&scratch.receivers))
        {
            *centre = end.motion.position_m.to_array();
        }
        let delays = self.own_echoes(index, time, &window, contacts, record, scratch);
        for other in self.other_emissions(index, &window, &delays) {
            let offset_s = self.offset_s(index, other);
            let time = self.emission(other);
            self.place_ends(time, scratch);
            self.echoes(other, time, offset_s, &window, contacts, scratch, |_, _| {});
        }
    }

    fn emission(&self, index: u64) -> TimeTag {
        self.scene.radar.emissions.emission(self.scene.start, index)
    }

    /// Emission `other` minus emission `index`, s.
    fn offset_s(&self, index: u64, other: u64) -> f64 {
        self.scene.radar.emissions.interval_s(index, other)
    }

    /// The echoes of the pulse itself, with their truth; returns the range of all delays.
    fn own_echoes(
        &self,
        index: u64,
        time: TimeTag,
        window: &Window,
        contacts: &mut Contacts,
        record: &mut Pulse,
        scratch: &mut Scratch,
    ) -> Range<f64> {
        let mut delays = f64::INFINITY..f64::NEG_INFINITY;
        let targets = self.scene.targets.len();
        let carrier_hz = self.scene.radar.carrier_hz;
        let (length_s, pairs) = (self.pulse_length_s, self.pairs.len());
        self.echoes(index, time, 0.0, window, contacts, scratch, |what, paths| {
            for (pair, path) in paths.iter().enumerate().take(pairs) {
                delays.start = delays.start.min(path.delay_s);
                delays.end = delays.end.max(path.delay_s);
                if !window.holds(path.delay_s, length_s) {
                    record.flags |= flags::OUTSIDE_WINDOW;
                }
                if let Some(target) = what {
                    record.target_delay_s[pair * targets + target] = path.delay_s;
                    record.target_doppler_hz[pair * targets + target] = path.doppler_hz(carrier_hz);
                }
            }
        });
        delays
    }

    /// Other emissions that may have an echo in the window, from the delays of this one.
    fn other_emissions(
        &self,
        index: u64,
        window: &Window,
        delays: &Range<f64>,
    ) -> impl Iterator<Item = u64> + use<> {
        let reach = |offset_s: f64| {
            let margin_s = FASTEST_RATE * offset_s.abs() + 1e-6;
            let first = offset_s + delays.start - margin_s;
            let last = offset_s + delays.end + margin_s + self.pulse_length_s;
            (last >= window.start_s - window.guard_s, first <= window.end_s + window.guard_s)
        };
        let (mut from, mut to) = (index, index);
        if delays.start <= delays.end {
            // Arrivals move with the emission, so each side ends at its first emission out of reach.
            while from > 0 && reach(self.offset_s(index, from - 1)).0 {
                from -= 1;
            }
            while to + 1 < self.scene.pulses && reach(self.offset_s(index, to + 1)).1 {
                to += 1;
            }
        }
        (from..=to).filter(move |other| *other != index)
    }

    /// Puts the antennas where they are at an emission.
    fn place_ends(&self, time: TimeTag, scratch: &mut Scratch) {
        scratch.transmitters.clear();
        scratch.transmitters.extend(self.transmitters.iter().map(|i| self.end(i, time)));
        scratch.receivers.clear();
        scratch.receivers.extend(self.receivers.iter().map(|i| self.end(i, time)));
    }

    fn end(&self, instrument: &Instrument, time: TimeTag) -> End {
        let truth = state(&self.tracks[instrument.platform].truth, time);
        let outward: Rotation<AntennaFrame, Enu> = match &instrument.pointing {
            Look::Mounted(mount) => mount.then(truth.attitude),
            Look::Servo { aim, aim_from, lag_s, bias } => {
                let then = time.plus(-lag_s);
                let known = state(self.known(instrument.platform, *aim_from), then);
                let aim = aim_point(aim, then.since(self.scene.start), &self.scene.frame, |platform| {
                    state(self.known(platform, *aim_from), then)
                });
                servo(&known, instrument.lever_arm, aim, truth.attitude, *bias)
            }
        };
        End {
            motion: motion(&phase_centre(&truth, instrument.lever_arm)),
            inward: outward.inverse(),
            y_a: (outward * Vector::new(0.0, 1.0, 0.0)).raw(),
            z_a: (outward * Vector::new(0.0, 0.0, 1.0)).raw(),
        }
    }

    fn known(&self, platform: usize, aim_from: AimFrom) -> &Track {
        match aim_from {
            AimFrom::Reported => &self.tracks[platform].reported,
            AimFrom::True => &self.tracks[platform].truth,
        }
    }

    /// Opening of the window after the emission, s.
    fn window_start_s(&self, time: TimeTag) -> f64 {
        let (aim, lead_s, aim_from) = match &self.scene.radar.window.gate {
            Gate::Fixed { start_s } => return *start_s,
            Gate::Follow { aim, lead_s, aim_from } => (aim, lead_s, *aim_from),
        };
        let Some(pair) = self.pairs.first() else { return 0.0 };
        let known = |platform: usize| state(self.known(platform, aim_from), time);
        let point = aim_point(aim, time.since(self.scene.start), &self.scene.frame, known);
        let centre = |i: &Instrument| motion(&phase_centre(&known(i.platform), i.lever_arm));
        let there = Mover { position_m: point.raw(), ..Mover::default() };
        let tx = centre(&self.transmitters[pair.transmitter]);
        let rx = centre(&self.receivers[pair.receiver]);
        bistatic(&tx, &there, &rx).delay_s - lead_s
    }

    /// Appends the contacts of an emission that fall into the window, and shows the paths of every target (and
    /// of the direct path, as `None`), fallen in or not.
    fn echoes(
        &self,
        emission: u64,
        time: TimeTag,
        offset_s: f64,
        window: &Window,
        contacts: &mut Contacts,
        scratch: &mut Scratch,
        mut show: impl FnMut(Option<usize>, &[Path]),
    ) {
        let only = self.scene.radar.tx_polarisation.of_pulse(emission);
        let since_start_s = time.since(self.scene.start);
        let falls_in = |paths: &[Path]| {
            paths.iter().any(|path| window.touches(offset_s + path.delay_s, self.pulse_length_s))
        };
        let Scratch { transmitters, receivers, paths } = scratch;
        for (place, target) in self.scene.targets.iter().enumerate() {
            let scatterer = target::mover(target, since_start_s);
            paths.clear();
            paths.extend(self.pairs.iter().map(|pair| {
                bistatic(&transmitters[pair.transmitter].motion, &scatterer, &receivers[pair.receiver].motion)
            }));
            show(Some(place), paths);
            if falls_in(paths) {
                self.append(contacts, offset_s, paths, |row, path| {
                    let pair = self.pairs[row.pair];
                    let (tx, rx) = (&transmitters[pair.transmitter], &receivers[pair.receiver]);
                    let (out, back) =
                        (path.bounce_m - tx.motion.position_m, path.bounce_m - path.reception_m);
                    self.scattered(row, only, tx, rx, out, back, &target.scattering)
                });
            }
        }
        if self.scene.radar.direct_path {
            paths.clear();
            paths.extend(self.pairs.iter().map(|pair| {
                direct(&transmitters[pair.transmitter].motion, &receivers[pair.receiver].motion)
            }));
            show(None, paths);
            if falls_in(paths) {
                self.append(contacts, offset_s, paths, |row, path| {
                    let pair = self.pairs[row.pair];
                    let (tx, rx) = (&transmitters[pair.transmitter], &receivers[pair.receiver]);
                    self.direct(row, only, tx, rx, path.reception_m - tx.motion.position_m)
                });
            }
        }
    }

    fn append(
        &self,
        contacts: &mut Contacts,
        offset_s: f64,
        paths: &[Path],
        mut amplitude: impl FnMut(&Row, &Path) -> Complex64,
    ) {
        contacts.emission_offset_s.push(offset_s);
        for (path, (delay_s, rate)) in
            paths.iter().zip(contacts.delay_s.iter_mut().zip(&mut contacts.delay_rate))
        {
            delay_s.push(path.delay_s);
            rate.push(path.rate);
        }
        for (row, column) in self.rows.iter().zip(&mut contacts.amplitude) {
            column.push(amplitude(row, &paths[row.pair]));
        }
    }

    fn scattered(
        &self,
        row: &Row,
        only: Option<Polarisation>,
        tx: &End,
        rx: &End,
        out: DVec3,
        back: DVec3,
        scattering: &[[Complex64; 2]; 2],
    ) -> Complex64 {
        if only.is_some_and(|only| only != row.tx) {
            return Complex64::ZERO;
        }
        let pair = self.pairs[row.pair];
        let (k_i, look_back) = (out.normalize_or_zero(), back.normalize_or_zero());
        let gains = self.transmitters[pair.transmitter].gain(tx, k_i)
            * self.receivers[pair.receiver].gain(rx, look_back);
        if gains == Complex64::ZERO {
            return gains;
        }
        let e_t = field_components(row.tx_axis, tx.y_a, tx.z_a, k_i);
        let e_r = field_components(row.rx_axis, rx.y_a, rx.z_a, -look_back);
        let spread = self.link.scattered(self.powers_w[pair.transmitter], out.length(), back.length());
        gains * received(e_r, scattering, e_t) * spread
    }

    fn direct(&self, row: &Row, only: Option<Polarisation>, tx: &End, rx: &End, out: DVec3) -> Complex64 {
        if only.is_some_and(|only| only != row.tx) {
            return Complex64::ZERO;
        }
        let pair = self.pairs[row.pair];
        let k = out.normalize_or_zero();
        let gains =
            self.transmitters[pair.transmitter].gain(tx, k) * self.receivers[pair.receiver].gain(rx, -k);
        let e_t = field_components(row.tx_axis, tx.y_a, tx.z_a, k);
        let e_r = field_components(row.rx_axis, rx.y_a, rx.z_a, k);
        let overlap = e_r[0] * e_t[0] + e_r[1] * e_t[1];
        gains * overlap * self.link.direct(self.powers_w[pair.transmitter], out.length())
    }
}

impl Instrument {
    fn new(mounted: &AntennaMount, wavelength_m: f64) -> Result<Self, PatternError> {
        let pointing = match &mounted.pointing {
            Pointing::Fixed { yaw_rad, pitch_rad, roll_rad } => {
                Look::Mounted(mount(*yaw_rad, *pitch_rad, *roll_rad))
            }
            Pointing::At { aim, aim_from, lag_s, bias_rad } => Look::Servo {
                aim: aim.clone(),
                aim_from: *aim_from,
                lag_s: *lag_s,
                bias: servo_bias(*bias_rad),
            },
        };
        Ok(Self {
            platform: mounted.platform,
            lever_arm: mounted.lever_arm,
            antenna: Antenna::new(&mounted.pattern, wavelength_m)?,
            pointing,
            isolation_db: mounted.cross_pol_isolation_db,
        })
    }

    fn gain(&self, end: &End, direction: DVec3) -> Complex64 {
        self.antenna.field_gain((end.inward * Vector::from_raw(direction)).raw())
    }
}

impl Look {
    fn lag_s(&self) -> f64 {
        match self {
            Self::Mounted(_) => 0.0,
            Self::Servo { lag_s, .. } => *lag_s,
        }
    }
}

/// A track's state. The run was checked to lie within every track; should an instant fall outside all the same,
/// the nearest end of the track is taken.
fn state(track: &Track, time: TimeTag) -> State {
    let within = match track.span() {
        Some((first, _)) if time < first => first,
        Some((_, last)) if time > last => last,
        _ => time,
    };
    track.state(within).unwrap_or(State {
        position: crate::frames::Point::new(0.0, 0.0, 0.0),
        velocity: Vector::ZERO,
        acceleration: Vector::ZERO,
        attitude: Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0),
        angular_rate: Vector::ZERO,
    })
}

fn motion(centre: &PhaseCentre) -> Mover {
    Mover {
        position_m: centre.position.raw(),
        velocity_mps: centre.velocity.raw(),
        acceleration_mps2: centre.acceleration.raw(),
    }
}

fn platform_record(state: &State) -> PlatformRecord {
    PlatformRecord {
        position_m: state.position.to_array(),
        velocity_mps: state.velocity.to_array(),
        attitude_quat: state.attitude.to_wxyz(),
    }
}
