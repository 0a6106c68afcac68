//! The `hydrosysid` command: reads arguments, calls the library, prints.

fn main() -> std::process::ExitCode {
    hydrosysid::cli::run()
}
