//! The kernels that are measured: their shaders, how much work a step of each is, and what they must give.

use super::super::access::Access;
use super::super::context::Context;
use super::super::memory::{Buffer, BufferKind, Image, ImageDesc};
use super::super::pipeline::{BindingKind, BindingSet, Bound, ComputePipeline, Shader};
use super::super::recorder::Recorder;
use super::super::runner::Runner;
use super::super::upload::Uploads;
use super::What;
use crate::Result;
use ash::vk;
use bytemuck::{Pod, Zeroable};

/// Invocations of a workgroup.
const GROUP: u32 = 128;
/// Workgroups that kernels of arithmetic start with, so few that a slow CPU takes some milliseconds, and that they have
/// at most.
const FIRST_GROUPS: u32 = 4;
const MAX_GROUPS: u32 = 16_384;
/// Passes over a buffer or an image in one submission.
const MAX_PASSES: u32 = 256;
/// Results of arithmetic repeat after so many invocations.
const LANES: usize = 256;

const COPY_BUFFERS: &[BindingKind] =
    &[BindingKind::Buffer(Access::ComputeRead), BindingKind::Buffer(Access::ComputeWrite)];
const RESULTS: BindingKind = BindingKind::Buffer(Access::ComputeWrite);
const RATE_BYTES: u32 = size_of::<RatePush>() as u32;

macro_rules! spirv {
    ($name:literal) => {
        include_bytes!(concat!("../../../glsl/spirv/gpu/", $name, ".comp.spv"))
    };
}

pub const COPY_WORDS: Shader =
    Shader { name: "copy_words", spirv: spirv!("copy_words"), bindings: COPY_BUFFERS, push_bytes: 4 };
pub const COPY_TEXELS: Shader = Shader {
    name: "copy_texels",
    spirv: spirv!("copy_texels"),
    bindings: &[BindingKind::Image(Access::ComputeRead), BindingKind::Image(Access::ComputeWrite)],
    push_bytes: 4,
};
pub const FLOAT_RATE: Shader =
    Shader { name: "float_rate", spirv: spirv!("float_rate"), bindings: &[RESULTS], push_bytes: RATE_BYTES };
pub const INTEGER_RATE: Shader =
    Shader { name: "integer_rate", spirv: spirv!("integer_rate"), bindings: &[RESULTS], push_bytes: RATE_BYTES };
pub const DOT8_RATE: Shader =
    Shader { name: "dot8_rate", spirv: spirv!("dot8_rate"), bindings: &[RESULTS], push_bytes: RATE_BYTES };
pub const DOT8_PACKED_RATE: Shader = Shader {
    name: "dot8_packed_rate",
    spirv: spirv!("dot8_packed_rate"),
    bindings: &[RESULTS],
    push_bytes: RATE_BYTES,
};
pub const SEARCH_PATH: Shader = Shader {
    name: "search_path",
    spirv: spirv!("search_path"),
    bindings: &[BindingKind::Image(Access::ComputeRead), BindingKind::Image(Access::ComputeRead), RESULTS],
    push_bytes: 8,
};
pub const PRODUCT_PATH: Shader = Shader {
    name: "product_path",
    spirv: spirv!("product_path"),
    bindings: &[BindingKind::Image(Access::ComputeRead), BindingKind::Image(Access::ComputeRead), RESULTS],
    push_bytes: 4,
};

