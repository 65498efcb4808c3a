//! What a processor of the samples needs to know of the radar apart from its figures: waveform, receive
//! filter, antennas, where they look, and of emitters beside it. It is in every recording (attribute
//! `instrument`, JSON) and on the wire, so that an image needs no scenario.
//!
//! ```
//! use nereus::recording::instrument::{Instrument, Look};
//! let text = r#"{ "waveform": { "kind": "lfm", "sweep_hz_per_s": 6e13, "rate_hz": null },
//!     "filter": { "kind": "raised-cosine", "flat_hz": 40e6, "zero_hz": 50e6 }, "earth_radius_factor": null,
//!     "window": { "kind": "beside", "platform": "aircraft", "along_m": 0.0, "across_m": -3000.0 },
//!     "middle_m": [0.0, 0.0], "antennas": [] }"#;
//! let instrument: Instrument = serde_json::from_str(text)?;
//! assert!(matches!(instrument.window, Some(Look::Beside { across_m: -3000.0, .. })));
//! # Ok::<(), serde_json::Error>(())
//! ```

use std::f64::consts::{PI, TAU};

use serde::{Deserialize, Serialize};

use crate::frames::{Body, Vector};
use crate::radar::filter::ReceiveFilter;
use crate::radar::waveform;
use crate::scene::Scene;
use crate::scene::radar::{
    Aim, AntennaMount, Band, Emitter, Gate, Pattern, Pointing, PolarisationBasis, Receiver, Scan, ScanLaw,
    Sweep, Transmitter, Waveform,
};
use crate::scene::sea::PatchPlace;

/// What a processor needs to know of the radar.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Instrument {
    /// What is radiated.
    pub waveform: WaveformRow,
    /// What the receiver makes of it.
    pub filter: FilterRow,
    /// The sea is a sphere of that many radii of the Earth (6371 km) below the origin; none: the plane z = 0.
    pub earth_radius_factor: Option<f64>,
    /// What the receive window follows; none where it opens at a fixed time.
    pub window: Option<Look>,
    /// Whether reception is continuous: what is called a pulse elsewhere is a block of samples, which begins
    /// where the one before ends. Emissions have times of their own, which the scenario says.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub continuous: bool,
    /// Middle of the scene, East and North, m: of an image where nothing looks anywhere.
    pub middle_m: [f64; 2],
    /// Delay of the reference by which echoes are dechirped, s; `None` where they are not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dechirp_s: Option<f64>,
    /// Antennas: transmitters, then receivers.
    pub antennas: Vec<AntennaRow>,
    /// What radiates besides; recordings without any do not mention it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub emitters: Vec<EmitterRow>,
    /// Error that pulses of each class keep against the reference, dB (`flags::ERROR_CLASS` of a pulse);
    /// empty where all are of one class.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub error_classes_db: Vec<f64>,
}

/// The transmitted baseband pulse, apart from its bandwidth and length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WaveformRow {
    /// As scenarios call it (`samples` of a file).
    pub kind: String,
    /// Rate of a linear sweep, Hz/s, negative when it falls.
    pub sweep_hz_per_s: Option<f64>,
    /// Rate of the samples of a waveform from a file, Hz.
    pub rate_hz: Option<f64>,
    /// Pulses that leave in turn: emission `k` is entry `k` modulo their number. None where all are alike.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pulses: Vec<PulseRow>,
}

/// One of several pulses in turn.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PulseRow {
    /// As scenarios call it (`samples` of a file).
    pub kind: String,
    /// Its carrier less that of the radar or the emitter, Hz.
    pub offset_hz: f64,
    /// Bandwidth about its carrier, Hz.
    pub bandwidth_hz: f64,
    /// Length, s.
    pub pulse_s: f64,
    /// Rate of a linear sweep, Hz/s, negative when it falls.
    pub sweep_hz_per_s: Option<f64>,
}

/// The receive filter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FilterRow {
    /// `raised-cosine`: 1, then `(1 + cos)/2` down to 0; real and even.
    pub kind: String,
    /// Where the flat part ends, Hz from the carrier.
    pub flat_hz: f64,
    /// Where the response ends, Hz from the carrier.
    pub zero_hz: f64,
}

