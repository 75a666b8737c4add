//! Work in pieces, as a scheduler does it: in any order, killed, twice, at once, and with what has
//! changed in between. The joined result is that of one run.

use crate::desk::{Desk, Outcome};
use relievo_tests::asset;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// A turning torus.
fn write_scene(desk: &Desk) {
    let [mesh, pattern] = ["meshes/torus.obj", "patterns/discs.png"].map(asset);
    let text = format!(
        "[image]\nsize = [64, 48]\n[camera]\neye = [0.0, 2.3, 3.4]\nfov = 38.0\n\
         [[object]]\nmesh = {mesh:?}\nshape = {pattern:?}\nrepeat = [24, 10]\ndepth = 0.1\n\
         [[animate]]\nkey = 'camera.orbit'\ntimes = [0, 2]\nvalues = [0, 360]\n"
    );
    desk.write("scene.toml", text);
}

const FRAMES: &str = "render scene.toml --backend cpu --frames 2..8";

/// Plans a piece for each frame.
fn planned(output: &str) -> Desk {
    let desk = Desk::new();
    write_scene(&desk);
    let plan = format!("{FRAMES} {output} --plan job.json --piece-seconds 0");
    let told = desk.run(&plan).done().stdout;
    assert!(told.contains("6 frames in 6 pieces"), "{told}");
    assert!(!desk.path("out").exists());
    desk
}

fn piece(desk: &Desk, number: usize) -> Outcome {
    desk.run(&format!("job job.json --piece {number}"))
}

/// Does all pieces, the last one first. Returns their number.
fn all_pieces(desk: &Desk) -> usize {
    let job = fs::read_to_string(desk.path("job.json")).unwrap();
    let count = job.matches("\"first\"").count();
    for number in (1..=count).rev() {
        piece(desk, number).done();
    }
    count
}

/// Asserts that two folders have the same files.
#[track_caller]
fn assert_same(a: &Path, b: &Path) {
    let mut count = 0;
    for entry in fs::read_dir(a).unwrap() {
        let name = entry.unwrap().file_name();
        let [a, b] = [a, b].map(|folder| fs::read(folder.join(&name)).unwrap());
        assert!(a == b, "{} differs", name.display());
        count += 1;
    }
    assert_eq!(fs::read_dir(b).unwrap().count(), count);
}

#[test]
fn frames_in_pieces_are_those_of_one_run() {
    let output = "-o out/%04d.png --aov out/%04d.exr";
    let desk = planned(output);
    desk.fails("job job.json --merge", 1, "missing: 1-6 | --piece");
    for number in [4, 2, 6, 1] {
        piece(&desk, number).done();
    }
    let state = desk.run("job job.json").done().stdout;
    assert!(
        state.contains("4 pieces done") && state.contains("missing: 3,5"),
        "{state}"
    );
    desk.fails("job job.json --merge", 1, "missing: 3,5");
    for number in [3, 5] {
        piece(&desk, number).done();
    }
    // Done again, it does nothing.
    let before = fs::metadata(desk.path("out/0004.png")).unwrap().modified();
    assert!(piece(&desk, 3).done().stdout.contains("was done before"));
    let after = fs::metadata(desk.path("out/0004.png")).unwrap().modified();
    assert_eq!(before.unwrap(), after.unwrap());
    desk.run("job job.json --merge").done();
    fs::rename(desk.path("out"), desk.path("pieces")).unwrap();
    desk.run(&format!("{FRAMES} {output}")).done();
    assert_same(&desk.path("out"), &desk.path("pieces"));
}

#[test]
fn an_animation_in_pieces_is_that_of_one_run() {
    let desk = planned("-o out/movie.apng");
    assert_eq!(all_pieces(&desk), 6);
    // Two merges at once write the same.
    let merge = || {
        let mut command = std::process::Command::new(crate::program());
        command.args(["job", "job.json", "--merge"]);
        command.current_dir(desk.0.path()).stdout(Stdio::null());
        command.spawn().unwrap()
    };
    for mut merge in [merge(), merge()] {
        assert!(merge.wait().unwrap().success());
    }
    let joined = fs::read(desk.path("out/movie.apng")).unwrap();
    desk.run(&format!("{FRAMES} -o out/movie.apng")).done();
    assert!(fs::read(desk.path("out/movie.apng")).unwrap() == joined);
}

