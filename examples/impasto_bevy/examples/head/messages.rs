//! What Vulkan's validation layer says: wgpu writes it to the log.

use bevy::app::App;
use bevy::log::BoxedLayer;
use bevy::log::tracing::field::{Field, Visit};
use bevy::log::tracing::{Event, Level, Subscriber};
use bevy::log::tracing_subscriber::Layer;
use bevy::log::tracing_subscriber::layer::Context;
use std::fmt::Debug;
use std::sync::{Mutex, PoisonError};

/// What of the log must be let through.
pub const FILTER: &str = "wgpu=warn,naga=warn";

static MESSAGES: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// For the log's plugin.
pub fn layer(_: &mut App) -> Option<BoxedLayer> {
    Some(Box::new(Listener))
}

/// What has come so far: all warnings and errors of wgpu's, which has a warning for a missing layer, too.
pub fn taken() -> Vec<String> {
    std::mem::take(&mut MESSAGES.lock().unwrap_or_else(PoisonError::into_inner))
}

struct Listener;

impl<S: Subscriber> Layer<S> for Listener {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        if *event.metadata().level() > Level::WARN {
            return;
        }
        let mut record = Record::default();
        event.record(&mut record);
        if record.target.starts_with("wgpu") {
            MESSAGES.lock().unwrap_or_else(PoisonError::into_inner).push(record.message);
        }
    }
}

/// A record of the `log` crate, as it is wrapped.
#[derive(Default)]
struct Record {
    target: String,
    message: String,
}

impl Visit for Record {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        match field.name() {
            "message" => self.message = format!("{value:?}"),
            "log.target" => self.target = format!("{value:?}").trim_matches('"').to_owned(),
            _ => {}
        }
    }
}
