//! Ships: a hull, a course, what it leaves behind.

use std::path::PathBuf;
use std::sync::Arc;

use super::Trajectory;
use super::mesh::Triangle;

/// A ship under way.
#[derive(Clone, Debug, PartialEq)]
pub struct Ship {
    /// Name, unique among ships.
    pub name: String,
    /// Its hull.
    pub hull: HullGiven,
    /// Length on the waterline to which the hull is scaled, m; `None` for its own.
    pub length_m: Option<f64>,
    /// Midship at the emission of pulse 0, East and North, m.
    pub position_m: [f64; 2],
    /// Direction it heads for, from +x counter-clockwise, radians.
    pub heading_rad: f64,
    /// Speed through the water, m/s; of one on a trajectory this and what is above are those at pulse 0.
    pub speed_mps: f64,
    /// How it moves, where it does not sail straight on; only East and North count.
    pub trajectory: Option<Trajectory>,
    /// Its gravity waves; `None` for none.
    pub kelvin: Option<KelvinWake>,
    /// Its turbulent wake; `None` for none.
    pub turbulent: Option<TurbulentWake>,
    /// Whether it echoes: the scatterers of its hull file, or its mesh.
    pub echo: bool,
    /// Which mesh echoes with it.
    pub mesh: ShipMesh,
    /// Triangles that echo, in the axes of [`super::mesh`]; empty until they are made, and without echo.
    pub panels: Arc<[Triangle]>,
}

/// A ship on a trajectory at an instant: it heads along its velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sailed {
    /// Midship, East and North, m.
    pub position_m: [f64; 2],
    /// Velocity East and North, m/s.
    pub velocity_mps: [f64; 2],
    /// Unit vector ahead.
    pub ahead: [f64; 2],
    /// Rate of turn to port, rad/s.
    pub turn_radps: f64,
}

impl Sailed {
    /// On a trajectory, at a time after pulse 0; one that stands still heads as given.
    pub fn on(trajectory: &Trajectory, elapsed_s: f64, otherwise: [f64; 2]) -> Self {
        let now = trajectory.at(elapsed_s);
        let ([x_m, y_m, _], [vx, vy, _]) = (now.position.to_array(), now.velocity.to_array());
        let ([ax, ay, _], speed_mps) = (now.acceleration.to_array(), vx.hypot(vy));
        let (position_m, velocity_mps) = ([x_m, y_m], [vx, vy]);
        if speed_mps == 0.0 {
            return Self { position_m, velocity_mps, ahead: otherwise, turn_radps: 0.0 };
        }
        let turn_radps = (vx * ay - vy * ax) / (speed_mps * speed_mps);
        Self { position_m, velocity_mps, ahead: [vx / speed_mps, vy / speed_mps], turn_radps }
    }
}

/// The fastest turn of a ship on a trajectory, rad/s: of 16 instants of every segment.
pub fn fastest_turn_radps(trajectory: &Trajectory) -> f64 {
    let turn = |time_s: f64| Sailed::on(trajectory, time_s, [1.0, 0.0]).turn_radps.abs();
    let of_segment = |pair: &[super::trajectory::Knot]| {
        let step_s = (pair[1].time_s - pair[0].time_s) / 16.0;
        (0..=16).map(|n| turn(pair[0].time_s + step_s * f64::from(n))).fold(0.0, f64::max)
    };
    trajectory.knots().windows(2).map(of_segment).fold(0.0, f64::max)
}

/// The mesh by which a ship echoes.
#[derive(Clone, Debug, PartialEq)]
pub struct ShipMesh {
    /// Whether it is used; `None`: where the hull's file has no scatterers.
    pub used: Option<bool>,
    /// What stands on the hull: a file of triangles.
    pub superstructure: Option<PathBuf>,
    /// Which axis of that file points up.
    pub up: UpAxis,
    /// Height of the deck above the waterline, m; `None` for a twentieth of the length.
    pub freeboard_m: Option<f64>,
    /// Longest edge of a panel, m.
    pub panel_m: f64,
    /// How it rides the sea.
    pub motion: ShipMotion,
}

/// Which axis of a mesh points up; x points forward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// z, and y to port.
    #[default]
    Z,
    /// y, and z to starboard.
    Y,
}

/// How a ship that echoes by its mesh rides the sea.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum ShipMotion {
    /// Level, at the height of the mean sea.
    #[default]
    Level,
    /// It heaves, pitches and rolls with the waves of the sea.
    Waves {
        /// Natural period of roll, s; `None` for that of its form.
        roll_period_s: Option<f64>,
        /// Its form; `None` until the panels are made.
        form: Option<HullForm>,
    },
}

/// What the motion of a hull in waves depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullForm {
    /// Length on the waterline, m.
    pub length_m: f64,
    /// Beam, m.
    pub beam_m: f64,
    /// Draught, m.
    pub draught_m: f64,
    /// Block coefficient: displaced volume over length times beam times draught.
    pub block: f64,
}

impl Default for ShipMesh {
    /// The hull alone, by panels of 1 m.
    fn default() -> Self {
        Self {
            used: None,
            superstructure: None,
            up: UpAxis::Z,
            freeboard_m: None,
            panel_m: 1.0,
            motion: ShipMotion::Level,
        }
    }
}

/// Where a hull comes from.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum HullGiven {
    /// A hull table.
    File(PathBuf),
    /// Wigley's parabolic hull.
    Wigley {
        /// Beam, m.
        beam_m: f64,
        /// Draught, m.
        draught_m: f64,
    },
}

/// How a Kelvin wake is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KelvinWake {
    /// Wave number at which waves are cut off, rad/m; `None` for `0.7 pi / facet`.
    pub band_limit_radpm: Option<f64>,
    /// Whether what is cut off scatters by Bragg within facets.
    pub short_waves: bool,
}

/// The dark V behind a ship: width `4 B (x / (4 L))^(1/a)`, `x` from the stern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurbulentWake {
    /// Exponent a of the spread, 4 to 5.
    pub spread_exponent: f64,
    /// Distance over which the damping falls by e, in lengths.
    pub decay_lengths: f64,
    /// Wind at 10 m that raises the short waves within, over the wind outside.
    pub wind_ratio: f64,
}

impl Default for TurbulentWake {
    /// Exponent 5, decay over 20 lengths, 0.4 of the wind.
    fn default() -> Self {
        Self { spread_exponent: 5.0, decay_lengths: 20.0, wind_ratio: 0.4 }
    }
}
