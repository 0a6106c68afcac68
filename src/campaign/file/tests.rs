use std::path::Path;

use proptest::prelude::*;

use super::*;
use crate::effects::Family;
use crate::frame::Dof;
use crate::procedure::Align;
use crate::run::{Role, RunKind};
use crate::thrust::efficiency::AdvanceSpeed;

/// The smallest campaign that can be read, on nine lines.
const LEAST: &str = "format = 1\n[vehicle]\nname = 'LAURS'\nmass = 189\n[model]\ndofs = ['surge', 'yaw']\n\
    effects = ['inertia', 'linear_drag@surge']\n[[run]]\nfile = 'a.csv'\n";

fn without_files() -> ReadOptions {
    ReadOptions { look_for_files: false, ..ReadOptions::default() }
}

fn read(text: &str) -> Result<CampaignFile, CampaignErrors> {
    CampaignFile::from_bytes(text.as_bytes(), Path::new("c.toml"), &without_files())
}

/// Returns `line:column: key: what` of every error.
fn wrong(text: &str) -> Vec<String> {
    let errors = read(text).unwrap_err();
    assert!(!errors.errors.is_empty());
    errors.errors.iter().map(|e| e.to_string().trim_start_matches("c.toml:").to_string()).collect()
}

/// A campaign that uses every table.
const FULL: &str = r#"format = 1
seed = 7
[vehicle]
name = "LAURS"
mass = 189
volume = 0.19
weight = 1854.1
buoyancy = 1887.5
cg = [0, 0, 0.02]
[water]
density = 1025.0
[noise]
u = 0.005
r = 3e-3
[model]
dofs = ["surge", "sway", "yaw"]
effects = ["inertia", "linear_drag", "quadratic_drag@surge", "added_mass_coupling@surge:pitch", "my_wind"]
coriolis = "free"
input = "hold"
[[parameter]]
effect = "quadratic_drag@surge"
value = 309.07
fixed = true
[[parameter]]
effect = "thruster_fault@surge"
name = "k"
min = -inf
max = 1
[[parameter]]
effect = "thruster_fault@surge"
name = "t_0"
value = 3.0
std = 0.5
[[effect]]
id = "my_wind"
dof = "surge"
formula = "wind_speed^2 * cos(wind_dir - psi)"
unit = "kg/m"
role = "baseline"
[[observe]]
channel = "depth_rate"
formula = "u * sin(theta)"
[[thruster]]
name = "T5"
position = [-0.4, 0.2, 0]
axis = [1, 0, 0]
forward = { a = 11.53, b = 4.21 }
reverse = { a = 7.87, b = 4.68 }
[efficiency]
eta_inter = [{ dof = "surge", thrusters = ["T5"], value = 1.0 }, { dof = "yaw", value = 0.97 }]
eta_adv = { slope = -0.1946, intercept = 0.9967, valid = [0, 1] }
advance_speed = "thruster_axis"
[stage.steady]
drift = 0.02
[stage.zigzag]
window = 3
filter = { window = { samples = 9 }, degree = 2 }
align = "previous"
[discover]
level = 0.05
families = ["body", "actuator"]
seed = 11
[[run]]
file = "surge_p28.csv"
kind = "oscillatory"
role = "train"
from = 1
to = 60.5
where = "abs(theta) > 0.2"
resample = 4
input = "linear"
[[run]]
file = ["nav.csv", { file = "imu.csv", clock_offset = 0.12 }]
kind = "zigzag"
role = "validate"
"#;

