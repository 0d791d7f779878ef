//! Which joint is which: by names, failing that by the tree's shape; four-legged bodies keep no feet.

use super::chains::Tree;
use super::folding::{FoldError, fold, left_by_name, rest_points, sides_notice};
use super::notice::{Notice, Severity};
use super::role_names::NameTables;
use super::role_topology::{fill_gaps, roles_of_fold};
use super::roles::{Role, RoleMap};
use super::skeleton::Skeleton;
use glam::DVec3;

/// Where a skeleton's roles come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RoleSource {
    /// The name table that knew most joints.
    ByNames(String),
    /// The shape of the tree (GRAFTS 1).
    ByTopology,
    /// Neither: no roles, only raw chains.
    None,
}

/// Gives a skeleton's joints their roles (DESIGN 3), and says how and with what doubts.
///
/// `first_pose` are the joints and leaf ends of the first frame, Y up, in any unit; without it the rest pose serves.
/// A skeleton without roles for the feet is a body whose contacts can't be judged; that is never an error.
pub fn assign_roles(
    skeleton: &Skeleton,
    tables: &NameTables,
    first_pose: Option<&[DVec3]>,
) -> (RoleMap, RoleSource, Vec<Notice>) {
    let rest = rest_points(skeleton);
    let points = first_pose.filter(|points| points.len() == rest.len()).unwrap_or(&rest);
    let mut notices = Vec::new();
    let (mut roles, source) = match tables.best(skeleton) {
        Some((table, mut roles)) => {
            fill_gaps(skeleton, &mut roles);
            notices.extend(sides_disagree(skeleton, &roles, points));
            (roles, RoleSource::ByNames(table.to_owned()))
        }
        None => match fold(skeleton, points) {
            Ok(folded) => {
                notices.push(guessed(skeleton, &folded.chains.leg_left));
                notices.extend(folded.notices.iter().cloned());
                (roles_of_fold(skeleton, &folded, points), RoleSource::ByTopology)
            }
            Err(error) => {
                notices.push(no_body(error));
                return (RoleMap::default(), RoleSource::None, notices);
            }
        },
    };
    if stands_on_four(skeleton, &roles, &rest, first_pose.map(|_| points)) {
        use Role::*;
        for role in [AnkleLeft, ToeLeft, AnkleRight, ToeRight, ClavicleLeft, ShoulderLeft, ElbowLeft, WristLeft] {
            roles.clear(role);
        }
        for role in [ClavicleRight, ShoulderRight, ElbowRight, WristRight] {
            roles.clear(role);
        }
        notices.push(quadruped());
    }
    (roles, source, notices)
}

/// Whether the arms are forelegs. The rest pose decides where it is a pose (legs below the hips); where it is none
/// (bones along X), a body on all fours in the first pose counts only if its arms are as long as its legs: people
/// crawl, but their arms are two thirds of that.
fn stands_on_four(skeleton: &Skeleton, roles: &RoleMap, rest: &[DVec3], first_pose: Option<&[DVec3]>) -> bool {
    use Role::*;
    let Some(on_four_at_rest) = on_four(skeleton, roles, rest) else { return false };
    let at = |points: &[DVec3], role| roles.get(role).and_then(|point| points.get(point).copied());
    let below_hips = |ankle, thigh, knee| {
        let (ankle, thigh, knee) = (at(rest, ankle)?, at(rest, thigh)?, at(rest, knee)?);
        Some(thigh.y - ankle.y > 0.6 * (thigh.distance(knee) + knee.distance(ankle)))
    };
    let stands = [below_hips(AnkleLeft, ThighLeft, KneeLeft), below_hips(AnkleRight, ThighRight, KneeRight)];
    if stands == [Some(true), Some(true)] {
        return on_four_at_rest;
    }
    let Some(points) = first_pose else { return false };
    let length = |a, b, c| Some(at(points, a)?.distance(at(points, b)?) + at(points, b)?.distance(at(points, c)?));
    let (arm, leg) = (length(ShoulderLeft, ElbowLeft, WristLeft), length(ThighLeft, KneeLeft, AnkleLeft));
    let alike = arm.zip(leg).is_some_and(|(arm, leg)| arm >= 0.75 * leg);
    alike && on_four(skeleton, roles, points) == Some(true)
}

