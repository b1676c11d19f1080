//! Explicit render passes, framebuffers and raster pipelines.
//!
//! Attachments are cleared at the start, unless they are kept, and stored at the end. Their layouts are brought about
//! by the recorder's barriers before the pass, so the render pass itself changes none.

use super::access::Access;
use super::context::Context;
use super::memory::{Buffer, Garbage, Image};
use super::pipeline::{
    set_layout, shader_module, specialization_entries, Bindable, BindingKind, BindingSet, RasterShader,
};
use super::recorder::{Recorder, Use};
use crate::Result;
use ash::vk;
use std::ops::Range;

/// One attachment of a render pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Attachment {
    /// Its format.
    pub format: vk::Format,
    /// What it is for.
    pub role: Role,
}

/// What an attachment is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// Drawn to.
    Color,
    /// Drawn over what is there, by its straight alpha.
    ColorOver,
    /// Depth, which must be the last attachment: the nearest is drawn.
    Depth,
    /// Depth that was drawn before, the last attachment too: what lies behind it is drawn, and it stays as it is.
    DepthBefore,
    /// Depth of a host's, the last attachment too: what lies before it, or as near, is drawn, and written to it.
    /// `reversed` says that nearer is more.
    DepthOver {
        /// Nearer is more.
        reversed: bool,
    },
}

impl Attachment {
    fn layout(self) -> vk::ImageLayout {
        self.access().info().layout
    }

    fn is_depth(self) -> bool {
        !matches!(self.role, Role::Color | Role::ColorOver)
    }

    fn access(self) -> Access {
        match self.role {
            Role::Color => Access::ColorAttachment,
            Role::Depth => Access::DepthAttachment,
            Role::ColorOver => Access::ColorBlend,
            Role::DepthBefore | Role::DepthOver { .. } => Access::DepthTest,
        }
    }

    fn load_op(self) -> vk::AttachmentLoadOp {
        match self.role {
            Role::Color | Role::Depth => vk::AttachmentLoadOp::CLEAR,
            Role::ColorOver | Role::DepthBefore | Role::DepthOver { .. } => vk::AttachmentLoadOp::LOAD,
        }
    }
}

/// A render pass of one subpass that stores all of its attachments.
pub(crate) struct RenderPass {
    context: Context,
    handle: vk::RenderPass,
    attachments: Vec<Attachment>,
}

impl RenderPass {
    /// Makes a render pass with these attachments, colour first.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, name: &str, attachments: &[Attachment]) -> Result<Self> {
        let descriptions: Vec<_> = attachments
            .iter()
            .map(|a| {
                vk::AttachmentDescription::default()
                    .format(a.format)
                    .samples(vk::SampleCountFlags::TYPE_1)
                    .load_op(a.load_op())
                    .store_op(vk::AttachmentStoreOp::STORE)
                    // A host's depth may come with a stencil, which is not ours.
                    .stencil_load_op(a.load_op())
                    .stencil_store_op(vk::AttachmentStoreOp::STORE)
                    .initial_layout(a.layout())
                    .final_layout(a.layout())
            })
            .collect();
        let reference = |i: usize, a: &Attachment| vk::AttachmentReference { attachment: i as u32, layout: a.layout() };
        let (mut colors, mut depth) = (Vec::new(), None);
        for (i, a) in attachments.iter().enumerate() {
            if a.is_depth() {
                depth = Some(reference(i, a));
            } else {
                colors.push(reference(i, a));
            }
        }
        let mut subpass = vk::SubpassDescription::default()
            .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
            .color_attachments(&colors);
        if let Some(depth) = &depth {
            subpass = subpass.depth_stencil_attachment(depth);
        }
        let subpasses = [subpass];
        let info = vk::RenderPassCreateInfo::default().attachments(&descriptions).subpasses(&subpasses);
        // SAFETY: a plain creation on a live device.
        let handle = unsafe { context.usable()?.create_render_pass(&info, None) }
            .map_err(context.failed("vkCreateRenderPass"))?;
        context.name(handle, name);
        Ok(RenderPass { context: context.clone(), handle, attachments: attachments.to_vec() })
    }
}

