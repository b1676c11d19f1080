//! A reader that stands between an OBJ file and the `tobj` parser, and passes on clean lines, one at a time.
//!
//! Real files hold constructs that `tobj` refuses or misreads: a byte order mark, `\` at a line's end, names that are
//! not UTF-8, MSVC's `1.#IND`, a `w` or colours after a position, indices out of range, polylines that it takes for
//! faces, corners with and without a normal in one object. So only what a mesh is made of gets through (`v`, `vn`,
//! `f`, `o`, `g`), in one plain form:
//!
//! - every corner is `position//normal` with absolute, checked indices. Normal 1 is a placeholder of NaNs for corners
//!   that have none, so that positions and normals always come in equal numbers; no other NaN gets through;
//! - texture coordinates and materials are left out: nothing here needs them, and a seam in them is no seam of the
//!   surface. No file but the model itself is ever opened.
//!
//! `tobj` reads one line from here at a time, so when it fails, [`ObjLines::line`] is the line that it failed at.

use std::io::{self, BufRead, Read};

use super::obj::{too_large, MAX_FILE_BYTES, MAX_TRIANGLES, MAX_VERTICES};
use super::MAX_OBJECTS;

/// The longest line, continuation lines included: a face of a million corners fits.
const MAX_LINE_BYTES: usize = 16 << 20;
/// The longest name of an object, in characters; what is beyond is cut off.
const MAX_NAME_CHARS: usize = 200;

/// Why the file cannot be read on.
pub(super) enum Failure {
    /// The system could not read it.
    Io(io::Error),
    /// What is wrong with its content, line number included.
    Content(String),
}

/// What was seen on the way.
#[derive(Default)]
pub(super) struct LineCounts {
    /// `v` lines.
    pub positions: usize,
    /// `vn` lines.
    pub normals: usize,
    /// `f` lines with fewer than three corners; they are not passed on.
    pub short_faces: usize,
    /// `l` and `p` lines; they are not passed on.
    pub lines_and_points: usize,
}

/// The cleaning reader: wraps the file and is read by `tobj`.
pub(super) struct ObjLines<R> {
    source: R,
    /// The current line of the file, continuation lines joined, without its line end.
    raw: Vec<u8>,
    /// What `tobj` is given for it, and how much of that it has read.
    clean: Vec<u8>,
    taken: usize,
    /// Number of the current line, from 1; of the last one where several are joined.
    line: u64,
    /// The last line ended in CR, so an LF right after it belongs to the same line end.
    after_cr: bool,
    bytes: u64,
    triangles: usize,
    /// `o` and `g` blocks that hold faces, and whether the current one does.
    blocks: usize,
    block_has_faces: bool,
    /// The highest position and normal index since the last object began, each with its line. A face may refer to
    /// what its block defines further down, so they are checked where the block ends.
    highest: [(u64, u64); 2],
    counts: LineCounts,
    failure: Option<Failure>,
}

impl<R: BufRead> ObjLines<R> {
    pub fn new(source: R) -> Self {
        Self {
            source,
            raw: Vec::new(),
            clean: b"vn nan nan nan\n".to_vec(),
            taken: 0,
            line: 0,
            after_cr: false,
            bytes: 0,
            triangles: 0,
            blocks: 0,
            block_has_faces: false,
            highest: [(0, 0); 2],
            counts: LineCounts::default(),
            failure: None,
        }
    }

    /// The number of the line that was read last, from 1.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// Ends reading: what was counted, or why reading failed.
    pub fn finish(self) -> Result<LineCounts, Failure> {
        self.failure.map_or(Ok(self.counts), Err)
    }

    /// Reads and cleans lines until one leaves something for `tobj`; leaves nothing at the end of the file.
    fn advance(&mut self) -> Result<(), Failure> {
        self.clean.clear();
        self.taken = 0;
        while self.clean.is_empty() {
            if !self.read_line()? {
                return self.end_block();
            }
            self.clean_line()?;
        }
        Ok(())
    }

