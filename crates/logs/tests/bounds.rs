//! Memory and time are bounded for any file: a file that exceeds a limit is refused with a message that contains a remedy.

use std::path::{Path, PathBuf};

use logs::{ColumnNames, LogSource, Table};

fn refusal(bytes: &[u8]) -> String {
    Table::from_bytes("log.csv", bytes).unwrap_err().to_string()
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rist-bounds-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn open(path: &Path, held: usize) -> Result<LogSource, String> {
    let names = ColumnNames::default();
    LogSource::open_within(path, &["a".into()], &names, held, 64).map(|log| log.0).map_err(|e| e.to_string())
}

fn rows(n: usize, change: f64) -> String {
    let row = |i: usize| format!("{:.3},{:.6},{:.6}\n", 0.01 * i as f64, (0.05 * i as f64).sin(), change);
    std::iter::once("t,q1,tau1\n".to_string()).chain((0..n).map(row)).collect()
}

#[test]
fn rows_without_an_end() {
    let long = "1".repeat(3 << 20);
    let quoted = format!("t,q1,tau1\n0,\"1,2\n{}", "3,4,5\n".repeat(1 << 19));
    for bytes in [
        format!("t,q1,tau1\n{long}").into_bytes(),
        format!("t q1 tau1\n{long}").into_bytes(),
        quoted.into_bytes(),
        format!("t,q1,tau1\n{}", "\n".repeat(3 << 20)).into_bytes(),
    ] {
        let message = refusal(&bytes);
        assert!(message.contains("1048576 bytes without the end of a row"), "{message}");
    }
}

/// Values in the encoding BYTE_STREAM_SPLIT: a whole page is read. A truncated page is refused here, before the library panics on
/// it; the message would then only be "damaged".
#[cfg(feature = "parquet")]
#[test]
fn split_values_cut_short() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/logs");
    let whole = Table::read(&corpus.join("split.parquet")).unwrap();
    assert_eq!(whole.header, ["t", "q1"]);
    for row in 0..9 {
        let t = 0.01 * row as f64;
        assert_eq!(whole.columns[0][row], t);
        // The expected sine was computed by another library, so it may differ by rounding.
        assert!((whole.columns[1][row] - t.sin()).abs() < 1e-15, "{row}");
    }
    let message = Table::read(&corpus.join("split_cut_short.parquet")).unwrap_err().to_string();
    assert!(message.contains("its 10 bytes are not whole values of 8"), "{message}");
}

#[test]
fn damaged_utf_16_is_named() {
    assert!(refusal(b"\xff\xfet\0\x00\xd8,\0").contains("damaged UTF-16; save it as UTF-8"));
}

#[test]
fn a_file_replaced_is_noticed() {
    let folder = folder("replaced");
    let path = folder.join("log.csv");
    std::fs::write(&path, rows(300, 1.0)).unwrap();
    let Ok(LogSource::Streamed(stream)) = open(&path, 100) else { panic!("it is held") };
    assert!(stream.blocks(0.1, 0, &mut |_| Ok(true)).is_ok());
    std::fs::write(&path, rows(300, 10.0)).unwrap();
    let message = stream.blocks(0.1, 0, &mut |_| Ok(true)).unwrap_err().to_string();
    assert!(message.contains("was replaced since"), "{message}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_without_an_end() {
    for device in ["/dev/zero", "/dev/urandom"] {
        for message in
            [Table::read(Path::new(device)).unwrap_err().to_string(), open(Path::new(device), 100).err().unwrap()]
        {
            assert!(message.contains(device), "{message}");
        }
    }
    let folder = folder("pipe");
    let pipe = folder.join("pipe");
    let feed = |text: String| {
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let pipe = pipe.clone();
        // The reader may close the pipe before the end, so an error of the writer is ignored.
        std::thread::spawn(move || std::fs::write(pipe, text).ok())
    };
    let writer = feed(rows(90, 1.0));
    assert_eq!(open(&pipe, 100).unwrap().report().kept, 90);
    writer.join().unwrap();
    std::fs::remove_file(&pipe).unwrap();
    let writer = feed(rows(300, 1.0));
    let message = open(&pipe, 100).err().unwrap();
    for said in ["more than 64 rows come from a pipe or device", "write it to a file"] {
        assert!(message.contains(said), "{message}");
    }
    writer.join().unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
}
