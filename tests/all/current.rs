//! Currents: comparison with Fossen's equation written with nalgebra, and with the same motion
//! relative to the water.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use hydrosysid::chain::{Attitude, Available, StateId, assemble};
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::{Coriolis, Effect, Family, ParameterKind, catalogue};
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model, places_of};
use hydrosysid::run::{Run, Signal};
use hydrosysid::simulate::{Track, free_run};
use hydrosysid::symbolic::{Graph, Leaf};
use nalgebra::{Matrix3, Matrix6, Quaternion, Rotation3, UnitQuaternion, Vector3, Vector6};

/// A steady current north and east, m/s.
const WATER: [f64; 2] = [0.2, -0.3];

fn set_water(model: &mut Model, water: [f64; 2]) {
    for (symbol, value) in ["V_N", "V_E"].iter().zip(water) {
        let p = model.parameter("current", symbol).expect("the model has a current");
        model.parameters[p].value = value;
    }
}

/// A rigid body of 500 kg whose centre of gravity is off the origin, and its added mass.
struct Body {
    mass: f64,
    centre: Vector3<f64>,
    inertia: Matrix3<f64>,
    added: Matrix6<f64>,
    linear: Vector6<f64>,
    quadratic: Vector6<f64>,
}

impl Body {
    fn new() -> Body {
        let mut added = Matrix6::from_diagonal(&Vector6::new(60.0, 340.0, 420.0, 30.0, 95.0, 70.0));
        for (i, j, value) in [(1, 5, 25.0), (2, 4, -31.0), (0, 4, 12.0)] {
            (added[(i, j)], added[(j, i)]) = (value, value);
        }
        Body {
            mass: 500.0,
            centre: Vector3::new(0.06, -0.02, 0.05),
            inertia: Matrix3::new(110.0, 1.0, -2.0, 1.0, 160.0, 3.0, -2.0, 3.0, 170.0),
            added,
            linear: Vector6::new(30.0, 60.0, 70.0, 15.0, 20.0, 18.0),
            quadratic: Vector6::new(150.0, 400.0, 450.0, 60.0, 90.0, 80.0),
        }
    }