#[test]
fn every_table_is_read() {
    let c = read(FULL).unwrap();
    assert_eq!((c.format, c.seed, c.discover.seed), (1, 7, Some(11)));
    assert_eq!(c.vehicle.mass, Some(189.0));
    assert_eq!((c.water.density, c.water.kinematic_viscosity), (1025.0, Water::default().kinematic_viscosity));
    assert_eq!(c.noise.sensors["r"], 0.003);
    assert_eq!(c.model.dofs, [Dof::Surge, Dof::Sway, Dof::Yaw]);
    assert_eq!((c.model.effects.len(), c.model.coriolis), (5, Coriolis::Free));
    assert_eq!(c.model.effects[3].other, Some(Dof::Pitch));
    assert_eq!((c.parameters[0].value, c.parameters[0].fixed), (Some(309.07), true));
    assert_eq!((c.parameters[1].min, c.parameters[2].std), (Some(f64::NEG_INFINITY), Some(0.5)));
    assert_eq!((c.effects[0].unit.to_string(), c.effects[0].role), ("kg/m".to_string(), EffectRole::Baseline));
    assert_eq!(c.observed[0].formula, "u * sin(theta)");
    assert_eq!(c.efficiency.eta_inter.0[0].thrusters, ["T5"]);
    assert_eq!(c.efficiency.advance_speed, AdvanceSpeed::ThrusterAxis);
    assert_eq!((c.stage.zigzag.window, c.stage.zigzag.align), (3, Align::Previous));
    assert_eq!(c.discover.families, [Family::Body, Family::Actuator]);
    assert_eq!((c.runs[0].kind, c.runs[0].role), (RunKind::Oscillatory, Role::Train));
    assert_eq!(c.runs[0].condition.as_deref(), Some("abs(theta) > 0.2"));
    assert_eq!(c.runs[1].files[1], RunFile { file: "imu.csv".into(), clock_offset: 0.12, log: None });
    assert_eq!(c.path_of(&c.runs[0].files[0]), Path::new("./surge_p28.csv"));
}

#[test]
fn law_what_is_written_reads_back() {
    for text in [LEAST, FULL] {
        let first = CampaignFile { source: None, ..read(text).unwrap() };
        let again = read(&first.to_toml().unwrap()).unwrap();
        assert_eq!(CampaignFile { source: None, ..again }, first);
    }
}

#[test]
fn formulas_keep_their_place() {
    let source = read(FULL).unwrap().source.unwrap();
    let place = source.locate("effect[0].formula").unwrap();
    assert_eq!((place.line, place.column), (37, 11));
    assert_eq!(&source.text[place.span], "\"wind_speed^2 * cos(wind_dir - psi)\"");
    assert_eq!(&source.text[place.key], "formula");
    assert_eq!(source.locate("run[0].where").map(|l| l.line), Some(69));
    assert_eq!(source.locate("run[1].where"), None);
    let error = source.error_at("run[0].where", Problem::Empty { right: "a condition" });
    assert_eq!(error.to_string(), "c.toml:69:9: run[0].where: is empty: a condition");
    assert_eq!(error.value.as_deref(), Some("\"abs(theta) > 0.2\""));
}

/// Checks that [`LEAST`] with `old` replaced by `new` is wrong, and that this is all that is
/// reported.
#[track_caller]
fn refused(old: &str, new: &str, told: &[&str]) {
    assert!(LEAST.contains(old), "{old}");
    assert_eq!(wrong(&LEAST.replace(old, new)), told, "{new}");
}

#[test]
fn unknown_keys_name_the_nearest() {
    refused("mass", "mas", &["4:1: vehicle.mas: unknown key `mas`, did you mean `mass`?"]);
    let told =
        "1:7: stage.filter: unknown key `filter`; there are bollard, steady, oscillatory, zigzag, direct, std, rates";
    refused("format = 1", "stage.filter = 1\nformat = 1", &[told]);
    let told = "9:20: run[0].file[0].clock_ofset: unknown key `clock_ofset`, did you mean `clock_offset`?";
    refused("'a.csv'", "[{file='a', clock_ofset=1}]", &[told]);
}

