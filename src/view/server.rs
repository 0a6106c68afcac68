//! The server: access control, size limits, and the threads that answer.

use std::io::{Cursor, Read};
use std::net::TcpStream;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use thiserror::Error;
use tiny_http::{Header, Method, Request, Response, Server};

use super::answer::{Answer, Refusal};
use super::query::Query;
use super::routes::{Asked, answer};
use super::token::Token;
use super::workspace::Workspace;
use crate::campaign::file::CampaignFile;

/// Number of requests that are answered in parallel: a slow one does not block the others.
const THREADS: usize = 6;

/// Maximum time for which a connection waits for a thread.
const KNOCK: Duration = Duration::from_millis(400);

/// Name of the header with the token.
const TOKEN: &str = "X-Hydrosysid-Token";

/// Name of the header with the stamp of the campaign that a change is meant for.
const STAMP: &str = "X-Hydrosysid-Stamp";

/// Options of the server.
#[derive(Debug, Clone, Default)]
pub struct ViewOptions {
    /// The campaign file or its folder; a folder without a campaign gets one with the first log.
    pub campaign: PathBuf,
    /// Port; 0 for any free one.
    pub port: u16,
    /// Allow logs outside the campaign's folder.
    pub allow_outside: bool,
}

/// Error at the start of the server.
#[derive(Debug, Error)]
pub enum ViewError {
    /// Neither the campaign nor a folder for it exists.
    #[error("{}: there is no such folder: create it, or name a campaign file", .0.display())]
    NoFolder(PathBuf),
    /// The port cannot be used.
    #[error("port {port} of 127.0.0.1 cannot be used: {message}; choose another with --port")]
    Port {
        /// The port.
        port: u16,
        /// Cause.
        message: String,
    },
    /// The system has no random numbers for the token.
    #[error("the system provides no random numbers for the token: {0}")]
    Random(#[from] getrandom::Error),
}

/// A page that is served on 127.0.0.1 until the program ends or [`View::stop`] is called.
pub struct View {
    server: Server,
    port: u16,
    token: Token,
    workspace: Arc<Workspace>,
    stopped: AtomicBool,
}

impl View {
    /// Takes the port; [`View::serve`] then answers.
    ///
    /// # Errors
    /// [`ViewError`].
    pub fn open(options: &ViewOptions) -> Result<View, ViewError> {
        let file = CampaignFile::at(&options.campaign);
        let folder = file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_path_buf();
        // a missing name without an extension was meant as a folder
        if !folder.is_dir() || (!file.is_file() && file.extension().is_none_or(|e| e != "toml")) {
            return Err(ViewError::NoFolder(options.campaign.clone()));
        }
        let token = Token::random()?;
        let refused = |message: String| ViewError::Port { port: options.port, message };
        let server = Server::http(("127.0.0.1", options.port)).map_err(|e| refused(e.to_string()))?;
        let port = server.server_addr().to_ip().map(|at| at.port()).ok_or_else(|| refused("no address".into()))?;
        let workspace = Arc::new(Workspace::new(file, folder, options.allow_outside));
        Ok(View { server, port, token, workspace, stopped: AtomicBool::new(false) })
    }

    /// The address of the page, with its token.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/?token={}", self.port, self.token.text())
    }

    /// Answers until [`View::stop`].
    pub fn serve(&self) {
        std::thread::scope(|scope| {
            for _ in 0..THREADS {
                scope.spawn(|| {
                    while !self.stopped.load(Ordering::Relaxed) {
                        if let Ok(request) = self.server.recv() {
                            self.handle(request);
                        }
                    }
                });
            }
            scope.spawn(|| self.knock());
        });
    }

    /// Connects to its own port regularly. tiny_http 0.12 counts a thread that it has woken as
    /// waiting until that thread runs: if two connections come at once, the second may wait for a
    /// thread until another connection ends. A connection that ends at once frees a thread.
    fn knock(&self) {
        while !self.stopped.load(Ordering::Relaxed) {
            drop(TcpStream::connect(("127.0.0.1", self.port)));
            std::thread::sleep(KNOCK);
        }
    }

