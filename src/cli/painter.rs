//! Drives the techniques: guides, preparation with a progress bar, and the pictures of all stages.

use super::failure::Result;
use super::image_frames::{ImageFrames, NextFrame};
use super::paints::Paints;
use super::picture::from_texels;
use super::session::{Device, Session, PART_COMPARISONS};
use super::techniques::{Chosen, Technique};
use super::values::Size;
use image::{GrayAlphaImage, LumaA, Rgba, RgbaImage};
use impasto::gpu::{Image, Uploads};
use impasto::scene::{GuidePass, Mesh, Moment};
use impasto::synthesis::params::BlockRecord;
use impasto::technique::aligned::{screen_displacements, AlignedFrame, AlignedTechnique, LevelVolume};
use impasto::technique::dependent::{Carry, CoverageReport, DependentTechnique, ViewCoverage};
use impasto::technique::image::ImageParams;
use impasto::technique::object::ObjectTechnique;
use impasto::technique::{ShadeRange, Show};
use std::collections::HashSet;

/// What is painted, and what it is like at first.
pub struct Scene<'a> {
    pub mesh: &'a Mesh,
    pub moment: Moment,
    pub size: Size,
}

/// A scene, ready to be drawn frame by frame.
pub struct Painter<'a> {
    scene: &'a Scene<'a>,
    moment: Moment,
    guides: GuidePass,
    technique: Prepared,
    range: ShadeRange,
    /// Whether there is a frame to go on from.
    began: bool,
}

enum Prepared {
    Image(Box<ImageFrames>),
    Object(ObjectTechnique),
    /// The frame as it was asked for, and the offsets of the objects' textures.
    Aligned(AlignedTechnique, AlignedFrame, Vec<[f64; 2]>),
    /// With how the next picture's carrying is to be recorded, if that has not been done.
    Dependent(Box<DependentTechnique>, CoverageReport, Option<Carry>),
}

impl<'a> Painter<'a> {
    /// Prepares the technique up to the first frame's drawing. The scene's moment is the one that the range of shade is
    /// found for.
    pub fn new(
        session: &mut Session,
        device: &mut Device,
        scene: &'a Scene<'a>,
        paints: &Paints,
        chosen: &Chosen,
    ) -> Result<Self> {
        let context = device.context.clone();
        let size = scene.size.pair();
        let mut uploads = Uploads::default();
        let guides = GuidePass::new(&context, &mut uploads, scene.mesh, size)?;
        device.upload(&mut uploads)?;
        let range = if chosen.levels {
            device.runner.run(|recorder| guides.record(recorder, &scene.moment))?;
            let shade = floats(&device.runner.read_image(guides.shade())?);
            ShadeRange::of_guide(&shade, &words(&device.runner.read_image(guides.id())?))
        } else {
            ShadeRange::default()
        };
        let seed = chosen.quilt.seed;
        let technique = match &chosen.technique {
            Technique::Image(continuity) => {
                let params = ImageParams { quilt: chosen.quilt, k: chosen.k, range, previous: None };
                let all = paints.all()?;
                let stages = session.quilt_stages(device, chosen.search)?;
                let painted = (&all[..], &paints.of_object[..]);
                let frames = ImageFrames::new(&context, &mut uploads, &stages, &guides, painted, &params, *continuity)?;
                device.upload(&mut uploads)?;
                session.phase("prepare");
                Prepared::Image(Box::new(frames))
            }
            Technique::Object(params) => {
                let all = paints.all()?;
                let technique =
                    ObjectTechnique::new(&context, &mut uploads, scene.mesh, size, &all, &paints.of_object, params)?;
                device.upload(&mut uploads)?;
                session.phase("prepare");
                Prepared::Object(technique)
            }
            Technique::Aligned(params, frame) => {
                let stages = session.quilt_stages(device, chosen.search)?;
                let levels = LevelVolume::new(&context, &mut uploads, &stages, &paints.levels(), params)?;
                let trajectories = paints.trajectories();
                let mut technique =
                    AlignedTechnique::new(&context, &mut uploads, &guides, levels, &trajectories, &paints.of_object)?;
                device.upload(&mut uploads)?;
                session.phase("prepare");
                prepare_levels(session, device, technique.levels(), seed)?;
                technique.levels_mut().finish();
                let offsets = vec![frame.offset_px.map(f64::from); scene.mesh.objects().len()];
                Prepared::Aligned(technique, AlignedFrame { range, ..*frame }, offsets)
            }
            Technique::Dependent(views, view_px, params) => {
                let covered = ViewCoverage::run(&context, &mut device.runner, scene.mesh, views, *view_px)?;
                let stages = session.quilt_stages(device, chosen.search)?;
                let mut params = *params;
                params.range = range;
                let all = paints.all()?;
                let mut technique = DependentTechnique::new(
                    &context,
                    &mut uploads,
                    &stages,
                    scene.mesh,
                    &scene.moment.lights,
                    &covered,
                    *view_px,
                    size,
                    &all,
                    &paints.of_object,
                    &params,
                )?;
                device.upload(&mut uploads)?;
                session.phase("prepare");
                let parts = technique.preparation_parts(PART_COMPARISONS);
                let progress = session.progress("preparing views", parts.len());
                for part in parts {
                    device.runner.run(|recorder| technique.record_preparation(recorder, &part, seed))?;
                    progress.step();
                }
                technique.finish_preparation();
                Prepared::Dependent(Box::new(technique), covered.report, None)
            }
        };
        Ok(Painter { scene, moment: scene.moment.clone(), guides, technique, range, began: false })
    }

