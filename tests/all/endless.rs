//! Inputs without end, inputs that can be read only once, and inputs with one very long line.
#![cfg(target_os = "linux")]

use std::fs::{self, File};
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output};

/// Maximum address space of a call, KiB: 200 MiB with code and stacks.
const ROOM: u64 = 200 << 10;

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("hydrosysid-endless-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("the temporary folder can be made");
        Folder(path)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Runs the command with an address space of [`ROOM`]; a larger allocation would abort it.
fn run(arguments: &[&str]) -> Output {
    // the time limit ends a command that waits for a second writer
    let script = format!("ulimit -v {ROOM}; exec timeout 120 \"$0\" \"$@\" -j 1");
    let mut shell = Command::new("sh");
    shell.args(["-c", &script, env!("CARGO_BIN_EXE_hydrosysid")]).args(arguments);
    // one heap for all threads: each further one reserves 64 MiB
    shell.env("MALLOC_ARENA_MAX", "1").env("NO_COLOR", "1").output().expect("the shell starts")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Asserts that every verb that takes a file refuses this one with a message.
fn is_refused(path: &str) {
    // not `init`, which accepts any log and writes a file that lists what it could not use
    let calls: [&[&str]; 7] = [
        &["check", path],
        &["convert", path, "/dev/null"],
        &["fit", path],
        &["compare", path, path],
        &["export", path, "--to", "csv"],
        &["plan", path],
        &["monitor", path, path],
    ];
    for arguments in calls {
        let output = run(arguments);
        assert!(matches!(output.status.code(), Some(1 | 2)), "{arguments:?}: {:?} {}", output.status, told(&output));
        assert!(told(&output).contains("error") && told(&output).len() < 4000, "{arguments:?}: {}", told(&output));
    }
}

#[test]
fn a_device_without_end_is_refused() {
    is_refused("/dev/zero");
}

#[test]
fn a_sparse_file_of_gigabytes_is_refused() {
    let folder = Folder::new("sparse");
    let path = folder.path("log.csv");
    File::create(&path).and_then(|file| file.set_len(8 << 30)).expect("the temporary folder can be written");
    is_refused(&path);
    assert!(told(&run(&["check", &path])).contains("a NUL byte"));
    let campaign = folder.path("campaign.toml");
    let text =
        "format = 1\n[model]\ndofs = ['surge']\neffects = ['inertia', 'linear_drag']\n[[run]]\nfile = 'short.csv'\n";
    fs::write(&campaign, text).expect("it can be written");
    let rows: String = (0..90).map(|k| format!("{},{},{}\n", 0.1 * f64::from(k), f64::from(k % 7), k % 5)).collect();
    let short = folder.path("short.csv");
    fs::write(&short, "t,u,tau_u\n".to_string() + &rows).expect("it can be written");
    // in place of published parameters or of a vehicle file it is refused as well
    for arguments in [
        &["compare", &campaign, "--params", &path] as &[&str],
        &["report", &campaign, "--params", &path, "-o", "/dev/null"],
        &["init", &short, "--vehicle", &path, "-o", &folder.path("made")],
    ] {
        let output = run(arguments);
        assert!(matches!(output.status.code(), Some(1 | 2)), "{arguments:?}: {:?} {}", output.status, told(&output));
        assert!(told(&output).contains("larger than 64 MiB"), "{arguments:?}: {}", told(&output));
    }
}

#[test]
fn a_line_of_a_hundred_megabytes_is_refused() {
    let folder = Folder::new("line");
    for (name, first) in [("header.csv", ""), ("row.csv", "t,u,v,r,tau_u,tau_v,tau_r\n0,1,1,1,1,1,1\n")] {
        let path = folder.path(name);
        let mut file = File::create(&path).expect("the temporary folder can be written");
        file.write_all(first.as_bytes()).expect("it can be written");
        (0..100).for_each(|_| file.write_all(&vec![b'7'; 1 << 20]).expect("it can be written"));
        is_refused(&path);
        let told = told(&run(&["check", &path]));
        assert!(told.contains("max_line_bytes") && told.contains("777") && told.contains("^^^"), "{told}");
    }
}

#[test]
fn a_pipe_is_read_once_and_its_line_still_shown() {
    let folder = Folder::new("pipe");
    let pipe = folder.path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("it starts").success());
    let text = "t,u,v,r,tau_u,tau_v,tau_r\n0,1,1,1,1,1,1\n1,\"1\",1,wrong,1,1,1\n2,1,1,1,1,1,1\n";
    let campaign = folder.path("campaign.toml");
    // a file that must be read several times is refused before it is opened
    let refused = run(&["init", &pipe, "-o", &campaign]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(told(&refused).contains("only once: save it as a file"), "{}", told(&refused));
    // so is a campaign that a verb reads again, for its size or its hash
    for verb in ["fit", "plan", "report"] {
        let refused = run(&[verb, &pipe]);
        assert_eq!(refused.status.code(), Some(2), "{verb}");
        assert!(told(&refused).contains("only once: save it as a file"), "{verb}: {}", told(&refused));
    }
    for verb in [&["check", &pipe] as &[&str], &["convert", &pipe, "/dev/null"]] {
        // a writer with a time limit, in case nobody opens the pipe
        let mut writer = Command::new("timeout")
            .args(["20", "sh", "-c", "printf '%s' \"$1\" > \"$2\"", "sh", text, &pipe])
            .spawn()
            .expect("it starts");
        let output = run(verb);
        assert!(writer.wait().expect("it ends").success(), "{verb:?} has not read it to its end: {}", told(&output));
        let told = told(&output);
        assert_eq!(output.status.code(), Some(1), "{verb:?}: {told}");
        let lines: Vec<&str> = told.lines().collect();
        let shown = lines.iter().position(|line| line.contains("1,\"1\",1,wrong,1,1,1")).expect("the line is shown");
        assert_eq!(lines[shown].find("wrong"), lines[shown + 1].find("^^^^^"), "{told}");
    }
}
