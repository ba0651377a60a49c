//! Digests of numbers that are the same in every process, on every machine and for every version of Python.
//!
//! BLAKE3 over little-endian bytes. Each digest begins with the purpose it is for, and every text and list with its length,
//! so that no two different contents are one sequence of bytes.

/// Numbers that are turned into bytes at a time: enough for the hash to work on several blocks side by side.
const CHUNK: usize = 4096;

/// Numbers between two looks at whether to go on: some milliseconds of work. Whole chunks, so that it makes no difference.
const WATCHED: usize = 256 * CHUNK;

/// A number with its little-endian bytes.
pub trait Element: Copy {
    /// Its size.
    const BYTES: usize;
    /// Writes its bytes, [`Element::BYTES`] of them.
    fn put(self, bytes: &mut [u8]);
    /// The number that stands for all that are equal to it: 0 for -0, and one NaN for all.
    fn settled(self) -> Self;
}

macro_rules! elements {
    ($($type:ty: $settled:expr),* $(,)?) => {$(
        impl Element for $type {
            const BYTES: usize = size_of::<$type>();
            #[inline]
            fn put(self, bytes: &mut [u8]) {
                bytes.copy_from_slice(&self.to_le_bytes());
            }
            #[inline]
            fn settled(self) -> Self {
                let settle: fn($type) -> $type = $settled;
                settle(self)
            }
        }
    )*};
}

elements! {
    i8: |x| x,
    i32: |x| x,
    u8: |x| x,
    u32: |x| x,
    u64: |x| x,
    f32: |x| if x.is_nan() { f32::NAN } else { x + 0.0 },
    f64: |x| if x.is_nan() { f64::NAN } else { x + 0.0 },
}

/// Which numbers have one digest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Numbers {
    /// Those of the same bits.
    Exact,
    /// Those that are equal, and all NaN.
    Equal,
}

/// A digest in the making.
#[derive(Debug)]
pub struct Digest {
    hasher: blake3::Hasher,
    numbers: Numbers,
    /// Room for the bytes of a part of a list.
    bytes: Vec<u8>,
}

impl Digest {
    /// One for a purpose: a name and a version of what goes in.
    pub fn new(purpose: &str, numbers: Numbers) -> Self {
        let mut digest = Self { hasher: blake3::Hasher::new(), numbers, bytes: Vec::new() };
        digest.text(purpose);
        digest
    }
    /// Adds a count.
    pub fn count(&mut self, n: usize) {
        self.hasher.update(&(n as u64).to_le_bytes());
    }
    /// Adds a text.
    pub fn text(&mut self, text: &str) {
        self.count(text.len());
        self.hasher.update(text.as_bytes());
    }
    /// Adds a list of numbers.
    pub fn list<T: Element>(&mut self, list: &[T]) {
        self.count(list.len());
        self.parts(list);
    }
    /// The same, asking now and then whether to go on.
    ///
    /// # Errors
    /// Those of `check`; what was added is lost then.
    pub fn watched_list<T: Element, E>(&mut self, list: &[T], check: impl Fn() -> Result<(), E>) -> Result<(), E> {
        self.count(list.len());
        list.chunks(WATCHED).try_for_each(|some| {
            check()?;
            self.parts(some);
            Ok(())
        })
    }
    fn parts<T: Element>(&mut self, list: &[T]) {
        for part in list.chunks(CHUNK) {
            self.bytes.resize(part.len() * T::BYTES, 0);
            let slots = self.bytes.chunks_exact_mut(T::BYTES).zip(part);
            match self.numbers {
                Numbers::Exact => slots.for_each(|(slot, x)| x.put(slot)),
                Numbers::Equal => slots.for_each(|(slot, x)| x.settled().put(slot)),
            }
            self.hasher.update(&self.bytes);
        }
    }
    /// The digest of what was added.
    pub fn finish(&self) -> [u8; 32] {
        *self.hasher.finalize().as_bytes()
    }
}

/// Bytes as two hexadecimal digits each.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(numbers: Numbers, list: &[f64]) -> [u8; 32] {
        let mut digest = Digest::new("test", numbers);
        digest.list(list);
        digest.finish()
    }

    #[test]
    fn equal_numbers_have_one_digest_and_exact_ones_their_own() {
        let payload = f64::from_bits(f64::NAN.to_bits() | 5);
        for (a, b) in [(0.0, -0.0), (f64::NAN, payload), (f64::NAN, -f64::NAN)] {
            assert_eq!(of(Numbers::Equal, &[a]), of(Numbers::Equal, &[b]));
            assert_ne!(of(Numbers::Exact, &[a]), of(Numbers::Exact, &[b]));
        }
        assert_ne!(of(Numbers::Equal, &[1.0]), of(Numbers::Equal, &[1.0_f64.next_up()]));
        assert_ne!(of(Numbers::Equal, &[0.0]), of(Numbers::Equal, &[f64::from_bits(1)]));
    }

    #[test]
    fn no_two_contents_are_one_sequence() {
        let mut joined = Digest::new("test", Numbers::Exact);
        let mut apart = Digest::new("test", Numbers::Exact);
        joined.list(&[1_u8, 2]);
        apart.list(&[1_u8]);
        apart.list(&[2_u8]);
        assert_ne!(joined.finish(), apart.finish());
        assert_ne!(of(Numbers::Exact, &[]), Digest::new("test", Numbers::Exact).finish());
        assert_ne!(Digest::new("a", Numbers::Exact).finish(), Digest::new("b", Numbers::Exact).finish());
    }

    #[test]
    fn long_lists_go_in_whole() {
        // Little-endian bytes of the list after purpose and lengths, across the ends of chunks.
        let list: Vec<u32> = (0..3 * CHUNK as u32 + 7).collect();
        let mut digest = Digest::new("x", Numbers::Equal);
        digest.list(&list);
        let mut bytes = [1_u64.to_le_bytes().as_slice(), b"x", &(list.len() as u64).to_le_bytes()].concat();
        bytes.extend(list.iter().flat_map(|x| x.to_le_bytes()));
        assert_eq!(digest.finish(), *blake3::hash(&bytes).as_bytes());
        let mut watched = Digest::new("x", Numbers::Equal);
        watched.watched_list(&list, || Ok::<_, ()>(())).unwrap();
        assert_eq!(watched.finish(), digest.finish());
        assert_eq!(Digest::new("x", Numbers::Equal).watched_list(&list, || Err(1)), Err(1));
        assert_eq!(hex(&[0, 1, 255]), "0001ff");
    }
}
