//! A job with many objects: bones first, then what lies between them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::error::{Error, Result, Shown};
use crate::io::{file_name, read_text, stem};
use crate::job::job_file::parse_job_file;
use crate::job::register::spec::RegisterJob;
use crate::job::reshape::spec::{ReshapeJob, one_or_many};

/// All that describes the anatomy of one person. Paths are relative to the job file. Lengths are
/// in the templates' unit.
#[derive(Clone, Debug, Default)]
pub struct AnatomyJob {
    /// The person's bones, already known.
    pub bones: Vec<PathBuf>,
    /// The same bones beside the templates, same vertices; named as the person's are.
    pub template_bones: Vec<PathBuf>,
    /// The bones are found by registering this skeleton first.
    pub skeleton: Option<RegisterJob>,
    /// What is reshaped.
    pub objects: Vec<Object>,
    /// Push objects apart where they overlap each other or bones [default: true].
    pub separate: Option<bool>,
    /// Distance to leave between surfaces.
    pub gap: Option<f64>,
    /// Objects reshaped at once [default: as many as cores and memory allow].
    pub jobs: Option<usize>,
    /// Folder for all results.
    pub out: Option<PathBuf>,
}

/// One organ or muscle.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its name; its results are named so.
    pub name: String,
    /// Names of the bones to which it is attached (with `attachment_distance`).
    pub attached_to: Vec<String>,
    /// How it is reshaped.
    pub reshape: ReshapeJob,
    /// Its keys as they were written, with the defaults, as JSON.
    pub options: String,
}

/// The file as it is written. Tables with the keys of other jobs are looked at one by one, so that
/// errors can name the object.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(default, deserialize_with = "one_or_many")]
    bones: Option<Vec<PathBuf>>,
    #[serde(default, deserialize_with = "one_or_many")]
    template_bones: Option<Vec<PathBuf>>,
    skeleton: Option<RegisterJob>,
    #[serde(default)]
    defaults: toml::Table,
    object: Vec<toml::Table>,
    separate: Option<bool>,
    gap: Option<f64>,
    jobs: Option<usize>,
    out: Option<PathBuf>,
}

impl AnatomyJob {
    /// Reads a TOML job file.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&read_text(path)?, path)
    }

    /// The same from text; `path` tells where paths start and serves the error sentences.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let document: Document = parse_job_file(text, path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut skeleton = document.skeleton;
        if let Some(job) = &mut skeleton {
            job.skeleton = folder.join(&job.skeleton);
            let files = [
                &mut job.target,
                &mut job.labels,
                &mut job.volume,
                &mut job.reference,
                &mut job.shape_model,
                &mut job.motion,
            ];
            for path in files.into_iter().flatten().chain(job.carry.iter_mut().flatten()) {
                *path = folder.join(&path);
            }
        }
        let objects = document
            .object
            .iter()
            .enumerate()
            .map(|(k, table)| object(k, table, &document.defaults, folder))
            .collect::<Result<_>>()
            .map_err(|e| Error::parse(path, None, e.to_string()))?;
        let job = Self {
            bones: surfaces(document.bones.as_deref(), folder)?,
            template_bones: surfaces(document.template_bones.as_deref(), folder)?,
            skeleton,
            objects,
            separate: document.separate,
            gap: document.gap,
            jobs: document.jobs,
            out: document.out.map(|out| folder.join(out)),
        };
        job.check().map_err(|e| Error::parse(path, None, e.to_string()))?;
        Ok(job)
    }

    fn check(&self) -> Result<()> {
        if self.skeleton.is_some() && !(self.bones.is_empty() && self.template_bones.is_empty()) {
            return Err(Error::invalid(
                "bones come from [skeleton] or from bones = [...]; leave one of the two out",
            ));
        }
        let mut names = BTreeSet::new();
        for object in &self.objects {
            if object.name.is_empty() || file_name(&object.name) != object.name {
                return Err(Error::invalid(format!(
                    "the object's name '{}' cannot be a file's name; use letters, digits, _, - and .",
                    object.name
                )));
            }
            if !names.insert(&object.name) {
                return Err(Error::invalid(format!("two objects are named '{}'", object.name)));
            }
        }
        if self.skeleton.is_none() {
            let people: BTreeSet<String> = self.bones.iter().map(|p| stem(p)).collect();
            if let Some(lost) = self.template_bones.iter().find(|p| !people.contains(&stem(p))) {
                return Err(Error::invalid(format!(
                    "the template bone {} has no bone of the same name among the person's bones",
                    lost.shown()
                )));
            }
        }
        Ok(())
    }
}

