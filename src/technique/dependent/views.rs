//! Finding out on the device which view shows which faces: the pictures that [`Coverage`] looks at.

use super::coverage::{Coverage, Covered, View};
use super::faces::FacePass;
use crate::gpu::{Buffer, BufferKind, Context, Recorder, Runner, Uploads};
use crate::scene::{Lights, Mesh};
#[cfg(doc)]
use crate::Error;
use crate::Result;
use std::ops::Deref;

/// The search for the views that show all faces (thesis chapter 8), a round at a time. Borrows the mesh, or shares it.
///
/// ```text
/// new -> [ uploads, record -> the host submits and waits -> advance ] as long as advance says so -> finish
/// ```
pub struct ViewCoverage<M> {
    mesh: M,
    size_px: u32,
    coverage: Coverage,
    faces: Option<FacePass>,
    face_count: u32,
    pictures: Vec<Buffer>,
}

impl<M: Deref<Target = Mesh>> ViewCoverage<M> {
    /// Prepares the first round: all faces, seen from `views`, in pictures of `size_px` pixels a side.
    ///
    /// # Errors
    /// Those of [`Coverage::new`]; [`Error::Memory`] when the budget does not allow it.
    pub fn new(context: &Context, uploads: &mut Uploads, mesh: M, views: &[View], size_px: u32) -> Result<Self> {
        let coverage = Coverage::new(&mesh, views, size_px)?;
        let mut this = ViewCoverage { mesh, size_px, coverage, faces: None, face_count: 0, pictures: Vec::new() };
        this.prepare(context, uploads)?;
        Ok(this)
    }

    fn prepare(&mut self, context: &Context, uploads: &mut Uploads) -> Result<()> {
        self.faces = None;
        let Some(round) = self.coverage.round() else { return Ok(()) };
        self.face_count = round.faces.len() as u32;
        let faces = FacePass::new(context, uploads, &self.mesh, self.size_px, round.faces.iter().copied())?;
        while self.pictures.len() < round.cameras.len() {
            let bytes = u64::from(self.size_px) * u64::from(self.size_px) * 4;
            self.pictures.push(Buffer::new(context, "faces of a view", BufferKind::Readback, bytes)?);
        }
        self.faces = Some(faces);
        Ok(())
    }

    /// Records the round.
    ///
    /// # Errors
    /// None for cameras of [`Coverage`].
    pub fn record(&self, recorder: &mut Recorder<'_>) -> Result<()> {
        let (Some(faces), Some(round)) = (&self.faces, self.coverage.round()) else { return Ok(()) };
        for (camera, picture) in round.cameras.iter().zip(&self.pictures) {
            faces.record(recorder, camera, &Lights::default(), 0..self.face_count)?;
            recorder.download_image("view_faces", &faces.face, picture);
        }
        Ok(())
    }

    /// Takes in the pictures, when all that was recorded has run, and prepares the next round; false when there is
    /// none.
    ///
    /// # Errors
    /// [`Error::Memory`] when the budget does not allow it.
    pub fn advance(&mut self, context: &Context, uploads: &mut Uploads) -> Result<bool> {
        let Some(round) = self.coverage.round() else { return Ok(false) };
        let pictures = self.pictures.iter().take(round.cameras.len());
        let ids: Vec<Vec<u32>> = pictures.map(|picture| bytemuck::pod_collect_to_vec(picture.mapped())).collect();
        self.coverage.take(&ids)?;
        self.prepare(context, uploads)?;
        Ok(self.faces.is_some())
    }

    /// The slices and the faces' sets of them, once [`ViewCoverage::advance`] has said false.
    pub fn finish(self) -> Covered {
        self.coverage.finish()
    }

    /// What the search may come to, without making it: an upper estimate.
    pub(crate) fn suppose(self) -> Covered {
        self.coverage.suppose()
    }

    /// All rounds on a device of one's own.
    ///
    /// # Errors
    /// Those of the steps, and of [`Runner::run`].
    pub fn run(context: &Context, runner: &mut Runner, mesh: M, views: &[View], size_px: u32) -> Result<Covered> {
        let mut uploads = Uploads::default();
        let mut this = ViewCoverage::new(context, &mut uploads, mesh, views, size_px)?;
        loop {
            runner.run(|recorder| {
                uploads.record(recorder);
                this.record(recorder)
            })?;
            if !this.advance(context, &mut uploads)? {
                return Ok(this.finish());
            }
        }
    }
}
