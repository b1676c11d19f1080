//! A page of HTML, written from top to bottom: text, tables, plots and pictures.
//!
//! The page needs nothing but itself, unless a picture is said to be a file beside it: no script, no style sheet, no
//! font from elsewhere. What it is given as text is escaped, since names of files and devices may hold anything. It
//! can be read on light and dark screens, by a screen reader, and on paper.

use super::table::Table;
use base64::prelude::{Engine, BASE64_STANDARD};
use std::fmt::Write;

const STYLE: &str = "
:root { color-scheme: light dark; --page: #faf9f6; --ink: #222; --faint: #595959; --line: #ccc; --inset: #efece5; }
@media (prefers-color-scheme: dark) {
:root { --page: #1b1b1d; --ink: #e6e4df; --faint: #a9a7a1; --line: #46464a; --inset: #29292c; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1200px; padding: 2rem; background: var(--page); color: var(--ink); \
font: 16px/1.5 system-ui, sans-serif; }
h1 { font-weight: 600; margin: 0 0 0.3rem; line-height: 1.2; }
h2 { font-weight: 600; margin: 3rem 0 0.3rem; line-height: 1.25; }
p { max-width: 45rem; margin: 0.3rem 0 1rem; }
h1, h2, p, figcaption, caption, dd, td, th { overflow-wrap: anywhere; }
a { color: inherit; }
figure { margin: 0.6rem 0 1rem; }
figure img, figure svg { display: block; max-width: 100%; height: auto; background: #fff; \
border: 1px solid var(--line); border-radius: 4px; }
figcaption, caption { color: var(--faint); font-size: 0.9rem; padding-top: 0.3rem; }
.row { display: flex; flex-wrap: wrap; gap: 1rem; align-items: flex-end; }
.row figure { flex: 1 1 300px; max-width: 560px; margin: 0; }
.grid { display: grid; gap: 1rem; align-items: end; margin-bottom: 1rem; }
.grid figure { margin: 0; }
.row img, .grid img { width: 100%; }
figure img.strip { height: 128px; }
.repeated { aspect-ratio: 1; background-size: 50% 50%; border: 1px solid var(--line); border-radius: 4px; \
print-color-adjust: exact; -webkit-print-color-adjust: exact; }
.scroll { overflow-x: auto; margin: 0 0 1rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
caption { text-align: left; padding: 0 0 0.3rem; }
th, td { padding: 0.25rem 0.8rem; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
thead th { border-bottom: 2px solid var(--faint); vertical-align: bottom; }
tbody th { font-weight: normal; }
.number { text-align: right; overflow-wrap: normal; }
td.number { white-space: nowrap; }
dl { display: grid; grid-template-columns: fit-content(40%) minmax(0, 1fr); gap: 0.2rem 1.2rem; margin: 0.3rem 0 1rem; }
dt { color: var(--faint); }
dd { margin: 0; }
pre { background: var(--inset); border-radius: 4px; padding: 0.6rem 0.8rem; overflow-x: auto; font-size: 0.85rem; \
white-space: pre-wrap; }
.note { color: var(--faint); font-size: 0.85rem; }
@page { margin: 15mm; }
@media print { :root { color-scheme: light; --page: #fff; --ink: #000; --faint: #444; --line: #999; --inset: #f2f2f2; }
body { max-width: none; padding: 0; font-size: 11pt; } .scroll { overflow: visible; }
h2 { break-after: avoid; } figure, tr, pre { break-inside: avoid; } }
";

/// A page that is being written. What is added stands below what was there.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    body: String,
}

/// A picture with what is said about it.
#[derive(Debug, Clone, Copy)]
pub struct Picture<'a> {
    source: Source<'a>,
    alt: &'a str,
    caption: &'a str,
    shape: Shape,
}

#[derive(Debug, Clone, Copy)]
enum Source<'a> {
    Png(&'a [u8]),
    File(&'a str),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shape {
    Plain,
    Strip,
    Repeated,
}

impl Page {
    /// A page with nothing but its title.
    pub fn new(title: &str) -> Self {
        Page { title: title.to_owned(), body: String::new() }
    }

    /// Begins a part of the page. All headings are of one level, so that none can be left out.
    pub fn heading(&mut self, text: &str) -> &mut Self {
        self.add(format_args!("<h2>{}</h2>", escape(text)))
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) -> &mut Self {
        self.add(format_args!("<p>{}</p>", escape(text)))
    }

    /// A command line, or other text for a computer.
    pub fn command(&mut self, text: &str) -> &mut Self {
        self.add(format_args!("<pre>{}</pre>", escape(text)))
    }

    /// A remark in small letters.
    pub fn note(&mut self, text: &str) -> &mut Self {
        self.add(format_args!("<div class=\"note\">{}</div>", escape(text)))
    }

    /// A table whose first column names its rows.
    pub fn table(&mut self, table: &Table, caption: &str) -> &mut Self {
        let class = |column| if table.is_words(column) { "" } else { " class=\"number\"" };
        let headers = (0..).zip(table.headers());
        let headers: String =
            headers.map(|(column, text)| format!("<th scope=\"col\"{}>{}</th>", class(column), escape(text))).collect();
        let mut rows = String::new();
        for cells in table.rows() {
            rows.push_str("<tr>");
            for (column, cell) in (0..).zip(cells) {
                let (open, close) = if column == 0 { ("th scope=\"row\"", "th") } else { ("td", "td") };
                rows.push_str(&format!("<{open}{}>{}</{close}>", class(column), escape(&cell.shown())));
            }
            rows.push_str("</tr>\n");
        }
        self.add(format_args!(
            "<div class=\"scroll\"><table>\n<caption>{}</caption>\n<thead><tr>{headers}</tr></thead>\n<tbody>\n{rows}\
             </tbody>\n</table></div>",
            escape(caption)
        ))
    }

    /// A drawing of the program's own: this text alone goes into the page as it is.
    pub fn svg(&mut self, svg: &str, caption: &str) -> &mut Self {
        self.add(format_args!("<figure>{}{}</figure>", svg.trim_end(), figcaption(caption)))
    }

    /// A picture in its own size, if that fits.
    pub fn picture(&mut self, picture: &Picture) -> &mut Self {
        self.add(format_args!("{}", picture.figure()))
    }

    /// Pictures side by side, as many as fit.
    pub fn row(&mut self, pictures: &[Picture]) -> &mut Self {
        self.add(format_args!("<div class=\"row\">\n{}</div>", figures(pictures)))
    }

    /// Pictures in rows of `columns`, however wide the page is.
    pub fn grid(&mut self, columns: usize, pictures: &[Picture]) -> &mut Self {
        let columns = columns.max(1);
        self.add(format_args!(
            "<div class=\"grid\" style=\"grid-template-columns: repeat({columns}, minmax(0, 1fr))\">\n{}</div>",
            figures(pictures)
        ))
    }

    /// Names with what they stand for: parameters, the device, the version.
    pub fn definitions<N: AsRef<str>, V: AsRef<str>>(&mut self, pairs: &[(N, V)]) -> &mut Self {
        let entry =
            |(name, value): &(N, V)| format!("<dt>{}</dt><dd>{}</dd>\n", escape(name.as_ref()), escape(value.as_ref()));
        self.add(format_args!("<dl>\n{}</dl>", pairs.iter().map(entry).collect::<String>()))
    }

    /// The page's text.
    pub fn finish(&self) -> String {
        let (title, body) = (escape(&self.title), &self.body);
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
             <style>{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n{body}</main>\n</body>\n</html>\n"
        )
    }

    fn add(&mut self, html: std::fmt::Arguments) -> &mut Self {
        // Writing to a string cannot fail.
        let _ = writeln!(self.body, "{html}");
        self
    }
}

impl<'a> Picture<'a> {
    /// A picture that the page itself holds. `alt` says to those who cannot see it what it shows.
    pub fn png(bytes: &'a [u8], alt: &'a str, caption: &'a str) -> Self {
        Picture { source: Source::Png(bytes), alt, caption, shape: Shape::Plain }
    }

    /// A file beside the page, which the picture leads to.
    pub fn file(path: &'a str, alt: &'a str, caption: &'a str) -> Self {
        Picture { source: Source::File(path), alt, caption, shape: Shape::Plain }
    }

    /// The same as a paint strip is best seen: low, however wide.
    pub fn strip(self) -> Self {
        Picture { shape: Shape::Strip, ..self }
    }

    /// The same twice across and twice down.
    pub fn repeated(self) -> Self {
        Picture { shape: Shape::Repeated, ..self }
    }

    fn figure(&self) -> String {
        let (address, alt) = (self.source.address(), escape(self.alt));
        let picture = match self.shape {
            Shape::Plain => format!("<img src=\"{address}\" alt=\"{alt}\">"),
            Shape::Strip => format!("<img class=\"strip\" src=\"{address}\" alt=\"{alt}\">"),
            Shape::Repeated => format!(
                "<div class=\"repeated\" role=\"img\" aria-label=\"{alt}\" \
                 style=\"background-image: url({address})\"></div>"
            ),
        };
        let picture = match (self.source, self.shape) {
            (Source::File(_), Shape::Plain | Shape::Strip) => format!("<a href=\"{address}\">{picture}</a>"),
            _ => picture,
        };
        format!("<figure>{picture}{}</figure>", figcaption(self.caption))
    }
}

impl Source<'_> {
    /// Where the picture is, in characters that mean nothing to HTML or CSS.
    fn address(&self) -> String {
        match self {
            Source::Png(bytes) => format!("data:image/png;base64,{}", BASE64_STANDARD.encode(bytes)),
            Source::File(path) => path
                .bytes()
                .map(|byte| match byte {
                    b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                        char::from(byte).to_string()
                    }
                    _ => format!("%{byte:02X}"),
                })
                .collect(),
        }
    }
}

fn figures(pictures: &[Picture]) -> String {
    pictures.iter().map(|picture| picture.figure() + "\n").collect()
}

fn figcaption(caption: &str) -> String {
    match caption {
        "" => String::new(),
        _ => format!("<figcaption>{}</figcaption>", escape(caption)),
    }
}

/// Text as it is written in HTML and XML, between tags and within quotes.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
pub mod tests {
    use super::super::error_map::ErrorMap;
    use super::super::picture::png;
    use super::super::plot::{Plot, Point, Series};
    use super::super::table::Cell;
    use super::*;

    /// Asserts that every tag is closed, except those of the names in `void`, and in the right order.
    pub fn assert_balanced(text: &str, void: &[&str]) {
        let mut open = Vec::new();
        for piece in text.split('<').skip(1) {
            let (tag, after) = piece.split_once('>').expect("an end of every tag");
            assert!(!after.contains('>') || open.contains(&"style"), "a stray > after <{tag}>");
            assert_eq!(tag.matches('"').count() % 2, 0, "an open quote in <{tag}>");
            let name = tag.split([' ', '/']).find(|word| !word.is_empty()).expect("a name");
            match tag.strip_prefix('/') {
                Some(closed) => assert_eq!(open.pop(), Some(closed)),
                None if tag.ends_with('/') || tag.starts_with('!') || void.contains(&name) => {}
                None => open.push(name),
            }
        }
        assert!(open.is_empty(), "left open: {open:?}");
    }

    /// The smallest PNG that there is: one grey pixel.
    const PNG: [u8; 67] = [
        0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00,
        0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00, 0x00, 0x00,
        0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x68, 0x00, 0x00, 0x00, 0x82, 0x00, 0x81, 0x77, 0xcd, 0x72,
        0xb6, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82,
    ];
    const PNG_BASE64: &str =
        "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg==";
    const VOID: [&str; 2] = ["meta", "img"];

    #[test]
    fn a_picture_is_within_the_page_and_a_file_beside_it_is_named() {
        let mut page = Page::new("Pictures");
        page.picture(&Picture::png(&PNG, "a dot", "A dot")).picture(&Picture::file("a b/ü.png", "a file", ""));
        page.picture(&Picture::file("x);'\"<.png", "", "").repeated());
        let html = page.finish();
        let figure = format!("<img src=\"data:image/png;base64,{PNG_BASE64}\" alt=\"a dot\">");
        assert!(html.contains(&format!("<figure>{figure}<figcaption>A dot</figcaption></figure>")), "{html}");
        assert!(html.contains("<figure><a href=\"a%20b/%C3%BC.png\"><img src=\"a%20b/%C3%BC.png\""), "{html}");
        assert!(html.contains("url(x%29%3B%27%22%3C.png)"), "{html}");
        assert_balanced(&html, &VOID);
    }

    #[test]
    fn all_text_is_escaped() {
        let evil = "<b>\"&'";
        let safe = "&lt;b&gt;&quot;&amp;&#39;";
        let mut table = Table::new([evil]);
        table.row([evil.into()]);
        let mut page = Page::new(evil);
        page.heading(evil).paragraph(evil).command(evil).note(evil).definitions(&[(evil, evil)]).table(&table, evil);
        page.svg("<svg></svg>", evil).picture(&Picture::png(&PNG, evil, evil));
        page.grid(0, &[Picture::png(&PNG, evil, evil).strip(), Picture::png(&PNG, evil, evil).repeated()]);
        let html = page.finish();
        assert!(!html.contains("<b>"), "{html}");
        // The title twice, four texts, a definition, a table of three, a caption, and three pictures with two.
        assert_eq!(html.matches(safe).count(), 2 + 4 + 2 + 3 + 1 + 3 * 2, "{html}");
        assert_balanced(&html, &VOID);
    }

    #[test]
    fn a_table_names_its_columns_and_rows() {
        let mut table = Table::new(["paint", "error"]);
        table.row(["red".into(), Cell::Number(0.25, 1)]);
        table.row(["green".into()]);
        let mut page = Page::new("Tables");
        let html = page.table(&table, "Errors").finish();
        for part in [
            "<caption>Errors</caption>",
            "<th scope=\"col\">paint</th><th scope=\"col\" class=\"number\">error</th>",
            "<tr><th scope=\"row\">red</th><td class=\"number\">0.2</td></tr>",
            "<tr><th scope=\"row\">green</th><td class=\"number\">-</td></tr>",
        ] {
            assert!(html.contains(part), "{part} in {html}");
        }
    }

    #[test]
    fn a_whole_report_is_one_file() {
        let wave = |name: &str, scale: f64, half_width| {
            let point = |step| {
                let x = f64::from(step) * 128.0;
                Point { x, y: scale * (1.0 + x.sqrt() / 9.0 + (x / 300.0).sin() / 4.0), half_width }
            };
            Series { name: name.into(), points: (1..=8).map(point).collect() }
        };
        let plot = |title: &str, series| Plot {
            title: title.into(),
            x_label: "side / px".into(),
            y_label: "time / ms".into(),
            series,
        };
        let names = ["object-based", "image-based", "view-aligned", "view-dependent"];
        let four = (1..).zip(names).map(|(scale, name)| wave(name, f64::from(scale), None)).collect();
        let two = vec![wave("before", 0.021, Some(0.004)), wave("after", 0.012, Some(0.002))];
        let errors = (0..64 * 40).map(|place| {
            let (x, y) = ((place % 64) as f32 - 32.0, (place / 64) as f32 - 20.0);
            (x.hypot(y) < 19.0).then(|| 0.0337 * (1.0 + (x / 5.0).sin() * (y / 4.0).cos()))
        });
        let map = ErrorMap::new(64, 40, errors.collect()).expect("a map").picture();
        let map = png(map).expect("a picture");
        let dots: Vec<Vec<u8>> = (1..=6)
            .map(|index| png(image::RgbaImage::from_pixel(60, 40, image::Rgba([40 * index, 90, 160, 255]))))
            .collect::<Result<_, _>>()
            .expect("pictures");
        let captions: Vec<String> = (1..=6).map(|index| format!("({index}) A colour")).collect();
        let cells: Vec<Picture> =
            dots.iter().zip(&captions).map(|(dot, caption)| Picture::png(dot, "a plain colour", caption)).collect();
        let mut table = Table::new(["technique", "error", "time / ms"]);
        for (index, name) in (1..).zip(names) {
            table.row([name.into(), Cell::Number(0.1 / f64::from(index), 4), Cell::Number(f64::from(index) * 7.0, 1)]);
        }
        let mut page = Page::new("Measurements");
        page.paragraph("What was measured, and on what.");
        page.definitions(&[("Device", "llvmpipe (a CPU)"), ("Version", "0.1.0")]);
        page.heading("Times").svg(&plot("Time of a frame", four).svg().expect("a plot"), "Four techniques.");
        page.svg(&plot("Time of a pass", two).svg().expect("a plot"), "Bars are 95 % confidence intervals.");
        page.heading("Errors").picture(&Picture::png(&map, "errors within a disc", "Errors by place"));
        page.table(&table, "Errors and times of the techniques");
        page.heading("Pictures").grid(3, &cells);
        let html = page.finish();
        assert_balanced(&html, &VOID);
        assert_eq!(html.matches("<svg ").count(), 2);
        assert_eq!(html.matches("src=\"data:image/png;base64,").count(), 7);
        let elsewhere = html.replace("http://www.w3.org/2000/svg", "");
        for word in ["http", "<script", "<link", "@import", "url("] {
            assert!(!elsewhere.contains(word), "{word}");
        }
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("report.html"), &html).expect("written");
    }
}
