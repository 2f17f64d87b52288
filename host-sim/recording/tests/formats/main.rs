//! Every format that is read or written, and what of it is refused.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod exports;
mod hdf5;
mod machine_file;
mod mat;
mod mcap;
mod mcap_protobuf;
mod other_logs;
mod outputs;
mod parquet;
mod real_data;
mod recording_csv;
mod round_trip;
mod ulog;
