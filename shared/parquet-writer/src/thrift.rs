//! Thrift's compact protocol, as far as Parquet's footer and page headers need it.

const I32: u8 = 5;
const I64: u8 = 6;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const STRUCT: u8 = 12;

/// A struct whose fields are added in the order of their numbers.
#[derive(Debug, Default)]
pub(crate) struct Struct {
    bytes: Vec<u8>,
    last: u8,
}

impl Struct {
    fn field(&mut self, number: u8, kind: u8) -> &mut Self {
        debug_assert!(number > self.last && number - self.last <= 15);
        self.bytes.push((number - self.last) << 4 | kind);
        self.last = number;
        self
    }

    /// A number as a zigzag varint, or as a plain one.
    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
    }

    fn zigzag(&mut self, value: i64) {
        self.varint(((value << 1) ^ (value >> 63)) as u64);
    }

    fn binary(&mut self, text: &str) {
        self.varint(text.len() as u64);
        self.bytes.extend(text.as_bytes());
    }

    fn list(&mut self, number: u8, kind: u8, count: usize) {
        self.field(number, LIST);
        match u8::try_from(count) {
            Ok(count) if count < 15 => self.bytes.push(count << 4 | kind),
            _ => {
                self.bytes.push(0xF0 | kind);
                self.varint(count as u64);
            }
        }
    }

    pub(crate) fn i32(&mut self, number: u8, value: i64) -> &mut Self {
        self.field(number, I32).zigzag(value);
        self
    }

    pub(crate) fn i64(&mut self, number: u8, value: i64) -> &mut Self {
        self.field(number, I64).zigzag(value);
        self
    }

    pub(crate) fn text(&mut self, number: u8, text: &str) -> &mut Self {
        self.field(number, BINARY).binary(text);
        self
    }

    pub(crate) fn nested(&mut self, number: u8, inner: Self) -> &mut Self {
        self.field(number, STRUCT);
        self.bytes.extend(inner.finish());
        self
    }

    pub(crate) fn i32_list(&mut self, number: u8, values: &[i64]) -> &mut Self {
        self.list(number, I32, values.len());
        values.iter().for_each(|value| self.zigzag(*value));
        self
    }

    pub(crate) fn text_list(&mut self, number: u8, texts: &[&str]) -> &mut Self {
        self.list(number, BINARY, texts.len());
        texts.iter().for_each(|text| self.binary(text));
        self
    }

    pub(crate) fn structs(&mut self, number: u8, structs: Vec<Self>) -> &mut Self {
        self.list(number, STRUCT, structs.len());
        structs.into_iter().for_each(|inner| self.bytes.extend(inner.finish()));
        self
    }

    /// The bytes, with the stop behind the last field.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        self.bytes.push(0);
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of the protocol's specification: zigzag of −1 is 1, of 2 is 4; 300 takes two bytes.
    #[test]
    fn numbers_lists_and_structs_are_compact() {
        let mut inner = Struct::default();
        inner.i32(1, -1).i64(3, 150);
        let mut outer = Struct::default();
        outer.nested(2, inner).text_list(3, &["ab"]).i32_list(4, &[2; 15]);
        let mut expected = vec![0x2C, 0x15, 1, 0x26, 0xAC, 0x02, 0, 0x19, 0x18, 2, b'a', b'b'];
        expected.extend([0x19, 0xF5, 15]);
        expected.extend([4; 15]);
        expected.push(0);
        assert_eq!(outer.finish(), expected);
    }
}
