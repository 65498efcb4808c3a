//! Changes of what a platform reports, while a run goes on.
//!
//! A change has a platform and a first pulse: every pulse from that one on has it, and none before. It comes
//! from the scenario (`[[event]]`) or from somebody who sends it ([`crate::pipeline::control`]); either way
//! it is one line of text:
//!
//! ```text
//! step AXIS VALUE UNIT      adds to the error of an axis                     step position.up 5 m
//! bias AXIS VALUE UNIT      sets its constant part                           bias attitude.heading 0.3 deg
//! ramp AXIS VALUE UNIT/s    sets by how much it grows from now on            ramp position.east -0.5 m/s
//! dropout SECONDS s         nothing new is reported for so long              dropout 2.5 s
//! latency MS ms             reports made from now on arrive so much later    latency 250 ms
//! clear                     removes what changes have brought                clear
//! ```
//!
//! `AXIS` is `position` or `velocity` with `.east`, `.north`, `.up`, or `attitude` with `.roll`, `.pitch`,
//! `.heading`. With `b` the constant of the error model ([`crate::motion::errors`]), `S` the steps since the
//! last `bias` or `clear`, and `r` the ramp, the error of an axis is, in addition to the other parts of the
//! model,
//!
//! ```text
//! e = (b, or the last bias) + S + r (t_k - t_r)     t_k: epoch of the report, t_r: when the ramp began; m, m/s, rad
//! ```
//!
//! A ramp of the position is in the velocity as well, as a ramp of the model is; another ramp goes on from
//! what has grown. A dropout holds the last report from before it, or moves it on, as `dropouts.during` of
//! the model has it; what changes meanwhile shows when it ends, and one more dropout makes it longer. When
//! the latency grows, what had arrived before stays at hand until a later report arrives. `clear` ends
//! dropouts too.
//!
//! What is reported is a function of the instant and of the list of changes alone. Readers take a lock for
//! reading where there are changes, and look at one number where there are none; nothing is allocated.
//!
//! ```
//! use nereus::motion::changes::Change;
//! let change: Change = "step position.up 5 m".parse()?;
//! assert_eq!(change.to_string(), "step position.up 5 m");
//! let error = "step position.up 5 deg".parse::<Change>().unwrap_err();
//! assert_eq!(error.to_string(), "unit 'deg' of position.up: allowed: m");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod standing;
mod grammar;

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, PoisonError, RwLock};

use thiserror::Error;

use crate::motion::errors::AXES;
use crate::pulse::log::{Entry, Log, Origin};
use crate::time::{PulseTimes, TimeTag};

pub use grammar::{AXIS_NAMES, NotAChange, addressed};
pub use standing::{Standing, latest, standing};

/// Most changes of a run.
pub const MOST_CHANGES: usize = 1024;

/// What changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Adds to the error of an axis.
    Step {
        /// Which of [`crate::motion::errors::AXES`].
        axis: usize,
        /// In the unit as written: m, m/s, degrees.
        value: f64,
    },
    /// Sets the constant part of the error of an axis.
    Bias {
        /// Which.
        axis: usize,
        /// In the unit as written.
        value: f64,
    },
    /// Sets the growth of the error of an axis.
    Ramp {
        /// Which.
        axis: usize,
        /// In the unit as written, per second.
        value: f64,
    },
    /// Nothing new is reported for a while.
    Dropout {
        /// How long, s.
        seconds: f64,
    },
    /// Reports take so long to arrive.
    Latency {
        /// How long, ms.
        ms: f64,
    },
    /// Removes what changes have brought.
    Clear,
}

impl Change {
    /// Whether it has a meaning: an axis that there is, finite numbers, times that are not negative.
    pub fn is_sound(&self) -> bool {
        match *self {
            Self::Step { axis, value } | Self::Bias { axis, value } | Self::Ramp { axis, value } => {
                axis < AXES && value.is_finite()
            }
            Self::Dropout { seconds: time } | Self::Latency { ms: time } => time.is_finite() && time >= 0.0,
            Self::Clear => true,
        }
    }
}

/// A change of the scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// The first pulse that has it.
    pub pulse: u64,
    /// The platform's place.
    pub platform: usize,
    /// What changes.
    pub change: Change,
}

/// A change and its instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Given {
    /// The first pulse that has it.
    pub pulse: u64,
    /// Emission of that pulse.
    pub time: TimeTag,
    /// The same, s after pulse 0.
    pub t_s: f64,
    /// What changes.
    pub change: Change,
}

