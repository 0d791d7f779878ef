//! Kinematics, roles, chains, units and skeleton ids on real captures.

use crate::plain_reader::{read_amc, read_bvh};
use crate::shared_data::{captures, reference, shared};
use glam::DVec3;
use motionmill::motion::bounds::{guess_unit_m, guess_up_axis, median_bone_lengths_mm};
use motionmill::motion::chains::raw_chains;
use motionmill::motion::folding::fold;
use motionmill::motion::kinematics::{file_pose_of_frame, plain_poses, pose_of_frame, poses};
use motionmill::motion::{
    BodyChain, BodyChains, Clip, NameTables, Notice, Role, RoleMap, RoleSource, Skeleton, UpAxis, assign_roles,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const CMU_UNIT_M: f64 = 0.0254 / 0.45;

fn tables() -> NameTables {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/skeletons");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let texts: Vec<(String, String)> = files
        .iter()
        .map(|file| {
            let name = file.file_stem().unwrap().to_str().unwrap().to_owned();
            (name, std::fs::read_to_string(file).unwrap())
        })
        .collect();
    NameTables::from_toml(&texts.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect::<Vec<_>>()).unwrap()
}

fn quirk(name: &str) -> Option<Clip> {
    Some(read_bvh(&shared()?.join("data/quirks").join(name), usize::MAX))
}

fn captured(file: &str, most_frames: usize) -> Option<Clip> {
    let file = captures()?.join(file);
    if file.extension().unwrap() == "bvh" {
        return Some(read_bvh(&file, most_frames));
    }
    let subject = file.file_stem().unwrap().to_str().unwrap().split('_').next().unwrap();
    Some(read_amc(&file.with_file_name(format!("{subject}.asf")), &file, most_frames))
}

fn roles_of(clip: &Clip, tables: &NameTables) -> (RoleMap, RoleSource, Vec<Notice>) {
    assign_roles(&clip.skeleton, tables, Some(&pose_of_frame(clip, 0)))
}

fn name_of(skeleton: &Skeleton, roles: &RoleMap, role: Role) -> String {
    let bare = |name: &str| name.rsplit(':').next().unwrap().to_owned();
    match roles.get(role) {
        None => "-".to_owned(),
        Some(joint) if joint < skeleton.joints.len() => bare(&skeleton.joints[joint].name),
        Some(point) => format!("{}.end", bare(&skeleton.joints[skeleton.ends()[point - skeleton.joints.len()]].name)),
    }
}

/// Every role's joint, in the order of [`Role::ALL`] but for the right side.
fn left_names(skeleton: &Skeleton, roles: &RoleMap) -> String {
    let left = Role::ALL.into_iter().filter(|role| !role.name().ends_with("right"));
    left.map(|role| name_of(skeleton, roles, role)).collect::<Vec<_>>().join(" ")
}

#[test]
fn every_family_is_known_by_its_names() {
    let tables = tables();
    let mixamo = "Hips Spine1 Spine2 Neck Head LeftShoulder LeftArm LeftForeArm LeftHand LeftUpLeg LeftLeg LeftFoot";
    for (file, table, left) in [
        ("skeleton-mixamo", "mixamo", format!("{mixamo} LeftToeBase")),
        ("skeleton-motionbuilder", "motionbuilder", format!("{mixamo} LeftToeBase")),
        ("skeleton-lafan1", "lafan1", format!("{mixamo} LeftToe")),
        (
            "skeleton-100style",
            "100style",
            "Hips Chest2 Chest3 Neck Head LeftCollar LeftShoulder LeftElbow LeftWrist LeftHip LeftKnee LeftAnkle LeftToe"
                .to_owned(),
        ),
        (
            "skeleton-daz",
            "daz",
            "hip abdomen chest neck head lCollar lShldr lForeArm lHand lThigh lShin lFoot lToe".to_owned(),
        ),
        (
            "skeleton-biped",
            "biped",
            "Bip01 _Spine1 _Spine2 _Neck _Head _L_Clavicle _L_UpperArm _L_Forearm _L_Hand _L_Thigh _L_Calf _L_Foot _L_Toe0"
                .replace(" _", " Bip01_"),
        ),
        (
            "skeleton-blender",
            "blender",
            "hips chest upper_chest neck head shoulder.L upper_arm.L forearm.L hand.L thigh.L shin.L foot.L toe.L".to_owned(),
        ),
        (
            "skeleton-bandai",
            "bandai-namco",
            "Hips Spine Chest Neck Head Shoulder_L UpperArm_L LowerArm_L Hand_L UpperLeg_L LowerLeg_L Foot_L Toes_L"
                .to_owned(),
        ),
    ] {
        let Some(clip) = quirk(&format!("{file}.bvh")) else { return };
        let (roles, source, notices) = roles_of(&clip, &tables);
        assert_eq!(source, RoleSource::ByNames(table.to_owned()), "{file}");
        let mut spaced = (*clip.skeleton).clone();
        spaced.joints.iter_mut().for_each(|joint| joint.name = joint.name.replace(' ', "_"));
        assert_eq!(left_names(&spaced, &roles), left, "{file}");
        assert!(notices.is_empty(), "{file}: {notices:?}");
        assert!(Role::ALL.into_iter().all(|role| roles.get(role).is_some()), "{file}");
        // The tree alone says the same.
        let (by_tree, source, _) = roles_of(&clip, &NameTables::default());
        assert_eq!((by_tree, source), (roles, RoleSource::ByTopology), "{file}");
    }
}

#[test]
fn captures_have_the_same_roles_by_names_and_by_their_tree() {
    let tables = tables();
    for (file, table, left) in [
        (
            "cmu/02/02_01.amc",
            "cmu-asf",
            "root upperback thorax lowerneck head lclavicle lhumerus lradius lwrist lfemur ltibia lfoot ltoes",
        ),
        (
            "cmu/03/03_01.amc",
            "cmu-asf",
            "root upperback thorax lowerneck head lclavicle lhumerus lradius lwrist lfemur ltibia lfoot ltoes",
        ),
        (
            "extra/cmu-bvh/01_01.bvh",
            "cgspeed",
            "Hips Spine Spine1 Neck Head LeftShoulder LeftArm LeftForeArm LeftHand LeftUpLeg LeftLeg LeftFoot LeftToeBase",
        ),
        (
            "extra/cmu-bvh/12_01.bvh",
            "cgspeed",
            "Hips Spine Spine1 Neck Head LeftShoulder LeftArm LeftForeArm LeftHand LeftUpLeg LeftLeg LeftFoot LeftToeBase",
        ),
        (
            "extra/cmu-bvh/131_01.bvh",
            "cgspeed-3dsmax",
            "Hips Chest Chest2 lowerneck Head LeftCollar LeftShoulder LeftElbow LeftWrist LeftHip LeftKnee LeftAnkle LeftToe",
        ),
        (
            "bandai-namco/dataset-1/dataset-1_walk_normal_001.bvh",
            "bandai-namco",
            "Hips Spine Chest Neck Head Shoulder_L UpperArm_L LowerArm_L Hand_L UpperLeg_L LowerLeg_L Foot_L Toes_L",
        ),
    ] {
        // Frame 1: the cgspeed files begin with a T-pose.
        let Some(clip) = captured(file, 2) else { return };
        let pose = pose_of_frame(&clip, 1);
        let (roles, source, notices) = assign_roles(&clip.skeleton, &tables, Some(&pose));
        assert_eq!(source, RoleSource::ByNames(table.to_owned()), "{file}");
        assert_eq!(left_names(&clip.skeleton, &roles), left, "{file}");
        assert!(notices.is_empty(), "{file}: {notices:?}");
        let by_tree = assign_roles(&clip.skeleton, &NameTables::default(), Some(&pose)).0;
        assert_eq!(left_names(&clip.skeleton, &by_tree), left, "{file} by its tree");
        assert_eq!(by_tree, roles, "{file}");
    }
}

#[test]
fn a_dog_is_not_taken_for_a_person() {
    let Some(clip) = quirk("skeleton-quadruped.bvh") else { return };
    for tables in [tables(), NameTables::default()] {
        let (roles, _, notices) = roles_of(&clip, &tables);
        assert!(!roles.has_feet());
        assert!(notices.iter().any(|notice| notice.kind == "quadruped"), "{notices:?}");
    }
}

#[test]
fn no_captured_person_is_taken_for_a_dog() {
    let Some(folder) = captures() else { return };
    let tables = tables();
    let mut files = files_below(&folder, "bvh");
    files.retain(|file| !file.to_str().unwrap().contains("dataset-2") || file.to_str().unwrap().contains("_001"));
    files.extend(files_below(&folder, "amc"));
    assert!(files.len() > 100);
    for file in files {
        let clip = captured(file.strip_prefix(&folder).unwrap().to_str().unwrap(), 1).unwrap();
        for tables in [&tables, &NameTables::default()] {
            let (roles, source, notices) = roles_of(&clip, tables);
            let found = Role::ALL.into_iter().filter(|&role| roles.get(role).is_some()).count();
            assert!(found == Role::COUNT, "{}: {found} roles, {source:?} {notices:?}", file.display());
        }
    }
}

#[test]
fn chains_are_those_of_the_reference() {
    let (Some(lines), Some(_)) = (reference("grafts.jsonl.xz"), captures()) else { return };
    let tables = tables();
    let mut compared = 0;
    for line in lines.lines() {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        if line["args"][0] != "chains" {
            continue;
        }
        let clip = captured(line["args"][1].as_str().unwrap(), 1).unwrap();
        let skeleton = &*clip.skeleton;
        let names = |joints: &[usize]| joints.iter().map(|&n| skeleton.joints[n].name.clone()).collect::<Vec<_>>();
        // As sets: the reference's order follows its reader's order of joints.
        let found: BTreeSet<Vec<String>> = raw_chains(skeleton).iter().map(|chain| names(chain)).collect();
        let wanted: BTreeSet<Vec<String>> = serde_json::from_value(line["out"]["chains"].clone()).unwrap();
        assert_eq!(found, wanted, "{line}");
        let pose = pose_of_frame(&clip, 0);
        let folded = fold(skeleton, &pose).unwrap();
        assert!(folded.notices.is_empty());
        let by_roles = BodyChains::of_roles(skeleton, &roles_of(&clip, &tables).0).unwrap();
        let wanted: BTreeMap<String, BTreeSet<String>> = serde_json::from_value(line["out"]["roles"].clone()).unwrap();
        for chains in [folded.chains, by_roles] {
            let mut found = BTreeMap::from([("pelvis".to_owned(), BTreeSet::from_iter(names(&chains.pelvis)))]);
            for chain in BodyChain::ALL {
                found.insert(chain.name().to_owned(), BTreeSet::from_iter(names(chains.joints(chain))));
            }
            assert_eq!(found, wanted, "{line}");
        }
        compared += 1;
    }
    assert_eq!(compared, 3);
}

#[test]
fn positions_are_those_of_the_reference() {
    let Some(_) = captures() else { return };
    for (file, stored, unit_m) in [
        ("cmu/02/02_01.amc", "cmu.02_01", CMU_UNIT_M),
        ("cmu/01/01_14.amc", "cmu.01_14", CMU_UNIT_M),
        ("extra/cmu-bvh/12_01.bvh", "extra.12_01", CMU_UNIT_M),
        ("bandai-namco/dataset-1/dataset-1_dash_normal_001.bvh", "bandai-namco.dataset-1_dash_normal_001", 0.01),
        ("bandai-namco/dataset-2/dataset-2_run_active_005.bvh", "bandai-namco.dataset-2_run_active_005", 0.01),
    ] {
        let mut clip = captured(file, usize::MAX).unwrap();
        clip.unit_m = unit_m;
        let fast = poses(&clip);
        let plain = plain_poses(&clip);
        let apart = fast.world.iter().zip(&plain.world).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(apart < 1e-12, "{file}: fast and plain differ by {apart}");
        let skeleton = &*clip.skeleton;
        let mut compared = 0;
        for row in reference(&format!("{stored}.csv.xz")).unwrap().lines().skip(1) {
            let cells: Vec<&str> = row.split(',').collect();
            let number = |n: usize| cells[n].parse::<f64>().unwrap();
            let by_name = |name: &str| skeleton.joints.iter().position(|joint| joint.name == name);
            let end_of = |joint| {
                let nth = skeleton.ends().iter().position(|&leaf| leaf == joint);
                skeleton.joints.len() + nth.unwrap()
            };
            let point = match cells[1].strip_suffix("_End") {
                Some(leaf) => end_of(by_name(leaf).unwrap()),
                None => {
                    let joint = by_name(cells[1]).unwrap();
                    let child = skeleton.joints.iter().position(|other| other.parent == Some(joint));
                    // The reference's Acclaim joint is the bone's far end.
                    if skeleton.joints[joint].bone.is_none() { joint } else { child.unwrap_or_else(|| end_of(joint)) }
                }
            };
            let wanted = DVec3::new(number(2), number(3), number(4));
            let distance = fast.at(cells[0].parse().unwrap(), point).distance(wanted);
            assert!(distance < 1e-5, "{file} {row}: {distance} m away");
            compared += 1;
        }
        assert!(compared >= 5 * skeleton.joints.len(), "{file}: {compared}");
    }
}

#[test]
fn units_are_guessed_by_the_size_of_the_body() {
    let tables = tables();
    let mut seen = 0;
    for (file, wanted) in [
        ("extra/cmu-bvh/131_01.bvh", CMU_UNIT_M),
        ("extra/cmu-bvh/01_01.bvh", CMU_UNIT_M),
        ("extra/cmu-bvh/131_01-metres.bvh", 1.0),
        ("bandai-namco/dataset-1/dataset-1_walk_normal_001.bvh", 0.01),
        ("bandai-namco/dataset-2/dataset-2_walk_active_001.bvh", 0.01),
        ("skeleton-mixamo.bvh", 0.01),
        ("skeleton-z-up.bvh", 0.01),
        ("skeleton-quadruped.bvh", 0.01),
    ] {
        let clip = if file.contains('/') { captured(file, 20) } else { quirk(file) };
        let Some(clip) = clip else { return };
        let roles = assign_roles(&clip.skeleton, &tables, Some(&file_pose_of_frame(&clip, 0))).0;
        let (unit_m, notice) = guess_unit_m(&clip, &roles);
        assert_eq!(unit_m, wanted, "{file}: {}", notice.message);
        let up = guess_up_axis(&clip, &roles).0;
        assert_eq!(up, if file == "skeleton-z-up.bvh" { UpAxis::Z } else { UpAxis::Y }, "{file}");
        seen += 1;
    }
    assert_eq!(seen, 8);
}

#[test]
fn one_bandai_body_has_few_skeleton_ids() {
    let Some(folder) = captures() else { return };
    let tables = tables();
    let mut files = files_below(&folder.join("bandai-namco"), "bvh");
    // All of dataset-1; of dataset-2 what has 1 in its number, from every content and style.
    files.retain(|file| !file.to_str().unwrap().contains("dataset-2") || file.to_str().unwrap().ends_with("1.bvh"));
    assert!(files.len() > 250, "{}", files.len());
    let mut ids: BTreeMap<String, usize> = BTreeMap::new();
    let mut by_offsets: BTreeSet<String> = BTreeSet::new();
    for file in files {
        let mut clip = read_bvh(&file, 40);
        clip.unit_m = 0.01;
        let roles = roles_of(&clip, &tables).0;
        let lengths = median_bone_lengths_mm(&clip, &poses(&clip), &roles);
        *ids.entry(clip.skeleton.skeleton_id(&lengths)).or_default() += 1;
        by_offsets.insert(format!("{:?}", clip.skeleton.joints.iter().map(|joint| joint.offset).collect::<Vec<_>>()));
    }
    assert!(by_offsets.len() >= 5, "the offsets tell {} bodies apart", by_offsets.len());
    assert_eq!(ids.len(), 1, "{ids:?}");
}

fn files_below(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|found| found == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}
