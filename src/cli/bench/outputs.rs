//! Where a run's results go: the terminal, and a folder with all that there is to keep.
//!
//! [`OutputFlags::check`] comes before the work, [`Checked::finish`] after it.

use super::super::failure::{Failure, Result};
use super::super::files::{check_file, check_folder, Outputs};
use super::super::session::Session;
use super::compare::Comparison;
use super::results::Results;
use super::{csv, markdown, page, previous, report, text};
use clap::Args;
use std::path::PathBuf;

/// What lies in the folder.
const FILES: [&str; 4] = ["bench.json", "bench.csv", "bench.md", "index.html"];

/// Flags about the results of `impasto bench`.
#[derive(Args, Debug, Clone, Default)]
pub struct OutputFlags {
    /// Folder for the results: bench.json (all of them), bench.csv, bench.md (for an issue), index.html (with plots)
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Compare with an earlier run; it may lie in the folder that is written to
    #[arg(long, value_name = "bench.json")]
    compare: Option<PathBuf>,
}

/// Outputs that can be written, and the earlier run.
pub struct Checked {
    folder: Option<PathBuf>,
    old: Option<(PathBuf, Results)>,
}

impl OutputFlags {
    /// Finds out whether the files can be written, and reads the earlier run.
    ///
    /// # Errors
    /// A folder or file that cannot be written; an earlier run that cannot be read.
    pub fn check(&self) -> Result<Checked> {
        if let Some(folder) = &self.output {
            check_folder(folder)?;
            let there = FILES.map(|name| folder.join(name)).into_iter().filter(|file| file.exists());
            there.into_iter().try_for_each(|file| check_file(&file))?;
        }
        let old = match &self.compare {
            Some(path) => Some((path.clone(), previous::load(path)?)),
            None => None,
        };
        Ok(Checked { folder: self.output.clone(), old })
    }
}

impl Checked {
    /// Hands the report to the session, and writes the files.
    ///
    /// # Errors
    /// A file that cannot be written after all.
    pub fn finish(&self, results: &Results, session: &mut Session) -> Result {
        let comparison = self.old.as_ref().map(|(path, old)| (path.as_path(), Comparison::new(old, results)));
        let parts = report::parts(results, comparison.as_ref().map(|(path, comparison)| (*path, comparison)));
        let mut document = json(results)?;
        session.result("results", document.clone(), text::text(&parts));
        if let (Some((_, comparison)), Some(fields)) = (&comparison, document.as_object_mut()) {
            fields.insert("comparison".to_owned(), json(comparison)?);
        }
        session.replace_document(document);
        let Some(folder) = &self.folder else { return Ok(()) };
        let document = serde_json::to_string_pretty(results).map_err(unwritable)? + "\n";
        let texts = [document, csv::csv(results), markdown::markdown(&parts), page::html(&parts)?];
        let mut outputs = Outputs::default();
        for (name, text) in FILES.into_iter().zip(texts) {
            outputs.add(folder.join(name), text);
        }
        session.wrote(outputs.commit()?);
        session.closing_line(format!("open {}", folder.join("index.html").display()));
        Ok(())
    }
}

fn json(part: &impl serde::Serialize) -> Result<serde_json::Value> {
    serde_json::to_value(part).map_err(unwritable)
}

fn unwritable(error: serde_json::Error) -> Failure {
    Failure::new(format!("writing the results as JSON: {error}"))
}

#[cfg(test)]
mod tests {
    use super::super::super::session::Common;
    use super::super::example::example;
    use super::*;
    use std::collections::BTreeSet;

    fn session() -> Session {
        Session::new("bench", Common { device: None, validate: false, json: false, quiet: true })
    }

    #[test]
    fn a_folder_gets_four_files_and_the_next_run_compares_with_the_first() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let folder = folder.path().join("new/folder");
        let flags = OutputFlags { output: Some(folder.clone()), compare: None };
        flags.check().expect("a folder to be made").finish(&example(), &mut session()).expect("files");
        for name in FILES {
            assert!(folder.join(name).metadata().is_ok_and(|file| file.len() > 1000), "{name}");
        }
        let flags = OutputFlags { output: Some(folder.clone()), compare: Some(folder.join("bench.json")) };
        let checked = flags.check().expect("an earlier run");
        checked.finish(&example(), &mut session()).expect("files");
        let text = std::fs::read_to_string(folder.join("bench.md")).expect("a file");
        assert!(text.contains("bench.json\n") && text.contains("GPU medians: 0 faster, 0 slower, 8 same"), "{text}");
    }

    #[test]
    fn what_cannot_be_written_or_read_is_told_before_the_work() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::create_dir(folder.path().join("bench.csv")).expect("a folder");
        let refused = |flags: OutputFlags| flags.check().err().expect("a failure").0;
        let output = Some(folder.path().to_owned());
        assert!(refused(OutputFlags { output, compare: None }).contains("bench.csv: is a folder, not a file"));
        let compare = Some(folder.path().join("old.json"));
        assert!(refused(OutputFlags { output: None, compare }).starts_with("--compare: "));
        assert!(OutputFlags::default().check().is_ok());
    }

    /// Where every field lies, as docs/bench.md writes it; both clocks have the same fields.
    fn fields(name: &str, value: &serde_json::Value, into: &mut BTreeSet<String>) {
        // The keys of these are names of the run's own.
        const MAPS: [&str; 2] = ["parameters.numbers", "devices[].compile_ms"];
        match value {
            serde_json::Value::Object(map) if !MAPS.contains(&name) => {
                let dot = if name.is_empty() { "" } else { "." };
                map.iter().for_each(|(key, value)| fields(&format!("{name}{dot}{key}"), value, into));
            }
            serde_json::Value::Array(all) if all.iter().any(serde_json::Value::is_object) => {
                all.iter().for_each(|value| fields(&format!("{name}[]"), value, into));
            }
            serde_json::Value::Array(none) if none.is_empty() => {}
            _ => drop(into.insert(name.replace("[].wall.", "[].gpu."))),
        }
    }

    #[test]
    fn the_documentation_names_exactly_the_fields_that_there_are() {
        let document = include_str!("../../../docs/bench.md");
        let rows = document.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` |"));
        let named: BTreeSet<String> = rows.map(|(name, _)| name.to_owned()).collect();
        let mut there = BTreeSet::new();
        fields("", &serde_json::to_value(example()).expect("JSON"), &mut there);
        // A clock that was not read has no fields where another measurement has them.
        there.remove("devices[].measurements[].gpu");
        assert_eq!(named, there);
    }
}
