//! Compute pipelines, their binding sets, and the pipeline cache on disk.
//!
//! A [`Shader`] is written once beside its stage: name, SPIR-V, what each binding is and how it is touched, bytes of
//! push constants. A test compares that with what the SPIR-V itself says, and barriers are derived from it, so neither
//! can drift from the GLSL.

use super::access::Access;
use super::caps::Caps;
use super::context::{vulkan, Context};
use super::memory::{Buffer, Garbage, Image, Sampler};
use super::recorder::Use;
use crate::{Error, Result};
use ash::vk;
use std::path::{Path, PathBuf};

/// What a shader's binding is, and how the shader touches it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BindingKind {
    /// A storage buffer.
    Buffer(Access),
    /// A storage image.
    Image(Access),
    /// An image with its sampler.
    Sampled(Access),
}

impl BindingKind {
    pub(crate) fn access(self) -> Access {
        match self {
            BindingKind::Buffer(access) | BindingKind::Image(access) | BindingKind::Sampled(access) => access,
        }
    }

    pub(crate) fn descriptor_type(self) -> vk::DescriptorType {
        match self {
            BindingKind::Buffer(_) => vk::DescriptorType::STORAGE_BUFFER,
            BindingKind::Image(_) => vk::DescriptorType::STORAGE_IMAGE,
            BindingKind::Sampled(_) => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
        }
    }
}

/// A compute shader as it is built in.
#[derive(Debug, Clone, Copy)]
pub struct Shader {
    /// The stage's name: its GLSL file, Rust module, debug label and timer row.
    pub name: &'static str,
    /// The optimised SPIR-V.
    pub spirv: &'static [u8],
    /// Bindings 0, 1, ... of set 0.
    pub bindings: &'static [BindingKind],
    /// Size of the push constant block, 128 bytes at most.
    pub push_bytes: u32,
}

/// A vertex and a fragment shader as they are built in, which share bindings and push constants.
#[derive(Debug, Clone, Copy)]
pub struct RasterShader {
    /// The pass's name: debug label and timer row.
    pub name: &'static str,
    /// The optimised SPIR-V of the vertex shader.
    pub vertex_spirv: &'static [u8],
    /// The optimised SPIR-V of the fragment shader.
    pub fragment_spirv: &'static [u8],
    /// Bindings 0, 1, ... of set 0.
    pub bindings: &'static [BindingKind],
    /// Size of the push constant block, 128 bytes at most.
    pub push_bytes: u32,
}

/// A pipeline that a [`BindingSet`] can be made for.
pub(crate) trait Bindable {
    /// The stage's name.
    fn name(&self) -> &'static str;
    /// What its bindings are.
    fn bindings(&self) -> &'static [BindingKind];
    /// Their layout.
    fn set_layout(&self) -> vk::DescriptorSetLayout;
}

/// The layout of descriptor set 0 with these bindings.
pub(crate) fn set_layout(
    context: &Context,
    bindings: &[BindingKind],
    stages: vk::ShaderStageFlags,
) -> Result<vk::DescriptorSetLayout> {
    let bindings: Vec<_> = (0..)
        .zip(bindings)
        .map(|(binding, kind)| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding)
                .descriptor_type(kind.descriptor_type())
                .descriptor_count(1)
                .stage_flags(stages)
        })
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: a plain creation on a live device; `info` outlives the call.
    unsafe { context.usable()?.create_descriptor_set_layout(&info, None) }
        .map_err(context.failed("vkCreateDescriptorSetLayout"))
}

/// Where the specialisation constants 0, 1, ... lie, 4 bytes each.
pub(crate) fn specialization_entries(constants: &[u32]) -> Vec<vk::SpecializationMapEntry> {
    let entry = |(id, _)| vk::SpecializationMapEntry { constant_id: id, offset: id * 4, size: 4 };
    (0..).zip(constants).map(entry).collect()
}

pub(crate) fn shader_module(context: &Context, name: &str, spirv: &[u8]) -> Result<vk::ShaderModule> {
    let words = ash::util::read_spv(&mut std::io::Cursor::new(spirv))
        .map_err(|e| Error::Device(format!("shader {name} is damaged: {e}")))?;
    let info = vk::ShaderModuleCreateInfo::default().code(&words);
    // SAFETY: the words are SPIR-V from our own compiler run; `info` outlives the call.
    unsafe { context.device().create_shader_module(&info, None) }.map_err(context.failed("vkCreateShaderModule"))
}

/// A compute shader ready to be dispatched. Clones are not offered: keep it where its stage lives.
pub(crate) struct ComputePipeline {
    context: Context,
    pub(crate) shader: Shader,
    pub(crate) handle: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
}

