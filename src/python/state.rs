//! States of values: the bytes that pickle keeps, and what makes two values equal.
//!
//! ```text
//! restore(name, version, head, *arrays)      head = numbers and texts, little-endian, then a seal of 32 bytes
//! ```
//! The seal is a digest of all the rest, so bytes that were damaged on the way are found, wherever they are. A type writes
//! its state once, in [`State::write`]: exact numbers go into pickles; numbers that stand for all that are equal decide
//! `==` and `hash`.

use std::collections::BTreeSet;
use std::convert::Infallible;
use std::hash::{DefaultHasher, Hasher};
use std::sync::LazyLock;

use arc_swap::ArcSwap;
use glam::DVec3;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};

use super::convert::exception;
use crate::digest::{Digest, Element, Numbers};

/// Bytes of a seal.
const SEAL: usize = 32;
/// Longest name of a technique or a number, bytes: several times the longest there is.
const LONGEST_NAME: usize = 256;

/// What is wrong with a state, in words.
pub type Fault = String;

/// A value that writes itself as bytes.
pub trait State: Sized {
    /// The class.
    const NAME: &'static str;
    /// What `write` writes now; `read` reads all versions up to it.
    const VERSION: u32 = 1;
    /// The oldest version that can read this value.
    fn version(&self) -> u32 {
        Self::VERSION
    }
    /// Writes all of it.
    fn write(&self, to: &mut Writer);
    /// Reads what `write` wrote.
    ///
    /// # Errors
    /// In words, for what no value has.
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault>;
}

/// Bytes in the making.
pub struct Writer {
    bytes: Vec<u8>,
    numbers: Numbers,
}

impl Writer {
    /// An empty one.
    pub fn new(numbers: Numbers) -> Self {
        Self { bytes: Vec::new(), numbers }
    }
    /// The bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    /// Adds numbers; their count is known to the reader.
    pub fn numbers(&mut self, list: &[f64]) {
        let settle = |x: f64| if self.numbers == Numbers::Equal { x.settled() } else { x };
        self.bytes.extend(list.iter().flat_map(|&x| settle(x).to_le_bytes()));
    }
    /// Adds a vector.
    pub fn vector(&mut self, v: DVec3) {
        self.numbers(&v.to_array());
    }
    /// Adds a whole number.
    pub fn whole(&mut self, n: i64) {
        self.bytes.extend(n.to_le_bytes());
    }
    /// Adds a count.
    pub fn count(&mut self, n: u64) {
        self.bytes.extend(n.to_le_bytes());
    }
    /// Adds which of some kinds follows.
    pub fn kind(&mut self, kind: u8) {
        self.bytes.push(kind);
    }
    /// Adds a text.
    pub fn text(&mut self, text: &str) {
        self.count(text.len() as u64);
        self.bytes.extend(text.as_bytes());
    }
}

/// Bytes that are read from the front.
pub struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// All of the bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }
    fn take(&mut self, n: usize) -> Result<&'a [u8], Fault> {
        let (taken, rest) = self.rest.split_at_checked(n).ok_or("it ends too early")?;
        self.rest = rest;
        Ok(taken)
    }
    fn eight(&mut self) -> Result<[u8; 8], Fault> {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(self.take(8)?);
        Ok(bytes)
    }
    /// Numbers.
    pub fn numbers<const N: usize>(&mut self) -> Result<[f64; N], Fault> {
        let mut found = [0.0; N];
        for x in &mut found {
            *x = f64::from_le_bytes(self.eight()?);
        }
        Ok(found)
    }
    /// A vector.
    pub fn vector(&mut self) -> Result<DVec3, Fault> {
        Ok(DVec3::from_array(self.numbers()?))
    }
    /// A whole number.
    pub fn whole(&mut self) -> Result<i64, Fault> {
        Ok(i64::from_le_bytes(self.eight()?))
    }
    /// A count that fits the type.
    pub fn count<T: TryFrom<u64>>(&mut self) -> Result<T, Fault> {
        let n = u64::from_le_bytes(self.eight()?);
        T::try_from(n).map_err(|_| format!("the count {n} is too large"))
    }
    /// Which of some kinds follows.
    pub fn kind(&mut self) -> Result<u8, Fault> {
        Ok(self.take(1)?[0])
    }
    /// A text.
    pub fn text(&mut self) -> Result<String, Fault> {
        let length = self.count()?;
        String::from_utf8(self.take(length)?.to_vec()).map_err(|e| e.to_string())
    }
    /// A name, one for all that are equal in this process.
    pub fn name(&mut self) -> Result<&'static str, Fault> {
        // Distinct names are few: of techniques, their parameters and their numbers. No lock, so that a process that is
        // forked meanwhile has none that nobody gives back.
        static NAMES: LazyLock<ArcSwap<BTreeSet<&'static str>>> = LazyLock::new(Default::default);
        let name = self.text()?;
        if name.len() > LONGEST_NAME {
            return Err(format!("a name of {} bytes", name.len()));
        }
        if let Some(known) = NAMES.load().get(name.as_str()) {
            return Ok(known);
        }
        let kept: &'static str = Box::leak(name.into_boxed_str());
        NAMES.rcu(|names| {
            let mut names = BTreeSet::clone(names);
            names.insert(kept);
            names
        });
        Ok(kept)
    }
    /// As many things as a count says.
    pub fn list<T>(&mut self, one: impl Fn(&mut Self) -> Result<T, Fault>) -> Result<Vec<T>, Fault> {
        let count: u64 = self.count()?;
        // Grows as things are found: the count of damaged bytes may be anything.
        (0..count).map(|_| one(self)).collect()
    }
    /// An error unless all was read.
    pub fn end(&self) -> Result<(), Fault> {
        if self.rest.is_empty() { Ok(()) } else { Err(format!("{} bytes are left over", self.rest.len())) }
    }
}

