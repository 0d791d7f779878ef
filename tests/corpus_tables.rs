//! Every table of a corpus: what is written is read back, under the names and types that SCHEMA promises.

use crate::corpus_samples::{Dice, all_tables, clip_row, commit, fault_row, sample_clips, skeleton_row};
use crate::shared_data::peers_python;
use motionmill::annotate::PlantState;
use motionmill::cluster::{Edge, Merge, Node, Sample, Sequence};
use motionmill::corpus::*;
use motionmill::motion::RoleMap;
use motionmill::synthesis::{Figure, Made, Recipe};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use proptest::prelude::*;
use std::fs::File;

fn store() -> (tempfile::TempDir, Store) {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::new(folder.path());
    (folder, store)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_shard_is_read_back(seed in any::<u64>(), n_clips in 1usize..6, max_frames in 1usize..40) {
        let (_folder, store) = store();
        let clips = sample_clips(seed, n_clips, max_frames);
        let record = commit(&store, ShardId::captured(0), &clips, all_tables());
        let read = read_record(&store, ShardId::captured(0)).unwrap().unwrap();
        prop_assert_eq!(&read, &record);
        let catalog = Catalog::open(&store).unwrap();
        for clip in &clips {
            let id = clip.row.clip_id;
            let shard = catalog.shard_of(id).unwrap();
            let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&shard.channels(id).unwrap()), bits(&clip.channels));
            prop_assert_eq!(shard.poses(id).unwrap(), clip.poses.clone());
            prop_assert_eq!(shard.labels(id).unwrap(), clip.labels.clone());
            prop_assert_eq!(shard.features(id).unwrap(), clip.features.clone());
            prop_assert_eq!(shard.plants(id).unwrap(), clip.plants.clone());
            prop_assert_eq!(shard.segments(id).unwrap(), clip.segments.clone());
            prop_assert_eq!(shard.provenance(id).unwrap(), clip.provenance.clone());
            let motion = shard.motion(id).unwrap();
            prop_assert_eq!(&*motion.skeleton, &clip.skeleton.body);
            prop_assert_eq!((motion.rate_hz, motion.unit_m, motion.up), (clip.row.rate_hz, clip.row.unit_m, clip.row.up_axis));
        }
        let shard = catalog.shards().next().unwrap();
        let streamed: Vec<_> = shard.all_features().unwrap().map(Result::unwrap).collect();
        let with = clips.iter().filter(|clip| !clip.features.effectors.is_empty());
        prop_assert_eq!(streamed, with.map(|clip| (clip.row.clip_id, clip.features.clone())).collect::<Vec<_>>());
        let streamed: Vec<_> = shard.all_labels().unwrap().map(Result::unwrap).collect();
        let with = clips.iter().filter_map(|clip| Some((clip.row.clip_id, clip.labels.clone()?)));
        prop_assert_eq!(streamed, with.collect::<Vec<_>>());
        prop_assert!(catalog.shard_of(0).is_err());
    }

    #[test]
    fn tables_over_the_corpus_are_read_back(seed in any::<u64>(), n in 0usize..50) {
        let (_folder, store) = store();
        let notes = FileNotes::new();
        let mut dice = Dice(seed);
        let state = dice.pick(&PlantState::ALL);

        let clips: Vec<ClipRow> = (0..n as u32).map(|id| clip_row(&mut dice, 2 * id)).collect();
        write_clips(&store, &clips, &notes).unwrap();
        prop_assert_eq!(read_clips(&store).unwrap(), clips);

        let skeletons: Vec<SkeletonRow> = (0..n.min(8)).map(|_| skeleton_row(&mut dice)).collect();
        write_skeletons(&store, &skeletons, &notes).unwrap();
        prop_assert_eq!(read_skeletons(&store).unwrap(), skeletons);

        let faults: Vec<FaultRow> = (0..n).map(|_| fault_row(&mut dice)).collect();
        write_faults(&store, &faults, &notes).unwrap();
        prop_assert_eq!(read_faults(&store).unwrap(), faults);

        let mut number = || dice.next() as u32;
        let items: Vec<Sample> = (0..n).map(|_| Sample { clip_id: number(), frame: number() }).collect();
        write_items(&store, "body", state, &items, &notes).unwrap();
        prop_assert_eq!(read_items(&store, "body", state).unwrap(), items);

        let edges: Vec<Edge> = (0..n)
            .map(|_| Edge { from_node: number(), to_node: number(), transitions: number(), clips: number() })
            .collect();
        write_edges(&store, &edges, &notes).unwrap();
        prop_assert_eq!(read_edges(&store).unwrap(), edges);

        let merges: Vec<Merge> = (0..n)
            .map(|_| Merge {
                item: dice.next() as u32,
                a: dice.next() as u32,
                b: dice.next() as u32,
                e: dice.f64(),
                members: dice.next() as u32,
                radius2: dice.f64(),
            })
            .collect();
        write_merges(&store, "body", state, &merges, &notes).unwrap();
        prop_assert_eq!(read_merges(&store, "body", state).unwrap(), merges);

        let nodes: Vec<Node> = (0..n).map(|_| node(&mut dice)).collect();
        write_nodes(&store, &nodes, &notes).unwrap();
        prop_assert_eq!(read_nodes(&store).unwrap(), nodes);

        let sequences: Vec<Sequence> = (0..n).map(|_| sequence(&mut dice)).collect();
        write_sequences(&store, &sequences, &notes).unwrap();
        prop_assert_eq!(read_sequences(&store).unwrap(), sequences);

        let recipes: Vec<Recipe> = (0..n).map(|_| recipe(&mut dice)).collect();
        write_recipes(&store, &recipes, &notes).unwrap();
        prop_assert_eq!(read_recipes(&store).unwrap(), recipes);

        let made: Vec<Made> = (0..n).map(|_| made(&mut dice)).collect();
        write_made(&store, &made, &FIGURES, &notes).unwrap();
        prop_assert_eq!(read_made(&store).unwrap(), made);
    }

    #[test]
    fn a_damaged_file_is_an_error_or_other_rows_but_never_a_panic(seed in any::<u64>()) {
        let (_folder, store) = store();
        let mut dice = Dice(seed);
        let clips: Vec<ClipRow> = (0..30).map(|id| clip_row(&mut dice, id)).collect();
        write_clips(&store, &clips, &FileNotes::new()).unwrap();
        let whole = store.read(CLIPS).unwrap().unwrap();
        for _ in 0..20 {
            let mut bytes = whole.clone();
            match dice.below(3) {
                0 => bytes.truncate(dice.below(whole.len())),
                1 => (0..8).for_each(|_| bytes[dice.below(whole.len())] ^= 1 << dice.below(8)),
                _ => {
                    // The footer, where the lengths are.
                    let at = whole.len() - 1 - dice.below(whole.len().min(3000));
                    bytes[at] = dice.next() as u8;
                }
            }
            store.put_atomic(CLIPS, &bytes).unwrap();
            let _ = read_clips(&store);
        }
    }
}

