//! Vectors and matrices that stand beside each other in a file, as columns.

use super::topics::{Series, Topic};

/// The shorter side of a matrix that is a table; a longer one is a picture or a map.
const MOST_COLUMNS: usize = 64;

/// The vectors, those of one length together.
pub(crate) fn topics(vectors: Vec<(String, Vec<f64>)>) -> Vec<Topic> {
    let mut topics: Vec<Topic> = Vec::new();
    for (name, values) in vectors {
        let column = (name, Series::Numbers(values));
        match topics.iter_mut().find(|topic| topic.rows() == column.1.len()) {
            Some(topic) => topic.columns.push(column),
            None => topics.push(Topic { logged_ns: Vec::new(), columns: vec![column] }),
        }
    }
    topics
}

/// What to do about objects of MATLAB, which no other program reads; nothing where there are none.
pub(crate) fn only_in_matlab(objects: &[String]) -> String {
    match objects {
        [] => String::new(),
        names => format!(
            "; {} is an object (table, timetable, timeseries), which only MATLAB reads: save its values, for a timetable T as \
             s = table2struct(timetable2table(T), 'ToScalar', true); save('log.mat', '-struct', 's', '-v7')",
            names.join(", ")
        ),
    }
}

/// A vector as it is; of a matrix the columns, or the rows where these are fewer. Values are column by column.
pub(crate) fn series(name: String, dimensions: &[usize], values: Vec<f64>) -> Vec<(String, Vec<f64>)> {
    let &[rows, columns] = dimensions else { return Vec::new() };
    if values.len() < 2 || rows.checked_mul(columns) != Some(values.len()) || rows.min(columns) > MOST_COLUMNS {
        return Vec::new();
    }
    if rows == 1 || columns == 1 {
        return vec![(name, values)];
    }
    let numbered = |index: usize, values: Vec<f64>| (format!("{name}[{}]", index + 1), values);
    if columns <= rows {
        values.chunks(rows).enumerate().map(|(index, column)| numbered(index, column.to_vec())).collect()
    } else {
        (0..rows).map(|row| numbered(row, values.iter().skip(row).step_by(rows).copied().collect())).collect()
    }
}
