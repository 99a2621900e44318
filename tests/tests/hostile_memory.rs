//! Inputs that state larger sizes than they have, or that decompress to much more data. Each is refused, with memory that is
//! bounded by the size of the input.
//!
//! The test counts all allocations of its process, so this file contains only one test.

use std::io::Write;
use std::path::Path;

use experiments::excitation::limits::LimitsFile;
use fleet::Accumulator;
use fleet::Comparison;
use identification::estimate::options::Options;
use linear_model::known_load::KnownLoad;
use logs::Table;
use peak_alloc::PeakAlloc;
use rist::describe::description::parse_robot;
use rist::motion::exciting::ExcitingMotion;
use rist::motion::planning::ExperimentPlan;
use rist::write_back::mjcf_into::mjcf_into;
use rist::{Estimate, ModelOptions, Validation};
use robot::format::{REPEATS_TOO_MUCH, read_urdf};
use tests::hostile::hardening;
use tests::{files_below, workspace};

#[global_allocator]
static ALLOCATED: PeakAlloc = PeakAlloc;

/// Memory that an input may use: this number of times its size in bytes. `MORE`: additional bytes.
const TIMES: usize = 64;
const MORE: usize = 64 << 20;

/// A function that reads an input. It fails with the error message of the program.
type Reader = fn(&[u8]) -> Result<(), String>;

struct Hostile {
    name: &'static str,
    bytes: Vec<u8>,
    reader: Reader,
    why: &'static str,
}

fn log(bytes: &[u8]) -> Result<(), String> {
    told(Table::from_bytes("log", bytes))
}

fn text(bytes: &[u8]) -> &str {
    // An input that is not UTF-8 is refused before a reader gets it.
    std::str::from_utf8(bytes).unwrap_or_default()
}

fn yaml_robot(bytes: &[u8]) -> Result<(), String> {
    robot("robot.yaml", bytes)
}

fn urdf(bytes: &[u8]) -> Result<(), String> {
    robot("robot.urdf", bytes)
}

fn robot(file: &str, bytes: &[u8]) -> Result<(), String> {
    told(parse_robot(text(bytes), Path::new(file), &ModelOptions::default()))
}

/// The readers of all YAML files that one command writes for the next, or that a user writes.
const ARTEFACTS: [Reader; 8] = [
    |b| told(Estimate::from_yaml("estimate.yaml", text(b))),
    |b| told(ExperimentPlan::from_yaml("plan.yaml", text(b)).and_then(|plan| plan.trajectories("plan.yaml"))),
    |b| told(ExcitingMotion::from_yaml("motion.yaml", text(b))),
    |b| told(Validation::from_yaml("validation.yaml", text(b))),
    |b| told(Options::parse("options.yaml", text(b))),
    |b| told(LimitsFile::from_yaml("limits.yaml", text(b))),
    |b| told(Comparison::from_yaml("comparison.yaml", text(b))),
    |b| told(KnownLoad::from_yaml("load.yaml", text(b))),
];

fn told<T, E: std::fmt::Display>(read: Result<T, E>) -> Result<(), String> {
    read.map(drop).map_err(|e| e.to_string())
}

fn readers(name: &str) -> Vec<Reader> {
    match name.rsplit('.').next().unwrap_or_default() {
        "csv" | "txt" | "gz" | "zst" | "mcap" | "npz" | "parquet" | "db3" | "arrow" | "arrows" | "feather" => vec![log],
        "tri" => vec![sums],
        "urdf" => vec![urdf],
        "par" => vec![par],
        "xml" => vec![simulator_model],
        "stl" => vec![mesh],
        "obj" => vec![|b| vertices(b, "mesh.obj")],
        "yaml" => ARTEFACTS.into_iter().chain([yaml_robot as Reader]).collect(),
        _ => Vec::new(),
    }
}

fn par(bytes: &[u8]) -> Result<(), String> {
    robot("robot.par", bytes)
}

/// Reads a simulator file (MJCF) and writes the inertial parameters of a known robot into it.
fn simulator_model(bytes: &[u8]) -> Result<(), String> {
    let arm = read_urdf(include_str!("../../fuzz/corpus/write_back/arm.urdf"), "arm.urdf").unwrap();
    let body = [0.02, 0.0, 0.0, 0.02, 0.0, 0.02, 0.0, 0.0, 0.0, 2.0];
    let bodies: Vec<_> = arm.link_ids().map(|id| (id, body)).collect();
    told(mjcf_into(text(bytes), "robot.xml", &arm, &bodies, &[], false))
}

fn gzip(text: &str) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(text.as_bytes()).unwrap();
    packed.finish().unwrap()
}

fn zstd(text: &str) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(text.as_bytes(), ruzstd::encoding::CompressionLevel::Fastest)
}

