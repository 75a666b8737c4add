//! Which files a scene may read.

use std::io;
use std::path::{Component, Path, PathBuf};

/// A folder of this name lies beside those with the meshes and patterns.
const SCENES: &str = "scenes";

/// The files that a scene may read.
pub(super) enum Reach {
    /// Every file.
    Anywhere,
    /// Those in this folder and below, without symbolic links.
    Below(PathBuf),
}

impl Reach {
    /// What a scene in `folder` may read: what is in there, or in the folder
    /// around it if it is called `scenes`.
    ///
    /// # Errors
    /// What the system says of `folder`.
    pub(super) fn of(folder: &Path) -> io::Result<Reach> {
        let folder = if folder == Path::new("") {
            Path::new(".")
        } else {
            folder
        };
        let folder = folder.canonicalize()?;
        Ok(Reach::Below(match folder.parent() {
            Some(around) if folder.ends_with(SCENES) => around.to_path_buf(),
            _ => folder,
        }))
    }

    /// What stands against reading `path`, if anything does.
    pub(super) fn check(&self, path: &Path) -> Result<(), String> {
        let Reach::Below(root) = self else {
            return Ok(());
        };
        let real = path.canonicalize().unwrap_or_else(|_| without_dots(path));
        if real.starts_with(root) {
            return Ok(());
        }
        Err(format!(
            "names {}, which is outside of {}; move the file there, or let the scene read any file with --allow-outside",
            real.display(),
            root.display()
        ))
    }
}

/// The absolute path of a file that is not there, as far as it is.
fn without_dots(path: &Path) -> PathBuf {
    let mut real = PathBuf::new();
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    for component in absolute.components() {
        match component {
            Component::ParentDir => {
                real.pop();
            }
            Component::CurDir => {}
            part => {
                real.push(part);
                // A link decides where the next `..` leads.
                real = real.canonicalize().unwrap_or(real);
            }
        }
    }
    real
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_scene_reads_its_folder_and_what_is_below() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir_all(at("project/meshes")).unwrap();
        fs::create_dir_all(at("project/scenes/more")).unwrap();
        fs::create_dir_all(at("project2")).unwrap();
        for file in ["a", "project/a", "project/meshes/a", "project2/a"] {
            fs::write(at(file), "").unwrap();
        }
        let may = |scenes: &str, path: &str| {
            let folder = at(scenes);
            Reach::of(&folder)
                .unwrap()
                .check(&folder.join(path))
                .is_ok()
        };
        // Also of files that are not there: the error is that they are missing.
        for path in [
            "a",
            "./a",
            "meshes/a",
            "meshes/../a",
            "none",
            "no/ne",
            "no/../ne",
        ] {
            assert!(may("project", path), "{path}");
        }
        for path in [
            "../a",
            "../none",
            "..",
            "meshes/../../a",
            "no/../../none",
            "../project2/a",
        ] {
            assert!(!may("project", path), "{path}");
        }
        assert!(may("project/scenes", "../meshes/a"));
        assert!(!may("project/scenes", "../../a"));
        assert!(!may("project/scenes", "../../project2/a"));
        assert!(!may("project/scenes/more", "../../meshes/a"));
        let absolute = at("project/a").display().to_string();
        assert!(may("project", &absolute) && !may("project2", &absolute));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let project = folder.path().join("project");
        fs::create_dir_all(project.join("meshes")).unwrap();
        fs::write(folder.path().join("secret"), "").unwrap();
        symlink(folder.path(), project.join("out")).unwrap();
        symlink("../secret", project.join("file")).unwrap();
        symlink("meshes", project.join("within")).unwrap();
        let reach = Reach::of(&project).unwrap();
        for path in ["out/secret", "file", "out/none", "out/project/../none"] {
            let problem = reach.check(&project.join(path)).unwrap_err();
            assert!(problem.contains("--allow-outside"), "{problem}");
        }
        for path in ["within/a", "out/project/a"] {
            assert!(reach.check(&project.join(path)).is_ok(), "{path}");
        }
    }
}
