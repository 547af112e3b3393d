//! A type of the wire as a value: its schema, and whether JSON is one.

use crate::body::Wired;
#[cfg(test)]
use serde_json::Value;
use std::collections::BTreeMap;
use utoipa::ToSchema;
use utoipa::openapi::{Ref, RefOr, Schema};

/// Schemas by name.
pub type Schemas = BTreeMap<String, RefOr<Schema>>;

/// A type of the wire.
#[derive(Clone, Copy, Debug)]
pub struct Wire {
    schema: fn(&mut Schemas) -> (String, RefOr<Schema>),
    // Every type read and written once more is half a minute of compiling.
    #[cfg(test)]
    again: fn(&Value) -> Result<Value, String>,
}

impl Wire {
    pub(super) const fn of<T: Wired>() -> Self {
        Self {
            schema: schema::<T>,
            #[cfg(test)]
            again: again::<T>,
        }
    }

    /// A type that is written in a query alone.
    pub(super) const fn query<T: ToSchema>() -> Self {
        Self {
            schema: schema::<T>,
            #[cfg(test)]
            again: |value| Ok(value.clone()),
        }
    }

    /// The name of its schema and a reference to it; it goes into `schemas` with all that it refers to.
    pub fn schema(&self, schemas: &mut Schemas) -> (String, RefOr<Schema>) {
        (self.schema)(schemas)
    }

    /// What is written of it once this has been read.
    ///
    /// # Errors
    /// Where this is none of its values.
    #[cfg(test)]
    pub(crate) fn again(&self, value: &Value) -> Result<Value, String> {
        (self.again)(value)
    }
}

fn schema<T: ToSchema>(schemas: &mut Schemas) -> (String, RefOr<Schema>) {
    let name = T::name().into_owned();
    let mut found = vec![(name.clone(), T::schema())];
    T::schemas(&mut found);
    schemas.extend(found);
    (name.clone(), Ref::from_schema_name(name).into())
}

#[cfg(test)]
fn again<T: Wired>(value: &Value) -> Result<Value, String> {
    let read = T::deserialize(value).map_err(|error| error.to_string())?;
    serde_json::to_value(read).map_err(|error| error.to_string())
}
