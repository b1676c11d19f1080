//! What `--check` makes sure of. A picture that only looks right to the program that made it proves nothing; so the
//! checks go by geometry that neither wgpu nor impasto has a hand in: rays from the eye through pixels.

use crate::host::{Host, Picture};
use crate::scene::{self, Pillar, PICTURE};
use crate::view::View;
use crate::{log, Result};
use glam::{Vec3, Vec4};
use std::path::Path;
use wgpu::hal::api::Vulkan;

/// The layer also compares what command buffers do to each other when they are submitted, which layers of 2023 leave
/// out unless they are told, and later ones do anyway. To be called before the first instance is made.
pub fn watch_submissions() {
    std::env::set_var("VK_LAYER_ENABLES", "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT");
}

/// Shows that the layer watches: writes to one buffer by two command buffers with nothing between them are a fault that
/// only this kind of validation sees, and the kind of fault that a host and a guest make together.
pub fn layer_watches() -> Result<()> {
    let host = Host::new(true)?;
    let buffer = host.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("written twice"),
        size: 256,
        usage: wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let fill = || {
        let mut encoder = host.device.create_command_encoder(&Default::default());
        // SAFETY: a fill of the whole buffer, which outlives the submission.
        unsafe {
            let device = host.device.as_hal::<Vulkan>().map(|device| device.raw_device().clone());
            let buffer = buffer.as_hal::<Vulkan>().map(|buffer| buffer.raw_handle());
            encoder.as_hal_mut::<Vulkan, _, _>(|encoder| {
                if let (Some(device), Some(buffer), Some(encoder)) = (device, buffer, encoder) {
                    device.cmd_fill_buffer(encoder.raw_handle(), buffer, 0, 256, 0);
                }
            });
        }
        encoder.finish()
    };
    let caused = log::provoked(|| {
        host.queue.submit([fill(), fill()]);
    });
    host.device.poll(wgpu::PollType::wait_indefinitely())?;
    match caused {
        0 => Err("the validation layer is not there, or does not validate synchronisation".into()),
        _ => Ok(()),
    }
}

/// A ray from the eye, of any length.
struct Ray {
    eye: Vec3,
    way: Vec3,
}

impl Ray {
    /// Through the middle of a pixel.
    fn through(view: &View, x: u32, y: u32) -> Self {
        let place = |v: u32, size: u32| 2.0 * (v as f32 + 0.5) / size as f32 - 1.0;
        let on_near = Vec4::new(place(x, PICTURE[0]), -place(y, PICTURE[1]), 1.0, 1.0);
        let eye = view.view.inverse().w_axis.truncate();
        Ray { eye, way: (view.projection * view.view).inverse().project_point3(on_near.truncate()) - eye }
    }

    /// The nearest distance from `middle` in units of `radii` that the ray comes to.
    fn passes(&self, middle: Vec3, radii: Vec3) -> f32 {
        let (eye, way) = ((self.eye - middle) / radii, (self.way / radii).normalize());
        (eye - eye.dot(way) * way).length()
    }

    /// Whether the ray meets the pillar, made wider by `room` on all sides.
    fn meets(&self, pillar: &Pillar, room: f32) -> bool {
        let half = pillar.half + room;
        let (a, b) = ((pillar.middle - half - self.eye) / self.way, (pillar.middle + half - self.eye) / self.way);
        a.min(b).max_element() < a.max(b).min_element()
    }
}

/// Pixels at one view.
#[derive(Debug, Default)]
pub struct Counts {
    /// How far the outline of what is painted is from where it must be, pixels: left, top, right, bottom. The largest.
    outline_px: f32,
    /// That the painted object has changed.
    pub painted: usize,
    /// In the midst of the head, with nothing of the host's near them: all of these must have changed.
    midst: usize,
    midst_painted: usize,
    /// Where a pillar stands before the head: none of these may have changed.
    pub hidden: usize,
    hidden_painted: usize,
    /// Where nothing of the head can be: none of these may have changed.
    beside_painted: usize,
    colors: usize,
}