    /// M_RB, Fossen (2021), eq. 3.49.
    fn rigid(&self) -> Matrix6<f64> {
        let s = self.mass * self.centre.cross_matrix();
        let mut m = Matrix6::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * self.mass));
        m.fixed_view_mut::<3, 3>(0, 3).copy_from(&-s);
        m.fixed_view_mut::<3, 3>(3, 0).copy_from(&s);
        m.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.inertia);
        m
    }

    /// C_RB(ν)ν of the rigid body: force and moment about the origin by the Newton-Euler equations.
    fn rigid_coriolis(&self, nu: &Vector6<f64>) -> Vector6<f64> {
        let (v, omega) = (nu.fixed_rows::<3>(0).into_owned(), nu.fixed_rows::<3>(3).into_owned());
        let force = self.mass * omega.cross(&(v + omega.cross(&self.centre)));
        let moment = self.mass * self.centre.cross(&omega.cross(&v)) + omega.cross(&(self.inertia * omega));
        Vector6::from_iterator(force.iter().chain(moment.iter()).copied())
    }

    /// C_A(ν)ν of the added mass: Fossen (2021), theorem 3.2.
    fn added_coriolis(&self, nu: &Vector6<f64>) -> Vector6<f64> {
        let pi = self.added * nu;
        let (p, l) = (pi.fixed_rows::<3>(0).into_owned(), pi.fixed_rows::<3>(3).into_owned());
        let (v, omega) = (nu.fixed_rows::<3>(0).into_owned(), nu.fixed_rows::<3>(3).into_owned());
        let (force, moment) = (omega.cross(&p), v.cross(&p) + omega.cross(&l));
        Vector6::from_iterator(force.iter().chain(moment.iter()).copied())
    }

    /// ν̇ from M_RB ν̇ + C_RB(ν)ν + M_A ν̇_r + C_A(ν_r)ν_r + D(ν_r)ν_r = τ, with separate dry and added mass.
    fn acceleration(&self, nu: &Vector6<f64>, angles: [f64; 3], water: [f64; 2], tau: &Vector6<f64>) -> Vector6<f64> {
        let r = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let drift = r.transpose() * Vector3::new(water[0], water[1], 0.0);
        let turning = -nu.fixed_rows::<3>(3).cross(&drift);
        let six = |v: Vector3<f64>| Vector6::new(v[0], v[1], v[2], 0.0, 0.0, 0.0);
        let nu_r = nu - six(drift);
        let drag = nu_r.zip_zip_map(&self.linear, &self.quadratic, |v, d, q| (d + q * v.abs()) * v);
        let force = tau - drag - self.rigid_coriolis(nu) - self.added_coriolis(&nu_r) + self.added * six(turning);
        (self.rigid() + self.added).lu().solve(&force).expect("a positive definite inertia")
    }

    /// The same body as a model, which has M_RB + M_A only.
    fn model(&self) -> Model {
        let effects = ["inertia", "added_mass_coupling", "linear_drag", "quadratic_drag", "current"];
        let rows =
            ["coriolis_surge", "coriolis_sway", "coriolis_heave", "coriolis_roll", "coriolis_pitch", "coriolis_yaw"];
        let all = [&effects[..], &rows[..]].concat();
        let mut model = Model::with_effects(&Dof::ALL, Coriolis::Tied, &all).expect("ids of the catalogue");
        let m = self.rigid() + self.added;
        for i in Dof::ALL {
            let k = i.index();
            assert!(model.set(&format!("inertia@{i}"), m[(k, k)]));
            assert!(model.set(&format!("linear_drag@{i}"), self.linear[k]));
            assert!(model.set(&format!("quadratic_drag@{i}"), self.quadratic[k]));
            for j in Dof::ALL.into_iter().filter(|j| *j != i) {
                // the model has both m_ij and m_ji, and each adds its value to both rows
                assert!(model.set(&format!("added_mass_coupling@{i}:{j}"), 0.5 * m[(k, j.index())]));
            }
        }
        model
    }
}

/// In six degrees of freedom, with a centre of gravity off the origin and any attitude, the
/// accelerations of the model, which has the sum M_RB + M_A only, are those of separate M_RB and
/// M_A. The tolerance is for the rounding of a 6 by 6 elimination.
#[test]
fn inertia_acts_on_the_velocity_through_the_water() {
    let body = Body::new();
    let mut model = body.model();
    let nu = Vector6::new(0.5, -0.2, 0.1, 0.15, -0.1, 0.3);
    let tau = Vector6::new(150.0, -60.0, 30.0, 5.0, -8.0, 40.0);
    for (angles, water) in [([0.0, 0.0, 0.7], WATER), ([0.4, -0.9, 2.5], WATER), ([-1.1, 0.3, -0.2], [0.0; 2])] {
        set_water(&mut model, water);
        let graph = Graph::new();
        let channels = Dof::ALL.iter().map(|dof| dof.force().to_string()).collect();
        let equations = assemble(&graph, &model, &Available { channels, ..Available::default() });
        let values = model.values();
        let read = |leaf: Leaf| match leaf {
            Leaf::State(k) if k < 6 => nu[usize::from(k)],
            Leaf::State(k) => angles[usize::from(k) - 9],
            Leaf::Parameter(p) => values[usize::from(p)],
            Leaf::Input(k) => {
                let name = &equations.inputs[usize::from(k)];
                Dof::ALL.iter().position(|dof| dof.force() == name).map_or(0.0, |i| tau[i])
            }
            _ => panic!("nothing is read from a log"),
        };
        let exact = body.acceleration(&nu, angles, water, &tau);
        for (k, exact) in exact.iter().enumerate() {
            let found = equations.states[k].rate.evaluate(&read);
            assert!((found - exact).abs() < 1e-12, "{}: {found}, by hand {exact}", Dof::ALL[k]);
        }
    }
}

