//! The task `book`: makes an mdBook of the pages in docs/. The book also contains interactive HTML pages that `rist` writes (live
//! pages).
//!
//! The table in docs/README.md determines the order of the chapters. The pages are copied unchanged to target/book/src, which
//! has the same folders as the repository, so that links stay valid. If mdbook is not installed, the pages are only checked,
//! and a message says so.
//!
//! `book --check` only checks the pages. `book --screenshots` also takes screenshots of the live pages with Chromium.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::book_pages::{Page, chapters, faults, pages};
use crate::cargo::{done, root, target};
use crate::pictures_task;

/// The live pages: file name, title, and the command that writes the page.
const LIVE: [(&str, &str, &[&str]); 3] = [
    (
        "ur5",
        "The page of an estimate: a UR5 with a gripper that its URDF does not have",
        &["identify", "models/ur5.urdf", "docs/ur5/log.csv", "--validate", "docs/ur5/other.csv", "--quiet", "--report"],
    ),
    (
        "motion",
        "The page of a motion, with its limits proved",
        &["report", "--model", "models/ur5.urdf", "--motion", "docs/ur5/motion.yaml", "--out"],
    ),
    (
        "inspect",
        "The base parameters of a UR5: choose one, and see what it took in",
        &["inspect", "models/ur5.urdf", "--format", "html"],
    ),
];

/// Width and height of a screenshot, pixels.
const SCREENSHOT_PIXELS: (u32, u32) = (1100, 800);
/// Largest size of a screenshot that is stored in the repository, bytes.
const LARGEST_SCREENSHOT_BYTES: u64 = 150_000;

pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    let with_screenshots = match arguments {
        [] => false,
        [flag] if flag == "--check" => return check().map(|_| ()),
        [flag] if flag == "--screenshots" => true,
        [other, ..] => return Err(format!("book takes --check, --screenshots or nothing; found `{other}`")),
    };
    let pages = check()?;
    // The old source folder is removed first, so that removed or renamed pages do not remain in the book.
    let book = target().join("book");
    let source = book.join("src");
    if source.exists() {
        std::fs::remove_dir_all(&source).map_err(|e| format!("{}: {e}", source.display()))?;
    }
    live_pages(&source.join("live"))?;
    if with_screenshots {
        screenshots(&source.join("live"))?;
    }
    copy(&pages, &source)?;
    write(&source.join("SUMMARY.md"), &summary(&pages)?)?;
    write(&source.join("live.md"), &live_chapter())?;
    write(&book.join("book.toml"), BOOK)?;
    // If mdbook is not installed, the task prints a message and succeeds.
    let html = book.join("html/index.html");
    match Command::new("mdbook").arg("--version").output() {
        Ok(found) if found.status.success() => {
            done(Command::new("mdbook").arg("build").arg(&book), "mdbook build")?;
            println!("the book: {}", html.display());
        }
        _ => println!(
            "SKIPPED: mdbook is absent (cargo install --locked mdbook), so the book was not rendered; its pages, links and \
             order hold, and its source is in {}",
            source.display()
        ),
    }
    Ok(())
}

/// Reads all pages. Fails if a link has no target, or if a page is not in the book.
fn check() -> Result<Vec<Page>, String> {
    let pages = pages()?;
    let faults = faults(&pages)?;
    match faults.is_empty() {
        true => {
            println!(
                "{} pages, {} links: all lead somewhere",
                pages.len(),
                pages.iter().map(|p| p.links().len()).sum::<usize>()
            );
            Ok(pages)
        }
        false => Err(faults.join("\n")),
    }
}

const BOOK: &str = "\
[book]
title = \"rist\"
language = \"en\"
src = \"src\"

[build]
build-dir = \"html\"
create-missing = false

[output.html]
default-theme = \"light\"
preferred-dark-theme = \"navy\"
";

/// The text of SUMMARY.md for mdBook: the parts and chapters in order.
fn summary(pages: &[Page]) -> Result<String, String> {
    let mut text = String::from("# Summary\n\n[rist](index.md)\n[Live pages](live.md)\n[All pages](docs/index.md)\n");
    for (part, chapters) in chapters(pages)? {
        let _ = write!(text, "\n# {part}\n\n");
        for page in chapters {
            let _ = writeln!(text, "- [{}]({})", page.title()?, in_book(&page.name));
        }
    }
    Ok(text)
}

