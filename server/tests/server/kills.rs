//! A process that keeps things is killed again and again: everything it had acknowledged is there, and nothing half.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::tempdir;
use umwelt_api::prior::Source;
use umwelt_core::controller::Controller;
use umwelt_core::settings::{Prior, Settings};
use umwelt_server::Store;
use umwelt_server::store::{
    Change, Contents, JobId, Posterior, Record, SqliteStore, StoredJob, StoredKind, StoredPrior,
    Told,
};

/// Where the child is to keep things.
const DIRECTORY: &str = "UMWELT_TEST_KILLED_IN";

/// Threads that keep things at the same time, so that groups form.
const WRITERS: u64 = 4;

/// Kills of a process that has data from the lives before, and of one that makes a new file.
const KILLS: u32 = 24;
const KILLS_OF_NEW: u32 = 8;

const PARTS: u64 = 10;

/// One of each kind, and again.
fn job(writer: u64) -> JobId {
    let kind = StoredKind::ALL[(writer % 2) as usize];
    JobId { kind, number: writer / 2 + 1 }
}

fn robot(writer: u64) -> umwelt_api::RobotId {
    format!("robot-{writer}").parse().unwrap()
}

/// What `writer` keeps in its turn `turn`: in every table something that says so.
fn changes(writer: u64, turn: u64) -> Vec<Change> {
    let (settings, body) = (Settings::default(), turn.to_string());
    let record = Record { told: Told::all(settings), task: None, stopped: false, revision: turn };
    let saved = Controller::new(settings).saved();
    vec![
        Change::PutJob(StoredJob { id: job(writer), finished: false, body: body.clone() }),
        Change::PutPart { job: job(writer), index: (turn % PARTS) as usize, body: body.clone() },
        Change::PutCheckpoint { job: job(writer), body: body.repeat(2000) },
        Change::PutPrior(StoredPrior {
            name: format!("prior-{writer}"),
            prior: Prior::default(),
            note: Some(body),
            source: Source::Put,
        }),
        Change::PutRobot(robot(writer), Box::new(record)),
        Change::PutPosterior(robot(writer), Box::new(Posterior { revision: turn, saved })),
    ]
}

/// The last turn of `writer` that is there; fails where a part of it is missing or is of another turn.
fn turn(store: &SqliteStore, contents: &Contents, writer: u64) -> u64 {
    let id = job(writer);
    let Some(job) = contents.jobs.iter().find(|job| job.id == id) else {
        assert_eq!(store.checkpoint(id).unwrap(), None);
        assert!(contents.robots.iter().all(|kept| kept.id != robot(writer)));
        return 0;
    };
    let turn: u64 = job.body.parse().unwrap();
    let index = (turn % PARTS) as usize;
    let parts = store.parts(id, index, 1).unwrap();
    assert_eq!((parts[0].index, &parts[0].body), (index, &job.body));
    assert_eq!(store.checkpoint(id).unwrap(), Some(job.body.repeat(2000)));
    let name = format!("prior-{writer}");
    let prior = contents.priors.iter().find(|prior| prior.name == name).unwrap();
    assert_eq!(prior.note.as_ref(), Some(&job.body));
    let robot = contents.robots.iter().find(|kept| kept.id == robot(writer)).unwrap();
    assert_eq!(robot.record.revision, turn);
    assert!(robot.saved.is_some(), "what it learned is of the same turn");
    turn
}

/// The process that is killed: it writes, and says what was acknowledged.
fn write(directory: &Path) {
    let store = SqliteStore::open(directory).unwrap();
    let contents = store.load().unwrap();
    std::thread::scope(|scope| {
        for writer in 0..WRITERS {
            let (store, contents) = (&store, &contents);
            scope.spawn(move || {
                for turn in turn(store, contents, writer) + 1.. {
                    store.commit(changes(writer, turn)).unwrap();
                    // The parent may have gone.
                    if writeln!(std::io::stdout().lock(), "kept {writer} {turn}").is_err() {
                        return;
                    }
                    // One that fails at its end leaves nothing of its beginning.
                    let mut broken = changes(writer, u64::MAX);
                    broken.retain(|change| !matches!(change, Change::PutPosterior(..)));
                    store.commit(broken).unwrap_err();
                }
            });
        }
    });
}

/// The test that starts itself as the process to be killed, where [`DIRECTORY`] says so.
const WRITER: &str = "whatever_was_acknowledged_outlives_a_kill_and_nothing_is_half";

fn start(directory: &Path) -> (Child, BufReader<ChildStdout>) {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args([&format!("kills::{WRITER}"), "--exact", "--nocapture"])
        .env(DIRECTORY, directory)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let output = BufReader::new(child.stdout.take().unwrap());
    (child, output)
}

/// Writer and turn of an acknowledgement; none where the line is another one.
fn acknowledged(line: &str) -> Option<(usize, u64)> {
    let (writer, turn) = line.strip_suffix('\n')?.strip_prefix("kept ")?.split_once(' ')?;
    Some((writer.parse().ok()?, turn.parse().ok()?))
}

/// Starts a process on `directory`, kills it after `lines` acknowledgements and `after`, and looks at what is there:
/// no less than what `kept` and this one's acknowledgements say, and at most one turn more, which no one was told of.
fn kill(directory: &Path, lines: usize, after: Duration, kept: &mut [u64; WRITERS as usize]) {
    let (mut child, mut output) = start(directory);
    let mut line = String::new();
    let mut heard = 0;
    let mut hear = |line: &str| {
        if let Some((writer, turn)) = acknowledged(line) {
            assert_eq!(turn, kept[writer] + 1, "no turn is left out");
            kept[writer] = turn;
            heard += 1;
        }
        heard
    };
    while output.read_line(&mut line).unwrap() > 0 && hear(&line) < lines {
        line.clear();
    }
    let begun = Instant::now();
    while begun.elapsed() < after {
        std::hint::spin_loop();
    }
    child.kill().unwrap();
    child.wait().unwrap();
    // What it had still said before it died.
    line.clear();
    while output.read_line(&mut line).unwrap() > 0 {
        hear(&line);
        line.clear();
    }
    let store = SqliteStore::open(directory).unwrap();
    let contents = store.load().unwrap();
    for writer in 0..WRITERS {
        let (found, told) = (turn(&store, &contents, writer), kept[writer as usize]);
        assert!(found == told || found == told + 1, "{found} is there, {told} was acknowledged");
        kept[writer as usize] = found;
    }
}

#[test]
fn whatever_was_acknowledged_outlives_a_kill_and_nothing_is_half() {
    if let Some(directory) = std::env::var_os(DIRECTORY) {
        return write(Path::new(&directory));
    }
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let directory = tempdir().unwrap();
    let mut kept = [0; WRITERS as usize];
    for _ in 0..KILLS {
        let after = Duration::from_micros(rng.random_range(0..5000));
        kill(directory.path(), rng.random_range(1..60), after, &mut kept);
    }
    assert!(kept.iter().all(|turns| *turns > 2 * u64::from(KILLS)), "{kept:?}");
}

/// The first line comes before the file is made: these are killed while they make it.
#[test]
fn a_kill_while_the_file_is_made_leaves_one_that_opens() {
    let mut rng = Pcg64Mcg::seed_from_u64(4);
    for _ in 0..KILLS_OF_NEW {
        let directory = tempdir().unwrap();
        let after = Duration::from_micros(rng.random_range(0..30_000));
        kill(directory.path(), 0, after, &mut [0; WRITERS as usize]);
    }
}
