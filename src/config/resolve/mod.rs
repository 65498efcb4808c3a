//! Tables become descriptions.
//!
//! Every function reads all keys of its table first, then closes the table, and only then gives up on
//! what is missing: so one pass reports every fault.

mod ais;
mod antenna;
mod calibration;
mod clock;
mod emitter;
mod errors;
mod event;
mod front_end;
mod land;
mod nav_out;
mod patch;
mod place;
mod plausible;
mod platform;
mod radar;
mod receiver;
mod sea;
mod ship;
mod signal;
mod ship_mesh;
mod turbulent;
mod slick;
mod steps;
mod stream;
mod target;
mod video;
mod way;
mod window;

use std::collections::HashMap;

use super::choices::{Begin, Curved, TrackKind};
use super::error::Problem;
use super::keys::{self, Key};
use super::section::Section;
use crate::echo::Fidelity;
use crate::frames::{Earth, Geodetic, SceneFrame};
use crate::motion::PlatformNav;
use crate::motion::changes::Event;
use crate::scene::Scene;
use crate::scene::calibration::Calibration;
use crate::scene::clock::Clocks;
use crate::time::TimeTag;
use crate::{sinks, transport};

/// What a scenario holds.
pub(super) struct Parts {
    pub(super) scene: Scene,
    pub(super) start_live: bool,
    pub(super) start_now: bool,
    pub(super) nav: Vec<PlatformNav>,
    pub(super) clocks: Clocks,
    pub(super) calibration: Vec<Calibration>,
    pub(super) events: Vec<Event>,
    pub(super) fidelity: Fidelity,
    pub(super) stream: transport::Settings,
    pub(super) relax_db: Vec<f64>,
    pub(super) monitor: Option<String>,
    pub(super) sinks: Vec<sinks::Settings>,
}

/// The scene frame, or what stands for it while faults are collected.
struct Ground {
    frame: SceneFrame,
    /// Undulation at the origin; `None` for a plain local frame.
    origin_h_m: Option<f64>,
    /// Whether the origin could be read (or is rightly absent).
    sound: bool,
}

impl Ground {
    /// Whether geodetic positions are possible; a faulty origin is not held against them.
    fn geodetic_allowed(&self) -> bool {
        self.origin_h_m.is_some() || !self.sound
    }
}

/// Names given so far, each beside the place where faulty ones were left out.
struct Names {
    what: &'static str,
    names: Vec<Option<String>>,
    /// Where each name stands first.
    places: HashMap<String, usize>,
}

impl Names {
    fn new(what: &'static str) -> Self {
        Self { what, names: Vec::new(), places: HashMap::new() }
    }

    /// Takes a name, or the place of a faulty one.
    fn push(&mut self, name: Option<String>) {
        if let Some(name) = &name {
            self.places.entry(name.clone()).or_insert(self.names.len());
        }
        self.names.push(name);
    }

    fn has(&self, name: &str) -> bool {
        self.places.contains_key(name)
    }

    /// The name that was just taken.
    fn last(&self) -> Option<String> {
        self.names.last().cloned().flatten()
    }

    /// Takes the name of a new entry, faulting duplicates (also against the antennas of `others`).
    fn take(&mut self, section: &Section<'_>, key: &'static Key, others: &[&Names]) {
        let name = section.name(key);
        self.enter(section, key, name, others);
    }

    /// The same where the name may be left out: the default one is entered like any other.
    fn take_or(&mut self, section: &Section<'_>, key: &'static Key, default: Option<String>) {
        let written = section.name(key);
        self.enter(section, key, if section.has(key) { written } else { default }, &[]);
    }

    fn enter(&mut self, section: &Section<'_>, key: &'static Key, name: Option<String>, others: &[&Names]) {
        if let Some(name) = &name
            && (self.has(name) || others.iter().any(|names| names.has(name)))
        {
            let what = if self.has(name) { self.what } else { "antenna" };
            section.fault(key, Problem::Duplicate { name: name.clone(), what });
        }
        self.push(name);
    }

