//! Laws of mechanics that the equations of motion must obey.

use hydrosysid_plant::attitude::{from_angles, rotation, turn};
use hydrosysid_plant::hydrodynamics::Hydrodynamics;
use hydrosysid_plant::integrate::integrate;
use hydrosysid_plant::plant::{Interval, Plant, STATES, State, nu_of, place, quaternion_of};
use hydrosysid_plant::random::Random;
use hydrosysid_plant::water::Current;
use hydrosysid_plant::{Campaign, Dof, Input, RandomForce, Vehicle};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// A state with these roll, pitch and yaw angles and this ν.
fn state(angles: [f64; 3], nu: [f64; 6]) -> State {
    let mut x = [0.0; STATES];
    x[place::QUATERNION..place::NU].copy_from_slice(&from_angles(angles));
    x[place::NU..place::LAG].copy_from_slice(&nu);
    x
}

/// State of `plant` after `seconds` from `x` with a constant command.
fn sail(plant: &Plant, x: State, seconds: f64, step: f64, command: &[f64]) -> State {
    let mut interval = Interval::quiet(0.0, seconds);
    for (slot, value) in interval.command.iter_mut().zip(command) {
        slot.0 = *value;
    }
    integrate(&plant.ready(), x, &interval, step, |_| {})
}

/// The heavy vehicle with a full symmetric, positive definite added mass matrix, and with the
/// centre of gravity off the origin on all axes.
fn coupled() -> Plant {
    let mut plant = Vehicle::named("heavy").expect("it exists").plant;
    let mut random = Random::new(3, 0);
    let added = plant.water.added_mass.diagonal();
    for i in 0..6 {
        for j in 0..i {
            let value = 0.12 * random.between(-1.0, 1.0) * (added[i] * added[j]).sqrt();
            (plant.water.added_mass[(i, j)], plant.water.added_mass[(j, i)]) = (value, value);
        }
    }
    plant.body.gravity_centre = Vector3::new(0.03, -0.02, 0.04);
    plant
}

/// The same vehicle without drag, neutrally buoyant, with both centres at one point.
fn ideal() -> Plant {
    let mut plant = coupled();
    plant.water = Hydrodynamics::ideal(plant.water.added_mass);
    plant.body.buoyancy = plant.body.weight;
    plant.body.buoyancy_centre = plant.body.gravity_centre;
    plant
}

const START: [f64; 6] = [0.7, -0.3, 0.4, 0.5, -0.6, 0.8];

/// Without drag, energy and momentum are constant. With steps of 1 ms the error of the method is about 1e-12.
#[test]
fn law_energy_and_momentum_are_kept_without_drag() {
    let plant = ideal();
    let matrix = plant.inertia();
    let kept = |x: &State| {
        let nu = nu_of(x);
        let momentum = matrix * nu;
        let r = rotation(quaternion_of(x));
        let linear = r * Vector3::new(momentum[0], momentum[1], momentum[2]);
        let angular =
            r * Vector3::new(momentum[3], momentum[4], momentum[5]) + Vector3::new(x[0], x[1], x[2]).cross(&linear);
        (0.5 * nu.dot(&momentum), linear, angular)
    };
    let start = state([0.4, -0.5, 1.2], START);
    let end = sail(&plant, start, 20.0, 1e-3, &[]);
    let ((e0, p0, l0), (e1, p1, l1)) = (kept(&start), kept(&end));
    assert!((nu_of(&end) - nu_of(&start)).amax() > 0.1, "it moves");
    assert!((e1 / e0 - 1.0).abs() < 1e-10, "{e0} {e1}");
    assert!((p1 - p0).amax() < 1e-9 * p0.norm() && (l1 - l0).amax() < 1e-8 * l0.norm(), "{p0} {p1} {l0} {l1}");
}

/// With drag the kinetic energy decreases from second to second.
#[test]
fn law_drag_takes_energy() {
    let mut plant = ideal();
    plant.water.linear = Matrix6::from_diagonal(&Vector6::repeat(1.0));
    plant.water.quadratic = Matrix6::from_diagonal(&Vector6::repeat(2.0));
    let matrix = plant.inertia();
    let energy = |x: &State| nu_of(x).dot(&(matrix * nu_of(x)));
    let mut x = state([0.4, -0.5, 1.2], START);
    for _ in 0..10 {
        let next = sail(&plant, x, 1.0, 0.01, &[]);
        assert!(energy(&next) < energy(&x));
        x = next;
    }
}

/// A body without water and torque moves as Euler's symmetric top: I₁ = I₂, so ω turns about z at
/// λ = (I₃ − I₁)/I₁ ω₃.
#[test]
fn law_a_body_without_torque_turns_as_eulers_top() {
    let mut plant = ideal();
    plant.water = Hydrodynamics::ideal(Matrix6::zeros());
    plant.body.gravity_centre = Vector3::zeros();
    plant.body.buoyancy_centre = Vector3::zeros();
    plant.body.inertia = Matrix3::from_diagonal(&Vector3::new(0.4, 0.4, 0.7));
    let end = nu_of(&sail(&plant, state([0.1, 0.2, 0.3], [0.0, 0.0, 0.0, 0.5, 0.0, 2.0]), 10.0, 2e-3, &[]));
    let turned = (0.7 - 0.4) / 0.4 * 2.0 * 10.0_f64;
    let expected = Vector3::new(0.5 * turned.cos(), 0.5 * turned.sin(), 2.0);
    assert!((Vector3::new(end[3], end[4], end[5]) - expected).amax() < 1e-9, "{end} {expected}");
}

