//! The interactive page: the real server, addressed over a socket with requests of a browser and
//! with ones it must refuse.

use std::fs;
use std::path::Path;

use hydrosysid::log;
use hydrosysid::tank::{BlindOptions, Hidden, blind, write_blind};
use hydrosysid::view::{View, ViewError, ViewOptions};
use serde_json::{Value, json};

use crate::adopt::sail;
use crate::served::Served;

/// Writes runs of the virtual tank and a campaign of them, with comments that must be kept.
fn tank(folder: &Path) {
    let made = blind(&BlindOptions { duration: 40.0, ..BlindOptions::default() }).expect("the tank sails");
    let mut text = "# my own words\nformat = 1\n[vehicle]\nname = 'tank' # the tub\nmass = 100.0\nlength = 0.6\n[model]\ndofs = ['surge', 'sway', 'yaw']\neffects = [\n  'inertia',  # of course\n  'linear_drag',\n  'quadratic_drag',\n]\n[log]\nposition_source = 'independent'\nmissing = 'no_sample'\n[fit]\nestimator = 'output_error' # quick\n".to_string();
    for (k, role) in [(0, "train"), (2, "train"), (4, "train"), (6, "validate")] {
        log::write(&made.runs[k], folder.join(format!("run{k}.csv"))).expect("the log is written");
        text += &format!("[[run]]\nfile = 'run{k}.csv' # number {k}\nrole = '{role}'\n");
    }
    fs::write(folder.join("campaign.toml"), text).expect("the campaign is written");
}

#[test]
fn only_whoever_has_the_token_and_asks_for_this_host_is_answered() {
    let served = Served::new("guard", tank);
    let (host, token) = served.place();
    let (own, right) = (("Host", host.as_str()), ("X-Hydrosysid-Token", token.as_str()));
    let get = |path: &str, headers: &[(&str, &str)]| served.request("GET", path, headers, b"").status;
    assert_eq!(get("/api/campaign", &[own, right]), 200);
    assert_eq!(get(&format!("/?token={token}"), &[own]), 200);
    assert_eq!(get(&format!("/?token={token}"), &[("Host", &host.replace("127.0.0.1", "localhost"))]), 200);
    for path in ["/", "/api/campaign", "/?token=", "/?token=0000", "/nothing"] {
        assert_eq!(get(path, &[own]), 403, "{path}");
    }
    let foreign = host.replace("127.0.0.1", "evil.example");
    for wrong in [foreign.as_str(), "127.0.0.1", "127.0.0.1:1", "", "127.0.0.1.evil.example"] {
        assert_eq!(get("/api/campaign", &[("Host", wrong), right]), 403, "{wrong}");
    }
    assert_eq!(get("/api/campaign", &[right]), 403, "no host");
    assert_eq!(get("/api/campaign", &[own, ("Host", "evil.example"), right]), 403, "two hosts");
    assert_eq!(get("/api/campaign", &[own, right, ("Origin", "http://evil.example")]), 403);
    assert_eq!(get("/api/campaign", &[own, right, ("Origin", &format!("http://{host}"))]), 200);
    // a request with the token in its address must not change anything
    let body = json!({"name": "coriolis_yaw", "on": true}).to_string();
    let before = served.text();
    let by_address = served.request("POST", &format!("/api/effect?token={token}"), &[own], body.as_bytes());
    assert_eq!((by_address.status, served.text()), (403, before));
    assert_eq!(served.request("DELETE", "/api/campaign", &[own, right], b"").status, 405);
}

#[test]
fn the_page_is_whole_and_lets_nothing_else_in() {
    let served = Served::new("page", |_| {});
    let (_, token) = served.place();
    let page = served.get(&format!("/?token={token}"));
    assert_eq!(page.status, 200);
    let head = page.head.to_lowercase();
    for header in
        ["content-security-policy: default-src 'none'", "x-frame-options: deny", "no-store", "nosniff", "no-referrer"]
    {
        assert!(head.contains(header), "{header}: {head}");
    }
    assert!(!page.body.contains("src=\"http") && !page.body.contains("href=\"http") && !page.body.contains("@import"));
    assert!(!page.body.contains(&token), "the token is the address's alone");
    let again = served.get(&format!("/?token={token}"));
    assert_ne!(page.body, again.body, "each page has its own nonce");
}

