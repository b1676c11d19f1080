//! Image-based frames one after the other: how each keeps to the one before it.

use super::failure::{Failure, Result};
use super::report::number;
use super::session::{Device, Session, PART_COMPARISONS};
use super::values::finite;
use clap::{Args, ValueEnum};
use impasto::gpu::{Context, Uploads};
use impasto::scene::{GuidePass, Moment, MotionPass};
use impasto::synthesis::quilt::{PreviousWeight, QuiltStages};
use impasto::synthesis::repair::RepairParams;
use impasto::technique::image::{ImageParams, ImageTechnique};
use impasto::technique::{Paint, Show};
use std::sync::Arc;

/// How image-based frames keep to the one before.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Coherence of image-based frames")]
pub struct CoherenceFlags {
    /// How a frame keeps to the one before it
    #[arg(long, value_enum, default_value_t = Coherence::Carry)]
    coherence: Coherence,
    #[command(flatten)]
    limits: CoherenceLimits,
    /// For match: new texture only for every N-th frame, blended in between, 1 to 1000
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 1,
          allow_negative_numbers = true)]
    blend_over: u32,
}

/// How closely they keep to it.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Coherence of image-based frames")]
pub struct CoherenceLimits {
    /// For carry: by what factor texture may be stretched or compressed before it is synthesised anew, 1.05 to 1.5
    #[arg(long, value_name = "FACTOR", value_parser = finite, default_value_t = RepairParams::default().stretch,
          allow_hyphen_values = true)]
    stretch: f32,
    /// For carry: by how many block sizes shade may lead texture out of its window before it is synthesised anew, 0 to
    /// 100
    #[arg(long, value_name = "BLOCKS", value_parser = finite, default_value_t = RepairParams::default().slack,
          allow_hyphen_values = true)]
    slack: f32,
    /// For carry: how much worse than the best position one may fit that is chosen for new texture, 0 to 10
    #[arg(long, value_name = "T", value_parser = finite, default_value_t = RepairParams::default().tolerance,
          allow_hyphen_values = true)]
    repair_tolerance: f32,
    /// For match: how much the last frame counts against the overlap, 0.25 to 3 in steps of 0.25
    #[arg(long, value_name = "WEIGHT", value_parser = finite, default_value_t = 1.0, allow_hyphen_values = true)]
    match_weight: f32,
}

/// [`Continuity`] as a flag.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
enum Coherence {
    /// Texture follows the surface, and is synthesised anew only where it no longer fits
    Carry,
    /// Blocks are chosen to match the last frame too (thesis chapter 6)
    Match,
    /// Not at all: every frame for itself
    Anew,
}

/// How image-based frames keep to the one before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Continuity {
    /// Every frame for itself.
    #[default]
    Anew,
    /// Blocks match the last frame, and every so many frames new texture is synthesised, blended in between.
    Match(PreviousWeight, u32),
    /// Texture follows the surface.
    Carry(RepairParams),
}

impl CoherenceFlags {
    /// What the flags ask for, for blocks of this size; adds them to the report.
    pub fn continuity(&self, block_px: u32, session: &mut Session) -> Result<Continuity> {
        session.parameter("coherence", format!("{:?}", self.coherence).to_lowercase());
        let continuity = match self.coherence {
            Coherence::Anew => Continuity::Anew,
            Coherence::Match => self.limits.matching(self.blend_over),
            Coherence::Carry => self.limits.carrying(),
        };
        if let Continuity::Match(_, over) = continuity {
            session.parameter("blend_over", over);
        }
        continuity.check(block_px, session)?;
        Ok(continuity)
    }
}

impl CoherenceLimits {
    /// Matching, with new texture every so many frames.
    pub fn matching(&self, blend_over: u32) -> Continuity {
        Continuity::Match(PreviousWeight(self.match_weight), blend_over)
    }

    /// Carrying.
    pub fn carrying(&self) -> Continuity {
        Continuity::Carry(RepairParams { stretch: self.stretch, tolerance: self.repair_tolerance, slack: self.slack })
    }
}

impl Continuity {
    /// Checks the limits for blocks of this size, and adds them to the report.
    pub fn check(&self, block_px: u32, session: &mut Session) -> Result {
        match self {
            Continuity::Anew => {}
            Continuity::Match(weight, _) => {
                session.parameter("match_weight", number(weight.0));
                weight.check(block_px)?;
            }
            Continuity::Carry(params) => {
                session.parameter("stretch", number(params.stretch));
                session.parameter("slack", number(params.slack));
                session.parameter("repair_tolerance", number(params.tolerance));
                params.check()?;
            }
        }
        Ok(())
    }
}

/// The technique with what leads from frame to frame.
pub struct ImageFrames {
    technique: ImageTechnique,
    seed: u32,
    continuity: Continuity,
    motion: Option<MotionPass>,
    /// The last frame, to move on from.
    last: Option<Moment>,
    /// How far a frame is from one texture to the next, where they are blended.
    blend: Option<f32>,
    /// The frames of the last two textures that were synthesised, where they are blended.
    keys: [u32; 2],
    drawn: bool,
}

