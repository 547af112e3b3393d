//! A type of the wire as a value: its schema, and whether JSON is one.

use crate::body::Wired;
use crate::schema::ToSchema;
#[cfg(all(test, feature = "document"))]
use serde_json::Value;
#[cfg(feature = "document")]
use std::collections::BTreeMap;
#[cfg(feature = "document")]
use utoipa::openapi::{Ref, RefOr, Schema};

/// Schemas by name.
#[cfg(feature = "document")]
pub type Schemas = BTreeMap<String, RefOr<Schema>>;

/// A type of the wire.
#[derive(Clone, Copy, Debug)]
pub struct Wire {
    #[cfg(feature = "document")]
    schema: fn(&mut Schemas) -> (String, RefOr<Schema>),
    // Every type read and written once more is half a minute of compiling.
    #[cfg(all(test, feature = "document"))]
    again: fn(&Value) -> Result<Value, String>,
}

impl Wire {
    #[cfg_attr(not(feature = "document"), expect(clippy::extra_unused_type_parameters))]
    pub(super) const fn of<T: Wired>() -> Self {
        Self {
            #[cfg(feature = "document")]
            schema: schema::<T>,
            #[cfg(all(test, feature = "document"))]
            again: again::<T>,
        }
    }

    /// A type that is written in a query alone.
    #[cfg_attr(not(feature = "document"), expect(clippy::extra_unused_type_parameters))]
    pub(super) const fn query<T: ToSchema>() -> Self {
        Self {
            #[cfg(feature = "document")]
            schema: schema::<T>,
            #[cfg(all(test, feature = "document"))]
            again: |value| Ok(value.clone()),
        }
    }

    /// The name of its schema and a reference to it; it goes into `schemas` with all that it refers to.
    #[cfg(feature = "document")]
    pub fn schema(&self, schemas: &mut Schemas) -> (String, RefOr<Schema>) {
        (self.schema)(schemas)
    }

    /// What is written of it once this has been read.
    ///
    /// # Errors
    /// Where this is none of its values.
    #[cfg(all(test, feature = "document"))]
    pub(crate) fn again(&self, value: &Value) -> Result<Value, String> {
        (self.again)(value)
    }
}

#[cfg(feature = "document")]
fn schema<T: ToSchema>(schemas: &mut Schemas) -> (String, RefOr<Schema>) {
    let name = T::name().into_owned();
    let mut found = vec![(name.clone(), T::schema())];
    T::schemas(&mut found);
    schemas.extend(found);
    (name.clone(), Ref::from_schema_name(name).into())
}

#[cfg(all(test, feature = "document"))]
fn again<T: Wired>(value: &Value) -> Result<Value, String> {
    let read = T::deserialize(value).map_err(|error| error.to_string())?;
    serde_json::to_value(read).map_err(|error| error.to_string())
}
