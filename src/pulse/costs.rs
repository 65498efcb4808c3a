//! What making pulses costs: time by stage, and how many facets and scatterer paths were dealt with.
//!
//! A stopwatch that always runs and is read between stages: [`Costs::begin`] starts it, [`Costs::lap`] gives
//! the time since the last reading to a stage. So no time is counted twice and the stages add up to the
//! whole, also where stages take turns within a pulse (tile by tile). Each worker has its own; [`Costs::add`]
//! sums them. Nothing allocates. A reading takes some 30 ns: read once per tile, not once per facet.
//!
//! Seconds are those of one worker: with two workers at once, a run of 1 s has 2 s of them.
//!
//! ```
//! use nereus::pulse::costs::{Costs, Stage};
//! let mut costs = Costs::default();
//! costs.begin();
//! // ... heights and slopes of 100 facets ...
//! costs.lap(Stage::Surface);
//! // ... scatterer paths; 60 are illuminated, 10 of them too weak to matter ...
//! costs.lap(Stage::ScattererPaths);
//! costs.looked_at(100, 60, 10);
//! costs.accumulated(50);
//! costs.made();
//! assert_eq!((costs.counts().pulses, costs.illuminated_share()), (1, 0.6));
//! assert_eq!(costs.seconds_per_pulse(Stage::Surface), costs.seconds(Stage::Surface));
//! ```

use std::time::{Duration, Instant};

/// What a worker does for a pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Tracks, window, navigation and truth of the pulse.
    Record,
    /// Heights, slopes and velocities of the facets.
    Surface,
    /// Which facet sees which antenna.
    Shadow,
    /// Delays, gains and scattering of facets, targets and direct paths.
    ScattererPaths,
    /// From scatterer paths at nodes to what is accumulated.
    Fill,
    /// Accumulation on the grids; for the reference, the sum over scatterer paths.
    Spread,
    /// From grids to spectra.
    Transform,
    /// Echoes of emitters beside the radar's own.
    Others,
    /// Noise, samples, converter.
    Receive,
}

impl Stage {
    /// All of them, in the order of the work.
    pub const ALL: [Self; 9] = [
        Self::Record,
        Self::Surface,
        Self::Shadow,
        Self::ScattererPaths,
        Self::Fill,
        Self::Spread,
        Self::Transform,
        Self::Others,
        Self::Receive,
    ];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Record => "record",
            Self::Surface => "surface",
            Self::Shadow => "shadow",
            Self::ScattererPaths => "paths",
            Self::Fill => "fill",
            Self::Spread => "spread",
            Self::Transform => "transform",
            Self::Others => "others",
            Self::Receive => "receive",
        }
    }
}

/// What was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Pulses made.
    pub pulses: u64,
    /// Facets for which it was found whether they are illuminated, counted again at every instant.
    pub facets: u64,
    /// Those of them that an antenna pair illuminates and receives, and that return something.
    pub illuminated: u64,
    /// Those of the illuminated ones that were left out because they are too weak to matter.
    pub culled: u64,
    /// Facets of sidelobe tiles, which are evaluated less often.
    pub sidelobe: u64,
    /// Facets of tiles beyond the beams, which are left out.
    pub beyond: u64,
    /// Scatterer paths accumulated, counted again in every pulse and for every pair of antennas.
    pub accumulated: u64,
}

/// Time and counts of one worker, or of several together.
#[derive(Clone, Copy, Debug, Default)]
pub struct Costs {
    spent: [Duration; Stage::ALL.len()],
    counts: Counts,
    read: Option<Instant>,
}

impl Costs {
    /// Starts the stopwatch; what was before belongs to no stage.
    pub fn begin(&mut self) {
        self.read = Some(Instant::now());
    }

    /// Gives the time since the last reading to a stage. The first reading of a stopwatch that nobody started
    /// only starts it.
    pub fn lap(&mut self, stage: Stage) {
        let now = Instant::now();
        if let Some(read) = self.read {
            self.spent[stage as usize] += now.saturating_duration_since(read);
        }
        self.read = Some(now);
    }

    /// Counts facets for which it was found whether they are illuminated: how many, how many of them are, how
    /// many of the illuminated ones were left out.
    pub fn looked_at(&mut self, facets: usize, illuminated: usize, culled: usize) {
        self.counts.facets += facets as u64;
        self.counts.illuminated += illuminated as u64;
        self.counts.culled += culled as u64;
    }

    /// Counts facets of sidelobe tiles, and of tiles beyond the beams.
    pub fn looked_at_less(&mut self, sidelobe: usize, beyond: usize) {
        self.counts.sidelobe += sidelobe as u64;
        self.counts.beyond += beyond as u64;
    }

