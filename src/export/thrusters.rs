//! Thrusters of a campaign: gz-sim's Thruster system, and tables and parameters for ArduSub.
//!
//! ```text
//! gz-sim: T = k_T ρ D⁴ n²        the command is a force, N; the blade speed n follows from it
//! ArduSub: pwm = 1500 + d (max − 1500) for d > 0, 1500 + d (1500 − min) for d < 0        d: demand, −1 … 1
//! ```
//!
//! ArduSub assumes that thrust is proportional to the demand (`AP_Motors6DOF::calc_thrust_to_pwm`);
//! the file tabulates the true thrust of a demand beside it. Sources: gz-sim, `Thruster.hh` (8);
//! ArduPilot, `AP_Motors6DOF.cpp` (4.5).

use std::fmt::Write;
use std::path::Path;

use super::body::turned_place;
use super::header::{Bounds, one_line};
use super::number::{number, numbers};
use super::xml::Xml;
use super::{Export, ExportError, ExportOptions, Target, codes, losses, version};
use crate::campaign::file::CampaignFile;
use crate::finding::Finding;
use crate::thrust::thruster::Thruster;

pub(super) fn export(
    path: &Path,
    campaign: &CampaignFile,
    target: Target,
    options: &ExportOptions,
) -> Result<Export, ExportError> {
    if campaign.thrusters.is_empty() {
        return Err(ExportError::NoThruster(path.to_path_buf()));
    }
    let mut findings = version::check(target, options)?;
    let gain = |t| losses::gain(campaign, t, options);
    let gains: Vec<f64> = campaign.thrusters.iter().map(gain).collect::<Result<_, _>>()?;
    let mut head = vec![
        format!(
            "{}: written by hydrosysid {} from {}",
            if campaign.vehicle.name.is_empty() { "a vehicle" } else { &campaign.vehicle.name },
            env!("CARGO_PKG_VERSION"),
            path.display()
        ),
        format!("Target: {} ({})", target.name(), target.version()),
    ];
    if gains.iter().any(|gain| (gain - 1.0).abs() > 1e-12) {
        let told = losses::named(&campaign.efficiency);
        head.push(format!(
            "Losses of thrust are in the curves: {told}; factor of each thruster {}",
            numbers(&gains, ", ")
        ));
    } else if options.acting {
        head.push("Curves of bollard pull: losses of thrust are not included".into());
    }
    head.extend(bounds(target).lines());
    let bytes = match target {
        Target::GazeboThrusters => gazebo(head, campaign, &gains, &mut findings),
        _ => ardusub(&head, campaign, &gains, &mut findings).into_bytes(),
    };
    let warnings = findings;
    Ok(Export { format: 1, target, version: target.version(), lost: Vec::new(), warnings, bytes })
}

fn bounds(target: Target) -> Bounds<'static> {
    match target {
        Target::GazeboThrusters => Bounds {
            limits: "steady thrust at bollard pull; no lag of the rotor, no supply voltage",
            stability: "the thrust has no state of its own; the spin of the blades, which gives no thrust, is stable while \
                        p_gain x step is below twice their inertia (kg m2)",
        },
        _ => Bounds {
            limits: "steady thrust at bollard pull, between the pulses of full command",
            stability: "the file moves nothing; gains of the controllers are not included",
        },
    }
}

fn gazebo(mut head: Vec<String>, campaign: &CampaignFile, gains: &[f64], findings: &mut Vec<Finding>) -> Vec<u8> {
    head.push("Commands are forces in N along the axis of the joint; positions and axes forward-port-up, m".into());
    head.push(
        "thrust_coefficient and propeller_diameter only set the speed of the blades: enter those of your propeller"
            .into(),
    );
    let mut xml = Xml::new(&head);
    let name = if campaign.vehicle.name.is_empty() { "vehicle" } else { &campaign.vehicle.name };
    xml.open("sdf", &[("version", "1.9")]);
    xml.open("model", &[("name", name)]);
    for (thruster, gain) in campaign.thrusters.iter().zip(gains) {
        let curve = thruster.curve();
        let (least, most) = curve.range();
        let axis = turned_place(thruster.direction().into());
        xml.comment(&[
            format!(
                "{}: at {}, axis {}",
                thruster.name,
                numbers(&turned_place(thruster.position), " "),
                numbers(&axis, " ")
            ),
            format!(
                "F = a V'|V'| + b V', forward a {} b {}, reverse a {} b {}, V' = V minus the dead band {}",
                number(gain * curve.forward.a),
                number(gain * curve.forward.b),
                number(gain * curve.reverse.a),
                number(gain * curve.reverse.b),
                number(curve.deadband)
            ),
        ]);
        xml.open("plugin", &[("filename", "gz-sim-thruster-system"), ("name", "gz::sim::systems::Thruster")]);
        xml.leaf("namespace", name);
        xml.leaf("joint_name", &format!("{}_joint", thruster.name));
        xml.leaf("fluid_density", &number(campaign.water.density));
        xml.leaf("thrust_coefficient", "1");
        if most.is_finite() && least.is_finite() {
            xml.leaf("max_thrust_cmd", &number(gain * most));
            xml.leaf("min_thrust_cmd", &number(gain * least));
        } else {
            let text = format!("thruster {:?} has no `max`: the simulator limits it to its own 1000 N", thruster.name);
            findings.push(Finding::new(&codes::PULSE, text));
        }
        xml.close();
    }
    xml.finish()
}

