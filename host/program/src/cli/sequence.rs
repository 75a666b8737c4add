//! `relievo render --frames`: a picture for each frame of an animated scene.

use super::job::{Estimate, Part, Piece, Place, Work};
use super::progress::Bar;
use super::render::{RenderArguments, SOFTWARE, check_outputs, default_output, draw, take_aov};
use super::say;
use super::session::{Loaded, choose_renderer, inputs, say_plans};
use anyhow::{Context, bail};
use relievo::Error;
use relievo::aov::{MOTION_BYTES, PIXEL_BYTES, save_exr};
use relievo::budget::{Plan, PlannedScene, plan_with};
use relievo::file::open_regular;
use relievo::limits::Account;
use relievo::motion::Moment;
use relievo::picture::Picture;
use relievo::prepare::{Assets, PreparedScene, View};
use relievo::render::Renderer;
use relievo::scene::Scene;
use std::collections::HashSet;
use std::io::BufReader;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Names of files with the number of a frame: `out/%04d.png`.
#[derive(Clone, Debug, PartialEq)]
struct Names {
    before: String,
    /// Least number of digits.
    digits: usize,
    after: String,
}

impl Names {
    /// Reads a pattern: `%d` or `%04d` is the place of the number, `%%` a percent sign.
    ///
    /// # Errors
    /// What is wrong with the pattern.
    fn parse(pattern: &Path) -> Result<Names, &'static str> {
        let text = pattern.to_str();
        let mut rest = text.ok_or("is not Unicode; choose another name")?;
        // What stands before the first place, between places, and after the last one.
        let mut parts = Vec::new();
        let mut part = String::new();
        let mut digits = 1;
        while let Some((before, after)) = rest.split_once('%') {
            part.push_str(before);
            let end = after.find(|c: char| !c.is_ascii_digit());
            let (width, tail) = after.split_at(end.unwrap_or(after.len()));
            let is_width = width.is_empty() || width.starts_with('0') && width.len() <= 3;
            match tail.strip_prefix('d').filter(|_| is_width) {
                Some(tail) => {
                    digits = width.parse().unwrap_or(1);
                    parts.push(std::mem::take(&mut part));
                    rest = tail;
                }
                None => {
                    part.push('%');
                    rest = after.strip_prefix('%').unwrap_or(after);
                }
            }
        }
        part.push_str(rest);
        parts.push(part);
        match <[String; 2]>::try_from(parts) {
            Ok([before, after]) => Ok(Names {
                before,
                digits,
                after,
            }),
            Err(parts) if parts.len() < 2 => Err(
                "has no place for the number of the frame; write %04d into it, such as out/%04d.png",
            ),
            Err(_) => Err("has several places for the number of the frame; leave one %04d"),
        }
    }

    /// Returns names of pictures in `folder`.
    fn in_folder(folder: &Path) -> anyhow::Result<Names> {
        let folder = folder.to_str().context("the job's folder is not Unicode")?;
        Ok(Names {
            before: format!("{folder}/frame-"),
            digits: 7,
            after: ".png".to_string(),
        })
    }

    /// Returns the name for a frame.
    fn of(&self, frame: u64) -> PathBuf {
        let digits = self.digits;
        format!("{}{frame:0digits$}{}", self.before, self.after).into()
    }
}

/// Reads the pattern of an option.
fn names(option: &str, path: &Path) -> anyhow::Result<Names> {
    Names::parse(path).map_err(|problem| anyhow::anyhow!("{option} {} {problem}", path.display()))
}

/// Where the pictures go.
enum Output {
    /// A file for each frame.
    Files(Names),
    /// One animated PNG, which is written at the end.
    Animation(PathBuf),
}

impl Output {
    /// Returns the output at `path` for `count` pictures of `scene`.
    fn new(
        path: PathBuf,
        scene: &Scene,
        count: u64,
        account: &mut Account<'_>,
    ) -> anyhow::Result<Output> {
        let extension = path.extension();
        if !extension.is_some_and(|extension| extension.eq_ignore_ascii_case("apng")) {
            return Ok(Output::Files(names("--output", &path)?));
        }
        if Names::parse(&path).is_ok() {
            bail!(
                "--output {} holds all frames; leave out the place for their number, or write .png",
                path.display()
            );
        }
        let pixels: u64 = scene.size.map(u64::from).iter().product();
        let channels = 3 + u64::from(scene.development.is_transparent);
        let what = format!("the animation of {count} frames");
        account.take(what, pixels.saturating_mul(count), channels)?;
        Ok(Output::Animation(path))
    }

