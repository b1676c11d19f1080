//! The C ABI from the side of C: programs that make a Vulkan device of their own and know of the library what
//! include/impasto.h says. They are compiled here, against a library that is built here.
#![cfg(target_os = "linux")]

mod expected;
#[path = "../../examples/make_header/header.rs"]
mod header;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-pedantic"];
/// Watches what C does with memory, and what of C's and of the library's is lost at the end.
const SANITIZED: [&str; 2] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Runs a program that must succeed; what it printed.
fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {}\n{text}", output.status);
    text
}

/// The folder that holds libimpasto.so, as an embedder builds it: of this package and no program's features.
fn library() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("a target folder");
        let arguments = ["rustc", "--lib", "--locked", "--offline", "--features", "capi", "--crate-type", "cdylib"];
        let mut cargo = Command::new(env!("CARGO"));
        run(cargo.args(arguments).arg("--target-dir").arg(target).current_dir(root()));
        target.join("debug")
    })
}

/// Compiles a C program of this folder, with these besides the common files.
fn compiled(name: &str, flags: &[&str]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let program = folder.path().join(name);
    let sources = [name, "host", "failing"].map(|name| root().join(format!("tests/capi/{name}.c")));
    let mut cc = Command::new("cc");
    cc.args(["-std=c99", "-O1", "-g"]).args(WARNINGS).args(flags).arg("-I").arg(root().join("include"));
    cc.args(sources).arg("-L").arg(library()).arg("-o").arg(&program);
    cc.args(["-limpasto", "-lvulkan", &format!("-Wl,-rpath,{}", library().display())]);
    run(&mut cc);
    (folder, program)
}

#[test]
fn the_header_is_what_the_library_says() {
    let made = header::header(root()).expect("a header");
    let there = std::fs::read_to_string(root().join("include/impasto.h")).expect("a header");
    assert!(made == there, "include/impasto.h is not what src/capi says; run `make header`");
}

#[test]
fn the_header_is_cpp_too() {
    let mut cpp = Command::new("c++");
    cpp.args(["-std=c++17", "-fsyntax-only", "-x", "c++"]).args(WARNINGS).arg("-Wno-pragma-once-outside-header");
    run(cpp.arg(root().join("include/impasto.h")));
}

/// Else a C program could not link, or would link to something that is not in the contract.
#[test]
fn the_library_has_the_headers_functions_and_no_others() {
    let listed = run(Command::new("nm").args(["-D", "--defined-only"]).arg(library().join("libimpasto.so")));
    let mut functions: Vec<_> = listed.lines().filter_map(|line| line.split_whitespace().nth(2)).collect();
    functions.sort_unstable();
    let text = std::fs::read_to_string(root().join("include/impasto.h")).expect("a header");
    let code = text.lines().filter(|line| !line.trim_start().starts_with(['*', '/']));
    let mut declared: Vec<_> = code
        .filter_map(|line| line.split_once('('))
        .filter_map(|(before, _)| before.rsplit([' ', '*']).next())
        .filter(|name| name.starts_with("impasto_"))
        .collect();
    declared.sort_unstable();
    assert!(declared.len() > 20, "{declared:?}");
    assert_eq!(functions, declared);
}

/// A program that was compiled with [`SANITIZED`], which must be done and not have lost anything.
fn run_sanitized(program: &Path, arguments: &[&Path]) {
    let told = suppressing("leaks.supp");
    let output = run(Command::new(program).args(arguments).env("LSAN_OPTIONS", format!("{told}:print_suppressions=0")));
    assert_eq!(output, "done\n");
}

fn suppressing(file: &str) -> String {
    format!("suppressions={}", root().join("tests/capi").join(file).display())
}

#[test]
fn c_paints_the_same_bytes_with_each_technique() {
    let (folder, program) = compiled("frames", &SANITIZED);
    let assets = root().join("assets");
    expected::write(&assets, folder.path());
    run_sanitized(&program, &[&assets, folder.path()]);
}

#[test]
fn what_c_does_wrong_is_told_and_harms_nothing() {
    let (_folder, program) = compiled("errors", &SANITIZED);
    run_sanitized(&program, &[Path::new("calls")]);
}

#[test]
fn calls_of_vulkan_that_fail_are_told_and_lose_nothing() {
    let (_folder, program) = compiled("errors", &SANITIZED);
    run_sanitized(&program, &[Path::new("failing")]);
}

/// It also watches what the library does with memory, which the sanitizers do not see. Without the validation layer,
/// which takes long there.
#[test]
fn valgrind_finds_nothing() {
    let (_folder, program) = compiled("errors", &[]);
    let mut valgrind = Command::new("valgrind");
    valgrind.args(["--quiet", "--error-exitcode=9", "--leak-check=full", "--errors-for-leak-kinds=definite"]);
    valgrind.args(["--show-leak-kinds=definite", &format!("--{}", suppressing("valgrind.supp"))]);
    assert_eq!(run(valgrind.arg(&program).args(["calls", "plain"])), "done\n");
}