impl Drop for RenderPass {
    fn drop(&mut self) {
        self.context.bury(Garbage::RenderPass(self.handle));
    }
}

/// The images that a render pass draws to. Keeps them alive.
pub(crate) struct Framebuffer {
    context: Context,
    handle: vk::Framebuffer,
    images: Vec<Image>,
    extent: vk::Extent2D,
}

impl Framebuffer {
    /// Binds `images`, all of one size, to the attachments of `pass`.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for an image of another context; [`crate::Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, pass: &RenderPass, images: &[&Image]) -> Result<Self> {
        images.iter().try_for_each(|image| context.check_same("image", image.context()))?;
        let size = images.first().map_or([1, 1, 1], |image| image.size_px());
        let views: Vec<_> = images.iter().map(|image| image.view()).collect();
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(pass.handle)
            .attachments(&views)
            .width(size[0])
            .height(size[1])
            .layers(1);
        // SAFETY: the views are live and kept so by `images`.
        let handle = unsafe { context.usable()?.create_framebuffer(&info, None) }
            .map_err(context.failed("vkCreateFramebuffer"))?;
        Ok(Framebuffer {
            context: context.clone(),
            handle,
            images: images.iter().map(|&image| image.clone()).collect(),
            extent: vk::Extent2D { width: size[0], height: size[1] },
        })
    }
}

impl Framebuffer {
    /// What it draws to.
    pub fn images(&self) -> &[Image] {
        &self.images
    }

    /// Width and height, pixels.
    pub fn size_px(&self) -> [u32; 2] {
        [self.extent.width, self.extent.height]
    }
}

impl Drop for Framebuffer {
    fn drop(&mut self) {
        self.context.bury(Garbage::Framebuffer(self.handle));
    }
}

/// One value of a vertex.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VertexAttribute {
    /// Its format; location is its place in the list.
    pub format: vk::Format,
    /// Its place in the vertex, bytes.
    pub offset_bytes: u32,
}

/// How to make a [`RasterPipeline`]: triangles, with the depth test that the pass's attachment asks for.
pub(crate) struct RasterDesc<'a> {
    /// Its shaders.
    pub shader: RasterShader,
    /// Size of a vertex, bytes; 0 for shaders that need none.
    pub vertex_bytes: u32,
    /// What a vertex holds.
    pub attributes: &'a [VertexAttribute],
    /// Leave out triangles that show their back.
    pub cull_back: bool,
    /// The fragment shader's specialisation constants 0, 1, ...
    pub constants: &'a [u32],
}

/// A vertex and a fragment shader that share bindings and push constants, ready to draw triangles.
pub(crate) struct RasterPipeline {
    context: Context,
    shader: RasterShader,
    handle: vk::Pipeline,
    layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
}

const STAGES: vk::ShaderStageFlags =
    vk::ShaderStageFlags::from_raw(vk::ShaderStageFlags::VERTEX.as_raw() | vk::ShaderStageFlags::FRAGMENT.as_raw());

/// The vertices and indices (u32) that draws take.
pub(crate) struct Geometry<'a> {
    pub vertices: &'a Buffer,
    pub indices: &'a Buffer,
}

/// One draw of a pass: its resources, its push constants, and which indices it takes (without a geometry: vertices).
pub(crate) struct Draw<'a, P> {
    pub set: Option<&'a BindingSet>,
    pub push: P,
    pub range: Range<u32>,
}