    /// Reads one line into `raw`, joined with the lines that continue it. False at the end of the file.
    fn read_line(&mut self) -> Result<bool, Failure> {
        self.raw.clear();
        if !self.append_line()? {
            return Ok(false);
        }
        if self.line == 1 {
            self.check_start()?;
        }
        // A backslash at the end of a comment is more likely the end of a Windows path than a continuation.
        let is_comment = self.raw.trim_ascii_start().starts_with(b"#");
        while !is_comment && self.raw.trim_ascii_end().ends_with(b"\\") {
            let without = self.raw.trim_ascii_end().len() - 1;
            self.raw.truncate(without);
            self.raw.push(b' ');
            if !self.append_line()? {
                break;
            }
        }
        Ok(true)
    }

    /// Appends the file's next line to `raw`, without its end: LF, CR LF, or a lone CR. False at the end of the file.
    fn append_line(&mut self) -> Result<bool, Failure> {
        let mut any = false;
        loop {
            let buffer = match self.source.fill_buf() {
                Ok(buffer) => buffer,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(Failure::Io(error)),
            };
            let Some(&first) = buffer.first() else {
                self.line += u64::from(any);
                return Ok(any);
            };
            if std::mem::take(&mut self.after_cr) && first == b'\n' {
                self.source.consume(1);
                continue;
            }
            any = true;
            let end = buffer.iter().position(|&byte| byte == b'\n' || byte == b'\r');
            let text = &buffer[..end.unwrap_or(buffer.len())];
            self.raw.extend_from_slice(text);
            self.after_cr = end.is_some_and(|at| buffer[at] == b'\r');
            let used = text.len() + usize::from(end.is_some());
            self.source.consume(used);
            self.bytes += used as u64;
            if self.bytes > MAX_FILE_BYTES {
                return Err(Failure::Content(too_large()));
            }
            if self.raw.len() > MAX_LINE_BYTES {
                return Err(Failure::Content(format!("line {} is longer than 16 MiB", self.line + 1)));
            }
            if end.is_some() {
                self.line += 1;
                return Ok(true);
            }
        }
    }

    /// Takes a byte order mark off the first line, and tells files that cannot be an OBJ by their first bytes.
    fn check_start(&mut self) -> Result<(), Failure> {
        let refuse = |reason: &str| Err(Failure::Content(reason.to_string()));
        if self.raw.starts_with(b"\x1f\x8b") {
            return refuse("is compressed with gzip; unpack it first");
        }
        if self.raw.starts_with(b"\xff\xfe") || self.raw.starts_with(b"\xfe\xff") {
            return refuse("is UTF-16 text; save it as UTF-8");
        }
        if self.raw.starts_with(b"\xef\xbb\xbf") {
            self.raw.drain(..3);
        }
        Ok(())
    }

    /// Turns `raw` into what `tobj` is given, which may be nothing.
    fn clean_line(&mut self) -> Result<(), Failure> {
        let raw = std::mem::take(&mut self.raw);
        let mut words = raw.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let outcome = match words.next() {
            Some(b"v") => {
                self.counts.positions += 1;
                self.clean_vector("v", words, self.counts.positions)
            }
            Some(b"vn") => {
                self.counts.normals += 1;
                self.clean_vector("vn", words, self.counts.normals)
            }
            Some(b"f") => self.clean_face(words),
            Some(b"o" | b"g") => self.clean_name(&raw),
            Some(b"l" | b"p") => {
                self.counts.lines_and_points += 1;
                Ok(())
            }
            _ => Ok(()),
        };
        self.raw = raw;
        outcome
    }

