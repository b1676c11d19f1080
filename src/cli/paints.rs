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
use impasto::technique::Paint;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Paints for the objects of a model.
#[derive(Args, Debug, Clone)]
pub struct PaintFlags {
    /// Paint strip, dark on the left and light on the right; OBJECT= (name or index) gives one object its own
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

/// What a model is painted with.
pub struct Paints {
    strips: Vec<Strip>,
    gradients: Vec<Trajectory>,
    /// Strip and gradient of each paint.
    pairs: Vec<(usize, Option<usize>)>,
    /// For each object, the index of its paint.
    pub of_object: Vec<u32>,
    /// The file of each strip.
    files: Vec<PathBuf>,
}

impl PaintFlags {
    /// Loads all strips and gives every object its paint.
    pub fn load(&self, mesh: &Mesh, session: &mut Session) -> Result<Paints> {
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
            let sample = PaintSample::load(text).map_err(|error| Failure::new(format!("--paint: {error}")))?;
            loaded.strips.push(self.strip.separate(sample, text, session)?);
            loaded.files.push(PathBuf::from(text));
        }
        // Stops become as many colours as the longest strip has columns.
        let columns = loaded.strips.iter().map(|strip| strip.trajectory.len()).max().unwrap_or(1);
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
}

impl Paints {
    /// The paints as the techniques take them, in the order of their numbers.
    pub fn all(&self) -> Vec<Paint<'_>> {
        let paint = |&(strip, gradient): &(usize, Option<usize>)| {
            let strip = &self.strips[strip];
            let trajectory = gradient.map_or(&strip.trajectory, |gradient| &self.gradients[gradient]);
            Paint { texture: &strip.texture, trajectory }
        };
        self.pairs.iter().map(paint).collect()
    }

    /// The strips in use, with their files.
    pub fn strips(&self) -> impl Iterator<Item = (&Path, &Strip)> {
        let used: BTreeSet<usize> = self.pairs.iter().map(|(strip, _)| *strip).collect();
        used.into_iter().map(|strip| (self.files[strip].as_path(), &self.strips[strip]))
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
