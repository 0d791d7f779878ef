//! A clip's feet and gait over time: heights, speeds, evidence, contacts, force, plant states, gait (T Figures 3.4-3.6).
//!
//! One page of panels over one axis. The left foot's colors are blue and darker, the right foot's orange and lighter, and
//! words say which is which. A frame is as wide as its share of the clip: marks of `[first, end)` reach from half a frame
//! before the first to half a frame before the end, so that a value stands over the middle of its frame's mark.

use super::canvas::{Anchor, Canvas, Drawn, INK, LEFT, PAGE_WIDTH, RIGHT, in_page_pixels, round_marks, spelled};
use super::columns::Columns;
use super::panels::has_numbers;
use crate::annotate::{FrameLabels, PlantState};

/// What is plotted.
#[derive(Clone, Copy, Debug)]
pub struct Plot<'a> {
    /// The clip's name.
    pub name: &'a str,
    /// What else the page's head says, in words.
    pub facts: &'a str,
    /// Frames a second.
    pub rate_hz: f64,
    /// The columns. Log-odds and force are those of the diagnostics; without any their panels are left out.
    pub labels: &'a FrameLabels,
    /// `[foot]`: height at which the evidence turns against a contact, metres in the body's own size, and its name.
    pub height_marks: [Option<(f64, &'a str)>; 2],
    /// Speed at which it does, m/s, and its name. None: it varies.
    pub speed_mark: Option<(f64, &'a str)>,
}

/// Pixels.
const HEAD: f64 = 52.0;
pub(super) const CURVE_HEIGHT: f64 = 92.0;
pub(super) const FLAT_HEIGHT: f64 = 58.0;
pub(super) const ROW_HEIGHT: f64 = 15.0;
const GAP: f64 = 30.0;
const AXIS_HEIGHT: f64 = 40.0;
const NOTE_HEIGHT: f64 = 20.0;

/// A part of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Heights(usize),
    Speeds(usize),
    LogOdds,
    Contacts,
    Force,
    States,
    Gait,
    Confidence,
}

/// Draws the page; returns a whole SVG document, the same bytes for the same values.
///
/// Values that are no numbers are gaps. Columns may have any length: frames without an entry have no value. In a clip
/// of more than 2,000 frames each column of the page shows the least and the greatest of its frames.
pub fn plot(plot: &Plot<'_>) -> String {
    let page = Page::new(plot);
    let height = HEAD + page.parts.iter().map(|part| page.height_of(*part) + GAP).sum::<f64>() + AXIS_HEIGHT;
    let height = if page.columns.per_column() > 1 { height + NOTE_HEIGHT } else { height }.ceil();
    let mut svg = String::new();
    let drawn = page.draw(&mut svg, height);
    // Only a device can fail, and a String is none.
    debug_assert!(drawn.is_ok(), "{drawn:?}");
    in_page_pixels(&svg, height)
}

/// What is on the page.
pub(super) struct Page<'a> {
    pub(super) plot: &'a Plot<'a>,
    n_frames: usize,
    pub(super) columns: Columns,
    pub(super) parts: Vec<Part>,
}

