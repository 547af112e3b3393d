//! The command line of Umwelt: see [`umwelt_client::cli`].

fn main() -> std::process::ExitCode {
    umwelt_client::cli::main()
}
