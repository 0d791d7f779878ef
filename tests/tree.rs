//! The cluster tree and graph of captured frames.

use crate::{bandai, shared_data};
use glam::DVec3;
use motionmill::annotate::features::features;
use motionmill::annotate::samples::samples;
use motionmill::annotate::{self, PlantState, annotate};
use motionmill::cluster::graph::{ClipRuns, PlacedSample, runs};
use motionmill::cluster::{
    AlignmentRule, Cut, Merge, Metric, Node, Sample, Settings, StateCut, Vector, align, components, cut, error_m2,
    first_nodes, frame_ranges, graph, medoids, nodes, tree,
};
use motionmill::motion::{Poses, RoleMap};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Some clips of the second Bandai-Namco set, evenly chosen among those whose name contains a word.
fn some_clips(word: &str, n: usize) -> Vec<(Poses, RoleMap)> {
    let Some(data) = shared_data::captures() else { return Vec::new() };
    let folder = data.join("bandai-namco/dataset-2");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.to_string_lossy().contains(word) && file.extension().is_some_and(|end| end == "bvh"));
    files.sort();
    files.iter().step_by((files.len() / n).max(1)).take(n).map(|file| bandai::read(file)).collect()
}

/// The canonical vectors of all frames, clip after clip; at most `n`, no two equal.
fn distinct_vectors(clips: &[(Poses, RoleMap)], n: usize) -> Vec<Vector> {
    let metric = Metric::new(&Settings::default()).unwrap();
    let mut seen = BTreeSet::new();
    let mut vectors = Vec::new();
    for (poses, roles) in clips {
        let frames: Vec<u32> = (0..poses.n_frames as u32).collect();
        let of_clip = metric.vectors(&features(poses, roles, bandai::RATE_HZ), &frames).unwrap();
        vectors.extend(of_clip.into_iter().filter(|vector| seen.insert(vector.0.map(f32::to_bits))));
    }
    vectors.truncate(n);
    vectors
}

#[test]
fn no_live_pair_is_ever_closer_than_the_one_that_merges() {
    let vectors = distinct_vectors(&some_clips("", 12), 1200);
    if vectors.is_empty() {
        return;
    }
    assert_eq!(vectors.len(), 1200);
    let merges = tree(vectors.clone(), &Settings::default()).unwrap();
    assert!(merges.len() > 1100, "{}", merges.len());
    let mut items: BTreeMap<u32, (Vector, u32)> = (0..).zip(vectors.iter().map(|&vector| (vector, 1))).collect();
    // Every live pair by (E, lower, higher), as a set: what is least is at its front.
    let mut pairs: BTreeSet<(u64, u32, u32)> = BTreeSet::new();
    let key = |a: (&u32, &(Vector, u32)), b: (&u32, &(Vector, u32))| {
        (error_m2(&a.1.0, &b.1.0).to_bits(), *a.0.min(b.0), *a.0.max(b.0))
    };
    for item in &items {
        pairs.extend(items.range(..item.0).map(|other| key(item, other)));
    }
    for merge in &merges {
        assert_eq!(pairs.first(), Some(&(merge.e.to_bits(), merge.a, merge.b)));
        let parts = [merge.a, merge.b].map(|part| (part, items[&part]));
        for (part, of_part) in &parts {
            for other in &items {
                pairs.remove(&key((part, of_part), other));
            }
        }
        let [(_, (a, n_a)), (_, (b, n_b))] = parts;
        items.remove(&merge.a);
        items.remove(&merge.b);
        let mean = |lane: usize| {
            let sum = f64::from(n_a) * f64::from(a.0[lane]) + f64::from(n_b) * f64::from(b.0[lane]);
            (sum / f64::from(n_a + n_b)) as f32
        };
        let made = (Vector(std::array::from_fn(mean)), n_a + n_b);
        pairs.extend(items.iter().map(|other| key((&merge.item, &made), other)));
        items.insert(merge.item, made);
        assert_eq!(merge.members, made.1);
    }
    let least = pairs.first().map_or(f64::INFINITY, |pair| f64::from_bits(pair.0));
    assert!(least >= Settings::default().t_max_m2, "stopped early, at {least}");
}