    /// `v` or `vn` with its first three numbers. What follows them is a weight for curves, or colours. What is not
    /// finite is passed on as infinite, so that NaN is left to mean "no normal".
    fn clean_vector<'a>(
        &mut self,
        keyword: &str,
        mut words: impl Iterator<Item = &'a [u8]>,
        count: usize,
    ) -> Result<(), Failure> {
        if count > MAX_VERTICES {
            return self.refuse(format!("more than {MAX_VERTICES} `{keyword}` lines"));
        }
        self.clean.extend_from_slice(keyword.as_bytes());
        for _ in 0..3 {
            let Some(word) = words.next().filter(|word| !word.starts_with(b"#")) else {
                return self.refuse(format!("`{keyword}` needs three numbers"));
            };
            self.clean.push(b' ');
            match std::str::from_utf8(word).ok().and_then(|word| word.parse::<f32>().ok()) {
                Some(number) if number.is_finite() => self.clean.extend_from_slice(word),
                None if !is_not_finite(word) => return self.refuse(format!("`{}` is not a number", quote(word))),
                _ => self.clean.extend_from_slice(b"inf"),
            }
        }
        self.clean.push(b'\n');
        Ok(())
    }

    /// `f` with its corners as `position//normal`.
    fn clean_face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Result<(), Failure> {
        self.clean.push(b'f');
        let mut corners = 0_usize;
        for word in words.take_while(|word| !word.starts_with(b"#")) {
            let mut parts = word.split(|&byte| byte == b'/');
            let position = self.index(word, parts.next().unwrap_or_default(), 0)?;
            // The second part is the texture coordinate; index 0 is how some programs write "no normal".
            let normal = match parts.nth(1) {
                None | Some(b"" | b"0") => 0,
                Some(part) => self.index(word, part, 1)?,
            };
            if parts.next().is_some() {
                return self.refuse(format!("face corner `{}` has more than three parts", quote(word)));
            }
            self.clean.push(b' ');
            push_number(&mut self.clean, position);
            self.clean.extend_from_slice(b"//");
            push_number(&mut self.clean, normal + 1);
            corners += 1;
        }
        if corners < 3 {
            self.counts.short_faces += 1;
            self.clean.clear();
            return Ok(());
        }
        self.block_has_faces = true;
        self.triangles += corners - 2;
        if self.triangles > MAX_TRIANGLES {
            return self.refuse(format!("more than {MAX_TRIANGLES} triangles"));
        }
        self.clean.push(b'\n');
        Ok(())
    }

    /// An index of a face corner (`kind` 0: position, 1: normal) as an absolute one from 1.
    fn index(&mut self, word: &[u8], part: &[u8], kind: usize) -> Result<u64, Failure> {
        let noun = ["vertex", "normal"][kind];
        let defined = [self.counts.positions, self.counts.normals][kind] as u64;
        let number = std::str::from_utf8(part).ok().and_then(|part| part.parse::<i64>().ok());
        let Some(number) = number else {
            return self.refuse(format!("face corner `{}` is not an index", quote(word)));
        };
        if number == 0 {
            return self.refuse(format!("face corner `{}`: indices start at 1, not 0", quote(word)));
        }
        if number < 0 {
            return match defined.checked_sub(number.unsigned_abs()) {
                Some(index) => Ok(index + 1),
                None => self.refuse(format!(
                    "face corner `{}` refers to {noun} {number}, but only {defined} are defined so far",
                    quote(word)
                )),
            };
        }
        let index = number.unsigned_abs();
        if index > self.highest[kind].0 {
            self.highest[kind] = (index, self.line);
        }
        Ok(index)
    }

    /// `o` or `g` with its name as plain text.
    fn clean_name(&mut self, raw: &[u8]) -> Result<(), Failure> {
        self.end_block()?;
        let rest = &raw.trim_ascii()[1..];
        // What is not UTF-8 is most likely Latin-1, whose bytes are the first 256 code points.
        let name = match std::str::from_utf8(rest) {
            Ok(name) => name.to_string(),
            Err(_) => rest.iter().map(|&byte| char::from(byte)).collect(),
        };
        let printable = |c: char| if c.is_control() { ' ' } else { c };
        self.clean.extend_from_slice(b"o ");
        self.clean.extend(name.trim().chars().take(MAX_NAME_CHARS).map(printable).collect::<String>().into_bytes());
        self.clean.push(b'\n');
        Ok(())
    }

    /// Ends the current object's block: `tobj` makes its mesh now, so what its faces refer to has to be there.
    fn end_block(&mut self) -> Result<(), Failure> {
        let defined = [self.counts.positions, self.counts.normals];
        for ((index, line), (defined, noun)) in
            self.highest.into_iter().zip(defined.into_iter().zip(["vertex", "normal"]))
        {
            if index > defined as u64 {
                return Err(Failure::Content(format!(
                    "line {line}: a face refers to {noun} {index}, but there are only {defined}"
                )));
            }
        }
        self.blocks += usize::from(std::mem::take(&mut self.block_has_faces));
        if self.blocks > MAX_OBJECTS {
            return self.refuse(format!("more than {MAX_OBJECTS} objects"));
        }
        self.highest = [(0, 0); 2];
        Ok(())
    }

    fn refuse<T>(&self, reason: String) -> Result<T, Failure> {
        Err(Failure::Content(format!("line {}: {reason}", self.line)))
    }
}

