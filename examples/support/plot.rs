//! Pictures for people: panels of lines and points in one SVG file, with units, legends and colours that colour-blind
//! readers can tell apart (Okabe and Ito).

#![allow(dead_code, reason = "each example takes what it needs")]

use std::error::Error;
use std::ops::Range;
use std::path::PathBuf;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

pub(crate) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(crate) const VERMILION: RGBColor = RGBColor(213, 94, 0);
pub(crate) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(crate) const ORANGE: RGBColor = RGBColor(230, 159, 0);
pub(crate) const SKY: RGBColor = RGBColor(86, 180, 233);
pub(crate) const PURPLE: RGBColor = RGBColor(204, 121, 167);
pub(crate) const BLACK: RGBColor = RGBColor(0, 0, 0);
pub(crate) const GREY: RGBColor = RGBColor(150, 150, 150);

/// The backend has whole pixels, so pictures are drawn large.
const TITLE: i32 = 30;
const TEXT: i32 = 26;
const FONT: &str = "sans-serif";

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

#[derive(Clone, Copy, PartialEq)]
enum Style {
    Line(u32),
    Dashes,
    Dots(u32),
    /// Line with a marker at each point.
    Marked,
}

struct Series {
    label: String,
    color: RGBColor,
    style: Style,
    points: Vec<(f64, f64)>,
}

/// One coordinate system with what is drawn in it.
pub(crate) struct Panel {
    title: String,
    labels: [String; 2],
    log: [bool; 2],
    ranges: [Option<Range<f64>>; 2],
    equal: bool,
    series: Vec<Series>,
}

impl Panel {
    /// Labels carry the unit: `"time t [1/ω]"`.
    pub(crate) fn new(title: &str, x: &str, y: &str) -> Self {
        Self {
            title: title.into(),
            labels: [x.into(), y.into()],
            log: [false; 2],
            ranges: [None, None],
            equal: false,
            series: Vec::new(),
        }
    }

    pub(crate) fn log_log(mut self) -> Self {
        self.log = [true; 2];
        self
    }

    pub(crate) fn log_y(mut self) -> Self {
        self.log[1] = true;
        self
    }

    /// One unit is as long up as across.
    pub(crate) fn equal_axes(mut self) -> Self {
        self.equal = true;
        self
    }

    pub(crate) fn x_range(mut self, range: Range<f64>) -> Self {
        self.ranges[0] = Some(range);
        self
    }

    pub(crate) fn y_range(mut self, range: Range<f64>) -> Self {
        self.ranges[1] = Some(range);
        self
    }

    pub(crate) fn line(self, label: &str, color: RGBColor, points: impl Points) -> Self {
        self.series(label, color, Style::Line(3), points)
    }

    /// A broad line, to lie under others.
    pub(crate) fn broad(self, label: &str, color: RGBColor, points: impl Points) -> Self {
        self.series(label, color, Style::Line(8), points)
    }

    pub(crate) fn dashes(self, label: &str, color: RGBColor, points: impl Points) -> Self {
        self.series(label, color, Style::Dashes, points)
    }

    pub(crate) fn marked(self, label: &str, color: RGBColor, points: impl Points) -> Self {
        self.series(label, color, Style::Marked, points)
    }

    pub(crate) fn dots(self, label: &str, color: RGBColor, radius: u32, points: impl Points) -> Self {
        self.series(label, color, Style::Dots(radius), points)
    }

    /// The guide `y = c x^order` between two abscissae of a log-log panel.
    pub(crate) fn slope(self, label: &str, order: f64, c: f64, [from, to]: [f64; 2]) -> Self {
        self.dashes(label, GREY, [from, to].map(|x| (x, c * x.powf(order))))
    }

    fn series(mut self, label: &str, color: RGBColor, style: Style, points: impl Points) -> Self {
        let points = points.into_iter().collect();
        self.series.push(Series { label: label.into(), color, style, points });
        self
    }