type Words = Box<dyn Fn(u32) -> usize>;
type Expected = Box<dyn Fn(usize, u32) -> u32>;
type Record = Box<dyn Fn(&mut Recorder<'_>, u32, u32)>;
type Read = Box<dyn Fn(&mut Runner) -> Result<Vec<u8>>>;

/// Something that can be run for a number of steps, each of the same work.
pub struct Kernel {
    pub name: &'static str,
    pub first_steps: u32,
    pub max_steps: u32,
    /// Bytes or operations of a step.
    pub step_work: u64,
    pub copy_bytes: u64,
    /// Words of the result of so many steps.
    pub words: Words,
    /// A word of the result, by its place and the seed.
    pub expected: Expected,
    /// Records so many steps with this seed, which changes all words of the result.
    pub record: Record,
    pub read: Read,
}

/// Texels of 16 bytes along a side of the square that has about so many bytes.
fn side_px(bytes: u64) -> u32 {
    (bytes / 16).isqrt() as u32 / 64 * 64
}

/// Whether a copy of so many bytes is something, within the device's limits, and no burden to the budget: besides the
/// two buffers or images there is the staging memory, and then that of reading back.
pub fn copy_fits(context: &Context, bytes: u64) -> bool {
    let (caps, inner) = (context.caps(), context.inner());
    let left = inner.budget.saturating_sub(inner.memory.allocated_bytes());
    let square = (64..=caps.max_image_2d_px).contains(&side_px(bytes));
    square && bytes <= caps.max_storage_buffer_bytes && bytes <= left / 4
}

/// The word at place `i` of what is copied: all are different.
fn source_word(i: usize) -> u32 {
    (i as u32).wrapping_mul(0x9e37_79b9)
}

fn bytes_of(words: impl Iterator<Item = u32>) -> Vec<u8> {
    words.flat_map(u32::to_ne_bytes).collect()
}

/// Makes something of this room, with what it uploads on the device when it returns.
fn uploaded<T>(runner: &mut Runner, make: impl FnOnce(&Context, &mut Uploads) -> Result<T>) -> Result<T> {
    let context = runner.context().clone();
    let mut uploads = Uploads::default();
    let made = make(&context, &mut uploads)?;
    runner.run(|recorder| {
        uploads.record(recorder);
        Ok(())
    })?;
    Ok(made)
}

/// The kernel that copies about so many bytes; a step is one pass over all of them.
pub fn copy(runner: &mut Runner, what: What, bytes: u64) -> Result<Kernel> {
    let side = side_px(bytes);
    let words = side as usize * side as usize * 4;
    let bytes = words as u64 * 4;
    let source = bytes_of((0..words).map(source_word));
    let kernel = |name, record: Record, read: Read| Kernel {
        name,
        first_steps: 1,
        max_steps: MAX_PASSES,
        step_work: 2 * bytes,
        copy_bytes: bytes,
        words: Box::new(move |_| words),
        expected: Box::new(move |i, seed| source_word(i) ^ if what == What::CopyBuffer { 0 } else { seed }),
        record,
        read,
    };
    uploaded(runner, |context, uploads| {
        if what == What::CopyTexels {
            let desc = ImageDesc::storage_2d(side, side, vk::Format::R32G32B32A32_UINT);
            let (from, to) = (Image::new(context, "ceiling", &desc)?, Image::new(context, "ceiling copy", &desc)?);
            uploads.image(context, &from, &source)?;
            let pipeline = ComputePipeline::new(context, &COPY_TEXELS)?;
            let set = BindingSet::new(context, &pipeline, &[(&from).into(), (&to).into()])?;
            let record: Record = Box::new(move |recorder, steps, seed| {
                (0..steps).for_each(|_| recorder.dispatch(&pipeline, &set, &seed, [side / 16, side / 8, 1]));
            });
            return Ok(kernel(COPY_TEXELS.name, record, Box::new(move |runner: &mut Runner| runner.read_image(&to))));
        }
        let from = Buffer::new(context, "ceiling", BufferKind::Storage, bytes)?;
        let to = Buffer::new(context, "ceiling copy", BufferKind::Storage, bytes)?;
        uploads.buffer(context, &from, &source)?;
        let result = to.clone();
        let read = Box::new(move |runner: &mut Runner| runner.read_buffer(&result));
        if what == What::CopyBuffer {
            let record: Record = Box::new(move |recorder, steps, _| {
                (0..steps).for_each(|_| recorder.copy_buffer("copy_buffer", &from, &to));
            });
            return Ok(kernel("copy_buffer", record, read));
        }
        let pipeline = ComputePipeline::new(context, &COPY_WORDS)?;
        let set = BindingSet::new(context, &pipeline, &[(&from).into(), (&to).into()])?;
        let groups = (words / (4 * 4 * GROUP as usize)) as u32;
        let record = Box::new(move |recorder: &mut Recorder<'_>, steps, seed: u32| {
            (0..steps).for_each(|_: u32| recorder.dispatch(&pipeline, &set, &seed, [groups, 1, 1]));
        });
        Ok(kernel(COPY_WORDS.name, record, read))
    })
}

/// The push constants of the rates without loads.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct RatePush {
    pub iterations: u32,
    pub multiplier: u32,
    pub addend: u32,
    pub seed: u32,
}

/// The push constants of the search's path.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PathPush {
    pub rows: u32,
    pub seed: u32,
}

