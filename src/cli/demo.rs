//! `impasto demo`: the built-in models and paints through every command, and a page that shows it all.
//!
//! The demo is a list of command lines ([`SCRIPT`]). Each is parsed and run as if it had been typed, so that the
//! page's captions are what made its pictures. All of it happens in a temporary folder within the output folder; only
//! when everything has gone well are the files moved to their places.

use super::builtin::BUILTIN;
use super::demo_page;
use super::failure::{Failure, Result};
use super::files::check_folder;
use super::session::Session;
use super::values::Size;
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use std::{env, fs, process};

/// Flags of `impasto demo`.
#[derive(Args, Debug)]
pub struct DemoArgs {
    /// Folder for the page, its pictures, and the models and strips that they are made of
    #[arg(short, long, value_name = "DIR", default_value = "demo")]
    output: PathBuf,
    /// Size of the rendered pictures
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1024x1024", allow_hyphen_values = true)]
    size: Size,
}

/// A command line, and what it shows.
pub struct Step {
    /// The arguments, `SIZE` standing for the size of a picture and `SQUARE` for that of a texture.
    arguments: &'static str,
    /// The title on the page.
    pub title: &'static str,
    /// What there is to see.
    pub text: &'static str,
    /// The pictures with their captions.
    pub pictures: &'static [(&'static str, &'static str)],
    /// A picture that is to be shown twice across and twice down.
    pub repeated: Option<&'static str>,
}

/// A step that was taken.
pub struct Taken {
    /// What it was.
    pub step: &'static Step,
    /// The command line.
    pub command: String,
    /// How long it took.
    pub time: Duration,
}