/// Whether two values are equal: numbers as numbers, and NaN to NaN.
pub fn equal<T: State>(a: &T, b: &T) -> bool {
    let bytes = |value: &T| {
        let mut w = Writer::new(Numbers::Equal);
        value.write(&mut w);
        w.bytes
    };
    bytes(a) == bytes(b)
}

/// A hash that equal values share.
pub fn hash<T: State>(value: &T) -> u64 {
    let mut w = Writer::new(Numbers::Equal);
    value.write(&mut w);
    let mut hasher = DefaultHasher::new();
    hasher.write(T::NAME.as_bytes());
    hasher.write(&w.bytes);
    hasher.finish()
}

/// The beginning of a digest as a hash.
pub fn first_eight(digest: &[u8; SEAL]) -> u64 {
    digest[..8].iter().fold(0, |n, &byte| n << 8 | u64::from(byte))
}

/// What `__reduce__` returns: the function and its arguments.
pub type Reduced<'py> = (Bound<'py, PyAny>, Bound<'py, PyTuple>);

/// `__reduce__` of a value without arrays.
pub fn reduce<'py, T: State>(py: Python<'py>, value: &T) -> PyResult<Reduced<'py>> {
    let mut head = Writer::new(Numbers::Exact);
    value.write(&mut head);
    let version = value.version();
    let Ok(seal) = seal(T::NAME, version, head.bytes(), nothing_more);
    reduced(py, T::NAME, version, head.bytes(), &seal, Vec::new())
}

/// What values without arrays add to their seals.
fn nothing_more(_: &mut Digest) -> Result<(), Infallible> {
    Ok(())
}

/// The digest of all that a state is made of; `arrays` adds what stands beside the head.
///
/// # Errors
/// Those of `arrays`.
pub fn seal<E>(
    name: &str,
    version: u32,
    head: &[u8],
    arrays: impl FnOnce(&mut Digest) -> Result<(), E>,
) -> Result<[u8; SEAL], E> {
    let mut digest = Digest::new("shadowlab state", Numbers::Exact);
    digest.text(name);
    digest.list(&[version]);
    digest.list(head);
    arrays(&mut digest)?;
    Ok(digest.finish())
}

/// `__reduce__` of parts.
pub fn reduced<'py>(
    py: Python<'py>,
    name: &str,
    version: u32,
    head: &[u8],
    seal: &[u8; SEAL],
    arrays: Vec<Bound<'py, PyAny>>,
) -> PyResult<Reduced<'py>> {
    let head = PyBytes::new(py, &[head, seal].concat());
    let mut parts = vec![name.into_pyobject(py)?.into_any(), version.into_pyobject(py)?.into_any(), head.into_any()];
    parts.extend(arrays);
    Ok((py.import("shadowlab._core")?.getattr("restore")?, PyTuple::new(py, parts)?))
}

/// A `StateError`.
pub fn state_error(py: Python<'_>, name: &str, what: impl std::fmt::Display) -> PyErr {
    let message =
        format!("{name}: expected the state that pickle wrote, but {what}; copy it again, or make a new {name}");
    exception(py, "StateError", message)
}

/// What is wrong where a seal is not that of the rest.
pub const OTHER_SEAL: &str = "its checksum is another";

/// A seal and what it is of, beside arrays; it may cross threads.
#[derive(Clone, Copy)]
pub struct Sealed<'a> {
    name: &'a str,
    version: u32,
    head: &'a [u8],
    seal: &'a [u8],
}

impl Sealed<'_> {
    /// Whether the seal is that of the head and of what `arrays` adds.
    ///
    /// # Errors
    /// Those of `arrays`.
    pub fn is_of<E>(&self, arrays: impl FnOnce(&mut Digest) -> Result<(), E>) -> Result<bool, E> {
        Ok(seal(self.name, self.version, self.head, arrays)?[..] == self.seal[..])
    }
}

/// What `restore` got.
pub struct Parts<'py> {
    /// The class.
    pub name: String,
    /// Of the writer.
    pub version: u32,
    /// Without the seal.
    pub head: Vec<u8>,
    seal: Vec<u8>,
    /// What stands beside the head.
    pub arrays: Vec<Bound<'py, PyAny>>,
}

