//! Finds the first number of a value that is not finite: a serializer that writes nothing.

use serde::ser::{self, Serialize};
use std::fmt;

/// A number that is infinite or NaN, and where.
#[derive(Debug)]
pub(crate) struct NotFinite {
    pub(crate) field: String,
    pub(crate) value: f64,
}

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}", self.field, self.value)
    }
}

impl std::error::Error for NotFinite {}

impl ser::Error for NotFinite {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self { field: message.to_string(), value: f64::NAN }
    }
}

/// Walks through everything that serde would write.
pub(crate) fn check<T: Serialize + ?Sized>(value: &T) -> Result<(), NotFinite> {
    value.serialize(&mut Walk::default())
}

#[derive(Default)]
struct Walk {
    path: Vec<String>,
}

impl Walk {
    fn inside<T: Serialize + ?Sized>(&mut self, name: String, value: &T) -> Result<(), NotFinite> {
        self.path.push(name);
        value.serialize(&mut *self)?;
        self.path.pop();
        Ok(())
    }
}

/// A compound value that is being walked through: the number of the next entry, the key of the present one.
struct Entries<'a> {
    walk: &'a mut Walk,
    next: usize,
    key: String,
}

impl Entries<'_> {
    fn item<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), NotFinite> {
        let index = self.next;
        self.next += 1;
        self.walk.inside(index.to_string(), value)
    }
}

macro_rules! nothing_to_check {
    ($($method:ident: $type:ty),+ $(,)?) => {
        $(fn $method(self, _value: $type) -> Result<(), NotFinite> { Ok(()) })+
    };
}

impl<'a> ser::Serializer for &'a mut Walk {
    type Ok = ();
    type Error = NotFinite;
    type SerializeSeq = Entries<'a>;
    type SerializeTuple = Entries<'a>;
    type SerializeTupleStruct = Entries<'a>;
    type SerializeTupleVariant = Entries<'a>;
    type SerializeMap = Entries<'a>;
    type SerializeStruct = Entries<'a>;
    type SerializeStructVariant = Entries<'a>;

    nothing_to_check! {
        serialize_bool: bool, serialize_char: char, serialize_str: &str, serialize_bytes: &[u8],
        serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64,
        serialize_unit_struct: &'static str,
    }

    fn serialize_f32(self, value: f32) -> Result<(), NotFinite> {
        self.serialize_f64(f64::from(value))
    }

    fn serialize_f64(self, value: f64) -> Result<(), NotFinite> {
        if value.is_finite() { Ok(()) } else { Err(NotFinite { field: self.path.join("."), value }) }
    }

    fn serialize_none(self) -> Result<(), NotFinite> {
        Ok(())
    }

    fn serialize_unit(self) -> Result<(), NotFinite> {
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), NotFinite> {
        value.serialize(self)
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), NotFinite> {
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), NotFinite> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), NotFinite> {
        self.inside(variant.to_owned(), value)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Entries<'a>, NotFinite> {
        Ok(Entries { walk: self, next: 0, key: String::new() })
    }

    fn serialize_tuple(self, _: usize) -> Result<Entries<'a>, NotFinite> {
        self.serialize_seq(None)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Entries<'a>, NotFinite> {
        self.serialize_seq(None)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Entries<'a>, NotFinite> {
        self.serialize_seq(None)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Entries<'a>, NotFinite> {
        self.serialize_seq(None)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Entries<'a>, NotFinite> {
        self.serialize_seq(None)
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Entries<'a>, NotFinite> {
        self.serialize_seq(None)
    }
}

macro_rules! walk_through {
    ($($trait:ident::$method:ident),+ $(,)?) => {
        $(impl ser::$trait for Entries<'_> {
            type Ok = ();
            type Error = NotFinite;
            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), NotFinite> {
                self.item(value)
            }
            fn end(self) -> Result<(), NotFinite> {
                Ok(())
            }
        })+
    };
}

walk_through!(
    SerializeSeq::serialize_element,
    SerializeTuple::serialize_element,
    SerializeTupleStruct::serialize_field,
    SerializeTupleVariant::serialize_field,
);

macro_rules! walk_through_fields {
    ($($trait:ident),+) => {
        $(impl ser::$trait for Entries<'_> {
            type Ok = ();
            type Error = NotFinite;
            fn serialize_field<T: Serialize + ?Sized>(
                &mut self,
                key: &'static str,
                value: &T,
            ) -> Result<(), NotFinite> {
                self.walk.inside(key.to_owned(), value)
            }
            fn end(self) -> Result<(), NotFinite> {
                Ok(())
            }
        })+
    };
}

walk_through_fields!(SerializeStruct, SerializeStructVariant);

impl ser::SerializeMap for Entries<'_> {
    type Ok = ();
    type Error = NotFinite;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), NotFinite> {
        let text = serde_json::to_value(key).ok();
        self.key = text.as_ref().and_then(|k| k.as_str()).unwrap_or("?").to_owned();
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), NotFinite> {
        self.walk.inside(self.key.clone(), value)
    }

    fn end(self) -> Result<(), NotFinite> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn every_kind_of_value_is_walked_through() {
        let fault = |value: &dyn Fn() -> Result<(), NotFinite>| value().unwrap_err().field;
        let map = BTreeMap::from([("a", vec![(1, Some(1.0)), (2, Some(f64::NAN))])]);
        assert_eq!(fault(&|| check(&map)), "a.1.1");
        assert_eq!(fault(&|| check(&[0.0f32, f32::INFINITY])), "1");
        assert!(check(&(1u8, 'c', "s", None::<f64>, [1.0])).is_ok());
    }
}
