//! The ways of painting on the command line: a group of flags for each technique.

use super::failure::{Failure, Result};
use super::image_frames::Continuity;
use super::quilting::{Quilting, SearchFlag};
use super::report::number;
use super::session::Session;
use super::values::{finite, vector};
use clap::{Args, ValueEnum};
use impasto::scene::{Mesh, Vec3};
use impasto::synthesis::params::QuiltParams;
use impasto::technique::aligned::{AlignedFrame, LevelBlend, LevelParams, Tileable};
use impasto::technique::dependent::{default_views, DependentParams, View};
use impasto::technique::image::ImageParams;
use impasto::technique::object::{CoordinateParams, ObjectParams, Orientation, SeamPolicy, StripRepeat};
use serde_json::{json, Value};
use std::path::Path;

/// Ways of painting.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TechniqueName {
    /// Texture synthesised over the picture, colour by shade: best for stills
    #[default]
    Image,
    /// Texture pinned to the surface, its place across the strip by shade: nothing to prepare
    Object,
    /// Texture in the plane of the picture, a prepared texture for every level of shade
    Aligned,
    /// Textures prepared for important views of the model, blended between them
    Dependent,
}

/// Flags of the techniques.
#[derive(Args, Debug, Clone)]
pub struct TechniqueOptions {
    /// How far a block's place in the strip may be from its shade's, in blocks; fractions allowed [default: 1/16 of the
    /// strip's width, 1 to 4 blocks; the thesis: 4]
    #[arg(long, value_name = "BLOCKS", allow_negative_numbers = true, help_heading = "Image and dependent")]
    k: Option<f32>,
    /// Spread the model's own range of shade over the whole strip
    #[arg(long)]
    levels: bool,
    #[command(flatten)]
    object: ObjectFlags,
    #[command(flatten)]
    pub aligned: LevelFlags,
    /// Texels of the texture to a pixel, 0.05 to 4: 2 makes marks half as large
    #[arg(long, value_name = "SCALE", value_parser = finite, default_value_t = 1.0, allow_hyphen_values = true,
          help_heading = "Aligned")]
    density: f32,
    /// Where the texture lies, in pixels
    #[arg(long, value_name = "X,Y", value_parser = pair, default_value = "0,0", allow_hyphen_values = true,
          help_heading = "Aligned")]
    offset: [f32; 2],
    #[command(flatten)]
    dependent: DependentFlags,
    /// How textures are blended: with the contrast that blending takes given back, or plainly as the hardware does
    #[arg(long, value_enum, default_value_t, help_heading = "Aligned and dependent")]
    blend: Blend,
}

#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Object")]
struct ObjectFlags {
    /// How often the strip repeats over the model, 0.01 to 1000
    #[arg(long, value_name = "BETA", default_value_t = 4.0, allow_negative_numbers = true)]
    repeats: f32,
    /// By how much the strip's rows are shifted at random from vertex to vertex, in repeats: 0 to 1
    #[arg(long, value_name = "GAMMA", default_value_t = 0.0, allow_negative_numbers = true)]
    variation: f32,
    /// Along what the strip repeats: x, y, z, a vector X,Y,Z, or a file of lines "x,y,z,dx,dy,dz", a direction for the
    /// vertices that are nearest to each point
    #[arg(long, value_name = "AXIS|FILE", default_value = "y", allow_hyphen_values = true)]
    along: String,
    /// What happens between disconnected pieces
    #[arg(long, value_enum, default_value_t)]
    seams: Seams,
    /// How the strip goes on above and below itself
    #[arg(long, value_enum, default_value_t)]
    repeat: Repeat,
    /// Where the mapping loses the paint, on flat faces and where the light falls along the strip
    #[arg(long, value_enum, default_value_t)]
    flat: Flat,
}

/// How the levels of view-aligned projection are prepared.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Aligned")]
pub struct LevelFlags {
    /// Levels of shade that the strip is cut into, 1 to 64 [default: 8, or those of a prepared paint]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    level_count: Option<u32>,
    /// Side of the texture of each level in pixels, 16 to 2048 [default: 512, or that of a prepared paint]
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    level_size: Option<u32>,
    /// How the textures are made to repeat
    #[arg(long, value_enum, default_value_t)]
    level_tiling: Tiling,
}

#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Dependent")]
struct DependentFlags {
    /// Important views as YAW:PITCH,YAW:PITCH,... in degrees [default: 14 around the model]
    #[arg(long, value_name = "VIEWS", value_parser = views, allow_hyphen_values = true)]
    views: Option<std::sync::Arc<Vec<View>>>,
    /// Side of the texture of each view in pixels, 512 to 4096
    #[arg(long, value_name = "PX", default_value_t = 512, allow_negative_numbers = true)]
    view_size: u32,
    /// By how many degrees a frame the view that chose a face's texture follows the camera while the face is in sight,
    /// 0 to 180; for animations
    #[arg(long, value_name = "DEGREES", value_parser = finite, default_value_t = DependentParams::default().follow_deg,
          allow_hyphen_values = true)]
    follow: f32,
}

