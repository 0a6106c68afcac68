//! The verb `fit` with `--stream`, or with logs that are too large to keep: integral least squares
//! in O(p²) memory.
//!
//! Each log is read piece by piece. Each piece is prepared like a run (window, condition, forces)
//! and folded into triangular factors; one thread reads while another folds. What needs a whole run
//! at once is refused.

use std::path::Path;
use std::sync::mpsc::sync_channel;
use std::thread;

use super::baseline;
use super::codes;
use super::error::Error;
use super::file::{CampaignFile, Estimator, ReadOptions, RunTable};
use super::fit::{Fit, Raw, assembled, of_rows};
use super::load::{Campaign, LoadOptions, assemble, moves, names, unjudged};
use super::logs::{Logged, needed};
use super::scale;
use super::unexcited::Seen;
use crate::effects::channel;
use crate::envelope::{self, Envelope};
use crate::estimate::{RegressorOptions, Span, Streamed};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::log::derived;
use crate::log::options::Repeated;
use crate::log::{LogOptions, OptionsError, Piece, Pieces, Rows};
use crate::model::Model;
use crate::plan::Instruments;
use crate::progress::tell;
use crate::run::{Role, Run};

/// Rows of a piece: about 2 MiB, and enough for a cluster.
const ROWS: usize = 1 << 15;

/// Number of pieces that wait between reading and folding.
const WAITING: usize = 2;

/// Total size of the logs, in bytes, above which integral least squares does not keep them; kept,
/// they take twice as much memory.
const KEPT: u64 = 64 << 20;

/// Whether a fit by `estimator`, or by that of the campaign file if `None`, uses integral least
/// squares on training logs of more than 64 MiB that can be read piece by piece.
///
/// # Errors
/// [`Error`] if the campaign file cannot be read.
pub fn too_large_to_keep(path: &Path, options: LoadOptions, estimator: Option<Estimator>) -> Result<bool, Error> {
    let read = ReadOptions { allow_outside: options.allow_outside, ..ReadOptions::default() };
    let file = CampaignFile::read(path, &read)?;
    if estimator.or(file.fit.estimator) != Some(Estimator::Integral) || bytes_of(&file) <= KEPT {
        return Ok(false);
    }
    let names = names(&file.runs);
    Ok(trained(&file, &names).all(|(table, name)| refuse_what_needs_all(&file, table, name).is_ok()))
}

/// Returns the runs that a streamed fit reads, with their names.
fn trained<'a>(file: &'a CampaignFile, names: &'a [String]) -> impl Iterator<Item = (&'a RunTable, &'a String)> {
    file.runs.iter().zip(names).filter(|(table, _)| table.role == Role::Train && moves(table.kind))
}

/// Returns the size of the logs of [`trained`] on disk, bytes.
fn bytes_of(file: &CampaignFile) -> u64 {
    let names = names(&file.runs);
    let logs = trained(file, &names).flat_map(|(table, _)| &table.files);
    logs.map(|log| std::fs::metadata(file.path_of(log)).map_or(0, |found| found.len())).sum()
}

/// Fits the free parameters of a campaign to its training runs of free motion without keeping their
/// logs. The campaign that is returned with the fit has no runs.
///
/// # Errors
/// [`Error`] as for loading and fitting, and if a run asks for something that needs it whole.
pub fn fit_streamed(path: &Path, options: LoadOptions) -> Result<(Campaign, Fit), Error> {
    in_pieces(path, options, ROWS)
}

