//! The schemas of the wire's types: there with the feature `document`, which makes the contract anew.

#[cfg(not(feature = "document"))]
pub use umwelt_no_schema::ToSchema;
#[cfg(feature = "document")]
pub use utoipa::ToSchema;

/// A type with a schema; without the feature `document` that is every type.
#[cfg(not(feature = "document"))]
pub trait ToSchema {}

#[cfg(not(feature = "document"))]
impl<T> ToSchema for T {}
