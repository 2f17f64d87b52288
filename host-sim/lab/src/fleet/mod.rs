//! Many machines: every row of a manifest is a diagnosis, over all cores, and what is done is not done again.

pub mod manifest;
pub mod summary;
pub mod table;

use std::collections::HashMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use diagnosis::effects::VOCABULARY;
use rayon::prelude::*;

use crate::Error;
use crate::conclude;
use crate::progress::{Course, Progress};
use crate::report::Answer;

pub use manifest::Task;
pub use table::Row;

/// The whole table is written each time, so of a thousand rows not after each: what a run that is stopped loses is this much.
const SAVED_EVERY: Duration = Duration::from_secs(2);

/// Does each task whose key is not among `earlier`, several at a time, and returns all rows in the order of the manifest. After each
/// `SAVED_EVERY` and at the end `save` gets the rows there are: a run that is stopped goes on from them.
///
/// # Errors
/// What `save` says; the tasks that are left are not begun then.
pub fn run(
    tasks: &[Task],
    earlier: &HashMap<String, Answer>,
    save: impl FnMut(&[&Row]) -> Result<(), Error> + Send,
) -> Result<Vec<Row>, Error> {
    let known: Vec<Option<Row>> = tasks.par_iter().map(|task| known(task, earlier)).collect();
    let left: Vec<usize> = (0..tasks.len()).filter(|&index| known[index].is_none()).collect();
    // Those that are done already tell nothing of how long the others take.
    let progress = Progress::new("fleet, rows diagnosed", left.len() as u64);
    let (done, arriving) = channel();
    let rows = thread::scope(|scope| {
        scope.spawn(|| {
            let _ = left.into_par_iter().try_for_each_with(done, |done, index| {
                let row = one(&tasks[index]);
                progress.advance(1);
                // Nobody takes rows any more that cannot be saved.
                done.send((index, row)).map_err(drop)
            });
        });
        collected(known, arriving, save)
    })?;
    Ok(rows.into_iter().flatten().collect())
}

/// The rows with those that arrive, which are saved now and then, and at the end. Where they cannot be, no more are taken.
fn collected(
    mut rows: Vec<Option<Row>>,
    arriving: Receiver<(usize, Row)>,
    mut save: impl FnMut(&[&Row]) -> Result<(), Error>,
) -> Result<Vec<Option<Row>>, Error> {
    let mut due: Option<Instant> = None;
    loop {
        let next = match due {
            None => arriving.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(due) => arriving.recv_timeout(due.saturating_duration_since(Instant::now())),
        };
        match next {
            Ok((index, row)) => {
                rows[index] = Some(row);
                due = due.or_else(|| Some(Instant::now() + SAVED_EVERY));
            }
            Err(ended) => {
                if due.take().is_some() {
                    save(&rows.iter().flatten().collect::<Vec<_>>())?;
                }
                if ended == RecvTimeoutError::Disconnected {
                    return Ok(rows);
                }
            }
        }
    }
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
    Ok(conclude::of_files(&task.machine_file(), &recordings, &holdout, &VOCABULARY, &Course::unseen())?
        .diagnosis
        .answer)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::report::Verdict;

    #[test]
    fn rows_that_come_fast_are_saved_together_and_no_row_waits_long() {
        let row = |line: u64| Row {
            task: Task { line, ..Task::default() },
            key: String::new(),
            outcome: Err("none".to_owned()),
        };
        let (done, arriving) = channel();
        let sending = thread::spawn(move || {
            (0..100).for_each(|line| done.send((line as usize, row(line))).unwrap());
            // The next one takes longer than a row may wait.
            thread::sleep(SAVED_EVERY + Duration::from_millis(500));
            done.send((100, row(100))).unwrap();
        });
        let mut saved = Vec::new();
        let rows = collected(vec![None; 101], arriving, |rows| {
            saved.push(rows.len());
            Ok(())
        });
        sending.join().unwrap();
        assert_eq!(rows.unwrap().into_iter().flatten().count(), 101);
        assert_eq!(saved, [100, 101]);
    }

    #[test]
    fn what_cannot_be_saved_ends_the_run() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("list.csv"), "machine,recordings\nm.toml,a.csv\n").unwrap();
        let tasks = manifest::read(&folder.path().join("list.csv")).unwrap();
        let error = run(&tasks, &HashMap::new(), |_| Err(Error::Usage("the disk is full".to_owned()))).unwrap_err();
        assert_eq!(error.to_string(), "the disk is full");
    }

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
