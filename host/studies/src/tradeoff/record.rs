//! Measurement files that survive interruptions: a header line, then a line for
//! each variant, written to disk as soon as it is measured.

use super::grid::{Grid, Shard};
use super::measure::Measurement;
use super::variant::Rendering;
use relievo::Error;
use relievo::file::read_regular;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Version of the file format.
pub const FORMAT: u32 = 1;

/// Maximum file size, bytes.
const LARGEST_FILE: u64 = 1 << 30;

/// Header: the first line of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// [`FORMAT`].
    pub format: u32,
    /// Program version.
    pub version: String,
    /// Name of the scene file.
    pub scene: String,
    /// SHA-256 of the scene and the files it names, hexadecimal.
    pub digest: String,
    /// Width and height of the pictures, pixels.
    pub size: [u32; 2],
    /// Timed frames per variant.
    pub frames: u32,
    /// Variants of the sweep.
    pub grid: Grid,
    /// Renderers of each variant.
    pub renderings: Vec<Rendering>,
    /// Shard of this file.
    pub shard: Shard,
    /// Machine.
    pub machine: Machine,
}

/// Hardware.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Machine {
    /// CPU name.
    pub cpu: String,
    /// GPU name.
    pub adapter: Option<String>,
}

/// Result of a variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Measured.
    Measured(Box<Measurement>),
    /// Cannot be drawn, with the reason.
    LeftOut(String),
}

/// A line of a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Name of the variant.
    pub key: String,
    /// Result.
    #[serde(flatten)]
    pub outcome: Outcome,
}

impl Header {
    /// Describes how `self` differs from `other`, ignoring shard and machine if
    /// `may_be_elsewhere`.
    fn differences(&self, other: &Header, may_be_elsewhere: bool) -> Vec<String> {
        let [ours, others] = [self, other].map(|header| match serde_json::to_value(header) {
            Ok(serde_json::Value::Object(fields)) => fields,
            _ => serde_json::Map::new(),
        });
        let is_free = |name: &str| may_be_elsewhere && ["shard", "machine"].contains(&name);
        ours.iter()
            .filter(|(name, value)| !is_free(name) && others.get(*name) != Some(value))
            .map(|(name, value)| {
                let other = others.get(name).unwrap_or(&serde_json::Value::Null);
                format!("{name} is {value} there and {other} here")
            })
            .collect()
    }

    /// Checks that files with these headers belong to the same sweep.
    ///
    /// # Errors
    /// The differences.
    pub fn is_of_same_sweep(&self, other: &Header) -> Result<(), String> {
        let mut differences = self.differences(other, true);
        if self.shard.count != other.shard.count {
            differences.push(format!(
                "it is one of {} shards there and of {} here",
                self.shard.count, other.shard.count
            ));
        }
        if differences.is_empty() {
            Ok(())
        } else {
            Err(differences.join("; "))
        }
    }
}

/// A measurement file being written.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    /// Locked until dropped.
    file: File,
    /// Its records.
    pub records: Vec<Record>,
}

/// Contents of a file.
struct Contents {
    header: Header,
    records: Vec<Record>,
    /// Length up to the end of the last complete line, bytes.
    whole: usize,
}

impl Store {
    /// How the problem of [`Store::open`] begins if another run has the file.
    pub const LOCKED: &str = "another run writes it";

    /// Returns the file name of `shard`.
    pub fn name(shard: Shard) -> String {
        format!("measurements-{}-of-{}.jsonl", shard.number, shard.count)
    }

