//! The work page, `hydrosysid view`: a server on this machine only, whose page edits one
//! `campaign.toml`.
//!
//! Nothing is stored only in the page. Every change is written into the campaign file, with
//! comments kept, before the page shows it, and every figure comes from the functions that command
//! line and Python call: [`campaign::init`](mod@crate::campaign), `check`, `fit`, `simulate`,
//! `compare`, `discover`, `adopt` and the report. The file has priority: an edit made elsewhere
//! appears in the page.
//!
//! The server listens on 127.0.0.1. A request must carry the token of the printed address and name
//! this host, so that no other page of the browser can reach the server, not even through a host
//! name that resolves to it (DNS rebinding).

mod answer;
mod columns;
mod discovery;
mod edit;
mod effects;
mod fit;
mod logs;
mod outline;
mod page;
mod plot;
mod query;
mod report;
mod routes;
mod server;
mod stretches;
mod task;
mod token;
mod workspace;

pub use server::{View, ViewError, ViewOptions};