/// Appends a number in decimal, in a fraction of the time that formatting takes.
fn push_number(text: &mut Vec<u8>, mut number: u64) {
    let start = text.len();
    loop {
        text.push(b'0' + (number % 10) as u8);
        number /= 10;
        if number == 0 {
            break;
        }
    }
    text[start..].reverse();
}

/// The spellings of NaN and infinity that Rust does not know, as the C runtime of Windows prints them.
fn is_not_finite(word: &[u8]) -> bool {
    let word = word.to_ascii_lowercase();
    ["#ind", "#inf", "#nan", "#qnan", "#snan", "nan("].iter().any(|mark| {
        let mark = mark.as_bytes();
        word.windows(mark.len()).any(|part| part == mark)
    })
}

/// A word of the file for an error text: at most 40 characters, printable.
fn quote(word: &[u8]) -> String {
    String::from_utf8_lossy(word).chars().take(40).map(|c| if c.is_control() { '?' } else { c }).collect()
}

impl<R: BufRead> Read for ObjLines<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let n = self.fill_buf()?.read(out)?;
        self.consume(n);
        Ok(n)
    }
}

impl<R: BufRead> BufRead for ObjLines<R> {
    /// The rest of the current clean line, or the next one. The reason of a failure is kept for [`ObjLines::finish`].
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.taken >= self.clean.len() && self.failure.is_none() {
            if let Err(failure) = self.advance() {
                self.failure = Some(failure);
            }
        }
        match self.failure {
            Some(_) => Err(io::Error::other("the model cannot be read on")),
            None => Ok(&self.clean[self.taken..]),
        }
    }

    fn consume(&mut self, n: usize) {
        self.taken += n;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What `tobj` would read, without the placeholder normal, or the reason of a failure.
    fn clean(text: &[u8]) -> Result<(String, LineCounts), String> {
        let mut lines = ObjLines::new(text);
        let mut out = String::new();
        let outcome = lines.read_to_string(&mut out);
        match lines.finish() {
            Ok(counts) => {
                outcome.expect("a reader without a failure reads to the end");
                let out = out.strip_prefix("vn nan nan nan\n").expect("the placeholder comes first");
                Ok((out.to_string(), counts))
            }
            Err(Failure::Content(reason)) => Err(reason),
            Err(Failure::Io(error)) => Err(error.to_string()),
        }
    }

    fn text(input: &[u8]) -> String {
        clean(input).expect("usable text").0
    }

    #[test]
    fn only_geometry_and_names_get_through() {
        let input = b"# c\nmtllib ../../etc/x.mtl\no a\nusemtl m\ns 1\nvt 0 0\nv 1 2 3 # c\ncurv 0 1 1 2\nvp 1\n";
        assert_eq!(text(input), "o a\nv 1 2 3\n");
    }

    #[test]
    fn every_line_end_and_continuation_is_understood() {
        assert_eq!(text(b"\xef\xbb\xbfv 1 2 3\r\nv 4 5 6\rv 7 8 9"), "v 1 2 3\nv 4 5 6\nv 7 8 9\n");
        assert_eq!(text(b"v 1 \\\n 2 \\  \r\n 3\nv 4 5 6\\"), "v 1 2 3\nv 4 5 6\n");
        assert_eq!(text(b"# C:\\models\\\nv 1 2 3\n"), "v 1 2 3\n");
        let lines = clean(b"v 1 2 3\r\n\r\n\rv 4 5 x\n").map(|_| ());
        assert_eq!(lines, Err("line 4: `x` is not a number".to_string()));
    }

    #[test]
    fn names_are_decoded_and_made_printable() {
        assert_eq!(text("g  \u{43a}\u{43e}\u{442} 2 \r\n".as_bytes()), "o \u{43a}\u{43e}\u{442} 2\n");
        assert_eq!(text(b"g m\xe6k\x1b[1m\n"), "o m\u{e6}k [1m\n");
        assert_eq!(text(b" g\n"), "o \n");
    }

    #[test]
    fn corners_become_absolute_with_a_normal_each() {
        let input = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1 2/7 -1\nf -3/1/1 2//-1 3/-9/0\nf 1// 2// 3//\n";
        let faces: Vec<String> = text(input).lines().skip(4).map(str::to_string).collect();
        assert_eq!(faces, ["f 1//1 2//1 3//1", "f 1//2 2//2 3//1", "f 1//1 2//1 3//1"]);
    }

    #[test]
    fn numbers_of_other_dialects_are_understood_or_refused() {
        assert_eq!(
            text(b"v 1.#IND -1.#INF 1\nv nan -inf 1e50\nv +1. .5 1E2 0 1 0 1\n"),
            concat!("v inf inf 1\n", "v inf inf inf\n", "v +1. .5 1E2\n",)
        );
        assert_eq!(clean(b"v 1,5 2 3\n").map(|_| ()), Err("line 1: `1,5` is not a number".to_string()));
        assert_eq!(clean(b"\nvn 1 2\n").map(|_| ()), Err("line 2: `vn` needs three numbers".to_string()));
    }

    #[test]
    fn bad_indices_are_told_with_their_line() {
        let with = |face: &str| clean(format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{face}\n# end\n").as_bytes()).map(|_| ());
        let cases = [
            ("f 1 2 4", "line 4: a face refers to vertex 4, but there are only 3"),
            ("f 1 2 -4", "line 4: face corner `-4` refers to vertex -4, but only 3 are defined so far"),
            ("f 1 2 0", "line 4: face corner `0`: indices start at 1, not 0"),
            ("f 1 2 3//2", "line 4: a face refers to normal 2, but there are only 0"),
            ("f 1 2 3/1/1/1", "line 4: face corner `3/1/1/1` has more than three parts"),
            ("f 1 2 x", "line 4: face corner `x` is not an index"),
            ("f 1 2 99999999999999999999", "line 4: face corner `99999999999999999999` is not an index"),
            ("f 1 2 -9223372036854775808", "refers to vertex -9223372036854775808"),
        ];
        for (face, reason) in cases {
            let error = with(face).expect_err(face);
            assert!(error.contains(reason), "{face}: {error}");
        }
        // A face may refer to what its block defines later.
        assert!(clean(b"f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").is_ok());
    }

    #[test]
    fn what_has_no_surface_is_counted() {
        let counts = clean(b"v 0 0 0\nf 1\nf 1 1\nf\nl 1 1 1 1\np 1\n").expect("usable text").1;
        assert_eq!((counts.short_faces, counts.lines_and_points, counts.positions), (3, 2, 1));
    }

    #[test]
    fn other_kinds_of_file_are_recognised() {
        assert!(clean(b"\x1f\x8b\x08rest").is_err_and(|reason| reason.contains("gzip")));
        assert!(clean(b"\xff\xfev\0 \0").is_err_and(|reason| reason.contains("UTF-16")));
    }

    #[test]
    fn an_endless_line_ends() {
        let mut endless = ObjLines::new(io::BufReader::new(io::repeat(b'x')));
        assert!(endless.read_to_end(&mut Vec::new()).is_err());
        assert!(matches!(endless.finish(), Err(Failure::Content(reason)) if reason.contains("16 MiB")));
    }
}
