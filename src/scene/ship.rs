//! Ships: a hull, a course, what it leaves behind.

use std::path::PathBuf;

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
    /// Speed through the water, m/s.
    pub speed_mps: f64,
    /// Its gravity waves; `None` for none.
    pub kelvin: Option<KelvinWake>,
    /// Its turbulent wake; `None` for none.
    pub turbulent: Option<TurbulentWake>,
    /// Whether the scatterers of its hull file echo.
    pub echo: bool,
}

/// Where a hull comes from.
#[derive(Clone, Debug, PartialEq)]
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
