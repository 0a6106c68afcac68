//! Command line arguments of a table over seeds: number of seeds, first seed, rows, output file.

/// Arguments of the command.
pub struct Arguments {
    /// Number of seeds for each row.
    pub seeds: u64,
    /// The first of them.
    pub first: u64,
    /// Text that a row or its section must contain; if empty, all rows.
    pub only: String,
    /// File to write; `None`: standard output.
    pub write: Option<String>,
}

impl Arguments {
    /// Reads `[--seeds N] [--first SEED] [--only TEXT] [--write FILE]`; `seeds` and `first` are the defaults.
    ///
    /// # Errors
    /// An unknown argument, or an argument without its value or with a wrong one.
    pub fn read(seeds: u64, first: u64) -> Result<Arguments, String> {
        let mut found = Arguments { seeds, first, only: String::new(), write: None };
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} needs a value"));
            let number =
                |text: String| text.parse::<u64>().map_err(|_| format!("{word} takes a whole number, not {text}"));
            match word.as_str() {
                "--seeds" => found.seeds = number(value()?)?,
                "--first" => found.first = number(value()?)?,
                "--only" => found.only = value()?,
                "--write" => found.write = Some(value()?),
                other => {
                    return Err(format!(
                        "unknown argument {other}: --seeds N, --first SEED, --only TEXT, --write FILE"
                    ));
                }
            }
        }
        Ok(found)
    }
}
