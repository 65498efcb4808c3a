//! Shards of a run: element 3 of 16.
//!
//! ```
//! use nereus::recording::shard::Shard;
//! let shard: Shard = "2/3".parse()?;
//! assert_eq!(shard.pulses(10), Some(3..6));
//! assert!("0/3".parse::<Shard>().is_err() && "4/3".parse::<Shard>().is_err());
//! # Ok::<(), nereus::recording::shard::NotAShard>(())
//! ```

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use thiserror::Error;

/// One of `of` parts of a run, of equal length to a pulse. Numbers begin with 1, as those of an array of jobs
/// do.
///
/// A recording is the same whatever the shards: blocks of pulses lie on a raster that begins with pulse 0,
/// and one that two shards share is made by both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: u64,
    of: u64,
}

/// Not a shard.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: K/N, K from 1 to N, such as 3/16")]
pub struct NotAShard;

impl Shard {
    /// Its number, from 1.
    pub fn number(self) -> u64 {
        self.number
    }

    /// Shards of the run.
    pub fn of(self) -> u64 {
        self.of
    }

    /// Its pulses of a run; none where the run has fewer pulses than shards.
    pub fn pulses(self, run: u64) -> Option<Range<u64>> {
        let (number, of, run) = (u128::from(self.number), u128::from(self.of), u128::from(run));
        // At most `run`, which is one.
        let before = |shards: u128| u64::try_from(run * shards / of).unwrap_or(u64::MAX);
        (of <= run).then(|| before(number - 1)..before(number))
    }
}

impl FromStr for Shard {
    type Err = NotAShard;

    fn from_str(text: &str) -> Result<Self, NotAShard> {
        let (number, of) = text.split_once('/').ok_or(NotAShard)?;
        let (number, of) = (number.parse().map_err(|_| NotAShard)?, of.parse().map_err(|_| NotAShard)?);
        if (1..=of).contains(&number) { Ok(Self { number, of }) } else { Err(NotAShard) }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}
