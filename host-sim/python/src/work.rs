//! Long work, away from Python's lock.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use lab::Error;
use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

create_exception!(servo_lab, ServoLabError, PyValueError, "Why a command stopped, in the words of the command line.");

/// Time between two looks whether Ctrl-C was pressed.
const BEAT: Duration = Duration::from_millis(50);

/// An error of the commands as Python raises it.
pub fn raised(error: Error) -> PyErr {
    ServoLabError::new_err(error.to_string())
}

/// What `work` gives, done with so many threads, as many as there are cores where that is none.
///
/// The threads are the call's own: a pool that outlives it would not survive a fork.
///
/// # Errors
/// That of the work; Ctrl-C, after which the work goes on unseen until it ends; a panic, which stays on its thread.
pub fn done<T: Send + 'static>(
    py: Python<'_>,
    jobs: Option<usize>,
    work: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(jobs.unwrap_or(0)).build();
    let threads = threads.map_err(|error| PyRuntimeError::new_err(format!("jobs: {error}")))?;
    let (send, mut receive) = channel();
    // A receiver that is gone has been interrupted.
    thread::spawn(move || drop(send.send(threads.install(work))));
    loop {
        let outcome;
        (receive, outcome) = py.detach(move || {
            let outcome = receive.recv_timeout(BEAT);
            (receive, outcome)
        });
        match outcome {
            Ok(outcome) => return outcome.map_err(raised),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => {
                let message = "the computation ended without an outcome: please report it";
                return Err(PyRuntimeError::new_err(message));
            }
        }
    }
}
