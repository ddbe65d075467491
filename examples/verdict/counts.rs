//! Bones that are right and wrong, and how many of them a verdict names.

use std::fmt;

/// A bone that is no further off than this, mm, is right.
const RIGHT: f64 = 1.0;

/// Bones by what they are and what is said of them.
#[derive(Default)]
pub struct Counts {
    pub wrong: usize,
    pub wrong_named: usize,
    pub right: usize,
    pub right_named: usize,
}

impl Counts {
    /// A bone this far off, where one that is further off than `wrong` is wrong.
    pub fn add(&mut self, error: f64, wrong: f64, named: bool) {
        if error > wrong {
            self.wrong += 1;
            self.wrong_named += usize::from(named);
        } else if error <= RIGHT {
            self.right += 1;
            self.right_named += usize::from(named);
        }
    }

    pub fn join(&mut self, other: &Self) {
        self.wrong += other.wrong;
        self.wrong_named += other.wrong_named;
        self.right += other.right;
        self.right_named += other.right_named;
    }

    pub fn summary(&self) -> String {
        let named = self.wrong_named + self.right_named;
        format!(
            "recall {:.3} ({} of {} wrong bones named), precision {:.3} ({} of {named} named bones wrong)",
            self.wrong_named as f64 / self.wrong.max(1) as f64,
            self.wrong_named,
            self.wrong,
            self.wrong_named as f64 / named.max(1) as f64,
            self.wrong_named
        )
    }
}

/// Two columns: wrong bones named, right bones named.
impl fmt::Display for Counts {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        let Self { wrong, wrong_named, right, right_named } = self;
        write!(to, "{wrong_named} of {wrong} | {right_named} of {right}")
    }
}
