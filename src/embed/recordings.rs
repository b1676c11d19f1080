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
    to: To,
    progress: Arc<Mutex<Progress>>,
}

enum To {
    Desk(Sender<Piece>),
    /// Nothing is recorded; what pieces hold is let go of as if it had been, on this context.
    Nobody(Context),
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
    let progress = Arc::new(Mutex::new(Progress { done: 0.0, step: "waiting", ready: false, recorded: false }));
    let desk = Desk { pieces, running: Vec::new(), progress: progress.clone() };
    (Recordings { to: To::Desk(to_desk), progress }, desk)
}

impl Recordings {
    /// One end without the other, for a measuring context.
    pub fn to_nobody(context: &Context) -> Self {
        let progress = Arc::new(Mutex::new(Progress { done: 0.0, step: "measuring", ready: false, recorded: false }));
        Recordings { to: To::Nobody(context.clone()), progress }
    }

    /// Whether nothing is recorded, and so nothing can be read back.
    pub fn is_to_nobody(&self) -> bool {
        matches!(self.to, To::Nobody(_))
    }

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
        let given_up = || Error::Device("the preparation was given up".to_owned());
        match &self.to {
            To::Desk(pieces) => {
                let (done, answer) = channel();
                pieces.send(Piece { record, runs, done }).map_err(|_| given_up())?;
                answer.recv().map_err(|_| given_up())?
            }
            To::Nobody(context) => {
                drop(record);
                let frame = context.frame();
                context.advance(frame + 1, frame);
                Ok(())
            }
        }
    }

    /// Tells how far it is: `done` of 1.
    pub fn progress(&self, step: &'static str, done: f32) {
        let mut progress = crate::gpu::lock(&self.progress);
        progress.step = step;
        progress.done = progress.done.max(done.min(1.0));
    }
}

impl Desk {
    /// Records the next piece, if there is one, and tells whether there was.
    pub fn step(&mut self, context: &Context, recorder: &mut Recorder<'_>) -> bool {
        self.release(context);
        let Ok(piece) = self.pieces.try_recv() else { return false };
        match (piece.record)(recorder) {
            Ok(()) if piece.runs => self.running.push((context.frame(), piece.done)),
            // A thread that is gone does not wait for an answer.
            result => drop(piece.done.send(result)),
        }
        true
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
