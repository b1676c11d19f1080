//! What the GPU tests share: a validated context, test pictures, and the optional sample data.
#![allow(dead_code)]

use impasto::gpu::{Context, ContextOptions, LogCallback, Runner};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// A context with the validation layer on; any message fails the test when the guard goes.
pub struct Validated {
    pub context: Context,
    messages: Arc<Mutex<Vec<String>>>,
}

impl Validated {
    pub fn new() -> Self {
        Self::with(ContextOptions::default())
    }

    pub fn with(options: ContextOptions) -> Self {
        let messages = Arc::new(Mutex::new(Vec::new()));
        let sink = messages.clone();
        let log: LogCallback = Arc::new(move |_, message| sink.lock().expect("no panic here").push(message.to_owned()));
        let options = ContextOptions { validation: true, log: Some(log), ..options };
        let context = Context::new(&options).expect("a Vulkan device and the validation layer");
        Validated { context, messages }
    }

    pub fn runner(&self) -> Runner {
        Runner::new(&self.context).expect("a runner")
    }

    /// The messages so far; taking them means that they are expected.
    pub fn take_messages(&self) -> Vec<String> {
        std::mem::take(&mut self.messages.lock().expect("no panic here"))
    }
}

impl Drop for Validated {
    fn drop(&mut self) {
        if std::thread::panicking() {
            return;
        }
        let messages = self.take_messages();
        assert!(messages.is_empty(), "validation: {}", messages.join("\n"));
    }
}

/// The optional folder of sample models and paint.
pub fn data_dir() -> Option<PathBuf> {
    let dir = std::env::var_os("IMPASTO_DATA")
        .map(PathBuf::from)
        .unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data"));
    if dir.is_dir() {
        return Some(dir);
    }
    eprintln!("no sample data in {}: this part is left out", dir.display());
    None
}

/// A small generator of numbers for test pictures (xorshift32).
pub struct Numbers(pub u32);

impl Numbers {
    pub fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }
}

/// Noise on two scales, so that overlaps differ in how well they fit.
pub fn noise(width: u32, height: u32, seed: u32) -> Vec<[u8; 4]> {
    let mut numbers = Numbers(seed | 1);
    let coarse: Vec<[u32; 3]> =
        (0..(width / 8 + 1) * (height / 8 + 1)).map(|_| [0; 3].map(|_: u32| numbers.next() % 192)).collect();
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| {
            let c = coarse[((y / 8) * (width / 8 + 1) + x / 8) as usize];
            let fine = numbers.next();
            [0, 1, 2].map(|i| (c[i] + (fine >> (8 * i)) % 64) as u8)
        })
        .map(|[r, g, b]| [r, g, b, 255])
        .collect()
}

const CHILD: &str = "IMPASTO_TEST_CHILD";

/// True in a process that [`run_child`] started.
pub fn is_child() -> bool {
    std::env::var_os(CHILD).is_some()
}

/// Runs one test of this very file in a process of its own with these environment variables; what it printed.
pub fn run_child(test: &str, environment: &[(&str, &str)]) -> String {
    let program = std::env::current_exe().expect("this program");
    let output = std::process::Command::new(program)
        .args(["--exact", test, "--nocapture"])
        .env(CHILD, "1")
        .envs(environment.iter().copied())
        .output()
        .expect("a process");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{test} with {environment:?}: {text}");
    assert!(text.contains("1 passed"), "{test} is not a test: {text}");
    text
}
