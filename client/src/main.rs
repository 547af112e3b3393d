//! The command line of Umwelt.

mod cli;
#[cfg(test)]
mod samples;
#[cfg(test)]
#[expect(dead_code, reason = "the tests of the library use the rest of it")]
mod test_server;

fn main() -> std::process::ExitCode {
    cli::main()
}
