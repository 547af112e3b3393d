//! The job that a path names.

use super::resource::Resource;
use crate::http::app::App;
use crate::http::extract::named;
use crate::jobs::Job;
use crate::resource::failure::{self, Failure};
use crate::store::Kind;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use std::sync::Arc;

/// The job that a path names: the `{evolution}` of `/v1/evolutions/{evolution}`.
pub(crate) struct Named<W: Resource>(pub(crate) Arc<Job<W>>);

impl<W: Resource> FromRequestParts<App> for Named<W> {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Failure> {
        let kind = W::KIND.name();
        let id: W::Id = named(parts, app, kind).await?;
        let found = W::jobs(app).find(id.as_ref()).map(Self);
        let name = id.as_ref();
        found.ok_or_else(|| {
            let unreadable = app.unreadable.failure(Kind::Job(W::KIND), name);
            unreadable.unwrap_or_else(|| failure::no_such(kind, name))
        })
    }
}

/// The id in a path of a job, valid but perhaps of none.
pub(crate) struct Name<W: Resource>(pub(crate) W::Id);

impl<W: Resource, S: Send + Sync> FromRequestParts<S> for Name<W> {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Failure> {
        named(parts, state, W::KIND.name()).await.map(Self)
    }
}
