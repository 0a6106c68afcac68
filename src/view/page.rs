//! The page itself: one HTML file with its style and script, and nothing from other sources.

use askama::Template;

use super::answer::{Answer, Refusal};
use super::token::nonce;
use crate::report::{SCRIPT, figure_style, page_style};

#[derive(Template)]
#[template(path = "view/view.html")]
struct Page {
    nonce: String,
    version: &'static str,
    chart_style: String,
    figure_style: String,
    report_style: &'static str,
    view_style: &'static str,
    script: &'static [&'static str],
}

/// Parts of the script, in order: one file per part of the page.
const SCRIPTS: &[&str] = &[
    SCRIPT,
    include_str!("../../templates/view/elements.js"),
    include_str!("../../templates/view/server.js"),
    include_str!("../../templates/view/logs.js"),
    include_str!("../../templates/view/columns.js"),
    include_str!("../../templates/view/stretches.js"),
    include_str!("../../templates/view/effects.js"),
    include_str!("../../templates/view/fit.js"),
    include_str!("../../templates/view/discovery.js"),
    include_str!("../../templates/view/report.js"),
    include_str!("../../templates/view/view.js"),
];

/// The page, with a policy that allows only its own style and script and connections to this server
/// only.
pub(super) fn page() -> Result<Answer, Refusal> {
    let nonce = nonce().map_err(|e| Refusal::failed(format!("the system provides no random numbers: {e}")))?;
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; connect-src 'self'; img-src data:; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    let page = Page {
        nonce,
        version: env!("CARGO_PKG_VERSION"),
        chart_style: page_style(),
        figure_style: figure_style(),
        report_style: include_str!("../../templates/report.css"),
        view_style: include_str!("../../templates/view/view.css"),
        script: SCRIPTS,
    };
    let html = page.render().map_err(|e| Refusal::failed(e.to_string()))?;
    Ok(Answer::page(html, policy))
}
