//! Why a command failed, in the words of the command line.

use impasto::Error;

/// A sentence for the person at the command line; `main` prints it and exits with status 1.
#[derive(Debug)]
pub struct Failure(pub String);

/// What a command returns.
pub type Result<T = ()> = std::result::Result<T, Failure>;

impl Failure {
    /// A failure in these words.
    pub fn new(text: impl Into<String>) -> Self {
        Failure(text.into())
    }

    /// A failure about one file.
    pub fn file(path: &std::path::Path, reason: impl std::fmt::Display) -> Self {
        Failure(format!("{}: {reason}", path.display()))
    }
}

impl From<Error> for Failure {
    /// The library's errors name its own parameters; here they are told by their flags.
    fn from(error: Error) -> Self {
        match error {
            Error::Parameter { name, value, allowed } => {
                let allowed = in_flags(&allowed);
                match flag(name) {
                    Some((flag, "")) => Failure(format!("{flag} is {value}, but must be {allowed}")),
                    Some((flag, what)) => Failure(format!("{flag}: {what} is {value}, but must be {allowed}")),
                    None => Failure(format!("{name} is {value}, but must be {allowed}")),
                }
            }
            Error::Memory { .. } => Failure(format!("{error}; a smaller picture needs less")),
            other => Failure(other.to_string()),
        }
    }
}

/// The flag that sets a parameter of the library, and which part of its value is meant, if not the whole.
fn flag(name: &str) -> Option<(&'static str, &'static str)> {
    Some(match name {
        "block_px" => ("--block", ""),
        "overlap_px" => ("--overlap", ""),
        "tolerance" => ("--tolerance", ""),
        "k" => ("--k", ""),
        "repeats" => ("--repeats", ""),
        "variation" => ("--variation", ""),
        "orientation" => ("--along", ""),
        "levels" => ("--level-count", ""),
        "stretch" => ("--stretch", ""),
        "slack" => ("--slack", ""),
        "repair tolerance" => ("--repair-tolerance", ""),
        "weight of the previous frame" => ("--match-weight", ""),
        "prepared levels" => ("--level-count or --level-size", "what was prepared"),
        "size_px" => ("--level-size", ""),
        "view_px" => ("--view-size", ""),
        "views" => ("--views", "the number of views"),
        "density" => ("--density", ""),
        "follow_deg" => ("--follow", ""),
        "offset_px" => ("--offset", ""),
        "search_scale" => ("--search-scale", ""),
        "stops" => ("--gradient", ""),
        "output width" => ("--size", "the width"),
        "output height" => ("--size", "the height"),
        "aspect" => ("--size", "width over height"),
        "yaw_deg" => ("--yaw", ""),
        "pitch_deg" => ("--pitch", ""),
        "distance" => ("--distance", ""),
        "fov_y_deg" => ("--fov", ""),
        "eye" => ("--eye", ""),
        "target" => ("--target", ""),
        "up" => ("--up", ""),
        "lights" => ("--light", "the number of lights"),
        "object" => ("OBJECT", ""),
        _ => return None,
    })
}

fn in_flags(allowed: &str) -> String {
    allowed.replace("block_px", "--block").replace("overlap_px", "--overlap")
}
