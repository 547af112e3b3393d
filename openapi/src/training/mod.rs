//! Simulated environments by name: a floor and a link on which priors are evolved.
//!
//! What a robot's real environment is found to be stands in [`crate::environment`].

mod floor;
mod link;
mod simulator;

pub use floor::{FLOORS, Floor, SLIP_MEAN, SLIP_SD, Slip, SlipChannel};
pub use link::{
    DELAY, LINKS, LatePackets, Link, LinkModel, MAX_OUTAGES, MAX_ROWS, OUTAGE_DURATION,
    OUTAGE_START, Outage, Rtt, SILENCE_RATE, Silences, TraceRow,
};

use crate::body;
use crate::check::{Check, Range, Validate};
use crate::checked::Checked;
use crate::id::EnvironmentId;
use crate::page::Unreadable;
use crate::prior::MAX_NOTE;
use crate::problem::Problems;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// Largest body of an environment in bytes; the longest trace has 60 kB, the most outages 60 kB.
pub const MAX_BODY: usize = 256 * 1024;

/// Most environments of one page: with the longest traces it is several megabytes.
pub const MAX_PAGE_SIZE: u64 = 100;

/// How much an environment counts beside the others; a thousandth of another one counts for nothing.
pub const WEIGHT: Range = Range::new(1e-3, 1e3, "");

/// Which fitness an individual has on an environment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = Fitness)]
pub enum Fitness {
    /// That of the normal environment (thesis eq. 52).
    #[default]
    Normal,
    /// That of the bad environment (thesis eq. 53).
    Bad,
}

/// A simulated environment as it is put: slip and link by the names of presets or in numbers.
///
/// ```
/// use umwelt_api::training::Spec;
/// let spec = Spec::read(br#"{"slip": "oily", "link": {"rtt": {"kind": "constant", "rtt_s": 0.02}}}"#)?;
/// assert_eq!(spec.weight, 1.0);
///
/// let problems = Spec::read(br#"{"slip": "lava", "link": "bad", "weight": 0}"#).unwrap_err();
/// let fields: Vec<_> = problems.details().iter().map(|detail| detail.field.as_str()).collect();
/// assert_eq!(fields, ["slip", "weight"]);
/// # Ok::<(), umwelt_api::Problems>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TrainingSpec)]
pub struct Spec {
    /// The floor.
    pub slip: Floor,
    /// The link.
    pub link: Link,
    /// Which fitness an individual has on it.
    #[serde(default)]
    pub fitness: Fitness,
    /// How much it counts beside the other environments of an evolution.
    #[serde(default = "weight")]
    #[schema(default = weight)]
    pub weight: f64,
    /// What people should know about it.
    #[serde(default)]
    pub note: Option<String>,
}

fn weight() -> f64 {
    1.0
}

impl Validate for Spec {
    fn check(&self, check: &mut Check) {
        self.slip.check("slip", check);
        self.link.check("link", check);
        check.number("weight", self.weight, WEIGHT);
        check.text("note", self.note.as_deref().unwrap_or_default(), 0..=MAX_NOTE);
    }
}

impl Spec {
    /// Reads the body of a PUT.
    ///
    /// # Errors
    /// Every problem of it: unknown fields, unknown presets, values out of range or that contradict each other.
    pub fn read(json: &[u8]) -> Result<Checked<Self>, Problems> {
        body::read_shared(json)
    }
}

/// A simulated environment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TrainingEnvironment)]
pub struct Environment {
    /// Its name.
    pub environment: EnvironmentId,
    /// The floor.
    pub slip: Floor,
    /// The link.
    pub link: Link,
    /// Which fitness an individual has on it.
    pub fitness: Fitness,
    /// How much it counts beside the other environments of an evolution.
    pub weight: f64,
    /// What people should know about it; null where no one said anything.
    pub note: Option<String>,
    /// Whether it comes with the server: such a one can be neither replaced nor removed.
    pub built_in: bool,
    /// Version of what was put, for `If-Match`.
    pub etag: String,
}

impl Environment {
    /// What the fields of an [`Environment`] are called that a [`Spec`] does not have: they are the server's to say.
    pub const GIVEN_BY_SERVER: [&str; 3] = ["environment", "built_in", "etag"];

    /// The environment of this name as `spec` has it.
    pub fn new(
        environment: EnvironmentId,
        spec: Spec,
        built_in: bool,
        etag: impl Into<String>,
    ) -> Self {
        let Spec { slip, link, fitness, weight, note } = spec;
        Self { environment, slip, link, fitness, weight, note, built_in, etag: etag.into() }
    }

    /// What one would put to have it again.
    pub fn to_spec(&self) -> Spec {
        let Self { slip, link, fitness, weight, note, .. } = self.clone();
        Spec { slip, link, fitness, weight, note }
    }
}

/// Some of the simulated environments, in the order of their names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TrainingPage)]
pub struct Page {
    /// The environments.
    pub environments: Vec<Environment>,
    /// Those that cannot be read, in the same part of the list; left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unreadable: Vec<Unreadable>,
    /// Where the next page begins; null on the last one.
    pub next_page_token: Option<String>,
}
