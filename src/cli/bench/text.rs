//! The report for a terminal: no plots, and no tables of details.

use super::super::table::on_one_line;
use super::report::Part;

/// The report's lines.
pub fn text(parts: &[Part]) -> String {
    let mut text = String::new();
    for part in parts {
        match part {
            Part::Heading(heading) => {
                let heading = on_one_line(heading);
                text += &format!("\n{heading}\n{}\n", "=".repeat(heading.chars().count()));
            }
            Part::Note(note) => text += &format!("{}\n", on_one_line(note)),
            Part::Facts(facts) => {
                let width = facts.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
                for (name, value) in facts {
                    text += &format!("{name:<width$}  {}\n", on_one_line(value));
                }
            }
            Part::Table(caption, table) => text += &format!("\n{}\n{}", on_one_line(caption), table.text()),
            Part::Detail(..) | Part::Plot(..) => {}
        }
    }
    text.truncate(text.trim_end().len());
    text
}

#[cfg(test)]
mod tests {
    use super::super::example::example;
    use super::super::report::{parts, tests::example_parts};
    use super::*;

    #[test]
    fn the_terminal_tells_all_but_details() {
        let text = text(&example_parts());
        for line in [
            "program     impasto 0.1.0, commit 1234abc+, release build",
            "parameters  quick, seed 1, frames 200, warm up frames 20",
            "driver     a driver 1.2.3, Vulkan 1.3.280",
            "The device was given up: the device was lost",
            "D0: A Fast GPU",
            "==============",
            "Medians by the GPU clock, side by side",
            "Compared with old/bench.json",
        ] {
            assert!(text.lines().any(|one| one == line), "{line} in\n{text}");
        }
        assert!(!text.contains("Plots") && !text.contains("core MHz"), "{text}");
    }

    #[test]
    fn a_name_from_outside_does_not_steer_the_terminal() {
        let mut results = example();
        results.devices[0].device.name = "evil\u{1b}[2J\nname".into();
        results.devices[0].measurements[0].check.verdict = "bad\u{7}".into();
        let text = text(&parts(&results, None));
        assert!(text.contains("D0: evil [2J name\n"), "{text}");
        assert!(text.chars().all(|character| character == '\n' || !character.is_control()), "{text}");
    }
}
