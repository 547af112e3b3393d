//! The data directory of the program: kept through its end, refused where it cannot be used, backed up while in use.

use crate::api::step;
use crate::process::{end, program, start};
use crate::sockets::request;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use tempfile::tempdir;
use umwelt_server::Store;
use umwelt_server::store::{DATA_FILE, SqliteStore};

fn serve(directory: &Path) -> Command {
    program(&["--listen", "127.0.0.1:0", "--data", directory.to_str().unwrap()])
}

/// The same call, killed where it does not end by itself.
fn limited(command: &Command) -> Command {
    let mut limited = Command::new("timeout");
    limited.arg("--signal=KILL").arg("20").arg(command.get_program()).args(command.get_args());
    for (name, _) in command.get_envs() {
        limited.env_remove(name);
    }
    limited
}

/// Runs a server that is to be refused; returns what it says.
fn refused(command: &mut Command) -> String {
    let Output { status, stdout, stderr } = limited(command).output().unwrap();
    let said = String::from_utf8_lossy(&stderr).into_owned();
    assert_eq!(status.code(), Some(1), "{said}");
    assert!(stdout.is_empty() && !said.contains("panicked"), "{said}");
    said
}

fn backup(directory: &Path, file: &Path) -> Command {
    program(&["backup", file.to_str().unwrap(), "--data", directory.to_str().unwrap()])
}

/// A data directory with one robot in it.
fn filled(directory: &Path) {
    let record = umwelt_server::store::Record {
        told: umwelt_server::store::Told::all(Default::default()),
        task: None,
        stopped: false,
        revision: 1,
    };
    let robot = umwelt_server::store::Change::PutRobot("r".parse().unwrap(), Box::new(record));
    SqliteStore::open(directory).unwrap().commit(vec![robot]).unwrap();
}

/// The same program without the rights of root, who may write everywhere.
fn as_nobody(command: Command) -> Command {
    let is_root = fs::metadata("/proc/self").is_ok_and(|process| {
        use std::os::unix::fs::MetadataExt;
        process.uid() == 0
    });
    if !is_root {
        return command;
    }
    let mut nobody = Command::new("setpriv");
    nobody.args(["--reuid=65534", "--regid=65534", "--clear-groups"]);
    nobody.arg(command.get_program()).args(command.get_args());
    nobody
}

fn set_mode(path: &Path, mode: u32) {
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
}

/// Guards against: the last seconds before an ordered end is lost, or the file needs its log beside it.
#[tokio::test]
async fn the_end_of_a_server_keeps_all_that_robots_learned() {
    let directory = tempdir().unwrap();
    let data = directory.path().join("made/by/the/server");
    let mut command = serve(&data);
    // No time for the task that keeps it now and then.
    command.args(["--drain-s", "0.001"]);
    let (child, address) = start(command);
    let put = request(address, "PUT", "/v1/robots/r", "{}").await;
    assert!(put.starts_with("HTTP/1.1 201"), "{put}");
    for sequence in 1..=20 {
        let mut body = step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0);
        body["deliveries"] = serde_json::json!([{"sequence": sequence - 1, "loop_delay_s": 0.2}]);
        let answer = request(address, "POST", "/v1/robots/r/step", &body.to_string()).await;
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    }
    let output = end(child, "-TERM");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let log = fs::metadata(data.join(format!("{DATA_FILE}-wal")));
    assert!(log.map_or(0, |log| log.len()) == 0, "all of it is in the file");
    let robots = SqliteStore::open(&data).unwrap().load().unwrap().robots;
    let saved = robots[0].saved.as_ref().unwrap();
    assert_eq!(saved.belief().link.estimate().samples, 20);

    let (child, address) = start(serve(&data));
    let robot = request(address, "GET", "/v1/robots/r", "").await;
    assert!(robot.starts_with("HTTP/1.1 200"), "{robot}");
    end(child, "-KILL");
}

#[tokio::test]
async fn a_second_server_on_the_same_data_is_refused_and_the_first_goes_on() {
    let directory = tempdir().unwrap();
    let (child, address) = start(serve(directory.path()));
    let said = refused(&mut serve(directory.path()));
    assert!(said.contains("in use by another umwelt-server"), "{said}");
    assert!(request(address, "PUT", "/v1/robots/r", "{}").await.starts_with("HTTP/1.1 201"));
    end(child, "-TERM");
}

