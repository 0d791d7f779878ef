//! A page of panels over one axis of frames, on the plotting crate's SVG: boxes, curves, bars, marks, words.
//!
//! The crate counts in whole pixels; a pixel here is a tenth of one on the page, so that curves don't show steps.

use super::columns::Run;
use plotters::coord::Shift;
use plotters::coord::ranged1d::Ranged;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::{
    BLACK, Cartesian2d, Circle, Color, DrawingArea, DrawingAreaErrorKind, IntoDrawingArea, IntoFont, PathElement,
    RGBColor, Rectangle, SVGBackend, ShapeStyle, Text, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, IntoTextStyle};
use std::ops::Range;

/// What drawing gives: nothing that is drawn into text fails, but the crate's types can say so.
pub(super) type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Widths on the page, pixels.
pub(super) const PAGE_WIDTH: f64 = 1200.0;
pub(super) const LEFT: f64 = 96.0;
pub(super) const RIGHT: f64 = 20.0;
/// What the crate counts for a pixel of the page.
const FINENESS: f64 = 10.0;
/// The one size of letters, 12.5 pixels, as the crate has it: 1.24 times as large; and how wide letters are on average.
const LETTER_SIZE: f64 = 12.5 * 1.24 * FINENESS;
const LETTER_WIDTH: f64 = 7.4;

pub(super) const INK: RGBColor = RGBColor(34, 34, 34);
const FAINT: RGBColor = RGBColor(228, 228, 228);
const FRAME: RGBColor = RGBColor(150, 150, 150);
const DASHES: RGBColor = RGBColor(90, 90, 90);

/// The page.
pub(super) struct Canvas<'a> {
    root: DrawingArea<SVGBackend<'a>, Shift>,
    /// On the axis, in frames: half a frame before the first to half a frame after the last.
    frames: Range<f64>,
    /// Where lines go down through all panels, in frames.
    time_marks: Vec<f64>,
}

/// A box over the axis of frames.
pub(super) struct Panel<'a> {
    area: DrawingArea<SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>,
    y: Range<f64>,
}