fn in_pieces(path: &Path, options: LoadOptions, length: usize) -> Result<(Campaign, Fit), Error> {
    let read = ReadOptions { allow_outside: options.allow_outside, ..ReadOptions::default() };
    let file = CampaignFile::read(path, &read)?;
    let names = names(&file.runs);
    let mut folding = Folding {
        file: &file,
        first: None,
        streamed: None,
        envelope: Envelope::new(),
        seen: Seen::default(),
        met: Vec::new(),
        rows: 0,
        length,
    };
    let mut fitted_runs = Vec::new();
    for (table, name) in trained(&file, &names) {
        refuse_what_needs_all(&file, table, name)?;
        folding.run(table, name)?;
        fitted_runs.push(name.clone());
    }
    let (Some(mut campaign), Some(streamed)) = (folding.first, folding.streamed) else {
        let text = "no run of free motion has role = \"train\"";
        return Err(Error::Refused { findings: vec![Finding::new(&codes::NO_TRAINING, text)] });
    };
    folding.seen.refuse(&campaign.model)?;
    campaign.findings.append(&mut folding.met);
    campaign.findings.extend(of_all_pieces(&campaign, &folding.seen));
    let (model, fits) = streamed.fit()?;
    let method = match campaign.curves.as_slice() {
        [] => "clusters of rows",
        _ => "clusters of rows; the thrusters' curves assumed exact",
    };
    let raw = Raw { std_method: method.into(), ..of_rows(model, &fits, &fitted_runs, &campaign) };
    let mut fit = assembled(raw, &campaign, Estimator::Integral, folding.envelope, Instruments::new());
    let text = format!(
        "{} rows of {:.1} MiB of logs were read piece by piece and not kept",
        folding.rows,
        bytes_of(&file) as f64 / f64::from(1 << 20)
    );
    fit.warnings.push(Finding::new(&codes::STREAMED, text));
    if fits.iter().any(|fit| fit.few_clusters) {
        fit.warnings.push(Finding::new(&codes::FEW_STRETCHES, codes::FEW_STRETCHES.meaning));
    }
    Ok((campaign, fit))
}

/// A campaign whose runs are folded one after the other.
struct Folding<'a> {
    file: &'a CampaignFile,
    /// The campaign of the first piece, without runs.
    first: Option<Campaign>,
    streamed: Option<Streamed>,
    envelope: Envelope,
    seen: Seen,
    /// Findings from reading the logs.
    met: Vec<Finding>,
    rows: usize,
    /// Rows of a piece.
    length: usize,
}

impl Folding<'_> {
    fn run(&mut self, table: &RunTable, name: &str) -> Result<(), Error> {
        let options = table.files[0].log.as_ref().or(table.log.as_ref()).unwrap_or(&self.file.log);
        let wrong = |source| Error::Log { run: name.to_string(), source };
        if options.earth_velocity().is_some() {
            return Err(wrong(OptionsError::StreamedVelocity.into()));
        }
        if derived::is_asked(options) {
            return Err(wrong(OptionsError::StreamedDerived.into()));
        }
        let rows = Rows::open(&self.file.path_of(&table.files[0]), options, &needed(self.file, table.kind));
        let mut pieces = Pieces::new(rows.map_err(wrong)?, self.length);
        let (send, receive) = sync_channel::<Piece>(WAITING);
        thread::scope(|scope| {
            let reader = scope.spawn(move || {
                while let Some(piece) = pieces.next_piece() {
                    // the receiver is gone: the folding has failed, and says why
                    if send.send(piece).is_err() {
                        return Ok(None);
                    }
                }
                pieces.finish().map(Some)
            });
            // the receiver is dropped with the loop, so that the reader ends if the folding fails
            let folded = receive.into_iter().try_for_each(|piece| self.piece(table, name, options, piece));
            let read = reader.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            // an unsound row is reported first: what is folded after it does not count
            if let Some(passage) = read.map_err(wrong)? {
                let file = self.file.path_of(&table.files[0]).display().to_string();
                self.met.extend(passage.findings(&file).into_iter().map(|found| found.of_run(name)));
            }
            folded
        })
    }

    fn piece(&mut self, table: &RunTable, name: &str, options: &LogOptions, piece: Piece) -> Result<(), Error> {
        self.rows += piece.rows;
        tell(format!("{name}: rows folded"), self.rows, 0);
        let Piece { signals, units, gaps, .. } = piece;
        let run = Run { name: name.into(), kind: table.kind, role: table.role, signals, gaps };
        let position = options.position_source == Some(crate::log::options::PositionSource::Independent);
        let through_water = options.is_through_water();
        let logged = Logged { run, units, position, through_water, piece: true, ..Logged::default() };
        let mut campaign = match assemble(self.file.clone(), vec![logged], std::slice::from_ref(table), Vec::new()) {
            Ok(campaign) => campaign,
            // a window or a condition may leave nothing of a piece
            Err(Error::Refused { findings }) if findings.iter().all(|f| f.code == codes::NOTHING_LEFT.code) => {
                return Ok(());
            }
            Err(other) => return Err(other),
        };
        let Some(run) = campaign.runs.pop() else { return Ok(()) };
        self.seen.look(&campaign, &run);
        for (name, [low, high]) in envelope::of([&run]) {
            // Keulegan-Carpenter numbers belong to whole runs
            if !Dof::ALL.iter().any(|dof| channel::keulegan_carpenter(*dof) == name) {
                let range = self.envelope.entry(name).or_insert([low, high]);
                *range = [range[0].min(low), range[1].max(high)];
            }
        }
        let window = self.file.stage.oscillatory.window;
        let regressor = RegressorOptions { span: Span::Samples(window), ..RegressorOptions::default() };
        let streamed = self.streamed.get_or_insert_with(|| Streamed::new(&campaign.model, regressor));
        streamed.push(&run)?;
        if self.first.is_none() {
            // one piece cannot tell: other pieces may have commands, other tables another role
            let of_all = [codes::NO_SCALE.code, codes::NO_VALIDATION.code];
            campaign.findings.retain(|finding| !of_all.contains(&finding.code));
            self.first = Some(campaign);
        }
        Ok(())
    }
}