#[test]
fn unknown_words_name_the_nearest() {
    refused("'surge', 'yaw'", "'sruge', 'yaw'", &["6:9: model.dofs[0]: unknown word `sruge`, did you mean `surge`?"]);
    refused("'a.csv'", "'a.csv'\nkind = 'zigzg'", &["10:8: run[0].kind: unknown word `zigzg`, did you mean `zigzag`?"]);
    let told = "10:8: run[0].role: unknown word `test`; there are train, validate";
    refused("'a.csv'", "'a.csv'\nrole = 'test'", &[told]);
    let told = "7:12: model.effects[0]: no effect is called `inertai`, did you mean `inertia`?; `hydrosysid effects` lists them";
    refused("'inertia'", "'inertai'", &[told]);
    let told = "7:23: model.effects[1]: \"linear_drag@sirge\": `sirge` is not a degree of freedom, did you mean \
                `surge`?; these are surge, sway, heave, roll, pitch and yaw";
    refused("linear_drag@surge", "linear_drag@sirge", &[told]);
    let own = "[[effect]]\nid = 'sail'\ndof = 'surge'\nformula = 'W'\nunit = 'furlong'\n[[run]]";
    let told = "12:8: effect[0].unit: \"furlong\" is no SI unit: `furlong` is none of 1, kg, m, s, N, rad, each with a \
                power, as in `kg/m` or `N*m*s2`";
    refused("[[run]]", own, &[told]);
}

#[test]
fn thrusters_without_a_place_are_told_once() {
    let head = "format = 1\n[model]\ndofs = ['surge']\neffects = ['inertia']\n[[run]]\nfile = 'a.csv'\n";
    let thruster = |k: usize| format!("[[thruster]]\nname = '{k}'\nforward = {{a = 1, b = 0}}\n");
    let text: String = std::iter::once(head.to_string()).chain((1..=8).map(thruster)).collect();
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let errors = CampaignFile::from_bytes(text.as_bytes(), Path::new("c.toml"), &options).unwrap_err().errors;
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert!(errors[0].to_string().contains("8 thrusters"), "{}", errors[0]);
}

#[test]
fn wrong_types_say_what_is_wanted() {
    refused("189", "'heavy'", &["4:8: vehicle.mass: string \"heavy\" found where a number is expected"]);
    refused(
        "'a.csv'",
        "3",
        &["9:8: run[0].file: integer 3 found where a path, a table {file, clock_offset, log}, or a list of them is \
             expected"],
    );
    refused(
        "'a.csv'",
        "'a.csv'\nrole = 3",
        &["10:8: run[0].role: another type found where a word in quotes is expected"],
    );
    refused("[[run]]", "[run]", &["8:1: run: a table found where a list of tables, with [[ ]], is expected"]);
    refused("format = 1", "format = '1'", &["1:10: format: string \"1\" found where a whole number is expected"]);
    let told = "2:8: seed: integer -1 found where a whole number, 0 or more is expected";
    refused("format = 1", "format = 1\nseed = -1", &[told]);
    refused("mass = 189", "cg = [0, 1]", &["4:6: vehicle.cg: 2 values found where a list of 3 is expected"]);
}

#[test]
fn what_must_be_there_is_asked_for() {
    refused("format = 1", "", &["1:1: format: `format` is missing: the file starts with format = 1"]);
    refused("[[run]]\nfile = 'a.csv'\n", "", &["1:1: run: no run: add a [[run]] table with at least `file`"]);
    let told =
        "5:1: model: `dofs` is missing: the degrees of freedom to model, as in dofs = [\"surge\", \"sway\", \"yaw\"]";
    refused("dofs = ['surge', 'yaw']\n", "", &[told]);
    let told = "8:1: run[0]: `file` is missing: the log, relative to the campaign file, as in file = \"run01.csv\"";
    refused("file = 'a.csv'", "kind = 'free'", &[told]);
    refused(
        "'surge', 'yaw'",
        "",
        &["6:8: model.dofs: is empty: list the degrees of freedom to model, as in [\"surge\", \"sway\", \"yaw\"]"],
    );
    refused("'a.csv'", "[]", &["9:8: run[0].file: is empty: a run needs at least one log"]);
    refused("'a.csv'", "' '", &["9:8: run[0].file: is empty: the path of a log"]);
    refused(
        "'a.csv'",
        "'a.csv'\nwhere = ''",
        &["10:9: run[0].where: is empty: a condition such as \"abs(theta) > 0.2\""],
    );
}

