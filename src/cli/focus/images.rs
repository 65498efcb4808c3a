//! Pictures and files of complex values.

use std::path::{Path, PathBuf};

use num_complex::Complex32;

use super::{FILTERS, FocusArgs, NAVS, Nav, TAPERS};
use crate::cli::error::{CliError, Refused};
use crate::cli::values::word_of;
use crate::cli::{counted, escape};
use crate::plot::canvas::Canvas;
use crate::processor::focus::Image;
use crate::processor::focus::picture::Scale;
use crate::recording::Recording;
use crate::recording::field_file::Attribute;
use crate::recording::image_file::ImageFile;
use crate::recording::output::{FileKind, Output};

/// Where images go.
pub(super) struct Outputs {
    pictures: Vec<Output>,
    values: Option<Output>,
}

impl Outputs {
    /// Those of images of such names.
    pub fn plan(args: &FocusArgs, names: &[String]) -> Result<Self, CliError> {
        let mut made = Self { pictures: Vec::new(), values: None };
        for path in &args.out {
            match path.extension().and_then(|e| e.to_str()) {
                Some("png") if made.pictures.is_empty() => {
                    let all = if args.panels { vec![path.clone()] } else { pictures(path, names) };
                    for path in all {
                        made.pictures.push(Output::plan(&path, FileKind::Png, args.force)?);
                    }
                }
                Some("h5") if made.values.is_none() => {
                    made.values = Some(Output::plan(path, FileKind::Hdf5, args.force)?);
                }
                kind => {
                    let allowed = match kind {
                        Some("png" | "h5") => "one name that ends in .png and one that ends in .h5",
                        _ => "a name that ends in .png or .h5",
                    };
                    return Err(Refused::value("out", escape::path(path), allowed).into());
                }
            }
        }
        Ok(made)
    }

    /// Writes images, each with the navigation by which it was made; the files made.
    pub fn write(
        self,
        args: &FocusArgs,
        recording: &Recording,
        images: &[(&Image, Nav)],
        names: &[String],
    ) -> Result<Vec<PathBuf>, CliError> {
        let paths = self.pictures.iter().chain(&self.values).map(|output| output.path().to_owned()).collect();
        let mut canvases = images.iter().map(|(image, nav)| picture(args, image, *nav));
        if args.panels {
            for output in self.pictures {
                let all: Vec<Canvas> = canvases.by_ref().collect::<Result<_, _>>()?;
                Canvas::tiled(&all, all.len().isqrt(), [255; 3]).save(output)?;
            }
        } else {
            for (output, canvas) in self.pictures.into_iter().zip(canvases) {
                canvas?.save(output)?;
            }
        }
        if let Some(output) = self.values {
            values(args, recording, images, names, output)?;
        }
        Ok(paths)
    }
}

/// Several pictures bear the names of what they show.
pub(super) fn pictures(path: &Path, names: &[String]) -> Vec<PathBuf> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let named = |name: &String| {
        // A recording of unknown origin may hold any name.
        let name = name.replace(|c: char| !(c.is_alphanumeric() || "-_.".contains(c)), "_");
        match names.len() {
            1 => path.to_owned(),
            _ => path.with_file_name(format!("{stem}_{name}.png")),
        }
    };
    names.iter().map(named).collect()
}

fn picture(args: &FocusArgs, image: &Image, nav: Nav) -> Result<Canvas, CliError> {
    let (pulses, nav) = (counted(image.pulses, "pulse"), word_of(&NAVS, &nav));
    let title = format!("{}, {pulses}, {nav} navigation", image.channel);
    let scale = match args.percentile {
        None => Scale::Decibels { span: args.dynamic_db },
        Some(percent) => Scale::Amplitudes { percent },
    };
    let size_px = if args.panels { 512 } else { 768 };
    Ok(image.picture(&title, args.looks, scale, size_px)?)
}

fn values(
    args: &FocusArgs,
    recording: &Recording,
    images: &[(&Image, Nav)],
    names: &[String],
    output: Output,
) -> Result<(), CliError> {
    let [(first_image, _), ..] = images else { return Ok(()) };
    let values: Vec<Vec<Complex32>> = images.iter().map(|(image, _)| image.values.clone()).collect();
    let (first, last) = (recording.index[0], recording.index[recording.index.len() - 1]);
    // Not a number: all pulses.
    let doppler_hz: Vec<f64> = images.iter().map(|(image, _)| image.doppler_hz.unwrap_or(f64::NAN)).collect();
    let attributes = [
        ("recording", Attribute::Text(&args.recording.display().to_string())),
        ("nav", Attribute::Text(word_of(&NAVS, &args.nav()))),
        ("window", Attribute::Text(word_of(&TAPERS, &args.window))),
        ("aperture", Attribute::Text(word_of(&TAPERS, &args.aperture))),
        ("filter", Attribute::Text(word_of(&FILTERS, &args.filter))),
        ("first_pulse", Attribute::Whole(first)),
        ("end_pulse", Attribute::Whole(last + 1)),
        ("height_m", Attribute::Real(args.height_m)),
        ("doppler_hz", Attribute::Reals(&doppler_hz)),
        ("carrier_hz", Attribute::Real(recording.header.carrier_hz)),
    ];
    let file =
        ImageFile { attributes: &attributes, channels: names, ground: &first_image.ground, images: &values };
    output.write(|partial| Ok(file.write(partial)?))
}
