//! The built programs as processes that never outlive their test.

use crate::wait;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Time for a program to say or to do something that it does at once: an age for it, and no harm on a busy machine.
pub const SOON: Duration = Duration::from_secs(10);

/// The program `name` as it was built from the sources of now.
///
/// # Panics
/// Where the programs do not build.
pub fn program(name: &str) -> PathBuf {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(build).join(name)
}

/// Builds all programs where this test was built, and in the same profile; returns their directory.
///
/// `cargo test` of this package alone does not build them: a stale one would be tested, or none found. The whole
/// workspace with one test target selects the very features of `cargo test --workspace`, so nothing is built twice.
fn build() -> PathBuf {
    let test = std::env::current_exe().expect("a test is a program");
    // <target>/<profile>/deps/<test>
    let directory = test.ancestors().nth(2).expect("tests are built below the target directory");
    let target = directory.parent().expect("the profile is below the target directory");
    let profile = match directory.file_name().and_then(|name| name.to_str()) {
        Some("debug") | None => "dev",
        Some(name) => name,
    };
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args(["build", "--quiet", "--offline", "--workspace", "--bins", "--test", "imports"])
        .args(["--profile", profile, "--target-dir"])
        .arg(target)
        .arg("--manifest-path")
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("../Cargo.toml"))
        .status()
        .expect("cargo runs");
    assert!(status.success(), "the programs do not build");
    directory.to_path_buf()
}

/// What a process can be told from outside.
#[derive(Clone, Copy, Debug)]
pub enum Signal {
    /// End in order.
    Terminate,
    /// Stand still until [`Signal::Continue`]; it cannot be refused.
    Stop,
    /// Go on.
    Continue,
}

/// A running program. It is killed where the test ends first; if the test fails, what it logged is shown.
#[derive(Debug)]
pub struct Process {
    name: String,
    child: Child,
    input: Option<ChildStdin>,
    output: Arc<Lines>,
    log: Arc<Lines>,
}

impl Process {
    /// Starts the program `name` with `arguments` and nothing on its standard input.
    ///
    /// # Panics
    /// Where it cannot be started.
    pub fn start(name: &str, arguments: &[&str]) -> Self {
        Self::spawn(name, arguments, Stdio::null())
    }

    /// The same with a standard input to write to.
    ///
    /// # Panics
    /// Where it cannot be started.
    pub fn start_with_input(name: &str, arguments: &[&str]) -> Self {
        Self::spawn(name, arguments, Stdio::piped())
    }

    /// The same with each line of its standard output given to `hear` as it comes, and kept nowhere.
    ///
    /// # Panics
    /// Where it cannot be started.
    pub fn start_heard(
        name: &str,
        arguments: &[&str],
        hear: impl FnMut(String) + Send + 'static,
    ) -> Self {
        let command = Command::new(program(name));
        Self::run(command, name, arguments, Stdio::piped(), |output| Lines::hear(output, hear))
    }

    /// Starts the program `name` so that a write beyond a limit of file sizes fails, as on a full disk: the signal that
    /// would end it is ignored. std has no safe call for that, so a shell does it and becomes the program.
    ///
    /// # Panics
    /// Where it cannot be started.
    pub fn start_limited(name: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new("sh");
        command.args(["-c", "trap '' XFSZ; exec \"$0\" \"$@\""]).arg(program(name));
        Self::run(command, name, arguments, Stdio::null(), Lines::follow)
    }

    fn spawn(name: &str, arguments: &[&str], input: Stdio) -> Self {
        Self::run(Command::new(program(name)), name, arguments, input, Lines::follow)
    }

    fn run(
        mut command: Command,
        name: &str,
        arguments: &[&str],
        input: Stdio,
        output: impl FnOnce(ChildStdout) -> Arc<Lines>,
    ) -> Self {
        command.args(arguments).stdin(input).stdout(Stdio::piped()).stderr(Stdio::piped());
        // Settings of whoever runs the tests are not theirs.
        for (variable, _) in std::env::vars_os() {
            if variable.to_str().is_some_and(|variable| variable.starts_with("UMWELT_")) {
                command.env_remove(variable);
            }
        }
        let mut child = command.spawn().unwrap_or_else(|error| panic!("{name}: {error}"));
        Self {
            name: format!("{name} {}", arguments.join(" ")),
            input: child.stdin.take(),
            output: output(child.stdout.take().expect("it is piped")),
            log: Lines::follow(child.stderr.take().expect("it is piped")),
            child,
        }
    }

    /// Line `index` of its standard output, as soon as it is there; none where the output ends before.
    ///
    /// # Panics
    /// Where it takes longer than [`SOON`].
    pub fn line(&self, index: usize) -> Option<String> {
        self.output.line(index, SOON).unwrap_or_else(|| panic!("{} says nothing", self.name))
    }

