//! What makes a scenario run in real time: changes of it, what each costs, and how fast the run is predicted
//! to be with it. Nothing is built or measured here ([`fit_trials`](super::fit_trials) does that).
//!
//! ```text
//! factor(change) = factor(as written) x C(as written) / C(change) x threads(change) / threads
//! ```
//!
//! with real-time factors, the first one measured on this machine, and `C` the seconds of a pulse by the
//! [cost model](crate::fidelity::cost). A change is one [`Step`] or two of different [`Kind`]s; of all that
//! are predicted to reach what is wanted, the one with the least harm is taken. Harm is a rank, not a
//! physical quantity:
//!
//! | step | harm | because |
//! | --- | --- | --- |
//! | more threads | 0 | the same pulses, to the bit |
//! | `fidelity.error_db` | 1 for 5 dB, 2 above [`VISIBLE_DB`] | the same sea, less exactly by a known amount |
//! | `sea.shadow.update_ms` | 2 for each doubling | the same sea, whose shadows come later |
//! | `scene.facet_m` | 2 + 10 (g - 1), facets g times as long | another draw, of fewer waves |
//! | `scene.patch_size_m` | 3 + 10 (g - 1), sides g times as short | another draw, of less sea |
//! | a warning that the scenario did not have | [`HARM_OF_WARNING`] | it may no longer be what was meant |

use serde::Serialize;

use super::settings::ERROR_KEY;
use super::sweep::{Overrides, Refused};
use crate::fidelity::budget::Plan;
use crate::fidelity::cost::{CostTable, Work};
use crate::scene::Patch;
use crate::units::{common_divisor, digits, is_product_of};

/// Times real time that are wanted unless asked otherwise: sinks, the pacer and other programs take some.
pub const MARGIN: f64 = 1.15;
/// The coarsest error of the ladder, dB, and from error to error of it.
pub const COARSEST_DB: f64 = -20.0;
const STEP_DB: f64 = 5.0;
/// Errors above this are seen in an image of the sea, dB.
pub const VISIBLE_DB: f64 = -40.0;
/// The longest interval of shadows that is proposed, ms: waves of 10 m move by a fifth of their length.
const LONGEST_UPDATE_MS: f64 = 500.0;
/// Sides that are tried, in facets over those written.
const SHARES: [f64; 8] = [0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.25];
/// Sides of whole tiles stay so.
const TILE: usize = 16;
/// Harm of a warning that the scenario did not have.
pub const HARM_OF_WARNING: f64 = 10.0;

/// What is changed; least harm first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Threads that make pulses.
    Threads,
    /// The error that is allowed.
    Error,
    /// From update to update of the shadows.
    Shadows,
    /// The side of a facet.
    Facets,
    /// The sides of the patch.
    Patch,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Threads, Self::Error, Self::Shadows, Self::Facets, Self::Patch];

    /// Each by itself, then two at a time; either of the last two makes fewer facets, as few as make sense.
    pub fn sets() -> Vec<Vec<Self>> {
        let rivals = [Self::Facets, Self::Patch];
        let two = |(n, a): (usize, Self)| {
            let others =
                Self::ALL[n + 1..].iter().filter(move |b| !(rivals.contains(&a) && rivals.contains(b)));
            others.map(move |b| vec![a, *b])
        };
        let single = Self::ALL.iter().map(|kind| vec![*kind]);
        single.chain(Self::ALL.into_iter().enumerate().flat_map(two)).collect()
    }
}

/// What a step changes of the work of a pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// Threads over those of the run.
    Threads(f64),
    /// The error, dB, of a plan of its own.
    Error(f64),
    /// Facets over those of the run, on the same patch.
    Facets(f64),
    /// Facets and area over those of the run.
    Patch(f64),
    /// The interval of shadows over that of the run.
    Update(f64),
}

/// A change of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Its kind.
    pub kind: Kind,
    /// The key and its value, as TOML.
    pub set: (String, String),
    /// How the run then is, in a few words.
    pub short: String,
    /// What it costs, in words.
    pub costs: String,
    /// How much that is.
    pub harm: f64,
    /// What it changes of the work.
    pub load: Load,
}

