//! Reading a log in pieces: signals of some thousand rows at a time, for logs larger than memory.
//!
//! Each piece begins with the last row of the previous one, so that no interval between rows is
//! lost. For a sensor that samples less often than there are rows, the interval across the border
//! of two pieces is lost.

use std::collections::BTreeMap;
use std::io::Read;
use std::sync::Arc;

use super::LogError;
use super::check::time::log_gaps;
use super::rows::{Passage, Rows};
use crate::run::Signal;

/// Consecutive rows of a log.
#[derive(Debug, Clone, Default)]
pub struct Piece {
    /// Signals as in [`super::LogFile::signals`].
    pub signals: BTreeMap<String, Signal>,
    /// Unit of each known signal after reading.
    pub units: BTreeMap<String, &'static str>,
    /// Time stamps at which a gap ends, s.
    pub gaps: Vec<f64>,
    /// Number of rows that were in no earlier piece.
    pub rows: usize,
}

/// A log that is read piece by piece.
pub struct Pieces<R> {
    rows: Rows<R>,
    length: usize,
    time: Vec<f64>,
    values: Vec<Vec<f64>>,
}

impl<R: Read> Pieces<R> {
    /// Returns a reader of pieces of `length` rows.
    pub fn new(rows: Rows<R>, length: usize) -> Pieces<R> {
        let width = rows.names().count();
        Pieces { rows, length: length.max(1), time: Vec::new(), values: vec![Vec::new(); width] }
    }

    /// Returns the next piece; `None` at the end. [`Pieces::finish`] tells whether all rows were sound.
    pub fn next_piece(&mut self) -> Option<Piece> {
        let last = self.time.len().saturating_sub(1);
        self.time.drain(..last);
        self.values.iter_mut().for_each(|column| drop(column.drain(..last)));
        let begun = self.time.len();
        while self.time.len() < begun + self.length
            && let Some(row) = self.rows.next_row()
        {
            self.time.push(row.t);
            self.values.iter_mut().zip(row.values).for_each(|(column, x)| column.push(*x));
        }
        let rows = self.time.len() - begun;
        (rows > 0).then(|| self.piece(rows))
    }

    fn piece(&self, rows: usize) -> Piece {
        let time: Arc<[f64]> = self.time.as_slice().into();
        let mut piece = Piece { rows, ..Piece::default() };
        for (column, values) in self.rows.plan().columns.iter().zip(&self.values) {
            let samples = values.iter().filter(|x| !x.is_nan()).count();
            if samples == 0 {
                continue;
            }
            let signal = if samples == values.len() {
                Signal::new(time.clone(), values.clone())
            } else {
                let (t, x): (Vec<f64>, Vec<f64>) = time.iter().zip(values).filter(|(_, x)| !x.is_nan()).unzip();
                Signal::new(t.into(), x)
            };
            if !column.unit.is_empty() {
                piece.units.insert(column.name.clone(), column.unit);
            }
            piece.signals.insert(column.name.clone(), signal);
        }
        piece.gaps = log_gaps(&time, &piece.signals);
        piece
    }

    /// Returns what was met while reading, if every row was sound.
    ///
    /// # Errors
    /// [`LogError::Refused`] with the first case of each kind and column.
    pub fn finish(self) -> Result<Passage, LogError> {
        self.rows.finish().map(|(_, passage)| passage)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LogOptions, PLANAR, read_from};
    use super::*;

    #[test]
    fn pieces_are_the_log() {
        let mut text = String::from("t,u,v,r,tau_u,tau_v,tau_r\n");
        for k in 0..250 {
            // a gap of 5 s after row 99
            let t = 0.1 * f64::from(k) + if k > 99 { 5.0 } else { 0.0 };
            text += &format!("{t},{},0,0,1,2,3\n", k);
        }
        let options = LogOptions::default();
        let whole = read_from(text.as_bytes(), "log", &options, &PLANAR).unwrap();
        let rows = Rows::new(text.as_bytes(), "log", &options, &PLANAR).unwrap();
        let mut pieces = Pieces::new(rows, 60);
        let (mut u, mut gaps) = (Vec::new(), Vec::new());
        while let Some(piece) = pieces.next_piece() {
            let values = piece.signals["u"].values();
            u.extend_from_slice(&values[values.len() - piece.rows..]);
            gaps.extend(piece.gaps);
        }
        assert_eq!(u, whole.signals["u"].values());
        assert_eq!(gaps, whole.gaps);
        assert_eq!(pieces.finish().unwrap().rows, 250);
    }
}