/// Why a change is not taken.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ChangeFault {
    /// Too many.
    #[error("more than {MOST_CHANGES} changes; allowed: at most so many in a run")]
    TooMany,
    /// A platform that is none.
    #[error("platform '{name}': allowed: {known}")]
    Platform {
        /// As named; empty: not named.
        name: String,
        /// Those that there are.
        known: String,
    },
    /// Numbers that no text would give.
    #[error("change '{text}': allowed: an axis that there is and finite numbers, times not below 0")]
    Unsound {
        /// As it would be written.
        text: String,
    },
    /// No pulse is left that could have it.
    #[error("pulse {pulse}: allowed: before pulse {end}, where the run ends")]
    AfterTheEnd {
        /// The pulse.
        pulse: u64,
        /// The pulse after the last one.
        end: u64,
    },
}

/// The changes of one platform, in the order of their pulses.
#[derive(Debug, Default)]
pub struct PlatformChanges {
    /// In front of the lock.
    count: AtomicUsize,
    given: RwLock<Vec<Given>>,
}

impl PlatformChanges {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count.load(Ordering::Acquire) == 0
    }

    /// Looks at them.
    pub fn read<R>(&self, look: impl FnOnce(&[Given]) -> R) -> R {
        if self.is_empty() {
            return look(&[]);
        }
        look(&self.given.read().unwrap_or_else(PoisonError::into_inner))
    }

    fn give(&self, given: Given) {
        let mut list = self.given.write().unwrap_or_else(PoisonError::into_inner);
        let place = list.partition_point(|other| other.pulse <= given.pulse);
        list.insert(place, given);
        self.count.store(list.len(), Ordering::Release);
    }
}

/// All changes of a run.
#[derive(Debug)]
pub struct Changes {
    names: Vec<String>,
    platforms: Vec<Arc<PlatformChanges>>,
    times: PulseTimes,
    start: TimeTag,
    log: Arc<Log>,
}

impl Changes {
    /// None yet, for platforms of these names and pulses at these times, the first at `start`.
    pub fn new(names: &[String], times: &PulseTimes, start: TimeTag) -> Self {
        Self {
            names: names.to_vec(),
            platforms: names.iter().map(|_| Arc::default()).collect(),
            times: times.clone(),
            start,
            log: Arc::default(),
        }
    }

    /// Those of a platform.
    pub fn of(&self, platform: usize) -> Option<&Arc<PlatformChanges>> {
        self.platforms.get(platform)
    }

    /// What recordings are reported.
    pub fn log(&self) -> &Arc<Log> {
        &self.log
    }

    /// The place of a platform; the only one if none is named.
    ///
    /// # Errors
    /// Names that no platform has.
    pub fn platform(&self, name: Option<&str>) -> Result<usize, ChangeFault> {
        let found = match name {
            Some(name) => self.names.iter().position(|own| own == name),
            None => (self.names.len() == 1).then_some(0),
        };
        found.ok_or_else(|| {
            let name = name.unwrap_or_default().to_owned();
            ChangeFault::Platform { name, known: self.names.join(", ") }
        })
    }

