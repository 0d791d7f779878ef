//! Roles by joint names: the tables of `configs/skeletons`, one a family of skeletons.
//!
//! A table lists the names that each role goes by, the preferred one first. Names match without regard to case,
//! to the separator (`upper_arm.L` is `Upper Arm L`), and to a namespace before `:` or `|`.

use super::roles::{Role, RoleMap};
use super::skeleton::Skeleton;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The joint names of one family of skeletons.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NameTable {
    /// What every name begins with, up to digits and a separator: `Bip` stands for `Bip01 `, `Bip001_` ...; an
    /// empty name is the prefix alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prefix: Option<String>,
    /// Joints without a role that a skeleton of the family has; without them the table is passed over. For families
    /// whose names are part of another's.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub needs: Vec<String>,
    /// Names of each role, the preferred one first. A joint that has a role already is passed over.
    pub joints: BTreeMap<Role, Vec<String>>,
}

/// Tables by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NameTables {
    tables: BTreeMap<String, NameTable>,
}

/// Why a name table can't be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NameTableError {
    /// Not TOML, an unknown field, or an unknown role.
    #[error("skeleton table `{table}`: {message}")]
    Unreadable {
        /// Its name.
        table: String,
        /// The parser's words, with line and column.
        message: String,
    },
    /// A role without which a table never wins.
    #[error("skeleton table `{table}`: no names for `{role}`; a table needs the hips and both legs down to the ankles")]
    Incomplete {
        /// Its name.
        table: String,
        /// What it lacks.
        role: &'static str,
    },
    /// Two tables of one name.
    #[error("skeleton table `{table}` is given twice")]
    Twice {
        /// Its name.
        table: String,
    },
}

impl NameTables {
    /// Tables from (name, TOML text).
    ///
    /// # Errors
    /// A text that is no table, lacks a leg, or a name given twice.
    pub fn from_toml(texts: &[(&str, &str)]) -> Result<NameTables, NameTableError> {
        let mut tables = NameTables::default();
        for &(name, text) in texts {
            let table = toml::from_str::<NameTable>(text).map_err(|error| NameTableError::Unreadable {
                table: name.to_owned(),
                message: error.to_string().trim_end().to_owned(),
            })?;
            if let Some(role) = Role::FEET.into_iter().find(|role| !table.joints.contains_key(role)) {
                return Err(NameTableError::Incomplete { table: name.to_owned(), role: role.name() });
            }
            if tables.tables.insert(name.to_owned(), table).is_some() {
                return Err(NameTableError::Twice { table: name.to_owned() });
            }
        }
        Ok(tables)
    }

    /// The table that names most joints, and the roles it gives; of equal ones the first by name. None where no
    /// table finds the hips and both legs, each joint below the one before.
    pub fn best(&self, skeleton: &Skeleton) -> Option<(&str, RoleMap)> {
        let mut best: Option<(usize, &str, RoleMap)> = None;
        for (name, table) in &self.tables {
            let Some(roles) = table.roles(skeleton) else { continue };
            let named = Role::ALL.into_iter().filter(|&role| roles.get(role).is_some()).count();
            if best.as_ref().is_none_or(|(most, _, _)| named > *most) {
                best = Some((named, name, roles));
            }
        }
        best.map(|(_, name, roles)| (name, roles))
    }
}

impl NameTable {
    /// The roles that this table gives, if it finds the hips and both legs.
    fn roles(&self, skeleton: &Skeleton) -> Option<RoleMap> {
        let mut joint_of_name = BTreeMap::new();
        for (index, joint) in skeleton.joints.iter().enumerate() {
            if let Some(name) = self.bare_name(&joint.name) {
                joint_of_name.entry(name).or_insert(index);
            }
        }
        if !self.needs.iter().all(|name| joint_of_name.contains_key(&normal(name))) {
            return None;
        }
        let mut roles = RoleMap::default();
        // The chest before the spine: it is the highest of several spine joints, the spine the next one.
        let mut order = Role::ALL;
        order.sort_by_key(|&role| role == Role::Spine);
        for role in order {
            let names = self.joints.get(&role).map_or(&[][..], Vec::as_slice);
            let free = |name: &String| {
                joint_of_name.get(&normal(name)).copied().filter(|&joint| roles.of_point(joint).is_none())
            };
            if let Some(joint) = names.iter().find_map(free) {
                roles.set(role, joint);
            }
        }
        (roles.has_feet() && limbs_hang_together(skeleton, &roles)).then_some(roles)
    }

