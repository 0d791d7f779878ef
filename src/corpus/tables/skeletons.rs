//! The `skeletons` table: one row a body, with all that rebuilding it needs.

use super::{RowTable, texts};
use crate::corpus::columns::Columns;
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;
use crate::motion::skeleton::{AngleUnit, PositionRule};
use crate::motion::{Axis, Bone, Channel, ChannelKind, Format, Joint, RestAxis, Role, RoleMap, Skeleton};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A row of `skeletons`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkeletonRow {
    /// Its id ([`Skeleton::skeleton_id`]).
    pub skeleton_id: String,
    /// `[source, name]` of the clip that `body` and `header` were taken from; of several shards' rows of one
    /// skeleton the lowest counts. Not a column.
    pub first_clip: [String; 2],
    /// Joints, channels, offsets as that clip had them.
    pub body: Skeleton,
    /// Which point has which role.
    pub roles: RoleMap,
    /// The HIERARCHY or ASF text of that clip, verbatim.
    pub header: String,
}

const FILE: &[(&str, &str)] = &[("unit", "file"), ("space", "file")];
const DEGREES: &[(&str, &str)] = &[("unit", "deg"), ("space", "file")];

impl RowTable for SkeletonRow {
    const NAME: &'static str = "skeletons";

    fn columns(rows: &[SkeletonRow]) -> Columns {
        fn all<'a, T: 'a>(
            rows: &'a [SkeletonRow],
            each: impl Fn(&Joint) -> Vec<T> + Copy + 'a,
        ) -> impl Iterator<Item = Vec<T>> + 'a {
            rows.iter().map(move |row| row.body.joints.iter().flat_map(each).collect())
        }
        let names: Vec<[Vec<String>; 2]> = rows
            .iter()
            .map(|row| {
                let joints = row.body.joints.iter().map(|joint| joint.name.clone());
                [joints.collect(), row.body.channel_names()]
            })
            .collect();
        let layouts: Vec<String> = rows.iter().map(|row| row.body.layout_id()).collect();
        let roles = rows.iter().map(|row| {
            let role = |joint| row.roles.of_point(joint).map(|role| role.name().to_owned());
            (0..row.body.joints.len()).map(role).collect()
        });
        let role_points =
            rows.iter().map(|row| Role::ALL.map(|role| row.roles.get(role).map(|point| point as i32)).to_vec());
        Columns::new()
            .str("skeleton", rows.iter().map(|row| row.skeleton_id.as_str()))
            .str("layout", layouts.iter().map(String::as_str))
            .str("format", rows.iter().map(|row| row.body.format.name()))
            .str_list("joints", names.iter().map(|[joints, _]| joints.as_slice()))
            .i32_list("parents", false, all(rows, |joint| vec![Some(joint.parent.map_or(-1, |parent| parent as i32))]))
            .str_opt_list("roles", roles)
            .str_list("channels", names.iter().map(|[_, channels]| channels.as_slice()))
            .f64_list("offsets", FILE, false, all(rows, |joint| joint.offset.to_array().map(Some).to_vec()))
            .f64_list("end_offsets", FILE, true, all(rows, |joint| three(joint.end.map(|end| end.to_array()))))
            .f64_list("axis", DEGREES, true, all(rows, |joint| three(joint.axis.map(|axis| axis.degrees))))
            .str_opt_list("axis_order", all(rows, |joint| vec![joint.axis.map(|axis| letters(axis.order))]))
            .str("angle_unit", rows.iter().map(|row| angle_name(row.body.angle_unit)))
            .str("header", rows.iter().map(|row| row.header.as_str()))
            .str("position_rule", rows.iter().map(|row| rule_name(row.body.position_rule)))
            .f64_list("bones", FILE, true, all(rows, bone))
            .i32_list("role_points", true, role_points)
    }

    fn from_rows(rows: &Rows<'_>) -> Result<Vec<SkeletonRow>, CorpusError> {
        let (skeleton, header) = (texts(rows, "skeleton")?, texts(rows, "header")?);
        let (format, angle_unit, rule) = (rows.str("format")?, rows.str("angle_unit")?, rows.str("position_rule")?);
        let (joints, channels) = (rows.str_lists("joints")?, rows.str_lists("channels")?);
        let (parents, role_points) = (rows.i32_opt_lists("parents")?, rows.i32_opt_lists("role_points")?);
        let (offsets, ends) = (rows.f64_opt_lists("offsets")?, rows.f64_opt_lists("end_offsets")?);
        let (axis, axis_order) = (rows.f64_opt_lists("axis")?, rows.str_opt_lists("axis_order")?);
        let bones = rows.f64_opt_lists("bones")?;
        let layouts = texts(rows, "layout")?;
        (0..rows.len())
            .map(|at| {
                let bad = |what: &str| rows.damaged(format!("skeleton {}: {what}", skeleton[at]));
                let n = joints[at].len();
                let lengths = [parents[at].len(), axis_order[at].len(), offsets[at].len() / 3, ends[at].len() / 3];
                if lengths.into_iter().chain([axis[at].len() / 3, bones[at].len() / 4]).any(|length| length != n) {
                    return Err(bad("lists of unequal lengths"));
                }
                let joint = |joint: usize| {
                    let parent = parents[at][joint].unwrap_or(-1);
                    let order = axis_order[at][joint].as_deref();
                    let degrees = triple(&axis[at], joint);
                    Some(Joint {
                        name: joints[at][joint].clone(),
                        parent: if parent < 0 { None } else { Some(parent as usize).filter(|&parent| parent < joint) },
                        offset: DVec3::from(triple(&offsets[at], joint)?),
                        end: triple(&ends[at], joint).map(DVec3::from),
                        channels: Vec::new(),
                        axis: match order {
                            None => None,
                            Some(order) => Some(RestAxis { degrees: degrees?, order: axes(order)? }),
                        },
                        bone: match &bones[at][4 * joint..4 * joint + 4] {
                            [Some(x), Some(y), Some(z), Some(length)] => {
                                Some(Bone { direction: DVec3::new(*x, *y, *z), length: *length })
                            }
                            _ => None,
                        },
                    })
                };
                let whole: Option<Vec<Joint>> = (0..n).map(joint).collect();
                let mut body = Skeleton {
                    format: match format.value(at) {
                        "bvh" => Format::Bvh,
                        "amc" => Format::Amc,
                        _ => return Err(bad("unknown format")),
                    },
                    joints: whole.ok_or_else(|| bad("a joint without an offset, or with half an axis"))?,
                    angle_unit: match angle_unit.value(at) {
                        "degrees" => AngleUnit::Degrees,
                        "radians" => AngleUnit::Radians,
                        _ => return Err(bad("unknown angle unit")),
                    },
                    position_rule: match rule.value(at) {
                        "replace" => PositionRule::Replace,
                        "add" => PositionRule::Add,
                        _ => return Err(bad("unknown position rule")),
                    },
                };
                give_channels(&mut body, &channels[at]).ok_or_else(|| bad("channels that fit no joint"))?;
                if body.layout_id() != layouts[at] {
                    return Err(bad("it is not of its layout"));
                }
                let n_points = n + body.ends().len();
                let mut roles = RoleMap::default();
                for (role, point) in Role::ALL.into_iter().zip(&role_points[at]) {
                    match point.map(|point| usize::try_from(point).ok().filter(|&point| point < n_points)) {
                        Some(Some(point)) => roles.set(role, point),
                        Some(None) => return Err(bad("a role without a point")),
                        None => {}
                    }
                }
                let first_clip = [String::new(), String::new()];
                Ok(SkeletonRow {
                    skeleton_id: skeleton[at].clone(),
                    first_clip,
                    body,
                    roles,
                    header: header[at].clone(),
                })
            })
            .collect()
    }
}

