//! Strips of stick figures: what a motion looks like, frame beside frame, one strip above the other.
//!
//! Left limbs are blue and dashed, right limbs red and solid, so that they stay apart in print; a disc (left) or a
//! square (right) on the ground marks a foot in contact.

use crate::motion::{Poses, Role, RoleMap, Skeleton};
use glam::DVec3;
use std::fmt::Write;

/// Where the viewer stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// On the right of the body: forward is to the right of the page.
    #[default]
    Side,
    /// Before the body: its left is to the right of the page.
    Front,
}

/// Where on the page the figures stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// Side by side at equal distances, each turned as the view asks for its own frame.
    #[default]
    Row,
    /// Where they are in the world, seen square to the way from the first frame's hips to the last one's (to the first
    /// frame's heading, if they hardly move).
    Path,
}

/// One strip.
#[derive(Clone, Debug)]
pub struct Strip<'a> {
    /// Written above it.
    pub title: &'a str,
    /// Positions of joints and ends.
    pub poses: &'a Poses,
    /// The tree of `poses`.
    pub skeleton: &'a Skeleton,
    /// Which joints are left, right, hips and head; without hips and thighs the view is along the world's axes.
    pub roles: &'a RoleMap,
    /// Frames a second, for the times below the figures.
    pub rate_hz: f64,
    /// Which frames, in order; those that don't exist are left out.
    pub frames: &'a [usize],
    /// `[frame]` of the whole clip: left and right foot on the ground.
    pub contacts: Option<[&'a [bool]; 2]>,
    /// Height of the ground line, metres.
    pub ground_m: f64,
    /// Where the viewer stands.
    pub view: View,
    /// Where the figures stand.
    pub layout: Layout,
}

/// `n` frames evenly spread over `[first, end)`, the first and the last frame included; fewer if there are fewer.
pub fn spread(first: usize, end: usize, n: usize) -> Vec<usize> {
    let count = end.saturating_sub(first);
    let n = n.min(count);
    (0..n).map(|k| if n == 1 { first } else { first + (k * (count - 1) + (n - 1) / 2) / (n - 1) }).collect()
}

/// Draws strips one below the other; returns a whole SVG document.
pub fn strips(strips: &[Strip<'_>]) -> String {
    let drawn: Vec<Drawn> = strips.iter().map(draw).collect();
    let width = drawn.iter().map(|strip| strip.width).fold(200.0, f64::max);
    let height: f64 = drawn.iter().map(|strip| strip.height).sum();
    let mut svg = String::new();
    // Writing to a String can't fail, here and below.
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
         viewBox=\"0 0 {width:.0} {height:.0}\">"
    );
    svg.push_str(
        "<style>\
         path{fill:none;stroke-width:2.2;stroke-linecap:round;stroke-linejoin:round}\
         .l{stroke:#2166ac;stroke-dasharray:5 2.6}.r{stroke:#c4391d}.m{stroke:#444}\
         .cl{fill:#2166ac}.cr{fill:#c4391d}.g{stroke:#999;stroke-width:1}\
         .h{fill:#fff;stroke:#444;stroke-width:2}\
         text{font-family:sans-serif;font-size:11px;fill:#333}.t{font-size:13px;font-weight:bold}\
         </style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
    );
    let mut top = 0.0;
    for strip in &drawn {
        let _ = writeln!(svg, "<g transform=\"translate(0 {top:.1})\">\n{}</g>", strip.body);
        top += strip.height;
    }
    svg.push_str("</svg>\n");
    svg
}

/// Pixels a metre.
const SCALE: f64 = 90.0;
/// Left, right and between figures, pixels.
const MARGIN: f64 = 24.0;
const TITLE_HEIGHT: f64 = 24.0;
const TIMES_HEIGHT: f64 = 26.0;
const LABEL_WIDTH: f64 = 38.0;
/// Metres.
const HEAD_RADIUS_M: f64 = 0.095;

struct Drawn {
    body: String,
    width: f64,
    height: f64,
}

/// Which limb a joint belongs to: class names of the style sheet.
fn limb_classes(skeleton: &Skeleton, roles: &RoleMap) -> Vec<&'static str> {
    let mut classes = vec!["m"; skeleton.joints.len()];
    let starts = [
        ("l", [Role::ThighLeft, Role::ClavicleLeft, Role::ShoulderLeft]),
        ("r", [Role::ThighRight, Role::ClavicleRight, Role::ShoulderRight]),
    ];
    for (index, joint) in skeleton.joints.iter().enumerate() {
        let own = starts.iter().find(|(_, starts)| starts.iter().any(|&role| roles.get(role) == Some(index)));
        classes[index] = match (own, joint.parent) {
            (Some((class, _)), _) => class,
            (None, Some(parent)) => classes[parent],
            (None, None) => "m",
        };
    }
    classes
}

