//! Curves with their standard error, as in the paper's Figure 5.

use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{DashedPathElement, PathElement, Polygon, Rectangle, Text};
use plotters::prelude::{Cartesian2d, ChartBuilder, DrawingBackend, SVGBackend};
use plotters::series::{DashedLineSeries, LineSeries};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, IntoFont, RGBColor, ShapeStyle, TextStyle, WHITE};

/// Size of a drawing, pixels: plotters rounds to whole ones, so that small drawings get crooked lines.
const SIZE: (u32, u32) = (1600, 1000);
/// So many lines have their names beside them, more have a legend.
const MOST_LABELS: usize = 5;
/// Names stand beside their lines between these shares of the lines' last values, and no farther right than this
/// share of the width.
const LABEL_SHARES: (f64, f64) = (0.1, 0.8);
const LAST_LABEL: f64 = 0.75;
/// Columns of the legend, on the right.
const LEGEND_WIDTH: u32 = 325;
/// The horizontal range of the line samples in the legend: longer than any dash and its gap.
const SAMPLE: (i32, i32) = (4, 76);

const FONT: &str = "Helvetica, Arial, sans-serif";
const TITLE_SIZE: i32 = 44;
const TEXT_SIZE: i32 = 30;
const LINE_WIDTH: u32 = 4;
const INK: RGBColor = RGBColor(40, 40, 40);
const FAINT: RGBColor = RGBColor(226, 226, 226);

/// Colors that can be told apart with color blindness (Okabe and Ito 2008), with a gray instead of the yellow, which is
/// too light for lines, and a dark brown as the ninth.
const COLORS: [RGBColor; 9] = [
    RGBColor(140, 140, 140),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(0, 114, 178),
    RGBColor(86, 180, 233),
    RGBColor(213, 94, 0),
    RGBColor(0, 0, 0),
    RGBColor(110, 60, 20),
];

/// Lengths of dashes and of the gaps between them, pixels.
const DASHES: [(u32, u32); 4] = [(24, 12), (6, 8), (48, 12), (14, 28)];

/// Curves of values, none below 0, by length.
pub struct Figure<'a> {
    /// The title above the drawing.
    pub title: String,
    /// The line below the title.
    pub subtitle: String,
    /// The meaning of the lengths, with unit.
    pub horizontal: &'a str,
    /// The meaning of the values.
    pub vertical: &'a str,
    /// Lengths are drawn from 0 to this, above 0.
    pub length: f64,
    /// Values are drawn from 0 to this, above 0.
    pub height: f64,
    /// The curves; later ones are drawn over earlier ones.
    pub lines: Vec<Line<'a>>,
}

/// One curve; shape `[points]` each.
pub struct Line<'a> {
    /// Its name in the legend.
    pub label: &'a str,
    /// Its color and dashes.
    pub line_style: LineStyle,
    /// The lengths, ascending.
    pub lengths: &'a [f64],
    /// Mean value at each length.
    pub mean: &'a [f64],
    /// Its standard error, where known.
    pub standard_error: &'a [Option<f64>],
}

/// Color and dashes of a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineStyle {
    /// Number of its color, below [`LineStyle::COLORS`]; other numbers are taken modulo it.
    pub color: usize,
    /// Number of its dash pattern, 0 for a solid line, below [`LineStyle::DASHES`]; other numbers are taken modulo it.
    pub dashes: usize,
}

impl LineStyle {
    /// Number of colors.
    pub const COLORS: usize = COLORS.len();
    /// Number of line styles, including solid lines.
    pub const DASHES: usize = DASHES.len() + 1;

    const fn color(self) -> RGBColor {
        COLORS[self.color % Self::COLORS]
    }

    fn stroke(self) -> ShapeStyle {
        ShapeStyle::from(self.color()).stroke_width(LINE_WIDTH)
    }

    /// `None` for a solid line.
    const fn dashes(self) -> Option<(u32, u32)> {
        match self.dashes % Self::DASHES {
            0 => None,
            number => Some(DASHES[number - 1]),
        }
    }
}

type Chart<'a, B> = ChartContext<'a, B, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

