//! Finds pelvis, trunk, head, arms and legs in any tree of joints by its shape: the folding rule of GRAFTS 1.
//!
//! 1. Joints without anatomy are set aside: twist joints, `ik_` targets, props, eyes and jaws, what hangs on a head.
//! 2. Two children of one joint that are alike in at least three levels are a *mirror pair*. The first pair on the
//!    way down from the root along the largest child are the legs, the next one above them the arms.
//! 3. A fork joint belongs to the part nearer the root.
//! 4. Sides by geometry (left is up x the way the feet point); names decide where geometry says nothing.
//!
//! What was set aside goes, in the end, to the part it hangs on.

use super::chains::{BodyChains, Tree};
use super::notice::{Notice, Severity};
use super::skeleton::Skeleton;
use glam::DVec3;
use std::collections::BTreeMap;

/// Levels down to which subtrees are told apart; no limb is that deep.
const MOST_LEVELS: usize = 64;

/// Why a tree is not the tree of a body; only its raw chains apply then.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FoldError {
    /// No two branches are alike.
    #[error("no two branches of the tree are alike in three levels: there are no legs")]
    NoLegs,
    /// Only legs hang on the pelvis.
    #[error("nothing but legs hangs on the pelvis")]
    NoTrunk,
    /// No second pair of like branches.
    #[error("no second pair of branches is alike in three levels: there are no arms")]
    NoArms,
}

/// A tree folded into a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Folded {
    /// Every joint in its part.
    pub chains: BodyChains,
    /// The joint that the legs hang on.
    pub hips: usize,
    /// The joint that the arms hang on.
    pub chest: usize,
    /// Sides that are uncertain.
    pub notices: Vec<Notice>,
}

/// Where joints and leaf ends lie with no rotation at all, file units: offsets summed up.
pub fn rest_points(skeleton: &Skeleton) -> Vec<DVec3> {
    let mut points: Vec<DVec3> = Vec::with_capacity(skeleton.joints.len());
    for joint in &skeleton.joints {
        points.push(joint.parent.map_or(DVec3::ZERO, |parent| points[parent]) + joint.offset);
    }
    for joint in skeleton.ends() {
        points.push(points[joint] + skeleton.joints[joint].end.unwrap_or(DVec3::ZERO));
    }
    points
}

/// Folds a skeleton's tree into a body. `points` are positions of joints and leaf ends with Y up, in any unit: the
/// first pose where there is one, since rest poses of some exporters are no pose at all.
///
/// # Errors
/// A tree without two mirror pairs on its way up.
pub fn fold(skeleton: &Skeleton, points: &[DVec3]) -> Result<Folded, FoldError> {
    let whole = Tree::new(skeleton);
    let bare = Tree { parents: whole.parents.clone(), children: anatomy(skeleton, &whole.children) };
    let shapes = Shapes::of(&bare);
    let roots = (0..bare.parents.len()).filter(|&joint| bare.parents[joint].is_none());
    let root = first_largest(roots, &shapes.size).ok_or(FoldError::NoLegs)?;

    let (pelvis, legs) = shapes.down_to_pair(&bare, root).ok_or(FoldError::NoLegs)?;
    let hips = pelvis[pelvis.len() - 1];
    let above = bare.children[hips].iter().copied().filter(|child| !legs.contains(child));
    let above = first_largest(above, &shapes.size).ok_or(FoldError::NoTrunk)?;
    let (trunk, arms) = shapes.down_to_pair(&bare, above).ok_or(FoldError::NoArms)?;

    let mut notices = Vec::new();
    let forward = way_of_feet(skeleton, &bare, legs, points);
    let legs = left_first(skeleton, &bare, legs, forward, points, "legs", &mut notices);
    let arms = left_first(skeleton, &bare, arms, forward, points, "arms", &mut notices);
    Ok(Folded { chains: whole.parts(&trunk, hips, legs, arms), hips, chest: trunk[trunk.len() - 1], notices })
}

/// Which of two joints is the left one by their names: where these first differ, one has an `l`, the other an `r`.
pub(super) fn left_by_name(skeleton: &Skeleton, pair: [usize; 2]) -> Option<usize> {
    let [a, b] = pair.map(|joint| skeleton.joints[joint].name.to_lowercase());
    match a.chars().zip(b.chars()).find(|(a, b)| a != b) {
        Some(('l', 'r')) => Some(pair[0]),
        Some(('r', 'l')) => Some(pair[1]),
        _ => None,
    }
}

