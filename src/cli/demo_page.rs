//! The page of `impasto demo`: what each command made, as files beside the page, so that they can be opened and used.

use super::demo::{Step, Taken};
use super::report_page::{Page, Picture};

/// The page's text.
pub fn html(taken: &[Taken]) -> String {
    let mut page = Page::new("impasto");
    page.paragraph(
        "3D models, shaded with real paint. Each command below makes the pictures above it; run it in this folder, \
         where the models and strips are too.",
    );
    for Taken { step, command, time } in taken {
        page.heading(step.title).paragraph(step.text).row(&pictures(step));
        page.command(command).note(&format!("{:.2} s", time.as_secs_f64()));
    }
    page.finish()
}

fn pictures(step: &Step) -> Vec<Picture<'static>> {
    let shown = step.pictures.iter().map(|(file, caption)| {
        let picture = Picture::file(file, caption, caption);
        let is_strip = ["strip", "paint", "one_color"].iter().any(|folder| file.starts_with(folder));
        if is_strip {
            picture.strip()
        } else {
            picture
        }
    });
    let caption = "Twice across and twice down";
    shown.chain(step.repeated.map(|file| Picture::file(file, caption, caption).repeated())).collect()
}
