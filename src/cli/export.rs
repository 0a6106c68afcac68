//! The verb `export`: a model or the thrusters of a campaign as a file for another tool.

use std::collections::BTreeMap;

use super::answer;
use super::arguments::Export;
use super::failure::Failure;
use super::output::Output;
use super::table::{table, wrapped};
use crate::export::{self, ExportOptions, Target};
use crate::nearest::nearest;
use crate::wording::count;

/// A target in the list.
#[derive(serde::Serialize)]
struct Listed {
    target: Target,
    version: &'static str,
    takes: &'static str,
}

pub(super) fn export(a: &Export, output: &Output) -> Result<(), Failure> {
    let (Some(file), Some(name)) = (&a.file, &a.to) else { return list(a, output) };
    // standard output gets the file itself
    let place = a.output.as_deref().filter(|path| !Output::is_stdout(path));
    output.may_write(place)?;
    let target = Target::from_name(name).ok_or_else(|| {
        if let Some(reason) = Target::why_absent(name) {
            return Failure::Argument(reason.into());
        }
        let near = nearest(name, Target::ALL.iter().map(|t| t.name())).map(|n| format!(", did you mean `{n}`?"));
        Failure::Argument(format!(
            "no target is called `{name}`{}; `hydrosysid export` lists them",
            near.unwrap_or_default()
        ))
    })?;
    let ending = place.and_then(|path| path.extension()).and_then(|end| end.to_str());
    let target = target.for_ending(ending);
    if place.is_none() && (target.is_binary() || output.json_on_stdout()) {
        return Err(Failure::Argument("give the file to write with --output".into()));
    }
    let inertia = match a.inertia.as_slice() {
        [] => None,
        [x, y, z] => Some([*x, *y, *z]),
        _ => return Err(Failure::Argument("--inertia takes three numbers: IXX,IYY,IZZ".into())),
    };
    let at: BTreeMap<String, f64> = a.at.iter().cloned().collect();
    let (link, version) = (a.link.clone(), a.target_version.clone());
    let options = ExportOptions { link, mass: a.mass, inertia, at, acting: a.acting, version };
    let made = export::export(file, target, &options)?;
    let Some(path) = place else {
        output.hand_over(&String::from_utf8_lossy(&made.bytes));
        output.json(&made)?;
        return output.tell(&made.warnings);
    };
    output.write(path, &made.bytes)?;
    output.print(&wrapped(&format!("{} written for {}: {}", path.display(), target.name(), target.version())));
    output.json(&made)?;
    output.tell(&made.warnings)?;
    let verb = if target.takes_campaign() { "fit" } else { "plan" };
    answer::next(&format!("hydrosysid {verb} {}", file.display()), output);
    Ok(())
}

fn list(a: &Export, output: &Output) -> Result<(), Failure> {
    if a.file.is_some() {
        return Err(Failure::Argument("give the target with --to; `hydrosysid export` lists them".into()));
    }
    let takes = |t: Target| if t.takes_campaign() { "campaign" } else { "model" };
    let all: Vec<Listed> =
        Target::ALL.iter().map(|t| Listed { target: *t, version: t.version(), takes: takes(*t) }).collect();
    let rows: Vec<Vec<String>> =
        all.iter().map(|l| vec![l.target.name().into(), l.takes.into(), l.version.into()]).collect();
    output.print(&format!("{} for simulators, control design and papers.", count(rows.len(), "target")));
    output.print(&table(&["target", "takes", "for"], &rows));
    output.json(&all)?;
    answer::next("hydrosysid export model.toml --to gazebo-added-mass -o vehicle.sdf", output);
    Ok(())
}
