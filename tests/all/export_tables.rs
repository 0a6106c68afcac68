//! Tables for papers: every parameter with its SNAME name and sign, and without the dry part.

use crate::exported::*;
use hydrosysid::campaign::{self, ModelFile, ModelParameter};
use hydrosysid::effects::Coriolis;
use hydrosysid::export::{ExportOptions, Target};
use hydrosysid::frame::Dof;
use hydrosysid::model::Model;

fn rows(file: &ModelFile, options: &ExportOptions) -> Vec<csv::StringRecord> {
    let text = text(&made(file, Target::Csv, options));
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    reader.records().map(|r| r.expect("it is CSV")).collect()
}

/// SNAME name and value of the parameter of an effect at a place.
fn sname(rows: &[csv::StringRecord], effect: &str, place: &str) -> (String, String) {
    let row = rows.iter().find(|r| &r[0] == effect && &r[1] == place).expect("it is there");
    (row[6].to_string(), row[7].to_string())
}

fn pair(name: &str, value: &str) -> (String, String) {
    (name.into(), value.into())
}

#[test]
fn tables_hold_every_parameter_with_snames_sign() {
    let file = planar(&COUPLED);
    let rows = rows(&file, &ExportOptions::default());
    assert_eq!(rows.len(), file.parameters.len());
    for (row, p) in rows.iter().zip(&file.parameters) {
        assert!((row[3].parse::<f64>().expect("a number") - p.value).abs() < 1e-9 * p.value.abs().max(1.0));
    }
    assert_eq!(sname(&rows, "quadratic_drag", "surge"), pair("X_u|u|", "-120"));
    assert_eq!(sname(&rows, "inertia", "surge"), pair("X_udot", "-50"));
    let latex = text(&made(&file, Target::Latex, &ExportOptions::default()));
    assert!(latex.contains("\\begin{tabular}") && latex.contains("$X_{u|u|} = -120.0$"), "{latex}");
    assert_eq!(latex.lines().filter(|l| l.ends_with("\\\\") && l.contains('&')).count(), file.parameters.len() + 1);
}

#[test]
fn a_sign_that_ends_a_symbol_is_a_part_of_its_index() {
    let file = file(&[Dof::Heave], &[("inertia@heave", 300.0), ("drag_asymmetry@heave", 40.0)], Coriolis::Tied);
    let latex = text(&made(&file, Target::Latex, &ExportOptions::default()));
    assert!(latex.contains("& $k_{w|w|-}$ &") && latex.contains("$Z_{w|w|-} = -40.00$"), "{latex}");
}

#[test]
fn the_dry_part_is_taken_off_couplings_and_moments_of_inertia() {
    let file = floating(&[]);
    let rows = |options: &ExportOptions| rows(&file, options);
    let unknown = rows(&ExportOptions::default());
    // subtracted: m z_g = 6 from m_uq = 9, −m z_g from m_vp = −8, m x_g = 10 from m_vr = 6
    assert_eq!(sname(&unknown, "added_mass_coupling", "surge:pitch"), pair("X_qdot", "-3"));
    assert_eq!(sname(&unknown, "added_mass_coupling", "sway:roll"), pair("Y_pdot", "2"));
    assert_eq!(sname(&unknown, "added_mass_coupling", "sway:yaw"), pair("Y_rdot", "4"));
    assert_eq!(sname(&unknown, "inertia", "pitch"), pair("", ""), "the dry moment of inertia is not known");
    let given = rows(&ExportOptions { inertia: Some([20.0, 25.0, 28.0]), ..ExportOptions::default() });
    assert_eq!(sname(&given, "inertia", "pitch"), pair("M_qdot", "-20"));
    let heavier = rows(&ExportOptions { mass: Some(210.0), ..ExportOptions::default() });
    assert_eq!(sname(&heavier, "inertia", "surge"), pair("X_udot", "-40"));
}

#[test]
fn a_result_says_of_couplings_what_a_table_says() {
    let file = floating(&[]);
    let model = file.model(&[], std::path::Path::new("model.toml")).expect("a model");
    let told = |place: &str, vehicle: &hydrosysid::vehicle::Vehicle| {
        let p = model.parameters.iter().find(|p| p.term == place).expect("it is there");
        let told = campaign::described(p, None, vehicle, &[]);
        (told.sname, told.sname_value)
    };
    // m r_g is subtracted: m z_g = 6 from m_uq = 9, −m z_g from m_vp = −8
    assert_eq!(told("added_mass_coupling@surge:pitch", &file.vehicle), (Some("X_qdot".into()), Some(-3.0)));
    assert_eq!(told("added_mass_coupling@sway:roll", &file.vehicle), (Some("Y_pdot".into()), Some(2.0)));
    let weightless = hydrosysid::vehicle::Vehicle { mass: None, ..file.vehicle.clone() };
    assert_eq!(told("added_mass_coupling@surge:pitch", &weightless), (None, None), "m r_g is not known");
}

#[test]
fn a_free_row_of_coriolis_has_snames_name_in_surge_too() {
    let mut file = planar(&[]);
    file.model.coriolis = Coriolis::Free;
    for (name, value) in [("coriolis_surge", 280.0), ("coriolis_sway", 240.0), ("coriolis_yaw", 95.0)] {
        let free = Model::with_effects(&PLANAR, Coriolis::Free, &[name]).expect("it can stand there");
        let p = &free.parameters[0];
        file.parameters.push(ModelParameter {
            effect: name.into(),
            name: p.spec.name.clone(),
            value,
            std: None,
            unit: p.spec.dimension,
            fixed: false,
            per_run: Default::default(),
        });
    }
    let rows = rows(&file, &ExportOptions::default());
    let of = |effect: &str| {
        let row = rows.iter().find(|r| &r[0] == effect).expect("it is there");
        (row[6].to_string(), row[7].to_string())
    };
    // X = + k_vr v r, Y = − k_ur u r, N = − k_uv u v
    assert_eq!(of("coriolis_surge"), pair("X_vr", "280"));
    assert_eq!((of("coriolis_sway"), of("coriolis_yaw")), (pair("Y_ur", "-240"), pair("N_uv", "-95")));
}

#[test]
fn a_righting_moment_is_a_difference_of_products_in_latex() {
    let latex = text(&made(&floating(&[]), Target::Latex, &ExportOptions::default()));
    assert!(latex.contains("$z_{g} W - z_{b} B$") && latex.contains("$W - B$"), "{latex}");
}
