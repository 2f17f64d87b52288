//! The application loop on the simulated plant: boot, enable, a step, a push, a pulled interlock, and what it logs.

use std::process::ExitCode;

use er_servo::app::Orders;
use er_servo::host_sim::{Bench, BenchError};
use er_servo::{Config, Counts, Frame, Params, Request, Supervisor};
use plant::{Er, Model};

/// Runs the session and prints the events as the image would log them.
pub fn run() -> ExitCode {
    match session() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn session() -> Result<(), Box<dyn std::error::Error>> {
    let config = Config::default();
    let params = Params::new(&config)?;
    let model = Model { er: Some(Er::new(0.0704, 0.470, 0.002, 0.003)), ..Model::paper() };
    let mut bench = Bench::new(&model, params, f64::from(config.period_s))?;
    println!("simulated plant: L 5 ms, field 2 ms dead time and 3 ms lag; true stiction 0.763 N m");
    bench.init().map_err(|error| format!("the chips did not come up: {error:?}"))?;
    let mut log = Log::default();
    log.watch(&bench.enable()?);

    let step = Orders { reference: Counts::from_rad(std::f64::consts::FRAC_PI_6), ..Orders::default() };
    println!("-- reference steps by 30 degrees");
    log.run(&mut bench, &step, 400)?;
    println!("-- 8 N m push the rotor for 50 ms");
    bench.external_torque_nm = 8.0;
    log.run(&mut bench, &step, 100)?;
    bench.external_torque_nm = 0.0;
    log.run(&mut bench, &step, 300)?;
    println!("-- the interlock is pulled, closed again, the fault cleared");
    bench.interlock_closed.set(false);
    log.run(&mut bench, &step, 1)?;
    bench.interlock_closed.set(true);
    log.run(&mut bench, &Orders { request: Request::ClearFault, ..step }, 1)?;
    log.run(&mut bench, &step, 100)?;
    Ok(())
}

/// Prints what changed from frame to frame.
#[derive(Default)]
struct Log {
    supervisor: Option<Supervisor>,
    limits: er_servo::Limits,
    mode: er_servo::Mode,
}

impl Log {
    fn run(&mut self, bench: &mut Bench, orders: &Orders, ticks: u32) -> Result<(), BenchError> {
        for _ in 0..ticks {
            let frame = bench.tick(orders)?;
            self.watch(&frame);
        }
        let truth = bench.truth();
        println!("   rotor at {:.5} rad, {:.4} rad/s", truth.position, truth.velocity);
        Ok(())
    }

    fn watch(&mut self, frame: &Frame) {
        let outputs = &frame.outputs;
        let at = format!("tick {:>5}", frame.seq);
        let settled =
            |state: Supervisor| if let Supervisor::Boot { .. } = state { Supervisor::default() } else { state };
        if self.supervisor.map(settled) != Some(settled(outputs.supervisor)) {
            println!("{at}  {}", outputs.supervisor.name());
            outputs.supervisor.faults().explain().for_each(|sentence| println!("{at}  {sentence}"));
        }
        if self.mode != outputs.mode {
            println!("{at}  {} {:.3} kV/mm", outputs.mode.name(), outputs.field_kv_mm);
        }
        if self.limits != outputs.limits {
            println!("{at}  limits {:?}", outputs.limits);
        }
        (self.supervisor, self.mode, self.limits) = (Some(outputs.supervisor), outputs.mode, outputs.limits);
    }
}