/// The text of a chapter that shows the live pages.
fn live_chapter() -> String {
    let mut text =
        String::from("# Live pages\n\nEach is one file that `rist` wrote, here in a frame; the link opens it alone.\n");
    for (name, what, command) in LIVE {
        let command = command.join(" ");
        let _ = write!(
            text,
            "\n## {what}\n\n`rist {command} ..`: [open it](live/{name}.html)\n\n<iframe src=\"live/{name}.html\" title=\"{what}\" \
             loading=\"lazy\" style=\"width:100%;height:70vh;border:1px solid #8884\"></iframe>\n"
        );
    }
    text
}

/// Writes the live pages (HTML pages by `rist`). If the environment variable RIST names a program, it is used; otherwise `rist`
/// is built.
fn live_pages(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for (name, _, arguments) in LIVE {
        let file = folder.join(format!("{name}.html"));
        let mut command = rist();
        command.args(arguments).current_dir(root());
        let is_printed = arguments.contains(&"--format");
        if !is_printed {
            command.arg(&file);
        }
        let output = command.output().map_err(|e| format!("rist: {e}"))?;
        if !output.status.success() {
            return Err(format!("rist {}: {}", arguments.join(" "), String::from_utf8_lossy(&output.stderr)));
        }
        if is_printed {
            std::fs::write(&file, output.stdout).map_err(|e| format!("{}: {e}", file.display()))?;
        }
    }
    Ok(())
}

fn rist() -> Command {
    if let Some(program) = std::env::var_os("RIST") {
        return Command::new(program);
    }
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    command.args(["run", "--quiet", "--locked", "--release", "--package", "cli", "--"]);
    command
}

/// Takes a screenshot of each live page, and stores it in docs/pictures.
fn screenshots(folder: &Path) -> Result<(), String> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let is_there = |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|found| found.status.success());
    let Some(browser) = names.into_iter().find(is_there) else {
        println!("SKIPPED: no Chromium is there, so no screenshots were taken");
        return Ok(());
    };
    for (name, ..) in LIVE {
        let picture = root().join(pictures_task::FOLDER).join(format!("{name}.png"));
        let page = folder.join(format!("{name}.html"));
        let mut command = Command::new(browser);
        command
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--force-color-profile=srgb"])
            // The scripts of a page draw after loading. With virtual time, they get the same time on any machine, however busy
            // the machine is.
            .arg("--virtual-time-budget=4000")
            .arg(format!("--window-size={},{}", SCREENSHOT_PIXELS.0, SCREENSHOT_PIXELS.1))
            .arg(format!("--screenshot={}", picture.display()))
            .arg(format!("file://{}", page.display()))
            .stderr(std::process::Stdio::null());
        done(&mut command, browser)?;
        let bytes = std::fs::metadata(&picture).map_err(|e| format!("{}: {e}", picture.display()))?.len();
        if bytes > LARGEST_SCREENSHOT_BYTES {
            return Err(format!("{}: {bytes} bytes; at most {LARGEST_SCREENSHOT_BYTES} are kept", picture.display()));
        }
        println!("{}: {bytes} bytes", picture.display());
    }
    Ok(())
}

/// Changes README.md in a file name or in links to index.md, because mdBook writes README as index.html but does not change the
/// links.
fn in_book(text: &str) -> String {
    let of_link = text.replace("README.md)", "index.md)").replace("README.md#", "index.md#");
    of_link.strip_suffix("README.md").map_or(of_link.clone(), |folder| format!("{folder}index.md"))
}

/// Copies the pages, and the files to which they link or which they show.
fn copy(pages: &[Page], source: &Path) -> Result<(), String> {
    let mut files: BTreeSet<PathBuf> = pages.iter().map(|page| PathBuf::from(&page.name)).collect();
    for page in pages {
        files.extend(page.targets().filter(|target| root().join(target).is_file()));
    }
    for file in files {
        let to = source.join(in_book(&file.display().to_string()));
        let folder = to.parent().unwrap_or(source);
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let failed = |e: std::io::Error| format!("{}: {e}", file.display());
        match file.extension().is_some_and(|end| end == "md") {
            true => write(&to, &in_book(&std::fs::read_to_string(root().join(&file)).map_err(failed)?))?,
            false => std::fs::copy(root().join(&file), &to).map(|_| ()).map_err(failed)?,
        }
    }
    Ok(())
}

fn write(file: &Path, text: &str) -> Result<(), String> {
    std::fs::write(file, text).map_err(|e| format!("{}: {e}", file.display()))
}
