//! What `impasto measure tests` writes: tables, plots after the thesis's figures 9.1 to 9.3, and the page of it all.

use super::failure::Result;
use super::metric_tests::{Curve, Direction, Subject, Test};
use super::picture::{from_texels, png};
use super::plot::{Plot, Point, Series};
use super::report_page::{Page, Picture};
use super::table::{Cell, Table};
use serde_json::Value;

/// A plot that was drawn.
pub struct Drawn {
    /// The file's name.
    pub file: String,
    /// The test that it belongs to.
    test: Test,
    /// What it shows.
    title: String,
    /// Its text.
    pub svg: String,
}

/// Every measured point, a row each.
pub fn table(curves: &[Curve]) -> Table {
    let headers = ["test", "texture", "direction", "block_px", "variable", "value", "error", "half_width", "samples"];
    let mut table = Table::new(headers);
    for curve in curves {
        let (test, variable, direction) = curve.test.words();
        for (value, score) in &curve.points {
            table.row([
                test.into(),
                curve.texture.into(),
                direction.map_or(Cell::Missing, Cell::from),
                Cell::Number(f64::from(curve.block_px), 0),
                variable.into(),
                Cell::Number(*value, 2),
                Cell::Number(score.mean, 5),
                score.half_width.map_or(Cell::Missing, |half| Cell::Number(half, 5)),
                Cell::Number(score.count as f64, 0),
            ]);
        }
    }
    table
}

/// A row for each curve: where its error is least and greatest, and its mean.
pub fn summary(curves: &[Curve]) -> Table {
    let mut table =
        Table::new(["test", "texture", "direction", "block_px", "least", "at", "greatest", "at", "mean", "unit"]);
    for curve in curves {
        let (test, variable, direction) = curve.test.words();
        let by_error = |a: &&(f64, _), b: &&(f64, _)| error(a).total_cmp(&error(b));
        let (least, greatest) = (curve.points.iter().min_by(by_error), curve.points.iter().max_by(by_error));
        let (Some(least), Some(greatest)) = (least, greatest) else { continue };
        let mean = curve.points.iter().map(|point| error(&point)).sum::<f64>() / curve.points.len() as f64;
        table.row([
            test.into(),
            curve.texture.into(),
            direction.unwrap_or_default().into(),
            Cell::Number(f64::from(curve.block_px), 0),
            Cell::Number(error(&least), 5),
            Cell::Number(least.0, 2),
            Cell::Number(error(&greatest), 5),
            Cell::Number(greatest.0, 2),
            Cell::Number(mean, 5),
            variable.into(),
        ]);
    }
    table
}

fn error(point: &&(f64, impasto::metric::Score)) -> f64 {
    point.1.mean
}

/// The plots: rotation for each block size, since the thesis compares textures there; stretching; sampling.
pub fn plots(curves: &[Curve], k: u32) -> Result<Vec<Drawn>> {
    let mut drawn = Vec::new();
    let mut draw = |test: Test, file: String, title: String, x_label: &str, lines: Vec<(String, &Curve)>| -> Result {
        let series = lines.into_iter().map(|(name, curve)| Series { name, points: points(curve) }).collect();
        let y_label = format!("mean distance of the {k} nearest");
        let svg = Plot { title: title.clone(), x_label: x_label.into(), y_label, series }.svg()?;
        drawn.push(Drawn { file, test, title, svg });
        Ok(())
    };
    let of = |test: Test| curves.iter().filter(move |curve| curve.test == test);
    let mut block_sizes: Vec<u32> = of(Test::Rotation).map(|curve| curve.block_px).collect();
    block_sizes.sort_unstable();
    block_sizes.dedup();
    for block_px in block_sizes {
        let lines = of(Test::Rotation).filter(|curve| curve.block_px == block_px);
        let lines = lines.map(|curve| (curve.texture.to_owned(), curve)).collect();
        let title = format!("Rotation, metric blocks of {block_px} x {block_px} pixels");
        draw(Test::Rotation, format!("rotation_{block_px}.svg"), title, "angle / degrees", lines)?;
    }
    let stretched = curves.iter().filter(|curve| matches!(curve.test, Test::Scale(_)));
    let name = |curve: &Curve| match curve.test {
        Test::Scale(Direction::X) => format!("{}, in x", curve.texture),
        Test::Scale(Direction::Y) => format!("{}, in y", curve.texture),
        _ => format!("{}, in both", curve.texture),
    };
    let lines: Vec<(String, &Curve)> = stretched.map(|curve| (name(curve), curve)).collect();
    let block_px = lines.first().map_or(0, |(_, curve)| curve.block_px);
    let title = format!("Scale, metric blocks of {block_px} x {block_px} pixels");
    draw(Test::Scale(Direction::Both), "scale.svg".into(), title, "factor", lines)?;
    let name = |curve: &Curve| format!("{}, metric blocks of {} x {1} pixels", curve.texture, curve.block_px);
    let lines = of(Test::Sampling).map(|curve| (name(curve), curve)).collect();
    draw(Test::Sampling, "sampling.svg".into(), "Poor sampling".into(), "side of a pasted block / pixels", lines)?;
    Ok(drawn)
}

