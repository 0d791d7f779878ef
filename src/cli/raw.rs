//! A skeleton as it is: joints, roles, channels, kinematic chains.

use super::table::{Side, Table};
use crate::corpus::SkeletonRow;
use crate::motion::Role;
use crate::motion::chains::{BodyChain, BodyChains, raw_chains};
use serde_json::{Value, json};

/// Joints, then the chains of the body, then those of T 5.2.
pub(super) fn text(skeleton: &SkeletonRow) -> String {
    let body = &skeleton.body;
    let mut table = Table::new(&[
        ("", Side::Right),
        ("joint", Side::Left),
        ("parent", Side::Left),
        ("role", Side::Left),
        ("offset, file units", Side::Left),
        ("channels", Side::Left),
    ]);
    for (index, joint) in body.joints.iter().enumerate() {
        let channels: Vec<String> = joint.channels.iter().map(|channel| channel.name()).collect();
        table.row([
            index.to_string(),
            joint.name.clone(),
            joint.parent.map_or(String::new(), |parent| body.joints[parent].name.clone()),
            skeleton.roles.of_point(index).map_or("", Role::name).to_owned(),
            joint.offset.to_array().map(|part| format!("{part:.4}")).join(" "),
            channels.join(" "),
        ]);
    }
    let mut text = table.text();
    for (point, joint) in (body.joints.len()..).zip(body.ends()) {
        if let Some(role) = skeleton.roles.of_point(point) {
            text.push_str(&format!("  the end of {} is {}\n", body.joints[joint].name, role.name()));
        }
    }
    text.push_str("\nchains of the body\n");
    match BodyChains::of_roles(body, &skeleton.roles) {
        None => text.push_str("  none: hips, thighs or shoulders have no role, or don't lie as a body's\n"),
        Some(chains) => {
            let named = BodyChain::ALL.map(|chain| (chain.name(), chains.joints(chain)));
            for (name, joints) in [("pelvis", chains.pelvis.as_slice())].into_iter().chain(named) {
                text.push_str(&format!("  {name:<11}{}\n", names(skeleton, joints).join(" ")));
            }
        }
    }
    text.push_str("\nkinematic chains (from branch to branch or leaf)\n");
    for chain in raw_chains(body) {
        text.push_str(&format!("  {}\n", names(skeleton, &chain).join(" ")));
    }
    text
}

/// The same for programs.
pub(super) fn json(skeleton: &SkeletonRow) -> Value {
    let body = &skeleton.body;
    let joints: Vec<Value> = body
        .joints
        .iter()
        .enumerate()
        .map(|(index, joint)| {
            json!({
                "name": joint.name, "parent": joint.parent, "role": skeleton.roles.of_point(index).map(Role::name),
                "offset": joint.offset.to_array(), "end": joint.end.map(|end| end.to_array()),
                "channels": joint.channels.iter().map(|channel| channel.name()).collect::<Vec<_>>(),
            })
        })
        .collect();
    let chains = BodyChains::of_roles(body, &skeleton.roles).map(|chains| {
        let named = BodyChain::ALL.map(|chain| (chain.name().to_owned(), json!(chains.joints(chain))));
        named.into_iter().chain([("pelvis".to_owned(), json!(chains.pelvis))]).collect::<serde_json::Map<_, _>>()
    });
    json!({
        "skeleton": skeleton.skeleton_id, "format": body.format.name(), "joints": joints,
        "channels": body.channel_names(), "body_chains": chains, "raw_chains": raw_chains(body),
        "header": skeleton.header,
    })
}

fn names<'a>(skeleton: &'a SkeletonRow, joints: &[usize]) -> Vec<&'a str> {
    joints.iter().map(|&joint| skeleton.body.joints[joint].name.as_str()).collect()
}
