//! The ships of a scene in figures.
//!
//! Froude number `V/sqrt(g L)`, the longest waves `2 pi V^2/g`, wave resistance in sea water of
//! [`DENSITY_KGPM3`], and whether patch and facets show their waves.

use std::f64::consts::TAU;

use serde::Serialize;

use super::{Adequacy, lattice};
use crate::pipeline::fault::{BuildError, BuildErrors};
use crate::pipeline::prepared::Prepared;
use crate::scene::hull::{Hull, Particulars, QUANTITIES};
use crate::scene::mesh;
use crate::scene::ship::{Sailed, ShipMotion, UpAxis};
use crate::scene::{Patch, Sea, Ship};
use crate::sea::fleet::{self, FleetError, ShipError};
use crate::sea::seakeeping::Seakeeping;
use crate::sea::wake::kochin::{Kochin, Transom};
use crate::sea::wake::{Presence, Reach, Settings, Wake, free_waves, kochin};

/// Density of sea water, kg/m^3.
pub const DENSITY_KGPM3: f64 = 1025.0;
/// Half angle of the wedge that holds the waves of a ship in deep water: its sine is 1/3.
const WEDGE_TANGENT: f64 = 0.353_553_390_593_273_8;

/// A ship in figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShipOutlook {
    /// Its name.
    pub name: String,
    /// That of its hull.
    pub hull: String,
    /// Length, m.
    pub length_m: f64,
    /// Beam, m.
    pub beam_m: f64,
    /// Draught, m.
    pub draught_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Speed over `sqrt(g L)`.
    pub froude: f64,
    /// Length of the waves that run along with it, m; `None` for a ship without waves.
    pub transverse_wavelength_m: Option<f64>,
    /// Wave resistance, N; `None` for a ship so slow that its integral has too many oscillations.
    pub resistance_n: Option<f64>,
    /// Whether its waves are on the map: `waves`, `slow`, `unresolved`, `band-limited`, or `off` where none
    /// were asked.
    pub waves: &'static str,
    /// Scatterers that its file gives.
    pub scatterers: usize,
    /// Panels of its mesh, where they echo.
    pub panels: usize,
    /// Extents of its superstructure, m: forward of midship, to port, up from the waterline.
    pub superstructure_m: Option<[[f64; 2]; 3]>,
    /// Natural period of roll, s, where it rides the waves.
    pub roll_period_s: Option<f64>,
    /// The particular that is furthest from what its file states, percent; `None` where nothing is stated.
    pub furthest_particular: Option<(&'static str, f64)>,
}

/// The word for a presence.
pub fn presence_word(presence: Presence) -> &'static str {
    match presence {
        Presence::Waves => "waves",
        Presence::Slow => "slow",
        Presence::Unresolved => "unresolved",
        Presence::BandLimited => "band-limited",
    }
}

impl ShipOutlook {
    /// That of a ship on facets of a side, m.
    ///
    /// # Errors
    /// A ship whose hull or numbers the laws do not cover.
    pub fn of(ship: &Ship, facet_m: f64) -> Result<Self, FleetError> {
        Self::found(ship, facet_m).map_err(|source| FleetError { ship: ship.name.clone(), source })
    }

    fn found(ship: &Ship, facet_m: f64) -> Result<Self, ShipError> {
        let hull = fleet::hull(ship)?;
        let kochin = Kochin::new(&hull, ship.speed_mps, Transom::Open)?;
        let waves = match &ship.kelvin {
            None => "off",
            Some(kelvin) => {
                // Whether there are waves does not depend on how far they are asked for.
                let settings = Settings {
                    cutoff_rad_m: kelvin.band_limit_radpm,
                    ..Settings::new(facet_m, Reach::disc(0.0))
                };
                let wake =
                    Wake::new(fleet::course(ship), hull.length_m(), &settings, |t| kochin.amplitude_m(t))?;
                presence_word(wake.presence())
            }
        };
        Ok(Self {
            name: ship.name.clone(),
            hull: hull.name().to_owned(),
            length_m: hull.length_m(),
            beam_m: hull.beam_m(),
            draught_m: hull.draught_m(),
            speed_mps: ship.speed_mps,
            froude: kochin.froude(),
            transverse_wavelength_m: (!kochin.is_still()).then(|| TAU / kochin.transverse_radpm()),
            resistance_n: kochin.wave_resistance_n(DENSITY_KGPM3).ok(),
            waves,
            scatterers: hull.scatterers().len(),
            panels: if ship.echo { fleet::panels(ship, &hull)?.len() } else { 0 },
            superstructure_m: match ship.echo {
                true => mesh::extents_m(&fleet::superstructure(ship, &hull)?),
                false => None,
            },
            roll_period_s: match ship.mesh.motion {
                ShipMotion::Level => None,
                ShipMotion::Waves { roll_period_s, .. } => {
                    Some(Seakeeping::new(&fleet::form(&hull), roll_period_s).roll_period_s())
                }
            },
            furthest_particular: furthest_particular(&hull),
        })
    }

