//! The text of the campaign, table by table.

use std::fmt::Write;

use super::commands::{self, Kind};
use super::degrees::{Chosen, is_steered};
use super::geometry::Full;
use super::held::{self, Commanded};
use super::quoted;
use super::reading::Understood;
use super::reading_options::{Common, table};
use super::{InitRequest, dives, drives, geometry, kinds, priors, roles};
use crate::campaign::steps_as_lines::goes_on;
use crate::campaign::vehicles::{KnownVehicle, with_thruster_lines, with_thruster_value};
use crate::campaign::{columns, forces};
use crate::check::fins;
use crate::effects::{Coriolis, CoriolisRow, Effect, EffectName, Place, catalogue, id};
use crate::frame::Dof;
use crate::log::options::LogOptions;
use crate::model::{name_of, places_of};
use crate::run::{Run, Signal, is_command};
use crate::tank::derived;
use crate::thrust::thruster::Thruster;
use crate::vehicle::Water;

/// First line of a campaign that `init` has written.
pub const HEAD: &str =
    "# A campaign of hydrosysid: one vehicle, its runs, and the model to fit. SI units. Lines that begin with";
/// How the comment of a log that was not read begins.
pub const NOT_READ: &str = "# not read: ";

/// The inputs of the text.
pub struct Draft<'a> {
    /// The request.
    pub request: &'a InitRequest,
    /// Reading options that the user has given.
    pub given: &'a LogOptions,
    /// The vehicle, with the reason if it was guessed.
    pub vehicle: Option<&'a (KnownVehicle, Option<String>)>,
    /// The logs.
    pub logs: &'a [Understood],
    /// Logs of each dive.
    pub dives: &'a [Vec<usize>],
}

/// The text of a campaign and the messages beside it.
pub struct Written {
    /// The whole text.
    pub text: String,
    /// Message that nothing moves under a command.
    pub idle: Option<String>,
    /// Degrees of freedom that are logged in part and not modelled, each with what is missing.
    pub left_out: Vec<String>,
}

