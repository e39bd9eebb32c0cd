//! Figures as SVG and as pixels, by one drawing for both.

use std::sync::LazyLock;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, FontTransform, register_font};

use super::ReportError;
use super::figure::{Figure, Look, Series};
use super::ticks::{Tick, ticks};

/// Size of a plot, pixels of the SVG.
const SIZE: (i32, i32) = (900, 460);
/// Where the axes are: left, top, right, bottom. The legend is on the right of them.
const FRAME: [i32; 4] = [84, 16, 640, 402];
/// Pixels of the PNG for one of the SVG.
const PIXELS: u32 = 2;
/// A line is drawn through about so many points at most.
const DRAWN: usize = 2500;
/// Told apart with every kind of colour vision (Okabe and Ito). The page maps them to lighter ones in the dark.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(138, 109, 0),
    RGBColor(86, 86, 206),
    RGBColor(96, 96, 96),
];
/// Axes and text.
const INK: RGBColor = RGBColor(17, 17, 17);
/// Lines of the grid.
const GRID: RGBColor = RGBColor(221, 221, 221);
/// The ground.
const PAPER: RGBColor = RGBColor(255, 255, 255);

/// A point of a series on the drawing.
pub(crate) struct Placed {
    pub(crate) series: usize,
    pub(crate) index: usize,
    pub(crate) at: (i32, i32),
}

/// A figure with its scales.
pub(crate) struct Plot<'a> {
    figure: &'a Figure,
    x: (f64, f64),
    y: (f64, f64),
    scale: i32,
}

type Outcome<E> = Result<(), DrawingAreaErrorKind<E>>;