#[test]
fn bad_requests_are_told_and_change_nothing() {
    let served = Served::new("bad", tank);
    let before = served.text();
    let post = |path: &str, body: &str| {
        let answer = served.post(path, body.as_bytes());
        assert!(answer.json()["message"].as_str().is_some_and(|m| !m.is_empty()), "{}", answer.body);
        answer.status
    };
    assert_eq!(post("/api/effect", "no json"), 400);
    assert_eq!(post("/api/effect", "{\"name\": 3}"), 400);
    assert_eq!(post("/api/effect", "{\"name\": \"inertia\", \"on\": true, \"more\": 1}"), 400);
    assert_eq!(post("/api/effect", "{\"name\": \"a b@c\", \"on\": true}"), 400);
    assert_eq!(post("/api/effect", "{\"name\": \"no_such_effect\", \"on\": true}"), 422);
    assert_eq!(post("/api/stretch", "{\"run\": 99, \"stretch\": {\"role\": \"train\"}}"), 404);
    assert_eq!(post("/api/stretch", "{\"run\": 0, \"stretch\": {\"role\": \"train\", \"from\": 9, \"to\": 2}}"), 400);
    assert_eq!(post("/api/stretch", "{\"run\": 0, \"stretch\": {\"role\": \"cook\"}}"), 400);
    assert_eq!(post("/api/undo", "{}"), 409);
    assert_eq!(post("/api/stop", "{\"name\": \"tea\"}"), 400);
    assert_eq!(post("/api/nothing", "{}"), 404);
    assert_eq!(post("/api/effect", &format!("{{\"name\": \"{}\"}}", "x".repeat(2 << 20))), 413);
    for name in ["../report.html", "/tmp/report.html", ".report.html", "run0.csv", "campaign.toml", ""] {
        assert_eq!(post("/api/report", &json!({"name": name}).to_string()), 400, "{name}");
    }
    for path in ["/api/columns?log=..%2F..%2Fetc%2Fpasswd", "/api/plot?log=%2Fetc%2Fpasswd", "/report"] {
        assert_eq!(served.get(path).status, 404, "{path}");
    }
    assert_eq!(served.get("/api/overlay?run=x").json()["figures"], json!([]));
    assert_eq!(served.get("/api/fit").json(), Value::Null);
    assert_eq!(served.text(), before);
    // a request that is not HTTP ends only its own connection
    let _ = served.send(b"\x00\xff\x13garbage\r\n\r\n");
    assert_eq!(served.get("/api/campaign").status, 200);
}

