//! What an effect prepares, technique by technique, on a thread of its own.

use super::recordings::Recordings;
use super::{EffectDesc, Method};
use crate::gpu::{Context, Image, Recorder, Uploads};
use crate::scene::{GuideImages, GuidePass, HostMotion, Lights, MotionPass};
use crate::synthesis::quilt::QuiltStages;
use crate::synthesis::repair::RepairParams;
use crate::technique::aligned::{AlignedFrame, AlignedTechnique, LevelParams, LevelSource, LevelVolume};
use crate::technique::dependent::{Covered, DependentParams, DependentTechnique, View, ViewCoverage};
use crate::technique::image::{ImageParams, ImageTechnique};
use crate::technique::object::ObjectTechnique;
use crate::technique::ShadeRange;
use crate::{Error, Result};
use std::sync::Arc;

/// A technique that is ready to draw.
pub(super) enum Prepared {
    Object(Box<ObjectTechnique>, ShadeRange),
    Image(Guides, Option<Motion>, Box<ImageTechnique>),
    /// With where the objects' textures lie, and whether they follow.
    Aligned(Guides, Box<AlignedTechnique>, AlignedFrame, Option<Vec<[f64; 2]>>),
    Dependent(Box<DependentTechnique>),
}

/// What is painted over.
pub(super) struct Guides {
    /// What draws them, if the host does not.
    pub pass: Option<GuidePass>,
    pub images: GuideImages,
}

/// What says where surfaces were.
pub(super) enum Motion {
    Own(MotionPass),
    Host(HostMotion),
}

impl Motion {
    pub fn image(&self) -> &Image {
        match self {
            Motion::Own(pass) => pass.motion(),
            Motion::Host(pass) => pass.motion(),
        }
    }
}

/// Prepares what `desc` describes.
pub(super) fn prepare(context: &Context, desc: &EffectDesc, recordings: &Recordings) -> Result<Prepared> {
    let this = Preparation { context, desc, recordings };
    recordings.progress("building", 0.0);
    let prepared = match &desc.method {
        Method::Object { params, range } => {
            let mut uploads = Uploads::default();
            let (paints, of_object) = (desc.paints(), &desc.paint_of_object);
            let technique =
                ObjectTechnique::new(context, &mut uploads, &desc.mesh, desc.size_px, &paints, of_object, params)?;
            this.upload(uploads)?;
            Prepared::Object(Box::new(technique), *range)
        }
        Method::Image { params, carry } => this.image(params, carry.as_ref())?,
        Method::Aligned { levels, frame, follow } => this.aligned(levels, frame, *follow)?,
        Method::Dependent { views, view_px, lights, params } => {
            let covered = this.coverage(views, *view_px)?;
            this.dependent(&covered, *view_px, lights, params)?
        }
    };
    recordings.progress("ready", 1.0);
    Ok(prepared)
}

struct Preparation<'a> {
    context: &'a Context,
    desc: &'a EffectDesc,
    recordings: &'a Recordings,
}

