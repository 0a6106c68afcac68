//! The faults that logs of vehicles have, each put into a sound log, and the findings that are right for it.

use crate::table::Table;

/// A fault.
pub struct Fault {
    /// Section of the page.
    pub section: &'static str,
    /// What it is.
    pub name: &'static str,
    /// Codes of which one has to be raised.
    pub codes: &'static [&'static str],
    /// Puts it into a log; the number changes where.
    pub inject: fn(Table, usize) -> String,
}

/// A change of the table alone.
macro_rules! table {
    (|$table:ident, $seed:ident| $change:block) => {
        |mut $table, $seed| {
            let _ = $seed;
            $change
            $table.csv()
        }
    };
}

/// A place in the middle half of a log.
fn inside(table: &Table, seed: usize) -> usize {
    let rows = table.rows.len();
    rows / 4 + (seed * 7919) % (rows / 2)
}

/// All faults.
pub const FAULTS: [Fault; 34] = [
    Fault {
        section: "Text",
        name: "a word where a number should be",
        codes: &["L013"],
        inject: table!(|t, seed| {
            let (k, at) = (inside(&t, seed), t.column("r"));
            t.rows[k][at] = "ERR".into();
        }),
    },
    Fault {
        section: "Text",
        name: "NaN in a cell",
        codes: &["L014", "L015"],
        inject: table!(|t, seed| {
            let (k, at) = (inside(&t, seed), t.column("u"));
            t.rows[k][at] = "NaN".into();
        }),
    },
    Fault {
        section: "Text",
        name: "a row cut short at the end",
        codes: &["L012"],
        inject: |t, _| {
            let text = t.csv();
            text[..text.len() - 1 - t.rows[t.rows.len() - 1].join(",").len() / 2].to_string()
        },
    },
    Fault {
        section: "Text",
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
        name: "decimal commas",
        codes: &["L007", "L012", "L013"],
        inject: |t, _| t.csv().replace(',', ";").replace('.', ","),
    },
    Fault {
        section: "Text",
        name: "a binary log under the name of a CSV",
        codes: &["L216"],
        inject: |t, _| format!("#ROSBAG V2.0\n{}", t.csv()),
    },
    Fault {
        section: "Time",
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
        name: "the clock set back by 3 s",
        codes: &["L017"],
        inject: table!(|t, seed| {
            let from = inside(&t, seed);
            t.change("t", |k, x| if k >= from { x - 3.0 } else { x });
        }),
    },
    Fault {
        section: "Time",
        name: "a gap of 1 s",
        codes: &["L105", "K105"],
        inject: table!(|t, seed| {
            let k = inside(&t, seed);
            t.rows.drain(k..k + 10);
        }),
    },
    Fault {
        section: "Time",
        name: "the clock set on by 0.7 s",
        codes: &["L105", "K105"],
        inject: table!(|t, seed| {
            let from = inside(&t, seed);
            t.change("t", |k, x| if k >= from { x + 0.7 } else { x });
        }),
    },
    Fault {
        section: "Time",
        name: "milliseconds without a unit",
        codes: &["L106"],
        inject: table!(|t, seed| {
            t.headers[0] = "t".into();
            t.change("t", |_, x| (x * 1e3).round());
        }),
    },
    Fault {
        section: "Time",
        name: "a second clock that is 0.4 % fast",
        codes: &["K104"],
        inject: table!(|t, seed| {
            let time: Vec<f64> = t.values("t").into_iter().flatten().collect();
            t.add("t_imu [s]", |k| time[k] * 1.004);
        }),
    },
    Fault {
        section: "Values",
        name: "a sensor's code for no value, ten times",
        codes: &["L107"],
        inject: table!(|t, seed| {
            let step = t.rows.len() / 11;
            t.change("u", |k, x| if k % step == seed % step { -32.768 } else { x });
        }),
    },
    Fault {
        section: "Values",
        name: "one outlier of 1.5 m/s",
        codes: &["L108", "L109"],
        inject: table!(|t, seed| {
            let at = inside(&t, seed);
            t.change("u", |k, x| if k == at { x + 1.5 } else { x });
        }),
    },
    Fault {
        section: "Values",
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
        name: "a speed that is zero throughout",
        codes: &["L112"],
        inject: table!(|t, seed| {
            t.change("u", |_, _| 0.0);
        }),
    },
    Fault {
        section: "Values",
        name: "a gyro that saturates at 60 % of its range",
        codes: &["L113", "K102"],
        inject: table!(|t, seed| {
            let most = t.values("r").into_iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
            t.change("r", |_, x| x.clamp(-0.6 * most, 0.6 * most));
        }),
    },
    Fault {
        section: "Units, signs and axes",
        name: "a rate in degrees a second",
        codes: &["K111", "L110"],
        inject: table!(|t, seed| {
            t.change("r", |_, x| x.to_degrees());
        }),
    },
    Fault {
        section: "Units, signs and axes",
        name: "a heading in degrees",
        codes: &["K111", "L110"],
        inject: table!(|t, seed| {
            t.change("psi", |_, x| x.to_degrees());
        }),
    },
    Fault {
        section: "Units, signs and axes",
        name: "a velocity in millimetres a second",
        codes: &["K111", "L110"],
        inject: table!(|t, seed| {
            t.change("u", |_, x| x * 1e3);
            t.change("v", |_, x| x * 1e3);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        name: "a gyro the other way round",
        codes: &["K112"],
        inject: table!(|t, seed| {
            t.change("r", |_, x| -x);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        name: "north and east exchanged",
        codes: &["K114", "K112"],
        inject: table!(|t, seed| {
            t.swap("x", "y");
        }),
    },
    Fault {
        section: "Units, signs and axes",
        name: "velocities forward and to port",
        codes: &["K114", "K112"],
        inject: table!(|t, seed| {
            t.change("v", |_, x| -x);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        name: "a gyro that shows 20 % too much",
        codes: &["K113"],
        inject: table!(|t, seed| {
            t.change("r", |_, x| 1.2 * x);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        name: "a heading the other way round",
        codes: &["K112", "K114"],
        inject: table!(|t, seed| {
            t.change("psi", |_, x| -x);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        name: "a DVL turned by 90°",
        codes: &["K114"],
        inject: table!(|t, seed| {
            t.swap("u", "v");
            t.change("u", |_, x| -x);
        }),
    },
    Fault {
        section: "Units, signs and axes",
        name: "a velocity in knots",
        codes: &["K111", "K113", "L110"],
        inject: table!(|t, seed| {
            t.change("u", |_, x| x * 3600.0 / 1852.0);
            t.change("v", |_, x| x * 3600.0 / 1852.0);
        }),
    },
    Fault {
        section: "Delays and commands",
        name: "a heading 0.3 s late",
        codes: &["K116"],
        inject: table!(|t, seed| {
            t.late("psi", 3);
        }),
    },
    Fault {
        section: "Delays and commands",
        name: "velocities 0.5 s late",
        codes: &["K116", "K122"],
        inject: table!(|t, seed| {
            t.late("u", 5);
            t.late("v", 5);
        }),
    },
    Fault {
        section: "Delays and commands",
        name: "a command with the wrong sign",
        codes: &["K121", "L114"],
        inject: table!(|t, seed| {
            t.change("tau_u", |_, x| -x);
            t.change("tau_r", |_, x| -x);
        }),
    },
    Fault {
        section: "Delays and commands",
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
        name: "commands that were not logged",
        codes: &["L116"],
        inject: table!(|t, seed| {
            for channel in ["tau_u", "tau_v", "tau_r"] {
                t.change(channel, |_, _| 0.0);
            }
        }),
    },
];
