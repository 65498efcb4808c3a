//! Clocks of antennas.

use crate::config::error::Problem;
use crate::config::keys::{self, Key};
use crate::config::section::Section;
use crate::radar::clock::Oscillator;
use crate::scene::clock::{Clock, Clocks, NamedClock};

/// One day, s.
const DAY_S: f64 = 86_400.0;

/// Clocks as they are read, antenna by antenna.
#[derive(Default)]
pub(super) struct Given {
    clocks: Clocks,
    /// Further names of antennas that share a clock, and its place.
    also: Vec<(String, usize)>,
    faulty: bool,
}

impl Given {
    /// Takes the clock of the next antenna.
    pub(super) fn take(
        &mut self,
        antenna: &Section<'_>,
        key: &'static Key,
        name: Option<String>,
        receives: bool,
    ) {
        let written = antenna.has(key);
        let place = antenna.section(key).and_then(|section| self.read(section, name));
        self.faulty |= written && place.is_none();
        let list = if receives { &mut self.clocks.receivers } else { &mut self.clocks.transmitters };
        list.push(place);
    }

    /// The next receiver, of this name, has the clock of the last.
    pub(super) fn share_last(&mut self, name: Option<String>) {
        let last = self.clocks.receivers.last().copied().flatten();
        self.also.extend(name.zip(last));
        self.clocks.receivers.push(last);
    }

    /// Whether any antenna has one.
    pub(super) fn has_any(&self) -> bool {
        self.clocks.transmitters.iter().chain(&self.clocks.receivers).any(Option::is_some)
    }

    /// All clocks, unless one is faulty.
    pub(super) fn clocks(self) -> Option<Clocks> {
        (!self.faulty).then_some(self.clocks)
    }

    fn read(&mut self, section: Section<'_>, name: Option<String>) -> Option<usize> {
        use keys::clock as k;
        let shares = section.has(&k::SAME_AS);
        let other = section.name(&k::SAME_AS);
        let (offset_s, drift) = (section.number(&k::OFFSET_S), section.number(&k::DRIFT));
        let ageing_per_day = section.number(&k::AGEING_PER_DAY);
        let of_kind = section.choice(&k::PRESET).map(Oscillator::noise_h);
        let noise = section.vector::<5>(&k::NOISE_H);
        let bandwidth_hz = section.number(&k::BANDWIDTH_HZ);
        let own = [&k::OFFSET_S, &k::DRIFT, &k::AGEING_PER_DAY, &k::PRESET, &k::NOISE_H, &k::BANDWIDTH_HZ];
        if shares {
            section.idle(&own, "with same_as");
        } else {
            section.at_most_one(&[&k::PRESET, &k::NOISE_H]);
        }
        let sound = [&k::NOISE_H, &k::BANDWIDTH_HZ, &k::PRESET].into_iter().zip([
            noise.is_some(),
            bandwidth_hz.is_some(),
            of_kind.is_some(),
        ]);
        let sound = sound.fold(true, |sound, (key, read)| sound && (read || !section.has(key)));
        let place = match (shares, other) {
            (true, Some(other)) => {
                let found = self.clocks.clocks.iter().position(|clock| clock.name == other);
                let also = || self.also.iter().find(|(name, _)| *name == other).map(|(_, place)| *place);
                let found = found.or_else(also);
                if found.is_none() {
                    let known: Vec<&str> = self.clocks.clocks.iter().map(|c| c.name.as_str()).collect();
                    let known =
                        if known.is_empty() { "none are defined".to_owned() } else { known.join(", ") };
                    let what = "antenna with a clock of its own above";
                    section.fault(&k::SAME_AS, Problem::NoSuch { name: other, what, known });
                }
                found
            }
            _ => None,
        };
        section.finish();
        if shares {
            return place;
        }
        let clock = Clock {
            offset_s: offset_s?,
            drift: drift?,
            ageing_per_s: ageing_per_day? / DAY_S,
            noise: noise.or(of_kind).unwrap_or_default(),
            bandwidth_hz,
        };
        self.clocks.clocks.push(NamedClock { name: name?, clock });
        sound.then(|| self.clocks.clocks.len() - 1)
    }
}
