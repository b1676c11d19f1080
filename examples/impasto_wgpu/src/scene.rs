//! The host's own scene, drawn with nothing but wgpu: a plinth and pillars on a floor, a string of beads, and the last
//! pass that makes the picture. Lengths are centimetres, y is up.

use crate::view::View;
use glam::{Mat3, Mat4, Vec3, Vec4};

/// The picture's size. The scene is drawn twice as large, and the last pass takes the mean of four pixels.
pub const PICTURE: [u32; 2] = [512, 384];
pub const FRAME: [u32; 2] = [2 * PICTURE[0], 2 * PICTURE[1]];

/// Colours are taken as they are stored, as impasto takes those of a strip: nothing is linearised.
pub const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Depth is reversed and without an end, as many engines have it: see `view`.
pub const NEARER_IS_MORE: bool = true;

/// From a surface towards the light: the painted object is lit by the same.
pub const LIGHT: Vec3 = Vec3::new(-0.74, 0.60, 0.30);
const BACKDROP: Vec3 = Vec3::new(0.87, 0.85, 0.80);
/// The plinth's upper side is at y = 0, where the head stands.
const FLOOR: f32 = -7.0;

const SOLIDS: usize = 16;
const BEADS: usize = 48;

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Solid {
    middle: Vec4,
    half: Vec4,
    color: Vec4,
}

/// As in `scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Uniforms {
    to_clip: Mat4,
    right: Vec4,
    up: Vec4,
    eye: Vec4,
    light: Vec4,
    backdrop: Vec4,
    casts: [Vec4; 4],
    solids: [Solid; SOLIDS],
    beads: [Vec4; BEADS],
}

/// A box that stands on the floor.
fn standing(x: f32, z: f32, half: [f32; 2], height: f32, color: [f32; 3]) -> Solid {
    let middle = Vec4::new(x, FLOOR + height / 2.0, z, 0.0);
    Solid { middle, half: Vec4::new(half[0], height / 2.0, half[1], 0.0), color: Vec3::from(color).extend(1.0) }
}

/// The floor comes last: nothing lies in its shadow.
fn solids() -> Vec<Solid> {
    let stone = [0.86, 0.80, 0.70];
    let mut all = vec![standing(0.0, 0.0, [8.0, 11.0], -FLOOR, [0.70, 0.72, 0.74])];
    // The first stands between the head and the camera's middle way.
    for (degrees, away, height) in
        [(68.0_f32, 27.0, 25.0), (128.0, 33.0, 14.0), (192.0, 33.0, 30.0), (246.0, 36.0, 38.0), (312.0, 34.0, 34.0)]
    {
        let (sin, cos) = degrees.to_radians().sin_cos();
        all.push(standing(away * cos, away * sin, [1.8, 1.8], height, stone));
        all.push(standing(away * cos, away * sin, [2.6, 2.6], 1.6, stone));
    }
    let mut floor = standing(0.0, 0.0, [400.0, 400.0], 0.0, [0.88, 0.85, 0.79]);
    floor.middle.y = FLOOR - 1.0;
    floor.half.y = 1.0;
    all.push(floor);
    all
}

/// A ring around the head that leans towards the viewer: part of it before the head, part of it behind.
fn beads() -> Vec<Vec4> {
    let lean = Mat3::from_rotation_z(0.16) * Mat3::from_rotation_x(0.30);
    let bead = |i: usize| {
        let (sin, cos) = (i as f32 / BEADS as f32 * std::f32::consts::TAU).sin_cos();
        (Vec3::new(0.0, 11.5, 0.0) + lean * (14.5 * Vec3::new(cos, 0.0, sin))).extend(0.62)
    };
    (0..BEADS).map(bead).collect()
}

/// The pillar that the camera passes, for the checks.
pub struct Pillar {
    pub middle: Vec3,
    pub half: Vec3,
}

pub fn pillar_before_the_head() -> Pillar {
    let solid = solids()[1];
    Pillar { middle: solid.middle.truncate(), half: solid.half.truncate() }
}

/// Everything that the host has on the device.
pub struct Scene {
    pub color: wgpu::Texture,
    pub depth: wgpu::Texture,
    pub color_view: wgpu::TextureView,
    pub depth_view: wgpu::TextureView,
    picture: wgpu::Texture,
    picture_view: wgpu::TextureView,
    uniforms: wgpu::Buffer,
    bindings: wgpu::BindGroup,
    frame_binding: wgpu::BindGroup,
    solid: wgpu::RenderPipeline,
    bead: wgpu::RenderPipeline,
    develop: wgpu::RenderPipeline,
    solids: Vec<Solid>,
}

