//! What is said of an endpoint whatever its types.

use super::wire::Wire;
use std::fmt;

/// How an endpoint is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// Shows something.
    Get,
    /// Creates or replaces what has a name.
    Put,
    /// Changes parts of something.
    Patch,
    /// Does something, or creates what gets its name from the server.
    Post,
    /// Removes something.
    Delete,
}

impl Method {
    /// The name in a request.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Get => "GET",
            Self::Put => "PUT",
            Self::Patch => "PATCH",
            Self::Post => "POST",
            Self::Delete => "DELETE",
        }
    }
}

/// Who may ask. A server has one token as yet, or none, so this is a plan that the table already keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scope {
    /// Everybody, without a token.
    Open,
    /// Who may look.
    Viewer,
    /// The robot itself.
    Robot,
    /// Who may change things.
    Operator,
}

/// A list that comes in pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Paged {
    /// Most items of a page.
    pub max: u64,
    /// Items of a page where nothing is said.
    pub default: u64,
    /// What a page token matches, as ECMAScript has it.
    pub token: &'static str,
}

/// The media type of a document that is no text to who accepts no other: makers of clients know none of pictures.
pub const BYTES: &str = "application/octet-stream";

/// What a success answers.
#[derive(Clone, Copy, Debug)]
pub enum Answer {
    /// JSON, with one of these codes and what each says.
    Json(Wire, &'static [(u16, &'static str)]),
    /// The same, and `Location` says where what was created is.
    Created(Wire, &'static [(u16, &'static str)]),
    /// Server-sent events.
    Events(Wire),
    /// A document of this media type with a version; what it is.
    Document(&'static str, &'static str),
    /// Any JSON object; what it is.
    Object(&'static str),
    /// Nothing; what that says.
    Nothing(&'static str),
}

/// What is said of an endpoint whatever its types.
#[derive(Clone, Copy, Debug)]
pub struct Operation {
    /// How it is asked.
    pub method: Method,
    /// Its path, with its parameters in braces.
    pub path: &'static str,
    /// Its name: unique.
    pub id: &'static str,
    /// What it is for, in a few words.
    pub summary: &'static str,
    /// The rest that one should know; may be empty.
    pub about: &'static str,
    /// The group to which it belongs.
    pub tag: &'static str,
    /// Who may ask.
    pub scope: Scope,
    /// Its body, the most bytes of one, and its media types.
    pub body: Option<(Wire, usize, &'static [&'static str])>,
    /// Whether it takes `If-Match`, and a PUT `If-None-Match`.
    pub is_conditional: bool,
    /// Whether it takes an `Idempotency-Key`.
    pub takes_key: bool,
    /// Its pages, where it is a list.
    pub paged: Option<Paged>,
    /// The states by which a list can be cut down, and what that means.
    pub state: Option<(Wire, &'static str)>,
    /// What a success answers.
    pub answer: Answer,
    /// The HTTP codes with which it fails by itself.
    pub fails: &'static [u16],
}

impl Operation {
    pub(super) const fn new(method: Method, id: &'static str, path: &'static str) -> Self {
        Self {
            method,
            path,
            id,
            summary: "",
            about: "",
            tag: "",
            scope: Scope::Viewer,
            body: None,
            is_conditional: false,
            takes_key: false,
            paged: None,
            state: None,
            answer: Answer::Nothing(""),
            fails: &[],
        }
    }

    /// The parts of its path, its parameters replaced by `values` in their order.
    ///
    /// # Panics
    /// Where there are not as many values as parameters: a mistake in the program.
    pub fn segments<'a>(&self, values: &[&'a str]) -> Vec<&'a str> {
        let mut values = values.iter();
        let parts = self.path.split('/').skip(1);
        let parts = parts
            .map(|part| match is_parameter(part) {
                true => *values.next().expect("a value for every parameter"),
                false => part,
            })
            .collect();
        assert!(values.next().is_none(), "more values than parameters");
        parts
    }

    /// Whether `path` is one of its paths.
    pub fn matches(&self, path: &str) -> bool {
        let mut given = path.split('/');
        let mut own = self.path.split('/');
        loop {
            match (own.next(), given.next()) {
                (None, None) => return true,
                (Some(own), Some(given)) if own == given || is_parameter(own) => {}
                _ => return false,
            }
        }
    }

    /// The names of the parameters in its path.
    pub fn parameters(&self) -> impl Iterator<Item = &'static str> {
        self.path.split('/').filter_map(|part| part.strip_prefix('{')?.strip_suffix('}'))
    }
}

fn is_parameter(part: &str) -> bool {
    part.starts_with('{')
}

impl fmt::Display for Operation {
    /// As `PUT /v1/robots/{robot}`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.method.name(), self.path)
    }
}
