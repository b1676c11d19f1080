//! Passes recorded into a command buffer that is given: label, timer and barriers at one choke point.
//!
//! # What is synchronised, and where
//! Every resource remembers how it was last touched in recording order. [`Recorder::pass`] looks at what the next pass
//! declares, derives the barriers ([`super::ResourceState::transition`]) and records them as one
//! `vkCmdPipelineBarrier` before the pass. Command buffers must therefore run in the order in which they were recorded,
//! on one queue. Inside a pass nothing is synchronised: its dispatches must not depend on each other.

use super::access::{Access, Barrier, ResourceState};
use super::context::Context;
use super::memory::{Buffer, Image};
use super::pipeline::{BindingSet, ComputePipeline};
use super::timing::PassTimer;
use ash::vk;
use std::ops::Range;

/// One resource of a pass and how the pass touches it.
#[derive(Clone, Copy)]
pub(crate) enum Use<'a> {
    /// A buffer.
    Buffer(&'a Buffer, Access),
    /// An image.
    Image(&'a Image, Access),
}

impl Use<'_> {
    /// Whether both touch one resource in the same way.
    pub(crate) fn same(&self, other: &Use<'_>) -> bool {
        match (self, other) {
            (Use::Buffer(a, x), Use::Buffer(b, y)) => a.id() == b.id() && x == y,
            (Use::Image(a, x), Use::Image(b, y)) => a.id() == b.id() && x == y,
            _ => false,
        }
    }
}

/// Records passes into one command buffer. Never submits, waits, allocates GPU memory or compiles.
pub struct Recorder<'a> {
    context: &'a Context,
    commands: vk::CommandBuffer,
    timer: Option<&'a mut PassTimer>,
    omit_barriers: bool,
    area: Option<vk::Rect2D>,
}

impl<'a> Recorder<'a> {
    /// Records into `commands`, timing passes with `timer` where one is given.
    ///
    /// # Safety
    /// `commands` must be a live primary command buffer of the context's device and queue family, in the recording
    /// state, outside of a render pass, used by nobody else while the recorder lives. Command buffers must be
    /// submitted in the order in which they were recorded, to one queue. Only what was made from this context may be
    /// recorded, and must live until it has run (dropping it is fine: it is destroyed when the frame is safe).
    pub unsafe fn new(context: &'a Context, commands: vk::CommandBuffer, timer: Option<&'a mut PassTimer>) -> Self {
        let mut recorder = Recorder { context, commands, timer, omit_barriers: false, area: None };
        if let Some(timer) = recorder.timer.as_deref_mut() {
            timer.reset();
        }
        recorder
    }

    /// The context that is recorded for.
    pub fn context(&self) -> &Context {
        self.context
    }

    /// Draws from here on into this part of images, as (x, y) and (width, height) in pixels, as if they were no larger;
    /// what lies around it is undefined, or kept by passes that draw over what is there. `None`: into all of them.
    /// Compute shaders pay no heed to it.
    pub(crate) fn draw_within(&mut self, area: Option<[(u32, u32); 2]>) {
        self.area = area.map(|[(x, y), (width, height)]| vk::Rect2D {
            offset: vk::Offset2D { x: x as i32, y: y as i32 },
            extent: vk::Extent2D { width, height },
        });
    }

    /// What of a picture of this size is drawn into; its part of [`Recorder::draw_within`].
    pub(crate) fn drawn_area(&self, [width, height]: [u32; 2]) -> vk::Rect2D {
        let all = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let Some(area) = self.area else { return all };
        let within = |at: i32, size: u32, most: u32| size.min(most.saturating_sub(at as u32)).max(1);
        let extent = vk::Extent2D {
            width: within(area.offset.x, area.extent.width, width),
            height: within(area.offset.y, area.extent.height, height),
        };
        vk::Rect2D { extent, ..area }
    }

    /// Leaves out every barrier from here on. Only for the test that shows that validation would notice.
    #[doc(hidden)]
    pub fn omit_barriers(&mut self) {
        self.omit_barriers = true;
    }

