//! The verb `compare` with published parameters: values from the literature against the user's own
//! log.
//!
//! ```text
//! z = (published − own)/√(σ_published² + σ_own²)
//! ```
//!
//! The file is TOML. `convention = "sname"`: names and signs of SNAME (`X_u|u|` negative where it
//! brakes, `X_udot` the negative of the added mass); `"hydrosysid"`: names and signs of this crate
//! (positive drag, virtual mass); `"fossen"`: diagonals of M_A, M_RB, D, D_n, positive, in the
//! order of ν.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::codes;
use super::compare::{Comparison, compare};
use super::difference::{COVER, two_sided};
use super::error::Error;
use super::fit::described;
use super::load::Campaign;
use super::noise::Noise;
use super::vehicles::vehicle;
use crate::compare::Disagreement;
use crate::effects::catalogue;
use crate::envelope::Envelope;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::{Model, Parameter, name_of, places_of};
use crate::nearest::nearest;
use crate::vehicle::Vehicle;

/// Names and signs of a file of parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Convention {
    /// SNAME's names and signs.
    Sname,
    /// The names and signs of this crate.
    Hydrosysid,
    /// Diagonals of Fossen's matrices.
    Fossen,
}

/// A published value.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
enum Given {
    Plain(f64),
    #[serde(rename_all = "snake_case")]
    Measured {
        value: f64,
        std: Option<f64>,
    },
}

/// A file of published parameters.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: i64,
    convention: Convention,
    #[serde(default)]
    source: String,
    /// Dry mass that belongs to SNAME's added mass, kg; that of the campaign if absent.
    mass: Option<f64>,
    /// Dry moments of inertia, kg·m².
    inertia: Option<[f64; 3]>,
    #[serde(default)]
    parameters: BTreeMap<String, Given>,
    #[serde(rename = "M_A")]
    added: Option<[f64; 6]>,
    #[serde(rename = "M_RB")]
    rigid: Option<[f64; 6]>,
    #[serde(rename = "D")]
    linear: Option<[f64; 6]>,
    #[serde(rename = "D_n")]
    quadratic: Option<[f64; 6]>,
}

/// Published parameters, in the signs of this crate.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Their source, as stated in their file.
    pub source: String,
    /// Term, symbol, value, standard deviation.
    values: Vec<(String, String, f64, Option<f64>)>,
}

/// A campaign compared with published parameters. Serialises as `hydrosysid compare --params --json`.
#[derive(Debug, Clone, Serialize)]
pub struct PublishedComparison {
    /// Format of the result: 1.
    pub format: u32,
    /// Source of the published parameters.
    pub source: String,
    /// Errors of the published model in each run and degree of freedom.
    pub runs: Vec<Disagreement>,
    /// Errors of the own model in the same.
    pub own_runs: Vec<Disagreement>,
    /// Noise with which the published model explains the runs best, and its prediction errors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
    /// Noise of the own model, and its prediction errors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_noise: Option<Noise>,
    /// Each parameter with the own estimate.
    pub parameters: Vec<PublishedParameter>,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
}

/// A parameter with the own estimate of it, in the signs of this crate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PublishedParameter {
    /// Term that reads it.
    pub effect: String,
    /// Symbol.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// SNAME's name.
    pub sname: Option<String>,
    /// Published value; `null` if it is not published and the own one was taken.
    pub published: Option<f64>,
    /// Standard deviation of `published`, if it is published.
    pub published_std: Option<f64>,
    /// Own estimate; `null` if the own model has no such term.
    pub own: Option<f64>,
    /// Standard deviation of `own`.
    pub own_std: Option<f64>,
    /// 95 % confidence interval of the own value.
    pub interval: Option<[f64; 2]>,
    /// Published minus own value, in standard deviations of the difference.
    pub z: Option<f64>,
    /// Probability of so large a difference by chance.
    pub p_value: Option<f64>,
}

