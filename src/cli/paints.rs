//! Which object is painted with what: `--paint` and `--gradient`, once or for each object.
//!
//! Both flags take a plain value, which serves all objects that have none of their own, or `OBJECT=VALUE`. A paint is a
//! strip together with the gradient that colours it; objects with the same two share one synthesis.

use super::failure::{Failure, Result};
use super::session::Session;
use super::strips::{Strip, StripFlags};
use clap::Args;
use impasto::paint::{PaintSample, Trajectory};
use impasto::scene::Mesh;
use impasto::technique::aligned::{LevelSource, LevelTexture};
use impasto::technique::Paint;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The name of the built-in grid, which shows how texture lies on a model (figure 5.1).
const GRID: &str = "grid";

/// Paints for the objects of a model.
#[derive(Args, Debug, Clone)]
pub struct PaintFlags {
    /// Paint strip, dark on the left and light on the right, or `grid` for a test pattern; with the technique aligned
    /// also what `prepare` made; OBJECT= (name or index) gives one object its own
    #[arg(long = "paint", value_name = "[OBJECT=]STRIP.png", required = true)]
    paints: Vec<String>,
    /// Other colours for the strip's texture: another strip's, or stops like 0:#102030,0.5:#ff8800,1:#ffffff
    #[arg(long = "gradient", value_name = "[OBJECT=]STRIP2.png|STOPS")]
    gradients: Vec<String>,
    #[command(flatten)]
    strip: StripFlags,
}

/// The values of a flag, each once, in the order of the command line, and which of them each object takes.
struct Assigned<'a> {
    values: Vec<&'a str>,
    of_object: Vec<Option<usize>>,
}

/// What a file of paint holds.
enum Source {
    /// A strip.
    Strip(Box<Strip>),
    /// Levels for view-aligned projection that were prepared before.
    Levels(LevelTexture),
}

impl Source {
    fn trajectory(&self) -> &Trajectory {
        match self {
            Source::Strip(strip) => &strip.trajectory,
            Source::Levels(levels) => levels.trajectory(),
        }
    }
}

/// What a model is painted with.
pub struct Paints {
    strips: Vec<Source>,
    gradients: Vec<Trajectory>,
    /// Strip and gradient of each paint.
    pairs: Vec<(usize, Option<usize>)>,
    /// For each object, the index of its paint.
    pub of_object: Vec<u32>,
    /// The file of each strip.
    files: Vec<PathBuf>,
}

impl PaintFlags {
    /// Loads all strips and gives every object its paint. `levels` says whether prepared levels will do as well.
    pub fn load(&self, mesh: &Mesh, levels: bool, session: &mut Session) -> Result<Paints> {
        let paints = assign("--paint", &self.paints, mesh)?;
        let gradients = assign("--gradient", &self.gradients, mesh)?;
        let mut pair_of_object = Vec::with_capacity(mesh.objects().len());
        for (index, (strip, gradient)) in paints.of_object.iter().zip(&gradients.of_object).enumerate() {
            let Some(strip) = *strip else {
                let name = &mesh.objects()[index].name;
                return Err(Failure::new(format!(
                    "--paint: object {index} `{name}` has no paint; give --paint {name}=STRIP.png, or --paint STRIP.png \
                     for all objects that have none"
                )));
            };
            pair_of_object.push((strip, *gradient));
        }
        let pairs: Vec<_> = pair_of_object.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
        let mut loaded =
            Paints { strips: Vec::new(), gradients: Vec::new(), pairs, of_object: Vec::new(), files: Vec::new() };
        for text in &paints.values {
            loaded.strips.push(self.source(text, levels, session)?);
            loaded.files.push(PathBuf::from(text));
        }
        // Stops become as many colours as the longest strip has columns.
        let columns = loaded.strips.iter().map(|source| source.trajectory().len()).max().unwrap_or(1);
        for text in &gradients.values {
            loaded.gradients.push(self.strip.gradient(text, columns)?);
        }
        for pair in pair_of_object {
            let paint = loaded.pairs.binary_search(&pair).unwrap_or_default();
            loaded.of_object.push(paint as u32);
        }
        session.parameter("paint", self.paints.clone());
        session.parameter("gradient", self.gradients.clone());
        self.strip.report(session);
        Ok(loaded)
    }

    fn source(&self, text: &str, levels: bool, session: &mut Session) -> Result<Source> {
        let wrong = |error| Failure::new(format!("--paint: {error}"));
        if text == GRID && !Path::new(text).exists() {
            return Ok(Source::Strip(Box::new(self.strip.separate(PaintSample::grid(), text, session)?)));
        }
        if Path::new(text).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ktx2")) {
            let texture = LevelTexture::load(text).map_err(wrong)?;
            if !levels {
                let only = "holds prepared levels, which only --technique aligned paints with";
                return Err(Failure::new(format!("--paint: {text}: {only}")));
            }
            return Ok(Source::Levels(texture));
        }
        let sample = PaintSample::load(text).map_err(wrong)?;
        Ok(Source::Strip(Box::new(self.strip.separate(sample, text, session)?)))
    }
}

