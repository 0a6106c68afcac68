//! `plant OUTDIR …`: a campaign folder whose truth is known.

use std::path::Path;
use std::process::ExitCode;

use hydrosysid_plant::trials::Manoeuvre;
use hydrosysid_plant::{Campaign, Commands, Dof, Hidden, Input, Pilots, PlantError, RandomForce, Suite, Vehicle, hide};

const HELP: &str = "\
Makes a campaign folder of a simulated vehicle whose truth is known (truth.json).

usage: plant OUTDIR [options]

vehicle
  --vehicle laurs|small|heavy   (small)       --dofs surge,sway,yaw | six   (the plane; heavy: six)
  --moves DOFS                  what moves, more than the model has   (as --dofs)
  --spread SHARE                coefficients about the typical ones   (0.15)
runs
  --runs N  --duration S  --lead-in S  --pilots open|closed|mixed  --bollard
  --manoeuvres LIST             in turn: a degree of freedom, zigzag, multisine, random, steps, constant, controlled,
                                constant:DOF=SHARE, bollard   (each alone, a zig-zag, all at once; the last third validates)
  --command-rate HZ  --input hold|linear  --commands wrench|thrusters
random force
  --force PERCENT               root mean square, of that of the command   (0)
  --correlation S               0: new at every command sample   (0)
  --force-of DOF=PERCENT:S      of one degree of freedom, in place of that; again for more
instruments
  --rate HZ  --noise FACTOR  --no-position  --attitude  --dvl-rate HZ  --dvl-held HZ  --dvl-noise M/S
  --dvl-latency S  --gyro-latency S  --gyro-filter S  --smoothing S  --colour PHI  --student K  --dropouts SHARE
  --outliers SHARE  --jitter S  --quantum SIGMAS
hidden
  --hide NAME[=SIZE]            again for more; size 1 is plain to see; --list names them
  --without coriolis_yaw        the plant lacks the row, the baseline has it
  --step S  --seed N
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.iter().any(|a| a == "--help" || a == "-h") || arguments.is_empty() {
        print!("{HELP}");
        return ExitCode::SUCCESS;
    }
    if arguments.iter().any(|a| a == "--list") {
        let names = hide::catalogue(&Dof::ALL, &["T1", "T2"]);
        println!("{}\noutside the catalogue:\n{}", names.join("\n"), hide::OUTSIDE.join("\n"));
        return ExitCode::SUCCESS;
    }
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("plant: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &[String]) -> Result<(), PlantError> {
    let (folder, campaign) = read(arguments)?;
    let sailed = campaign.sail()?;
    sailed.write(Path::new(&folder))?;
    println!("{folder}: {} runs of {} s, hidden: {:?}", sailed.logs.len(), campaign.duration, sailed.truth.hidden);
    for force in &sailed.truth.force {
        println!("  random force in {}: {:.4} rms, {} s", force.dof.name(), force.rms, force.correlation);
    }
    Ok(())
}

/// The folder and the campaign that the arguments describe.
fn read(arguments: &[String]) -> Result<(String, Campaign), PlantError> {
    let wrong = |text: String| PlantError::Wrong(text);
    let after = |key: &str| arguments.iter().position(|a| a == key).and_then(|k| arguments.get(k + 1));
    let name = after("--vehicle").map_or("small", String::as_str);
    let vehicle = Vehicle::named(name).ok_or_else(|| wrong(format!("no vehicle {name:?}: laurs, small or heavy")))?;
    let default = if name == "heavy" { "six" } else { "surge,sway,yaw" };
    let dofs = dofs(after("--dofs").map_or(default, String::as_str))?;
    let mut campaign = Campaign::new(vehicle, &dofs);
    let mut suite = Suite::default();
    let mut folder = None;
    let mut rest = arguments.iter();
    while let Some(key) = rest.next() {
        if !key.starts_with("--") {
            if folder.replace(key.clone()).is_some() {
                return Err(wrong(format!("{key:?}: one folder is enough")));
            }
            continue;
        }
        match key.as_str() {
            "--no-position" => suite.position = false,
            "--attitude" => suite.attitude = true,
            "--bollard" => campaign.bollard = true,
            _ => {
                let value = rest.next().ok_or_else(|| wrong(format!("{key} needs a value")))?;
                set(key, value, &mut campaign, &mut suite)?;
            }
        }
    }
    campaign.instruments = suite.instruments(&campaign.moves);
    Ok((folder.ok_or_else(|| wrong("name the folder to write".to_string()))?, campaign))
}

