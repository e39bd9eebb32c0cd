//! Figures as SVG and, with the feature `plot`, as pixels, by one drawing for both.
//!
//! Tested by `tests/paths/results.rs`.

use std::collections::HashSet;
#[cfg(all(feature = "plot", not(target_arch = "wasm32")))]
use std::sync::LazyLock;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};
#[cfg(all(feature = "plot", not(target_arch = "wasm32")))]
use plotters::style::{FontStyle, register_font};

use super::axes::ranges;
use super::figure::{Axis, Colour, Figure, Look, Series, Shades};
use super::layout::{BAR, Entry, INDENT, KEY, Layout};
use super::ticks::{Tick, ticks};
use crate::trajectory::error::PlotError;

/// Lines of more points are drawn to the pixel ([`thinned`]).
const DRAWN: usize = 2500;
/// Lines that have more points even then are drawn as dots.
const MOST_JOINED: usize = 20_000;
/// Told apart with every kind of colour vision (Okabe and Ito), in the order of [`Colour`]. A page maps them
/// to lighter ones in the dark.
const PALETTE: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(138, 109, 0),
    RGBColor(86, 86, 206),
    RGBColor(96, 96, 96),
    INK,
];
/// From low to high, told apart with every kind of colour vision, and in print by their lightness (S. van der
/// Walt, N. Smith, "viridis").
const SCALE: [RGBColor; 10] = [
    RGBColor(68, 1, 84),
    RGBColor(72, 40, 120),
    RGBColor(62, 74, 137),
    RGBColor(49, 104, 142),
    RGBColor(38, 130, 142),
    RGBColor(31, 158, 137),
    RGBColor(53, 183, 121),
    RGBColor(109, 205, 89),
    RGBColor(180, 222, 44),
    RGBColor(253, 231, 37),
];
/// Colours between them that are drawn.
const SHADES: usize = 64;
/// Axes and text.
const INK: RGBColor = RGBColor(17, 17, 17);
/// Lines of the grid.
const GRID: RGBColor = RGBColor(221, 221, 221);
/// The ground.
const PAPER: RGBColor = RGBColor(255, 255, 255);

/// A point of a series on the drawing.
pub(crate) struct PlacedPoint {
    pub(crate) series: usize,
    pub(crate) index: usize,
    pub(crate) at: (i32, i32),
}

/// A figure with its scales.
#[derive(Clone)]
pub(crate) struct Plot<'a> {
    figure: &'a Figure,
    layout: Layout,
    x: (f64, f64),
    y: (f64, f64),
    scale: i32,
    /// Whether letters are drawn in the font of this library, which has no raised minus; browsers take their
    /// own.
    is_bitmap: bool,
}

type DrawResult<E> = Result<(), DrawingAreaErrorKind<E>>;