impl Scene {
    pub fn new(device: &wgpu::Device) -> Self {
        use wgpu::TextureUsages as U;
        let texture = |label, size: [u32; 2], format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let color = texture("frame", FRAME, COLOR, U::RENDER_ATTACHMENT | U::TEXTURE_BINDING);
        let depth = texture("depth", FRAME, DEPTH, U::RENDER_ATTACHMENT);
        let picture = texture("picture", PICTURE, COLOR, U::RENDER_ATTACHMENT | U::COPY_SRC);
        let (color_view, depth_view, picture_view) = (view(&color), view(&depth), view(&picture));

        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("uniforms"),
            size: size_of::<Uniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let scene = device.create_shader_module(wgpu::include_wgsl!("scene.wgsl"));
        let last = device.create_shader_module(wgpu::include_wgsl!("develop.wgsl"));
        let layout = layout(
            device,
            wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
        );
        let frame_layout = self::layout(
            device,
            wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
        );
        let bind = |layout, resource| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout,
                entries: &[wgpu::BindGroupEntry { binding: 0, resource }],
            })
        };
        let bindings = bind(&layout, uniforms.as_entire_binding());
        let frame_binding = bind(&frame_layout, wgpu::BindingResource::TextureView(&color_view));
        Self {
            solid: pipeline(device, &layout, &scene, ["solid_vertex", "solid_fragment"], true),
            bead: pipeline(device, &layout, &scene, ["bead_vertex", "bead_fragment"], true),
            develop: pipeline(device, &frame_layout, &last, ["corners", "develop"], false),
            solids: solids(),
            color,
            depth,
            color_view,
            depth_view,
            picture,
            picture_view,
            uniforms,
            bindings,
            frame_binding,
        }
    }

    /// Tells where the frame is seen from.
    pub fn look(&self, queue: &wgpu::Queue, view: &View) {
        let from_view = view.view.inverse();
        let mut uniforms = Uniforms {
            to_clip: view.projection * view.view,
            right: from_view.x_axis,
            up: from_view.y_axis,
            eye: from_view.w_axis,
            light: LIGHT.normalize().extend(self.solids.len() as f32 - 1.0),
            backdrop: BACKDROP.extend(1.0),
            casts: [
                Vec4::new(0.0, 13.0, -1.0, 0.0),
                Vec4::new(7.2, 8.5, 9.3, 1.0),
                Vec4::new(0.0, 4.5, 3.5, 0.0),
                Vec4::new(4.8, 5.5, 5.5, 1.0),
            ],
            solids: bytemuck::Zeroable::zeroed(),
            beads: bytemuck::Zeroable::zeroed(),
        };
        uniforms.solids[..self.solids.len()].copy_from_slice(&self.solids);
        uniforms.beads.copy_from_slice(&beads());
        queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
    }

    /// The first half of a frame: all that is the host's own.
    pub fn draw_solids(&self, encoder: &mut wgpu::CommandEncoder) {
        let [r, g, b] = BACKDROP.to_array().map(f64::from);
        let mut pass = self.pass(
            encoder,
            "solids",
            wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
            wgpu::LoadOp::Clear(0.0),
        );
        pass.set_pipeline(&self.solid);
        pass.set_bind_group(0, &self.bindings, &[]);
        pass.draw(0..36, 0..self.solids.len() as u32);
    }

    /// The second half: beads into the frame that holds the painted object by now, before and behind it.
    pub fn draw_beads(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = self.pass(encoder, "beads", wgpu::LoadOp::Load, wgpu::LoadOp::Load);
        pass.set_pipeline(&self.bead);
        pass.set_bind_group(0, &self.bindings, &[]);
        pass.draw(0..4, 0..BEADS as u32);
    }

    fn pass<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        label: &str,
        color: wgpu::LoadOp<wgpu::Color>,
        depth: wgpu::LoadOp<f32>,
    ) -> wgpu::RenderPass<'a> {
        let store = wgpu::StoreOp::Store;
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: color, store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth_view,
                depth_ops: Some(wgpu::Operations { load: depth, store }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// Makes the picture of the frame, and copies it to `readback`.
    pub fn develop(&self, encoder: &mut wgpu::CommandEncoder, readback: &wgpu::Buffer) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("develop"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.picture_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.develop);
        pass.set_bind_group(0, &self.frame_binding, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * PICTURE[0]), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            self.picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: readback, layout },
            self.picture.size(),
        );
    }
}

fn layout(device: &wgpu::Device, ty: wgpu::BindingType) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty,
            count: None,
        }],
    })
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    module: &wgpu::ShaderModule,
    [vertex, fragment]: [&str; 2],
    in_space: bool,
) -> wgpu::RenderPipeline {
    let strip = vertex == "bead_vertex";
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(&device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(layout)],
            immediate_size: 0,
        })),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState {
            topology: if strip {
                wgpu::PrimitiveTopology::TriangleStrip
            } else {
                wgpu::PrimitiveTopology::TriangleList
            },
            cull_mode: Some(wgpu::Face::Back),
            ..Default::default()
        },
        depth_stencil: in_space.then(|| wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options: Default::default(),
            targets: &[Some(COLOR.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
