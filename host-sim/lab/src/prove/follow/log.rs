//! A recording as the table it is, to be changed cell by cell.

use std::path::Path;

use crate::{Error, output};

/// Header and cells.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Log {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Log {
    pub(super) fn read(file: &Path) -> Result<Self, Error> {
        let wrong = |error: csv::Error| Error::input(file, None, "", error.to_string());
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(file).map_err(wrong)?;
        let header = reader.headers().map_err(wrong)?.iter().map(|name| name.trim().to_owned()).collect();
        let rows: Result<Vec<Vec<String>>, _> =
            reader.records().map(|row| Ok(row?.iter().map(|cell| cell.trim().to_owned()).collect())).collect();
        Ok(Self { header, rows: rows.map_err(wrong)? })
    }

    pub(super) fn write(&self, file: &Path) -> Result<(), Error> {
        let mut text = self.header.join(",") + "\n";
        self.rows.iter().for_each(|row| text += &(row.join(",") + "\n"));
        output::write_text(file, &text)
    }

    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are columns whose names begin so.
    fn columns(&self, beginning: &str) -> Vec<usize> {
        (0..self.header.len()).filter(|&at| self.header[at].starts_with(beginning)).collect()
    }

    /// Numbers of the first column whose name begins so; none where there is none, or a cell is no number.
    pub(super) fn numbers(&self, beginning: &str) -> Option<Vec<f64>> {
        let at = *self.columns(beginning).first()?;
        self.rows.iter().map(|row| row.get(at)?.parse().ok()).collect()
    }

    /// Changes every cell of the columns whose names begin so, row by row.
    pub(super) fn change(&mut self, beginning: &str, new: impl Fn(usize, f64) -> f64) {
        for at in self.columns(beginning) {
            for (row, cells) in self.rows.iter_mut().enumerate() {
                if let Some(value) = cells.get(at).and_then(|cell| cell.parse().ok()) {
                    // A zero has no sign.
                    cells[at] = format!("{:?}", new(row, value) + 0.0);
                }
            }
        }
    }

    /// These rows alone.
    pub(super) fn part(&self, rows: std::ops::Range<usize>) -> Self {
        Self { header: self.header.clone(), rows: self.rows[rows].to_vec() }
    }

    /// Every other row; what was held over two is their mean. Numbers of rows count on by one.
    pub(super) fn halved(&self) -> Self {
        let mut halved =
            Self { header: self.header.clone(), rows: self.rows.chunks_exact(2).map(|two| two[0].clone()).collect() };
        for beginning in ["torque_", "force_", "field_"] {
            for at in self.columns(beginning) {
                let mean = |two: &[Vec<String>]| {
                    Some(0.5 * (two[0][at].parse::<f64>().ok()? + two[1][at].parse::<f64>().ok()?))
                };
                for (row, two) in halved.rows.iter_mut().zip(self.rows.chunks_exact(2)) {
                    if let Some(mean) = mean(two) {
                        row[at] = format!("{mean:?}");
                    }
                }
            }
        }
        for at in self.columns("seq") {
            for row in &mut halved.rows {
                if let Ok(number) = row[at].parse::<u64>() {
                    row[at] = (number / 2).to_string();
                }
            }
        }
        halved
    }
}
