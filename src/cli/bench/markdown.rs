//! The report in Markdown, to be pasted into an issue (GitHub's dialect, which has tables).

use super::super::table::Table;
use super::report::{Part, TITLE};

/// The report's text.
pub fn markdown(parts: &[Part]) -> String {
    let mut text = format!("# {TITLE}\n");
    for part in parts {
        text += &match part {
            Part::Heading(heading) => format!("\n## {}\n", escape(heading)),
            Part::Note(note) => format!("\n{}\n", escape(note)),
            Part::Facts(facts) => {
                let line = |(name, value): &(String, String)| format!("- {}: {}\n", escape(name), escape(value));
                format!("\n{}", facts.iter().map(line).collect::<String>())
            }
            Part::Table(caption, table) => format!("\n**{}**\n\n{}", escape(caption), rows(table)),
            Part::Detail(caption, table) => {
                format!("\n<details><summary>{}</summary>\n\n{}\n</details>\n", escape(caption), rows(table))
            }
            Part::Plot(..) => continue,
        };
    }
    text
}

fn rows(table: &Table) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let headers = table.headers().into_iter().map(escape).collect();
    let rule = |column| if table.is_words(column) { "---" } else { "---:" }.to_owned();
    let rules = (0..table.headers().len()).map(rule).collect();
    let rows = table.rows().map(|row| row.into_iter().map(|cell| escape(&cell.shown())).collect());
    [headers, rules].into_iter().chain(rows).map(line).collect()
}

/// Text that stays on its line and in its cell, and means nothing to Markdown or HTML.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '&' => escaped.push_str("&amp;"),
            '|' | '\\' | '`' | '*' | '[' | ']' | '~' | '#' => escaped.extend(['\\', character]),
            _ if character.is_control() => escaped.push(' '),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::super::report::tests::example_parts;
    use super::*;

    #[test]
    fn all_rows_of_a_table_have_as_many_cells_as_its_head() {
        let text = markdown(&example_parts());
        let cells = |line: &str| line.replace("\\|", "").matches('|').count();
        let mut tables = 0;
        let mut width = None;
        for line in text.lines() {
            match line.starts_with('|') {
                true => {
                    tables += usize::from(width.is_none());
                    assert_eq!(cells(line), *width.get_or_insert(cells(line)), "{line}");
                }
                false => width = None,
            }
        }
        // Five kinds and two details on two devices, two tables side by side, two of comparison, one of failures.
        assert_eq!(tables, 2 * (5 + 2) + 2 + 2 + 1, "{text}");
    }

    #[test]
    fn names_are_escaped_and_what_an_issue_needs_is_there() {
        let text = markdown(&example_parts());
        for line in [
            "# impasto bench",
            "## D1: A &lt;Slow&gt; \"GPU\", \\| old",
            "- driver: a driver 1.2.3, Vulkan 1.3.280",
            "- system: Debian GNU/Linux 12 (bookworm), linux 6.1.0, x86_64",
            "- processor: A Processor \\| at 3 GHz, 8 threads",
            "| measurement | GPU p50 | p95 | wall p50 | p95 | max | unit | MiB | check |",
            "| --- | ---: | ---: | ---: | ---: | ---: | --- | ---: | --- |",
            "## Compared with old/bench.json",
        ] {
            assert!(text.lines().any(|one| one == line), "{line} in\n{text}");
        }
        assert!(text.contains("bytes change from round to round \\| twice |\n"), "{text}");
        assert_eq!(escape("a_b\n`#1` [x](y) \\ *"), "a_b \\`\\#1\\` \\[x\\](y) \\\\ \\*");
    }
}
