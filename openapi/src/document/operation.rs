//! One operation of the contract in its OpenAPI form.

use super::{examples, failures};
use crate::endpoint::{Answer, BYTES, Method, Operation, Paged, Schemas, Wire};
use crate::id::{ComparisonId, EnvironmentId, EvolutionId, PriorId, RobotId};
use crate::idempotency::MAX_KEY;
use crate::page::MAX_PAGE_TOKEN;
use crate::{IdempotencyKey, comparison, evolution};
use utoipa::openapi::path::{OperationBuilder, ParameterBuilder, ParameterIn};
use utoipa::openapi::request_body::RequestBodyBuilder;
use utoipa::openapi::schema::{ObjectBuilder, OneOfBuilder, Schema, SchemaType, Type};
use utoipa::openapi::{
    Content, ContentBuilder, HeaderBuilder, HttpMethod, PathItem, Ref, RefOr, Required, Response,
    ResponseBuilder,
};
use utoipa::{PartialSchema, ToSchema};

/// What 304 says.
const NOT_MODIFIED: &str = "It is as it was: `If-None-Match` names its version";

/// The path item with `operation` alone; the schemas that it uses go into `schemas`.
pub(super) fn item(operation: &Operation, schemas: &mut Schemas) -> PathItem {
    let method = match operation.method {
        Method::Get => HttpMethod::Get,
        Method::Put => HttpMethod::Put,
        Method::Patch => HttpMethod::Patch,
        Method::Post => HttpMethod::Post,
        Method::Delete => HttpMethod::Delete,
    };
    let mut built = OperationBuilder::new()
        .operation_id(Some(operation.id))
        .summary(Some(operation.summary))
        .tag(operation.tag)
        .description(Some(about(operation)).filter(|about| !about.is_empty()));
    built = parameters(built, operation, schemas);
    if let Some((wire, _, media_types)) = operation.body {
        let content = content(&wire, schemas);
        let body = RequestBodyBuilder::new().required(Some(Required::True));
        let body = media_types.iter().fold(body, |body, it| body.content(*it, content.clone()));
        built = built.request_body(Some(body.build()));
    }
    built = answers(built, operation.answer, schemas);
    for code in codes(operation) {
        built = built.response(code.to_string(), Ref::from_response_name(failures::name(code)));
    }
    built = built.response("default", Ref::from_response_name(failures::ANY));
    PathItem::new(method, built)
}

/// The codes with which an operation fails: its own, and those of what it takes.
fn codes(operation: &Operation) -> Vec<u16> {
    let mut codes = operation.fails.to_vec();
    if operation.body.is_some() {
        codes.extend([408, 413, 415]);
    }
    if operation.is_conditional {
        codes.push(412);
    }
    codes
}

/// What one should know. `If-Match` is said here and is no parameter: a value that the schema of one allows is refused
/// where the resource is another one, which is what it is for.
fn about(operation: &Operation) -> String {
    let conditional = match (operation.is_conditional, operation.method) {
        (false, _) => "",
        (true, Method::Put) => {
            "With the header `If-Match: ETAG` it is written only if it still has this `etag`, `*` only if it exists; with `If-None-Match: *` only if it does not."
        }
        (true, Method::Patch) => {
            "With the header `If-Match: ETAG` it is changed only if it still has this `etag`."
        }
        (true, _) => {
            "With the header `If-Match: ETAG` it is removed only if it still has this `etag`."
        }
    };
    let words = [operation.about, conditional].into_iter().filter(|words| !words.is_empty());
    words.collect::<Vec<_>>().join(" ")
}

fn parameters(
    mut built: OperationBuilder,
    operation: &Operation,
    schemas: &mut Schemas,
) -> OperationBuilder {
    for name in operation.parameters() {
        let schema = match name {
            "robot" => named::<RobotId>(schemas),
            "prior" => named::<PriorId>(schemas),
            "environment" => named::<EnvironmentId>(schemas),
            "evolution" => named::<EvolutionId>(schemas),
            "comparison" => named::<ComparisonId>(schemas),
            "figure" if operation.tag == "comparisons" => named::<comparison::Figure>(schemas),
            "figure" => named::<evolution::Figure>(schemas),
            other => unreachable!("no parameter of a path is called {other}"),
        };
        let parameter = ParameterBuilder::new()
            .name(name)
            .parameter_in(ParameterIn::Path)
            .required(Required::True)
            .description(Some(format!("Id of the {name}")))
            .schema(Some(schema));
        built = built.parameter(parameter.build());
    }
    let mut optional = Vec::new();
    if let Some(Paged { max, default, token }) = operation.paged {
        let size = integer(1, Some(max), Some(default));
        let schema = text(MAX_PAGE_TOKEN).pattern(Some(token));
        let about = "The `next_page_token` of the page before";
        optional.push(("page_size", ParameterIn::Query, "Most of them to list", size));
        optional.push(("page_token", ParameterIn::Query, about, schema.into()));
    }
    if let Some((wire, about)) = operation.state {
        optional.push(("state", ParameterIn::Query, about, wire.schema(schemas).1));
    }
    if operation.takes_key {
        let about = "Of this one intention to create: visible ASCII characters, best a random UUID";
        let schema = text(MAX_KEY).min_length(Some(1)).pattern(Some("^[!-~]+$")).into();
        optional.push((IdempotencyKey::HEADER, ParameterIn::Header, about, schema));
    }
    if let Answer::Events(_) = operation.answer {
        let about = "Id of the last event that was received";
        let schema = integer(0, None, None);
        optional.push(("Last-Event-ID", ParameterIn::Header, about, schema));
    }
    if let Answer::Document(..) = operation.answer {
        let about = "Not again if it has this `ETag` still";
        let schema = ObjectBuilder::new().schema_type(SchemaType::Type(Type::String));
        optional.push(("If-None-Match", ParameterIn::Header, about, schema.into()));
    }
    for (name, place, about, schema) in optional {
        let parameter = ParameterBuilder::new()
            .name(name)
            .parameter_in(place)
            .required(Required::False)
            .description(Some(about))
            .schema(Some(schema));
        built = built.parameter(parameter.build());
    }
    built
}

