//! What a write costs: pages of the disk, and time of those who drive robots.

use super::*;

/// Guards against: robots that drive wear out the card that keeps what they learn. A page holds what one robot learned;
/// nothing more may be written for it, to the log or beside it.
#[test]
fn keeping_what_a_robot_learned_costs_about_a_page() {
    const ROBOTS: u64 = 20;
    const ROUNDS: u64 = 20;
    let directory = tempdir().unwrap();
    let store = open(&directory);
    let names: Vec<_> = (0..ROBOTS).map(|number| format!("robot-{number}")).collect();
    store.commit(names.iter().map(|name| robot(name, 1)).collect()).unwrap();
    let round = |deliveries| {
        let saved = saved(&record(1), deliveries);
        let change = |name: &String| {
            Change::PutPosterior(
                id(name),
                Box::new(Posterior { revision: 1, saved: saved.clone() }),
            )
        };
        store.commit(names.iter().map(change).collect()).unwrap();
    };
    round(1);
    store.settle().unwrap();
    let log = || fs::metadata(directory.path().join(format!("{DATA_FILE}-wal"))).unwrap().len();
    let mut written = 0;
    for number in 0..ROUNDS {
        let before = log();
        round(2 + number);
        written += log().checked_sub(before).expect("the log is not brought in meanwhile");
    }
    let per_save = written / (ROUNDS * ROBOTS);
    assert!(per_save < 4500, "{per_save} bytes");
    let connection = open::read_only(&file(&directory)).unwrap();
    let temp = connection.pragma_query_value(None, "temp_store", |row| row.get::<_, i64>(0));
    assert_eq!(temp, Ok(2), "what SQLite notes down meanwhile is in memory");
}

/// Guards against: steps wait for a core while something is written.
#[cfg(target_os = "linux")]
#[test]
fn the_thread_that_writes_steps_back() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    store.probe().unwrap();
    // proc_pid_stat(5): the name in parentheses, niceness in field 19.
    let niceness = |stat: String| {
        let (name, fields) = stat.split_once('(')?.1.rsplit_once(')')?;
        let niceness = fields.split_whitespace().nth(16)?.parse::<i32>().ok()?;
        (name == "store").then_some(niceness)
    };
    let tasks = fs::read_dir("/proc/self/task").unwrap().filter_map(Result::ok);
    let stats = tasks.filter_map(|task| fs::read_to_string(task.path().join("stat")).ok());
    let found: Vec<_> = stats.filter_map(niceness).collect();
    // Or lower, where the whole process was told to step back.
    assert!(found.iter().any(|niceness| *niceness >= 9), "{found:?}");
}
