//! What can be found suspicious before a run.

use nalgebra::Matrix4;

/// What a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Concern {
    /// Too few points.
    Amount,
    /// The template's surface: holes, flipped triangles.
    Surface,
    /// Two units.
    Unit,
    /// Two frames: LPS beside RAS.
    Frame,
    /// Two up axes.
    UpAxis,
    /// The template is somewhere else.
    Place,
    /// The template is of the other side of the body.
    Side,
    /// Two landmarks with each other's targets.
    Exchange,
    /// Landmarks or attachments that are not on the template or contradict each other.
    Landmarks,
    /// Attachments that do not hold the body.
    Attachments,
}

/// What becomes of a run all the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// A good result, perhaps less than could be.
    Note,
    /// Probably nonsense.
    Doubtful,
    /// Nonsense: the command line refuses to begin.
    Refused,
}

/// What mends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Moving the template so; a mirror image where its determinant is below 0.
    Move(Matrix4<f64>),
    /// Swapping the targets of two landmarks, by their numbers.
    Exchange(usize, usize),
}

/// Something suspicious.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What it is about.
    pub concern: Concern,
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong and what can be done, as one sentence that begins small.
    pub text: String,
    /// How far the person's points are from the template on average, where that is the matter.
    pub distance: Option<f64>,
    /// How far they are when it is mended.
    pub mended_distance: Option<f64>,
    /// What mends it, where that is known.
    pub remedy: Option<Remedy>,
}

impl Finding {
    /// One without numbers and remedy.
    pub fn new(concern: Concern, severity: Severity, text: String) -> Self {
        Self { concern, severity, text, distance: None, mended_distance: None, remedy: None }
    }
}