/// The direction in the world that points to the right of the page.
fn page_right(poses: &Poses, roles: &RoleMap, frame: usize, view: View) -> DVec3 {
    let (Some(left), Some(right)) = (roles.get(Role::ThighLeft), roles.get(Role::ThighRight)) else {
        return if view == View::Side { DVec3::Z } else { DVec3::X };
    };
    let across = poses.at(frame, left) - poses.at(frame, right);
    let left = DVec3::new(across.x, 0.0, across.z).normalize_or(DVec3::X);
    if view == View::Side { left.cross(DVec3::Y) } else { left }
}

fn draw(strip: &Strip<'_>) -> Drawn {
    let Strip { poses, skeleton, roles, .. } = *strip;
    let frames: Vec<usize> = strip.frames.iter().copied().filter(|&frame| frame < poses.n_frames).collect();
    let hips = roles.get(Role::Hips).unwrap_or(0);
    // A joint that stays at the origin while the hips travel (Bandai-Namco's `joint_Root`) is no part of the body: points
    // that are no numbers are not drawn.
    let parent_of = |&joint: &usize| skeleton.joints.get(joint).and_then(|joint| joint.parent);
    let above_hips: Vec<usize> = std::iter::successors(parent_of(&hips), parent_of).collect();
    let travel = match (frames.first(), frames.last()) {
        (Some(&first), Some(&last)) => {
            let way = poses.at(last, hips) - poses.at(first, hips);
            let way = DVec3::new(way.x, 0.0, way.z);
            // A view across a way that was hardly made would be a view from anywhere.
            if way.length() > 0.5 { way.normalize() } else { page_right(poses, roles, first, View::Side) }
        }
        _ => DVec3::Z,
    };
    let travel = match strip.view {
        View::Side => travel,
        View::Front => DVec3::Y.cross(travel),
    };
    let figures: Vec<Figure> = frames
        .iter()
        .map(|&frame| {
            let (right, origin) = match strip.layout {
                Layout::Row => (page_right(poses, roles, frame, strip.view), poses.at(frame, hips)),
                Layout::Path => (travel, DVec3::ZERO),
            };
            let points = (0..poses.n_points)
                .map(|point| {
                    if above_hips.contains(&point) {
                        return [f64::NAN; 2];
                    }
                    let at = poses.at(frame, point) - DVec3::new(origin.x, 0.0, origin.z);
                    [at.dot(right), at.y - strip.ground_m]
                })
                .collect();
            Figure { frame, points, shift_m: 0.0 }
        })
        .collect();
    let (figures, width_m, top_m, bottom_m) = lay_out(figures, strip.layout);
    let ground_y = TITLE_HEIGHT + top_m * SCALE;
    let height = ground_y + bottom_m * SCALE + TIMES_HEIGHT;
    let width = width_m * SCALE + 2.0 * MARGIN;
    let mut body = String::new();
    let _ = writeln!(body, "<text class=\"t\" x=\"{MARGIN:.0}\" y=\"16\">{}</text>", escaped(strip.title));
    let _ = writeln!(body, "<path class=\"g\" d=\"M{:.0} {ground_y:.1}H{:.0}\"/>", 0.5 * MARGIN, width - 0.5 * MARGIN);
    let classes = limb_classes(skeleton, roles);
    for figure in &figures {
        figure.draw(&mut body, strip, &classes, ground_y);
    }
    let mut free_x = f64::NEG_INFINITY;
    for figure in &figures {
        let x = figure.page(hips, ground_y)[0];
        // Where figures stand close together, only some have their time written below.
        if x.is_finite() && x >= free_x {
            let (time_s, y) = (figure.frame as f64 / strip.rate_hz, height - 6.0);
            let _ = writeln!(body, "<text text-anchor=\"middle\" x=\"{x:.1}\" y=\"{y:.1}\">{time_s:.2} s</text>");
            free_x = x + LABEL_WIDTH;
        }
    }
    Drawn { body, width, height }
}

/// Points of one frame on the page's axes, metres.
struct Figure {
    frame: usize,
    points: Vec<[f64; 2]>,
    shift_m: f64,
}