    /// Counts scatterer paths that were accumulated in one pulse.
    pub fn accumulated(&mut self, paths: usize) {
        self.counts.accumulated += paths as u64;
    }

    /// Counts a pulse.
    pub fn made(&mut self) {
        self.counts.pulses += 1;
    }

    /// Takes in what another worker has spent and counted.
    pub fn add(&mut self, other: &Self) {
        self.spent.iter_mut().zip(other.spent).for_each(|(to, from)| *to += from);
        let Counts { pulses, facets, illuminated, culled, sidelobe, beyond, accumulated } = other.counts;
        self.counts.pulses += pulses;
        self.counts.facets += facets;
        self.counts.illuminated += illuminated;
        self.counts.culled += culled;
        self.counts.sidelobe += sidelobe;
        self.counts.beyond += beyond;
        self.counts.accumulated += accumulated;
    }

    /// Time of a stage, s.
    pub fn seconds(&self, stage: Stage) -> f64 {
        self.spent[stage as usize].as_secs_f64()
    }

    /// What was counted.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Time of a stage for one pulse, s; 0 before there is a pulse.
    pub fn seconds_per_pulse(&self, stage: Stage) -> f64 {
        if self.counts.pulses == 0 { 0.0 } else { self.seconds(stage) / self.counts.pulses as f64 }
    }

    /// Share of the facets that is illuminated, 0 to 1.
    pub fn illuminated_share(&self) -> f64 {
        share(self.counts.illuminated, self.counts.facets)
    }

    /// Share of the facets that is illuminated and left out, 0 to 1.
    pub fn culled_share(&self) -> f64 {
        share(self.counts.culled, self.counts.facets)
    }

    /// Share of the facets in sidelobe tiles, 0 to 1.
    pub fn sidelobe_share(&self) -> f64 {
        share(self.counts.sidelobe, self.counts.facets)
    }

    /// Share of the facets in tiles beyond the beams, 0 to 1.
    pub fn beyond_share(&self) -> f64 {
        share(self.counts.beyond, self.counts.facets)
    }

    /// Scatterer paths accumulated in a pulse, mean.
    pub fn accumulated_per_pulse(&self) -> f64 {
        share(self.counts.accumulated, self.counts.pulses)
    }
}

/// A ratio, 0 of nothing.
fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total_s(costs: &Costs) -> f64 {
        Stage::ALL.iter().map(|stage| costs.seconds(*stage)).sum()
    }
    use std::thread::sleep;

    #[test]
    fn stages_add_up_to_the_whole() {
        let mut costs = Costs::default();
        let outside = Instant::now();
        costs.begin();
        for stage in Stage::ALL.into_iter().chain(Stage::ALL) {
            sleep(Duration::from_micros(200));
            costs.lap(stage);
        }
        let outside_s = outside.elapsed().as_secs_f64();
        for stage in Stage::ALL {
            // A sleep is never shorter than asked.
            assert!(costs.seconds(stage) >= 400e-6, "{stage:?}");
        }
        assert!(total_s(&costs) <= outside_s);
    }

    #[test]
    fn time_before_the_beginning_belongs_to_nothing() {
        let mut costs = Costs::default();
        sleep(Duration::from_millis(2));
        costs.lap(Stage::Fill);
        assert_eq!(total_s(&costs), 0.0);
        sleep(Duration::from_millis(2));
        costs.begin();
        costs.lap(Stage::Fill);
        assert!(total_s(&costs) < 2e-3);
    }

    #[test]
    fn workers_are_summed() {
        let mut one = Costs::default();
        one.looked_at(10, 6, 1);
        one.looked_at_less(4, 1);
        one.accumulated(5);
        one.made();
        let mut both = one;
        both.add(&one);
        let expected = Counts {
            pulses: 2,
            facets: 20,
            illuminated: 12,
            culled: 2,
            sidelobe: 8,
            beyond: 2,
            accumulated: 10,
        };
        assert_eq!(both.counts(), expected);
        assert_eq!(
            (both.illuminated_share(), both.culled_share(), both.accumulated_per_pulse()),
            (0.6, 0.1, 5.0)
        );
        assert_eq!(Costs::default().illuminated_share(), 0.0);
    }

    #[test]
    fn names_differ() {
        let names: std::collections::BTreeSet<_> = Stage::ALL.iter().map(|stage| stage.name()).collect();
        assert_eq!(names.len(), Stage::ALL.len());
        // Places of the times.
        assert!(Stage::ALL.iter().enumerate().all(|(place, stage)| *stage as usize == place));
    }
}