#[test]
fn lost_and_changed_outputs_are_made_again() {
    let desk = planned("-o out/%04d.png");
    assert_eq!(all_pieces(&desk), 6);
    let expected = fs::read(desk.path("out/0004.png")).unwrap();
    fs::write(desk.path("out/0004.png"), "torn").unwrap();
    fs::remove_file(desk.path("out/0007.png")).unwrap();
    let state = desk.run("job job.json").done().stdout;
    assert!(state.contains("missing: 3,6"), "{state}");
    let parts =
        "piece 3: out/0004.png has changed; run it again | piece 6: cannot read out/0007.png";
    desk.fails("job job.json --merge", 1, parts);
    for number in [3, 6] {
        piece(&desk, number).done();
    }
    desk.run("job job.json --merge").done();
    assert!(fs::read(desk.path("out/0004.png")).unwrap() == expected);
}

#[test]
fn pieces_of_something_else_are_refused() {
    let desk = planned("-o out/%04d.png");
    assert_eq!(all_pieces(&desk), 6);
    let file = |number: usize| desk.path(&format!("job.pieces/{number:04}.json"));
    let kept = fs::read(file(2)).unwrap();
    // The same piece twice.
    fs::copy(file(1), file(2)).unwrap();
    desk.fails(
        "job job.json --merge",
        1,
        "0002.json is piece 1, a second time | remove it",
    );
    fs::write(file(2), "{").unwrap();
    desk.fails(
        "job job.json --merge",
        1,
        "0002.json is damaged | run piece 2 again",
    );
    let other = String::from_utf8(kept.clone())
        .unwrap()
        .replacen("\"job\":\"", "\"job\":\"0", 1);
    fs::write(file(2), other).unwrap();
    desk.fails("job job.json --merge", 1, "0002.json is of another plan");
    desk.fails("job job.json --piece 2", 1, "0002.json is of another plan");
    fs::write(file(2), kept).unwrap();
    desk.run("job job.json --merge").done();
    // A plan does not replace one whose pieces are there.
    let plan = format!("{FRAMES} -o out/%04d.png --plan job.json");
    desk.fails(
        &plan,
        1,
        "job.pieces has pieces of an earlier plan | remove",
    );
    let plan = format!("{FRAMES} -o out/%04d.png --plan scene.toml");
    desk.fails(&plan, 1, "scene.toml does not end in .json");
    desk.fails("job job.json --piece 7", 1, "pieces 1 to 6");
    desk.fails("job none.json", 1, "none.json");
    desk.write("no.json", "{}");
    desk.fails("job no.json", 1, "no.json is no job file | --plan");
}

#[test]
fn a_changed_scene_and_another_program_are_refused() {
    let desk = planned("-o out/%04d.png");
    piece(&desk, 1).done();
    let scene = fs::read_to_string(desk.path("scene.toml")).unwrap();
    desk.write("scene.toml", scene.replace("2.3", "2.4"));
    for what in ["--piece 2", "--merge"] {
        desk.fails(
            &format!("job job.json {what}"),
            1,
            "scene.toml has changed | plan again",
        );
    }
    desk.write("scene.toml", scene);
    let job = fs::read_to_string(desk.path("job.json")).unwrap();
    for (old, new) in [
        ("\"version\": \"", "\"version\": \"9."),
        ("\"program\": \"", "\"program\": \"0"),
    ] {
        desk.write("job.json", job.replacen(old, new, 1));
        desk.fails(
            "job job.json --piece 2",
            1,
            "another build of relievo | plan again",
        );
    }
    desk.write(
        "job.json",
        job.replacen("\"folder\": \"", "\"folder\": \"/none", 1),
    );
    desk.fails(
        "job job.json --piece 2",
        1,
        "this machine cannot enter | share",
    );
}

/// A killed piece leaves nothing that looks done, and no rest of a file.
#[cfg(unix)]
#[test]
fn a_killed_piece_is_done_again() {
    let desk = Desk::new();
    write_scene(&desk);
    let size = "--size 640x480";
    let plan = format!("{FRAMES} {size} -o out/%04d.png --plan job.json");
    desk.run(&plan).done();
    for signal in ["-KILL", "-TERM"] {
        let mut command = std::process::Command::new(crate::program());
        command.args(["job", "job.json", "--piece", "1"]);
        command.current_dir(desk.0.path()).stdout(Stdio::null());
        let mut running = command.spawn().unwrap();
        let start = Instant::now();
        while !desk.path("out/0002.png").exists() {
            assert!(start.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(5));
        }
        let id = running.id().to_string();
        let killed = std::process::Command::new("kill")
            .args([signal, &id])
            .status();
        assert!(killed.unwrap().success());
        running.wait().unwrap();
        assert!(!desk.path("job.pieces/0001.json").exists());
        desk.fails("job job.json --merge", 1, "missing: 1");
        fs::remove_dir_all(desk.path("out")).unwrap();
    }
    piece(&desk, 1).done();
    desk.run("job job.json --merge").done();
    assert_eq!(fs::read_dir(desk.path("out")).unwrap().count(), 6);
}

