//! Things that go by names: a field that holds a name or the thing itself, and what a name stands for.

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// What a name stands for, or else all the names that there are.
pub type Known<T> = Result<T, Vec<String>>;

/// The name of a thing, or the thing.
pub(crate) enum NameOr<T> {
    Name(String),
    Thing(T),
}

impl<'de, T: Deserialize<'de>> NameOr<T> {
    /// Reads a text as a name and an object as the thing. Unlike serde's `untagged`, what is wrong within the object
    /// keeps its field path and its words. `expecting` says what else was expected.
    pub(crate) fn read<D: Deserializer<'de>>(
        deserializer: D,
        expecting: &'static str,
    ) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Either { expecting, thing: PhantomData })
    }
}

struct Either<T> {
    expecting: &'static str,
    thing: PhantomData<T>,
}

impl<'de, T: Deserialize<'de>> Visitor<'de> for Either<T> {
    type Value = NameOr<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expecting)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<NameOr<T>, E> {
        Ok(NameOr::Name(text.to_owned()))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<NameOr<T>, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map)).map(NameOr::Thing)
    }
}