    /// Records one pass: barriers for `uses`, then `body` between label and timestamps.
    pub(crate) fn pass(
        &mut self,
        name: &'static str,
        uses: &[Use<'_>],
        body: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) {
        let context = self.context;
        let device = context.device();
        // Before the barriers, so that waiting for what is needed counts as part of the pass.
        let timed = self.timer.as_deref_mut().and_then(|timer| timer.begin(context, self.commands, name));
        self.barriers(uses);
        let label = context.inner().debug_utils.as_ref();
        if let Some(debug) = label {
            // Names of passes are literals of ours and short; one with a NUL inside simply goes unlabelled.
            let text = std::ffi::CString::new(name).unwrap_or_default();
            // SAFETY: the command buffer is recording (`new`).
            unsafe {
                debug.cmd_begin_debug_utils_label(self.commands, &vk::DebugUtilsLabelEXT::default().label_name(&text));
            }
        }
        body(device, self.commands);
        if let (Some(timer), Some(slot)) = (self.timer.as_deref_mut(), timed) {
            timer.end(context, self.commands, slot);
        }
        if let Some(debug) = label {
            // SAFETY: as above; closes the label opened there.
            unsafe { debug.cmd_end_debug_utils_label(self.commands) };
        }
    }

    fn barriers(&mut self, uses: &[Use<'_>]) {
        let mut src = vk::PipelineStageFlags::empty();
        let mut dst = vk::PipelineStageFlags::empty();
        // Buffers share one memory barrier; images have their own for the layout.
        let mut memory = vk::MemoryBarrier::default();
        let mut any_memory = false;
        let mut images: Vec<vk::ImageMemoryBarrier<'_>> = Vec::with_capacity(uses.len());
        for (i, one) in uses.iter().enumerate() {
            debug_assert!(
                uses[..i].iter().all(|other| match (other, one) {
                    (Use::Buffer(a, _), Use::Buffer(b, _)) => a.id() != b.id(),
                    (Use::Image(a, _), Use::Image(b, _)) => a.id() != b.id(),
                    _ => true,
                }),
                "a pass declares each resource once"
            );
            let barrier: Option<Barrier> = match one {
                Use::Buffer(buffer, access) => buffer.state().transition(*access, false),
                Use::Image(image, access) => image.state().transition(*access, true),
            };
            let Some(barrier) = barrier else { continue };
            src |= barrier.src_stages;
            dst |= barrier.dst_stages;
            match one {
                Use::Buffer(..) => {
                    memory.src_access_mask |= barrier.src_access;
                    memory.dst_access_mask |= barrier.dst_access;
                    any_memory = true;
                }
                Use::Image(image, _) => images.push(image_barrier(image, &barrier)),
            }
        }
        if src.is_empty() || self.omit_barriers {
            return;
        }
        let memory = [memory];
        let memory = if any_memory { &memory[..] } else { &[] };
        // SAFETY: the command buffer is recording outside of a render pass (`new`); the images are live.
        unsafe {
            let none = vk::DependencyFlags::empty();
            self.context.device().cmd_pipeline_barrier(self.commands, src, dst, none, memory, &[], &images);
        }
    }

    /// One dispatch of `pipeline` as a pass of its own, with `push` as its push constants.
    /// Barriers follow from the shader's table of bindings.
    pub(crate) fn dispatch<P: bytemuck::NoUninit>(
        &mut self,
        pipeline: &ComputePipeline,
        set: &BindingSet,
        push: &P,
        groups: [u32; 3],
    ) {
        if !groups.contains(&0) {
            self.compute(pipeline, set, push, None, |device, commands| {
                // SAFETY: `compute` has bound all that the dispatch needs.
                unsafe { device.cmd_dispatch(commands, groups[0], groups[1], groups[2]) };
            });
        }
    }

    /// As [`Recorder::dispatch`], but the numbers of workgroups are three words of a buffer that shaders have written,
    /// from byte `offset` on, a multiple of 4.
    pub(crate) fn dispatch_indirect<P: bytemuck::NoUninit>(
        &mut self,
        pipeline: &ComputePipeline,
        set: &BindingSet,
        push: &P,
        (groups, offset): (&Buffer, u64),
    ) {
        debug_assert!(offset % 4 == 0 && offset + 12 <= groups.bytes(), "{}", pipeline.shader.name);
        self.compute(pipeline, set, push, Some(Use::Buffer(groups, Access::Indirect)), |device, commands| {
            // SAFETY: `compute` has bound all that the dispatch needs, and made the words visible; the buffer, which is
            // no binding of this stage, has them.
            unsafe { device.cmd_dispatch_indirect(commands, groups.handle(), offset) };
        });
    }

    /// A pass with a pipeline, its set and push constants bound.
    fn compute<P: bytemuck::NoUninit>(
        &mut self,
        pipeline: &ComputePipeline,
        set: &BindingSet,
        push: &P,
        more: Option<Use<'_>>,
        dispatch: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) {
        let shader = &pipeline.shader;
        let bytes = bytemuck::bytes_of(push);
        debug_assert_eq!(bytes.len(), shader.push_bytes as usize, "push constants of {}", shader.name);
        let mut uses: Vec<Use<'_>> = Vec::with_capacity(shader.bindings.len() + 1);
        for one in set.uses() {
            // A stage may be given one resource for two of its bindings.
            if !uses.iter().any(|other| other.same(&one)) {
                uses.push(one);
            }
        }
        uses.extend(more);
        self.pass(shader.name, &uses, |device, commands| {
            let point = vk::PipelineBindPoint::COMPUTE;
            // SAFETY: pipeline and set are live, made for each other (`BindingSet::new`), and the set's resources are
            // in the state that the barriers above have brought them to.
            unsafe {
                device.cmd_bind_pipeline(commands, point, pipeline.handle);
                device.cmd_bind_descriptor_sets(commands, point, pipeline.layout, 0, &[set.set], &[]);
                if !bytes.is_empty() {
                    device.cmd_push_constants(commands, pipeline.layout, vk::ShaderStageFlags::COMPUTE, 0, bytes);
                }
            }
            dispatch(device, commands);
        });
    }

    /// Leaves an image as its next user wants it: in a layout, with what was written to it visible to these stages and
    /// accesses. For a host that takes over an image from here.
    pub fn hand_over(&mut self, image: &Image, to: ResourceState) {
        let barrier = image.state().hand_over(to);
        if self.omit_barriers {
            return;
        }
        let barriers = [image_barrier(image, &barrier)];
        let (device, none) = (self.context.device(), vk::DependencyFlags::empty());
        let (src, dst) = (barrier.src_stages, barrier.dst_stages);
        // SAFETY: the command buffer is recording outside of a render pass (`new`); the image is live.
        unsafe { device.cmd_pipeline_barrier(self.commands, src, dst, none, &[], &[], &barriers) };
    }

    /// Copies all of `from` to the start of `to`.
    pub(crate) fn copy_buffer(&mut self, name: &'static str, from: &Buffer, to: &Buffer) {
        let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: from.bytes().min(to.bytes()) }];
        let uses = [Use::Buffer(from, Access::TransferRead), Use::Buffer(to, Access::TransferWrite)];
        self.pass(name, &uses, |device, commands| {
            // SAFETY: both buffers are live and at least `size` bytes large.
            unsafe { device.cmd_copy_buffer(commands, from.handle(), to.handle(), &region) };
        });
    }

