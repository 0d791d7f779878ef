//! The promises of a run (DESIGN 3, 4, 5): the same bytes however it is run, killed or interrupted; and an end with
//! one message where it can't go on, never a wait for ever. Every child has a deadline.

use crate::running::*;
use crate::shared_data::captures;
use motionmill::corpus::Store;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

#[test]
fn the_same_bytes_for_any_number_of_workers_and_processes_and_order_of_inputs() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    run("enrich", &[a, b], &out("two"), &["-w", "2"]).with(0);
    reference.equals(&out("two"), "2 workers");
    run("enrich", &[b, a], &out("four"), &["-w", "4"]).with(0);
    reference.equals(&out("four"), "4 workers, inputs in the other order");
    for process in start_two(folder.path(), "enrich", &[b, a], &out("both"), [&[], &[]]) {
        process.end().with(0);
    }
    reference.equals(&out("both"), "2 processes");
}

#[test]
fn killed_at_any_instant_a_run_continues_to_the_same_bytes() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let seed = 20;
    for (n, draw) in draws(seed).take(6).enumerate() {
        let out = folder.path().join(n.to_string());
        // Some are killed twice: the second time while they pick up what the first left.
        for kill in 0..1 + n % 2 {
            let running = start("enrich", &[a, b], &out, &["-w", if n % 3 == 0 { "1" } else { "2" }]);
            std::thread::sleep(reference.took.mul_f64((n as f64 + draw) / 6.0 / (1 + kill) as f64));
            running.signal("-KILL");
            running.end();
        }
        run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
        reference.equals(&out, &format!("kill {n} of seed {seed}"));
    }
}

#[test]
fn interrupted_a_run_says_what_is_safe_and_continues_to_the_same_bytes() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let seed = 5;
    let mut interrupted = 0;
    for (n, draw) in draws(seed).take(4).enumerate() {
        let out = folder.path().join(n.to_string());
        let running = start("enrich", &[a, b], &out, &["-w", "2"]);
        std::thread::sleep(Duration::from_millis(60) + reference.took.mul_f64((n as f64 + draw) / 6.0));
        running.signal("-INT");
        let ended = running.end();
        if ended.code == Some(130) {
            interrupted += 1;
            let last = ended.err.lines().last().unwrap_or_default();
            let safe = format!("safe in {}; the same command continues", out.display());
            assert!(last.starts_with("interrupted: ") && last.ends_with(&safe), "{}", ended.err);
            let left: Vec<String> = digests(&out).into_keys().filter(|name| !is_whole(name)).collect();
            assert!(left.is_empty(), "left by interrupt {n}: {left:?}");
        } else {
            ended.with(0);
        }
        run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
        reference.equals(&out, &format!("interrupt {n} of seed {seed}"));
    }
    assert!(interrupted >= 2, "the machine was too fast for {} of 4", 4 - interrupted);
}

fn is_whole(name: &str) -> bool {
    !name.ends_with(".partial") && name != ".run"
}

#[test]
fn an_interrupt_of_one_process_ends_both() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    for victim in [0, 1] {
        let out = folder.path().join(victim.to_string());
        let running = start_two(folder.path(), "enrich", &[a, b], &out, [&[], &[]]);
        std::thread::sleep(reference.took / 4);
        running[victim].signal("-INT");
        for process in running {
            assert!(process.end().with(130).err.contains("safe in"));
        }
        run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
        reference.equals(&out, &format!("after an interrupt of process {victim}"));
    }
}

#[test]
fn a_process_that_is_lost_ends_the_other_with_one_message() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    for (victim, part) in [(0, 0.2), (1, 0.3), (1, 0.7)] {
        let out = folder.path().join(format!("{victim}-{part}"));
        let mut running = start_two(folder.path(), "enrich", &[a, b], &out, [&[], &[]]);
        std::thread::sleep(Duration::from_millis(200) + reference.took.mul_f64(part * 0.5));
        running[victim].child.kill().unwrap();
        let killed = Instant::now();
        let [first, second] = running;
        let other = if victim == 0 { second } else { first };
        other.end().fails_with("another process of this run was lost");
        assert!(killed.elapsed() < Duration::from_secs(10), "the other took {:?}", killed.elapsed());
        run("enrich", &[a, b], &out, &["-w", "1"]).with(0);
        reference.equals(&out, &format!("after the loss of process {victim}"));
    }
}

