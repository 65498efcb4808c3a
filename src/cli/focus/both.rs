//! `nereus focus --nav both`: what errors of the reports do to the image, predicted and measured.

use std::io::Write;
use std::path::Path;

use super::images::{Outputs, pictures};
use super::{FocusArgs, Nav, at, image, names, open, report, table};
use crate::cli::error::{CliError, Refused};
use crate::cli::escape;
use crate::motion::PlatformTracks;
use crate::pipeline::build;
use crate::pipeline::scenario::Scenario;
use crate::processor::comparison::{Side, compare as compare_images, difference};
use crate::processor::focus::{Focuser, Image, Navigation};
use crate::processor::two_way_gain::TwoWayGain;
use crate::recording::Recording;
use crate::recording::output::{FileKind, Output};

/// Refuses options that have no meaning with this --nav.
pub(super) fn check(args: &FocusArgs) -> Result<(), Refused> {
    if args.nav().is_none() {
        let refused = Refused::value("speckle", "with --nav both", "with --nav true or --nav reported");
        return if args.speckle { Err(refused) } else { Ok(()) };
    }
    match [("against", &args.against), ("cuts", &args.cuts)].into_iter().find(|(_, path)| path.is_some()) {
        Some((key, Some(path))) => Err(Refused::value(key, path.display(), "with --nav both only")),
        _ => Ok(()),
    }
}

/// Focuses twice and compares.
pub(super) fn compare(
    args: &FocusArgs,
    focuser: &Focuser,
    scenario: Option<&Scenario>,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    let recording = focuser.recording();
    if let Some(path) = args.cuts.as_ref().filter(|_| recording.header.targets.is_empty()) {
        return Err(Refused::value("cuts", path.display(), "for a recording of targets").into());
    }
    let places = focuser.channels();
    let names = names(recording, &places);
    let doubled: Vec<String> =
        names.iter().flat_map(|name| [format!("{name}_true"), format!("{name}_reported")]).collect();
    let outputs = Outputs::plan(args, &doubled)?;
    let mut cuts = Vec::new();
    for path in args.cuts.iter().flat_map(|path| pictures(path, &names)) {
        cuts.push(Output::plan(&path, FileKind::Png, args.force)?);
    }
    let other = args.against.as_ref().map(|path| reference(args, path, recording)).transpose()?;
    let (measure, measure_scenario) = match &other {
        Some((recording, scenario)) => (recording, scenario.as_ref()),
        None => (recording, scenario),
    };
    let right_path = args.against.as_ref().unwrap_or(&args.recording);
    let (at, right_at) = (at(&args.recording), at(right_path));
    let right = focuser.by_truth(measure, measure_scenario.map(Scenario::described)).map_err(&right_at)?;
    // Aims may differ from those of another recording only.
    let tracks = [measure_scenario, scenario].map(|of| if other.is_some() { tracks(of) } else { None });
    let mut channels = Vec::with_capacity(places.len());
    let mut images = Vec::with_capacity(2 * places.len());
    for (channel, right_channel) in places.into_iter().zip(right.channels()) {
        let pair = [image(&right, right_channel).map_err(&right_at)?, image(focuser, channel).map_err(&at)?];
        let [right_gain, gain] = [
            gain(&right, measure_scenario, tracks[0].as_deref(), right_channel),
            gain(focuser, scenario, tracks[1].as_deref(), channel),
        ];
        let [right_image, image] = &pair;
        let found = compare_images(
            &Side { focuser: &right, channel: right_channel, image: right_image, gain: right_gain },
            &Side { focuser, channel, image, gain },
        );
        channels.push(found.map_err(&at)?);
        images.extend(pair);
    }
    let navs = [Navigation::True, Navigation::Reported].map(Some).into_iter().cycle();
    let shown: Vec<(&Image, Nav)> = images.iter().zip(navs).collect();
    let mut made = outputs.write(args, recording, &shown, &doubled)?;
    for (output, channel) in cuts.into_iter().zip(&channels) {
        made.push(output.path().to_owned());
        channel.cuts()?.save(output)?;
    }
    let of = args.against.as_ref().map(|path| path.display().to_string());
    let of = of.map_or(String::new(), |path| format!(" navigation of {}", escape::name(&path)));
    let mut report =
        report::begun(args, focuser, "images", &format!("; reported navigation beside true{of}"));
    channels.iter().for_each(|channel| table::add_channel(&mut report, channel));
    report.value("channels", &channels).paths("out", &made);
    super::print(args, report, &made, out)
}

/// Tracks of a scenario; none where it names files that are not there.
fn tracks(scenario: Option<&Scenario>) -> Option<Vec<PlatformTracks>> {
    let run = &scenario?.0;
    build::tracks(&run.nav, &run.scene).ok().map(|(tracks, _)| tracks)
}

fn gain<'a>(
    focuser: &Focuser,
    scenario: Option<&'a Scenario>,
    tracks: Option<&'a [PlatformTracks]>,
    channel: usize,
) -> Option<TwoWayGain<'a>> {
    TwoWayGain::of(focuser.recording(), scenario?.described(), tracks?, channel)
}

/// The recording that is the measure: as many pulses of the same radar, with the same channels.
fn reference(
    args: &FocusArgs,
    path: &Path,
    like: &Recording,
) -> Result<(Recording, Option<Scenario>), CliError> {
    let (right, scenario) = open(args, path)?;
    match difference(&right, like) {
        Some(what) => Err(Refused::Against { path: path.to_owned(), what }.into()),
        None => Ok((right, scenario)),
    }
}