    /// A joint's name without namespace and prefix, in normal form; None where the prefix is missing.
    fn bare_name(&self, name: &str) -> Option<String> {
        let inner = normal(name.rsplit([':', '|']).next().unwrap_or(name));
        let Some(prefix) = &self.prefix else { return Some(inner) };
        let prefix = normal(prefix);
        let strip = |name: &str| {
            let rest = name.strip_prefix(&prefix)?.trim_start_matches(|c: char| c.is_ascii_digit());
            if rest.is_empty() { Some(String::new()) } else { rest.strip_prefix('_').map(str::to_owned) }
        };
        strip(&normal(name)).or_else(|| strip(&inner))
    }
}

/// Lower case, with `_` for every run of separators.
fn normal(name: &str) -> String {
    let mut out = String::with_capacity(name.len());
    for letter in name.chars() {
        if !matches!(letter, ' ' | '_' | '.' | '-' | ':' | '|') {
            out.extend(letter.to_lowercase());
        } else if !out.ends_with('_') && !out.is_empty() {
            out.push('_');
        }
    }
    out
}

/// Whether each joint of a limb lies below the one before: what tells a body from a list of like names.
fn limbs_hang_together(skeleton: &Skeleton, roles: &RoleMap) -> bool {
    use Role::*;
    let limbs = [
        [Hips, ThighLeft, KneeLeft, AnkleLeft, ToeLeft],
        [Hips, ThighRight, KneeRight, AnkleRight, ToeRight],
        [Hips, ClavicleLeft, ShoulderLeft, ElbowLeft, WristLeft],
        [Hips, ClavicleRight, ShoulderRight, ElbowRight, WristRight],
        [Hips, Spine, Chest, Neck, Head],
    ];
    let is_below = |mut joint: usize, above: usize| {
        while let Some(parent) = skeleton.joints[joint].parent {
            if parent == above {
                return true;
            }
            joint = parent;
        }
        false
    };
    limbs.iter().all(|limb| {
        let joints: Vec<usize> = limb.iter().filter_map(|&role| roles.get(role)).collect();
        joints.windows(2).all(|pair| is_below(pair[1], pair[0]))
    })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::motion::sample_bodies::{named_body, shipped_tables};

    const LEGS: &str = r#"
        hips = ["Hips"]
        thigh_left = ["LT"]
        knee_left = ["LK"]
        ankle_left = ["LA"]
        thigh_right = ["RT"]
        knee_right = ["RK"]
        ankle_right = ["RA"]
    "#;

    fn table(before: &str, after: &str) -> String {
        format!("{before}\n[joints]\n{LEGS}\n{after}")
    }

    #[test]
    fn names_match_without_case_separator_and_namespace() {
        let tables = NameTables::from_toml(&[("one", &table("", ""))]).unwrap();
        for form in ["LT", "lt", "Actor01:LT", "a|b:Lt"] {
            let body = named_body(&format!("Hips({form}(LK(LA)) RT(RK(RA)))"));
            assert_eq!(tables.best(&body).unwrap().1.get(Role::ThighLeft), Some(1), "{form}");
        }
        assert!(tables.best(&named_body("Hips(LTx(LK(LA)) RT(RK(RA)))")).is_none());
        assert_eq!(normal("Upper Arm.L"), normal("upper_arm--l"));
    }

    #[test]
    fn a_prefix_is_needed_and_taken_off() {
        let text = table("prefix = \"Bip\"", "").replace("\"Hips\"", "\"Pelvis\", \"\"");
        let tables = NameTables::from_toml(&[("one", &text)]).unwrap();
        let body = |hips: &str, p: &str| named_body(&format!("{hips}({p}LT({p}LK({p}LA)) {p}RT({p}RK({p}RA)))"));
        assert_eq!(tables.best(&body("Bip01", "Bip01_")).unwrap().1.get(Role::Hips), Some(0));
        assert!(tables.best(&body("x:Bip001_Pelvis", "x:Bip001_")).is_some());
        assert!(tables.best(&body("Bip01", "Bipod_")).is_none());
        assert!(tables.best(&body("Bip01", "")).is_none());
    }

    #[test]
    fn a_table_is_passed_over_without_the_joints_it_needs() {
        let text = table("needs = [\"Low Back\"]", "");
        let tables = NameTables::from_toml(&[("one", &text)]).unwrap();
        assert!(tables.best(&named_body("Hips(LT(LK(LA)) RT(RK(RA)))")).is_none());
        assert!(tables.best(&named_body("Hips(LT(LK(LA)) RT(RK(RA)) low_back)")).is_some());
    }

    #[test]
    fn the_table_that_names_most_wins_then_the_first_by_name() {
        let tables = NameTables::from_toml(&[
            ("c-more", &table("", "head = [\"Top\"]")),
            ("b-equal", &table("", "")),
            ("a-equal", &table("", "")),
        ])
        .unwrap();
        assert_eq!(tables.best(&named_body("Hips(LT(LK(LA)) RT(RK(RA)) Top)")).unwrap().0, "c-more");
        assert_eq!(tables.best(&named_body("Hips(LT(LK(LA)) RT(RK(RA)))")).unwrap().0, "a-equal");
    }

    #[test]
    fn names_that_do_not_hang_together_are_no_body() {
        let tables = NameTables::from_toml(&[("one", &table("", ""))]).unwrap();
        assert!(tables.best(&named_body("Hips(LT(LK(LA)) RT(RK) RA)")).is_none());
        assert!(tables.best(&named_body("LT(LK(LA(RT(RK(RA)) Hips)))")).is_none());
    }

    #[test]
    fn the_chest_is_the_highest_spine_joint_and_the_spine_the_next() {
        let tables = NameTables::from_toml(&[(
            "one",
            &table("", "chest = [\"S3\", \"S2\", \"S1\"]\nspine = [\"S3\", \"S2\", \"S1\"]"),
        )])
        .unwrap();
        let roles = |body: &str| tables.best(&named_body(body)).unwrap().1;
        let three = roles("Hips(LT(LK(LA)) RT(RK(RA)) S1(S2(S3)))");
        assert_eq!((three.get(Role::Spine), three.get(Role::Chest)), (Some(8), Some(9)));
        let one = roles("Hips(LT(LK(LA)) RT(RK(RA)) S1)");
        assert_eq!((one.get(Role::Spine), one.get(Role::Chest)), (None, Some(7)));
    }

    #[test]
    fn tables_that_cannot_be_used_say_why() {
        let unknown = NameTables::from_toml(&[("x", &table("", "tail = [\"Tail\"]"))]).unwrap_err().to_string();
        assert!(unknown.contains("`x`") && unknown.contains("tail") && unknown.contains("line"), "{unknown}");
        let no_leg = table("", "").replace("ankle_left = [\"LA\"]", "");
        let incomplete = NameTables::from_toml(&[("x", &no_leg)]).unwrap_err();
        assert_eq!(incomplete, NameTableError::Incomplete { table: "x".to_owned(), role: "ankle_left" });
        let twice = [("x", table("", "")), ("x", table("", ""))];
        let twice = NameTables::from_toml(&twice.each_ref().map(|(name, text)| (*name, text.as_str()))).unwrap_err();
        assert_eq!(twice, NameTableError::Twice { table: "x".to_owned() });
    }

    #[test]
    fn shipped_tables_name_every_role() {
        for (name, table) in &shipped_tables().tables {
            let missing: Vec<_> = Role::ALL.into_iter().filter(|role| !table.joints.contains_key(role)).collect();
            assert!(missing.is_empty(), "{name}: {missing:?}");
        }
    }
}