/// Whether the trunk lies within 30 degrees of level and the arms reach about as low as the legs; None where a role
/// is missing.
fn on_four(skeleton: &Skeleton, roles: &RoleMap, points: &[DVec3]) -> Option<bool> {
    let tree = Tree::new(skeleton);
    let ends = skeleton.ends();
    let joint = |role| roles.get(role).filter(|&point| point < skeleton.joints.len());
    let lowest = |role| {
        let below = tree.below(joint(role)?);
        let tips = (0..ends.len()).filter(|&n| below.contains(&ends[n])).map(|n| skeleton.joints.len() + n);
        below.iter().copied().chain(tips).filter_map(|point| points.get(point)).map(|point| point.y).reduce(f64::min)
    };
    let arms = lowest(Role::ShoulderLeft)?.min(lowest(Role::ShoulderRight)?);
    let legs = lowest(Role::ThighLeft)?.min(lowest(Role::ThighRight)?);
    let hips = *points.get(joint(Role::Hips)?)?;
    let trunk = *points.get(joint(Role::Chest)?)? - hips;
    let level = trunk.y.abs() < 0.5 * trunk.length();
    Some(level && (arms - legs).abs() < 0.25 * (hips.y - legs))
}

/// A warning where the thighs named left and right lie the other way round for the way the feet point.
fn sides_disagree(skeleton: &Skeleton, roles: &RoleMap, points: &[DVec3]) -> Option<Notice> {
    use Role::*;
    let at = |role| roles.get(role).and_then(|point| points.get(point).copied());
    let (left, right) = (roles.get(ThighLeft)?, roles.get(ThighRight)?);
    let forward = (at(ToeLeft)? - at(AnkleLeft)?) + (at(ToeRight)? - at(AnkleRight)?);
    let across = at(ThighLeft)? - at(ThighRight)?;
    // Feet that point down or sideways in the first pose say nothing.
    let cosine = across.dot(DVec3::Y.cross(forward)) / (across.length() * forward.length());
    if cosine >= -0.5 || left_by_name(skeleton, [left, right]) == Some(right) || !cosine.is_finite() {
        return None;
    }
    let name = |joint: usize| skeleton.joints[joint].name.as_str();
    Some(sides_notice(format!("`{}` lies to the right of `{}`", name(left), name(right))))
}

fn note(kind: &str, message: String, why: &str, remedy: &str) -> Notice {
    Notice {
        severity: Severity::Note,
        kind: kind.to_owned(),
        line: None,
        frame: None,
        count: 1,
        message,
        why: why.to_owned(),
        remedy: remedy.to_owned(),
    }
}

fn guessed(skeleton: &Skeleton, leg: &[usize]) -> Notice {
    let first = leg.first().map_or("", |&joint| skeleton.joints[joint].name.as_str());
    note(
        "roles-guessed",
        format!("no table knows these joint names; the roles come from the shape of the tree (`{first}`: left leg)"),
        "contacts, features and grafts read joints by role",
        "check them with `motionmill inspect`; a table in configs/skeletons names them for good",
    )
}

fn no_body(error: FoldError) -> Notice {
    note(
        "roles-not-found",
        format!("no table knows these joint names, and {error}"),
        "without feet there are no contacts, gaits and grafts; channels and poses are written all the same",
        "name the joints in a table of your own, as in configs/skeletons",
    )
}

