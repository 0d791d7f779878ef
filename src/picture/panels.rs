//! What each panel of a plot shows: curves over stance, log-odds, bars of contacts and plant states, gait.

use super::canvas::{Anchor, Canvas, Drawn, INK, Key, LEFT, Panel, ink_on, round_marks, width_of};
use super::plot::{CURVE_HEIGHT, FLAT_HEIGHT, Page, Part, ROW_HEIGHT};
use crate::annotate::{Gait, PlantState};
use plotters::prelude::DrawingAreaErrorKind;
use plotters::style::RGBColor;
use std::ops::Range;

/// Colors of a foot.
pub(super) struct FootColors {
    pub(super) ankle: RGBColor,
    toe: RGBColor,
    stance: RGBColor,
    pinned: RGBColor,
    /// Behind curves.
    tint: RGBColor,
}

pub(super) const FEET: [(&str, FootColors); 2] = [
    (
        "Left",
        FootColors {
            ankle: RGBColor(9, 50, 110),
            toe: RGBColor(74, 144, 217),
            stance: RGBColor(33, 90, 160),
            pinned: RGBColor(9, 50, 110),
            tint: RGBColor(225, 236, 248),
        },
    ),
    (
        "Right",
        FootColors {
            ankle: RGBColor(150, 52, 4),
            toe: RGBColor(245, 150, 70),
            stance: RGBColor(235, 125, 50),
            pinned: RGBColor(178, 74, 10),
            tint: RGBColor(253, 236, 222),
        },
    ),
];

const MARK: RGBColor = RGBColor(120, 120, 120);
/// Of two curves in a panel the lighter one is broad and below, the darker one fine and above: both are seen where they
/// are equal.
const FINE: f64 = 1.5;
const BROAD: f64 = 3.0;
/// Log-odds run from -3 to 3.
const LOG_ODDS: Range<f64> = -3.0..3.0;

/// They differ in lightness.
const GAITS: [(Gait, RGBColor, &str); 5] = [
    (Gait::Stand, RGBColor(214, 214, 214), "S"),
    (Gait::Walk, RGBColor(150, 205, 140), "W"),
    (Gait::Run, RGBColor(30, 110, 80), "R"),
    (Gait::Jump, RGBColor(106, 61, 154), "J"),
    (Gait::Unknown, RGBColor(250, 250, 250), "?"),
];

