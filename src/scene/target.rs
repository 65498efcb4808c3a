//! Point targets.

use std::path::PathBuf;

use num_complex::Complex64;

use super::Trajectory;
use crate::frames::{Enu, Point, Vector};

/// A point target on a straight course, or on a trajectory.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Name, unique in a scene.
    pub name: String,
    /// Position at the emission of pulse 0.
    pub position: Point<Enu>,
    /// Velocity, m/s, at pulse 0; constant without a trajectory.
    pub velocity: Vector<Enu>,
    /// How it moves, where it does not go straight on.
    pub trajectory: Option<Trajectory>,
    /// Scattering matrix `S[p][q]`, sqrt(m^2), p received, q transmitted, order (v, h), in the
    /// forward-scatter alignment of [`crate::geometry::bistatic`]: `|S_pq|^2` is the radar cross section.
    pub scattering: [[Complex64; 2]; 2],
    /// How its radar cross section fluctuates about that of the matrix.
    pub swerling: Swerling,
    /// Where it takes its cross section from, in place of the matrix.
    pub aspect: Option<Aspect>,
    /// How it floats, if it does: waves lift it from the height of its position.
    pub floating: Option<Floating>,
    /// Whether the sea reflects the rays between it and the antennas.
    pub multipath: bool,
}

/// How a target floats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floating {
    /// Length over which it averages the surface, m: shorter waves do not lift it.
    pub waterline_m: f64,
}

/// Radar cross sections by the direction from which a target is seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Aspect {
    /// File of monostatic cross sections, dBsm, over azimuth from the bow, positive to starboard, and
    /// elevation.
    pub path: PathBuf,
    /// Heading, clockwise from North, rad; `None`: along the velocity of the moment.
    pub heading_rad: Option<f64>,
    /// What holds outside the grid of the file, dBsm.
    pub floor_dbsm: f64,
}

/// How the radar cross section of a target fluctuates: Swerling's cases.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Swerling {
    /// Case 0: not at all.
    #[default]
    Steady,
    /// Case 1: exponential, constant over a scan.
    Case1 {
        /// Length of a scan, s; the first begins at pulse 0.
        scan_s: f64,
    },
    /// Case 2: exponential, independent from pulse to pulse.
    Case2,
    /// Case 3: chi-square of four degrees of freedom, constant over a scan.
    Case3 {
        /// Length of a scan, s; the first begins at pulse 0.
        scan_s: f64,
    },
    /// Case 4: chi-square of four degrees of freedom, independent from pulse to pulse.
    Case4,
}

impl Swerling {
    /// Number of the case.
    pub fn case(self) -> u8 {
        match self {
            Self::Steady => 0,
            Self::Case1 { .. } => 1,
            Self::Case2 => 2,
            Self::Case3 { .. } => 3,
            Self::Case4 => 4,
        }
    }

    /// Length of the scan over which it is constant, s.
    pub fn scan_s(self) -> Option<f64> {
        match self {
            Self::Case1 { scan_s } | Self::Case3 { scan_s } => Some(scan_s),
            _ => None,
        }
    }
}

impl Target {
    /// Position and velocity at a time after pulse 0.
    pub fn at(&self, elapsed_s: f64) -> (Point<Enu>, Vector<Enu>) {
        match &self.trajectory {
            None => (self.position + self.velocity * elapsed_s, self.velocity),
            Some(trajectory) => {
                let now = trajectory.at(elapsed_s);
                (now.position, now.velocity)
            }
        }
    }

    /// A bound on its speed, m/s.
    pub fn fastest_mps(&self) -> f64 {
        self.trajectory.as_ref().map_or_else(|| self.velocity.norm(), Trajectory::fastest_mps)
    }

    /// A target whose radar cross section is constant.
    pub fn new(
        name: impl Into<String>,
        position: Point<Enu>,
        velocity: Vector<Enu>,
        scattering: [[Complex64; 2]; 2],
    ) -> Self {
        Self {
            name: name.into(),
            position,
            velocity,
            trajectory: None,
            scattering,
            swerling: Swerling::Steady,
            aspect: None,
            floating: None,
            multipath: false,
        }
    }

    /// The matrix of a sphere (or trihedral) of the given radar cross section, m^2: in the
    /// forward-scatter alignment `diag(1, -1) sqrt(sigma)`, so that HH and VV of a monostatic radar
    /// come out equal.
    pub fn sphere(rcs_m2: f64) -> [[Complex64; 2]; 2] {
        let s = rcs_m2.sqrt();
        let zero = Complex64::ZERO;
        [[Complex64::new(s, 0.0), zero], [zero, Complex64::new(-s, 0.0)]]
    }
}