    /// Refuses names of inputs and names that come twice.
    fn check(&self, scene: &Scene, aov: Option<&Names>, frames: Range<u64>) -> anyhow::Result<()> {
        let mut seen = HashSet::new();
        for frame in frames {
            let aov = aov.map(|names| names.of(frame));
            let picture = match self {
                Output::Files(names) => names.of(frame),
                Output::Animation(path) => path.clone(),
            };
            check_outputs(scene, &picture, aov.as_deref())?;
            let of_frame = match self {
                Output::Files(_) => [Some(picture), aov],
                Output::Animation(_) => [aov, None],
            };
            for path in of_frame.into_iter().flatten() {
                if seen.contains(&path) {
                    bail!(
                        "two of the outputs would be {}; choose another name for -o or --aov",
                        path.display()
                    );
                }
                seen.insert(path);
            }
        }
        Ok(())
    }
}

/// `relievo render --frames`.
pub struct Animation {
    arguments: RenderArguments,
    frames: Range<u64>,
    scene: Scene,
    output: Output,
    aov: Option<Names>,
}

impl Animation {
    /// Reads and checks the scene.
    pub fn new(arguments: RenderArguments, frames: Range<u64>) -> anyhow::Result<Animation> {
        arguments.check();
        let limits = arguments.limits.limits();
        let mut scene = Scene::load_within(&arguments.scene, &limits)?;
        scene.set_budget(arguments.budget);
        scene.size = arguments.size.unwrap_or(scene.size);
        let mut account = Account::new(&scene.path, &limits);
        let aov = match &arguments.aov {
            Some(path) => {
                take_aov(&scene, PIXEL_BYTES + MOTION_BYTES, &mut account)?;
                Some(names("--aov", path)?)
            }
            None => None,
        };
        let path = default_output(&arguments, "%04d.png");
        let output = Output::new(path, &scene, frames.end - frames.start, &mut account)?;
        output.check(&scene, aov.as_ref(), frames.clone())?;
        Ok(Animation {
            arguments,
            frames,
            scene,
            output,
            aov,
        })
    }

    /// Draws `frames` to `target`.
    fn draw(&self, frames: Range<u64>, target: Target) -> (Sequence<'_>, anyhow::Result<()>) {
        let mut sequence = Sequence {
            arguments: &self.arguments,
            scene: &self.scene,
            target,
            aov: self.aov.clone(),
            before: None,
            written: Vec::new(),
            drawn: Vec::new(),
        };
        let result = if self.scene.is_still() {
            sequence.draw_still(frames)
        } else {
            sequence.draw_changing(frames)
        };
        (sequence, result)
    }

    /// Writes the animated PNG.
    fn save(&self, path: &Path, pictures: &[Picture]) -> anyhow::Result<()> {
        let comments = [("Software", SOFTWARE), ("relievo-scene", &self.scene.text)];
        Picture::save_animation(pictures, self.scene.frame_rate, path, &comments)?;
        say(format_args!("{}", path.display()))
    }
}

impl Work for Animation {
    fn unit(&self) -> &'static str {
        "frame"
    }

    fn count(&self) -> usize {
        (self.frames.end - self.frames.start) as usize
    }

    fn inputs(&self) -> anyhow::Result<Vec<PathBuf>> {
        Ok(inputs(&self.scene))
    }

    fn estimate(&self) -> anyhow::Result<Estimate> {
        let Range { start, end } = self.frames;
        let start_time = Instant::now();
        let (sequence, result) = self.draw(start..end.min(start + 3), Target::Nowhere);
        result?;
        let seconds = |time: &Instant| time.duration_since(start_time).as_secs_f64();
        let drawn: Vec<f64> = sequence.drawn.iter().map(seconds).collect();
        let (first, last) = (drawn[0], drawn[drawn.len() - 1]);
        let unit = match drawn.len() {
            1 => first,
            several => (last - first) / (several - 1) as f64,
        };
        Ok(Estimate {
            setup: (first - unit).max(0.0),
            units: vec![unit; self.count()],
            // The merge of an animation holds all of its pictures, and the encoded file.
            merge_memory: match self.output {
                Output::Animation(_) => {
                    let pixels: u64 = self.scene.size.map(u64::from).iter().product();
                    8 * pixels * self.count() as u64
                }
                Output::Files(_) => 0,
            },
            ..Estimate::default()
        })
    }

    fn work(&self, piece: &Piece, place: Option<&Place<'_>>) -> anyhow::Result<Part> {
        let units = piece.units();
        let frames = self.frames.start + units.start as u64..self.frames.start + units.end as u64;
        let target = match (&self.output, place) {
            (Output::Files(names), _) => Target::Files(names.clone()),
            (Output::Animation(_), None) => Target::Memory(Vec::new()),
            (Output::Animation(_), Some(place)) => Target::Files(Names::in_folder(place.folder)?),
        };
        let (sequence, result) = self.draw(frames, target);
        // What was drawn before an error is kept.
        if let (Output::Animation(path), Target::Memory(pictures)) =
            (&self.output, &sequence.target)
            && !pictures.is_empty()
        {
            self.save(path, pictures)?;
        }
        result?;
        Ok(Part {
            files: sequence.written,
            ..Part::default()
        })
    }

    fn merge(&self, parts: Vec<Part>) -> anyhow::Result<()> {
        let Output::Animation(path) = &self.output else {
            return Ok(());
        };
        let files = parts.into_iter().flat_map(|part| part.files);
        let is_picture = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "png");
        let pictures = files.filter(is_picture).map(|path| read(&path));
        let pictures = pictures.collect::<anyhow::Result<Vec<_>>>()?;
        // Without a job it was written from memory.
        if pictures.is_empty() {
            return Ok(());
        }
        self.save(path, &pictures)
    }
}

