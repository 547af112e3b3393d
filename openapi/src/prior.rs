//! Named priors: what a robot may be told to believe of the floor before any sample.

#[cfg(feature = "core")]
pub use crate::built_in::prior as built_in;

use crate::body;
use crate::check::{Check, Validate};
use crate::checked::Checked;
use crate::evolution::Optimizer;
use crate::id::{EvolutionId, PriorId, RobotId};
use crate::page::Unreadable;
use crate::problem::Problems;
use crate::robot;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// Largest body of a prior in bytes; a full one has 1 kB.
pub const MAX_BODY: usize = 16 * 1024;

/// Longest note in characters: a paragraph.
pub const MAX_NOTE: usize = 1000;

/// Most robots that a prior names as its users; their number is told in full.
pub const MAX_ROBOTS: usize = 100;

/// A named prior as it is put. A channel that is left out has the weak default.
///
/// ```
/// use umwelt_api::prior::Spec;
/// let spec = Spec::read(br#"{"forward": {"mu": -0.1, "k": 5, "r": 8, "s": 0.1}, "note": "the wet hall"}"#)?;
/// assert_eq!(spec.to_core().forward.mu(), -0.1);
///
/// let problems = Spec::read(br#"{"forward": {"mu": -0.1, "k": 0, "r": -8, "s": 0.1}}"#).unwrap_err();
/// let fields: Vec<_> = problems.details().iter().map(|detail| detail.field.as_str()).collect();
/// assert_eq!(fields, ["forward.k", "forward.r"]);
/// # Ok::<(), umwelt_api::Problems>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = PriorSpec)]
pub struct Spec {
    /// Forward error per metre commanded.
    pub forward: robot::ChannelPrior,
    /// Lateral error per metre commanded.
    pub lateral: robot::ChannelPrior,
    /// Heading error per radian commanded.
    pub turn: robot::ChannelPrior,
    /// Heading error in rad per metre commanded; used where `drift` is on.
    pub drift: robot::ChannelPrior,
    /// What people should know about it.
    pub note: Option<String>,
}

impl Default for Spec {
    fn default() -> Self {
        robot::Prior::default().into()
    }
}

impl From<robot::Prior> for Spec {
    /// Without a note.
    fn from(values: robot::Prior) -> Self {
        let robot::Prior { forward, lateral, turn, drift } = values;
        Self { forward, lateral, turn, drift, note: None }
    }
}

impl Validate for Spec {
    fn check(&self, check: &mut Check) {
        self.values().check(check);
        check.text("note", self.note.as_deref().unwrap_or_default(), 0..=MAX_NOTE);
    }
}

impl Spec {
    /// Reads the body of a PUT.
    ///
    /// # Errors
    /// Every problem of it: unknown fields, values out of range.
    pub fn read(json: &[u8]) -> Result<Checked<Self>, Problems> {
        body::read_shared(json)
    }

    /// The belief about each channel.
    pub fn values(&self) -> robot::Prior {
        let Self { forward, lateral, turn, drift, .. } = *self;
        robot::Prior { forward, lateral, turn, drift }
    }
}

/// Where a prior comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[schema(as = PriorSource)]
pub enum Source {
    /// It comes with the server.
    BuiltIn,
    /// Someone put it.
    Put,
    /// An evolution found it.
    Evolution {
        /// The evolution; it may have been removed since.
        evolution: EvolutionId,
        /// Its seed.
        seed: u64,
        /// What it searched with.
        optimizer: Optimizer,
        /// Mean fitness on fresh seeds; null where it is not known.
        fitness: Option<f64>,
    },
    /// It stands in the description of the robot itself and has no name.
    Inline,
}

/// A named prior.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Prior)]
pub struct Prior {
    /// Its name.
    pub prior: PriorId,
    /// Forward error per metre commanded.
    pub forward: robot::ChannelPrior,
    /// Lateral error per metre commanded.
    pub lateral: robot::ChannelPrior,
    /// Heading error per radian commanded.
    pub turn: robot::ChannelPrior,
    /// Heading error in rad per metre commanded; used where `drift` is on.
    pub drift: robot::ChannelPrior,
    /// What people should know about it; null where no one said anything.
    pub note: Option<String>,
    /// Where it comes from.
    pub source: Source,
    /// The first 100 robots that use it, in the order of their ids.
    pub robots: Vec<RobotId>,
    /// How many robots use it.
    pub robot_count: u64,
    /// Version of values and note, for `If-Match`.
    pub etag: String,
}

impl Prior {
    /// What the fields of a [`Prior`] are called that a [`Spec`] does not have: they are the server's to say.
    pub const GIVEN_BY_SERVER: [&str; 5] = ["prior", "source", "robots", "robot_count", "etag"];

    /// The prior of this name as `spec` has it.
    pub fn new(prior: PriorId, spec: Spec, source: Source, etag: impl Into<String>) -> Self {
        let Spec { forward, lateral, turn, drift, note } = spec;
        let (robots, robot_count, etag) = (Vec::new(), 0, etag.into());
        Self { prior, forward, lateral, turn, drift, note, source, robots, robot_count, etag }
    }

    /// The same, used by `robots`, of which it names the first [`MAX_ROBOTS`].
    pub fn used_by(mut self, robots: impl IntoIterator<Item = RobotId>) -> Self {
        let mut robots = robots.into_iter();
        self.robots = robots.by_ref().take(MAX_ROBOTS).collect();
        self.robot_count = (self.robots.len() + robots.count()) as u64;
        self
    }

    /// The belief about each channel.
    pub fn values(&self) -> robot::Prior {
        let Self { forward, lateral, turn, drift, .. } = *self;
        robot::Prior { forward, lateral, turn, drift }
    }

    /// What one would put to have it again.
    pub fn to_spec(&self) -> Spec {
        Spec { note: self.note.clone(), ..self.values().into() }
    }
}

/// Some of the priors, in the order of their names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = PriorPage)]
pub struct Page {
    /// The priors.
    pub priors: Vec<Prior>,
    /// Those that cannot be read, in the same part of the list; left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unreadable: Vec<Unreadable>,
    /// Where the next page begins; null on the last one.
    pub next_page_token: Option<String>,
}