/// Returns the findings that need all pieces: degrees of freedom without a known force, and whether
/// some run validates.
fn of_all_pieces(campaign: &Campaign, seen: &Seen) -> Vec<Finding> {
    let formulas = baseline::driven_by_formulas(&campaign.file);
    let undriven: Vec<Dof> =
        seen.uncommanded(&campaign.model).into_iter().filter(|dof| !formulas.contains(dof)).collect();
    let roles = campaign.file.runs.iter().map(|table| table.role);
    scale::finding(&campaign.model, &undriven).into_iter().chain(unjudged(roles)).collect()
}

/// Refuses what cannot be done with pieces.
fn refuse_what_needs_all(file: &CampaignFile, table: &RunTable, name: &str) -> Result<(), Error> {
    let own = table.files.first().and_then(|file| file.log.as_ref());
    let options = own.or(table.log.as_ref()).unwrap_or(&file.log);
    let (model, _): (Model, _) = baseline::build(file)?;
    let whole = |channel: &str| {
        let amplitude = Dof::ALL.iter().any(|dof| channel::keulegan_carpenter(*dof) == channel);
        amplitude || [channel::SUPPLY_RATIO, channel::ANCHOR_NORTH, channel::ANCHOR_EAST].contains(&channel)
    };
    let reads = model.terms.iter().find(|t| t.effect.channels(t.place).iter().any(|c| whole(c)));
    let own = model.parameters.iter().find(|p| p.spec.per_run);
    let text = match (reads, own) {
        _ if table.files.len() != 1 => "a run of several logs cannot be streamed".to_string(),
        _ if options.sort => "`sort` needs the whole log".to_string(),
        _ if options.repeated == Repeated::NoSample => "`repeated = \"no_sample\"` needs the whole log".to_string(),
        _ if table.input.is_some_and(|input| input != file.model.input) => {
            "an `input` other than the model's needs all runs at once".to_string()
        }
        (Some(term), _) => format!("`{}` reads a channel that is computed from the whole run", term.name()),
        (None, Some(p)) => format!("{} of `{}` has its own value in each run", p.spec.name, p.term),
        _ => return Ok(()),
    };
    let text = format!("{name}: {text}; fit without --stream");
    Err(Error::Refused { findings: vec![Finding::new(&codes::NOT_STREAMED, text).of_run(name)] })
}

#[cfg(test)]
mod tests {
    use super::super::fit::{FitOptions, FitParameter, fit};
    use super::*;
    use crate::tank::{BlindOptions, write_blind};