/// Reads a picture that [`Picture::save_png`] has written.
fn read(path: &Path) -> anyhow::Result<Picture> {
    let file = open_regular(path).with_context(|| format!("cannot read {}", path.display()))?;
    let wrong = || format!("{} is not a picture of this program", path.display());
    let mut reader = png::Decoder::new(BufReader::new(file))
        .read_info()
        .with_context(wrong)?;
    let mut bytes = vec![0; reader.output_buffer_size().with_context(wrong)?];
    let found = reader.next_frame(&mut bytes).with_context(wrong)?;
    bytes.truncate(found.buffer_size());
    Ok(Picture {
        width: found.width,
        height: found.height,
        bytes,
    })
}

/// Where the pictures of a sequence go.
enum Target {
    /// A file for each frame.
    Files(Names),
    Memory(Vec<Picture>),
    Nowhere,
}

/// A sequence that is being drawn.
struct Sequence<'a> {
    arguments: &'a RenderArguments,
    scene: &'a Scene,
    target: Target,
    aov: Option<Names>,
    /// The picture before.
    before: Option<Moment>,
    /// The files that are written.
    written: Vec<PathBuf>,
    /// When each frame was drawn.
    drawn: Vec<Instant>,
}

impl Sequence<'_> {
    /// Returns the scene at frame `number`.
    fn at(&self, number: u64) -> Result<Scene, Error> {
        Ok(self.scene.at_time(number as f64 / self.scene.frame_rate)?)
    }

    /// Returns the number of the frame that the motion in frame `first` is measured from, if
    /// that is asked for; none is before frame 0.
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
        let mut told = None;
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
            let Loaded {
                scene,
                prepared,
                plans,
            } = &loaded;
            let (mut renderer, line) = self.renderer(prepared, plans)?;
            if told.is_none() {
                say(format_args!("{line}"))?;
            }
            if told.as_ref() != Some(plans) {
                say_plans(&loaded)?;
                told = Some(plans.clone());
            }
            self.draw(number, scene, prepared, &prepared.view(), renderer.as_mut())?;
        }
        Ok(())
    }

    fn renderer<'s>(
        &self,
        prepared: &'s PreparedScene,
        plans: &[Option<Plan>],
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
        // The picture comes last: where it is, the frame is complete.
        if let Some(names) = &self.aov {
            let words = renderer.geometry(&view.frame).map_err(Error::from)?;
            let now = Moment::new(prepared, view);
            if !matches!(self.target, Target::Nowhere) {
                // Frame 0 has no motion.
                let before = self.before.as_ref().unwrap_or(&now);
                let path = names.of(number);
                save_exr(&path, &words, scene, prepared, view, Some(before))?;
                say(format_args!("{}", path.display()))?;
                self.written.push(path);
            }
            self.before = Some(now);
        }
        let picture = draw(prepared, view, renderer)?;
        match &mut self.target {
            Target::Files(names) => {
                let path = names.of(number);
                let number = number.to_string();
                let comments = [
                    ("Software", SOFTWARE),
                    ("relievo-scene", &scene.text),
                    ("relievo-frame", &number),
                ];
                picture.save_png(&path, &comments)?;
                say(format_args!("{}", path.display()))?;
                self.written.push(path);
            }
            Target::Memory(pictures) => pictures.push(picture),
            Target::Nowhere => {}
        }
        self.drawn.push(Instant::now());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_one_place_for_the_number() {
        let name = |pattern: &str| Names::parse(Path::new(pattern)).map(|names| names.of(7));
        for (pattern, expected) in [
            ("out/%04d.png", "out/0007.png"),
            ("%d.png", "7.png"),
            ("100% done/50%%-%03d.png", "100% done/50%-007.png"),
            ("a%20b/%d%", "a%20b/7%"),
        ] {
            assert_eq!(name(pattern), Ok(PathBuf::from(expected)), "{pattern}");
        }
        let long = Names::parse(Path::new("%d")).unwrap().of(12345);
        assert_eq!(long, PathBuf::from("12345"));
        for (bad, part) in [
            ("out.png", "no place"),
            ("%4d.png", "no place"),
            ("%s.png", "no place"),
            ("%0999d.png", "no place"),
            ("%04d%d.png", "several places"),
        ] {
            assert!(name(bad).unwrap_err().contains(part), "{bad}");
        }
    }
}