#[test]
fn another_format_is_all_that_is_told() {
    refused(
        "format = 1",
        "format = 2\nnew_key = 3",
        &["1:10: format: format 2 is not known: this version reads format 1"],
    );
}

#[test]
fn syntax_has_line_and_column() {
    refused("189", "1\nmass = 2", &["5:1: duplicate key `mass`: keep one"]);
    let errors = wrong(&LEAST.replace("'yaw']", "'yaw'").replace("format = 1", "format = 1 1"));
    assert!(errors.len() >= 2 && errors[0].starts_with("1:10: "), "{errors:?}");
}

#[test]
fn contradictions_are_refused() {
    let parameter = |lines: &str, told: &[&str]| {
        refused("[[run]]", &format!("[[parameter]]\neffect = 'inertia@yaw'\n{lines}\n[[run]]"), told);
    };
    parameter("fixed = true", &["10:9: parameter[0].fixed: `inertia@yaw` is fixed, but has no value: add `value`"]);
    parameter(
        "std = 1",
        &["10:7: parameter[0].std: `std` is the standard deviation of a prior around `value`: add `value`"],
    );
    parameter(
        "value = 1\nstd = 1\nfixed = true",
        &["11:7: parameter[0].std: `fixed` holds the value, `std` lets it vary: keep one"],
    );
    parameter(
        "value = 1\nstd = -1",
        &["11:7: parameter[0].std: -1 is not valid here: a standard deviation must be above 0"],
    );
    parameter("min = 2\nmax = 1", &["10:7: parameter[0].min: min = 2 is above max = 1"]);
    parameter("value = 3\nmax = 2.5", &["10:9: parameter[0].value: value = 3 is outside min = -inf, max = 2.5"]);
    parameter(
        "tie = 'inertia@surge'\nvalue = 3",
        &["11:9: parameter[0].value: `tie` makes it equal to another parameter, which has the value, bounds and \
             prior: remove `value` here"],
    );
    parameter(
        "[[parameter]]\neffect = 'inertia'",
        &["11:10: parameter[1].effect: the parameter of `inertia` is given twice, first in line 9: keep one"],
    );
    refused("'a.csv'", "'a.csv'\nfrom = 5\nto = 4", &["10:8: run[0].from: from = 5 is not before to = 4"]);
    refused(
        "'a.csv'",
        "['a.csv', 'a.csv']",
        &["9:18: run[0].file[1]: \"a.csv\" is given twice, first in line 9: keep one"],
    );
    refused(
        "'inertia'",
        "'inertia', 'inertia@yaw'",
        &["7:23: model.effects[1]: `inertia@yaw` is given twice, first in line 7: keep one"],
    );
    refused("'yaw'", "'yaw', 'surge'", &["6:25: model.dofs[2]: surge is given twice, first in line 6: keep one"]);
    refused(
        "linear_drag@surge",
        "linear_drag@sway",
        &["7:23: model.effects[1]: `sway` is not among the `dofs` of [model]: add it there, or leave this out"],
    );
    refused(
        "dofs = ",
        "undriven = ['sway']\ndofs = ",
        &["6:13: model.undriven[0]: `sway` is not among the `dofs` of [model]: add it there, or leave this out"],
    );
}