impl Page<'_> {
    pub(super) fn draw_part(&self, canvas: &Canvas<'_>, part: Part, top: f64) -> Drawn {
        match part {
            Part::Heights(foot) => self.draw_heights(canvas, foot, top),
            Part::Speeds(foot) => self.draw_speeds(canvas, foot, top),
            Part::LogOdds => self.draw_log_odds(canvas, top),
            Part::Contacts => self.draw_contacts(canvas, top),
            Part::Force => self.draw_force(canvas, top),
            Part::States => self.draw_states(canvas, top),
            Part::Gait => self.draw_gait(canvas, top),
            Part::Confidence => self.draw_confidence(canvas, top),
        }
    }

    /// Where every column has its least and greatest value, lines are drawn finer.
    fn width(&self, width: f64) -> f64 {
        if self.columns.per_column() > 1 { 0.6 * width } else { width }
    }

    fn curve(&self, column: &[Option<f32>]) -> Vec<Vec<(f64, f64)>> {
        self.columns.curve(|frame| number(column, frame))
    }

    /// Ankle and toe of a foot over its stance, and its mark; `marks`: `[foot]`.
    fn draw_joints(
        &self,
        canvas: &Canvas<'_>,
        foot: usize,
        what: &str,
        columns: &[Vec<Option<f32>>; 4],
        marks: [Option<(f64, &str)>; 2],
        top: f64,
    ) -> Drawn {
        let (side, colors) = &FEET[foot];
        let marks = marks.map(|mark| mark.filter(|(value, _)| value.is_finite() && *value > 0.0));
        let highest = marks.iter().flatten().map(|(value, _)| 1.3 * value).reduce(f64::max);
        let at_least = highest.unwrap_or(0.1);
        // Both feet on one scale, so that they can be compared.
        let y = reach(columns, 0.0..at_least);
        let panel = canvas.panel(top, CURVE_HEIGHT, y.clone())?;
        let stance = self.columns.runs(|frame| is_so(&self.plot.labels.stance[foot], frame));
        panel.bars(&stance, y.clone(), colors.tint)?;
        canvas.lines_of_time(&panel)?;
        canvas.values(&panel, &round_marks(&y, 5))?;
        let mut key = vec![Key::Patch("stance", colors.tint)];
        if let Some((value, name)) = marks[foot] {
            panel.dashes(value)?;
            key.push(Key::Dashes(name));
        }
        let [ankle, toe] = [&columns[2 * foot], &columns[2 * foot + 1]];
        panel.curve(&self.curve(toe), colors.toe, self.width(BROAD))?;
        panel.curve(&self.curve(ankle), colors.ankle, self.width(FINE))?;
        panel.border()?;
        key.push(Key::Line("ankle", colors.ankle, FINE));
        if has_numbers(toe) {
            key.push(Key::Line("toe", colors.toe, BROAD));
        }
        canvas.heading(&format!("{side} foot: {what}"), &key, top)
    }

    fn draw_heights(&self, canvas: &Canvas<'_>, foot: usize, top: f64) -> Drawn {
        let labels = self.plot.labels;
        self.draw_joints(
            canvas,
            foot,
            "height above the resting ground (m)",
            &labels.heights,
            self.plot.height_marks,
            top,
        )
    }

    fn draw_speeds(&self, canvas: &Canvas<'_>, foot: usize, top: f64) -> Drawn {
        self.draw_joints(canvas, foot, "speed (m/s)", &self.plot.labels.speeds, [self.plot.speed_mark; 2], top)
    }

    fn draw_log_odds(&self, canvas: &Canvas<'_>, top: f64) -> Drawn {
        let Some(shown) = &self.plot.labels.diagnostics else { return Ok(()) };
        let panel = self.framed(canvas, top, CURVE_HEIGHT, reach(&shown.log_odds, LOG_ODDS), &[-3.0, 0.0, 3.0])?;
        panel.level(0.0, MARK, 1.0)?;
        let lines = [("left", FEET[0].1.ankle, FINE), ("right", FEET[1].1.toe, BROAD)];
        for foot in [1, 0] {
            let (_, color, width) = lines[foot];
            panel.curve(&self.curve(&shown.log_odds[foot]), color, self.width(width))?;
        }
        let key = lines.map(|(side, color, width)| Key::Line(side, color, width));
        canvas.heading("Log-odds of the foot being planted", &key, top)
    }

    /// Names and marks of the rows of contacts: per foot raw ones, if there are log-odds, stance and pinned.
    pub(super) fn contact_rows(&self) -> Vec<(usize, &'static str)> {
        let raw = self.parts.contains(&Part::LogOdds);
        let words = ["raw", "stance", "pinned"].into_iter().skip(usize::from(!raw));
        [0, 1].into_iter().flat_map(|foot| words.clone().map(move |word| (foot, word))).collect()
    }

    fn draw_contacts(&self, canvas: &Canvas<'_>, top: f64) -> Drawn {
        let labels = self.plot.labels;
        let rows = self.contact_rows();
        let count = rows.len() as f64;
        let panel = self.framed(canvas, top, count * ROW_HEIGHT, 0.0..count, &[])?;
        panel.level(count / 2.0, MARK, 1.0)?;
        for (at, &(foot, word)) in rows.iter().enumerate() {
            let (side, colors) = &FEET[foot];
            let (runs, color) = match word {
                "stance" => (self.columns.runs(|frame| is_so(&labels.stance[foot], frame)), colors.stance),
                "pinned" => (self.columns.runs(|frame| is_so(&labels.pinned[foot], frame)), colors.pinned),
                _ => {
                    let odds = labels.diagnostics.as_ref().map(|shown| shown.log_odds[foot].as_slice());
                    let planted = |frame| odds.and_then(|odds| number(odds, frame)).is_some_and(|odds| odds > 0.0);
                    (self.columns.runs(planted), colors.toe)
                }
            };
            self.row(canvas, &panel, (at, rows.len()), &format!("{} {word}", side.to_lowercase()), |y| {
                panel.bars(&runs, y, color)
            })?;
        }
        let name = match self.parts.contains(&Part::LogOdds) {
            true => "Contacts: raw (log-odds above 0), decoded stance, pinned",
            false => "Contacts: stance, pinned",
        };
        canvas.heading(name, &[], top)
    }

    fn draw_force(&self, canvas: &Canvas<'_>, top: f64) -> Drawn {
        let Some(shown) = &self.plot.labels.diagnostics else { return Ok(()) };
        let y = reach([&shown.force], 0.0..1.2);
        let panel = self.framed(canvas, top, FLAT_HEIGHT, y.clone(), &round_marks(&y, 4))?;
        panel.dashes(1.0)?;
        panel.curve(&self.curve(&shown.force), INK, self.width(FINE))?;
        let key = [Key::Dashes("standing still"), Key::Line("force", INK, FINE)];
        canvas.heading("Vertical force on the feet (body weights)", &key, top)
    }

    fn draw_states(&self, canvas: &Canvas<'_>, top: f64) -> Drawn {
        let states = &self.plot.labels.plant_state;
        let count = PlantState::ALL.len();
        let panel = self.framed(canvas, top, count as f64 * ROW_HEIGHT, 0.0..count as f64, &[])?;
        for (at, state) in PlantState::ALL.into_iter().enumerate() {
            let color = match state {
                PlantState::L => FEET[0].1.stance,
                PlantState::LB | PlantState::LN => FEET[0].1.toe,
                PlantState::R => FEET[1].1.stance,
                PlantState::RB | PlantState::RN => FEET[1].1.toe,
                PlantState::N => MARK,
            };
            let runs = self.columns.runs(|frame| states.get(frame).copied().flatten() == Some(state));
            self.row(canvas, &panel, (at, count), state.name(), |y| panel.bars(&runs, y, color))?;
        }
        canvas.heading(
            "Plant state: the foot in single support now (L, R) or last, then both (B) or none (N)",
            &[],
            top,
        )
    }

    fn draw_gait(&self, canvas: &Canvas<'_>, top: f64) -> Drawn {
        let gaits = &self.plot.labels.gait;
        let height = self.height_of(Part::Gait);
        let panel = canvas.panel(top, height, 0.0..1.0)?;
        let segments = self.columns.commonest(|frame| gaits.get(frame).copied().flatten());
        let mut key = Vec::new();
        for (gait, color, letter) in GAITS {
            let of_gait: Vec<&Range<usize>> =
                segments.iter().filter(|(known, _)| *known == gait).map(|(_, frames)| frames).collect();
            if !of_gait.is_empty() {
                key.push(Key::Patch(gait.name(), color));
            }
            for frames in of_gait {
                panel.bar(frames, 0.0..1.0, color)?;
                let ends = [frames.start, frames.end].map(|frame| canvas.x_of(frame as f64 - 0.5));
                let fits = |text: &&str| width_of(text) + 4.0 < ends[1] - ends[0];
                // What has no room for its name may have some for a letter; the key has the colors.
                if let Some(text) = [gait.name(), letter].iter().copied().find(fits) {
                    let middle = (ends[0] + ends[1]) / 2.0;
                    canvas.words(text, middle, top + height / 2.0, Anchor::Middle, ink_on(color), false)?;
                }
            }
        }
        panel.border()?;
        canvas.heading("Gait", &key, top)
    }

    fn draw_confidence(&self, canvas: &Canvas<'_>, top: f64) -> Drawn {
        let column = &self.plot.labels.gait_confidence;
        let panel = self.framed(canvas, top, FLAT_HEIGHT, -0.06..1.06, &[0.0, 0.5, 1.0])?;
        panel.curve(&self.curve(column), INK, self.width(FINE))?;
        canvas.heading("Confidence in the gait (0 to 1)", &[], top)
    }

    /// A panel with the time's lines, its marks and its border.
    fn framed<'c>(
        &self,
        canvas: &Canvas<'c>,
        top: f64,
        height: f64,
        y: Range<f64>,
        marks: &[f64],
    ) -> Result<Panel<'c>, DrawingAreaErrorKind<std::io::Error>> {
        let panel = canvas.panel(top, height, y)?;
        canvas.lines_of_time(&panel)?;
        canvas.values(&panel, marks)?;
        panel.border()?;
        Ok(panel)
    }

    /// A row of a panel of rows, the first at the top, with its name at the left.
    fn row(
        &self,
        canvas: &Canvas<'_>,
        panel: &Panel<'_>,
        (at, count): (usize, usize),
        name: &str,
        bars: impl Fn(Range<f64>) -> Drawn,
    ) -> Drawn {
        let middle = (count - at) as f64 - 0.5;
        canvas.words(name, LEFT - 8.0, panel.y_of(middle), Anchor::End, INK, false)?;
        bars(middle - 0.36..middle + 0.36)
    }
}

fn number(column: &[Option<f32>], frame: usize) -> Option<f64> {
    column.get(frame).copied().flatten().map(f64::from).filter(|value| value.is_finite())
}

pub(super) fn has_numbers(column: &[Option<f32>]) -> bool {
    (0..column.len()).any(|frame| number(column, frame).is_some())
}

fn is_so(column: &[Option<bool>], frame: usize) -> bool {
    column.get(frame).copied().flatten() == Some(true)
}

/// From the least to the greatest number, and what must be seen in any case.
fn reach<'a>(columns: impl IntoIterator<Item = &'a Vec<Option<f32>>>, at_least: Range<f64>) -> Range<f64> {
    let (mut low, mut high) = (at_least.start, at_least.end);
    for column in columns {
        for value in (0..column.len()).filter_map(|frame| number(column, frame)) {
            low = low.min(value);
            high = high.max(value);
        }
    }
    let margin = 0.06 * (high - low);
    low - margin..high + margin
}
