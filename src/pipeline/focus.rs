//! The short way back: a recording to its images.

use super::scenario::Scenario;
use crate::processor::focus::{FocusError, Focuser, Image, Settings};
use crate::recording::Recording;

/// Images of all channels of echoes that a recording holds, as `nereus focus` makes them: complex amplitudes
/// in sqrt(W) on a grid to the East and to the North, m ([`focus`](crate::processor::focus) says more).
///
/// ```
/// use nereus::{Recording, Scenario, focus};
///
/// // Eight pulses of a corner reflector, recorded into a plain folder.
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("corner");
/// let sink = format!("[{{ kind = \"plain\", path = {path:?} }}]");
/// let scenario = Scenario::load("configs/selftest.toml", &[("sink", &sink)])?;
/// scenario.stream(0..8)?.run(&Default::default(), None)?;
///
/// let recording = Recording::open(&path, None)?;
/// let mut settings = focus::Settings::default();
/// settings.centre_m = Some([3300.0, 0.0]);
/// settings.size_m = [8.0; 2];
/// settings.pixel_m = 0.25;
/// let images = focus(&recording, &settings)?;
/// assert_eq!((images[0].channel.as_str(), images[0].ground.pixels), ("VV", [32, 32]));
/// // By the radar equation -104.2 dBW: 100 W, 30 dBi at both ends, 100 m^2 at 3.3 km.
/// let peak_w = images[0].values.iter().map(|z| z.norm_sqr()).fold(0.0, f32::max);
/// assert!((10.0 * peak_w.log10() + 104.2).abs() < 0.2, "{peak_w}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// No channel of echoes, no replica, no true navigation (of what was received over the wire: set
/// `settings.nav` to [`Navigation::Reported`](crate::processor::focus::Navigation)), no middle
/// ([`Scenario::of`] says why its scenario is not read), a grid that cannot be, phase centres that are not
/// recorded, a Doppler band about an aim that is not known.
pub fn focus(recording: &Recording, settings: &Settings) -> Result<Vec<Image>, FocusError> {
    let scenario = Scenario::of(recording).ok();
    let focuser = Focuser::new(recording, scenario.as_ref().map(Scenario::described), settings)?;
    focuser.channels().into_iter().map(|channel| focuser.image(channel, &|_, _| ())).collect()
}