impl RasterPipeline {
    /// Compiles the pipeline for `pass`.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] when a call fails.
    pub fn new(context: &Context, pass: &RenderPass, desc: &RasterDesc<'_>) -> Result<Self> {
        let mut pipeline = RasterPipeline {
            context: context.clone(),
            shader: desc.shader,
            handle: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
        };
        pipeline.set_layout = set_layout(context, desc.shader.bindings, STAGES)?;
        let layouts = [pipeline.set_layout];
        let pushes = [vk::PushConstantRange::default().stage_flags(STAGES).size(desc.shader.push_bytes)];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts).push_constant_ranges(&pushes);
        // SAFETY: a plain creation on a live device; `pipeline` frees it if a later call fails.
        pipeline.layout = unsafe { context.device().create_pipeline_layout(&info, None) }
            .map_err(context.failed("vkCreatePipelineLayout"))?;
        pipeline.handle = pipeline.build(pass, desc)?;
        context.name(pipeline.handle, desc.shader.name);
        Ok(pipeline)
    }

    fn build(&self, pass: &RenderPass, desc: &RasterDesc<'_>) -> Result<vk::Pipeline> {
        let device = self.context.device();
        let vertex = shader_module(&self.context, desc.shader.name, desc.shader.vertex_spirv)?;
        let fragment = match shader_module(&self.context, desc.shader.name, desc.shader.fragment_spirv) {
            Ok(module) => module,
            Err(error) => {
                // SAFETY: nothing uses the module.
                unsafe { device.destroy_shader_module(vertex, None) };
                return Err(error);
            }
        };
        let stage =
            |flag, module| vk::PipelineShaderStageCreateInfo::default().stage(flag).module(module).name(c"main");
        let entries = specialization_entries(desc.constants);
        let specialization =
            vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(desc.constants));
        let stages = [
            stage(vk::ShaderStageFlags::VERTEX, vertex),
            stage(vk::ShaderStageFlags::FRAGMENT, fragment).specialization_info(&specialization),
        ];
        let bindings = [vk::VertexInputBindingDescription::default().stride(desc.vertex_bytes)];
        let attributes: Vec<_> = (0..)
            .zip(desc.attributes)
            .map(|(location, a)| {
                vk::VertexInputAttributeDescription::default()
                    .location(location)
                    .format(a.format)
                    .offset(a.offset_bytes)
            })
            .collect();
        let mut input = vk::PipelineVertexInputStateCreateInfo::default();
        if !attributes.is_empty() {
            input = input.vertex_binding_descriptions(&bindings).vertex_attribute_descriptions(&attributes);
        }
        let assembly =
            vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .cull_mode(if desc.cull_back { vk::CullModeFlags::BACK } else { vk::CullModeFlags::NONE })
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .line_width(1.0);
        let samples =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
        // Whether depth is written, and what is drawn.
        let test = pass.attachments.iter().find_map(|a| match a.role {
            Role::Color | Role::ColorOver => None,
            Role::Depth => Some((true, vk::CompareOp::LESS)),
            Role::DepthBefore => Some((false, vk::CompareOp::GREATER)),
            Role::DepthOver { reversed: false } => Some((true, vk::CompareOp::LESS_OR_EQUAL)),
            Role::DepthOver { reversed: true } => Some((true, vk::CompareOp::GREATER_OR_EQUAL)),
        });
        let mut depth = vk::PipelineDepthStencilStateCreateInfo::default();
        if let Some((write, compare)) = test {
            depth = depth.depth_test_enable(true).depth_write_enable(write).depth_compare_op(compare);
        }
        let colors = pass.attachments.iter().filter(|a| !a.is_depth());
        let blends: Vec<_> = colors.map(|a| color_blend(a.role)).collect();
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
        let dynamics = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamics);
        let info = [vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(self.layout)
            .render_pass(pass.handle)];
        // SAFETY: every pointer in `info` outlives the call; the modules are not needed after it.
        let made = unsafe {
            let cache = self.context.inner().pipeline_cache;
            let made = self.context.compile(|| device.create_graphics_pipelines(cache, &info, None));
            device.destroy_shader_module(vertex, None);
            device.destroy_shader_module(fragment, None);
            made
        };
        let pipelines = made.map_err(|(_, result)| self.context.failed("vkCreateGraphicsPipelines")(result))?;
        Ok(pipelines.first().copied().unwrap_or_default())
    }
}