/// Drawings beside each other, with the places of their corners, as the text of an SVG file of this size.
pub(super) fn drawn_svg(size: (u32, u32), plots: &[((i32, i32), Plot<'_>)]) -> Result<String, PlotError> {
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
    drawn(&area, plots)?;
    drop(area);
    Ok(text)
}

/// The content of a PNG file.
#[cfg(feature = "plot")]
pub(super) fn drawn_png(size: (u32, u32), plots: &[((i32, i32), Plot<'_>)]) -> Result<Vec<u8>, PlotError> {
    let (width, height) = size;
    let mut pixels = vec![0; 3 * width as usize * height as usize];
    let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
    let plots: Vec<_> = plots.iter().map(|(corner, plot)| (*corner, plot.as_pixels())).collect();
    drawn(&area, &plots)?;
    drop(area);
    encoded(&pixels, size).map_err(|error| failed(&plots, &error))
}

#[cfg(feature = "plot")]
fn encoded(pixels: &[u8], (width, height): (u32, u32)) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = vec![];
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(file)
}

fn drawn<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    plots: &[((i32, i32), Plot<'_>)],
) -> Result<(), PlotError> {
    if !has_font() {
        return Err(failed(plots, &"its font is unusable"));
    }
    plots.iter().try_for_each(|(_, plot)| plot.check())?;
    area.fill(&PAPER).map_err(|error| failed(plots, &error))?;
    for (corner, plot) in plots {
        let (width, height) = plot.layout.size;
        let (width, height) = ((width * plot.scale) as u32, (height * plot.scale) as u32);
        let part = area.clone().shrink(*corner, (width, height));
        plot.draw(&part).map_err(|error| failed(plots, &error))?;
    }
    area.present().map_err(|error| failed(plots, &error))
}

fn failed(plots: &[((i32, i32), Plot<'_>)], error: &dyn std::fmt::Display) -> PlotError {
    let figure = plots.first().map_or_else(String::new, |(_, plot)| plot.figure.title.clone());
    PlotError::Drawing { figure, cause: error.to_string() }
}

impl<'a> Plot<'a> {
    pub(crate) fn new(figure: &'a Figure, layout: Layout, scale: i32) -> Self {
        let [x, y] = ranges(figure, &layout);
        Self { figure, layout, x, y, scale, is_bitmap: false }
    }

    /// Refuses limits that are no range.
    fn check(&self) -> Result<(), PlotError> {
        for (axis, name) in [(&self.figure.x, 'x'), (&self.figure.y, 'y')] {
            if let Some((from, to)) = axis.range
                && axis.places(from, to).is_none()
            {
                return Err(PlotError::Range { figure: self.figure.title.clone(), axis: name, from, to });
            }
        }
        Ok(())
    }

    #[cfg(feature = "plot")]
    fn as_pixels(&self) -> Self {
        Self { is_bitmap: true, ..self.clone() }
    }

    /// The glyphs of a text: in the font of this library a raised minus is drawn as a macron.
    fn letters(&self, text: &str) -> String {
        if self.is_bitmap { text.replace('⁻', "¯") } else { text.to_owned() }
    }

    /// The place of a point, in pixels; `None` if it cannot be drawn.
    fn at(&self, (x, y): (f64, f64)) -> Option<(i32, i32)> {
        let (x, y) = (self.figure.x.place(x)?, self.figure.y.place(y)?);
        let is_inside = |place: f64, (low, high): (f64, f64)| (low..=high).contains(&place);
        (is_inside(x, self.x) && is_inside(y, self.y)).then(|| (self.horizontal(x), self.vertical(y)))
    }

    fn horizontal(&self, place: f64) -> i32 {
        let [left, _, right, _] = self.layout.frame;
        self.scale * left + (f64::from(self.scale * (right - left)) * part(place, self.x)).round() as i32
    }

    fn vertical(&self, place: f64) -> i32 {
        let [_, top, _, bottom] = self.layout.frame;
        self.scale * bottom - (f64::from(self.scale * (bottom - top)) * part(place, self.y)).round() as i32
    }

    /// Every point that is drawn, for the page: marks all, lines at some places.
    pub(crate) fn placed(&self) -> Vec<PlacedPoint> {
        let mut placed = vec![];
        for (number, series) in self.figure.series.iter().enumerate() {
            let stride = if series.marked() { 1 } else { series.points.len().div_ceil(40).max(1) };
            for (index, point) in series.points.iter().enumerate().step_by(stride) {
                placed.extend(self.at(*point).map(|at| PlacedPoint { series: number, index, at }));
            }
        }
        placed
    }

    /// Width and height, in pixels.
    pub(crate) fn size(&self) -> (u32, u32) {
        let (width, height) = self.layout.size;
        ((self.scale * width) as u32, (self.scale * height) as u32)
    }

    pub(crate) fn svg(&self) -> Result<String, PlotError> {
        drawn_svg(self.size(), &[((0, 0), self.clone())])
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> DrawResult<B::ErrorType> {
        if let Some((x, y)) = self.layout.title {
            let at = (self.scale * x, self.scale * y);
            self.text(area, &self.figure.title, at, 16, HPos::Left, VPos::Top)?;
        }
        self.axes(area)?;
        if let Some(shades) = &self.figure.shades {
            self.shades(area, shades)?;
            self.bar(area, shades)?;
        }
        for (number, series) in self.figure.series.iter().enumerate() {
            self.series(area, number, series)?;
        }
        self.layout.legend.iter().try_for_each(|entry| self.entry(area, entry))
    }

    fn axes<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> DrawResult<B::ErrorType> {
        let s = self.scale;
        let [left, top, right, bottom] = self.layout.frame.map(|edge| s * edge);
        let line = |from: (i32, i32), to: (i32, i32), colour: RGBColor| {
            area.draw(&PathElement::new(vec![from, to], colour.stroke_width(s as u32)))
        };
        let [across, along] = self.layout.marks();
        for Tick { place, label } in ticks(self.x, &self.figure.x, across) {
            let x = self.horizontal(place);
            line((x, top), (x, bottom), GRID)?;
            self.text(area, &label, (x, bottom + 8 * s), 13, HPos::Center, VPos::Top)?;
        }
        for Tick { place, label } in ticks(self.y, &self.figure.y, along) {
            let y = self.vertical(place);
            line((left, y), (right, y), GRID)?;
            self.text(area, &label, (left - 8 * s, y), 13, HPos::Right, VPos::Center)?;
        }
        line((left, bottom), (right, bottom), INK)?;
        line((left, top), (left, bottom), INK)?;
        let middle = ((left + right) / 2, (top + bottom) / 2);
        self.text(area, &self.figure.x.label, (middle.0, bottom + 30 * s), 15, HPos::Center, VPos::Top)?;
        let label = &self.figure.y.label;
        if label.chars().count() == 1 {
            return self.text(area, label, (4 * s, middle.1), 15, HPos::Left, VPos::Center);
        }
        let style = self.style(15, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
        area.draw(&Text::new(self.letters(label), (4 * s, middle.1), style))
    }

    /// A rectangle for each run of cells with one colour.
    fn shades<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        shades: &Shades,
    ) -> DrawResult<B::ErrorType> {
        let [w, h] = [0.5 * shades.cell.0, 0.5 * shades.cell.1];
        let mut cells: Vec<(f64, f64, usize)> = shades
            .points
            .iter()
            .filter_map(|(x, y, value)| Some((*y, *x, shade(*value, shades.range)?)))
            .collect();
        cells.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let is_one =
            |a: &(f64, f64, usize), b: &(f64, f64, usize)| a.0 == b.0 && a.2 == b.2 && b.1 - a.1 < 3.0 * w;
        for run in cells.chunk_by(is_one) {
            let ([first, ..], [.., last]) = (run, run) else { continue };
            let corner = |x: f64, y: f64| {
                let inside = |place: f64, (low, high): (f64, f64)| place.clamp(low, high);
                let (x, y) = (self.figure.x.place(x)?, self.figure.y.place(y)?);
                Some((self.horizontal(inside(x, self.x)), self.vertical(inside(y, self.y))))
            };
            let corners = (corner(first.1 - w, first.0 + h), corner(last.1 + w, last.0 - h));
            if let (Some(one), Some(other)) = corners {
                area.draw(&Rectangle::new([one, other], scaled(first.2).filled()))?;
            }
        }
        Ok(())
    }

    /// The bar of colours beside the axes.
    fn bar<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        shades: &Shades,
    ) -> DrawResult<B::ErrorType> {
        let s = self.scale;
        let [_, top, right, bottom] = self.layout.frame.map(|edge| s * edge);
        let (left, right) = (right + s * BAR, right + 2 * s * BAR);
        let height = |part: f64| bottom - (f64::from(bottom - top) * part).round() as i32;
        for number in 0..SHADES {
            let [low, high] = [number, number + 1].map(|edge| height(edge as f64 / SHADES as f64));
            area.draw(&Rectangle::new([(left, high), (right, low)], scaled(number).filled()))?;
        }
        let [_, marks] = self.layout.marks();
        for Tick { place, label } in ticks(shades.range, &Axis::linear(""), marks) {
            let y = height(part(place, shades.range));
            self.text(area, &label, (right + 6 * s, y), 13, HPos::Left, VPos::Center)?;
        }
        let style = self.style(15, HPos::Center, VPos::Bottom).transform(FontTransform::Rotate270);
        let (width, _) = self.layout.size;
        area.draw(&Text::new(self.letters(&shades.label), (s * width - 8 * s, (top + bottom) / 2), style))
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
    ) -> DrawResult<B::ErrorType> {
        area.draw(&Text::new(self.letters(text), at, self.style(size, across, along)))
    }

    fn series<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        number: usize,
        series: &Series,
    ) -> DrawResult<B::ErrorType> {
        let points: Vec<Option<(i32, i32)>> = series.points.iter().map(|point| self.at(*point)).collect();
        // Points that are outside, or have no place, interrupt a line.
        let pieces = points.split(Option::is_none);
        let pieces = pieces.map(|piece| piece.iter().flatten().copied().collect::<Vec<_>>());
        let mut pieces: Vec<Vec<(i32, i32)>> = pieces.collect();
        if series.joined() && points.len() > DRAWN {
            pieces.iter_mut().for_each(|piece| *piece = thinned(piece));
            if pieces.iter().map(Vec::len).sum::<usize>() > MOST_JOINED {
                return self.dots(area, series, points.into_iter().flatten());
            }
        }
        pieces.into_iter().try_for_each(|piece| self.stroke(area, series, piece))?;
        points.into_iter().flatten().try_for_each(|at| self.mark(area, number, series, at))
    }

    /// A dot in each cell of its width that has a point.
    fn dots<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        series: &Series,
        points: impl Iterator<Item = (i32, i32)>,
    ) -> DrawResult<B::ErrorType> {
        let (width, mut known) = (self.scale, HashSet::new());
        let new = points.filter(|(x, y)| known.insert((x / width, y / width)));
        let new: Vec<(i32, i32)> = new.collect();
        let style = colour(series.colour).filled();
        new.into_iter().try_for_each(|at| area.draw(&Circle::new(at, (width / 2).max(1), style)))
    }

    fn stroke<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        series: &Series,
        points: Vec<(i32, i32)>,
    ) -> DrawResult<B::ErrorType> {
        let width = |tenths: u32| (tenths * self.scale as u32).div_ceil(10);
        let style = |tenths: u32| colour(series.colour).stroke_width(width(tenths));
        match series.look {
            _ if points.len() < 2 => Ok(()),
            Look::Marks | Look::Dots | Look::FineDots => Ok(()),
            Look::Joined | Look::Line => self.line(area, points, style(15)),
            Look::Broad => self.line(area, points, style(40)),
            Look::Dashed => {
                let (dash, gap) = (7 * self.scale, 5 * self.scale);
                area.draw(&DashedPathElement::new(points, dash, gap, style(15)))
            }
        }
    }

    /// A line through points. In pixels its pieces are drawn one by one with round joints: the corners that
    /// the backend would draw grow without bound as the angle between pieces falls.
    fn line<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        points: Vec<(i32, i32)>,
        style: ShapeStyle,
    ) -> DrawResult<B::ErrorType> {
        if !self.is_bitmap {
            return area.draw(&PathElement::new(points, style));
        }
        let radius = style.stroke_width / 2;
        for piece in points.windows(2) {
            if piece[0] != piece[1] {
                area.draw(&PathElement::new(piece.to_vec(), style))?;
                area.draw(&Circle::new(piece[1], radius, style.filled()))?;
            }
        }
        Ok(())
    }

    fn mark<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        number: usize,
        series: &Series,
        at: (i32, i32),
    ) -> DrawResult<B::ErrorType> {
        let (s, colour) = (self.scale, colour(series.colour));
        match (series.look, number % 4) {
            (Look::Line | Look::Dashed | Look::Broad, _) => Ok(()),
            (Look::FineDots, _) => area.draw(&Circle::new(at, s, colour.filled())),
            (Look::Dots, _) => area.draw(&Circle::new(at, (5 * s) / 2, colour.filled())),
            (_, 0) => area.draw(&Circle::new(at, 4 * s, colour.filled())),
            (_, 1) => area.draw(&TriangleMarker::new(at, 6 * s, colour.filled())),
            (_, 2) => {
                let corners = [(at.0 - 4 * s, at.1 - 4 * s), (at.0 + 4 * s, at.1 + 4 * s)];
                area.draw(&Rectangle::new(corners, colour.filled()))
            }
            _ => area.draw(&Cross::new(at, 5 * s, colour.stroke_width(2 * s as u32))),
        }
    }

    fn entry<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        entry: &Entry,
    ) -> DrawResult<B::ErrorType> {
        let s = self.scale;
        let Some(series) = self.figure.series.get(entry.series) else { return Ok(()) };
        let (x, y) = (s * entry.at.0, s * entry.at.1);
        self.stroke(area, series, vec![(x, y), (x + KEY * s, y)])?;
        self.mark(area, entry.series, series, (x + KEY / 2 * s, y))?;
        self.text(area, &series.name, (x + INDENT * s, y), 14, HPos::Left, VPos::Center)
    }
}

