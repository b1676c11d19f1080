//! The table of accesses, and the barriers that follow from it: pure data, tested without a GPU.
//!
//! A pass declares how it touches each resource as an [`Access`]. A [`ResourceState`] remembers what happened to one
//! resource so far; [`ResourceState::transition`] compares the two and answers with the [`Barrier`] that is needed, or
//! none. The rules are those of the Vulkan memory model: a read after a write needs the write made available to the
//! reader's stage (once), a write after reads needs only that the reads have run, a write after a write needs both, and
//! a change of image layout is itself a write.

use ash::vk;

/// How a pass touches a buffer or an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Copied or blitted from.
    TransferRead,
    /// Copied, filled or cleared to; the rest of the content stays.
    TransferWrite,
    /// Filled or cleared as a whole: what was in it before may be thrown away.
    TransferDiscard,
    /// Read by a compute shader as a storage buffer or a storage image.
    ComputeRead,
    /// Written by a compute shader (a storage buffer or storage image) without regard to what was there.
    ComputeWrite,
    /// Read by a compute shader through a sampler.
    ComputeSampled,
    /// Read and written by a compute shader.
    ComputeReadWrite,
    /// Read by a fragment shader as a storage image.
    FragmentRead,
    /// Read by a fragment shader through a sampler.
    FragmentSampled,
    /// Read by draw calls as vertices or indices.
    VertexInput,
    /// Read as the number of workgroups of a dispatch.
    Indirect,
    /// Rendered to as a colour attachment that is cleared first.
    ColorAttachment,
    /// Rendered over as a colour attachment: what is there stays, or is blended with.
    ColorBlend,
    /// Rendered to and tested against as a depth attachment that is cleared first.
    DepthAttachment,
    /// Tested against as a depth attachment whose content stays, but where a pass writes to it.
    DepthTest,
    /// Read by the host after a wait for the submission.
    HostRead,
}

/// What an access means to Vulkan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct AccessInfo {
    pub stages: vk::PipelineStageFlags,
    pub access: vk::AccessFlags,
    pub layout: vk::ImageLayout,
    pub writes: bool,
    pub discards: bool,
}

impl Access {
    pub(crate) fn info(self) -> AccessInfo {
        use vk::{AccessFlags as A, ImageLayout as L, PipelineStageFlags as S};
        let depth = S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS;
        let depth_access = A::DEPTH_STENCIL_ATTACHMENT_READ | A::DEPTH_STENCIL_ATTACHMENT_WRITE;
        let color_access = A::COLOR_ATTACHMENT_READ | A::COLOR_ATTACHMENT_WRITE;
        let (stages, access, layout, writes, discards) = match self {
            Access::TransferRead => (S::TRANSFER, A::TRANSFER_READ, L::TRANSFER_SRC_OPTIMAL, false, false),
            Access::TransferWrite => (S::TRANSFER, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL, true, false),
            Access::TransferDiscard => (S::TRANSFER, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL, true, true),
            Access::ComputeRead => (S::COMPUTE_SHADER, A::SHADER_READ, L::GENERAL, false, false),
            Access::ComputeSampled => (S::COMPUTE_SHADER, A::SHADER_READ, L::SHADER_READ_ONLY_OPTIMAL, false, false),
            Access::ComputeWrite => (S::COMPUTE_SHADER, A::SHADER_WRITE, L::GENERAL, true, false),
            Access::ComputeReadWrite => (S::COMPUTE_SHADER, A::SHADER_READ | A::SHADER_WRITE, L::GENERAL, true, false),
            Access::FragmentRead => (S::FRAGMENT_SHADER, A::SHADER_READ, L::GENERAL, false, false),
            Access::FragmentSampled => (S::FRAGMENT_SHADER, A::SHADER_READ, L::SHADER_READ_ONLY_OPTIMAL, false, false),
            Access::VertexInput => {
                (S::VERTEX_INPUT, A::VERTEX_ATTRIBUTE_READ | A::INDEX_READ, L::UNDEFINED, false, false)
            }
            Access::Indirect => (S::DRAW_INDIRECT, A::INDIRECT_COMMAND_READ, L::UNDEFINED, false, false),
            Access::ColorAttachment => {
                (S::COLOR_ATTACHMENT_OUTPUT, color_access, L::COLOR_ATTACHMENT_OPTIMAL, true, true)
            }
            Access::ColorBlend => (S::COLOR_ATTACHMENT_OUTPUT, color_access, L::COLOR_ATTACHMENT_OPTIMAL, true, false),
            Access::DepthAttachment => (depth, depth_access, L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL, true, true),
            // A render pass stores what it has loaded, which counts as a write.
            Access::DepthTest => (depth, depth_access, L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL, true, false),
            Access::HostRead => (S::HOST, A::HOST_READ, L::GENERAL, false, false),
        };
        AccessInfo { stages, access, layout, writes, discards }
    }

