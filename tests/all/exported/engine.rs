//! A physics engine like those of simulators: one rigid body, forces of each step from the state
//! before it, semi-implicit Euler. World z up, body forward-port-up, as in Gazebo; commands and
//! results forward-starboard-down.

use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3, Vector6};

use super::turn;

/// Standard gravity of the tests, m/s².
pub const GRAVITY: f64 = 9.81;

/// The rigid body of a link, forward-port-up.
pub struct Link {
    pub mass: f64,
    /// Centre of mass from the origin of the link, m.
    pub centre: Vector3<f64>,
    /// Inertia about the centre of mass, kg·m².
    pub inertia: Matrix3<f64>,
    /// M_A about the origin of the link, for an engine that adds it to the inertia of the link.
    pub fluid: Matrix6<f64>,
}

/// State that a plugin gets at a step, forward-port-up.
pub struct Seen {
    /// Velocity of the origin of the link, body axes.
    pub nu: Vector6<f64>,
    /// Rotation from body to world.
    pub attitude: Rotation3<f64>,
    pub step: f64,
}

/// Forces of a plugin in body axes, at the origin of the link and at the centre of mass.
#[derive(Default)]
pub struct Forces {
    pub at_origin: Vector6<f64>,
    pub at_centre: Vector6<f64>,
}

fn skew(a: Vector3<f64>) -> Matrix3<f64> {
    a.cross_matrix()
}

impl Link {
    /// M_RB about the origin of the link.
    fn rigid(&self) -> Matrix6<f64> {
        let (m, s) = (self.mass, skew(self.centre));
        let mut rigid = Matrix6::zeros();
        rigid.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(m);
        rigid.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-m * s));
        rigid.fixed_view_mut::<3, 3>(3, 0).copy_from(&(m * s));
        rigid.fixed_view_mut::<3, 3>(3, 3).copy_from(&(self.inertia - m * s * s));
        rigid
    }

    /// Velocities every `every` seconds under `command` (forward-starboard-down, at the origin of
    /// the link) and a plugin.
    pub fn run(
        &self,
        [step, every, seconds]: [f64; 3],
        command: &dyn Fn(f64) -> Vector6<f64>,
        plugin: &mut dyn FnMut(&Seen) -> Forces,
    ) -> Vec<Vector6<f64>> {
        let inertia = self.rigid() + self.fluid;
        let inverse = inertia.try_inverse().expect("the inertia is regular");
        let mut nu = Vector6::zeros();
        let mut attitude = Rotation3::identity();
        let mut path = vec![nu];
        let steps = (every / step).round() as usize;
        for k in 0..(seconds / step).round() as usize {
            let forces = plugin(&Seen { nu, attitude, step });
            let centre = forces.at_centre;
            let lift = self.centre.cross(&Vector3::new(centre[0], centre[1], centre[2]));
            let down = attitude.inverse() * Vector3::new(0.0, 0.0, -self.mass * GRAVITY);
            let tip = self.centre.cross(&down);
            let mut total = turn(&command(step * k as f64)) + forces.at_origin + centre;
            total += Vector6::new(down[0], down[1], down[2], tip[0] + lift[0], tip[1] + lift[1], tip[2] + lift[2]);
            nu += step * (inverse * (total + super::coriolis(&inertia, &nu)));
            attitude *= Rotation3::new(step * Vector3::new(nu[3], nu[4], nu[5]));
            if (k + 1) % steps == 0 {
                path.push(turn(&nu));
            }
        }
        path
    }
}

/// Root mean square difference of each velocity, u to r, over the root mean square of the velocity.
pub fn differences(path: &[Vector6<f64>], truth: &[Vector6<f64>]) -> Vec<f64> {
    assert_eq!(path.len(), truth.len());
    let share = |i: usize| {
        let size: f64 = truth.iter().map(|nu| nu[i].powi(2)).sum();
        let apart: f64 = path.iter().zip(truth).map(|(a, b)| (a[i] - b[i]).powi(2)).sum();
        if size > 0.0 { (apart / size).sqrt() } else { 0.0 }
    };
    (0..6).map(share).collect()
}

/// Asserts that the difference of every velocity is below `share` of its root mean square.
pub fn assert_within(path: &[Vector6<f64>], truth: &[Vector6<f64>], share: f64) {
    let worst = differences(path, truth);
    println!("differences of u v w p q r: {worst:.5?}");
    assert!(worst.iter().all(|d| *d < share), "apart by {worst:.4?}");
}
