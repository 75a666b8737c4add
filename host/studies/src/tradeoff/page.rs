//! The [`Report`] as a Markdown page.

use super::effects::{Effect, effects};
use super::grid::reference;
use super::record::Machine;
use super::report::{Metric, Report, Row};
use super::subject::Subject;
use super::variant::{Axis, Class, Variant};
use crate::bench::{Clock, significant, write_aligned};
use std::collections::BTreeSet;
use std::fmt::{self, Write};

/// Origin of the page.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// Command line.
    pub command: &'a str,
    /// File name of the CSV.
    pub csv: &'a str,
    /// File name of the chart.
    pub chart: &'a str,
}

impl Report {
    /// Writes the page.
    pub fn to_markdown(&self, subject: &Subject, asked: Asked<'_>) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = self.write(&mut text, subject, asked);
        text
    }

    fn write(&self, out: &mut String, subject: &Subject, asked: Asked<'_>) -> fmt::Result {
        let Some(first) = self.headers.first() else {
            return Ok(());
        };
        writeln!(out, "# Cost and error of each choice: {}\n", first.scene)?;
        writeln!(
            out,
            "Made by `{}` with relievo {}. All results are in [{}]({}).\n",
            asked.command, first.version, asked.csv, asked.csv
        )?;
        self.write_scene(out, subject)?;
        let [width, height] = first.size;
        writeln!(
            out,
            "\n{} variants at {width} × {height} pixels, of which {} were measured. Each was timed in {} rounds \
             in turn with one reference of its class (`{}`), after one to warm up, and in up to four times as many while the quartiles lay more than 5 % apart; times are medians of the ratios \
             within rounds, as multiples of the cheapest variant of the class: CPU and GPU apart.\n",
            self.rows.len() + self.left_out.len(),
            self.rows.len(),
            first.frames,
            Variant {
                settings: reference(subject),
                rendering: first
                    .renderings
                    .first()
                    .copied()
                    .unwrap_or(super::Rendering::Cpu),
            }
            .picture_key(),
        )?;
        self.write_machines(out)?;
        writeln!(out, "\n![Time against error]({})", asked.chart)?;
        for class in self.classes() {
            self.write_front(out, class)?;
        }
        self.write_effects(out, subject)?;
        self.write_left_out(out, subject)?;
        writeln!(
            out,
            "\n## Measurements\n\n\
             The truth is the mesh as curved prisms over its triangles, searched in double precision (the accurate tier without its bounds), \
             one ray a pixel: *error* is how far, in pixels, a pixel is from a place where the truth shows what it shows (99 % of the pixels are nearer; \
             above 8 is not told apart), *misplaced* the share of pixels further than half a pixel; *IoU* compares the silhouettes; \
             *interior holes* are pixels inside the outline where nothing was hit; *depth p99* is the 99th percentile of the error of the distance, world units.\n\n\
             *FLIP* (LDR-FLIP, mean, 67 pixels a degree) is the difference that a person sees between the picture and one drawn with \
             tolerance 0.0001 px, 4096 + 60 steps, 32-bit maps, 2 × 2 samples a pixel and the scene's own shadows: 0 to 1. \
             Shadows and samples change it, and none of the other errors. On the front, thousandths of it are not told apart.\n\n\
             *Steps* are those of the linear search, mean over the rays that hit. *Bytes* are what the scene and its colour picture take of the GPU; \
             *instructions* those of the colour shaders that the scene needs, each counted once.",
        )
    }

    fn write_scene(&self, out: &mut String, subject: &Subject) -> fmt::Result {
        let objects = &subject.scene.objects;
        write!(
            out,
            "The scene has {} object{}: ",
            objects.len(),
            plural(objects.len())
        )?;
        let name = |path: &std::path::Path| {
            path.file_name()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
        };
        let parts: Vec<String> = objects
            .iter()
            .map(|object| {
                format!(
                    "{} with {}",
                    object.mesh.file().map_or_else(|| object.mesh.label(), name),
                    object.shape.label()
                )
            })
            .collect();
        writeln!(out, "{}.", parts.join(", "))
    }

