//! The rows of the table: the random force and instruments of a campaign, and the wrong assumptions
//! of the fit.

use hydrosysid_plant::{Campaign, Dof, Input, Pilots, RandomForce, Suite, Vehicle};

/// One row.
pub struct Cell {
    /// Section of the page.
    pub section: &'static str,
    /// Name of the row.
    pub name: String,
    /// The campaign of a seed.
    pub campaign: Box<dyn Fn(u64) -> Campaign + Sync>,
    /// Measurement noise that is given to the fit, as a factor of the true one; `None`: the fit estimates it.
    pub stated: Option<f64>,
}

fn planar(vehicle: &str, suite: &Suite, force: f64, correlation: f64, seed: u64) -> Campaign {
    let vehicle = Vehicle::named(vehicle).unwrap_or_else(|| unreachable!("the plant has this vehicle"));
    let force = RandomForce { share: force / 100.0, correlation };
    let instruments = suite.instruments(&Dof::PLANE);
    Campaign { force, instruments, seed, ..Campaign::new(vehicle, &Dof::PLANE) }
}

fn cell(section: &'static str, name: impl Into<String>, campaign: impl Fn(u64) -> Campaign + Sync + 'static) -> Cell {
    Cell { section, name: name.into(), campaign: Box::new(campaign), stated: None }
}

/// All rows.
pub fn cells() -> Vec<Cell> {
    let mut all = Vec::new();
    let grid = "Random force by rms (share of the commanded force) and correlation time";
    all.push(cell(grid, "none", |seed| planar("laurs", &Suite::default(), 0.0, 1.0, seed)));
    for force in [0.5, 2.0, 5.0, 10.0] {
        for correlation in [0.0, 0.5, 3.0] {
            let name = format!("{force} %, {correlation} s");
            all.push(cell(grid, name, move |seed| planar("laurs", &Suite::default(), force, correlation, seed)));
        }
    }
    let wrong = "What the filter does not assume, no random force unless said";
    let suites: [(&str, Suite, f64); 8] = [
        ("sensor noise AR(1) 0.8", Suite { colour: 0.8, ..Suite::default() }, 0.0),
        ("velocity held three samples", Suite { dvl_rate: Some(10.0 / 3.0), held: true, ..Suite::default() }, 2.0),
        ("stamp jitter 20 ms", Suite { jitter: 0.02, ..Suite::default() }, 2.0),
        ("Student t, 3 degrees of freedom", Suite { student: Some(3), ..Suite::default() }, 2.0),
        ("1 % outliers", Suite { outliers: 0.01, ..Suite::default() }, 2.0),
        ("quantised to two deviations", Suite { quantum: 2.0, ..Suite::default() }, 2.0),
        ("10 % drop-outs", Suite { dropouts: 0.1, ..Suite::default() }, 2.0),
        ("smoothed heading and filtered gyro", Suite { gyro_filter: 0.05, smoothing: 0.3, ..Suite::default() }, 2.0),
    ];
    for (name, suite, force) in suites {
        let told = if force > 0.0 { format!("{name}; force {force} %, 1 s") } else { name.to_string() };
        all.push(cell(wrong, told, move |seed| planar("laurs", &suite, force, 1.0, seed)));
    }
    for factor in [1.0 / 3.0, 3.0] {
        let name = format!("stated noise {factor:.2} times the truth; force 2 %, 1 s");
        let campaign = |seed| planar("laurs", &Suite::default(), 2.0, 1.0, seed);
        all.push(Cell { stated: Some(factor), ..cell(wrong, name, campaign) });
    }
    let small = "Small directionally unstable vehicle, force 2 %, 1 s";
    for (name, noise) in [("velocity 5 mm/s", 0.005), ("velocity 50 mm/s", 0.05)] {
        let suite = Suite { dvl_noise: Some(noise), ..Suite::default() };
        all.push(cell(small, name, move |seed| planar("small", &suite, 2.0, 1.0, seed)));
    }
    let twenty = Suite { rate: 20.0, gyro_filter: 0.05, smoothing: 0.3, dropouts: 0.1, ..Suite::default() };
    all.push(cell(small, "20 Hz, commands held 5 Hz, filtered gyro, smoothed heading, 10 % drop-outs", {
        move |seed| Campaign { command_rate: 5.0, input: Input::Hold, ..planar("small", &twenty, 2.0, 1.0, seed) }
    }));
    all.push(cell(small, "runs of 10 s: 30 s of data and 60 s held out", |seed| Campaign {
        duration: 10.0,
        runs: 4,
        ..planar("small", &Suite::default(), 2.0, 1.0, seed)
    }));
    all.push(cell(small, "closed loop on noisy measurements", |seed| Campaign {
        pilots: Pilots::Closed,
        ..planar("small", &Suite::default(), 2.0, 1.0, seed)
    }));
    all.push(cell("Six degrees of freedom, eight thrusters' worth of force, 2 %, 1 s", "heavy", |seed| {
        let vehicle = Vehicle::named("heavy").unwrap_or_else(|| unreachable!("the plant has this vehicle"));
        let force = RandomForce { share: 0.02, correlation: 1.0 };
        Campaign { force, seed, ..Campaign::new(vehicle, &Dof::ALL) }
    }));
    all
}