fn quadruped() -> Notice {
    note(
        "quadruped",
        "a level trunk on four legs: contacts not applicable".to_owned(),
        "the rules for plants, gaits and grafts are those of two-legged bodies",
        "nothing, unless this is a person; then look at the rest pose of the file",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::sample_bodies::{CMU, named_body, shipped_tables};

    const DOG: &str = "Hips@0,0,0(
        Spine@0,4,14(Spine1@0,1,18(Neck@0,8,12(Head@0,9,11(*@0,-2,15))
            LeftShoulder@5,-4,8(LeftArm@0,-12,-3(LeftForeArm@0,-15,2(LeftHand@0,-15,0(*@0,-3,5))))
            RightShoulder@-5,-4,8(RightArm@0,-12,-3(RightForeArm@0,-15,2(RightHand@0,-15,0(*@0,-3,5))))))
        LeftUpLeg@5,-2,-2(LeftLeg@0,-17,3(LeftFoot@0,-15,-8(*@0,-13,4)))
        RightUpLeg@-5,-2,-2(RightLeg@0,-17,3(RightFoot@0,-15,-8(*@0,-13,4)))
        Tail@0,4,-7(Tail1@0,-5,-10(*@0,-6,-8)))";

    fn kinds(notices: &[Notice]) -> Vec<&str> {
        notices.iter().map(|notice| notice.kind.as_str()).collect()
    }

    #[test]
    fn a_dog_keeps_no_feet() {
        let (roles, source, notices) = assign_roles(&named_body(DOG), &shipped_tables(), None);
        assert!(matches!(source, RoleSource::ByNames(_)), "{source:?}");
        assert!(!roles.has_feet() && roles.get(Role::WristLeft).is_none() && roles.get(Role::Hips).is_some());
        assert_eq!(kinds(&notices), ["quadruped"]);
    }

    #[test]
    fn a_dog_without_names_keeps_none_either_even_on_its_hind_legs() {
        let nameless = ["Left", "Right", "Hips", "Spine", "Shoulder", "Arm", "Leg", "Foot", "Neck", "Head", "Hand"]
            .iter()
            .zip(["a", "e", "c", "d", "f", "g", "h", "i", "j", "k", "m"])
            .fold(DOG.to_owned(), |body, (word, letter)| body.replace(word, letter));
        let body = named_body(&nameless);
        let upright: Vec<DVec3> = rest_points(&body).iter().map(|p| DVec3::new(p.x, p.z, -p.y)).collect();
        for pose in [None, Some(upright.as_slice())] {
            let (roles, source, notices) = assign_roles(&body, &shipped_tables(), pose);
            assert_eq!(source, RoleSource::ByTopology);
            assert!(!roles.has_feet());
            assert!(kinds(&notices).contains(&"quadruped"), "{notices:?}");
        }
    }

    #[test]
    fn people_on_all_fours_stay_people() {
        let body = named_body(CMU);
        // Bent forward at the hips, arms straight down.
        let mut crawl = rest_points(&body);
        for (point, joint) in crawl.iter_mut().zip(&body.joints) {
            let is_leg = ["hip", "fem", "tib", "foot", "toes", "root"].iter().any(|part| joint.name.contains(part));
            if !is_leg {
                *point = DVec3::new(0.1 * point.x, 16.0 - point.x.abs(), point.y - 16.0);
            }
        }
        let (roles, _, notices) = assign_roles(&body, &shipped_tables(), Some(&crawl));
        assert!(roles.has_feet() && !kinds(&notices).contains(&"quadruped"), "{notices:?}");
        // The same where the rest pose is none.
        let mut flat = body.clone();
        for joint in &mut flat.joints {
            joint.offset = DVec3::new(joint.offset.length(), 0.0, 0.0);
        }
        let (roles, _, notices) = assign_roles(&flat, &shipped_tables(), Some(&crawl));
        assert!(roles.has_feet() && !kinds(&notices).contains(&"quadruped"), "{notices:?}");
    }

    #[test]
    fn exchanged_names_are_told() {
        let mirrored = CMU.replace("@1.7,", "@-1.75,").replace("@-1.6,", "@1.6,");
        let (_, _, notices) = assign_roles(&named_body(&mirrored), &shipped_tables(), None);
        assert_eq!(kinds(&notices), ["sides-uncertain"]);
        assert!(assign_roles(&named_body(CMU), &shipped_tables(), None).2.is_empty());
    }

    #[test]
    fn what_is_no_body_is_marked() {
        let (roles, source, notices) = assign_roles(&named_body("prop(a b)"), &shipped_tables(), None);
        assert_eq!((roles, source), (RoleMap::default(), RoleSource::None));
        assert_eq!(kinds(&notices), ["roles-not-found"]);
    }
}