/// Gives the figures their places: shifts, and width, height and depth of the strip in metres.
fn lay_out(mut figures: Vec<Figure>, layout: Layout) -> (Vec<Figure>, f64, f64, f64) {
    let finite = |figures: &[Figure], axis: usize| {
        let values = figures.iter().flat_map(|figure| figure.points.iter().map(move |point| point[axis]));
        let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if low <= high { (low, high) } else { (0.0, 0.0) }
    };
    let (low_m, high_m) = finite(&figures, 0);
    let (deep_m, top_m) = finite(&figures, 1);
    let pitch_m = match layout {
        Layout::Row => (0.78 * (high_m - low_m) + 0.1).max(0.5),
        Layout::Path => 0.0,
    };
    for (index, figure) in figures.iter_mut().enumerate() {
        figure.shift_m = pitch_m * index as f64 - low_m;
    }
    let width_m = high_m - low_m + pitch_m * figures.len().saturating_sub(1) as f64;
    (figures, width_m, top_m.max(0.5) + HEAD_RADIUS_M, (-deep_m).max(0.0))
}

impl Figure {
    /// Where a point is on the page, pixels.
    fn page(&self, point: usize, ground_y: f64) -> [f64; 2] {
        let [x, y] = self.points[point];
        [MARGIN + (x + self.shift_m) * SCALE, ground_y - y * SCALE]
    }