/// An antenna.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AntennaRow {
    /// Its name.
    pub name: String,
    /// Whether it transmits.
    pub transmits: bool,
    /// The platform that carries it.
    pub platform: String,
    /// Phase centre in the body frame (forward, starboard, down), m.
    pub lever_arm_m: [f64; 3],
    /// `isotropic`, `rectangle`, `ellipse`, `file`.
    pub pattern: String,
    /// Width (along +y) and height (along +z) of a uniformly illuminated aperture, m.
    pub aperture_m: Option<[f64; 2]>,
    /// Where it looks.
    pub look: Look,
    /// Where the window of a receiver opens that has a gate of its own; none where that of the radar holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<GateRow>,
}

/// Where a receive window of its own opens.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[non_exhaustive]
pub enum GateRow {
    /// A fixed time after the emission.
    Fixed {
        /// Start after the emission, s.
        start_s: f64,
    },
    /// So long before the echo of an aim point.
    Follow {
        /// The aim point.
        look: Look,
        /// How much earlier the window opens, s.
        lead_s: f64,
    },
}

/// An emitter beside the transmitters of the radar, and who receives it. Emission `k` leaves `start_s` plus
/// `k` intervals after pulse 0.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EmitterRow {
    /// Its antenna, by whose name it goes.
    pub antenna: AntennaRow,
    /// What it radiates.
    pub waveform: WaveformRow,
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Bandwidth of the waveform, Hz.
    pub bandwidth_hz: f64,
    /// Length of the waveform, s.
    pub pulse_s: f64,
    /// Emission 0 minus pulse 0 of the radar, s.
    pub start_s: f64,
    /// Mean pulse repetition frequency, Hz.
    pub prf_hz: f64,
    /// Intervals that it has in turn: 1 where all are equal.
    pub intervals: u32,
    /// These, s; empty where all are equal, and where a datagram of the wire had no room for them.
    pub pri_s: Vec<f64>,
    /// Peak power, W.
    pub power_w: f64,
    /// Letter of its polarisation.
    pub polarisation: String,
    /// Basis of that ([`PolarisationBasis::name`]).
    pub basis: String,
    /// Names of the receivers that take it.
    pub receivers: Vec<String>,
    /// Whether they take its direct path.
    pub direct_path: bool,
    /// Whether they take its echoes.
    pub echo: bool,
}

/// Where an antenna or a receive window looks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[non_exhaustive]
pub enum Look {
    /// Ahead of a mount that is bolted to the body.
    Body {
        /// Turn about body z (down), rad.
        yaw_rad: f64,
        /// Then about the new y, rad.
        pitch_rad: f64,
        /// Then about the boresight, rad.
        roll_rad: f64,
    },
    /// At a point that moves on a straight line.
    Point {
        /// Position at the emission of pulse 0, ENU, m.
        position_m: [f64; 3],
        /// Velocity, m/s.
        velocity_mps: [f64; 3],
    },
    /// At a point of the mean sea surface beside a platform, in axes along its horizontal velocity.
    Beside {
        /// The platform.
        platform: String,
        /// Ahead, m.
        along_m: f64,
        /// To starboard, m.
        across_m: f64,
    },
    /// Wherever a pedestal turns it: [`encoder_deg`](crate::pulse::AntennaRecord::encoder_deg) of each pulse.
    Scan {
        /// Whether azimuth and elevation are those from North and the horizontal plane; else from the
        /// platform's nose and deck.
        level: bool,
        /// Rate, deg/s, clockwise from above; of a sector, that within a sweep; 0 of a beam that jumps.
        rate_deg_per_s: f64,
        /// Azimuths between which it goes to and fro, or jumps, deg; both 0: it turns without end.
        sector_deg: [f64; 2],
        /// Elevation, of the first sweep, deg.
        elevation_deg: f64,
    },
}

impl Default for Look {
    fn default() -> Self {
        Self::Body { yaw_rad: 0.0, pitch_rad: 0.0, roll_rad: 0.0 }
    }
}

impl Look {
    fn at(aim: &Aim, platforms: &[String]) -> Self {
        match aim {
            Aim::Point { position, velocity } => {
                Self::Point { position_m: position.to_array(), velocity_mps: velocity.to_array() }
            }
            Aim::Beside { platform, along_m, across_m } => Self::Beside {
                platform: platforms.get(*platform).cloned().unwrap_or_default(),
                along_m: *along_m,
                across_m: *across_m,
            },
        }
    }

