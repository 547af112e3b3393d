//! The checksum in every row: over the table's name, the key and every other column. A digit that changes on the disk is
//! noticed by it, and so is a row that stands under another's key or in another table.
//!
//! It is a CRC of 64 bits. A CRC finds every change within 64 neighbouring bits for certain, and so every byte and every
//! digit that alone is wrong; of anything worse it misses one in 2^64. No one is kept from forging a row by it.

use crc::{CRC_64_XZ, Crc, Digest, Table};
use rusqlite::Connection;
use rusqlite::functions::FunctionFlags;
use rusqlite::types::ValueRef;

/// Sixteen bytes at a time: trials of a comparison are tens of MB.
type Lookup = Table<16>;

static CRC: Crc<u64, Lookup> = Crc::<u64, Lookup>::new(&CRC_64_XZ);

/// Any number of arguments, as SQLite counts them.
const ANY: i32 = -1;

/// Gives a connection the function `row_checksum(table, column, ...)`, by which rows are written and read.
pub(super) fn install(connection: &Connection) -> rusqlite::Result<()> {
    let flags = FunctionFlags::SQLITE_UTF8 | FunctionFlags::SQLITE_DETERMINISTIC;
    connection.create_scalar_function("row_checksum", ANY, flags, |context| {
        let mut digest = CRC.digest();
        for index in 0..context.len() {
            take_in(&mut digest, context.get_raw(index));
        }
        Ok(digest.finalize().cast_signed())
    })
}

/// Type, length and bytes of a value: `('ab', 'c')` is not `('a', 'bc')`, and 1 is not '1'.
fn take_in(digest: &mut Digest<'_, u64, Lookup>, value: ValueRef<'_>) {
    let (kind, number, bytes): (u8, u64, &[u8]) = match value {
        ValueRef::Null => (0, 0, &[]),
        ValueRef::Integer(integer) => (1, integer.cast_unsigned(), &[]),
        ValueRef::Real(real) => (2, real.to_bits(), &[]),
        ValueRef::Text(text) => (3, text.len() as u64, text),
        ValueRef::Blob(blob) => (4, blob.len() as u64, blob),
    };
    digest.update(&[kind]);
    digest.update(&number.to_le_bytes());
    digest.update(bytes);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its value is on the disk: it never changes. Computed apart from this, bit by bit, by the definition of the CRC.
    #[test]
    fn a_checksum_is_that_of_type_length_and_bytes_of_every_value() {
        let connection = Connection::open_in_memory().unwrap();
        install(&connection).unwrap();
        let of = |sql: &str| -> i64 {
            connection
                .query_row(&format!("SELECT row_checksum({sql})"), [], |row| row.get(0))
                .unwrap()
        };
        let mut bytes = Vec::new();
        for (kind, number, text) in [(3, 6, "robots"), (3, 2, "r1"), (1, 12, ""), (0, 0, "")] {
            bytes.push(kind);
            bytes.extend(u64::to_le_bytes(number));
            bytes.extend(text.bytes());
        }
        assert_eq!(of("'robots', 'r1', 12, NULL"), bitwise(&bytes).cast_signed());
        let all = ["'ab', 'c'", "'a', 'bc'", "'abc'", "1", "'1'", "x'31'", "1.0", "NULL", "0", ""];
        let found: std::collections::BTreeSet<_> = all.iter().map(|sql| of(sql)).collect();
        assert_eq!(found.len(), all.len(), "no two of them are alike");
    }

    /// CRC-64/XZ as it is defined: reflected polynomial of ECMA-182, all ones before and after.
    fn bitwise(bytes: &[u8]) -> u64 {
        const POLYNOMIAL: u64 = 0xc96c_5795_d787_0f42;
        !bytes.iter().fold(u64::MAX, |crc, byte| {
            (0..8).fold(crc ^ u64::from(*byte), |crc, _| {
                if crc & 1 == 1 { (crc >> 1) ^ POLYNOMIAL } else { crc >> 1 }
            })
        })
    }
}