/// Guards against: a disk that fails fills itself and others with the same line twice a second, or the server has to be
/// started anew.
#[tokio::test]
async fn a_store_that_fails_in_use_is_said_once_and_found_again() {
    let directory = tempdir().unwrap();
    let mut command = serve(directory.path());
    // No one reads the log meanwhile: every refused request in it would be too much for the pipe.
    command.args(["--log", "umwelt_server=info"]);
    let (child, address) = start(command);
    let (file, aside) = (directory.path().join(DATA_FILE), directory.path().join("aside"));
    let put = async || request(address, "PUT", "/v1/robots/r", "{}").await;
    assert!(put().await.starts_with("HTTP/1.1 201"));
    fs::rename(&file, &aside).unwrap();
    for _ in 0..5 {
        let refused = put().await;
        assert!(
            refused.starts_with("HTTP/1.1 503") && refused.contains("put it back"),
            "{refused}"
        );
        let ready = request(address, "GET", "/readyz", "").await;
        assert!(ready.starts_with("HTTP/1.1 503"), "{ready}");
    }
    fs::rename(&aside, &file).unwrap();
    while !request(address, "GET", "/readyz", "").await.starts_with("HTTP/1.1 200") {
        tokio::task::yield_now().await;
    }
    assert!(put().await.starts_with("HTTP/1.1 200"));
    let log = String::from_utf8(end(child, "-TERM").stderr).unwrap();
    assert_eq!(log.matches("cannot write to store").count(), 1, "{log}");
    assert_eq!(log.matches("store works again").count(), 1, "{log}");
}

#[test]
fn data_that_cannot_be_written_is_refused_with_a_remedy() {
    let directory = tempdir().unwrap();
    set_mode(directory.path(), 0o755);
    // Where no one can reach it, whatever the build directory's rights are.
    let copy = directory.path().join("umwelt-server");
    fs::copy(env!("CARGO_BIN_EXE_umwelt-server"), &copy).unwrap();
    let run = |data: &Path| {
        let mut command = Command::new(&copy);
        command.args(["--listen", "127.0.0.1:0", "--data", data.to_str().unwrap()]);
        refused(&mut as_nobody(command))
    };
    let forbidden = directory.path().join("forbidden");
    fs::create_dir(&forbidden).unwrap();
    set_mode(&forbidden, 0o555);
    for data in [&forbidden, &forbidden.join("below")] {
        let said = run(data);
        assert!(said.contains("cannot use the data directory"), "{said}");
        assert!(said.contains(data.to_str().unwrap()) && said.contains("--data"), "{said}");
    }
    // The directory may be written, the file in it may not.
    let data = directory.path().join("data");
    filled(&data);
    set_mode(&data, 0o777);
    for entry in fs::read_dir(&data).unwrap() {
        set_mode(&entry.unwrap().path(), 0o666);
    }
    set_mode(&data.join(DATA_FILE), 0o444);
    let said = run(&data);
    assert!(said.contains(DATA_FILE) && said.contains("writable"), "{said}");
    set_mode(&forbidden, 0o755);
}

#[test]
fn damaged_data_is_refused_with_a_remedy() {
    let directory = tempdir().unwrap();
    filled(directory.path());
    let file = directory.path().join(DATA_FILE);
    fs::write(&file, vec![b'x'; 8192]).unwrap();
    let said = refused(&mut serve(directory.path()));
    assert!(said.contains("is damaged") && said.contains("backup"), "{said}");
    assert_eq!(fs::read(&file).unwrap(), vec![b'x'; 8192], "it is not touched");
}

#[tokio::test]
async fn a_backup_is_written_while_the_server_runs_and_opens_as_data() {
    let directory = tempdir().unwrap();
    let data = directory.path().join("data");
    let (child, address) = start(serve(&data));
    request(address, "PUT", "/v1/robots/r", "{}").await;
    let elsewhere = directory.path().join("elsewhere");
    fs::create_dir(&elsewhere).unwrap();
    let file = elsewhere.join(DATA_FILE);
    let output = backup(&data, &file).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains(file.to_str().unwrap()) && said.contains("1 robots"), "{said}");
    let again = refused(&mut backup(&data, &file));
    assert!(again.contains("exists already"), "{again}");
    assert!(request(address, "PUT", "/v1/robots/s", "{}").await.starts_with("HTTP/1.1 201"));
    end(child, "-TERM");

    let (child, address) = start(serve(&elsewhere));
    assert!(request(address, "GET", "/v1/robots/r", "").await.starts_with("HTTP/1.1 200"));
    assert!(request(address, "GET", "/v1/robots/s", "").await.starts_with("HTTP/1.1 404"));
    end(child, "-TERM");
    let nothing = refused(&mut backup(&directory.path().join("nowhere"), &file));
    assert!(nothing.contains("there is no data file"), "{nothing}");
}