#[test]
fn the_tables_open_elsewhere() {
    let Some(python) = peers_python() else { return };
    let (_folder, store) = store();
    let mut dice = Dice(6);
    for shard in [ShardId::captured(0), ShardId::captured(1), ShardId::made(0)] {
        let clips = sample_clips(shard.number.into(), 6, 3000);
        commit(&store, shard, &clips, all_tables());
    }
    let notes = FileNotes::from([("detector".to_owned(), "adaptive".to_owned())]);
    write_clips(&store, &(0..100).map(|id| clip_row(&mut dice, id)).collect::<Vec<_>>(), &notes).unwrap();
    write_skeletons(&store, &(0..9).map(|_| skeleton_row(&mut dice)).collect::<Vec<_>>(), &notes).unwrap();
    write_faults(&store, &(0..50).map(|_| fault_row(&mut dice)).collect::<Vec<_>>(), &notes).unwrap();
    write_nodes(&store, &(0..50).map(|_| node(&mut dice)).collect::<Vec<_>>(), &notes).unwrap();
    write_sequences(&store, &(0..50).map(|_| sequence(&mut dice)).collect::<Vec<_>>(), &notes).unwrap();
    write_edges(&store, &[], &notes).unwrap();
    write_recipes(&store, &(0..50).map(|_| recipe(&mut dice)).collect::<Vec<_>>(), &notes).unwrap();
    write_made(&store, &(0..50).map(|_| made(&mut dice)).collect::<Vec<_>>(), &FIGURES, &notes).unwrap();
    for state in [PlantState::LB, PlantState::N] {
        let items: Vec<Sample> = (0..70_000).map(|frame| Sample { clip_id: frame / 999, frame }).collect();
        write_items(&store, "body", state, &items, &notes).unwrap();
        assert_eq!(read_items(&store, "body", state).unwrap(), items);
        let merges = Merge { item: 9, a: 1, b: 2, e: 0.25, members: 3, radius2: 0.125 };
        write_merges(&store, "body", state, &[merges], &notes).unwrap();
    }
    let script = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers/open_tables.py");
    let output = std::process::Command::new(python).arg(script).arg(store.root()).output().unwrap();
    println!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stdout.iter().filter(|&&byte| byte == b'\n').count() >= 19);
}

