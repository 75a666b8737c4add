//! `relievo render --frames`: a picture for each frame of an animated scene.

use super::progress::Bar;
use super::render::{RenderArguments, SOFTWARE, check_outputs, default_output, draw, take_aov};
use super::say;
use super::session::{Loaded, choose_renderer, say_plans};
use relievo::Error;
use relievo::aov::{MOTION_BYTES, PIXEL_BYTES, save_exr};
use relievo::budget::{PlannedScene, plan_with};
use relievo::limits::Account;
use relievo::motion::Moment;
use relievo::picture::Picture;
use relievo::prepare::{Assets, PreparedScene, View};
use relievo::render::Renderer;
use relievo::scene::Scene;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Names of files with the number of a frame: `out/%04d.png`.
#[derive(Debug, PartialEq)]
struct Names {
    before: String,
    /// Least number of digits.
    digits: usize,
    after: String,
}

impl Names {
    /// Reads a pattern; `None` unless it has one place for the number.
    fn parse(pattern: &Path) -> Option<Names> {
        let (before, rest) = pattern.to_str()?.split_once('%')?;
        let (digits, after) = rest.split_once('d')?;
        let is_plain = digits.is_empty() || digits.starts_with('0');
        let digits = if digits.is_empty() {
            1
        } else {
            digits.parse().ok()?
        };
        (is_plain && digits <= 20 && !after.contains('%')).then(|| Names {
            before: before.to_string(),
            digits,
            after: after.to_string(),
        })
    }

    fn of(&self, frame: u64) -> PathBuf {
        let digits = self.digits;
        format!("{}{frame:0digits$}{}", self.before, self.after).into()
    }
}

/// Where the pictures go.
enum Output {
    /// A file for each frame.
    Files(Names),
    /// One animated PNG.
    Animation {
        path: PathBuf,
        pictures: Vec<Picture>,
    },
}

fn names(option: &str, path: &Path) -> anyhow::Result<Names> {
    Names::parse(path).ok_or_else(|| {
        anyhow::anyhow!(
            "{option} {} has no place for the number of the frame; write %04d into it, such as out/%04d.png",
            path.display()
        )
    })
}

/// A sequence that is being drawn.
struct Sequence<'a> {
    arguments: &'a RenderArguments,
    scene: &'a Scene,
    output: Output,
    aov: Option<Names>,
    /// The picture before.
    before: Option<Moment>,
}

pub fn run(arguments: &RenderArguments, frames: Range<u64>) -> anyhow::Result<()> {
    arguments.check();
    let limits = arguments.limits.limits();
    let mut scene = Scene::load_within(&arguments.scene, &limits)?;
    scene.set_budget(arguments.budget);
    scene.size = arguments.size.unwrap_or(scene.size);
    let path = default_output(arguments, "%04d.png");
    let mut account = Account::new(&scene.path, &limits);
    let output = if path
        .extension()
        .is_some_and(|extension| extension == "apng")
    {
        let pixels: u64 = scene.size.map(u64::from).iter().product();
        let count = frames.end - frames.start;
        let what = format!("the animation of {count} frames");
        account.take(what, pixels.saturating_mul(count), 3)?;
        check_outputs(&scene, &path, None)?;
        Output::Animation {
            path,
            pictures: Vec::new(),
        }
    } else {
        Output::Files(names("--output", &path)?)
    };
    let aov = match &arguments.aov {
        Some(path) => {
            take_aov(&scene, PIXEL_BYTES + MOTION_BYTES, &mut account)?;
            Some(names("--aov", path)?)
        }
        None => None,
    };
    for frame in frames.clone() {
        let aov = aov.as_ref().map(|names| names.of(frame));
        match &output {
            Output::Files(names) => check_outputs(&scene, &names.of(frame), aov.as_deref())?,
            Output::Animation { path, .. } => check_outputs(&scene, path, aov.as_deref())?,
        }
    }
    let mut sequence = Sequence {
        arguments,
        scene: &scene,
        output,
        aov,
        before: None,
    };
    if scene.is_still() {
        sequence.draw_still(frames)?;
    } else {
        sequence.draw_changing(frames)?;
    }
    if let Output::Animation { path, pictures } = &sequence.output {
        let comments = [("Software", SOFTWARE), ("relievo-scene", &scene.text)];
        Picture::save_animation(pictures, scene.frame_rate, path, &comments)?;
        say(format_args!("{}", path.display()))?;
    }
    Ok(())
}