impl Paints {
    /// One strip for all objects of a model.
    pub fn single(strip: Strip, file: PathBuf, mesh: &Mesh) -> Self {
        Self::in_turn([(strip, file)], mesh)
    }

    /// Strips for the objects of a model in turn: the first, the second, ..., the first again.
    pub fn in_turn(strips: impl IntoIterator<Item = (Strip, PathBuf)>, mesh: &Mesh) -> Self {
        let objects = mesh.objects().len();
        let (strips, files): (Vec<_>, Vec<_>) =
            strips.into_iter().take(objects).map(|(strip, file)| (Source::Strip(Box::new(strip)), file)).unzip();
        let pairs: Vec<_> = (0..strips.len()).map(|strip| (strip, None)).collect();
        let of_object = (0..objects).map(|object| (object % strips.len().max(1)) as u32).collect();
        Paints { strips, gradients: Vec::new(), pairs, of_object, files }
    }

    /// The paints as the techniques take them, in the order of their numbers.
    pub fn all(&self) -> Result<Vec<Paint<'_>>> {
        let paint = |(&(strip, _), trajectory): (&(usize, Option<usize>), _)| match &self.strips[strip] {
            Source::Strip(strip) => Ok(Paint { texture: &strip.texture, trajectory }),
            Source::Levels(_) => Err(Failure::file(self.files[strip].as_path(), "holds prepared levels and no strip")),
        };
        self.pairs.iter().zip(self.trajectories()).map(paint).collect()
    }

    /// The paints as view-aligned projection takes them.
    pub fn levels(&self) -> Vec<LevelSource<'_>> {
        let level = |(strip, _): &(usize, Option<usize>)| match &self.strips[*strip] {
            Source::Strip(strip) => LevelSource::Strip(&strip.texture),
            Source::Levels(levels) => LevelSource::Prepared(levels),
        };
        self.pairs.iter().map(level).collect()
    }

    /// The colours of each paint.
    pub fn trajectories(&self) -> Vec<&Trajectory> {
        let trajectory = |&(strip, gradient): &(usize, Option<usize>)| {
            gradient.map_or(self.strips[strip].trajectory(), |gradient| &self.gradients[gradient])
        };
        self.pairs.iter().map(trajectory).collect()
    }

    /// Number and size of the levels that were prepared before, if there are any; they must agree.
    pub fn prepared(&self) -> Result<Option<(u32, u32)>> {
        let mut found: Option<(u32, u32)> = None;
        for (source, file) in self.strips.iter().zip(&self.files) {
            let Source::Levels(levels) = source else { continue };
            let own = (levels.levels(), levels.size_px());
            if found.is_some_and(|found| found != own) {
                let text = format!("has {} levels of {} pixels, unlike the paint before it", own.0, own.1);
                return Err(Failure::file(file, text));
            }
            found = Some(own);
        }
        Ok(found)
    }

    /// The strips in use, with their files.
    pub fn strips(&self) -> impl Iterator<Item = (&Path, &Strip)> {
        let used: BTreeSet<usize> = self.pairs.iter().map(|(strip, _)| *strip).collect();
        used.into_iter().filter_map(|number| match &self.strips[number] {
            Source::Strip(strip) => Some((self.files[number].as_path(), &**strip)),
            Source::Levels(_) => None,
        })
    }
}

/// Reads `VALUE` and `OBJECT=VALUE`. What is the name of a file is a value, whatever it contains.
fn assign<'a>(flag: &str, texts: &'a [String], mesh: &Mesh) -> Result<Assigned<'a>> {
    let mut values: Vec<&str> = Vec::with_capacity(texts.len());
    let mut default = None;
    let mut of_object = vec![None; mesh.objects().len()];
    for text in texts {
        let (place, value) = match text.split_once('=') {
            Some((object, value)) if !Path::new(text).exists() => {
                let wrong = |error| Failure::new(format!("{flag} {text}: {}", Failure::from(error).0));
                let index = mesh.object_index(object).map_err(wrong)?;
                (&mut of_object[index], value)
            }
            _ => (&mut default, text.as_str()),
        };
        // A value that is given twice is one value: what it names is loaded, and synthesised with, once.
        let number = values.iter().position(|known| *known == value).unwrap_or_else(|| {
            values.push(value);
            values.len() - 1
        });
        if let Some(first) = place.replace(number) {
            let first = values[first];
            let hint = "OBJECT= gives a value to one object";
            return Err(Failure::new(format!("{flag}: both {first} and {value} for the same objects; {hint}")));
        }
    }
    for place in &mut of_object {
        *place = place.or(default);
    }
    Ok(Assigned { values, of_object })
}