fn answers(built: OperationBuilder, answer: Answer, schemas: &mut Schemas) -> OperationBuilder {
    let described = |words: &str| ResponseBuilder::new().description(words);
    match answer {
        Answer::Json(wire, codes) | Answer::Created(wire, codes) => {
            codes.iter().fold(built, |built, &(code, words)| {
                let mut response =
                    described(words).content("application/json", content(&wire, schemas));
                if code == 201 && matches!(answer, Answer::Created(..)) {
                    let location = HeaderBuilder::new()
                        .schema(Some(text(200)))
                        .description(Some("Path of what was created"));
                    response = response.header("Location", location.build());
                }
                built.response(code.to_string(), response.build())
            })
        }
        Answer::Events(wire) => {
            // Who reads events one by one has the event, who takes the stream for one answer its text.
            let whole = ObjectBuilder::new()
                .schema_type(SchemaType::Type(Type::String))
                .description(Some("All that comes until the stream ends, as text"));
            let either = OneOfBuilder::new().item(wire.schema(schemas).1).item(whole).build();
            let content = ContentBuilder::new().schema(Some(Schema::OneOf(either)));
            let response = described("One event per `data:` line")
                .content("text/event-stream", content.build());
            built.response("200", response.build())
        }
        Answer::Document(media_type, words) => document(built, media_type, words),
        Answer::Object(words) => {
            let schema = ObjectBuilder::new().schema_type(SchemaType::Type(Type::Object)).build();
            let content = ContentBuilder::new().schema(Some(schema)).build();
            built.response("200", described(words).content("application/json", content).build())
        }
        Answer::Nothing(words) => built.response("204", Response::new(words)),
    }
}

/// A document that has a version, for those who do not have that already. Who knows no pictures takes it as bytes.
fn document(built: OperationBuilder, media_type: &str, words: &str) -> OperationBuilder {
    let etag = HeaderBuilder::new()
        .schema(Some(text(200)))
        .description(Some("Version of the document"))
        .build();
    let written = |schema: ObjectBuilder| Content::new(Some(Schema::Object(schema.build())));
    let mut response =
        ResponseBuilder::new().description(words).header("ETag", etag.clone()).content(
            media_type,
            written(ObjectBuilder::new().schema_type(SchemaType::Type(Type::String))),
        );
    if !media_type.starts_with("text/") {
        response = response.content(BYTES, written(bytes()));
    }
    let unchanged = ResponseBuilder::new().description(NOT_MODIFIED).header("ETag", etag);
    built.response("200", response.build()).response("304", unchanged.build())
}

fn content(wire: &Wire, schemas: &mut Schemas) -> Content {
    let (name, schema) = wire.schema(schemas);
    ContentBuilder::new().schema(Some(schema)).example(examples::of(&name)).build()
}

/// A reference to the schema of `T`, which has no parts.
fn named<T: ToSchema + PartialSchema>(schemas: &mut Schemas) -> RefOr<Schema> {
    let name = T::name().into_owned();
    schemas.insert(name.clone(), T::schema());
    Ref::from_schema_name(name).into()
}

/// An integer from `min` on.
fn integer(min: u64, max: Option<u64>, default: Option<u64>) -> RefOr<Schema> {
    ObjectBuilder::new()
        .schema_type(SchemaType::Type(Type::Integer))
        .minimum(Some(min as f64))
        .maximum(max.map(|max| max as f64))
        .default(default.map(Into::into))
        .into()
}

/// A text of at most `max` bytes.
fn text(max: usize) -> ObjectBuilder {
    ObjectBuilder::new().schema_type(SchemaType::Type(Type::String)).max_length(Some(max))
}

fn bytes() -> ObjectBuilder {
    let format = utoipa::openapi::SchemaFormat::KnownFormat(utoipa::openapi::KnownFormat::Binary);
    ObjectBuilder::new().schema_type(SchemaType::Type(Type::String)).format(Some(format))
}
