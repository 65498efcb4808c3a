//! What a processor makes of recorded pulses: complex images and their quality.
//!
//! | page | holds |
//! | --- | --- |
//! | [`focus`] | a recording to its images, with the defaults of `nereus focus` |
//! | [`range_compress`] | pulse compression with the recorded replica |
//! | [`taper`] | weights over a band or an aperture |
//! | [`backproject`] | bistatic time-domain back-projection: f64 reference, fast f32 |
//! | [`point_target`] | what an image makes of a point: width, side lobes, place |
//! | [`degradation`] | what navigation errors do to a point: predicted from the paths, closed forms |
//! | [`ppi`] | plan position picture of a scanning antenna: power over range and reported bearing |
//! | [`video`] | a pulse to powers of range cells, as fast as pulses come |
//! | [`radials`] | reported azimuth and powers of each pulse of a scanning antenna, as fast as pulses come |
//! | [`multilook`] | means of power, percentiles |

pub mod taper;
pub mod range_compress;
pub mod backproject;
pub mod multilook;
pub mod point_target;
#[doc(hidden)]
pub mod degradation;
pub mod focus;
pub mod ppi;
pub mod video;
pub mod radials;
pub(crate) mod comparison;
pub(crate) mod two_way_gain;