impl<'a> Plot<'a> {
    pub(crate) fn new(figure: &'a Figure) -> Self {
        let range = |places: &mut dyn Iterator<Item = f64>| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for place in places {
                (low, high) = (low.min(place), high.max(place));
            }
            if low > high {
                return (0.0, 1.0);
            }
            // A range of nothing but rounding is none.
            let pad = if high - low > 1e-12 * low.abs().max(high.abs()) { 0.05 * (high - low) } else { 0.5 };
            (low - pad, high + pad)
        };
        let both = || {
            let points = figure.series.iter().flat_map(|series| &series.points);
            points.filter_map(|(x, y)| Some((figure.x.place(*x)?, figure.y.place(*y)?)))
        };
        Self { figure, x: range(&mut both().map(|p| p.0)), y: range(&mut both().map(|p| p.1)), scale: 1 }
    }

    /// Where a point is, in pixels; `None` if it cannot be drawn.
    fn at(&self, (x, y): (f64, f64)) -> Option<(i32, i32)> {
        let (x, y) = (self.figure.x.place(x)?, self.figure.y.place(y)?);
        Some((self.horizontal(x), self.vertical(y)))
    }

    fn horizontal(&self, place: f64) -> i32 {
        let [left, _, right, _] = FRAME;
        self.scale * left + (f64::from(self.scale * (right - left)) * part(place, self.x)).round() as i32
    }

    fn vertical(&self, place: f64) -> i32 {
        let [_, top, _, bottom] = FRAME;
        self.scale * bottom - (f64::from(self.scale * (bottom - top)) * part(place, self.y)).round() as i32
    }

    /// Every point that is drawn, for the page: marks all, lines at some places.
    pub(crate) fn placed(&self) -> Vec<Placed> {
        let mut placed = vec![];
        for (number, series) in self.figure.series.iter().enumerate() {
            let stride = if series.marked() { 1 } else { series.points.len().div_ceil(40).max(1) };
            for (index, point) in series.points.iter().enumerate().step_by(stride) {
                placed.extend(self.at(*point).map(|at| Placed { series: number, index, at }));
            }
        }
        placed
    }

    pub(crate) fn svg(&self) -> Result<String, ReportError> {
        fonts()?;
        let mut text = String::new();
        let size = (SIZE.0 as u32, SIZE.1 as u32);
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        self.draw(&area).map_err(|error| self.failed(&error))?;
        drop(area);
        Ok(text)
    }

    pub(crate) fn png(&self) -> Result<Vec<u8>, ReportError> {
        fonts()?;
        let (width, height) = (SIZE.0 as u32 * PIXELS, SIZE.1 as u32 * PIXELS);
        let mut pixels = vec![0; 3 * width as usize * height as usize];
        let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
        let larger = Plot { scale: PIXELS as i32, ..*self };
        larger.draw(&area).map_err(|error| self.failed(&error))?;
        drop(area);
        let mut file = vec![];
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(|error| self.failed(&error))?;
        writer.write_image_data(&pixels).map_err(|error| self.failed(&error))?;
        writer.finish().map_err(|error| self.failed(&error))?;
        Ok(file)
    }

    fn failed(&self, error: &dyn std::fmt::Display) -> ReportError {
        ReportError::Plot { figure: self.figure.title.clone(), cause: error.to_string() }
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Outcome<B::ErrorType> {
        area.fill(&PAPER)?;
        self.axes(area)?;
        for (number, series) in self.figure.series.iter().enumerate() {
            self.series(area, number, series)?;
        }
        self.legend(area)?;
        area.present()
    }

    fn axes<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Outcome<B::ErrorType> {
        let s = self.scale;
        let [left, top, right, bottom] = FRAME.map(|edge| s * edge);
        let line = |from: (i32, i32), to: (i32, i32), colour: RGBColor| {
            area.draw(&PathElement::new(vec![from, to], colour.stroke_width(s as u32)))
        };
        for Tick { place, label } in ticks(self.x, self.figure.x.logarithmic) {
            let x = self.horizontal(place);
            line((x, top), (x, bottom), GRID)?;
            self.text(area, &label, (x, bottom + 8 * s), 13, HPos::Center, VPos::Top)?;
        }
        for Tick { place, label } in ticks(self.y, self.figure.y.logarithmic) {
            let y = self.vertical(place);
            line((left, y), (right, y), GRID)?;
            self.text(area, &label, (left - 8 * s, y), 13, HPos::Right, VPos::Center)?;
        }
        line((left, bottom), (right, bottom), INK)?;
        line((left, top), (left, bottom), INK)?;
        let middle = ((left + right) / 2, (top + bottom) / 2);
        self.text(area, &self.figure.x.label, (middle.0, bottom + 32 * s), 15, HPos::Center, VPos::Top)?;
        let style = self.style(15, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
        area.draw(&Text::new(self.figure.y.label.as_str(), (10 * s, middle.1), style))
    }

    fn style(&self, size: i32, across: HPos, along: VPos) -> TextStyle<'static> {
        let font = ("sans-serif", size * self.scale).into_font();
        TextStyle::from(font).color(&INK).pos(Pos::new(across, along))
    }

    fn text<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        text: &str,
        at: (i32, i32),
        size: i32,
        across: HPos,
        along: VPos,
    ) -> Outcome<B::ErrorType> {
        area.draw(&Text::new(text, at, self.style(size, across, along)))
    }

    fn series<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        number: usize,
        series: &Series,
    ) -> Outcome<B::ErrorType> {
        let stride = if series.marked() { 1 } else { series.points.len().div_ceil(DRAWN).max(1) };
        let last = series.points.len().saturating_sub(1);
        let kept = series.points.iter().enumerate().filter(|(i, _)| i % stride == 0 || *i == last);
        let points: Vec<_> = kept.filter_map(|(_, point)| self.at(*point)).collect();
        self.stroke(area, series, points.clone())?;
        if series.marked() {
            for at in points {
                self.mark(area, number, series, at)?;
            }
        }
        Ok(())
    }

    fn stroke<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        series: &Series,
        points: Vec<(i32, i32)>,
    ) -> Outcome<B::ErrorType> {
        let width = |tenths: u32| (tenths * self.scale as u32).div_ceil(10);
        let style = |tenths: u32| colour(series.colour).stroke_width(width(tenths));
        match series.look {
            _ if points.len() < 2 => Ok(()),
            Look::Marks => Ok(()),
            Look::Joined | Look::Line => area.draw(&PathElement::new(points, style(15))),
            Look::Dashed => {
                let (dash, gap) = (7 * self.scale, 5 * self.scale);
                area.draw(&DashedPathElement::new(points, dash, gap, style(15)))
            }
        }
    }

    fn mark<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        number: usize,
        series: &Series,
        at: (i32, i32),
    ) -> Outcome<B::ErrorType> {
        let s = self.scale;
        let colour = colour(series.colour);
        match number % 4 {
            0 => area.draw(&Circle::new(at, 4 * s, colour.filled())),
            1 => area.draw(&TriangleMarker::new(at, 6 * s, colour.filled())),
            2 => {
                let corners = [(at.0 - 4 * s, at.1 - 4 * s), (at.0 + 4 * s, at.1 + 4 * s)];
                area.draw(&Rectangle::new(corners, colour.filled()))
            }
            _ => area.draw(&Cross::new(at, 5 * s, colour.stroke_width(2 * s as u32))),
        }
    }

    fn legend<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Outcome<B::ErrorType> {
        let s = self.scale;
        let (left, mut y) = (s * (FRAME[2] + 22), s * (FRAME[1] + 10));
        let all = &self.figure.series;
        for (number, series) in all.iter().enumerate() {
            // Series of one name and look are one in the legend.
            if all.iter().take(number).any(|other| (&other.name, other.look) == (&series.name, series.look)) {
                continue;
            }
            self.stroke(area, series, vec![(left, y), (left + 26 * s, y)])?;
            if series.marked() {
                self.mark(area, number, series, (left + 13 * s, y))?;
            }
            for (row, line) in wrapped(&series.name, 25).iter().enumerate() {
                let at = (left + 36 * s, y + 17 * s * row as i32);
                self.text(area, line, at, 14, HPos::Left, VPos::Center)?;
                y += if row > 0 { 17 * s } else { 0 };
            }
            y += 24 * s;
        }
        Ok(())
    }
}

/// How far a place is along a range, 0 to 1.
fn part(place: f64, (low, high): (f64, f64)) -> f64 {
    (place - low) / (high - low)
}

fn colour(index: usize) -> RGBColor {
    PALETTE[index % PALETTE.len()]
}

/// Text in lines of about so many characters, broken at spaces.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = vec![];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// The font of both backends: none of the machine is needed.
fn fonts() -> Result<(), ReportError> {
    static REGISTERED: LazyLock<bool> = LazyLock::new(|| {
        register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok()
    });
    match *REGISTERED {
        true => Ok(()),
        false => Err(ReportError::Format("the font of the plots is unusable".into())),
    }
}