    /// Opens or creates the file of the header's shard in `folder`. Keeps
    /// existing lines except an incomplete last one. `restart` removes them,
    /// and the files of sweeps with another number of shards.
    ///
    /// # Errors
    /// [`Error::Measurements`] if the file belongs to something else or is
    /// locked by another run; [`Error::Write`].
    pub fn open(folder: &Path, header: &Header, restart: bool) -> Result<Store, Error> {
        let path = folder.join(Store::name(header.shard));
        for (other, shard) in files(folder)? {
            if shard.count == header.shard.count {
                continue;
            }
            if !restart {
                return Err(Error::Measurements {
                    path: other,
                    problem: format!(
                        "is a part of a sweep in {} shards, and this one is in {}; name another folder, or measure everything anew with --restart",
                        shard.count, header.shard.count
                    ),
                });
            }
            std::fs::remove_file(&other).map_err(|source| Error::Write {
                path: other,
                source,
            })?;
        }
        let failed = |source| Error::Write {
            path: path.clone(),
            source,
        };
        std::fs::create_dir_all(folder).map_err(failed)?;
        if path.exists() && !path.is_file() {
            let problem = "it is a folder, a pipe or a device; name another folder";
            return Err(failed(std::io::Error::other(problem)));
        }
        // Locked before reading: another run may be writing.
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(failed)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                return Err(Error::Measurements {
                    path,
                    problem: format!(
                        "{}; wait for its end, or name another folder",
                        Store::LOCKED
                    ),
                });
            }
            // Some file systems do not support locks.
            Err(TryLockError::Error(_)) | Ok(()) => {}
        }
        // Read through the locked handle, because the lock may exclude others.
        let mut bytes = Vec::new();
        if !restart {
            file.read_to_end(&mut bytes)
                .map_err(|error| unreadable(&path, &error))?;
        }
        let known = parse(&path, &bytes)?;
        let records = match known {
            Some(contents) => {
                let differences = contents.header.differences(header, false);
                if !differences.is_empty() {
                    return Err(Error::Measurements {
                        path,
                        problem: format!(
                            "holds measurements of something else: {}; name another folder, or measure anew with --restart",
                            differences.join("; ")
                        ),
                    });
                }
                cut(&mut file, contents.whole as u64).map_err(failed)?;
                contents.records
            }
            None => {
                cut(&mut file, 0).map_err(failed)?;
                write_line(&mut file, header).map_err(failed)?;
                Vec::new()
            }
        };
        Ok(Store {
            path,
            file,
            records,
        })
    }

    /// Returns whether the variant of this name was measured.
    pub fn has(&self, key: &str) -> bool {
        self.records.iter().any(|record| record.key == key)
    }

    /// Appends a line and flushes it to disk.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn add(&mut self, record: Record) -> Result<(), Error> {
        write_line(&mut self.file, &record).map_err(|source| Error::Write {
            path: self.path.clone(),
            source,
        })?;
        self.records.push(record);
        Ok(())
    }
}

/// Truncates to `length` bytes and seeks to the end.
fn cut(file: &mut File, length: u64) -> std::io::Result<()> {
    file.set_len(length)?;
    file.seek(SeekFrom::Start(length))?;
    Ok(())
}

fn write_line(file: &mut File, value: &impl Serialize) -> std::io::Result<()> {
    let mut line = serde_json::to_vec(value)?;
    line.push(b'\n');
    file.write_all(&line)?;
    file.sync_data()
}

fn unreadable(path: &Path, error: &std::io::Error) -> Error {
    Error::Measurements {
        path: path.to_path_buf(),
        problem: format!("cannot be read: {error}; check its permissions, or name another folder"),
    }
}

/// Parses the contents of the file at `path`; `None` without a complete line.
fn parse(path: &Path, bytes: &[u8]) -> Result<Option<Contents>, Error> {
    let problem = |problem: String| Error::Measurements {
        path: path.to_path_buf(),
        problem,
    };
    // Ignore an incomplete last line.
    let whole = bytes
        .iter()
        .rposition(|byte| *byte == b'\n')
        .map_or(0, |end| end + 1);
    let lines: Vec<&[u8]> = bytes[..whole]
        .split_inclusive(|byte| *byte == b'\n')
        .collect();
    let Some((first, rest)) = lines.split_first() else {
        return Ok(None);
    };
    let damaged = |number: usize, error: serde_json::Error| {
        problem(format!(
            "line {number} is not a measurement of this version ({error}); name another folder, or measure anew with --restart"
        ))
    };
    let header: Header = serde_json::from_slice(first).map_err(|error| damaged(1, error))?;
    let records = rest
        .iter()
        .enumerate()
        .map(|(index, line)| {
            serde_json::from_slice(line).map_err(|error| damaged(index + 2, error))
        })
        .collect::<Result<Vec<Record>, Error>>()?;
    Ok(Some(Contents {
        header,
        records,
        whole,
    }))
}