fn points(curve: &Curve) -> Vec<Point> {
    curve.points.iter().map(|(x, score)| Point { x: *x, y: score.mean, half_width: score.half_width }).collect()
}

/// What the page says about how it was made.
pub fn definitions(parameters: &Value, device: &str) -> Vec<(String, String)> {
    let value = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let parameters = parameters.as_object().into_iter().flatten().filter(|(_, value)| !value.is_null());
    let mut pairs: Vec<_> = parameters.map(|(name, v)| (name.replace('_', " "), value(v))).collect();
    pairs.push(("device".into(), device.into()));
    pairs.push(("version".into(), format!("impasto {}", env!("CARGO_PKG_VERSION"))));
    pairs
}

/// The page's text.
pub fn html(
    subjects: &[Subject],
    curves: &[Curve],
    plots: &[Drawn],
    definitions: &[(String, String)],
    seed: u32,
) -> Result<String> {
    let mut page = Page::new("Tests of the texture metric");
    page.paragraph(
        "Each texture is compared with copies of itself that are wrong in a known way (R. Bailey 2004, sections 9.1.1 to \
         9.1.3). The error is the mean over randomly chosen pixels of the copy; bars are 95 % confidence intervals.",
    );
    page.definitions(definitions);
    page.heading("Textures");
    add_pictures(&mut page, subjects.iter().map(|subject| Ok((subject.name.to_owned(), subject.picture.clone()))))?;

    page.heading("Rotation").paragraph(
        "The copy is turned about its centre, and only what lies within the original is measured. A texture with a \
         diagonal element should differ most at a right angle and least after half a turn; a symmetric one hardly.",
    );
    add_plots(&mut page, plots, Test::Rotation);
    let turned = subjects.iter().flat_map(|subject| [30.0, 90.0].map(|angle| (subject, angle)));
    let turned = turned.map(|(subject, angle)| {
        let copy = Test::Rotation.copy(&subject.picture, angle, seed)?;
        Ok((format!("{}, turned by {angle} degrees", subject.name), copy))
    });
    add_pictures(&mut page, turned)?;

    page.heading("Scale").paragraph(
        "The copy is stretched in one direction or both. Shrinking takes means over areas, growing interpolates. The error \
         should grow away from a factor of 1.",
    );
    let both = Test::Scale(Direction::Both);
    add_plots(&mut page, plots, both);
    let tested = || subjects.iter().filter(|subject| subject.in_all_tests);
    let stretched = tested().flat_map(|subject| [0.5, 1.0, 2.0].map(|factor| (subject, factor)));
    let stretched = stretched.map(|(subject, factor)| {
        let side = 2 * subject.picture.width();
        let copy = padded(&both.copy(&subject.picture, factor, seed)?, side)?;
        Ok((format!("{}, {factor} times as large", subject.name), copy))
    });
    add_pictures(&mut page, stretched)?;

    page.heading("Poor sampling").paragraph(
        "The copy is put together of blocks that are taken at random from the vertical stripe around their place, joined \
         by minimum error cuts. The error should fall as blocks grow, since there are fewer cuts.",
    );
    add_plots(&mut page, plots, Test::Sampling);
    let sampled = tested().flat_map(|subject| [4.0, 20.0, 32.0].map(|side| (subject, side)));
    let sampled = sampled.map(|(subject, side)| {
        let copy = Test::Sampling.copy(&subject.picture, side, seed)?;
        Ok((format!("{}, of blocks of {side} x {side} pixels", subject.name), copy))
    });
    add_pictures(&mut page, sampled)?;

    page.heading("Numbers").table(&summary(curves), "The least and the greatest error of each curve, and its mean");
    page.note("All points are in tests.csv and tests.json.");
    Ok(page.finish())
}

fn add_plots(page: &mut Page, plots: &[Drawn], test: Test) {
    for plot in plots.iter().filter(|plot| plot.test == test) {
        page.svg(&plot.svg, &plot.title);
    }
}

/// A picture in the middle of a square with sides of `side` pixels, so that pictures of different sizes are shown
/// alike.
fn padded(picture: &impasto::metric::Picture, side: u32) -> Result<impasto::metric::Picture> {
    let (left, top) = (side.saturating_sub(picture.width()) / 2, side.saturating_sub(picture.height()) / 2);
    let pixel = |place: u32| {
        let (x, y) = ((place % side).wrapping_sub(left), (place / side).wrapping_sub(top));
        let inside = x < picture.width() && y < picture.height();
        if inside {
            picture.pixels()[(y * picture.width() + x) as usize]
        } else {
            [0; 4]
        }
    };
    Ok(impasto::metric::Picture::new(side, side, (0..side * side).map(pixel).collect())?)
}

/// Pictures three in a row, held by the page itself.
fn add_pictures(page: &mut Page, pictures: impl Iterator<Item = Result<(String, impasto::metric::Picture)>>) -> Result {
    let mut encoded = Vec::new();
    for picture in pictures {
        let (caption, picture) = picture?;
        let texels = picture.pixels().as_flattened().to_vec();
        encoded.push((caption, png(from_texels(texels, (picture.width(), picture.height()))?)?));
    }
    let shown: Vec<Picture> = encoded.iter().map(|(caption, bytes)| Picture::png(bytes, caption, caption)).collect();
    page.grid(3, &shown);
    Ok(())
}