impl Published {
    /// Reads a file of published parameters for the model of a campaign. If `path` is the name of a
    /// vehicle that comes with the program, or a vehicle file, its `[published]` table is read.
    ///
    /// # Errors
    /// [`Error::Parameters`] naming the file and the key.
    pub fn read(path: &Path, campaign: &Campaign) -> Result<Published, Error> {
        let failed = |message: String| Error::Parameters { file: path.to_path_buf(), message };
        let name = path.to_string_lossy();
        if !path.exists() || vehicle(&name).is_ok_and(|known| known.file.published.is_some()) {
            let known = vehicle(&name).map_err(|e| failed(e.to_string()))?;
            let published = known.file.published.ok_or_else(|| failed("the vehicle has no [published]".into()))?;
            return Published::parse(&published.to_string(), path, campaign);
        }
        let text = crate::text_file::read(path).map_err(|e| failed(e.to_string()))?;
        Published::parse(&text, path, campaign)
    }

    /// Reads the text of such a file; messages name `path`.
    ///
    /// # Errors
    /// As [`Published::read`].
    pub fn parse(text: &str, path: &Path, campaign: &Campaign) -> Result<Published, Error> {
        Published::of_vehicle(text, path, &campaign.vehicle, &campaign.model)
    }

    /// The same for a vehicle and a model. Names that no term of the model has are looked up in the
    /// catalogue.
    pub(super) fn of_vehicle(text: &str, path: &Path, vehicle: &Vehicle, model: &Model) -> Result<Published, Error> {
        let failed = |message: String| Error::Parameters { file: path.to_path_buf(), message };
        let file: File = toml::from_str(text).map_err(|e| failed(e.to_string().trim_end().to_string()))?;
        if file.format != 1 {
            return Err(failed(format!("format = {}: this version reads format 1", file.format)));
        }
        let mut given: BTreeMap<String, Given> = file.parameters.clone();
        let matrices = [("M_A", file.added), ("M_RB", file.rigid), ("D", file.linear), ("D_n", file.quadratic)];
        let some: Vec<&str> = matrices.iter().filter(|(_, m)| m.is_some()).map(|(name, _)| *name).collect();
        match (file.convention, some.as_slice()) {
            (Convention::Fossen, []) => {
                return Err(failed("convention = \"fossen\" needs M_A, D or D_n: six numbers each".into()));
            }
            (Convention::Fossen, _) if !given.is_empty() => {
                return Err(failed("convention = \"fossen\" takes M_A, M_RB, D and D_n, not [parameters]".into()));
            }
            (Convention::Fossen, _) => given = snames(&file),
            (_, [name, ..]) => return Err(failed(format!("{name} belongs to convention = \"fossen\""))),
            (_, []) => {}
        }
        let own = file.convention == Convention::Hydrosysid;
        let mass = file.mass.or(file.rigid.map(|m| m[0])).or(vehicle.mass);
        let dry = Dry { vehicle: Vehicle { mass, ..vehicle.clone() }, inertia: inertia(&file) };
        let mut values = Vec::new();
        for (key, value) in given {
            let (number, std) = match value {
                Given::Plain(value) => (value, None),
                Given::Measured { value, std } => (value, std),
            };
            if !number.is_finite() || std.is_some_and(|s| !(s.is_finite() && s >= 0.0)) {
                return Err(failed(format!("`{key}`: value and std must be finite numbers, and std not below 0")));
            }
            let (term, symbol) = find(&key, own, model).ok_or_else(|| {
                failed(format!("`{key}` is not a parameter that this version knows{}", hint(&key, own, model)))
            })?;
            let number = if own { number } else { dry.turned(&key, number).map_err(failed)? };
            // matrices of Fossen also have entries for degrees of freedom that are not modelled
            if file.convention == Convention::Fossen && !model.dofs.iter().any(|d| term.contains(d.name())) {
                continue;
            }
            values.push((term, symbol, number, std));
        }
        if values.is_empty() {
            return Err(failed("it has no parameter that this campaign needs".into()));
        }
        Ok(Published { source: file.source, values })
    }

    /// Returns term, symbol, value and standard deviation of each parameter, SI, in the signs of
    /// this crate.
    pub fn values(&self) -> impl Iterator<Item = (&str, &str, f64, Option<f64>)> {
        self.values.iter().map(|(term, symbol, value, std)| (term.as_str(), symbol.as_str(), *value, *std))
    }

