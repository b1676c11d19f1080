//! Reads the document of an earlier run, for `--compare`.

use super::super::failure::{Failure, Result};
use super::results::{Results, Samples, SCHEMA};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The most bytes that are read: what is longer is no document of ours. A full, sustained run has a few million.
const MOST_BYTES: u64 = 256 << 20;

/// What tells whether a document is one of ours. Unknown fields are no error, here nor in the rest.
#[derive(Deserialize)]
struct Head {
    #[serde(default)]
    schema: Value,
    #[serde(default)]
    tool: Value,
}

/// The document in a file.
pub fn load(path: &Path) -> Result<Results> {
    let file = File::open(path).map_err(|error| failure(path, error))?;
    parse(&read(file, MOST_BYTES).map_err(|error| failure(path, error))?, path)
}

/// All that is in there, if that is no more than `most` bytes.
fn read(from: impl Read, most: u64) -> std::io::Result<String> {
    let mut text = String::new();
    match from.take(most + 1).read_to_string(&mut text)? as u64 > most {
        true => Err(std::io::Error::other(format!("is longer than {most} bytes"))),
        false => Ok(text),
    }
}

fn parse(text: &str, path: &Path) -> Result<Results> {
    let other = "is no result of this command; it takes the bench.json that `impasto bench --output DIR` writes";
    let head: Head = serde_json::from_str(text).map_err(|error| match error.is_data() {
        true => failure(path, other),
        false => failure(path, format!("is not JSON: {error}")),
    })?;
    let (Some(schema), Some("impasto")) = (head.schema.as_u64(), head.tool["name"].as_str()) else {
        return Err(failure(path, other));
    };
    if schema != u64::from(SCHEMA) {
        let version = head.tool["version"].as_str().unwrap_or("of an unknown version");
        let reason = format!("was written by impasto {version} in schema {schema}, but this program reads {SCHEMA}");
        return Err(failure(path, reason));
    }
    let results: Results = serde_json::from_str(text).map_err(|error| failure(path, error))?;
    check(&results).map_err(|reason| failure(path, reason))?;
    Ok(results)
}

/// No time or rate is negative. (JSON has no number that is not finite.) Every name is that of one measurement.
fn check(results: &Results) -> std::result::Result<(), String> {
    for device in &results.devices {
        let mut names = BTreeSet::new();
        if let Some(twice) = device.measurements.iter().find(|one| !names.insert(&one.id)) {
            return Err(format!("{} is there twice for {}", twice.id, device.device.name));
        }
    }
    for one in results.devices.iter().flat_map(|device| &device.measurements) {
        for (name, samples) in [("gpu", &one.gpu), ("wall", &one.wall)] {
            let Some(Samples { p50, p90, p95, p99, min, max, raw }) = samples else { continue };
            let mut numbers = [p50, p90, p95, p99, min, max].into_iter().chain(raw);
            if let Some(bad) = numbers.find(|number| **number < 0.0) {
                return Err(format!("{}: a number of \"{name}\" is {bad}, which is negative", one.id));
            }
        }
    }
    Ok(())
}

fn failure(path: &Path, reason: impl std::fmt::Display) -> Failure {
    Failure::new(format!("--compare: {}: {reason}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::super::example::example;
    use super::*;
    use serde_json::{json, to_value};

    fn parsed(value: &Value) -> Result<Results> {
        parse(&value.to_string(), Path::new("old.json"))
    }

    fn refused(text: &str) -> String {
        let failure = parse(text, Path::new("old.json")).expect_err(text).0;
        assert!(failure.starts_with("--compare: old.json: "), "{failure}");
        failure
    }

    #[test]
    fn what_was_written_is_read_and_unknown_fields_are_no_error() {
        let mut value = to_value(example()).expect("JSON");
        assert!(to_value(parsed(&value).expect("results")).expect("JSON") == value);
        value["more"] = json!(1);
        value["devices"][0]["measurements"][0]["gpu"]["p99.9"] = json!([2.5]);
        assert!(to_value(parsed(&value).expect("results")).expect("JSON") == to_value(example()).expect("JSON"));
    }

    #[test]
    fn a_document_of_another_kind_is_refused_in_words() {
        assert!(refused("so what").contains("is not JSON: expected value at line 1"), "not JSON");
        assert!(refused("{\"schema\": 1,").contains("is not JSON: EOF"), "cut off");
        for other in ["[]", "7", "{}", "{\"schema\": 1}", "{\"schema\": 1, \"tool\": {\"name\": \"other\"}}"] {
            assert!(refused(other).contains("is no result of this command"), "{other}");
        }
        let mut newer = to_value(example()).expect("JSON");
        newer["schema"] = json!(SCHEMA + 1);
        newer["tool"]["version"] = json!("9.0.0");
        assert!(refused(&newer.to_string()).contains("impasto 9.0.0 in schema 2, but this program reads 1"));
    }

    #[test]
    fn a_field_that_is_missing_or_wrong_is_named() {
        let mut value = to_value(example()).expect("JSON");
        value["system"].as_object_mut().expect("an object").remove("cores");
        assert!(refused(&value.to_string()).contains("missing field `cores` at line 1 column"));
        let wrong = |p50: Value| {
            let mut value = to_value(example()).expect("JSON");
            value["devices"][0]["measurements"][0]["gpu"]["p50"] = p50;
            refused(&value.to_string())
        };
        assert!(wrong(json!(null)).contains("invalid type: null, expected f64"));
        assert!(wrong(json!("3")).contains("invalid type: string"));
        let negative = wrong(json!(-3.0));
        assert!(negative.contains("frame/image/head/light-orbit/640x360: a number of \"gpu\" is -3"), "{negative}");
    }

    #[test]
    fn numbers_are_read_as_they_were_written() {
        let mut results = example();
        // Some of these are read as their neighbours unless the parser takes care.
        let raw: Vec<f64> = (1..1000).map(|number| f64::from(number).sqrt() / 7.0).collect();
        results.devices[0].measurements[0].wall = Samples::of(raw.clone());
        let read = parsed(&to_value(results).expect("JSON")).expect("results");
        let wall = read.devices[0].measurements[0].wall.as_ref();
        assert_eq!(
            wall.map(|wall| wall.raw.iter().map(|ms| ms.to_bits()).collect::<Vec<_>>()),
            Some(raw.iter().map(|ms| ms.to_bits()).collect())
        );
    }

    #[test]
    fn a_run_without_failures_is_read_where_none_are_named() {
        let mut value = to_value(example()).expect("JSON");
        value["devices"][0].as_object_mut().expect("an object").remove("failures");
        assert!(parsed(&value).expect("results").devices[0].failures.is_empty());
    }

    #[test]
    fn what_is_too_long_or_there_twice_is_refused() {
        assert_eq!(read(&b"12345"[..], 5).expect("short enough"), "12345");
        assert!(read(std::io::repeat(b'0'), 5).is_err_and(|error| error.to_string() == "is longer than 5 bytes"));
        let mut results = example();
        results.devices[0].measurements[1].id = results.devices[0].measurements[0].id.clone();
        let told = refused(&to_value(results).expect("JSON").to_string());
        assert!(told.contains("frame/image/head/light-orbit/640x360 is there twice for A Fast GPU"), "{told}");
    }

    #[test]
    fn a_file_that_is_not_there_is_named() {
        let failure = load(Path::new("no/such.json")).expect_err("no file").0;
        assert!(failure.starts_with("--compare: no/such.json: "), "{failure}");
    }
}
