//! A progress bar: on a terminal only, so that pipes and logs stay clean.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;

/// A bar that clears itself away.
pub struct Progress(ProgressBar);

impl Progress {
    /// A bar of `steps` steps on standard error; none at all unless that is a terminal, or if `quiet`.
    pub fn new(what: &'static str, steps: usize, quiet: bool) -> Self {
        Self::with_template(what, steps, quiet, "{msg} {wide_bar} {percent:>3}%  {elapsed} + {eta}")
    }

    /// A bar of `frames` frames, with how many there are in a second.
    pub fn frames(what: &'static str, frames: usize, quiet: bool) -> Self {
        Self::with_template(what, frames, quiet, "{msg} {wide_bar} {pos}/{len}  {per_sec}  {elapsed} + {eta}")
    }

    fn with_template(what: &'static str, steps: usize, quiet: bool, template: &str) -> Self {
        // The target for standard error hides itself where there is no terminal.
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(steps as u64), target);
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_message(what);
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        Progress(bar)
    }

    /// One step is done.
    pub fn step(&self) {
        self.0.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