impl Draft<'_> {
    /// Writes the whole text and the messages beside it.
    pub fn write(&self) -> Written {
        let thrusters = self.thruster_tables();
        let known = geometry::read(&thrusters);
        let chosen = Chosen::of(self.logs, &known);
        let mut text =
            format!("{HEAD}\n# `# guessed:` say what was guessed and why: check each of them.\nformat = 1\n");
        for guess in &self.request.learned.guessed {
            let _ = writeln!(text, "# guessed: {guess}");
        }
        text += &self.vehicle_table();
        text += &self.model_table(&chosen, &known);
        text += &thrusters;
        let common = self.common();
        text += &self.log_table(&common);
        text += "\n# What is known of a parameter beforehand:\n# [[parameter]]\n# effect = \"quadratic_drag@surge\"\n# value = 309.07\n# fixed = true   # or std = 20.0 as a prior, min = , max = ; or tie = \"quadratic_drag@sway\": one common unknown\n";
        text += &self.vehicle.map_or_else(String::new, |(known, _)| priors::of(known, &chosen.dofs));
        text += &self.mass_of_hull(&chosen);
        let roles = self.roles(&chosen.dofs);
        for (dive, role) in self.dives.iter().zip(roles) {
            text += &self.run_table(dive, role, &common);
        }
        Written { text: text + &self.not_placed(), idle: chosen.idle, left_out: chosen.left_out }
    }

    /// The prior on the surge inertia that sets the scale of masses and drags if the force is not
    /// known: the dry mass and 5 % of added mass.
    fn mass_of_hull(&self, chosen: &Chosen) -> String {
        let Some(mass) = self.mass_for_scale(chosen) else { return String::new() };
        let why = if chosen.pushed { "no force is known" } else { "the loss of thrust at the hull is not known" };
        // added mass over mass: 0.05 of the Mariner ship, 0.03 of a REMUS 100, 0.1 of an Otter
        format!(
            "\n# guessed: the scale of all masses and drags, as {why}: the added mass of a long hull is assumed to be \
             5 % of its mass\n[[parameter]]\neffect = {}\nvalue = {:.6e}\nstd = {:.2e}\n",
            quoted(&name_of(id::INERTIA, Place::at(Dof::Surge))),
            1.05 * mass,
            0.05 * mass
        )
    }

    /// The dry mass if it tells more of the scale than the thrust: no force is known, its curve is
    /// guessed, or the hull takes a part of it.
    fn mass_for_scale(&self, chosen: &Chosen) -> Option<f64> {
        self.request.facts.mass.filter(|_| (chosen.pushed || chosen.scaled) && self.vehicle.is_none())
    }

    /// The drag effects beside the quadratic ones. At nearly constant speed only the quadratic drag
    /// and the thrust can be seen in surge. A hull that fins steer is slender and moves ahead: its
    /// turns and its drift are damped by lift, in proportion to its speed.
    fn drags(&self, chosen: &Chosen, is_one_force: bool) -> Vec<String> {
        let steered: Vec<Dof> =
            self.logs.iter().filter_map(Understood::as_run).flat_map(|run| fins::steered(&run)).collect();
        let is_slender = self.vehicle.is_none() && chosen.dofs.contains(&Dof::Surge);
        let drag = |dof: &Dof| match *dof {
            Dof::Surge if is_one_force => None,
            dof if is_slender && steered.contains(&dof) => Some(name_of(id::MIXED_DRAG, Place::pair(dof, Dof::Surge))),
            dof => Some(name_of(id::LINEAR_DRAG, Place::at(dof))),
        };
        let each: Vec<String> = chosen.dofs.iter().filter_map(drag).collect();
        let is_plain = each.len() == chosen.dofs.len() && each.iter().all(|name| name.starts_with(id::LINEAR_DRAG));
        if is_plain { vec![id::LINEAR_DRAG.to_string()] } else { each }
    }

    /// Comments with the fields of a log of another format that the campaign does not read.
    fn not_placed(&self) -> String {
        let mut text = String::new();
        for (log, fields) in self.request.learned.not_placed.iter().filter(|(_, fields)| !fields.is_empty()) {
            let _ = writeln!(
                text,
                "\n# Not recognised, and not in {log}; `init … --log 'columns.NAME = \"STREAM:FIELD\"'` reads a field:"
            );
            for line in fields {
                let _ = writeln!(text, "#   {line}");
            }
        }
        text
    }

    /// `[vehicle]`, `[water]` and the other sections of a vehicle file; without one, the keys that
    /// the user is to fill in.
    fn vehicle_table(&self) -> String {
        let facts = &self.request.facts;
        let figures = [
            ("mass", facts.mass, "dry mass, kg"),
            ("volume", facts.volume, "displaced volume, m3"),
            ("weight", facts.weight, "weight in air, N"),
            ("buoyancy", facts.buoyancy, "buoyancy, N"),
            ("length", facts.length, "characteristic length, m; volume^(1/3) when absent"),
        ];
        let Some((known, why)) = self.vehicle else {
            let name = if facts.name.is_empty() { "vehicle" } else { &facts.name };
            let mut text = format!("\n[vehicle]\nname = {}\n", quoted(name));
            for (key, value, meaning) in figures {
                let _ = match value {
                    Some(value) => writeln!(text, "{key} = {value:?}   # {meaning}"),
                    None => writeln!(text, "# {key} =    # {meaning}"),
                };
            }
            return text
                + "\n[water]\ndensity = 1000.0   # kg/m3\nkinematic_viscosity = 1.004e-6   # m2/s, fresh water of 20 degrees\n";
        };
        let mut text = format!("\n# vehicle file: {}\n", known.id);
        if let Some(why) = why {
            let _ = writeln!(text, "# guessed: the vehicle: {why}");
        }
        for line in sections(&known.text, |name| !["thruster"].contains(&name)).lines() {
            let key = line.split('=').next().unwrap_or("").trim();
            let own = figures.iter().find(|(name, ..)| *name == key).and_then(|(_, value, _)| *value);
            match (own, key) {
                (Some(value), _) => drop(writeln!(text, "{key} = {value:?}")),
                (None, "name") if !facts.name.is_empty() => drop(writeln!(text, "name = {}", quoted(&facts.name))),
                _ => text = text + line + "\n",
            }
        }
        text
    }

    /// The `[[thruster]]` tables: those of the vehicle, else guessed ones if commands are logged;
    /// as comments if forces are logged, too.
    fn thruster_tables(&self) -> String {
        if let Some((known, _)) = self.vehicle {
            let mut text = sections(&known.text, |name| name == "thruster");
            for (k, _) in self.request.learned.directions.iter().enumerate().filter(|(_, d)| **d < 0) {
                let why = format!("the log's MOT_{}_DIRECTION = -1: this thruster runs in reverse", k + 1);
                text = with_thruster_value(&text, k, "span", |span| -span, &why);
            }
            for (k, neutral) in self.request.learned.neutral.iter().enumerate() {
                if let Some(neutral) = neutral {
                    let why = format!("the log's SERVOn_TRIM of thruster {} is where its output is at rest", k + 1);
                    text = with_thruster_value(&text, k, "neutral", |_| *neutral, &why);
                }
            }
            return format!("\n{}", self.with_pulses(&text));
        }
        let Some((log, signals)) = self.commands() else { return String::new() };
        let forced =
            self.logs.iter().any(|l| l.log.as_ref().is_some_and(|l| l.signals.keys().any(|n| n.starts_with("tau_"))));
        let Some(kind) = log.kind.filter(|_| !log.commands.is_empty() && !signals.is_empty()) else {
            return String::new();
        };
        let greatest = drives::greatest(&signals);
        let pulse = (kind == Kind::Pulse).then(|| self.pulses(&signals));
        let tables = geometry::tables(&log.commands, kind, greatest, &self.full_thrust(log.commands.len()), pulse);
        if forced {
            let commented: String =
                tables.lines().map(|line| format!("# {}\n", line.trim_start_matches("# "))).collect();
            return format!(
                "\n# The log has tau_*: thrusters are not needed. With these tables their commands would be used \
                 instead:\n{commented}"
            );
        }
        tables
    }

    /// The assumed full thrust of a thruster of unknown make: the drag of a hull at the greatest
    /// speed of the logs if fins steer a vehicle of known mass, else that of a T200.
    fn full_thrust(&self, thrusters: usize) -> Full {
        let (mass, water) = (self.request.facts.mass, Water::default());
        let speeds = self.logs.iter().filter_map(|l| l.log.as_ref()?.signals.get(Dof::Surge.velocity()));
        let fastest = speeds.flat_map(|s| s.values()).fold(0.0, |most: f64, u| most.max(*u));
        match mass.filter(|_| is_steered(self.logs) && fastest > 0.0) {
            Some(mass) => Full::of_hull(mass, fastest, water.density, thrusters),
            None => Full::T200,
        }
    }

    /// The log with the most commands, and the commands of all logs with the same columns: they are
    /// of one vehicle.
    fn commands(&self) -> Option<(&Understood, Vec<&Signal>)> {
        let log = self.logs.iter().filter(|l| l.log.is_some()).max_by_key(|l| l.commands.len())?;
        let alike = self.logs.iter().filter(|l| drives::headers(l) == drives::headers(log));
        Some((log, alike.flat_map(drives::signals).collect()))
    }

    /// The thruster tables of a vehicle. Neutral and span are added if the log has pulses and the
    /// vehicle file lacks them.
    fn with_pulses(&self, text: &str) -> String {
        let Some((log, signals)) = self.commands() else { return text.to_string() };
        if log.kind != Some(Kind::Pulse) || signals.is_empty() {
            return text.to_string();
        }
        let (neutral, span, why) = self.pulses(&signals);
        let thrusters = geometry::read(text);
        with_thruster_lines(text, |k| {
            let says = |of: fn(&Thruster) -> Option<f64>| thrusters.get(k).is_none_or(|t| of(t).is_some());
            let mut lines = String::new();
            if !says(|t| t.neutral) {
                let _ = writeln!(lines, "# guessed: the vehicle file gives no neutral: {why}\nneutral = {neutral:?}");
            }
            if !says(|t| t.span) {
                let _ = writeln!(lines, "# guessed: the vehicle file gives no span: {why}\nspan = {span:?}");
            }
            lines
        })
    }

    /// Neutral and span of the pulses with the reason: as the autopilot states them, else from the
    /// values.
    fn pulses(&self, signals: &[&Signal]) -> (f64, f64, String) {
        let (neutral, span, why) = commands::pulses(signals);
        let learned = &self.request.learned;
        let Some(limit) = learned.span else { return (neutral, span, why) };
        let neutral = learned.neutral.iter().copied().flatten().next().unwrap_or(1500.0);
        (neutral, limit, "the log's MOT_PWM_MIN and MOT_PWM_MAX, and the neutral of ArduSub".into())
    }

    fn model_table(&self, chosen: &Chosen, thrusters: &[Thruster]) -> String {
        let has = |dof| chosen.dofs.contains(&dof);
        let is_scaled = chosen.scaled && self.mass_for_scale(chosen).is_some();
        let is_one_force = chosen.pushed || is_scaled;
        let mut effects = vec![id::INERTIA.to_string()];
        effects.extend(self.drags(chosen, is_one_force));
        effects.push(id::QUADRATIC_DRAG.to_string());
        if is_one_force {
            let thrust = if is_scaled { id::THRUST_INTERACTION_LOSS } else { id::BIAS };
            effects.push(name_of(thrust, Place::at(Dof::Surge)));
        }
        let rows = chosen.dofs.iter().map(|row| CoriolisRow { row: *row, coriolis: Coriolis::Tied });
        let stands = |row: &CoriolisRow| !places_of(row, &chosen.dofs).is_empty();
        effects.extend(rows.filter(stands).map(|row| row.about().id.to_string()));
        effects.extend([Dof::Heave, Dof::Roll, Dof::Pitch].into_iter().filter(|d| has(*d)).filter_map(id::restoring));
        // the net weight acts along the axes of a vehicle that tilts, and a centre of gravity above
        // or below the origin couples surge to pitch and sway to roll
        for (along, tilt) in [(Dof::Surge, Dof::Pitch), (Dof::Sway, Dof::Roll)] {
            if has(along) && has(tilt) {
                effects.push(format!("{}@{along}:{tilt}", id::ADDED_MASS_COUPLING));
                effects.extend(id::restoring(along).filter(|_| has(Dof::Heave)));
            }
        }
        let logged =
            |name: &str| self.logs.iter().any(|l| l.log.as_ref().is_some_and(|l| l.signals.contains_key(name)));
        let logged_by_all = |name: &str| {
            let mut read = self.logs.iter().filter_map(|l| l.log.as_ref()).peekable();
            read.peek().is_some() && read.all(|l| l.signals.contains_key(name))
        };
        // fins whose angles are logged, of an unknown vehicle
        if self.vehicle.is_none() {
            for fin in id::fins().into_iter().filter(|fin| has(fin.turns) && logged(fin.channel)) {
                effects.push(fin.lift);
                effects.extend(has(Dof::Surge).then_some(fin.drag));
            }
        }
        // a measured wind acts on what stands out of the water
        effects.extend(columns::blowing(&chosen.dofs, logged_by_all));
        if let Some(model) = self.vehicle.and_then(|(known, _)| known.file.model.as_ref()) {
            let known = catalogue(Coriolis::Tied);
            let reads = |name: &EffectName| {
                let effect = known.iter().find(|e| e.about().id == name.id);
                let places = effect.map(|e| places_of(e.as_ref(), &Dof::ALL)).unwrap_or_default();
                let channels = places.iter().flat_map(|place| effect.map(|e| e.channels(*place)).unwrap_or_default());
                channels.filter(|channel| !derived(channel)).all(|channel| logged(&channel))
            };
            effects.extend(model.effects.iter().filter(|name| reads(name)).map(ToString::to_string));
        }
        let list = |items: Vec<String>| items.iter().map(|i| quoted(i)).collect::<Vec<_>>().join(", ");
        let mut text = "\n[model]\n".to_string();
        for word in &chosen.words {
            let _ = writeln!(text, "# guessed: {word}");
        }
        if columns::is_either_way(logged_by_all) {
            text += "# guessed: wind_dir is where the wind blows from; if it is where it blows to, write \
                     wind_to_surge for wind_surge, and so on\n";
        }
        let _ = writeln!(
            text,
            "dofs = [{}]   # surge sway heave roll pitch yaw",
            list(chosen.dofs.iter().map(ToString::to_string).collect())
        );
        let _ = writeln!(text, "effects = [{}]   # `hydrosysid effects` lists them", list(effects));
        text += "coriolis = \"tied\"   # \"tied\" to the inertias | \"free\" coefficients\n";
        if !chosen.undriven.is_empty() {
            let names: Vec<String> = chosen.undriven.iter().map(|dof| format!("\"{dof}\"")).collect();
            let _ = writeln!(
                text,
                "undriven = [{}]   # nothing commands them: in a log without their force, it is zero",
                names.join(", ")
            );
        }
        let commanded = self.logs.iter().filter_map(|understood| {
            let log = understood.log.as_ref()?;
            let mut signals = drives::signals(understood);
            let is_sent = |name: &str, signal: &Signal| is_command(name) && !goes_on(name, signal);
            signals.extend(log.signals.iter().filter(|(name, s)| is_sent(name, s)).map(|(_, s)| s));
            let run = understood.as_run()?;
            let run = forces::commanded(run.clone(), &log.units, thrusters).unwrap_or(run);
            Some(Commanded { signals, rows: log.rows, run })
        });
        let (is_held, why) = held::commands_are_held(&commanded.collect::<Vec<_>>());
        if let Some(why) = why {
            let _ = writeln!(text, "# guessed: {why}");
        }
        let input = if is_held { "hold" } else { "linear" };
        let _ = writeln!(text, "input = \"{input}\"   # what commands do between samples: \"linear\" | \"hold\"");
        text
    }

    /// The options that all logs have in common, with their reasons; each run states the rest. If a
    /// dive has several logs, only the user's options are common.
    fn common(&self) -> Common {
        let read: Vec<&Understood> = self.logs.iter().filter(|l| l.log.is_some()).collect();
        let single = self.dives.iter().all(|dive| dive.len() == 1);
        if single { Common::of(&read, self.given) } else { Common::of(&[], self.given) }
    }

    fn log_table(&self, common: &Common) -> String {
        let mut text = "\n[log]\n# position_source = \"independent\"   # x, y measured apart from the velocity \
                        (acoustics, GNSS); \"dead_reckoned\" otherwise\n# velocity_reference = \"ground\"   # what \
                        u, v, w are relative to: \"ground\" | \"water\"\n"
            .to_string();
        let has = |name: &str| self.logs.iter().any(|l| l.log.as_ref().is_some_and(|l| l.signals.contains_key(name)));
        if has("x") && has("y") && !(has("u") && has("v")) && self.given.position_source.is_none() {
            text += "# guessed: no log has u and v, so north and east must be measured \
                     independently\nposition_source = \"independent\"\n";
        }
        text + &common.text("log")
    }

    /// Role of each dive.
    fn roles(&self, dofs: &[Dof]) -> Vec<&'static str> {
        let read = |dive: &Vec<usize>| {
            let logs = dive.iter().filter_map(|k| self.logs[*k].log.as_ref());
            let signals = logs.flat_map(|log| log.signals.iter().map(|(name, signal)| (name.clone(), signal.clone())));
            Run { signals: signals.collect(), ..Run::default() }
        };
        let dives: Vec<Run> = self.dives.iter().map(read).collect();
        let role = |validates: bool| if validates { "validate" } else { "train" };
        roles::validating(&dives, dofs).into_iter().map(role).collect()
    }

    fn run_table(&self, dive: &[usize], role: &str, common: &Common) -> String {
        let logs: Vec<&Understood> = dive.iter().map(|k| &self.logs[*k]).collect();
        let readable: Vec<&Understood> = logs.iter().copied().filter(|l| l.log.is_some()).collect();
        let mut text = String::new();
        for log in logs.iter().filter(|l| l.log.is_none()) {
            let _ = writeln!(text, "\n{NOT_READ}{}", log.shown);
            for line in &log.refused {
                let _ = writeln!(text, "# {line}");
            }
            let _ = writeln!(text, "# [[run]]\n# file = {}", quoted(&log.shown));
        }
        let Some(first) = readable.first() else { return text };
        text += "\n[[run]]\n";
        let facts = |log: &Understood| {
            let read = log.log.as_ref();
            let rows = read.map_or(0, |l| l.rows);
            let seconds = read.and_then(|l| Some(l.time.last()? - l.time.first()?)).unwrap_or(0.0);
            format!("{rows} rows, {seconds:.1} s")
        };
        if readable.len() == 1 {
            let _ = writeln!(text, "file = {}   # {}", quoted(&first.shown), facts(first));
        }
        let (kind, why) = kinds::of(&readable);
        if let Some(why) = why {
            let _ = writeln!(text, "# guessed: {why}");
        }
        let _ = writeln!(
            text,
            "kind = \"{kind}\"   # bollard | bench | towing | constant_velocity | oscillatory | zigzag | free"
        );
        if self.dives.len() >= 3 {
            text += "# guessed: every third run takes no part in the fit, where other runs move the same degrees of \
                     freedom as far\n";
        }
        let _ = writeln!(text, "role = \"{role}\"   # train | validate: takes no part in the fit");
        for stretch in logs.iter().filter_map(|l| self.request.learned.closed_loop.get(&l.shown)).flatten() {
            let _ = writeln!(text, "# guessed: {stretch}");
        }
        for remark in readable.iter().flat_map(|l| &l.remarks) {
            let _ = writeln!(text, "# {remark}");
        }
        if readable.len() > 1 {
            let _ = writeln!(
                text,
                "# guessed: these logs are of one dive: they hold different channels over the same time, {}",
                dives::reason(&readable)
            );
            for log in readable {
                let _ = writeln!(text, "[[run.file]]\nfile = {}   # {}", quoted(&log.shown), facts(log));
                text += &table(log, "run.file.log");
            }
        } else {
            text += &common.rest(first, "run.log");
        }
        text
    }
}

/// The sections of a TOML text whose name `keep` accepts, each with the comments before it.
fn sections(text: &str, keep: impl Fn(&str) -> bool) -> String {
    let (mut out, mut pending, mut kept) = (String::new(), String::new(), true);
    for line in text.lines() {
        let trimmed = line.trim_start();
        if trimmed.starts_with('#') || trimmed.is_empty() {
            pending = pending + line + "\n";
            continue;
        }
        if trimmed.starts_with('[') {
            kept = keep(trimmed.trim_start_matches('[').split([']', '.']).next().unwrap_or("").trim());
        }
        if kept {
            out = out + &pending + line + "\n";
        }
        pending.clear();
    }
    out
}
