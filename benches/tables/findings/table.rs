//! A log as a table of text, into which faults are injected.

/// Header and cells of a CSV.
#[derive(Debug, Clone)]
pub struct Table {
    /// Headers with their units: `u [m/s]`.
    pub headers: Vec<String>,
    /// Cells, row by row; empty where a sensor has no sample.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// The table of a CSV without quotes.
    pub fn read(csv: &str) -> Table {
        let mut lines = csv.lines().map(|line| line.split(',').map(str::to_string).collect::<Vec<_>>());
        Table { headers: lines.next().unwrap_or_default(), rows: lines.collect() }
    }

    /// The CSV.
    pub fn csv(&self) -> String {
        let lines = std::iter::once(&self.headers).chain(&self.rows);
        lines.map(|cells| cells.join(",") + "\n").collect()
    }

    /// Index of the column of a channel.
    pub fn column(&self, channel: &str) -> usize {
        let is = |header: &String| header.split(' ').next() == Some(channel);
        self.headers.iter().position(is).unwrap_or_else(|| panic!("the log has no {channel}"))
    }

    /// The values of a channel, row by row.
    pub fn values(&self, channel: &str) -> Vec<Option<f64>> {
        let at = self.column(channel);
        self.rows.iter().map(|row| row[at].parse().ok()).collect()
    }

    /// Changes the samples of a channel; `to` gets the index of the row and the value.
    pub fn change(&mut self, channel: &str, mut to: impl FnMut(usize, f64) -> f64) {
        let at = self.column(channel);
        for (k, row) in self.rows.iter_mut().enumerate() {
            if let Ok(value) = row[at].parse::<f64>() {
                row[at] = to(k, value).to_string();
            }
        }
    }

    /// Adds a column of values.
    pub fn add(&mut self, header: &str, value: impl Fn(usize) -> f64) {
        self.headers.push(header.to_string());
        self.rows.iter_mut().enumerate().for_each(|(k, row)| row.push(value(k).to_string()));
    }

    /// Exchanges two channels.
    pub fn swap(&mut self, a: &str, b: &str) {
        let (a, b) = (self.column(a), self.column(b));
        self.rows.iter_mut().for_each(|row| row.swap(a, b));
    }

    /// Delays the samples of a channel by `rows` rows; the first ones stay as they are.
    pub fn late(&mut self, channel: &str, rows: usize) {
        let at = self.column(channel);
        for k in (rows..self.rows.len()).rev() {
            self.rows[k][at] = self.rows[k - rows][at].clone();
        }
    }
}