#[test]
fn an_effect_that_is_switched_on_is_in_the_file_and_in_the_fit() {
    let served = Served::new("effect", tank);
    let outline = served.done("/api/effect", &json!({"name": "coriolis_yaw", "on": true}));
    let text = served.text();
    for kept in ["# my own words", "# the tub", "'inertia',  # of course", "# quick", "# number 6"] {
        assert!(text.contains(kept), "{kept}: {text}");
    }
    assert!(text.contains("'quadratic_drag',\n  \"coriolis_yaw\",\n]"), "{text}");
    let places = |outline: &Value, id: &str| -> Vec<bool> {
        let families = outline["effects"].as_array().unwrap().iter();
        let mut all = families.flat_map(|family| family["effects"].as_array().unwrap());
        let found = all.find(|effect| effect["id"] == id).unwrap_or_else(|| panic!("{id} is listed"));
        found["places"].as_array().unwrap().iter().map(|place| place["on"] == true).collect()
    };
    assert_eq!(places(&outline, "coriolis_yaw"), [true]);
    assert_eq!(places(&outline, "linear_drag"), [true, true, true]);

    served.done("/api/fit", &json!({}));
    let progress = served.wait("fit");
    assert!(progress["refusal"].is_null(), "{progress}");
    let fit = served.get("/api/fit").json();
    assert_eq!((fit["first_look"].as_bool(), fit["estimator"].as_str()), (Some(false), Some("output_error")));
    let parameters = fit["parameters"].as_array().unwrap();
    assert!(parameters.iter().any(|p| p["effect"] == "quadratic_drag" && p["text"].as_str().unwrap().contains('±')));
    let run = fit["runs"].as_array().unwrap().iter().find(|r| r["role"] == "validate").unwrap();
    let overlay = served.get(&format!("/api/overlay?run={}", run["run"].as_str().unwrap())).json();
    let figures = overlay["figures"].as_array().unwrap();
    assert_eq!(figures.len(), 3);
    assert!(figures[0].as_str().unwrap().contains("<svg"));

    // one place of a plain id is removed, the others remain
    let outline = served.done("/api/effect", &json!({"name": "linear_drag@yaw", "on": false}));
    assert_eq!(places(&outline, "linear_drag"), [true, true, false]);
    assert!(
        served.text().contains("\"linear_drag@surge\"") && !served.text().contains("'linear_drag'"),
        "{}",
        served.text()
    );
    served.done("/api/undo", &json!({}));
    assert_eq!(served.text(), text);
    served.done("/api/effect", &json!({"name": "coriolis_yaw", "on": false}));
    assert!(!served.text().contains("coriolis_yaw") && served.text().contains("# of course"));
}

/// After a switch of an effect, a quick estimator gives the first fit and overlay.
/// `benches/first_look.rs` measures the time.
#[test]
fn fit_and_overlay_follow_a_switch_by_a_quick_estimator_first() {
    let options =
        BlindOptions { hidden: vec![Hidden::new("coriolis_yaw".to_string(), 1.0)], ..BlindOptions::default() };
    let served = Served::new("first", |folder| {
        write_blind(folder, &options).expect("the tank sails");
    });
    for switched in [true, false] {
        served.done("/api/effect", &json!({"name": "bias@yaw", "on": switched}));
        let looked = served.looked();
        assert_eq!((&looked["first_look"], &looked["estimator"]), (&json!(true), &json!("integral")), "{looked}");
        let names: Vec<&str> =
            looked["parameters"].as_array().unwrap().iter().filter_map(|p| p["effect"].as_str()).collect();
        assert_eq!(names.contains(&"bias"), switched, "{names:?}");
        let overlay = served.get("/api/overlay?run=run05.csv").json();
        assert_eq!(overlay["figures"].as_array().map(Vec::len), Some(3));
        served.done("/api/stop", &json!({"name": "fit"}));
    }
}

#[test]
fn stretches_are_runs_of_the_file() {
    let served = Served::new("stretches", tank);
    served.done("/api/stretch", &json!({"run": 0, "stretch": {"role": "train", "from": 1.5, "to": 20.0}}));
    let outline = served.done("/api/stretch/add", &json!({"run": 0, "stretch": {"role": "validate", "from": 20.0}}));
    let log = &outline["logs"][0];
    assert_eq!(log["stretches"].as_array().unwrap().len(), 2);
    assert_eq!((&log["stretches"][1]["role"], &log["stretches"][1]["from"]), (&json!("validate"), &json!(20.0)));
    assert_eq!(log["stretches"][1]["name"], "run0.csv #2");
    let text = served.text();
    assert!(text.contains("from = 1.5\nto = 20.0\n") && text.matches("# number 0").count() == 2, "{text}");
    let plot = served.get("/api/plot?log=run0.csv&channel=r&below=-").json();
    assert_eq!((&plot["channel"], &plot["roles"]), (&json!("r"), &json!(["train", "validate"])));
    assert!(plot["figure"].as_str().unwrap().contains("data-span=\"1\""));
    served.done("/api/stretch/remove", &json!({"run": 1}));
    assert_eq!(served.get("/api/campaign").json()["logs"][0]["stretches"].as_array().unwrap().len(), 1);
    // the last run cannot be removed, as a campaign needs one
    for _ in 0..3 {
        served.done("/api/stretch/remove", &json!({"run": 0}));
    }
    assert_eq!(served.post("/api/stretch/remove", b"{\"run\": 0}").status, 422);
}