impl<'py> Parts<'py> {
    /// The arguments of `restore`, checked for their types.
    pub fn of(parts: &Bound<'py, PyTuple>) -> PyResult<Self> {
        let py = parts.py();
        let mut items = parts.iter();
        let name: Option<String> = items.next().and_then(|item| item.extract().ok());
        let Some(name) = name else { return Err(state_error(py, "value", "its class is missing")) };
        let version: Option<i64> = items.next().and_then(|item| item.extract().ok());
        let head: Option<Vec<u8>> =
            items.next().and_then(|item| Some(item.cast::<PyBytes>().ok()?.as_bytes().to_vec()));
        let (Some(version), Some(mut head)) = (version, head) else {
            return Err(state_error(py, &name, "its version or its bytes are missing"));
        };
        let version =
            u32::try_from(version).map_err(|_| state_error(py, &name, format!("its version is {version}")))?;
        if head.len() < SEAL {
            return Err(state_error(py, &name, "it ends too early"));
        }
        let seal = head.split_off(head.len() - SEAL);
        Ok(Self { name, version, head, seal, arrays: items.collect() })
    }
    /// An error about these.
    pub fn error(&self, py: Python<'_>, what: impl std::fmt::Display) -> PyErr {
        state_error(py, &self.name, what)
    }
    /// An error unless the version is one that is known, and there are so many arrays.
    pub fn check(&self, py: Python<'_>, newest: u32, arrays: usize) -> PyResult<()> {
        if self.version > newest {
            let name = &self.name;
            let message = format!(
                "{name}: expected a state of version {newest} or older, got version {}, which a newer shadowlab wrote; \
                 update shadowlab here, or write it again with this version ({})",
                self.version,
                env!("CARGO_PKG_VERSION")
            );
            return Err(exception(py, "StateError", message));
        }
        if self.version == 0 || self.arrays.len() != arrays {
            let what = format!("it has version {} and {} arrays", self.version, self.arrays.len());
            return Err(self.error(py, what));
        }
        Ok(())
    }
    /// The seal.
    pub fn sealed(&self) -> Sealed<'_> {
        Sealed { name: &self.name, version: self.version, head: &self.head, seal: &self.seal }
    }
    /// An error unless the seal is that of the head and of what `arrays` adds.
    pub fn check_seal<E>(&self, py: Python<'_>, arrays: impl FnOnce(&mut Digest) -> Result<(), E>) -> PyResult<()>
    where
        PyErr: From<E>,
    {
        if self.sealed().is_of(arrays)? { Ok(()) } else { Err(self.error(py, OTHER_SEAL)) }
    }
    /// The value of a state without arrays.
    pub fn value<T: State>(&self, py: Python<'py>) -> PyResult<T> {
        self.check(py, T::VERSION, 0)?;
        self.check_seal(py, nothing_more)?;
        self.read(py, T::read)
    }
    /// What a function reads of the head, all of it.
    pub fn read<T>(&self, py: Python<'_>, read: impl FnOnce(&mut Reader<'_>) -> Result<T, Fault>) -> PyResult<T> {
        let mut reader = Reader::new(&self.head);
        let found = read(&mut reader).and_then(|value| reader.end().map(|()| value));
        found.map_err(|fault| self.error(py, fault))
    }
}

/// `PartialEq`, `Eq` and `Hash` of a class by its state, for `#[pyclass(eq, hash)]`.
macro_rules! by_state {
    ($($class:ty),*) => {$(
        impl PartialEq for $class {
            fn eq(&self, other: &Self) -> bool {
                $crate::python::state::equal(self, other)
            }
        }
        impl Eq for $class {}
        impl std::hash::Hash for $class {
            fn hash<H: std::hash::Hasher>(&self, hasher: &mut H) {
                hasher.write_u64($crate::python::state::hash(self));
            }
        }
    )*};
}
pub(super) use by_state;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_no_more() {
        let mut w = Writer::new(Numbers::Exact);
        w.numbers(&[-0.0, 1.5]);
        w.whole(-7);
        w.text("ä");
        w.kind(3);
        let mut r = Reader::new(w.bytes());
        let [zero, number] = r.numbers().unwrap();
        assert_eq!((zero.to_bits(), number), ((-0.0_f64).to_bits(), 1.5));
        assert_eq!((r.whole().unwrap(), r.text().unwrap().as_str(), r.kind().unwrap()), (-7, "ä", 3));
        r.end().unwrap();
        for end in 0..w.bytes().len() {
            let mut r = Reader::new(&w.bytes()[..end]);
            let all = r.numbers::<2>().and_then(|_| r.whole()).and_then(|_| r.text()).and_then(|_| r.kind());
            assert!(all.is_err(), "{end}");
        }
        assert!(Reader::new(&[1]).end().is_err());
    }

    #[test]
    fn counts_of_damaged_bytes_take_no_memory() {
        let huge = u64::MAX.to_le_bytes();
        assert!(Reader::new(&huge).text().is_err());
        assert!(Reader::new(&huge).list(|r| r.kind()).is_err());
        assert!(Reader::new(&huge).count::<u32>().is_err());
    }
}
