//! What Mesa's compiler for AMD makes of every shader, for two generations of GPUs that
//! need not be there: as in the committed table, without spilled registers, and exact
//! where the module is.
//!
//! `RELIEVO_UPDATE_GOLDEN=1` accepts what it makes now.

mod page;
mod process;

use process::{Answer, Job, Made, Process};
use relievo_compiled::{Allowed, GENERATIONS, Shader, manifest};
use relievo_shaders::Compiled;
use relievo_shared::{for_each_facet, for_each_search};
use relievo_tests::{lacking, root};
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

/// Shaders that spill scalar registers to lanes of vector ones, by generation and folder.
/// They must become fewer.
const SPILL: [(&str, &str, &[&str]); 10] = [
    // Four to ten registers.
    ("RDNA2", "relievo_exact", PRISMS),
    // Six registers and one.
    ("RDNA2", "relievo_fused", PRISMS.split_at(2).0),
    // Four registers.
    ("RDNA2", "relievo_fast", PRISMS.split_at(1).0),
    // As those of one pattern.
    ("RDNA2", "relievo_exact", LAYERS),
    ("RDNA2", "relievo_fused", LAYERS.split_at(2).0),
    ("RDNA2", "relievo_fast", LAYERS.split_at(1).0),
    // Six registers, 14 in the fused module and 22 in the exact one.
    ("RDNA2", "relievo_exact", &["shade_edges"]),
    ("RDNA2", "relievo_fused", &["shade_edges"]),
    ("RDNA2", "relievo_fast", &["shade_edges"]),
    // Three registers. These devices fuse sums, and shade with the fused module.
    ("RDNA3", "relievo_exact", &["shade_edges"]),
];
const PRISMS: &[&str] = &[
    "surface_prisms_straight",
    "color_prisms_straight_shadow",
    "color_prisms_straight",
    "geometry_prisms_straight",
    "surface_prisms",
];
const LAYERS: &[&str] = &[
    "surface_prisms_layers",
    "color_prisms_layers_shadow",
    "color_prisms_layers",
    "geometry_prisms_layers",
];

/// The folders of the renderer's modules.
const RENDERERS: [&str; 3] = ["relievo_exact", "relievo_fused", "relievo_fast"];

/// The folders of the modules of single functions.
const KERNELS: [&str; 2] = ["kernels_exact", "kernels_fused"];

/// A module that is broken on purpose.
const BROKEN: &str = "without decorations";

/// Returns what the assembly of a module may contain beside exact operations; `None` if
/// anything.
fn allowed(folder: &str, shader: &Shader) -> Option<Allowed> {
    // Divisions, roots and fused sums are those that the module asks for: the builder allows
    // them only where results are corrected, and in canaries.
    let is_exact = folder != "relievo_fast";
    is_exact.then(|| Allowed::asked_by(shader))
}

fn path(folder: &str, entry_point: &str) -> PathBuf {
    let name = format!("assets/shaders/{folder}/{entry_point}.spv");
    root().join(name)
}

/// The shaders of a folder of the renderer, as they are compiled: fragment shaders with the
/// vertex shader that they are drawn with, and compute shaders.
fn programs(folder: &str) -> Vec<Vec<&'static str>> {
    macro_rules! facets {
        ($($facet:ident $outlines:ident $vertex:ident;)*) => {
            [$((stringify!($facet), stringify!($outlines), stringify!($vertex))),*]
        };
    }
    let facets = for_each_facet!(facets);
    macro_rules! fragments {
        ($($search:ident: $model:ident over $facet:ident $(given $given:ident)?
            draws $color:ident $shadow:ident $geometry:ident $surface:ident $hit:ident
            tiers { $($tiers:tt)* }
            special { $($facts:expr => $special:ident over $special_facet:ident $(through $words:ident)?
                draws $special_color:ident $special_shadow:ident $special_geometry:ident $special_surface:ident $special_hit:ident;)* })*) => {
            vec![$(
                (stringify!($facet), [stringify!($color), stringify!($shadow),
                    stringify!($geometry), stringify!($surface)]),
                $((stringify!($special_facet), [stringify!($special_color),
                    stringify!($special_shadow), stringify!($special_geometry),
                    stringify!($special_surface)]),)*
            )*]
        };
    }
    let fragments = for_each_search!(fragments);
    let mut programs = vec![
        vec!["outlines_exits"],
        vec!["place", "exits"],
        vec!["screen", "shade"],
        vec!["screen", "mean"],
        vec!["screen", "shade_edges"],
    ];
    programs.extend(facets.map(|(_, outlines, _)| vec![outlines]));
    for (_, names) in &fragments {
        programs.extend(names.map(|fragment| vec!["place", fragment]));
    }
    if folder == "relievo_fast" {
        // Exports find outlines in their vertex shader.
        for (facet, _, vertex) in facets {
            let drawn = fragments.iter().find(|(over, _)| *over == facet);
            let (_, [color, ..]) = drawn.expect("a model is drawn over it");
            programs.push(vec![vertex, color]);
        }
    }
    programs
}

