//! The recording of a run sent elsewhere than its scenario has it.

use std::path::{Path, PathBuf};

use super::{Kind, Settings, names_crsd, names_hdf5};
use crate::inputs::shown;

/// Why a recording cannot be sent elsewhere.
#[derive(Debug, thiserror::Error)]
pub enum RedirectionError {
    /// Several recordings.
    #[error(
        "--out {} does not say which of {recordings} recordings; allowed with one, else --set sink.<n>.path=...",
        shown(out)
    )]
    WhichSink {
        /// What was asked.
        out: PathBuf,
        /// Recordings of the scenario.
        recordings: usize,
    },
    /// An HDF5 file asked of a build without HDF5.
    #[error(
        "this build has no HDF5 (feature `hdf5`): --out {} cannot be an HDF5 file; allowed: a folder",
        shown(out)
    )]
    NoHdf5 {
        /// What was asked.
        out: PathBuf,
    },
}

/// Refuses the name of an HDF5 file where this build makes none.
///
/// # Errors
/// Such a name.
pub fn check_name(out: &Path) -> Result<(), RedirectionError> {
    match names_hdf5(out) && !cfg!(feature = "hdf5") {
        true => Err(RedirectionError::NoHdf5 { out: out.to_owned() }),
        false => Ok(()),
    }
}

/// Sends the recording elsewhere, or replaces the null sink where there is none.
///
/// # Errors
/// Several recordings, and a name of an HDF5 file where this build makes none.
pub fn redirect(sinks: &mut Vec<Settings>, out: &Path) -> Result<(), RedirectionError> {
    let mut paths: Vec<&mut PathBuf> =
        sinks.iter_mut().filter_map(|sink| sink.kind.recording_path()).collect();
    match &mut paths[..] {
        [path] => {
            **path = out.to_owned();
            record_as_named(sinks, out);
        }
        [] => {
            check_name(out)?;
            let kind = Kind::recording_at(out, false);
            // A resolved run has at least one sink. One that sends goes on sending.
            match sinks.iter_mut().find(|sink| sink.kind == Kind::Null) {
                Some(sink) => sink.kind = kind,
                None => {
                    let queue_pulses = sinks.first().map_or(64, |sink| sink.queue_pulses);
                    sinks.push(Settings::new(kind, queue_pulses));
                }
            }
        }
        several => {
            return Err(RedirectionError::WhichSink { out: out.to_owned(), recordings: several.len() });
        }
    }
    Ok(())
}

/// A recording whose new name ends as HDF5 or CRSD becomes one, where this build can make it.
fn record_as_named(sinks: &mut [Settings], out: &Path) {
    let (to_hdf5, to_crsd) = (cfg!(feature = "hdf5") && names_hdf5(out), names_crsd(out));
    for sink in sinks {
        match &sink.kind {
            Kind::Plain { path, force } | Kind::Crsd { path, force } if to_hdf5 => {
                sink.kind = Kind::Hdf5 { path: path.clone(), segment_s: None, force: *force };
            }
            Kind::Plain { path, force } | Kind::Hdf5 { path, force, .. } if to_crsd => {
                sink.kind = Kind::Crsd { path: path.clone(), force: *force };
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn redirected(kinds: Vec<Kind>, out: &str) -> Result<Vec<Kind>, RedirectionError> {
        let of = |kind| Settings::new(kind, 7);
        let mut sinks: Vec<Settings> = kinds.into_iter().map(of).collect();
        redirect(&mut sinks, out.as_ref())?;
        assert!(sinks.iter().all(|sink| sink.queue_pulses == 7));
        Ok(sinks.into_iter().map(|sink| sink.kind).collect())
    }

    fn plain(path: &str) -> Kind {
        Kind::Plain { path: path.into(), force: true }
    }

    #[test]
    fn the_one_recording_goes_elsewhere_by_its_name() {
        assert_eq!(redirected(vec![Kind::Null, plain("a")], "b").unwrap(), [Kind::Null, plain("b")]);
        let crsd = Kind::Crsd { path: "b.crsd".into(), force: true };
        assert_eq!(redirected(vec![plain("a")], "b.crsd").unwrap(), [crsd]);
        #[cfg(feature = "hdf5")]
        {
            let hdf5 = Kind::Hdf5 { path: "b.h5".into(), segment_s: None, force: true };
            assert_eq!(redirected(vec![plain("a")], "b.h5").unwrap(), [hdf5]);
        }
    }

    #[test]
    fn without_a_recording_one_is_added_and_of_several_none_is_meant() {
        let added = Kind::Plain { path: "b".into(), force: false };
        assert_eq!(redirected(vec![Kind::Null], "b").unwrap(), [added]);
        let error = redirected(vec![plain("a"), plain("c")], "b").unwrap_err();
        assert!(error.to_string().contains("which of 2 recordings"), "{error}");
    }
}
