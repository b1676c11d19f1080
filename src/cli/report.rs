//! Writing to the terminal without ever panicking, as `println!` does when nobody listens.

use super::failure::{Failure, Result};
use serde_json::{json, Value};
use std::io::{ErrorKind, Write};

/// Prints to standard output. That a reader has gone away is no failure.
pub fn print(text: &str) -> Result {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::new(format!("standard output: {error}"))),
        _ => Ok(()),
    }
}

/// Prints a warning.
pub fn warn_on_stderr(text: &str) {
    to_stderr(&format!("impasto: warning: {text}\n"));
}

/// Prints an error.
pub fn error_on_stderr(text: &str) {
    to_stderr(&format!("impasto: error: {text}\n"));
}

fn to_stderr(text: &str) {
    // There is nowhere left to report a failure to.
    let _ = std::io::stderr().write_all(text.as_bytes());
}

/// A number as it was written: 0.1, not the 0.10000000149 that a single-precision 0.1 is.
pub fn number(value: f32) -> Value {
    value.to_string().parse::<f64>().map_or(Value::Null, |value| json!(value))
}