impl<'a> Page<'a> {
    fn new(plot: &'a Plot<'a>) -> Page<'a> {
        let labels = plot.labels;
        let n_frames = labels.time_s.len();
        let mut parts = Vec::new();
        for foot in [0, 1] {
            parts.extend([Part::Heights(foot), Part::Speeds(foot)]);
        }
        if let Some(shown) = &labels.diagnostics
            && shown.log_odds.iter().any(|odds| has_numbers(odds))
        {
            parts.push(Part::LogOdds);
        }
        parts.push(Part::Contacts);
        if labels.diagnostics.as_ref().is_some_and(|shown| has_numbers(&shown.force)) {
            parts.push(Part::Force);
        }
        parts.extend([Part::States, Part::Gait, Part::Confidence]);
        Page { plot, n_frames, columns: Columns::new(n_frames), parts }
    }

    pub(super) fn height_of(&self, part: Part) -> f64 {
        match part {
            Part::Heights(_) | Part::Speeds(_) | Part::LogOdds => CURVE_HEIGHT,
            Part::Force | Part::Confidence => FLAT_HEIGHT,
            Part::Contacts => self.contact_rows().len() as f64 * ROW_HEIGHT,
            Part::States => PlantState::ALL.len() as f64 * ROW_HEIGHT,
            Part::Gait => 1.3 * ROW_HEIGHT,
        }
    }

    fn draw(&self, svg: &mut String, height: f64) -> Drawn {
        let Plot { name, facts, rate_hz, .. } = *self.plot;
        let rate_hz = if rate_hz.is_finite() && rate_hz > 0.0 { rate_hz } else { 1.0 };
        let last = self.n_frames.max(1) as f64 - 0.5;
        let seconds = round_marks(&(-0.5 / rate_hz..last / rate_hz), 14);
        // Times of frames only: the axis is half a frame longer at either end.
        let of_frames = -1e-9..=(last - 0.5) / rate_hz + 1e-9;
        let seconds: Vec<f64> = seconds.into_iter().filter(|mark| of_frames.contains(mark)).collect();
        let time_marks = seconds.iter().map(|mark| mark * rate_hz).collect();
        let canvas = Canvas::new(svg, height, self.n_frames, time_marks)?;
        canvas.words(&shortened(name), LEFT, 16.0, Anchor::Start, INK, true)?;
        canvas.words(facts, LEFT, 33.0, Anchor::Start, INK, false)?;
        let mut top = HEAD;
        for &part in &self.parts {
            top += GAP - 8.0;
            self.draw_part(&canvas, part, top)?;
            top += self.height_of(part) + 8.0;
        }
        self.draw_axis(&canvas, top - 8.0, rate_hz, &seconds)?;
        canvas.finish()
    }

    /// Seconds, and below them frames.
    fn draw_axis(&self, canvas: &Canvas<'_>, top: f64, rate_hz: f64, seconds: &[f64]) -> Drawn {
        for (mark, text) in seconds.iter().zip(spelled(seconds)) {
            canvas.tick(mark * rate_hz, top, &text)?;
        }
        canvas.words("time (s)", LEFT - 28.0, top + 12.0, Anchor::End, INK, false)?;
        let last = self.n_frames.max(1) as f64 - 0.5;
        let whole = |mark: &f64| (mark - mark.round()).abs() < 1e-6 && *mark > -0.5;
        let frames: Vec<f64> = round_marks(&(-0.5..last), 14).into_iter().filter(whole).collect();
        for &mark in &frames {
            canvas.tick(mark, top + 20.0, &format!("{:.0}", mark.abs()))?;
        }
        canvas.words("frame", LEFT - 28.0, top + 32.0, Anchor::End, INK, false)?;
        let per_column = self.columns.per_column();
        if per_column > 1 {
            let thinned = format!("curves: least and greatest of every {per_column} frames; pale bars: some of them");
            canvas.words(&thinned, PAGE_WIDTH - RIGHT, top + 48.0, Anchor::End, INK, false)?;
        }
        Ok(())
    }
}

/// A name that fits on the page: of a longer one the end, which tells clips of a folder apart.
fn shortened(name: &str) -> String {
    const MOST: usize = 140;
    let n_letters = name.chars().count();
    if n_letters <= MOST {
        return name.to_owned();
    }
    let end: String = name.chars().skip(n_letters - MOST).collect();
    format!("... {end}")
}

#[cfg(test)]
mod tests {
    use super::super::panels::FEET;
    use super::*;
    use crate::annotate::{FrameDiagnostics, Gait};
    use plotters::style::RGBColor;