/// Gives the columns of the `channels` table back to their joints, which they follow in order.
fn give_channels(body: &mut Skeleton, names: &[String]) -> Option<()> {
    let joints = body.unique_joint_names();
    let mut names = names.iter().map(String::as_str).peekable();
    for (joint, name) in body.joints.iter_mut().zip(&joints) {
        let kind = |column: &str| channel(column.strip_prefix(name.as_str())?.strip_prefix('.')?);
        while let Some(channel) = names.peek().and_then(|column| kind(column)) {
            joint.channels.push(channel);
            names.next();
        }
    }
    names.next().is_none().then_some(())
}

/// The channel of a name such as `Xposition` or `Zrotation#2`.
fn channel(name: &str) -> Option<Channel> {
    let (name, repeat) = name.split_once('#').map_or((name, None), |(name, repeat)| (name, Some(repeat)));
    if repeat.is_some_and(|repeat| repeat.is_empty() || !repeat.bytes().all(|byte| byte.is_ascii_digit())) {
        return None;
    }
    let kind = |kind: ChannelKind| {
        let axis = Axis::from_letter(name.chars().next()?)?;
        Some(Channel { kind, axis }).filter(|channel| channel.name() == name)
    };
    match name {
        "Length" => Some(Channel { kind: ChannelKind::Length, axis: Axis::X }),
        _ => kind(ChannelKind::Position).or_else(|| kind(ChannelKind::Rotation)),
    }
}

fn three(values: Option<[f64; 3]>) -> Vec<Option<f64>> {
    values.map_or(vec![None; 3], |values| values.map(Some).to_vec())
}

fn triple(values: &[Option<f64>], joint: usize) -> Option<[f64; 3]> {
    match values.get(3 * joint..3 * joint + 3)? {
        [Some(x), Some(y), Some(z)] => Some([*x, *y, *z]),
        _ => None,
    }
}

fn bone(joint: &Joint) -> Vec<Option<f64>> {
    joint.bone.map_or(vec![None; 4], |bone| {
        [bone.direction.x, bone.direction.y, bone.direction.z, bone.length].map(Some).to_vec()
    })
}

fn letters(order: [Axis; 3]) -> String {
    order.map(Axis::letter).iter().collect()
}

fn axes(order: &str) -> Option<[Axis; 3]> {
    let axes: Option<Vec<Axis>> = order.chars().map(Axis::from_letter).collect();
    axes?.try_into().ok()
}

fn angle_name(unit: AngleUnit) -> &'static str {
    match unit {
        AngleUnit::Degrees => "degrees",
        AngleUnit::Radians => "radians",
    }
}

fn rule_name(rule: PositionRule) -> &'static str {
    match rule {
        PositionRule::Replace => "replace",
        PositionRule::Add => "add",
    }
}