/// A frame to go on to.
pub struct NextFrame<'a> {
    pub moment: &'a Moment,
    pub number: u32,
    /// Whether it has nothing to do with the one before.
    pub fresh: bool,
    /// Whether it is to be shown, or only to be gone on from.
    pub shown: bool,
    /// What a later frame shows; if that is beyond this sequence or a cut, the last frame before.
    pub ahead: &'a dyn Fn(u32) -> Result<Moment>,
}

impl<'a> NextFrame<'a> {
    /// A frame that stands for itself.
    pub fn alone(moment: &'a Moment, number: u32) -> Self {
        NextFrame {
            moment,
            number,
            fresh: true,
            shown: true,
            ahead: &|number| Err(Failure::new(format!("frame {number} is not known"))),
        }
    }
}

impl ImageFrames {
    /// Prepares the technique over `guides`. Object i is painted with `paints[paint_of_object[i]]`.
    pub fn new(
        context: &Context,
        uploads: &mut Uploads,
        stages: &Arc<QuiltStages>,
        guides: &GuidePass,
        (paints, paint_of_object): (&[Paint<'_>], &[u32]),
        params: &ImageParams,
        continuity: Continuity,
    ) -> Result<Self> {
        let previous = match continuity {
            Continuity::Match(weight, _) => Some(weight),
            Continuity::Anew | Continuity::Carry(_) => None,
        };
        let params = ImageParams { previous, ..*params };
        let mut technique = ImageTechnique::new(context, uploads, stages, guides, paints, paint_of_object, &params)?;
        let mut motion = None;
        if let Continuity::Carry(params) = &continuity {
            let pass = MotionPass::new(context, guides)?;
            technique.carry(context, uploads, guides, paints, pass.motion(), params)?;
            motion = Some(pass);
        }
        let seed = params.quilt.seed;
        let (last, blend, keys, drawn) = (None, None, [0; 2], false);
        Ok(ImageFrames { technique, seed, continuity, motion, last, blend, keys, drawn })
    }

    /// Whether a frame needs those before it.
    pub fn has_memory(&self) -> bool {
        self.continuity != Continuity::Anew
    }

    /// Goes on to a frame, guides included, with a progress bar of the `session` if one is given.
    pub fn advance(
        &mut self,
        session: Option<&Session>,
        device: &mut Device,
        guides: &GuidePass,
        next: &NextFrame<'_>,
    ) -> Result {
        if !next.shown && !self.has_memory() {
            return Ok(());
        }
        let fresh = next.fresh || self.last.is_none();
        self.drawn = false;
        match self.continuity {
            Continuity::Match(_, over) if over > 1 => self.advance_keys(session, device, guides, next, fresh, over)?,
            _ => {
                let last = self.last.take().filter(|_| !fresh);
                device.runner.run(|recorder| {
                    guides.record(recorder, next.moment)?;
                    if let Some(motion) = &self.motion {
                        motion.record(recorder, last.as_ref(), next.moment)?;
                    }
                    if fresh {
                        self.technique.forget(recorder);
                    } else if self.motion.is_some() {
                        self.technique.record_next(recorder, self.seed, next.number);
                    }
                    Ok(())
                })?;
                if fresh || self.motion.is_none() {
                    self.synthesise(session, device, next.number)?;
                }
                self.drawn = true;
            }
        }
        self.last = Some(next.moment.clone());
        Ok(())
    }

    /// Synthesises the textures that a frame lies between.
    fn advance_keys(
        &mut self,
        session: Option<&Session>,
        device: &mut Device,
        guides: &GuidePass,
        next: &NextFrame<'_>,
        fresh: bool,
        over: u32,
    ) -> Result {
        if fresh {
            device.runner.run(|recorder| {
                guides.record(recorder, next.moment)?;
                self.technique.forget(recorder);
                Ok(())
            })?;
            self.synthesise(session, device, next.number)?;
            self.keys = [next.number; 2];
        }
        while next.number >= self.keys[1] {
            let key = self.keys[1] + over;
            let moment = (next.ahead)(key)?;
            device.runner.run(|recorder| guides.record(recorder, &moment))?;
            self.synthesise(session, device, key)?;
            self.keys = [self.keys[1], key];
        }
        self.blend = Some((next.number - self.keys[0]) as f32 / over as f32);
        Ok(device.runner.run(|recorder| {
            guides.record(recorder, next.moment)?;
            self.technique.record_guide(recorder);
            Ok(())
        })?)
    }

    fn synthesise(&self, session: Option<&Session>, device: &mut Device, number: u32) -> Result {
        let parts = self.technique.parts(PART_COMPARISONS);
        let progress = session.map(|session| session.progress("painting", parts.len()));
        for part in parts {
            device.runner.run(|recorder| {
                self.technique.record_part(recorder, &part, self.seed, number);
                Ok(())
            })?;
            if let Some(progress) = &progress {
                progress.step();
            }
        }
        Ok(())
    }

    /// Draws the frame, unless that is done already.
    pub fn draw(&mut self, device: &mut Device, show: Show) -> Result {
        if self.drawn && show == Show::Painted {
            return Ok(());
        }
        self.drawn = show == Show::Painted;
        Ok(device.runner.run(|recorder| match self.blend {
            Some(blend) => self.technique.record_blend(recorder, blend, show),
            None => {
                self.technique.record_recombine(recorder, show);
                Ok(())
            }
        })?)
    }

    pub fn technique(&self) -> &ImageTechnique {
        &self.technique
    }
}