    /// A walk of alternate feet, ten frames a step, with all columns filled.
    fn labels(n_frames: usize) -> FrameLabels {
        let left = |frame: usize| (frame / 10).is_multiple_of(2);
        let height = |side: bool| (0..n_frames).map(|f| Some(if left(f) == side { 0.0 } else { 0.2 })).collect();
        let planted = |side: bool| (0..n_frames).map(|frame| Some(left(frame) == side)).collect();
        let odds = |side: bool| (0..n_frames).map(|f| Some(if left(f) == side { 3.0 } else { -3.0 })).collect();
        let state = |frame| Some(if left(frame) { PlantState::L } else { PlantState::R });
        FrameLabels {
            time_s: (0..n_frames).map(|frame| frame as f64 / 30.0).collect(),
            heights: [true, true, false, false].map(height),
            speeds: [true, true, false, false].map(height),
            stance: [true, false].map(planted),
            pinned: [true, false].map(planted),
            plant_state: (0..n_frames).map(state).collect(),
            gait: vec![Some(Gait::Walk); n_frames],
            gait_confidence: vec![Some(0.9); n_frames],
            diagnostics: Some(FrameDiagnostics {
                log_odds: [true, false].map(odds),
                force: vec![Some(1.0); n_frames],
                ground: [vec![None; n_frames], vec![None; n_frames]],
            }),
            ..FrameLabels::default()
        }
    }

    fn drawn(labels: &FrameLabels) -> String {
        let (height_marks, speed_mark) = ([Some((0.06, "evidence height")); 2], None);
        plot(&Plot { name: "a/b", facts: "40 frames", rate_hz: 30.0, labels, height_marks, speed_mark })
    }

    /// Points of the curves of a color, a curve a piece.
    fn curves(svg: &str, color: RGBColor) -> Vec<usize> {
        let RGBColor(red, green, blue) = color;
        let of_color = format!("stroke=\"#{red:02X}{green:02X}{blue:02X}\"");
        let lines = svg.lines().filter(|line| line.starts_with("<polyline") && line.contains(&of_color));
        // The samples of the keys have two.
        lines.map(|line| line.matches(',').count()).filter(|&points| points > 2).collect()
    }

    #[test]
    fn every_panel_is_there_and_the_same_labels_give_the_same_bytes() {
        let svg = drawn(&labels(40));
        assert_eq!(svg, drawn(&labels(40)));
        assert!(svg.starts_with("<svg width=\"1200\" height=\""), "{}", &svg[..80]);
        assert!(svg.contains("viewBox=\"0 0 12000 ") && svg.ends_with("</svg>\n"));
        for words in [
            "a/b",
            "40 frames",
            "Left foot: height above the resting ground (m)",
            "Right foot: speed (m/s)",
            "Log-odds of the foot being planted",
            "Contacts: raw (log-odds above 0), decoded stance, pinned",
            "left raw",
            "right pinned",
            "Vertical force on the feet (body weights)",
            "RN",
            "Gait",
            "walk",
            "Confidence in the gait (0 to 1)",
            "time (s)",
            "frame",
        ] {
            assert!(svg.contains(&format!(">\n{words}")), "{words}");
        }
        // The ankle's heights and speeds, and the log-odds.
        assert_eq!(curves(&svg, FEET[0].1.ankle), [40; 3]);
    }

    #[test]
    fn a_detector_that_weighs_nothing_has_neither_log_odds_nor_force_nor_raw_contacts() {
        let mut labels = labels(40);
        let unknown = || vec![None; 40];
        labels.diagnostics = Some(FrameDiagnostics {
            log_odds: [unknown(), unknown()],
            force: unknown(),
            ground: [unknown(), unknown()],
        });
        for diagnostics in [labels.diagnostics.clone(), None] {
            labels.diagnostics = diagnostics;
            let svg = drawn(&labels);
            assert!(!svg.contains("Log-odds") && !svg.contains("force") && !svg.contains("raw"));
            assert!(svg.contains("Contacts: stance, pinned") && svg.contains("left stance"));
        }
    }