impl ComputePipeline {
    /// Compiles `shader`; takes from milliseconds to seconds, so never while recording a frame.
    ///
    /// # Errors
    /// [`Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, shader: &Shader) -> Result<Self> {
        Self::specialized(context, shader, &[])
    }

    /// As [`ComputePipeline::new`], with `constants` for the specialisation constants 0, 1, ...
    ///
    /// # Errors
    /// [`Error::Vulkan`] when a call fails.
    pub fn specialized(context: &Context, shader: &Shader, constants: &[u32]) -> Result<Self> {
        let device = context.device();
        let entries = specialization_entries(constants);
        let specialization =
            vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(constants));
        // What was made so far is freed when a later call fails: `pipeline` owns it.
        let mut pipeline = ComputePipeline {
            context: context.clone(),
            shader: *shader,
            handle: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
        };
        pipeline.set_layout = set_layout(context, shader.bindings, vk::ShaderStageFlags::COMPUTE)?;
        // SAFETY: plain creations on a live device; every create info outlives its call.
        unsafe {
            let push =
                vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(shader.push_bytes);
            let (layouts, pushes) = ([pipeline.set_layout], [push]);
            let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts);
            if shader.push_bytes > 0 {
                info = info.push_constant_ranges(&pushes);
            }
            pipeline.layout =
                device.create_pipeline_layout(&info, None).map_err(context.failed("vkCreatePipelineLayout"))?;
            let module = shader_module(context, shader.name, shader.spirv)?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(c"main")
                .specialization_info(&specialization);
            let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(pipeline.layout)];
            let cache = context.inner().pipeline_cache;
            let made = context.compile(|| device.create_compute_pipelines(cache, &info, None));
            device.destroy_shader_module(module, None);
            let pipelines = made.map_err(|(_, result)| context.failed("vkCreateComputePipelines")(result))?;
            pipeline.handle = pipelines.first().copied().unwrap_or_default();
        }
        context.name(pipeline.handle, shader.name);
        Ok(pipeline)
    }
}

impl Bindable for ComputePipeline {
    fn name(&self) -> &'static str {
        self.shader.name
    }

    fn bindings(&self) -> &'static [BindingKind] {
        self.shader.bindings
    }

    fn set_layout(&self) -> vk::DescriptorSetLayout {
        self.set_layout
    }
}

impl Drop for ComputePipeline {
    fn drop(&mut self) {
        self.context.bury(Garbage::Pipeline(self.handle, self.layout, self.set_layout));
    }
}

/// A resource given to a binding.
#[derive(Clone)]
pub(crate) enum Bound {
    /// A buffer, whole.
    Buffer(Buffer),
    /// An image, whole.
    Image(Image),
    /// An image, whole, and how it is sampled.
    Sampled(Image, Sampler),
}

impl From<&Buffer> for Bound {
    fn from(buffer: &Buffer) -> Self {
        Bound::Buffer(buffer.clone())
    }
}

impl From<&Image> for Bound {
    fn from(image: &Image) -> Self {
        Bound::Image(image.clone())
    }
}

impl From<(&Image, &Sampler)> for Bound {
    fn from((image, sampler): (&Image, &Sampler)) -> Self {
        Bound::Sampled(image.clone(), sampler.clone())
    }
}

/// The resources of one dispatch or draw, in the order of the shader's bindings. Keeps them alive.
pub(crate) struct BindingSet {
    context: Context,
    pool: vk::DescriptorPool,
    pub(crate) set: vk::DescriptorSet,
    bindings: &'static [BindingKind],
    bound: Vec<Bound>,
}

impl BindingSet {
    /// Binds `bound` to bindings 0, 1, ... of `pipeline`. Allocates, so never while recording a frame.
    ///
    /// # Errors
    /// [`Error::Device`] when the resources do not fit the shader's bindings, [`Error::Parameter`] when one is of another
    /// context, [`Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, pipeline: &impl Bindable, bound: &[Bound]) -> Result<Self> {
        let bindings = pipeline.bindings();
        let fits = bound.len() == bindings.len()
            && bound.iter().zip(bindings).all(|(bound, kind)| {
                matches!(
                    (bound, kind),
                    (Bound::Image(_), BindingKind::Image(_))
                        | (Bound::Buffer(_), BindingKind::Buffer(_))
                        | (Bound::Sampled(..), BindingKind::Sampled(_))
                )
            });
        if !fits {
            return Err(Error::Device(format!("the resources bound to {} do not fit its bindings", pipeline.name())));
        }
        for one in bound {
            let (Bound::Image(image) | Bound::Sampled(image, _)) = one else { continue };
            context.check_same("image", image.context())?;
        }
        let device = context.usable()?;
        let sizes: Vec<_> = bindings
            .iter()
            .map(|kind| vk::DescriptorPoolSize { ty: kind.descriptor_type(), descriptor_count: 1 })
            .collect();
        let mut set = BindingSet {
            context: context.clone(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            bindings,
            bound: bound.to_vec(),
        };
        // SAFETY: plain creations on a live device; the written resources are live and kept by `bound`.
        unsafe {
            let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
            set.pool = device.create_descriptor_pool(&info, None).map_err(context.failed("vkCreateDescriptorPool"))?;
            let layouts = [pipeline.set_layout()];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(set.pool).set_layouts(&layouts);
            let sets = device.allocate_descriptor_sets(&info).map_err(context.failed("vkAllocateDescriptorSets"))?;
            set.set = sets.first().copied().unwrap_or_default();
            for (binding, (bound, kind)) in (0..).zip(bound.iter().zip(bindings)) {
                let buffers;
                let images;
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(set.set)
                    .dst_binding(binding)
                    .descriptor_type(kind.descriptor_type());
                let write = match bound {
                    Bound::Buffer(buffer) => {
                        buffers =
                            [vk::DescriptorBufferInfo { buffer: buffer.handle(), offset: 0, range: vk::WHOLE_SIZE }];
                        write.buffer_info(&buffers)
                    }
                    Bound::Image(image) | Bound::Sampled(image, _) => {
                        let sampler = match bound {
                            Bound::Sampled(_, sampler) => sampler.handle(),
                            _ => vk::Sampler::null(),
                        };
                        images = [vk::DescriptorImageInfo {
                            sampler,
                            image_view: image.view(),
                            image_layout: kind.access().info().layout,
                        }];
                        write.image_info(&images)
                    }
                };
                device.update_descriptor_sets(&[write], &[]);
            }
        }
        Ok(set)
    }