/// Files, and the surfaces in folders, sorted by name.
fn surfaces(paths: Option<&[PathBuf]>, folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for path in paths.unwrap_or_default().iter().map(|p| folder.join(p)) {
        if !path.is_dir() {
            found.push(path);
            continue;
        }
        let io = |e| Error::io("read", &path, e);
        let mut inside = Vec::new();
        for entry in std::fs::read_dir(&path).map_err(io)? {
            let file = entry.map_err(io)?.path();
            let extension = file.extension().map(|e| e.to_string_lossy().to_lowercase());
            if extension.is_some_and(|e| ["obj", "ply", "stl"].contains(&e.as_str())) {
                inside.push(file);
            }
        }
        inside.sort();
        found.append(&mut inside);
    }
    Ok(found)
}

fn object(k: usize, own: &toml::Table, defaults: &toml::Table, folder: &Path) -> Result<Object> {
    let mut table = defaults.clone();
    table.extend(own.clone());
    let options = serde_json::to_string(&table)
        .map_err(|e| Error::invalid(format!("object {} (from 1): {e}", k + 1)))?;
    let Some(toml::Value::String(name)) = table.remove("name") else {
        return Err(Error::invalid(format!("object {} (from 1) has no name", k + 1)));
    };
    let wrong = |message: &str| {
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        Error::invalid(format!("object '{name}': {message}"))
    };
    let attached_to = match table.remove("attached_to") {
        None => Vec::new(),
        Some(list) => Vec::<String>::deserialize(list).map_err(|e| wrong(e.message()))?,
    };
    for key in ["out", "report", "tets_out", "ply_out"] {
        if table.contains_key(key) {
            return Err(wrong(&format!(
                "{key} is the whole job's; results are named by the object"
            )));
        }
    }
    let reshape = ReshapeJob::deserialize(table).map_err(|e| wrong(e.message()))?;
    let reshape = reshape.relative_to(folder);
    if !attached_to.is_empty()
        && (reshape.attachments.is_some() || reshape.attachment_distance.is_none())
    {
        return Err(wrong(
            "attached_to needs attachment_distance, and takes the place of attachments",
        ));
    }
    Ok(Object { name, attached_to, reshape, options })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<AnatomyJob> {
        AnatomyJob::parse(text, Path::new("case/job.toml"))
    }

    #[test]
    fn defaults_go_to_all_objects_and_their_own_keys_win() {
        let job = parse(
            "bones = ['p/a.ply']\ntemplate_bones = ['t/a.obj']\n[defaults]\ntet_count = 4000\n\
             attachment_distance = 2\n[[object]]\nname = 'm'\ntemplate = 'm.obj'\n\
             attached_to = ['a']\n[[object]]\nname = 'n'\ntet_count = 50\n",
        )
        .unwrap();
        assert_eq!(job.bones, [Path::new("case/p/a.ply")]);
        let counts: Vec<_> = job.objects.iter().map(|o| o.reshape.tet_count).collect();
        assert_eq!(counts, [Some(4000), Some(50)]);
        assert_eq!(job.objects[0].reshape.template.as_deref(), Some(Path::new("case/m.obj")));
        assert_eq!(job.objects[0].attached_to, ["a"]);
    }

    #[test]
    fn errors_name_the_object() {
        for (text, expected) in [
            ("[[object]]\nname = 'm'\ntemplat = 'm.obj'\n", "object 'm': unknown field `templat`"),
            ("[[object]]\ntemplate = 'm.obj'\n", "object 1 (from 1) has no name"),
            ("[[object]]\nname = 'm'\n[[object]]\nname = 'm'\n", "two objects are named 'm'"),
            ("[[object]]\nname = 'a/b'\n", "cannot be a file's name"),
            ("[[object]]\nname = 'm'\nout = 'a.obj'\n", "out is the whole job's"),
            ("[[object]]\nname = 'm'\nattached_to = ['a']\n", "needs attachment_distance"),
            ("template_bones = ['t/a.obj']\nobject = []\n", "t/a.obj has no bone of the same name"),
        ] {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.starts_with("case/job.toml") && error.contains(expected), "{error}");
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
