//! A table and its picture, in a folder of their own.

use std::fs;
use std::path::{Path, PathBuf};

use crate::recording::output::{FileKind, Output, OutputError};

/// `NAME.csv` and `NAME.png` in a folder.
pub struct TableAndPicture {
    table: Output,
    /// The picture.
    pub picture: Output,
    /// Both, the table first.
    pub paths: [PathBuf; 2],
    kind: FileKind,
    /// Whether the table is one that this program has written.
    begun: bool,
}

impl TableAndPicture {
    /// In a folder, which is made where it is not there.
    ///
    /// # Errors
    /// Files that may not be made.
    pub fn plan(folder: &Path, name: &str, kind: FileKind, force: bool) -> Result<Self, OutputError> {
        fs::create_dir_all(folder).map_err(OutputError::io(folder, "making the folder"))?;
        let paths = ["csv", "png"].map(|extension| folder.join(format!("{name}.{extension}")));
        let table = Output::plan(&paths[0], kind, force)?;
        let picture = Output::plan(&paths[1], FileKind::Png, force)?;
        Ok(Self { table, picture, paths, kind, begun: false })
    }

    /// Writes the table: as a new file, or in the place of the one that this program has written before.
    ///
    /// # Errors
    /// What the system refuses.
    pub fn write_table(&mut self, csv: String) -> Result<(), OutputError> {
        let table = match std::mem::replace(&mut self.begun, true) {
            false => self.table.clone(),
            true => Output::plan(&self.paths[0], self.kind, true)?,
        };
        table.write(|partial| fs::write(partial, csv).map_err(OutputError::io(partial, "writing")))
    }
}