    fn folder(name: &str) -> std::path::PathBuf {
        let folder = std::env::temp_dir().join(format!("hydrosysid-stream-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        folder
    }

    /// The same rows of the same balance, folded instead of kept: a QR decomposition with the rows
    /// in another order.
    #[test]
    fn a_stream_finds_what_logs_in_memory_say() {
        let folder = folder("same");
        write_blind(&folder, &BlindOptions { duration: 60.0, ..BlindOptions::default() }).unwrap();
        let path = folder.join("campaign.toml");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("coriolis = \"tied\"", "coriolis = \"free\"")).unwrap();
        let kept = Campaign::load(&path, LoadOptions::default()).unwrap();
        let kept = fit(&kept, FitOptions { estimator: Some(Estimator::Integral) }).unwrap();
        let (campaign, streamed) = in_pieces(&path, LoadOptions::default(), 70).unwrap();
        assert!(campaign.runs.is_empty() && streamed.std_method == "clusters of rows");
        assert!(streamed.warnings.iter().any(|w| w.code == codes::STREAMED.code && w.message.contains(" MiB")));
        assert_eq!(streamed.stages[0].rows, kept.stages[0].rows);
        assert_eq!(streamed.envelope["u"], kept.envelope["u"]);
        for (a, b) in streamed.parameters.iter().zip(&kept.parameters) {
            assert!((a.value / b.value - 1.0).abs() < 1e-8, "{}: {} {}", a.name, a.value, b.value);
            assert!((a.std_paper.unwrap() / b.std_paper.unwrap() - 1.0).abs() < 1e-8, "{}", a.name);
            // two corrections for correlated residuals: of similar size
            assert!((a.std.unwrap() / b.std.unwrap()).ln().abs() < 1.0, "{}: {:?} {:?}", a.name, a.std, b.std);
        }
        std::fs::remove_dir_all(folder).unwrap();
    }

    /// Bounds hold in a stream as they do in memory, and a degree of freedom at rest is refused.
    #[test]
    fn a_stream_keeps_bounds_and_refuses_what_rests() {
        let folder = folder("bounds");
        write_blind(&folder, &BlindOptions { duration: 60.0, ..BlindOptions::default() }).unwrap();
        let path = folder.join("campaign.toml");
        let text = std::fs::read_to_string(&path).unwrap().replace("coriolis = \"tied\"", "coriolis = \"free\"");
        let fits = || {
            let kept = Campaign::load(&path, LoadOptions::default()).unwrap();
            let options = FitOptions { estimator: Some(Estimator::Integral) };
            (fit(&kept, options).unwrap(), in_pieces(&path, LoadOptions::default(), 70).unwrap().1)
        };
        std::fs::write(&path, &text).unwrap();
        let free = fits().1;
        // a drag and an inertia that must be larger than these rows show
        let mut bounded = text.clone();
        for name in ["linear_drag@surge", "inertia@yaw"] {
            let (effect, dof) = name.split_once('@').unwrap();
            let own = |p: &&FitParameter| p.effect == effect && p.dof.is_some_and(|d| d.name() == dof);
            let value = 1.5 * free.parameters.iter().find(own).unwrap().value;
            bounded += &format!("\n[[parameter]]\neffect = \"{name}\"\nvalue = {value}\nmin = {value}\n");
        }
        std::fs::write(&path, bounded).unwrap();
        let (kept, streamed) = fits();
        let unphysical = |fit: &Fit| fit.warnings.iter().filter(|w| w.code == codes::UNPHYSICAL.code).count();
        assert_eq!((unphysical(&kept), unphysical(&streamed)), (2, 2));
        for (a, b) in streamed.parameters.iter().zip(&kept.parameters) {
            assert!((a.value - b.value).abs() <= 1e-8 * b.value.abs(), "{}: {} {}", a.name, a.value, b.value);
            assert_eq!(a.std.is_some(), b.std.is_some(), "{}", a.name);
        }

        std::fs::write(&path, &text).unwrap();
        let file = CampaignFile::read(&path, &ReadOptions::default()).unwrap();
        for table in &file.runs {
            at_rest(&file.path_of(&table.files[0]), &["v", "tau_v"]);
        }
        let refused = in_pieces(&path, LoadOptions::default(), 70).unwrap_err().to_string();
        assert!(refused.contains("sway: in no run of the fit"), "{refused}");
        std::fs::remove_dir_all(folder).unwrap();
    }

    /// Warnings are those of all pieces: a sway that later runs drive has a known force, a run that
    /// validates counts, and rows that the options drop are reported.
    #[test]
    fn a_stream_warns_as_logs_in_memory_do() {
        let folder = folder("warns");
        write_blind(&folder, &BlindOptions { duration: 60.0, ..BlindOptions::default() }).unwrap();
        let path = folder.join("campaign.toml");
        let text = std::fs::read_to_string(&path).unwrap().replace("coriolis = \"tied\"", "coriolis = \"free\"");
        std::fs::write(&path, text.replacen("[log]", "[log]\nmissing = \"drop\"", 1)).unwrap();
        let file = CampaignFile::read(&path, &ReadOptions::default()).unwrap();
        // a cell of the last row is empty
        let log = file.path_of(&file.runs[0].files[0]);
        let rows = std::fs::read_to_string(&log).unwrap();
        let last = rows.trim_end().rsplit_once(',').unwrap().0;
        std::fs::write(&log, format!("{last},\n")).unwrap();
        // the first run, and with it the first piece, drives no sway
        at_rest(&log, &["tau_v"]);
        let codes = |fit: &Fit| -> Vec<&str> {
            let of_the_log =
                |code: &&str| code.starts_with('L') || [codes::NO_SCALE.code, codes::NO_VALIDATION.code].contains(code);
            let mut codes: Vec<&str> = fit.warnings.iter().map(|w| w.code).filter(of_the_log).collect();
            codes.sort_unstable();
            codes
        };
        let kept = Campaign::load(&path, LoadOptions::default()).unwrap();
        let kept = fit(&kept, FitOptions { estimator: Some(Estimator::Integral) }).unwrap();
        let streamed = in_pieces(&path, LoadOptions::default(), 70).unwrap().1;
        assert_eq!(codes(&streamed), codes(&kept), "{:?} {:?}", streamed.warnings, kept.warnings);
        let dropped = streamed.warnings.iter().find(|w| w.message.contains("1 row dropped")).unwrap();
        assert_eq!(dropped.run.as_deref(), Some(file.runs[0].files[0].file.as_str()));
        std::fs::remove_dir_all(folder).unwrap();
    }

    /// Writes 0 into columns of a log.
    fn at_rest(log: &Path, columns: &[&str]) {
        let mut rows = csv::ReaderBuilder::new().has_headers(false).from_path(log).unwrap();
        let rows: Vec<Vec<String>> = rows.records().map(|row| row.unwrap().iter().map(Into::into).collect()).collect();
        let mut to = csv::Writer::from_path(log).unwrap();
        for (i, row) in rows.iter().enumerate() {
            let cell = |(name, cell): (&String, &String)| match i > 0
                && columns.contains(&name.split(' ').next().unwrap_or(name))
            {
                true => "0".to_string(),
                false => cell.clone(),
            };
            to.write_record(rows[0].iter().zip(row).map(cell)).unwrap();
        }
        to.flush().unwrap();
    }

    /// Only the size on disk counts: a log padded with zeros is as large as any other.
    #[test]
    fn logs_are_kept_unless_they_are_large_and_can_be_read_in_pieces() {
        let folder = folder("large");
        write_blind(&folder, &BlindOptions { duration: 5.0, ..BlindOptions::default() }).unwrap();
        let path = folder.join("campaign.toml");
        let large = |estimator| too_large_to_keep(&path, LoadOptions::default(), estimator).unwrap();
        assert!(!large(Some(Estimator::Integral)));
        let file = CampaignFile::read(&path, &ReadOptions::default()).unwrap();
        let log = file.path_of(&file.runs[0].files[0]);
        std::fs::OpenOptions::new().append(true).open(&log).unwrap().set_len(KEPT + 1).unwrap();
        assert!(large(Some(Estimator::Integral)) && !large(Some(Estimator::OutputError)) && !large(None));
        let text = std::fs::read_to_string(&path).unwrap();
        let sorted = text.replacen("[log]", "[log]\nsort = true", 1);
        assert_ne!(text, sorted);
        std::fs::write(&path, sorted).unwrap();
        assert!(!large(Some(Estimator::Integral)));
        std::fs::remove_dir_all(folder).unwrap();
    }
}