impl Step {
    fn new(
        kind: Kind,
        (key, value): (&str, String),
        [short, costs]: [String; 2],
        harm: f64,
        load: Load,
    ) -> Self {
        Self { kind, set: (key.to_owned(), value), short, costs, harm, load }
    }
}

/// Errors coarser than one, in steps of 5 dB.
pub fn coarser(error_db: f64) -> impl Iterator<Item = f64> {
    let first = (error_db / STEP_DB).floor() + 1.0;
    let last = COARSEST_DB / STEP_DB;
    (0..).map(move |n| first + f64::from(n)).take_while(move |n| *n <= last).map(|n| n * STEP_DB)
}

/// Errors finer than one, in steps of 5 dB.
pub fn finer(error_db: f64) -> impl Iterator<Item = f64> {
    let first = (error_db / STEP_DB).ceil() - 1.0;
    (0..).map(move |n| (first - f64::from(n)) * STEP_DB)
}

/// A step to another error.
pub fn error_step(from_db: f64, to_db: f64) -> Step {
    let visible = (to_db - VISIBLE_DB.max(from_db)).max(0.0);
    let says = [format!("at {to_db} dB"), format!("error {to_db} dB instead of {from_db}")];
    let harm = (to_db - from_db + visible) / STEP_DB;
    Step::new(Kind::Error, (ERROR_KEY, format!("{to_db}")), says, harm, Load::Error(to_db))
}

/// Steps to more threads, as many as the machine has.
pub fn thread_steps(threads: usize, most: usize) -> impl Iterator<Item = Step> {
    (threads + 1..=most).map(move |more| {
        let costs = format!("{more} threads instead of {threads}: the same pulses, to the bit");
        let says = [format!("with {more} threads"), costs];
        let load = Load::Threads(more as f64 / threads.max(1) as f64);
        Step::new(Kind::Threads, ("stream.threads", more.to_string()), says, 0.0, load)
    })
}

/// Steps to longer intervals of shadows that are found so often, s.
pub fn shadow_steps(update_s: f64) -> impl Iterator<Item = Step> {
    let update_ms = 1e3 * update_s;
    let longer = [1.0, 2.0, 3.0].into_iter().map(move |doublings: f64| (doublings, doublings.exp2()));
    longer.filter(move |(_, times)| update_ms * times <= LONGEST_UPDATE_MS).map(move |(doublings, times)| {
        let ms = (update_ms * times).round();
        let short = format!("with shadows every {ms} ms");
        let says = [short, format!("shadows every {ms} ms instead of {}", digits(update_ms))];
        let load = Load::Update(ms / update_ms);
        Step::new(Kind::Shadows, ("sea.shadow.update_ms", ms.to_string()), says, 2.0 * doublings, load)
    })
}

/// Steps to fewer facets, over the same patch and over a smaller one.
pub fn patch_steps(patch: &Patch) -> impl Iterator<Item = Step> {
    let Patch { facets: [nx, ny], facet_m, .. } = *patch;
    let size_m = patch.size_m();
    let mut sides: Vec<[usize; 2]> = SHARES.iter().filter_map(|share| fewer([nx, ny], *share)).collect();
    sides.dedup();
    let of = move |[x, y]: [usize; 2]| {
        let (times, share) = (nx as f64 / x as f64, (x * y) as f64 / (nx * ny) as f64);
        let [width_m, height_m] = [x, y].map(|n| whole(n as f64 * facet_m));
        let short = format!("on a patch of {width_m} x {height_m} m");
        let [x_m, y_m] = size_m.map(whole);
        let says = [short, format!("a patch of {width_m} x {height_m} m instead of {x_m} x {y_m}")];
        let set = ("scene.patch_size_m", format!("[{width_m},{height_m}]"));
        let smaller = Step::new(Kind::Patch, set, says, 3.0 + 10.0 * (times - 1.0), Load::Patch(share));
        let longer = side_m(size_m, [x, y]).map(|longer_m| {
            let costs = format!(
                "{x} x {y} facets of {} m instead of {nx} x {ny} of {facet_m}: waves shorter than {} m are lost",
                three_digits(longer_m),
                digits(2.0 * longer_m)
            );
            let set = ("scene.facet_m", longer_m.to_string());
            let says = [format!("with {x} x {y} facets"), costs];
            Step::new(Kind::Facets, set, says, 2.0 + 10.0 * (times - 1.0), Load::Facets(share))
        });
        longer.into_iter().chain([smaller])
    };
    sides.into_iter().flat_map(of)
}

