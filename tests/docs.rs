//! Citations of sections, equations and algorithms resolve; so do links and
//! file names in README.md and docs/, and the book lists every page.

use relievo_tests::root;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// All files below `folder` with this extension, sorted; build outputs and
/// hidden folders are skipped.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy();
        if path.is_dir() {
            if !name.starts_with('.') && name != "target" && name != "out" {
                found.extend(files(&path, extension));
            }
        } else if path.extension().is_some_and(|other| other == extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// README.md and every page below docs/.
fn pages() -> Vec<PathBuf> {
    let mut pages = files(&root().join("docs"), "md");
    pages.push(root().join("README.md"));
    pages
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn algorithm_page() -> String {
    read(&root().join("docs/algorithm.md"))
}

/// The comments of a source, with the lines of each comment joined.
fn comments(source: &str) -> String {
    let mut text = String::new();
    for line in source.lines() {
        match line.split_once("//") {
            Some((_, comment)) => {
                text += comment.trim_start_matches(['/', '!']);
                text.push(' ');
            }
            None => text.push('\n'),
        }
    }
    text
}

/// The numbers after each occurrence of `word` or its plural, such as 4 and 5
/// in "equations (4) and (5)".
fn numbers_after(word: &str, text: &str) -> BTreeSet<u32> {
    let text = text.to_lowercase();
    let mut numbers = BTreeSet::new();
    for (at, _) in text.match_indices(word) {
        let mut rest = &text[at + word.len()..];
        rest = rest.strip_prefix('s').unwrap_or(rest);
        while let Some((number, after)) = number_at(rest) {
            numbers.insert(number);
            // In "equation (5), 0 < f" the list ends with its brackets.
            let is_bracketed = rest.trim_start().starts_with('(');
            rest = [", ", " and ", "–"]
                .iter()
                .find_map(|joint| after.strip_prefix(joint))
                .filter(|next| next.starts_with('(') == is_bracketed)
                .unwrap_or("");
        }
    }
    numbers
}

/// The number at the start of `text`, in brackets or not, and what follows.
fn number_at(text: &str) -> Option<(u32, &str)> {
    let text = text.trim_start();
    let (text, is_bracketed) = match text.strip_prefix('(') {
        Some(inner) => (inner, true),
        None => (text, false),
    };
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    let number = text[..digits].parse().ok()?;
    let rest = &text[digits..];
    let rest = if is_bracketed {
        rest.strip_prefix(')')?
    } else {
        rest
    };
    Some((number, rest))
}

/// The numbers of equations in brackets: "(4)".
fn bracketed_numbers(text: &str) -> BTreeSet<u32> {
    text.match_indices('(')
        .filter_map(|(at, _)| number_at(&text[at..]))
        .map(|(number, _)| number)
        .collect()
}

#[test]
fn cited_sections_equations_and_algorithms_exist() {
    let page = algorithm_page();
    let sections: BTreeSet<u32> = page
        .lines()
        .filter_map(|line| line.strip_prefix("## "))
        .filter_map(|heading| number_at(heading).map(|(number, _)| number))
        .collect();
    let (_, table) = page
        .split_once("## 17. Where the paper's equations are")
        .expect("algorithm.md has the table of equations");
    let equations = bracketed_numbers(table);
    let algorithms = numbers_after("algorithm", table);

    let mut unresolved = Vec::new();
    let mut citations = 0;
    for path in files(&root(), "rs") {
        let text = comments(&read(&path));
        let in_paper_tier = path.ends_with("paper.rs");
        let mut cited_equations = numbers_after("equation", &text);
        if in_paper_tier {
            cited_equations.extend(bracketed_numbers(&text));
        }
        for (kind, cited, known) in [
            ("section", numbers_after("section", &text), &sections),
            ("equation", cited_equations, &equations),
            ("algorithm", numbers_after("algorithm", &text), &algorithms),
        ] {
            citations += cited.len();
            for number in cited.difference(known) {
                unresolved.push(format!("{}: {kind} {number}", path.display()));
            }
        }
    }
    assert!(citations > 50, "{citations} citations found");
    assert!(unresolved.is_empty(), "{unresolved:#?}");
}

/// A page's text without code blocks and inline code, and the inline code.
fn prose_and_code(page: &str) -> (String, Vec<String>) {
    let (mut prose, mut code, mut is_block) = (String::new(), Vec::new(), false);
    for line in page.lines() {
        if line.trim_start().starts_with("```") {
            is_block = !is_block;
        } else if !is_block {
            for (i, part) in line.split('`').enumerate() {
                if i % 2 == 0 {
                    prose += part;
                } else {
                    code.push(part.to_string());
                }
            }
        }
        prose.push('\n');
    }
    (prose, code)
}

/// The anchors of a page's headings, as GitHub and mdBook make them.
fn anchors(page: &str) -> BTreeSet<String> {
    let mut is_block = false;
    let headings = page.lines().filter(|line| {
        is_block ^= line.starts_with("```");
        !is_block && line.starts_with('#')
    });
    headings
        .map(|heading| {
            let title = heading.trim_start_matches('#').trim().to_lowercase();
            title
                .chars()
                .filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c))
                .map(|c| if c == ' ' { '-' } else { c })
                .collect()
        })
        .collect()
}

/// The targets of the links and images of a page's prose.
fn links(prose: &str) -> Vec<&str> {
    prose
        .match_indices("](")
        .filter_map(|(at, _)| prose[at + 2..].split(')').next())
        .filter(|target| !target.contains("://"))
        .collect()
}

#[test]
fn links_and_anchors_resolve() {
    let mut broken = Vec::new();
    let mut count = 0;
    for page in pages() {
        let text = read(&page);
        let (prose, _) = prose_and_code(&text);
        for link in links(&prose) {
            count += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = match file {
                "" => page.clone(),
                file => page.parent().unwrap().join(file),
            };
            let resolves =
                target.exists() && (anchor.is_empty() || anchors(&read(&target)).contains(anchor));
            if !resolves {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(count > 50, "{count} links found");
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn files_that_pages_name_exist() {
    let folders = [
        "assets/",
        "docs/",
        "host/",
        "shader-crate/",
        "shared/",
        "tests/",
    ];
    let mut missing = Vec::new();
    for page in pages() {
        if page.ends_with("CHANGELOG.md") {
            continue;
        }
        for name in prose_and_code(&read(&page)).1 {
            let is_path = folders.iter().any(|folder| name.starts_with(folder))
                && !name.contains([' ', '*', '…', '{', '<']);
            if is_path && !root().join(&name).exists() {
                missing.push(format!("{}: {name}", page.display()));
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn the_book_lists_every_page() {
    let docs = root().join("docs");
    let summary = read(&docs.join("SUMMARY.md"));
    let listed: BTreeSet<PathBuf> = links(&summary).iter().map(|link| docs.join(link)).collect();
    let pages: BTreeSet<PathBuf> = files(&docs, "md")
        .into_iter()
        .filter(|page| !page.ends_with("SUMMARY.md"))
        .collect();
    assert_eq!(listed, pages);
}
