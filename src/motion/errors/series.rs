//! An error model drawn: the series of its random parts, and which report is at hand when.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

use super::{AXES, Between, ErrorModel, ErrorsFault, MOST_VALUES};
use crate::rng::{Room, stream};
use crate::time::PulseTimes;

/// Streams beside those of the axes.
const JITTER: u64 = 16;
const DROPOUTS: u64 = 17;
/// The part of a stream that gives the bias; no epoch has this number.
const BIAS: u64 = 1 << 63;
/// Standard deviations beyond which an arrival is cut.
const MOST_SIGMAS: f64 = 8.0;
/// Part of an epoch's length by which a report may be late and still count: rounding of times.
const SLACK: f64 = 1e-6;

/// What a model is drawn for.
#[derive(Clone, Copy, Debug)]
pub struct Circumstances<'a> {
    /// Seed of the scene.
    pub seed: u64,
    /// The platform's place.
    pub platform: usize,
    /// When pulses leave.
    pub times: &'a PulseTimes,
    /// Pulses of the run.
    pub pulses: u64,
    /// How long before pulse 0 reports are asked for (the lag of a servo), s.
    pub before_s: f64,
}

/// When reports are made.
#[derive(Clone, Debug)]
enum Epochs {
    Regular { rate_hz: f64 },
    Pulses { times: PulseTimes, mean_hz: f64 },
}

impl Epochs {
    fn time_s(&self, epoch: i64) -> f64 {
        match self {
            Self::Regular { rate_hz } => epoch as f64 / rate_hz,
            Self::Pulses { times, mean_hz } => match u64::try_from(epoch) {
                Ok(pulse) => times.interval_s(0, pulse),
                Err(_) => epoch as f64 / mean_hz,
            },
        }
    }

    fn mean_hz(&self) -> f64 {
        match self {
            Self::Regular { rate_hz } => *rate_hz,
            Self::Pulses { mean_hz, .. } => *mean_hz,
        }
    }

    fn slack_s(&self) -> f64 {
        SLACK / self.mean_hz()
    }

    /// The last epoch at or before a time.
    fn at_or_before(&self, t_s: f64) -> i64 {
        let t_s = t_s + self.slack_s();
        let guess = (t_s * self.mean_hz()).floor();
        // Saturates, far beyond every run.
        let guess = guess as i64;
        let regular = match self {
            Self::Regular { .. } => true,
            Self::Pulses { times, .. } => times.is_uniform(),
        };
        if regular || guess < 0 {
            return match self.time_s(guess) > t_s {
                true => guess - 1,
                false => guess + i64::from(self.time_s(guess.saturating_add(1)) <= t_s),
            };
        }
        // Intervals in turn: the mean is off by less than a cycle, which is bracketed first.
        let (mut low, mut high, mut width) = (guess, guess.saturating_add(1), 1);
        while self.time_s(low) > t_s && low > -1 {
            (low, width) = ((low - width).max(-1), width * 2);
        }
        width = 1;
        while self.time_s(high) <= t_s {
            (high, width) = (high.saturating_add(width), width * 2);
        }
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if self.time_s(middle) <= t_s {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }
}

/// The report that is at hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatestReport {
    /// Its epoch.
    pub epoch: i64,
    /// Time of the epoch after pulse 0, s; `None`: the instant itself.
    pub time_s: Option<f64>,
    /// What is done until the next one.
    pub between: Between,
    /// Whether a later one was lost.
    pub dropout: bool,
}

/// The errors of one platform's report.
#[derive(Clone, Debug)]
pub struct Errors {
    model: ErrorModel,
    epochs: Epochs,
    /// Epoch of the first value of every series.
    first: i64,
    biases: [f64; AXES],
    series: [Vec<f64>; AXES],
    /// Arrival less latency, s; empty without jitter.
    jitter_s: Vec<f64>,
    /// Epochs back to one that was received; empty without dropouts.
    lost: Vec<u32>,
    /// A report of the very instant, always.
    immediate: bool,
}