impl Figure<'_> {
    /// The drawing as SVG.
    ///
    /// # Errors
    /// If the drawing library fails.
    pub fn draw(&self) -> Result<String, String> {
        let mut svg = String::new();
        self.draw_on(&SVGBackend::with_string(&mut svg, SIZE).into_drawing_area())
            .map_err(|error| error.to_string())?;
        Ok(svg)
    }

    fn draw_on<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Drawn<B> {
        root.fill(&WHITE)?;
        root.draw(&Text::new(self.title.as_str(), (120, 28), text(TITLE_SIZE)))?;
        root.draw(&Text::new(self.subtitle.as_str(), (120, 84), text(TEXT_SIZE)))?;
        let is_labeled = self.lines.len() <= MOST_LABELS;
        let legend_width = if is_labeled { 0 } else { LEGEND_WIDTH };
        let (left, right) = root.split_horizontally(SIZE.0 - legend_width);
        let mut chart = ChartBuilder::on(&left)
            .margin_top(140)
            .margin_right(20)
            .margin_bottom(20)
            .margin_left(20)
            .x_label_area_size(90)
            .y_label_area_size(100)
            .build_cartesian_2d(0.0..self.length, 0.0..self.height)?;
        self.draw_axes(&mut chart)?;
        for line in &self.lines {
            line.draw_band(&mut chart, self.length)?;
        }
        for line in &self.lines {
            line.draw_mean(&mut chart, self.length)?;
        }
        if is_labeled {
            self.draw_labels(&mut chart)?;
        } else {
            self.draw_legend(&right)?;
        }
        root.present()
    }

    fn draw_axes<B: DrawingBackend>(&self, chart: &mut Chart<'_, B>) -> Drawn<B> {
        chart
            .configure_mesh()
            .x_labels(10)
            .y_labels(6)
            .max_light_lines(0)
            .bold_line_style(ShapeStyle::from(FAINT).stroke_width(2))
            .axis_style(ShapeStyle::from(INK).stroke_width(2))
            .label_style(text(TEXT_SIZE))
            .axis_desc_style(text(TEXT_SIZE))
            .x_label_formatter(&|length| format!("{length:.0}"))
            .y_label_formatter(&|value| format!("{value:.1}"))
            .x_desc(self.horizontal)
            .y_desc(self.vertical)
            .draw()
    }

    /// The name of each line beside it, to the right of all lines, with a thin line to where it belongs: the fastest
    /// line at the top.
    fn draw_labels<B: DrawingBackend>(&self, chart: &mut Chart<'_, B>) -> Drawn<B> {
        let mut lines: Vec<&Line<'_>> = self.lines.iter().collect();
        lines.sort_by(|a, b| a.point_at(0.5).0.total_cmp(&b.point_at(0.5).0));
        let step = (LABEL_SHARES.1 - LABEL_SHARES.0) / lines.len().max(2) as f64;
        for (place, line) in lines.iter().enumerate() {
            let share = LABEL_SHARES.1 - step * place as f64;
            let (x, y) = line.point_at(share);
            let slowest = lines.iter().map(|other| other.point_at(share).0).fold(x, f64::max);
            let from = (slowest + 0.02 * self.length).min(LAST_LABEL * self.length);
            let color = line.line_style.color();
            chart.draw_series([PathElement::new([(x, y), (from, y)], color.stroke_width(1))])?;
            let style = text(TEXT_SIZE).color(&color).pos(Pos::new(HPos::Left, VPos::Center));
            chart.draw_series([Text::new(format!(" {}", line.label), (from, y), style)])?;
        }
        Ok(())
    }

    fn draw_legend<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Drawn<B> {
        for (y, line) in (160..).step_by(50).zip(&self.lines) {
            area.draw(&Rectangle::new(
                [(SAMPLE.0, y - 12), (SAMPLE.1, y + 12)],
                line.line_style.color().mix(0.2).filled(),
            ))?;
            let (ends, stroke) = ([(SAMPLE.0, y), (SAMPLE.1, y)], line.line_style.stroke());
            match line.line_style.dashes() {
                None => area.draw(&PathElement::new(ends, stroke))?,
                Some((dash, gap)) => area.draw(&DashedPathElement::new(ends, dash, gap, stroke))?,
            }
            area.draw(&Text::new(line.label, (SAMPLE.1 + 12, y - 15), text(TEXT_SIZE)))?;
        }
        Ok(())
    }
}