    /// Place of a name, faulting names that nothing has.
    fn find(&self, section: &Section<'_>, key: &'static Key) -> Option<usize> {
        self.place_of(section, key, section.name(key)?)
    }

    /// The same of a name that was read.
    fn place_of(&self, section: &Section<'_>, key: &'static Key, name: String) -> Option<usize> {
        let found = self.places.get(&name).copied();
        if found.is_none() && self.names.iter().all(Option::is_some) {
            let mut known: Vec<&str> = self.names.iter().flatten().map(String::as_str).collect();
            known.dedup();
            let known = if known.is_empty() { "none are defined".to_owned() } else { known.join(", ") };
            section.fault(key, Problem::NoSuch { name, what: self.what, known });
        }
        found
    }

    /// Places of the names in a list, in order; of all where there is no list, `None` for a faulty one.
    fn find_all(&self, section: &Section<'_>, key: &'static Key) -> Option<Vec<usize>> {
        let given = section.words(key, |word| Some(word.to_owned()));
        if !section.has(key) {
            return Some((0..self.names.len()).collect());
        }
        let given = given?;
        if given.is_empty() {
            let known: Vec<&str> = self.names.iter().flatten().map(String::as_str).collect();
            let allowed = format!("one or more of {}", known.join(", "));
            section.fault(key, Problem::Type { found: "[]".to_owned(), allowed });
            return None;
        }
        let places: Vec<_> = given.into_iter().map(|name| self.place_of(section, key, name)).collect();
        let mut places = places.into_iter().collect::<Option<Vec<usize>>>()?;
        places.sort_unstable();
        places.dedup();
        Some(places)
    }

    /// The same where the name may be left out, if there is only one. That there is none is
    /// a fault elsewhere.
    fn find_among(&self, section: &Section<'_>, key: &'static Key) -> Option<usize> {
        if section.has(key) {
            return self.find(section, key);
        }
        section.name(key);
        if self.names.len() > 1 {
            let known: Vec<&str> = self.names.iter().flatten().map(String::as_str).collect();
            section.fault(key, Problem::Missing { allowed: format!("one of {}", known.join(", ")) });
        }
        (self.names.len() == 1).then_some(0)
    }

    /// The same where the name may be left out, if there is only one.
    fn find_or_only(&self, section: &Section<'_>, key: &'static Key) -> Option<usize> {
        if section.has(key) {
            return self.find(section, key);
        }
        // Counts as read, for the message about keys that are not.
        section.name(key);
        if let [_] = &self.names[..] {
            return Some(0);
        }
        section.fault(key, Problem::Missing { allowed: key.kind.allowed() });
        None
    }
}

/// Where the tracks of platforms come from, whatever else is wrong with them.
#[derive(Clone, Copy)]
struct Sources {
    live: bool,
    recorded: bool,
}