impl Errors {
    /// Draws a model for a run.
    ///
    /// # Errors
    /// A model without meaning, and series longer than [`MOST_VALUES`].
    pub fn new(model: &ErrorModel, of: &Circumstances) -> Result<Self, ErrorsFault> {
        model.check()?;
        let epochs = match model.rate_hz {
            Some(rate_hz) => Epochs::Regular { rate_hz },
            None => Epochs::Pulses { times: of.times.clone(), mean_hz: of.times.mean_prf_hz() },
        };
        let key = |axis: u64| of.platform as u64 * 256 + axis;
        let draw = |axis: u64, part: u64| -> f64 {
            StandardNormal.sample(&mut stream(of.seed, Room::ReportErrors, key(axis), part))
        };
        let biases = std::array::from_fn(|axis| match model.axes[axis].bias_sigma {
            0.0 => 0.0,
            sigma => sigma * draw(axis as u64, BIAS),
        });
        let back_s = of.before_s.max(0.0) + model.latency_s + MOST_SIGMAS * model.jitter_s;
        let before = (back_s * epochs.mean_hz()).ceil() + 2.0;
        // A pulse later than the last, for what looks ahead by a light time.
        let run_s = of.times.interval_s(0, of.pulses);
        let after = (run_s * epochs.mean_hz()).ceil() + 2.0;
        let count = before + after;
        let kept = model.axes.iter().filter(|axis| axis.is_random()).count()
            + usize::from(model.jitter_s > 0.0)
            + usize::from(model.dropouts.is_some());
        let values = count * kept as f64;
        if values > MOST_VALUES as f64 {
            return Err(ErrorsFault::TooLong { values: values as u64, epochs: count as u64 });
        }
        let first = -(before as i64);
        let count = if kept > 0 { count as usize } else { 0 };
        let immediate = model.rate_hz.is_none()
            && model.latency_s == 0.0
            && model.jitter_s == 0.0
            && model.dropouts.is_none();
        let mut drawn = Self {
            model: model.clone(),
            epochs,
            first,
            biases,
            series: Default::default(),
            jitter_s: Vec::new(),
            lost: Vec::new(),
            immediate,
        };
        for axis in (0..AXES).filter(|axis| model.axes[*axis].is_random()) {
            drawn.series[axis] = drawn.noise(of.seed, key(axis as u64), axis, count);
        }
        if model.jitter_s > 0.0 {
            let arrival = |place: usize| {
                let number = draw(JITTER, (first + place as i64) as u64);
                model.jitter_s * number.clamp(-MOST_SIGMAS, MOST_SIGMAS)
            };
            drawn.jitter_s = (0..count).map(arrival).collect();
        }
        if model.dropouts.is_some() {
            drawn.lost = drawn.receptions(of.seed, key(DROPOUTS), count);
        }
        Ok(drawn)
    }

    /// Gauss-Markov, walk and white of one axis, from epoch 0 both ways.
    fn noise(&self, seed: u64, key: u64, axis: usize, count: usize) -> Vec<f64> {
        let model = &self.model.axes[axis];
        let zero = (-self.first) as usize;
        let mut values = vec![0.0; count];
        // Always three numbers, so that one process does not change another.
        let numbers = |place: usize| -> [f64; 3] {
            let epoch = self.first + place as i64;
            let mut numbers = stream(seed, Room::ReportErrors, key, epoch as u64);
            std::array::from_fn(|_| StandardNormal.sample(&mut numbers))
        };
        let [g, _, n] = numbers(zero);
        let at_zero = model.gm_sigma * g;
        values[zero] = at_zero + model.white * n;
        let mut run = |places: &mut dyn Iterator<Item = (usize, usize)>| {
            let (mut markov, mut walk) = (at_zero, 0.0);
            for (place, before) in places {
                let [from_s, to_s] = [before, place].map(|p| self.epochs.time_s(self.first + p as i64));
                let dt = (to_s - from_s).abs();
                let [g, w, n] = numbers(place);
                if model.gm_sigma > 0.0 {
                    let fresh = (-(-2.0 * dt / model.gm_tau_s).exp_m1()).sqrt();
                    markov = markov * (-dt / model.gm_tau_s).exp() + model.gm_sigma * fresh * g;
                }
                walk += model.walk * dt.sqrt() * w;
                values[place] = markov + walk + model.white * n;
            }
        };
        run(&mut (zero + 1..count).map(|place| (place, place - 1)));
        run(&mut (0..zero).rev().map(|place| (place, place + 1)));
        values
    }