/// An MCAP file with `count` compressed chunks; each decompresses to `content`.
fn chunks_of(count: usize, content: &[u8]) -> Vec<u8> {
    let mut packed = lz4_flex::frame::FrameEncoder::new(Vec::new());
    packed.write_all(content).unwrap();
    let packed = packed.finish().unwrap();
    let head = [&[0; 16][..], &(content.len() as u64).to_le_bytes(), &[0; 4], &3u32.to_le_bytes(), b"lz4"].concat();
    let content = [&head[..], &(packed.len() as u64).to_le_bytes(), &packed].concat();
    let chunk = [&[6][..], &(content.len() as u64).to_le_bytes(), &content].concat();
    [&b"\x89MCAP0\r\n"[..], &chunk.repeat(count)].concat()
}

/// MCAP chunks that each contain one record of `size` zeros. No reader needs this record.
fn chunks_of_zeros(count: usize, size: usize) -> Vec<u8> {
    chunks_of(count, &[&[9][..], &(size as u64).to_le_bytes(), &vec![0; size]].concat())
}

/// A .npz with one array of `rows` x 2 zeros.
fn npz_of_zeros(rows: usize) -> Vec<u8> {
    let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, 2), }}\n");
    let mut packed = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(b"\x93NUMPY\x01\0").unwrap();
    packed.write_all(&(head.len() as u16).to_le_bytes()).unwrap();
    packed.write_all(head.as_bytes()).unwrap();
    let size = 10 + head.len() + 16 * rows;
    std::io::copy(&mut std::io::Read::take(std::io::repeat(0), 16 * rows as u64), &mut packed).unwrap();
    let packed = packed.finish().unwrap();
    let sizes = [(packed.len() as u32).to_le_bytes(), (size as u32).to_le_bytes()].concat();
    let common = [&[20, 0, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0][..], &sizes, &[5, 0, 0, 0]].concat();
    let local = [&b"PK\x03\x04"[..], &common, b"q.npy", &packed].concat();
    let central = [&b"PK\x01\x02\x14\0"[..], &common, &[0; 14], b"q.npy"].concat();
    let place = (local.len() as u32).to_le_bytes();
    let end = [&b"PK\x05\x06\0\0\0\0\x01\0\x01\0"[..], &(central.len() as u32).to_le_bytes(), &place, &[0, 0]].concat();
    [local, central, end].concat()
}

/// A Parquet file with two columns of zeros, which is very small.
fn parquet_of_zeros(rows: usize) -> Vec<u8> {
    let column = |name: &str| (name.to_string(), logs::Cells::Numbers(vec![0.0; rows]));
    logs::parquet_bytes(&[column("t"), column("q1")]).unwrap()
}

fn unpacked(gzip: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(gzip), &mut bytes).unwrap();
    bytes
}

/// A YAML text with ten levels of anchors. Each level repeats the previous one ten times.
fn anchors() -> String {
    let mut text = "a0: &a0 [x]\n".to_string();
    for layer in 1..10 {
        let ten = vec![format!("*a{}", layer - 1); 10].join(", ");
        text += &format!("a{layer}: &a{layer} [{ten}]\n");
    }
    text
}

/// An Arrow file of 64 rows that claims to have more rows: each number 64 in it is replaced by `rows`.
fn arrow_of_claims(rows: u64) -> Vec<u8> {
    let mut bytes = include_bytes!("identification/foreign_logs/polars.arrow").to_vec();
    let (found, claimed) = (64u64.to_le_bytes(), rows.to_le_bytes());
    let places: Vec<usize> = (0..bytes.len() - 8).filter(|&at| bytes[at..at + 8] == found).collect();
    assert!(places.len() > 5, "{places:?}");
    places.iter().for_each(|&at| bytes[at..at + 8].copy_from_slice(&claimed));
    bytes
}

fn two_links(theta: &str) -> String {
    format!(
        "convention: khalil-kleinfinger\nname: r\nlinks:\n  - {{link: 1, antecedent: base, theta: q1}}\n  - {{link: 2, \
         antecedent: 1, d: \"{theta}\", theta: q2}}\n"
    )
}

