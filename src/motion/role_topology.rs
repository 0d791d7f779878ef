//! Roles by the shape of the tree: what each joint of a folded body is, by its place and its bone's length.
//!
//! Thigh, knee and ankle are the ends of the two longest bones in a row of a leg (shoulder, elbow and wrist alike),
//! so a joint before them (CMU's `lhipjoint`, a clavicle) and toes or fingers after them need no names.

use super::chains::Tree;
use super::folding::{Folded, anatomy, first_largest};
use super::roles::{Role, RoleMap};
use super::skeleton::Skeleton;
use glam::DVec3;

/// Roles of a folded body. `points`: joints and leaf ends, as for [`fold`](super::folding::fold).
pub fn roles_of_fold(skeleton: &Skeleton, folded: &Folded, points: &[DVec3]) -> RoleMap {
    use Role::*;
    let body = Body::new(skeleton, points);
    let chains = &folded.chains;
    let mut roles = RoleMap::default();
    roles.set(Hips, folded.hips);
    roles.set(Chest, folded.chest);
    for (chain, limb) in [
        (&chains.leg_left, [None, Some(ThighLeft), Some(KneeLeft), Some(AnkleLeft)]),
        (&chains.leg_right, [None, Some(ThighRight), Some(KneeRight), Some(AnkleRight)]),
        (&chains.arm_left, [Some(ClavicleLeft), Some(ShoulderLeft), Some(ElbowLeft), Some(WristLeft)]),
        (&chains.arm_right, [Some(ClavicleRight), Some(ShoulderRight), Some(ElbowRight), Some(WristRight)]),
    ] {
        let path = body.path(chain[0]);
        let Some(first) = body.longest_two(&path) else { continue };
        for (role, at) in limb.into_iter().zip(first as isize - 1..) {
            let point = usize::try_from(at).ok().and_then(|at| path.get(at));
            if let (Some(role), Some(&point)) = (role, point) {
                roles.set(role, point);
            }
        }
    }
    if let Some(&first) = chains.head.first() {
        let path = body.path(first);
        let head = body.head_of(&path);
        roles.set(Head, head);
        if head != first {
            roles.set(Neck, first);
        }
    }
    fill_gaps(skeleton, &mut roles);
    roles
}

/// Gives the roles that follow from others: the spine joint below the chest, the joint (or leaf end) after the
/// ankle and after the elbow.
pub(super) fn fill_gaps(skeleton: &Skeleton, roles: &mut RoleMap) {
    use Role::*;
    let body = Body::new(skeleton, &[]);
    let chest = roles.get(Chest).filter(|&chest| chest < skeleton.joints.len());
    if roles.get(Spine).is_none()
        && let Some(below) = chest.and_then(|chest| skeleton.joints[chest].parent)
        && roles.of_point(below).is_none()
    {
        roles.set(Spine, below);
    }
    for (before, role) in
        [(AnkleLeft, ToeLeft), (AnkleRight, ToeRight), (ElbowLeft, WristLeft), (ElbowRight, WristRight)]
    {
        if roles.get(role).is_none()
            && let Some(before) = roles.get(before).filter(|&before| before < skeleton.joints.len())
            && let Some(&after) = body.path(before).get(1)
        {
            roles.set(role, after);
        }
    }
}

/// A skeleton's tree without joints of no anatomy, and its points.
struct Body<'a> {
    skeleton: &'a Skeleton,
    points: &'a [DVec3],
    tree: Tree,
    sizes: Vec<usize>,
}

