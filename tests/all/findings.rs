//! The table of `docs/findings.md` over a few seeds: at least 98 % of the faults injected into logs
//! of the plant are found, and at most 1 % of the sound logs raise a warning.

use crate::findings_table::estimates::ESTIMATES;
use crate::findings_table::faults::FAULTS;
use crate::findings_table::judge::{Base, SOUND, of_sound};

/// Seeds that the table does not use.
const SEEDS: std::ops::Range<u64> = 80_001..80_004;

#[test]
fn faults_are_told() {
    let base = Base::sail(SEEDS).expect("the plant sails");
    let (mut hits, mut all, mut misses) = (0, 0, Vec::new());
    for (number, fault) in FAULTS.iter().chain(&ESTIMATES).enumerate() {
        let (hit, of, missed) = base.hits(number, fault).expect("a log can be written");
        (hits, all) = (hits + hit, all + of);
        misses.extend(missed.keys().map(|codes| format!("{}: {codes}", fault.name)));
    }
    assert!(all >= 3 * (FAULTS.len() + ESTIMATES.len()) && 100 * hits >= 98 * all, "{hits} of {all}: {misses:#?}");
}

#[test]
fn sound_logs_raise_no_warning() {
    let (mut wrong, mut all) = (Vec::new(), 0);
    for (name, way) in SOUND {
        let told = of_sound(SEEDS, way, name).expect("the plant sails");
        all += told.len();
        wrong.extend(told.into_iter().filter(|codes| !codes.is_empty()).map(|codes| format!("{name}: {codes:?}")));
    }
    assert!(all >= 100 && 100 * wrong.len() <= all, "{} of {all}: {wrong:#?}", wrong.len());
}