/// The head's midst, and what it lies in, as middle and radii.
const MIDST: [Vec3; 2] = [Vec3::new(0.0, 13.5, -1.0), Vec3::new(4.5, 5.5, 6.0)];
const HULL: [Vec3; 2] = [Vec3::new(0.0, 10.7, 0.3), Vec3::new(12.0, 16.0, 14.0)];

/// Where the head's outermost vertices are in the picture: left, top, right, bottom.
fn outline(view: &View, vertices: &[Vec3]) -> [f32; 4] {
    let to_clip = view.projection * view.view;
    let outermost = |[left, top, right, bottom]: [f32; 4], vertex: &Vec3| {
        let clip = to_clip.project_point3(*vertex);
        let x = (0.5 + 0.5 * clip.x) * PICTURE[0] as f32;
        let y = (0.5 - 0.5 * clip.y) * PICTURE[1] as f32;
        [left.min(x), top.min(y), right.max(x), bottom.max(y)]
    };
    vertices.iter().fold([f32::MAX, f32::MAX, 0.0, 0.0], outermost)
}

/// The vertices of the head's file.
pub fn vertices(obj: &Path) -> Result<Vec<Vec3>> {
    let mut vertices = Vec::new();
    for line in std::fs::read_to_string(obj)?.lines() {
        if let Some(numbers) = line.strip_prefix("v ") {
            let numbers: Vec<f32> =
                numbers.split_whitespace().map(str::parse).collect::<std::result::Result<_, _>>()?;
            vertices.push(Vec3::from_slice(&numbers));
        }
    }
    Ok(vertices)
}

/// Compares the host's own picture at a view with the one that impasto has painted in.
pub fn count(view: &View, plain: &Picture, painted: &Picture, vertices: &[Vec3]) -> Counts {
    let before = scene::pillar_before_the_head();
    let mut counts = Counts::default();
    let mut found = [f32::MAX, f32::MAX, 0.0, 0.0];
    let mut colors = std::collections::BTreeSet::new();
    let pixels = (0..PICTURE[1]).flat_map(|y| (0..PICTURE[0]).map(move |x| (x, y)));
    for (((x, y), plain), painted) in pixels.zip(plain).zip(painted) {
        let ray = Ray::through(view, x, y);
        let changed = plain != painted;
        counts.painted += usize::from(changed);
        if changed {
            colors.insert(painted.map(|v| v >> 3));
            let [left, top, right, bottom] = found;
            let (x, y) = (x as f32, y as f32);
            found = [left.min(x), top.min(y), right.max(x + 1.0), bottom.max(y + 1.0)];
        }
        if ray.passes(HULL[0], HULL[1]) > 1.0 {
            counts.beside_painted += usize::from(changed);
        } else if ray.passes(MIDST[0], MIDST[1]) < 1.0 {
            if ray.meets(&before, -0.2) {
                counts.hidden += 1;
                counts.hidden_painted += usize::from(changed);
            } else if !ray.meets(&before, 0.2) {
                counts.midst += 1;
                counts.midst_painted += usize::from(changed);
            }
        }
    }
    counts.colors = colors.len();
    let apart = found.iter().zip(outline(view, vertices)).map(|(found, expected)| (found - expected).abs());
    counts.outline_px = apart.fold(0.0, f32::max);
    counts
}

impl Counts {
    /// What is wrong with a view, in words.
    pub fn fault(&self) -> Option<String> {
        let wrong = match self {
            _ if self.beside_painted > 0 => "something is painted where the head cannot be",
            _ if self.hidden_painted > 0 => "the head shows through a pillar",
            // Beads pass before it.
            _ if self.midst_painted * 100 < self.midst * 93 => "the head has holes",
            _ if self.hidden == 0 && self.outline_px > 1.5 => "the head is not where it must be",
            _ if self.painted < 8_000 => "the head is too small",
            _ if self.colors < 200 => "the head is not painted, but filled",
            _ => return None,
        };
        Some(format!("{wrong}: {self:?}"))
    }
}