/// Guards against: the disk is full, the server restarts, and no one can stop a robot that drives.
#[tokio::test]
async fn a_server_starts_on_a_full_disk_and_robots_can_be_stopped() {
    let directory = tempdir().unwrap();
    filled(directory.path());
    // No file may grow: for a program the same as a disk that is full, and no disk has to be.
    let mut full = Command::new("sh");
    full.args(["-c", "trap '' XFSZ; ulimit -S -f 0; exec \"$0\" \"$@\""]);
    full.arg(env!("CARGO_BIN_EXE_umwelt-server"));
    full.args(["--listen", "127.0.0.1:0", "--data", directory.path().to_str().unwrap()]);
    // No one reads the log meanwhile: every refused request in it would be too much for the pipe.
    full.args(["--log", "umwelt_server=info"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let (child, address) = start(full);
    let call = async |method: &str, path: &str| request(address, method, path, "{}").await;
    assert!(call("GET", "/healthz").await.starts_with("HTTP/1.1 200"));
    let ready = call("GET", "/readyz").await;
    assert!(ready.starts_with("HTTP/1.1 503") && ready.contains("free some space"), "{ready}");
    assert!(call("GET", "/v1/robots/r").await.contains("\"stopped\":false"));
    for (method, path) in [("PUT", "/v1/robots/s"), ("DELETE", "/v1/robots/r")] {
        let refused = call(method, path).await;
        assert!(refused.starts_with("HTTP/1.1 503"), "{method} {path}: {refused}");
        assert!(refused.contains("free some space"), "{refused}");
    }
    assert!(call("POST", "/v1/robots/r/stop").await.starts_with("HTTP/1.1 200"));
    assert!(call("GET", "/v1/robots/r").await.contains("\"stopped\":true"));
    assert!(call("POST", "/v1/robots/r/resume").await.starts_with("HTTP/1.1 503"));

    let pid = child.id().to_string();
    let room = Command::new("prlimit").args(["--pid", &pid, "--fsize=unlimited"]).status();
    assert!(room.unwrap().success());
    let ready = async {
        while !call("GET", "/readyz").await.starts_with("HTTP/1.1 200") {
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(Duration::from_secs(60), ready).await.expect("there is room again");
    assert!(call("PUT", "/v1/robots/s").await.starts_with("HTTP/1.1 201"));
    let log = String::from_utf8(end(child, "-TERM").stderr).unwrap();
    assert_eq!(log.matches("cannot write to store").count(), 1, "{log}");
    let robots = SqliteStore::open(directory.path()).unwrap().load().unwrap().robots;
    let kept: Vec<_> = robots.iter().map(|it| (it.id.as_str(), it.record.stopped)).collect();
    assert_eq!(kept, [("r", true), ("s", false)], "the stop too");
}

/// Guards against: one digit on the disk turns a waypoint of 0.25 m into one of 8.25 m, and a robot drives there.
#[tokio::test]
async fn one_digit_that_changes_on_the_disk_is_named_and_given_up_alone() {
    let directory = tempdir().unwrap();
    let (child, address) = start(serve(directory.path()));
    for robot in ["r", "s"] {
        let path = format!("/v1/robots/{robot}");
        assert!(request(address, "PUT", &path, "{}").await.starts_with("HTTP/1.1 201"));
    }
    let task = "{\"waypoints\": [{\"x_m\": 0.2517, \"y_m\": 0.0}]}";
    assert!(request(address, "PUT", "/v1/robots/r/task", task).await.starts_with("HTTP/1.1 201"));
    end(child, "-TERM");
    let file = directory.path().join(DATA_FILE);
    let mut bytes = fs::read(&file).unwrap();
    let places: Vec<_> =
        (0..bytes.len() - 6).filter(|at| &bytes[*at..*at + 6] == b"0.2517").collect();
    assert!(!places.is_empty());
    places.iter().for_each(|at| bytes[*at] = b'8');
    fs::write(&file, bytes).unwrap();
    let said = refused(&mut serve(directory.path()));
    assert!(said.contains("robots r (its checksum does not match"), "{said}");
    assert!(said.contains("backup") && said.contains("--remove-damaged"), "{said}");
    let data = directory.path().to_str().unwrap().to_owned();
    let check = |more: &[&str]| {
        let output = program(&[&["check", "--data", &data], more].concat()).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (code, said) = check(&[]);
    assert!(code == Some(1) && said.starts_with("robots r (its checksum"), "{said}");
    let (code, said) = check(&["--remove-damaged"]);
    assert!(code == Some(0) && said.contains("which are removed"), "{said}");
    assert_eq!(check(&[]).0, Some(0));
    let (child, address) = start(serve(directory.path()));
    assert!(request(address, "GET", "/v1/robots/r", "").await.starts_with("HTTP/1.1 404"));
    assert!(request(address, "GET", "/v1/robots/s", "").await.starts_with("HTTP/1.1 200"));
    end(child, "-KILL");
}
