//! Every mistake of a pipeline, a config or a `--set` is named at its place, with its reason and its remedy.

use motionmill::plan::{Plan, Stage};

/// All messages that a pipeline, a config and `--set` values give, with the folder taken off the file names.
pub(crate) fn messages(pipeline: Option<&str>, config: Option<&str>, sets: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_string_lossy().into_owned()
    };
    let pipeline = pipeline.map_or("enrich".to_owned(), |text| put("mine.toml", text));
    let config = config.map(|text| put("config.toml", text));
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    match Plan::load(&pipeline, config.as_deref(), &sets) {
        Ok(_) => "no mistake\n".to_owned(),
        Err(errors) => {
            let folder = format!("{}/", folder.path().display());
            errors.iter().map(|error| format!("{error}\n").replace(&folder, "")).collect()
        }
    }
}

#[track_caller]
fn config_says(config: &str, expected: &str) {
    assert_eq!(messages(None, Some(config), &[]), expected.trim_start());
}

#[track_caller]
fn pipeline_says(pipeline: &str, expected: &str) {
    assert_eq!(messages(Some(pipeline), None, &[]), expected.trim_start());
}

#[track_caller]
fn set_says(set: &str, expected: &str) {
    assert_eq!(messages(None, None, &[set]), expected.trim_start());
}

/// A pipeline of these stages.
pub(crate) fn stages(names: &str) -> String {
    names.split_whitespace().map(|name| format!("[[stage]]\nuse = \"{name}\"\n")).collect()
}

#[test]
fn an_unknown_field_names_the_nearest_with_the_users_value() {
    config_says(
        "[contacts]\n\n[contacts.thesis]\n  max_hieght_m = 0.07\n",
        "
error: config.toml:4:3: unknown field `max_hieght_m` in [contacts.thesis]
  why: no such field; the nearest is `max_height_m`
  try: max_height_m = 0.07
",
    );
}

#[test]
fn a_value_in_another_unit_is_not_carried_over() {
    config_says(
        "[contacts.thesis]\nmax_height_cm = 5\n",
        "
error: config.toml:2:1: unknown field `max_height_cm` in [contacts.thesis]
  why: no such field; the nearest is `max_height_m`
  try: max_height_m = 0.05
",
    );
}

#[test]
fn a_field_of_another_section_is_sent_home_and_a_strange_one_gets_the_list() {
    config_says(
        "foo = 2\n[contacts]\nmax_height_m = 0.07\n[contacts.thesis]\nthreshold = 1\n",
        "
error: config.toml:1:1: unknown field `foo` outside any section
  why: no such field; there are `ingest`, `inputs`, `source`, `clip`, `limits`, `shards`, `tables`, `poses`, `procedural`, `annotations`, `contacts`, `cluster`, `neighbors`, `graph`, `recipes`, `graft`, `action` and `judge`
  try: take it out; configs/default.toml lists every setting
error: config.toml:3:1: unknown field `max_height_m` in [contacts]
  why: no such field here; it belongs to [contacts.extrema] or [contacts.thesis]
  try: max_height_m = 0.07 below [contacts.extrema]
error: config.toml:5:1: unknown field `threshold` in [contacts.thesis]
  why: no such field; there are `max_height_m`, `max_speed_mps` and `close_gap_s`
  try: take it out; configs/default.toml lists every setting
",
    );
}

#[test]
fn an_unknown_section_names_the_nearest() {
    config_says(
        "[contcts.thesis]\nmax_height_m = 1\n[[sourc]]\nfolder = 'x'\n",
        "
error: config.toml:1:2: unknown section [contcts]
  why: no such section; the nearest is `contacts`
  try: [contacts]
error: config.toml:3:3: unknown section [sourc]
  why: no such section; the nearest is `source`
  try: [[source]]
",
    );
}

#[test]
fn wrong_types_say_what_is_needed_in_which_unit() {
    config_says(
        "[contacts.thesis]\nmax_height_m = \"5 cm\"\n[limits]\nmax_joints = 1.5\nmax_depth = -3\nmax_poses = 18446744073709551616\n\
         [tables]\nposes = 1\n[graph]\nthresholds_m2 = [0.4, \"x\"]\n[contacts]\ndetector = 3\n",
        "
error: config.toml:2:16: `max_height_m` in [contacts.thesis] is text: \"5 cm\"
  why: a number in metres is needed
  try: max_height_m = 0.05
error: config.toml:4:14: `max_joints` in [limits] is a number with a fraction: 1.5
  why: a whole number, not below 0, is needed
  try: max_joints = 4096
error: config.toml:5:13: `max_depth` in [limits] is a whole number: -3
  why: a whole number, not below 0, is needed
  try: max_depth = 4096
error: config.toml:6:13: `max_poses` in [limits] is a whole number: 18446744073709551616
  why: a smaller whole number is needed
  try: max_poses = 200000000
error: config.toml:8:9: `poses` in [tables] is a whole number: 1
  why: `true` or `false` is needed
  try: poses = true
error: config.toml:10:23: `thresholds_m2` in [graph] is text: \"x\"
  why: a number in square metres is needed
  try: thresholds_m2 = [0.5]
error: config.toml:12:12: `detector` in [contacts] is a whole number: 3
  why: one of `adaptive`, `thesis`, `extrema` is needed
  try: detector = \"adaptive\"
",
    );
}

