//! Kinematic chains: the raw ones of T 5.2, which every skeleton has, and the six of a body.
//!
//! T 5.2 as printed cannot run (GRAFTS 1): here a finished chain goes to the result, and a branch joint enters the
//! work list once. Nothing recurses on the call stack, so a skeleton may be thousands of joints deep.

use super::roles::{Role, RoleMap};
use super::skeleton::Skeleton;
use serde::{Deserialize, Serialize};

/// A part of the body whose motion can be taken from another clip (GRAFTS 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "the names say it")]
pub enum BodyChain {
    Trunk,
    Head,
    ArmLeft,
    ArmRight,
    LegLeft,
    LegRight,
}

/// The joints of a body, each in one part; within a part parents come before children.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BodyChains {
    /// From the hierarchy's root down to the joint that the legs hang on, and what else hangs there.
    pub pelvis: Vec<usize>,
    /// From above the pelvis up to the joint that the arms hang on: a fork belongs to the part nearer the root.
    pub trunk: Vec<usize>,
    /// What hangs on the trunk beside the arms.
    pub head: Vec<usize>,
    /// With clavicle, hand and fingers.
    pub arm_left: Vec<usize>,
    /// With clavicle, hand and fingers.
    pub arm_right: Vec<usize>,
    /// With foot and toes.
    pub leg_left: Vec<usize>,
    /// With foot and toes.
    pub leg_right: Vec<usize>,
}

impl BodyChain {
    /// All six.
    pub const ALL: [BodyChain; 6] = [
        BodyChain::Trunk,
        BodyChain::Head,
        BodyChain::ArmLeft,
        BodyChain::ArmRight,
        BodyChain::LegLeft,
        BodyChain::LegRight,
    ];

    /// The word in tables and recipes.
    pub fn name(self) -> &'static str {
        ["trunk", "head", "arm_left", "arm_right", "leg_left", "leg_right"][self as usize]
    }

    /// The chain of that name.
    pub fn from_name(name: &str) -> Option<BodyChain> {
        BodyChain::ALL.into_iter().find(|chain| chain.name() == name)
    }
}

impl BodyChains {
    /// The joints of one chain.
    pub fn joints(&self, chain: BodyChain) -> &[usize] {
        match chain {
            BodyChain::Trunk => &self.trunk,
            BodyChain::Head => &self.head,
            BodyChain::ArmLeft => &self.arm_left,
            BodyChain::ArmRight => &self.arm_right,
            BodyChain::LegLeft => &self.leg_left,
            BodyChain::LegRight => &self.leg_right,
        }
    }

    /// The body's parts by its roles: legs below the hips, arms below the fork of the two shoulders, the rest of
    /// what hangs on the trunk is head. None where hips, thighs or shoulders have no role or don't lie so.
    pub fn of_roles(skeleton: &Skeleton, roles: &RoleMap) -> Option<BodyChains> {
        let tree = Tree::new(skeleton);
        let joint = |role| roles.get(role).filter(|&point| point < skeleton.joints.len());
        let hips = joint(Role::Hips)?;
        let thighs = (joint(Role::ThighLeft)?, joint(Role::ThighRight)?);
        let shoulders = (joint(Role::ShoulderLeft)?, joint(Role::ShoulderRight)?);
        // A joint of its own may carry the legs (Daz: hip, then pelvis): what lies between is pelvis.
        let (_, legs) = tree.fork(hips, thighs)?;
        let (trunk, arms) = tree.fork(hips, shoulders)?;
        let tops = [legs[0], legs[1], arms[0], arms[1]];
        let distinct = (1..4).all(|n| !tops[..n].contains(&tops[n]));
        let apart = distinct && trunk.iter().all(|joint| !tops.contains(joint));
        apart.then(|| tree.parts(&trunk, hips, legs, arms))
    }
}

/// All chains of T 5.2, repaired: from each leaf or branch joint up to the next branch joint or root, which is
/// part of the chain too. Each chain from the root outwards; leaves' chains first, then those of branch joints.
pub fn raw_chains(skeleton: &Skeleton) -> Vec<Vec<usize>> {
    let children = skeleton.children();
    let parent = |joint: usize| skeleton.joints[joint].parent;
    let mut work: Vec<usize> = (0..children.len()).filter(|&joint| children[joint].is_empty()).collect();
    let mut queued = vec![false; children.len()];
    let mut chains = Vec::new();
    let mut next = 0;
    while let Some(&end) = work.get(next) {
        next += 1;
        let mut chain = vec![end];
        let mut joint = end;
        while let Some(above) = parent(joint) {
            joint = above;
            chain.push(joint);
            if children[joint].len() > 1 {
                if parent(joint).is_some() && !queued[joint] {
                    queued[joint] = true;
                    work.push(joint);
                }
                break;
            }
        }
        if chain.len() > 1 {
            chain.reverse();
            chains.push(chain);
        }
    }
    chains
}

/// A skeleton's tree, for going down it.
pub(super) struct Tree {
    pub(super) parents: Vec<Option<usize>>,
    pub(super) children: Vec<Vec<usize>>,
}

impl Tree {
    pub(super) fn new(skeleton: &Skeleton) -> Tree {
        Tree { parents: skeleton.joints.iter().map(|joint| joint.parent).collect(), children: skeleton.children() }
    }

    /// A joint and everything below it, parents first, first children first.
    pub(super) fn below(&self, joint: usize) -> Vec<usize> {
        let mut found = Vec::new();
        let mut stack = vec![joint];
        while let Some(joint) = stack.pop() {
            found.push(joint);
            stack.extend(self.children[joint].iter().rev());
        }
        found
    }