fn three_digits(length_m: f64) -> f64 {
    format!("{length_m:.2e}").parse().unwrap_or(length_m)
}

/// A length without what decimal facets leave in binary.
fn whole(length_m: f64) -> f64 {
    (length_m * 1e6).round() / 1e6
}

/// Facets along both sides, about so many times those given, in the same ratio: numbers that transforms like,
/// whole tiles where those given are.
fn fewer(facets: [usize; 2], share: f64) -> Option<[usize; 2]> {
    let [nx, ny] = facets;
    let unit = common_divisor(nx, ny);
    let tiles = facets.iter().all(|n| n.is_multiple_of(TILE) && *n > 4 * TILE);
    let is_fit = |n: &usize| is_product_of(&[2, 3, 5, 7], *n) && (!tiles || n.is_multiple_of(TILE));
    let most = (unit as f64 * share) as usize;
    let least = (unit as f64 * SHARES[SHARES.len() - 1]).ceil() as usize;
    (least.max(1)..=most).rev().map(|m| facets.map(|n| n / unit * m)).find(|sides| sides.iter().all(is_fit))
}

/// The side of so many facets over a patch, m, in as few digits as make them whole.
fn side_m(size_m: [f64; 2], facets: [usize; 2]) -> Option<f64> {
    let exact_m = size_m[0] / facets[0] as f64;
    let rounded = |decimals: usize| format!("{exact_m:.decimals$e}").parse().ok();
    let is_whole =
        |facet_m: &f64| Patch::new(size_m, *facet_m, [0.0; 2]).is_ok_and(|patch| patch.facets == facets);
    (1..17).filter_map(rounded).find(is_whole)
}

/// What the speed of changes is predicted by.
#[derive(Clone, Debug)]
pub struct Model {
    /// Times real time as written, measured.
    pub factor: f64,
    /// Its plan.
    pub plan: Plan,
    /// Plans for coarser errors, dB.
    pub plans: Vec<(f64, Plan)>,
}

impl Model {
    /// What a pulse asks for with some steps.
    pub fn work(&self, steps: &[&Step]) -> Work {
        let (mut plan, mut facets, mut area, mut update) = (&self.plan, 1.0, 1.0, 1.0);
        for step in steps {
            match step.load {
                Load::Threads(_) => {}
                Load::Facets(times) => facets *= times,
                Load::Patch(times) => (facets, area) = (facets * times, area * times),
                Load::Update(times) => update *= times,
                Load::Error(db) => {
                    plan = self.plans.iter().find(|(of, _)| *of == db).map_or(plan, |(_, plan)| plan);
                }
            }
        }
        plan.work_with([facets, area, update])
    }

    /// Times real time with some steps.
    pub fn factor(&self, steps: &[&Step]) -> f64 {
        let threads = steps.iter().map(|step| if let Load::Threads(times) = step.load { times } else { 1.0 });
        let [written_s, changed_s] =
            [self.plan.work, self.work(steps)].map(|work| CostTable::TABLE.seconds(&work));
        self.factor * threads.product::<f64>() * written_s / changed_s
    }
}

/// The steps with the least harm, one of each kind, that reach what is wanted by a speed; of equal harm the
/// fastest.
pub fn least<'a>(
    kinds: &[Kind],
    steps: &'a [Step],
    wanted: f64,
    factor: impl Fn(&[&Step]) -> f64,
) -> Option<Vec<&'a Step>> {
    let all = combinations(kinds, steps).into_iter().map(|steps| (factor(&steps), steps));
    let fit = all.filter(|(factor, _)| *factor >= wanted);
    let order = |(a, one): &(f64, Vec<&Step>), (b, other): &(f64, Vec<&Step>)| {
        harm(one).total_cmp(&harm(other)).then(b.total_cmp(a))
    };
    fit.min_by(order).map(|(_, steps)| steps)
}

