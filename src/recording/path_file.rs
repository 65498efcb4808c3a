//! The scatterer paths of one pulse in an HDF5 file, for whoever wants to make its echo by other means.
//!
//! ```text
//! s_c(t) = sum_n a_cn exp(-j 2 pi f0 tau_n) p(u_n) exp(-j 2 pi f0 r_n u_n),   u_n = (t - o_n - tau_n)/(1 + r_n)
//! ```
//!
//! `t` after the emission of the pulse; the first of the samples is taken at `window_start_s`. Before it is
//! sampled, `s_c` passes the [receive filter](crate::radar::filter).
//!
//! | dataset | symbol | what | unit |
//! | --- | --- | --- | --- |
//! | `/emission_offset_s` `[n]` | `o` | emission of the scatterer path after that of the pulse; zero unless several pulses are in the air | s |
//! | `/delay_s` `[pair, n]` | `tau` | delay | s |
//! | `/delay_rate` `[pair, n]` | `r` | its rate, negative when closing | 1 |
//! | `/amplitude` `[channel, n]` | `a` | complex amplitude without carrier phase | sqrt(W) |
//! | `/channel_pair` `[channel]` | | the pair whose delays are those of a channel | |
//!
//! All in f64, each with the attributes `unit` and `meaning`. Root attributes: `format = "nereus-paths"`,
//! `version` (1), `channels` and `pairs` (names, pairs as `transmitter/receiver`), and those of the caller.
//! HDF5 format bounds 1.10.
//!
//! ```
//! use nereus::recording::path_file::PathFile;
//! use nereus::paths::list::ScattererPaths;
//! use num_complex::Complex64;
//! let mut paths = ScattererPaths::new(1, 1, 1);
//! paths.push(0.0, [(28.3e-6, -1e-7)], &[Complex64::new(1e-8, 0.0)]);
//! let file = PathFile {
//!     attributes: &[],
//!     pairs: &["tx/rx".to_owned()],
//!     channels: &["VV".to_owned()],
//!     channel_pairs: &[1],
//!     paths: &paths,
//! };
//! let refused = file.write("never.h5".as_ref()).unwrap_err();
//! assert_eq!(refused.to_string(), "channel 0 lies on pair 1; there are 1");
//! ```

use std::path::Path;

use super::field_file::{self, Attribute, FieldFileError, Fields, SOFTWARE};
#[cfg(feature = "hdf5")]
use super::field_file::{Fault, list, put, texts};
use crate::paths::list::ScattererPaths;
use crate::pulse::Pulse;
use crate::scene::Scene;
use crate::scene::radar::{Pair, Sweep, Waveform};
use crate::units::in_turn;

/// What a file holds.
#[derive(Clone, Copy, Debug)]
pub struct PathFile<'a> {
    /// Further root attributes.
    pub attributes: &'a [(&'a str, Attribute<'a>)],
    /// Name of each pair.
    pub pairs: &'a [String],
    /// Name of each channel.
    pub channels: &'a [String],
    /// The pair of each channel.
    pub channel_pairs: &'a [usize],
    /// The scatterer paths.
    pub paths: &'a ScattererPaths,
}

/// Writes the scatterer paths of a pulse of a scene; `config` is the scenario's text.
///
/// # Errors
/// What cannot be written.
pub fn write(
    path: &Path,
    scene: &Scene,
    config: &str,
    pulse: &Pulse,
    channel_pairs: &[usize],
    paths: &ScattererPaths,
) -> Result<(), FieldFileError> {
    let radar = &scene.radar;
    let pair = |pair: &Pair| {
        let (tx, rx) = (&radar.transmitters[pair.transmitter].name, &radar.receivers[pair.receiver].name);
        format!("{tx}/{rx}")
    };
    let pairs: Vec<String> = radar.pairs().iter().map(pair).collect();
    let channels: Vec<String> = radar.channels.iter().map(|channel| channel.name.clone()).collect();
    let mut attributes = vec![
        ("software", Attribute::Text(SOFTWARE)),
        ("config", Attribute::Text(config)),
        ("seed", Attribute::Whole(scene.seed)),
        ("pulse", Attribute::Whole(pulse.index)),
        ("carrier_hz", Attribute::Real(radar.carrier_hz)),
        ("sample_rate_hz", Attribute::Real(radar.sample_rate_hz)),
        ("prf_hz", Attribute::Real(radar.emissions.mean_prf_hz())),
        ("window_start_s", Attribute::Real(pulse.window_start_s)),
        ("samples", Attribute::Whole(radar.window.samples as u64)),
    ];
    // What the pulse itself radiated, where several leave in turn.
    let radiated = in_turn(radar.waveform.pulses(), pulse.index).unwrap_or(&radar.waveform);
    if radiated.offset_hz() != 0.0 {
        attributes.push(("offset_hz", Attribute::Real(radiated.offset_hz())));
    }
    match radiated.level() {
        Waveform::Lfm { bandwidth_hz, duration_s, sweep } => attributes.extend([
            ("waveform", Attribute::Text("lfm")),
            ("bandwidth_hz", Attribute::Real(*bandwidth_hz)),
            ("pulse_s", Attribute::Real(*duration_s)),
            ("sweep", Attribute::Text(if matches!(sweep, Sweep::Up) { "up" } else { "down" })),
        ]),
        Waveform::Samples { rate_hz, .. } => attributes.extend([
            ("waveform", Attribute::Text("samples")),
            ("waveform_rate_hz", Attribute::Real(*rate_hz)),
        ]),
        other => {
            attributes.push(("waveform", Attribute::Text(other.kind())));
            attributes.extend(other.bandwidth_hz().map(|hz| ("bandwidth_hz", Attribute::Real(hz))));
            attributes.extend(other.duration_s().map(|s| ("pulse_s", Attribute::Real(s))));
            if let Waveform::PhaseCode { code, .. } = other {
                attributes.push(("code", Attribute::Text(code.name())));
                attributes.push(("chips", Attribute::Whole(code.chips() as u64)));
            }
        }
    }
    PathFile { attributes: &attributes, pairs: &pairs, channels: &channels, channel_pairs, paths }.write(path)
}

