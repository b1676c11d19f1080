//! The program `impasto`: the library's techniques as commands. All of it is in [`cli`].

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
