//! The firmware of the er-servo: on the MCU the image; on a host its application loop on the simulated plant (feature
//! `host-sim`), or, without that feature, the table of parameters the image has.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
mod fw;

#[cfg(all(not(target_os = "none"), feature = "host-sim"))]
mod host;

#[cfg(all(not(target_os = "none"), feature = "host-sim"))]
fn main() -> std::process::ExitCode {
    host::run()
}

#[cfg(all(not(target_os = "none"), not(feature = "host-sim")))]
fn main() {
    println!("frame schema {}, {} bytes a frame", er_servo::FRAME_SCHEMA, er_servo::FRAME_BYTES);
    println!("{:<24} {:>12} {:>8} {:>8}  unit", "parameter", "default", "min", "max");
    let defaults = er_servo::Config::default();
    for parameter in er_servo::parameters::TABLE {
        let value = (parameter.get)(&defaults);
        println!("{:<24} {value:>12} {:>8} {:>8}  {}", parameter.name, parameter.min, parameter.max, parameter.unit);
    }
    println!("\nto run the application loop on the simulated plant: cargo run --features host-sim");
}