    fn of(pointing: &Pointing, platforms: &[String]) -> Self {
        match pointing {
            Pointing::At { aim, .. } => Self::at(aim, platforms),
            Pointing::Scan(Scan { law, level_by, .. }) => {
                let level = level_by.is_some();
                let (rate, sector, elevation) = match law {
                    ScanLaw::Rotation { rate_rad_per_s, elevation_rad, .. } => {
                        (*rate_rad_per_s, [0.0; 2], *elevation_rad)
                    }
                    ScanLaw::Sector { from_rad, to_rad, rate_rad_per_s, elevations_rad, .. } => {
                        let first = elevations_rad.first().copied().unwrap_or(0.0);
                        (*rate_rad_per_s, [*from_rad, *to_rad], first)
                    }
                    ScanLaw::Steps { directions_rad, .. } => {
                        let [begin, first] = directions_rad.first().copied().unwrap_or_default();
                        let (mut before, mut ends) = (begin, [begin; 2]);
                        for [azimuth, _] in directions_rad {
                            // From one to the next the shorter way.
                            before += (azimuth - before + PI).rem_euclid(TAU) - PI;
                            ends = [ends[0].min(before), ends[1].max(before)];
                        }
                        (0.0, ends, first)
                    }
                };
                Self::Scan {
                    level,
                    rate_deg_per_s: rate.to_degrees(),
                    sector_deg: sector.map(f64::to_degrees),
                    elevation_deg: elevation.to_degrees(),
                }
            }
            Pointing::Fixed { yaw_rad, pitch_rad, roll_rad } => {
                Self::Body { yaw_rad: *yaw_rad, pitch_rad: *pitch_rad, roll_rad: *roll_rad }
            }
        }
    }

    /// Its numbers, in the order of its fields.
    pub(crate) fn numbers(&self) -> [f64; 6] {
        match self {
            Self::Body { yaw_rad, pitch_rad, roll_rad } => [*yaw_rad, *pitch_rad, *roll_rad, 0.0, 0.0, 0.0],
            Self::Point { position_m: [x, y, z], velocity_mps: [vx, vy, vz] } => [*x, *y, *z, *vx, *vy, *vz],
            Self::Beside { along_m, across_m, .. } => [*along_m, *across_m, 0.0, 0.0, 0.0, 0.0],
            Self::Scan { rate_deg_per_s, sector_deg: [from, to], elevation_deg, .. } => {
                [*rate_deg_per_s, *from, *to, *elevation_deg, 0.0, 0.0]
            }
        }
    }
}

impl AntennaRow {
    fn of(name: &str, transmits: bool, mount: &AntennaMount, platforms: &[String]) -> Self {
        let (pattern, aperture_m) = match &mount.pattern {
            Pattern::Isotropic { .. } => (ISOTROPIC, None),
            Pattern::Rectangle { width_m, height_m } | Pattern::Tapered { width_m, height_m, .. } => {
                ("rectangle", Some([*width_m, *height_m]))
            }
            Pattern::Ellipse { width_m, height_m } => ("ellipse", Some([*width_m, *height_m])),
            Pattern::File { .. } => ("file", None),
        };
        Self {
            name: name.to_owned(),
            transmits,
            platform: platforms.get(mount.platform).cloned().unwrap_or_default(),
            lever_arm_m: mount.lever_arm.to_array(),
            pattern: pattern.to_owned(),
            aperture_m,
            look: Look::of(&mount.pointing, platforms),
            window: None,
        }
    }

    fn of_receiver(receiver: &Receiver, platforms: &[String]) -> Self {
        let window = receiver.gate.as_ref().map(|gate| match gate {
            Gate::Fixed { start_s } => GateRow::Fixed { start_s: *start_s },
            Gate::Follow { aim, lead_s, .. } => {
                GateRow::Follow { look: Look::at(aim, platforms), lead_s: *lead_s }
            }
        });
        Self { window, ..Self::of(&receiver.name, false, &receiver.antenna, platforms) }
    }