    fn draw(&self, area: &Area<'_>) -> Result<(), Box<dyn Error>> {
        let (width, _) = area.dim_in_pixel();
        let (width, margin) = (i32::try_from(width)?, 16);
        let title = (FONT, TITLE).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Top));
        area.draw(&Text::new(self.title.clone(), (margin, 12), title))?;
        let top = self.draw_legend(area, margin, 24 + TITLE, width)? + 8;

        let [x, y] = self.axes(area, top);
        let mut chart = ChartBuilder::on(area)
            .margin_top(top)
            .margin_right(34)
            .margin_left(margin)
            .margin_bottom(8)
            .x_label_area_size(74)
            .y_label_area_size(118)
            .build_cartesian_2d(x.clone(), y.clone())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(225, 225, 225))
            .axis_style(RGBColor(90, 90, 90))
            .x_labels(x.ticks.len())
            .y_labels(y.ticks.len())
            .label_style((FONT, TEXT - 2))
            .axis_desc_style((FONT, TEXT))
            .x_desc(self.labels[0].as_str())
            .y_desc(self.labels[1].as_str())
            .draw()?;
        for series in &self.series {
            let color = series.color;
            let at = |&(px, py): &(f64, f64)| (x.place(px), y.place(py));
            let places: Vec<(f64, f64)> = series.points.iter().map(at).collect();
            // Points outside, or without a place (zero on a logarithmic axis, NaN), interrupt a line.
            let inside = |(px, py): &(f64, f64)| x.range.contains(px) && y.range.contains(py);
            let pieces = || places.split(|place| !inside(place)).filter(|piece| !piece.is_empty());
            let dots = |radius: u32| {
                pieces()
                    .flatten()
                    .map(move |&place| Circle::new(place, radius, color.filled()))
                    .collect::<Vec<_>>()
            };
            match series.style {
                Style::Line(stroke) => {
                    for piece in pieces() {
                        let line = piece.iter().copied();
                        chart.draw_series(LineSeries::new(line, color.stroke_width(stroke)))?;
                    }
                }
                Style::Dashes => {
                    for piece in pieces() {
                        let line = piece.iter().copied();
                        chart.draw_series(DashedLineSeries::new(line, 14, 8, color.stroke_width(3)))?;
                    }
                }
                Style::Dots(radius) => {
                    chart.draw_series(dots(radius))?;
                }
                Style::Marked => {
                    for piece in pieces() {
                        let line = piece.iter().copied();
                        chart.draw_series(LineSeries::new(line, color.stroke_width(3)))?;
                    }
                    chart.draw_series(dots(7))?;
                }
            }
        }
        Ok(())
    }

    /// A row of keys above the plot, so that it never covers data; answers where it ends.
    fn draw_legend(&self, area: &Area<'_>, left: i32, top: i32, width: i32) -> Result<i32, Box<dyn Error>> {
        const KEY: i32 = 44;
        let row = TEXT + 10;
        let (mut x, mut y) = (left, top);
        let text = (FONT, TEXT).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
        let labelled = || self.series.iter().filter(|series| !series.label.is_empty());
        for series in labelled() {
            let letters = i32::try_from(series.label.chars().count())?;
            let length = KEY + 10 + letters * TEXT * 58 / 100;
            if x > left && x + length > width {
                (x, y) = (left, y + row);
            }
            let middle = y + row / 2;
            let color = series.color;
            let ends = [(x, middle), (x + KEY, middle)];
            match series.style {
                Style::Line(stroke) => {
                    area.draw(&PathElement::new(ends, color.stroke_width(stroke.max(4))))?;
                }
                Style::Dashes => {
                    for from in [x, x + 16, x + 32] {
                        let dash = [(from, middle), (from + 10, middle)];
                        area.draw(&PathElement::new(dash, color.stroke_width(4)))?;
                    }
                }
                Style::Dots(_) => area.draw(&Circle::new((x + KEY / 2, middle), 7, color.filled()))?,
                Style::Marked => {
                    area.draw(&PathElement::new(ends, color.stroke_width(4)))?;
                    area.draw(&Circle::new((x + KEY / 2, middle), 7, color.filled()))?;
                }
            }
            area.draw(&Text::new(series.label.clone(), (x + KEY + 10, middle), text.clone()))?;
            x += length + 26;
        }
        Ok(if labelled().next().is_some() { y + row } else { top })
    }

    fn axes(&self, area: &Area<'_>, top: i32) -> [Axis; 2] {
        let extent = |axis: usize| {
            let log = self.log[axis];
            let values = self.series.iter().flat_map(|series| &series.points);
            let values = values.map(|&(x, y)| place(log, [x, y][axis])).filter(|value| value.is_finite());
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
            let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
            let pad = if low < high { 0.04 * (high - low) } else { 0.5 * low.abs().max(1e-12) };
            match &self.ranges[axis] {
                Some(range) => place(log, range.start)..place(log, range.end),
                None => low - pad..high + pad,
            }
        };
        let [mut x, mut y] = [extent(0), extent(1)];
        if self.equal {
            let (width, height) = area.dim_in_pixel();
            let (width, height) = (f64::from(width) - 168.0, f64::from(height) - 82.0 - f64::from(top));
            let unit = ((x.end - x.start) / width).max((y.end - y.start) / height);
            let widen = |range: &Range<f64>, pixels: f64| {
                let middle = 0.5 * (range.start + range.end);
                middle - 0.5 * unit * pixels..middle + 0.5 * unit * pixels
            };
            (x, y) = (widen(&x, width), widen(&y, height));
        }
        [Axis::new(x, self.log[0], 8), Axis::new(y, self.log[1], 7)]
    }
}