/// The fastest steps of some sets of kinds, one of each kind of a set.
pub fn fastest<'a>(
    sets: &[Vec<Kind>],
    steps: &'a [Step],
    factor: impl Fn(&[&Step]) -> f64,
) -> Option<Vec<&'a Step>> {
    let all = sets.iter().flat_map(|kinds| combinations(kinds, steps));
    all.max_by(|a, b| factor(a).total_cmp(&factor(b)))
}

/// One step of each kind, in every combination.
fn combinations<'a>(kinds: &[Kind], steps: &'a [Step]) -> Vec<Vec<&'a Step>> {
    kinds.iter().fold(vec![Vec::new()], |before: Vec<Vec<&Step>>, kind| {
        let of_kind = || steps.iter().filter(|step| step.kind == *kind);
        before.iter().flat_map(|some| of_kind().map(|step| [&some[..], &[step]].concat())).collect()
    })
}

/// Harm of steps together.
pub fn harm(steps: &[&Step]) -> f64 {
    steps.iter().map(|step| step.harm).sum()
}

/// A change that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Remedy {
    /// What is changed, `key=value`.
    pub set: Vec<String>,
    /// What that costs, in words, one for each.
    pub costs: Vec<String>,
    /// Warnings that the scenario did not have.
    pub warnings: Vec<String>,
    /// Times real time, as predicted.
    pub predicted_factor: f64,
    /// The same as measured; none where only predictions are asked.
    pub real_time_factor: Option<f64>,
    /// Predicted error against the reference, dB.
    pub predicted_rel_rms_db: Option<f64>,
    /// How much is lost, a rank.
    pub harm: f64,
}

impl Remedy {
    /// Times real time, measured or predicted.
    pub fn factor(&self) -> f64 {
        self.real_time_factor.unwrap_or(self.predicted_factor)
    }
}

/// Everything that is found of a scenario.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Fit {
    /// Times real time as written, measured.
    pub real_time_factor: f64,
    /// What is wanted.
    pub margin: f64,
    /// Whether that is enough.
    pub fits: bool,
    /// Threads that make pulses.
    pub threads: usize,
    /// The error that is asked, dB; none of the reference.
    pub error_db: Option<f64>,
    /// Of one that fits: the finest error with which it is predicted to fit as well, dB.
    pub fits_at_db: Option<f64>,
    /// Changes that make it fit, least harm first.
    pub remedies: Vec<Remedy>,
    /// Where there are none: the change that comes nearest.
    pub nearest: Option<Remedy>,
    /// Where there are none: what takes most of a pulse of the fastest change.
    pub limit: Option<Limit>,
    /// Whether not all was tried.
    pub out_of_time: bool,
    /// Changes that the scenario does not allow.
    pub refused: Vec<Refused>,
}

/// What takes most of a pulse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limit {
    /// The stage.
    pub stage: &'static str,
    /// Its share, by the cost model.
    pub share: f64,
}

impl Fit {
    /// Least harm first; of equal harm the fastest. Where something is enough, no nearest miss.
    pub fn sort(&mut self) {
        let order =
            |a: &Remedy, b: &Remedy| a.harm.total_cmp(&b.harm).then(b.factor().total_cmp(&a.factor()));
        self.remedies.sort_by(order);
        if !self.remedies.is_empty() {
            self.nearest = None;
        }
    }

    /// Keeps what comes nearest, if it helps at all.
    pub fn missed(&mut self, remedy: Remedy) {
        if remedy.factor() > self.real_time_factor
            && self.nearest.as_ref().is_none_or(|nearest| nearest.factor() < remedy.factor())
        {
            self.nearest = Some(remedy);
        }
    }
}

/// Overrides of some steps.
pub fn overrides(steps: &[&Step]) -> Overrides {
    steps.iter().map(|step| step.set.clone()).collect()
}

