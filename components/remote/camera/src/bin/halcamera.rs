//! The program halcamera: pictures of a camera in the network, for the component align, and marks in pictures.
#![forbid(unsafe_code)]

use camera::{Address, Delivery, Feed};
use clap::{Parser, Subcommand};
use hal_marks::{Files, Ink, MarkKind as Mark, Picture, Search, Source as _, choose, search};
use std::{
    collections::VecDeque,
    fs,
    io::Write as _,
    path::{Path, PathBuf},
    process::ExitCode,
    time::Duration,
};

/// Receives pictures of a camera over HTTP, and writes the newest ones to a folder, where the component align takes
/// them (SOURCE = live FOLDER). The commands mjpeg and shot end with the camera; find searches the pictures of a folder for marks.
#[derive(Parser)]
#[command(name = "halcamera", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Take a stream of pictures (multipart/x-mixed-replace), such as `http://PHONE:8080/video`.
    Mjpeg(Save),
    /// Take one picture with each request, such as `http://PHONE:8080/shot.jpg`.
    Shot(Save),
    /// Search the pictures of a folder for marks.
    Find(Find),
}

#[derive(clap::Args)]
struct Save {
    /// Address of the camera: `http://HOST[:PORT]/PATH`.
    address: String,
    /// Folder for the pictures.
    #[arg(long)]
    folder: PathBuf,
    /// Number of pictures that are kept; older ones that this program wrote are removed. 1 to 10000.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=10000))]
    keep: u16,
    /// Number of pictures after which the program ends; 0 is no end.
    #[arg(long, default_value_t = 0)]
    pictures: u64,
    /// Longest wait for bytes of the camera, in seconds: 1 to 600.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=600))]
    timeout: u16,
}

#[derive(clap::Args)]
struct Find {
    /// Folder with pictures, JPEG or PNG.
    folder: PathBuf,
    /// Kind of the marks: circle or square.
    #[arg(long, value_parser = kind, default_value = "circle")]
    kind: Mark,
    /// Diameter or side in pixels: 8 to 4000.
    #[arg(long, value_parser = size)]
    size: f64,
    /// Marks are brighter than their background.
    #[arg(long)]
    bright: bool,
}

fn kind(text: &str) -> Result<Mark, String> {
    Mark::of(text).ok_or_else(|| "circle or square".to_owned())
}

fn size(text: &str) -> Result<f64, String> {
    let size = text.parse::<f64>().ok().filter(|s| (8.0..=4000.0).contains(s));
    size.ok_or_else(|| "a number between 8 and 4000".to_owned())
}

fn main() -> ExitCode {
    hal_output::program(|_| {
        let done = match Arguments::parse().command {
            Command::Mjpeg(options) => save(Delivery::Mjpeg, &options),
            Command::Shot(options) => save(Delivery::Shot, &options),
            Command::Find(options) => find(&options),
        };
        match done {
            Ok(code) => code,
            Err(text) => {
                drop(writeln!(std::io::stderr(), "halcamera: {text}"));
                ExitCode::FAILURE
            }
        }
    })
}

/// Writes the pictures of a camera to a folder.
fn save(kind: Delivery, options: &Save) -> Result<ExitCode, String> {
    let say = |e: camera::Refused| format!("{}: {e}", options.address);
    let address = Address::parse(&options.address).map_err(say)?;
    fs::create_dir_all(&options.folder)
        .map_err(|e| format!("{}: {}", options.folder.display(), hal_output::reason(&e)))?;
    let mut number = last(&options.folder);
    let mut kept = VecDeque::new();
    let mut feed = Feed::start(kind, address, Duration::from_secs(options.timeout.into()));
    let (mut count, mut lost) = (0_u64, 0);
    while options.pictures == 0 || count < options.pictures {
        let (bytes, picture, missed) = feed.take().map_err(say)?;
        number += 1;
        (count, lost) = (count + 1, lost + missed);
        let ending = if bytes.starts_with(b"\x89PNG") { "png" } else { "jpg" };
        let path = options.folder.join(format!("{number:09}.{ending}"));
        hal_output::write(&path, &bytes)
            .map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))?;
        if count == 1 {
            let text = format!("pictures of {} x {} pixels\n", picture.width(), picture.height());
            hal_output::print(&text).map_err(|e| e.to_string())?;
        }
        kept.push_back(path);
        while kept.len() > usize::from(options.keep) {
            if let Some(old) = kept.pop_front() {
                // Another program may have removed it already.
                drop(fs::remove_file(old));
            }
        }
    }
    hal_output::print(&format!("{count} pictures, {lost} older ones left out\n"))
        .map_err(|e| e.to_string())?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the largest number of a picture in a folder.
fn last(folder: &Path) -> u64 {
    let names = fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    let numbers = names.filter_map(|e| {
        let path = e.path();
        path.file_stem()?.to_str()?.parse::<u64>().ok()
    });
    numbers.filter(|n| *n < 1_000_000_000).max().unwrap_or(0)
}

/// Searches the pictures of a folder.
fn find(options: &Find) -> Result<ExitCode, String> {
    let ink = if options.bright { Ink::Bright } else { Ink::Dark };
    let wanted = Search { kind: options.kind, size: options.size, ink };
    let mut files = Files::open(&options.folder, false).map_err(|e| e.to_string())?;
    let (mut number, mut missing) = (0, 0);
    while let Some(picture) = files.take().map_err(|e| e.to_string())? {
        number += 1;
        let text = marks(&picture, &wanted, number, &mut missing);
        hal_output::print(&text).map_err(|e| e.to_string())?;
    }
    if number == 0 {
        return Err(format!("{}: no pictures", options.folder.display()));
    }
    Ok(if missing == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Returns the marks of a picture as lines.
fn marks(picture: &Picture, wanted: &Search, number: u32, missing: &mut u32) -> String {
    let seen = search(picture, wanted);
    let middle = hal_marks::Camera::middle((picture.width(), picture.height()));
    let mut out = String::new();
    for mark in &seen.marks {
        out.push_str(&format!(
            "{number}: {} at X {:.3} Y {:.3} +- {:.3}, angle {:.2}, area {:.0}, contrast {:.0}\n",
            mark.kind.name(),
            mark.centre.x,
            mark.centre.y,
            mark.uncertainty,
            mark.angle,
            mark.area,
            mark.contrast
        ));
    }
    if let Err(why) = choose(&seen, middle) {
        *missing += 1;
        out.push_str(&format!("{number}: {why}\n"));
    }
    out
}
