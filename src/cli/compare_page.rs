//! The report of `impasto compare`: table 10.1 with the thesis's figures beside ours, what the thesis found and whether
//! it holds, the grid of figures 10.1 to 10.3, maps and a plot.

use super::compare::{Measured, PLOTTED, TECHNIQUES};
use super::failure::Result;
use super::meter::{Figures, FIGURE_HEADERS};
use super::plot::{Plot, Point, Series};
use super::report_page::{Page, Picture};
use super::table::{Cell, Table};
use super::techniques::TechniqueName;
use impasto::metric::Score;
use serde_json::{json, Value};

/// What was compared.
pub struct Report<'a> {
    pub model: &'a str,
    pub turn_deg: f32,
    /// The paints' names.
    pub paints: &'a [String],
    /// Their strips as PNG.
    pub strips: &'a [Vec<u8>],
    pub measured: &'a [Measured],
    /// The map of each as PNG.
    pub maps: &'a [Vec<u8>],
}

/// Table 10.1 of the thesis: similarity, shading, frame-to-frame coherence in image space.
const THESIS: [(TechniqueName, [f64; 3]); 3] = [
    (TechniqueName::Image, [0.07539, 0.00536, 0.00297]),
    (TechniqueName::Aligned, [0.08048, 0.00521, 0.00016]),
    (TechniqueName::Dependent, [0.10197, 0.00582, 0.00547]),
];

/// The figures of the table, in its order: heading and name.
const COLUMNS: [(&str, &str); 9] = [
    ("similarity", "similarity"),
    ("shading, squared", "shading_error_squared"),
    ("shading, absolute", "shading_error_absolute"),
    ("coherence, image", "coherence_image_space"),
    ("coherence, object", "coherence_object_space"),
    ("co-occurrence", "cooccurrence_error"),
    ("sliced Wasserstein", "sliced_wasserstein"),
    ("FLIP to next", "flip"),
    ("first frame, s", "first_frame_seconds"),
];

/// What the thesis found, and whether it is so here.
struct Finding {
    claim: &'static str,
    verdict: Verdict,
    figures: String,
    /// Why it may be otherwise here.
    why: &'static str,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    So,
    NotSo,
    /// The confidence intervals leave it open.
    Open,
}

impl Verdict {
    fn word(self) -> &'static str {
        match self {
            Verdict::So => "yes",
            Verdict::NotSo => "no",
            Verdict::Open => "open",
        }
    }

    fn sentence(self) -> &'static str {
        match self {
            Verdict::So => "It is so here",
            Verdict::NotSo => "It is not so here",
            Verdict::Open => "It cannot be told here, within the confidence of the figures",
        }
    }
}

/// Whether one mean is below all others, each with half the width of its confidence interval.
fn below(one: (f64, f64), others: [(f64, f64); 2]) -> Verdict {
    let sure = others.map(|other| {
        let apart = other.0 - one.0;
        if apart.abs() <= one.1.hypot(other.1) {
            Verdict::Open
        } else if apart > 0.0 {
            Verdict::So
        } else {
            Verdict::NotSo
        }
    });
    // One that is surely lower is enough against it.
    [Verdict::NotSo, Verdict::Open].into_iter().find(|verdict| sure.contains(verdict)).unwrap_or(Verdict::So)
}

/// A technique's name on the command line.
pub fn word(technique: TechniqueName) -> &'static str {
    match technique {
        TechniqueName::Image => "image",
        TechniqueName::Object => "object",
        TechniqueName::Aligned => "aligned",
        TechniqueName::Dependent => "dependent",
    }
}

fn title(technique: TechniqueName) -> &'static str {
    match technique {
        TechniqueName::Image => "Image-based texture synthesis",
        TechniqueName::Object => "Object-based texture mapping",
        TechniqueName::Aligned => "View-aligned 3D texture projection",
        TechniqueName::Dependent => "View-dependent interpolation",
    }
}

