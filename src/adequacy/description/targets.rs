//! What is modelled of point targets.

use std::collections::BTreeMap;

use super::{Described, described};
use crate::scene::Target;

/// Adds what makes the echo of targets vary.
pub(super) fn models(targets: &[Target], with: &mut Vec<Described>, without: &mut Vec<Described>) {
    let tracked = targets.iter().filter(|target| target.trajectory.is_some()).count();
    if tracked > 0 {
        with.push(described(
            "tracks of targets",
            format!("{tracked} of {} do not go straight on", targets.len()),
        ));
    }
    let floating = targets.iter().filter(|target| target.floating.is_some()).count();
    if floating > 0 {
        with.push(described(
            "heave of targets",
            format!(
                "{floating} ride the waves of the sea that are longer than they; aspects tilt with the slope"
            ),
        ));
        without.push(described("motion of floating targets", "no resonance, no sway, no waves of ships"));
    } else {
        without.push(described("heave of targets", "target.floating = false: heights keep to the mean sea"));
    }
    let mirrored = targets.iter().filter(|target| target.multipath).count();
    if mirrored > 0 {
        let how = "four paths each by the mean sea: Fresnel, roughness factor, divergence";
        with.push(described("multipath", format!("{mirrored} of {}: {how}", targets.len())));
        without
            .push(described("diffuse multipath", "nothing but the coherent field; none to hulls or the sea"));
    } else {
        without.push(described("multipath", "target.multipath = false: targets are in free space"));
    }
    let by_aspect = targets.iter().filter(|target| target.aspect.is_some()).count();
    if by_aspect > 0 {
        let how = "from tables of monostatic cross sections, read at the bisector of both antennas; no phase";
        with.push(described("target aspect", format!("{by_aspect} {how}")));
    } else {
        without.push(described("target aspect", "no target.rcs_csv: the same cross section from all sides"));
    }
    let mut cases: BTreeMap<u8, usize> = BTreeMap::new();
    for target in targets {
        *cases.entry(target.swerling.case()).or_default() += 1;
    }
    let steady = cases.remove(&0).unwrap_or(0);
    if cases.is_empty() {
        without.push(described("target fluctuation", "target.swerling = 0: constant cross sections"));
        return;
    }
    let of = |(case, count): (&u8, &usize)| format!("{count} of Swerling's case {case}");
    let mut parts: Vec<String> = cases.iter().map(of).collect();
    if steady > 0 {
        parts.push(format!("{steady} constant"));
    }
    with.push(described("target fluctuation", format!("{}; phases do not fluctuate", parts.join(", "))));
}
