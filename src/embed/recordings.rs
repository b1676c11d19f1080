//! How a thread that prepares gets its work onto the GPU: it hands over pieces, and the host's thread records them.
//!
//! The thread's code so reads like that of a program with a runner of its own, though nothing but the host submits.

use super::Progress;
use crate::gpu::{Context, Recorder};
use crate::{Error, Result};
use std::sync::mpsc::{channel, Receiver, Sender};
use std::sync::{Arc, Mutex};

type Record = Box<dyn FnOnce(&mut Recorder<'_>) -> Result<()> + Send>;

/// Something to be recorded.
struct Piece {
    record: Record,
    /// Whether it counts as done when the GPU has run it, not as soon as it is recorded.
    runs: bool,
    done: Sender<Result<()>>,
}

/// The preparing thread's end.
pub(super) struct Recordings {
    pieces: Sender<Piece>,
    progress: Arc<Mutex<Progress>>,
}

/// The host's end.
pub(super) struct Desk {
    pieces: Receiver<Piece>,
    /// What the GPU has yet to run, with the frame that it was recorded in.
    running: Vec<(u64, Sender<Result<()>>)>,
    progress: Arc<Mutex<Progress>>,
}

/// Both ends.
pub(super) fn recordings() -> (Recordings, Desk) {
    let (to_desk, pieces) = channel();
    let progress = Arc::new(Mutex::new(Progress { done: 0.0, step: "waiting", ready: false }));
    let desk = Desk { pieces, running: Vec::new(), progress: progress.clone() };
    (Recordings { pieces: to_desk, progress }, desk)
}

impl Recordings {
    /// Has something recorded, and returns when it is.
    ///
    /// # Errors
    /// Those of `record`, and [`Error::Device`] when the host has given the preparation up.
    pub fn record(&self, record: impl FnOnce(&mut Recorder<'_>) -> Result<()> + Send + 'static) -> Result<()> {
        self.hand_over(Box::new(record), false)
    }

    /// Has something recorded, and returns when the GPU has run it.
    ///
    /// # Errors
    /// As [`Recordings::record`].
    pub fn run(&self, record: impl FnOnce(&mut Recorder<'_>) -> Result<()> + Send + 'static) -> Result<()> {
        self.hand_over(Box::new(record), true)
    }

    fn hand_over(&self, record: Record, runs: bool) -> Result<()> {
        let given_up = |_| Error::Device("the preparation was given up".to_owned());
        let (done, answer) = channel();
        self.pieces.send(Piece { record, runs, done }).map_err(|_| given_up(std::sync::mpsc::RecvError))?;
        answer.recv().map_err(given_up)?
    }

    /// Tells how far it is: `done` of 1.
    pub fn progress(&self, step: &'static str, done: f32) {
        let mut progress = crate::gpu::lock(&self.progress);
        progress.step = step;
        progress.done = progress.done.max(done.min(1.0));
    }
}

impl Desk {
    /// Records the next piece, if there is one.
    pub fn step(&mut self, context: &Context, recorder: &mut Recorder<'_>) {
        self.release(context);
        let Ok(piece) = self.pieces.try_recv() else { return };
        match (piece.record)(recorder) {
            Ok(()) if piece.runs => self.running.push((context.frame(), piece.done)),
            // A thread that is gone does not wait for an answer.
            result => drop(piece.done.send(result)),
        }
    }

    /// Tells the thread what the GPU has run.
    fn release(&mut self, context: &Context) {
        let safe = context.safe_frame();
        self.running.retain(|(frame, done)| {
            let over = *frame <= safe;
            if over {
                drop(done.send(Ok(())));
            }
            !over
        });
    }

    pub fn progress(&self) -> Progress {
        *crate::gpu::lock(&self.progress)
    }
}