impl Report<'_> {
    fn of(&self, technique: TechniqueName) -> impl Iterator<Item = &Measured> {
        self.measured.iter().filter(move |one| one.technique == technique)
    }

    /// The mean over all paints.
    fn mean(&self, technique: TechniqueName, figure: &str) -> f64 {
        let values: Vec<f64> = self.of(technique).filter_map(|one| one.figures.get(figure)).collect();
        values.iter().sum::<f64>() / values.len().max(1) as f64
    }

    fn table(&self) -> Table {
        let mut table = Table::new(["technique"].into_iter().chain(COLUMNS.map(|(heading, _)| heading)));
        for technique in TECHNIQUES {
            let decimals = |name: &str| if name == "first_frame_seconds" { 2 } else { 5 };
            let cells = COLUMNS.map(|(_, name)| Cell::Number(self.mean(technique, name), decimals(name)));
            table.row(std::iter::once(Cell::from(title(technique))).chain(cells));
        }
        table
    }

    /// The mean over all paints with half the width of its 95 % confidence interval, which may be unknown: infinite,
    /// then.
    fn interval(&self, technique: TechniqueName, figure: &str) -> (f64, f64) {
        let widths = self.of(technique).map(|one| one.figures.half_width(figure).unwrap_or(f64::INFINITY));
        let squares: f64 = widths.map(|half| half * half).sum();
        (self.mean(technique, figure), squares.sqrt() / self.paints.len().max(1) as f64)
    }

    fn findings(&self) -> Vec<Finding> {
        let compared = [TechniqueName::Image, TechniqueName::Aligned, TechniqueName::Dependent];
        let values = |figure: &str| compared.map(|technique| self.interval(technique, figure));
        let told = |figure: &str| {
            let part = |technique: TechniqueName| {
                let (mean, half) = self.interval(technique, figure);
                let half = if half.is_finite() { format!("{half:.5}") } else { "unknown".to_owned() };
                format!("{} {mean:.5} +- {half}", word(technique))
            };
            compared.map(part).join(", ")
        };
        let negative = |(mean, half): (f64, f64)| (-mean, half);
        let [image, aligned, dependent] = values("similarity");
        let shading = values("shading_error_squared");
        let calm = values("coherence_image_space");
        // The least and the greatest, as they are and as far apart as their intervals allow.
        let range = |value: fn(&(f64, f64)) -> f64| {
            let values = shading.iter().map(value);
            values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)))
        };
        let near = |(low, high): (f64, f64)| high < 1.5 * low;
        let (low, high) = (range(|v| v.0 - v.1).0, range(|v| v.0 + v.1).1);
        vec![
            Finding {
                claim: "Image-based synthesis is the most similar to the sample.",
                verdict: below(image, [aligned, dependent]),
                figures: told("similarity"),
                why: "Its error stands where the shade changes quickly (see the maps): a block brings the texture of one \
                      shade to pixels of other shades, while view-aligned projection, whose levels here keep their \
                      contrast between levels, picks its level anew at every pixel. Smaller blocks, or a smaller k, \
                      bring it closer.",
            },
            Finding {
                claim: "View-dependent interpolation is the least similar.",
                verdict: below(negative(dependent), [negative(image), negative(aligned)]),
                figures: told("similarity"),
                why: "Here the contrast that blending takes is given back, and few slices are blended at a time.",
            },
            Finding {
                claim: "The three of table 10.1 have about the same shading error (within a factor of 1.5).",
                verdict: match (near(range(|v| v.0)), near((low, high))) {
                    (_, true) => Verdict::So,
                    (true, false) => Verdict::Open,
                    (false, _) => Verdict::NotSo,
                },
                figures: told("shading_error_squared"),
                why: "Colour comes from the shade itself in all of them; what differs is how well the nearest blocks of \
                      the strip can be told apart by their texture.",
            },
            Finding {
                claim: "View-aligned projection is the calmest in image space.",
                verdict: below(calm[1], [calm[0], calm[2]]),
                figures: told("coherence_image_space"),
                why: "Its texture stands still in the picture; only the shade moves.",
            },
        ]
    }

    fn plot(&self) -> Plot {
        let series = TECHNIQUES.map(|technique| Series {
            name: title(technique).to_owned(),
            points: PLOTTED
                .into_iter()
                .filter_map(|block| {
                    let of_block = |one: &Measured| {
                        one.by_block.iter().filter(|(size, _)| *size == block).flat_map(|(_, v)| v.clone()).collect()
                    };
                    let values: Vec<f64> = self.of(technique).flat_map(|one| -> Vec<f64> { of_block(one) }).collect();
                    let score = Score::of(&values)?;
                    Some(Point { x: f64::from(block), y: score.mean, half_width: score.half_width })
                })
                .collect(),
        });
        Plot {
            title: "Similarity by the side of the compared blocks".to_owned(),
            x_label: "side of a block, pixels".to_owned(),
            y_label: "mean distance of the nearest".to_owned(),
            series: series.into(),
        }
    }
}

/// The table for the terminal.
pub fn text(report: &Report) -> String {
    let mut text = report.table().text();
    for finding in report.findings() {
        text.push_str(&format!("{:4}  {} ({})\n", finding.verdict.word(), finding.claim, finding.figures));
    }
    text.trim_end().to_owned()
}

/// All figures: a row for each paint, technique and figure.
pub fn csv(report: &Report) -> String {
    let mut table = Table::new(["paint", "technique"].into_iter().chain(FIGURE_HEADERS));
    for one in report.measured {
        one.figures.rows_after(&mut table, &[report.paints[one.paint].as_str(), word(one.technique)]);
    }
    table.csv()
}

/// All figures by paint and technique.
pub fn figures_json(report: &Report) -> Value {
    let one = |one: &Measured| {
        json!({
            "paint": report.paints[one.paint], "technique": word(one.technique), "figures": one.figures.json(),
            "similarity_by_block": one.by_block.iter().map(|(block, values)| {
                let mut figures = Figures::default();
                figures.score("similarity", values);
                json!({ "block_size": block, "similarity": figures.json()["similarity"] })
            }).collect::<Vec<_>>(),
        })
    };
    report.measured.iter().map(one).collect()
}