impl PathFile<'_> {
    /// Writes the file, which must not exist.
    ///
    /// # Errors
    /// Names that are not those of the list, and what the library refuses.
    pub fn write(&self, path: &Path) -> Result<(), FieldFileError> {
        field_file::write(self, path)
    }
}

impl Fields for PathFile<'_> {
    fn root(&self) -> (&str, &[(&str, Attribute<'_>)]) {
        ("nereus-paths", self.attributes)
    }

    fn check(&self) -> Result<(), FieldFileError> {
        let pairs = self.paths.delay_s.len();
        let tables = [
            ("pairs", self.pairs.len(), pairs),
            ("channels", self.channels.len(), self.paths.amplitude.len()),
            ("channels", self.channel_pairs.len(), self.paths.amplitude.len()),
        ];
        for (what, names, columns) in tables {
            if names != columns {
                return Err(FieldFileError::Names { what, names, columns });
            }
        }
        match self.channel_pairs.iter().position(|pair| *pair >= pairs) {
            Some(channel) => Err(FieldFileError::Pair { channel, pair: self.channel_pairs[channel], pairs }),
            None => Ok(()),
        }
    }

    #[cfg(feature = "hdf5")]
    fn fill(&self, file: &::hdf5::File) -> Result<(), Fault> {
        for (name, values) in [("channels", self.channels), ("pairs", self.pairs)] {
            if !values.is_empty() {
                list(file, name, &texts(values)?)?;
            }
        }
        let Self { paths, channel_pairs, .. } = self;
        let n = paths.len();
        let offset_meaning = "emission of the path after that of the pulse";
        put(file, "emission_offset_s", (n,), &paths.emission_offset_s, "s", offset_meaning)?;
        let (delay_s, rate) = (paths.delay_s.concat(), paths.delay_rate.concat());
        let shape = (paths.delay_s.len(), n);
        put(file, "delay_s", shape, &delay_s, "s", "delay after the emission of the path")?;
        put(file, "delay_rate", shape, &rate, "1", "rate of the delay, negative when closing")?;
        let (shape, meaning) = ((paths.amplitude.len(), n), "amplitude without carrier phase");
        put(file, "amplitude", shape, &paths.amplitude.concat(), "sqrt(W)", meaning)?;
        let pairs: Vec<u64> = channel_pairs.iter().map(|pair| *pair as u64).collect();
        put(file, "channel_pair", (pairs.len(),), &pairs, "1", "row of delay_s of each channel").map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(pairs: usize, channel_pairs: &[usize]) -> String {
        let paths = ScattererPaths::new(2, 3, 0);
        let names = |n: usize| (0..n).map(|k| k.to_string()).collect::<Vec<_>>();
        let (pairs, channels) = (names(pairs), names(3));
        let file =
            PathFile { attributes: &[], pairs: &pairs, channels: &channels, channel_pairs, paths: &paths };
        file.write(Path::new("never.h5")).unwrap_err().to_string()
    }

    #[test]
    fn names_are_those_of_the_list() {
        assert_eq!(refused(1, &[0, 0, 1]), "1 pairs are named; the path list has 2");
        assert_eq!(refused(2, &[0, 1]), "2 channels are named; the path list has 3");
        assert_eq!(refused(2, &[0, 1, 2]), "channel 2 lies on pair 2; there are 2");
    }
}