    /// The child of `above` under which `joint` lies (or which it is).
    fn child_toward(&self, above: usize, joint: usize) -> Option<usize> {
        let mut joint = joint;
        loop {
            let parent = self.parents[joint]?;
            if parent == above {
                return Some(joint);
            }
            joint = parent;
        }
    }

    /// Where the ways from `above` to two joints part: the joints passed on the way, and the two where they go on.
    fn fork(&self, above: usize, (left, right): (usize, usize)) -> Option<(Vec<usize>, [usize; 2])> {
        let mut passed = Vec::new();
        let mut fork = above;
        loop {
            let tops = [self.child_toward(fork, left)?, self.child_toward(fork, right)?];
            if tops[0] != tops[1] {
                return Some((passed, tops));
            }
            fork = tops[0];
            passed.push(fork);
        }
    }

    /// Every joint in its part: `trunk` from above the `hips` to the fork, the tops of both legs and arms. What
    /// hangs on the trunk's last joint is head, what hangs on an earlier one is trunk, all else is pelvis.
    pub(super) fn parts(&self, trunk: &[usize], hips: usize, legs: [usize; 2], arms: [usize; 2]) -> BodyChains {
        let fork = trunk.last().copied().unwrap_or(hips);
        let mut chains = BodyChains {
            leg_left: self.below(legs[0]),
            leg_right: self.below(legs[1]),
            arm_left: self.below(arms[0]),
            arm_right: self.below(arms[1]),
            ..BodyChains::default()
        };
        // Where the trunk is empty, everything but legs and arms is pelvis.
        if trunk.is_empty() {
            fill(&mut chains, self.roots_and_below());
            return chains;
        }
        let beside_arms = self.children[fork].iter().filter(|child| !arms.contains(child));
        chains.head = beside_arms.flat_map(|&child| self.below(child)).collect();
        let mut taken = vec![false; self.parents.len()];
        for &joint in chains.head.iter().chain(&chains.arm_left).chain(&chains.arm_right) {
            taken[joint] = true;
        }
        chains.trunk = self.below(trunk[0]).into_iter().filter(|&joint| !taken[joint]).collect();
        fill(&mut chains, self.roots_and_below());
        chains
    }

    fn roots_and_below(&self) -> Vec<usize> {
        let roots = (0..self.parents.len()).filter(|&joint| self.parents[joint].is_none());
        roots.flat_map(|root| self.below(root)).collect()
    }
}

/// Gives the joints that no chain has to the pelvis.
fn fill(chains: &mut BodyChains, all: Vec<usize>) {
    let mut taken = vec![false; all.len()];
    for chain in BodyChain::ALL {
        for &joint in chains.joints(chain) {
            taken[joint] = true;
        }
    }
    chains.pelvis = all.into_iter().filter(|&joint| !taken[joint]).collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::sample_bodies::{CMU, body_names, named_body, shipped_tables};

    fn chains_of(body: &str) -> Vec<String> {
        let skeleton = named_body(body);
        raw_chains(&skeleton).iter().map(|chain| body_names(&skeleton, chain).join(" ")).collect()
    }

    #[test]
    fn each_branch_joint_ends_the_chains_above_it_once() {
        let chains = chains_of("root(a(b(c) d(e f)) g)");
        assert_eq!(chains, ["a b c", "d e", "d f", "root g", "root a", "a d"]);
        assert_eq!(chains_of("root"), Vec::<String>::new());
        assert_eq!(chains_of("root(a(b))"), ["root a b"]);
    }

    #[test]
    fn a_wrist_that_forks_into_hand_and_thumb_makes_ten_chains() {
        assert_eq!(raw_chains(&named_body(CMU)).len(), 10);
    }

    #[test]
    fn three_thousand_joints_in_a_row_are_one_chain() {
        let deep = named_body(&format!("{}x{}", "a(".repeat(2999), ")".repeat(2999)));
        assert_eq!(raw_chains(&deep).len(), 1);
        assert_eq!(raw_chains(&deep)[0].len(), 3000);
    }

    #[test]
    fn named_roles_put_every_joint_in_one_part() {
        let skeleton = named_body(CMU);
        let tables = shipped_tables();
        let Some((_, roles)) = tables.best(&skeleton) else { panic!("CMU is known") };
        let Some(chains) = BodyChains::of_roles(&skeleton, &roles) else { panic!("CMU is a body") };
        let names = |joints: &[usize]| body_names(&skeleton, joints).join(" ");
        assert_eq!(names(&chains.pelvis), "root");
        assert_eq!(names(&chains.trunk), "lowerback upperback thorax");
        assert_eq!(names(&chains.head), "lowerneck upperneck head");
        assert_eq!(names(&chains.arm_left), "lclavicle lhumerus lradius lwrist lhand lfingers lthumb");
        assert_eq!(names(&chains.leg_right), "rhipjoint rfemur rtibia rfoot rtoes");
        let count: usize = BodyChain::ALL.into_iter().map(|chain| chains.joints(chain).len()).sum();
        assert_eq!(count + chains.pelvis.len(), skeleton.joints.len());
        assert_eq!(BodyChain::from_name("arm_right"), Some(BodyChain::ArmRight));
    }

    #[test]
    fn roles_that_do_not_lie_like_a_body_have_no_chains() {
        let skeleton = named_body("a(b(c) d)");
        let mut roles = RoleMap::default();
        assert_eq!(BodyChains::of_roles(&skeleton, &roles), None);
        for (role, joint) in [
            (Role::Hips, 0),
            (Role::ThighLeft, 1),
            (Role::ThighRight, 2),
            (Role::ShoulderLeft, 2),
            (Role::ShoulderRight, 3),
        ] {
            roles.set(role, joint);
        }
        assert_eq!(BodyChains::of_roles(&skeleton, &roles), None);
    }
}
