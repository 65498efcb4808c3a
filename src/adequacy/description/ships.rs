//! Ships in words.

use super::{Described, described};
use crate::adequacy::ShipOutlook;
use crate::adequacy::ships::mesh_text;
use crate::inputs::shown;
use crate::scene::Scene;
use crate::scene::ship::{HullGiven, Ship, ShipMotion};
use crate::sea::wake::leg::legs;
use crate::units::neat;

/// Below this Froude number real ships make smaller waves than thin ones.
const SLOW_FROUDE: f64 = 0.2;

/// What is modelled of ships, and what is not and why.
pub(super) fn models(scene: &Scene, with: &mut Vec<Described>, without: &mut Vec<Described>) {
    if scene.ships.is_empty() {
        without.push(described("ships and wakes", "no [[ship]], no [[ais]]"));
        return;
    }
    for ship in &scene.ships {
        with.push(described("ship", ship_text(ship)));
    }
    let idle = |what: &str, lacks: fn(&Ship) -> bool, why: &str, without: &mut Vec<Described>| {
        let names: Vec<&str> =
            scene.ships.iter().filter(|ship| lacks(ship)).map(|ship| ship.name.as_str()).collect();
        if !names.is_empty() {
            without.push(described(what, format!("{}: {why}", names.join(", "))));
        }
    };
    idle("waves of ships", |ship| ship.kelvin.is_none(), "wake = false", without);
    let smooth = |ship: &Ship| ship.kelvin.is_some_and(|kelvin| !kelvin.short_waves);
    idle(
        "short waves of ships",
        smooth,
        "wake_bragg = false, its default from 6 GHz on and on tracks",
        without,
    );
    idle("turbulent wakes", |ship| ship.turbulent.is_none(), "turbulent = false", without);
    idle("echo of ships", |ship| !ship.echo, "echo = false", without);
    let level = |ship: &Ship| ship.mesh.motion == ShipMotion::Level;
    idle("heave, roll and pitch of ships", level, "motion = \"level\": they ride level", without);
    without.push(described(
        "ships otherwise",
        "hulls neither break nor reflect waves, and hide the sea behind them only \
         where their mesh echoes",
    ));
}

fn ship_text(ship: &Ship) -> String {
    let hull = match &ship.hull {
        HullGiven::File(path) => shown(path),
        HullGiven::Wigley { beam_m, draught_m } => {
            format!("Wigley's hull of {} m beam and {} m draught", neat(*beam_m), neat(*draught_m))
        }
    };
    let scaled = ship.length_m.map_or(String::new(), |length_m| format!(", {length_m} m long"));
    let [e, n] = ship.position_m.map(neat);
    let towards_deg = ship.heading_rad.to_degrees().rem_euclid(360.0);
    let heading_deg = neat((90.0 - towards_deg).rem_euclid(360.0));
    let mut text = format!(
        "{}: {hull}{scaled}; from {e} m East, {n} m North, heading {heading_deg} deg from North at {} m/s",
        ship.name,
        neat(ship.speed_mps)
    );
    if let Some(way) = &ship.trajectory {
        let [first_s, last_s] = way.span_s().map(neat);
        text += &format!(
            " at pulse 0, on a track of {} knots from {first_s} to {last_s} s after it; {} straight legs make its \
             waves",
            way.knots().len(),
            legs(way).len()
        );
    }
    if let Some(kelvin) = &ship.kelvin {
        text += "; Kelvin wake";
        if let Some(limit_radpm) = kelvin.band_limit_radpm {
            text += &format!(" up to {limit_radpm} rad/m");
        }
        if kelvin.short_waves {
            text += ", what is shorter scatters within facets";
        }
    }
    if let Some(turbulent) = &ship.turbulent {
        text += &format!(
            "; turbulent wake (exponent {}, {} lengths, {} of the wind)",
            turbulent.spread_exponent, turbulent.decay_lengths, turbulent.wind_ratio
        );
    }
    if ship.echo {
        text += "; it echoes";
    }
    if ship.mesh.motion != ShipMotion::Level {
        text += "; it heaves, pitches and rolls with the waves";
    }
    text
}

/// The figures that follow from hull and speed.
pub fn rows(ships: &[ShipOutlook]) -> Vec<Described> {
    ships.iter().map(|ship| described(&ship.name, figures(ship))).collect()
}

fn force(newtons: f64) -> String {
    if newtons < 1e3 { format!("{newtons:.3} N") } else { format!("{:.2} kN", newtons / 1e3) }
}

/// A ship in a line.
pub fn figures(ship: &ShipOutlook) -> String {
    let mut text = format!(
        "{} of {:.1} m, beam {:.2} m, draught {:.2} m, at {} m/s: Froude number {:.3}",
        ship.hull, ship.length_m, ship.beam_m, ship.draught_m, ship.speed_mps, ship.froude
    );
    if let Some(transverse_m) = ship.transverse_wavelength_m {
        if ship.froude < SLOW_FROUDE {
            text += &format!(" (below {SLOW_FROUDE} real ships make smaller waves)");
        }
        text += &format!(", transverse waves {transverse_m:.2} m long");
    }
    if let Some(resistance_n) = ship.resistance_n {
        text += &format!(", wave resistance {}", force(resistance_n));
    }
    text += match ship.waves {
        "waves" => "; its wake is resolved",
        "off" => "; no waves asked for",
        "slow" => "; too slow for waves",
        "unresolved" => "; its wake is too fine for the facets",
        _ => "; its wake is beyond the band limit",
    };
    if ship.panels > 0 {
        text += &format!("; {} panels of its mesh echo", ship.panels);
    }
    if let Some(extents_m) = ship.superstructure_m {
        text += &format!("; its superstructure {}", mesh_text(extents_m));
    }
    if let Some(roll_period_s) = ship.roll_period_s {
        text += &format!("; it rides the waves and rolls with a period of {roll_period_s:.1} s");
    }
    if let Some((quantity, percent)) = ship.furthest_particular {
        let units = ["_m", "_m2", "_m3", "_percent"];
        let name = units.iter().find_map(|unit| quantity.strip_suffix(unit)).unwrap_or(quantity);
        let quantity = name.replace('_', " ");
        text += &format!(
            "; offsets agree with the stated particulars; largest deviation {percent:.2} % ({quantity})"
        );
    }
    text
}
