//! The page of a report, in Markdown.

use super::DeviceReport;
use crate::bench::{significant, write_aligned};
use relievo::verify::AdapterReport;
use std::collections::BTreeSet;
use std::fmt;

impl DeviceReport {
    /// Returns the headers of the table of devices.
    pub fn columns() -> [&'static str; 8] {
        [
            "device",
            "driver",
            "exact shaders",
            "words that differ, of",
            "planar, ms",
            "fast",
            "accurate",
            "curved extrusion / curved relief",
        ]
    }

    /// Returns API and driver.
    fn driver(&self) -> String {
        let AdapterReport {
            backend, driver, ..
        } = &self.words;
        format!("{backend}, {}", driver.trim_end())
    }

    /// Returns the device's line of that table. Times are of the shaders that the program
    /// takes.
    pub fn line(&self) -> [String; 8] {
        let words = &self.words;
        let promised = words.modules.iter().filter(|module| module.promises);
        let [different, compared] = promised.fold([0, 0], |[different, compared], module| {
            [different + module.different, compared + module.words]
        });
        let shaders = self.tiers.first().map(|time| time.shaders);
        let time = |tier: &str| {
            let mut times = self.tiers.iter();
            let found = times.find(|time| time.tier == tier && Some(time.shaders) == shaders);
            found.map_or_else(String::new, |time| significant(time.milliseconds))
        };
        let speeds: Vec<String> = self
            .table1
            .iter()
            .filter(|time| Some(time.shaders) == shaders && time.method == "curved basic")
            .map(|time| format!("{:.2}", time.speed_to_curved_relief))
            .collect();
        [
            words.name.clone(),
            self.driver(),
            if words.exact { "yes" } else { "no" }.to_string(),
            format!("{different} of {compared}"),
            time("planar"),
            time("fast"),
            time("accurate"),
            speeds.join(", "),
        ]
    }
}

impl fmt::Display for DeviceReport {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.effort.size;
        writeln!(out, "## {}\n", self.words.name)?;
        writeln!(
            out,
            "Relievo {}, {}. {}. Measured in {:.0} s; times are medians of {} frames of {width} × {height} pixels.\n",
            self.relievo,
            self.system,
            self.driver(),
            self.seconds,
            self.effort.frames
        )?;
        let line = [
            DeviceReport::columns().map(str::to_string).to_vec(),
            self.line().to_vec(),
        ];
        write_aligned(out, &line)?;

        writeln!(out, "\n### Canaries\n")?;
        let mut lines = vec![
            ["canary", "required", "differ", "meaning"]
                .map(str::to_string)
                .to_vec(),
        ];
        lines.extend(self.words.canaries.iter().map(|canary| {
            vec![
                canary.name.clone(),
                if canary.required { "yes" } else { "" }.to_string(),
                format!("{} of {}", canary.different, canary.words),
                if canary.different > 0 {
                    canary.tells.clone()
                } else {
                    String::new()
                },
            ]
        }));
        write_aligned(out, &lines)?;

        writeln!(out, "\n### Words\n")?;
        let mut lines = vec![
            [
                "shaders",
                "promise the CPU's words",
                "differ",
                "of",
                "functions",
                "pictures",
            ]
            .map(str::to_string)
            .to_vec(),
        ];
        lines.extend(self.words.modules.iter().map(|module| {
            let functions = module
                .kernels
                .iter()
                .filter(|kernel| kernel.found.different > 0);
            let pictures = module.pictures.iter();
            let pictures =
                pictures.filter(|picture| picture.color.different + picture.geometry.different > 0);
            vec![
                module.shaders.clone(),
                if module.promises { "yes" } else { "" }.to_string(),
                module.different.to_string(),
                module.words.to_string(),
                format!("{} of {} differ", functions.count(), module.kernels.len()),
                format!("{} of {} differ", pictures.count(), module.pictures.len()),
            ]
        }));
        write_aligned(out, &lines)?;

        writeln!(out, "\n### Tiers\n")?;
        let mut lines = vec![["tier", "shaders", "ms", "by"].map(str::to_string).to_vec()];
        lines.extend(self.tiers.iter().map(|time| {
            vec![
                time.tier.to_string(),
                time.shaders.to_string(),
                significant(time.milliseconds),
                time.clock.describe().to_string(),
            ]
        }));
        write_aligned(out, &lines)?;

        writeln!(out, "\n### Table 1\n")?;
        let header = ["shaders", "map", "method", "ms", "speed to curved relief"];
        let mut lines = vec![header.map(str::to_string).to_vec()];
        lines.extend(self.table1.iter().map(|time| {
            vec![
                time.shaders.to_string(),
                time.map.to_string(),
                time.method.clone(),
                significant(time.milliseconds),
                format!("{:.2}", time.speed_to_curved_relief),
            ]
        }));
        write_aligned(out, &lines)?;

        writeln!(out, "\n### Compiled shaders\n")?;
        if let Some(why) = &self.not_compiled {
            return writeln!(
                out,
                "The driver does not tell what it makes of shaders: {why}."
            );
        }
        let names = self
            .compiled
            .iter()
            .flat_map(|shader| shader.statistics.keys());
        let names: BTreeSet<&String> = names.collect();
        let mut lines = vec![vec!["tier".to_string(), "shaders".to_string()]];
        lines[0].extend(names.iter().map(|name| name.to_string()));
        lines.extend(self.compiled.iter().map(|shader| {
            let mut line = vec![shader.tier.to_string(), shader.shaders.to_string()];
            line.extend(names.iter().map(|name| {
                let value = shader.statistics.get(*name);
                value.map_or_else(String::new, u64::to_string)
            }));
            line
        }));
        write_aligned(out, &lines)
    }
}
