//! What commands that paint a model share: the model, its paint, the flags of all techniques, the view, and loading and
//! checking them.

use super::failure::Result;
use super::paints::{PaintFlags, Paints};
use super::quilting::Quilting;
use super::session::Session;
use super::techniques::{Chosen, TechniqueName, TechniqueOptions};
use super::values::{color, Size};
use super::view::ViewFlags;
use clap::builder::Resettable;
use clap::Args;
use impasto::scene::{Camera, Lights, Mesh, MeshOptions};
use impasto::technique::image::ImageParams;
use std::path::{Path, PathBuf};

/// A model, and what all ways of painting it take.
#[derive(Args, Debug)]
#[command(next_help_heading = "Picture and paint")]
pub struct ShotFlags {
    /// Wavefront OBJ model
    #[arg(value_name = "MODEL.obj", help_heading = Resettable::Reset)]
    model: PathBuf,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1024x1024", allow_hyphen_values = true)]
    pub size: Size,
    #[command(flatten)]
    paints: PaintFlags,
    #[command(flatten)]
    pub quilting: Quilting,
    #[command(flatten)]
    technique: TechniqueOptions,
    #[command(flatten)]
    pub view: ViewFlags,
}

/// How it is painted, for commands that paint in one way.
#[derive(Args, Debug)]
#[command(next_help_heading = "Picture and paint")]
pub struct LookFlags {
    /// Way of painting
    #[arg(long, value_enum, default_value_t)]
    pub technique: TechniqueName,
    /// Colour behind the model, like #ffffff [default: transparent]
    #[arg(long, value_name = "COLOR", value_parser = color)]
    pub background: Option<[u8; 3]>,
}

/// All of it, loaded and checked.
pub struct Shot {
    pub mesh: Mesh,
    pub camera: Camera,
    pub lights: Lights,
    pub paints: Paints,
}

impl ShotFlags {
    /// Loads and checks everything for painting in these ways, and reports the flags.
    pub fn load(&self, techniques: &[TechniqueName], session: &mut Session) -> Result<Shot> {
        let lights = self.view.lights()?;
        let mesh = load_model(&self.model, session)?;
        let camera = self.view.camera(&mesh, self.size.aspect())?;
        let only_aligned = techniques.iter().all(|name| *name == TechniqueName::Aligned);
        let paints = self.paints.load(&mesh, only_aligned, session)?;
        let window = self.technique.image(&self.quilting);
        // A k out of range is told before any work.
        window.window_px(1)?;
        let any = |wanted: &[TechniqueName]| techniques.iter().any(|name| wanted.contains(name));
        for (file, strip) in paints.strips() {
            let size = (strip.sample.width(), strip.sample.height());
            if any(&[TechniqueName::Image, TechniqueName::Aligned, TechniqueName::Dependent]) {
                self.quilting.check(file, size, self.size, false)?;
            }
            if any(&[TechniqueName::Image, TechniqueName::Dependent]) {
                warn_of_wide_window(file, size.0, &window, session)?;
            }
        }
        session.parameter("model", self.model.display().to_string());
        session.parameter("size", self.size.to_string());
        techniques.iter().for_each(|name| self.technique.report(*name, session));
        self.quilting.report(session);
        self.view.report(&camera, &lights, session);
        Ok(Shot { mesh, camera, lights, paints })
    }

    /// The parameters of a technique for what was loaded.
    pub fn choose(&self, technique: TechniqueName, shot: &Shot) -> Result<Chosen> {
        self.technique.choose(technique, &self.quilting, &shot.mesh, shot.paints.prepared()?)
    }
}

/// Loads a model and tells what was wrong with it.
pub fn load_model(path: &Path, session: &mut Session) -> Result<Mesh> {
    let loaded = Mesh::load(path, &MeshOptions::default())?;
    for warning in loaded.warnings {
        session.warn(format!("{}: {warning}", path.display()));
    }
    Ok(loaded.mesh)
}

/// A window that takes in most of the strip brings marks of one shade into another.
fn warn_of_wide_window(file: &Path, width: u32, params: &ImageParams, session: &mut Session) -> Result {
    let block = params.quilt.block_px;
    let positions = (width + 1).saturating_sub(block);
    let window = params.window_px(width)?.saturating_mul(2).saturating_add(1).min(positions);
    if window.saturating_mul(2) > width {
        session.warn(format!(
            "{}: --k{} with --block {block} searches {window} of the strip's {width} columns, more than half of it, \
             for every shade; a smaller --k keeps the marks of one shade out of another",
            file.display(),
            params.k.map_or_else(|| " left to itself".to_owned(), |k| format!(" {k}"))
        ));
    }
    Ok(())
}
