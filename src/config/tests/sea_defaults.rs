//! Effects of the sea that are on unless a scenario asks for what they cannot do.

use super::sea::sea_of;
use crate::scene::sea::{Breaking, Waves};

#[test]
fn waves_are_choppy_and_break_where_they_can() {
    let waves = |list: &[(&str, &str)]| sea_of(list).waves;
    assert_eq!([waves(&[]), waves(&[("sea.waves", "linear")])], [Waves::Choppy, Waves::Linear]);
    // What choppy waves cannot do is asked for.
    assert_eq!(waves(&[("sea.depth_m", "20")]), Waves::Linear);
    assert_eq!(waves(&[("sea.scattering.displacement", "false")]), Waves::Linear);
    assert_eq!(
        waves(&[("target", "[{ position_m = [0, 0, 1], rcs_m2 = 1, floating = true }]")]),
        Waves::Linear
    );
    assert_eq!(
        waves(&[("target", "[{ position_m = [0, 0, 1], rcs_m2 = 1, floating = false }]")]),
        Waves::Choppy
    );
    let breaking = |list: &[(&str, &str)]| sea_of(list).scattering.breaking;
    assert_eq!(
        [breaking(&[]), breaking(&[("sea.scattering.breaking", "off")])],
        [Breaking::Whitecaps, Breaking::Off]
    );
    let large = [("scene.facet_m", "4"), ("scene.patch_size_m", "[2640, 2640]")];
    assert_eq!(breaking(&large), Breaking::Whitecaps);
    // More scatterers than facets in a gale, or than are allowed.
    let coarse = [("scene.facet_m", "5"), ("scene.patch_size_m", "[500, 500]")];
    assert_eq!(breaking(&coarse), Breaking::Off);
    let larger = [large[0], ("scene.patch_size_m", "[2656, 2656]")];
    assert_eq!(breaking(&larger), Breaking::Off);
    let asked = ("sea.scattering.breaking", "whitecaps");
    assert_eq!(breaking(&[coarse[0], coarse[1], asked]), Breaking::Whitecaps);
}