impl Line<'_> {
    fn draw_band<B: DrawingBackend>(&self, chart: &mut Chart<'_, B>, length: f64) -> Drawn<B> {
        let edge = |side: f64| {
            let points = self.points(length).zip(self.standard_error);
            points.filter_map(move |((x, mean), error)| Some((x, (mean + side * (*error)?).clamp(0.0, 1.0))))
        };
        let mut outline: Vec<(f64, f64)> = edge(-1.0).collect();
        outline.reverse();
        outline.splice(0..0, edge(1.0));
        if !outline.is_empty() {
            chart.draw_series([Polygon::new(outline, self.line_style.color().mix(0.2))])?;
        }
        Ok(())
    }

    fn draw_mean<B: DrawingBackend>(&self, chart: &mut Chart<'_, B>, length: f64) -> Drawn<B> {
        let (points, stroke) = (self.points(length), self.line_style.stroke());
        match self.line_style.dashes() {
            None => chart.draw_series(LineSeries::new(points, stroke))?,
            Some((dash, gap)) => chart.draw_series(DashedLineSeries::new(points, dash, gap, stroke))?,
        };
        Ok(())
    }

    /// Where the mean first reaches this share of its last value.
    fn point_at(&self, share: f64) -> (f64, f64) {
        let height = share * self.mean.last().copied().unwrap_or_default();
        let place = self.mean.iter().position(|&mean| mean >= height).unwrap_or(0);
        (self.lengths.get(place).copied().unwrap_or_default(), height)
    }

    /// Up to a length.
    fn points(&self, length: f64) -> impl Iterator<Item = (f64, f64)> + Clone {
        let points = self.lengths.iter().copied().zip(self.mean.iter().copied());
        points.take_while(move |&(x, _)| x <= length)
    }
}

fn text(size: i32) -> TextStyle<'static> {
    (FONT, size).into_font().color(&INK)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn svg(standard_error: &[Option<f64>], dashes: usize, lines: usize) -> String {
        let line = || Line {
            label: "greedy",
            line_style: LineStyle { color: 2, dashes },
            lengths: &[0.0, 1.0, 2.0],
            mean: &[0.0, 0.5, 0.9],
            standard_error,
        };
        let figure = Figure {
            title: "a map <&>".to_owned(),
            subtitle: "3 seeds".to_owned(),
            horizontal: "Path length (cells)",
            vertical: "F1",
            length: 2.0,
            height: 1.0,
            lines: (0..lines).map(|_| line()).collect(),
        };
        figure.draw().unwrap()
    }

    #[test]
    fn a_drawing_names_its_axes_and_its_lines() {
        let svg = svg(&[Some(0.0), Some(0.1), Some(0.1)], 0, 1);
        for word in ["a map &lt;&amp;&gt;", "3 seeds", "Path length (cells)", "F1", "greedy", "#009E73"] {
            assert!(svg.contains(word), "{word}\n{svg}");
        }
        assert_eq!(svg.matches("<polygon").count(), 1, "{svg}");
    }

    #[test]
    fn one_seed_has_no_standard_error_to_draw() {
        assert!(!svg(&[None; 3], 0, 1).contains("<polygon"));
    }

    #[test]
    fn dashes_are_drawn_in_the_curve_and_in_the_legend() {
        let lines = |dashes, lines| svg(&[None; 3], dashes, lines).matches("stroke=\"#009E73\"").count();
        // The curve and its sample; or the curve and the line to its name.
        assert_eq!(lines(0, MOST_LABELS + 1), 2 * (MOST_LABELS + 1));
        assert_eq!(lines(0, MOST_LABELS), 2 * MOST_LABELS);
        for dashes in 1..LineStyle::DASHES {
            assert!(lines(dashes, MOST_LABELS + 1) > 10 * (MOST_LABELS + 1), "{dashes}");
        }
    }
}