/// The motion in a steady current is the motion in still water plus the drift of the current, with
/// all forces of the water and the body switched on. With steps of 2 ms the two differ by rounding
/// and the error of the method only, below 1e-8.
#[test]
fn law_of_galilei_in_six_degrees_of_freedom() {
    let mut still = coupled();
    let vehicle = Vehicle::named("heavy").expect("it exists");
    still.actuation.thrusters = vehicle.thrusters;
    for thruster in &mut still.actuation.thrusters {
        (thruster.lag, thruster.advance_loss) = (0.2, 0.2);
    }
    let water = &mut still.water;
    (water.linear[(1, 5)], water.quadratic[(5, 1)], water.mixed[(1, 5)]) = (2.0, 1.5, 3.0);
    water.cubic = [5.0; 6];
    water.asymmetry = [4.0, 3.0, 2.0, 0.1, 0.1, 0.1];
    water.three_halves = [2.0, 1.0, 1.0, 0.1, 0.1, 0.1];
    water.friction = [0.3, 0.2, 0.3, 0.02, 0.02, 0.02];
    water.memory = [(4.0, 1.0), (3.0, 2.0), (0.0, 1.0), (0.1, 1.0), (0.0, 1.0), (0.1, 2.0)];
    let flow = Vector3::new(0.4, -0.3, 0.1);
    let carried = Plant { current: Current::Steady(flow), ..still.clone() };
    let command = [0.6, 0.5, -0.4, -0.3, 0.2, -0.1, 0.15, 0.1];
    let (mut seen, angles) = (state([0.3, -0.4, 1.0], START), [0.3, -0.4, 1.0]);
    let drift = |x: &State| rotation(quaternion_of(x)).tr_mul(&flow);
    let over_ground = drift(&seen);
    let mut moved = state(angles, START);
    (0..3).for_each(|k| moved[place::NU + k] += over_ground[k]);
    for second in 1..=20 {
        seen = sail(&still, seen, 1.0, 2e-3, &command);
        moved = sail(&carried, moved, 1.0, 2e-3, &command);
        let mut expected = seen;
        let over_ground = drift(&seen);
        for k in 0..3 {
            expected[k] += flow[k] * f64::from(second);
            expected[place::NU + k] += over_ground[k];
        }
        let worst = expected.iter().zip(&moved).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-8, "after {second} s: {worst}");
    }
}

/// A body that drifts with the water and turns is not accelerated through it. With added mass
/// relative to the ground it would be pushed by more than 1 N, so the test above would find this
/// wrong equation.
#[test]
fn the_law_of_galilei_can_be_broken() {
    let mut plant = coupled();
    plant.current = Current::Steady(Vector3::new(0.4, 0.0, 0.0));
    // no drag, neutral balance, diagonal added mass: nothing may accelerate it through the water
    plant.water.linear = Matrix6::zeros();
    plant.water.quadratic = Matrix6::zeros();
    plant.body.gravity_centre = Vector3::zeros();
    plant.body.buoyancy = plant.body.weight;
    plant.body.buoyancy_centre = Vector3::zeros();
    plant.water.added_mass = Matrix6::from_diagonal(&plant.water.added_mass.diagonal());
    plant.moves = [true, true, false, false, false, true];
    let x = state([0.0; 3], [0.4, 0.0, 0.0, 0.0, 0.0, 0.5]);
    let end = sail(&plant, x, 3.0, 0.01, &[]);
    let through = nu_of(&end).fixed_rows::<3>(0) - rotation(quaternion_of(&end)).tr_mul(&Vector3::new(0.4, 0.0, 0.0));
    assert!(through.amax() < 1e-9, "{through}");
    // without M_A ν̇_c the force M_A (ω × RᵀV) would act, more than 1 N here
    assert!(plant.water.added_mass[(0, 0)] * 0.5 * 0.4 > 1.0);
}

/// The speed after many time constants is the root of b u + a u² = τ.
#[test]
fn law_terminal_speed_has_its_closed_form() {
    for name in ["laurs", "small"] {
        let vehicle = Vehicle::named(name).expect("it exists");
        let mut plant = vehicle.plant.clone();
        plant.moves = [true, true, false, false, false, false];
        for i in 0..2 {
            let (b, a, f) = (plant.water.linear[(i, i)], plant.water.quadratic[(i, i)], 0.5 * vehicle.rated[i]);
            let mut command = [0.0; 6];
            command[i] = f;
            let end = nu_of(&sail(&plant, state([0.0; 3], [0.0; 6]), 120.0, 0.01, &command));
            let expected = ((b * b + 4.0 * a * f).sqrt() - b) / (2.0 * a);
            assert!((end[i] / expected - 1.0).abs() < 1e-9, "{name}: {} {expected}", end[i]);
        }
    }
}

