use crate::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A folder with files.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Folder {
        let folder = Folder(tempfile::tempdir().unwrap());
        for (name, text) in files {
            folder.write(name, text);
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        std::fs::write(self.path(name), text).unwrap();
    }

    /// Replaces a part of a file.
    fn edit(&self, name: &str, from: &str, to: &str) {
        let text = std::fs::read_to_string(self.path(name)).unwrap();
        assert!(text.contains(from), "{name}: {text}");
        self.write(name, &text.replace(from, to));
    }
}

/// Reads a project of a `Cargo.toml` alone.
fn project(text: &str) -> Result<Project, String> {
    let folder = Folder::new(&[
        ("Cargo.toml", text),
        ("shader/Cargo.toml", ""),
        ("second/Cargo.toml", ""),
    ]);
    Project::load(&folder.path("Cargo.toml")).map_err(|error| {
        let error = error.to_string();
        assert!(error.contains("Cargo.toml"), "{error}");
        error
    })
}

#[test]
fn a_package_is_its_own_shader_crate() {
    let text = "[package]\nname = \"my-noise\"\n[package.metadata.relievo]\n";
    let read = project(text).unwrap();
    assert_eq!((read.shaders.as_str(), read.also.len()), ("shaders", 0));
    let [only] = read.crates.as_slice() else {
        panic!()
    };
    assert_eq!((only.path.as_str(), only.name.as_str()), (".", "my_noise"));
    assert_eq!(
        (&only.folder, only.about.as_str()),
        (&read.root, "my_noise")
    );
    assert_eq!(read.shader_folder(), read.root.join("shaders"));
}

#[test]
fn a_workspace_names_its_shader_crates() {
    let section = "[workspace.metadata.relievo]\nshaders = \"a/b\"\nalso = [\"x/y.toml\"]\n";
    let crates = "crates = [{ path = \"shader\", name = \"one\", about = \"first\" }, { path = \"second\", name = \"two\" }]\n";
    let read = project(&format!("{section}{crates}")).unwrap();
    assert_eq!(
        (read.shaders.as_str(), &read.also),
        ("a/b", &vec!["x/y.toml".to_string()])
    );
    let crates: Vec<_> = read
        .crates
        .iter()
        .map(|c| (c.name.as_str(), c.about.as_str()))
        .collect();
    assert_eq!(crates, [("one", "first"), ("two", "two")]);
    assert_eq!(read.crates[1].folder, read.root.join("second"));
}