    /// Ends [`View::serve`] and all running work.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
        self.workspace.fit.stop();
        self.workspace.discovery.stop();
        self.workspace.report.stop();
        for _ in 0..THREADS {
            self.server.unblock();
        }
    }

    fn handle(&self, mut request: Request) {
        let asked = self.admitted(&request).and_then(|query| {
            let post = *request.method() == Method::Post;
            let stamp = request.headers().iter().find(|h| h.field.equiv(STAMP)).map(|h| h.value.to_string());
            let asked = Asked { post, query, stamp, body: request.as_reader() };
            catch_unwind(AssertUnwindSafe(|| answer(&self.workspace, asked)))
                .unwrap_or_else(|_| Err(Refusal::failed("internal error: this request ended in a panic")))
        });
        // the client may have closed the connection
        let _ = request.respond(response(asked.unwrap_or_else(|refusal| refusal.answer())));
    }

    /// The query of a request that passes the access control.
    fn admitted(&self, request: &Request) -> Result<Query, Refusal> {
        let headers = |name: &'static str| request.headers().iter().filter(move |h| h.field.equiv(name));
        let hosts: Vec<&str> = headers("Host").map(|h| h.value.as_str()).collect();
        let here = |host: &str| ["127.0.0.1", "localhost"].iter().any(|name| host == format!("{name}:{}", self.port));
        if !matches!(hosts.as_slice(), [host] if here(host)) {
            return Err(Refusal::forbidden("this server answers only on 127.0.0.1"));
        }
        let own = |origin: &str| origin.strip_prefix("http://").is_some_and(here);
        if headers("Origin").any(|h| !own(h.value.as_str())) {
            return Err(Refusal::forbidden(
                "the request comes from another page: only the page of this server may send \
                                           it",
            ));
        }
        let query = Query::of(request.url());
        let sent = headers(TOKEN).next().map(|h| h.value.as_str());
        let given = match request.method() {
            // any page can link to an address, but not set a header
            Method::Post => sent,
            Method::Get => sent.or(Some(query.value("token"))),
            _ => return Err(Refusal { status: 405, ..Refusal::bad("only GET and POST are answered") }),
        };
        match given.is_some_and(|token| self.token.is(token)) {
            true => Ok(query),
            false => Err(Refusal::forbidden("the token is wrong or missing: open the address that hydrosysid printed")),
        }
    }
}

/// The HTTP response, with headers that forbid caching, framing and use by other pages.
fn response(answer: Answer) -> Response<Cursor<Vec<u8>>> {
    let fixed = [
        ("Content-Type", answer.media),
        ("Content-Security-Policy", answer.policy.as_str()),
        ("Cache-Control", "no-store"),
        ("Referrer-Policy", "no-referrer"),
        ("X-Content-Type-Options", "nosniff"),
        ("X-Frame-Options", "DENY"),
        ("Cross-Origin-Resource-Policy", "same-origin"),
    ];
    let headers: Vec<Header> =
        fixed.iter().filter_map(|(name, value)| Header::from_bytes(*name, *value).ok()).collect();
    let length = answer.body.len();
    let whole = Response::new(answer.status.into(), headers, Cursor::new(answer.body), Some(length), None);
    // the length is known, so the response is not sent in chunks
    whole.with_chunked_threshold(usize::MAX)
}

/// Reads a whole body of at most `most` bytes.
pub(super) fn read_body(body: &mut dyn Read, most: u64) -> Result<Vec<u8>, Refusal> {
    let mut bytes = Vec::new();
    body.take(most + 1).read_to_end(&mut bytes).map_err(|e| Refusal::bad(format!("the request broke off: {e}")))?;
    match bytes.len() as u64 > most {
        true => Err(Refusal::too_large(format!("more than {most} bytes were sent"))),
        false => Ok(bytes),
    }
}
