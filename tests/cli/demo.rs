//! demo: no file, no argument, a whole page; and its captions are true.

use crate::support::Place;
use std::collections::BTreeSet;

#[test]
fn the_page_is_complete_and_its_commands_make_its_pictures() {
    let place = Place::new();
    let report = place.json("demo --size 96x96 -o show --validate");
    let page = place.text("show/index.html");
    let mut shown = BTreeSet::new();
    for piece in page.split("src=\"").skip(1).chain(page.split("url(").skip(1)) {
        let name = piece.split(['"', ')']).next().expect("a name");
        assert!(!name.starts_with('/') && !name.contains(':'), "{name} is beside the page");
        assert!(place.picture(&format!("show/{name}")).width() > 0);
        shown.insert(name.to_owned());
    }
    assert!(shown.len() > 15, "{shown:?}");
    let left = place.files().keys().any(|path| path.to_string_lossy().contains(".impasto"));
    assert!(!left, "no temporary folder is left");

    // Run again what the captions say, in a copy of the models and strips, and compare every file.
    let again = Place::new();
    for name in ["head.obj", "teapot_on_table.obj"] {
        std::fs::copy(place.path("show").join(name), again.path(name)).expect("copied");
    }
    for name in ["strip_green_yellow.png", "strip_dark_red.png", "strip_red_yellow.png"] {
        std::fs::copy(place.path("show").join(name), again.path(name)).expect("copied");
    }
    let commands = report["commands"].as_array().expect("commands");
    for command in commands {
        let line = command["command"].as_str().expect("text");
        assert!(page.contains(line), "{line}");
        again.ok(line.strip_prefix("impasto ").expect("the program's name"));
    }
    let mut compared = 0;
    for (path, bytes) in place.files() {
        let Ok(name) = path.strip_prefix(place.path("show")) else { continue };
        if bytes.is_some() && name != std::path::Path::new("index.html") {
            assert_eq!(bytes, std::fs::read(again.dir.path().join(name)).ok(), "{}", name.display());
            compared += 1;
        }
    }
    assert!(compared > 25, "{compared}");
}

#[test]
fn without_arguments_it_writes_a_folder_named_demo() {
    let place = Place::new();
    let stdout = place.ok("demo --size 64x64");
    assert!(place.path("demo/index.html").is_file());
    assert!(stdout.contains(" s  impasto render head.obj"), "the time of each command: {stdout}");
    assert!(stdout.trim_end().ends_with("see demo/index.html"), "{stdout}");
}
