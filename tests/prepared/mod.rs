//! What the library prepares, stage by stage and technique by technique, each as small as it can be.
#![allow(dead_code)]

use crate::common::noise;
use crate::host::Host;
use impasto::gpu::{Context, Image, PassTimer, Recorder, Uploads};
use impasto::paint::{TextureDifference, Trajectory};
use impasto::scene::{Camera, GuidePass, Lights, Mesh, MeshOptions, Moment, MotionPass, Vec3};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{Quilt, QuiltStages, SampleTexels};
use impasto::synthesis::repair::RepairParams;
use impasto::technique::aligned::{AlignedFrame, AlignedTechnique, LevelParams, LevelSource, LevelVolume};
use impasto::technique::dependent::{Covered, DependentParams, DependentTechnique, View, ViewCoverage};
use impasto::technique::image::{ImageParams, ImageTechnique};
use impasto::technique::object::{ObjectParams, ObjectTechnique};
use impasto::technique::{Paint, ShadeRange, Show};
use impasto::Result;
use std::cell::OnceCell;

pub const SIZE: (u32, u32) = (40, 30);
const SAMPLE: (u32, u32) = (48, 32);
const QUILT: QuiltParams = QuiltParams { block_px: 16, overlap_px: 4, tolerance: 0.1, seed: 5, tileable: false };
const VIEWS_PX: u32 = 512;