    /// Every place that it looks at, or its window follows.
    pub(super) fn looks(&self) -> impl Iterator<Item = &Look> {
        let follows = match &self.window {
            Some(GateRow::Follow { look, .. }) => Some(look),
            _ => None,
        };
        follows.into_iter().chain([&self.look])
    }

    /// Whether it radiates alike in all directions, so that where it looks is no aim.
    pub fn is_isotropic(&self) -> bool {
        self.pattern == ISOTROPIC
    }

    /// Phase centre in the body frame.
    pub(crate) fn lever_arm(&self) -> Vector<Body> {
        let [forward, starboard, down] = self.lever_arm_m;
        Vector::new(forward, starboard, down)
    }
}

const ISOTROPIC: &str = "isotropic";

impl WaveformRow {
    /// Of a description; bandwidths and lengths of files among pulses in turn are 0.
    pub fn of(waveform: &Waveform) -> Self {
        let (sweep_hz_per_s, rate_hz) = match waveform.level() {
            Waveform::Lfm { bandwidth_hz, duration_s, sweep } => {
                let sign = if *sweep == Sweep::Up { 1.0 } else { -1.0 };
                (Some(sign * bandwidth_hz / duration_s), None)
            }
            Waveform::Samples { rate_hz, .. } => (None, Some(*rate_hz)),
            _ => (None, None),
        };
        let pulses = if waveform.turns() > 1 { waveform.pulses() } else { &[] };
        let pulses = pulses.iter().map(PulseRow::of).collect();
        Self { kind: waveform.kind().to_owned(), sweep_hz_per_s, rate_hz, pulses }
    }

    /// The same with bandwidths and lengths as they were made, those of files among them.
    pub fn as_made(mut self, waveform: &dyn waveform::Waveform) -> Self {
        for (row, pulse) in self.pulses.iter_mut().zip(waveform.in_turn()) {
            (row.bandwidth_hz, row.pulse_s) = (pulse.bandwidth_hz(), pulse.duration_s());
        }
        self
    }

    /// What of it cannot be.
    pub(crate) fn fault(&self) -> Option<String> {
        let wrong = self.pulses.iter().find(|row| !row.is_legal())?;
        Some(format!("a pulse in turn of {wrong:?}"))
    }
}

impl PulseRow {
    fn of(pulse: &Waveform) -> Self {
        Self {
            kind: pulse.kind().to_owned(),
            offset_hz: pulse.offset_hz(),
            bandwidth_hz: pulse.bandwidth_hz().unwrap_or(0.0),
            pulse_s: pulse.duration_s().unwrap_or(0.0),
            sweep_hz_per_s: WaveformRow::of(pulse).sweep_hz_per_s,
        }
    }

    /// Whether its figures are those of a radar.
    pub(crate) fn is_legal(&self) -> bool {
        self.offset_hz.abs() <= 1e12
            && (0.0..=1e12).contains(&self.bandwidth_hz)
            && (0.0..=1e6).contains(&self.pulse_s)
            && self.sweep_hz_per_s.is_none_or(f64::is_finite)
    }

    /// Its band about the carrier of the radar or the emitter.
    pub fn band(&self) -> Band {
        Band::about(self.offset_hz, self.bandwidth_hz)
    }
}

impl EmitterRow {
    /// That of an emitter of a scene, whose waveform this is.
    pub fn of(emitter: &Emitter, scene: &Scene, waveform: &dyn waveform::Waveform) -> Self {
        let Emitter { transmitter, emissions, .. } = emitter;
        let receivers = emitter.receivers.iter().filter_map(|place| scene.radar.receivers.get(*place));
        let pri_s = emissions.intervals_s();
        Self {
            antenna: AntennaRow::of(&transmitter.name, true, &transmitter.antenna, &scene.platforms),
            waveform: WaveformRow::of(&emitter.waveform).as_made(waveform),
            carrier_hz: emitter.carrier_hz,
            bandwidth_hz: waveform.bandwidth_hz(),
            pulse_s: waveform.duration_s(),
            start_s: emissions.start_s(),
            prf_hz: emissions.mean_prf_hz(),
            intervals: pri_s.len().max(1) as u32,
            pri_s,
            power_w: transmitter.power_w,
            polarisation: emitter.polarisation.letter().to_string(),
            basis: PolarisationBasis::of(&transmitter.antenna.pattern).name().to_owned(),
            receivers: receivers.map(|receiver| receiver.name.clone()).collect(),
            direct_path: emitter.direct_path,
            echo: emitter.echo,
        }
    }

