//! The turbulent wake of a ship, as a scenario asks for it.

use crate::config::keys;
use crate::config::section::Section;
use crate::scene::ship::TurbulentWake;

pub(super) fn turbulent(section: Section<'_>) -> Option<TurbulentWake> {
    use keys::turbulent::{DECAY_LENGTHS, SPREAD_EXPONENT, WIND_RATIO};
    let spread_exponent = section.number(&SPREAD_EXPONENT);
    let decay_lengths = section.number(&DECAY_LENGTHS);
    let wind_ratio = section.number(&WIND_RATIO);
    section.finish();
    Some(TurbulentWake {
        spread_exponent: spread_exponent?,
        decay_lengths: decay_lengths?,
        wind_ratio: wind_ratio?,
    })
}
