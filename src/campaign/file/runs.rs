//! The `[[run]]` tables: the logs of each experiment, and the part of it that is used.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::is_default;
use crate::log::LogOptions;
use crate::model::Interpolation;
use crate::run::{Role, RunKind};

/// A `[[run]]` table.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunTable {
    /// Its logs, one or more: in the file a path, a table, or a list of either.
    #[serde(rename = "file", with = "files")]
    pub files: Vec<RunFile>,
    /// Kind of experiment.
    #[serde(default)]
    pub kind: RunKind,
    /// Fit or validation.
    #[serde(default)]
    pub role: Role,
    /// First instant that is used, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// Last instant that is used, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// Condition on the channels under which samples are used, such as `abs(theta) > 0.2`.
    #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
    pub condition: Option<String>,
    /// Rate to which the log is resampled, Hz; as logged if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resample: Option<f64>,
    /// Hold of the inputs between samples; that of `[model]` if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input: Option<Interpolation>,
    /// Reading options of this run, including those of the campaign's `[log]` that it does not set
    /// itself; `None` if it sets none. On writing, an option without a value (`comment`, an empty
    /// `missing_values`) is left out, and so comes back as the campaign's `[log]` has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<LogOptions>,
}

/// One log of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunFile {
    /// Path, relative to the campaign's folder.
    pub file: String,
    /// Seconds added to its time stamps, to bring them to the clock of the run's first log.
    #[serde(default, skip_serializing_if = "is_default")]
    pub clock_offset: f64,
    /// Reading options of this log, including those of the run that it does not set itself; `None`
    /// if it sets none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<LogOptions>,
}

impl From<&str> for RunFile {
    fn from(file: &str) -> RunFile {
        RunFile { file: file.to_string(), ..RunFile::default() }
    }
}

/// A [`RunFile`] as it may be written: a path alone, or a table.
struct Written(RunFile);

impl<'de> Deserialize<'de> for Written {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Written, D::Error> {
        struct One;
        impl<'de> Visitor<'de> for One {
            type Value = Written;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a path or a table {file, clock_offset, log}")
            }

            fn visit_str<E: Error>(self, file: &str) -> Result<Written, E> {
                Ok(Written(RunFile::from(file)))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Written, A::Error> {
                RunFile::deserialize(MapAccessDeserializer::new(map)).map(Written)
            }
        }
        deserializer.deserialize_any(One)
    }
}

impl Serialize for Written {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if is_default(&self.0.clock_offset) && self.0.log.is_none() {
            serializer.serialize_str(&self.0.file)
        } else {
            self.0.serialize(serializer)
        }
    }
}

/// One log, or a list of them.
mod files {
    use super::*;

    pub fn serialize<S: Serializer>(files: &[RunFile], serializer: S) -> Result<S::Ok, S::Error> {
        match files {
            [one] => Written(one.clone()).serialize(serializer),
            several => serializer.collect_seq(several.iter().cloned().map(Written)),
        }
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<RunFile>, D::Error> {
        struct Several;
        impl<'de> Visitor<'de> for Several {
            type Value = Vec<RunFile>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a path, a table {file, clock_offset, log}, or a list of them")
            }

            fn visit_str<E: Error>(self, file: &str) -> Result<Vec<RunFile>, E> {
                Ok(vec![RunFile::from(file)])
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Vec<RunFile>, A::Error> {
                Ok(vec![RunFile::deserialize(MapAccessDeserializer::new(map))?])
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Vec<RunFile>, A::Error> {
                let several = Vec::<Written>::deserialize(SeqAccessDeserializer::new(seq))?;
                Ok(several.into_iter().map(|w| w.0).collect())
            }
        }
        deserializer.deserialize_any(Several)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_may_be_a_path_a_table_or_a_list() {
        let files = |text: &str| toml::from_str::<RunTable>(text).unwrap().files;
        let late = RunFile { file: "imu.csv".into(), clock_offset: -0.25, log: None };
        assert_eq!(files("file = 'a.csv'"), [RunFile::from("a.csv")]);
        assert_eq!(files("file = { file = 'imu.csv', clock_offset = -0.25 }"), std::slice::from_ref(&late));
        let both = files("file = ['a.csv', { file = 'imu.csv', clock_offset = -0.25 }]");
        assert_eq!(both, [RunFile::from("a.csv"), late]);
        let run = RunTable { files: both, ..RunTable::default() };
        assert_eq!(toml::from_str::<RunTable>(&toml::to_string(&run).unwrap()).unwrap(), run);
    }

    #[test]
    fn a_misspelt_key_of_a_file_is_named() {
        let error = toml::from_str::<RunTable>("file = [{ file = 'imu.csv', clock_ofset = 1 }]").unwrap_err();
        assert!(error.message().contains("clock_ofset"), "{error}");
        assert!(toml::from_str::<RunTable>("file = 3").unwrap_err().message().contains("a path, a table"));
    }
}