fn place(log: bool, value: f64) -> f64 {
    if log { value.log10() } else { value }
}

/// Whatever yields points.
pub(crate) trait Points: IntoIterator<Item = (f64, f64)> {}

impl<I: IntoIterator<Item = (f64, f64)>> Points for I {}

/// A linear axis, or a logarithmic one in decades.
#[derive(Clone)]
struct Axis {
    range: Range<f64>,
    log: bool,
    ticks: Vec<f64>,
    step: f64,
}

impl Axis {
    fn new(range: Range<f64>, log: bool, most: u32) -> Self {
        let raw = (range.end - range.start) / f64::from(most);
        let decade = 10f64.powf(raw.log10().floor());
        let nice = [1.0, 2.0, 5.0, 10.0].into_iter().find(|nice| nice * decade >= raw).unwrap_or(10.0);
        let step = if log { (nice * decade).max(1.0).ceil() } else { nice * decade };
        let (first, last) = ((range.start / step).ceil() as i64, (range.end / step).floor() as i64);
        let mut ticks: Vec<f64> = (first..=last).map(|tick| tick as f64 * step).collect();
        if log && ticks.len() < 3 {
            // Less than two decades: 1, 2, 5 of each.
            let decades = range.start.floor() as i64..=range.end.floor() as i64;
            let all = decades.flat_map(|n| [1.0, 2.0, 5.0].map(|nice: f64| n as f64 + nice.log10()));
            ticks = all.filter(|tick| range.contains(tick)).collect();
        }
        Self { range, log, ticks, step }
    }

    fn place(&self, value: f64) -> f64 {
        place(self.log, value)
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (low, high): (i32, i32)) -> i32 {
        let part = (value - self.range.start) / (self.range.end - self.range.start);
        // Far outside is far enough: what leaves the picture must not leave the integers.
        low + (part.clamp(-20.0, 20.0) * f64::from(high - low)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, &at: &f64) -> String {
        if self.log {
            let whole = (at + 1e-9).floor();
            let leading = 10f64.powf(at - whole).round();
            let power = format!("10{}", superscript(whole as i32));
            return if leading == 1.0 { power } else { format!("{leading}·{power}") };
        }
        if at == 0.0 {
            return "0".into();
        }
        let largest = self.range.start.abs().max(self.range.end.abs());
        if !(1e-3..1e5).contains(&largest) {
            let text = format!("{at:.*e}", usize::from(largest / self.step > 9.0));
            let (mantissa, power) = text.split_once('e').unwrap_or((&text, "0"));
            return format!("{mantissa}·10{}", superscript(power.parse().unwrap_or(0)));
        }
        let digits = (-self.step.log10().floor()).max(0.0) as usize;
        format!("{at:.digits$}")
    }
}

fn superscript(power: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digit = |letter: char| letter.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]);
    power.to_string().chars().map(digit).collect()
}

/// Draws panels, `columns` to a row, each `size` pixels, into `target/wzvi/<example>/<name>.svg` under the working
/// directory, and says so.
pub(crate) fn save(
    example: &str,
    name: &str,
    columns: usize,
    size: (u32, u32),
    panels: &[Panel],
) -> Result<(), Box<dyn Error>> {
    let folder: PathBuf = ["target", "wzvi", example].iter().collect();
    std::fs::create_dir_all(&folder)?;
    let file = folder.join(format!("{name}.svg"));
    let rows = panels.len().div_ceil(columns);
    let whole = (size.0 * u32::try_from(columns)?, size.1 * u32::try_from(rows)?);
    let root = SVGBackend::new(&file, whole).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, panel) in root.split_evenly((rows, columns)).iter().zip(panels) {
        panel.draw(area)?;
    }
    root.present()?;
    println!("  {}", file.display());
    Ok(())
}
