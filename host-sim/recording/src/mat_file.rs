//! MATLAB `.mat` of version 5 to 7: vectors, columns of matrices, and those in structures, by their names with dots.
//!
//! Read here and by no crate: of those there are, `matfile` knows no structures, and `matrw` refuses what SciPy writes, takes a
//! file that is cut short for a whole one and panics on others. The format is fixed since 1996 (MathWorks, MAT-File Format, R2024b).

mod element;

use std::path::Path;

use super::topics::Topic;
use super::vectors;
use crate::Error;
use element::{Array, Content};

/// Elements of an array of structures that are looked into.
const MOST_STRUCTURES: usize = 64;

/// The vectors of a `.mat` file, those of one length together.
pub(crate) fn read(file: &Path, bytes: &[u8]) -> Result<Vec<Topic>, Error> {
    let failed = |message: String| Error::input(file, None, "", message);
    let variables = element::variables(bytes).map_err(failed)?;
    let mut objects = Vec::new();
    let mut found = Vec::new();
    for (name, array) in variables {
        collect(name, array, &mut found, &mut objects);
    }
    let topics = vectors::topics(found);
    if topics.is_empty() {
        let objects = vectors::only_in_matlab(&objects);
        return Err(failed(format!("it holds no vectors of numbers{objects}")));
    }
    Ok(topics)
}

fn collect(name: String, array: Array, found: &mut Vec<(String, Vec<f64>)>, objects: &mut Vec<String>) {
    match array.content {
        Content::Numbers(values) => found.extend(vectors::series(name, &array.dimensions, values)),
        Content::Structures(structures) => {
            let alone = structures.len() == 1;
            for (index, fields) in structures.into_iter().take(MOST_STRUCTURES).enumerate() {
                let before = if alone { name.clone() } else { format!("{name}[{}]", index + 1) };
                for (field, array) in fields {
                    collect(format!("{before}.{field}"), array, found, objects);
                }
            }
        }
        Content::Object => objects.push(name),
        Content::Other => {}
    }
}
