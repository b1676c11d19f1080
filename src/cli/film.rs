//! Where frames go: numbered pictures, a film through ffmpeg, an animated PNG or an animated GIF.
//!
//! Numbered pictures are written by threads of their own, each under a temporary name first, so that a picture that is
//! there is whole. Beside them stands `animation.json`, which says what they were made by: pictures of something else
//! are not taken for finished ones. All the others are written under a temporary name too, and take their own at the
//! end.

use super::failure::{Failure, Result};
use super::files::{check_file, check_folder, Outputs, Staged};
use super::picture::{encode, format_of, over};
use super::values::Size;
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, ImageFormat, RgbaImage};
use serde_json::Value;
use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{sync_channel, Receiver, SyncSender};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

/// Threads that encode and write pictures.
const WRITERS: usize = 2;
/// Frames that may wait for them.
const WAITING: usize = 4;
/// The file that says what numbered pictures were made by.
const MADE_BY: &str = "animation.json";
/// Films that ffmpeg is asked for, by their extension, and what it calls them.
const FILMS: [(&str, &str); 4] = [("mp4", "mp4"), ("webm", "webm"), ("mkv", "matroska"), ("mov", "mov")];
/// What a GIF ends with.
const GIF_TRAILER: u8 = 0x3b;

/// What is to be written.
pub struct Target {
    path: PathBuf,
    kind: Kind,
    rate: u32,
}

enum Kind {
    /// What stands before the number, how many digits it has, what stands after it, and the format.
    Numbered(String, usize, String, ImageFormat),
    /// What ffmpeg calls it.
    Film(&'static str),
    Png,
    Gif,
}

impl Target {
    /// Reads what is to be written from its name.
    pub fn new(path: &Path, rate: u32) -> Result<Self> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let kind = if let Some((before, rest)) = name.split_once('%') {
            let wrong = || Failure::file(path, "the number must be written like %04d, with 1 to 9 digits");
            let (digits, after) = rest.split_once('d').ok_or_else(wrong)?;
            let digits = digits.strip_prefix('0').unwrap_or(digits);
            let digits: usize = if digits.is_empty() { 1 } else { digits.parse().map_err(|_| wrong())? };
            if !(1..=9).contains(&digits) || after.contains('%') {
                return Err(wrong());
            }
            Kind::Numbered(before.to_owned(), digits, after.to_owned(), format_of(path)?)
        } else if let Some((_, format)) = FILMS.iter().find(|(name, _)| *name == extension) {
            Kind::Film(format)
        } else if extension == "png" {
            Kind::Png
        } else if extension == "gif" {
            Kind::Gif
        } else {
            let films = FILMS.map(|(name, _)| name).join(", .");
            let text =
                format!("must be numbered pictures like DIR/%04d.png, a film .{films}, or an animated .png or .gif");
            return Err(Failure::file(path, text));
        };
        Ok(Target { path: path.to_owned(), kind, rate })
    }

    /// Whether every frame is a file of its own.
    pub fn is_numbered(&self) -> bool {
        matches!(self.kind, Kind::Numbered(..))
    }

    /// Finds out whether it can be written; and whether what is there already is by the same parameters, if it is to be
    /// kept.
    pub fn check(&self, made_by: Option<&Value>) -> Result {
        match &self.kind {
            Kind::Numbered(..) => {
                check_folder(self.folder())?;
                let note = self.folder().join(MADE_BY);
                if let (Some(made_by), true) = (made_by, note.exists()) {
                    let text = fs::read_to_string(&note).map_err(|error| Failure::file(&note, error))?;
                    if text != note_text(made_by) {
                        let text =
                            "the pictures there were made with other parameters; leave --resume out to make all anew";
                        return Err(Failure::file(&note, text));
                    }
                }
                Ok(())
            }
            Kind::Film(_) => {
                check_file(&self.path)?;
                let found = Command::new("ffmpeg").arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
                match found {
                    Ok(status) if status.success() => Ok(()),
                    _ => Err(Failure::file(
                        &self.path,
                        "a film takes the program ffmpeg, which is not here; write DIR/%04d.png, .png or .gif instead",
                    )),
                }
            }
            Kind::Png | Kind::Gif => check_file(&self.path),
        }
    }

    /// Whether the picture of a frame is there.
    pub fn has(&self, number: u32) -> bool {
        self.picture(number).is_some_and(|path| path.is_file())
    }

    fn folder(&self) -> &Path {
        self.path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
    }

    fn picture(&self, number: u32) -> Option<PathBuf> {
        let Kind::Numbered(before, digits, after, _) = &self.kind else { return None };
        let digits = *digits;
        Some(self.path.with_file_name(format!("{before}{number:0digits$}{after}")))
    }
}

fn note_text(made_by: &Value) -> String {
    format!("{made_by:#}\n")
}

