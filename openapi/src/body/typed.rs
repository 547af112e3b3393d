//! From a value to a type, stricter than serde and more lenient: an object is an object and never a list of its
//! fields, and `20.0` is a whole number.

use super::fault::{Fault, Step, is_object};
use super::tree::{MAX_EXACT, Node, Number};
use crate::problem::reason;
use serde::de::value::{BorrowedStrDeserializer, StrDeserializer};
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, MapAccess, SeqAccess, VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;
use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::HashMap;

/// The fields that the types know of the objects that were read as structs.
#[derive(Default)]
pub(super) struct Shapes(RefCell<HashMap<usize, &'static [&'static str]>>);

impl Shapes {
    /// The fields of this object, if it was read as a struct.
    pub(super) fn of(&self, object: &Node<'_>) -> Option<&'static [&'static str]> {
        self.0.borrow().get(&place(object)).copied()
    }
}

/// Where a value lies: the tree does not move while it is looked at.
fn place(node: &Node<'_>) -> usize {
    std::ptr::from_ref(node).addr()
}

/// A value that is to be read as some type.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a, 'de> {
    node: &'a Node<'de>,
    /// Where is noted what is read as a struct.
    shapes: Option<&'a Shapes>,
}

impl<'a, 'de> Reader<'a, 'de> {
    /// Reads `node`.
    pub(super) fn new(node: &'a Node<'de>) -> Self {
        Self { node, shapes: None }
    }

    /// Reads `node` and notes what is read as a struct.
    pub(super) fn noting(node: &'a Node<'de>, shapes: &'a Shapes) -> Self {
        Self { node, shapes: Some(shapes) }
    }

    /// The error of a value of another kind.
    fn is_not(self, wanted: impl std::fmt::Display) -> Fault {
        Fault::kind(self.node.kind(), self.node.shown(), wanted)
    }

    /// The integer that it is, from `min` to `max`.
    fn integer(self, min: i128, max: i128) -> Result<i128, Fault> {
        let wanted = || {
            // Beyond that no one can be sure of a whole number: it is not offered.
            let exact = MAX_EXACT as i128;
            format!("a whole number from {} to {}", min.max(-exact), max.min(exact))
        };
        let Node::Number(number) = self.node else { return Err(self.is_not(wanted())) };
        let integer = number.integer().filter(|integer| (min..=max).contains(integer));
        integer.ok_or_else(|| {
            Fault::value(reason::MALFORMED, self.node.shown(), format!("use {}", wanted()))
        })
    }

    fn text<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.node {
            Node::Text(Cow::Borrowed(text)) => visitor.visit_borrowed_str(text),
            Node::Text(Cow::Owned(text)) => visitor.visit_str(text),
            _ => Err(self.is_not("a text")),
        }
    }

    fn list<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        let Node::List(items) = self.node else { return Err(self.is_not("a list")) };
        visitor.visit_seq(Items { items, next: 0, shapes: self.shapes })
    }

    fn object<V: Visitor<'de>>(
        self,
        visitor: V,
        known: &'static [&'static str],
    ) -> Result<V::Value, Fault> {
        match self.node {
            Node::Object(fields) => {
                if let Some(shapes) = self.shapes.filter(|_| !known.is_empty()) {
                    shapes.0.borrow_mut().insert(place(self.node), known);
                }
                visitor.visit_map(Fields { fields, next: 0, shapes: self.shapes })
            }
            _ if known.is_empty() => Err(self.is_not("an object")),
            _ => Err(self.is_not(format!("an object with {}", known.join(", ")))),
        }
    }
}

macro_rules! integers {
    ($($deserialize:ident $visit:ident $integer:ident)*) => {$(
        fn $deserialize<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
            let integer = self.integer($integer::MIN.into(), $integer::MAX.into())?;
            visitor.$visit(integer as $integer)
        }
    )*};
}

impl<'de> Deserializer<'de> for Reader<'_, 'de> {
    type Error = Fault;