/// Demands in the table.
const DEMANDS: [f64; 9] = [-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0];

/// Pulse width at which ArduSub assumes no thrust, µs.
const NEUTRAL: f64 = 1500.0;

/// Pulse widths at full reverse and full forward of a thruster, µs, the lower one first; and
/// whether it runs in reverse direction.
fn ends(thruster: &Thruster) -> Option<(f64, f64, bool)> {
    let (neutral, span, max) = (thruster.neutral?, thruster.span?, thruster.max?);
    let reach = (span * max).abs();
    Some((neutral - reach, neutral + reach, span < 0.0))
}

fn ardusub(head: &[String], campaign: &CampaignFile, gains: &[f64], findings: &mut Vec<Finding>) -> String {
    let mut text: String = head.iter().map(|line| format!("# {}\n", one_line(line))).collect();
    text +=
        "# A parameter file (name,value); lines with # are for people. Motor n is the n-th [[thruster]]: check the\n";
    text += "# order and MOT_n_DIRECTION against the frame before arming.\n";
    let known: Vec<(f64, f64, bool)> = campaign.thrusters.iter().filter_map(ends).collect();
    if !known.is_empty() {
        let least = known.iter().map(|e| e.0).fold(f64::INFINITY, f64::min);
        let most = known.iter().map(|e| e.1).fold(f64::NEG_INFINITY, f64::max);
        let _ = writeln!(text, "MOT_PWM_MIN,{}\nMOT_PWM_MAX,{}", number(least.round()), number(most.round()));
        for (n, thruster) in campaign.thrusters.iter().enumerate() {
            if let Some((.., reverse)) = ends(thruster) {
                let _ = writeln!(text, "MOT_{}_DIRECTION,{}", n + 1, if reverse { -1 } else { 1 });
            }
        }
        text += &tables(campaign, gains, (least, most), findings);
    }
    for thruster in campaign.thrusters.iter().filter(|t| ends(t).is_none()) {
        let told =
            format!("thruster {:?} has no `neutral`, `span` or `max`: its pulse widths are not known", thruster.name);
        let _ = writeln!(text, "# {told}");
        findings.push(Finding::new(&codes::PULSE, told));
    }
    text
}

/// True thrust beside the proportional thrust that ArduSub assumes.
fn tables(campaign: &CampaignFile, gains: &[f64], (least, most): (f64, f64), findings: &mut Vec<Finding>) -> String {
    let mut text = String::new();
    for (thruster, gain) in campaign.thrusters.iter().zip(gains) {
        let Some((_, _, reverse)) = ends(thruster) else { continue };
        let _ = writeln!(text, "# {}: demand, pulse us, thrust N, proportional N", one_line(&thruster.name));
        let curve = thruster.curve();
        let pulse = |d: f64| NEUTRAL + d * if d > 0.0 { most - NEUTRAL } else { NEUTRAL - least };
        let force = |d: f64| {
            // MOT_n_DIRECTION mirrors the demand of a thruster that runs in reverse direction
            let mirrored = if reverse { pulse(-d) } else { pulse(d) };
            thruster.command_of_pulse(mirrored).map_or(f64::NAN, |v| gain * curve.force(v))
        };
        let full = |d: f64| d.abs() * force(d.signum());
        let mut worst: f64 = 0.0;
        for d in DEMANDS {
            let (own, straight) = if d == 0.0 { (force(0.0), 0.0) } else { (force(d), full(d)) };
            worst = worst.max((own - straight).abs() / force(1.0).abs().max(force(-1.0).abs()));
            let shown = if reverse { pulse(-d) } else { pulse(d) };
            let _ = writeln!(text, "#   {}, {}, {own:.2}, {straight:.2}", number(d), number(shown.round()));
        }
        if worst > 0.05 {
            let told = format!(
                "thruster {:?}: its thrust differs from a straight line of the demand by up to {:.0} % of full thrust, and ArduSub has no curve for it",
                thruster.name,
                100.0 * worst
            );
            findings.push(Finding::new(&codes::CURVE_LOST, told));
        }
    }
    text
}