#[test]
fn processes_that_do_not_belong_together_refuse_each_other() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("corpus");
    let more: [&[&str]; 2] = [&[], &["--set", "cluster.t_max_m2=0.4"]];
    for process in start_two(folder.path(), "enrich", &[a, b], &out, more) {
        process.end().fails_with("runs another plan");
    }
    let elsewhere = folder.path().join("elsewhere");
    let [first, second] = start_two(folder.path(), "enrich", &[a, b], &out, [&[], &[]]);
    second.signal("-KILL");
    second.end();
    first.signal("-INT");
    first.end().with(130);
    let hosts = folder.path().join("hosts");
    let told = |process| ["--hosts", hosts.to_str().unwrap(), "--process", process, "-w", "1"];
    let first = start("enrich", &[a, b], &out, &told("0"));
    let second = start("enrich", &[a, b], &elsewhere, &told("1"));
    second.end().fails_with("is at work in another corpus");
    first.end().fails_with("another process of this run was lost");
    assert!(!elsewhere.exists());
    let mut late = told("0").to_vec();
    late.extend(["--hosts-deadline-s", "1"]);
    run("enrich", &[a, b], &out, &late).fails_with("after 1 s these processes have not connected: 1 (127.0.0.1:");
}

#[test]
fn a_second_run_in_a_corpus_is_told_so() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("corpus");
    let _lock = motionmill::corpus::RunLock::acquire(&Store::new(&out)).unwrap();
    let ended =
        run("enrich", &[a, b], &out, &["-w", "2"]).fails_with("another run is at work in this corpus (process ");
    assert!(ended.took < Duration::from_secs(20), "{:?}", ended.took);
    assert_eq!(digests(&out).into_keys().collect::<Vec<_>>(), [".run"]);
}

/// What fails on worker 0 alone, between two dataflows or in them, reaches all workers of all processes.
#[test]
fn what_one_worker_can_not_do_ends_the_run_everywhere() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let all_end = |out: &Path, more: &[&str], words: &str| {
        let mut with_workers = more.to_vec();
        with_workers.extend(["-w", "3"]);
        run("enrich", &[a, b], out, &with_workers).fails_with(words);
        for process in start_two(folder.path(), "enrich", &[a, b], out, [more, more]) {
            process.end().fails_with(words);
        }
    };
    // Reading samples for the trees, and channels for the choice of recipes.
    for (table, changed) in [("features", "cluster.t_max_m2=0.4"), ("channels", "recipes.select=47")] {
        let out = folder.path().join(table);
        copy(&reference.folder.path().join("corpus"), &out);
        let file = captured_file(&out, table);
        flip(&file);
        all_end(&out, &["--set", changed], "damaged");
        fs::remove_file(&file).unwrap();
        run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
        reference.equals(&out, &format!("after the damaged file of {table} was deleted"));
    }
    // Writing a shard, folding: a file where a folder should be, and a folder where a file should be.
    for (name, is_folder) in [("poses", false), ("merges", false), ("clips.parquet", true), ("made.parquet", true)] {
        let blocked = folder.path().join(format!("blocked-{name}"));
        fs::create_dir_all(&blocked).unwrap();
        fs::write(blocked.join(".lock"), "").unwrap();
        let obstacle = blocked.join(name);
        if is_folder {
            fs::create_dir_all(obstacle.join("in the way")).unwrap();
        } else {
            fs::write(&obstacle, "").unwrap();
        }
        all_end(&blocked, &[], name);
        if is_folder {
            fs::remove_dir_all(&obstacle).unwrap();
        } else {
            fs::remove_file(&obstacle).unwrap();
        }
        run("enrich", &[a, b], &blocked, &["-w", "2"]).with(0);
        reference.equals(&blocked, &format!("after {name} was out of the way"));
    }
}

#[test]
fn real_captures_give_the_same_bytes_for_one_worker_two_and_after_a_kill() {
    let Some(data) = captures() else { return };
    let cmu = data.join("cmu/02");
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("02");
    fs::create_dir(&input).unwrap();
    for name in ["02.asf", "02_01.amc", "02_02.amc", "02_03.amc", "02_04.amc"] {
        fs::copy(cmu.join(name), input.join(name)).unwrap();
    }
    let [one, two, killed] = ["one", "two", "killed"].map(|name| folder.path().join(name));
    let first = run("enrich", &[&input], &one, &["-w", "1", "--config", "cmu"]).with(0);
    run("enrich", &[&input], &two, &["-w", "2", "--config", "cmu"]).with(0);
    same(&digests(&one), &digests(&two), "2 workers");
    let running = start("enrich", &[&input], &killed, &["-w", "2", "--config", "cmu"]);
    std::thread::sleep(first.took.mul_f64(0.4));
    running.signal("-KILL");
    running.end();
    run("enrich", &[&input], &killed, &["-w", "2", "--config", "cmu"]).with(0);
    same(&digests(&one), &digests(&killed), "after a kill");
}