/// The commands that print: joined pieces print what one run prints.
#[test]
fn printed_results_are_those_of_one_run() {
    let [torus, blob] = ["scenes/torus.toml", "scenes/blob.toml"].map(asset);
    let assets = asset("");
    let verify = format!(
        "verify {} {} --size 48x36 --inputs 50",
        torus.display(),
        blob.display()
    );
    let budget = format!(
        "bench budget --scenes 3 --size 40x30 --backend cpu --assets {}",
        assets.display()
    );
    for command in [verify, "bounds --inputs 200".to_string(), budget] {
        if crate::left_out(&command).is_some() {
            continue;
        }
        let desk = Desk::new();
        let run = |arguments: String| {
            Outcome::of(desk.command().args(arguments.split_whitespace())).done()
        };
        let whole = run(command.clone()).stdout;
        run(format!("{command} --plan job.json --piece-seconds 0.2"));
        all_pieces(&desk);
        assert_eq!(
            desk.run("job job.json --merge").done().stdout,
            whole,
            "{command}"
        );
    }
}

/// But for times, a sweep in pieces gives the table of one run.
#[cfg(feature = "studies")]
#[test]
fn a_sweep_in_pieces_is_that_of_one_run() {
    let desk = Desk::new();
    let scene = asset("scenes/torus.toml");
    let sweep = |output: &str| {
        let scene = scene.display();
        format!("tradeoff {scene} --quick --size 32x24 --backend cpu --frames 1 -o {output}")
    };
    desk.run(&format!(
        "{} --plan job.json --piece-seconds 2",
        sweep("parts")
    ))
    .done();
    let count = all_pieces(&desk);
    // A damaged line is measured again.
    let file = desk.path(&format!("job.pieces/measurements-1-of-{count}.jsonl"));
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() - 20]).unwrap();
    desk.fails(
        "job job.json --merge",
        1,
        "piece 1: | has changed; run it again",
    );
    let again = piece(&desk, 1).done().stdout;
    assert!(again.contains("variants measured: 1"), "{again}");
    desk.run("job job.json --merge").done();
    desk.run(&sweep("whole")).done();
    let table = |folder: &str| -> Vec<Vec<String>> {
        let text = fs::read_to_string(desk.path(&format!("{folder}/tradeoff.csv"))).unwrap();
        let mut lines = text.lines();
        let header: Vec<&str> = lines.next().unwrap().split(',').collect();
        let timed = ["time", "quartile", "_ms", "frames", "front"];
        let is_timed = |name: &str| timed.iter().any(|part| name.contains(part));
        let untimed: Vec<usize> = (0..header.len())
            .filter(|&i| !is_timed(header[i]))
            .collect();
        let of_line = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            untimed.iter().map(|&i| cells[i].to_string()).collect()
        };
        lines.map(of_line).collect()
    };
    assert_eq!(table("whole"), table("parts"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_no_piece() {
    let desk = Desk::new();
    write_scene(&desk);
    // Its own mounts: only this process sees the small disk.
    let script = "mkdir small && mount -t tmpfs -o size=24k none small || exit 77; \
        \"$0\" job job.json --piece 1; code=$?; ls -A small job.pieces; exit $code";
    let plan = format!("{FRAMES} -o small/%04d.png --plan job.json");
    desk.run(&plan).done();
    let mut command = assert_cmd::Command::new("unshare");
    command.args(["--mount", "--map-root-user", "sh", "-c", script]);
    let outcome = Outcome::of(command.arg(crate::program()).current_dir(desk.0.path()));
    if outcome.code == Some(77) || outcome.stderr.contains("unshare") {
        println!("NOT TESTED: this machine lets nobody mount a disk");
        return;
    }
    assert_eq!(outcome.code, Some(3), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("small/"), "{}", outcome.stderr);
    assert!(
        !outcome.stdout.contains(".json") && !outcome.stdout.contains(".part"),
        "{}",
        outcome.stdout
    );
}

/// What would be submitted to Slurm.
#[test]
fn the_missing_pieces_are_an_array() {
    let desk = planned("-o out/%04d.png");
    piece(&desk, 2).done();
    let told = desk
        .run("submit job.json --slurm --dry-run -- --partition=main")
        .done()
        .stdout;
    for part in [
        "'--array=1,3-6'",
        "'--requeue'",
        "'--partition=main'",
        "--dependency=afterany:JOB",
        "--merge",
        "--mem=",
        "--time=6",
    ] {
        assert!(told.contains(part), "{part}\n{told}");
    }
    let outcome = Outcome::of(
        desk.command()
            .env("PATH", "")
            .args(["submit", "job.json", "--slurm"]),
    );
    assert_eq!(outcome.code, Some(1));
    assert!(
        outcome.stderr.contains("cannot run sbatch"),
        "{}",
        outcome.stderr
    );
}
