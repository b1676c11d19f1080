//! Line plots as SVG, for pages of measurements.
//!
//! [`Plot::svg`] draws with the crate `plotters`, whose SVG backend leaves the measuring of text to whoever shows the
//! picture. Without fonts at hand it can only guess how wide a text is, so the legend stands in rows below the plot,
//! where a long name disturbs nothing, and not in a box among the data. The same plot gives the same text every time.

use super::failure::{Failure, Result};
use super::report_page::escape;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::ops::Range;

/// Size of plot and axes, without the legend.
const SIZE: (u32, u32) = (720, 420);
/// Height of the legend's rows.
const ROW: i32 = 22;
/// Where the lines of the legend begin and end, and their texts begin.
const LEGEND: (i32, i32, i32) = (90, 126, 136);
/// Significant digits of a number beside a tick.
const DIGITS: usize = 6;
const FONT: &str = "sans-serif";
/// Plotters adds and multiplies what it is given; beyond this it could leave the range of its numbers.
const LARGEST: f64 = 1e30;
/// Plotters takes a shorter axis for one of no length.
const SMALLEST: f64 = 1e-12;

/// Colours that stay apart for people who confuse red and green, or blue and yellow (Okabe and Ito 2008), without the
/// yellow, which is faint on white. Together with [`MARKERS`], of which there are 4, 28 series look different.
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(0, 0, 0),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];
const MARKERS: [Marker; 4] = [Marker::Disc, Marker::Triangle, Marker::Cross, Marker::Ring];

/// Lines over a common pair of axes. The vertical one begins at 0, or below it if a value does.
#[derive(Debug, Clone, Default)]
pub struct Plot {
    /// What the plot shows.
    pub title: String,
    /// What goes to the right, with its unit.
    pub x_label: String,
    /// What goes up, with its unit.
    pub y_label: String,
    /// The lines, in the order of the legend.
    pub series: Vec<Series>,
}

/// A line.
#[derive(Debug, Clone, Default)]
pub struct Series {
    /// What the legend calls it.
    pub name: String,
    /// Its points, joined in this order. What is not a finite number is left out.
    pub points: Vec<Point>,
}

/// A measured point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// To the right.
    pub x: f64,
    /// Up.
    pub y: f64,
    /// Half the width of the confidence interval around `y`, drawn as a bar.
    pub half_width: Option<f64>,
}

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Marker {
    Disc,
    Triangle,
    Cross,
    Ring,
}

type Area<'a, Axes> = DrawingArea<SVGBackend<'a>, Axes>;
type DrawnResult<'a> = std::result::Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>;