fn set(key: &str, value: &str, campaign: &mut Campaign, suite: &mut Suite) -> Result<(), PlantError> {
    let wrong = |expected: &str| PlantError::Wrong(format!("{key} {value}: expected {expected}"));
    let number = || value.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| wrong("a number"));
    let count = || value.parse::<u64>().map_err(|_| wrong("a whole number"));
    match key {
        "--vehicle" | "--dofs" => {}
        "--moves" => campaign.moves = dofs(value)?,
        "--spread" => campaign.spread = number()?,
        "--runs" => campaign.runs = count()? as usize,
        "--duration" => campaign.duration = number()?,
        "--lead-in" => campaign.lead_in = number()?,
        "--pilots" => {
            campaign.pilots = match value {
                "open" => Pilots::Open,
                "closed" => Pilots::Closed,
                "mixed" => Pilots::Mixed,
                _ => return Err(wrong("open, closed or mixed")),
            }
        }
        "--manoeuvres" => {
            let one = |name: &str| Manoeuvre::named(name).ok_or_else(|| wrong("names as --help lists them"));
            campaign.manoeuvres = value.split(',').map(one).collect::<Result<_, _>>()?;
        }
        "--command-rate" => campaign.command_rate = number()?,
        "--input" => {
            campaign.input = match value {
                "hold" => Input::Hold,
                "linear" => Input::Linear,
                _ => return Err(wrong("hold or linear")),
            }
        }
        "--commands" => {
            campaign.commands = match value {
                "wrench" => Commands::Wrench,
                "thrusters" => Commands::Thrusters,
                _ => return Err(wrong("wrench or thrusters")),
            }
        }
        "--force" => campaign.force.share = number()? / 100.0,
        "--correlation" => campaign.force.correlation = number()?,
        "--force-of" => campaign.own_forces.push(own_force(value).ok_or_else(|| wrong("DOF=PERCENT:SECONDS"))?),
        "--rate" => suite.rate = number()?,
        "--noise" => suite.noise = number()?,
        "--dvl-rate" => suite.dvl_rate = Some(number()?),
        "--dvl-held" => (suite.dvl_rate, suite.held) = (Some(number()?), true),
        "--dvl-noise" => suite.dvl_noise = Some(number()?),
        "--dvl-latency" => suite.dvl_latency = number()?,
        "--gyro-latency" => suite.gyro_latency = number()?,
        "--gyro-filter" => suite.gyro_filter = number()?,
        "--smoothing" => suite.smoothing = number()?,
        "--colour" => suite.colour = number()?,
        "--student" => suite.student = Some(count()? as u32),
        "--dropouts" => suite.dropouts = number()?,
        "--outliers" => suite.outliers = number()?,
        "--jitter" => suite.jitter = number()?,
        "--quantum" => suite.quantum = number()?,
        "--hide" => {
            let (name, size) = value.split_once('=').unwrap_or((value, "1"));
            let size = size.parse().map_err(|_| wrong("NAME or NAME=SIZE"))?;
            campaign.hidden.push(Hidden { name: name.to_string(), size });
        }
        "--without" => campaign.without.push(value.to_string()),
        "--step" => campaign.step = number()?,
        "--seed" => campaign.seed = count()?,
        _ => return Err(PlantError::Wrong(format!("{key} is unknown; --help lists what there is"))),
    }
    Ok(())
}

/// Parses `surge=5:0.5`: degree of freedom, percent, seconds.
fn own_force(value: &str) -> Option<(Dof, RandomForce)> {
    let (dof, force) = value.split_once('=')?;
    let (share, correlation) = force.split_once(':')?;
    let number = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite() && *x >= 0.0);
    Some((Dof::from_name(dof)?, RandomForce { share: number(share)? / 100.0, correlation: number(correlation)? }))
}

fn dofs(text: &str) -> Result<Vec<Dof>, PlantError> {
    if text == "six" {
        return Ok(Dof::ALL.to_vec());
    }
    let unknown = |name: &str| PlantError::Wrong(format!("no degree of freedom {name:?}"));
    let mut list: Vec<Dof> =
        text.split(',').map(|name| Dof::from_name(name).ok_or_else(|| unknown(name))).collect::<Result<_, _>>()?;
    list.sort_unstable();
    list.dedup();
    Ok(list)
}