    /// All lines of its standard output so far.
    pub fn lines(&self) -> Vec<String> {
        self.output.all()
    }

    /// What it has logged so far.
    pub fn log(&self) -> String {
        self.log.all().join("\n")
    }

    /// Writes one line to its standard input; false where it does not read any more.
    ///
    /// # Panics
    /// Where the input is closed or was never open.
    pub fn write_line(&mut self, line: &str) -> bool {
        let input = self.input.as_mut().expect("started with an input");
        writeln!(input, "{line}").and_then(|()| input.flush()).is_ok()
    }

    /// Its standard input, for someone else to write to; none where it was started without or it was taken already.
    pub fn take_input(&mut self) -> Option<ChildStdin> {
        self.input.take()
    }

    /// Its number in the system.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Closes its standard input.
    pub fn close_input(&mut self) {
        self.input = None;
    }

    /// Sends a signal. std has no safe call for it, so the system's program does it.
    ///
    /// # Panics
    /// Where there is no such process any more.
    pub fn signal(&self, signal: Signal) {
        let name = match signal {
            Signal::Terminate => "-TERM",
            Signal::Stop => "-STOP",
            Signal::Continue => "-CONT",
        };
        let status = Command::new("kill").args([name, &self.child.id().to_string()]).status();
        assert!(status.expect("kill runs").success(), "{} has ended", self.name);
    }

    /// Kills it: SIGKILL, at once and without its help. It is gone on return.
    ///
    /// # Panics
    /// Where it had ended by itself, or the system does not know it.
    pub fn kill(&mut self) {
        assert_eq!(self.ended(), None, "{} has ended by itself: {}", self.name, self.log());
        self.child.kill().expect("it is our child");
        self.child.wait().expect("it is our child");
    }

    /// Its exit status, where it has ended.
    ///
    /// # Panics
    /// Where the system does not know it.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        self.child.try_wait().expect("it is our child")
    }

    /// Waits for its end, and until all that it said is here.
    ///
    /// # Panics
    /// Where it does not end `within` the time.
    pub async fn end(&mut self, within: Duration) -> ExitStatus {
        let what = format!("the end of {}", self.name);
        wait::until(&what, within, async || {
            let status = self.ended()?;
            (self.output.is_over() && self.log.is_over()).then_some(status)
        })
        .await
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            eprintln!("--- {}\n{}\n---", self.name, self.log());
        }
    }
}

/// The lines of a stream, read on a thread of their own so that the writer never waits.
#[derive(Debug, Default)]
struct Lines {
    read: Mutex<Heard>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Heard {
    lines: Vec<String>,
    is_over: bool,
}

impl Lines {
    fn follow(stream: impl Read + Send + 'static) -> Arc<Self> {
        let lines = Arc::new(Self::default());
        let kept = Arc::clone(&lines);
        Self::read_each(&lines, stream, move |line| {
            kept.read().lines.push(line);
            kept.changed.notify_all();
        });
        lines
    }

    /// Keeps none of them.
    fn hear(
        stream: impl Read + Send + 'static,
        each: impl FnMut(String) + Send + 'static,
    ) -> Arc<Self> {
        let lines = Arc::new(Self::default());
        Self::read_each(&lines, stream, each);
        lines
    }

    fn read_each(
        lines: &Arc<Self>,
        stream: impl Read + Send + 'static,
        mut each: impl FnMut(String) + Send + 'static,
    ) {
        let writer = Arc::clone(lines);
        std::thread::spawn(move || {
            for line in BufReader::new(stream).split(b'\n').map_while(Result::ok) {
                each(String::from_utf8_lossy(&line).into_owned());
            }
            writer.read().is_over = true;
            writer.changed.notify_all();
        });
    }

    /// Line `index`, `Some(None)` where the stream ends before it, none where it does not come `within` the time.
    fn line(&self, index: usize, within: Duration) -> Option<Option<String>> {
        let deadline = Instant::now() + within;
        let mut read = self.read();
        loop {
            if let Some(line) = read.lines.get(index) {
                return Some(Some(line.clone()));
            }
            if read.is_over {
                return Some(None);
            }
            let left = deadline.checked_duration_since(Instant::now())?;
            let waited = self.changed.wait_timeout(read, left);
            read = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn all(&self) -> Vec<String> {
        self.read().lines.clone()
    }

    fn is_over(&self) -> bool {
        self.read().is_over
    }

    fn read(&self) -> MutexGuard<'_, Heard> {
        // A line is pushed or not: what is behind a poisoned lock is whole.
        self.read.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
