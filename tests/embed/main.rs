//! Effects inside of a host that knows nothing of the library: prepared beside its frames, recorded with one call, laid
//! over its own picture.

#[path = "../common/mod.rs"]
mod common;
mod composite;
mod faults;
mod frames;
#[path = "../host/mod.rs"]
mod host;
mod limits;
mod memory;
mod threads;

use ash::vk;
use common::noise;
use host::{Host, HostImage};
use impasto::embed::{Effect, EffectDesc, EffectFrame, EffectPaint, Method};
use impasto::gpu::{Context, Image, ImageDesc, Recorder, ResourceState};
use impasto::paint::{TextureDifference, Trajectory};
use impasto::scene::{Camera, Framing, Lights, Mesh, MeshOptions, Moment, Pose, Vec3};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::repair::RepairParams;
use impasto::technique::aligned::{AlignedFrame, LevelParams};
use impasto::technique::dependent::{DependentParams, View};
use impasto::technique::image::ImageParams;
use impasto::technique::object::ObjectParams;
use impasto::technique::ShadeRange;
use std::sync::Arc;

const SIZE: (u32, u32) = (90, 70);
const QUILT: QuiltParams = QuiltParams { block_px: 16, overlap_px: 4, tolerance: 0.1, seed: 5, tileable: false };
const VIEWS: [View; 2] = [View { yaw_deg: 20.0, pitch_deg: 10.0 }, View { yaw_deg: 200.0, pitch_deg: 0.0 }];
const VIEW_PX: u32 = 512;

/// A context on the host's device, which goes before that does.
fn borrow(host: &Host) -> Context {
    // SAFETY: the tests drop the context before the host's device, when all work is done.
    unsafe { Context::from_host(host.lent()) }.expect("a context")
}

fn recorder(context: &Context, commands: vk::CommandBuffer) -> Recorder<'_> {
    // SAFETY: the host's command buffers are begun, submitted in order and waited for.
    unsafe { Recorder::new(context, commands, None) }
}

fn assert_silent(messages: &[String]) {
    assert!(messages.is_empty(), "validation: {}", messages.join("\n"));
}

