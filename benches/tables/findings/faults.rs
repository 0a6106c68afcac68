//! Faults of vehicle logs, each injected into a sound log, and the codes of the findings that are
//! right for it.

use super::table::Table;

/// Kind of log into which a fault is injected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Log {
    /// Commands as functions of time, motion in all degrees of freedom.
    Moving,
    /// A controller holds heading and speed.
    Controlled,
    /// As `Moving`, with the heading smoothed by the time constant of this index.
    Smoothed(usize),
}

/// A fault.
pub struct Fault {
    /// Section of the page.
    pub section: &'static str,
    /// Kind of log into which it is injected.
    pub log: Log,
    /// Name of the fault.
    pub name: &'static str,
    /// Codes of which at least one must be raised.
    pub codes: &'static [&'static str],
    /// Injects it into a log and returns the CSV; the number changes the place.
    pub inject: fn(Table, usize) -> String,
}

/// A fault that only changes the table.
macro_rules! table {
    (|$table:ident, $seed:ident| $change:block) => {
        |mut $table, $seed| {
            let _ = $seed;
            $change
            $table.csv()
        }
    };
}

/// Index of a row in the middle half of a log.
fn inside(table: &Table, seed: usize) -> usize {
    let rows = table.rows.len();
    rows / 4 + (seed * 7919) % (rows / 2)
}