/// The kernel of a rate of arithmetic; a step is a workgroup.
pub fn arithmetic(runner: &mut Runner, what: What) -> Result<Kernel> {
    match what {
        What::SearchPath => search_path(runner),
        What::ProductPath => product_path(runner),
        // 4,096 times 3 more than the start, which floats hold exactly.
        What::Float => rate(runner, &FLOAT_RATE, 2, 1, 3, |x| x + 3),
        What::Dot8 => dot8_rate(runner, &DOT8_RATE),
        What::Dot8Packed => dot8_rate(runner, &DOT8_PACKED_RATE),
        _ => {
            const M: u32 = 1_664_525;
            const C: u32 = 1_013_904_223;
            rate(runner, &INTEGER_RATE, 2, M, C, |x| x.wrapping_mul(M).wrapping_add(C))
        }
    }
}

fn dot8_rate(runner: &mut Runner, shader: &'static Shader) -> Result<Kernel> {
    const M: u32 = 0x7f81_03fd;
    let step = |x: u32| {
        let products =
            x.to_le_bytes().into_iter().zip(M.to_le_bytes()).map(|(a, b)| i32::from(a as i8) * i32::from(b as i8));
        x.wrapping_add_signed(products.sum())
    };
    rate(runner, shader, 8, M, 0, step)
}

/// A rate without loads: chains of `step` from numbers that depend on the invocation.
fn rate(
    runner: &mut Runner,
    shader: &'static Shader,
    step_operations: u64,
    multiplier: u32,
    addend: u32,
    step: impl Fn(u32) -> u32,
) -> Result<Kernel> {
    const ITERATIONS: u32 = 1024;
    // Of each of the twelve chains, in an iteration.
    const STEPS: u32 = 4;
    let chains: Vec<u32> =
        (0..LANES as u32 + 12).map(|start| (0..ITERATIONS * STEPS).fold(start, |x, _| step(x))).collect();
    let word = |lane: usize| {
        let chain = |i: usize| chains[lane + i].wrapping_mul(2 * (i as u32 % 4) + 1);
        (0..12).map(chain).fold(0, u32::wrapping_add)
    };
    let operations = u64::from(ITERATIONS * STEPS) * 12 * step_operations;
    let push = move |seed| RatePush { iterations: ITERATIONS, multiplier, addend, seed };
    groups(runner, shader, operations, (0..LANES).map(word).collect(), push, |_, _| Ok(Vec::new()))
}

/// Small integers without a pattern, as the sums of their products must be exact in floats.
fn below_16(i: usize) -> u32 {
    source_word(i + 1) >> 28
}

/// A sum of sums that tells them apart.
fn sum_of_sums(sums: impl IntoIterator<Item = u32>) -> u32 {
    sums.into_iter().zip(0..).map(|(sum, i)| sum.wrapping_mul(2 * i + 1)).fold(0, u32::wrapping_add)
}

fn search_path(runner: &mut Runner) -> Result<Kernel> {
    const ROWS: u32 = 128;
    const SAMPLE_WIDTH: usize = 176;
    const SAMPLE_HEIGHT: usize = 80;
    const BLOCK_WIDTH: usize = 30;
    const BLOCK_HEIGHT: usize = 64;
    let sample = |x: usize, y: usize| [0, 1, 2].map(|c| below_16((y * SAMPLE_WIDTH + x) * 3 + c));
    let block = |x: usize, y: usize| [0, 1, 2].map(|c| below_16((y * BLOCK_WIDTH + x) * 3 + c + 50_000));
    let expected = |lane: usize| {
        let mut sums = [0; 8];
        for (j, sum) in sums.iter_mut().enumerate() {
            let (left, top) = (8 * (lane % 16) + j, lane / 16);
            for (x, y) in (0..BLOCK_HEIGHT).flat_map(|y| (0..BLOCK_WIDTH).map(move |x| (x, y))) {
                let products = sample(left + x, top + y).into_iter().zip(block(x, y)).map(|(a, b)| a * b);
                *sum += products.sum::<u32>() * (ROWS / BLOCK_HEIGHT as u32);
            }
        }
        sum_of_sums(sums)
    };
    let operations = u64::from(ROWS) * BLOCK_WIDTH as u64 * 8 * 3 * 2;
    let push = |seed| PathPush { rows: ROWS, seed };
    groups(runner, &SEARCH_PATH, operations, (0..LANES).map(expected).collect(), push, |context, uploads| {
        let mut image = |name,
                         width: usize,
                         height: usize,
                         texel: &dyn Fn(usize, usize) -> [u32; 3]|
         -> Result<Bound> {
            let image =
                Image::new(context, name, &ImageDesc::storage_2d(width as u32, height as u32, vk::Format::R32_UINT))?;
            let texels = (0..height).flat_map(|y| (0..width).map(move |x| texel(x, y)));
            uploads.image(context, &image, &bytes_of(texels.map(|[r, g, b]| r | g << 8 | b << 16 | 0xff << 24)))?;
            Ok((&image).into())
        };
        Ok(vec![
            image("sample", SAMPLE_WIDTH, SAMPLE_HEIGHT, &sample)?,
            image("block", BLOCK_WIDTH, BLOCK_HEIGHT, &block)?,
        ])
    })
}