    fn draw(&self, body: &mut String, strip: &Strip<'_>, classes: &[&str], ground_y: f64) {
        let page = |point: usize| self.page(point, ground_y);
        let skeleton = strip.skeleton;
        let ends = skeleton.ends();
        let head = strip.roles.get(Role::Head);
        // Far limbs first: the viewer stands on the right of the body, or before it.
        for class in ["l", "m", "r"] {
            let mut path = String::new();
            let mut last = usize::MAX;
            let mut line = |from: usize, to: usize| {
                let ([x0, y0], [x1, y1]) = (page(from), page(to));
                if [x0, y0, x1, y1].iter().all(|value| value.is_finite()) {
                    if last != from {
                        let _ = write!(path, "M{x0:.1} {y0:.1}");
                    }
                    let _ = write!(path, "L{x1:.1} {y1:.1}");
                    last = to;
                }
            };
            for (index, joint) in skeleton.joints.iter().enumerate() {
                if let Some(parent) = joint.parent.filter(|_| classes[index] == class) {
                    line(parent, index);
                }
                if let Some(end) = ends.iter().position(|&owner| owner == index)
                    && classes[index] == class
                    && head != Some(index)
                {
                    line(index, skeleton.joints.len() + end);
                }
            }
            if !path.is_empty() {
                let _ = writeln!(body, "<path class=\"{class}\" d=\"{path}\"/>");
            }
        }
        if let Some(head) = head.filter(|&head| head < self.points.len()) {
            let end = ends.iter().position(|&owner| owner == head).map(|end| skeleton.joints.len() + end);
            let ([x, y], radius) = (page(end.unwrap_or(head)), HEAD_RADIUS_M * SCALE);
            if x.is_finite() && y.is_finite() {
                let _ = writeln!(body, "<circle class=\"h\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"/>");
            }
        }
        self.draw_contacts(body, strip, &page, ground_y);
    }

    fn draw_contacts(&self, body: &mut String, strip: &Strip<'_>, page: &dyn Fn(usize) -> [f64; 2], ground_y: f64) {
        let feet = [[Role::ToeLeft, Role::AnkleLeft], [Role::ToeRight, Role::AnkleRight]];
        for (side, contact) in strip.contacts.into_iter().flatten().enumerate() {
            let planted = contact.get(self.frame).copied().unwrap_or(false);
            let point = feet[side].iter().find_map(|&role| strip.roles.get(role));
            let Some(x) = point.filter(|_| planted).map(|point| page(point)[0]).filter(|x| x.is_finite()) else {
                continue;
            };
            let y = ground_y + 5.0;
            let _ = if side == 0 {
                writeln!(body, "<circle class=\"cl\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.6\"/>")
            } else {
                let (x, y) = (x - 3.2, y - 3.2);
                writeln!(body, "<rect class=\"cr\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"6.4\" height=\"6.4\"/>")
            };
        }
    }
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            // XML has no way to write most control characters.
            letter if letter.is_control() => out.push(' '),
            letter => out.push(letter),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::annotate::Foot;
    use crate::motion::kinematics::poses;
    use crate::motion::{Clip, Format};
    use crate::procedural::{SyntheticClip, corpus, make};

    fn roles() -> RoleMap {
        let mut roles = RoleMap::default();
        for (role, point) in [
            (Role::Hips, 0),
            (Role::ThighLeft, 2),
            (Role::AnkleLeft, 4),
            (Role::ToeLeft, 5),
            (Role::ThighRight, 7),
            (Role::AnkleRight, 9),
            (Role::ToeRight, 10),
            (Role::Head, 16),
            (Role::ClavicleLeft, 17),
            (Role::ClavicleRight, 24),
        ] {
            roles.set(role, point);
        }
        roles
    }

    fn walk() -> SyntheticClip {
        make(&corpus(1, 1)[0], Format::Amc).unwrap_or_else(|error| panic!("{error}"))
    }

    fn drawn(made: &SyntheticClip, title: &str, layout: Layout, view: View) -> String {
        let poses = poses(&made.clip);
        let frames = spread(0, made.clip.n_frames, 8);
        let contacts = [made.truth.left_contact.as_slice(), made.truth.right_contact.as_slice()];
        let Clip { skeleton, rate_hz, .. } = &made.clip;
        strips(&[Strip {
            title,
            poses: &poses,
            skeleton,
            roles: &roles(),
            rate_hz: *rate_hz,
            frames: &frames,
            contacts: Some(contacts),
            ground_m: 0.0,
            view,
            layout,
        }])
    }

    #[test]
    fn eight_figures_have_both_sides_a_head_and_their_contacts() {
        let made = walk();
        let svg = drawn(&made, "a < b & c", Layout::Row, View::Side);
        let count = |what: &str| svg.matches(what).count();
        assert_eq!([count("class=\"l\""), count("class=\"r\""), count("class=\"h\"")], [8, 8, 8]);
        let frames = spread(0, made.clip.n_frames, 8);
        let planted = |foot: Foot| {
            let contact = [&made.truth.left_contact, &made.truth.right_contact][foot as usize];
            frames.iter().filter(|&&frame| contact[frame]).count()
        };
        assert_eq!(count("class=\"cl\""), planted(Foot::Left));
        assert_eq!(count("class=\"cr\""), planted(Foot::Right));
        assert!(svg.contains("a &lt; b &amp; c") && svg.ends_with("</svg>\n"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn a_walk_laid_on_its_path_is_as_wide_as_the_walk_is_long() {
        let made = walk();
        let width = |layout| -> f64 {
            let svg = drawn(&made, "walk", layout, View::Side);
            svg.split("width=\"").nth(1).and_then(|rest| rest.split('"').next()?.parse().ok()).unwrap_or(0.0)
        };
        let poses = poses(&made.clip);
        let way = poses.at(made.clip.n_frames - 1, 0) - poses.at(0, 0);
        assert!((width(Layout::Path) / SCALE - way.length()).abs() < 2.0, "{} {}", width(Layout::Path), way.length());
        assert_ne!(width(Layout::Path), width(Layout::Row));
    }

    #[test]
    fn a_joint_above_the_hips_is_no_part_of_the_body() {
        let made = walk();
        let poses = poses(&made.clip);
        let mut roles = roles();
        roles.set(Role::Hips, 11);
        let width = |poses: &Poses| -> f64 {
            let svg = strips(&[Strip {
                title: "",
                poses,
                skeleton: &made.clip.skeleton,
                roles: &roles,
                rate_hz: 30.0,
                frames: &[0, 10],
                contacts: None,
                ground_m: 0.0,
                view: View::Side,
                layout: Layout::Row,
            }]);
            svg.split("width=\"").nth(1).and_then(|rest| rest.split('"').next()?.parse().ok()).unwrap_or(f64::MAX)
        };
        let mut left_behind = poses.clone();
        (0..poses.n_frames).for_each(|frame| left_behind.world[frame * poses.n_points] = DVec3::splat(-90.0));
        assert_eq!(made.clip.skeleton.joints[11].parent, Some(0));
        assert_eq!(width(&left_behind), width(&poses));
    }

    #[test]
    fn frames_that_are_not_there_and_positions_that_are_not_numbers_are_left_out() {
        let made = walk();
        let mut poses = poses(&made.clip);
        poses.world[3] = DVec3::NAN;
        let strip = Strip {
            title: "",
            poses: &poses,
            skeleton: &made.clip.skeleton,
            roles: &roles(),
            rate_hz: 30.0,
            frames: &[0, 1_000_000],
            contacts: None,
            ground_m: 0.0,
            view: View::Front,
            layout: Layout::Row,
        };
        let svg = strips(&[strip]);
        assert!(!svg.contains("NaN"));
        assert_eq!(svg.matches("class=\"h\"").count(), 1);
        assert!(strips(&[]).ends_with("</svg>\n"));
    }

    #[test]
    fn frames_spread_from_end_to_end() {
        assert_eq!(spread(0, 101, 3), [0, 50, 100]);
        assert_eq!(spread(5, 8, 10), [5, 6, 7]);
        assert_eq!(spread(4, 4, 3), [0_usize; 0]);
        assert_eq!(spread(4, 9, 1), [4]);
    }
}