/// Children without the joints that have no anatomy.
pub(super) fn anatomy(skeleton: &Skeleton, children: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let bare_name = |joint: usize| {
        let name = skeleton.joints[joint].name.as_str();
        name.rsplit([':', '|']).next().unwrap_or(name).to_lowercase()
    };
    let stray = |joint: usize| {
        let name = bare_name(joint);
        name.starts_with("ik_") || ["twist", "prop", "eye", "jaw"].iter().any(|word| name.contains(word))
    };
    // A leaf within the segment of a sibling that goes on: a twist joint by any name.
    let within = |leaf: usize, sibling: usize| {
        let (offset, segment) = (skeleton.joints[leaf].offset, skeleton.joints[sibling].offset);
        let along = offset.dot(segment) / segment.length_squared();
        !children[sibling].is_empty()
            && (0.02..0.98).contains(&along)
            && (offset - segment * along).length() < 0.01 * segment.length()
    };
    let twists = |joint: usize, siblings: &[usize]| {
        children[joint].is_empty() && siblings.iter().any(|&sibling| sibling != joint && within(joint, sibling))
    };
    (0..children.len())
        .map(|joint| {
            if bare_name(joint).ends_with("head") {
                return Vec::new();
            }
            let siblings = &children[joint];
            // Hundreds of siblings are no limb, and comparing all of them would take long.
            let few = siblings.len() <= 64;
            siblings.iter().copied().filter(|&child| !(stray(child) || few && twists(child, siblings))).collect()
        })
        .collect()
}

/// Of some joints the one with the largest value, the first of equal ones.
pub(super) fn first_largest(joints: impl Iterator<Item = usize>, value: &[usize]) -> Option<usize> {
    joints.reduce(|best, joint| if value[joint] > value[best] { joint } else { best })
}

/// Sizes of subtrees, and what tells their shapes apart.
struct Shapes {
    size: Vec<usize>,
    depth: Vec<usize>,
    /// Equal for joints whose whole subtrees are alike.
    whole: Vec<usize>,
    /// `[n][joint]`: equal for joints whose subtrees are alike in n + 1 levels, the joint itself being the first.
    levels: Vec<Vec<usize>>,
}

impl Shapes {
    fn of(tree: &Tree) -> Shapes {
        let n_joints = tree.parents.len();
        let (mut size, mut depth, mut whole) = (vec![1; n_joints], vec![1; n_joints], vec![0; n_joints]);
        let mut numbers = BTreeMap::new();
        for joint in (0..n_joints).rev() {
            for &child in &tree.children[joint] {
                size[joint] += size[child];
                depth[joint] = depth[joint].max(depth[child] + 1);
            }
            whole[joint] = number_of(&mut numbers, &tree.children[joint], &whole);
        }
        let deepest = depth.iter().copied().max().unwrap_or(0).min(MOST_LEVELS);
        let mut levels = vec![vec![0; n_joints]];
        while levels.len() < deepest {
            let before = &levels[levels.len() - 1];
            let mut numbers = BTreeMap::new();
            levels.push((0..n_joints).map(|joint| number_of(&mut numbers, &tree.children[joint], before)).collect());
        }
        Shapes { size, depth, whole, levels }
    }

    /// From a joint down along the largest child to the first that has a mirror pair.
    fn down_to_pair(&self, tree: &Tree, from: usize) -> Option<(Vec<usize>, [usize; 2])> {
        let mut path = vec![from];
        let mut joint = from;
        loop {
            if let Some(pair) = self.mirror_pair(&tree.children[joint]) {
                return Some((path, pair));
            }
            joint = first_largest(tree.children[joint].iter().copied(), &self.size)?;
            path.push(joint);
        }
    }