#[test]
fn equals_scipys_centroid_linkage() {
    let Some(python) = shared_data::peers_python() else { return };
    let vectors = distinct_vectors(&some_clips("", 40), 3000);
    if vectors.is_empty() {
        return;
    }
    assert_eq!(vectors.len(), 3000);
    let merges = tree(vectors.clone(), &Settings::default()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let [rows, log] = ["vectors.f32", "merges.json"].map(|name| folder.path().join(name));
    let bytes: Vec<u8> = vectors.iter().flat_map(|vector| vector.0).flat_map(f32::to_le_bytes).collect();
    std::fs::write(&rows, bytes).unwrap();
    let list: Vec<_> = merges.iter().map(|m| (m.item, m.a, m.b, m.e, m.members)).collect();
    std::fs::write(&log, serde_json::to_string(&list).unwrap()).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers/centroid_linkage.py");
    let output = Command::new(python).arg(script).args([&rows, &log]).output().unwrap();
    let said = [output.stdout, output.stderr].map(|said| String::from_utf8_lossy(&said).into_owned()).concat();
    assert!(output.status.success(), "{said}");
    println!("{said}");
}

#[test]
fn where_and_which_way_a_motion_goes_does_not_matter() {
    let metric = Metric::new(&Settings::default()).unwrap();
    for (poses, roles) in some_clips("", 5) {
        // A turn by atan(3/4), a slide along the floor.
        let mut moved = poses.clone();
        for p in &mut moved.world {
            *p = DVec3::new(0.8 * p.x + 0.6 * p.z + 3.0, p.y, -0.6 * p.x + 0.8 * p.z - 7.0);
        }
        let frames: Vec<u32> = (0..poses.n_frames as u32).collect();
        let of = |poses: &Poses| metric.vectors(&features(poses, &roles, bandai::RATE_HZ), &frames).unwrap();
        let (here, there) = (of(&poses), of(&moved));
        let largest = here.iter().zip(&there).map(|(a, b)| error_m2(a, b)).fold(0.0, f64::max);
        assert!(largest < 1e-9, "{largest}");
        assert!(error_m2(&here[0], &here[frames.len() / 2]) > 1e-3);
    }
}

/// What the graph stage does with one plant state.
struct State {
    plant_state: PlantState,
    samples: Vec<Sample>,
    vectors: Vec<Vector>,
    merges: Vec<Merge>,
    cut: Cut,
}

/// Trees and cuts of all states of some clips, and each clip's plant states and samples.
type Labels = Vec<(Vec<Option<PlantState>>, Vec<u32>)>;

fn states_of(clips: &[(Poses, RoleMap)], threshold_m2: f64) -> (Vec<State>, Labels) {
    let settings = Settings::default();
    let metric = Metric::new(&settings).unwrap();
    let mut of_state: BTreeMap<PlantState, (Vec<Sample>, Vec<Vector>)> = BTreeMap::new();
    let mut labels = Vec::new();
    for ((poses, roles), clip_id) in clips.iter().zip(0..) {
        let states = annotate(poses, roles, bandai::RATE_HZ, &annotate::Settings::default()).frames.plant_state;
        let frames = samples(poses.n_frames, bandai::RATE_HZ, &states, Some(10.0));
        let vectors = metric.vectors(&features(poses, roles, bandai::RATE_HZ), &frames).unwrap();
        for (&frame, vector) in frames.iter().zip(vectors) {
            let of_state = of_state.entry(states[frame as usize].unwrap()).or_default();
            of_state.0.push(Sample { clip_id, frame });
            of_state.1.push(vector);
        }
        labels.push((states, frames));
    }
    let states = of_state.into_iter().map(|(plant_state, (samples, vectors))| {
        let merges = tree(vectors.clone(), &settings).unwrap();
        let cut = cut(vectors.len(), &merges, threshold_m2).unwrap();
        State { plant_state, samples, vectors, merges, cut }
    });
    (states.collect(), labels)
}

#[test]
fn the_graph_of_some_clips_adds_up() {
    let clips = some_clips("", 25);
    if clips.is_empty() {
        return;
    }
    let (states, labels) = states_of(&clips, 0.2);
    let first = first_nodes(&states.iter().map(|state| state.cut.n_nodes()).collect::<Vec<_>>()).unwrap();
    let mut node_of: BTreeMap<Sample, u32> = BTreeMap::new();
    for (state, &first) in states.iter().zip(&first) {
        let nodes = state.cut.nodes_of_samples();
        node_of.extend(state.samples.iter().copied().zip(nodes.into_iter().map(|node| first + node)));
    }
    let records: Vec<ClipRuns> = (0..)
        .zip(&labels)
        .map(|(clip_id, (states, samples))| {
            let placed: Vec<PlacedSample> = frame_ranges(states, samples)
                .into_iter()
                .zip(samples)
                .map(|(frames, &frame)| PlacedSample { frames, node: node_of[&Sample { clip_id, frame }] })
                .collect();
            ClipRuns { clip_id, runs: runs(&placed) }
        })
        .collect();
    let mut found = graph(&records);
    let numbers: Vec<u32> = found.visits.iter().map(|visits| visits.node).collect();
    let components = components(&numbers, &found.edges);
    let mut rows: Vec<Node> = Vec::new();
    for (state, &first_node) in states.iter().zip(&first) {
        let central = medoids(&state.vectors, &state.cut);
        let cut = StateCut {
            cut: &state.cut,
            first_node,
            samples: &state.samples,
            vectors: &state.vectors,
            medoids: &central,
        };
        align(&mut found.sequences, cut, AlignmentRule::Medoid);
        rows.extend(nodes("body", state.plant_state, cut, &state.merges, &found.visits, &components));
    }

    // Every frame of every clip lies in one sequence, of a node of its own plant state.
    let mut covered: Vec<Vec<u32>> = labels.iter().map(|(states, _)| vec![0; states.len()]).collect();
    for sequence in &found.sequences {
        let (clip, row) = (sequence.clip_id as usize, &rows[sequence.node as usize]);
        for frame in sequence.first..sequence.end {
            covered[clip][frame as usize] += 1;
            assert_eq!(labels[clip].0[frame as usize], Some(row.plant_state), "{sequence:?}");
        }
        let aligned = sequence.alignment_frame.unwrap();
        assert!((sequence.first..sequence.end).contains(&aligned) && labels[clip].1.contains(&aligned));
    }
    assert!(covered.iter().flatten().all(|&n| n == 1));
    // A clip of m sequences makes m - 1 transitions.
    let transitions: u32 = found.edges.iter().map(|edge| edge.transitions).sum();
    assert_eq!(transitions as usize, found.sequences.len() - clips.len());
    let members: u32 = rows.iter().map(|row| row.members).sum();
    assert_eq!(members as usize, node_of.len());
    for (number, row) in rows.iter().enumerate() {
        assert_eq!((row.node, node_of[&row.medoid]), (number as u32, number as u32));
        assert!(row.clips > 0 && row.radius2 <= row.max_radius2 + 1e-9 && row.component <= row.node);
    }
    // Something is shared: otherwise the clips would merely lie side by side.
    assert!(rows.iter().filter(|row| row.clips > 2).count() > 10);
    let mut reverse = records;
    reverse.reverse();
    assert_eq!(graph(&reverse).edges, found.edges);
}

#[test]
fn a_walk_cycle_falls_into_five_to_ten_nodes() {
    // DESIGN 6; FEASIBILITY 1 counts 8.3 with another detector of plants, each clip for itself.
    let mut counts = Vec::new();
    for clip in some_clips("_walk_", 20) {
        let metric = Metric::new(&Settings::default()).unwrap();
        let (poses, roles) = &clip;
        let frames: Vec<u32> = (0..poses.n_frames as u32).collect();
        let vectors = metric.vectors(&features(poses, roles, bandai::RATE_HZ), &frames).unwrap();
        let states = annotate(poses, roles, bandai::RATE_HZ, &annotate::Settings::default()).frames.plant_state;
        let mut node_of_frame = vec![(None, 0); frames.len()];
        for plant_state in PlantState::ALL {
            let own: Vec<usize> = (0..frames.len()).filter(|&frame| states[frame] == Some(plant_state)).collect();
            let own_vectors: Vec<Vector> = own.iter().map(|&frame| vectors[frame]).collect();
            let merges = tree(own_vectors.clone(), &Settings::default()).unwrap();
            let nodes = cut(own.len(), &merges, 0.5).unwrap().nodes_of_samples();
            for (frame, node) in own.into_iter().zip(nodes) {
                node_of_frame[frame] = (Some(plant_state), node);
            }
        }
        let middle = frames.len() / 2;
        let cycle: BTreeSet<_> = node_of_frame[middle - 14..middle + 14].iter().collect();
        counts.push(cycle.len());
    }
    counts.sort_unstable();
    if let Some(median) = counts.get(counts.len() / 2) {
        assert!((5..=10).contains(median), "{counts:?}");
    }
}
