//! The reader of logs: whatever the bytes, a log of finite numbers in increasing time, or findings. What was read is
//! written, and read again to the same bits.
//!
//! The first line may hold `[log]` options as TOML in one line, `#! missing = "drop"`.

#![no_main]

use hydrosysid::check::{self, CheckOptions};
use hydrosysid::log::{self, LogFile, LogOptions, options::Missing};
use hydrosysid_fuzz::within_memory;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| within_memory(|| read(data)));

fn read(data: &[u8]) {
    let (options, bytes) = split(data);
    match log::read_from(bytes, "log.csv", &options, &["t", "u"]) {
        Ok(read) => {
            sound(&read);
            check::log(&read, &CheckOptions::default());
            round_trip(&read);
        }
        Err(refused) => assert!(!refused.to_string().is_empty()),
    }
}

fn split(data: &[u8]) -> (LogOptions, &[u8]) {
    let rest = data.strip_prefix(b"#!").and_then(|rest| Some(rest.split_at(rest.iter().position(|b| *b == b'\n')?)));
    let options = rest.and_then(|(line, _)| toml::from_str(std::str::from_utf8(line).ok()?).ok());
    match (options, rest) {
        (Some(options), Some((_, bytes))) => (options, &bytes[1..]),
        _ => (LogOptions::default(), data),
    }
}

fn sound(read: &LogFile) {
    for signal in read.signals.values() {
        assert!(signal.values().iter().chain(signal.time()).all(|x| x.is_finite()));
        assert!(signal.time().windows(2).all(|w| w[0] < w[1]));
    }
    assert!(read.gaps.windows(2).all(|w| w[0] < w[1]));
}

fn round_trip(read: &LogFile) {
    let mut bytes = Vec::new();
    log::write_log(read, &mut bytes).expect("memory takes all");
    let options = LogOptions { missing: Missing::NoSample, ..LogOptions::default() };
    // stamps that start late are those of a wall clock, and would be counted anew
    if read.time.first().is_some_and(|t| t.abs() >= 1e8) {
        return;
    }
    let again = log::read_from(&bytes[..], "again.csv", &options, &["t"]).expect("what was written is a log");
    for (name, signal) in &read.signals {
        let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        let same = &again.signals[name];
        assert_eq!(bits(signal.time()), bits(same.time()), "{name}");
        assert_eq!(bits(signal.values()), bits(same.values()), "{name}");
    }
}
