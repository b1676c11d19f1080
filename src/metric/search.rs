//! The nearest source blocks of tested blocks by the thesis's metric (section 9.1), on the GPU: exact, by comparing
//! with all.
//!
//! ```text
//! picture -> feature_bins -> features (of chosen blocks) --> feature_distance -> feature_nearest -> host: exact order
//! ```
//!
//! A comparison takes 75 multiplications, two terms of the dot products in each, and 15 roots. Since devices may round
//! roots differently, the device keeps some more than are asked for, and the host compares those in integers and 64-bit
//! roots and drops the rest.

use super::features::{block_corner, check_block, FeatureBins, Features, HISTOGRAMS};
use super::sampling::Eligible;
use super::Picture;
use crate::gpu::{
    Access, BindingKind, BindingSet, Buffer, BufferKind, ComputePipeline, Context, Image, ImageDesc, Runner, Shader,
    Uploads,
};
use crate::{Error, Result};
use ash::vk;
use std::ops::RangeInclusive;

pub(crate) const FEATURE_BINS: Shader = Shader {
    name: "feature_bins",
    spirv: include_bytes!("../../glsl/spirv/metric/feature_bins.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: 0,
};

pub(crate) const FEATURES: Shader = Shader {
    name: "features",
    spirv: include_bytes!("../../glsl/spirv/metric/features.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Buffer(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: size_of::<FeaturesPush>() as u32,
};

pub(crate) const FEATURE_DISTANCE: Shader = Shader {
    name: "feature_distance",
    spirv: include_bytes!("../../glsl/spirv/metric/feature_distance.comp.spv"),
    bindings: &[
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeRead),
        BindingKind::Image(Access::ComputeWrite),
    ],
    push_bytes: size_of::<DistancePush>() as u32,
};

pub(crate) const FEATURE_NEAREST: Shader = Shader {
    name: "feature_nearest",
    spirv: include_bytes!("../../glsl/spirv/metric/feature_nearest.comp.spv"),
    bindings: &[BindingKind::Image(Access::ComputeRead), BindingKind::Buffer(Access::ComputeWrite)],
    push_bytes: size_of::<NearestPush>() as u32,
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct FeaturesPush {
    blocks: u32,
    block_px: u32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct DistancePush {
    blocks: u32,
    apart: u32,
    tested_blocks: u32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct NearestPush {
    blocks: u32,
    segments: u32,
    segment_blocks: u32,
    tested: u32,
}

/// How many nearest blocks may be asked for.
pub const NEAREST: RangeInclusive<u32> = 1..=32;

/// Texels in a row of the images that hold lists, as in the shaders.
const ACROSS: u32 = 4096;
/// Blocks that one dispatch looks at: their features fill 480 rows.
const CHUNK: usize = 1 << 17;
/// Tested blocks of one submission.
const BATCH: usize = 32;
/// Source blocks and tested blocks that one invocation compares, as in feature_distance.comp.
const SOURCE_TOGETHER: u32 = 4;
const TESTED_TOGETHER: u32 = 8;
/// Source blocks that one invocation of feature_nearest.comp goes through.
const SEGMENT: u32 = 1024;
/// Blocks that the device keeps beyond those that are asked for.
const SPARE: u32 = 6;

/// A source pixel that is near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// The pixel of the source around which the block lies.
    pub pixel: (u32, u32),
    /// The metric: [`Features::distance`].
    pub distance: f64,
}

/// The stages, ready for any pictures.
pub struct BlockSearch {
    context: Context,
    bins: ComputePipeline,
    features: ComputePipeline,
    distance: ComputePipeline,
    nearest: ComputePipeline,
    k: u32,
}

/// What is searched: a source's blocks.
pub struct Source {
    block_px: u32,
    size: (u32, u32),
    bins: FeatureBins,
    on_device: DeviceBins,
    /// The features of all its blocks, if they are one chunk.
    features: Option<Image>,
    /// Pixels whose blocks take part.
    pixels: Vec<(u32, u32)>,
}

/// The bins of a picture's pixels on the device.
struct DeviceBins {
    low: Image,
    high: Image,
}

impl BlockSearch {
    /// Compiles the stages of a search for the `k` nearest.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a `k` out of [`NEAREST`], [`Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, k: u32) -> Result<Self> {
        if !NEAREST.contains(&k) {
            return Err(Error::parameter("k", k, format!("{} to {}", NEAREST.start(), NEAREST.end())));
        }
        Ok(BlockSearch {
            context: context.clone(),
            bins: ComputePipeline::new(context, &FEATURE_BINS)?,
            features: ComputePipeline::new(context, &FEATURES)?,
            distance: ComputePipeline::new(context, &FEATURE_DISTANCE)?,
            nearest: ComputePipeline::specialized(context, &FEATURE_NEAREST, &[k + SPARE])?,
            k,
        })
    }

    /// Prepares a source. All of its blocks that lie inside the object take part, each once, around the pixel that they
    /// would not have to be moved for.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a block's side out of [`super::BLOCK_PX`], or a source with fewer than `k` such blocks;
    /// [`Error::Device`] for a picture that is too large for the device.
    pub fn source(&self, runner: &mut Runner, picture: &Picture, block_px: u32) -> Result<Source> {
        check_block(block_px, picture)?;
        let size = (picture.width(), picture.height());
        let before = block_px / 2;
        let centred = |x: u32, y: u32| {
            let (left, top) = block_corner((x, y), size, block_px);
            (left + before, top + before) == (x, y)
        };
        let pixels = Eligible::new(picture, block_px).all(centred);
        if pixels.len() < self.k as usize {
            let allowed = format!("at least the {} that are asked for", self.k);
            return Err(Error::parameter("blocks of the source", pixels.len(), allowed));
        }
        let on_device = self.device_bins(runner, picture)?;
        let features = match pixels.len() {
            0..=CHUNK => Some(self.record_features(runner, &on_device, size, block_px, &pixels)?),
            _ => None,
        };
        Ok(Source { block_px, size, bins: FeatureBins::new(picture), on_device, features, pixels })
    }

    /// The features of the blocks around `pixels` of a picture, which must lie in it.
    ///
    /// # Errors
    /// As [`BlockSearch::source`].
    pub fn features(
        &self,
        runner: &mut Runner,
        picture: &Picture,
        block_px: u32,
        pixels: &[(u32, u32)],
    ) -> Result<Vec<Features>> {
        check_block(block_px, picture)?;
        let size = (picture.width(), picture.height());
        if let Some((x, y)) = pixels.iter().find(|(x, y)| *x >= size.0 || *y >= size.1) {
            let allowed = format!("inside the picture of {} x {}", size.0, size.1);
            return Err(Error::parameter("pixel", format!("{x}, {y}"), allowed));
        }
        let bins = self.device_bins(runner, picture)?;
        let mut all = Vec::with_capacity(pixels.len());
        for chunk in pixels.chunks(CHUNK) {
            let image = self.record_features(runner, &bins, size, block_px, chunk)?;
            let texels: Vec<[u8; 16]> = bytemuck::pod_collect_to_vec(&runner.read_image(&image)?);
            all.extend((0..chunk.len()).map(|block| unpack(|h| texels[h * chunk.len() + block])));
        }
        Ok(all)
    }

    /// The `k` nearest source pixels of each tested block, nearest first, of equally near ones the first in reading
    /// order. Of source blocks beyond the k-th whose distances agree with its to 1 in 100,000 any may be taken.
    ///
    /// # Errors
    /// [`Error::Memory`] when the budget does not allow it, [`Error::Vulkan`] when a call fails.
    pub fn nearest(&self, runner: &mut Runner, source: &Source, tested: &[Features]) -> Result<Vec<Vec<Neighbour>>> {
        let kept = (self.k + SPARE) as usize;
        let mut found: Vec<Vec<(f32, u32)>> = vec![Vec::new(); tested.len()];
        let mut first = 0;
        for chunk in source.pixels.chunks(CHUNK) {
            let features = match &source.features {
                Some(features) => features.clone(),
                None => self.record_features(runner, &source.on_device, source.size, source.block_px, chunk)?,
            };
            let blocks = chunk.len() as u32;
            let segments = blocks.div_ceil(SEGMENT);
            let context = &self.context;
            let rows = (BATCH as u32 * blocks).div_ceil(ACROSS);
            let desc = ImageDesc::storage_2d(ACROSS, rows, vk::Format::R32_SFLOAT);
            let distances = Image::new(context, "feature distances", &desc)?;
            let bytes = BATCH as u64 * u64::from(segments) * kept as u64 * 8;
            let nearest = Buffer::new(context, "nearest blocks", BufferKind::Storage, bytes)?;
            let desc = ImageDesc::storage_2d(ACROSS, 1, vk::Format::R32G32B32A32_UINT);
            let tested_image = Image::new(context, "tested features", &desc)?;
            let bound = [(&features).into(), (&tested_image).into(), (&distances).into()];
            let distance_set = BindingSet::new(context, &self.distance, &bound)?;
            let bound = [(&distances).into(), (&nearest).into()];
            let nearest_set = BindingSet::new(context, &self.nearest, &bound)?;
            for (batch, found) in tested.chunks(BATCH).zip(found.chunks_mut(BATCH)) {
                let mut uploads = Uploads::default();
                uploads.image(context, &tested_image, bytemuck::cast_slice(&packed(batch)))?;
                let count = batch.len() as u32;
                runner.run(|recorder| {
                    uploads.record(recorder);
                    let apart = blocks.div_ceil(SOURCE_TOGETHER);
                    let push = DistancePush { blocks, apart, tested_blocks: count };
                    let groups = [apart.div_ceil(64), count.div_ceil(TESTED_TOGETHER), 1];
                    recorder.dispatch(&self.distance, &distance_set, &push, groups);
                    let push = NearestPush { blocks, segments, segment_blocks: SEGMENT, tested: count };
                    recorder.dispatch(&self.nearest, &nearest_set, &push, [(segments * count).div_ceil(64), 1, 1]);
                    Ok(())
                })?;
                let pairs: Vec<[u32; 2]> = bytemuck::pod_collect_to_vec(&runner.read_buffer(&nearest)?);
                for (found, of_tested) in found.iter_mut().zip(pairs.chunks(segments as usize * kept)) {
                    found.extend(of_tested.iter().map(|[bits, block]| (f32::from_bits(*bits), first + block)));
                    found.retain(|(distance, _)| distance.is_finite());
                    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                    found.truncate(kept);
                }
            }
            first += blocks;
        }
        let exact = |(tested, found): (&Features, Vec<(f32, u32)>)| {
            let neighbour = |(_, block)| {
                let pixel = source.pixels[block as usize];
                let distance = tested.distance(&source.features(pixel), source.block_px);
                (block, Neighbour { pixel, distance })
            };
            let mut nearest: Vec<(u32, Neighbour)> = found.into_iter().map(neighbour).collect();
            nearest.sort_by(|a, b| a.1.distance.total_cmp(&b.1.distance).then(a.0.cmp(&b.0)));
            nearest.truncate(self.k as usize);
            nearest.into_iter().map(|(_, neighbour)| neighbour).collect()
        };
        Ok(tested.iter().zip(found).map(exact).collect())
    }

    fn device_bins(&self, runner: &mut Runner, picture: &Picture) -> Result<DeviceBins> {
        let context = &self.context;
        let (width, height) = (picture.width(), picture.height());
        let image = |name| Image::new(context, name, &ImageDesc::storage_2d(width, height, vk::Format::R32_UINT));
        let (pixels, low, high) = (image("measured picture")?, image("low bins")?, image("high bins")?);
        let mut uploads = Uploads::default();
        uploads.image(context, &pixels, bytemuck::cast_slice(picture.pixels()))?;
        let set = BindingSet::new(context, &self.bins, &[(&pixels).into(), (&low).into(), (&high).into()])?;
        runner.run(|recorder| {
            uploads.record(recorder);
            recorder.dispatch(&self.bins, &set, &(), [width.div_ceil(16), height.div_ceil(8), 1]);
            Ok(())
        })?;
        Ok(DeviceBins { low, high })
    }

    /// Histogram h of block n at texel h * blocks + n.
    fn record_features(
        &self,
        runner: &mut Runner,
        bins: &DeviceBins,
        size: (u32, u32),
        block_px: u32,
        pixels: &[(u32, u32)],
    ) -> Result<Image> {
        let context = &self.context;
        let corners: Vec<[u32; 2]> = pixels.iter().map(|&pixel| block_corner(pixel, size, block_px).into()).collect();
        let list = Buffer::new(context, "block corners", BufferKind::Storage, corners.len() as u64 * 8)?;
        let mut uploads = Uploads::default();
        uploads.buffer(context, &list, bytemuck::cast_slice(&corners))?;
        let blocks = pixels.len() as u32;
        let rows = (HISTOGRAMS as u32 * blocks).div_ceil(ACROSS).max(1);
        let desc = ImageDesc::storage_2d(ACROSS, rows, vk::Format::R32G32B32A32_UINT);
        let features = Image::new(context, "features", &desc)?;
        let bound = [(&bins.low).into(), (&bins.high).into(), (&list).into(), (&features).into()];
        let set = BindingSet::new(context, &self.features, &bound)?;
        runner.run(|recorder| {
            uploads.record(recorder);
            let push = FeaturesPush { blocks, block_px };
            recorder.dispatch(&self.features, &set, &push, [blocks.div_ceil(64), HISTOGRAMS as u32, 1]);
            Ok(())
        })?;
        Ok(features)
    }
}

impl Source {
    /// The pixels whose blocks are searched, in reading order.
    pub fn pixels(&self) -> &[(u32, u32)] {
        &self.pixels
    }

    /// The features of the block around one of the pixels.
    pub fn features(&self, pixel: (u32, u32)) -> Features {
        self.bins.features(block_corner(pixel, self.size, self.block_px), self.block_px)
    }

    /// The side of a block, pixels.
    pub fn block_px(&self) -> u32 {
        self.block_px
    }

    /// Width of the source, pixels.
    pub fn width(&self) -> u32 {
        self.size.0
    }
}

/// Features from what features.comp wrote of each histogram.
fn unpack(histogram: impl Fn(usize) -> [u8; 16]) -> Features {
    Features(std::array::from_fn(|h| std::array::from_fn(|bin| histogram(h)[bin])))
}

/// A batch as features.comp would write it, with texels to spare.
fn packed(tested: &[Features]) -> Vec<[u32; 4]> {
    let mut texels = vec![[0; 4]; ACROSS as usize];
    let histograms = (0..HISTOGRAMS).flat_map(|h| tested.iter().map(move |features| features.0[h]));
    for (texel, counts) in texels.iter_mut().zip(histograms) {
        for (bin, count) in (0..).zip(counts) {
            texel[bin / 4] |= u32::from(count) << (8 * (bin % 4));
            texel[3] += u32::from(count).pow(2);
        }
    }
    texels
}