    /// Its place in a set of accesses.
    fn bit(self) -> u32 {
        1 << self as u32
    }
}

/// A dependency between what happened to a resource and what happens next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Barrier {
    /// Stages that must have run.
    pub src_stages: vk::PipelineStageFlags,
    /// Writes that must be made available.
    pub src_access: vk::AccessFlags,
    /// Stages that wait.
    pub dst_stages: vk::PipelineStageFlags,
    /// Accesses that the writes are made visible to.
    pub dst_access: vk::AccessFlags,
    /// The image layout before; `UNDEFINED` where the content may be thrown away.
    pub old_layout: vk::ImageLayout,
    /// The image layout after.
    pub new_layout: vk::ImageLayout,
}

/// What happened to one resource so far, in recording order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResourceState {
    write_stages: vk::PipelineStageFlags,
    write_access: vk::AccessFlags,
    read_stages: vk::PipelineStageFlags,
    /// The ways of reading that the last write is visible to already, a bit for each [`Access`].
    visible: u32,
    layout: vk::ImageLayout,
}

impl Default for ResourceState {
    fn default() -> Self {
        Self::fresh()
    }
}

impl ResourceState {
    /// A resource that nothing has touched.
    pub const fn fresh() -> Self {
        ResourceState {
            write_stages: vk::PipelineStageFlags::empty(),
            write_access: vk::AccessFlags::empty(),
            read_stages: vk::PipelineStageFlags::empty(),
            visible: 0,
            layout: vk::ImageLayout::UNDEFINED,
        }
    }

    /// A resource that a host hands over: last used by `stages` and `access`, an image lying in `layout`. Or one that a
    /// host is handed, and will use so next ([`super::Recorder::hand_over`]).
    pub fn from_host(stages: vk::PipelineStageFlags, access: vk::AccessFlags, layout: vk::ImageLayout) -> Self {
        ResourceState { write_stages: stages, write_access: access, layout, ..Self::fresh() }
    }

    /// As [`ResourceState::from_host`], for a use that the table knows: stages, accesses and layout of `access`.
    pub fn of(access: Access) -> Self {
        let info = access.info();
        Self::from_host(info.stages, info.access, info.layout)
    }

    /// The layout that an image lies in after all that was recorded.
    pub fn layout(&self) -> vk::ImageLayout {
        self.layout
    }

    /// Gives the image up to a host, and answers with the barrier that has to stand before its use.
    pub(crate) fn hand_over(&mut self, to: ResourceState) -> Barrier {
        let mut src_stages = self.write_stages | self.read_stages;
        if src_stages.is_empty() {
            src_stages = vk::PipelineStageFlags::TOP_OF_PIPE;
        }
        let barrier = Barrier {
            src_stages,
            src_access: self.write_access,
            dst_stages: to.write_stages,
            dst_access: to.write_access,
            old_layout: self.layout,
            new_layout: to.layout,
        };
        *self = to;
        barrier
    }

