//! Maps and pictures that a command makes.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use super::sea::SeaError;
use crate::plot::canvas::Canvas;
use crate::plot::picture::{Axis, Picture};
use crate::recording::output::{FileKind, Output, OutputError, apart};
use crate::scene::Patch;

/// The files that were asked for, each of which may be made, and no two of which are the same.
pub(super) fn outputs<const N: usize>(
    asked: [(&Option<PathBuf>, FileKind); N],
    force: bool,
) -> Result<[Option<Output>; N], SeaError> {
    if cfg!(not(feature = "hdf5")) {
        let hdf5 = asked.iter().filter(|(_, kind)| matches!(kind, FileKind::Hdf5));
        if let Some(out) = hdf5.filter_map(|(path, _)| path.as_ref()).next() {
            return Err(SeaError::NoHdf5 { out: out.clone() });
        }
    }
    let mut outputs = [const { None }; N];
    for (output, (path, kind)) in outputs.iter_mut().zip(asked) {
        *output = plan(path.as_ref(), kind, force)?;
    }
    apart(outputs.iter().flatten())?;
    Ok(outputs)
}

/// A file that was asked for, if it may be made.
pub(super) fn plan(
    path: Option<&PathBuf>,
    kind: FileKind,
    force: bool,
) -> Result<Option<Output>, OutputError> {
    path.map(|path| Output::plan(path, kind, force)).transpose()
}

/// Axes of a picture of a patch; facets lie about their centres.
pub(super) fn axes(patch: &Patch) -> [Axis<'static>; 2] {
    [("East, m", 0), ("North, m", 1)].map(|(label, axis)| {
        let from = (patch.first[axis] as f64 - 0.5) * patch.facet_m;
        Axis { label, from, to: from + patch.size_m()[axis] }
    })
}

pub(super) fn save_png(output: Output, picture: &Picture) -> Result<(), SeaError> {
    save_canvas(output, &picture.draw()?)
}

/// Writes a picture that is drawn.
pub(super) fn save_canvas(output: Output, canvas: &Canvas) -> Result<(), SeaError> {
    output.write(|partial| {
        let file = File::create_new(partial).map_err(OutputError::io(partial, "making the file"))?;
        let mut file = BufWriter::new(file);
        canvas.write_png(&mut file)?;
        file.flush().map_err(OutputError::io(partial, "writing"))?;
        Ok(())
    })
}