impl Sequence<'_> {
    /// Returns the scene at frame `number`.
    fn at(&self, number: u64) -> Result<Scene, Error> {
        Ok(self.scene.at_time(number as f64 / self.scene.frame_rate)?)
    }

    /// Returns the number of the frame that the motion in `first` is measured from: frame 0 has
    /// none before.
    fn earlier(&self, first: u64) -> Option<u64> {
        self.aov.as_ref().and_then(|_| first.checked_sub(1))
    }

    fn load(&self, scene: &Scene, assets: &mut Assets) -> Result<PlannedScene, Error> {
        let bar = Bar::new();
        plan_with(scene, assets, &|step| bar.step(&step))
    }

    /// Draws a scene whose camera and light alone change: prepared once.
    fn draw_still(&mut self, frames: Range<u64>) -> anyhow::Result<()> {
        let first = self.at(frames.start)?;
        let PlannedScene {
            scene: prepared,
            plans,
        } = self.load(&first, &mut Assets::default())?;
        let (mut renderer, line) = self.renderer(&prepared, &plans)?;
        say(format_args!("{line}"))?;
        if let Some(earlier) = self.earlier(frames.start) {
            let view = prepared.view_of(&self.at(earlier)?);
            self.before = Some(Moment::new(&prepared, &view));
        }
        for number in frames {
            let scene = self.at(number)?;
            let view = prepared.view_of(&scene);
            self.draw(number, &scene, &prepared, &view, renderer.as_mut())?;
        }
        Ok(())
    }

    /// Draws a scene that is prepared for each frame; what has not changed is kept.
    fn draw_changing(&mut self, frames: Range<u64>) -> anyhow::Result<()> {
        let mut assets = Assets::default();
        if let Some(earlier) = self.earlier(frames.start) {
            let scene = self.load(&self.at(earlier)?, &mut assets)?.scene;
            self.before = Some(Moment::new(&scene, &scene.view()));
        }
        let start = frames.start;
        for number in frames {
            let scene = self.at(number)?;
            let PlannedScene {
                scene: prepared,
                plans,
            } = self.load(&scene, &mut assets)?;
            let loaded = Loaded {
                scene,
                prepared,
                plans,
            };
            let (mut renderer, line) = self.renderer(&loaded.prepared, &loaded.plans)?;
            if number == start {
                say(format_args!("{line}"))?;
                say_plans(&loaded)?;
            }
            let Loaded {
                scene, prepared, ..
            } = &loaded;
            self.draw(number, scene, prepared, &prepared.view(), renderer.as_mut())?;
        }
        Ok(())
    }

    fn renderer<'s>(
        &self,
        prepared: &'s PreparedScene,
        plans: &[Option<relievo::budget::Plan>],
    ) -> Result<(Box<dyn Renderer + 's>, String), Error> {
        let adapter = self.arguments.adapter.as_deref();
        Ok(choose_renderer(
            self.arguments.backend,
            adapter,
            prepared,
            plans,
        )?)
    }

    /// Draws and writes frame `number`, which shows `scene`.
    fn draw(
        &mut self,
        number: u64,
        scene: &Scene,
        prepared: &PreparedScene,
        view: &View,
        renderer: &mut dyn Renderer,
    ) -> anyhow::Result<()> {
        let picture = draw(prepared, view, renderer)?;
        match &mut self.output {
            Output::Files(names) => {
                let path = names.of(number);
                let number = number.to_string();
                let comments = [
                    ("Software", SOFTWARE),
                    ("relievo-scene", &scene.text),
                    ("relievo-frame", &number),
                ];
                picture.save_png(&path, &comments)?;
                say(format_args!("{}", path.display()))?;
            }
            Output::Animation { pictures, .. } => pictures.push(picture),
        }
        if let Some(names) = &self.aov {
            let words = renderer.geometry(&view.frame).map_err(Error::from)?;
            let now = Moment::new(prepared, view);
            // Frame 0 has no motion.
            let before = self.before.as_ref().unwrap_or(&now);
            let path = names.of(number);
            save_exr(&path, &words, scene, prepared, view, Some(before))?;
            say(format_args!("{}", path.display()))?;
            self.before = Some(now);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_one_place_for_the_number() {
        let name =
            |pattern: &str, frame| Names::parse(Path::new(pattern)).map(|names| names.of(frame));
        assert_eq!(name("out/%04d.png", 7), Some("out/0007.png".into()));
        assert_eq!(name("%d.png", 12345), Some("12345.png".into()));
        for bad in [
            "out.png",
            "%4d.png",
            "%s.png",
            "%04d%d.png",
            "100%.png",
            "%099d.png",
        ] {
            assert_eq!(name(bad, 1), None, "{bad}");
        }
    }
}