    /// Its resources, and how the shader touches them.
    pub(crate) fn uses(&self) -> impl Iterator<Item = Use<'_>> {
        self.bound.iter().zip(self.bindings).map(|(bound, kind)| match bound {
            Bound::Buffer(buffer) => Use::Buffer(buffer, kind.access()),
            Bound::Image(image) | Bound::Sampled(image, _) => Use::Image(image, kind.access()),
        })
    }
}

impl Drop for BindingSet {
    fn drop(&mut self) {
        self.context.bury(Garbage::DescriptorPool(self.pool));
    }
}

/// The pipeline cache's file: one per device and driver, its header checked before Vulkan sees it.
#[derive(Debug, Clone)]
pub struct PipelineCacheFile {
    path: PathBuf,
    vendor_id: u32,
    device_id: u32,
    uuid: [u8; 16],
}

const CACHE_MAGIC: &[u8; 8] = b"impasto1";
const CACHE_MAX_BYTES: u64 = 64 << 20;

impl PipelineCacheFile {
    /// The file in `dir` that belongs to the device with these `caps`.
    pub fn new(dir: &Path, caps: &Caps) -> Self {
        let hex: String = caps.pipeline_cache_uuid.iter().map(|b| format!("{b:02x}")).collect();
        PipelineCacheFile {
            path: dir.join(format!("pipelines-{hex}.bin")),
            vendor_id: caps.vendor_id,
            device_id: caps.device_id,
            uuid: caps.pipeline_cache_uuid,
        }
    }

    /// Where the file lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The cached data, if the file is whole and belongs to this very device and driver.
    pub fn load(&self) -> Option<Vec<u8>> {
        if std::fs::metadata(&self.path).ok()?.len() > CACHE_MAX_BYTES {
            return None;
        }
        let file = std::fs::read(&self.path).ok()?;
        let (head, data) = file.split_at_checked(16)?;
        let sum = u64::from_le_bytes(head.get(8..16)?.try_into().ok()?);
        let whole = head.starts_with(CACHE_MAGIC) && sum == fnv1a(data);
        // VkPipelineCacheHeaderVersionOne: length, version, vendor, device, UUID.
        let word = |i: usize| data.get(i * 4..i * 4 + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let ours = word(1) == Some(1)
            && word(2) == Some(self.vendor_id)
            && word(3) == Some(self.device_id)
            && data.get(16..32) == Some(&self.uuid[..]);
        (whole && ours).then(|| data.to_vec())
    }

    pub(crate) fn create(file: Option<&Self>, device: &ash::Device) -> Result<vk::PipelineCache> {
        let data = file.and_then(Self::load).unwrap_or_default();
        let info = vk::PipelineCacheCreateInfo::default().initial_data(&data);
        // SAFETY: the data is empty or was written by this driver for this device and is unharmed.
        unsafe { device.create_pipeline_cache(&info, None) }.map_err(vulkan("vkCreatePipelineCache"))
    }

    /// Writes the cache; a cache that cannot be written is only slower next time, so failures are of no consequence.
    pub(crate) fn save(&self, device: &ash::Device, cache: vk::PipelineCache) {
        // SAFETY: the cache is live.
        let Ok(data) = (unsafe { device.get_pipeline_cache_data(cache) }) else { return };
        let mut file = CACHE_MAGIC.to_vec();
        file.extend(fnv1a(&data).to_le_bytes());
        file.extend(data);
        if std::fs::read(&self.path).is_ok_and(|old| old == file) {
            return;
        }
        let Some(dir) = self.path.parent() else { return };
        // Renaming a finished file means that a reader never sees half of one; its name is this context's own.
        let own = (std::process::id(), vk::Handle::as_raw(cache));
        let temporary = self.path.with_extension(format!("{}.{:x}.tmp", own.0, own.1));
        let written = std::fs::create_dir_all(dir)
            .and_then(|()| std::fs::write(&temporary, file))
            .and_then(|()| std::fs::rename(&temporary, &self.path));
        if written.is_err() {
            let _ = std::fs::remove_file(&temporary);
        }
    }
}

/// FNV-1a (Fowler, Noll and Vo): guards against a damaged file, not against an enemy.
fn fnv1a(data: &[u8]) -> u64 {
    data.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}