#[test]
fn columns_are_mapped_and_their_lights_follow() {
    let log =
        |k: i32| format!("{},{},{}\n", 0.1 * f64::from(k), (0.2 * f64::from(k)).sin(), (0.15 * f64::from(k)).cos());
    let rows: String = (0..400).map(log).collect();
    let served = Served::new("columns", |folder| {
        fs::write(folder.join("a.csv"), format!("t,fast,tau_u\n{rows}")).unwrap();
        fs::write(folder.join("b.csv"), format!("t,u,tau_u\n{rows}")).unwrap();
        let text = "# mine\nformat = 1\n[vehicle]\nname = 'x'\n[model]\ndofs = ['surge']\neffects = ['inertia', 'linear_drag']\n[[run]]\nfile = 'a.csv' # first\n[[run]]\nfile = 'b.csv'\n";
        fs::write(folder.join("campaign.toml"), text).unwrap();
    });
    let columns = || served.get("/api/columns?log=a.csv").json();
    let before = columns();
    assert_eq!((&before["verdict"], &before["files"][0]["columns"][1]["channel"]), (&json!("red"), &json!("fast")));
    assert!(!before["findings"].as_array().unwrap().is_empty(), "that u is absent is told: {before}");
    served.done(
        "/api/columns",
        &json!({"log": "a.csv", "header": "fast", "channel": "u", "unit": "cm/s", "flipped": true}),
    );
    // the other log has no such column, so the entry is written for this log only
    let text = served.text();
    assert!(text.contains("[run.log.columns]") && text.contains("# first") && text.contains("# mine"), "{text}");
    let after = columns();
    let column = &after["files"][0]["columns"][1];
    assert_ne!(after["verdict"], "red", "{after}");
    assert_eq!((&column["channel"], &column["unit"], &column["sign"]), (&json!("u"), &json!("cm/s"), &json!(-1)));
    served.done("/api/columns", &json!({"log": "a.csv", "header": "fast", "channel": ""}));
    assert_eq!(columns()["files"][0]["columns"][1]["channel"], "fast");
}

#[test]
fn logs_that_are_dropped_become_a_campaign_and_are_never_written_over() {
    let made = blind(&BlindOptions { duration: 20.0, ..BlindOptions::default() }).expect("the tank sails");
    let served = Served::new("drop", |_| {});
    let outline = served.get("/api/campaign").json();
    assert_eq!((&outline["exists"], &outline["logs"]), (&json!(false), &json!([])));
    let mut csv = Vec::new();
    log::write_to(&made.runs[0], &mut csv).unwrap();
    for name in ["first.csv", "second.csv"] {
        assert_eq!(served.post(&format!("/api/log?name={name}"), &csv).json()["was_there"], false);
    }
    assert_eq!(served.post("/api/log?name=first.csv", &csv).json()["was_there"], true);
    assert_eq!(served.post("/api/log?name=first.csv", b"t,u\n0,1\n").status, 409);
    for name in ["..%2Fout.csv", "%2Ftmp%2Fout.csv", "campaign.toml", ".profile", "a%00b.csv"] {
        assert_eq!(served.post(&format!("/api/log?name={name}"), &csv).status, 400, "{name}");
    }
    assert_eq!(fs::read(served.folder.join("first.csv")).unwrap(), csv);
    let outline = served.done("/api/runs", &json!({"files": ["first.csv"], "name": "tub", "mass": 100.0}));
    assert_eq!((&outline["vehicle"], &outline["mass"]), (&json!("tub"), &json!(100.0)));
    assert!(served.text().contains("# guessed:") || served.text().contains("hydrosysid"));
    // adds to the existing campaign
    let outline = served.done("/api/runs", &json!({"files": ["second.csv"]}));
    assert_eq!(outline["logs"].as_array().unwrap().len(), 2);
    assert_eq!(served.post("/api/runs", b"{\"files\": [\"second.csv\"]}").status, 409);
    assert_eq!(served.post("/api/runs", b"{\"files\": [\"absent.csv\"]}").status, 404);
    assert_eq!(served.post("/api/runs", b"{\"files\": [\"..\"]}").status, 400);
    // a log that cannot be read leaves no file behind
    served.post("/api/log?name=photo.csv", b"\x89PNG\x00\x01");
    assert_eq!(served.post("/api/runs", b"{\"files\": [\"photo.csv\"]}").status, 422);
    assert!(!served.folder.join("photo.csv").exists());
    let check = served.get("/api/check").json();
    assert_eq!(check["logs"].as_array().unwrap().len(), 2);
}

