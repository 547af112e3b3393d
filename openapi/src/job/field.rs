//! Fields whose name depends on the kind: each is an object of one field, flattened into the one around it.

use super::kind::JobKind;
use serde::de::{DeserializeOwned, Error, IgnoredAny, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserializer, Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;

pub(super) fn write_id<K: JobKind, S: Serializer>(
    id: &K::Id,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    write(K::NAME, id, serializer)
}

pub(super) fn read_id<'de, K: JobKind, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<K::Id, D::Error> {
    read(K::NAME, deserializer)
}

pub(super) fn write_list<K: JobKind, T: Serialize, S: Serializer>(
    jobs: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    write(K::LIST, jobs, serializer)
}

pub(super) fn read_list<'de, K: JobKind, T: DeserializeOwned, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<T, D::Error> {
    read(K::LIST, deserializer)
}

fn write<T: Serialize, S: Serializer>(
    name: &'static str,
    value: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(1))?;
    map.serialize_entry(name, value)?;
    map.end()
}

fn read<'de, T: DeserializeOwned, D: Deserializer<'de>>(
    name: &'static str,
    deserializer: D,
) -> Result<T, D::Error> {
    deserializer.deserialize_map(OneField { name, value: PhantomData })
}

struct OneField<T> {
    name: &'static str,
    value: PhantomData<T>,
}

impl<'de, T: DeserializeOwned> Visitor<'de> for OneField<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "an object with the field {}", self.name)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<T, A::Error> {
        while let Some(name) = map.next_key::<String>()? {
            if name == self.name {
                return map.next_value();
            }
            map.next_value::<IgnoredAny>()?;
        }
        Err(A::Error::missing_field(self.name))
    }
}
