//! One route of the contract and its OpenAPI form.

use crate::id::{ComparisonId, EnvironmentId, EvolutionId, PriorId, RobotId};
use crate::idempotency::MAX_KEY;
use crate::page::MAX_PAGE_TOKEN;
use crate::problem::ErrorBody;
use crate::{IdempotencyKey, comparison, evolution};
use std::collections::BTreeMap;
use utoipa::ToSchema;
use utoipa::openapi::path::{OperationBuilder, ParameterBuilder, ParameterIn};
use utoipa::openapi::request_body::RequestBodyBuilder;
use utoipa::openapi::schema::{ObjectBuilder, Schema, SchemaType, Type};
use utoipa::openapi::{
    ContentBuilder, HeaderBuilder, HttpMethod, PathItem, Ref, RefOr, Required, Response,
    ResponseBuilder,
};

/// A page token that is the last id of the page before.
pub(super) const ID_TOKEN: &str = "^[a-z0-9-]{1,63}$";

/// A page token that is the last number of the page before.
pub(super) const NUMBER_TOKEN: &str = "^[0-9]{1,19}$";

/// Schemas by name.
pub(super) type Schemas = BTreeMap<String, RefOr<Schema>>;

/// One operation on one path.
pub(super) struct Route {
    path: &'static str,
    schemas: Schemas,
    method: HttpMethod,
    operation: OperationBuilder,
    about: String,
}

/// What 304 says.
const NOT_MODIFIED: &str = "It is as it was: `If-None-Match` names its version";

impl Route {
    pub(super) fn get(path: &'static str, id: &str, summary: &str) -> Self {
        Self::new(HttpMethod::Get, path, id, summary)
    }

    pub(super) fn put(path: &'static str, id: &str, summary: &str) -> Self {
        Self::new(HttpMethod::Put, path, id, summary)
    }

    pub(super) fn post(path: &'static str, id: &str, summary: &str) -> Self {
        Self::new(HttpMethod::Post, path, id, summary)
    }

    pub(super) fn delete(path: &'static str, id: &str, summary: &str) -> Self {
        Self::new(HttpMethod::Delete, path, id, summary)
    }

    /// Every operation knows its path parameters, whose names say what they are, and may fail.
    fn new(method: HttpMethod, path: &'static str, id: &str, summary: &str) -> Self {
        let operation = OperationBuilder::new().operation_id(Some(id)).summary(Some(summary));
        let about = String::new();
        let mut route = Self { path, schemas: Schemas::new(), method, operation, about };
        for name in path.split('/').filter_map(|part| part.strip_prefix('{')?.strip_suffix('}')) {
            let schema = match name {
                "robot" => route.schema::<RobotId>(),
                "prior" => route.schema::<PriorId>(),
                "environment" => route.schema::<EnvironmentId>(),
                "evolution" => route.schema::<EvolutionId>(),
                "comparison" => route.schema::<ComparisonId>(),
                "figure" if path.starts_with("/v1/comparisons/") => {
                    route.schema::<comparison::Figure>()
                }
                "figure" => route.schema::<evolution::Figure>(),
                other => unreachable!("nobody knows what a {other} is"),
            };
            let about = format!("Id of the {name}");
            route = route.parameter(name, ParameterIn::Path, Required::True, &about, schema);
        }
        let problem = route.problem("Any other problem").build();
        route.operation = route.operation.response("default", problem);
        route
    }

    pub(super) fn tag(mut self, tag: &str) -> Self {
        self.operation = self.operation.tag(tag);
        self
    }

    pub(super) fn about(mut self, description: &str) -> Self {
        self.about.push_str(description);
        self
    }

    pub(super) fn query(self, name: &str, about: &str, schema: RefOr<Schema>) -> Self {
        self.parameter(name, ParameterIn::Query, Required::False, about, schema)
    }

    pub(super) fn query_as<T: ToSchema>(mut self, name: &str, about: &str) -> Self {
        let schema = self.schema::<T>();
        self.query(name, about, schema)
    }

