//! The page to work with, `hydrosysid view`: a server on this machine alone, whose page edits one `campaign.toml`.
//!
//! Nothing exists only in the page. Every change is written into the campaign file, comments kept, before the page shows
//! it, and every figure comes from the functions that command line and Python call: [`campaign::init`](mod@crate::campaign),
//! `check`, `fit`, `simulate`, `compare`, `discover`, `adopt` and the report. What the file says wins: an edit elsewhere
//! shows up in the page.
//!
//! The server listens on 127.0.0.1. A request has to carry the token of the address that was printed, and to ask for this
//! host by its name, so that no other page of the browser reaches it, not even by a name that leads here (DNS rebinding).

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