    /// Returns the own model with the published values; absent terms are added.
    fn model(&self, own: &Model, path: &Path) -> Result<Model, Error> {
        let mut model = own.clone();
        for (term, symbol, value, std) in &self.values {
            if model.term(term).is_none() {
                model
                    .add_named(term)
                    .map_err(|e| Error::Parameters { file: path.to_path_buf(), message: e.to_string() })?;
            }
            if let Some(p) = model.parameter(term, symbol) {
                model.parameters[p].value = *value;
                model.parameters[p].std = *std;
                model.parameters[p].per_run.clear();
            }
        }
        Ok(model)
    }
}

/// Dry mass and inertias to which added masses are added.
struct Dry {
    vehicle: Vehicle,
    inertia: Option<[f64; 3]>,
}

impl Dry {
    /// Converts a value of SNAME to the signs of this crate.
    fn turned(&self, key: &str, value: f64) -> Result<f64, String> {
        let all = || Dof::ALL.into_iter();
        let named = |row: Dof, column: Dof| key == format!("{}_{}dot", row.sname(), column.velocity());
        let Some((row, column)) = all().flat_map(|r| all().map(move |c| (r, c))).find(|(r, c)| named(*r, *c)) else {
            return Ok(-value);
        };
        let turns = row == column && row.is_rotation();
        let dry = match row == column {
            true if turns => self.inertia.map(|i| i[row.index() - 3]),
            true => self.vehicle.mass,
            false => self.vehicle.dry_coupling(row, column),
        };
        let what = if turns { "the dry `inertia`, as in inertia = [Ixx, Iyy, Izz]" } else { "the dry `mass`" };
        dry.map(|dry| dry - value)
            .ok_or_else(|| format!("`{key}` is added mass alone: it needs {what}, to give the virtual mass"))
    }
}

fn inertia(file: &File) -> Option<[f64; 3]> {
    file.inertia.or(file.rigid.map(|m| [m[3], m[4], m[5]]))
}

/// Returns the diagonals of Fossen's matrices under SNAME's names.
fn snames(file: &File) -> BTreeMap<String, Given> {
    let mut all = BTreeMap::new();
    for dof in Dof::ALL {
        let (row, v) = (dof.sname(), dof.velocity());
        let named = [
            (file.added, format!("{row}_{v}dot")),
            (file.linear, format!("{row}_{v}")),
            (file.quadratic, format!("{row}_{v}|{v}|")),
        ];
        for (matrix, name) in named {
            if let Some(m) = matrix {
                all.insert(name, Given::Plain(-m[dof.index()]));
            }
        }
    }
    all
}

/// Returns term and symbol of a name: those of a term of the model, otherwise of any term that may
/// be in it.
fn find(key: &str, own: bool, model: &Model) -> Option<(String, String)> {
    let (term, symbol) = key.split_once(' ').map_or((None, key), |(term, symbol)| (Some(term), symbol));
    let matches =
        |p: &crate::effects::ParameterSpec| if own { p.name == symbol } else { p.sname.as_deref() == Some(symbol) };
    for t in model.terms.iter().filter(|t| term.is_none_or(|name| t.name() == name)) {
        if own && term.is_none() && t.name() == key {
            return t.parameters.first().map(|p| (key.to_string(), model.parameters[*p].spec.name.clone()));
        }
        if let Some(p) = t.parameters.iter().find(|p| matches(&model.parameters[**p].spec)) {
            return Some((t.name(), model.parameters[*p].spec.name.clone()));
        }
    }
    let known = catalogue(model.coriolis);
    known.iter().find_map(|effect| {
        places_of(effect.as_ref(), &Dof::ALL).into_iter().find_map(|place| {
            let name = name_of(effect.about().id, place);
            let found = effect.parameters(place).into_iter().find(|p| matches(p) || (own && key == name))?;
            (term.is_none_or(|t| t == name)).then_some((name, found.name))
        })
    })
}