    /// A list that comes in pages of at most `max`; `token` is what a page token matches.
    pub(super) fn paged(self, max: u64, default: u64, token: &str) -> Self {
        let schema = ObjectBuilder::new()
            .schema_type(SchemaType::Type(Type::String))
            .max_length(Some(MAX_PAGE_TOKEN))
            .pattern(Some(token));
        self.query("page_size", "Most of them to list", integer(1, max, default)).query(
            "page_token",
            "The `next_page_token` of the page before",
            schema.into(),
        )
    }

    /// Takes `If-Match`, and where something is put `If-None-Match` too. They are no parameters: a value that the schema
    /// of one allows is refused where the resource is another one, which is what it is for.
    pub(super) fn conditional(mut self) -> Self {
        let words = if self.method == HttpMethod::Put {
            "With the header `If-Match: ETAG` it is written only if it still has this `etag`, `*` only if it exists; with `If-None-Match: *` only if it does not."
        } else {
            "With the header `If-Match: ETAG` it is removed only if it still has this `etag`."
        };
        if !self.about.is_empty() {
            self.about.push(' ');
        }
        self.about.push_str(words);
        self.fails(&[412])
    }

    pub(super) fn idempotency_key(self) -> Self {
        let about = "Of this one intention to create: visible ASCII characters, best a random UUID";
        let schema = ObjectBuilder::new()
            .schema_type(SchemaType::Type(Type::String))
            .min_length(Some(1))
            .max_length(Some(MAX_KEY))
            .pattern(Some("^[!-~]+$"));
        let (place, optional) = (ParameterIn::Header, Required::False);
        self.parameter(IdempotencyKey::HEADER, place, optional, about, schema.into())
    }

    pub(super) fn last_event_id(self) -> Self {
        let about = "Id of the last event that was received";
        let schema = integer_from(0);
        self.parameter("Last-Event-ID", ParameterIn::Header, Required::False, about, schema)
    }

    pub(super) fn takes<T: ToSchema>(mut self) -> Self {
        let content = ContentBuilder::new().schema(Some(self.schema::<T>())).build();
        let body = RequestBodyBuilder::new()
            .required(Some(Required::True))
            .content("application/json", content)
            .build();
        self.operation = self.operation.request_body(Some(body));
        self.fails(&[408, 413, 415])
    }

    pub(super) fn gives<T: ToSchema>(mut self, code: u16, about: &str) -> Self {
        let content = ContentBuilder::new().schema(Some(self.schema::<T>())).build();
        let response =
            ResponseBuilder::new().description(about).content("application/json", content);
        self.respond(code, response.build())
    }

    /// Gives what was created, and says in `Location` where it is.
    pub(super) fn creates<T: ToSchema>(mut self, about: &str) -> Self {
        let content = ContentBuilder::new().schema(Some(self.schema::<T>())).build();
        let location = HeaderBuilder::new()
            .schema(Some(text(200)))
            .description(Some("Path of what was created"))
            .build();
        let response = ResponseBuilder::new()
            .description(about)
            .header("Location", location)
            .content("application/json", content);
        self.respond(201, response.build())
    }

    /// Gives a document that has a version, to those who do not have that already.
    pub(super) fn gives_text(self, media_type: &str, about: &str) -> Self {
        let schema = ObjectBuilder::new().schema_type(SchemaType::Type(Type::String)).build();
        let content = ContentBuilder::new().schema(Some(schema)).build();
        let etag = HeaderBuilder::new()
            .schema(Some(text(200)))
            .description(Some("Version of the document"))
            .build();
        let response = ResponseBuilder::new()
            .description(about)
            .header("ETag", etag.clone())
            .content(media_type, content);
        let unchanged = ResponseBuilder::new().description(NOT_MODIFIED).header("ETag", etag);
        let known = "Not again if it has this `ETag` still";
        self.parameter("If-None-Match", ParameterIn::Header, Required::False, known, text(200))
            .respond(200, response.build())
            .respond(304, unchanged.build())
    }

    pub(super) fn gives_object(self, about: &str) -> Self {
        let schema = ObjectBuilder::new().schema_type(SchemaType::Type(Type::Object)).build();
        let content = ContentBuilder::new().schema(Some(schema)).build();
        let response =
            ResponseBuilder::new().description(about).content("application/json", content);
        self.respond(200, response.build())
    }