/// A line with the same pixels and fewer points: of neighbours in one column of pixels the first, the lowest,
/// the highest and the last, in their order.
fn thinned(points: &[(i32, i32)]) -> Vec<(i32, i32)> {
    let mut thin: Vec<(i32, i32)> = Vec::new();
    for column in points.chunk_by(|a, b| a.0 == b.0) {
        let place = |best: Option<usize>| best.unwrap_or(0);
        let lowest = place((0..column.len()).min_by_key(|&i| column[i].1));
        let highest = place((0..column.len()).max_by_key(|&i| column[i].1));
        let kept = [0, lowest.min(highest), lowest.max(highest), column.len() - 1];
        for at in kept.map(|i| column[i]) {
            if thin.last() != Some(&at) {
                thin.push(at);
            }
        }
    }
    thin
}

/// The number of the colour of a value; none for NaN.
fn shade(value: f64, range: (f64, f64)) -> Option<usize> {
    let place = (SHADES as f64 * part(value, range)).clamp(0.0, SHADES as f64 - 1.0);
    (!place.is_nan()).then_some(place as usize)
}

/// The colour of this number.
fn scaled(number: usize) -> RGBColor {
    let place = number as f64 / (SHADES - 1) as f64 * (SCALE.len() - 1) as f64;
    let (low, share) =
        ((place as usize).min(SCALE.len() - 2), place - (place as usize).min(SCALE.len() - 2) as f64);
    let mix = |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    let (RGBColor(r, g, b), RGBColor(to_r, to_g, to_b)) = (SCALE[low], SCALE[low + 1]);
    RGBColor(mix(r, to_r), mix(g, to_g), mix(b, to_b))
}

/// How far a place is along a range, 0 to 1.
fn part(place: f64, (low, high): (f64, f64)) -> f64 {
    (place - low) / (high - low)
}

fn colour(index: usize) -> RGBColor {
    if index == Colour::INK { INK } else { PALETTE[index % (PALETTE.len() - 1)] }
}

/// Whether the font of pixels is registered: no font of the machine is needed.
#[cfg(all(feature = "plot", not(target_arch = "wasm32")))]
fn has_font() -> bool {
    static REGISTERED: LazyLock<bool> = LazyLock::new(|| {
        register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok()
    });
    *REGISTERED
}

/// A reader of SVG has fonts of its own, and so has a browser.
#[cfg(not(all(feature = "plot", not(target_arch = "wasm32"))))]
fn has_font() -> bool {
    true
}