    /// Copies all texels of `from` to `to`, which has its size and format.
    pub(crate) fn copy_image(&mut self, name: &'static str, from: &Image, to: &Image) {
        let uses = [Use::Image(from, Access::TransferRead), Use::Image(to, Access::TransferDiscard)];
        let [width, height, depth] = from.size_px();
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            layer_count: 1,
            ..Default::default()
        };
        let region = vk::ImageCopy {
            src_subresource: layers,
            dst_subresource: layers,
            extent: vk::Extent3D { width, height, depth },
            ..Default::default()
        };
        let layouts = [Access::TransferRead.info().layout, Access::TransferDiscard.info().layout];
        self.pass(name, &uses, |device, commands| {
            let (source, target) = (from.handle(), to.handle());
            // SAFETY: both images are live, of one size, of a colour format, and in these layouts.
            unsafe { device.cmd_copy_image(commands, source, layouts[0], target, layouts[1], &[region]) };
        });
    }

    /// Writes `data` to the start of a buffer, from the command buffer itself: for small things that change with every
    /// frame. Its length is a multiple of 4 bytes, and no more than the buffer has.
    pub(crate) fn update_buffer(&mut self, name: &'static str, buffer: &Buffer, data: &[u8]) {
        /// The most that one command may carry.
        const MOST_BYTES: usize = 65_536;
        let data = &data[..data.len().min(buffer.bytes() as usize) / 4 * 4];
        self.pass(name, &[Use::Buffer(buffer, Access::TransferWrite)], |device, commands| {
            for (part, bytes) in (0..).zip(data.chunks(MOST_BYTES)) {
                // SAFETY: the buffer is live, made for transfers, and at least as large as `data`; each part is a
                // multiple of 4 bytes and within the limit.
                unsafe { device.cmd_update_buffer(commands, buffer.handle(), part * MOST_BYTES as u64, bytes) };
            }
        });
    }

    /// Fills an image with the tightly packed texels in `from`.
    pub(crate) fn upload_image(&mut self, name: &'static str, from: &Buffer, to: &Image) {
        let uses = [Use::Buffer(from, Access::TransferRead), Use::Image(to, Access::TransferDiscard)];
        self.pass(name, &uses, |device, commands| {
            let layout = Access::TransferDiscard.info().layout;
            // SAFETY: `from` holds the image's texels: callers upload exactly one image's worth.
            unsafe { device.cmd_copy_buffer_to_image(commands, from.handle(), to.handle(), layout, &[to.whole()]) };
        });
    }

    /// Fills `slices` of a 3D image with the tightly packed texels in `from`; the others stay as they are.
    pub(crate) fn upload_slices(&mut self, name: &'static str, from: &Buffer, to: &Image, slices: Range<u32>) {
        let uses = [Use::Buffer(from, Access::TransferRead), Use::Image(to, Access::TransferWrite)];
        let mut region = to.whole();
        region.image_offset.z = slices.start as i32;
        region.image_extent.depth = slices.len() as u32;
        self.pass(name, &uses, |device, commands| {
            let layout = Access::TransferWrite.info().layout;
            // SAFETY: `from` holds the texels of these slices, and the image has them: `Uploads` has checked both.
            unsafe { device.cmd_copy_buffer_to_image(commands, from.handle(), to.handle(), layout, &[region]) };
        });
    }

    /// Copies whole images, each to one of the same size and format.
    pub(crate) fn copy_images(&mut self, name: &'static str, pairs: &[(&Image, &Image)]) {
        let read = pairs.iter().map(|(from, _)| Use::Image(from, Access::TransferRead));
        let written = pairs.iter().map(|(_, to)| Use::Image(to, Access::TransferDiscard));
        self.pass(name, &read.chain(written).collect::<Vec<_>>(), |device, commands| {
            let (read, written) = (Access::TransferRead.info().layout, Access::TransferDiscard.info().layout);
            for (from, to) in pairs {
                let whole = from.whole();
                let region = vk::ImageCopy::default()
                    .src_subresource(whole.image_subresource)
                    .dst_subresource(whole.image_subresource)
                    .extent(whole.image_extent);
                // SAFETY: both images are live, in these layouts, and alike: callers make the one after the other.
                unsafe { device.cmd_copy_image(commands, from.handle(), read, to.handle(), written, &[region]) };
            }
        });
    }

    /// Copies an image's texels, tightly packed, to `to`.
    pub(crate) fn download_image(&mut self, name: &'static str, from: &Image, to: &Buffer) {
        let uses = [Use::Image(from, Access::TransferRead), Use::Buffer(to, Access::TransferWrite)];
        self.pass(name, &uses, |device, commands| {
            let layout = Access::TransferRead.info().layout;
            // SAFETY: `to` was made large enough for the image's texels.
            unsafe { device.cmd_copy_image_to_buffer(commands, from.handle(), layout, to.handle(), &[from.whole()]) };
        });
        // What the host reads after its wait must be made visible to it.
        self.barriers(&[Use::Buffer(to, Access::HostRead)]);
    }

    /// Copies a buffer to a readback buffer and makes it visible to the host.
    pub(crate) fn download_buffer(&mut self, name: &'static str, from: &Buffer, to: &Buffer) {
        self.copy_buffer(name, from, to);
        self.barriers(&[Use::Buffer(to, Access::HostRead)]);
    }

    /// Sets every texel of the images to zero.
    pub(crate) fn clear_images(&mut self, name: &'static str, images: &[&Image]) {
        self.fill_images(name, images, 0);
    }

    /// Sets every channel of every texel of the images, which hold integers unless it is 0, to `value`.
    pub(crate) fn fill_images(&mut self, name: &'static str, images: &[&Image], value: u32) {
        let uses: Vec<_> = images.iter().map(|image| Use::Image(image, Access::TransferDiscard)).collect();
        self.pass(name, &uses, |device, commands| {
            let layout = Access::TransferDiscard.info().layout;
            for image in images {
                let color = vk::ClearColorValue { uint32: [value; 4] };
                // SAFETY: the image is live, of a colour format and in the transfer layout.
                unsafe { device.cmd_clear_color_image(commands, image.handle(), layout, &color, &[image.range()]) };
            }
        });
    }
}

fn image_barrier(image: &Image, barrier: &Barrier) -> vk::ImageMemoryBarrier<'static> {
    vk::ImageMemoryBarrier::default()
        .src_access_mask(barrier.src_access)
        .dst_access_mask(barrier.dst_access)
        .old_layout(barrier.old_layout)
        .new_layout(barrier.new_layout)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image.handle())
        .subresource_range(image.range())
}
