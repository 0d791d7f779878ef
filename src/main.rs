//! The command line.

fn main() -> std::process::ExitCode {
    motionmill::cli::main()
}