#[test]
fn discovery_has_progress_an_end_on_demand_a_name_to_adopt_and_a_report() {
    let served = Served::new("discovery", |folder| sail(folder, 2.0));
    served.done("/api/discovery", &json!({}));
    let progress = served.get("/api/progress").json()["discovery"].clone();
    assert_eq!(progress["running"], true);
    served.done("/api/stop", &json!({"name": "discovery"}));
    assert_eq!(served.wait("discovery")["has_result"], false);
    served.done("/api/discovery", &json!({}));
    let progress = served.wait("discovery");
    assert!(progress["refusal"].is_null(), "{progress}");
    let found = served.get("/api/discovery").json();
    assert_eq!((&found["verdict"], &found["adopt"]), (&json!("explained"), &json!(["bias@surge"])), "{found}");
    assert!(found["figure"].as_str().unwrap().contains("<svg"));
    served.done("/api/adopt", &json!({"name": "bias@surge"}));
    assert!(served.text().contains("\"quadratic_drag\", \"bias@surge\"] # so far"), "{}", served.text());
    served.done("/api/report", &json!({"name": "report.html"}));
    assert!(served.wait("report")["refusal"].is_null());
    let page = fs::read_to_string(served.folder.join("report.html")).unwrap();
    assert!(page.starts_with("<!doctype html>") && page.contains(": identification"));
    assert_eq!(served.post("/api/report", b"{\"name\": \"report.html\"}").status, 409);
    assert_eq!(served.get("/report").status, 200);
}

#[test]
fn an_edit_elsewhere_shows_and_a_broken_file_is_told_and_left() {
    let served = Served::new("elsewhere", tank);
    let stamp = served.get("/api/progress").json()["stamp"].clone();
    let text = served.text().replace("'tank'", "'barge'");
    fs::write(served.folder.join("campaign.toml"), &text).unwrap();
    assert_ne!(served.get("/api/progress").json()["stamp"], stamp);
    assert_eq!(served.get("/api/campaign").json()["vehicle"], "barge");
    // a change that was meant for the earlier state of the campaign is refused
    let (host, token) = served.place();
    let stamp = stamp.as_str().unwrap();
    let headers = [("Host", host.as_str()), ("X-Hydrosysid-Token", &token), ("X-Hydrosysid-Stamp", stamp)];
    let late = served.request("POST", "/api/stretch/remove", &headers, b"{\"run\": 0}");
    assert_eq!((late.status, served.text()), (409, text));
    fs::write(served.folder.join("campaign.toml"), "format = 1\n[model\n").unwrap();
    let outline = served.get("/api/campaign");
    assert_eq!(outline.status, 200);
    assert!(outline.json()["problem"]["message"].as_str().unwrap().contains("campaign.toml:2"), "{}", outline.body);
    assert_eq!(served.post("/api/effect", b"{\"name\": \"bias@yaw\", \"on\": true}").status, 422);
    assert_eq!(served.text(), "format = 1\n[model\n");
}

#[test]
fn where_there_is_no_folder_nothing_is_served() {
    let missing = std::env::temp_dir().join("hydrosysid-view-nowhere/at/all");
    let options = ViewOptions { campaign: missing, ..ViewOptions::default() };
    assert!(matches!(View::open(&options), Err(ViewError::NoFolder(_))));
    let typo = ViewOptions { campaign: std::env::temp_dir().join("hydrosysid-view-typo"), ..ViewOptions::default() };
    assert!(matches!(View::open(&typo), Err(ViewError::NoFolder(_))));
}