    /// The two that are alike in most levels (in all counts most); of equal ones the larger, then the first.
    fn mirror_pair(&self, children: &[usize]) -> Option<[usize; 2]> {
        let limbs: Vec<usize> = children.iter().copied().filter(|&child| self.depth[child] >= 3).collect();
        let mut best: Option<((usize, usize), [usize; 2])> = None;
        for (n, &a) in limbs.iter().enumerate() {
            for &b in &limbs[n + 1..] {
                let rank = (self.alike(a, b), self.size[a]);
                if rank.0 >= 3 && best.is_none_or(|(most, _)| rank > most) {
                    best = Some((rank, [a, b]));
                }
            }
        }
        best.map(|(_, pair)| pair)
    }

    fn alike(&self, a: usize, b: usize) -> usize {
        if self.whole[a] == self.whole[b] {
            return usize::MAX;
        }
        self.levels.partition_point(|level| level[a] == level[b])
    }
}

/// A number for a joint by the numbers of its children, whatever their order.
fn number_of(numbers: &mut BTreeMap<Vec<usize>, usize>, children: &[usize], below: &[usize]) -> usize {
    let mut shape: Vec<usize> = children.iter().map(|&child| below[child]).collect();
    shape.sort_unstable();
    let next = numbers.len();
    *numbers.entry(shape).or_insert(next)
}

/// The last bones of both legs added up: where the feet point.
fn way_of_feet(skeleton: &Skeleton, tree: &Tree, legs: [usize; 2], points: &[DVec3]) -> DVec3 {
    legs.into_iter()
        .filter_map(|leg| {
            let last = *tree.below(leg).last()?;
            Some(points.get(last)? - points.get(skeleton.joints[last].parent?)?)
        })
        .sum()
}

/// The pair with the left one first, and a notice where geometry and names disagree or are silent.
fn left_first(
    skeleton: &Skeleton,
    tree: &Tree,
    pair: [usize; 2],
    forward: DVec3,
    points: &[DVec3],
    what: &str,
    notices: &mut Vec<Notice>,
) -> [usize; 2] {
    let left = DVec3::Y.cross(forward);
    let side = |joint: usize| {
        let below = tree.below(joint);
        let top = skeleton.joints[joint].parent.and_then(|parent| points.get(parent)).copied().unwrap_or(DVec3::ZERO);
        let sum: DVec3 = below.iter().filter_map(|&joint| points.get(joint)).map(|point| *point - top).sum();
        sum.dot(left) / below.len() as f64
    };
    let [a, b] = pair.map(side);
    let by_shape = (a != b && (a - b).is_finite()).then(|| if a > b { pair[0] } else { pair[1] });
    let by_name = left_by_name(skeleton, pair);
    let names = pair.map(|joint| skeleton.joints[joint].name.as_str());
    match (by_shape, by_name) {
        (Some(shape), Some(name)) if shape != name => {
            notices
                .push(sides_notice(format!("{what} `{}` and `{}`: names and geometry disagree", names[0], names[1])));
        }
        (None, None) => {
            notices.push(sides_notice(format!("{what} `{}` and `{}`: neither names a side", names[0], names[1])));
        }
        _ => {}
    }
    if by_shape.or(by_name) == Some(pair[1]) { [pair[1], pair[0]] } else { pair }
}