impl Plot {
    /// The plot as an `svg` element, which is a picture to a screen reader.
    pub fn svg(&self) -> Result<String> {
        let rows = i32::try_from(self.series.len()).ok().and_then(|rows| rows.checked_mul(ROW));
        let legend = rows.and_then(|height| u32::try_from(height + ROW / 2).ok()).ok_or_else(|| {
            Failure::new(format!("a plot of {} lines is more than a picture can hold", self.series.len()))
        })?;
        let mut text = String::new();
        {
            let area = SVGBackend::with_string(&mut text, (SIZE.0, SIZE.1 + legend)).into_drawing_area();
            self.draw(&area).map_err(|error| Failure::new(format!("drawing the plot \"{}\": {error}", self.title)))?;
        }
        Ok(text.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{}\" ", escape(&self.title)), 1))
    }

    fn draw<'a>(&self, area: &Area<'a, Shift>) -> DrawnResult<'a> {
        area.fill(&WHITE)?;
        let (upper, lower) = area.split_vertically(SIZE.1);
        let mut chart = ChartBuilder::on(&upper)
            .caption(&self.title, (FONT, 22))
            .margin(14)
            .x_label_area_size(48)
            .y_label_area_size(76)
            .build_cartesian_2d(self.x_range(), self.y_range())?;
        chart
            .configure_mesh()
            .bold_line_style(RGBColor(221, 221, 221))
            .light_line_style(TRANSPARENT)
            .axis_style(RGBColor(102, 102, 102))
            .label_style((FONT, 16))
            .axis_desc_style((FONT, 18))
            .x_labels(8)
            .y_labels(8)
            .x_label_formatter(&|x| short(*x, DIGITS))
            .y_label_formatter(&|y| short(*y, DIGITS))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .draw()?;
        for (index, series) in self.series.iter().enumerate() {
            let (color, marker) = look(index);
            let points: Vec<Point> = series.drawn().collect();
            let line = PathElement::new(points.iter().map(|p| (p.x, p.y)).collect::<Vec<_>>(), color.stroke_width(2));
            chart.draw_series([line])?;
            chart.draw_series(points.iter().filter_map(|p| {
                let half = p.half_width?;
                Some(ErrorBar::new_vertical(p.x, p.y - half, p.y, p.y + half, color.stroke_width(1), 8))
            }))?;
            chart.draw_series(points.iter().map(|p| marker.at((p.x, p.y), color)))?;
        }
        self.draw_legend(&lower)
    }

    fn draw_legend<'a>(&self, area: &Area<'a, Shift>) -> DrawnResult<'a> {
        let (from, to, text) = LEGEND;
        for (index, series) in (0..).zip(&self.series) {
            let (color, marker) = look(index);
            let y = index as i32 * ROW + ROW / 2;
            area.draw(&PathElement::new(vec![(from, y), (to, y)], color.stroke_width(2)))?;
            area.draw(&marker.at(((from + to) / 2, y), color))?;
            area.draw(&Text::new(series.name.clone(), (text, y - 8), (FONT, 16)))?;
        }
        Ok(())
    }

    /// From the leftmost point to the rightmost, and a little further.
    fn x_range(&self) -> Range<f64> {
        let xs = || self.series.iter().flat_map(Series::drawn).map(|point| point.x);
        let (low, high) = (xs().fold(f64::INFINITY, f64::min), xs().fold(f64::NEG_INFINITY, f64::max));
        if low > high {
            return 0.0..1.0;
        }
        // Points that lie above each other, or nearly so, still need an axis of some length.
        let size = low.abs().max(high.abs());
        let margin = if high - low <= size * 1e-9 + SMALLEST { size.max(1.0) / 2.0 } else { (high - low) * 0.03 };
        low - margin..high + margin
    }

    /// From 0, or below it, to the highest point, and a little further.
    fn y_range(&self) -> Range<f64> {
        let points =
            || self.series.iter().flat_map(Series::drawn).map(|point| (point.y, point.half_width.unwrap_or(0.0)));
        let low = points().map(|(y, half)| y - half).fold(0.0, f64::min);
        let high = points().map(|(y, half)| y + half).fold(0.0, f64::max);
        let length = high - low;
        if length <= SMALLEST {
            return 0.0..1.0;
        }
        let above = if high > 0.0 { length * 0.06 } else { 0.0 };
        let below = if low < 0.0 { length * 0.06 } else { 0.0 };
        low - below..high + above
    }
}

impl Series {
    /// The points that can be drawn, with the intervals that can be.
    fn drawn(&self) -> impl Iterator<Item = Point> + '_ {
        // Comparing so leaves out what is not a number, too.
        let fits = |value: f64| value.abs() <= LARGEST;
        let points = self.points.iter().filter(move |point| fits(point.x) && fits(point.y));
        points.map(move |point| Point {
            half_width: point.half_width.filter(|half| *half >= 0.0 && fits(*half)),
            ..*point
        })
    }
}

impl Marker {
    fn at<'a, C: Clone + 'static>(self, place: C, color: RGBColor) -> DynElement<'static, SVGBackend<'a>, C> {
        match self {
            Marker::Disc => Circle::new(place, 4, color.filled()).into_dyn(),
            Marker::Triangle => TriangleMarker::new(place, 6, color.filled()).into_dyn(),
            Marker::Cross => Cross::new(place, 4, color.stroke_width(2)).into_dyn(),
            Marker::Ring => Circle::new(place, 5, color.stroke_width(2)).into_dyn(),
        }
    }
}

fn look(index: usize) -> (RGBColor, Marker) {
    (COLORS[index % COLORS.len()], MARKERS[index % MARKERS.len()])
}