fn product_path(runner: &mut Runner) -> Result<Kernel> {
    /// Rows of positions.
    const ROWS: usize = 2;
    /// Texels of a position, of eight coordinates.
    const TEXELS: usize = 8;
    const TEMPLATES: usize = 10;
    // Of both signs. By the position's place, of which 256 lie beside each other, and the number of the coordinate.
    let coordinate = |x: usize, y: usize, i: usize| below_16((y * LANES + x) * 8 * TEXELS + i) as i32 - 8;
    let template = |k: usize, i: usize| below_16(k * 8 * TEXELS + i + 100_000) as i32 - 8;
    let expected = |lane: usize| {
        let sum = |r, k| (0..8 * TEXELS).map(|i| coordinate(lane, r, i) * template(k, i)).sum::<i32>() as u32;
        sum_of_sums((0..ROWS * TEMPLATES).map(|j| sum(j / TEMPLATES, j % TEMPLATES)))
    };
    let operations = (ROWS * TEXELS * 8 * TEMPLATES * 2) as u64;
    let push = |seed| seed;
    groups(runner, &PRODUCT_PATH, operations, (0..LANES).map(expected).collect(), push, |context, uploads| {
        let mut image = |name, size: [usize; 2], format, word: &dyn Fn(usize, usize, usize) -> u32| -> Result<Bound> {
            let image = Image::new(context, name, &ImageDesc::storage_2d(size[0] as u32, size[1] as u32, format))?;
            let words = (0..size[0] * size[1] * 4).map(|i| word(i / 4 % size[0], i / 4 / size[0], i % 4));
            uploads.image(context, &image, &bytes_of(words))?;
            Ok((&image).into())
        };
        let two_coordinates = |x, y, c| {
            let [low, high] = [0, 1].map(|i| coordinate(x, y % ROWS, y / ROWS * 8 + 2 * c + i) as u32);
            low & 0xffff | high << 16
        };
        let number = |k, y, c| (template(k, 4 * y + c) as f32).to_bits();
        Ok(vec![
            image("coordinates", [LANES, ROWS * TEXELS], vk::Format::R32G32B32A32_UINT, &two_coordinates)?,
            image("templates", [TEMPLATES, 2 * TEXELS], vk::Format::R32G32B32A32_SFLOAT, &number)?,
        ])
    })
}

/// A kernel whose steps are workgroups, with a word of the result for each invocation, of which `expected` repeats.
/// The result is the last of the bindings, after those that `bind` makes.
fn groups<P: Pod>(
    runner: &mut Runner,
    shader: &'static Shader,
    invocation_operations: u64,
    expected: Vec<u32>,
    push: impl Fn(u32) -> P + 'static,
    bind: impl FnOnce(&Context, &mut Uploads) -> Result<Vec<Bound>>,
) -> Result<Kernel> {
    uploaded(runner, |context, uploads| {
        let result = Buffer::new(context, "result", BufferKind::Storage, u64::from(MAX_GROUPS * GROUP) * 4)?;
        let mut bound = bind(context, uploads)?;
        bound.push((&result).into());
        let pipeline = ComputePipeline::new(context, shader)?;
        let set = BindingSet::new(context, &pipeline, &bound)?;
        Ok(Kernel {
            name: shader.name,
            first_steps: FIRST_GROUPS,
            max_steps: MAX_GROUPS,
            step_work: invocation_operations * u64::from(GROUP),
            copy_bytes: 0,
            words: Box::new(|steps| (steps * GROUP) as usize),
            expected: Box::new(move |i, seed| expected[i % LANES] ^ seed),
            record: Box::new(move |recorder, steps, seed| {
                recorder.dispatch(&pipeline, &set, &push(seed), [steps, 1, 1]);
            }),
            read: Box::new(move |runner| runner.read_buffer(&result)),
        })
    })
}
