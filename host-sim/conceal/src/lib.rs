//! Machines with something concealed, and recordings of them.
//!
//! The tool that diagnoses must not be judged by data of its own making: a shared integrator would share its phantom
//! physics. This crate therefore has numerics of its own, of another kind: Moreau's time stepping, in which velocities
//! jump by impulses and dry friction is a set from which each step takes the impulse it needs, at a fixed step of
//! [`STEP_S`]; delays are ring buffers of steps, lags exact recursions. Only the control law [`er_servo::step`] is shared,
//! so that the loop is the real one.
//!
//! Data takes this way: [`plan`] says what a seed is, [`catalogue`] draws effects and their sizes, [`physics`] holds the machine as numbers, [`rotor`]
//! integrates it, [`closed_loop`] runs the law on it along a [`mod@reference`], [`recording`] writes what the drive would have
//! logged, [`case`] puts all of that together, and [`seal`] closes the truth away. The same seed gives the same files. That is the fixed plan: one
//! machine, lists of effects. In the drawn one [`drawn`] makes machines, logs and noise of any kind, with effects of the vocabulary or
//! of [`outside`] in sizes of what the motion can tell.
#![forbid(unsafe_code)]

pub mod case;
pub mod catalogue;
pub mod closed_loop;
mod delay;
pub mod drawn;
mod drive;
mod fluid;
mod friction;
pub mod indistinct;
mod machine_file;
pub mod named;
pub mod outside;
pub mod physics;
pub mod plan;
pub mod recording;
pub mod reference;
pub mod rotor;
pub mod seal;
mod sensor;
mod shaft;
pub mod subject;

pub use rotor::STEP_S;

/// Why a recording could not be made or written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The configuration is not one the law takes.
    #[error("the control law refuses its configuration: {0}")]
    Config(er_servo::ConfigError),
    /// The drive left the running state: the drawn machine cannot be controlled along this reference.
    #[error("the drive tripped at {t_s} s: {faults}")]
    Tripped {
        /// When, s.
        t_s: f64,
        /// What the law said.
        faults: String,
    },
    /// No drawn machine runs with the effects of its blueprint.
    #[error("seed {seed}: none of the drawn machines runs with such effects")]
    NoMachine {
        /// The seed.
        seed: u64,
    },
    /// Every family outside the vocabulary was used.
    #[error(
        "every family of effects outside the vocabulary was used: new ones are needed before a round can be scored"
    )]
    NoFamily,
    /// A file that is no reference.
    #[error("the reference cannot be played: {0}")]
    ReferenceFile(String),
    /// A file that cannot be written.
    #[error("cannot write {0}")]
    Write(String),
    /// Text that could not be made.
    #[error("the recording cannot be written: {0}")]
    Csv(#[from] csv::Error),
    /// The seal as JSON.
    #[error("the seal cannot be written: {0}")]
    Json(#[from] serde_json::Error),
}