const FIGURES: [&str; 3] = ["wrist_jerk", "skate", "arm_leg_lock"];

fn node(dice: &mut Dice) -> Node {
    Node {
        node: dice.next() as u32,
        tree: dice.text(),
        plant_state: dice.pick(&PlantState::ALL),
        threshold: dice.f64(),
        item: dice.next() as u32,
        members: dice.next() as u32,
        clips: dice.next() as u32,
        radius2: dice.f64(),
        max_radius2: dice.f64(),
        medoid: Sample { clip_id: dice.next() as u32, frame: dice.next() as u32 },
        component: dice.next() as u32,
    }
}

fn sequence(dice: &mut Dice) -> Sequence {
    Sequence {
        node: dice.next() as u32,
        clip_id: dice.next() as u32,
        first: dice.next() as u32,
        end: dice.next() as u32,
        samples: dice.next() as u32,
        alignment_frame: dice.maybe(|dice| dice.next() as u32),
        previous_node: dice.maybe(|dice| dice.next() as u32),
        next_node: dice.maybe(|dice| dice.next() as u32),
    }
}

fn recipe(dice: &mut Dice) -> Recipe {
    Recipe {
        recipe: dice.text(),
        kind: dice.text(),
        base: dice.text(),
        donor: dice.maybe(Dice::text),
        chains: dice.many(4, Dice::text),
        alternate: dice.maybe(|dice| dice.next() as i32),
        options: dice.text(),
        seed: dice.next() << 20,
        rule: dice.text(),
        cell: dice.maybe(Dice::text),
    }
}

fn made(dice: &mut Dice) -> Made {
    let judged = dice.below(4) > 0;
    let range = |dice: &mut Dice| [dice.next() as u32, dice.next() as u32];
    Made {
        recipe: dice.text(),
        clip_id: dice.maybe(|dice| dice.next() as u32),
        accepted: dice.below(2) == 0,
        reasons: dice.many(3, Dice::text),
        base_range: dice.maybe(range),
        donor_range: dice.maybe(range),
        figures: FIGURES
            .iter()
            .filter(|_| judged)
            .map(|name| Figure {
                name: (*name).to_owned(),
                own: Some(dice.f32()),
                base: dice.maybe(Dice::f32),
                donor: dice.maybe(Dice::f32),
            })
            .collect(),
    }
}

/// Columns of a file as `name type`, `?` where null is allowed.
fn columns(store: &Store, name: &str) -> Vec<String> {
    use arrow::datatypes::{DataType, Field};
    fn short(field: &Field) -> String {
        let kind = match field.data_type() {
            DataType::UInt32 => "u32".to_owned(),
            DataType::UInt64 => "u64".to_owned(),
            DataType::Int32 => "i32".to_owned(),
            DataType::Float32 => "f32".to_owned(),
            DataType::Float64 => "f64".to_owned(),
            DataType::Boolean => "bool".to_owned(),
            DataType::Utf8 => "str".to_owned(),
            DataType::List(element) => format!("list<{}>", short(element)),
            other => panic!("{other}"),
        };
        format!("{kind}{}", if field.is_nullable() { "?" } else { "" })
    }
    let file = File::open(store.path(name)).unwrap();
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).unwrap();
    builder.schema().fields().iter().map(|field| format!("{} {}", field.name(), short(field))).collect()
}

