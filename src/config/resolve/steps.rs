//! Beams that jump: how long they stay, and what they cannot be beside.

use crate::config::error::Problem;
use crate::config::keys::radar::PRI_US;
use crate::config::section::Section;
use crate::scene::radar::{AntennaMount, Pointing, Scan, ScanLaw};
use crate::time::PulseTimes;

/// Whether the beam of an antenna jumps.
pub(super) fn jumps(mount: &AntennaMount) -> bool {
    mount.pointing.dwell_pulses().is_some()
}

/// How long the beam of a mount stays in a direction, s.
fn dwell_of(mount: &mut AntennaMount) -> Option<(u64, &mut f64)> {
    match &mut mount.pointing {
        Pointing::Scan(Scan { law: ScanLaw::Steps { dwell_pulses, dwell_s, .. }, .. }) => {
            Some((*dwell_pulses, dwell_s))
        }
        _ => None,
    }
}

/// Says how long the beams of the radar's antennas stay, by its intervals. Faults dwells that are not always
/// as long.
pub(super) fn dwell<'a>(
    section: &Section<'_>,
    antennas: impl Iterator<Item = (&'a str, &'a mut AntennaMount)>,
    emissions: &PulseTimes,
) {
    let in_turn = emissions.intervals_s().len().max(1) as u64;
    for (name, mount) in antennas {
        let Some((pulses, dwell_s)) = dwell_of(mount) else { continue };
        *dwell_s = emissions.interval_s(0, pulses);
        if pulses % in_turn != 0 {
            let found = format!("{in_turn} intervals in turn beside dwell_pulses = {pulses} of \"{name}\"");
            let allowed = format!("a dwell of a multiple of {in_turn} pulses");
            section.fault(&PRI_US, Problem::Type { found, allowed });
        }
    }
}