    /// Notes `next`, and answers with the barrier that has to stand before it, if one has to.
    /// `image` says whether layouts count.
    pub fn transition(&mut self, next: Access, image: bool) -> Option<Barrier> {
        let info = next.info();
        let relayout = image && self.layout != info.layout;
        let written = !self.write_stages.is_empty();
        let seen = self.visible & next.bit() != 0;
        let needed = relayout || if info.writes { written || !self.read_stages.is_empty() } else { written && !seen };
        let barrier = needed.then(|| {
            // A write waits for the reads; a pure read waits only for the write. With nothing before it (a first
            // layout change) there is nothing to wait for.
            let mut src_stages = self.write_stages;
            if info.writes || relayout {
                src_stages |= self.read_stages;
            }
            if src_stages.is_empty() {
                src_stages = vk::PipelineStageFlags::TOP_OF_PIPE;
            }
            let old_layout = if info.discards { vk::ImageLayout::UNDEFINED } else { self.layout };
            Barrier {
                src_stages,
                src_access: self.write_access,
                dst_stages: info.stages,
                dst_access: info.access,
                old_layout,
                new_layout: if image { info.layout } else { vk::ImageLayout::UNDEFINED },
            }
        });
        if image {
            self.layout = info.layout;
        }
        if info.writes {
            self.write_stages = info.stages;
            self.write_access = info.access;
            self.read_stages = vk::PipelineStageFlags::empty();
            self.visible = 0;
        } else {
            if relayout {
                // The layout change is the last write now; it is visible to this read only.
                self.write_stages = info.stages;
                self.write_access = vk::AccessFlags::empty();
                self.read_stages = vk::PipelineStageFlags::empty();
                self.visible = 0;
            }
            self.read_stages |= info.stages;
            self.visible |= next.bit();
        }
        barrier
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vk::{AccessFlags as A, ImageLayout as L, PipelineStageFlags as S};

    fn states(accesses: &[Access], image: bool) -> Vec<Option<Barrier>> {
        let mut state = ResourceState::fresh();
        accesses.iter().map(|&access| state.transition(access, image)).collect()
    }

    #[test]
    fn first_use_of_a_buffer_needs_nothing() {
        for access in [Access::TransferWrite, Access::ComputeRead, Access::VertexInput] {
            assert_eq!(states(&[access], false), [None]);
        }
    }

    #[test]
    fn read_after_write_waits_once_per_reader() {
        let got =
            states(&[Access::ComputeWrite, Access::ComputeRead, Access::ComputeRead, Access::TransferRead], false);
        let first = got[1].expect("read after write");
        assert_eq!((first.src_stages, first.src_access), (S::COMPUTE_SHADER, A::SHADER_WRITE));
        assert_eq!((first.dst_stages, first.dst_access), (S::COMPUTE_SHADER, A::SHADER_READ));
        assert_eq!(got[2], None, "the write is visible to this stage already");
        let copy = got[3].expect("another stage has not seen the write");
        assert_eq!((copy.src_access, copy.dst_access), (A::SHADER_WRITE, A::TRANSFER_READ));
    }

    #[test]
    fn what_is_visible_of_a_write_is_not_visible_of_the_next() {
        let got =
            states(&[Access::ComputeWrite, Access::ComputeRead, Access::ComputeWrite, Access::ComputeRead], false);
        assert_eq!(got[3], got[1]);
        assert!(got[3].is_some());
    }

    #[test]
    fn write_after_read_waits_for_every_reader() {
        let got =
            states(&[Access::TransferWrite, Access::ComputeRead, Access::TransferRead, Access::ComputeWrite], false);
        let war = got[3].expect("write after reads");
        assert!(war.src_stages.contains(S::COMPUTE_SHADER | S::TRANSFER));
    }

    #[test]
    fn write_after_write_waits() {
        let got = states(&[Access::ComputeReadWrite, Access::ComputeReadWrite], false);
        assert_eq!(got[1].map(|b| b.src_access), Some(A::SHADER_READ | A::SHADER_WRITE));
    }

    #[test]
    fn images_change_layout_and_discards_forget_content() {
        let got = states(
            &[Access::TransferDiscard, Access::ComputeRead, Access::TransferRead, Access::ColorAttachment],
            true,
        );
        let clear = got[0].expect("from undefined");
        assert_eq!((clear.old_layout, clear.new_layout), (L::UNDEFINED, L::TRANSFER_DST_OPTIMAL));
        assert_eq!(clear.src_stages, S::TOP_OF_PIPE);
        let read = got[1].expect("layout change");
        assert_eq!((read.old_layout, read.new_layout), (L::TRANSFER_DST_OPTIMAL, L::GENERAL));
        let copy = got[2].expect("a read in another layout waits for the reads before it");
        assert!(copy.src_stages.contains(S::COMPUTE_SHADER));
        assert_eq!(got[3].map(|b| b.old_layout), Some(L::UNDEFINED));
    }

    #[test]
    fn a_host_is_handed_what_it_wants_and_counts_as_its_last_user() {
        let mut state = ResourceState::fresh();
        state.transition(Access::ColorAttachment, true);
        let sampled = ResourceState::from_host(S::FRAGMENT_SHADER, A::SHADER_READ, L::SHADER_READ_ONLY_OPTIMAL);
        assert_eq!(ResourceState::of(Access::FragmentSampled), sampled);
        let handed = state.hand_over(sampled);
        assert_eq!((handed.src_stages, handed.dst_stages), (S::COLOR_ATTACHMENT_OUTPUT, S::FRAGMENT_SHADER));
        assert!(handed.src_access.contains(A::COLOR_ATTACHMENT_WRITE));
        assert_eq!((handed.old_layout, handed.new_layout), (L::COLOR_ATTACHMENT_OPTIMAL, L::SHADER_READ_ONLY_OPTIMAL));
        let again = state.transition(Access::ColorAttachment, true).expect("the host has read it");
        assert_eq!(again.src_stages, S::FRAGMENT_SHADER);
    }

    #[test]
    fn what_is_drawn_over_is_kept() {
        let got = states(&[Access::TransferWrite, Access::ColorBlend, Access::ColorBlend], true);
        let over = got[1].expect("another layout");
        assert_eq!((over.old_layout, over.new_layout), (L::TRANSFER_DST_OPTIMAL, L::COLOR_ATTACHMENT_OPTIMAL));
        assert_eq!(got[2].map(|b| (b.src_access, b.old_layout)), Some((over.dst_access, over.new_layout)));
    }

    #[test]
    fn depth_is_read_by_compute_after_it_was_drawn() {
        let got = states(&[Access::DepthAttachment, Access::ComputeSampled, Access::TransferRead], true);
        let read = got[1].expect("read after drawing");
        assert_eq!(
            (read.old_layout, read.new_layout),
            (L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL, L::SHADER_READ_ONLY_OPTIMAL)
        );
        assert!(read.src_stages.contains(S::LATE_FRAGMENT_TESTS));
        assert!(read.src_access.contains(A::DEPTH_STENCIL_ATTACHMENT_WRITE));
        assert_eq!((read.dst_stages, read.dst_access), (S::COMPUTE_SHADER, A::SHADER_READ));
        assert!(got[2].expect("another layout").src_stages.contains(S::COMPUTE_SHADER));
    }

    #[test]
    fn a_layout_change_for_a_read_is_ordered_before_other_readers() {
        let mut state = ResourceState::fresh();
        state.transition(Access::ColorAttachment, true);
        state.transition(Access::ComputeRead, true);
        let host = state.transition(Access::HostRead, true).expect("host has not seen it");
        assert_eq!(host.old_layout, L::GENERAL);
        assert!(host.src_stages.contains(S::COMPUTE_SHADER));
    }
}