fn golden(text: &str) -> Vec<String> {
    text.split(',').map(|column| column.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
}

#[test]
fn columns_are_those_of_the_schema() {
    let (_folder, store) = store();
    let notes = FileNotes::new();
    write_clips(&store, &[], &notes).unwrap();
    write_skeletons(&store, &[], &notes).unwrap();
    write_faults(&store, &[], &notes).unwrap();
    write_items(&store, "body", PlantState::LB, &[], &notes).unwrap();
    write_merges(&store, "body", PlantState::LB, &[], &notes).unwrap();
    write_nodes(&store, &[], &notes).unwrap();
    write_sequences(&store, &[], &notes).unwrap();
    write_edges(&store, &[], &notes).unwrap();
    write_recipes(&store, &[], &notes).unwrap();
    write_made(&store, &[], &FIGURES[..2], &notes).unwrap();
    // The columns from up_axis on are additions.
    let clips = "clip_id u32, name str, source str, format str, layout str, skeleton str, subject str?, frames u32,
        rate_hz f64, frame_time_s f64?, duration_s f64, unit_m f64, max_rounding f32, licenses list<str>,
        attribution str?, may_share bool?, may_sell bool?, origin str, parents list<u32>, recipe str?,
        leg_length_m f32?, ground_height_m f32?, noise_m f32?, gait_class str?, thesis_class str?,
        stand_fraction f32?, walk_fraction f32?, run_fraction f32?, jump_fraction f32?, unknown_fraction f32?,
        gait_confidence f32?, duty_factor f32?, flight_fraction f32?, checks list<str>, warnings u32, up_axis str,
        leg_spread_m f32?, ground_spread_m f32?, ground_slope_x f32?, ground_slope_z f32?, ground_slope_share f32?,
        uneven bool?, belt_mps f32?, noise_spread_m f32?";
    // The last three are additions.
    let skeletons = "skeleton str, layout str, format str, joints list<str>, parents list<i32>, roles list<str?>,
        channels list<str>, offsets list<f64>, end_offsets list<f64?>, axis list<f64?>, axis_order list<str?>,
        angle_unit str, header str, position_rule str, bones list<f64?>, role_points list<i32?>";
    // The last is an addition.
    let faults = "source str, name str, severity str, kind str, line u32?, frame u32?, count u32, message str,
        remedy str, why str";
    let annotations = "clip_id u32, frame u32, time_s f64, root_x f32, root_y f32, root_z f32, heading f32?,
        speed f32, turn_rate f32?, left_ankle_height f32?, left_toe_height f32?, right_ankle_height f32?,
        right_toe_height f32?, left_ankle_speed f32?, left_toe_speed f32?, right_ankle_speed f32?,
        right_toe_speed f32?, left_stance bool?, right_stance bool?, left_pinned bool?, right_pinned bool?,
        plant_state str?, gait str?, gait_confidence f32?, phase f32?";
    let shard = ShardId::captured(0);
    let finished = ShardWriter::create(&store, shard, all_tables()).finish().unwrap();
    finished.commit(ShardRecord::new(shard)).unwrap();
    let items = items_file("body", PlantState::LB);
    let merges = merges_file("body", PlantState::LB);
    assert_eq!(merges, "merges/tree=body/plant_state=LB/part-00000.parquet");
    for (file, wanted) in [
        (CLIPS, clips),
        (SKELETONS, skeletons),
        (FAULTS, faults),
        (&shard.file(Table::Annotations, ""), annotations),
        (
            &shard.file(Table::Plants, ""),
            "clip_id u32, foot str, first u32, end u32, x f32, y f32, z f32, slip_m f32, confidence f32?",
        ),
        (&shard.file(Table::Segments, ""), "clip_id u32, gait str, first u32, end u32, confidence f32?"),
        (
            &shard.file(Table::Provenance, ""),
            "clip_id u32, frame u32, part str, parent u32, parent_frame f64, weight f32",
        ),
        (&items, "item u32, clip_id u32, frame u32"),
        (&merges, "item u32, a u32, b u32, e f64, members u32, radius2 f64"),
        (
            NODES,
            "node u32, tree str, plant_state str, threshold f64, item u32, members u32, clips u32, radius2 f64,
             max_radius2 f64, medoid_clip_id u32, medoid_frame u32, component u32",
        ),
        (
            SEQUENCES,
            "node u32, clip_id u32, first u32, end u32, samples u32, alignment_frame u32?, previous_node u32?,
             next_node u32?",
        ),
        (EDGES, "from_node u32, to_node u32, transitions u32, clips u32"),
        (
            RECIPES,
            "recipe str, kind str, base str, donor str?, chains list<str>, alternate i32?, options str, seed u64,
             rule str, cell str?",
        ),
        (
            MADE,
            "recipe str, clip_id u32?, accepted bool, reasons list<str>, base_first u32?, base_end u32?,
             donor_first u32?, donor_end u32?, wrist_jerk f32?, wrist_jerk_base f32?, wrist_jerk_donor f32?,
             skate f32?, skate_base f32?, skate_donor f32?",
        ),
    ] {
        assert_eq!(columns(&store, file), golden(wanted), "{file}");
    }
    let features = columns(&store, &shard.file(Table::Features, ""));
    assert_eq!(features.len(), 47);
    assert_eq!(features[..3], ["clip_id u32", "frame u32", "head.px f32"]);
    assert_eq!(features[46], "toe_right.az f32");
    assert_eq!(features[14], "wrist_left.vx f32");
}

/// A little skeleton whose joint names repeat but for case.
const TWINS: &str = r#"{"format": "bvh", "angle_unit": "degrees", "position_rule": "replace", "joints": [
    {"name": "Foot", "parent": null, "offset": [0.0, 0.0, 0.0], "end": null, "axis": null, "bone": null,
     "channels": [{"kind": "Position", "axis": "X"}, {"kind": "Rotation", "axis": "Z"},
                  {"kind": "Rotation", "axis": "Z"}]},
    {"name": "foot", "parent": 0, "offset": [0.0, 1.0, 0.0], "end": [0.0, 1.0, 0.0], "axis": null, "bone": null,
     "channels": [{"kind": "Rotation", "axis": "Y"}]},
    {"name": "膝", "parent": 0, "offset": [0.0, 1.0, 0.0], "end": [0.0, 1.0, 0.0], "axis": null, "bone": null,
     "channels": []}]}"#;