const SCRIPT: [Step; 24] = [
    Step {
        arguments: "render head.obj --paint strip_green_yellow.png -o head_green_yellow.png --size SIZE \
                    --levels --dump head_green_yellow",
        title: "Image-based texture synthesis",
        text: "The model's shade decides where in the strip a block of texture is taken from, and picks the colour at \
               every pixel (figure 6.1 of the thesis).",
        pictures: &[
            ("head_green_yellow.png", "Colour and texture together"),
            ("strip_green_yellow.png", "The paint strip"),
            ("head_green_yellow/shade.png", "Shade"),
            ("head_green_yellow/id.png", "Object ID"),
            ("head_green_yellow/color.png", "Colour only"),
            ("head_green_yellow/texture.png", "Texture only"),
        ],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint strip_dark_red.png -o head_dark_red.png --size SIZE --levels",
        title: "Another paint",
        text: "Long strokes near the vertical.",
        pictures: &[("head_dark_red.png", "Painted"), ("strip_dark_red.png", "The paint strip")],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint strip_red_yellow.png -o head_red_yellow.png --size SIZE --levels",
        title: "A third paint",
        text: "Diagonal strokes, and a colour that runs from maroon through orange to yellow.",
        pictures: &[("head_red_yellow.png", "Painted"), ("strip_red_yellow.png", "The paint strip")],
        repeated: None,
    },
    Step {
        arguments:
            "render head.obj --paint strip_dark_red.png --gradient 0:#0b1440,0.45:#1f7a8c,0.8:#e8c07d,1:#fff8e7 \
                    -o head_recolored.png --size SIZE --levels",
        title: "The same strokes in other colours",
        text: "The texture is that of the dark red strip, the colours are a gradient of four stops.",
        pictures: &[("head_recolored.png", "Painted"), ("strip_dark_red.png", "The strip that gives the texture")],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint strip_green_yellow.png -o head_object.png --size SIZE --levels \
                    --technique object",
        title: "Object-based texture mapping",
        text: "The strip is wrapped around the model: its columns follow the light, its rows repeat along the height. \
               Nothing is prepared.",
        pictures: &[("head_object.png", "Green and yellow"), ("strip_green_yellow.png", "The paint strip")],
        repeated: None,
    },
    Step {
        arguments: "prepare strip_green_yellow.png -o strip_green_yellow.ktx2",
        title: "A strip, prepared for view-aligned projection",
        text: "A tileable texture for each of eight levels of shade, in a file that a game can ship.",
        pictures: &[("strip_green_yellow.png", "The paint strip")],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint strip_green_yellow.ktx2 -o head_aligned.png --size SIZE --levels \
                    --technique aligned",
        title: "View-aligned 3D texture projection",
        text:
            "Texture lies in the plane of the picture, and shade picks the level; blended levels keep their contrast.",
        pictures: &[("head_aligned.png", "Green and yellow")],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint strip_green_yellow.ktx2 -o head_aligned_linear.png --size SIZE --levels \
                    --technique aligned --blend linear",
        title: "The same with the hardware's plain blend",
        text: "Between two levels marks lose contrast: the error that the thesis names.",
        pictures: &[("head_aligned_linear.png", "Plain blend"), ("head_aligned.png", "Contrast kept")],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint strip_green_yellow.png -o head_dependent.png --size SIZE --levels \
                    --technique dependent --dump head_dependent",
        title: "View-dependent interpolation",
        text: "Important views around the model have textures of their own; other views blend them.",
        pictures: &[("head_dependent.png", "Green and yellow"), ("head_dependent/texture.png", "Texture only")],
        repeated: None,
    },
    Step {
        arguments:
            "render head.obj --paint strip_dark_red.png -o red_object.png --size SIZE --levels --technique object",
        title: "Dark red, object-based",
        text: "Figures 10.1 to 10.3 of the thesis show each technique with three paints.",
        pictures: &[("red_object.png", "Object-based"), ("head_dark_red.png", "Image-based")],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint strip_dark_red.png -o red_aligned.png --size SIZE --levels \
                    --technique aligned",
        title: "Dark red, view-aligned",
        text: "Long strokes stay near the vertical of the picture.",
        pictures: &[("red_aligned.png", "View-aligned")],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint strip_dark_red.png -o red_dependent.png --size SIZE --levels \
                    --technique dependent",
        title: "Dark red, view-dependent",
        text: "Strokes follow the form from view to view.",
        pictures: &[("red_dependent.png", "View-dependent")],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint strip_red_yellow.png -o yellow_object.png --size SIZE --levels \
                    --technique object",
        title: "Red and yellow, object-based",
        text: "The strip's own transition of colours, around the head.",
        pictures: &[("yellow_object.png", "Object-based"), ("head_red_yellow.png", "Image-based")],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint strip_red_yellow.png -o yellow_aligned.png --size SIZE --levels \
                    --technique aligned",
        title: "Red and yellow, view-aligned",
        text: "Diagonal strokes, alike over the whole picture.",
        pictures: &[("yellow_aligned.png", "View-aligned")],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint strip_red_yellow.png -o yellow_dependent.png --size SIZE --levels \
                    --technique dependent",
        title: "Red and yellow, view-dependent",
        text: "Diagonal strokes of each view, blended.",
        pictures: &[("yellow_dependent.png", "View-dependent")],
        repeated: None,
    },
    Step {
        arguments: "render head.obj --paint grid -o grid.png --size SIZE --technique object --flat lose",
        title: "How the strip lies on the model",
        text: "A grid in place of paint (figure 5.1): the dotted line is one of constant light.",
        pictures: &[("grid.png", "The grid")],
        repeated: None,
    },
    Step {
        arguments: "render teapot_on_table.obj --paint strip_red_yellow.png --paint table=strip_green_yellow.png \
                    -o flat_lose.png --size SIZE --technique object --flat lose",
        title: "Flat faces lose their paint",
        text: "The table has one shade, so one texel of the strip spreads over it (figure 5.3).",
        pictures: &[("flat_lose.png", "As in the thesis")],
        repeated: None,
    },
    Step {
        arguments: "render teapot_on_table.obj --paint strip_red_yellow.png --paint table=strip_green_yellow.png \
                    -o flat_keep.png --size SIZE --technique object",
        title: "Flat faces keep their paint",
        text: "Where the mapping spreads the strip too thin, it is laid on from three sides instead.",
        pictures: &[("flat_keep.png", "Kept")],
        repeated: None,
    },
    Step {
        arguments: "render teapot_on_table.obj --paint strip_red_yellow.png --paint table=strip_green_yellow.png \
                    -o teapot.png --size SIZE --dump teapot",
        title: "A paint for every object",
        text: "The table is flat: it has one shade, and keeps its painted look all the same (compare figure 5.3).",
        pictures: &[
            ("teapot.png", "Painted"),
            ("teapot/id.png", "Object ID, a colour for each object"),
            ("teapot/color.png", "Colour only"),
            ("teapot/texture.png", "Texture only"),
        ],
        repeated: None,
    },
    Step {
        arguments: "paint strip_green_yellow.png -o paint --gradient 0:#1b1464,0.5:#c2417c,1:#ffe9a8",
        title: "A strip, taken apart and put together again",
        text: "Strip = trajectory + texture; texture + another trajectory = a strip in other colours (figures 4.1 and \
               4.4).",
        pictures: &[
            ("strip_green_yellow.png", "The strip"),
            ("paint/trajectory.png", "Its colour trajectory"),
            ("paint/texture.png", "Its texture (grey is no difference)"),
            ("paint/gradient.png", "Other colours"),
            ("paint/recombined.png", "Texture and other colours"),
        ],
        repeated: None,
    },
    Step {
        arguments: "paint strip_green_yellow.png -o one_color --gradient 0:#2c6e7f,1:#4f9d8c",
        title: "A paint of nearly one colour",
        text: "A short gradient leaves little but the strokes: a sample that is alike everywhere.",
        pictures: &[("strip_green_yellow.png", "The strip"), ("one_color/recombined.png", "Nearly one colour")],
        repeated: None,
    },
    Step {
        arguments: "quilt one_color/recombined.png -o quilt.png --size SQUARE --block 48 --overlap 12 --tolerance 0.4",
        title: "Image quilting",
        text: "More of the same: blocks of the sample, cut where the eye sees it least.",
        pictures: &[("one_color/recombined.png", "The sample"), ("quilt.png", "Quilted")],
        repeated: None,
    },
    Step {
        arguments:
            "quilt one_color/recombined.png -o quilt_wrap.png --size SQUARE --block 48 --overlap 12 --tolerance 0.4 \
                    --tileable wrap",
        title: "A quilt that repeats",
        text: "Blocks are fitted across the edges too.",
        pictures: &[("quilt_wrap.png", "Quilted around the edges")],
        repeated: Some("quilt_wrap.png"),
    },
    Step {
        arguments: "tile quilt.png -o quilt_tiled.png",
        title: "An existing picture, made to repeat",
        text: "The quilt from above, blended with itself under a circular mask (figure 3.8).",
        pictures: &[("quilt_tiled.png", "Tiled by mask")],
        repeated: Some("quilt_tiled.png"),
    },
];

