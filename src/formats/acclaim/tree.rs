//! Bones and hierarchy lines into joints, parents before children.

use super::asf::{Root, is_root, rest_axis};
use crate::formats::finding::{Deviation, Finding};
use crate::formats::text::excerpt;
use crate::motion::skeleton::{AngleUnit, PositionRule};
use crate::motion::{Axis, Bone, Channel, Format, Joint, Skeleton};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// A bone of `:bonedata`.
pub(super) struct BoneData {
    /// Name as written.
    pub(super) raw: Vec<u8>,
    /// The same in UTF-8.
    pub(super) name: String,
    /// Line of its name.
    pub(super) line: u32,
    pub(super) direction: DVec3,
    pub(super) length: f64,
    /// In the file's angle unit.
    pub(super) axis: [f64; 3],
    pub(super) axis_letters: [Axis; 3],
    pub(super) channels: Vec<Channel>,
}

/// One child on a line of `:hierarchy`.
pub(super) struct Child<'a> {
    pub(super) line: u32,
    pub(super) parent: &'a [u8],
    pub(super) child: &'a [u8],
}

/// Joints and bones, each other's numbers. Joint 0 is the root, which is no bone.
pub(super) struct Tree {
    /// Joint of each bone; `None` for bones outside the hierarchy.
    pub(super) joint_of: Vec<Option<usize>>,
    /// Bone of each joint.
    pub(super) bone_of: Vec<Option<usize>>,
    /// Parent joint of each joint.
    parents: Vec<Option<usize>>,
    /// Bones that no line mentions.
    pub(super) left_out: Vec<usize>,
}

/// Checks the hierarchy and numbers the joints.
pub(super) fn build(
    bones: &[BoneData],
    children: &[Child<'_>],
    bone_named: &HashMap<Vec<u8>, usize>,
    max_depth: usize,
) -> Result<Tree, Finding> {
    // Parent of each bone: a bone, or the root (`Some(None)`); and the line that says so.
    let mut parent_of: Vec<Option<Option<usize>>> = vec![None; bones.len()];
    let mut line_of = vec![0; bones.len()];
    let mut mentioned = vec![false; bones.len()];
    let find = |name: &[u8], line| match bone_named.get(name) {
        Some(&bone) => Ok(bone),
        None => Err(Finding::new(line, Deviation::HierarchyUnknownBone { bone: excerpt(name) })),
    };
    for &Child { line, parent, child } in children {
        let parent = if is_root(parent) { None } else { Some(find(parent, line)?) };
        let bone = find(child, line)?;
        if parent_of[bone].replace(parent).is_some() {
            return Err(Finding::new(line, Deviation::TwoParents { bone: excerpt(child) }));
        }
        line_of[bone] = line;
        mentioned[bone] = true;
        if let Some(parent) = parent {
            mentioned[parent] = true;
        }
    }
    let mut children_of: Vec<Vec<usize>> = vec![Vec::new(); bones.len()];
    let mut ready = BinaryHeap::new();
    for (bone, parent) in parent_of.iter().enumerate() {
        match parent {
            Some(Some(parent)) => children_of[*parent].push(bone),
            Some(None) => ready.push(Reverse(bone)),
            None => {}
        }
    }
    // The earliest order of :bonedata that puts parents before children: always the first bone that may come.
    let mut tree =
        Tree { joint_of: vec![None; bones.len()], bone_of: vec![None], parents: vec![None], left_out: Vec::new() };
    let mut depth = vec![1];
    while let Some(Reverse(bone)) = ready.pop() {
        let parent = match parent_of[bone] {
            Some(Some(parent)) => tree.joint_of[parent].expect("a parent is numbered before its children"),
            _ => 0,
        };
        depth.push(depth[parent] + 1);
        if depth[tree.bone_of.len()] > max_depth {
            return Err(Finding::new(line_of[bone], Deviation::TooDeep { limit: max_depth }));
        }
        tree.joint_of[bone] = Some(tree.bone_of.len());
        tree.bone_of.push(Some(bone));
        tree.parents.push(Some(parent));
        ready.extend(children_of[bone].iter().map(|&child| Reverse(child)));
    }
    let loose = |name: &[u8]| !is_root(name) && bone_named.get(name).is_some_and(|&bone| tree.joint_of[bone].is_none());
    if let Some(&Child { line, parent, .. }) = children.iter().find(|child| loose(child.parent)) {
        return Err(Finding::new(line, Deviation::HierarchyLoose { bone: excerpt(parent) }));
    }
    tree.left_out = (0..bones.len()).filter(|&bone| !mentioned[bone]).collect();
    Ok(tree)
}

impl Tree {
    /// The joints as a skeleton.
    pub(super) fn skeleton(&self, root: &Root, bones: &[BoneData], angle_unit: AngleUnit) -> Skeleton {
        let mut has_children = vec![false; self.parents.len()];
        for parent in self.parents.iter().flatten() {
            has_children[*parent] = true;
        }
        let joints = self.bone_of.iter().zip(&self.parents).enumerate().map(|(joint, (bone, &parent))| match bone {
            None => Joint {
                name: "root".to_owned(),
                parent,
                offset: root.position,
                end: None,
                channels: root.channels.clone(),
                axis: Some(rest_axis(root.orientation, root.axis_letters, angle_unit)),
                bone: None,
            },
            Some(bone) => {
                let bone = &bones[*bone];
                let vector = |bone: &BoneData| bone.direction * bone.length;
                let parent_bone = parent.and_then(|parent| self.bone_of[parent]);
                Joint {
                    name: bone.name.clone(),
                    parent,
                    offset: parent_bone.map_or(DVec3::ZERO, |parent| vector(&bones[parent])),
                    end: (!has_children[joint]).then(|| vector(bone)),
                    channels: bone.channels.clone(),
                    axis: Some(rest_axis(bone.axis, bone.axis_letters, angle_unit)),
                    bone: Some(Bone { direction: bone.direction, length: bone.length }),
                }
            }
        });
        Skeleton { format: Format::Amc, joints: joints.collect(), angle_unit, position_rule: PositionRule::default() }
    }
}
