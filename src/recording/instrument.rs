//! What a processor of the samples needs to know of the radar apart from its figures: waveform, receive
//! filter, antennas, where they look. It is in every recording (attribute `instrument`, JSON) and on the
//! wire, so that an image needs no scenario.
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

use serde::{Deserialize, Serialize};

use crate::frames::{Body, Vector};
use crate::radar::filter::ReceiveFilter;
use crate::scene::Scene;
use crate::scene::radar::{Aim, AntennaMount, Gate, Pattern, Pointing, Sweep, Waveform};
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
    /// Antennas: transmitters, then receivers.
    pub antennas: Vec<AntennaRow>,
}

/// The transmitted baseband pulse, apart from its bandwidth and length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WaveformRow {
    /// `lfm` or `samples`.
    pub kind: String,
    /// Rate of a linear sweep, Hz/s, negative when it falls.
    pub sweep_hz_per_s: Option<f64>,
    /// Rate of the samples of a waveform from a file, Hz.
    pub rate_hz: Option<f64>,
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
        }
    }
}

impl AntennaRow {
    fn of(name: &str, transmits: bool, mount: &AntennaMount, platforms: &[String]) -> Self {
        let (pattern, aperture_m) = match &mount.pattern {
            Pattern::Isotropic { .. } => (ISOTROPIC, None),
            Pattern::Rectangle { width_m, height_m } => ("rectangle", Some([*width_m, *height_m])),
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
        }
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

impl Instrument {
    pub(super) fn to_json(&self) -> String {
        serde_json::json!(self).to_string()
    }

    pub(super) fn from_json(text: &str) -> Result<Self, serde_json::Error> {
        serde_json::from_str(text)
    }

    /// That of a scene.
    pub fn of(scene: &Scene) -> Self {
        let radar = &scene.radar;
        let (kind, sweep_hz_per_s, rate_hz) = match &radar.waveform {
            Waveform::Lfm { bandwidth_hz, duration_s, sweep } => {
                let sign = if *sweep == Sweep::Up { 1.0 } else { -1.0 };
                ("lfm", Some(sign * bandwidth_hz / duration_s), None)
            }
            Waveform::Samples { rate_hz, .. } => ("samples", None, Some(*rate_hz)),
        };
        let [flat_hz, zero_hz] = ReceiveFilter::new(radar.sample_rate_hz).edges_hz();
        let still = scene.sea.as_ref().filter(|sea| sea.place == PatchPlace::Fixed).map(|sea| &sea.patch);
        let middle = |axis: usize| {
            still.map_or(0.0, |patch| {
                (patch.first[axis] + (patch.facets[axis] / 2) as i64) as f64 * patch.facet_m
            })
        };
        let platforms = &scene.platforms;
        let transmitters = radar.transmitters.iter().map(|end| (&end.name, true, &end.antenna));
        let receivers = radar.receivers.iter().map(|end| (&end.name, false, &end.antenna));
        Self {
            waveform: WaveformRow { kind: kind.to_owned(), sweep_hz_per_s, rate_hz },
            filter: FilterRow { kind: "raised-cosine".to_owned(), flat_hz, zero_hz },
            earth_radius_factor: scene.frame.earth().radius_factor(),
            window: match &radar.window.gate {
                Gate::Follow { aim, .. } => Some(Look::at(aim, platforms)),
                Gate::Fixed { .. } => None,
            },
            continuous: radar.sent.is_some(),
            middle_m: [0, 1].map(middle),
            antennas: transmitters
                .chain(receivers)
                .map(|(name, transmits, mount)| AntennaRow::of(name, transmits, mount, platforms))
                .collect(),
        }
    }

    /// An antenna by its name.
    pub fn antenna(&self, name: &str) -> Option<&AntennaRow> {
        self.antennas.iter().find(|antenna| antenna.name == name)
    }
}