    /// For types that look at what there is. They may put it aside and read it later, so a whole number is one from
    /// the beginning.
    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.node {
            Node::Null => visitor.visit_unit(),
            Node::Bool(value) => visitor.visit_bool(*value),
            Node::Number(Number::Unsigned(number)) => visitor.visit_u64(*number),
            Node::Number(Number::Negative(number)) => visitor.visit_i64(*number),
            Node::Number(number @ Number::Float(float)) => match number.integer() {
                Some(integer) if integer >= 0 => visitor.visit_u64(integer as u64),
                Some(integer) => visitor.visit_i64(integer as i64),
                None => visitor.visit_f64(*float),
            },
            Node::Text(_) => self.text(visitor),
            // A list of the fields of one is what a tagged enum would take too.
            Node::List(_) if is_object(&visitor) => Err(self.is_not("an object")),
            Node::List(_) => self.list(visitor),
            Node::Object(_) => self.object(visitor, &[]),
        }
    }

    integers! {
        deserialize_u8 visit_u8 u8
        deserialize_u16 visit_u16 u16
        deserialize_u32 visit_u32 u32
        deserialize_u64 visit_u64 u64
        deserialize_i8 visit_i8 i8
        deserialize_i16 visit_i16 i16
        deserialize_i32 visit_i32 i32
        deserialize_i64 visit_i64 i64
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        let Node::Number(number) = self.node else { return Err(self.is_not("a number")) };
        visitor.visit_f64(number.float())
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.deserialize_f64(visitor)
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        let Node::Bool(value) = self.node else { return Err(self.is_not("true or false")) };
        visitor.visit_bool(*value)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.text(visitor)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.text(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.node {
            Node::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.list(visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        _length: usize,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        self.list(visitor)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _length: usize,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        self.list(visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.object(visitor, &[])
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        self.object(visitor, fields)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.node {
            Node::Text(name) => visitor.visit_enum(Choice { name, content: None }),
            Node::Object(fields) if let [(name, content)] = &fields[..] => {
                let chosen = visitor.visit_enum(Choice { name, content: Some(content) });
                chosen.map_err(|fault| fault.within(Step::Field(name.to_string())))
            }
            _ => Err(self.is_not(format!("one of: {}", variants.join(", ")))),
        }
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_unit()
    }

    /// The name of a variant, in a field that tells variants apart: never its number.
    fn deserialize_identifier<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.node {
            Node::Text(_) => self.deserialize_any(visitor),
            _ => Err(self.is_not("a text")),
        }
    }

    forward_to_deserialize_any! { i128 u128 char bytes byte_buf unit unit_struct }
}

/// The items of a list.
struct Items<'a, 'de> {
    items: &'a [Node<'de>],
    next: usize,
    shapes: Option<&'a Shapes>,
}

impl<'de> SeqAccess<'de> for Items<'_, 'de> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Fault> {
        let index = self.next;
        let Some(item) = self.items.get(index) else { return Ok(None) };
        self.next += 1;
        let read = seed.deserialize(Reader { node: item, shapes: self.shapes }).map(Some);
        read.map_err(|fault| fault.about(|| item.shown()).within(Step::Item(index)))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.items.len() - self.next)
    }
}

/// The fields of an object.
struct Fields<'a, 'de> {
    fields: &'a [(Cow<'de, str>, Node<'de>)],
    next: usize,
    shapes: Option<&'a Shapes>,
}

impl<'de> MapAccess<'de> for Fields<'_, 'de> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Fault> {
        let Some((name, value)) = self.fields.get(self.next) else { return Ok(None) };
        let key = match name {
            Cow::Borrowed(name) => seed.deserialize(BorrowedStrDeserializer::new(name)),
            Cow::Owned(name) => seed.deserialize(StrDeserializer::new(name)),
        };
        key.map(Some).map_err(|fault: Fault| fault.holding(value.shown()))
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, Fault> {
        // Only asked for behind a name, so it is there.
        let Some((name, value)) = self.fields.get(self.next) else {
            return Err(serde::de::Error::custom("a field without a name"));
        };
        self.next += 1;
        let read = seed.deserialize(Reader { node: value, shapes: self.shapes });
        read.map_err(|fault| fault.about(|| value.shown()).within(Step::Field(name.to_string())))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.fields.len() - self.next)
    }
}

/// One of several: a name alone, or with what belongs to it.
struct Choice<'a, 'de> {
    name: &'a str,
    content: Option<&'a Node<'de>>,
}

impl<'de> EnumAccess<'de> for Choice<'_, 'de> {
    type Error = Fault;
    type Variant = Self;

    fn variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<(T::Value, Self), Fault> {
        Ok((seed.deserialize(StrDeserializer::<Fault>::new(self.name))?, self))
    }
}

impl<'de> Choice<'_, 'de> {
    fn content(&self) -> Reader<'_, 'de> {
        Reader::new(self.content.unwrap_or(&Node::Null))
    }
}

impl<'de> VariantAccess<'de> for Choice<'_, 'de> {
    type Error = Fault;

    fn unit_variant(self) -> Result<(), Fault> {
        match self.content {
            None => Ok(()),
            Some(content) => Err(Reader::new(content).is_not("its name alone")),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Fault> {
        seed.deserialize(self.content())
    }

    fn tuple_variant<V: Visitor<'de>>(self, _len: usize, visitor: V) -> Result<V::Value, Fault> {
        self.content().list(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        self.content().object(visitor, fields)
    }
}