/// A number beside a tick, with no more significant digits than it needs, nor than `digits`.
pub fn short(value: f64, digits: usize) -> String {
    // Through text, because that is the only rounding to decimal digits that leaves no trace of binary ones.
    let rounded: f64 = format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value);
    match rounded {
        _ if rounded == 0.0 => "0".to_owned(),
        _ if (1e-3..1e6).contains(&rounded.abs()) => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::report_page::tests::assert_balanced;
    use super::*;

    fn plot(series: Vec<Series>) -> Plot {
        Plot { title: "Time & size".into(), x_label: "side / px".into(), y_label: "time / ms".into(), series }
    }

    fn line(name: &str, points: &[(f64, f64, Option<f64>)]) -> Series {
        let points = points.iter().map(|&(x, y, half_width)| Point { x, y, half_width }).collect();
        Series { name: name.into(), points }
    }

    #[test]
    fn a_plot_is_well_formed_and_names_all_that_it_shows() {
        let plot = plot(vec![
            line("image-based", &[(256.0, 4.0, Some(0.5)), (512.0, 16.5, None)]),
            line("<view> \"aligned\"", &[(256.0, 2.0, None), (512.0, 3.0, None)]),
        ]);
        let svg = plot.svg().expect("a plot");
        assert_balanced(&svg, &[]);
        assert!(svg.starts_with("<svg role=\"img\" aria-label=\"Time &amp; size\" "), "{svg}");
        for text in ["\nTime &amp; size\n", "side / px", "time / ms", "image-based", "&lt;view&gt; &quot;aligned&quot;"]
        {
            assert!(svg.contains(text), "{text} in {svg}");
        }
        for tick in ["\n0\n", "\n10\n", "\n300\n"] {
            assert!(svg.contains(tick), "{tick} in {svg}");
        }
        for (color, marker) in [("#0072B2", "<circle"), ("#D55E00", "<polygon")] {
            assert!(svg.lines().any(|line| line.starts_with(marker) && line.contains(color)), "{marker} {color} {svg}");
        }
        assert_eq!(svg, plot.svg().expect("a plot"), "the same every time");
    }

    #[test]
    fn an_interval_is_a_bar() {
        let lines = |half_width| {
            let svg = plot(vec![line("a", &[(1.0, 1.0, half_width), (2.0, 3.0, None)])]).svg().expect("a plot");
            svg.matches("stroke=\"#0072B2\"").count()
        };
        assert!(lines(Some(0.5)) > lines(None));
        assert_eq!(lines(Some(f64::NAN)), lines(None));
    }

    #[test]
    fn the_vertical_axis_begins_at_0_and_holds_all_intervals() {
        let above = plot(vec![line("a", &[(1.0, 10.0, Some(2.0)), (2.0, 11.0, None)])]).y_range();
        assert!(above.start == 0.0 && above.end > 12.0 && above.end < 13.0, "{above:?}");
        let below = plot(vec![line("a", &[(1.0, 1.0, Some(2.0))])]).y_range();
        assert!(below.start < -1.0 && below.end > 3.0, "{below:?}");
    }

    #[test]
    fn odd_values_are_drawn_or_left_out() {
        let odd = [f64::NAN, f64::INFINITY, f64::MAX, -1e30, 1e30, 1e-300, 0.0, 1.0, 1.0 + f64::EPSILON, -1e-13, 1e15];
        let mut cases = vec![vec![], vec![line("nothing", &[])]];
        cases.extend(odd.iter().flat_map(|&a| odd.map(|b| vec![line("odd", &[(a, b, Some(b)), (b, a, None)])])));
        for case in cases {
            let svg = plot(case.clone()).svg().expect("a plot");
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{case:?}: {svg}");
            assert_balanced(&svg, &[]);
        }
    }

    #[test]
    fn many_lines_look_different() {
        let looks: Vec<_> = (0..28).map(look).collect();
        assert!((1..28).all(|index| !looks[..index].contains(&looks[index])));
    }

    #[test]
    fn ticks_have_no_digits_without_meaning() {
        let cases = [(0.1 + 0.2, "0.3"), (0.0, "0"), (-0.0, "0"), (2500.0, "2500"), (-1.5, "-1.5"), (2e-7, "2e-7")];
        for (value, text) in
            cases.into_iter().chain([(3e9, "3e9"), (1234567.0, "1.23457e6"), (0.00012, "1.2e-4"), (0.00125, "0.00125")])
        {
            assert_eq!(short(value, 6), text);
        }
        assert_eq!(short(0.83149, 3), "0.831");
    }
}
