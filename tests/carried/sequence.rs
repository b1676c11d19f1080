//! A sequence that is painted frame by frame, and the oracle in step with it.

use crate::common::Validated;
use crate::oracles::{carry, settled_pixel, Moved};
use impasto::gpu::{Image, ImageDesc, Runner, Uploads};
use impasto::paint::{TextureDifference, Trajectory};
use impasto::scene::{Camera, GuidePass, Lights, Mesh, Moment};
use impasto::synthesis::params::{BlockRecord, QuiltParams};
use impasto::synthesis::quilt::QuiltStages;
use impasto::synthesis::quilt_oracle::{quilt_oracle, OracleGuide};
use impasto::synthesis::repair::{RepairParams, NOT_PASTED};
use impasto::synthesis::repair_oracle::{repair_oracle, BlockFate, CarriedTexture, OracleRepair, Repaired};
use impasto::technique::image::{ImageParams, ImageTechnique};
use impasto::technique::Paint;

/// A strip, taken apart.
pub struct Strip {
    pub texture: TextureDifference,
    pub trajectory: Trajectory,
}

impl Strip {
    pub fn paint(&self) -> Paint<'_> {
        Paint { texture: &self.texture, trajectory: &self.trajectory }
    }

    fn size(&self) -> (u32, u32) {
        (self.texture.width(), self.texture.height())
    }
}

/// What is painted, and with what: object i with `strips[objects[i]]`.
pub struct Model<'a> {
    pub mesh: &'a Mesh,
    pub strips: &'a [Strip],
    pub objects: &'a [u32],
}

/// How far a frame may be off on average, between texels: lavapipe's filter makes it about 0.6. With the corners' weights
/// put back the oracle is off by more than a single value may be.
const MEAN_OFF: f64 = 0.68;

pub struct Sequence<'a> {
    gpu: &'a Validated,
    runner: Runner,
    model: &'a Model<'a>,
    size: (u32, u32),
    guides: GuidePass,
    motion: Image,
    technique: ImageTechnique,
    /// What the oracle is told; the technique keeps what it was made with.
    pub params: ImageParams,
    pub repair: RepairParams,
    pub band_rows: u32,
    /// Where each pixel's texture comes from, by the oracle.
    pub places: Vec<Option<(u32, u32)>>,
}

/// A frame, with what led to it. Places are as the images have them.
#[derive(Clone, PartialEq)]
pub struct Painted {
    pub tone: Vec<f32>,
    /// The number of each pixel's paint, from 1; 0 is background.
    pub paint_at: Vec<u32>,
    pub frame: Vec<[u8; 4]>,
    pub places: Vec<[u16; 4]>,
    /// For each paint.
    pub carried: Vec<Vec<[u16; 4]>>,
    pub sources: Vec<Vec<u32>>,
    pub records: Vec<Vec<BlockRecord>>,
}

/// A frame by the oracle.
pub struct Expected {
    pub frame: Vec<[u8; 4]>,
    pub places: Vec<Option<(u32, u32)>>,
    pub carried: Vec<Vec<Option<CarriedTexture>>>,
    pub repaired: Vec<Repaired>,
}

