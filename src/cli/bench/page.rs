//! The report as a page of HTML that needs nothing but itself.

use super::super::failure::Result;
use super::super::report_page::Page;
use super::report::{Part, TITLE};

/// The page's text.
pub fn html(parts: &[Part]) -> Result<String> {
    let mut page = Page::new(TITLE);
    let mut plotted = false;
    for part in parts {
        match part {
            Part::Heading(heading) => page.heading(heading),
            Part::Note(note) => page.paragraph(note),
            Part::Facts(facts) => page.definitions(facts),
            Part::Table(caption, table) | Part::Detail(caption, table) => page.table(table, caption),
            Part::Plot(plot, caption) => {
                if !std::mem::replace(&mut plotted, true) {
                    page.heading("Plots");
                }
                page.svg(&plot.svg()?, caption)
            }
        };
    }
    page.note("All numbers, and every sample, are in bench.json; bench.csv has a row for each measurement.");
    Ok(page.finish())
}

#[cfg(test)]
mod tests {
    use super::super::super::report_page::tests::assert_balanced;
    use super::super::report::tests::example_parts;
    use super::*;

    #[test]
    fn the_page_is_well_formed_and_needs_nothing_else() {
        let html = html(&example_parts()).expect("a page");
        assert_balanced(&html, &["meta"]);
        assert_eq!((html.matches("<svg ").count(), html.matches("<h2>Plots</h2>").count()), (3, 1));
        assert_eq!(html.matches("<table>").count(), 2 * (5 + 2) + 2 + 2 + 1);
        assert!(html.contains("<h2>D1: A &lt;Slow&gt; &quot;GPU&quot;, | old</h2>"), "{html}");
        let elsewhere = html.replace("http://www.w3.org/2000/svg", "");
        for word in ["http", "<script", "<link", "@import", "url(", "<Slow>"] {
            assert!(!elsewhere.contains(word), "{word}");
        }
    }
}