    fn write_machines(&self, out: &mut String) -> fmt::Result {
        let machines: BTreeSet<&Machine> =
            self.headers.iter().map(|header| &header.machine).collect();
        let parts: Vec<String> = machines
            .iter()
            .map(|machine| match &machine.adapter {
                Some(adapter) => format!("{}; {adapter}", machine.cpu),
                None => machine.cpu.clone(),
            })
            .collect();
        writeln!(out, "Measured on {}.", parts.join(", and on "))?;
        if machines.len() > 1 {
            writeln!(
                out,
                "Ratios of different machines stand beside each other here: what is cheap on one need not be so on another."
            )?;
        }
        let clocks: BTreeSet<&str> = self
            .rows
            .iter()
            .map(
                |row| match (row.variant.rendering.class(), row.measured.clock) {
                    (Class::Cpu, _) => "CPU times by wall clock around the whole frame",
                    (Class::Gpu, Clock::Wall) => "GPU times by wall clock around the whole frame",
                    (Class::Gpu, Clock::Device) => {
                        "GPU times by the device's timestamps around the render pass"
                    }
                },
            )
            .collect();
        let clocks: Vec<&str> = clocks.into_iter().collect();
        writeln!(out, "{}.", clocks.join("; "))
    }

    fn write_front(&self, out: &mut String, class: Class) -> fmt::Result {
        for metric in Metric::ALL {
            let front = self.front(class, metric);
            if front.is_empty() {
                continue;
            }
            writeln!(
                out,
                "\n## {}: Pareto front of time and {}\n\n{} of {} variants; the numbers are those of the chart.\n",
                class.name(),
                metric.title(),
                front.len(),
                self.points(class, metric).len()
            )?;
            let mut header = vec!["", "variant", "time", "quartiles", "steps"];
            if class == Class::Gpu {
                header.extend(["bytes", "instructions"]);
            }
            header.extend([
                "error px",
                "misplaced %",
                "IoU",
                "interior holes",
                "depth p99",
                "FLIP",
            ]);
            let mut lines = vec![header.into_iter().map(str::to_string).collect::<Vec<_>>()];
            for (index, (row, _)) in front.iter().enumerate() {
                lines.push(front_line(index + 1, row, class));
            }
            write_aligned(out, &lines)?;
        }
        Ok(())
    }

    fn write_effects(&self, out: &mut String, subject: &Subject) -> fmt::Result {
        writeln!(
            out,
            "\n## Effect of each axis\n\n\
             Medians over all pairs of variants that differ in nothing else. Errors are those before → after."
        )?;
        for class in self.classes() {
            let renderings = self.headers.iter().flat_map(|header| &header.renderings);
            let mut of_class = renderings.filter(|rendering| rendering.class() == class);
            let Some(&rendering) = of_class.next() else {
                continue;
            };
            let start = Variant {
                settings: reference(subject),
                rendering,
            };
            writeln!(out, "\n{}:\n", class.name())?;
            for axis in Axis::ALL {
                let effects = effects(self, class, axis, &start);
                if effects.is_empty() {
                    continue;
                }
                let parts: Vec<String> = effects.iter().map(sentence).collect();
                writeln!(
                    out,
                    "- **{}**, in place of {}: {}.",
                    axis.title(),
                    start.value(axis),
                    parts.join("; ")
                )?;
            }
        }
        Ok(())
    }