/// Everything that is compiled.
fn jobs() -> Vec<Job> {
    let renderers = RENDERERS.into_iter().flat_map(|folder| {
        let job = move |names: Vec<&str>| Job {
            folder,
            files: names.iter().map(|name| path(folder, name)).collect(),
        };
        programs(folder).into_iter().map(job)
    });
    let kernels = KERNELS.into_iter().flat_map(|folder| {
        files(folder).into_iter().map(move |name| Job {
            folder,
            files: vec![path(folder, &name)],
        })
    });
    let broken = Job {
        folder: BROKEN,
        files: vec![path("relievo_exact", "place"), broken("color_curved")],
    };
    renderers.chain(kernels).chain([broken]).collect()
}

/// The entry points of a folder.
fn files(folder: &str) -> BTreeSet<String> {
    let files = fs::read_dir(root().join("assets/shaders").join(folder)).unwrap();
    let name = |path: PathBuf| path.file_stem().unwrap().to_str().unwrap().to_string();
    files.map(|file| name(file.unwrap().path())).collect()
}

/// An exact module without its decorations, in a file.
fn broken(name: &str) -> PathBuf {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| tempfile::tempdir().unwrap());
    let bytes = fs::read(path("relievo_exact", name)).unwrap();
    let words: Vec<u32> = bytes
        .as_chunks::<4>()
        .0
        .iter()
        .copied()
        .map(u32::from_le_bytes)
        .collect();
    let (bare, count) = crate::twins::stripped_file(&words);
    assert!(count > 100, "{name}: {count}");
    let bytes: Vec<u8> = bare.iter().flat_map(|word| word.to_le_bytes()).collect();
    let file = folder.path().join(format!("{name}.spv"));
    fs::write(&file, bytes).unwrap();
    file
}

/// What was made for a generation.
struct Measured {
    generation: &'static str,
    answer: Answer,
}

/// Compiles everything, once for all tests; `None`, with a message, where no driver can.
fn measured() -> Option<&'static [Measured]> {
    static ALL: OnceLock<Result<Vec<Measured>, String>> = OnceLock::new();
    let all = ALL.get_or_init(|| {
        let manifest = manifest().ok_or("mesa-vulkan-drivers is not installed")?;
        let jobs = jobs();
        // Both at once.
        let started = GENERATIONS.each_ref().map(|generation| {
            let process = Process::start(generation, &manifest, &jobs);
            (generation.name, process)
        });
        let finish = |(generation, process): (_, Process)| {
            let answer = process.finish()?;
            Ok(Measured { generation, answer })
        };
        started.into_iter().map(finish).collect()
    });
    match all {
        Ok(all) => Some(all),
        Err(error) => {
            lacking(&format!("a Mesa driver for AMD ({error})"));
            None
        }
    }
}

/// The row of a module.
fn row<'a>(generation: &'a str, made: &'a Made) -> Compiled<'a> {
    let number = |name| {
        let value = made.statistics.get(name);
        *value.unwrap_or_else(|| panic!("the driver does not say its {name}")) as u32
    };
    Compiled {
        generation,
        folder: &made.folder,
        entry_point: &made.entry_point,
        vgprs: number("VGPRs"),
        // Those in use, not the 128 that every wave has.
        sgprs: number("Pre-Sched SGPRs"),
        spilled_vgprs: number("Spilled VGPRs"),
        spilled_sgprs: number("Spilled SGPRs"),
        scratch: number("Scratch size"),
        waves: number("Subgroups per SIMD"),
        instructions: number("Instructions"),
        latency: number("Latency"),
        throughput: number("Inverse Throughput"),
        bytes: number("Code size"),
    }
}

/// The table of what was made.
fn table(all: &[Measured]) -> String {
    let mut rows = Vec::new();
    let mut seen = BTreeSet::new();
    for &Measured {
        generation,
        ref answer,
    } in all
    {
        for made in &answer.made {
            // A vertex shader is drawn with several fragment shaders.
            let is_new = seen.insert((generation, &made.folder, &made.entry_point));
            if is_new && RENDERERS.contains(&made.folder.as_str()) {
                rows.push(row(generation, made).to_string());
            }
        }
    }
    rows.sort();
    let drivers: BTreeSet<&str> = all.iter().map(|one| one.answer.driver.as_str()).collect();
    let drivers: Vec<&str> = drivers.into_iter().collect();
    let (drivers, columns) = (drivers.join(", "), Compiled::COLUMNS);
    format!("# {drivers}\n{columns}\n{}\n", rows.join("\n"))
}

/// The committed table.
fn committed() -> String {
    let file = root().join("assets/shaders/registers.csv");
    fs::read_to_string(file).unwrap().replace("\r\n", "\n")
}

/// Whether the committed table was made with the compiler that is here; if not, says so.
fn is_compiler_known(all: &[Measured]) -> bool {
    let (now, known) = (table(all), committed());
    let (now, known) = (compiler(&now), compiler(&known));
    if now != known {
        eprintln!("NOT COMPARED: the table is of {known}, and {now} is here");
    }
    now == known
}

/// The compiler that a table was made with.
fn compiler(table: &str) -> &str {
    let line = table.lines().next().unwrap_or_default();
    line.trim_start_matches("# ")
}