    #[test]
    fn a_gap_breaks_a_line() {
        let mut labels = labels(40);
        labels.heights[0][10..15].fill(None);
        assert_eq!(curves(&drawn(&labels), FEET[0].1.ankle), [10, 25, 40, 40]);
    }

    #[test]
    fn bars_reach_from_half_a_frame_before_the_first_to_half_a_frame_before_the_end() {
        let (mut labels, n_frames) = (labels(40), 40);
        labels.gait = (0..n_frames).map(|frame| Some(if frame < 10 { Gait::Stand } else { Gait::Jump })).collect();
        let svg = drawn(&labels);
        let bar = |fill: &str| {
            let line = svg.lines().find(|line| line.starts_with("<rect") && line.contains(fill));
            let number = |name: &str| -> Option<f64> {
                line?.split(&format!(" {name}=\"")).nth(1)?.split('"').next()?.parse().ok()
            };
            (number("x"), number("width"))
        };
        let per_frame = 10.0 * (PAGE_WIDTH - LEFT - RIGHT) / n_frames as f64;
        let near = |found: Option<f64>, wanted: f64| found.is_some_and(|found| (found - wanted).abs() < 2.5);
        // The panel begins half a frame before frame 0.
        let (x, width) = bar("#D6D6D6");
        assert!(near(x, 10.0 * LEFT) && near(width, 10.0 * per_frame), "{x:?} {width:?}");
        let (x, width) = bar("#6A3D9A");
        assert!(near(x, 10.0 * LEFT + 10.0 * per_frame) && near(width, 30.0 * per_frame), "{x:?} {width:?}");
    }

    #[test]
    fn odd_values_and_lengths_make_a_picture_without_odd_numbers() {
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, f32::MIN_POSITIVE, -0.0];
        for n_frames in [0, 1, 2, 7, 2500] {
            let mut labels = labels(n_frames);
            let columns = labels.heights.iter_mut().chain(&mut labels.speeds).chain([&mut labels.gait_confidence]);
            for column in columns {
                column.iter_mut().zip(odd.iter().cycle()).for_each(|(value, odd)| *value = Some(*odd));
            }
            labels.stance[0].truncate(n_frames / 2);
            labels.gait.clear();
            for (rate_hz, mark) in
                [(30.0, 0.06), (0.0, f64::NAN), (f64::NAN, f64::INFINITY), (1e-300, 0.0), (1e9, -1.0)]
            {
                let mark = Some((mark, "mark"));
                let name = "<a>\u{1}&\"b\"";
                let facts = "x".repeat(500);
                let (labels, height_marks, speed_mark) = (&labels, [mark, None], mark);
                let odd = Plot { name, facts: &facts, rate_hz, labels, height_marks, speed_mark };
                assert!(Page::new(&odd).draw(&mut String::new(), 900.0).is_ok());
                let svg = plot(&odd);
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{n_frames} {rate_hz}");
                assert!(svg.contains("&lt;a&gt; &amp;") && svg.ends_with("</svg>\n"));
            }
        }
    }

    #[test]
    fn each_foot_has_a_mark_of_its_own() {
        let labels = labels(40);
        let height_marks = [Some((0.06, "mark of the left")), Some((0.12, "mark of the right"))];
        let svg =
            plot(&Plot { name: "a/b", facts: "", rate_hz: 30.0, labels: &labels, height_marks, speed_mark: None });
        assert!(svg.contains("mark of the left") && svg.contains("mark of the right"));
    }

    #[test]
    fn half_an_hour_is_a_small_file() {
        let mut labels = labels(216_000);
        // The worst case: every column is another than the one before.
        labels.heights[0].iter_mut().enumerate().for_each(|(frame, value)| *value = Some((frame % 7) as f32));
        labels.gait = (0..216_000).map(|frame| Some([Gait::Walk, Gait::Run][frame / 216 % 2])).collect();
        let svg = drawn(&labels);
        assert!(svg.len() < 2_000_000, "{} bytes", svg.len());
        assert!(svg.contains("curves: least and greatest of every 216 frames"));
    }
}