/// [`LevelBlend`] as a flag.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Blend {
    /// Contrast kept
    #[default]
    Contrast,
    /// As the hardware blends
    Linear,
}

/// [`SeamPolicy`] as a flag.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Seams {
    /// The strip goes on from the closest vertex
    #[default]
    Carry,
    /// Each piece begins somewhere at random
    Fresh,
}

/// [`StripRepeat`] as a flag.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Repeat {
    /// Its upper edge is cut into its lower one
    #[default]
    Wrap,
    /// Every other repeat is mirrored
    Mirror,
}

/// [`ObjectParams::keep_paint`] as a flag.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Flat {
    /// The strip is laid on from three sides there
    #[default]
    Keep,
    /// One colour spreads, as in the thesis
    Lose,
}

/// [`Tileable`] as a flag.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Tiling {
    /// Blocks are quilted around the edges as well
    #[default]
    Wrap,
    /// The texture is blended with itself under a circular mask, as in the thesis
    Mask,
}

/// What was chosen.
pub struct Chosen {
    /// The technique with its own parameters.
    pub technique: Technique,
    /// How to quilt.
    pub quilt: QuiltParams,
    /// How to search for it.
    pub search: SearchFlag,
    /// How far from its shade a block may come.
    pub k: Option<f32>,
    /// Whether to spread the model's own range of shade.
    pub levels: bool,
}

/// A technique with its parameters.
pub enum Technique {
    /// Image-based texture synthesis: how a frame keeps to the one before.
    Image(Continuity),
    /// Object-based texture mapping.
    Object(ObjectParams),
    /// View-aligned projection: how its levels are prepared, how its frame is drawn.
    Aligned(LevelParams, AlignedFrame),
    /// View-dependent interpolation: its views, the size of their textures, the rest.
    Dependent(Vec<View>, u32, DependentParams),
}

impl TechniqueOptions {
    /// Checks what can be checked before anything is loaded, and puts the parameters together. `prepared` is the number
    /// and size of the levels of a paint that was prepared before.
    pub fn choose(
        &self,
        name: TechniqueName,
        quilting: &Quilting,
        mesh: &Mesh,
        prepared: Option<(u32, u32)>,
    ) -> Result<Chosen> {
        let quilt = quilting.params(false);
        let technique = match name {
            TechniqueName::Image => Technique::Image(Continuity::Anew),
            TechniqueName::Object => Technique::Object(self.object.params(quilting.seed, mesh)?),
            TechniqueName::Aligned => {
                let blend = match self.blend {
                    Blend::Contrast => LevelBlend::Contrast,
                    Blend::Linear => LevelBlend::Linear,
                };
                let frame =
                    AlignedFrame { density: self.density, offset_px: self.offset, blend, ..AlignedFrame::default() };
                frame.check()?;
                Technique::Aligned(self.aligned.params(quilt, prepared)?, frame)
            }
            TechniqueName::Dependent => {
                let views = self.dependent.views.as_deref().cloned().unwrap_or_else(default_views);
                if !(512..=4096).contains(&self.dependent.view_size) {
                    let size = self.dependent.view_size;
                    return Err(Failure::new(format!("--view-size is {size}, but must be from 512 to 4096 pixels")));
                }
                let keep_contrast = self.blend == Blend::Contrast;
                let follow_deg = self.dependent.follow;
                let params =
                    DependentParams { quilt, k: self.k, keep_contrast, follow_deg, ..DependentParams::default() };
                params.check()?;
                Technique::Dependent(views, self.dependent.view_size, params)
            }
        };
        Ok(Chosen { technique, quilt, search: quilting.search, k: self.k, levels: self.levels })
    }

    /// The parameters of image-based synthesis.
    pub fn image(&self, quilting: &Quilting) -> ImageParams {
        ImageParams { quilt: quilting.params(false), k: self.k, ..ImageParams::default() }
    }

    /// Adds the flags that count for a technique to the report.
    pub fn report(&self, technique: TechniqueName, session: &mut Session) {
        let name = |value: &dyn std::fmt::Debug| format!("{value:?}").to_lowercase();
        session.parameter("technique", name(&technique));
        session.parameter("levels", self.levels);
        match technique {
            TechniqueName::Image => session.parameter("k", self.k.map_or(Value::Null, number)),
            TechniqueName::Object => {
                let object = &self.object;
                session.parameter("repeats", number(object.repeats));
                session.parameter("variation", number(object.variation));
                session.parameter("along", object.along.clone());
                session.parameter("seams", name(&object.seams));
                session.parameter("repeat", name(&object.repeat));
                session.parameter("flat", name(&object.flat));
            }
            TechniqueName::Aligned => {
                self.aligned.report(session);
                session.parameter("density", number(self.density));
                session.parameter("offset", json!(self.offset.map(number)));
                session.parameter("blend", name(&self.blend));
            }
            TechniqueName::Dependent => {
                let views = self.dependent.views.as_deref().cloned().unwrap_or_else(default_views);
                let views: Vec<Value> =
                    views.iter().map(|view| json!([number(view.yaw_deg), number(view.pitch_deg)])).collect();
                session.parameter("k", self.k.map_or(Value::Null, number));
                session.parameter("views", views);
                session.parameter("view_size", self.dependent.view_size);
                session.parameter("follow", number(self.dependent.follow));
                session.parameter("blend", name(&self.blend));
            }
        }
    }
}

