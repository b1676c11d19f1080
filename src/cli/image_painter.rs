//! Drives the image-based technique: guides, synthesis in parts with a progress bar, and the pictures of all stages.

use super::failure::Result;
use super::paints::Paints;
use super::picture::from_texels;
use super::session::{Device, Session, PART_COMPARISONS};
use super::values::Size;
use image::{GrayAlphaImage, LumaA, Rgba, RgbaImage};
use impasto::gpu::Uploads;
use impasto::scene::{Camera, GuidePass, Lights, Mesh};
use impasto::synthesis::params::BlockRecord;
use impasto::synthesis::quilt::QuiltStages;
use impasto::technique::image::{ImageParams, ImageTechnique};
use impasto::technique::Show;
use std::collections::HashSet;

/// A scene, ready to be painted or painted already.
pub struct ImagePainter {
    guides: GuidePass,
    technique: ImageTechnique,
    objects: usize,
    size: Size,
    seed: u32,
}

impl ImagePainter {
    /// Draws the guides and prepares the synthesis.
    #[allow(clippy::too_many_arguments)] // the scene, the paints, the place
    pub fn new(
        device: &mut Device,
        mesh: &Mesh,
        camera: &Camera,
        lights: &Lights,
        paints: &Paints,
        params: &ImageParams,
        size: Size,
    ) -> Result<Self> {
        let context = &device.context;
        let mut uploads = Uploads::default();
        let stages = QuiltStages::new(context)?;
        let guides = GuidePass::new(context, &mut uploads, mesh, size.pair())?;
        let technique =
            ImageTechnique::new(context, &mut uploads, &stages, &guides, &paints.all(), &paints.of_object, params)?;
        device.upload(&mut uploads)?;
        device.runner.run(|recorder| guides.record(recorder, camera, lights))?;
        Ok(ImagePainter { guides, technique, objects: mesh.objects().len(), size, seed: params.quilt.seed })
    }

    /// Synthesises the texture and draws the frame.
    pub fn paint(&self, session: &Session, device: &mut Device) -> Result {
        let parts = self.technique.parts(PART_COMPARISONS);
        let progress = session.progress("painting", parts.len());
        for part in parts {
            device.runner.run(|recorder| {
                self.technique.record_part(recorder, &part, self.seed, 0);
                Ok(())
            })?;
            progress.step();
        }
        Ok(())
    }

    /// The frame: painted, its colour alone, or its texture alone.
    pub fn frame(&self, device: &mut Device, show: Show) -> Result<RgbaImage> {
        device.runner.run(|recorder| {
            self.technique.record_recombine(recorder, show);
            Ok(())
        })?;
        from_texels(device.runner.read_image(self.technique.frame())?, self.size.pair())
    }

    /// The shade in use, 0..1 as 0..255; the background is transparent.
    pub fn shade(&self, device: &mut Device) -> Result<GrayAlphaImage> {
        let shade = floats(&device.runner.read_image(self.technique.shade())?);
        let id = self.ids(device)?;
        let mut picture = GrayAlphaImage::new(self.size.width, self.size.height);
        for ((pixel, shade), id) in picture.pixels_mut().zip(shade).zip(id) {
            if id != 0 {
                *pixel = LumaA([(shade * 255.0 + 0.5).floor() as u8, 255]);
            }
        }
        Ok(picture)
    }

    /// The ID buffer with a colour for every object; the background is transparent.
    pub fn id(&self, device: &mut Device) -> Result<RgbaImage> {
        let colors = id_colors(self.objects);
        let mut picture = RgbaImage::new(self.size.width, self.size.height);
        for (pixel, id) in picture.pixels_mut().zip(self.ids(device)?) {
            // 0 is the background.
            let color = (id as usize).checked_sub(1).and_then(|object| colors.get(object));
            if let Some([r, g, b]) = color {
                *pixel = Rgba([*r, *g, *b, 255]);
            }
        }
        Ok(picture)
    }

    /// What was chosen for the blocks of each paint.
    pub fn blocks(&self, device: &mut Device) -> Result<Vec<Vec<BlockRecord>>> {
        let mut all = Vec::new();
        for quilt in self.technique.quilts() {
            all.push(quilt.read_records(&mut device.runner)?);
        }
        Ok(all)
    }

    fn ids(&self, device: &mut Device) -> Result<Vec<u32>> {
        let bytes = device.runner.read_image(self.guides.id())?;
        Ok(bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }
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
