//! Hulls: offset tables, their particulars, their own scatterers.
//!
//! | symbol | unit | meaning |
//! | --- | --- | --- |
//! | x | m | from midship, positive **astern**; midship is halfway between the first and the last station |
//! | y | m | half-breadth `Y(x, z) >= 0` to starboard; the hull is `\|y\| <= Y` |
//! | z | m | up from the design waterline, 0 at it |
//!
//! A table is a grid of stations (bow to stern) by waterlines (keel to design waterline). Between its nodes
//! `Y` is **piecewise quadratic**: stations 1-2-3, 3-4-5 and so on are the panels of Simpson's rule, and
//! waterlines likewise. So both counts are odd, and the middle one of a panel lies between its quarter
//! points. Steps between panels may differ (half-spaced ends are usual).
//!
//! How a file is written is described in [`table`] (offsets) and [`description`] (particulars, scatterers).
//!
//! Limits: 3 to 2001 stations, 3 to 1001 waterlines, 0.05 to 1000 m long, neither broader nor deeper than
//! long; one hull, port like starboard.
//!
//! ```
//! use nereus::scene::hull::{Hull, Particulars};
//! let model = Hull::wigley(2.5, 0.25, 0.15625)?;
//! let ship = model.scaled_to_length(100.0)?;
//! let found = Particulars::of(&ship);
//! assert!((found.volume_m3 - 4.0 / 9.0 * 100.0 * 10.0 * 6.25).abs() < 1e-6);
//! let refused = Hull::wigley(100.0, -10.0, 6.25).unwrap_err().to_string();
//! assert!(refused.contains("negative"));
//! # Ok::<(), nereus::scene::hull::HullError>(())
//! ```

mod check;
pub mod description;
mod fault;
mod limits;
mod panel;
mod particulars;
pub mod table;

use std::path::Path;

use crate::frames::{Body, Point};

pub use fault::{HullError, HullFault, Place, What};
pub use limits::{LENGTH_RANGE_M, MOST_STATIONS, MOST_WATERLINES};
pub use panel::Panel;
pub use particulars::{Particulars, QUANTITIES, Stated};

/// Stations and waterlines of a hull that comes from a formula.
const FORMULA_GRID: [usize; 2] = [51, 25];

/// A hull.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    name: String,
    stations_m: Vec<f64>,
    waterlines_m: Vec<f64>,
    half_breadths_m: Vec<f64>,
    draught_m: f64,
    stated: Stated,
    scatterers: Vec<Scatterer>,
    /// Length over that of the file or formula it came from.
    scale: f64,
}

/// What a ship's file has in addition to its offsets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facts {
    /// Name.
    pub name: String,
    /// Draught that the particulars refer to, m; `None`: the depth of the hull (a sonar dome reaches below
    /// the draught).
    pub draught_m: Option<f64>,
    /// Published particulars.
    pub stated: Stated,
    /// Points that return an echo of their own.
    pub scatterers: Vec<Scatterer>,
}

/// A point of the ship that returns an echo of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Scatterer {
    /// Name, unique in a hull.
    pub name: String,
    /// Forward, starboard, down of midship at the waterline.
    pub position: Point<Body>,
    /// Radar cross section, m^2.
    pub rcs_m2: f64,
}

impl Hull {
    /// A hull of `half_breadths_m[station * waterlines + waterline]`. Stations may be measured from anywhere:
    /// they are kept from midship.
    ///
    /// # Errors
    /// A table that is no hull: sizes, order, numbers out of range.
    pub fn new(
        stations_m: &[f64],
        waterlines_m: &[f64],
        half_breadths_m: &[f64],
        facts: Facts,
    ) -> Result<Self, HullError> {
        let mut faults = check::finite(stations_m, waterlines_m, half_breadths_m);
        if faults.is_empty() {
            faults = check::offsets(stations_m, waterlines_m, half_breadths_m);
        }
        if !faults.is_empty() {
            return Err(HullError::faulty(&facts.name, faults));
        }
        let hull = Self::assembled(stations_m, waterlines_m, half_breadths_m, facts);
        let faults = check::facts(&hull);
        if faults.is_empty() { Ok(hull) } else { Err(HullError::faulty(&hull.name, faults)) }
    }

    /// Of offsets that were found to be right.
    fn assembled(stations_m: &[f64], waterlines_m: &[f64], half_breadths_m: &[f64], facts: Facts) -> Self {
        let midship_m = match (stations_m.first(), stations_m.last()) {
            (Some(bow), Some(stern)) => 0.5 * (bow + stern),
            _ => 0.0,
        };
        let mut hull = Self {
            name: facts.name,
            stations_m: stations_m.iter().map(|x| x - midship_m).collect(),
            waterlines_m: waterlines_m.to_vec(),
            half_breadths_m: half_breadths_m.to_vec(),
            draught_m: 0.0,
            stated: facts.stated,
            scatterers: facts.scatterers,
            scale: 1.0,
        };
        hull.draught_m = facts.draught_m.unwrap_or_else(|| hull.depth_m());
        hull
    }

