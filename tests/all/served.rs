//! A server of the page on its own folder, addressed over a socket.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use hydrosysid::view::{View, ViewOptions};
use serde_json::{Value, json};

/// A server on its own folder; both end when it is dropped.
pub struct Served {
    pub folder: PathBuf,
    view: Arc<View>,
    thread: Option<std::thread::JoinHandle<()>>,
}

/// An answer: status, headers, body.
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: String,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|_| panic!("no JSON: {}", self.body))
    }
}

impl Served {
    pub fn new(name: &str, fill: impl FnOnce(&Path)) -> Served {
        let folder = std::env::temp_dir().join(format!("hydrosysid-view-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).expect("the temporary folder can be made");
        fill(&folder);
        let options = ViewOptions { campaign: folder.clone(), ..ViewOptions::default() };
        let view = Arc::new(View::open(&options).expect("a port is free"));
        let serving = view.clone();
        let thread = Some(std::thread::spawn(move || serving.serve()));
        Served { folder, view, thread }
    }

    pub fn place(&self) -> (String, String) {
        let address = self.view.address();
        let (host, token) = address["http://".len()..].split_once("/?token=").expect("the address has a token");
        (host.to_string(), token.to_string())
    }

    /// Sends a raw request and returns the answer.
    pub fn send(&self, text: &[u8]) -> Answer {
        let mut stream = TcpStream::connect(self.place().0).expect("the server listens");
        stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a socket has a time limit");
        // the server may refuse before everything is sent
        let _ = stream.write_all(text);
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
        let status = head.split(' ').nth(1).and_then(|s| s.parse().ok()).unwrap_or(0);
        Answer { status, head: head.to_string(), body: body.to_string() }
    }

    /// Sends a request with these headers in addition to `Connection` and `Content-Length`.
    pub fn request(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
        let mut text = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n");
        for (name, value) in headers {
            text += &format!("{name}: {value}\r\n");
        }
        text += &format!("Content-Length: {}\r\n\r\n", body.len());
        self.send(&[text.as_bytes(), body].concat())
    }

    pub fn get(&self, path: &str) -> Answer {
        let (host, token) = self.place();
        self.request("GET", path, &[("Host", &host), ("X-Hydrosysid-Token", &token)], b"")
    }

    pub fn post(&self, path: &str, body: &[u8]) -> Answer {
        let (host, token) = self.place();
        self.request("POST", path, &[("Host", &host), ("X-Hydrosysid-Token", &token)], body)
    }

    /// Posts a request that must succeed.
    pub fn done(&self, path: &str, body: &Value) -> Value {
        let answer = self.post(path, body.to_string().as_bytes());
        assert_eq!(answer.status, 200, "{path}: {}", answer.body);
        answer.json()
    }

    pub fn text(&self) -> String {
        fs::read_to_string(self.folder.join("campaign.toml")).expect("the campaign is there")
    }

    /// The first fit of the campaign in its current state.
    pub fn looked(&self) -> Value {
        let stamp = self.get("/api/progress").json()["stamp"].clone();
        self.done("/api/fit", &json!({}));
        loop {
            let fit = self.get("/api/fit").json();
            if fit["stamp"] == stamp {
                return fit;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Waits until a task has ended, and returns its progress.
    pub fn wait(&self, work: &str) -> Value {
        let begun = Instant::now();
        loop {
            let progress = self.get("/api/progress").json()[work].clone();
            if progress["running"] == json!(false) {
                return progress;
            }
            assert!(begun.elapsed() < Duration::from_secs(300), "{work} takes too long: {progress}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.view.stop();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        let _ = fs::remove_dir_all(&self.folder);
    }
}