    /// What of it cannot be.
    pub(crate) fn fault(&self, receivers: &[String]) -> Option<String> {
        let Self { antenna, pri_s, .. } = self;
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        let signal = [self.carrier_hz, self.bandwidth_hz, self.pulse_s, self.prf_hz, self.power_w];
        let most = [1e12, 1e12, 1e6, 1e9, 1e15];
        let shape = [self.waveform.sweep_hz_per_s, self.waveform.rate_hz];
        let what = if !signal.iter().zip(most).all(|(value, most)| (0.0..=most).contains(value))
            || self.carrier_hz == 0.0
            || self.prf_hz < 1e-6
        {
            format!("carrier, bandwidth, length, PRF and power of {signal:?}")
        } else if !(self.start_s.abs() <= 1e6 && shape.iter().flatten().all(|value| value.is_finite())) {
            format!("a start of {} s, a sweep and a rate of {shape:?}", self.start_s)
        } else if let Some(found) = self.waveform.fault() {
            found
        } else if self.intervals == 0
            || !(pri_s.is_empty() || pri_s.len() == self.intervals as usize)
            || !pri_s.iter().all(|pri_s| (1e-10..=1e4).contains(pri_s))
        {
            format!("{} intervals for {}, or one that is none", pri_s.len(), self.intervals)
        } else if let Some(name) = self.receivers.iter().find(|name| !receivers.contains(name)) {
            format!("the receiver '{}'", name.escape_debug())
        } else if !antenna.transmits || antenna.window.is_some() || self.polarisation.chars().count() != 1 {
            format!("polarisation '{}', or an antenna that receives", self.polarisation.escape_debug())
        } else if !finite(&antenna.aperture_m.unwrap_or_default()) {
            format!("an aperture of {:?} m", antenna.aperture_m)
        } else {
            return None;
        };
        Some(format!("'{}': {what}", antenna.name.escape_debug()))
    }
}

impl Instrument {
    pub(super) fn to_json(&self) -> String {
        serde_json::json!(self).to_string()
    }

    pub(super) fn from_json(text: &str) -> Result<Self, serde_json::Error> {
        serde_json::from_str(text)
    }

    /// That of a scene, without its emitters, whose waveforms may be files.
    pub fn of(scene: &Scene) -> Self {
        let radar = &scene.radar;
        let [flat_hz, zero_hz] = ReceiveFilter::new(radar.sample_rate_hz).edges_hz();
        let still = scene.sea.as_ref().filter(|sea| sea.place == PatchPlace::Fixed).map(|sea| &sea.patch);
        let middle = |axis: usize| {
            still.map_or(0.0, |patch| {
                (patch.first[axis] + (patch.facets[axis] / 2) as i64) as f64 * patch.facet_m
            })
        };
        let platforms = &scene.platforms;
        let row = |end: &Transmitter| AntennaRow::of(&end.name, true, &end.antenna, platforms);
        Self {
            waveform: WaveformRow::of(&radar.waveform),
            filter: FilterRow { kind: "raised-cosine".to_owned(), flat_hz, zero_hz },
            earth_radius_factor: scene.frame.earth().radius_factor(),
            window: match &radar.window.gate {
                Gate::Follow { aim, .. } => Some(Look::at(aim, platforms)),
                Gate::Fixed { .. } => None,
            },
            continuous: radar.sent.is_some(),
            dechirp_s: radar.dechirp.map(|dechirp| dechirp.delay_s),
            middle_m: [0, 1].map(middle),
            antennas: (radar.transmitters.iter().map(row))
                .chain(radar.receivers.iter().map(|end| AntennaRow::of_receiver(end, platforms)))
                .collect(),
            emitters: Vec::new(),
            error_classes_db: Vec::new(),
        }
    }

    /// An antenna by its name.
    pub fn antenna(&self, name: &str) -> Option<&AntennaRow> {
        self.antennas.iter().find(|antenna| antenna.name == name)
    }
}
