//! What is modelled of point targets.

use std::collections::BTreeMap;

use super::{Described, described};
use crate::scene::Target;

/// Adds what makes the echo of targets vary.
pub(super) fn models(targets: &[Target], with: &mut Vec<Described>, without: &mut Vec<Described>) {
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