    /// Takes a change. It must not concern a pulse that has been begun.
    ///
    /// # Errors
    /// More than [`MOST_CHANGES`]; a platform that is none.
    pub fn enter(&self, event: &Event, origin: Origin) -> Result<(), ChangeFault> {
        let Event { pulse, platform, change } = *event;
        let (Some(of), Some(name)) = (self.platforms.get(platform), self.names.get(platform)) else {
            return Err(ChangeFault::Platform { name: platform.to_string(), known: self.names.join(", ") });
        };
        if !change.is_sound() {
            return Err(ChangeFault::Unsound { text: change.to_string() });
        }
        let taken: usize = self.platforms.iter().map(|of| of.count.load(Ordering::Acquire)).sum();
        if taken >= MOST_CHANGES {
            return Err(ChangeFault::TooMany);
        }
        let time = self.times.emission(self.start, pulse);
        let text = change.to_string();
        let (time_ns, _) = time.to_unix_ns();
        self.log.enter(Entry { pulse, time_ns, platform: name.clone(), text, origin });
        of.give(Given { pulse, time, t_s: time.since(self.start), change });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changes() -> Changes {
        let names = ["mast".to_owned(), "aircraft".to_owned()];
        Changes::new(&names, &PulseTimes::uniform(200.0).unwrap(), TimeTag::new(1_000_000, 0.25))
    }

    #[test]
    fn they_stand_in_the_order_of_their_pulses() {
        let changes = changes();
        for (pulse, text) in [(9, "dropout 1 s"), (3, "clear"), (9, "latency 2 ms")] {
            let event = Event { pulse, platform: 1, change: text.parse().unwrap() };
            changes.enter(&event, Origin::Control).unwrap();
        }
        let reported = changes.of(1).unwrap().read(|given| {
            given.iter().map(|one| (one.pulse, one.t_s, one.change.to_string())).collect::<Vec<_>>()
        });
        let text = |n: usize| reported[n].2.as_str();
        assert_eq!((text(0), text(1), text(2)), ("clear", "dropout 1 s", "latency 2 ms"));
        // A quarter of a second has been added and taken off: 2^-54 s.
        assert!(reported[0].0 == 3 && (reported[0].1 - 3.0 / 200.0).abs() < 1e-16);
        assert!(changes.of(0).unwrap().is_empty() && changes.of(2).is_none());
        assert_eq!(changes.log().entries().len(), 3);
    }

    #[test]
    fn there_is_an_end_to_them() {
        let changes = changes();
        let clear = Event { pulse: 1, platform: 0, change: Change::Clear };
        (0..MOST_CHANGES).for_each(|_| changes.enter(&clear, Origin::Scenario).unwrap());
        assert_eq!(changes.enter(&clear, Origin::Control), Err(ChangeFault::TooMany));
        let unsound = [Change::Step { axis: 9, value: 1.0 }, Change::Ramp { axis: 0, value: f64::NAN }];
        for change in unsound.into_iter().chain([Change::Dropout { seconds: -1.0 }]) {
            let reported = changes.enter(&Event { change, ..clear }, Origin::Control).unwrap_err();
            assert!(matches!(reported, ChangeFault::Unsound { .. }), "{reported}");
        }
    }

    proptest::proptest! {
        #![proptest_config(crate::rng::cases::proptests(256))]

        /// Whatever was changed, the report at hand is one that was made, and what is added is finite.
        #[test]
        fn any_list_has_a_meaning(
            list in proptest::collection::vec((0u64..50, 0usize..6, 0usize..AXES, -1e4f64..1e4), 0..12),
            model in 0usize..3,
            at in 0u64..60,
        ) {
            use crate::motion::errors::{Circumstances, Dropouts, ErrorModel, Errors, Between};
            let times = PulseTimes::uniform(200.0).unwrap();
            let of = Circumstances { seed: 1, platform: 0, times: &times, pulses: 60, before_s: 0.0 };
            let model = match model {
                0 => ErrorModel::default(),
                1 => ErrorModel { rate_hz: Some(70.0), latency_s: 0.01, jitter_s: 0.004, ..ErrorModel::default() },
                _ => ErrorModel {
                    dropouts: Some(Dropouts { per_hour: 1e5, mean_s: 0.02, during: Between::Hold }),
                    ..ErrorModel::default()
                },
            };
            let errors = Errors::new(&model, &of).unwrap();
            let mut given: Vec<Given> = list
                .iter()
                .map(|&(pulse, kind, axis, value)| {
                    let change = match kind {
                        0 => Change::Step { axis, value },
                        1 => Change::Bias { axis, value },
                        2 => Change::Ramp { axis, value },
                        3 => Change::Dropout { seconds: value.abs() * 1e-5 },
                        4 => Change::Latency { ms: value.abs() * 1e-2 },
                        _ => Change::Clear,
                    };
                    let time = times.emission(TimeTag::default(), pulse);
                    Given { pulse, time, t_s: time.since(TimeTag::default()), change }
                })
                .collect();
            given.sort_by_key(|one| one.pulse);
            let begun = given.partition_point(|one| one.pulse <= at);
            let t_s = times.interval_s(0, at);
            let (in_effect, latest) = latest(&errors, &given[..begun], t_s);
            proptest::prop_assert!(in_effect <= begun);
            let epoch_s = latest.time_s.unwrap_or(t_s);
            proptest::prop_assert!(epoch_s <= t_s + 1e-6);
            let added = standing(&errors, &given[..in_effect], epoch_s);
            proptest::prop_assert!(added.error.iter().chain(&added.growth).all(|value| value.is_finite()));
            // A list that ends with `clear` adds nothing.
            let cleared = Given { change: Change::Clear, pulse: at, time: TimeTag::default(), t_s };
            let all: Vec<Given> = given[..begun].iter().copied().chain([cleared]).collect();
            proptest::prop_assert!(standing(&errors, &all, t_s).is_nothing());
        }
    }
}
