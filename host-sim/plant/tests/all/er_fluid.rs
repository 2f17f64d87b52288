//! The options of a real fluid against closed forms.

use crate::common::{FLOW, KINETICS, distance, field, run};
use plant::er_fluid::{Electrode, FlowCurve, Kinetics, Temperature};
use plant::{Command, Er, FieldResponse, FluidResponse, Model, Plant, State};

/// A rotor of 0.075 kg m2 in nothing but that fluid, without delay.
fn rotor(flow: FlowCurve) -> Model {
    let response = FluidResponse::Field(FieldResponse { flow: Some(flow), ..FieldResponse::default() });
    Model { er: Some(Er { response, ..Er::new(0.0704, 0.470, 0.0, 0.0) }), ..Model::new(0.075) }
}

fn speed_after(model: &Model, start_rad_s: f64, command: Command, t_s: f64) -> f64 {
    let mut plant = Plant::new(model, State::new(0.0, start_rad_s), 0.0).unwrap();
    plant.advance(&command, t_s).unwrap();
    plant.state().velocity
}

#[test]
fn a_shear_thinning_fluid_slows_the_rotor_by_its_closed_form() {
    // J w' = -k w^n with n = 1/2: sqrt(w) falls by k / 2J a second; 2 - 0.05 / 0.15 after one.
    let model = rotor(FlowCurve { consistency: 0.05, consistency_per_kv_mm: 0.0, exponent: 0.5 });
    let found = speed_after(&model, 4.0, Command::new(0.0, 0.0), 1.0);
    let exact = (2.0 - 0.05 / 0.15_f64).powi(2);
    // What the straight beginning takes away is of the size (0.002 / w)^2.
    assert!((found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
}

#[test]
fn yield_and_flow_balance_the_drive_at_the_speed_of_herschel_and_bulkley() {
    // T = a E^2 + b E + (k + k_E E) w^n at E = 2: 1.2216 + 0.5 sqrt(w); 2.2216 N m make 4 rad/s.
    let model = rotor(FLOW);
    let torque = 0.0704 * 4.0 + 0.470 * 2.0 + 1.0;
    let found = speed_after(&model, 0.1, Command::new(torque, 2.0), 20.0);
    assert!((found - 4.0).abs() < 1e-4, "{found}");
    let mut plant = Plant::new(&model, State::new(0.0, 4.0), 0.0).unwrap();
    plant.advance(&Command::new(torque, 2.0), 0.01).unwrap();
    assert!((plant.er_torque() - torque).abs() < 1e-4, "{}", plant.er_torque());
    // Below its yield nothing flows.
    assert_eq!(speed_after(&model, 0.0, Command::new(1.2, 2.0), 1.0), 0.0);
}

#[test]
fn an_exponent_of_one_is_viscous_friction() {
    let flow = FlowCurve { consistency: 0.2, consistency_per_kv_mm: 0.0, exponent: 1.0 };
    let viscous = Model { viscous: 0.2, ..field(|_| ()) };
    let apart = distance(&run(&field(|f| f.flow = Some(flow)), 800, 1), &run(&viscous, 800, 1));
    assert!(apart < 1e-10, "{apart:e}");
}

/// Field that acts after each of the commands, kV/mm, held for that long, s.
fn fields(model: &Model, commands: &[(f64, f64)]) -> Vec<f64> {
    let mut plant = Plant::new(model, State::default(), 0.0).unwrap();
    let mut now_s = 0.0;
    let mut after = |&(field_kv_mm, held_s): &(f64, f64)| {
        now_s += held_s;
        plant.advance(&Command::new(0.0, field_kv_mm), now_s).unwrap();
        let segment = plant.last_segment().unwrap();
        segment.fluid.at(segment.end_s - segment.start_s)
    };
    commands.iter().map(&mut after).collect()
}

#[test]
fn rise_and_fall_take_the_time_of_their_field() {
    // 4 ms at 1 kV/mm: a rise to 2 kV/mm takes 4 / 2^2 = 1 ms, a fall from there 4 / sqrt(2) ms.
    let model = field(|f| {
        (f.dead_time_s, f.rise_s, f.fall_s, f.kinetics) = (0.0, 0.004, 0.004, KINETICS);
    });
    let found = fields(&model, &[(2.0, 0.001), (2.0, 0.2), (0.5, 0.002), (0.0, 0.001), (1.0, 0.2), (1.5, 0.002)]);
    let fall_s = 0.004 / 2.0_f64.sqrt();
    let at_half = 0.5 + 1.5 * (-0.002 / fall_s).exp();
    let exact = [
        2.0 * (1.0 - (-1.0_f64).exp()),
        2.0,
        at_half,
        // The fall goes on at the pace it began with.
        at_half * (-0.001 / fall_s).exp(),
        1.0,
        1.0 + 0.5 * (1.0 - (-0.002 * 1.5_f64.powi(2) / 0.004).exp()),
    ];
    for (found, exact) in found.iter().zip(exact) {
        assert!((found - exact).abs() < 1e-12, "{found} {exact}");
    }
}

#[test]
fn weak_fields_count_as_the_weakest() {
    let model =
        field(|f| (f.dead_time_s, f.rise_s, f.kinetics) = (0.0, 0.001, Kinetics { rise_exponent: 1.0, ..KINETICS }));
    // 1 ms / 0.1 = 10 ms for every rise to less than 0.1 kV/mm.
    let [found] = fields(&model, &[(0.05, 0.01)])[..] else { panic!() };
    assert!((found - 0.05 * (1.0 - (-1.0_f64).exp())).abs() < 1e-14, "{found}");
}

#[test]
fn a_warm_fluid_yields_and_flows_less_each_by_its_own_law() {
    let temperature = Temperature { above_reference_k: 10.0, yield_per_k: 0.02, viscosity_per_k: 0.03 };
    let warm = rotor(FLOW).er.unwrap().at_temperature(&temperature).unwrap();
    let FluidResponse::Field(FieldResponse { flow: Some(flow), .. }) = warm.response else { panic!() };
    assert_eq!(warm.scale, (-0.2_f64).exp());
    let share = (-0.3_f64).exp();
    assert_eq!((flow.consistency, flow.consistency_per_kv_mm), (0.3 * share, 0.1 * share));
    let model = Model { er: Some(warm), ..Model::new(0.075) };
    let torque = 1.2216 * (-0.2_f64).exp() + share;
    let found = speed_after(&model, 0.1, Command::new(torque, 2.0), 30.0);
    assert!((found - 4.0).abs() < 1e-4, "{found}");
}

#[test]
fn an_amplifier_charges_the_electrodes_at_its_current() {
    // 1 mA into 1 nF are 1e6 V/s, over 0.5 mm 2000 kV/mm/s: 3 kV/mm in 1.5 ms.
    let electrode = Electrode { capacitance_f: 1e-9, current_a: 1e-3, gap_m: 5e-4 };
    let slew = electrode.slew_kv_mm_s().unwrap();
    assert!((slew - 2000.0).abs() < 1e-9, "{slew}");
    let model = field(|f| *f = FieldResponse { slew_kv_mm_s: Some(slew), ..FieldResponse::default() });
    for (found, exact) in fields(&model, &[(3.0, 0.001), (3.0, 0.001), (1.0, 0.0005)]).iter().zip([2.0, 3.0, 2.0]) {
        assert!((found - exact).abs() < 1e-9, "{found} {exact}");
    }
    let refused = Electrode { gap_m: 0.0, ..electrode }.slew_kv_mm_s().unwrap_err();
    assert!(refused.to_string().starts_with("er.electrode.gap_m = 0"), "{refused}");
}

#[test]
fn what_no_fluid_is_is_refused() {
    let refused = |model: Model| Plant::new(&model, State::default(), 0.0).unwrap_err().to_string();
    let thick = refused(rotor(FlowCurve { exponent: 1.5, ..FLOW }));
    assert_eq!(thick, "er.flow.exponent = 1.5: must be from 0.1 to 1");
    let negative = refused(rotor(FlowCurve { consistency: -1.0, ..FLOW }));
    assert!(negative.starts_with("er.flow.consistency = -1"), "{negative}");
    let kinetics = refused(field(|f| f.kinetics.fall_exponent = -0.5));
    assert_eq!(kinetics, "er.fall_exponent = -0.5: must be from 0 to 2");
    let mut spring = rotor(FLOW);
    if let Some(er) = &mut spring.er {
        er.preyield_stiffness = Some(200.0);
    }
    assert!(refused(spring).contains("left out where the fluid is a spring"));
    let hot = Temperature { above_reference_k: 1e6, yield_per_k: -1.0, viscosity_per_k: 0.0 };
    assert!(Er::new(1.0, 1.0, 0.0, 0.0).at_temperature(&hot).is_err());
}