/// A warning that left and right may be exchanged.
pub(super) fn sides_notice(message: String) -> Notice {
    Notice {
        severity: Severity::Warning,
        kind: "sides-uncertain".to_owned(),
        line: None,
        frame: Some(0),
        count: 1,
        message,
        why: "left and right may be exchanged in contacts, plant states and grafts".to_owned(),
        remedy: "look at the clip; name the joints in a skeleton table of your own, or set the up axis".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::motion::chains::BodyChain;
    use crate::motion::sample_bodies::{CMU, body_names, named_body};

    const LEGS: &str = "LeftUpLeg@9,-5,0(LeftLeg@0,-42,0(LeftFoot@0,-40,-1(LeftToe@0,-6,13)))
        RightUpLeg@-9,-5,0(RightLeg@0,-42,0(RightFoot@0,-40,-1(RightToe@0,-6,13)))";
    const ARMS: &str = "LeftShoulder@4,20,0(LeftArm@13,0,0(LeftForeArm@27,0,0(LeftHand@25,0,0)))
        RightShoulder@-4,20,0(RightArm@-13,0,0(RightForeArm@-27,0,0(RightHand@-25,0,0)))";

    fn folded(body: &str) -> (Skeleton, Folded) {
        let skeleton = named_body(body);
        let folded = fold(&skeleton, &rest_points(&skeleton)).unwrap();
        let count: usize = BodyChain::ALL.into_iter().map(|chain| folded.chains.joints(chain).len()).sum();
        assert_eq!(count + folded.chains.pelvis.len(), skeleton.joints.len(), "every joint in one part");
        (skeleton, folded)
    }

    fn part(body: &str, chain: BodyChain) -> String {
        let (skeleton, folded) = folded(body);
        body_names(&skeleton, folded.chains.joints(chain)).join(" ")
    }

    fn is_body(body: &str) {
        for (chain, first) in [
            (BodyChain::LegLeft, "LeftUpLeg"),
            (BodyChain::LegRight, "RightUpLeg"),
            (BodyChain::ArmLeft, "LeftShoulder"),
            (BodyChain::ArmRight, "RightShoulder"),
        ] {
            assert_eq!(part(body, chain).split(' ').next(), Some(first), "{body}");
        }
        assert!(folded(body).1.notices.is_empty());
    }

    #[test]
    fn thumbs_fold_into_the_arm() {
        assert_eq!(part(CMU, BodyChain::ArmLeft), "lclavicle lhumerus lradius lwrist lhand lfingers lthumb");
        assert_eq!(part(CMU, BodyChain::Trunk), "lowerback upperback thorax");
        assert_eq!(part(CMU, BodyChain::Head), "lowerneck upperneck head");
        assert_eq!(part(CMU, BodyChain::LegLeft), "lhipjoint lfemur ltibia lfoot ltoes");
    }

    #[test]
    fn a_place_above_the_hips_folds_into_the_pelvis() {
        let body = format!("joint_Root(Hips@0,94,0(Spine(Chest(Neck(Head) {ARMS})) {LEGS}))");
        is_body(&body);
        let (skeleton, folded) = folded(&body);
        assert_eq!(body_names(&skeleton, &folded.chains.pelvis), ["joint_Root", "Hips"]);
        assert_eq!(skeleton.joints[folded.hips].name, "Hips");
    }

    #[test]
    fn five_fingers_fold_into_the_arm() {
        let fingers = |side: &str, x: i32| {
            let finger =
                |name: &str, z: i32| format!("{side}{name}1@{x},0,{z}({side}{name}2@{x},0,0({side}{name}3@{x},0,0))");
            [("Thumb", 3), ("Index", 2), ("Middle", 1), ("Ring", 0), ("Pinky", -1)].map(|(n, z)| finger(n, z)).join(" ")
        };
        let arms = ARMS
            .replace("LeftHand@25,0,0", &format!("LeftHand@25,0,0({})", fingers("Left", 3)))
            .replace("RightHand@-25,0,0", &format!("RightHand@-25,0,0({})", fingers("Right", -3)));
        let body = format!("Hips@0,94,0({LEGS} Spine(Spine1(Spine2(Neck(Head(HeadTop)) {arms}))))");
        is_body(&body);
        assert_eq!(part(&body, BodyChain::ArmRight).split(' ').count(), 4 + 15);
        assert_eq!(part(&body, BodyChain::Head), "Neck Head HeadTop");
    }

    #[test]
    fn shoulders_under_the_neck_end_the_trunk_there() {
        let body = format!("Hips@0,94,0({LEGS} Spine(Chest(Neck(Head {ARMS}))))");
        is_body(&body);
        assert_eq!(part(&body, BodyChain::Trunk), "Spine Chest Neck");
        assert_eq!(part(&body, BodyChain::Head), "Head");
    }

    #[test]
    fn twist_ik_and_prop_joints_do_not_hide_the_body() {
        let arms = ARMS
            .replace("LeftForeArm@27", "LeftArmRoll@13,0,0 LeftForeArm@27")
            .replace("RightHand@-25,0,0", "forearm_twist_r@-11,0.3,0 RightHand@-25,0,0(prop_r@-5,0,0(blade@-5,0,0))");
        let legs = LEGS.replace("LeftLeg@0,-42,0", "thigh_twist_l@0,-20,0 LeftLeg@0,-42,0");
        let eyes = "Head(eye_l(a(b)) eye_r(c(d)))";
        let ik = "ik_foot_root(ik_foot_l(ik_a(ik_b)) ik_foot_r(ik_c(ik_d)))";
        let body = format!("root({ik} Hips@0,94,0({legs} Spine(Chest(Neck({eyes}) {arms}))))");
        is_body(&body);
        assert!(part(&body, BodyChain::ArmLeft).contains("LeftArmRoll"), "a twist joint moves with its arm");
        assert!(part(&body, BodyChain::ArmRight).contains("forearm_twist_r RightHand prop_r blade"));
        assert!(part(&body, BodyChain::Head).contains("eye_r c d"));
        let (skeleton, folded) = folded(&body);
        assert!(body_names(&skeleton, &folded.chains.pelvis).contains(&"ik_foot_l"));
    }

    #[test]
    fn spine_beside_two_legs_is_no_leg() {
        // cgspeed's LowerBack is alike a leg in three levels; the legs are alike in all.
        let body = "Hips(LHip(LUp@9,0,0(LLeg@0,-4,0(LFoot@0,-4,0(LToe@0,0,2)))) RHip(RUp@-9,0,0(RLeg@0,-4,0(RFoot@0,-4,0(RToe@0,0,2)))) \
            LowerBack(Spine(Spine1(Neck(Head) LSh@1,0,0(LArm@5,0,0(LHand@5,0,0)) RSh@-1,0,0(RArm@-5,0,0(RHand@-5,0,0))))))";
        assert_eq!(part(body, BodyChain::Trunk), "LowerBack Spine Spine1");
        assert_eq!(part(body, BodyChain::LegRight), "RHip RUp RLeg RFoot RToe");
    }

    #[test]
    fn geometry_decides_the_sides_and_says_so() {
        let swapped = format!("Hips@0,94,0({LEGS} Spine(Chest(Neck(Head) {ARMS})))")
            .replace("Left", "x")
            .replace("Right", "Left")
            .replace('x', "Right");
        let (skeleton, folded) = folded(&swapped);
        assert_eq!(skeleton.joints[folded.chains.leg_left[0]].name, "RightUpLeg");
        assert_eq!(folded.notices.len(), 2);
        assert!(folded.notices[0].message.contains("disagree"), "{}", folded.notices[0].message);
    }

    #[test]
    fn names_decide_where_geometry_is_silent() {
        let body = named_body("h(r_a(r_b(r_c)) l_a(l_b(l_c)) s(c(rx(ry(rz)) lx(ly(lz)))))");
        let folded = fold(&body, &[]).unwrap();
        assert_eq!(body_names(&body, &folded.chains.leg_left), ["l_a", "l_b", "l_c"]);
        assert_eq!(body_names(&body, &folded.chains.arm_right), ["rx", "ry", "rz"]);
        assert!(folded.notices.is_empty());
        let nameless = named_body("h(a1(a2(a3)) b1(b2(b3)) s(c(d1(d2(d3)) e1(e2(e3)))))");
        assert_eq!(fold(&nameless, &[]).unwrap().notices.len(), 2);
    }

    #[test]
    fn trees_that_are_no_body_are_refused() {
        let refusal = |body: &str| fold(&named_body(body), &[]).unwrap_err();
        assert_eq!(refusal("a(b(c(d)))"), FoldError::NoLegs);
        assert_eq!(refusal(""), FoldError::NoLegs);
        assert_eq!(refusal("h(a(b(c)) d(e(f)))"), FoldError::NoTrunk);
        assert_eq!(refusal("h(a(b(c)) d(e(f)) s(t u))"), FoldError::NoArms);
    }

    #[test]
    fn four_thousand_joints_fold_quickly() {
        let chain = |n: usize| format!("{}x{}", "a(".repeat(n - 1), ")".repeat(n - 1));
        assert_eq!(fold(&named_body(&chain(4000)), &[]), Err(FoldError::NoLegs));
        // Two long branches that differ only at their ends.
        let long = format!("h({} {}(b c){})", chain(2000), "a(".repeat(1999) + "x", ")".repeat(1999));
        assert_eq!(fold(&named_body(&long), &[]).unwrap_err(), FoldError::NoTrunk);
        let broad = format!("h({})", "a(b(c))".repeat(1300));
        assert_eq!(fold(&named_body(&broad), &[]).unwrap_err(), FoldError::NoArms);
    }
}
