//! The verb `view`: starts the server, prints its address, opens it in a browser, and answers until
//! Ctrl-C.

use std::process::{Command, Stdio};

use super::arguments as typed;
use super::failure::Failure;
use super::output::Output;
use crate::view::{View, ViewOptions};

pub(super) fn view(a: &typed::View, output: &Output) -> Result<(), Failure> {
    output.may_write(None)?;
    let options = ViewOptions { campaign: a.campaign.clone(), port: a.port, allow_outside: a.loading.allow_outside };
    let view = View::open(&options)?;
    let address = view.address();
    output.json(&serde_json::json!({"format": 1, "address": address}))?;
    if !output.json_on_stdout() {
        output.hand_over(&format!("{address}\n"));
    }
    // now, because a caller may be waiting for the address
    output.finish()?;
    if !a.no_browser && !open(&address) {
        output.remark("no browser could be opened: open the address above in one");
    }
    output.remark("this page is served until Ctrl-C");
    view.serve();
    Ok(())
}

/// Opens an address in the user's browser; returns whether a program for it was found.
fn open(address: &str) -> bool {
    let (program, arguments): (&str, &[&str]) = match std::env::consts::OS {
        "macos" => ("open", &[]),
        "windows" => ("rundll32", &["url.dll,FileProtocolHandler"]),
        _ => ("xdg-open", &[]),
    };
    let started = Command::new(program)
        .args(arguments)
        .arg(address)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    started.is_ok()
}