/// Takes frames and writes them.
pub struct Sink<'a> {
    target: &'a Target,
    way: Way,
    written: Vec<PathBuf>,
}

enum Way {
    Pictures { queue: Option<SyncSender<Job>>, writers: Vec<JoinHandle<()>>, failure: Arc<Mutex<Option<Failure>>> },
    Film { ffmpeg: Child, input: Option<ChildStdin>, staged: Staged },
    Png { writer: Box<png::Writer<File>>, staged: Staged },
    Gif { encoder: Box<GifEncoder<File>>, staged: Staged },
}

type Job = (PathBuf, RgbaImage, ImageFormat);

impl<'a> Sink<'a> {
    /// Opens the target for `count` frames of `size`.
    pub fn open(target: &'a Target, size: Size, count: usize, made_by: &Value) -> Result<Self> {
        let way = match &target.kind {
            Kind::Numbered(..) => {
                let mut note = Outputs::default();
                note.add(target.folder().join(MADE_BY), note_text(made_by));
                note.commit()?;
                let (queue, jobs) = sync_channel::<Job>(WAITING);
                let (jobs, failure) = (Arc::new(Mutex::new(jobs)), Arc::new(Mutex::new(None)));
                let writer = |_| {
                    let (jobs, failure) = (jobs.clone(), failure.clone());
                    std::thread::spawn(move || write_pictures(&jobs, &failure))
                };
                Way::Pictures { queue: Some(queue), writers: (0..WRITERS).map(writer).collect(), failure }
            }
            Kind::Film(format) => {
                let staged = Staged::new(&target.path)?;
                // Even sides, which the usual colour format of films takes.
                let pad = "pad=ceil(iw/2)*2:ceil(ih/2)*2,format=yuv420p";
                let mut ffmpeg = Command::new("ffmpeg")
                    .args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgba"])
                    .args(["-video_size", &size.to_string(), "-framerate", &target.rate.to_string(), "-i", "-"])
                    // A temporary name does not say what is meant.
                    .args(["-vf", pad, "-f", format])
                    .arg(staged.place())
                    .stdin(Stdio::piped())
                    .stdout(Stdio::null())
                    .stderr(Stdio::piped())
                    .spawn()
                    .map_err(|error| Failure::file(&target.path, format!("ffmpeg: {error}")))?;
                let input = ffmpeg.stdin.take();
                Way::Film { ffmpeg, input, staged }
            }
            Kind::Png => {
                let staged = Staged::new(&target.path)?;
                let file = staged.file.try_clone().map_err(|error| Failure::file(&target.path, error))?;
                let writer = png_writer(file, size, count, target.rate);
                Way::Png { writer: Box::new(writer.map_err(|error| Failure::file(&target.path, error))?), staged }
            }
            Kind::Gif => {
                let staged = Staged::new(&target.path)?;
                // Not buffered: what a buffer still holds when it goes may be lost without a word.
                let file = staged.file.try_clone().map_err(|error| Failure::file(&target.path, error))?;
                let mut encoder = GifEncoder::new_with_speed(file, 10);
                encoder.set_repeat(Repeat::Infinite).map_err(|error| Failure::file(&target.path, error))?;
                Way::Gif { encoder: Box::new(encoder), staged }
            }
        };
        Ok(Sink { target, way, written: Vec::new() })
    }

    /// Takes a frame. Films and GIFs, which know no half transparency, lie on white.
    pub fn write(&mut self, number: u32, frame: RgbaImage) -> Result {
        let target = self.target;
        match &mut self.way {
            Way::Pictures { queue, failure, .. } => {
                let Kind::Numbered(_, _, _, format) = &target.kind else { return Ok(()) };
                let Some(path) = target.picture(number) else { return Ok(()) };
                let sent = queue.as_ref().is_some_and(|queue| queue.send((path.clone(), frame, *format)).is_ok());
                if let Some(failure) = failure.lock().ok().and_then(|mut failure| failure.take()) {
                    return Err(failure);
                }
                if !sent {
                    return Err(Failure::file(&path, "the threads that write pictures have ended"));
                }
                self.written.push(path);
            }
            Way::Film { input, ffmpeg, .. } => {
                let bytes = over(frame, [255; 3]).into_raw();
                let sent = input.as_mut().map(|input| input.write_all(&bytes));
                if let Some(Err(error)) = sent {
                    // What ffmpeg says of it says more.
                    drop(input.take());
                    let mut said = Vec::new();
                    if let Some(stderr) = &mut ffmpeg.stderr {
                        // What cannot be read says nothing.
                        let _ = stderr.read_to_end(&mut said);
                    }
                    let words = last_line(&said).unwrap_or_else(|| error.to_string());
                    return Err(Failure::file(&target.path, format!("ffmpeg: {words}")));
                }
            }
            Way::Png { writer, .. } => {
                writer.write_image_data(&frame).map_err(|error| Failure::file(&target.path, error))?;
            }
            Way::Gif { encoder, .. } => {
                let delay = Delay::from_numer_denom_ms(1000, target.rate);
                let frame = Frame::from_parts(over(frame, [255; 3]), 0, 0, delay);
                encoder.encode_frame(frame).map_err(|error| Failure::file(&target.path, error))?;
            }
        }
        Ok(())
    }