/// Runs the script and writes the page.
pub fn run(args: &DemoArgs, session: &mut Session) -> Result {
    check_folder(&args.output)?;
    session.parameter("output", args.output.display().to_string());
    session.parameter("size", args.size.to_string());
    let staging = Staging::new(&args.output)?;
    for file in &BUILTIN {
        fs::write(staging.path.join(file.name), file.bytes).map_err(|error| Failure::file(&staging.path, error))?;
    }
    session.phase("setup");
    let mut taken = Vec::with_capacity(SCRIPT.len());
    for step in &SCRIPT {
        taken.push(take(step, args.size, &staging.path, session)?);
        session.phase("commands");
    }
    let page = staging.path.join("index.html");
    fs::write(&page, demo_page::html(&taken)).map_err(|error| Failure::file(&page, error))?;
    let written = staging.publish(&args.output)?;
    session.wrote(written);
    session.phase("write");
    let steps: Vec<_> = taken
        .iter()
        .map(|taken| json!({ "command": taken.command, "wall_ms": taken.time.as_secs_f64() * 1e3 }))
        .collect();
    let lines: Vec<String> =
        taken.iter().map(|taken| format!("{:6.2} s  {}", taken.time.as_secs_f64(), taken.command)).collect();
    session.result("commands", steps, lines.join("\n"));
    session.closing_line(format!("see {}", args.output.join("index.html").display()));
    Ok(())
}

