//! A campaign: one vehicle, its runs, and what is asked of them.
//!
//! [`file`] reads and writes its TOML.

pub mod file;