fn hint(key: &str, own: bool, model: &Model) -> String {
    let names: Vec<String> = model
        .parameters
        .iter()
        .filter_map(|p| if own { Some(p.spec.name.clone()) } else { p.spec.sname.clone() })
        .collect();
    match nearest(key, names.iter().map(String::as_str)) {
        Some(near) => format!(", did you mean `{near}`?"),
        None => format!("; the campaign's model has {}", names.join(", ")),
    }
}

/// Compares published parameters with the runs of a campaign and with its own fitted model.
///
/// # Errors
/// [`Error`] if a term cannot be in the model or a run lacks what it reads.
pub fn compare_published(
    campaign: &Campaign,
    own: &Model,
    envelope: &Envelope,
    published: &Published,
    path: &Path,
) -> Result<PublishedComparison, Error> {
    let model = published.model(own, path)?;
    // the noise belongs to the own model: a published model leaves other noise
    let Comparison { runs, noise, mut warnings, .. } = compare(&campaign.clone().with_noise(None), &model, envelope)?;
    let Comparison { runs: own_runs, noise: own_noise, .. } = compare(campaign, own, envelope)?;
    let parameters: Vec<PublishedParameter> =
        model.parameters.iter().map(|p| beside(p, own, published, campaign)).collect();
    let taken: Vec<String> =
        parameters.iter().filter(|p| p.published.is_none()).map(|p| format!("{} of `{}`", p.name, p.effect)).collect();
    if !taken.is_empty() {
        let text = format!("not published, taken from the campaign's own model: {}", taken.join(", "));
        warnings.push(Finding::new(&codes::NOT_PUBLISHED, text));
    }
    Ok(PublishedComparison {
        format: 1,
        source: published.source.clone(),
        runs,
        own_runs,
        noise,
        own_noise,
        parameters,
        warnings,
    })
}

fn beside(p: &Parameter, own: &Model, published: &Published, campaign: &Campaign) -> PublishedParameter {
    let told = described(p, None, &campaign.vehicle, &[]);
    let given = published
        .values
        .iter()
        .find(|(term, symbol, ..)| *symbol == p.spec.name && (*term == p.term || p.spec.shared.is_some()));
    let mine = own.parameter(&p.term, &p.spec.name).map(|k| &own.parameters[k]);
    let own_std = mine.and_then(|m| if m.fixed { Some(0.0) } else { m.std });
    let std = own_std.map(|s| s.hypot(given.and_then(|g| g.3).unwrap_or(0.0))).filter(|s| *s > 0.0 && s.is_finite());
    let z = given.zip(mine).zip(std).map(|((g, m), s)| (g.2 - m.value) / s);
    PublishedParameter {
        effect: p.term.clone(),
        name: p.spec.name.clone(),
        unit: p.spec.dimension.to_string(),
        sname: told.sname,
        published: given.map(|g| g.2),
        published_std: given.and_then(|g| g.3),
        own: mine.map(|m| m.value),
        own_std,
        interval: mine.zip(own_std).map(|(m, s)| [m.value - COVER * s, m.value + COVER * s]),
        z,
        p_value: z.map(two_sided),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coupling_has_its_m_r_g_back() {
        let vehicle = Vehicle { mass: Some(200.0), cg: Some([0.05, 0.0, 0.03]), ..Vehicle::default() };
        let dry = Dry { vehicle, inertia: None };
        // m_uq = m z_g − X_q̇, m_vp = −m z_g − Y_ṗ, m_vr = m x_g − Y_ṙ
        for (key, value, own) in
            [("X_qdot", -3.0, 9.0), ("Y_pdot", 2.0, -8.0), ("Y_rdot", 4.0, 6.0), ("X_vdot", -1.0, 1.0)]
        {
            let turned = dry.turned(key, value).unwrap();
            assert!((turned - own).abs() < 1e-12, "{key}: {turned}");
        }
        assert_eq!(dry.turned("X_u", -20.0), Ok(20.0));
        let unknown = Dry { vehicle: Vehicle::default(), inertia: None };
        assert!(unknown.turned("X_qdot", -3.0).unwrap_err().contains("dry `mass`"));
    }
}