type Record = Box<dyn FnMut(&mut Recorder<'_>) -> Result<()>>;

/// Something prepared: what records a picture, and the picture.
pub struct Prepared {
    pub picture: Option<Image>,
    record: Record,
}

impl Prepared {
    fn new(picture: &Image, record: impl FnMut(&mut Recorder<'_>) -> Result<()> + 'static) -> Self {
        Prepared { picture: Some(picture.clone()), record: Box::new(record) }
    }

    /// The picture's bytes, drawn in the host's command buffer. To be called once: what is synthesised before the first
    /// frame is recorded here too.
    pub fn draw(&mut self, context: &Context, host: &Host) -> Vec<u8> {
        host.run(|commands| (self.record)(&mut recorder(context, commands)).expect("a picture"));
        let Some(picture) = &self.picture else { return Vec::new() };
        let [width, height, _] = picture.size_px();
        host.read_image(picture.handle(), picture.layout(), (width, height))
    }
}

/// A recorder into a command buffer of the host's.
pub fn recorder(context: &Context, commands: ash::vk::CommandBuffer) -> Recorder<'_> {
    // SAFETY: the host's command buffers are begun, submitted in order and waited for.
    unsafe { Recorder::new(context, commands, None) }
}

/// A board whose normals are those of a ball, and its paint.
pub struct Scene {
    mesh: Mesh,
    moment: Moment,
    texture: TextureDifference,
    trajectory: Trajectory,
    /// Found when it is first needed.
    covered: OnceCell<Covered>,
}

pub type Prepare = fn(&Scene, &Context, &Host) -> Result<Prepared>;

impl Scene {
    pub fn new() -> Self {
        let text = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n\
                    vn -0.7 -0.7 0.5\nvn 0.7 -0.7 0.5\nvn 0.7 0.7 0.5\nvn -0.7 0.7 0.5\n\
                    f 1//1 2//2 3//3 4//4\n";
        let mesh = Mesh::parse(text.as_bytes(), "board.obj", &MeshOptions::default()).expect("a mesh").mesh;
        let camera = Camera::look_at(5.0 * Vec3::Z, Vec3::ZERO, None, 30.0).expect("a camera");
        let moment = Moment::at_rest(camera, Lights::default()).fit_depth(&mesh);
        let pixels = noise(SAMPLE.0, SAMPLE.1, 4);
        let pixels = pixels.iter().map(|p| [0, 1, 2].map(|k| f32::from(p[k]) / 255.0 - 0.5)).collect();
        let texture = TextureDifference::from_pixels(SAMPLE.0, SAMPLE.1, pixels).expect("a difference");
        let trajectory = Trajectory::from_colors(vec![[0.1, 0.2, 0.3], [0.9, 0.8, 0.6]]).expect("a trajectory");
        Scene { mesh, moment, texture, trajectory, covered: OnceCell::new() }
    }

    /// All that is prepared, by name.
    pub fn all() -> [(&'static str, Prepare); 9] {
        [
            ("timer", Self::timer),
            ("quilt", Self::quilt),
            ("guides", Self::guides),
            ("object", Self::object),
            ("image", Self::image),
            ("carried image", Self::carried),
            ("aligned", Self::aligned),
            ("views", Self::views),
            ("dependent", Self::dependent),
        ]
    }

    fn paints(&self) -> [Paint<'_>; 1] {
        [Paint { texture: &self.texture, trajectory: &self.trajectory }]
    }

    fn timer(&self, context: &Context, _: &Host) -> Result<Prepared> {
        let timer = PassTimer::new(context, 10)?;
        let record = move |_: &mut Recorder<'_>| timer.read().map(|_| ());
        Ok(Prepared { picture: None, record: Box::new(record) })
    }

    fn quilt(&self, context: &Context, host: &Host) -> Result<Prepared> {
        let mut uploads = Uploads::default();
        let stages = QuiltStages::new(context);
        let texels = SampleTexels::new(context, &mut uploads, &noise(SAMPLE.0, SAMPLE.1, 21), SAMPLE)?;
        let quilt = Quilt::new(context, &mut uploads, &stages, &texels, SIZE, &QUILT, None)?;
        upload(context, host, &mut uploads);
        Ok(Prepared::new(&quilt.canvas().clone(), move |recorder| {
            quilt.record(recorder, QUILT.seed, 0);
            Ok(())
        }))
    }

    fn guides(&self, context: &Context, host: &Host) -> Result<Prepared> {
        let mut uploads = Uploads::default();
        let guides = GuidePass::new(context, &mut uploads, &self.mesh, SIZE)?;
        let motion = MotionPass::new(context, &guides)?;
        upload(context, host, &mut uploads);
        let moment = self.moment.clone();
        Ok(Prepared::new(&guides.shade().clone(), move |recorder| {
            guides.record(recorder, &moment)?;
            motion.record(recorder, None, &moment)
        }))
    }

    fn object(&self, context: &Context, host: &Host) -> Result<Prepared> {
        let mut uploads = Uploads::default();
        let params = ObjectParams::default();
        let object = ObjectTechnique::new(context, &mut uploads, &self.mesh, SIZE, &self.paints(), &[0], &params)?;
        upload(context, host, &mut uploads);
        let moment = self.moment.clone();
        let frame = object.frame().clone();
        Ok(Prepared::new(&frame, move |r| object.record(r, &moment, ShadeRange::default(), Show::Painted)))
    }

    fn image(&self, context: &Context, host: &Host) -> Result<Prepared> {
        self.image_based(context, host, false)
    }

    fn carried(&self, context: &Context, host: &Host) -> Result<Prepared> {
        self.image_based(context, host, true)
    }

    fn image_based(&self, context: &Context, host: &Host, carried: bool) -> Result<Prepared> {
        let mut uploads = Uploads::default();
        let guides = GuidePass::new(context, &mut uploads, &self.mesh, SIZE)?;
        let stages = QuiltStages::new(context);
        let (paints, params) = (self.paints(), ImageParams { quilt: QUILT, ..ImageParams::default() });
        let mut image = ImageTechnique::new(context, &mut uploads, &stages, &guides, &paints, &[0], &params)?;
        if carried {
            let motion = MotionPass::new(context, &guides)?;
            let (motion, repair) = (motion.motion(), RepairParams::default());
            image.carry(context, &mut uploads, &guides, &paints, motion, &repair)?;
        }
        upload(context, host, &mut uploads);
        let moment = self.moment.clone();
        Ok(Prepared::new(&image.frame().clone(), move |recorder| {
            guides.record(recorder, &moment)?;
            image.record(recorder, QUILT.seed, 0);
            Ok(())
        }))
    }

    fn aligned(&self, context: &Context, _: &Host) -> Result<Prepared> {
        let mut uploads = Uploads::default();
        let guides = GuidePass::new(context, &mut uploads, &self.mesh, SIZE)?;
        let stages = QuiltStages::new(context);
        let params = LevelParams { levels: 2, size_px: 32, quilt: QUILT, ..LevelParams::default() };
        let sources = [LevelSource::Strip(&self.texture)];
        let levels = LevelVolume::new(context, &mut uploads, &stages, &sources, &params)?;
        let colors = [&self.trajectory];
        let mut aligned = AlignedTechnique::new(context, &mut uploads, &guides, levels, &colors, &[0])?;
        let moment = self.moment.clone();
        Ok(Prepared::new(&aligned.frame().clone(), move |recorder| {
            uploads.record(recorder);
            for part in aligned.levels().parts(u64::MAX) {
                aligned.levels().record_part(recorder, &part, 3);
            }
            aligned.levels_mut().finish();
            guides.record(recorder, &moment)?;
            aligned.record(recorder, &AlignedFrame::default(), &[])
        }))
    }

    fn covered(&self, context: &Context, host: &Host) -> Result<Covered> {
        let views = [View { yaw_deg: 0.0, pitch_deg: 0.0 }];
        let mut uploads = Uploads::default();
        let mut coverage = ViewCoverage::new(context, &mut uploads, &self.mesh, &views, VIEWS_PX)?;
        loop {
            host.run(|commands| {
                let mut recorder = recorder(context, commands);
                uploads.record(&mut recorder);
                coverage.record(&mut recorder).expect("cameras");
            });
            if !coverage.advance(context, &mut uploads)? {
                return Ok(coverage.finish());
            }
        }
    }

    fn views(&self, context: &Context, host: &Host) -> Result<Prepared> {
        self.covered(context, host)?;
        Ok(Prepared { picture: None, record: Box::new(|_| Ok(())) })
    }

    fn dependent(&self, context: &Context, host: &Host) -> Result<Prepared> {
        let covered = match self.covered.get() {
            Some(covered) => covered,
            None => {
                let covered = self.covered(context, host)?;
                self.covered.get_or_init(|| covered)
            }
        };
        let mut uploads = Uploads::default();
        let stages = QuiltStages::new(context);
        let params = DependentParams { quilt: QUILT, ..DependentParams::default() };
        let mut dependent = DependentTechnique::new(
            context,
            &mut uploads,
            &stages,
            &self.mesh,
            &self.moment.lights,
            covered,
            VIEWS_PX,
            SIZE,
            &self.paints(),
            &[0],
            &params,
        )?;
        let moment = self.moment.clone();
        Ok(Prepared::new(&dependent.frame().clone(), move |recorder| {
            uploads.record(recorder);
            for part in dependent.preparation_parts(u64::MAX) {
                dependent.record_preparation(recorder, &part, 3)?;
            }
            dependent.finish_preparation();
            dependent.record(recorder, &moment, Show::Painted)
        }))
    }
}

fn upload(context: &Context, host: &Host, uploads: &mut Uploads) {
    host.run(|commands| uploads.record(&mut recorder(context, commands)));
}
