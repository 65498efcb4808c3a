//! Receivers, and arrays of them.

use super::antenna::{self, MountKeys, mount_keys};
use super::clock::Given;
use super::window::gate;
use super::{Ground, Names};
use crate::config::error::Problem;
use crate::config::keys::{self, Key, figure};
use crate::config::section::Section;
use crate::frames::Vector;
use crate::scene::radar::{AntennaMount, PortErrors, Receiver};

/// The receivers of a table: one, or the elements of an array.
pub(super) fn receivers(
    section: Section<'_>,
    (names, transmitters): (&mut Names, &Names),
    ground: &Ground,
    platforms: &Names,
    clocks: &mut Given,
) -> Vec<Option<Receiver>> {
    use keys::receiver as k;
    let name = section.name(&k::NAME);
    let array = section.section(&k::ARRAY).and_then(array);
    let is_array = section.has(&k::ARRAY);
    let of_array = array.as_ref().map_or(1, |array| array.errors.len());
    for element in 0..of_array {
        // Nobody asks for elements of an array that is not known.
        let known = if is_array && array.is_none() { None } else { name.as_ref() };
        let own = known.map(|name| if is_array { format!("{name}-{element}") } else { name.clone() });
        names.enter(&section, &k::NAME, own, &[transmitters]);
        if element == 0 {
            clocks.take(&section, &k::CLOCK, names.last(), true);
        } else {
            clocks.share_last(names.last());
        }
    }
    let antenna = antenna::mount(&section, &mount_keys!(receiver), ground, platforms);
    let (gain_db, phase_deg) = (section.number(&k::GAIN_DB), section.number(&k::PHASE_DEG));
    let own = section.has(&k::WINDOW);
    let gate = section.section(&k::WINDOW).and_then(|section| {
        use keys::own_window::{FOLLOW, START_US};
        let all = "every receiver takes radar.window.samples";
        section.idle(&[&keys::window::SAMPLES], all);
        let gate = gate(&section, [&START_US, &FOLLOW], ground, platforms);
        section.finish();
        gate
    });
    section.finish();
    let of_all = || {
        let (mount, gain_db, phase_deg) = (antenna?, gain_db?, phase_deg?);
        let ports = PortErrors { gain_db, phase_rad: phase_deg.to_radians(), ..mount.ports };
        let array = if is_array { array? } else { Array { spacing_m: [0.0; 3], errors: vec![[0.0; 2]] } };
        Some((AntennaMount { ports, ..mount }, if own { Some(gate?) } else { None }, array))
    };
    let Some((mount, gate, array)) = of_all() else { return vec![None; of_array] };
    let first = names.names.len() - of_array;
    let element = |(n, [gain_db, phase_deg]): (usize, &[f64; 2])| {
        let along = n as f64 - 0.5 * (of_array - 1) as f64;
        let [forward, starboard, down] = array.spacing_m.map(|spacing_m| along * spacing_m);
        let ports = PortErrors {
            gain_db: mount.ports.gain_db + gain_db,
            phase_rad: mount.ports.phase_rad + phase_deg.to_radians(),
            ..mount.ports
        };
        let from_middle = Vector::new(forward, starboard, down);
        let lever_arm = mount.lever_arm + from_middle;
        let name = names.names.get(first + n).cloned().flatten()?;
        Some(Receiver {
            name,
            antenna: AntennaMount { lever_arm, of_array: from_middle, ports, ..mount.clone() },
            gate: gate.clone(),
        })
    };
    array.errors.iter().enumerate().map(element).collect()
}

/// Where the elements of an array are, and their errors, dB and degrees.
struct Array {
    spacing_m: [f64; 3],
    errors: Vec<[f64; 2]>,
}

fn array(section: Section<'_>) -> Option<Array> {
    use keys::array::{ELEMENTS, GAINS_DB, PHASES_DEG, SPACING_M};
    let elements = section.count(&ELEMENTS).and_then(|count| usize::try_from(count).ok());
    let spacing_m = section.vector(&SPACING_M);
    if spacing_m == Some([0.0; 3]) {
        let (found, allowed) = ("no distance".to_owned(), "a distance between elements".to_owned());
        section.fault(&SPACING_M, Problem::Type { found, allowed });
    }
    let list = |key: &'static Key| {
        let list = section.numbers(key);
        if !section.has(key) {
            return elements.map(|count| vec![0.0; count]);
        }
        if let (Some(list), Some(count)) = (&list, elements)
            && list.len() != count
        {
            let found = format!("{} numbers", list.len());
            let allowed = format!("one for each of the {} elements", figure(count as f64));
            section.fault(key, Problem::Type { found, allowed });
            return None;
        }
        list
    };
    let (gains_db, phases_deg) = (list(&GAINS_DB), list(&PHASES_DEG));
    section.finish();
    let (elements, gains_db, phases_deg) = (elements?, gains_db?, phases_deg?);
    let errors = (0..elements).map(|n| [gains_db[n], phases_deg[n]]).collect();
    Some(Array { spacing_m: spacing_m?, errors })
}
