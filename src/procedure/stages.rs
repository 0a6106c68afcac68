//! The stages in sequence; each uses the results of the earlier ones.

use std::collections::BTreeSet;

use super::drag::Drag;
use super::inertia::Kind;
use super::stage_covariance::{Held, Known};
use super::{
    Bench, ProcedureError, StagedOptions, StagedResult, acting_forces, advance, bollard, codes, direct_regression,
    drag, effective_thrust, inertia, of_kind, parameters_of, prepare,
};
use crate::chain::Nature;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::run::{Run, RunKind};
use crate::thrust::efficiency::Efficiency;
use crate::thrust::interaction::Interaction;

/// State of the procedure while it runs.
pub(super) struct Stages<'a> {
    /// Training runs with nominal forces.
    pub runs: &'a [Run],
    pub bench: Bench<'a>,
    pub options: &'a StagedOptions,
    pub held: &'a mut Held,
    pub result: &'a mut StagedResult,
}

impl<'a> Stages<'a> {
    fn of_kind(&self, kind: RunKind, dof: Dof) -> Vec<&'a Run> {
        of_kind(self.runs, kind, dof, &self.result.model.dofs)
    }

    /// Stage (i): η_inter of each degree of freedom and group that has bollard runs and no known value.
    pub fn interaction(&mut self) -> Result<(), ProcedureError> {
        if self.options.bollard.skip {
            return Ok(());
        }
        let given: Vec<_> = self.held.efficiency.eta_inter.0.iter().map(|e| (e.value, e.std)).collect();
        for (k, (value, std)) in given.into_iter().enumerate() {
            if let Some(std) = std {
                self.held.know(Known::Interaction(k), value, &[std * std]);
            }
        }
        for dof in self.result.model.dofs.clone() {
            let runs = self.of_kind(RunKind::Bollard, dof);
            let of = |runs: &[&Run]| bollard::stages(dof, runs, self.bench.thrusters, &self.options.bollard);
            let mut found = of(&runs)?;
            // if a curve gives too much thrust, η_inter is too small by the same factor
            let moved = self.held.moved_by_thrust(&runs, |runs, _| {
                of(runs).map(|found| found.iter().map(|(_, eta)| eta.value).collect::<Vec<f64>>())
            })?;
            let (mut kept, mut jacobian, mut own) = (Vec::new(), Vec::new(), Vec::new());
            for (k, (_, eta)) in found.iter().enumerate() {
                let table = &mut self.held.efficiency.eta_inter.0;
                if !table.iter().any(|e| e.dof == dof && (e.thrusters.is_empty() || e.thrusters == eta.thrusters)) {
                    kept.push((k, (Known::Interaction(table.len()), eta.value)));
                    jacobian.push(moved[k].clone());
                    own.push(eta.std.map_or(0.0, |std| std * std));
                    table.push(eta.clone());
                }
            }
            let entries: Vec<(Known, f64)> = kept.iter().map(|(_, entry)| *entry).collect();
            let own: Vec<Vec<f64>> =
                (0..own.len()).map(|i| (0..own.len()).map(|j| if i == j { own[i] } else { 0.0 }).collect()).collect();
            let covariance = self.held.derive(&entries, &jacobian, &own);
            for (i, (k, (known, _))) in kept.into_iter().enumerate() {
                let std = covariance[i][i].max(0.0).sqrt();
                found[k].0.estimates[0].std = std;
                if let Known::Interaction(entry) = known {
                    self.held.efficiency.eta_inter.0[entry].std = Some(std);
                }
            }
            self.result.stages.extend(found.into_iter().map(|(stage, _)| stage));
        }
        Ok(())
    }

    /// Stage (ii), towing: drag from the load cells, from runs without thrust.
    pub fn towed(&mut self) -> Result<Vec<Option<Drag>>, ProcedureError> {
        let mut found = Vec::new();
        for dof in self.result.model.dofs.clone() {
            let still = self.of_kind(RunKind::Towing, dof).into_iter().filter(|run| !advance::is_powered(run, dof));
            let runs: Vec<Run> = still.filter_map(|run| drag::towed(run, dof)).collect();
            let cells = Held::without_thrust();
            found.push(self.drag_stage("towing", dof, &runs.iter().collect::<Vec<_>>(), &cells)?);
        }
        Ok(found)
    }

    /// Runs a drag stage on these runs; `None` if it is skipped, there are no runs, or it fails.
    fn drag_stage(&mut self, name: &str, dof: Dof, runs: &[&Run], held: &Held) -> Result<Option<Drag>, ProcedureError> {
        if self.options.steady.skip || runs.is_empty() {
            return Ok(None);
        }
        match drag::stage(name, dof, runs, &self.result.model, held, &self.options.steady)? {
            Ok(mut drag) => {
                self.result.stages.append(&mut drag.stages);
                drag.found.fit.write_to(&mut self.result.model);
                Ok(Some(drag))
            }
            Err(finding) => {
                self.result.warnings.push(finding);
                Ok(None)
            }
        }
    }

    /// η_adv from powered towing, if it is not known. If no propelled run will replace a towed
    /// drag, that drag is held from here on, so that later results that depend on both are
    /// correlated correctly. Returns those of `towed` that are not yet held.
    pub fn advance(&mut self, mut towed: Vec<Option<Drag>>) -> Vec<Option<Drag>> {
        if self.held.efficiency.eta_adv.is_some() || self.options.bollard.skip {
            return towed;
        }
        for (k, dof) in self.result.model.dofs.clone().into_iter().enumerate() {
            let runs: Vec<&Run> =
                self.of_kind(RunKind::Towing, dof).into_iter().filter(|run| advance::is_powered(run, dof)).collect();
            if runs.is_empty() || self.held.efficiency.eta_adv.is_some() {
                continue;
            }
            let drag = towed[k].take();
            let alone = self.of_kind(RunKind::ConstantVelocity, dof).is_empty();
            if let Some(drag) = drag.as_ref().filter(|_| alone) {
                drag.hold(self.held, &self.result.model, dof);
            }
            if let Err(lack) = self.advance_line(dof, &runs, drag.as_ref(), alone) {
                let text = format!("advance, {dof}: {lack}");
                self.result.warnings.push(Finding::new(&codes::TOO_LITTLE, text));
            }
            towed[k] = drag.filter(|_| !alone);
        }
        towed
    }

    /// η_adv from the powered towing runs of one degree of freedom, with the uncertainty of the
    /// towed drag: through its entries if it is `held`, otherwise as part of the line's own
    /// covariance. The error says what the data lacks.
    fn advance_line(&mut self, dof: Dof, runs: &[&Run], drag: Option<&Drag>, held: bool) -> Result<(), String> {
        let (model, thrusters) = (&self.result.model, self.bench.thrusters);
        let mut line = advance::stage(dof, runs, model, &self.held.efficiency, thrusters)?;
        let of = |runs: &[&Run], losses: &Efficiency| advance::values(dof, runs, model, losses, thrusters);
        let mut jacobian = self.held.moved_by_thrust(runs, of)?;
        let mut own: Vec<Vec<f64>> = line.covariance.iter().map(|row| row.to_vec()).collect();
        if let Some(drag) = drag {
            let known = drag.deviations();
            let by_drag = advance::by_drag(dof, runs, model, (&self.held.efficiency, thrusters), &known)?;
            if held {
                for (column, (parameter, _)) in known.iter().enumerate() {
                    if let Some(entry) = self.held.entry_of(*parameter) {
                        jacobian.iter_mut().zip(&by_drag).for_each(|(row, by)| row[entry] = by[column]);
                    }
                }
            } else {
                drag.carry(&by_drag, &mut own);
            }
        }
        let found = [(Known::Slope, line.fit.slope.value), (Known::Intercept, line.fit.intercept.value)];
        let covariance = self.held.derive(&found, &jacobian, &own);
        for (k, estimate) in line.stage.estimates.iter_mut().enumerate() {
            estimate.std = covariance[k][k].max(0.0).sqrt();
        }
        line.stage.covariance = covariance;
        self.held.efficiency.eta_adv = Some(line.fit.loss);
        self.result.stages.push(line.stage);
        Ok(())
    }

    /// Adds findings where the losses of thrust are not known.
    pub fn coverage(&mut self) {
        let dofs = &self.result.model.dofs;
        let mut unknown: BTreeSet<(Dof, Vec<String>)> = BTreeSet::new();
        for run in self.runs.iter().filter(|run| !matches!(run.kind, RunKind::Bollard | RunKind::Towing)) {
            // nothing is estimated from the commands that hold the other degrees of freedom
            let shown = prepare::shown(run, dofs).map(Dof::force);
            let warnings = acting_forces(run, &self.held.efficiency, self.bench.thrusters).1;
            let counts = |w: &Finding| w.column.is_none() || w.column.as_deref() == shown;
            self.result.warnings.extend(warnings.into_iter().filter(counts));
            for dof in dofs {
                let group = effective_thrust::group(run, *dof, self.bench.thrusters);
                let table = &self.held.efficiency.eta_inter.0;
                let measured = table.iter().any(|e| e.dof == *dof);
                let known = |e: &Interaction| e.dof == *dof && (e.thrusters.is_empty() || e.thrusters == group);
                if measured && !group.is_empty() && !table.iter().any(known) {
                    unknown.insert((*dof, group));
                }
            }
        }
        for (dof, group) in unknown {
            let text = format!("{dof}: no eta_inter for {} together; 1 was used", group.join(", "));
            self.result.warnings.push(Finding::new(&codes::NO_GROUP, text));
        }
    }

    /// Stage (ii), propelled. If there is also a towed drag, the propelled one is kept, as in the
    /// paper.
    pub fn drag(&mut self, dof: Dof, towed: Option<Drag>) -> Result<(), ProcedureError> {
        let runs = self.of_kind(RunKind::ConstantVelocity, dof);
        let own = self.held.clone();
        let propelled = self.drag_stage("steady", dof, &runs, &own)?;
        match propelled.or(towed) {
            Some(drag) => drag.hold(self.held, &self.result.model, dof),
            None if parameters_of(&self.result.model, dof, Nature::Drag).iter().any(|p| !self.held.has(*p))
                && !self.options.steady.skip =>
            {
                let text = format!("no run shows the drag in {dof}; constant_velocity or towing runs would show it");
                self.result.warnings.push(Finding::new(&codes::NO_RUN, text));
            }
            None => {}
        }
        Ok(())
    }

    /// Stage (iii) of one kind in one degree of freedom.
    pub fn integral(&mut self, kind: Kind, dof: Dof) -> Result<(), ProcedureError> {
        let (of, skip) = match kind {
            Kind::Oscillatory => (RunKind::Oscillatory, self.options.oscillatory.skip),
            Kind::Zigzag => (RunKind::Zigzag, self.options.zigzag.skip),
        };
        let model = &self.result.model;
        let runs: Vec<Run> = match kind {
            Kind::Oscillatory => self.of_kind(of, dof).into_iter().cloned().collect(),
            Kind::Zigzag => {
                let align = self.options.zigzag.align;
                self.of_kind(of, dof).into_iter().map(|run| prepare::aligned(run, dof, align)).collect()
            }
        };
        let runs: Vec<&Run> = runs.iter().collect();
        if skip || runs.is_empty() || kind.free(model, dof, self.held, self.options).is_empty() {
            return Ok(());
        }
        match inertia::stages(kind, dof, &runs, model, self.held, &self.bench, self.options)? {
            Ok((stages, found)) => {
                self.result.stages.extend(stages);
                let every = found.fit.parameters.iter().map(|c| c.parameter);
                // (29) gives I_r and b as results of the zig-zag; in surge and sway an oscillation
                // determines them better
                let kept: Vec<usize> =
                    every.filter(|p| kind == Kind::Oscillatory || dof == Dof::Yaw || !self.held.has(*p)).collect();
                found.fit.write_some(&kept, &mut self.result.model);
                self.held.add(&found, &kept, None);
            }
            Err(finding) => self.result.warnings.push(finding),
        }
        Ok(())
    }

    /// The direct regression beside the stages, if it is asked for.
    pub fn direct(&mut self) {
        if self.options.direct.skip {
            return;
        }
        let act = |run: &Run| acting_forces(run, &self.held.efficiency, self.bench.thrusters).0;
        let acting: Vec<Run> = self.runs.iter().map(act).collect();
        for dof in self.result.model.dofs.clone() {
            let moving = of_kind(&acting, direct_regression::kind_of(dof, &acting), dof, &self.result.model.dofs);
            if moving.is_empty() {
                continue;
            }
            match direct_regression::direct(dof, &moving, &self.result.model, self.options) {
                Ok((stage, _)) => self.result.stages.push(stage),
                Err(error) => {
                    let text = format!("direct, {dof}: {error}");
                    self.result.warnings.push(Finding::new(&codes::TOO_LITTLE, text));
                }
            }
        }
    }
}