    /// What the user should know of its waves.
    fn warning(&self, ship: &Ship, facet_m: f64) -> Option<String> {
        let longest_m = self.transverse_wavelength_m.unwrap_or(0.0);
        let why = match self.waves {
            "slow" => {
                let (speed_mps, least_mps) = (self.speed_mps, kochin::LEAST_SPEED_MPS);
                let name = &self.name;
                return Some(format!(
                    "ship \"{name}\" raises no waves at {speed_mps} m/s: slower than {least_mps} m/s they are ripples"
                ));
            }
            "unresolved" => {
                format!("shorter than {} facets of {facet_m} m", free_waves::LEAST_FACETS_A_WAVE)
            }
            "band-limited" => {
                let limit = ship.kelvin.and_then(|kelvin| kelvin.band_limit_radpm);
                let limit_radpm = limit.unwrap_or(0.7 * std::f64::consts::PI / facet_m);
                format!("beyond its band limit of {limit_radpm} rad/m")
            }
            _ => return None,
        };
        let name = &self.name;
        Some(format!("no waves of ship \"{name}\" on the map: the longest, {longest_m:.2} m, are {why}"))
    }
}

/// Extents of a mesh.
pub(super) fn mesh_text([along, across, up]: [[f64; 2]; 3]) -> String {
    format!(
        "reaches from {:.1} to {:.1} m forward of midship, {:.1} to {:.1} m to port, {:.1} to {:.1} m up",
        along[0], along[1], across[0], across[1], up[0], up[1]
    )
}

/// What is odd of a superstructure on a hull of a length: it lies on its side, or is much larger than the
/// ship.
fn mesh_warning(ship: &Ship, length_m: f64, extents_m: [[f64; 2]; 3]) -> Option<String> {
    let [along, across, up] = extents_m;
    let middle = |[low, high]: [f64; 2]| (0.5 * (low + high)).abs() / (high - low).max(f64::MIN_POSITIVE);
    let name = &ship.name;
    // What stands on a ship lies on both sides of her plane of symmetry and above the waterline.
    if middle(up) < 0.05 && across[0] * across[1] >= 0.0 {
        let key = if ship.mesh.up == UpAxis::Z { "y" } else { "z" };
        let extents = mesh_text(extents_m);
        return Some(format!(
            "superstructure of ship \"{name}\" lies on its side: {extents}; up = \"{key}\" would turn it"
        ));
    }
    let largest_m = [along, across, up].map(|[low, high]| high - low).into_iter().fold(0.0, f64::max);
    (largest_m > 1.5 * length_m).then(|| {
        format!(
            "superstructure of ship \"{name}\" is {largest_m:.0} m wide, the ship {length_m:.0} m long: is its file in metres?"
        )
    })
}

/// The particular furthest from the stated one.
fn furthest_particular(hull: &Hull) -> Option<(&'static str, f64)> {
    let found = Particulars::of(hull).values();
    let rows = QUANTITIES.into_iter().zip(found).zip(hull.stated().values);
    rows.filter_map(|((quantity, computed), stated)| {
        Some((quantity, Particulars::difference_percent(quantity, computed, stated?)))
    })
    .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}