/// A vehicle that drifts with the water and turns is not accelerated: its velocity over ground
/// remains that of the water.
#[test]
fn a_turning_vehicle_drifts_with_the_water() {
    let effects = ["inertia", "linear_drag", "coriolis_surge", "coriolis_sway", "coriolis_yaw", "current"];
    let mut model = Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied, &effects).unwrap();
    for (name, value) in [("inertia@surge", 800.0), ("inertia@sway", 600.0), ("inertia@yaw", 190.0)] {
        assert!(model.set(name, value));
    }
    set_water(&mut model, WATER);
    let time: Arc<[f64]> = (0..=400).map(|k| 0.05 * f64::from(k)).collect();
    let mut run = Run::default();
    for name in ["tau_u", "tau_v", "tau_r", "u", "v", "r", "psi"] {
        run.signals.insert(name.into(), Signal::new(time.clone(), vec![0.0; time.len()]));
    }
    let rows = sail(&model, &run, Attitude::Angles, &|id| match id {
        StateId::Velocity(Dof::Surge) => WATER[0],
        StateId::Velocity(Dof::Sway) => WATER[1],
        StateId::Velocity(Dof::Yaw) => 0.4,
        _ => 0.0,
    });
    for row in rows {
        let [u, v] = [Dof::Surge, Dof::Sway].map(|dof| row[&StateId::Velocity(dof)]);
        let over_ground = rotation(&row) * Vector3::new(u, v, 0.0);
        let error = (over_ground - Vector3::new(WATER[0], WATER[1], 0.0)).norm();
        // at 0.4 rad/s and steps of 5 ms, rounding is larger than the error of the scheme
        assert!(error < 1e-10, "{error}");
    }
}

type Row = BTreeMap<StateId, f64>;

/// The states at every sample of a run.
fn sail(model: &Model, run: &Run, attitude: Attitude, start: &dyn Fn(StateId) -> f64) -> Vec<Row> {
    let channels: BTreeSet<String> = run.signals.keys().cloned().collect();
    let available = Available { channels: channels.clone(), position: true, attitude, ..Available::default() };
    let dynamics = Dynamics::compile(model, &available, &channels, &[]);
    let theta = model.values();
    let track = Track::new(run, 0, &dynamics, &theta, Interpolation::Linear, 0.005).expect("a whole run");
    let x0: Vec<f64> = dynamics.states.iter().map(|id| start(*id)).collect();
    let result = free_run(&dynamics, &track, &theta, &x0, 0, track.time.len() - 1);
    let row = |x: &[f64]| dynamics.states.iter().copied().zip(x.iter().copied()).collect();
    result.states.chunks(dynamics.states.len()).map(row).collect()
}

/// Rotation from body to earth axes.
fn rotation(row: &Row) -> Rotation3<f64> {
    let part = |k: u8| row.get(&StateId::Quaternion(k)).copied();
    if let (Some(w), Some(x), Some(y), Some(z)) = (part(0), part(1), part(2), part(3)) {
        return UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix();
    }
    let angle = |dof: Dof| row.get(&StateId::Position(dof)).copied().unwrap_or(0.0);
    Rotation3::from_euler_angles(angle(Dof::Roll), angle(Dof::Pitch), angle(Dof::Yaw))
}

