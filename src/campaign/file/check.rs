//! Checks that types cannot express: contradicting values, unknown names, missing files.

use toml::de::{DeTable, DeValue};

use super::error::Problem;
use super::report::Report;
use super::{CampaignFile, ForceNoise, ReadOptions, folder_of, paths};
use crate::campaign::columns;
use crate::campaign::init::unread_mark;
use crate::effects::EffectName;
use crate::filter::{PolynomialFilter, Window};
use crate::log::{LogOptions, OptionsError};
use crate::nearest::nearest;
use crate::thrust::thruster::ThrusterError;
use crate::vehicle::{Vehicle, VehicleError, Water};

/// Checks that the file has what every campaign needs, before faulty entries are cut off.
pub(super) fn presence(root: &DeTable<'_>, report: &mut Report) {
    for (key, right) in
        [("format", "the file starts with format = 1"), ("model", "a [model] table with `dofs` and `effects`")]
    {
        if !root.contains_key(key) {
            report.at_start(key, Problem::MissingKey { key: key.to_string(), right });
        }
    }
    match root.get("run").map(|run| (run.span(), run.get_ref())) {
        None => match unread_mark(&report.source.text) {
            Some(at) => report.at_span(at..at, Problem::NoneRead),
            None => report.at_start("run", Problem::NoRuns),
        },
        Some((span, DeValue::Array(runs))) if runs.is_empty() => report.at_span(span, Problem::NoRuns),
        _ => {}
    }
}

/// Reports numbers that are not finite. TOML has `inf` and `nan`; a campaign uses `inf` in bounds
/// only.
pub(super) fn numbers(root: &DeTable<'_>, report: &mut Report) {
    let mut found = Vec::new();
    super::tree::walk(root, "", &mut |path, _, value| {
        let text = value.as_float().map(toml::de::DeFloat::as_str);
        let number = text.and_then(|text| text.replace('_', "").parse::<f64>().ok());
        let bound = path.starts_with("parameter[") && (path.ends_with("].min") || path.ends_with("].max"));
        if number.is_some_and(|n| n.is_nan() || (n.is_infinite() && !bound)) {
            found.push(path.to_string());
        }
    });
    found.iter().for_each(|path| report.at(path, Problem::NotFinite));
}

/// Checks of the tables, one function per table.
pub(super) struct Check<'a> {
    pub campaign: &'a CampaignFile,
    pub options: &'a ReadOptions,
    pub report: &'a mut Report,
}

