//! Finds the first number of a value that is not finite: a serializer that writes nothing.

use serde::ser::{self, Serialize};
use std::fmt;
use thiserror::Error;

/// A number that is infinite or NaN, and where.
#[derive(Debug, Error)]
#[error("{field} is {value}")]
pub(crate) struct NotFinite {
    pub(crate) field: String,
    pub(crate) value: f64,
}

impl ser::Error for NotFinite {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self { field: message.to_string(), value: f64::NAN }
    }
}

type Found = Result<(), NotFinite>;

/// Walks through everything that serde would write.
pub(crate) fn check<T: Serialize + ?Sized>(value: &T) -> Found {
    value.serialize(Walk)
}

/// Checks a part of a value, and puts the part's name before the place of a fault in it.
fn inside<T: Serialize + ?Sized>(name: &str, value: &T) -> Found {
    check(value).map_err(|NotFinite { field, value }| {
        let field = if field.is_empty() { name.to_owned() } else { format!("{name}.{field}") };
        NotFinite { field, value }
    })
}

struct Walk;

/// A walk through the parts of a value: the number of the next part, and the key of the present one.
#[derive(Default)]
struct Parts {
    next: usize,
    key: String,
}

impl Parts {
    /// Checks a part that has a name, or the next one of a sequence.
    fn part<T: Serialize + ?Sized>(&mut self, name: Option<&&str>, value: &T) -> Found {
        self.next += 1;
        name.map_or_else(|| inside(&(self.next - 1).to_string(), value), |name| inside(name, value))
    }
}

macro_rules! serializer {
    (without parts: $($leaf:ident($($leaf_type:ty),*)),+; with parts: $($whole:ident -> $kind:ident($($type:ty),*)),+;) => {
        impl ser::Serializer for Walk {
            type Ok = ();
            type Error = NotFinite;
            $(type $kind = Parts;)+
            $(fn $leaf(self, $(_: $leaf_type),*) -> Found { Ok(()) })+
            $(fn $whole(self, $(_: $type),*) -> Result<Parts, NotFinite> { Ok(Parts::default()) })+

            fn serialize_f32(self, value: f32) -> Found {
                self.serialize_f64(f64::from(value))
            }
            fn serialize_f64(self, value: f64) -> Found {
                if value.is_finite() { Ok(()) } else { Err(NotFinite { field: String::new(), value }) }
            }
            fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Found {
                check(value)
            }
            fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Found {
                check(value)
            }
            fn serialize_newtype_variant<T: Serialize + ?Sized>(
                self, _: &'static str, _: u32, variant: &'static str, value: &T,
            ) -> Found {
                inside(variant, value)
            }
        }
    };
}

serializer! {
    without parts:
        serialize_bool(bool), serialize_char(char), serialize_str(&str), serialize_bytes(&[u8]),
        serialize_i8(i8), serialize_i16(i16), serialize_i32(i32), serialize_i64(i64),
        serialize_u8(u8), serialize_u16(u16), serialize_u32(u32), serialize_u64(u64),
        serialize_none(), serialize_unit(), serialize_unit_struct(&'static str),
        serialize_unit_variant(&'static str, u32, &'static str);
    with parts:
        serialize_seq -> SerializeSeq(Option<usize>),
        serialize_tuple -> SerializeTuple(usize),
        serialize_tuple_struct -> SerializeTupleStruct(&'static str, usize),
        serialize_tuple_variant -> SerializeTupleVariant(&'static str, u32, &'static str, usize),
        serialize_map -> SerializeMap(Option<usize>),
        serialize_struct -> SerializeStruct(&'static str, usize),
        serialize_struct_variant -> SerializeStructVariant(&'static str, u32, &'static str, usize);
}

macro_rules! parts {
    ($($kind:ident::$method:ident($($name:ident)?)),+) => {
        $(impl ser::$kind for Parts {
            type Ok = ();
            type Error = NotFinite;
            fn $method<T: Serialize + ?Sized>(&mut self, $($name: &'static str,)? value: &T) -> Found {
                self.part([$($name)?].first(), value)
            }
            fn end(self) -> Found { Ok(()) }
        })+
    };
}

parts!(
    SerializeSeq::serialize_element(),
    SerializeTuple::serialize_element(),
    SerializeTupleStruct::serialize_field(),
    SerializeTupleVariant::serialize_field(),
    SerializeStruct::serialize_field(name),
    SerializeStructVariant::serialize_field(name)
);

impl ser::SerializeMap for Parts {
    type Ok = ();
    type Error = NotFinite;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Found {
        let text = serde_json::to_value(key).ok();
        self.key = text.as_ref().and_then(|k| k.as_str()).unwrap_or("?").to_owned();
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Found {
        inside(&self.key, value)
    }

    fn end(self) -> Found {
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
