//! A folder with a strip and a model, and the program to run in it.

use image::{Rgb, RgbImage, RgbaImage};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// After this long a run counts as hung.
const PATIENCE: Duration = Duration::from_secs(300);

/// A folder of its own for every test.
pub struct Place {
    pub dir: TempDir,
    variables: Vec<(&'static str, &'static str)>,
}

/// What a run came to.
pub struct Ran {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Place {
    /// A folder with `strip.png` (96x40, dark blue to light yellow, with a texture), `other.png` and `scene.obj`: a
    /// pyramid `tent` on a rectangle `floor`.
    pub fn new() -> Self {
        let place = Place { dir: TempDir::new().expect("a temporary folder"), variables: Vec::new() };
        strip(96, 40, [20, 30, 80], [250, 240, 160]).save(place.path("strip.png")).expect("strip");
        strip(80, 48, [60, 0, 0], [255, 200, 190]).save(place.path("other.png")).expect("strip");
        let scene = "o tent\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1.6 0\nf 4 3 5\nf 3 2 5\nf 2 1 5\nf 1 4 5\n\
                     o floor\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 9 8 7 6\n";
        fs::write(place.path("scene.obj"), scene).expect("model");
        place
    }

    pub fn with_variable(mut self, name: &'static str, value: &'static str) -> Self {
        self.variables.push((name, value));
        self
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// Runs the program with these words, in the folder.
    pub fn run(&self, line: &str) -> Ran {
        self.run_words(&line.split_whitespace().collect::<Vec<_>>())
    }

    /// The same with a variable of the environment.
    pub fn run_with(&self, name: &str, value: &str, line: &str) -> Ran {
        let words: Vec<&str> = line.split_whitespace().collect();
        self.run_command(Command::new(env!("CARGO_BIN_EXE_impasto")).args(&words).env(name, value), &words)
    }

    pub fn run_words(&self, words: &[&str]) -> Ran {
        self.run_command(Command::new(env!("CARGO_BIN_EXE_impasto")).args(words), words)
    }

    /// As `run_words`, in an address space of 2 GiB: who asks for more is refused it, and fails.
    pub fn run_words_in_2_gib(&self, words: &[&str]) -> Ran {
        let limited = r#"ulimit -v 2097152 && exec "$0" "$@""#;
        self.run_command(Command::new("sh").args(["-c", limited, env!("CARGO_BIN_EXE_impasto")]).args(words), words)
    }

    /// Starts the program, and does not wait for it nor listen to it.
    pub fn start(&self, line: &str) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_impasto"));
        self.spawn(command.args(line.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::null()))
    }

    fn spawn(&self, command: &mut Command) -> Child {
        command
            .current_dir(self.dir.path())
            // Compiled pipelines are kept from run to run.
            .env("XDG_CACHE_HOME", Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli-cache"))
            .envs(self.variables.iter().copied())
            .stdin(Stdio::null())
            .spawn()
            .expect("the program starts")
    }

    fn run_command(&self, command: &mut Command, words: &[&str]) -> Ran {
        let logs = TempDir::new().expect("a temporary folder");
        let log = |name: &str| File::create(logs.path().join(name)).expect("a log file");
        let mut child = self.spawn(command.stdout(log("stdout")).stderr(log("stderr")));
        let started = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().expect("the program can be waited for") {
                break status;
            }
            if started.elapsed() > PATIENCE {
                child.kill().expect("the program can be stopped");
                panic!("{words:?} hangs");
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        let text = |name: &str| fs::read_to_string(logs.path().join(name)).expect("UTF-8");
        Ran { code: status.code(), stdout: text("stdout"), stderr: text("stderr") }
    }

    /// Runs, and expects success without a word on standard error.
    pub fn ok(&self, line: &str) -> String {
        let ran = self.run(line);
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{line}");
        ran.stdout
    }

    /// Runs with `--json`, and expects one document.
    pub fn json(&self, line: &str) -> Value {
        let stdout = self.ok(&format!("{line} --json"));
        serde_json::from_str(&stdout).unwrap_or_else(|error| panic!("{line}: {error}: {stdout}"))
    }

    /// Runs, and expects the exit status 1 or 2, a message that contains all of `parts`, and no change to any file.
    pub fn fails(&self, line: &str, code: i32, parts: &[&str]) {
        self.fails_words(&line.split_whitespace().collect::<Vec<_>>(), code, parts);
    }

    pub fn fails_words(&self, words: &[&str], code: i32, parts: &[&str]) {
        let before = self.files();
        let ran = self.run_words(words);
        let Ran { stdout, stderr, .. } = &ran;
        assert_eq!((ran.code, stdout.as_str()), (Some(code), ""), "{words:?}: {stderr}");
        let start = if code == 1 { "impasto: error: " } else { "error: " };
        let message = stderr.lines().filter(|line| line.starts_with(start)).count();
        assert_eq!(message, 1, "{words:?}: {stderr}");
        for part in parts {
            assert!(stderr.contains(part), "{words:?}: `{part}` is not in: {stderr}");
        }
        assert!(self.files() == before, "{words:?} changed files");
    }

    /// Every file and folder in the folder, with its content.
    pub fn files(&self) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        let mut found = BTreeMap::new();
        collect(self.dir.path(), &mut found);
        found
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).expect("UTF-8")
    }

    pub fn picture(&self, name: &str) -> RgbaImage {
        image::open(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}")).to_rgba8()
    }
}

fn collect(dir: &Path, found: &mut BTreeMap<PathBuf, Option<Vec<u8>>>) {
    for entry in fs::read_dir(dir).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(&path, found);
            found.insert(path, None);
        } else {
            let bytes = fs::read(&path).ok();
            found.insert(path, bytes);
        }
    }
}

/// A strip from one colour to another, with an uneven texture.
pub fn strip(width: u32, height: u32, dark: [u8; 3], light: [u8; 3]) -> RgbImage {
    let mut numbers = crate::common::Numbers(width * 31 + height);
    RgbImage::from_fn(width, height, |x, _| {
        let t = f64::from(x) / f64::from(width - 1);
        let noise = f64::from(numbers.next() % 25) - 12.0;
        Rgb([0, 1, 2].map(|i| {
            let value = f64::from(dark[i]) * (1.0 - t) + f64::from(light[i]) * t + noise;
            value.clamp(0.0, 255.0) as u8
        }))
    })
}