impl Check<'_> {
    pub fn all(&mut self) {
        self.vehicle();
        self.thrusters();
        self.model();
        self.own_effects();
        self.parameters();
        self.efficiency();
        self.fit();
        self.stages();
        self.discover();
        self.log("log", &self.campaign.log);
        self.runs();
    }

    /// Reports a number outside its range; one that is not finite was reported before.
    fn range(&mut self, path: &str, value: f64, good: bool, right: &'static str) {
        if value.is_finite() && !good {
            self.report.at(path, Problem::OutOfRange { value, right });
        }
    }

    fn twice(&mut self, path: &str, first: &str, what: impl std::fmt::Display) {
        let first_line = self.report.line(first);
        self.report.at(path, Problem::Twice { what: what.to_string(), first_line });
    }

    fn filled(&mut self, path: &str, text: &str, right: &'static str) {
        if text.trim().is_empty() {
            self.report.at(path, Problem::Empty { right });
        }
    }

    fn vehicle(&mut self) {
        let campaign = self.campaign;
        let figures = |v: &Vehicle| -> [Vehicle; 7] {
            let none = Vehicle::default();
            [
                Vehicle { mass: v.mass, ..none.clone() },
                Vehicle { volume: v.volume, ..none.clone() },
                Vehicle { weight: v.weight, ..none.clone() },
                Vehicle { buoyancy: v.buoyancy, ..none.clone() },
                Vehicle { length: v.length, ..none.clone() },
                Vehicle { cg: v.cg, ..none.clone() },
                Vehicle { cb: v.cb, ..none },
            ]
        };
        // one figure at a time, so that each wrong one is reported
        let mut wrong: Vec<VehicleError> =
            figures(&campaign.vehicle).iter().filter_map(|one| one.validate().err()).collect();
        let usual = Water::default();
        wrong.extend(Water { density: campaign.water.density, ..usual }.validate().err());
        wrong.extend(Water { kinematic_viscosity: campaign.water.kinematic_viscosity, ..usual }.validate().err());
        for error in wrong {
            let (path, finite) = match &error {
                VehicleError::NotPositive { table, key, value, .. } => (format!("{table}.{key}"), value.is_finite()),
                VehicleError::BadPosition { key, .. } => (format!("vehicle.{key}"), false),
            };
            if finite {
                self.report.at(&path, Problem::Vehicle(error));
            }
        }
        for (channel, std) in &campaign.noise.sensors {
            self.range(&format!("noise.{channel}"), *std, *std > 0.0, "a standard deviation must be above 0");
        }
        for (dof, most) in &campaign.noise.force_max {
            self.range(&format!("noise.force_max.{dof}"), *most, *most > 0.0, "an rms must be above 0");
        }
        if let Err((key, right)) = campaign.noise.forces() {
            let value = match &campaign.noise.force {
                Some(ForceNoise::Held(table)) => table.get(&key).copied().unwrap_or(f64::NAN),
                _ => f64::NAN,
            };
            self.range(&format!("noise.force.{key}"), value, false, right);
        }
    }

    fn thrusters(&mut self) {
        let thrusters = &self.campaign.thrusters;
        for (i, thruster) in thrusters.iter().enumerate() {
            if let Err(error) = thruster.validate() {
                let key = match &error {
                    ThrusterError::BadVector { key, .. } => format!("thruster[{i}].{key}"),
                    _ => format!("thruster[{i}]"),
                };
                self.report.at(&key, Problem::Thruster(error));
            }
            let path = format!("thruster[{i}].bollard");
            if let Some(table) = &thruster.bollard
                && self.options.look_for_files
                && let Err(problem) =
                    paths::check(&folder_of(&self.report.source.file), &table.file, self.options.allow_outside)
            {
                self.report.at(&path, problem);
            }
            if let Some(first) = thrusters[..i].iter().position(|t| t.name == thruster.name) {
                self.twice(&format!("thruster[{i}].name"), &format!("thruster[{first}].name"), &thruster.name);
            }
        }
    }

    fn model(&mut self) {
        let model = &self.campaign.model;
        if model.dofs.is_empty() && self.report.source.locate("model.dofs").is_some() && !self.report.told("model.dofs")
        {
            let right = "list the degrees of freedom to model, as in [\"surge\", \"sway\", \"yaw\"]";
            self.report.at("model.dofs", Problem::Empty { right });
        }
        for (i, dof) in model.dofs.iter().enumerate() {
            if let Some(first) = model.dofs[..i].iter().position(|d| d == dof) {
                self.twice(&format!("model.dofs[{i}]"), &format!("model.dofs[{first}]"), dof);
            }
        }
        for (i, dof) in model.undriven.clone().into_iter().enumerate() {
            self.modelled(&format!("model.undriven[{i}]"), Some(dof));
        }
        for (i, name) in model.effects.iter().enumerate() {
            let path = format!("model.effects[{i}]");
            self.name(&path, name);
            if let Some(first) = model.effects[..i].iter().position(|other| name.overlaps(other)) {
                self.twice(&path, &format!("model.effects[{first}]"), format_args!("`{name}`"));
            }
        }
    }

    /// Checks that an effect exists, in a degree of freedom that is modelled.
    fn name(&mut self, path: &str, name: &EffectName) {
        let own = self.campaign.effects.iter().map(|e| e.id.as_str());
        let known: Vec<&str> = self.options.known_effects.iter().map(String::as_str).chain(own).collect();
        if !known.contains(&name.id.as_str()) && !columns::may_bring(&name.id) {
            let nearest = nearest(&name.id, known).map(str::to_string);
            self.report.at(path, Problem::UnknownEffect { id: name.id.clone(), nearest });
        }
        name.thrusters.iter().for_each(|thruster| self.thruster(path, thruster));
        // the other degree of freedom of a coupling may be only logged
        self.modelled(path, name.dof);
    }

    /// Checks that the campaign describes a thruster.
    fn thruster(&mut self, path: &str, word: &str) {
        let known: Vec<String> = self.campaign.thrusters.iter().map(|t| t.name.clone()).collect();
        if known.iter().all(|name| name != word) {
            let nearest = nearest(word, known.iter().map(String::as_str)).map(str::to_string);
            let message = format!("no [[thruster]] describes `{word}`: add a table for each");
            self.report.at(
                path,
                match known.is_empty() {
                    true => Problem::Unreadable { message },
                    false => Problem::UnknownWord { word: word.into(), nearest, known },
                },
            );
        }
    }

    fn modelled(&mut self, path: &str, dof: Option<crate::frame::Dof>) {
        let dofs = &self.campaign.model.dofs;
        // if the list itself is wrong or absent, that is reported instead
        let whole = !dofs.is_empty() && !self.report.told("model.dofs");
        if let Some(dof) = dof.filter(|dof| whole && !dofs.contains(dof)) {
            self.report.at(path, Problem::NotModelled { dof });
        }
    }

    fn own_effects(&mut self) {
        let campaign = self.campaign;
        for (i, effect) in campaign.effects.iter().enumerate() {
            let path = |key: &str| format!("effect[{i}].{key}");
            match effect.id.parse::<EffectName>() {
                Ok(name) if name.dof.is_none() => {}
                _ => {
                    let right = "an id of letters, digits and `_`; the degree of freedom has its own key, `dof`";
                    self.report
                        .at(&path("id"), Problem::Unreadable { message: format!("{:?}: give {right}", effect.id) });
                }
            }
            if self.options.known_effects.contains(&effect.id) {
                self.report.at(&path("id"), Problem::EffectTaken { id: effect.id.clone() });
            }
            if let Some(first) = campaign.effects[..i].iter().position(|e| e.id == effect.id) {
                self.twice(&path("id"), &format!("effect[{first}].id"), format_args!("`{}`", effect.id));
            }
            self.modelled(&path("dof"), Some(effect.dof));
            self.filled(&path("formula"), &effect.formula, "a formula over states and channels");
        }
        for (i, observe) in campaign.observed.iter().enumerate() {
            let path = |key: &str| format!("observe[{i}].{key}");
            self.filled(&path("channel"), &observe.channel, "the name of a column of the log");
            self.filled(&path("formula"), &observe.formula, "a formula over states and channels");
            if let Some(first) = campaign.observed[..i].iter().position(|o| o.channel == observe.channel) {
                self.twice(&path("channel"), &format!("observe[{first}].channel"), &observe.channel);
            }
        }
    }

    fn parameters(&mut self) {
        let parameters = &self.campaign.parameters;
        if let Some(i) = super::tie_cycle(parameters) {
            self.report.at(&format!("parameter[{i}].tie"), Problem::TieCycle);
        }
        for (i, p) in parameters.iter().enumerate() {
            let path = |key: &str| format!("parameter[{i}].{key}");
            self.name(&path("effect"), &p.effect);
            let same = |o: &super::ParameterTable| {
                o.effect.overlaps(&p.effect) && (o.name == p.name || o.name.is_none() || p.name.is_none())
            };
            if let Some(first) = parameters[..i].iter().position(same) {
                let what = format!("the parameter of `{}`", p.effect);
                self.twice(&path("effect"), &format!("parameter[{first}].effect"), what);
            }
            if let Some(tie) = &p.tie {
                self.name(&path("tie"), tie);
                let own = [
                    ("value", p.value.is_some()),
                    ("fixed", p.fixed),
                    ("std", p.std.is_some()),
                    ("min", p.min.is_some()),
                    ("max", p.max.is_some()),
                ];
                for (key, _) in own.into_iter().filter(|(_, given)| *given) {
                    self.report.at(&path(key), Problem::TiedWithOwn { key });
                }
                continue;
            }
            match (p.value, p.fixed, p.std) {
                (None, true, _) => {
                    self.report.at(&path("fixed"), Problem::FixedWithoutValue { effect: p.effect.to_string() });
                }
                (None, false, Some(_)) => self.report.at(&path("std"), Problem::PriorWithoutValue),
                (Some(_), true, Some(_)) => self.report.at(&path("std"), Problem::FixedWithPrior),
                _ => {}
            }
            if let Some(std) = p.std {
                self.range(&path("std"), std, std > 0.0, "a standard deviation must be above 0");
            }
            let (min, max) = (p.min.unwrap_or(f64::NEG_INFINITY), p.max.unwrap_or(f64::INFINITY));
            if min > max {
                self.report.at(&path("min"), Problem::MinAboveMax { min, max });
            } else if let Some(value) = p.value.filter(|v| *v < min || *v > max) {
                self.report.at(&path("value"), Problem::OutsideBounds { value, min, max });
            }
        }
    }

    fn efficiency(&mut self) {
        let campaign = self.campaign;
        let table = &campaign.efficiency;
        if let Err(error) = table.eta_inter.validate() {
            self.report.at("efficiency.eta_inter", Problem::Efficiency(error));
        }
        if let Some(Err(error)) = table.eta_adv.map(|loss| loss.validate()) {
            self.report.at("efficiency.eta_adv", Problem::Efficiency(error));
        }
        // without [[thruster]] tables the names are those of the log
        let named = if campaign.thrusters.is_empty() { &[][..] } else { &table.eta_inter.0 };
        for (i, entry) in named.iter().enumerate() {
            for (k, name) in entry.thrusters.iter().enumerate() {
                self.thruster(&format!("efficiency.eta_inter[{i}].thrusters[{k}]"), name);
            }
        }
    }

    fn fit(&mut self) {
        let fit = &self.campaign.fit;
        self.range("fit.segment", fit.segment, fit.segment > 0.0, "a duration above 0 s");
        if let Some(longest) = fit.longest_step {
            self.range("fit.longest_step", longest, longest > 0.0, "a duration above 0 s");
        }
    }

    fn stages(&mut self) {
        let stage = &self.campaign.stage;
        let part = "a fraction above 0 and at most 1";
        for (name, value) in [("bollard", stage.bollard.steady_part), ("steady", stage.steady.steady_part)] {
            self.range(&format!("stage.{name}.steady_part"), value, value > 0.0 && value <= 1.0, part);
        }
        let least = stage.bollard.least_force;
        self.range("stage.bollard.least_force", least, least >= 0.0, "a magnitude of a force must not be negative");
        let steady = &stage.steady;
        for (name, value) in [("drift", steady.drift), ("scatter", steady.scatter)] {
            self.range(&format!("stage.steady.{name}"), value, value > 0.0, "a fraction of the speed above 0");
        }
        self.range("stage.steady.length", steady.length, steady.length > 0.0, "a duration above 0 s");
        for (i, window) in steady.windows.iter().enumerate() {
            if window.from >= window.to {
                let problem = Problem::FromAfterTo { from: window.from, to: window.to };
                self.report.at(&format!("stage.steady.windows[{i}]"), problem);
            }
        }
        for (name, window) in [("oscillatory", stage.oscillatory.window), ("zigzag", stage.zigzag.window)] {
            self.range(&format!("stage.{name}.window"), window as f64, window > 0, "at least 1 sample");
        }
        let filters = [
            ("oscillatory", stage.oscillatory.filter),
            ("zigzag", stage.zigzag.filter),
            ("direct", Some(stage.direct.filter)),
        ];
        self.filter("stage.rates", stage.rates);
        for (name, filter) in filters {
            if let Some(filter) = filter {
                self.filter(&format!("stage.{name}.filter"), filter);
            }
        }
    }

    fn filter(&mut self, path: &str, filter: PolynomialFilter) {
        match filter.window {
            Window::Samples(n) => {
                let path = format!("{path}.window.samples");
                self.range(&path, n as f64, n % 2 == 1, "an odd number of samples");
                let right = "a polynomial of degree d needs more than d samples";
                self.range(&path, n as f64, n % 2 == 0 || n > filter.degree, right);
            }
            Window::Seconds(s) => self.range(&format!("{path}.window.seconds"), s, s > 0.0, "a width above 0"),
        }
    }

    fn discover(&mut self) {
        let table = &self.campaign.discover;
        self.range(
            "discover.level",
            table.level,
            table.level > 0.0 && table.level < 1.0,
            "between 0 and 1, such as 0.01",
        );
        self.range("discover.max_effects", table.max_effects as f64, table.max_effects > 0, "at least 1");
        if table.families.is_empty() {
            self.report.at("discover.families", Problem::Empty { right: "body, actuator, environment, sensor" });
        }
    }

    /// Checks reading options. An error that a run inherits from the campaign was reported there.
    fn log(&mut self, path: &str, log: &LogOptions) {
        let Err(error) = log.validate() else { return };
        let key = match &error {
            OptionsError::Delimiter(_) | OptionsError::DelimiterIsDecimal(_) => "delimiter".to_string(),
            OptionsError::Decimal(_) => "decimal".to_string(),
            OptionsError::EmptyComment => "comment".to_string(),
            OptionsError::Scale { column, .. }
            | OptionsError::Sign { column, .. }
            | OptionsError::Unit { column, .. } => {
                format!("columns.{column}")
            }
            OptionsError::TimeScale => "columns.t".to_string(),
            OptionsError::SameHeader { second, .. } => format!("columns.{second}"),
            OptionsError::VelocityFrames(column) => format!("columns.{column}"),
            OptionsError::StreamedVelocity => "columns.u".to_string(),
            OptionsError::StreamedDerived => "columns".to_string(),
            OptionsError::UnitOfDate => "time_unit".to_string(),
            OptionsError::Limit(key) => key.to_string(),
        };
        let problem = Problem::Log(error);
        if self.campaign.log.validate().err().map(Problem::Log).as_ref() != Some(&problem) || path == "log" {
            self.report.at(&format!("{path}.{key}"), problem);
        }
    }

    fn runs(&mut self) {
        let campaign = self.campaign;
        let folder = folder_of(&self.report.source.file);
        for (i, run) in campaign.runs.iter().enumerate() {
            let path = |key: &str| format!("run[{i}].{key}");
            if let (Some(from), Some(to)) = (run.from, run.to)
                && from >= to
            {
                self.report.at(&path("from"), Problem::FromAfterTo { from, to });
            }
            if let Some(rate) = run.resample {
                self.range(&path("resample"), rate, rate > 0.0, "a rate in Hz above 0");
            }
            if let Some(condition) = &run.condition {
                self.filled(&path("where"), condition, "a condition such as \"abs(theta) > 0.2\"");
            }
            if run.files.is_empty() {
                self.report.at(&path("file"), Problem::Empty { right: "a run needs at least one log" });
            }
            if let Some(log) = &run.log {
                self.log(&path("log"), log);
            }
            for (k, log) in run.files.iter().enumerate() {
                let place = self.place_of(i, k);
                if let Some(own) = &log.log {
                    self.log(&format!("{place}.log"), own);
                }
                if log.file.trim().is_empty() {
                    self.report.at(&place, Problem::Empty { right: "the path of a log" });
                } else if self.options.look_for_files
                    && let Err(problem) = paths::check(&folder, &log.file, self.options.allow_outside)
                {
                    self.report.at(&place, problem);
                }
                // a log that is listed twice in one run would count its samples twice
                if let Some(first) = run.files[..k].iter().position(|other| other.file == log.file) {
                    self.twice(&place, &self.place_of(i, first), format_args!("{:?}", log.file));
                }
            }
        }
    }

    /// Returns the path of the text that names log k of run i, in whichever form it was written.
    fn place_of(&self, i: usize, k: usize) -> String {
        let forms = [format!("run[{i}].file[{k}].file"), format!("run[{i}].file[{k}]"), format!("run[{i}].file.file")];
        let written = forms.into_iter().find(|path| self.report.source.locate(path).is_some());
        written.unwrap_or_else(|| format!("run[{i}].file"))
    }
}
