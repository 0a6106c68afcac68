//! The words of a table over seeds: how many, from which on, which rows, where to.

/// What is asked of the command.
pub struct Arguments {
    /// Seeds a row.
    pub seeds: u64,
    /// The first of them.
    pub first: u64,
    /// Text that a row or its section holds; all rows where it is empty.
    pub only: String,
    /// File to write; printed where there is none.
    pub write: Option<String>,
}

impl Arguments {
    /// `[--seeds N] [--first SEED] [--only TEXT] [--write FILE]`: so many `seeds` from `first` on where nothing else is said.
    ///
    /// # Errors
    /// A word that is none of these, or one that lacks its value.
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
