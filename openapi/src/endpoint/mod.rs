//! Every endpoint of the contract, each said once: the document, the server's router and the client are made from these
//! constants.
//!
//! ```
//! use umwelt_api::endpoint::{Method, PUT_TASK};
//! let task = PUT_TASK.operation();
//! assert_eq!((task.method, task.path), (Method::Put, "/v1/robots/{robot}/task"));
//! assert_eq!(task.segments(&["rover-7"]), ["v1", "robots", "rover-7", "task"]);
//! assert_eq!(task.to_string(), "PUT /v1/robots/{robot}/task");
//! ```

/// Constants of [`Endpoint`] whose first line of documentation is their summary, and the list of them.
macro_rules! endpoints {
    ($(#[doc = $summary:literal] $(#[doc = $rest:literal])* $name:ident: $type:ty = $value:expr;)*) => {
        $(
            #[doc = $summary]
            $(#[doc = $rest])*
            pub const $name: $type = $value.summary($summary);
        )*

        pub(super) const ALL: &[Operation] = &[$($name.operation()),*];
    };
}

mod body;
mod jobs;
mod library;
mod operation;
mod robots;
mod server;
mod wire;

pub use jobs::*;
pub use library::*;
pub use operation::{Answer, BYTES, Method, Operation, Paged, Scope};
pub use robots::*;
pub use server::*;
#[cfg(feature = "document")]
pub use wire::Schemas;
pub use wire::Wire;

use crate::body::{Body, Wired};
use crate::schema::ToSchema;
use std::marker::PhantomData;

/// An endpoint whose request has a body `B` and whose answer is an `A`; `()` where there is none, or no JSON.
#[derive(Clone, Copy, Debug)]
pub struct Endpoint<B = (), A = ()> {
    operation: Operation,
    types: PhantomData<fn(B) -> A>,
}

/// Every operation, in reading order.
pub fn all() -> impl Iterator<Item = &'static Operation> {
    [robots::ALL, library::ALL, jobs::ALL, server::ALL].into_iter().flatten()
}

const fn get(id: &'static str, path: &'static str) -> Endpoint {
    Endpoint::new(Operation::new(Method::Get, id, path))
}

const fn put(id: &'static str, path: &'static str) -> Endpoint {
    Endpoint::new(Operation { scope: Scope::Operator, ..Operation::new(Method::Put, id, path) })
}

const fn patch(id: &'static str, path: &'static str) -> Endpoint {
    Endpoint::new(Operation { scope: Scope::Operator, ..Operation::new(Method::Patch, id, path) })
}

const fn post(id: &'static str, path: &'static str) -> Endpoint {
    Endpoint::new(Operation { scope: Scope::Operator, ..Operation::new(Method::Post, id, path) })
}

const fn delete(id: &'static str, path: &'static str) -> Endpoint {
    Endpoint::new(Operation { scope: Scope::Operator, ..Operation::new(Method::Delete, id, path) })
}

impl<B, A> Endpoint<B, A> {
    const fn new(operation: Operation) -> Self {
        Self { operation, types: PhantomData }
    }

    /// What is said of it whatever its types.
    pub const fn operation(&self) -> Operation {
        self.operation
    }

    const fn summary(self, words: &'static str) -> Self {
        Self::new(Operation { summary: words.trim_ascii(), ..self.operation })
    }

    const fn tag(self, tag: &'static str) -> Self {
        Self::new(Operation { tag, ..self.operation })
    }

    const fn about(self, about: &'static str) -> Self {
        Self::new(Operation { about, ..self.operation })
    }

    const fn scope(self, scope: Scope) -> Self {
        Self::new(Operation { scope, ..self.operation })
    }

    /// Takes `If-Match`, and where something is put `If-None-Match` too.
    const fn conditional(self) -> Self {
        Self::new(Operation { is_conditional: true, ..self.operation })
    }

    /// Takes an `Idempotency-Key`.
    const fn keyed(self) -> Self {
        Self::new(Operation { takes_key: true, ..self.operation })
    }

    /// A list that comes in pages.
    const fn paged(self, paged: Paged) -> Self {
        Self::new(Operation { paged: Some(paged), ..self.operation })
    }

    /// A list of which those in one state can be asked for.
    const fn by_state<S: ToSchema>(self, about: &'static str) -> Self {
        Self::new(Operation { state: Some((Wire::query::<S>(), about)), ..self.operation })
    }

    const fn fails(self, codes: &'static [u16]) -> Self {
        Self::new(Operation { fails: codes, ..self.operation })
    }

    const fn takes<T: Body>(self) -> Endpoint<T, A> {
        let body = Some((Wire::of::<T>(), T::MAX_BYTES, T::MEDIA_TYPES));
        Endpoint::new(Operation { body, ..self.operation })
    }

    /// Answers JSON, with one of these codes.
    const fn gives<T: Wired>(self, codes: &'static [(u16, &'static str)]) -> Endpoint<B, T> {
        Endpoint::new(Operation { answer: Answer::Json(Wire::of::<T>(), codes), ..self.operation })
    }

    /// Answers JSON, and says where what was created is.
    const fn creates<T: Wired>(self, codes: &'static [(u16, &'static str)]) -> Endpoint<B, T> {
        let answer = Answer::Created(Wire::of::<T>(), codes);
        Endpoint::new(Operation { answer, ..self.operation })
    }

    /// Answers server-sent events.
    const fn streams<T: Wired>(self) -> Endpoint<B, T> {
        Endpoint::new(Operation { answer: Answer::Events(Wire::of::<T>()), ..self.operation })
    }

    const fn answers(self, answer: Answer) -> Self {
        Self::new(Operation { answer, ..self.operation })
    }
}