/// A model with every effect of the catalogue at small values, except sensors and effects that are
/// tied to the ground.
fn everything(coriolis: Coriolis) -> Model {
    let all = catalogue(coriolis);
    // effects with a value for each run would replace those with one value for all, and have the
    // same formulas
    let stands = |e: &&Arc<dyn Effect>| !e.tied_to_ground() && e.same_in_all_runs().is_none();
    let known = all.iter().filter(|e| e.about().family != Family::Sensor).filter(stands);
    let mut model = Model::with_effects(&Dof::ALL, coriolis, &[]).expect("no effects");
    model.weight = 1854.1;
    for effect in known {
        for place in places_of(effect.as_ref(), &Dof::ALL) {
            model.add(effect.clone(), place).expect("each place once");
        }
    }
    for p in 0..model.parameters.len() {
        let spec = &model.parameters[p].spec;
        let of_run = spec.per_run;
        model.parameters[p].value = match (&spec.kind, spec.name.as_str()) {
            (_, "m_u" | "m_v" | "m_w") => 500.0,
            (_, name) if name.starts_with("I_") => 200.0,
            (_, name) if name.starts_with("d_") => 80.0,
            (ParameterKind::Linear, _) => spec.neutral + 0.01 * (1.0 + (p as f64 * 0.7).sin()),
            (ParameterKind::Shape { grid, .. }, _) => grid[0] + 0.1,
        };
        if of_run {
            model.parameters[p].per_run = vec![model.parameters[p].value];
        }
    }
    model
}

/// The motion in a current is the motion in still water plus the drift: over twenty seconds the
/// states agree to 1e-8, with Euler angles and with a quaternion. The error of the method at steps
/// of 5 ms is about 1e-10.
#[test]
fn law_galilei_of_a_whole_motion() {
    let time: Arc<[f64]> = (0..=200).map(|k| 0.1 * f64::from(k)).collect();
    let mut run = Run::default();
    let mut insert = |name: &str, value: &dyn Fn(f64) -> f64| {
        run.signals.insert(name.into(), Signal::new(time.clone(), time.iter().map(|t| value(*t)).collect::<Vec<_>>()));
    };
    for (i, dof) in Dof::ALL.into_iter().enumerate() {
        let size = if dof.is_rotation() { 12.0 } else { 90.0 };
        insert(dof.force(), &|t| size * (t * (0.3 + 0.1 * i as f64) + i as f64).sin());
        insert(dof.velocity(), &|_| 0.0);
        insert(dof.position(), &|_| 0.0);
        insert(&format!("KC_{}", dof.velocity()), &|_| 0.3);
    }
    insert("supply_voltage_ratio", &|t| 1.0 - 0.002 * t);
    let water = Vector3::new(WATER[0], WATER[1], 0.0);
    let angles = UnitQuaternion::from_euler_angles(0.3, -0.4, 1.2);
    for (coriolis, attitude) in
        [(Coriolis::Tied, Attitude::Angles), (Coriolis::Free, Attitude::Angles), (Coriolis::Tied, Attitude::Quaternion)]
    {
        let (mut moving, mut still) = (everything(coriolis), everything(coriolis));
        set_water(&mut moving, WATER);
        set_water(&mut still, [0.0; 2]);
        let start = |id: StateId, drift: Vector3<f64>| match id {
            StateId::Velocity(dof) if !dof.is_rotation() => 0.3 + drift[dof.index()],
            StateId::Velocity(_) => 0.1,
            StateId::Position(dof) if dof.is_rotation() => [0.3, -0.4, 1.2][dof.index() - 3],
            StateId::Quaternion(k) => [angles.w, angles.i, angles.j, angles.k][usize::from(k)],
            _ => 0.0,
        };
        let from_ground = sail(&moving, &run, attitude, &|id| start(id, angles.inverse() * water));
        let from_water = sail(&still, &run, attitude, &|id| start(id, Vector3::zeros()));
        let turned = angles.to_rotation_matrix().angle_to(&rotation(from_water.last().unwrap()));
        assert!(turned > 0.3, "the vehicle has to turn for the law to say anything: {turned} rad");
        for ((t, a), b) in run.signals["u"].time().iter().zip(&from_ground).zip(&from_water) {
            let drift = rotation(b).inverse() * water;
            for (id, value) in b {
                let expected = match *id {
                    StateId::Velocity(dof) if !dof.is_rotation() => value + drift[dof.index()],
                    StateId::Position(dof) if !dof.is_rotation() => value + water[dof.index()] * t,
                    _ => *value,
                };
                assert!((a[id] - expected).abs() < 1e-8, "{coriolis:?} {id:?} at {t} s: {} for {expected}", a[id]);
            }
        }
    }
}