    /// Reads a hull: a description (`.toml`), or an offset table alone (`.csv`).
    ///
    /// All faults are reported at once, each with its file and line.
    ///
    /// # Errors
    /// A file that cannot be read, and all faults of description and table.
    pub fn load(path: &Path) -> Result<Self, HullError> {
        description::load(path)
    }

    /// Wigley's parabolic hull, `Y = (B/2) (1 - (2x/L)^2) (1 - (z/T)^2)`, which its table represents exactly.
    ///
    /// # Errors
    /// Dimensions out of range.
    pub fn wigley(length_m: f64, beam_m: f64, draught_m: f64) -> Result<Self, HullError> {
        let [stations, waterlines] = FORMULA_GRID;
        // From -1 to 1 and from -1 to 0, exact at the ends and in the middle.
        let along = |i: usize| (2 * i) as f64 / (stations - 1) as f64 - 1.0;
        let up = |j: usize| j as f64 / (waterlines - 1) as f64 - 1.0;
        let stations_m: Vec<f64> = (0..stations).map(|i| 0.5 * length_m * along(i)).collect();
        let waterlines_m: Vec<f64> = (0..waterlines).map(|j| draught_m * up(j)).collect();
        let half_breadths_m: Vec<f64> = (0..stations)
            .flat_map(|i| (0..waterlines).map(move |j| (i, j)))
            .map(|(i, j)| 0.5 * beam_m * (1.0 - along(i).powi(2)) * (1.0 - up(j).powi(2)))
            .collect();
        let facts = Facts { name: "Wigley".to_owned(), draught_m: Some(draught_m), ..Facts::default() };
        Self::new(&stations_m, &waterlines_m, &half_breadths_m, facts)
    }

    /// The same form at another length. Stated particulars and the places of scatterers are scaled with it;
    /// the radar cross sections of scatterers stay, they are those of the file.
    ///
    /// # Errors
    /// A length out of range.
    pub fn scaled_to_length(&self, length_m: f64) -> Result<Self, HullError> {
        let [least, most] = LENGTH_RANGE_M;
        if !(least..=most).contains(&length_m) {
            return Err(HullError::Length { value_m: length_m, least_m: least, most_m: most });
        }
        let ratio = length_m / self.length_m();
        let scaled = |values: &[f64]| values.iter().map(|value| value * ratio).collect();
        let moved = |scatterer: &Scatterer| Scatterer {
            position: Point::from_raw(scatterer.position.raw() * ratio),
            ..scatterer.clone()
        };
        Ok(Self {
            name: self.name.clone(),
            stations_m: scaled(&self.stations_m),
            waterlines_m: scaled(&self.waterlines_m),
            half_breadths_m: scaled(&self.half_breadths_m),
            draught_m: self.draught_m * ratio,
            stated: self.stated.scaled(ratio),
            scatterers: self.scatterers.iter().map(moved).collect(),
            scale: self.scale * ratio,
        })
    }

    /// Name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Stations from bow to stern, m from midship, positive astern.
    pub fn stations_m(&self) -> &[f64] {
        &self.stations_m
    }

    /// Waterlines from the lowest to the design waterline, m up from it: the last is 0.
    pub fn waterlines_m(&self) -> &[f64] {
        &self.waterlines_m
    }

    /// Half-breadths of a station at every waterline, m.
    pub fn half_breadths_m(&self, station: usize) -> &[f64] {
        let width = self.waterlines_m.len();
        &self.half_breadths_m[station * width..(station + 1) * width]
    }

    /// From the first station to the last, m.
    pub fn length_m(&self) -> f64 {
        self.stations_m.last().unwrap_or(&0.0) - self.stations_m.first().unwrap_or(&0.0)
    }

    /// Twice the largest half-breadth below the design waterline, m.
    pub fn beam_m(&self) -> f64 {
        2.0 * self.half_breadths_m.iter().copied().fold(0.0, f64::max)
    }

    /// Draught that the particulars refer to, m.
    pub fn draught_m(&self) -> f64 {
        self.draught_m
    }

    /// From the design waterline to the lowest point of the table that belongs to the hull, m.
    pub fn depth_m(&self) -> f64 {
        self.deepest_m(0..self.stations_m.len())
    }

    /// Depth of the transom's lower edge at rest, m; 0 for a stern that closes.
    pub fn transom_depth_m(&self) -> f64 {
        let stern = self.stations_m.len() - 1;
        self.deepest_m(stern..stern + 1)
    }

    /// Depth of the waterline below the lowest breadth, where the hull closes; of the lowest one for a flat
    /// bottom.
    fn deepest_m(&self, stations: std::ops::Range<usize>) -> f64 {
        let first = stations.filter_map(|i| self.half_breadths_m(i).iter().position(|y| *y > 0.0)).min();
        first.map_or(0.0, |first| -self.waterlines_m[first.saturating_sub(1)])
    }

    /// Length over that of the file or formula that it came from.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Published particulars.
    pub fn stated(&self) -> &Stated {
        &self.stated
    }

    /// Points that return an echo of their own.
    pub fn scatterers(&self) -> &[Scatterer] {
        &self.scatterers
    }
}
