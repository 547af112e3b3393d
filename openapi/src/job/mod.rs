//! Jobs: what the server does in the background, whatever its kind. Jobs of a kind are run one at a time.
//!
//! A kind is a [`JobKind`]: it names its fields and says what is asked for, how far a job has got, and with what it ends.
//! All the rest is described once: [`Job`], [`JobPage`], [`JobEvent`].
//!
//! On the wire an id stands in a field of the kind's name (`evolution`, `comparison`) and a list in one of its plural, and
//! what a job ends with stands beside the fields of all jobs. Fields of the type cannot have names that depend on the kind,
//! so these three are written and read by functions (`field`), and the schemas are put together by hand (`schema`).

mod field;
mod kind;
mod resource;
#[cfg(feature = "document")]
mod schema;
mod state;

pub use kind::{JobDescription, JobKind, JobNews, Wire};
pub use resource::{Job, JobEvent, JobPage};
pub use state::State;