impl<'a> Sequence<'a> {
    pub fn new(
        gpu: &'a Validated,
        model: &'a Model<'a>,
        size: (u32, u32),
        params: &ImageParams,
        repair: &RepairParams,
    ) -> Self {
        let mut runner = gpu.runner();
        let mut uploads = Uploads::default();
        let guides = GuidePass::new(&gpu.context, &mut uploads, model.mesh, size).expect("a guide pass");
        let desc = ImageDesc::storage_2d(size.0, size.1, ash::vk::Format::R32_UINT);
        let motion = Image::new(&gpu.context, "motion", &desc).expect("a picture");
        let stages = QuiltStages::new(&gpu.context);
        let paints: Vec<Paint<'_>> = model.strips.iter().map(Strip::paint).collect();
        let mut technique =
            ImageTechnique::new(&gpu.context, &mut uploads, &stages, &guides, &paints, model.objects, params)
                .expect("a technique");
        technique.carry(&gpu.context, &mut uploads, &guides, &paints, &motion, repair).expect("carrying");
        let upload = |recorder: &mut impasto::gpu::Recorder<'_>| {
            uploads.record(recorder);
            Ok(())
        };
        runner.run(upload).expect("run");
        let (params, repair, places) = (*params, *repair, Vec::new());
        Sequence { gpu, runner, model, size, guides, motion, technique, params, repair, band_rows: u32::MAX, places }
    }

    /// Paints the first frame, which is a quilting for each paint, and checks that.
    pub fn start(&mut self, camera: &Camera, lights: &Lights) -> Painted {
        let (guides, technique, seed) = (&self.guides, &self.technique, self.params.quilt.seed);
        self.runner
            .run(|recorder| {
                guides.record(recorder, &Moment::at_rest(*camera, lights.clone()))?;
                technique.record(recorder, seed, 0);
                Ok(())
            })
            .expect("run");
        let painted = self.read();
        let shade = painted.shade();
        self.places = vec![None; shade.len()];
        for (number, strip) in (1..).zip(self.model.strips) {
            let covered = painted.covered(number);
            let guide = self.guide(&shade, &covered, strip);
            let texels = strip.texture.to_unorm8();
            let quilted =
                quilt_oracle(&texels, strip.size(), self.size, &self.params.quilt, Some(&guide)).expect("oracle");
            for (i, from) in quilted.source.iter().enumerate().filter(|(i, _)| covered[*i]) {
                let (x, y) = from.expect("covered pixels are painted");
                let (x, y) = (u32::from(x), u32::from(y));
                assert_eq!(
                    painted.sources[number as usize - 1][i],
                    x | y << 16,
                    "the first frame's source of pixel {i}"
                );
                self.places[i] = Some((64 * x, 64 * y));
            }
        }
        assert!(painted.places == encoded(&self.places), "the first frame's places");
        painted
    }

    /// Paints a frame that goes on from the last.
    pub fn next(&mut self, camera: &Camera, lights: &Lights, motion: &[u32], frame: u32) -> Painted {
        let mut uploads = Uploads::default();
        uploads.image(&self.gpu.context, &self.motion, bytemuck::cast_slice(motion)).expect("motion");
        let (guides, technique, seed) = (&self.guides, &self.technique, self.params.quilt.seed);
        self.runner
            .run(|recorder| {
                uploads.record(recorder);
                guides.record(recorder, &Moment::at_rest(*camera, lights.clone()))?;
                technique.record_next(recorder, seed, frame);
                Ok(())
            })
            .expect("run");
        self.read()
    }

    fn read(&mut self) -> Painted {
        let technique = &self.technique;
        let runner = &mut self.runner;
        let mut words =
            |image: &Image| -> Vec<u32> { bytemuck::pod_collect_to_vec(&runner.read_image(image).expect("a picture")) };
        let tone = words(technique.shade()).into_iter().map(f32::from_bits).collect();
        let objects = words(self.guides.id());
        let frame = words(technique.frame()).into_iter().map(u32::to_le_bytes).collect();
        let sources = technique.quilts().map(|quilt| words(quilt.source())).collect();
        let mut places = |image: &Image| -> Vec<[u16; 4]> {
            bytemuck::pod_collect_to_vec(&runner.read_image(image).expect("places"))
        };
        let (last, carried) = technique.carried().expect("it carries");
        let (last, carried) = (places(last), carried.into_iter().map(places).collect());
        let records = technique.quilts().map(|quilt| quilt.read_records(runner).expect("records")).collect();
        let paint_of = |&id: &u32| if id == 0 { 0 } else { self.model.objects[id as usize - 1] + 1 };
        let paint_at = objects.iter().map(paint_of).collect();
        Painted { tone, paint_at, frame, places: last, carried, sources, records }
    }

    fn guide<'g>(&self, shade: &'g [u8], covered: &'g [bool], strip: &Strip) -> OracleGuide<'g> {
        OracleGuide { shade, covered, window_px: self.params.window_px(strip.texture.width()).expect("k in range") }
    }

    /// The frame by the oracle, from the guide of the painted one and the places before it.
    pub fn expect(&self, painted: &Painted, motion: &[u32], frame: u32) -> Expected {
        let moved = Moved { size: self.size, motion, paint_at: &painted.paint_at, places: &self.places };
        let shade = painted.shade();
        let mut expected = Expected {
            frame: vec![[0; 4]; shade.len()],
            places: vec![None; shade.len()],
            carried: Vec::new(),
            repaired: Vec::new(),
        };
        for (number, strip) in (1..).zip(self.model.strips) {
            let QuiltParams { block_px, .. } = self.params.quilt;
            let stretch = f64::from(self.repair.stretch);
            let limits = ((64.0 / stretch).round() as u32, (64.0 * stretch).round() as u32);
            let carried = carry(&moved, number, strip.size(), limits);
            let (covered, texels) = (painted.covered(number), strip.texture.to_unorm8());
            let params = QuiltParams { tolerance: self.repair.tolerance, ..self.params.quilt };
            let input = OracleRepair {
                sample: &texels,
                sample_size: strip.size(),
                output: self.size,
                params: &params,
                guide: &self.guide(&shade, &covered, strip),
                carried: &carried,
                slack_px: (f64::from(self.repair.slack) * f64::from(block_px)).floor() as u32,
                band_rows: self.band_rows,
            };
            let repaired = repair_oracle(&input, frame).expect("oracle");
            for i in (0..shade.len()).filter(|&i| covered[i]) {
                let pasted = repaired.source[i].map(|(x, y)| (64 * u32::from(x), 64 * u32::from(y)));
                let place = pasted.or(carried[i].map(|texture| texture.place)).expect("covered pixels have texture");
                expected.places[i] = Some(place);
                expected.frame[i] = settled_pixel(&texels, strip.size(), &strip.trajectory, painted.tone[i], place);
            }
            expected.carried.push(carried);
            expected.repaired.push(repaired);
        }
        expected
    }
}

