//! `umwelt-server`: the controller server for two-wheel robots.

use std::process::ExitCode;

fn main() -> ExitCode {
    umwelt_server::program::main()
}