#[test]
fn a_section_is_no_value_and_no_list() {
    config_says(
        "cluster = 3\nsource = 'x'\ncontacts = [\"thesis\"]\n[inputs]\nskip = 'a'\n",
        "
error: config.toml:1:11: `cluster` is a whole number: 3
  why: a section with fields is needed
  try: [cluster]
error: config.toml:2:10: `source` is text: \"x\"
  why: a list in [ ] is needed
  try: [[source]]
error: config.toml:3:12: `contacts` is a list: [\"thesis\"]
  why: a section with fields is needed
  try: [contacts]
error: config.toml:5:8: `skip` in [inputs] is text: \"a\"
  why: a list in [ ] is needed
  try: skip = []
",
    );
}

#[test]
fn an_unknown_word_gets_the_words_that_there_are() {
    config_says(
        "[poses]\nrotations = \"quaternions\"\n[[source]]\nup = \"x\"\n",
        "
error: config.toml:2:13: `rotations` in [poses] is \"quaternions\"
  why: it can be `none` or `quaternion`; the nearest is `quaternion`
  try: rotations = \"quaternion\"
error: config.toml:4:6: `up` in [[source]] is \"x\"
  why: it can be `y` or `z`
  try: up = \"y\"
",
    );
}

#[test]
fn a_value_out_of_range_says_the_range_and_why() {
    config_says(
        "[contacts.thesis]\nmax_height_m = -1\nmax_speed_mps = nan\n[cluster]\nt_max_m2 = 0\n[[source]]\nunit_m = 0\n",
        "
error: config.toml:2:16: `max_height_m` in [contacts.thesis] is -1
  why: it must be above 0 and at most 1: at 0 no foot is ever planted, beyond 1 m all are
  try: max_height_m = 0.05
error: config.toml:3:17: `max_speed_mps` in [contacts.thesis] is NaN
  why: it must be a finite number
  try: max_speed_mps = 1.0
error: config.toml:5:12: `t_max_m2` in [cluster] is 0
  why: it must be above 0: no two frames would be merged
  try: t_max_m2 = 0.5
error: config.toml:7:10: `unit_m` in [[source]] is 0
  why: it must be above 0 and at most 2000: no file is in another unit; a millimetre is 0.001, a mile 1609
  try: unit_m = 0.01
",
    );
}

#[test]
fn values_that_do_not_go_together_are_named() {
    config_says(
        "[graph]\nthresholds_m2 = [0.1, 0.7, 0.1]\n",
        "
error: config.toml:2:23: `thresholds_m2` in [graph] is 0.7
  why: the tree stops at `t_max_m2` = 0.5 in [cluster], so it can't be cut above
  try: thresholds_m2 = [0.5]
error: config.toml:2:28: `thresholds_m2` in [graph] is 0.1
  why: one graph for each threshold, so each stands once
  try: thresholds_m2 = [0.5]
",
    );
    config_says(
        "[graph]\nthresholds_m2 = []\n",
        "
error: config.toml:2:17: `thresholds_m2` in [graph] is []
  why: without a threshold there is no graph
  try: thresholds_m2 = [0.5]
",
    );
    assert_eq!(
        messages(None, Some("[cluster]\nt_max_m2 = 0.7\n[graph]\nthresholds_m2 = [0.7]\n"), &[]),
        "no mistake\n"
    );
}

#[test]
fn rules_for_sources_and_clips_are_checked_one_by_one() {
    config_says(
        "[[source]]\nlabel = 'a/b'\n[[source]]\nfolder = 'x'\n[[clip]]\nrate_hz = 60\n[[clip]]\nname = 'a'\nunit = 3\n",
        "
error: config.toml:2:9: `label` in [[source]] is \"a/b\"
  why: a label stands before `/` in clip names, and `#2` marks repeats
  try: label = \"studio\"
error: config.toml:4:10: `folder` in [[source]] is \"x\"
  why: an earlier [[source]] takes every such folder, so this one never counts
  try: folder = \"*\"
error: config.toml:5:1: no `name` in [[clip]]
  why: it has no default
  try: name = \"take_07\"
error: config.toml:9:1: unknown field `unit` in [[clip]]
  why: no such field; the nearest is `unit_m`
  try: unit_m = 1.0
",
    );
}

#[test]
fn a_range_is_checked_at_its_own_place_when_an_earlier_element_can_not_be_read() {
    // The second rule moves to the place of the first, which is left out: nothing may be said at the wrong line.
    let said = messages(None, Some("[[clip]]\nrate_hz = 1\n[[clip]]\nname = 'a'\nunit_m = -1\n"), &[]);
    assert!(said.starts_with("error: config.toml:1:1: no `name` in [[clip]]"), "{said}");
    assert_eq!(said.matches("error:").count(), 1, "{said}");
}

#[test]
fn what_is_no_toml_is_shown_at_its_place() {
    config_says(
        "[contacts]\ndetector = thesis # the old one\n[limits\nmax_joints = 3\n",
        "
error: config.toml:2:12: not TOML: invalid boolean, expected `true`
  why: settings are TOML: `name = value`, text in quotes, sections in [ ]
  try: detector = \"thesis\"
error: config.toml:3:8: not TOML: unclosed table, expected `]`
  why: settings are TOML: `name = value`, text in quotes, sections in [ ]
  try: mend this line: [limits
",
    );
    config_says(
        "[contacts]\ndetector = 'thesis'\ndetector = 'thesis'\n",
        "
error: config.toml:3:1: not TOML: duplicate key
  why: a name may stand once in a section, or it would be unclear which value counts
  try: keep one of the two
",
    );
    config_says(
        "[limits]\n# é\nmax_joints = 99999999999999999999999999999999999999999999\n",
        "
error: config.toml:3:14: `99999999999999999999999999999999999999999999` is too large a number
  why: no field takes a number of that size
  try: write a smaller one
",
    );
}

#[test]
fn columns_count_characters_and_windows_line_ends_count_once() {
    let said = messages(None, Some("[inputs]\r\nskip = [\"é\", 1]\r\n"), &[]);
    assert!(said.starts_with("error: config.toml:2:14: `skip` in [inputs] is a whole number: 1\n"), "{said}");
}

#[test]
fn names_that_are_neither_shipped_nor_files() {
    let said = |pipeline: &str, config: Option<&str>| {
        let errors = Plan::load(pipeline, config, &[]).unwrap_err();
        errors.iter().map(|error| format!("{error}\n")).collect::<String>()
    };
    assert_eq!(
        said("enrih", Some("cmuu")),
        "error: enrih: no such pipeline\n  why: it is neither a file nor one of `annotate`, `graph`, `enrich` or `demo`\n  \
         try: the nearest pipeline that ships is `enrich`\n\
         error: cmuu: no such config\n  why: it is neither a file nor one of `default`, `cmu` or `bandai-namco`\n  \
         try: the nearest config that ships is `cmu`\n"
    );
    assert_eq!(
        said("nowhere/mine.toml", None),
        "error: nowhere/mine.toml: this pipeline can't be read: No such file or directory (os error 2)\n  \
         why: it is looked for from the folder that the program runs in\n  \
         try: name a file, or one of `annotate`, `graph`, `enrich` or `demo`\n"
    );
    let folder = tempfile::tempdir().unwrap();
    let latin = folder.path().join("latin.toml");
    std::fs::write(&latin, b"[inputs]\nskip = [\"\xe9\"]\n").unwrap();
    let said = said("annotate", latin.to_str());
    assert!(said.contains("latin.toml:2:10: not UTF-8 from here on\n"), "{said}");
}

#[test]
fn an_impossible_order_says_what_to_move() {
    pipeline_says(
        &stages("ingest features contacts graph tree"),
        "
error: mine.toml:7:1: `graph` comes before `tree`
  why: graph needs the merges that tree makes
  try: move [[stage]] use = \"graph\" below use = \"tree\"
",
    );
}

#[test]
fn a_missing_prerequisite_says_what_to_add() {
    pipeline_says(
        &stages("ingest contacts tree"),
        "
error: mine.toml:5:1: `tree` without `features`
  why: tree needs the features that frames are compared by
  try: add [[stage]] use = \"features\" above it
",
    );
    pipeline_says(
        &stages("ingest contacts gait recipes make"),
        "
error: mine.toml:9:1: `make` without `judge`
  why: make needs the judge's word: no made clip counts without it
  try: add [[stage]] use = \"judge\" below it
",
    );
}

#[test]
fn a_stage_twice_or_unknown_or_nameless() {
    pipeline_says(
        &stages("ingest ingest"),
        "
error: mine.toml:3:1: `ingest` stands twice
  why: each stage writes its own tables, once
  try: take one [[stage]] use = \"ingest\" out
",
    );
    // `gait` needs `contacts`, which could not be read: nothing is said of that.
    pipeline_says(
        &format!("{}[[stage]]\nfoo = 1\n[[stage]]\nuse = 3\n", stages("ingest contact gait zzz")),
        "
error: mine.toml:4:7: unknown stage `contact`
  why: no such stage; the nearest is `contacts`
  try: use = \"contacts\"
error: mine.toml:8:7: unknown stage `zzz`
  why: there are `ingest`, `features`, `contacts`, `gait`, `tree`, `neighbors`, `graph`, `recipes`, `make` and `judge`
  try: use = \"ingest\"
error: mine.toml:9:1: a stage without `use`
  why: `use` says which stage it is: `ingest`, `features`, `contacts`, `gait`, `tree`, `neighbors`, `graph`, `recipes`, `make` or `judge`
  try: use = \"ingest\"
error: mine.toml:12:7: `use` is a whole number: 3
  why: a stage is called by its name
  try: use = \"ingest\"
",
    );
}

#[test]
fn options_of_a_stage_are_checked_as_the_fields_of_its_section() {
    pipeline_says(
        "[[stage]]\nuse = \"ingest\"\n[[stage]]\nuse = \"contacts\"\ndetectr = 'thesis'\n[[stage]]\nuse = \"gait\"\nmachine = 1\n\
         [[stage]]\nuse = \"recipes\"\nselect = 'many'\narm_groups = 0\n",
        "
error: mine.toml:5:1: unknown option `detectr` of stage `contacts`
  why: no such option; the nearest is `detector`
  try: detector = 'thesis'
error: mine.toml:8:1: unknown option `machine` of stage `gait`
  why: gait has no options
  try: take it out
error: mine.toml:11:10: `select` in stage `recipes` is text: \"many\"
  why: a whole number, not below 0, is needed
  try: select = 200
error: mine.toml:12:14: `arm_groups` in stage `recipes` is 0
  why: it must be at least 1: every clip is in a group
  try: arm_groups = 60
",
    );
}

#[test]
fn conditions_of_a_where_are_checked() {
    pipeline_says(
        "[[stage]]\nuse = \"ingest\"\nwhere = { gait = 'walk', source = 'cmu' }\n[[stage]]\nuse = \"contacts\"\nwhere = {}\n\
         [[stage]]\nuse = \"gait\"\n[[stage]]\nuse = \"recipes\"\n\
         where = { gait = ['walk', 'rn'], min_duration = 3, max_duration_s = -1, name = 7 }\n",
        "
error: mine.toml:3:11: `gait` in `where` of stage `ingest`
  why: it is not known before the clips have been read
  try: put it on `tree`, `neighbors` or `recipes`
error: mine.toml:6:1: `where` on stage `contacts`
  why: contacts works on all that the stages above it give
  try: put it on `ingest`, `tree`, `neighbors` or `recipes`
error: mine.toml:11:27: `gait` in `where` of stage `recipes` is \"rn\"
  why: it can be `unknown`, `stand`, `walk`, `run`, `jump` or `other`; the nearest is `run`
  try: gait = \"run\"
error: mine.toml:11:34: unknown condition `min_duration` in `where` of stage `recipes`
  why: no such condition; the nearest is `min_duration_s`
  try: min_duration_s = 1.0
error: mine.toml:11:69: `max_duration_s` in `where` of stage `recipes` is -1
  why: it must be at least 0: no clip is longer
  try: mend the number, or take the condition out
error: mine.toml:11:80: `name` in `where` of stage `recipes` is a whole number: 7
  why: text or a list of texts is needed
  try: name = \"cmu\"
",
    );
    let plan = "[[stage]]\nuse = 'ingest'\nwhere = { name = ['02_*', '16_*'], format = 'amc' }\n";
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("two.toml");
    std::fs::write(&file, plan).unwrap();
    let plan = Plan::load(file.to_str().unwrap(), None, &[]).unwrap();
    assert_eq!(plan.pipeline, "two");
    assert_eq!(plan.filter(Stage::Ingest).name, ["02_*", "16_*"]);
    assert!(plan.filter(Stage::Tree).is_empty());
}

#[test]
fn a_pipeline_has_stages_and_nothing_else() {
    pipeline_says(
        "stages = []\ndescription = 3\n[stage]\nuse = 'ingest'\n",
        "
error: mine.toml:1:1: unknown field `stages` in a pipeline
  why: a pipeline has a `description` and a list of [[stage]]
  try: [[stage]]
error: mine.toml:2:15: `description` is a whole number
  why: it is shown as text
  try: description = \"what this pipeline makes\"
error: mine.toml:3:1: `stage` is a section
  why: a pipeline is a list of stages, and in TOML a list of tables has double brackets
  try: [[stage]]
",
    );
    pipeline_says(
        "",
        "
error: mine.toml:1:1: a pipeline without stages
  why: there is nothing to do
  try: [[stage]] use = \"ingest\"
",
    );
}

#[test]
fn tables_that_a_stage_reads_can_not_be_left_out() {
    config_says(
        "[tables]\nchannels = false\nfeatures = false\nposes = false\n",
        "
error: config.toml:2:12: `channels` in [tables] is false, and the pipeline has `make`
  why: make reads the channels table
  try: leave it true, or take `make` out of the pipeline
error: config.toml:3:12: `features` in [tables] is false, and the pipeline has `tree`
  why: tree reads the features table
  try: leave it true, or take `tree` out of the pipeline
",
    );
    let sets = ["tables.channels=false".to_owned(), "tables.features=false".to_owned()];
    assert!(Plan::load("annotate", None, &sets).is_ok());
}

#[test]
fn mistakes_of_set_name_the_whole_of_it() {
    set_says(
        "contacts.thesis.max_hieght_m=0.04",
        "
error: --set contacts.thesis.max_hieght_m=0.04: unknown field `max_hieght_m` in [contacts.thesis]
  why: no such field; the nearest is `max_height_m`
  try: --set contacts.thesis.max_height_m=0.04
",
    );
    set_says(
        "contacts.detector=thesys",
        "
error: --set contacts.detector=thesys: `detector` in [contacts] is \"thesys\"
  why: it can be `adaptive`, `thesis` or `extrema`; the nearest is `thesis`
  try: --set contacts.detector=thesis
",
    );
    set_says(
        "contacts.thesis.max_height_m=-1",
        "
error: --set contacts.thesis.max_height_m=-1: `max_height_m` in [contacts.thesis] is -1
  why: it must be above 0 and at most 1: at 0 no foot is ever planted, beyond 1 m all are
  try: --set contacts.thesis.max_height_m=0.05
",
    );
    set_says(
        "max_height_m=0.04",
        "
error: --set max_height_m=0.04: unknown field `max_height_m` outside any section
  why: no such field here; it belongs to [contacts.extrema] or [contacts.thesis]
  try: --set contacts.extrema.max_height_m=0.04
",
    );
    set_says(
        "contacts",
        "
error: --set contacts: no `=` in `contacts`
  why: a value is set by its path in the config, `=`, and the value
  try: --set contacts.detector=thesis
",
    );
    set_says(
        "contacts..x=1",
        "
error: --set contacts..x=1: `contacts..x` is no path to a value
  why: sections and fields are separated by single dots
  try: --set contacts.thesis.max_height_m=0.05
",
    );
    set_says(
        "graph.thresholds_m2=[0.1",
        "
error: --set graph.thresholds_m2=[0.1: not TOML: unclosed array, expected `]`
  why: settings are TOML: `name = value`, text in quotes, sections in [ ]
  try: put text in quotes, lists in [ ]
",
    );
    set_says(
        "source.unit_m=1",
        "
error: --set source.unit_m=1: `source` is a section: { ... }
  why: a list in [ ] is needed
  try: put [[source]] into a config
",
    );
}

#[test]
fn mistakes_of_all_three_come_together_in_their_order() {
    let said = messages(
        Some(&format!("{}sed = 1\n", stages("ingest contacts gait recipes graph"))),
        Some("[limits]\nmax_joint = 3\n[contacts.thesis]\nclose_gap_s = 7\n"),
        &["x=1", "cluster.rate_hz=0"],
    );
    let heads: Vec<&str> = said.lines().filter(|line| line.starts_with("error:")).collect();
    assert_eq!(
        heads,
        [
            "error: mine.toml:9:1: `graph` without `tree`",
            "error: mine.toml:11:1: unknown option `sed` of stage `graph`",
            "error: config.toml:2:1: unknown field `max_joint` in [limits]",
            "error: config.toml:4:15: `close_gap_s` in [contacts.thesis] is 7",
            "error: --set x=1: unknown field `x` outside any section",
            "error: --set cluster.rate_hz=0: `rate_hz` in [cluster] is 0",
        ]
    );
}
