#![forbid(unsafe_code)]
//! The command line; everything lives in the library.

fn main() -> std::process::ExitCode {
    asperity::cli::run()
}
