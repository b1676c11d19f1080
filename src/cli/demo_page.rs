//! The page of `impasto demo`: plain HTML beside its pictures, no script, nothing from elsewhere.

use super::demo::{Step, Taken};

const STYLE: &str = "
body { margin: 0 auto; max-width: 1200px; padding: 2rem; background: #faf9f6; color: #222; \
font: 16px/1.5 system-ui, sans-serif; }
h1 { font-weight: 600; margin-bottom: 0; }
h2 { margin: 3rem 0 0; font-weight: 600; }
p { max-width: 45rem; margin: 0.3rem 0 1rem; }
.row { display: flex; flex-wrap: wrap; gap: 1rem; align-items: flex-end; }
figure { margin: 0; flex: 1 1 300px; max-width: 560px; }
figure img { display: block; width: 100%; background: #fff; border: 1px solid #ddd; border-radius: 4px; }
figure img.strip { image-rendering: auto; height: 128px; }
.repeated { aspect-ratio: 1; background-size: 50% 50%; border: 1px solid #ddd; border-radius: 4px; }
figcaption { color: #555; font-size: 0.9rem; padding-top: 0.3rem; }
pre { background: #efece5; border-radius: 4px; padding: 0.6rem 0.8rem; overflow-x: auto; font-size: 0.85rem; \
white-space: pre-wrap; }
.time { color: #777; font-size: 0.85rem; }
";

/// The page's text.
pub fn html(taken: &[Taken]) -> String {
    let mut body = String::new();
    for Taken { step, command, time } in taken {
        body.push_str(&format!("<section>\n<h2>{}</h2>\n<p>{}</p>\n", escape(step.title), escape(step.text)));
        body.push_str(&figures(step));
        body.push_str(&format!("<pre>{}</pre>\n", escape(command)));
        body.push_str(&format!("<div class=\"time\">{:.2} s</div>\n</section>\n", time.as_secs_f64()));
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>impasto</title>\n<style>{STYLE}</style>\n\
         </head>\n<body>\n<h1>impasto</h1>\n<p>3D models, shaded with real paint. Each command below makes the pictures \
         above it; run it in this folder, where the models and strips are too.</p>\n{body}</body>\n</html>\n"
    )
}

fn figures(step: &Step) -> String {
    let mut row = String::from("<div class=\"row\">\n");
    for (file, caption) in step.pictures {
        let strip = ["strip", "paint", "one_color"].iter().any(|folder| file.starts_with(folder));
        let class = if strip { " class=\"strip\"" } else { "" };
        let caption = escape(caption);
        row.push_str(&format!(
            "<figure><a href=\"{file}\"><img{class} src=\"{file}\" alt=\"{caption}\"></a>\
             <figcaption>{caption}</figcaption></figure>\n"
        ));
    }
    if let Some(file) = step.repeated {
        row.push_str(&format!(
            "<figure><div class=\"repeated\" style=\"background-image: url({file})\"></div>\
             <figcaption>Twice across and twice down</figcaption></figure>\n"
        ));
    }
    row + "</div>\n"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
