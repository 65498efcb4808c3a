//! Ship wakes: Kelvin waves on a straight or slowly turning course or along a track, and the turbulent wake
//! (the strip) behind the stern.
//!
//! | page | holds |
//! | --- | --- |
//! | [`kochin`] | amplitude of the waves of any hull, and the resistance they mean |
//! | [`wigley`] | amplitude of the waves of a Wigley hull, in closed form |
//! | [`course`] | where a ship is, and how much it may turn |
//! | [`nodes`] | the waves of a ship as a finite sum: how many, which, and the band limit of a map |
//! | [`leg`] | waves of a ship that turns: those of straight legs, cross-faded |
//! | [`upstream`] | no waves ahead of the bow |
//! | [`free_waves`] | the wake of one ship; all fields at a point, summed wave by wave |
//! | [`nonuniform`] | sums of arbitrary plane waves on a grid of facets, by FFT |
//! | [`map`] | all fields of several wakes on a rectangle of facets |
//! | [`short_waves`] | the waves that a map leaves out, as a local spectrum within its facets |
//! | [`short_wave_nodes`] | the same on nodes, fast |
//! | [`turbulent`] | the strip of damped small waves |
//! | [`track_line`] | the track on which a ship leaves it |
//!
//! A hull enters through the complex amplitude of its free waves, `A(theta)` in metres, as a function of
//! `tan theta`; theta is the angle of a wave's direction from the course.
//!
//! ```
//! use nereus::scene::Patch;
//! use nereus::sea::surface::{Fields, Grid, Selection};
//! use nereus::sea::wake::{Course, Map, Reach, Settings, Wake, Wigley};
//! let hull = Wigley { length_m: 100.0, beam_m: 13.0, draught_m: 4.3 };
//! let course = Course::straight([60.0, 0.0], 0.0, 9.0);
//! let patch = Patch::new([256.0, 128.0], 2.0, [-60.0, 0.0])?;
//! let settings = Settings::new(patch.facet_m, Reach::of(&patch, &course, [0.0, 10.0])?);
//! let wake = Wake::new(course, hull.length_m, &settings, |tan_theta| hull.amplitude_m(9.0, tan_theta))?;
//! let mut map = Map::<f64>::new(vec![wake.clone()], &patch, -100.0)?;
//!
//! let grid = Grid::new(128, 64, 2.0)?;
//! let mut fields = Fields::new(&grid, Selection::ALL);
//! map.add(patch.first, 10.0, &mut fields)?;
//! let key = [-20, 4];
//! let sum = wake.at(patch.centre_m(key), 10.0)?;
//! assert!((fields.height_m[patch.nearest_index(key)] - sum.height_m).abs() < 1e-5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod course;
pub mod cut;
pub mod fault;
pub mod free_waves;
pub mod kochin;
pub mod leg;
pub mod map;
pub mod nodes;
pub mod nonuniform;
pub mod short_wave_nodes;
pub mod short_waves;
pub mod track_line;
pub mod turbulent;
pub mod upstream;
pub mod wigley;

pub use course::{Course, Reach};
pub use fault::WakeError;
pub use free_waves::{Presence, Settings, Wake};
pub use leg::{Leg, LegWindow};
pub use map::Map;
pub use nodes::Band;
pub use short_wave_nodes::ShortWaveNodes;
pub use short_waves::ShortWaves;
pub use track_line::TrackLine;
pub use turbulent::TurbulentStrip;
pub use upstream::Upstream;
pub use wigley::Wigley;
