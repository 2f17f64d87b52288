//! MATLAB `.mat` of version 5 to 7: vectors, columns of matrices, and those in structures, by their names with dots.
//!
//! Read here and by no crate: of those there are, `matfile` knows no structures, and `matrw` refuses what SciPy writes, takes a
//! file that is cut short for a whole one and panics on others. The format is fixed since 1996 (MathWorks, MAT-File Format, R2024b).

mod element;

use std::path::Path;

use super::topics::{Series, Topic};
use crate::Error;
use element::{Array, Content};

/// The shorter side of a matrix that is a table; a longer one is a picture or a map.
const MOST_COLUMNS: usize = 64;
/// Elements of an array of structures that are looked into.
const MOST_STRUCTURES: usize = 64;

/// The vectors of a `.mat` file, those of one length together.
pub(crate) fn read(file: &Path, bytes: &[u8]) -> Result<Vec<Topic>, Error> {
    let failed = |message: String| Error::input(file, None, "", message);
    let variables = element::variables(bytes).map_err(failed)?;
    let mut objects = Vec::new();
    let mut vectors = Vec::new();
    for (name, array) in variables {
        collect(name, array, &mut vectors, &mut objects);
    }
    let mut topics: Vec<Topic> = Vec::new();
    for (name, values) in vectors {
        let column = (name, Series::Numbers(values));
        match topics.iter_mut().find(|topic| topic.rows() == column.1.len()) {
            Some(topic) => topic.columns.push(column),
            None => topics.push(Topic { logged_ns: Vec::new(), columns: vec![column] }),
        }
    }
    if topics.is_empty() {
        let objects = match objects.as_slice() {
            [] => String::new(),
            names => format!(
                "; {} is an object (table, timetable, timeseries), which only MATLAB reads: save its values, for a timetable T as \
                 s = table2struct(timetable2table(T), 'ToScalar', true); save('log.mat', '-struct', 's', '-v7')",
                names.join(", ")
            ),
        };
        return Err(failed(format!("it holds no vectors of numbers{objects}")));
    }
    Ok(topics)
}

fn collect(name: String, array: Array, vectors: &mut Vec<(String, Vec<f64>)>, objects: &mut Vec<String>) {
    match array.content {
        Content::Numbers(values) => vectors.extend(series(name, &array.dimensions, values)),
        Content::Structures(structures) => {
            let alone = structures.len() == 1;
            for (index, fields) in structures.into_iter().take(MOST_STRUCTURES).enumerate() {
                let before = if alone { name.clone() } else { format!("{name}[{}]", index + 1) };
                for (field, array) in fields {
                    collect(format!("{before}.{field}"), array, vectors, objects);
                }
            }
        }
        Content::Object => objects.push(name),
        Content::Other => {}
    }
}

/// A vector as it is; of a matrix the columns, or the rows where these are fewer.
fn series(name: String, dimensions: &[usize], values: Vec<f64>) -> Vec<(String, Vec<f64>)> {
    let &[rows, columns] = dimensions else { return Vec::new() };
    if values.len() < 2 || rows.checked_mul(columns) != Some(values.len()) || rows.min(columns) > MOST_COLUMNS {
        return Vec::new();
    }
    if rows == 1 || columns == 1 {
        return vec![(name, values)];
    }
    // Column by column in memory.
    let numbered = |index: usize, values: Vec<f64>| (format!("{name}[{}]", index + 1), values);
    if columns <= rows {
        values.chunks(rows).enumerate().map(|(index, column)| numbered(index, column.to_vec())).collect()
    } else {
        (0..rows).map(|row| numbered(row, values.iter().skip(row).step_by(rows).copied().collect())).collect()
    }
}