fn hostile() -> Vec<Hostile> {
    let of = |name, bytes, reader, why| Hostile { name, bytes, reader, why };
    let rows = |row: &str, count: usize| format!("t,q1,tau1\n{}", row.repeat(count));
    let header: Vec<String> = (0..10_000).map(|c| format!("c{c}")).collect();
    let links: String = (0..20_000).map(|k| format!("<link name=\"l{k}\"/>")).collect();
    let stl = [&[0; 80][..], &u32::MAX.to_le_bytes(), &[0; 50]].concat();
    let too_much = REPEATS_TOO_MUCH;
    let unfolds = "64 times the file";
    let mut all = vec![
        of("a gzip stream of one row", gzip(&rows("1", 3 << 20)), log, "without the end of a row"),
        of("rows of one cell", format!("{}\n{}", header.join(","), "1\n".repeat(30_000)).into(), log, "fewer cells"),
        of("a gzip stream of short rows", gzip(&rows("0,0,0\n", 20 << 20)), log, unfolds),
        of("a zstd stream of short rows", zstd(&rows("0,0,0\n", 20 << 20)), log, unfolds),
        of("a chunk of zeros", chunks_of(1, &vec![0; 256 << 20]), log, unfolds),
        of("chunks of zeros", chunks_of_zeros(20, 16 << 20), log, unfolds),
        of("an array of zeros", npz_of_zeros(8 << 20), log, unfolds),
        of("columns of zeros", parquet_of_zeros(16 << 20), log, unfolds),
        of("a batch of claimed rows", arrow_of_claims(1 << 25), log, "does not hold the 33554432 values"),
        of("sums of a thousand columns", unpacked(include_bytes!("../data/hostile/bomb.tri.gz")), sums, unfolds),
        of("a robot of anchors", anchors().into(), yaml_robot, too_much),
        of("a robot of brackets", "[".repeat(100_000).into(), yaml_robot, "recursion limit"),
        of("a length of brackets", two_links(&"(".repeat(100_000)).into(), yaml_robot, "1000 characters"),
        of("a length of signs", two_links(&"-".repeat(100_000)).into(), yaml_robot, "1000 characters"),
        of("elements in elements", "<robot name=\"r\">".repeat(50_000).into(), urdf, "never closed"),
        of("links of no robot", format!("<robot name=\"r\">{links}</robot>").into(), urdf, "more than 2000 links"),
        of(
            "sums of a large claim",
            b"rist-tri 4 9 1000000000000000 0123456789abcdef\nname: r\n\n".into(),
            sums,
            "cut short",
        ),
        of("a .par of brackets", format!("NL = 1\nNJ = 1\nNF = 1\nd = {{{}}}\n", "(".repeat(100_000)).into(), par, ""),
        of("a model of bodies in bodies", "<mujoco><body>".repeat(50_000).into(), simulator_model, "robot.xml"),
        of("a mesh of a large claim", stl, mesh, "where its head promises"),
    ];
    all.extend(ARTEFACTS.into_iter().map(|reader| of("anchors", anchors().into(), reader, "")));
    all.extend(
        ARTEFACTS.into_iter().map(|reader| of("brackets", "[".repeat(100_000).into(), reader, "recursion limit")),
    );
    all
}

fn sums(bytes: &[u8]) -> Result<(), String> {
    told(Accumulator::from_bytes("sums.tri", bytes))
}

fn mesh(bytes: &[u8]) -> Result<(), String> {
    vertices(bytes, "mesh.stl")
}

fn vertices(bytes: &[u8], name: &str) -> Result<(), String> {
    told(clearance::mesh::parse_vertices(bytes, Path::new(name)))
}

/// Largest additional memory during `work`, bytes.
fn peak_of(work: impl FnOnce()) -> usize {
    let before = ALLOCATED.current_usage();
    ALLOCATED.reset_peak_usage();
    work();
    ALLOCATED.peak_usage() - before
}

#[test]
fn what_an_input_takes_is_bounded_by_its_size() {
    tests::register_wings();
    let mut beyond = Vec::new();
    for input in hostile() {
        let mut answer = Ok(());
        let peak = peak_of(|| answer = (input.reader)(&input.bytes));
        let message = answer.expect_err(input.name);
        assert!(message.contains(input.why) && message.len() < 2000, "{}: {message}", input.name);
        println!("{}: {} bytes, {peak} taken: {}", input.name, input.bytes.len(), message.lines().next().unwrap());
        if peak > TIMES * input.bytes.len() + MORE {
            beyond.push((input.name.to_string(), peak));
        }
    }
    // Files of all kinds, truncated at several positions, so that their stated sizes are too large. Hostile files from security
    // tests are read whole.
    let corpora = files_below(&workspace().join("fuzz/corpus")).into_iter().map(|path| (path, 50));
    let attacks = hardening().map_or(Vec::new(), |folder| files_below(&folder)).into_iter().map(|path| (path, 0));
    let mut count = 0;
    for (path, cuts) in corpora.chain(attacks) {
        let bytes = std::fs::read(&path).unwrap();
        let step = if cuts == 0 { bytes.len().max(1) } else { bytes.len().div_ceil(cuts).max(1) };
        for reader in readers(&path.display().to_string()) {
            count += 1;
            for cut in (0..bytes.len()).step_by(step).chain([bytes.len()]) {
                let peak = peak_of(|| drop(reader(&bytes[..cut])));
                if peak > TIMES * cut + MORE {
                    beyond.push((format!("{} up to {cut}", path.display()), peak));
                }
            }
        }
    }
    assert!(count > 100, "{count} pairs of file and reader");
    assert!(beyond.is_empty(), "{beyond:?}");
}