/// Adds ships to an adequacy.
pub(super) fn ships(prepared: &Prepared, sea: &Sea, adequacy: &mut Adequacy) -> Result<(), BuildErrors> {
    let facet_m = sea.patch.facet_m;
    let mut faults = Vec::new();
    for ship in &prepared.scene().ships {
        match ShipOutlook::of(ship, facet_m) {
            Ok(found) => {
                adequacy.warnings.extend(found.warning(ship, facet_m));
                if ship.echo && found.scatterers + found.panels == 0 {
                    adequacy.warnings.push(format!(
                        "ship \"{}\" has echo = true, but mesh = false and its hull has no [[scatterer]]: it returns nothing",
                        ship.name
                    ));
                }
                let mesh = found.superstructure_m;
                adequacy.warnings.extend(mesh.and_then(|mesh| mesh_warning(ship, found.length_m, mesh)));
                if ship.kelvin.is_some() || ship.turbulent.is_some() {
                    adequacy.warnings.extend(outside(ship, found.length_m, prepared, sea)?);
                }
                adequacy.ships.push(found);
            }
            Err(fault) => faults.push(BuildError::Ship(fault)),
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(BuildErrors(faults)) }
}

/// A ship that is never on the patch, and whether its wake is.
fn outside(
    ship: &Ship,
    length_m: f64,
    prepared: &Prepared,
    sea: &Sea,
) -> Result<Option<String>, BuildErrors> {
    let course = fleet::course(ship);
    let mut reached = false;
    for at in prepared.spread(3) {
        let patch = at.patch(sea)?;
        let pose = course.pose(at.elapsed_s);
        if let Some(way) = &ship.trajectory {
            if holds(&patch, Sailed::on(way, at.elapsed_s, pose.ahead).position_m) {
                return Ok(None);
            }
            continue;
        }
        if holds(&patch, pose.position_m) {
            return Ok(None);
        }
        reached |= lattice(at.scene(), &patch).iter().any(|point| {
            let [x_m, y_m, _] = point.to_array();
            let [astern_m, starboard_m] = pose.astern_starboard_m([x_m, y_m]);
            let behind_m = astern_m + 0.5 * length_m;
            behind_m > 0.0 && starboard_m.abs() <= WEDGE_TANGENT * behind_m
        });
    }
    if ship.trajectory.is_some() {
        let name = &ship.name;
        return Ok(Some(format!(
            "ship \"{name}\" lies outside the patch of sea at the start, middle and end of the run"
        )));
    }
    let wake = if reached { ": its wake reaches it" } else { ", and so does its wake" };
    let name = &ship.name;
    Ok(Some(format!(
        "ship \"{name}\" lies outside the patch of sea at the start, middle and end of the run{wake}"
    )))
}

fn holds(patch: &Patch, position_m: [f64; 2]) -> bool {
    (0..2).all(|axis| {
        let low_m = (patch.first[axis] as f64 - 0.5) * patch.facet_m;
        (low_m..low_m + patch.size_m()[axis]).contains(&position_m[axis])
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::scene::ship::{HullGiven, KelvinWake, TurbulentWake};

    fn wigley(length_m: f64, beam_m: f64, draught_m: f64, speed_mps: f64) -> Ship {
        Ship {
            name: "wigley".to_owned(),
            hull: HullGiven::Wigley { beam_m, draught_m },
            length_m: Some(length_m),
            position_m: [0.0, 0.0],
            heading_rad: 0.0,
            speed_mps,
            kelvin: Some(KelvinWake::default()),
            turbulent: Some(TurbulentWake::default()),
            echo: false,
            mesh: Default::default(),
            trajectory: None,
            panels: Default::default(),
        }
    }

    #[test]
    fn a_ship_at_the_edge_is_on_the_patch() {
        let patch = Patch::new([8.0, 4.0], 1.0, [0.0, 0.0]).unwrap();
        // Facets lie about their centres: from -4.5 to 3.5 m, and from -2.5 to 1.5 m.
        assert!(holds(&patch, [-4.4, 1.4]) && holds(&patch, [3.4, -2.4]));
        assert!(!holds(&patch, [3.6, 0.0]) && !holds(&patch, [0.0, 1.6]) && !holds(&patch, [-4.6, 0.0]));
    }

    #[test]
    fn froude_and_wavelength_are_those_of_their_formulas() {
        let ship = ShipOutlook::of(&wigley(100.0, 10.0, 6.25, 9.0), 1.0).unwrap();
        // Products and a root: a few roundings.
        assert!((ship.froude / (9.0 / 981f64.sqrt()) - 1.0).abs() < 1e-15);
        assert!((ship.transverse_wavelength_m.unwrap() / (TAU * 81.0 / 9.81) - 1.0).abs() < 1e-15);
        assert_eq!((ship.waves, ship.furthest_particular), ("waves", None));
    }

    proptest! {
        #![proptest_config(crate::rng::cases::proptests(32))]

        #[test]
        fn figures_are_numbers(
            length in -1.3..3.0f64,
            ratios in [-4.0..0.0f64, -4.0..0.0f64],
            speed in -6.0..2.0f64,
            facet in -2.0..3.0f64,
        ) {
            let length_m = 10f64.powf(length).max(0.05);
            let [beam_m, draught_m] = ratios.map(|ratio| length_m * 10f64.powf(ratio).max(1.0001e-4));
            let ship = wigley(length_m, beam_m, draught_m, 10f64.powf(speed));
            let found = ShipOutlook::of(&ship, 10f64.powf(facet)).unwrap();
            let numbers = [Some(found.froude), found.transverse_wavelength_m, found.resistance_n];
            prop_assert!(numbers.iter().flatten().all(|value| value.is_finite() && *value >= 0.0), "{found:?}");
        }
    }
}
