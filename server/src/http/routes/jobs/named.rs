//! The job that a path names.

use super::resource::Resource;
use crate::http::app::App;
use crate::http::extract::named;
use crate::jobs::{Job, Jobs};
use crate::resource::failure::{self, Failure};
use crate::store::Kind;
use axum::extract::{FromRef, FromRequestParts};
use axum::http::request::Parts;
use std::sync::Arc;
use umwelt_api::job::JobKind;

/// The job that a path names: the `{evolution}` of `/v1/evolutions/{evolution}`.
pub(crate) struct Named<W: Resource>(pub(crate) Arc<Job<W>>);

impl<W: Resource, S: Send + Sync> FromRequestParts<S> for Named<W>
where
    App: FromRef<S>,
    Jobs<W>: FromRef<S>,
{
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Failure> {
        let Name(id) = Name::<W>::from_request_parts(parts, state).await?;
        let name = id.as_ref();
        Jobs::<W>::from_ref(state).find(name).map(Self).ok_or_else(|| {
            let unreadable = App::from_ref(state).unreadable.failure(Kind::Job(W::KIND), name);
            unreadable.unwrap_or_else(|| failure::no_such(W::KIND.name(), name))
        })
    }
}

/// The id in a path of a job, valid but perhaps of none.
pub(crate) struct Name<W: Resource>(pub(crate) <W::Kind as JobKind>::Id);

impl<W: Resource, S: Send + Sync> FromRequestParts<S> for Name<W> {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Failure> {
        named(parts, state, W::KIND.name()).await.map(Self)
    }
}