    pub(super) fn gives_nothing(self, about: &str) -> Self {
        self.respond(204, Response::new(about))
    }

    pub(super) fn streams<T: ToSchema>(mut self, about: &str) -> Self {
        let content = ContentBuilder::new().schema(Some(self.schema::<T>())).build();
        let response =
            ResponseBuilder::new().description(about).content("text/event-stream", content);
        self.respond(200, response.build())
    }

    pub(super) fn fails(mut self, codes: &[u16]) -> Self {
        for &code in codes {
            let about = match code {
                400 => "INVALID_ARGUMENT or OUT_OF_RANGE: every bad field at once",
                404 => "NOT_FOUND",
                408 => "DEADLINE_EXCEEDED: the body did not arrive in time",
                409 => {
                    "FAILED_PRECONDITION, ALREADY_EXISTS or ABORTED: the request is good, the state is another one"
                }
                412 => "ABORTED or ALREADY_EXISTS: not as `If-Match` or `If-None-Match` want it",
                413 => "INVALID_ARGUMENT: the body is too large",
                415 => "INVALID_ARGUMENT: the body is not declared as JSON, or is compressed",
                429 => "RESOURCE_EXHAUSTED: too much at once",
                503 => "UNAVAILABLE: not now, ask again",
                other => unreachable!("no words for {other}"),
            };
            let mut response = self.problem(about);
            if code == 429 {
                let header = HeaderBuilder::new()
                    .schema(Some(integer_from(0)))
                    .description(Some("Seconds to wait before asking again"))
                    .build();
                response = response.header("Retry-After", header);
            }
            self = self.respond(code, response.build());
        }
        self
    }

    /// The path, its item with this one operation, and the schemas that it uses.
    pub(super) fn into_parts(self) -> (&'static str, PathItem, Schemas) {
        let about = Some(self.about).filter(|about| !about.is_empty());
        let operation = self.operation.description(about);
        (self.path, PathItem::new(self.method, operation), self.schemas)
    }

    fn problem(&mut self, about: &str) -> ResponseBuilder {
        let content = ContentBuilder::new().schema(Some(self.schema::<ErrorBody>())).build();
        ResponseBuilder::new().description(about).content("application/json", content)
    }

    fn respond(mut self, code: u16, response: Response) -> Self {
        self.operation = self.operation.response(code.to_string(), response);
        self
    }

    fn parameter(
        mut self,
        name: &str,
        place: ParameterIn,
        required: Required,
        about: &str,
        schema: RefOr<Schema>,
    ) -> Self {
        let parameter = ParameterBuilder::new()
            .name(name)
            .parameter_in(place)
            .required(required)
            .description(Some(about))
            .schema(Some(schema));
        self.operation = self.operation.parameter(parameter.build());
        self
    }

    /// A reference to the schema of `T`, which is kept with all that it refers to.
    fn schema<T: ToSchema>(&mut self) -> RefOr<Schema> {
        let name = T::name().into_owned();
        let mut found = vec![(name.clone(), T::schema())];
        T::schemas(&mut found);
        self.schemas.extend(found);
        Ref::from_schema_name(name).into()
    }
}

/// An integer from `min` to `max`.
pub(super) fn integer(min: u64, max: u64, default: u64) -> RefOr<Schema> {
    ObjectBuilder::new()
        .schema_type(SchemaType::Type(Type::Integer))
        .minimum(Some(min as f64))
        .maximum(Some(max as f64))
        .default(Some(default.into()))
        .into()
}

fn integer_from(min: u64) -> RefOr<Schema> {
    ObjectBuilder::new()
        .schema_type(SchemaType::Type(Type::Integer))
        .minimum(Some(min as f64))
        .into()
}

/// A text of at most `max` bytes.
pub(super) fn text(max: usize) -> RefOr<Schema> {
    ObjectBuilder::new().schema_type(SchemaType::Type(Type::String)).max_length(Some(max)).into()
}