#[test]
fn numbers_that_cannot_be_are_refused() {
    refused("189", "nan", &["4:8: vehicle.mass: must be a finite number"]);
    refused(
        "189",
        "-1\nvolume = 0",
        &[
            "4:8: vehicle.mass: [vehicle] mass = -1: must be a positive number of kg",
            "5:10: vehicle.volume: [vehicle] volume = 0: must be a positive number of m3",
        ],
    );
    refused(
        "[model]",
        "[noise]\nu = 0\n[model]",
        &["6:5: noise.u: 0 is not valid here: a standard deviation must be above 0"],
    );
    refused(
        "'a.csv'",
        "'a.csv'\nresample = -4",
        &["10:12: run[0].resample: -4 is not valid here: a rate in Hz above 0"],
    );
    refused(
        "[[run]]",
        "[stage.direct]\nfilter = { window = { samples = 4 }, degree = 2 }\n[[run]]",
        &["9:33: stage.direct.filter.window.samples: 4 is not valid here: an odd number of samples"],
    );
    refused(
        "[[run]]",
        "[efficiency]\neta_inter = { surge = 0 }\n[[run]]",
        &["9:13: efficiency.eta_inter: eta_inter of surge = 0: must be a positive number, near 1"],
    );
    refused(
        "[[run]]",
        "[efficiency.eta_adv]\nslope = -0.2\nintercept = -1\nvalid = [0, 1]\n[[run]]",
        &[
            "8:1: efficiency.eta_adv: eta_adv { slope = -0.2, intercept = -1, valid = [0.0, 1.0] }: needs a positive intercept and a range of speeds from 0 or above",
        ],
    );
    refused(
        "[[run]]",
        "[discover]\nlevel = 1.5\nfamilies = []\n[[run]]",
        &[
            "9:9: discover.level: 1.5 is not valid here: between 0 and 1, such as 0.01",
            "10:12: discover.families: is empty: body, actuator, environment, sensor",
        ],
    );
}

#[test]
fn own_effects_and_thrusters_have_names_of_their_own() {
    let sail = "[[effect]]\nid = 'ID'\ndof = 'surge'\nformula = 'W'\nunit = 'N'\n";
    let two = format!("{}{}[[run]]", sail.replace("ID", "sail"), sail.replace("ID", "sail"));
    refused("[[run]]", &two, &["14:6: effect[1].id: `sail` is given twice, first in line 9: keep one"]);
    let taken = "9:6: effect[0].id: `bias` is an effect of the catalogue: choose another id for your own";
    refused("[[run]]", &format!("{}[[run]]", sail.replace("ID", "bias")), &[taken]);
    let dofs = FULL.replace("thrusters = [\"T5\"]", "thrusters = [\"T6\"]");
    assert_eq!(wrong(&dofs), ["50:44: efficiency.eta_inter[0].thrusters[0]: unknown word `T6`, did you mean `T5`?"]);
    assert_eq!(
        wrong(&FULL.replace("axis = [1, 0, 0]", "axis = [0, 0, 0]")),
        ["46:8: thruster[0].axis: thruster \"T5\": axis = [0.0, 0.0, 0.0] must be three finite numbers, not all zero",]
    );
}

#[test]
fn several_problems_are_all_told_in_order_up_to_twenty() {
    let text =
        LEAST.replace("mass", "mas").replace("'inertia'", "'inertai'").replace("'a.csv'", "'a.csv'\nfrom = 'now'");
    let lines: Vec<usize> = read(&text).unwrap_err().errors.iter().map(|e| e.location.clone().unwrap().line).collect();
    assert_eq!(lines, [4, 7, 10]);
    let many: String = (10..40).map(|i| format!("key_{i} = 1\n")).collect();
    let errors = read(&format!("{LEAST}{many}")).unwrap_err();
    assert_eq!((errors.errors.len(), errors.more), (CampaignErrors::MOST, true));
}

#[test]
fn columns_count_characters_and_bytes_that_are_no_text_are_shown() {
    let told = wrong("\u{feff}format = 2\n");
    assert_eq!(told, ["1:10: format: format 2 is not known: this version reads format 1"]);
    assert!(wrong(&LEAST.replace("name = 'LAURS'", "\"größe\" = 1"))[0].starts_with("3:1: vehicle.größe"));
    let after = LEAST.replace("'surge', 'yaw'", "'süd', 'nord'");
    assert!(wrong(&after)[1].starts_with("6:16: model.dofs[1]"), "{:?}", wrong(&after));
    let errors = CampaignFile::from_bytes(b"\xa3\x95\x80\x80Y", Path::new("dive.BIN"), &without_files());
    let text = errors.unwrap_err().to_string();
    assert!(text.starts_with("dive.BIN:1:1: this is an ArduPilot DataFlash log, not a campaign file"), "{text}");
    assert!(text.contains("hydrosysid init LOG") && text.contains("hydrosysid[ardupilot]"), "{text}");
    let errors = CampaignFile::from_bytes(b"format = 1\nname = '\xff'", Path::new("c.toml"), &without_files());
    let text = errors.unwrap_err().to_string();
    assert_eq!(text, "c.toml:2:9: byte 0xff is not UTF-8: save the file as UTF-8 text");
}

