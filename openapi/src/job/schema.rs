//! The schemas of jobs, pages and events of any kind, with the names of the wire.

use super::{Job, JobDescription, JobEvent, JobKind, JobPage, State};
use crate::page::Unreadable;
use std::borrow::Cow;
use utoipa::openapi::schema::{
    AllOfBuilder, ArrayBuilder, Object, ObjectBuilder, SchemaType, Type,
};
use utoipa::openapi::{Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

type Schemas = Vec<(String, RefOr<Schema>)>;

impl<K: JobKind> PartialSchema for Job<K> {
    fn schema() -> RefOr<Schema> {
        let JobDescription { one, .. } = K::DESCRIPTION;
        let mut job = ObjectBuilder::new()
            .description(Some(format!("{} as it is now.", capitalised(one))))
            .property(K::NAME, reference::<K::Id>("Its id, given by the server."))
            .required(K::NAME)
            .property("state", reference::<State>("Where it stands."))
            .required("state")
            .property("spec", reference::<K::Spec>("What was asked for, all filled in."))
            .required("spec")
            .property("progress", reference::<K::Progress>("How far it has got."))
            .required("progress")
            .property("interrupted", count("How often it went on after a restart of the server."))
            .required("interrupted")
            .property(
                "created_unix_s",
                count("When it was submitted, in seconds since 1970 by the server's clock."),
            )
            .required("created_unix_s")
            .property(
                "error",
                text_or_null(
                    "Why it failed, or what keeps it from going on; null where nothing does.",
                ),
            )
            .build();
        if let RefOr::T(Schema::Object(outcome)) = K::Outcome::schema() {
            job.properties.extend(outcome.properties);
            job.required.extend(outcome.required);
        }
        job.into()
    }
}

impl<K: JobKind> ToSchema for Job<K> {
    fn name() -> Cow<'static, str> {
        K::DESCRIPTION.job.into()
    }

    fn schemas(schemas: &mut Schemas) {
        add::<K::Id>(schemas);
        add::<State>(schemas);
        add::<K::Spec>(schemas);
        add::<K::Progress>(schemas);
        K::Outcome::schemas(schemas);
    }
}

impl<K: JobKind> PartialSchema for JobPage<K> {
    fn schema() -> RefOr<Schema> {
        let jobs = ArrayBuilder::new()
            .items(Ref::from_schema_name(Job::<K>::name()))
            .description(Some(K::DESCRIPTION.listed));
        let unreadable = ArrayBuilder::new().items(Ref::from_schema_name(Unreadable::name())).description(Some(
            "Those that cannot be read, in the same part of the list; left out where there are none.",
        ));
        let about = format!("Some of the {}, the newest first.", K::LIST);
        ObjectBuilder::new()
            .description(Some(about))
            .property(K::LIST, jobs)
            .required(K::LIST)
            .property("unreadable", unreadable)
            .property(
                "next_page_token",
                text_or_null("Where the next page begins; null on the last one."),
            )
            .into()
    }
}

impl<K: JobKind> ToSchema for JobPage<K> {
    fn name() -> Cow<'static, str> {
        K::DESCRIPTION.page.into()
    }

    fn schemas(schemas: &mut Schemas) {
        add::<Job<K>>(schemas);
        add::<Unreadable>(schemas);
    }
}

impl<K: JobKind> PartialSchema for JobEvent<K> {
    fn schema() -> RefOr<Schema> {
        let JobDescription { one, event_id, .. } = K::DESCRIPTION;
        let fields = ObjectBuilder::new()
            .property("id", count(event_id))
            .required("id")
            .property(K::NAME, reference::<K::Id>(&format!("The {}.", K::NAME)))
            .required(K::NAME);
        AllOfBuilder::new()
            .item(reference::<K::News>("What happened."))
            .item(fields)
            .description(Some(format!("Something that happened to {one}.")))
            .into()
    }
}

impl<K: JobKind> ToSchema for JobEvent<K> {
    fn name() -> Cow<'static, str> {
        K::DESCRIPTION.event.into()
    }

    fn schemas(schemas: &mut Schemas) {
        add::<K::Id>(schemas);
        add::<K::News>(schemas);
    }
}

/// Adds the schema of `T` and all that it refers to.
fn add<T: ToSchema>(schemas: &mut Schemas) {
    schemas.push((T::name().into_owned(), T::schema()));
    T::schemas(schemas);
}

fn reference<T: ToSchema>(about: &str) -> RefOr<Schema> {
    let mut reference = Ref::from_schema_name(T::name());
    about.clone_into(&mut reference.description);
    reference.into()
}

fn count(about: &str) -> RefOr<Schema> {
    let mut schema = u64::schema();
    if let RefOr::T(Schema::Object(integer)) = &mut schema {
        integer.description = Some(about.to_owned());
    }
    schema
}

fn text_or_null(about: &str) -> Object {
    ObjectBuilder::new()
        .schema_type(SchemaType::from_iter([Type::String, Type::Null]))
        .description(Some(about))
        .build()
}

fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}