/// A place as images have it.
fn words_of(place: Option<CarriedTexture>) -> [u16; 4] {
    let Some(CarriedTexture { place: (x, y), misfit }) = place else { return [0; 4] };
    let flags = 0x8000 | if misfit { 0x4000 } else { 0 };
    [x as u16, (x >> 16) as u16, y as u16, (y >> 16) as u16 | flags]
}

fn encoded(places: &[Option<(u32, u32)>]) -> Vec<[u16; 4]> {
    let settled = |place: &Option<(u32, u32)>| place.map(|place| CarriedTexture { place, misfit: false });
    places.iter().map(settled).map(words_of).collect()
}

/// The first index at which two lists differ.
fn first_difference<T: PartialEq>(a: &[T], b: &[T]) -> Option<usize> {
    assert_eq!(a.len(), b.len());
    (0..a.len()).find(|&i| a[i] != b[i])
}

impl Painted {
    /// The guide's shade in 8 bits.
    fn shade(&self) -> Vec<u8> {
        self.tone.iter().map(|tone| (tone * 255.0 + 0.5) as u8).collect()
    }

    fn covered(&self, paint: u32) -> Vec<bool> {
        self.paint_at.iter().map(|&at| at == paint).collect()
    }

    /// The first difference to the oracle's frame, in words.
    pub fn difference(&self, expected: &Expected) -> Result<(), String> {
        for (layer, repaired) in expected.repaired.iter().enumerate() {
            let carried: Vec<_> = expected.carried[layer].iter().map(|&place| words_of(place)).collect();
            if let Some(i) = first_difference(&self.carried[layer], &carried) {
                let (got, want) = (self.carried[layer][i], carried[i]);
                return Err(format!("layer {layer}: carried to {i} is {got:x?}, but {want:x?} by the oracle"));
            }
            blocks_difference(&self.records[layer], &repaired.blocks).map_err(|e| format!("layer {layer}: {e}"))?;
            let word = |from: &Option<(u16, u16)>| from.map_or(NOT_PASTED, |(x, y)| u32::from(x) | u32::from(y) << 16);
            let source: Vec<u32> = repaired.source.iter().map(word).collect();
            if let Some(i) = first_difference(&self.sources[layer], &source) {
                let (got, want) = (self.sources[layer][i], source[i]);
                return Err(format!("layer {layer}: source of {i} is {got:x}, but {want:x} by the oracle"));
            }
        }
        let places = encoded(&expected.places);
        if let Some(i) = first_difference(&self.places, &places) {
            return Err(format!("place of {i} is {:x?}, but {:x?} by the oracle", self.places[i], places[i]));
        }
        self.frame_difference(expected)
    }

    /// A texel alone is a plain copy, to which a colour is added. Between texels, filters weigh and round in 8 bits,
    /// and what they give is drawn at twice its contrast.
    fn frame_difference(&self, expected: &Expected) -> Result<(), String> {
        let (mut between, mut sum) = (0, 0);
        for (i, (got, want)) in self.frame.iter().zip(&expected.frame).enumerate() {
            let whole = expected.places[i].is_none_or(|(x, y)| x % 64 == 0 && y % 64 == 0);
            for off in got.iter().zip(want).map(|(got, want)| got.abs_diff(*want)) {
                if off > if whole { 1 } else { 4 } {
                    return Err(format!("frame at {i}: {got:?}, but {want:?} by the oracle"));
                }
                if !whole {
                    between += 1;
                    sum += u32::from(off);
                }
            }
        }
        // Of few pixels the mean says little.
        if between > 1000 && f64::from(sum) > MEAN_OFF * f64::from(between) {
            return Err(format!("frame is off by {sum} in {between} values between texels"));
        }
        Ok(())
    }
}

/// Records there must be of what was kept and what was pasted; only of the latter do they tell the position.
fn blocks_difference(records: &[BlockRecord], fates: &[BlockFate]) -> Result<(), String> {
    let placed: Vec<&BlockFate> = fates.iter().filter(|fate| !matches!(fate, BlockFate::Skipped)).collect();
    if placed.len() != records.len() {
        return Err(format!("{} blocks are placed, but {} by the oracle", records.len(), placed.len()));
    }
    let agree = |record: &BlockRecord, fate: &BlockFate| match *fate {
        BlockFate::Pasted(want) => *record == want,
        BlockFate::Kept(first, last) => (record.allowed[0], record.allowed[2]) == (first, last),
        BlockFate::Skipped => false,
    };
    match records.iter().zip(placed).find(|(record, fate)| !agree(record, fate)) {
        Some((record, fate)) => Err(format!("block {record:?}, but {fate:?} by the oracle")),
        None => Ok(()),
    }
}