/// Runs one command line in the folder.
fn take(step: &'static Step, size: Size, folder: &Path, session: &mut Session) -> Result<Taken> {
    // A texture of less than four blocks a side would not show much, but a quick demo may ask for it.
    let square = size.width.min(size.height).clamp(64, 512);
    let arguments = step.arguments.replace("SIZE", &size.to_string()).replace("SQUARE", &format!("{square}x{square}"));
    let command = format!("impasto {arguments}");
    let back = env::current_dir().map_err(|error| Failure::new(format!("the current folder: {error}")))?;
    env::set_current_dir(folder).map_err(|error| Failure::file(folder, error))?;
    let started = Instant::now();
    let result = super::run_words(&command, session);
    let time = started.elapsed();
    env::set_current_dir(&back).map_err(|error| Failure::file(&back, error))?;
    result.map_err(|failure| Failure::new(format!("{command}: {}", failure.0)))?;
    Ok(Taken { step, command, time })
}

/// The temporary folder; it goes when it is dropped.
struct Staging {
    path: PathBuf,
    /// Folders that were made for it, the innermost first; they go as well unless the demo comes to its end.
    made: Vec<PathBuf>,
}

impl Staging {
    fn new(output: &Path) -> Result<Self> {
        let output = std::path::absolute(output).map_err(|error| Failure::file(output, error))?;
        let made = output.ancestors().take_while(|folder| !folder.exists()).map(Path::to_owned).collect();
        let staging = Staging { path: output.join(format!(".impasto-{}.tmp", process::id())), made };
        fs::create_dir_all(&staging.path).map_err(|error| Failure::file(&staging.path, error))?;
        Ok(staging)
    }

    /// Moves every file to its place and tells where.
    fn publish(mut self, output: &Path) -> Result<Vec<PathBuf>> {
        let mut written = Vec::new();
        move_files(&self.path, output, &mut written)?;
        self.made.clear();
        Ok(written)
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // Nothing can be done about a temporary folder that will not go.
        let _ = fs::remove_dir_all(&self.path);
        for folder in &self.made {
            // Fails, as it should, for a folder that somebody else has put something into.
            let _ = fs::remove_dir(folder);
        }
    }
}

fn move_files(from: &Path, to: &Path, written: &mut Vec<PathBuf>) -> Result {
    let fail = |path: &Path| {
        let path = path.to_owned();
        move |error| Failure::file(&path, error)
    };
    fs::create_dir_all(to).map_err(fail(to))?;
    let mut entries: Vec<_> =
        fs::read_dir(from).and_then(Iterator::collect::<std::io::Result<_>>).map_err(fail(from))?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let (source, target) = (entry.path(), to.join(entry.file_name()));
        if source.is_dir() {
            move_files(&source, &target, written)?;
        } else {
            fs::rename(&source, &target).map_err(fail(&target))?;
            written.push(target);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_shows_only_what_the_script_or_the_program_makes() {
        let named = |name: &str| {
            let folder = name.split_once('/').map_or(name, |(folder, _)| folder);
            SCRIPT.iter().any(|step| step.arguments.split_whitespace().any(|word| word == folder))
        };
        for step in &SCRIPT {
            for (file, _) in step.pictures.iter().chain(&step.repeated.map(|file| (file, ""))) {
                assert!(named(file) || BUILTIN.iter().any(|builtin| builtin.name == *file), "{file}");
            }
        }
    }
}