/// Warnings that are of no kind that was there before: texts that differ in more than figures.
pub fn new_warnings(found: &[String], before: &[String]) -> Vec<String> {
    let words = |text: &String| -> Vec<String> {
        let has_no_figure = |word: &&str| !word.contains(|c: char| c.is_ascii_digit());
        text.split_whitespace().filter(has_no_figure).map(str::to_owned).collect()
    };
    let known: Vec<_> = before.iter().map(words).collect();
    found.iter().filter(|text| !known.contains(&words(text))).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE_M: [f64; 2] = [512.0, 512.0];

    /// All steps of a run at -60 dB with 2 of 3 threads.
    fn steps() -> Vec<Step> {
        let patch = Patch::new(SIDE_M, 1.0, [0.0; 2]).unwrap();
        let errors = coarser(-60.0).map(|db| error_step(-60.0, db));
        thread_steps(2, 3).chain(errors).chain(shadow_steps(0.045)).chain(patch_steps(&patch)).collect()
    }

    /// A run at half of real time, whose pulses take facets and a constant, less by 1 dB in 20 of error.
    fn speed(steps: &[&Step]) -> f64 {
        let (mut seconds, mut threads) = (0.9, 1.0);
        for step in steps {
            match step.load {
                Load::Threads(times) => threads = times,
                Load::Facets(share) | Load::Patch(share) => seconds *= share,
                Load::Update(times) => seconds -= 0.05 * (1.0 - 1.0 / times),
                Load::Error(db) => seconds *= 1.0 - (db + 60.0) / 80.0,
            }
        }
        0.5 * threads / (seconds + 0.1)
    }

    #[test]
    fn errors_lie_on_a_ladder() {
        assert_eq!(coarser(-60.0).collect::<Vec<_>>(), [-55., -50., -45., -40., -35., -30., -25., -20.]);
        assert_eq!(coarser(-31.5).collect::<Vec<_>>(), [-30., -25., -20.]);
        assert_eq!(coarser(-20.0).count(), 0);
        assert_eq!(finer(-58.0).take(3).collect::<Vec<_>>(), [-60., -65., -70.]);
        assert_eq!(finer(-60.0).next(), Some(-65.0));
        let harm = |from, to| error_step(from, to).harm;
        assert_eq!([harm(-60.0, -55.0), harm(-60.0, -40.0), harm(-60.0, -35.0)], [1.0, 4.0, 6.0]);
        assert_eq!(harm(-30.0, -20.0), 4.0);
    }

    /// Facets are whole, of numbers that transforms like, in the ratio of the sides; a patch has whole ones.
    #[test]
    fn patches_stay_legal() {
        let of = |size_m: [f64; 2], facet_m: f64| {
            let patch = Patch::new(size_m, facet_m, [0.0; 2]).unwrap();
            patch_steps(&patch).map(|step| step.set).collect::<Vec<_>>()
        };
        let set = |key: &str, value: &str| (key.to_owned(), value.to_owned());
        let square = of(SIDE_M, 1.0);
        assert_eq!(square[0], set("scene.facet_m", "1.142857143"));
        assert_eq!(square[1], set("scene.patch_size_m", "[448,448]"));
        assert_eq!(square[2], set("scene.facet_m", "1.28"));
        assert_eq!(square[square.len() - 1], set("scene.patch_size_m", "[128,128]"));
        for (size_m, facet_m) in [
            (SIDE_M, 1.0),
            ([600.0, 450.0], 1.5),
            ([0.3, 0.6], 0.1),
            ([30.4, 60.8], 0.4),
            ([511.0, 512.0], 1.0),
        ] {
            let sets = of(size_m, facet_m);
            assert_eq!(sets.is_empty(), size_m == [511.0, 512.0], "{sets:?}");
            for (key, value) in sets {
                let numbers = value.trim_matches(['[', ']']).split(',').map(|n| n.parse::<f64>().unwrap());
                let numbers: Vec<f64> = numbers.collect();
                let patch = match key.as_str() {
                    "scene.facet_m" => Patch::new(size_m, numbers[0], [0.0; 2]),
                    _ => Patch::new([numbers[0], numbers[1]], facet_m, [0.0; 2]),
                };
                let [nx, ny] = patch.unwrap().facets;
                let is_smooth = |n| is_product_of(&[2, 3, 5, 7], n);
                assert!(is_smooth(nx) && is_smooth(ny), "{nx} {ny}");
                assert!((nx as f64 / ny as f64 - size_m[0] / size_m[1]).abs() < 1e-9, "{nx} {ny}");
            }
        }
    }

    #[test]
    fn shadows_come_later_up_to_half_a_second() {
        let sets = |update_s: f64| shadow_steps(update_s).map(|step| step.set.1).collect::<Vec<_>>();
        assert_eq!(sets(0.045), ["90", "180", "360"]);
        assert_eq!(sets(0.2), ["400"]);
        assert!(sets(0.3).is_empty());
    }

    #[test]
    fn the_least_harm_that_is_enough_is_taken() {
        let steps = steps();
        let set = |kinds: &[Kind], wanted: f64| {
            let steps = least(kinds, &steps, wanted, speed)?;
            Some(steps.iter().map(|step| step.set.1.clone()).collect::<Vec<_>>().join(" "))
        };
        assert_eq!(set(&[Kind::Threads], 0.7).as_deref(), Some("3"));
        assert_eq!(set(&[Kind::Threads], 0.8), None);
        assert_eq!(set(&[Kind::Error], 0.6).as_deref(), Some("-45"));
        assert_eq!(set(&[Kind::Facets], 0.6).as_deref(), Some("1.142857143"));
        assert_eq!(set(&[Kind::Shadows], 0.6), None);
        // Of two kinds each gives a little.
        assert_eq!(set(&[Kind::Threads, Kind::Error], 0.8).as_deref(), Some("3 -50"));
        assert_eq!(set(&[Kind::Error, Kind::Facets], 1.15).as_deref(), Some("-45 1.52380952"));
        let all = fastest(&Kind::sets(), &steps, speed).unwrap();
        assert_eq!(all.iter().map(|step| step.kind).collect::<Vec<_>>(), [Kind::Threads, Kind::Patch]);
    }

    #[test]
    fn kinds_are_tried_alone_and_in_pairs() {
        let sets = Kind::sets();
        let alone = sets.iter().filter(|kinds| kinds.len() == 1).count();
        let mut once = sets.clone();
        once.sort();
        once.dedup();
        assert_eq!((alone, sets.len(), once.len()), (5, 14, 14));
    }

    #[test]
    fn remedies_stand_by_harm_then_by_speed() {
        let of = |harm: f64, real_time_factor: Option<f64>| Remedy {
            set: Vec::new(),
            costs: Vec::new(),
            warnings: Vec::new(),
            predicted_factor: 1.5,
            real_time_factor,
            predicted_rel_rms_db: None,
            harm,
        };
        let remedies = vec![of(3.0, None), of(0.0, Some(1.2)), of(3.0, Some(1.6)), of(1.0, Some(1.2))];
        let mut found = Fit { remedies, ..Fit::default() };
        found.missed(of(1.0, Some(0.5)));
        found.sort();
        assert!(found.nearest.is_none());
        let order: Vec<(f64, f64)> = found.remedies.iter().map(|r| (r.harm, r.factor())).collect();
        assert_eq!(order, [(0.0, 1.2), (1.0, 1.2), (3.0, 1.6), (3.0, 1.5)]);
        for factor in [0.8, 0.9, 0.7] {
            found.missed(of(1.0, Some(factor)));
        }
        assert_eq!(found.nearest.unwrap().factor(), 0.9);
    }

    #[test]
    fn a_warning_is_new_if_its_words_are() {
        let before = ["3.5 facets in a cell of 3.53 m".to_owned()];
        let found = ["2.1 facets in a cell of 3.53 m".to_owned(), "facets of 4 m are longer".to_owned()];
        assert_eq!(new_warnings(&found, &before), found[1..]);
    }
}