impl Body<'_> {
    fn new<'a>(skeleton: &'a Skeleton, points: &'a [DVec3]) -> Body<'a> {
        let mut tree = Tree::new(skeleton);
        tree.children = anatomy(skeleton, &tree.children);
        let mut sizes = vec![1; tree.parents.len()];
        for joint in (0..sizes.len()).rev() {
            sizes[joint] += tree.children[joint].iter().map(|&child| sizes[child]).sum::<usize>();
        }
        Body { skeleton, points, tree, sizes }
    }

    /// From a joint down along the largest child, and the leaf's end if it has a length.
    fn path(&self, top: usize) -> Vec<usize> {
        let mut path = vec![top];
        let mut joint = top;
        while let Some(child) = first_largest(self.tree.children[joint].iter().copied(), &self.sizes) {
            path.push(child);
            joint = child;
        }
        let end = self.skeleton.joints[joint].end.filter(|end| end.length_squared() > 0.0);
        if let Some(n) = end.and_then(|_| self.skeleton.ends().iter().position(|&leaf| leaf == joint)) {
            path.push(self.skeleton.joints.len() + n);
        }
        path
    }

    /// Where in a path the two longest bones in a row begin. Both begin at joints. Of sums within 15 % the later
    /// one: CMU's clavicles are as long as forearms.
    fn longest_two(&self, path: &[usize]) -> Option<usize> {
        let at = |n: usize| self.points.get(path[n]).copied().unwrap_or(DVec3::ZERO);
        let bone = |n: usize| at(n).distance(at(n + 1));
        let sums: Vec<f64> = (0..path.len().saturating_sub(2)).map(|n| bone(n) + bone(n + 1)).collect();
        let most = sums.iter().copied().fold(0.0, f64::max);
        sums.iter().rposition(|&sum| sum >= 0.85 * most)
    }

    /// The base of the skull: the first joint named a head, else the last joint of the path. A leaf that is named
    /// an end (`HeadTop_End`, `Nub`) is none.
    fn head_of(&self, path: &[usize]) -> usize {
        let joints: Vec<usize> = path.iter().copied().filter(|&point| point < self.skeleton.joints.len()).collect();
        let name = |joint: usize| self.skeleton.joints[joint].name.to_lowercase();
        let is_end = |joint: usize| ["end", "nub", "tip", "top", "site"].iter().any(|word| name(joint).ends_with(word));
        let named = joints.iter().copied().find(|&joint| name(joint).contains("head") && !is_end(joint));
        let last = || joints.iter().copied().rev().find(|&joint| !is_end(joint));
        named.or_else(last).unwrap_or(path[0])
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::motion::folding::{fold, rest_points};
    use crate::motion::sample_bodies::{CMU, named_body, shipped_tables};

    fn roles(body: &str) -> (Skeleton, RoleMap) {
        let skeleton = named_body(body);
        let points = rest_points(&skeleton);
        let roles = roles_of_fold(&skeleton, &fold(&skeleton, &points).unwrap(), &points);
        (skeleton, roles)
    }

    #[test]
    fn the_tree_alone_gives_what_the_names_give() {
        let (skeleton, by_tree) = roles(CMU);
        let tables = shipped_tables();
        let (table, by_names) = tables.best(&skeleton).unwrap();
        assert_eq!(table, "cmu-asf");
        for role in Role::ALL {
            assert_eq!(by_tree.get(role), by_names.get(role), "{role:?}");
        }
    }

    #[test]
    fn ends_stand_for_wrists_and_toes_that_are_no_joints() {
        let (skeleton, roles) = roles(
            "h(la@9,0,0(lb@0,-40,0(lc@0,-40,0(*@0,-5,12))) ra@-9,0,0(rb@0,-40,0(rc@0,-40,0(*@0,-5,12))) \
             s(c(n@0,30,0(*@0,20,0) lx@15,20,0(ly@30,0,0(lz@25,0,0(*@0,0,0))) rx@-15,20,0(ry@-30,0,0(rz@-25,0,0(*@0,0,0))))))",
        );
        let n_joints = skeleton.joints.len();
        assert_eq!((roles.get(Role::ToeLeft), roles.get(Role::ToeRight)), (Some(n_joints), Some(n_joints + 1)));
        assert_eq!(skeleton.joints[roles.get(Role::WristLeft).unwrap()].name, "lz");
        assert_eq!(skeleton.joints[roles.get(Role::ShoulderLeft).unwrap()].name, "lx");
        assert_eq!((roles.get(Role::ClavicleLeft), roles.get(Role::Neck)), (None, None));
        assert_eq!(skeleton.joints[roles.get(Role::Head).unwrap()].name, "n");
        assert!(roles.has_feet());
    }

    #[test]
    fn the_head_is_no_end_joint() {
        let arms = "lx@5,0,0(ly@30,0,0(lz@25,0,0)) rx@-5,0,0(ry@-30,0,0(rz@-25,0,0))";
        let legs = "la@9,0,0(lb@0,-40,0(lc@0,-40,0(ld@0,0,9))) ra@-9,0,0(rb@0,-40,0(rc@0,-40,0(rd@0,0,9)))";
        let body = format!("h({legs} s(c(n1(n2(skull(HeadTop_End))) {arms})))");
        let (skeleton, roles) = roles(&body);
        let name = |role| skeleton.joints[roles.get(role).unwrap()].name.as_str();
        assert_eq!((name(Role::Neck), name(Role::Head)), ("n1", "skull"));
        assert_eq!((name(Role::Spine), name(Role::Chest)), ("s", "c"));
    }
}
