//! Where the time of a run goes.

use std::time::Instant;

use serde::Serialize;

/// Seconds that one stage took.
#[derive(Clone, Debug, Serialize)]
pub struct Stage {
    /// What was done.
    pub name: String,
    /// How long.
    pub seconds: f64,
}

/// Stages with their seconds, in words.
pub(crate) fn sentence(stages: &[Stage]) -> String {
    let words: Vec<String> =
        stages.iter().map(|s| format!("{} {:.1}", s.name, s.seconds)).collect();
    words.join(", ")
}

/// The stages of a run so far.
pub(crate) struct Stages {
    last: Instant,
    done: Vec<Stage>,
}

impl Stages {
    /// The first stage begins.
    pub fn begin() -> Self {
        Self { last: Instant::now(), done: Vec::new() }
    }

    /// The present stage, of this name, ends and the next one begins.
    pub fn end(&mut self, name: &str) {
        let seconds = self.last.elapsed().as_secs_f64();
        self.done.push(Stage { name: name.to_owned(), seconds });
        self.last = Instant::now();
    }

    /// All of them.
    pub fn done(self) -> Vec<Stage> {
        self.done
    }
}