/// A pseudo-random number between −1 and 1 from row and channel, as the noise of a sensor on a
/// vehicle at rest.
fn scatter(row: usize, channel: usize) -> f64 {
    let mixed = (row as u64 * 31 + channel as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// All faults.
pub const FAULTS: [Fault; 39] = [
    Fault {
        section: "Text",
        log: Log::Moving,
        name: "a word where a number should be",
        codes: &["L013"],
        inject: table!(|t, seed| {
            let (k, at) = (inside(&t, seed), t.column("r"));
            t.rows[k][at] = "ERR".into();
        }),
    },
    Fault {
        section: "Text",
        log: Log::Moving,
        name: "NaN in a cell",
        codes: &["L014", "L015"],
        inject: table!(|t, seed| {
            let (k, at) = (inside(&t, seed), t.column("u"));
            t.rows[k][at] = "NaN".into();
        }),
    },
    Fault {
        section: "Text",
        log: Log::Moving,
        name: "a row cut short at the end",
        codes: &["L012"],
        inject: |t, _| {
            let text = t.csv();
            text[..text.len() - 1 - t.rows[t.rows.len() - 1].join(",").len() / 2].to_string()
        },
    },
    Fault {
        section: "Text",
        log: Log::Moving,
        name: "a block of NUL bytes",
        codes: &["L003"],
        inject: |t, seed| {
            let text = t.csv();
            let at = text.len() / 2 + seed % 100;
            format!("{}{}{}", &text[..at], "\0".repeat(64), &text[at..])
        },
    },
    Fault {
        section: "Text",
        log: Log::Moving,
        name: "decimal commas",
        codes: &["L007", "L012", "L013"],
        inject: |t, _| t.csv().replace(',', ";").replace('.', ","),
    },
    Fault {
        section: "Text",
        log: Log::Moving,
        name: "a binary log under the name of a CSV",
        codes: &["L216"],
        inject: |t, _| format!("#ROSBAG V2.0\n{}", t.csv()),
    },
    Fault {
        section: "Time",
        log: Log::Moving,
        name: "a row written twice",
        codes: &["L017"],
        inject: table!(|t, seed| {
            let k = inside(&t, seed);
            let row = t.rows[k].clone();
            t.rows.insert(k, row);
        }),
    },
    Fault {
        section: "Time",
        log: Log::Moving,
        name: "the clock set back by 3 s",
        codes: &["L017"],
        inject: table!(|t, seed| {
            let from = inside(&t, seed);
            t.change("t", |k, x| if k >= from { x - 3.0 } else { x });
        }),
    },
    Fault {
        section: "Time",
        log: Log::Moving,
        name: "a gap of 1 s",
        codes: &["L105", "K105"],
        inject: table!(|t, seed| {
            let k = inside(&t, seed);
            t.rows.drain(k..k + 10);
        }),
    },
    Fault {
        section: "Time",
        log: Log::Moving,
        name: "the clock set on by 0.7 s",
        codes: &["L105", "K105"],
        inject: table!(|t, seed| {
            let from = inside(&t, seed);
            t.change("t", |k, x| if k >= from { x + 0.7 } else { x });
        }),
    },
    Fault {
        section: "Time",
        log: Log::Moving,
        name: "milliseconds without a unit",
        codes: &["L106"],
        inject: table!(|t, seed| {
            t.headers[0] = "t".into();
            t.change("t", |_, x| (x * 1e3).round());
        }),
    },
    Fault {
        section: "Time",
        log: Log::Moving,
        name: "a second clock that is 0.4 % fast",
        codes: &["K104"],
        inject: table!(|t, seed| {
            let time: Vec<f64> = t.values("t").into_iter().flatten().collect();
            t.add("t_imu [s]", |k| time[k] * 1.004);
        }),
    },
    Fault {
        section: "Values",
        log: Log::Moving,
        name: "a sensor's code for no value, ten times",
        codes: &["L107"],
        inject: table!(|t, seed| {
            let step = t.rows.len() / 11;
            t.change("u", |k, x| if k % step == seed % step { -32.768 } else { x });
        }),
    },
    Fault {
        section: "Values",
        log: Log::Moving,
        name: "one outlier of 1.5 m/s",
        codes: &["L108", "L109"],
        inject: table!(|t, seed| {
            let at = inside(&t, seed);
            t.change("u", |k, x| if k == at { x + 1.5 } else { x });
        }),
    },
    Fault {
        section: "Values",
        log: Log::Moving,
        name: "a velocity renewed at 2 Hz, written at 10",
        codes: &["L111", "K101"],
        inject: table!(|t, seed| {
            let mut held = 0.0;
            t.change("u", |k, x| {
                if k % 5 == 0 {
                    held = x;
                }
                held
            });
        }),
    },
    Fault {
        section: "Values",
        log: Log::Moving,
        name: "a heading that freezes for 15 s",
        codes: &["K102"],
        inject: table!(|t, seed| {
            let from = inside(&t, seed).min(t.rows.len() - 151);
            let mut held = 0.0;
            t.change("psi", |k, x| {
                if k <= from {
                    held = x;
                }
                if k < from + 150 { held } else { x }
            });
        }),
    },
    Fault {
        section: "Values",
        log: Log::Moving,
        name: "a speed that is zero throughout",
        codes: &["L112"],
        inject: table!(|t, seed| {
            t.change("u", |_, _| 0.0);
        }),
    },
    Fault {
        section: "Values",
        log: Log::Moving,
        name: "a gyro that saturates at 60 % of its range",
        codes: &["L113", "K102"],
        inject: table!(|t, seed| {
            let most = t.values("r").into_iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
            t.change("r", |_, x| x.clamp(-0.6 * most, 0.6 * most));
        }),
    },
    Fault {
        section: "Values",
        log: Log::Moving,
        name: "−9999 once",
        codes: &["L107"],
        inject: table!(|t, seed| {
            let at = inside(&t, seed);
            t.change("v", |k, x| if k == at { -9999.0 } else { x });
        }),
    },
    Fault {
        section: "Values",
        log: Log::Moving,
        name: "a gyro that is dead: 1e-7 rad/s",
        codes: &["K118"],
        inject: table!(|t, seed| {
            t.change("r", |k, _| 1e-7 * scatter(k, seed));
        }),
    },
    Fault {
        section: "Units, signs and axes",
        log: Log::Moving,
        name: "a rate in degrees a second",
        codes: &["K111", "L110"],
        inject: table!(|t, seed| {
            t.change("r", |_, x| x.to_degrees());
        }),
    },
    Fault {
        section: "Units, signs and axes",
        log: Log::Moving,
        name: "a heading in degrees",
        codes: &["K111", "L110"],
        inject: table!(|t, seed| {
            t.change("psi", |_, x| x.to_degrees());
        }),
    },
    Fault {
        section: "Units, signs and axes",
        log: Log::Moving,
        name: "a velocity in millimetres a second",
        codes: &["K111", "L110"],
        inject: table!(|t, seed| {
            t.change("u", |_, x| x * 1e3);
            t.change("v", |_, x| x * 1e3);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        log: Log::Moving,
        name: "a gyro the other way round",
        codes: &["K112"],
        inject: table!(|t, seed| {
            t.change("r", |_, x| -x);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        log: Log::Moving,
        name: "north and east exchanged",
        codes: &["K114", "K112"],
        inject: table!(|t, seed| {
            t.swap("x", "y");
        }),
    },
    Fault {
        section: "Units, signs and axes",
        log: Log::Moving,
        name: "velocities forward and to port",
        codes: &["K114", "K112"],
        inject: table!(|t, seed| {
            t.change("v", |_, x| -x);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        log: Log::Moving,
        name: "a gyro that shows 20 % too much",
        codes: &["K113"],
        inject: table!(|t, seed| {
            t.change("r", |_, x| 1.2 * x);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        log: Log::Moving,
        name: "a heading the other way round",
        codes: &["K112", "K114"],
        inject: table!(|t, seed| {
            t.change("psi", |_, x| -x);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        log: Log::Moving,
        name: "a DVL turned by 90°",
        codes: &["K114"],
        inject: table!(|t, seed| {
            t.swap("u", "v");
            t.change("u", |_, x| -x);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        log: Log::Moving,
        name: "a velocity in knots",
        codes: &["K111", "K113", "L110"],
        inject: table!(|t, seed| {
            t.change("u", |_, x| x * 3600.0 / 1852.0);
            t.change("v", |_, x| x * 3600.0 / 1852.0);
        }),
    },
    Fault {
        section: "Delays and commands",
        log: Log::Moving,
        name: "a heading 0.3 s late",
        codes: &["K116"],
        inject: table!(|t, seed| {
            t.late("psi", 3);
        }),
    },
    Fault {
        section: "Delays and commands",
        log: Log::Moving,
        name: "velocities 0.5 s late",
        codes: &["K116", "K122"],
        inject: table!(|t, seed| {
            t.late("u", 5);
            t.late("v", 5);
        }),
    },
    Fault {
        section: "Delays and commands",
        log: Log::Moving,
        name: "a command with the wrong sign",
        codes: &["K121", "L114"],
        inject: table!(|t, seed| {
            t.change("tau_u", |_, x| -x);
            t.change("tau_r", |_, x| -x);
        }),
    },
    Fault {
        section: "Delays and commands",
        log: Log::Moving,
        name: "motion 0.4 s after its command",
        codes: &["K122"],
        inject: table!(|t, seed| {
            for channel in ["u", "v", "r", "x", "y", "psi"] {
                t.late(channel, 4);
            }
        }),
    },
    Fault {
        section: "Delays and commands",
        log: Log::Moving,
        name: "motion 1.2 s after its command",
        codes: &["K122"],
        inject: table!(|t, seed| {
            for channel in ["u", "v", "r", "x", "y", "psi"] {
                t.late(channel, 12);
            }
        }),
    },
    Fault {
        section: "Delays and commands",
        log: Log::Moving,
        name: "commands that were not logged",
        codes: &["L116"],
        inject: table!(|t, seed| {
            for channel in ["tau_u", "tau_v", "tau_r"] {
                t.change(channel, |_, _| 0.0);
            }
        }),
    },
    Fault {
        section: "What the run shows",
        log: Log::Moving,
        name: "a vehicle at rest",
        codes: &["K134"],
        inject: table!(|t, seed| {
            for (number, (channel, noise)) in
                [("u", 0.005), ("v", 0.005), ("r", 0.003), ("psi", 0.009), ("x", 0.05), ("y", 0.05)]
                    .into_iter()
                    .enumerate()
            {
                t.change(channel, |k, _| 1.7 * noise * scatter(k, number + seed));
            }
            for channel in ["tau_u", "tau_v", "tau_r"] {
                t.change(channel, |_, _| 0.0);
            }
        }),
    },
    Fault {
        section: "What the run shows",
        log: Log::Controlled,
        name: "a controller steers, and the log's mode says so",
        codes: &["K133"],
        inject: table!(|t, seed| {
            t.add("closed_loop", |_| 1.0);
        }),
    },
    Fault {
        section: "What the run shows",
        log: Log::Controlled,
        name: "a controller steers, and nothing says so",
        codes: &["K132"],
        inject: |t, _| t.csv(),
    },
];