/// How what is drawn meets what is there.
fn color_blend(role: Role) -> vk::PipelineColorBlendAttachmentState {
    let (all, one) = (vk::ColorComponentFlags::RGBA, vk::BlendFactor::ONE);
    let over = vk::BlendFactor::ONE_MINUS_SRC_ALPHA;
    vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(all)
        .blend_enable(role == Role::ColorOver)
        .src_color_blend_factor(vk::BlendFactor::SRC_ALPHA)
        .dst_color_blend_factor(over)
        .src_alpha_blend_factor(one)
        .dst_alpha_blend_factor(over)
}

impl Bindable for RasterPipeline {
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

impl Drop for RasterPipeline {
    fn drop(&mut self) {
        self.context.bury(Garbage::Pipeline(self.handle, self.layout, self.set_layout));
    }
}

impl Recorder<'_> {
    /// Records one render pass that makes all of `draws` into `target`, cleared to zero and the far depth first.
    pub(crate) fn draw<P: bytemuck::NoUninit>(
        &mut self,
        pass: &RenderPass,
        target: &Framebuffer,
        pipeline: &RasterPipeline,
        geometry: Option<&Geometry<'_>>,
        draws: &[Draw<'_, P>],
    ) {
        let bytes = pipeline.shader.push_bytes as usize;
        debug_assert_eq!(size_of::<P>(), bytes, "push constants of {}", pipeline.shader.name);
        let mut uses = Vec::with_capacity(8);
        if let Some(geometry) = geometry {
            uses.push(Use::Buffer(geometry.vertices, Access::VertexInput));
            uses.push(Use::Buffer(geometry.indices, Access::VertexInput));
        }
        uses.extend(target.images.iter().zip(&pass.attachments).map(|(image, a)| Use::Image(image, a.access())));
        for one in draws.iter().filter_map(|draw| draw.set).flat_map(BindingSet::uses) {
            // Draws share some of their resources.
            if !uses.iter().any(|other| other.same(&one)) {
                uses.push(one);
            }
        }
        let clears: Vec<_> = pass
            .attachments
            .iter()
            .map(|a| {
                if a.is_depth() {
                    vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 1.0, stencil: 0 } }
                } else {
                    vk::ClearValue { color: vk::ClearColorValue { uint32: [0; 4] } }
                }
            })
            .collect();
        let area = self.drawn_area([target.extent.width, target.extent.height]);
        let viewport = vk::Viewport {
            x: area.offset.x as f32,
            y: area.offset.y as f32,
            width: area.extent.width as f32,
            height: area.extent.height as f32,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        self.pass(pipeline.shader.name, &uses, |device, commands| {
            let begin = vk::RenderPassBeginInfo::default()
                .render_pass(pass.handle)
                .framebuffer(target.handle)
                .render_area(area)
                .clear_values(&clears);
            let point = vk::PipelineBindPoint::GRAPHICS;
            // SAFETY: all objects are live and fit each other; the barriers have brought the attachments to the
            // layouts that the render pass starts from; indices lie within the vertices (checked by the mesh).
            unsafe {
                device.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE);
                device.cmd_bind_pipeline(commands, point, pipeline.handle);
                device.cmd_set_viewport(commands, 0, &[viewport]);
                device.cmd_set_scissor(commands, 0, &[area]);
                if let Some(geometry) = geometry {
                    device.cmd_bind_vertex_buffers(commands, 0, &[geometry.vertices.handle()], &[0]);
                    device.cmd_bind_index_buffer(commands, geometry.indices.handle(), 0, vk::IndexType::UINT32);
                }
                for Draw { set, push, range } in draws {
                    device.cmd_push_constants(commands, pipeline.layout, STAGES, 0, bytemuck::bytes_of(push));
                    if let Some(set) = set {
                        device.cmd_bind_descriptor_sets(commands, point, pipeline.layout, 0, &[set.set], &[]);
                    }
                    let count = range.len() as u32;
                    if geometry.is_some() {
                        device.cmd_draw_indexed(commands, count, 1, range.start, 0, 0);
                    } else {
                        device.cmd_draw(commands, count, 1, range.start, 0);
                    }
                }
                device.cmd_end_render_pass(commands);
            }
        });
    }
}
