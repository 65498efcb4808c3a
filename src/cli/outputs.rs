//! Maps and pictures that a command makes.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::sea::SeaError;
use crate::plot::canvas::Canvas;
use crate::plot::picture::{Axis, Picture};
use crate::recording::output::{FileKind, Output, OutputError, apart};
use crate::scene::{Patch, Scene};

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

/// A table and its picture, in a folder of their own.
pub(super) struct TableAndPicture {
    table: Output,
    pub picture: Output,
    pub paths: [PathBuf; 2],
    kind: FileKind,
    /// Whether the table is one that this program has written.
    begun: bool,
}

impl TableAndPicture {
    /// `NAME.csv` and `NAME.png` in a folder, which is made where it is not there.
    pub fn plan(folder: &Path, name: &str, kind: FileKind, force: bool) -> Result<Self, OutputError> {
        fs::create_dir_all(folder).map_err(OutputError::io(folder, "making the folder"))?;
        let paths = ["csv", "png"].map(|extension| folder.join(format!("{name}.{extension}")));
        let table = Output::plan(&paths[0], kind, force)?;
        let picture = Output::plan(&paths[1], FileKind::Png, force)?;
        Ok(Self { table, picture, paths, kind, begun: false })
    }

    /// Writes the table: as a new file, or in the place of the one that this program has written before.
    pub fn write_table(&mut self, csv: String) -> Result<(), SeaError> {
        let table = match std::mem::replace(&mut self.begun, true) {
            false => self.table.clone(),
            true => Output::plan(&self.paths[0], self.kind, true)?,
        };
        table.write(|partial| {
            fs::write(partial, csv).map_err(OutputError::io(partial, "writing")).map_err(SeaError::from)
        })
    }
}

/// The number of a channel of a scene.
pub(super) fn channel_number(scene: &Scene, name: &str) -> Result<usize, SeaError> {
    let all = &scene.radar.channels;
    all.iter().position(|channel| channel.name == name).ok_or_else(|| {
        let known: Vec<&str> = all.iter().map(|channel| channel.name.as_str()).collect();
        SeaError::NoChannel { name: name.to_owned(), known: known.join(", ") }
    })
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
