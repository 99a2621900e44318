//! Reads a data set of LeRobot: a folder with `meta/info.json`, and with the episodes as Parquet files in `data`.
//!
//! The files are read in the order of their names and concatenated; the column `episode_index` separates the episodes. A note
//! lists the motor names of `meta/info.json` with their columns. The unit of a column is the unit in its header, otherwise the SI
//! unit (columns/finder.rs). `rist columns` proposes units from the values (columns/proposal/).

use std::path::{Path, PathBuf};

use gate::source;

use crate::Error;
use crate::table::{MAX_CELLS, Table};

/// Largest size of `meta/info.json`, bytes.
const MAX_INFO_BYTES: u64 = 1 << 22;
/// Largest number of files in a data set.
const MAX_FILES: usize = 100_000;

/// Reads the data set in a folder; `None` if the folder is not a data set.
pub(crate) fn read(folder: &Path) -> Result<Option<Table>, Error> {
    let info = folder.join("meta").join("info.json");
    if !folder.is_dir() || !info.is_file() {
        return Ok(None);
    }
    let name = folder.display().to_string();
    let files = files(&folder.join("data")).map_err(|e| Error::at(&name, 0, format!("cannot be read: {e}")))?;
    let mut all: Option<Table> = None;
    for file in &files {
        let next = Table::read(file)?;
        match &mut all {
            None => all = Some(Table { file: name.clone(), ..next }),
            Some(all) => append(all, &next).map_err(|e| Error::at(&file.display().to_string(), 0, e))?,
        }
    }
    let mut table = all.ok_or_else(|| Error::at(&name, 0, "no Parquet file is below its folder `data`"))?;
    table.notes.extend(names(&info)?);
    Ok(Some(table))
}

/// The Parquet files in `data` and in its direct subfolders, sorted by name.
fn files(data: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut folders = vec![data.to_path_buf()];
    for entry in std::fs::read_dir(data)? {
        let path = entry?.path();
        if path.is_dir() && folders.len() < MAX_FILES {
            folders.push(path);
        }
    }
    for folder in folders {
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.extension().is_some_and(|end| end == "parquet") && path.is_file() && found.len() < MAX_FILES {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

fn append(all: &mut Table, next: &Table) -> Result<(), String> {
    if all.header != next.header {
        return Err(format!("its columns are not those of the files before: {}", next.header.join(", ")));
    }
    let rows = all.rows() + next.rows();
    if rows.saturating_mul(all.header.len()) > MAX_CELLS {
        return Err(format!("with it there are more than {MAX_CELLS} numbers; give some of the Parquet files instead"));
    }
    all.columns.iter_mut().zip(&next.columns).for_each(|(all, next)| all.extend_from_slice(next));
    all.texts.iter_mut().zip(&next.texts).for_each(|(all, next)| *all = all.take().or_else(|| next.clone()));
    Ok(())
}

/// Sentences that list the motors of each array.
fn names(info: &Path) -> Result<Vec<String>, Error> {
    let file = info.display().to_string();
    let bytes = source::read(info, MAX_INFO_BYTES).map_err(|e| Error::at(&file, 0, format!("cannot be read: {e}")))?;
    let info: serde_json::Value =
        serde_json::from_slice(&bytes).map_err(|e| Error::at(&file, e.line(), format!("no JSON: {e}")))?;
    let Some(features) = info.get("features").and_then(|features| features.as_object()) else { return Ok(vec![]) };
    let mut notes = Vec::new();
    for (feature, about) in features.iter().filter(|(name, _)| name.starts_with("observation.")) {
        // Older data sets have `names: {motors: [..]}` instead of a list.
        let names = match about.get("names") {
            Some(serde_json::Value::Object(groups)) => groups.values().next(),
            other => other,
        };
        let names: Option<Vec<&str>> =
            names.and_then(|n| n.as_array()).and_then(|names| names.iter().map(|name| name.as_str()).collect());
        let is_signal = about.get("dtype").and_then(|kind| kind.as_str()).is_some_and(|kind| kind.starts_with("float"));
        if let Some(names) = names.filter(|names| is_signal && !names.is_empty()) {
            notes.push(format!(
                "{feature}_1 .. {feature}_{} are {}",
                names.len(),
                gate::shown::line(&names.join(", "))
            ));
        }
    }
    Ok(notes)
}

#[cfg(feature = "parquet")]
#[cfg(test)]
mod tests {
    use crate::{Cells, ColumnNames, LogSource, NamePattern, parquet_bytes};

    #[test]
    fn episodes_in_files_are_one_log() {
        let folder = std::env::temp_dir().join(format!("rist-lerobot-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        for sub in ["meta", "data/chunk-000"] {
            std::fs::create_dir_all(folder.join(sub)).unwrap();
        }
        let info =
            r#"{"features": {"observation.state": {"dtype": "float32", "names": ["a.pos", "b.pos"]}, "action": {}}}"#;
        std::fs::write(folder.join("meta/info.json"), info).unwrap();
        for episode in 0..3 {
            let t: Vec<f64> = (0..100).map(|k| 0.02 * f64::from(k)).collect();
            let of = |f: &dyn Fn(f64) -> f64| Cells::Numbers(t.iter().map(|t| f(*t)).collect());
            let columns = vec![
                ("timestamp".to_string(), of(&|t| t)),
                ("state_1".to_string(), of(&f64::sin)),
                ("effort_1".to_string(), of(&f64::cos)),
                ("episode_index".to_string(), of(&|_| f64::from(episode))),
            ];
            let bytes = parquet_bytes(&columns).unwrap();
            std::fs::write(folder.join(format!("data/chunk-000/episode_00000{episode}.parquet")), bytes).unwrap();
        }
        let names = ColumnNames { position: Some(NamePattern::Pattern("state_{}".into())), ..ColumnNames::default() };
        let (source, columns) = LogSource::open(&folder, &["a".into()], &names).unwrap();
        assert_eq!((source.report().kept, source.report().left_out.episodes_by_column), (300, 2));
        assert!(columns.notes.iter().any(|n| n == "observation.state_1 .. observation.state_2 are a.pos, b.pos"));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
