//! Image-based frames that are synthesised anew, one after the other, with several in flight.

use super::rounds::Time;
use super::scenes::Model;
use crate::cli::failure::Result;
use crate::cli::quilting::SearchFlag;
use crate::cli::session::{Device, Session, PART_COMPARISONS};
use crate::cli::values::Size;
use impasto::gpu::{FrameLoop, Recorder, Uploads};
use impasto::scene::{GuidePass, Moment};
use impasto::technique::image::{ImageParams, ImagePart, ImageTechnique};
use std::time::Instant;

/// Guide, quilt and recombination, ready to be recorded.
pub struct Stream {
    guides: GuidePass,
    technique: ImageTechnique,
    /// What goes into each submission of a frame: as much as no watchdog minds.
    submissions: Vec<Vec<ImagePart>>,
    seed: u32,
}

impl Stream {
    /// Prepares it for a model and a size.
    pub fn new(
        session: &mut Session,
        device: &mut Device,
        model: &Model,
        size: Size,
        params: &ImageParams,
    ) -> Result<Self> {
        let mut uploads = Uploads::default();
        let guides = GuidePass::new(&device.context, &mut uploads, &model.mesh, size.pair())?;
        let stages = session.quilt_stages(device, SearchFlag::Auto)?;
        let (paints, objects) = (model.paints.all()?, &model.paints.of_object);
        let technique = ImageTechnique::new(&device.context, &mut uploads, &stages, &guides, &paints, objects, params)?;
        device.upload(&mut uploads)?;
        let submissions = in_submissions(technique.parts(PART_COMPARISONS));
        Ok(Stream { guides, technique, submissions, seed: params.quilt.seed })
    }

    /// The frames of some moments, so many in flight. Afterwards all are done; the time is that of the host, a frame's
    /// share of it.
    pub fn run(&self, device: &Device, moments: &[Moment], in_flight: u32) -> Result<Time> {
        let mut frames = FrameLoop::new(&device.context, in_flight as usize * self.submissions.len())?;
        let start = Instant::now();
        for (number, moment) in (0..).zip(moments) {
            for submission in 0..self.submissions.len() {
                frames.run(|recorder| self.record(recorder, submission, moment, number))?;
            }
        }
        frames.finish()?;
        let wall_ms = start.elapsed().as_secs_f64() * 1e3 / moments.len().max(1) as f64;
        Ok(Time { gpu_ms: 0.0, wall_ms })
    }

    fn record(
        &self,
        recorder: &mut Recorder<'_>,
        submission: usize,
        moment: &Moment,
        number: u32,
    ) -> impasto::Result<()> {
        if submission == 0 {
            self.guides.record(recorder, moment)?;
        }
        for part in &self.submissions[submission] {
            self.technique.record_part(recorder, part, self.seed, number);
        }
        Ok(())
    }

    /// The frame that was done last.
    pub fn read(&self, device: &mut Device) -> Result<Vec<u8>> {
        Ok(device.runner.read_image(self.technique.frame())?)
    }
}

/// What is first and last of a frame costs next to nothing, and goes with its neighbours.
fn in_submissions<T>(parts: Vec<T>) -> Vec<Vec<T>> {
    let count = parts.len().saturating_sub(2).max(1);
    let mut submissions: Vec<Vec<T>> = (0..count).map(|_| Vec::new()).collect();
    for (number, part) in parts.into_iter().enumerate() {
        submissions[number.saturating_sub(1).min(count - 1)].push(part);
    }
    submissions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_and_last_parts_go_with_their_neighbours() {
        assert_eq!(in_submissions(vec![0, 1, 2]), [[0, 1, 2]]);
        assert_eq!(in_submissions(vec![0, 1, 2, 3, 4]), [vec![0, 1], vec![2], vec![3, 4]]);
        assert_eq!(in_submissions(vec![0]), [[0]]);
    }
}
