//! Destinations of results: full disks, devices, pipes, links, and files that must not be overwritten.
#![cfg(unix)]

use std::fs::{self, File, Permissions};
use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A folder for one test, which is removed when it is dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("hydrosysid-outputs-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("the temporary folder can be made");
        fs::write(path.join("log.csv"), log()).expect("the temporary folder can be written");
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

fn log() -> String {
    let row = |k: i32| {
        let t = 0.1 * f64::from(k);
        format!("{t:.1},{:.4},{:.4},{:.4},{:.3},{:.3},{:.3}\n", t.sin(), t.cos(), (2.0 * t).sin(), t, -t, 5.0 - t)
    };
    "t,u,v,r,tau_u,tau_v,tau_r\n".to_string() + &(0..60).map(row).collect::<String>()
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hydrosysid"));
    command.args(arguments).env("NO_COLOR", "1");
    command
}

fn run(arguments: &[&str]) -> Output {
    command(arguments).output().expect("the command starts")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let folder = Folder::new("full");
    let log = folder.path("log.csv");
    let calls: [&[&str]; 5] =
        [&["effects"], &["explain"], &["init", "log.csv"], &["--help"], &["effects", "--json", "-"]];
    for arguments in calls {
        let full = || Stdio::from(File::options().write(true).open("/dev/full").expect("it is there"));
        let status =
            command(arguments).current_dir(&folder.0).stdout(full()).stderr(Stdio::null()).status().expect("it starts");
        assert_eq!(status.code(), Some(2), "{arguments:?}");
        let status = command(arguments)
            .current_dir(&folder.0)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .expect("it starts");
        assert_eq!(status.code(), Some(0), "{arguments:?}");
    }
    let output = run(&["convert", &log, "-o", "/dev/full"]);
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    assert!(Path::new("/dev/full").metadata().is_ok_and(|found| found.file_type().is_char_device()));
}

#[test]
fn links_permissions_and_devices_stay_what_they_are() {
    let folder = Folder::new("links");
    let (log, link, file) = (folder.path("log.csv"), folder.path("link.csv"), folder.path("plain.csv"));
    fs::write(&file, "old").expect("it can be written");
    fs::set_permissions(&file, Permissions::from_mode(0o600)).expect("they can be set");
    symlink("plain.csv", &link).expect("a link can be made");
    assert_eq!(run(&["convert", &log, "-o", &link]).status.code(), Some(2), "without --force nothing is replaced");
    let output = run(&["convert", &log, "-o", &link, "--force"]);
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    assert!(fs::symlink_metadata(&link).expect("it is there").is_symlink());
    assert!(fs::read_to_string(&file).expect("it is text").starts_with("t [s],"));
    assert_eq!(fs::metadata(&file).expect("it is there").permissions().mode() & 0o777, 0o600);

    let pipe = folder.path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("it starts").success());
    let reader = {
        std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read_to_string(pipe)
        })
    };
    let output = run(&["convert", &log, "-o", &pipe, "--force"]);
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    assert!(reader.join().expect("it reads").expect("it is text").starts_with("t [s],"));
    assert!(fs::metadata(&pipe).expect("it is there").file_type().is_fifo());
    // a shell's >(…) and | are links of the process that lead to no path
    let script = "\"$0\" convert \"$1\" -o /dev/stdout --quiet | head -1";
    let piped =
        Command::new("sh").args(["-c", script, env!("CARGO_BIN_EXE_hydrosysid"), &log]).output().expect("it starts");
    assert!(String::from_utf8_lossy(&piped.stdout).starts_with("t [s],"), "{}", told(&piped));
    let output = run(&["convert", &log, "-o", "/dev/null", "--force"]);
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    assert!(Path::new("/dev/null").metadata().is_ok_and(|found| found.file_type().is_char_device()));
}

#[test]
fn what_a_call_reads_it_never_writes() {
    let folder = Folder::new("inputs");
    let (log, campaign) = (folder.path("log.csv"), folder.path("campaign.toml"));
    let text = "format = 1\n[model]\ndofs = ['surge', 'sway', 'yaw']\neffects = ['inertia', 'linear_drag']\n[[run]]\nfile = 'log.csv'\n";
    fs::write(&campaign, text).expect("it can be written");
    let other = folder.path("other.csv");
    fs::hard_link(&log, &other).expect("a link can be made");
    let link = folder.path("link.csv");
    symlink("log.csv", &link).expect("a link can be made");
    let here = folder.0.display().to_string();
    let calls: [&[&str]; 10] = [
        &["convert", &log, "-o", &log],
        &["convert", &log, "-o", &other],
        &["convert", &log, "-o", &link],
        &["check", &campaign, "--json", &log],
        &["check", &campaign, "--json", &campaign],
        &["init", &log, "-o", &log],
        &["fit", &campaign, "--estimator", "integral", "--model", &log],
        &["fit", &here, "--estimator", "integral", "--model", &log],
        &["check", &here, "--json", &campaign],
        &["report", &here, "-o", &log],
    ];
    for arguments in calls {
        let output = run(&[arguments, &["--force"]].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", told(&output));
        assert!(told(&output).contains("this call reads that file"), "{arguments:?}: {}", told(&output));
    }
    assert_eq!(fs::read_to_string(&log).expect("it is there"), self::log());
    assert_eq!(fs::read_to_string(&campaign).expect("it is there"), text);
}