impl Sources {
    fn of(platforms: &[Section<'_>]) -> Self {
        use keys::platform::{REPORTED, TRACK};
        let kinds = |part| platforms.iter().filter_map(move |of| of.peek_choice_in(part, &keys::track::KIND));
        let recorded = |kind| matches!(kind, TrackKind::Recorded(_));
        Self {
            live: kinds(&TRACK).any(|kind| kind == TrackKind::Live),
            recorded: kinds(&TRACK).chain(kinds(&REPORTED)).any(recorded),
        }
    }

    /// Faults a start that does not go with the tracks.
    fn check_start(self, section: &Section<'_>, time: &SceneTime, has_ais: bool) {
        let fault = |problem| section.fault(&keys::scene::START_UTC, problem);
        match self {
            Self { recorded: true, .. } if !time.start_written => fault(Problem::NeedsStart),
            Self { live: true, .. } if !time.start_written => fault(Problem::LiveNeedsStart),
            _ => {}
        }
        let Some(word) = time.word else { return };
        let known = match self {
            Self { recorded: true, .. } => {
                Some(("beside a recorded track", "a UTC time within the recording"))
            }
            _ if has_ais => Some(("beside a recorded log", "a UTC time within the log")),
            Self { live: true, .. } if word == Begin::Now => {
                Some(("with live navigation", "\"live\", or a UTC time"))
            }
            Self { live: false, .. } if word == Begin::Live => {
                Some(("without live navigation", "\"now\", or a UTC time"))
            }
            _ => None,
        };
        if let Some((place, allowed)) = known {
            let found = match word {
                Begin::Now => "\"now\"",
                Begin::Live => "\"live\"",
            };
            fault(Problem::Live { found, place, allowed });
        }
    }
}

/// Host and port where a sink sends; the default depends on its kind.
fn address_or(section: &Section<'_>, absent: &str) -> Option<String> {
    let asked = section.address(&keys::sink::ADDRESS);
    if section.has(&keys::sink::ADDRESS) { asked } else { Some(absent.to_owned()) }
}

/// Reads a whole scenario.
pub(super) fn resolve(root: Section<'_>) -> Option<Parts> {
    let scene = root.section(&keys::root::SCENE);
    let (ground, time) =
        scene.as_ref().map_or((no_ground(), SceneTime::MISSING), |s| (ground(s), scene_time(s)));
    let platform_sections = root.sections(&keys::root::PLATFORM);
    let sources = Sources::of(&platform_sections);
    let mut platforms = Names::new("platform");
    let nav: Vec<Option<PlatformNav>> = platform_sections
        .into_iter()
        .map(|section| {
            platforms.take(&section, &keys::platform::NAME, &[]);
            platform::platform(section, &ground)
        })
        .collect();
    let patch = scene.as_ref().map(|section| {
        sources.check_start(section, &time, root.has(&keys::root::AIS));
        let longest_m = |azimuth_m| patch::longest_facet_m(&root, azimuth_m);
        patch::given(section, longest_m, root.has(&keys::root::SEA), &ground, &platforms)
    });
    let azimuth_m = patch.as_ref().and_then(|patch| patch.azimuth_m);
    let mut clocks = clock::Given::default();
    let mut calibration = Some(Vec::new());
    let radar = radar::radar(&root, &ground, &platforms, &mut clocks, &mut calibration);
    let (patch, place) = match (patch, scene) {
        (Some(patch), Some(section)) => {
            let placed = patch.place(&section, radar.as_ref());
            section.finish();
            placed
        }
        _ => (None, None),
    };
    let sea = sea::sea(
        &root,
        patch,
        place,
        azimuth_m,
        root.peek_in(&keys::root::RADAR, &keys::radar::CARRIER_HZ),
        radar.as_ref().map(|radar| 1.0 / radar.sends().mean_prf_hz()),
        radar.as_ref().is_some_and(|radar| radar.sent.is_some()),
    );
    let start = time.start.filter(|_| time.start_written);
    // A word stands for an instant that is not known.
    let known = start.filter(|_| time.word.is_none());
    let run = way::Run { start: known, duration_s: time.duration_s };
    let ships = ship::ships(&root, &ground, start, run);
    let targets = target::targets(&root, &ground, run);
    plausible::targets(&root, &ground, targets.as_deref(), time.duration_s);
    let fidelity = stream::fidelity(&root);
    let stream = stream::stream(
        &root,
        radar.as_ref(),
        (platforms.names.len(), targets.as_ref().map_or(0, Vec::len)),
        sources.live,
        fidelity.as_ref(),
    );
    let target_count = targets.as_ref().map_or(0, Vec::len);
    let known = calibration.as_ref().map_or(0, Vec::len);
    let sinks = stream::sinks(&root, radar.as_ref(), &ground, &platforms, target_count, known);
    let events = event::events(&root, &platforms, radar.as_ref(), time.duration_s);
    root.finish();

    let radar = radar?;
    let scene = Scene {
        frame: ground.frame,
        start: time.start?,
        pulses: radar.emissions.count_within(time.duration_s?),
        seed: time.seed?,
        platforms: platforms.names.into_iter().collect::<Option<_>>()?,
        radar,
        sea: sea?,
        ships: ships?,
        targets: targets?,
    };
    let (stream, relax_db, monitor) = stream?;
    Some(Parts {
        scene,
        start_live: time.word == Some(Begin::Live),
        start_now: time.word == Some(Begin::Now),
        nav: nav.into_iter().collect::<Option<_>>()?,
        clocks: clocks.clocks()?,
        calibration: calibration?,
        events: events?,
        fidelity: fidelity?,
        stream,
        relax_db,
        monitor,
        sinks: sinks?,
    })
}

struct SceneTime {
    start: Option<TimeTag>,
    start_written: bool,
    /// What stands in place of an instant; `start` only stands for it.
    word: Option<Begin>,
    duration_s: Option<f64>,
    seed: Option<u64>,
}

impl SceneTime {
    /// Of a scenario without `[scene]`.
    const MISSING: Self = Self { start: None, start_written: true, word: None, duration_s: None, seed: None };
}

fn scene_time(section: &Section<'_>) -> SceneTime {
    use keys::scene::{DURATION_S, SEED, START_UTC};
    let start_written = section.has(&START_UTC);
    // 2000-01-01T00:00:00Z.
    let midnight_2000 = TimeTag::new(946_684_800, 0.0);
    let given = section.time_or(&START_UTC);
    SceneTime {
        start: if start_written {
            given.map(|time| time.unwrap_or(midnight_2000))
        } else {
            Some(midnight_2000)
        },
        start_written,
        word: given.and_then(Result::err),
        duration_s: section.number(&DURATION_S),
        seed: section.count(&SEED),
    }
}

fn no_ground() -> Ground {
    Ground { frame: SceneFrame::plain(Earth::Flat), origin_h_m: None, sound: false }
}

fn ground(section: &Section<'_>) -> Ground {
    use keys::scene::{EARTH, EARTH_RADIUS_FACTOR, HORIZON, ORIGIN_H_M, ORIGIN_LAT_DEG, ORIGIN_LON_DEG};
    let trio = [&ORIGIN_LAT_DEG, &ORIGIN_LON_DEG, &ORIGIN_H_M];
    let written = trio.iter().filter(|key| section.has(key)).count();
    let [lat_deg, lon_deg, h_m] = trio.map(|key| section.number(key));
    if let Some(first) = trio.iter().find(|key| section.has(key)).filter(|_| written < trio.len()) {
        section.fault(first, Problem::Alone { keys: crate::config::hint::names(&trio) });
    }
    let curved = section.choice(&EARTH).map_or(written == trio.len(), |Curved(curved)| curved);
    let mut factor = Some(1.0);
    if curved {
        factor = section.number(&EARTH_RADIUS_FACTOR);
    } else if section.has(&EARTH_RADIUS_FACTOR) {
        section.number(&EARTH_RADIUS_FACTOR);
        section.fault(&EARTH_RADIUS_FACTOR, Problem::Idle { when: "the earth is flat".to_owned() });
    }
    let horizon = section.flag_or(&HORIZON, true);
    if !curved && section.has(&HORIZON) {
        section.fault(&HORIZON, Problem::Idle { when: "the earth is flat".to_owned() });
    }
    let (Some(radius_factor), Some(horizon)) = (factor, horizon) else { return no_ground() };
    let earth = if curved { Earth::Curved { radius_factor } } else { Earth::Flat };
    match (written, lat_deg, lon_deg, h_m) {
        (0, ..) => {
            Ground { frame: SceneFrame::plain(earth).with_horizon(horizon), origin_h_m: None, sound: true }
        }
        (3, Some(lat_deg), Some(lon_deg), Some(h_m)) => Ground {
            frame: SceneFrame::at(Geodetic::from_deg(lat_deg, lon_deg, h_m), earth).with_horizon(horizon),
            origin_h_m: Some(h_m),
            sound: true,
        },
        _ => no_ground(),
    }
}
