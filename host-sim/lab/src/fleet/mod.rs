//! Many machines: every row of a manifest is a diagnosis, over all cores, and what is done is not done again.

pub mod manifest;
pub mod summary;
pub mod table;

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use diagnosis::effects::VOCABULARY;
use rayon::prelude::*;

use crate::Error;
use crate::conclude;
use crate::progress::{Course, Progress};
use crate::report::Answer;

pub use manifest::Task;
pub use table::Row;

/// Does each task whose key is not among `earlier`, several at a time, and returns all rows in the order of the manifest. After each,
/// `save` gets the rows there are: a run that is stopped there goes on from them.
///
/// # Errors
/// What `save` says; the tasks that are left are not begun then.
pub fn run(
    tasks: &[Task],
    earlier: &HashMap<String, Answer>,
    save: impl FnMut(&[&Row]) -> Result<(), Error> + Send,
) -> Result<Vec<Row>, Error> {
    let bar = Progress::new("diagnoses", tasks.len() as u64);
    let known: Vec<Option<Row>> = tasks.par_iter().map(|task| known(task, earlier)).collect();
    let left: Vec<usize> = (0..tasks.len()).filter(|&index| known[index].is_none()).collect();
    bar.advance((tasks.len() - left.len()) as u64);
    let state = Mutex::new((known, save));
    left.into_par_iter().try_for_each(|index| {
        let row = one(&tasks[index]);
        let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
        let (rows, save) = &mut *state;
        rows[index] = Some(row);
        bar.advance(1);
        save(&rows.iter().flatten().collect::<Vec<_>>())
    })?;
    let (rows, _) = state.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(rows.into_iter().flatten().collect())
}

/// The row of a task that an earlier run has done.
fn known(task: &Task, earlier: &HashMap<String, Answer>) -> Option<Row> {
    let key = task.key().ok()?;
    let answer = earlier.get(&key)?.clone();
    Some(Row { task: task.clone(), key, outcome: Ok(answer) })
}

/// Diagnoses one row; whatever is wrong with it is its outcome.
fn one(task: &Task) -> Row {
    let (key, answer) = match task.key() {
        Ok(key) => (key, answer(task)),
        Err(error) => (String::new(), Err(error)),
    };
    Row { task: task.clone(), key, outcome: answer.map_err(|error| error.to_string()) }
}

fn answer(task: &Task) -> Result<Answer, Error> {
    let [recordings, holdout] = task.recording_files();
    Ok(conclude::of_files(&task.machine_file(), &recordings, &holdout, &VOCABULARY, &Course::unseen())?.diagnosis.answer)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::report::Verdict;

    /// The files are no recordings: only an answer that is there already can be the answer.
    #[test]
    fn what_is_done_is_not_done_again_until_a_file_changes() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["m.toml", "a.csv", "b.csv"] {
            std::fs::write(at(name), "nothing").unwrap();
        }
        std::fs::write(at("list.csv"), "machine,recordings,holdout\nm.toml,a.csv,b.csv\nm.toml,b.csv,\n").unwrap();
        let tasks = manifest::read(&at("list.csv")).unwrap();
        let answer = Answer { verdict: Verdict::Named, ..Answer::default() };
        let earlier = HashMap::from([(tasks[0].key().unwrap(), answer.clone())]);
        let mut saved = 0;
        let rows = run(&tasks, &earlier, |rows| {
            saved += rows.len();
            Ok(())
        });
        let rows = rows.unwrap();
        assert_eq!(rows[0].outcome, Ok(answer));
        assert!(rows[1].outcome.is_err() && saved == 2, "saved once, with both rows: {saved}");
        std::fs::write(at("b.csv"), "another").unwrap();
        assert!(run(&tasks, &earlier, |_| Ok(())).unwrap()[0].outcome.is_err());
    }
}