/// What the thesis found, and whether it holds.
pub fn findings_json(report: &Report) -> Value {
    let one = |Finding { claim, verdict, figures, .. }: Finding| json!({ "claim": claim, "holds": verdict.word(), "figures": figures });
    report.findings().into_iter().map(one).collect()
}

/// The whole report as JSON.
pub fn json(report: &Report, device: &Value, parameters: &Value) -> String {
    let thesis: Vec<Value> = THESIS
        .iter()
        .map(|(technique, [similarity, shading, coherence])| {
            json!({ "technique": word(*technique), "similarity": similarity, "shading": shading,
                    "coherence_image_space": coherence })
        })
        .collect();
    let document = json!({
        "tool": "impasto", "version": env!("CARGO_PKG_VERSION"), "device": device, "parameters": parameters,
        "results": figures_json(report), "findings": findings_json(report), "thesis_table_10_1": thesis,
    });
    format!("{document:#}\n")
}

/// The page.
pub fn html(report: &Report, device: &Value, parameters: &Value) -> Result<String> {
    let mut page = Page::new("The techniques, compared");
    page.paragraph(&format!(
        "{} with {} paint(s). Every figure is an error: 0 is best. Similarity and shading error are means over random \
         pixels and their nearest pixels in the strip; coherence compares a frame with the next, for which the camera \
         turned {} degrees around the model (chapter 9 of the thesis).",
        report.model,
        report.paints.len(),
        report.turn_deg
    ));
    page.heading("Figures");
    page.table(&report.table(), "Means over all paints; the time of a first frame includes all preparation.");
    let mut table = Table::new(["technique", "similarity", "shading", "frame-to-frame"]);
    for (technique, values) in THESIS {
        table.row(std::iter::once(Cell::from(title(technique))).chain(values.map(|value| Cell::Number(value, 5))));
    }
    page.table(&table, "Table 10.1 of the thesis: its own renderings, paint, blocks and size.");
    page.paragraph(
        "The thesis does not give its block size, nor say whether its shading error is squared; by its size it is most \
         likely squared. So orders compare with it, and single figures do not. It measured coherence in image space.",
    );
    page.heading("What the thesis found");
    for finding in report.findings() {
        let why = if finding.verdict == Verdict::So { String::new() } else { format!(" {}", finding.why) };
        let sentence = finding.verdict.sentence();
        page.paragraph(&format!("{} {sentence}: {}.{why}", finding.claim, finding.figures));
    }
    page.paragraph(
        "Image-based frames are synthesised anew here, each for itself, with nothing carried over from the frame before: \
         their coherence is that of no coherence at all. View-aligned texture stands still in the picture.",
    );
    page.heading("Pictures");
    for (number, paint) in report.paints.iter().enumerate() {
        page.picture(&Picture::png(&report.strips[number], paint, paint).strip());
        let pictures: Vec<Picture> = report
            .measured
            .iter()
            .filter(|one| one.paint == number)
            .map(|one| Picture::png(&one.frame, title(one.technique), title(one.technique)))
            .collect();
        page.grid(4, &pictures);
    }
    page.heading("Similarity by block size");
    page.svg(&report.plot().svg()?, "Over all paints, with 95 % confidence intervals.");
    page.heading("Where the texture differs from the sample");
    for (number, paint) in report.paints.iter().enumerate() {
        let captions: Vec<String> =
            TECHNIQUES.iter().map(|technique| format!("{}, {paint}", title(*technique))).collect();
        let maps = report.measured.iter().zip(report.maps).filter(|(one, _)| one.paint == number);
        let pictures: Vec<Picture> =
            maps.zip(&captions).map(|((_, map), caption)| Picture::png(map, caption, caption)).collect();
        page.grid(4, &pictures);
    }
    page.heading("All figures");
    for one in report.measured {
        let mut table = Table::new(FIGURE_HEADERS);
        one.figures.rows(&mut table);
        page.table(&table, &format!("{}, {}", report.paints[one.paint], title(one.technique)));
    }
    page.heading("How it was made");
    let mut pairs = vec![("impasto".to_owned(), env!("CARGO_PKG_VERSION").to_owned())];
    for (group, value) in [("device", device), ("", parameters)] {
        for (name, value) in value.as_object().into_iter().flatten() {
            let name = if group.is_empty() { name.clone() } else { format!("{group} {name}") };
            pairs.push((name, value.as_str().map_or_else(|| value.to_string(), str::to_owned)));
        }
    }
    page.definitions(&pairs);
    Ok(page.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_holds_only_beyond_the_intervals() {
        let one = (1.0, 0.1);
        assert_eq!(below(one, [(1.3, 0.1), (2.0, 0.5)]), Verdict::So);
        assert_eq!(below(one, [(1.1, 0.1), (2.0, 0.5)]), Verdict::Open);
        assert_eq!(below(one, [(1.1, 0.1), (0.5, 0.1)]), Verdict::NotSo);
        assert_eq!(below(one, [(0.9, 0.1), (0.95, 0.1)]), Verdict::Open);
    }
}