/// One entry of what stands above a panel on the right.
pub(super) enum Key<'a> {
    /// A curve of that color and width.
    Line(&'a str, RGBColor, f64),
    /// A dashed line across.
    Dashes(&'a str),
    /// A patch of that color.
    Patch(&'a str, RGBColor),
}

/// Where words stand at their place.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

fn fine(pixels: f64) -> i32 {
    (pixels * FINENESS).round() as i32
}

fn stroke(color: RGBColor, width: f64) -> ShapeStyle {
    color.stroke_width(fine(width).max(1) as u32)
}

/// XML has no way to write most control characters.
fn printable(text: &str) -> String {
    text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect()
}

/// Round numbers between two, at most `n`.
pub(super) fn round_marks(range: &Range<f64>, n: usize) -> Vec<f64> {
    let marks = RangedCoordf64::from(range.start..range.end).key_points(n);
    marks.into_iter().filter(|mark| (range.start..=range.end).contains(mark)).collect()
}

/// How many decimals tell round numbers at one distance apart.
fn decimals(marks: &[f64]) -> usize {
    let step = marks.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let mut decimals = 0;
    let mut unit = 1.0;
    while step.is_finite() && decimals < 6 && unit > step * 1.01 {
        unit /= 10.0;
        decimals += 1;
    }
    decimals
}

/// Round numbers as words, all with the same decimals.
pub(super) fn spelled(marks: &[f64]) -> Vec<String> {
    let decimals = decimals(marks);
    // No -0.0.
    marks.iter().map(|&mark| format!("{:.decimals$}", if mark.abs() < 1e-9 { 0.0 } else { mark })).collect()
}

/// How wide words are, about: nobody knows which font will draw them.
pub(super) fn width_of(text: &str) -> f64 {
    text.chars().count() as f64 * LETTER_WIDTH
}

impl<'a> Canvas<'a> {
    /// An empty page of that height for a clip of `n_frames`.
    pub(super) fn new(
        svg: &'a mut String,
        height: f64,
        n_frames: usize,
        time_marks: Vec<f64>,
    ) -> Result<Canvas<'a>, DrawingAreaErrorKind<std::io::Error>> {
        let size = (fine(PAGE_WIDTH) as u32, fine(height) as u32);
        let root = SVGBackend::with_string(svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        Ok(Canvas { root, frames: -0.5..n_frames.max(1) as f64 - 0.5, time_marks })
    }

    /// A panel from `top` down, with lines where the time is round.
    pub(super) fn panel(
        &self,
        top: f64,
        height: f64,
        y: Range<f64>,
    ) -> Result<Panel<'a>, DrawingAreaErrorKind<std::io::Error>> {
        let size = (fine(PAGE_WIDTH - LEFT - RIGHT), fine(height));
        let area = self.root.clone().shrink((fine(LEFT), fine(top)), size);
        let (across, down) = area.get_pixel_range();
        let axes = Cartesian2d::<RangedCoordf64, RangedCoordf64>::new(
            self.frames.clone(),
            y.clone(),
            (across, down.end..down.start),
        );
        Ok(Panel { area: area.apply_coord_spec(axes), y })
    }

    /// Where a frame is on the page, pixels from its left.
    pub(super) fn x_of(&self, frame: f64) -> f64 {
        LEFT + (frame - self.frames.start) / (self.frames.end - self.frames.start) * (PAGE_WIDTH - LEFT - RIGHT)
    }

    /// Lines of the time, over what was drawn before and below what comes.
    pub(super) fn lines_of_time(&self, panel: &Panel<'a>) -> Drawn {
        for &mark in &self.time_marks {
            panel.area.draw(&PathElement::new([(mark, panel.y.start), (mark, panel.y.end)], stroke(FAINT, 1.0)))?;
        }
        Ok(())
    }

    /// Words with their middle at height `y`.
    pub(super) fn words(&self, text: &str, x: f64, y: f64, anchor: Anchor, color: RGBColor, bold: bool) -> Drawn {
        let font = ("sans-serif", LETTER_SIZE).into_font();
        let font = if bold { font.style(FontStyle::Bold) } else { font };
        let h_pos = match anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let style = font.into_text_style(&self.root).color(&color).pos(Pos::new(h_pos, VPos::Center));
        self.root.draw(&Text::new(printable(text), (fine(x), fine(y)), style))
    }

    /// A panel's name above it, and what its lines and colors are on the right.
    pub(super) fn heading(&self, name: &str, key: &[Key<'_>], top: f64) -> Drawn {
        let y = top - 9.0;
        self.words(name, LEFT, y, Anchor::Start, INK, true)?;
        let mut right = PAGE_WIDTH - RIGHT;
        for entry in key.iter().rev() {
            let (Key::Line(text, ..) | Key::Patch(text, ..) | Key::Dashes(text)) = entry;
            let x = right - width_of(text);
            self.words(text, x, y, Anchor::Start, INK, false)?;
            let across = |from: f64, to: f64| [(fine(x + from), fine(y)), (fine(x + to), fine(y))];
            match *entry {
                Key::Line(_, color, width) => {
                    self.root.draw(&PathElement::new(across(-30.0, -6.0), stroke(color, width)))?;
                }
                Key::Dashes(_) => {
                    for from in [-30.0, -21.0, -12.0] {
                        self.root.draw(&PathElement::new(across(from, from + 6.0), stroke(DASHES, 1.2)))?;
                    }
                }
                Key::Patch(_, color) => {
                    let corners = [(fine(x - 22.0), fine(y - 5.0)), (fine(x - 6.0), fine(y + 5.0))];
                    self.root.draw(&Rectangle::new(corners, color.filled()))?;
                    self.root.draw(&outline(corners, 0.7))?;
                }
            }
            right = x - 46.0;
        }
        Ok(())
    }

    /// Round values along the left side of a panel.
    pub(super) fn values(&self, panel: &Panel<'a>, marks: &[f64]) -> Drawn {
        for (&mark, text) in marks.iter().zip(spelled(marks)) {
            panel.level(mark, FAINT, 1.0)?;
            self.words(&text, LEFT - 8.0, panel.y_of(mark), Anchor::End, INK, false)?;
        }
        Ok(())
    }

    /// A short mark below `y` at a frame, with words below it.
    pub(super) fn tick(&self, frame: f64, y: f64, text: &str) -> Drawn {
        let x = fine(self.x_of(frame));
        self.root.draw(&PathElement::new([(x, fine(y)), (x, fine(y + 4.0))], stroke(FRAME, 1.0)))?;
        self.words(text, self.x_of(frame), y + 12.0, Anchor::Middle, INK, false)
    }

    /// Ends the page.
    pub(super) fn finish(&self) -> Drawn {
        self.root.present()
    }
}

impl Panel<'_> {
    /// Where a value is on the page, pixels from its top.
    pub(super) fn y_of(&self, value: f64) -> f64 {
        f64::from(self.area.map_coordinate(&(0.0, value)).1) / FINENESS
    }

    /// The border.
    pub(super) fn border(&self) -> Drawn {
        let (across, down) = self.area.get_pixel_range();
        let size = (across.end - across.start, down.end - down.start);
        self.area.strip_coord_spec().draw(&outline([(0, 0), size], 1.0))
    }

    /// A line across at a value.
    pub(super) fn level(&self, value: f64, color: RGBColor, width: f64) -> Drawn {
        let frames = self.area.get_x_range();
        self.area.draw(&PathElement::new([(frames.start, value), (frames.end, value)], stroke(color, width)))
    }

    /// A dashed line across at a value.
    pub(super) fn dashes(&self, value: f64) -> Drawn {
        let frames = self.area.get_x_range();
        let dash = (frames.end - frames.start) / 150.0;
        for at in 0..150 {
            let start = frames.start + f64::from(at) * dash;
            let ends = [(start, value), (start + 0.65 * dash, value)];
            self.area.draw(&PathElement::new(ends, stroke(DASHES, 1.2)))?;
        }
        Ok(())
    }

    /// A curve in pieces; a piece of one frame is a dot.
    pub(super) fn curve(&self, pieces: &[Vec<(f64, f64)>], color: RGBColor, width: f64) -> Drawn {
        for piece in pieces {
            match piece.as_slice() {
                &[point] => self.area.draw(&Circle::new(point, fine(1.2 * width), color.filled()))?,
                points => self.area.draw(&PathElement::new(points, stroke(color, width)))?,
            }
        }
        Ok(())
    }

    /// Frames `[first, end)` filled between two values: half a frame before the first to half a frame before the end.
    pub(super) fn bar(&self, frames: &Range<usize>, y: Range<f64>, color: RGBColor) -> Drawn {
        let (first, end) = (frames.start as f64 - 0.5, frames.end as f64 - 0.5);
        self.area.draw(&Rectangle::new([(first, y.start), (first.max(end), y.end)], color.filled()))
    }

    /// Bars; half as strong where only some frames of a column are meant.
    pub(super) fn bars(&self, runs: &[Run], y: Range<f64>, color: RGBColor) -> Drawn {
        for run in runs {
            self.bar(&run.frames, y.clone(), if run.throughout { color } else { paler(color) })?;
        }
        Ok(())
    }
}

/// A box's outline, as a path: the crate gives the width of a rectangle's line away.
fn outline([(left, top), (right, bottom)]: [(i32, i32); 2], width: f64) -> PathElement<(i32, i32)> {
    PathElement::new([(left, top), (right, top), (right, bottom), (left, bottom), (left, top)], stroke(FRAME, width))
}

/// Half way to white.
fn paler(color: RGBColor) -> RGBColor {
    let half = |part: u8| part / 2 + 128;
    RGBColor(half(color.0), half(color.1), half(color.2))
}

/// Black or white, whichever can be read on a color.
pub(super) fn ink_on(color: RGBColor) -> RGBColor {
    let luma = 3 * u32::from(color.0) + 6 * u32::from(color.1) + u32::from(color.2);
    if luma > 1280 { BLACK } else { WHITE }
}

/// The document with the page's own size: what the crate counted in is left to the view box.
pub(super) fn in_page_pixels(svg: &str, height: f64) -> String {
    let of_crate = format!("<svg width=\"{}\" height=\"{}\"", fine(PAGE_WIDTH), fine(height));
    svg.replacen(&of_crate, &format!("<svg width=\"{PAGE_WIDTH:.0}\" height=\"{height:.0}\""), 1)
}