fn is_updating() -> bool {
    std::env::var_os("RELIEVO_UPDATE_GOLDEN").is_some()
}

#[test]
fn every_shader_is_compiled() {
    for folder in RENDERERS {
        let compiled: BTreeSet<&str> = programs(folder).into_iter().flatten().collect();
        let files = files(folder);
        // What exports turn into functions is compiled in the shaders of engines.
        let is_drawn = |name: &&str| !name.starts_with("hit_");
        let files: BTreeSet<&str> = files.iter().map(String::as_str).filter(is_drawn).collect();
        assert_eq!(files, compiled, "{folder}");
    }
}

#[test]
fn the_table_says_what_the_compiler_makes() {
    let Some(all) = measured() else { return };
    let now = table(all);
    if is_updating() {
        fs::write(root().join("assets/shaders/registers.csv"), &now).unwrap();
        fs::write(page::path(), page::pages(&now).0).unwrap();
    }
    let known = committed();
    if !is_compiler_known(all) {
        return;
    }
    let rows: [BTreeSet<&str>; 2] = [&known, &now].map(|table| table.lines().collect());
    let gone = rows[0].difference(&rows[1]).map(|row| format!("- {row}"));
    let new = rows[1].difference(&rows[0]).map(|row| format!("+ {row}"));
    let changes: Vec<String> = gone.chain(new).collect();
    assert!(
        now == known,
        "the compiler makes something else of these shaders; if that is meant, accept it with \
         RELIEVO_UPDATE_GOLDEN=1:\n  {}\n{}",
        Compiled::COLUMNS,
        changes.join("\n")
    );
}

#[test]
fn no_shader_spills_registers() {
    let Some(all) = measured() else { return };
    let table = table(all);
    for row in Compiled::rows(&table) {
        // Shading is a pass of its own: what counts is how many of its waves fit. These
        // devices fuse sums, and draw no prisms with the modules that do not.
        let may_be_large = row.entry_point.starts_with("shade")
            || row.folder == "relievo_exact" && row.entry_point.contains("prisms");
        let has_room = row.vgprs <= 128 || (may_be_large && row.waves >= 8);
        let fits = has_room && row.spilled_vgprs == 0 && row.scratch == 0;
        assert!(fits, "{row}");
    }
    let spill: BTreeSet<[&str; 3]> = Compiled::rows(&table)
        .filter(Compiled::spills)
        .map(|row| [row.generation, row.folder, row.entry_point])
        .collect();
    let known: BTreeSet<[&str; 3]> = SPILL
        .into_iter()
        .flat_map(|(generation, folder, names)| {
            names.iter().map(move |name| [generation, folder, name])
        })
        .collect();
    let new: Vec<_> = spill.difference(&known).collect();
    assert!(new.is_empty(), "these shaders spill: {new:?}");
    // Another compiler may do without.
    let gone: Vec<_> = known.difference(&spill).collect();
    assert!(
        gone.is_empty() || !is_compiler_known(all),
        "these shaders spill no more, take them from the list: {gone:?}"
    );
}

/// What is not exact in the modules of the folders `wanted`, and how many modules they have.
fn faults(measured: &Measured, wanted: &[&str]) -> (usize, Vec<String>) {
    let (mut count, mut found) = (0, Vec::new());
    let made = measured.answer.made.iter();
    for made in made.filter(|made| wanted.contains(&made.folder.as_str())) {
        let faults = made.faults.as_ref().expect("it is checked");
        let place = format!(
            "{}, {}/{}",
            measured.generation, made.folder, made.entry_point
        );
        found.extend(faults.iter().map(|fault| format!("{place}: {fault}")));
        count += 1;
    }
    (count, found)
}

#[test]
fn exact_modules_stay_exact_when_compiled() {
    let Some(all) = measured().filter(|all| is_compiler_known(all)) else {
        return;
    };
    for measured in all {
        let folders = [RENDERERS[0], RENDERERS[1], KERNELS[0], KERNELS[1]];
        let (count, found) = faults(measured, &folders);
        assert!(count > 200, "{count}");
        assert!(found.is_empty(), "{}", found.join("\n"));
    }
}

#[test]
fn a_module_without_decorations_is_caught_when_compiled() {
    let Some(all) = measured().filter(|all| is_compiler_known(all)) else {
        return;
    };
    for measured in all {
        let (count, found) = faults(measured, &[BROKEN]);
        let with = |part: &str| found.iter().filter(|fault| fault.contains(part)).count();
        let (fused, free) = (
            with("fused products that round"),
            with("not marked precise"),
        );
        assert_eq!(count, 2);
        assert!(fused > 100 && free > 100, "{fused}, {free}");
        eprintln!(
            "{}: {fused} fused, {free} not marked precise",
            measured.generation
        );
    }
}

#[test]
fn the_page_shows_the_table() {
    // Together with the table, in its test.
    if !is_updating() {
        let (wanted, page) = page::pages(&committed());
        assert!(
            wanted == page,
            "RELIEVO_UPDATE_GOLDEN=1 renews docs/registers.md"
        );
    }
}