    /// Whether a frame depends on those before it, as far as it is not fresh.
    pub fn has_memory(&self) -> bool {
        match &self.technique {
            Prepared::Image(frames) => frames.has_memory(),
            Prepared::Object(_) => false,
            Prepared::Aligned(..) | Prepared::Dependent(..) => true,
        }
    }

    /// Goes on to a frame, with a progress bar of the `session` if one is given. The range of shade stays that of the
    /// first frame.
    pub fn advance(&mut self, session: Option<&Session>, device: &mut Device, next: &NextFrame<'_>) -> Result {
        let fresh = next.fresh || !self.began;
        match &mut self.technique {
            Prepared::Image(frames) => frames.advance(session, device, &self.guides, next)?,
            Prepared::Object(_) => {}
            Prepared::Aligned(_, frame, offsets) if fresh => offsets.fill(frame.offset_px.map(f64::from)),
            Prepared::Aligned(_, _, offsets) => {
                let moments = [&self.moment, next.moment];
                let ways = screen_displacements(self.scene.mesh, moments, self.scene.size.pair())?;
                for (offset, way) in offsets.iter_mut().zip(ways) {
                    *offset = [offset[0] - f64::from(way[0]), offset[1] - f64::from(way[1])];
                }
            }
            Prepared::Dependent(technique, _, pending) => {
                // A frame that is shown is carried with its drawing, unless nobody has drawn it.
                if let Some(carry) = pending.replace(if fresh { Carry::Cut } else { Carry::Next }) {
                    record_carry(device, technique, &self.moment, carry)?;
                }
                if let Some(carry) = pending.take_if(|_| !next.shown) {
                    record_carry(device, technique, next.moment, carry)?;
                }
            }
        }
        self.moment = next.moment.clone();
        self.began = true;
        Ok(())
    }

    fn draw_guides(&self, device: &mut Device) -> Result {
        Ok(device.runner.run(|recorder| self.guides.record(recorder, &self.moment))?)
    }

    /// The frame: painted, its colour alone, or its texture alone.
    pub fn frame(&mut self, device: &mut Device, show: Show) -> Result<RgbaImage> {
        self.draw(device, show)?;
        from_texels(device.runner.read_image(self.image())?, self.scene.size.pair())
    }

    /// Draws the frame and leaves it on the device, as [`Painter::image`]. With [`Painter::advance`] it is one
    /// submission, but for what is synthesised anew.
    pub fn draw(&mut self, device: &mut Device, show: Show) -> Result {
        let moment = &self.moment;
        match &mut self.technique {
            Prepared::Image(frames) => frames.draw(device, show)?,
            Prepared::Object(technique) => {
                device.runner.run(|recorder| technique.record(recorder, moment, self.range, show))?;
            }
            Prepared::Aligned(technique, frame, offsets) => {
                let frame = AlignedFrame { show, ..*frame };
                let guides = &self.guides;
                device.runner.run(|recorder| {
                    guides.record(recorder, moment)?;
                    technique.record(recorder, &frame, offsets)
                })?;
            }
            Prepared::Dependent(technique, _, pending) => {
                let carry = pending.take();
                device.runner.run(|recorder| {
                    if let Some(carry) = carry {
                        technique.record_carry(recorder, moment, carry);
                    }
                    technique.record_picture(recorder, moment, show)
                })?;
            }
        }
        Ok(())
    }

    /// The frame that was drawn last: R8G8B8A8_UNORM, straight alpha.
    pub fn image(&self) -> &Image {
        match &self.technique {
            Prepared::Image(frames) => frames.technique().frame(),
            Prepared::Object(technique) => technique.frame(),
            Prepared::Aligned(technique, ..) => technique.frame(),
            Prepared::Dependent(technique, ..) => technique.frame(),
        }
    }

    /// What the search for views came to, if there was one.
    pub fn coverage(&self) -> Option<&CoverageReport> {
        match &self.technique {
            Prepared::Dependent(_, report, _) => Some(report),
            _ => None,
        }
    }

    /// The shade in use at every pixel, 0 to 1; 0 in the background.
    pub fn shades(&self, device: &mut Device) -> Result<Vec<f32>> {
        Ok(match &self.technique {
            Prepared::Image(frames) => floats(&device.runner.read_image(frames.technique().shade())?),
            _ => {
                self.draw_guides(device)?;
                let shade = floats(&device.runner.read_image(self.guides.shade())?);
                shade.into_iter().map(|shade| self.range.spread(shade)).collect()
            }
        })
    }