    /// Waits until everything is written, and tells the files.
    pub fn finish(self) -> Result<Vec<PathBuf>> {
        let path = &self.target.path;
        match self.way {
            Way::Pictures { mut queue, writers, failure } => {
                drop(queue.take());
                for writer in writers {
                    writer.join().map_err(|_| Failure::file(path, "a thread that writes pictures has failed"))?;
                }
                let failed = failure.lock().ok().and_then(|mut failure| failure.take());
                failed.map_or(Ok(self.written), Err)
            }
            Way::Film { ffmpeg, mut input, staged } => {
                drop(input.take());
                // Takes in what it says while it waits, so that neither waits for the other.
                let output = ffmpeg.wait_with_output().map_err(|error| Failure::file(path, error))?;
                if !output.status.success() {
                    let words = last_line(&output.stderr).unwrap_or_else(|| "it failed".to_owned());
                    return Err(Failure::file(path, format!("ffmpeg: {words}")));
                }
                Ok(vec![staged.rename()?])
            }
            Way::Png { writer, staged } => {
                writer.finish().map_err(|error| Failure::file(path, error))?;
                staged.sync()?;
                Ok(vec![staged.rename()?])
            }
            Way::Gif { encoder, mut staged } => {
                // Its trailer is written when it goes, and nobody says whether that went well.
                drop(encoder);
                let mut last = [0];
                let read = staged.file.seek(SeekFrom::End(-1)).and_then(|_| staged.file.read_exact(&mut last));
                read.map_err(|error| Failure::file(path, error))?;
                if last != [GIF_TRAILER] {
                    return Err(Failure::file(path, "its end could not be written"));
                }
                staged.sync()?;
                Ok(vec![staged.rename()?])
            }
        }
    }
}

/// Begins a PNG that shows its frames over and over; a plain one if there is but one frame.
fn png_writer(
    file: File,
    Size { width, height }: Size,
    count: usize,
    rate: u32,
) -> std::result::Result<png::Writer<File>, png::EncodingError> {
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    // As numbered pictures are compressed.
    encoder.set_compression(png::Compression::Fast);
    // To have fewer frames in the end than it says is an error.
    encoder.validate_sequence(true);
    if count > 1 {
        // Frames and rates have upper bounds that fit; 0 plays are endless ones.
        encoder.set_animated(count as u32, 0)?;
        encoder.set_frame_delay(1, rate as u16)?;
    }
    encoder.write_header()
}

/// The last line of what a program has said.
fn last_line(text: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(text);
    text.lines().rfind(|line| !line.trim().is_empty()).map(str::to_owned)
}

fn write_pictures(jobs: &Mutex<Receiver<Job>>, failure: &Mutex<Option<Failure>>) {
    loop {
        // Waiting holds the lock, but only until a frame comes: then the next thread may wait.
        let job = jobs.lock().ok().and_then(|jobs| jobs.recv().ok());
        let Some((path, frame, format)) = job else { return };
        let written = encode(frame, format).and_then(|bytes| {
            let mut file = Outputs::default();
            file.add(&path, bytes);
            file.commit()
        });
        if let (Err(error), Ok(mut failure)) = (written, failure.lock()) {
            failure.get_or_insert(error);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_animated_png_that_lacks_frames_never_takes_its_place() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = dir.path().join("film.png");
        fs::write(&path, "old").expect("written");
        let target = Target::new(&path, 100).expect("a target");
        let written = |frames: u32| {
            let mut sink = Sink::open(&target, Size { width: 3, height: 2 }, 2, &Value::Null)?;
            (0..frames).try_for_each(|number| sink.write(number, RgbaImage::new(3, 2)))?;
            assert_eq!(fs::read(&path).expect("a file"), b"old");
            sink.finish()
        };
        for wrong in [0, 1, 3] {
            assert!(written(wrong).is_err(), "{wrong}");
            assert_eq!(fs::read(&path).expect("a file"), b"old");
            assert_eq!(fs::read_dir(dir.path()).expect("a folder").count(), 1, "nothing else is left behind");
        }
        assert_eq!(written(2).expect("a file"), std::slice::from_ref(&path));
        assert_eq!(image::open(&path).expect("a picture").to_rgba8(), RgbaImage::new(3, 2));
    }
}