    /// Epochs back to the last report that was received.
    fn receptions(&self, seed: u64, key: u64, count: usize) -> Vec<u32> {
        let Some(dropouts) = self.model.dropouts else { return Vec::new() };
        let zero = (-self.first) as usize;
        let mut lost = vec![0u32; count];
        for place in zero + 1..count {
            let epoch = self.first + place as i64;
            let dt = self.epochs.time_s(epoch) - self.epochs.time_s(epoch - 1);
            let chance: f64 = stream(seed, Room::ReportErrors, key, epoch as u64).random();
            let down = lost[place - 1] > 0;
            let stays_down = if dropouts.mean_s > 0.0 { (-dt / dropouts.mean_s).exp() } else { 0.0 };
            let falls = -(-dt * dropouts.per_hour / 3600.0).exp_m1();
            if chance < if down { stays_down } else { falls } {
                lost[place] = lost[place - 1].saturating_add(1);
            }
        }
        lost
    }

    /// Place of an epoch in the series, the nearest where they do not reach.
    fn place(&self, epoch: i64, len: usize) -> usize {
        usize::try_from(epoch.saturating_sub(self.first)).unwrap_or(0).min(len.saturating_sub(1))
    }

    /// The model.
    pub fn model(&self) -> &ErrorModel {
        &self.model
    }

    /// The constant part of the error of an axis: the bias that is given, and the one that was drawn.
    pub fn constant(&self, axis: usize) -> f64 {
        self.model.axes[axis].bias + self.biases[axis]
    }

    /// The error of an axis in the report of an epoch, which was `t_s` after pulse 0, before rounding.
    pub fn value(&self, axis: usize, epoch: i64, t_s: f64) -> f64 {
        self.model.axes[axis].known(t_s)[0] + self.biases[axis] + self.random(axis, epoch)
    }

    /// The part of it that changes by chance.
    pub fn random(&self, axis: usize, epoch: i64) -> f64 {
        let series = &self.series[axis];
        if series.is_empty() { 0.0 } else { series[self.place(epoch, series.len())] }
    }

    /// What is known exactly of an axis, and the constant that was drawn, with first and second derivative.
    pub fn known(&self, axis: usize, t_s: f64) -> [f64; 3] {
        let mut jet = self.model.axes[axis].known(t_s);
        jet[0] += self.biases[axis];
        jet
    }

    /// The report that is at hand `t_s` after pulse 0.
    pub fn latest(&self, t_s: f64) -> LatestReport {
        self.latest_after(t_s, None)
    }

    /// The report that was at hand just before: a report that is made or arrives at the instant itself is
    /// not.
    pub fn received_before(&self, t_s: f64, latency_s: Option<f64>) -> LatestReport {
        self.latest_after(t_s - 2.0 * self.epochs.slack_s(), latency_s)
    }

    /// Time of an epoch after pulse 0, s; `None` if that is `t_s` itself.
    pub fn time_unless_now(&self, epoch: i64, t_s: f64) -> Option<f64> {
        let time_s = self.epochs.time_s(epoch);
        let now = (t_s - time_s).abs() <= self.epochs.slack_s();
        (!now).then_some(time_s)
    }

    /// The report that is at hand `t_s` after pulse 0 where reports take another time to arrive than the
    /// model has it.
    pub fn latest_after(&self, t_s: f64, latency_s: Option<f64>) -> LatestReport {
        let Self { model, epochs, .. } = self;
        let (between, dropout) = (model.between, false);
        if self.immediate && latency_s.is_none() {
            return LatestReport { epoch: epochs.at_or_before(t_s), time_s: None, between, dropout };
        }
        let latency_s = latency_s.unwrap_or(model.latency_s);
        let mut epoch = if self.jitter_s.is_empty() {
            epochs.at_or_before(t_s - latency_s)
        } else {
            // Any of those that were made may have arrived, also before an older one.
            let mut epoch = epochs.at_or_before(t_s);
            let slack_s = epochs.slack_s();
            while epoch > self.first {
                let jitter_s = self.jitter_s[self.place(epoch, self.jitter_s.len())];
                let takes_s = (latency_s + jitter_s).max(0.0);
                if epochs.time_s(epoch) + takes_s <= t_s + slack_s {
                    break;
                }
                epoch -= 1;
            }
            epoch
        };
        let mut latest = LatestReport { epoch, time_s: None, between, dropout };
        if let Some(dropouts) = &model.dropouts {
            // Lookups beyond the series find its last value.
            let place = self.place(epoch, self.lost.len());
            let back = i64::from(self.lost[place]);
            if back > 0 {
                epoch = self.first + place as i64 - back;
                latest = LatestReport { epoch, time_s: None, between: dropouts.during, dropout: true };
            }
        }
        latest.time_s = self.time_unless_now(epoch, t_s);
        latest
    }
}