#[test]
fn errors_keep_value_and_bytes_of_key_and_value() {
    let errors = read(&LEAST.replace("189", "'heavy'")).unwrap_err();
    let location = errors.errors[0].location.clone().unwrap();
    assert_eq!(&errors.text[location.span], "'heavy'");
    assert_eq!(&errors.text[location.key], "mass");
    assert_eq!(errors.errors[0].value.as_deref(), Some("'heavy'"));
}

proptest! {
    #[test]
    fn law_arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(CampaignFile::from_bytes(&bytes, Path::new("c.toml"), &without_files()).is_err());
    }

    #[test]
    fn law_a_damaged_campaign_never_panics(at in 0.0..1.0_f64, cut in 0..12_usize, put in "\\PC{0,3}|[\\[\\]{}=\n\"',#.]{1,4}") {
        let start = (at * FULL.len() as f64) as usize;
        let end = (start + cut).min(FULL.len());
        let text = format!("{}{put}{}", &FULL[..start], &FULL[end..]);
        if let Err(errors) = read(&text) {
            prop_assert!(!errors.errors.is_empty() && errors.errors.len() <= CampaignErrors::MOST);
            prop_assert!(errors.errors.iter().all(|e| e.location.is_some()), "{}", errors);
        }
    }

    #[test]
    fn law_any_text_and_number_reads_back(name in "\\PC*", formula in "\\PC+", value in any::<f64>(), seed in any::<u64>()) {
        let mut campaign = CampaignFile { seed, source: None, ..read(FULL).unwrap() };
        campaign.vehicle.name = name;
        campaign.observed[0].formula = format!("u {formula}");
        campaign.parameters[0].value = value.is_finite().then_some(value);
        campaign.parameters[0].fixed = value.is_finite();
        let again = read(&campaign.to_toml().unwrap()).unwrap();
        prop_assert_eq!(CampaignFile { source: None, ..again }, campaign);
    }
}

#[test]
fn a_run_takes_over_the_reading_options_it_does_not_set() {
    let log = "[log]\ndelimiter = ';'\ndecimal = ','\nmissing_values = ['-']\ncolumns = { u = 'U', v = 'V' }\n";
    let text = LEAST.replace("[[run]]", &format!("{log}[[run]]\nfile = 'b.csv'\n[[run]]"));
    let text = format!("{text}log = {{ decimal = '.', columns = {{ v = 'VV' }} }}\n");
    let campaign = read(&text).unwrap();
    assert_eq!(campaign.runs[0].log, None);
    let own = campaign.runs[1].log.as_ref().unwrap();
    assert_eq!((own.delimiter, own.decimal, own.missing_values.len()), (';', '.', 1));
    assert_eq!((own.columns["u"].name.as_str(), own.columns["v"].name.as_str()), ("U", "VV"));
    let again = read(&campaign.to_toml().unwrap()).unwrap();
    assert_eq!(CampaignFile { source: None, ..again }, CampaignFile { source: None, ..campaign });
}

#[test]
fn wrong_reading_options_are_told_once_where_they_stand() {
    let run = "[[run]]\nfile = 'b.csv'\nlog = { sort = true }\n[[run]]";
    let told = "9:1: log.delimitor: unknown key `delimitor`, did you mean `delimiter`?";
    refused("[[run]]", &format!("[log]\ndelimitor = ';'\n{run}"), &[told]);
    let told = "9:11: log.decimal: decimal = ';': it must be \".\" or \",\"";
    refused("[[run]]", &format!("[log]\ndecimal = ';'\n{run}"), &[told]);
    let told = "10:12: run[0].log.missing: unknown word `nosample`, did you mean `no_sample`?";
    refused("'a.csv'", "'a.csv'\n[run.log]\nmissing = 'nosample'", &[&told.replace("10:12", "11:11")]);
}