#[test]
fn wide_columns_say_what_they_are_and_differ_but_for_case() {
    let (_folder, store) = store();
    let mut dice = Dice(1);
    let mut row = skeleton_row(&mut dice);
    row.body = serde_json::from_str(TWINS).unwrap();
    row.roles = RoleMap::default();
    row.roles.set(motionmill::motion::Role::Hips, 0);
    row.roles.set(motionmill::motion::Role::WristLeft, 4);
    let clip = crate::corpus_samples::sample_clip(&mut dice, 9, 4, &row);
    let record = commit(&store, ShardId::captured(3), &[clip], all_tables());
    let layout = row.body.layout_id();
    let channels = record.shard.file(Table::Channels, &layout);
    assert_eq!(channels, format!("channels/layout={layout}/shard-00003.parquet"));
    let wanted = ["clip_id u32", "frame u32", "Foot.Xposition f32", "Foot.Zrotation f32", "Foot.Zrotation#2 f32"];
    assert_eq!(columns(&store, &channels)[..5], wanted);
    assert_eq!(columns(&store, &channels)[5..], ["foot#2.Yrotation f32"]);
    let poses = record.shard.file(Table::Poses, &layout);
    let names: Vec<String> = columns(&store, &poses);
    assert_eq!(names[..4], ["clip_id u32", "frame u32", "time_s f64", "Foot.x f32"]);
    assert_eq!(names[12..15], ["foot#2.end.x f32", "foot#2.end.y f32", "foot#2.end.z f32"]);
    assert_eq!(names[15], "膝.end.x f32");
    assert_eq!(names[18], "Foot.qx f32");
    let mut lower: Vec<String> = names.iter().map(|name| name.to_lowercase()).collect();
    lower.sort();
    lower.dedup();
    assert_eq!(lower.len(), names.len());

    let open = |name: &str| ParquetRecordBatchReaderBuilder::try_new(File::open(store.path(name)).unwrap()).unwrap();
    let builder = open(&channels);
    let field = |n: usize| builder.schema().field(n).metadata().clone();
    let text = |pairs: &[(&str, &str)]| {
        pairs
            .iter()
            .map(|(k, v)| ((*k).to_owned(), (*v).to_owned()))
            .collect::<std::collections::BTreeMap<String, String>>()
    };
    assert_eq!(
        field(3),
        text(&[("unit", "deg"), ("space", "file"), ("joint", "Foot"), ("role", "hips"), ("part", "root")])
    );
    let builder = open(&poses);
    let wrist = builder.schema().field(15).metadata().clone();
    assert_eq!(
        wrist,
        text(&[("unit", "m"), ("space", "world"), ("joint", "膝"), ("role", "wrist_left"), ("part", "root")])
    );
    let footer = builder.metadata().file_metadata();
    assert_eq!(footer.created_by(), Some("motionmill 2"));
    let keys: Vec<_> = footer.key_value_metadata().unwrap().iter().map(|entry| entry.key.as_str()).collect();
    assert_eq!(keys, ["motionmill.format_version", "motionmill.table", "ARROW:schema"]);
    let column = builder.metadata().row_group(0).column(3);
    assert!(column.offset_index_offset().is_some() && column.statistics().is_some());
}

