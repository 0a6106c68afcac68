//! The exported file for thrusters of gz-sim gives the forces of the library for a minute, by the
//! update of its Thruster system.
//!
//! The update is written from gz-sim 8, `src/systems/thruster/Thruster.cc` (`Configure`,
//! `OnCmdThrust`, `ThrustToAngularVec`, `AngularVelToThrust`, `PreUpdate`), commanded by force;
//! world and link forward-port-up.

use std::path::Path;

use crate::exported::quoted::assert_quoted;
use crate::exported::*;
use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::export::{ExportOptions, Target, export};
use hydrosysid::frame::Dof;
use nalgebra::{Vector3, Vector6};
use roxmltree::{Document, Node};

/// Defaults of the system.
const DIAMETER: f64 = 0.02;
const LIMIT: f64 = 1000.0;

/// `ThrusterPrivateData`, with the joint and the curve that the comment of the file states.
struct Plugin {
    coefficient: f64,
    density: f64,
    diameter: f64,
    least: f64,
    most: f64,
    thrust: f64,
    place: Vector3<f64>,
    axis: Vector3<f64>,
    /// Forward a, b, reverse a, b, dead band.
    curve: [f64; 5],
}

/// The numbers in a text, in order.
fn figures(text: &str) -> Vec<f64> {
    text.split(|c: char| c == ',' || c.is_whitespace()).filter_map(|word| word.parse().ok()).collect()
}

impl Plugin {
    fn configure(plugin: Node<'_, '_>) -> Plugin {
        let value = |name: &str, default: f64| plugin.children().find(|n| n.has_tag_name(name)).map_or(default, number);
        assert_eq!(plugin.attribute("filename"), Some("gz-sim-thruster-system"));
        assert!(child(plugin, "joint_name").text().is_some_and(|name| name.ends_with("_joint")));
        let comment = plugin.prev_siblings().find(Node::is_comment).and_then(|n| n.text()).expect("a comment");
        let (joint, curve) = comment.split_once("F = ").expect("joint and curve");
        let (place, axis) = joint.rsplit_once(": at ").expect("a place").1.split_once("axis").expect("an axis");
        let curve: [f64; 5] = figures(curve).try_into().expect("five numbers");
        let (most, least) = (value("max_thrust_cmd", LIMIT), value("min_thrust_cmd", -LIMIT));
        assert!(most >= least, "the system would take its own limits");
        Plugin {
            coefficient: value("thrust_coefficient", 1.0),
            density: value("fluid_density", 1000.0),
            diameter: value("propeller_diameter", DIAMETER),
            least,
            most,
            thrust: 0.0,
            place: Vector3::from_row_slice(&figures(place)),
            axis: Vector3::from_row_slice(&figures(axis)),
            curve,
        }
    }

    /// The force, N, that the comment of the file asks to publish for a command V.
    fn published(&self, command: f64) -> f64 {
        let [a, b, reverse_a, reverse_b, dead] = self.curve;
        let (a, b) = if command < 0.0 { (reverse_a, reverse_b) } else { (a, b) };
        let beyond = command.signum() * (command.abs() - dead).max(0.0);
        a * beyond * beyond.abs() + b * beyond
    }

    fn on_cmd_thrust(&mut self, force: f64) {
        self.thrust = force.clamp(self.least, self.most);
    }

    /// `ThrustToAngularVec`, rad/s.
    fn speed(&self) -> f64 {
        let scale = self.density * self.coefficient * self.diameter.powi(4);
        let speed = (self.thrust / scale).abs().sqrt();
        if self.thrust * self.coefficient > 0.0 { speed } else { -speed }
    }

    /// `AngularVelToThrust`, N.
    fn thrust_of(&self, speed: f64) -> f64 {
        self.coefficient * self.diameter.powi(4) * speed.abs() * speed * self.density
    }

    /// `AddWorldWrench` of `PreUpdate`, about the origin of the model.
    fn wrench(&self) -> Vector6<f64> {
        let force = self.axis.normalize() * self.thrust;
        let moment = self.place.cross(&force);
        Vector6::new(force[0], force[1], force[2], moment[0], moment[1], moment[2])
    }
}

/// Commands of the two thrusters at a step, which cross the dead band and exceed the limits.
fn commands(k: usize) -> [f64; 2] {
    let t = STEP * k as f64;
    [1.2 * (0.4 * t).sin(), 1.1 * (0.63 * t + 1.0).sin() - 0.1]
}

/// Wrenches of the simulator and of the library's thrusters over a minute.
fn moved(efficiency: &str, folder: &str) -> (Vec<Vector6<f64>>, Vec<Vector6<f64>>) {
    let path = thrusters(&Path::new(env!("CARGO_TARGET_TMPDIR")).join(folder), "boat", efficiency);
    let export = export(&path, Target::GazeboThrusters, &ExportOptions::default()).expect("it can be exported");
    let text = text(&export);
    let document = Document::parse(&text).expect("it is XML");
    let mut plugins: Vec<Plugin> =
        document.descendants().filter(|n| n.has_tag_name("plugin")).map(Plugin::configure).collect();
    assert_eq!(plugins.len(), 2);
    let read = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let bytes = std::fs::read(&path).expect("it was written");
    let campaign = CampaignFile::from_bytes(&bytes, &path, &read).expect("a campaign");
    let names: Vec<&str> = campaign.thrusters.iter().map(|t| t.name.as_str()).collect();
    let factor = campaign.efficiency.eta_inter.value(Dof::Surge, &names);
    let mut simulated = Vec::new();
    let mut own = Vec::new();
    for k in 0..(SECONDS / STEP) as usize {
        let mut total = Vector6::zeros();
        let mut wanted = Vector6::zeros();
        for ((plugin, thruster), command) in plugins.iter_mut().zip(&campaign.thrusters).zip(commands(k)) {
            plugin.on_cmd_thrust(plugin.published(command));
            let shaft = plugin.thrust_of(plugin.speed());
            assert!((shaft - plugin.thrust).abs() < 1e-9 * LIMIT, "blades at the speed of the thrust give it");
            total += plugin.wrench();
            wanted += thruster.unit_wrench() * thruster.curve().force(command) * factor;
        }
        simulated.push(turn(&total));
        own.push(wanted);
    }
    (simulated, own)
}

#[test]
fn the_system_gives_the_thrust_of_the_campaign() {
    let (simulated, own) = moved("", "gazebo-thrusters");
    // the file has numbers of eleven digits; both sides limit commands beyond `max`
    assert_quoted(Target::GazeboThrusters, &simulated, &own);
}

#[test]
fn losses_by_interaction_are_in_the_thrust() {
    let eta = "[efficiency]\neta_inter = { surge = 0.8, sway = 0.8, heave = 0.8, roll = 0.8, pitch = 0.8, yaw = 0.8 }";
    let (simulated, own) = moved(eta, "gazebo-thrusters-losses");
    let apart = simulated.iter().zip(&own).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
    let most = simulated.iter().map(|w| w[0]).fold(0.0, f64::max);
    assert!(apart < 1e-8 && most > 40.0 && most < 0.8 * 90.0, "{apart} {most}");
}