/// Lists the measurement files in `folder` by shard.
fn files(folder: &Path) -> Result<Vec<(PathBuf, Shard)>, Error> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => {
            return Err(Error::Measurements {
                path: folder.to_path_buf(),
                problem: format!("cannot be read: {error}; name a folder"),
            });
        }
    };
    let mut found: Vec<(PathBuf, Shard)> = entries
        .flatten()
        .filter_map(|entry| {
            let name = entry.file_name();
            let numbers = name
                .to_str()?
                .strip_prefix("measurements-")?
                .strip_suffix(".jsonl")?;
            let (number, count) = numbers.split_once("-of-")?;
            let shard = Shard {
                number: number.parse().ok()?,
                count: count.parse().ok()?,
            };
            Some((entry.path(), shard))
        })
        .collect();
    found.sort_by_key(|(_, shard)| (shard.count, shard.number));
    Ok(found)
}

/// Reads all measurement files in `folder`, which must hold every shard of one
/// sweep.
///
/// # Errors
/// [`Error::Measurements`] naming the mismatch or the missing shards.
pub fn read_all(folder: &Path) -> Result<(Vec<Header>, Vec<Record>), Error> {
    let problem = |path: &Path, problem: String| Error::Measurements {
        path: path.to_path_buf(),
        problem,
    };
    let mut headers: Vec<Header> = Vec::new();
    let mut records = Vec::new();
    for (path, shard) in files(folder)? {
        let bytes = read_regular(&path, LARGEST_FILE).map_err(|error| unreadable(&path, &error))?;
        let Some(contents) = parse(&path, &bytes)? else {
            // Treated as missing.
            continue;
        };
        if contents.header.shard != shard {
            let name = Store::name(contents.header.shard);
            return Err(problem(
                &path,
                format!("holds another shard than its name says; call it {name}"),
            ));
        }
        if let Some(first) = headers.first()
            && let Err(differences) = contents.header.is_of_same_sweep(first)
        {
            return Err(problem(
                &path,
                format!(
                    "is of another sweep than {}: {differences}; keep the files of one sweep in a folder",
                    Store::name(first.shard)
                ),
            ));
        }
        headers.push(contents.header);
        records.extend(contents.records);
    }
    let Some(first) = headers.first() else {
        return Err(problem(
            folder,
            "holds no measurements-*.jsonl; run the sweep first".to_string(),
        ));
    };
    let count = first.shard.count;
    let there: BTreeSet<u32> = headers.iter().map(|header| header.shard.number).collect();
    let missing: Vec<String> = (1..=count)
        .filter(|number| !there.contains(number))
        .map(|number| format!("{number}/{count}"))
        .collect();
    if !missing.is_empty() {
        return Err(problem(
            folder,
            format!("shards are missing: {}; measure them", missing.join(", ")),
        ));
    }
    Ok((headers, records))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::bench::Clock;
    use crate::tradeoff::ground_truth::Errors;

    pub fn header(number: u32, count: u32) -> Header {
        Header {
            format: FORMAT,
            version: "1".to_string(),
            scene: "a.toml".to_string(),
            digest: "00".to_string(),
            size: [32, 24],
            frames: 2,
            grid: Grid::Quick,
            renderings: vec![Rendering::Cpu],
            shard: Shard { number, count },
            machine: Machine {
                cpu: "a CPU".to_string(),
                adapter: None,
            },
        }
    }

    /// Returns a record with a time of `ratio` references.
    pub fn record(key: &str, ratio: f64, error_px: f64, flip: f64) -> Record {
        let errors = Errors {
            silhouette_iou: 0.99,
            holes: 3,
            interior_holes: 1,
            extra: 2,
            distance_p99: 0.01,
            class_errors: 0.02,
            error_px,
            misplaced: 0.05,
        };
        Record {
            key: key.to_string(),
            outcome: Outcome::Measured(Box::new(Measurement {
                milliseconds: vec![2.0 * ratio, 3.0 * ratio],
                reference_milliseconds: vec![2.0, 3.0],
                clock: Clock::Wall,
                steps_per_ray: 12.5,
                gpu_bytes: None,
                instructions: None,
                errors,
                flip: Some(flip),
            })),
        }
    }

    #[test]
    fn what_was_written_is_there_again_and_a_torn_line_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("new");
        let header = header(1, 1);
        let left_out = Record {
            key: "c".to_string(),
            outcome: Outcome::LeftOut("it folds".to_string()),
        };
        let written = [record("a", 1.5, f64::INFINITY, 0.1), left_out];
        let mut store = Store::open(&folder, &header, false).unwrap();
        for record in &written {
            store.add(record.clone()).unwrap();
        }
        drop(store);
        let path = folder.join("measurements-1-of-1.jsonl");
        let whole = std::fs::read(&path).unwrap();
        // Truncated in the third line.
        let mut torn = whole.clone();
        torn.extend(b"{\"key\":\"b\",\"left_o");
        std::fs::write(&path, torn).unwrap();
        let mut store = Store::open(&folder, &header, false).unwrap();
        assert_eq!(store.records, written);
        assert!(store.has("a") && store.has("c") && !store.has("b"));
        store.add(record("b", 1.0, 0.5, 0.2)).unwrap();
        drop(store);
        assert_eq!(
            Store::open(&folder, &header, false).unwrap().records.len(),
            3
        );
        // Truncated in the first line: treated as empty.
        std::fs::write(&path, &whole[..20]).unwrap();
        assert!(
            Store::open(&folder, &header, false)
                .unwrap()
                .records
                .is_empty()
        );
    }

    #[test]
    fn what_does_not_fit_is_an_error_that_says_so_unless_anew() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let fails = |header: &Header, parts: &[&str]| {
            let message = Store::open(folder, header, false).unwrap_err().to_string();
            for part in parts {
                assert!(message.contains(part), "{message}");
            }
        };
        let mut store = Store::open(folder, &header(1, 1), false).unwrap();
        store.add(record("a", 1.0, 0.1, 0.1)).unwrap();
        fails(&header(1, 1), &["another run"]);
        drop(store);
        let mut other = header(1, 1);
        other.size = [64, 48];
        fails(
            &other,
            &["size is [32,24] there and [64,48] here", "--restart"],
        );
        fails(&header(1, 2), &["1 shards", "--restart"]);
        let path = folder.join("measurements-1-of-1.jsonl");
        let mut text = std::fs::read_to_string(&path).unwrap();
        text.insert_str(0, "not JSON\n");
        std::fs::write(&path, text).unwrap();
        fails(&header(1, 1), &["line 1", "--restart"]);
        let anew = Store::open(folder, &other, true).unwrap();
        assert!(anew.records.is_empty());
        drop(anew);
        drop(Store::open(folder, &header(2, 3), true).unwrap());
        assert!(!path.exists());
    }

    #[test]
    fn parts_are_joined_if_they_belong_together_and_none_is_missing() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let message = || read_all(folder).unwrap_err().to_string();
        assert!(message().contains("no measurements"), "{}", message());
        let add = |number: u32, key: &str| {
            let mut store = Store::open(folder, &header(number, 3), false).unwrap();
            store.add(record(key, 1.0, 0.1, 0.1)).unwrap();
        };
        add(2, "b");
        assert!(message().contains("1/3, 3/3"), "{}", message());
        add(1, "a");
        let mut elsewhere = header(3, 3);
        elsewhere.machine.cpu = "another CPU".to_string();
        drop(Store::open(folder, &elsewhere, false).unwrap());
        let (headers, records) = read_all(folder).unwrap();
        assert_eq!((headers.len(), records.len()), (3, 2));

        let mut foreign = header(3, 3);
        foreign.frames = 7;
        drop(Store::open(folder, &foreign, true).unwrap());
        assert!(
            message().contains("frames is 7 there and 2 here"),
            "{}",
            message()
        );
    }
}