/// With sideslip to starboard (v > 0) while going ahead, the Munk moment −(m_v − m_u) u v turns a
/// vehicle with m_v > m_u to port, which increases the slip, and one with m_v < m_u to starboard.
#[test]
fn law_munk_moment_has_its_sign() {
    for name in ["laurs", "small"] {
        let mut plant = Vehicle::named(name).expect("it exists").plant;
        plant.moves = [true, true, false, false, false, true];
        let inertia = plant.inertia();
        let x = state([0.0; 3], [0.5, 0.1, 0.0, 0.0, 0.0, 0.0]);
        let rate = nu_of(&plant.ready().rates(0.0, &x, &Interval::quiet(0.0, 0.1)).state)[5];
        let expected = -(inertia[(1, 1)] - inertia[(0, 0)]) * 0.5 * 0.1 / inertia[(5, 5)];
        assert!((rate - expected).abs() < 1e-12, "{name}: {rate} {expected}");
        assert_eq!(rate < 0.0, name == "small");
        plant.coriolis[5] = 0.0;
        assert!(nu_of(&plant.ready().rates(0.0, &x, &Interval::quiet(0.0, 0.1)).state)[5].abs() < 1e-12);
    }
}

/// Ahead at half thrust with an initial sideslip of 0.001 m/s, the small vehicle has turned by more
/// than 0.5 rad after 20 s, LAURS by less than 0.01 rad.
#[test]
fn the_small_vehicle_is_directionally_unstable() {
    let turned = |name: &str| {
        let vehicle = Vehicle::named(name).expect("it exists");
        let mut plant = vehicle.plant.clone();
        plant.moves = [true, true, false, false, false, true];
        let x = state([0.0; 3], [0.3, 0.001, 0.0, 0.0, 0.0, 0.0]);
        let end = sail(&plant, x, 20.0, 0.01, &[0.5 * vehicle.rated[0]]);
        turn(quaternion_of(&end))
    };
    assert!(turned("small") > 0.5 && turned("laurs") < 0.01, "{} {}", turned("small"), turned("laurs"));
}

/// The righting moment brings the vehicle back to level, and the net buoyancy lifts it at the speed
/// at which drag balances it.
#[test]
fn restoring_rights_and_buoyancy_lifts() {
    let plant = Vehicle::named("heavy").expect("it exists").plant;
    let end = sail(&plant, state([0.5, -0.4, 0.0], [0.0; 6]), 60.0, 0.01, &[]);
    let r = rotation(quaternion_of(&end));
    assert!((r[(2, 2)] - 1.0).abs() < 1e-6 && end[2] < -1.0, "{} {}", r[(2, 2)], end[2]);
    let heave = nu_of(&end)[2];
    let (b, a) = (plant.water.linear[(2, 2)], plant.water.quadratic[(2, 2)]);
    // B − W = 2 N balances the drag of rising
    assert!((b * heave - a * heave * heave + 2.0).abs() < 1e-6, "{heave}");
    let norm: f64 = quaternion_of(&end).iter().map(|q| q * q).sum();
    assert!((norm - 1.0).abs() < 1e-14);
}

/// Halving the step changes no state by more than 1e-7, with a random force, held and linear
/// commands, losses with kinks and a delay that is no multiple of a period.
#[test]
fn law_half_the_step_changes_nothing() {
    let all = Dof::ALL;
    for (name, dofs) in [("laurs", &Dof::PLANE[..]), ("small", &Dof::PLANE[..]), ("heavy", &all[..])] {
        for input in [Input::Hold, Input::Linear] {
            let mut campaign = Campaign::new(Vehicle::named(name).expect("it exists"), dofs);
            (campaign.duration, campaign.input, campaign.runs) = (20.0, input, 8);
            campaign.force = RandomForce { share: 0.05, correlation: 0.3 };
            let actuation = &mut campaign.vehicle.plant.actuation;
            (actuation.delay, actuation.losses.lag) = (0.137, 0.21);
            actuation.losses.deadband = campaign.vehicle.rated.map(|f| 0.05 * f);
            actuation.losses.reverse = [0.2; 6];
            actuation.losses.advance = [0.1; 6];
            let coarse = campaign.sail().expect("it sails");
            campaign.step /= 2.0;
            let fine = campaign.sail().expect("it sails");
            let mut worst: f64 = 0.0;
            for (a, b) in coarse.logs.iter().zip(&fine.logs).filter(|(log, _)| log.kind != "zigzag") {
                for ((_, x), (_, y)) in a.truth.iter().zip(&b.truth) {
                    worst = x.iter().zip(y).map(|(x, y)| (x - y).abs()).fold(worst, f64::max);
                }
            }
            assert!(worst < 1e-7, "{name} {input:?}: {worst}");
        }
    }
}