/// A ball of 512 triangles: all shades, and seen whole from few views.
fn ball() -> Arc<Mesh> {
    // The octahedron's eight sides, each cut into `CUTS` x `CUTS` triangles and blown up.
    const CUTS: u32 = 8;
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for side in 0..8 {
        let sign = [0, 1, 2].map(|bit| if side >> bit & 1 == 0 { 1.0 } else { -1.0 });
        let outwards = sign.iter().product::<f32>() > 0.0;
        let first = positions.len() as u32;
        for row in 0..=CUTS {
            for column in 0..=CUTS - row {
                let corner = [row, column, CUTS - row - column].map(|part| part as f32);
                let point = Vec3::from_array([0, 1, 2].map(|axis| sign[axis] * corner[axis])).normalize();
                positions.push(point.to_array());
            }
        }
        let at = |row: u32, column: u32| first + row * (CUTS + 1) - row * row.saturating_sub(1) / 2 + column;
        for row in 0..CUTS {
            for column in 0..CUTS - row {
                let mut triangles = vec![[at(row, column), at(row + 1, column), at(row, column + 1)]];
                if column + row + 1 < CUTS {
                    triangles.push([at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)]);
                }
                for [a, b, c] in triangles {
                    indices.extend(if outwards { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    let normals = positions.clone();
    let built = Mesh::build(positions, Some(normals), &indices, &[], &MeshOptions::default());
    Arc::new(built.expect("a mesh").mesh)
}

fn paint() -> EffectPaint {
    let pixels = noise(96, 64, 4).iter().map(|p| [0, 1, 2].map(|k| f32::from(p[k]) / 255.0 - 0.5)).collect();
    let texture = TextureDifference::from_pixels(96, 64, pixels).expect("a difference");
    let trajectory = Trajectory::from_colors(vec![[0.1, 0.2, 0.3], [0.9, 0.8, 0.6]]).expect("a trajectory");
    EffectPaint { texture, trajectory }
}

/// Every technique, in all ways that remember something.
fn methods() -> [(&'static str, Method); 5] {
    let params = ImageParams { quilt: QUILT, ..ImageParams::default() };
    let levels = LevelParams { levels: 3, size_px: 64, quilt: QUILT, ..LevelParams::default() };
    let dependent = DependentParams { quilt: QUILT, ..DependentParams::default() };
    [
        ("object", Method::Object { params: ObjectParams::default(), range: ShadeRange::default() }),
        ("image", Method::Image { params, carry: None }),
        ("image, carried", Method::Image { params, carry: Some(RepairParams::default()) }),
        ("aligned", Method::Aligned { levels, frame: AlignedFrame::default(), follow: true }),
        (
            "dependent",
            Method::Dependent { views: VIEWS.to_vec(), view_px: VIEW_PX, lights: Lights::default(), params: dependent },
        ),
    ]
}

/// A ball that turns by 3 degrees a frame.
fn moment(mesh: &Mesh, frame: u32) -> Moment {
    let aspect = SIZE.0 as f32 / SIZE.1 as f32;
    let camera = Camera::framing(mesh, &Framing::default(), aspect).expect("a camera");
    let turn = Pose::new(3.0 * (frame % 40) as f32, Vec3::Y, Vec3::ZERO, Vec3::ZERO).expect("a pose");
    Moment { poses: vec![turn], ..Moment::at_rest(camera, Lights::default()) }
}

/// Prepares an effect piece by piece, as many frames as it takes; how many it took.
fn prepare(host: &Host, context: &Context, effect: &mut Effect, frame: &mut u64) -> u32 {
    let mut recorded = 0;
    let mut done = 0.0;
    while !effect.progress().ready {
        *frame += 1;
        // The host has waited for the frame before.
        context.advance(*frame, *frame - 1);
        host.run(|commands| {
            let progress = effect.prepare(&mut recorder(context, commands)).expect("a preparation");
            assert!(progress.done >= done && progress.done <= 1.0, "{progress:?} after {done}");
            done = progress.done;
        });
        recorded += 1;
        assert!(recorded < 100_000, "the preparation does not end: {:?}", effect.progress());
    }
    recorded
}

/// An effect that is ready.
fn ready(host: &Host, context: &Context, desc: EffectDesc, frame: &mut u64) -> Effect {
    let mut effect = Effect::new(context, desc).expect("an effect");
    prepare(host, context, &mut effect, frame);
    effect
}

/// Records a frame of an effect, submits, waits; its picture.
fn picture(host: &Host, context: &Context, effect: &mut Effect, frame: &EffectFrame<'_>) -> Vec<u8> {
    host.run(|commands| effect.record(&mut recorder(context, commands), frame).expect("a frame"));
    let picture = effect.picture().expect("a picture");
    host.read_image(picture.handle(), picture.layout(), SIZE)
}

/// The host's image as the library sees it, just written by [`Host::write_image`].
fn wrapped(context: &Context, image: &HostImage) -> Image {
    let desc = ImageDesc { size_px: [image.size.0, image.size.1, 1], format: image.format, usage: image.usage };
    // SAFETY: the host's image outlives the context, and was left in this state.
    unsafe { Image::from_host(context, image.image, image.view, &desc, written()) }
}

fn written() -> ResourceState {
    ResourceState::from_host(
        vk::PipelineStageFlags::TRANSFER,
        vk::AccessFlags::TRANSFER_WRITE,
        vk::ImageLayout::TRANSFER_DST_OPTIMAL,
    )
}

fn desc(mesh: &Arc<Mesh>, method: &Method) -> EffectDesc {
    EffectDesc { seed: 3, piece: 2_000_000, ..EffectDesc::new(mesh.clone(), paint(), method.clone(), SIZE) }
}