impl ObjectFlags {
    fn params(&self, seed: u32, mesh: &Mesh) -> Result<ObjectParams> {
        let coordinates = CoordinateParams {
            repeats: self.repeats,
            variation: self.variation,
            orientation: orientation(&self.along, mesh)?,
            seams: match self.seams {
                Seams::Carry => SeamPolicy::Carry,
                Seams::Fresh => SeamPolicy::Fresh,
            },
            seed,
        };
        let repeat = match self.repeat {
            Repeat::Wrap => StripRepeat::Wrap,
            Repeat::Mirror => StripRepeat::Mirror,
        };
        Ok(ObjectParams { coordinates, repeat, keep_paint: self.flat == Flat::Keep })
    }
}

impl LevelFlags {
    /// The library's parameters; what is not given is that of a prepared paint, or the default.
    pub fn params(&self, quilt: QuiltParams, prepared: Option<(u32, u32)>) -> Result<LevelParams> {
        let default = LevelParams::default();
        let (levels, size_px) = prepared.unwrap_or((default.levels, default.size_px));
        let tileable = match self.level_tiling {
            Tiling::Wrap => Tileable::Wrap,
            Tiling::Mask => Tileable::Mask,
        };
        let params = LevelParams {
            levels: self.level_count.unwrap_or(levels),
            size_px: self.level_size.unwrap_or(size_px),
            tileable,
            quilt,
        };
        params.check()?;
        Ok(params)
    }

    /// Adds the flags to the report.
    pub fn report(&self, session: &mut Session) {
        session.parameter("level_count", self.level_count);
        session.parameter("level_size", self.level_size);
        session.parameter("level_tiling", format!("{:?}", self.level_tiling).to_lowercase());
    }
}

/// Points that a file of directions may have: each vertex looks at all of them.
const MAX_DIRECTIONS: usize = 10_000;

fn orientation(text: &str, mesh: &Mesh) -> Result<Orientation> {
    let axis = match text {
        "x" => Some(Vec3::X),
        "y" => Some(Vec3::Y),
        "z" => Some(Vec3::Z),
        _ => vector(text).ok(),
    };
    if let Some(axis) = axis {
        return Ok(Orientation::Axis(axis));
    }
    let path = Path::new(text);
    let bytes = std::fs::read_to_string(path).map_err(|error| {
        Failure::new(format!("--along: {text}: {error} (wanted: x, y, z, a vector X,Y,Z or a file of directions)"))
    })?;
    let mut points = Vec::new();
    for (number, line) in (1..).zip(bytes.lines()).filter(|(_, line)| !line.trim().is_empty()) {
        let values: Vec<f32> = line.split(',').map_while(|part| part.trim().parse().ok()).collect();
        let [x, y, z, dx, dy, dz] = values[..] else {
            return Err(Failure::file(path, format!("line {number} must be six numbers x,y,z,dx,dy,dz")));
        };
        if !values.iter().all(|value| value.is_finite()) || (dx, dy, dz) == (0.0, 0.0, 0.0) {
            return Err(Failure::file(path, format!("line {number} must have finite numbers and a direction")));
        }
        points.push((Vec3::new(x, y, z), Vec3::new(dx, dy, dz)));
    }
    if points.is_empty() || points.len() > MAX_DIRECTIONS {
        let count = points.len();
        return Err(Failure::file(path, format!("has {count} directions, but must have 1 to {MAX_DIRECTIONS}")));
    }
    let nearest = |position: &[f32; 3]| {
        let position = Vec3::from(*position);
        let distance = |point: &&(Vec3, Vec3)| point.0.distance_squared(position);
        points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).map_or(Vec3::Y, |point| point.1)
    };
    Ok(Orientation::Field(mesh.positions().iter().map(nearest).collect()))
}

fn pair(text: &str) -> std::result::Result<[f32; 2], String> {
    let wrong = || "must be two numbers X,Y".to_owned();
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    Ok([finite(x.trim()).map_err(|_| wrong())?, finite(y.trim()).map_err(|_| wrong())?])
}

fn views(text: &str) -> std::result::Result<std::sync::Arc<Vec<View>>, String> {
    let view = |part: &str| {
        let (yaw, pitch) = part.split_once(':')?;
        let number = |text: &str| finite(text.trim()).ok();
        Some(View { yaw_deg: number(yaw)?, pitch_deg: number(pitch)? })
    };
    let views: Option<Vec<View>> = text.split(',').map(view).collect();
    views.map(std::sync::Arc::new).ok_or_else(|| "must be YAW:PITCH,YAW:PITCH,... in degrees".to_owned())
}
