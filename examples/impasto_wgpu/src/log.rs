//! Messages of wgpu and of the validation layer, which wgpu passes on through the crate `log`: printed, and counted.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

struct Counter;

static WARNINGS: AtomicUsize = AtomicUsize::new(0);
static QUIET: AtomicBool = AtomicBool::new(false);

impl log::Log for Counter {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() <= log::Level::Warn
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            WARNINGS.fetch_add(1, Ordering::Relaxed);
            if !QUIET.load(Ordering::Relaxed) {
                eprintln!("{} {}: {}", record.level(), record.target(), record.args());
            }
        }
    }

    fn flush(&self) {}
}

/// To be called before wgpu's instance is made: wgpu asks the layer only for what the log lets through.
pub fn install() {
    if log::set_logger(&Counter).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
}

/// How many warnings and errors there were since this was asked last.
pub fn take() -> usize {
    WARNINGS.swap(0, Ordering::Relaxed)
}

/// How many there are while `work` runs, which is expected to cause some: they are not printed.
pub fn provoked(work: impl FnOnce()) -> usize {
    QUIET.store(true, Ordering::Relaxed);
    let before = WARNINGS.load(Ordering::Relaxed);
    work();
    QUIET.store(false, Ordering::Relaxed);
    let caused = WARNINGS.load(Ordering::Relaxed) - before;
    WARNINGS.fetch_sub(caused, Ordering::Relaxed);
    caused
}
