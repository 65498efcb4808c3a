//! The sea beyond the patch: what its keys mean, and what they refuse.

use super::*;
use crate::scene::sea::FarSea;

const SEA: &str = include_str!("../../../configs/sea.toml");

fn faults(list: &[(&str, &str)]) -> String {
    let error = parse(SEA, &in_configs(), &settings(list)).unwrap_err();
    error.faults().iter().map(|fault| format!("{fault}\n")).collect()
}

#[test]
fn the_sea_ends_with_the_patch_unless_asked() {
    let far =
        |list: &[(&str, &str)]| parse(SEA, &in_configs(), &settings(list)).unwrap().scene.sea.unwrap().far;
    assert_eq!((far(&[]), far(&[("sea.far.enabled", "false")])), (None, None));
    let usual = FarSea { cells: 4, most: 16_384, texture: true };
    assert_eq!(far(&[("sea.far.enabled", "true")]), Some(usual));
    let own = "{ enabled = true, cells = 9, most_cells = 1000, texture = false }";
    assert_eq!(far(&[("sea.far", own)]), Some(FarSea { cells: 9, most: 1000, texture: false }));
}

#[test]
fn a_far_sea_that_cannot_be_is_refused() {
    let on = ("sea.far.enabled", "true");
    let still = faults(&[on, ("sea.wind_mps", "0.1")]);
    assert!(still.contains("sea.wind_mps") && still.contains("0.3 m/s or more"), "{still}");
    let many = faults(&[on, ("sea.far.cells", "0"), ("sea.far.most_cells", "2000000000")]);
    assert!(many.contains("sea.far.cells") && many.contains("sea.far.most_cells: 2000000000"), "{many}");
    assert!(many.contains("1048576"), "{many}");
    let off = faults(&[("sea.far.cells", "2"), ("sea.far.texture", "false")]);
    assert!(off.contains("sea.far.cells") && off.contains("sea.far.texture"), "{off}");
    assert!(off.contains("enabled = false"), "{off}");
    let gate = faults(&[on, ("radar.window", "{ gate = 'continuous', samples = 1000 }")]);
    assert!(gate.contains("sea.far: a far sea beside gate"), "{gate}");
}
