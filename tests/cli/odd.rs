//! Odd pictures and models of the optional sample data: a result or an error that names the file, nothing in between.

use crate::common::data_dir;
use crate::support::Place;
use std::path::{Path, PathBuf};

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Runs in little memory and with validation, any message of which would be an error that names no file; tells whether
/// a picture came out.
fn result_or_error(place: &Place, words: &[&str], file: &Path) -> bool {
    let ran = place.run_words_in_2_gib(&[words, &["--validate"]].concat());
    let out = place.path("out.png");
    match ran.code {
        Some(0) => {
            assert!(image::open(&out).is_ok(), "{words:?}");
            std::fs::remove_file(out).expect("removed");
            true
        }
        Some(1) => {
            let name = file.file_name().expect("a name").to_string_lossy();
            let error = ran.stderr.lines().find(|line| line.starts_with("impasto: error: "));
            assert!(error.is_some_and(|line| line.contains(&*name)), "{words:?}: {}", ran.stderr);
            assert!(!out.exists(), "{words:?}");
            false
        }
        other => panic!("{words:?}: {other:?}: {}", ran.stderr),
    }
}

#[test]
fn odd_pictures_give_a_picture_or_an_error() {
    let Some(data) = data_dir() else { return };
    let place = Place::new();
    let [mut good, mut bad] = [0, 0];
    for file in files(&data.join("odd_images")) {
        let path = file.to_str().expect("UTF-8");
        let flags = ["-o", "out.png", "--size", "48x32", "--block", "8", "--overlap", "2"];
        let quilted = result_or_error(&place, &[&["quilt", path][..], &flags].concat(), &file);
        let rendered = result_or_error(
            &place,
            &[&["render", "scene.obj", "--paint", path, "--k", "1"][..], &flags].concat(),
            &file,
        );
        assert_eq!(quilted, rendered, "{path}: the same pictures can be used for both");
        *(if quilted { &mut good } else { &mut bad }) += 1;
    }
    assert!(good > 10 && bad > 5, "{good} {bad}");
}

#[test]
fn odd_models_give_a_picture_or_an_error() {
    let Some(data) = data_dir() else { return };
    let place = Place::new();
    let [mut good, mut bad] = [0, 0];
    for file in files(&data.join("odd_models")).into_iter().filter(|file| file.extension().is_some_and(|e| e == "obj"))
    {
        let path = file.to_str().expect("UTF-8");
        let flags = ["--paint", "strip.png", "-o", "out.png", "--size", "48x32", "--block", "8", "--overlap", "2"];
        let rendered = result_or_error(&place, &[&["render", path][..], &flags].concat(), &file);
        *(if rendered { &mut good } else { &mut bad }) += 1;
    }
    assert!(good > 10 && bad > 2, "{good} {bad}");
}