    /// The shade in use, 0..1 as 0..255; the background is transparent.
    pub fn shade(&self, device: &mut Device) -> Result<GrayAlphaImage> {
        let shades = self.shades(device)?;
        let id = self.ids(device)?;
        let Size { width, height } = self.scene.size;
        let mut picture = GrayAlphaImage::new(width, height);
        for ((pixel, shade), id) in picture.pixels_mut().zip(shades).zip(id) {
            if id != 0 {
                *pixel = LumaA([(shade * 255.0 + 0.5).floor() as u8, 255]);
            }
        }
        Ok(picture)
    }

    /// The ID buffer with a colour for every object; the background is transparent.
    pub fn id(&self, device: &mut Device) -> Result<RgbaImage> {
        let colors = id_colors(self.scene.mesh.objects().len());
        let mut picture = RgbaImage::new(self.scene.size.width, self.scene.size.height);
        for (pixel, id) in picture.pixels_mut().zip(self.ids(device)?) {
            // 0 is the background.
            let color = (id as usize).checked_sub(1).and_then(|object| colors.get(object));
            if let Some([r, g, b]) = color {
                *pixel = Rgba([*r, *g, *b, 255]);
            }
        }
        Ok(picture)
    }

    /// What was chosen for the blocks of each paint; none but in image-based synthesis.
    pub fn blocks(&self, device: &mut Device) -> Result<Vec<Vec<BlockRecord>>> {
        let mut all = Vec::new();
        if let Prepared::Image(frames) = &self.technique {
            for quilt in frames.technique().quilts() {
                all.push(quilt.read_records(&mut device.runner)?);
            }
        }
        Ok(all)
    }

    fn ids(&self, device: &mut Device) -> Result<Vec<u32>> {
        self.draw_guides(device)?;
        Ok(words(&device.runner.read_image(self.guides.id())?))
    }
}

fn record_carry(device: &mut Device, technique: &DependentTechnique, moment: &Moment, carry: Carry) -> Result {
    Ok(device.runner.run(|recorder| {
        technique.record_carry(recorder, moment, carry);
        Ok(())
    })?)
}

/// Synthesises levels with a progress bar.
pub fn prepare_levels(session: &mut Session, device: &mut Device, levels: &LevelVolume, seed: u32) -> Result {
    let parts = levels.parts(PART_COMPARISONS);
    let progress = session.progress("preparing levels", parts.len());
    for part in parts {
        device.runner.run(|recorder| {
            levels.record_part(recorder, &part, seed);
            Ok(())
        })?;
        progress.step();
    }
    Ok(())
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// A colour for each object; an object's colour depends on its index alone, and no two are the same.
pub fn id_colors(count: usize) -> Vec<[u8; 3]> {
    let mut used = HashSet::new();
    (0..count)
        .map(|index| {
            // Steps of the golden ratio spread any number of hues; every few of them get another brightness.
            let hue = (0.58 + index as f64 * 0.618_033_988_749_895).fract();
            let value = [0.95, 0.7, 0.82][index / 8 % 3];
            let saturation = [0.65, 0.9, 0.4][index / 24 % 3];
            let mut color = hsv(hue, saturation, value);
            while !used.insert(color) {
                let [r, g, b] = color;
                color = u32::from_be_bytes([0, r, g, b]).wrapping_add(0x0001_0301).to_be_bytes()[1..]
                    .try_into()
                    .unwrap_or_default();
            }
            color
        })
        .collect()
}

fn hsv(hue: f64, saturation: f64, value: f64) -> [u8; 3] {
    // Distance of the hue from red, green and blue in sixths of the circle, after the usual piecewise linear form.
    [5.0, 3.0, 1.0].map(|n| {
        let k: f64 = (n + hue * 6.0) % 6.0;
        let low = k.min(4.0 - k).clamp(0.0, 1.0);
        ((value - value * saturation * low) * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_objects_differ_and_are_stable() {
        let many = id_colors(65_535);
        assert_eq!(many.iter().collect::<HashSet<_>>().len(), many.len());
        assert_eq!(id_colors(10), many[..10]);
        // The first ones can be told apart at a glance.
        for (i, a) in many[..8].iter().enumerate() {
            for b in &many[..i] {
                let apart: u32 = a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
                assert!(apart > 50, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn hues_are_in_order() {
        assert_eq!(hsv(0.0, 1.0, 1.0), [255, 0, 0]);
        assert_eq!(hsv(1.0 / 3.0, 1.0, 1.0), [0, 255, 0]);
        assert_eq!(hsv(2.0 / 3.0, 1.0, 1.0), [0, 0, 255]);
        assert_eq!(hsv(0.5, 0.0, 0.5), [128, 128, 128]);
    }
}