    fn write_left_out(&self, out: &mut String, subject: &Subject) -> fmt::Result {
        let notes = subject.left_out();
        if notes.is_empty() && self.left_out.is_empty() {
            return Ok(());
        }
        writeln!(out, "\n## Left out\n")?;
        for note in notes {
            writeln!(out, "- {note}")?;
        }
        // Group variants with the same reason.
        let mut reasons: Vec<(&str, Vec<&Variant>)> = Vec::new();
        for (variant, reason) in &self.left_out {
            match reasons.iter_mut().find(|(known, _)| known == reason) {
                Some((_, variants)) => variants.push(variant),
                None => reasons.push((reason, vec![variant])),
            }
        }
        for (reason, variants) in reasons {
            let common = Axis::ALL.map(|axis| {
                let values: BTreeSet<String> =
                    variants.iter().map(|variant| variant.value(axis)).collect();
                let mut values = values.into_iter();
                match (values.next(), values.next()) {
                    (Some(only), None) => only,
                    _ => "*".to_string(),
                }
            });
            let (count, plural) = (variants.len(), plural(variants.len()));
            writeln!(
                out,
                "- {count} variant{plural} `{}`: {reason}.",
                common.join("/")
            )?;
        }
        if self.rows.iter().all(|row| row.measured.flip.is_none()) {
            writeln!(
                out,
                "- The FLIP difference: without the accurate tier there is no picture to compare with."
            )?;
        }
        Ok(())
    }
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// Formats an error in pixels.
fn pixels(error: f64) -> String {
    if error.is_finite() {
        error.to_string()
    } else {
        "> 8".to_string()
    }
}

fn front_line(number: usize, row: &Row, class: Class) -> Vec<String> {
    let measured = &row.measured;
    let errors = &measured.errors;
    // The quartiles are of ratios to the reference, unlike the time.
    let scale = row.time / row.to_reference.median;
    let optional = |value: Option<u64>| value.map_or_else(String::new, |value| value.to_string());
    let mut line = vec![
        number.to_string(),
        row.variant.key(),
        format!("{:.3}", row.time),
        format!(
            "{:.3}–{:.3}",
            scale * row.to_reference.lower_quartile,
            scale * row.to_reference.upper_quartile
        ),
        format!("{:.2}", measured.steps_per_ray),
    ];
    if class == Class::Gpu {
        line.extend([measured.gpu_bytes, measured.instructions].map(optional));
    }
    line.extend([
        pixels(errors.error_px),
        format!("{:.2}", 100.0 * errors.misplaced),
        format!("{:.5}", errors.silhouette_iou),
        errors.interior_holes.to_string(),
        format!("{:.2e}", errors.distance_p99),
        measured
            .flip
            .map_or_else(String::new, |flip| format!("{flip:.4}")),
    ]);
    line
}

/// Describes an effect.
fn sentence(effect: &Effect) -> String {
    let Effect {
        value,
        pairs,
        time,
        error_px: [before, after],
        misplaced,
        flip,
    } = effect;
    let flip = flip.map_or_else(String::new, |flip| {
        format!(", FLIP × {}", significant(flip))
    });
    format!(
        "`{value}` takes {} × the time, error {} → {} px, misplaced {:.2} → {:.2} %{flip} ({pairs} pair{})",
        significant(*time),
        pixels(*before),
        pixels(*after),
        100.0 * misplaced[0],
        100.0 * misplaced[1],
        plural(*pairs)
    )
}

#[cfg(test)]
mod tests {
    use super::super::report::tests::report;
    use super::super::tests::subject;
    use super::*;

    #[test]
    fn the_page_says_what_the_chart_shows() {
        let report = report();
        let asked = Asked {
            command: "relievo tradeoff a.toml -o out",
            csv: "tradeoff.csv",
            chart: "pareto.svg",
        };
        let page = report.to_markdown(&subject(""), asked);
        for class in report.classes() {
            for metric in Metric::ALL {
                for (row, _) in report.front(class, metric) {
                    assert!(page.contains(&row.variant.key()), "{page}");
                }
            }
        }
        for part in [
            "relievo tradeoff a.toml -o out",
            "(tradeoff.csv)",
            "(pareto.svg)",
            "42 variants at 32 × 24 pixels, of which 41 were measured",
            "torus.obj with discs.png",
            "Measured on a CPU.",
            "**Tier**, in place of fast: `planar` takes",
            "the \"map\" folds, here",
            "> 8",
        ] {
            assert!(page.contains(part), "{part:?} is missing in\n{page}");
        }
        let shaders = page.matches("**Shaders**, in place of gpu-exact").count();
        assert_eq!(shaders, 1, "{page}");
    }
}