impl Preparation<'_> {
    fn upload(&self, mut uploads: Uploads) -> Result<()> {
        self.recordings.progress("uploading", 0.1);
        self.recordings.record(move |recorder| {
            uploads.record(recorder);
            Ok(())
        })
    }

    fn guides(&self, uploads: &mut Uploads) -> Result<Guides> {
        if let Some(images) = &self.desc.inputs.guides {
            return Ok(Guides { pass: None, images: images.clone() });
        }
        let pass = GuidePass::new(self.context, uploads, &self.desc.mesh, self.desc.size_px)?;
        Ok(Guides { images: (&pass).into(), pass: Some(pass) })
    }

    fn image(&self, params: &ImageParams, carry: Option<&RepairParams>) -> Result<Prepared> {
        let (context, mut uploads, paints) = (self.context, Uploads::default(), self.desc.paints());
        let stages = QuiltStages::new(context);
        let guides = self.guides(&mut uploads)?;
        let of_object = &self.desc.paint_of_object;
        let mut technique =
            ImageTechnique::new(context, &mut uploads, &stages, &guides.images, &paints, of_object, params)?;
        let motion = match (carry, &self.desc.inputs.vectors) {
            (None, _) => None,
            (Some(_), None) => Some(Motion::Own(MotionPass::new(context, &guides.images)?)),
            (Some(_), Some((vectors, params))) => {
                Some(Motion::Host(HostMotion::new(context, &guides.images, vectors, params)?))
            }
        };
        if let (Some(params), Some(motion)) = (carry, &motion) {
            technique.carry(context, &mut uploads, &guides.images, &paints, motion.image(), params)?;
        }
        self.upload(uploads)?;
        Ok(Prepared::Image(guides, motion, Box::new(technique)))
    }

    fn aligned(&self, levels: &LevelParams, frame: &AlignedFrame, follow: bool) -> Result<Prepared> {
        let (context, mut uploads, paints) = (self.context, Uploads::default(), self.desc.paints());
        let stages = QuiltStages::new(context);
        let guides = self.guides(&mut uploads)?;
        let sources: Vec<_> = paints.iter().map(|paint| LevelSource::Strip(paint.texture)).collect();
        let volume = LevelVolume::new(context, &mut uploads, &stages, &sources, levels)?;
        let trajectories: Vec<_> = paints.iter().map(|paint| paint.trajectory).collect();
        let of_object = &self.desc.paint_of_object;
        let technique = AlignedTechnique::new(context, &mut uploads, &guides.images, volume, &trajectories, of_object)?;
        self.upload(uploads)?;
        let seed = self.desc.seed;
        let parts = technique.levels().parts(self.desc.piece);
        let mut technique =
            self.in_parts("synthesising levels", technique, parts, move |technique, recorder, part| {
                technique.levels().record_part(recorder, part, seed);
                Ok(())
            })?;
        technique.levels_mut().finish();
        let offsets = follow.then(|| vec![frame.offset_px.map(f64::from); self.desc.mesh.objects().len()]);
        Ok(Prepared::Aligned(guides, Box::new(technique), *frame, offsets))
    }

    /// Which view shows which faces: a round at a time, each of which waits for the GPU.
    fn coverage(&self, views: &[View], view_px: u32) -> Result<Covered> {
        let mut uploads = Uploads::default();
        let mut coverage = ViewCoverage::new(self.context, &mut uploads, self.desc.mesh.clone(), views, view_px)?;
        if self.recordings.is_to_nobody() {
            return Ok(coverage.suppose());
        }
        loop {
            self.recordings.progress("looking for views", 0.05);
            let round = Arc::new(coverage);
            let recorded = round.clone();
            self.recordings.run(move |recorder| {
                uploads.record(recorder);
                recorded.record(recorder)
            })?;
            coverage = alone(round)?;
            uploads = Uploads::default();
            if !coverage.advance(self.context, &mut uploads)? {
                return Ok(coverage.finish());
            }
        }
    }

    fn dependent(
        &self,
        covered: &Covered,
        view_px: u32,
        lights: &Lights,
        params: &DependentParams,
    ) -> Result<Prepared> {
        let (context, mut uploads, paints) = (self.context, Uploads::default(), self.desc.paints());
        let stages = QuiltStages::new(context);
        let technique = DependentTechnique::new(
            context,
            &mut uploads,
            &stages,
            &self.desc.mesh,
            lights,
            covered,
            view_px,
            self.desc.size_px,
            &paints,
            &self.desc.paint_of_object,
            params,
        )?;
        self.upload(uploads)?;
        let seed = self.desc.seed;
        let parts = technique.preparation_parts(self.desc.piece);
        let mut technique =
            self.in_parts("synthesising views", technique, parts, move |technique, recorder, part| {
                technique.record_preparation(recorder, part, seed)
            })?;
        technique.finish_preparation();
        Ok(Prepared::Dependent(Box::new(technique)))
    }

    /// Has all parts of a technique's preparation recorded, one by one.
    fn in_parts<T: Send + Sync + 'static, P: Send + 'static>(
        &self,
        step: &'static str,
        technique: T,
        parts: Vec<P>,
        record: impl Fn(&T, &mut Recorder<'_>, &P) -> Result<()> + Copy + Send + 'static,
    ) -> Result<T> {
        let technique = Arc::new(technique);
        let count = parts.len() as f32;
        for (number, part) in parts.into_iter().enumerate() {
            self.recordings.progress(step, 0.15 + 0.85 * number as f32 / count);
            let technique = technique.clone();
            self.recordings.record(move |recorder| record(&technique, recorder, &part))?;
        }
        alone(technique)
    }
}

/// What the host's thread has let go of, having recorded it.
fn alone<T>(shared: Arc<T>) -> Result<T> {
    Arc::into_inner(shared).ok_or_else(|| Error::Device("a recording outlives itself".to_owned()))
}