#[test]
fn the_same_rows_give_the_same_bytes() {
    let files = |settings: ShardSettings| {
        let (_folder, store) = store();
        commit(&store, ShardId::captured(0), &sample_clips(5, 6, 900), settings);
        let clips: Vec<ClipRow> = (0..40).map(|id| clip_row(&mut Dice(u64::from(id)), id)).collect();
        write_clips(
            &store,
            &clips,
            &FileNotes::from([("b".to_owned(), "2".to_owned()), ("a".to_owned(), "1".to_owned())]),
        )
        .unwrap();
        let names = store.list("").unwrap();
        names.into_iter().map(|name| (store.read(&name).unwrap().unwrap(), name)).collect::<Vec<_>>()
    };
    let once = files(all_tables());
    assert!(once.len() >= 9, "{}", once.len());
    assert!(once == files(all_tables()));
}

#[test]
fn a_clip_deep_in_a_long_file_is_found() {
    let (_folder, store) = store();
    let mut dice = Dice(11);
    let row = skeleton_row(&mut dice);
    let lengths = [1, 700, 4096, 4095, 20_480, 3, 9000];
    let clips: Vec<_> = lengths
        .iter()
        .enumerate()
        .map(|(n, &n_frames)| crate::corpus_samples::sample_clip(&mut dice, 10 * n as u32, n_frames, &row))
        .collect();
    let settings = ShardSettings { tables: vec![Table::Channels], ..ShardSettings::default() };
    let record = commit(&store, ShardId::made(1), &clips, settings);
    assert_eq!(record.files[0].rows, lengths.iter().sum::<usize>() as u64);
    let shard = ShardReader::new(&store, &record);
    for clip in &clips {
        assert!(shard.channels(clip.row.clip_id).unwrap() == clip.channels, "clip {}", clip.row.clip_id);
    }
    let all: Vec<_> = shard.all_channels(&row.body.layout_id()).unwrap().map(Result::unwrap).collect();
    assert!(
        all.iter().map(|(id, values)| (*id, values)).eq(clips.iter().map(|clip| (clip.row.clip_id, &clip.channels)))
    );
    let error = shard.labels(0).unwrap_err();
    assert_eq!(error.to_string(), "annotations of made-00001 is not in this corpus");
}