#[test]
fn wrong_sections_are_refused_with_the_way_out() {
    let head = "[workspace.metadata.relievo]\n";
    let package = "[package]\nname = \"a\"\n";
    let refused = [
        (package.to_string(), "add one, such as"),
        (
            format!("{package}[package.metadata.relievo]\n{head}"),
            "remove one",
        ),
        (head.to_string(), "name the shader crates"),
        (format!("{head}crates = []\n"), "name a crate"),
        (
            format!("{head}shader = \"a\"\n"),
            "unknown field `shader`, expected one of `shaders`",
        ),
        (format!("{head}shaders = 1\n"), "expected a string"),
        (
            format!("{head}crates = [{{ path = \"shader\" }}]"),
            "missing field `name`",
        ),
        (
            format!("{head}crates = [{{ path = \"shader\", name = \"a\", x = 1 }}]"),
            "unknown field `x`",
        ),
        (
            format!("{head}crates = [{{ path = \"shader\", name = \"a b\" }}]"),
            "letters, digits",
        ),
        (
            format!("{head}crates = [{{ path = \"none\", name = \"a\" }}]"),
            "no none/Cargo.toml",
        ),
        (
            format!(
                "{head}crates = [{{ path = \"shader\", name = \"a\" }}, {{ path = \"second\", name = \"A\" }}]"
            ),
            "two have the name \"A\"",
        ),
        (
            format!("{package}[package.metadata.relievo]\nshaders = \"../a\"\n"),
            "shaders: \"../a\"",
        ),
        (
            format!("{package}[package.metadata.relievo]\nalso = [\"/a\"]\n"),
            "also: \"/a\"",
        ),
        ("[".to_string(), "TOML"),
    ];
    for (text, expected) in refused {
        let error = project(&text).unwrap_err();
        assert!(error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn the_project_of_a_folder_is_the_first_with_a_section() {
    let folder = Folder::new(&[
        (
            "Cargo.toml",
            "[package]\nname = \"a\"\n[package.metadata.relievo]\n",
        ),
        ("b/Cargo.toml", "[package]\nname = \"b\"\n"),
        ("b/src/lib.rs", ""),
    ]);
    let found = Project::find(&folder.path("b/src")).unwrap();
    assert_eq!(found.crates[0].name, "a");
    folder.edit("Cargo.toml", "[package.metadata.relievo]", "");
    let error = Project::find(&folder.path("b/src"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("--manifest-path"), "{error}");
}

/// A checkout with a library, its tools for tests and its build script; and a workspace of a
/// user beside it, with a shader crate that depends on it.
fn checkout_and_user() -> (Folder, Project) {
    let folder = Folder::new(&[
        (
            "checkout/Cargo.toml",
            "[workspace]\nmembers = [\"exact\", \"tools\"]\n[workspace.package]\nedition = \"2024\"\n[workspace.dependencies]\nglam = { version = \"0.34\", features = [\"u32\"] }\nserde = \"1\"\n",
        ),
        (
            "checkout/exact/Cargo.toml",
            "[package]\nname = \"exact\"\nversion = \"0.1.0\"\nedition.workspace = true\n[dependencies]\nglam.workspace = true\n[dev-dependencies]\ntools = { path = \"../tools\" }\nserde.workspace = true\n",
        ),
        ("checkout/exact/src/lib.rs", "pub mod deep;"),
        ("checkout/exact/src/deep/mod.rs", ""),
        ("checkout/exact/src/deep/tests.rs", ""),
        ("checkout/exact/build.rs", "fn main() {}"),
        ("checkout/exact/tests/all.rs", ""),
        (
            "checkout/tools/Cargo.toml",
            "[package]\nname = \"tools\"\nversion = \"0.1.0\"\n",
        ),
        ("checkout/tools/src/lib.rs", ""),
        (
            "user/Cargo.toml",
            "[package]\nname = \"user\"\nversion = \"0.1.0\"\n[workspace]\nmembers = [\"near\", \"optional\"]\n[dependencies]\nexact = { path = \"../checkout/exact\" }\nnear = { path = \"near\" }\n[target.'cfg(target_arch = \"spirv\")'.dependencies]\noptional = { path = \"optional\", optional = true }\n[dev-dependencies]\nserde = \"1\"\n[profile.release]\nopt-level = 3\n[package.metadata.relievo]\nalso = [\"table.txt\", \"more\"]\n",
        ),
        ("user/src/lib.rs", "pub mod light;"),
        ("user/src/light.rs", ""),
        ("user/table.txt", "1"),
        ("user/more/one.rs", ""),
        ("user/more/notes.txt", ""),
        (
            "user/near/Cargo.toml",
            "[package]\nname = \"near\"\nversion = \"0.1.0\"\n[lib]\npath = \"lib.rs\"\n",
        ),
        ("user/near/lib.rs", ""),
        (
            "user/near/inner/Cargo.toml",
            "[package]\nname = \"inner\"\nversion = \"0.1.0\"\n",
        ),
        ("user/near/inner/src/lib.rs", ""),
        (
            "user/optional/Cargo.toml",
            "[package]\nname = \"optional\"\nversion = \"0.1.0\"\n",
        ),
        ("user/optional/src/lib.rs", ""),
        ("user/Cargo.lock", LOCK),
    ]);
    let project = Project::load(&folder.path("user/Cargo.toml")).unwrap();
    (folder, project)
}

/// As cargo writes it: with what tests need, and with two packages of one name.
const LOCK: &str = r#"version = 4

[[package]]
name = "exact"
version = "0.1.0"
dependencies = ["glam", "serde", "tools"]

[[package]]
name = "glam"
version = "0.34.2"
source = "registry+https://github.com/rust-lang/crates.io-index"
checksum = "aaaa"
dependencies = ["libm 0.2.1"]

[[package]]
name = "libm"
version = "0.1.9"
source = "registry+https://github.com/rust-lang/crates.io-index"
checksum = "bbbb"

[[package]]
name = "libm"
version = "0.2.1"
source = "registry+https://github.com/rust-lang/crates.io-index"
checksum = "cccc"

[[package]]
name = "near"
version = "0.1.0"

[[package]]
name = "optional"
version = "0.1.0"

[[package]]
name = "serde"
version = "1.0.0"
source = "registry+https://github.com/rust-lang/crates.io-index"
checksum = "dddd"

[[package]]
name = "tools"
version = "0.1.0"

[[package]]
name = "user"
version = "0.1.0"
dependencies = ["exact", "near", "optional", "serde"]
"#;

#[test]
fn sources_are_found_by_following_dependencies() {
    let (folder, project) = checkout_and_user();
    let digests = source_digests(&project).unwrap();
    let names: Vec<&str> = digests.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "Cargo.toml",
            "Cargo.toml: metadata.relievo",
            "exact/Cargo.toml",
            "exact/build.rs",
            "exact/src/deep/mod.rs",
            "exact/src/lib.rs",
            "exact: what it inherits",
            "more/one.rs",
            "near/Cargo.toml",
            "near/lib.rs",
            "optional/Cargo.toml",
            "optional/src/lib.rs",
            "src/lib.rs",
            "src/light.rs",
            "table.txt",
            "user: locked dependencies",
            "user: profile, resolver and patches",
        ]
    );
    assert_eq!(digests["src/light.rs"], digest(b""));
    // Only what is asked for is written.
    assert!(!folder.path("user/target").exists() && !folder.path("checkout/Cargo.lock").exists());
}

/// Returns the sources that an edit changes.
fn seen(edit: impl Fn(&Folder)) -> BTreeSet<String> {
    let (folder, project) = checkout_and_user();
    let before = source_digests(&project).unwrap();
    edit(&folder);
    let project = Project::load(&project.manifest_path).unwrap();
    let after = source_digests(&project).unwrap();
    let name = |change: String| {
        let end = change.rfind(": ").unwrap();
        change[..end].to_string()
    };
    changed_sources(&before, &after)
        .into_iter()
        .map(name)
        .collect()
}

#[test]
fn what_decides_the_modules_is_seen() {
    let is_seen = |file: &str, from: &str, to: &str, expected: &[&str]| {
        let names = seen(|folder| {
            if from.is_empty() {
                folder.write(file, to);
            } else {
                folder.edit(file, from, to);
            }
        });
        assert_eq!(
            names,
            expected.iter().map(ToString::to_string).collect(),
            "{file}: {to}"
        );
    };
    is_seen("user/src/light.rs", "", "// A", &["src/light.rs"]);
    is_seen("user/src/new.rs", "", "", &["src/new.rs"]);
    is_seen("user/table.txt", "1", "2", &["table.txt"]);
    is_seen(
        "user/optional/src/lib.rs",
        "",
        "// A",
        &["optional/src/lib.rs"],
    );
    // Outside the project.
    is_seen(
        "checkout/exact/src/deep/mod.rs",
        "",
        "// A",
        &["exact/src/deep/mod.rs"],
    );
    is_seen(
        "checkout/exact/build.rs",
        "main() {}",
        "main() { }",
        &["exact/build.rs"],
    );
    let inherited = "exact: what it inherits";
    is_seen("checkout/Cargo.toml", "\"u32\"", "\"i32\"", &[inherited]);
    is_seen("checkout/Cargo.toml", "2024", "2021", &[inherited]);
    // Versions and checksums.
    let locked = "user: locked dependencies";
    is_seen("user/Cargo.lock", "0.34.2", "0.34.3", &[locked]);
    is_seen("user/Cargo.lock", "cccc", "eeee", &[locked]);
    is_seen(
        "user/Cargo.lock",
        "index\"\nchecksum = \"cccc",
        "fork\"\nchecksum = \"cccc",
        &[locked],
    );
    // What the project's Cargo.toml says of its code, and its sections.
    let own = "Cargo.toml";
    let section = "Cargo.toml: metadata.relievo";
    is_seen(
        "user/Cargo.toml",
        "near = {",
        "near = { features = [\"a\"],",
        &[own],
    );
    is_seen("user/Cargo.toml", ", optional = true", "", &[own]);
    is_seen(
        "user/Cargo.toml",
        ", \"more\"",
        "",
        &[section, "more/one.rs"],
    );
    let profile = "user: profile, resolver and patches";
    is_seen(
        "user/Cargo.toml",
        "opt-level = 3",
        "opt-level = 2",
        &[profile],
    );
}

#[test]
fn what_only_tests_need_is_not_seen() {
    let unseen: [(&str, &str, &str); 10] = [
        (
            "checkout/tools/src/lib.rs",
            "",
            "// A comment in a dev-dependency.",
        ),
        ("checkout/exact/src/deep/tests.rs", "", "// A"),
        ("checkout/exact/tests/all.rs", "", "// A"),
        ("checkout/Cargo.toml", "serde = \"1\"", "serde = \"1.1\""),
        ("user/Cargo.toml", "serde = \"1\"", "serde = \"1.1\""),
        ("user/Cargo.toml", "[dependencies]", "# A\n[dependencies]"),
        (
            "user/Cargo.toml",
            "path = \"near\"",
            "path = \"../user/near\"",
        ),
        ("user/src/lib.rs", "pub mod light;", "pub mod light;\r"),
        ("user/Cargo.lock", "dddd", "ffff"),
        ("user/Cargo.lock", "bbbb", "ffff"),
    ];
    for (file, from, to) in unseen {
        let names = seen(|folder| {
            if from.is_empty() {
                folder.write(file, to);
            } else {
                folder.edit(file, from, to);
            }
        });
        assert!(names.is_empty(), "{file}: {names:?}");
    }
}

#[test]
fn a_package_in_the_place_of_another_is_a_source() {
    let names = seen(|folder| {
        folder.write(
            "glam/Cargo.toml",
            "[package]\nname = \"glam\"\nversion = \"0.34.2\"\n",
        );
        folder.write("glam/src/lib.rs", "");
        folder.edit(
            "user/Cargo.toml",
            "[dev-dependencies]",
            "[patch.crates-io]\nglam = { path = \"../glam\" }\n[dev-dependencies]",
        );
    });
    assert!(names.contains("glam/src/lib.rs"), "{names:?}");
    assert!(
        names.contains("user: profile, resolver and patches"),
        "{names:?}"
    );
}

#[test]
fn missing_and_doubtful_files_are_errors() {
    let refused = |edit: &dyn Fn(&Folder)| {
        let (folder, project) = checkout_and_user();
        edit(&folder);
        source_digests(&project).unwrap_err().to_string()
    };
    let error = refused(&|folder| std::fs::remove_file(folder.path("user/Cargo.lock")).unwrap());
    assert!(error.contains("cargo generate-lockfile"), "{error}");
    let error =
        refused(&|folder| folder.edit("user/Cargo.lock", "name = \"glam\"", "name = \"other\""));
    assert!(error.contains("no package 'glam'"), "{error}");
    let error = refused(&|folder| std::fs::remove_file(folder.path("user/table.txt")).unwrap());
    assert!(error.contains("table.txt"), "{error}");
    // A folder of the project with the name of a package elsewhere.
    let error = refused(&|folder| {
        folder.write("user/exact/src/lib.rs", "");
        folder.write(
            "user/exact/Cargo.toml",
            "[package]\nname = \"inner\"\nversion = \"0.1.0\"\n",
        );
        folder.edit(
            "user/Cargo.toml",
            "\"optional\"]",
            "\"optional\", \"exact\"]",
        );
        folder.edit(
            "user/Cargo.toml",
            "near = {",
            "inner = { path = \"exact\" }\nnear = {",
        );
    });
    assert!(error.contains("rename a package"), "{error}");
}

/// A manifest of two modules, with these files and sources.
fn built(folder: &Path, project: &Project) -> Manifest {
    let bytes = b"words";
    let module = Module {
        sha256: digest(bytes),
        bytes: bytes.len() as u64,
    };
    let modules = ["user_fast/a.spv", "user_exact/a.spv"];
    for name in modules {
        let path = folder.join("shaders").join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    let text = |text: &str| text.to_string();
    Manifest {
        toolchain: Toolchain {
            rustc: text("rustc 1.99.0-nightly"),
            rust_gpu: text("0.11.0"),
            builder: text(VERSION),
            target: text("spirv-unknown-vulkan1.1"),
        },
        folders: BTreeMap::from([
            (text("user_fast"), text("user: fast")),
            (text("user_exact"), text("user: exact")),
        ]),
        modules: modules.map(|name| (text(name), module.clone())).into(),
        sources: source_digests(project).unwrap(),
    }
}

#[test]
fn every_difference_to_the_manifest_is_reported() {
    let (folder, project) = checkout_and_user();
    let error = changes(&project).unwrap_err().to_string();
    assert!(error.contains("cargo relievo build"), "{error}");
    let manifest = built(&folder.path("user"), &project);
    folder.write("user/shaders/manifest.toml", &manifest.to_text());
    assert_eq!(Manifest::load(&project).unwrap(), manifest);
    assert!(changes(&project).unwrap().is_empty());
    // No path of the machine.
    assert!(
        !manifest
            .to_text()
            .contains(folder.0.path().to_str().unwrap())
    );

    // Sources: changed, new, gone.
    let sources = &manifest.sources;
    for source in sources.keys() {
        let mut other = sources.clone();
        other.insert(source.clone(), digest(b"another text"));
        let changes = changed_sources(sources, &other);
        assert_eq!(changes.len(), 1);
        assert!(changes[0].starts_with(&format!("{source}: changed")));
        other.remove(source);
        assert!(changed_sources(sources, &other)[0].starts_with(&format!("{source}: gone")));
        assert!(changed_sources(&other, sources)[0].starts_with(&format!("{source}: new")));
    }

    // Modules: one bit, a byte more, unknown, missing.
    let module = folder.path("user/shaders/user_fast/a.spv");
    let report = || changes(&project).unwrap().join("\n");
    std::fs::write(&module, b"wordt").unwrap();
    assert_eq!(report(), "user_fast/a.spv: not the compiled module");
    std::fs::write(&module, b"words?").unwrap();
    assert_eq!(report(), "user_fast/a.spv: 6 bytes, but 5 in the manifest");
    std::fs::write(&module, b"words").unwrap();
    folder.write("user/shaders/user_fast/b.spv", "");
    assert_eq!(report(), "user_fast/b.spv: not in the manifest");
    std::fs::remove_dir_all(folder.path("user/shaders/user_fast")).unwrap();
    assert_eq!(report(), "user_fast/a.spv: missing");

    let manifest = Manifest {
        toolchain: Toolchain {
            builder: "0.0.9".to_string(),
            ..manifest.toolchain
        },
        ..manifest
    };
    folder.write("user/shaders/manifest.toml", &manifest.to_text());
    assert!(
        report().contains("version 0.0.9 made the modules"),
        "{}",
        report()
    );
    folder.write("user/shaders/manifest.toml", "[toolchain]\n");
    let error = changes(&project).unwrap_err().to_string();
    assert!(error.contains("write the file anew"), "{error}");
}

#[test]
fn keys_may_be_in_any_order() {
    let text = |crates: &str| format!("[workspace.metadata.relievo]\ncrates = [{{ {crates} }}]\n");
    let one = project(&text("path = \"shader\", name = \"a\"")).unwrap();
    let two = project(&text("name = \"a\", path = \"shader\"")).unwrap();
    assert_eq!(one.section, two.section);
    let other = project(&text("name = \"b\", path = \"shader\"")).unwrap();
    assert_ne!(one.section, other.section);
}
