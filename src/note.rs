//! Notes: what a technique could not do as asked, and what speaks against a matrix, as data with an English text.
//!
//! A [`Note`] has a kind, details where the kind alone does not say why, numbers by name, and the maps it is about. Its text
//! is made from these and never read back; [`gathered`] makes one note of the equal notes of several maps.

mod kinds;

use std::fmt;

pub use kinds::{Detail, Kind};

/// A number of a note: one value, or the range of the values of several maps.
#[derive(Debug, Clone, Copy)]
pub struct Span {
    /// The least value.
    pub least: f64,
    /// The largest.
    pub most: f64,
}

/// One thing to know about a result.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Note {
    kind: Kind,
    details: Vec<Detail>,
    values: Vec<(&'static str, Span)>,
    maps: Option<Vec<usize>>,
}

impl Span {
    /// A single value.
    pub fn of(value: f64) -> Self {
        Self { least: value, most: value }
    }
    /// From the least to the most of both.
    fn with(self, other: Self) -> Self {
        Self { least: self.least.min(other.least), most: self.most.max(other.most) }
    }
    fn bits(self) -> [u64; 2] {
        // Adding zero makes one of both zeros.
        [self.least, self.most].map(|x| (x + 0.0).to_bits())
    }
}

// By bits, so that a note with a NaN equals itself.
impl PartialEq for Span {
    fn eq(&self, other: &Self) -> bool {
        self.bits() == other.bits()
    }
}

impl Eq for Span {}

impl std::hash::Hash for Span {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.bits().hash(state);
    }
}

impl Note {
    /// A note without details about all maps; `values` has the numbers that the kind names.
    pub fn new(kind: Kind, values: &[(&str, f64)]) -> Self {
        Self::detailed(kind, &[], values)
    }
    /// No warp: the map is a uniform one.
    pub fn no_warp(why: &[Detail], values: &[(&str, f64)]) -> Self {
        Self::detailed(Kind::NoWarp, why, values)
    }
    /// A note with details, which are of its kind, about all maps.
    pub fn detailed(kind: Kind, details: &[Detail], values: &[(&str, f64)]) -> Self {
        let given = |name: &str| values.iter().find(|v| v.0 == name).map(|v| v.1);
        let names = Self::names(kind, details);
        debug_assert!(details.iter().all(|detail| detail.kind() == kind), "{kind:?} {details:?}");
        debug_assert!(names.len() == values.len() && names.iter().all(|n| given(n).is_some()), "{names:?} {values:?}");
        let values = names.into_iter().map(|name| (name, Span::of(given(name).unwrap_or(f64::NAN)))).collect();
        Self { kind, details: details.to_vec(), values, maps: None }
    }
    /// The names of the numbers that a kind with these details has, in the order of its text.
    pub fn names(kind: Kind, details: &[Detail]) -> Vec<&'static str> {
        let mut names = Vec::new();
        for text in std::iter::once(kind.text()).chain(details.iter().map(|detail| detail.text())) {
            for (name, _) in places(text) {
                if name != DETAILS && !names.contains(&name) {
                    names.push(name);
                }
            }
        }
        names
    }
    /// The same note with other numbers, in the order of [`Note::names`].
    pub fn spanning(mut self, spans: impl IntoIterator<Item = Span>) -> Self {
        self.values.iter_mut().zip(spans).for_each(|(value, span)| value.1 = span);
        self
    }
    /// The same note about other maps, counted from 0; about all of them where none are given.
    pub fn about(mut self, maps: Option<Vec<usize>>) -> Self {
        self.maps = maps.map(|mut maps| {
            maps.sort_unstable();
            maps.dedup();
            maps
        });
        self
    }
    /// What it is about.
    pub fn kind(&self) -> Kind {
        self.kind
    }
    /// What the kind alone does not say: why there is no warp, which faces have no map, what speaks against a matrix.
    pub fn details(&self) -> &[Detail] {
        &self.details
    }
    /// Its numbers by name.
    pub fn values(&self) -> &[(&'static str, Span)] {
        &self.values
    }
    /// The maps that it is about, counted from 0; nothing where it is about all maps of the result.
    pub fn maps(&self) -> Option<&[usize]> {
        self.maps.as_deref()
    }
    /// The texts of the details.
    pub fn reasons(&self) -> Vec<String> {
        self.details.iter().map(|detail| self.filled(detail.text())).collect()
    }
    /// The texts of the details as one; empty where the kind says it all.
    pub fn reason(&self) -> String {
        self.reasons().join(self.kind.between_details())
    }
    /// A text with its places filled in.
    fn filled(&self, text: &'static str) -> String {
        let mut filled = String::with_capacity(2 * text.len());
        let mut pieces = text.split('{');
        filled.push_str(pieces.next().unwrap_or_default());
        for (piece, (name, format)) in pieces.zip(places(text)) {
            match self.values.iter().find(|value| value.0 == name) {
                Some((_, span)) => filled.push_str(&range_text(*span, format)),
                None => filled.push_str(&self.reason()),
            }
            filled.push_str(piece.split_once('}').map_or("", |(_, after)| after));
        }
        filled
    }
    /// Whether both differ in numbers at most that have a range: the same kind, details and exact numbers.
    fn is_like(&self, other: &Self) -> bool {
        let exact = |name: &str| {
            let texts = std::iter::once(self.kind.text()).chain(self.details.iter().map(|detail| detail.text()));
            texts.flat_map(places).any(|(n, format)| n == name && format.is_empty())
        };
        self.kind == other.kind
            && self.details == other.details
            && self.values.iter().zip(&other.values).all(|(a, b)| a.1 == b.1 || !exact(a.0))
    }
}

/// The English text. A note about some of several maps begins with their numbers, which count from 1.
impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.kind != Kind::LightInBox {
            if let Some(maps) = &self.maps {
                write!(f, "{}", which(maps))?;
            }
            return f.write_str(&self.filled(self.kind.text()));
        }
        // Nobody knows in which map a caster next to the light is: the largest distance holds for all of them.
        let ranges =
            self.values.iter().any(|(_, span)| range_text(*span, ".4") != range_text(Span::of(span.most), ".4"));
        let farthest = self.clone().spanning(self.values.iter().map(|(_, span)| Span::of(span.most)));
        let text = if ranges || self.maps.is_some() { kinds::LIGHT_IN_SOME_BOX } else { self.kind.text() };
        f.write_str(&farthest.filled(text))
    }
}

/// The place of the details in the text of a kind.
const DETAILS: &str = "details";

/// The places of a text, `{name}` or `{name:format}`, as name and format.
fn places(text: &'static str) -> impl Iterator<Item = (&'static str, &'static str)> {
    let place = |piece: &'static str| {
        let inside = piece.split_once('}').map_or(piece, |(inside, _)| inside);
        inside.split_once(':').unwrap_or((inside, ""))
    };
    text.split('{').skip(1).map(place)
}

/// A number, or both ends of a range where their texts differ.
fn range_text(span: Span, format: &str) -> String {
    let [least, most] = [span.least, span.most].map(|x| number_text(x, format));
    if least == most { least } else { format!("{least} to {most}") }
}

fn number_text(x: f64, format: &str) -> String {
    match format {
        "0" => format!("{x:.0}"),
        ".4" => format!("{x:.4}"),
        "e" => format!("{x:e}"),
        ".3e" => format!("{x:.3e}"),
        ".4e" => format!("{x:.4e}"),
        ".2g" => significant(x, 2),
        _ => format!("{x}"),
    }
}

/// A number with so many significant digits, as C's `%g` writes it.
fn significant(x: f64, digits: i32) -> String {
    let scientific = format!("{x:.*e}", digits as usize - 1);
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text.to_string(),
    };
    match scientific.split_once('e').and_then(|(mantissa, e)| Some((mantissa, e.parse::<i32>().ok()?))) {
        Some((_, e)) if (-4..digits).contains(&e) => trimmed(&format!("{x:.*}", (digits - 1 - e) as usize)),
        Some((mantissa, e)) => {
            format!("{}e{}{:02}", trimmed(mantissa), if e < 0 { '-' } else { '+' }, e.abs())
        }
        None => format!("{x}").to_lowercase(),
    }
}

/// The maps that a note is about, as the beginning of its text.
fn which(maps: &[usize]) -> String {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for map in maps.iter().map(|map| map + 1) {
        match runs.last_mut() {
            Some([_, last]) if *last + 1 == map => *last = map,
            _ => runs.push([map, map]),
        }
    }
    let text = |[first, last]: &[usize; 2]| match last - first {
        0 => format!("{first}"),
        1 => format!("{first}, {last}"),
        _ => format!("{first} to {last}"),
    };
    let plural = if maps.len() == 1 { "" } else { "s" };
    format!("map{plural} {}: ", runs.iter().map(text).collect::<Vec<_>>().join(", "))
}

/// The notes of maps, each map's in its own order, as notes of all of them: equal notes become one with the maps it is about,
/// and of notes that differ in numbers with a range one is left, with the range of each number.
pub fn gathered<'a>(of_maps: impl ExactSizeIterator<Item = &'a [Note]>) -> Vec<Note> {
    let count = of_maps.len();
    let mut groups: Vec<(Vec<usize>, Note)> = Vec::new();
    for (map, notes) in of_maps.enumerate() {
        for note in notes {
            match groups.iter_mut().find(|(_, group)| group.is_like(note)) {
                Some((maps, group)) => {
                    if maps.last() != Some(&map) {
                        maps.push(map);
                    }
                    group.values.iter_mut().zip(&note.values).for_each(|(a, b)| a.1 = a.1.with(b.1));
                }
                None => groups.push((vec![map], note.clone())),
            }
        }
    }
    groups.into_iter().map(|(maps, note)| note.about((maps.len() < count).then_some(maps))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(maps: &[&[&Note]]) -> Vec<String> {
        let owned: Vec<Vec<Note>> = maps.iter().map(|notes| notes.iter().map(|n| (*n).clone()).collect()).collect();
        gathered(owned.iter().map(Vec::as_slice)).iter().map(Note::to_string).collect()
    }
    fn raised(given: f64, least: f64) -> Note {
        Note::new(Kind::WarpDistanceRaised, &[("given", given), ("least", least)])
    }
    fn in_box(distance: f64) -> Note {
        Note::new(Kind::LightInBox, &[("distance", distance)])
    }

    #[test]
    fn every_text_has_a_known_format_and_its_own_details() {
        let formats = ["", "0", ".4", "e", ".3e", ".4e", ".2g"];
        for kind in Kind::ALL {
            let details: Vec<Detail> = Detail::ALL.iter().copied().filter(|d| d.kind() == *kind).collect();
            let asks = places(kind.text()).any(|(name, _)| name == DETAILS);
            assert_eq!(asks, !details.is_empty(), "{kind:?}");
            let texts = std::iter::once(kind.text()).chain(details.iter().map(|d| d.text()));
            assert!(texts.flat_map(places).all(|(_, format)| formats.contains(&format)), "{kind:?}");
            let numbers: Vec<_> = Note::names(*kind, &details).into_iter().map(|name| (name, 0.5)).collect();
            let text = Note::detailed(*kind, &details, &numbers).to_string();
            assert!(!text.contains(['{', '}']) && !text.contains("NaN"), "{text}");
            assert_eq!(Kind::named(kind.name()), Some(*kind));
        }
    }

    #[test]
    fn equal_notes_are_one_with_the_maps_counted_from_one() {
        let (dark, small) = (Note::new(Kind::NothingSeen, &[]), Note::new(Kind::NoLogarithm, &[]));
        let at = |maps: &str, note: &Note| format!("{maps}{note}");
        assert_eq!(of(&[&[&dark], &[], &[&dark]]), [at("maps 1, 3: ", &dark)]);
        assert_eq!(of(&[&[&dark], &[&dark], &[&dark]]), [at("", &dark)], "all of them need no list");
        assert_eq!(
            of(&[&[&dark], &[&dark], &[&dark], &[], &[&dark, &small]]),
            [at("maps 1 to 3, 5: ", &dark), at("map 5: ", &small)]
        );
        assert_eq!(of(&[&[], &[&dark]]), [at("map 2: ", &dark)]);
        assert_eq!(of(&[&[&dark, &dark], &[]]), [at("map 1: ", &dark)]);
        assert!(of(&[&[], &[]]).is_empty());
        let gathered = gathered([[dark.clone()].as_slice(), &[]].into_iter());
        assert_eq!(gathered, [dark.clone().about(Some(vec![0]))]);
        assert_eq!(gathered[0].maps(), Some([0].as_slice()));
        assert_eq!(dark.maps(), None);
    }

    #[test]
    fn notes_that_differ_in_a_number_are_one_with_its_range() {
        let told = of(&[&[&raised(1e-3, 0.5)], &[&raised(1e-3, 0.25)], &[]]);
        assert_eq!(told, ["maps 1, 2: warp distance 1e-3 raised to 2.5e-1 to 5e-1, the least for the body"]);
        let all = [vec![raised(-2.0, 10.0)], vec![raised(1.5e-7, 9.0)]];
        let note = &gathered(all.iter().map(Vec::as_slice))[0];
        let span = |least, most| Span { least, most };
        assert_eq!(note.values(), [("given", span(-2.0, 1.5e-7)), ("least", span(9.0, 10.0))], "by value");
        let below = |sine: f64| Note::no_warp(&[Detail::BelowMinSine], &[("sine", sine)]);
        let alike = of(&[&[&below(0.012341)], &[&below(0.012342)]]);
        assert_eq!(alike, ["no warp, a uniform map: the sine between light and view, 1.234e-2, is below min_sin"]);
        // Another border is another thing, and so is another reason.
        let border = |at: f64| Note::new(Kind::BorderOutside, &[("border", at), ("near", 1.0), ("far", 9.5)]);
        assert_eq!(of(&[&[&border(0.5)], &[&border(20.0)]]).len(), 2);
        assert_eq!(of(&[&[&Note::no_warp(&[Detail::FlatBody], &[])], &[&below(0.0)]]).len(), 2);
    }

    #[test]
    fn the_largest_distance_to_a_light_in_a_box_is_given_for_all_maps() {
        let (near, far) = (in_box(0.125), in_box(2.5));
        let some = "the light is inside a mesh's box: what is nearer to it than 2.5000 may cast no shadow";
        assert_eq!(of(&[&[&near], &[&far], &[]]), [some]);
        assert_eq!(of(&[&[&far], &[]]), [some]);
        assert_eq!(of(&[&[&near], &[&far]]), [some]);
        assert_eq!(of(&[&[&far], &[&far]]), [some.replace("may cast", "casts")]);
    }

    #[test]
    fn details_are_joined_and_numbers_written_as_c_does() {
        let faces = Note::detailed(Kind::FaceUnseen, &[Detail::Left, Detail::Near], &[]);
        assert_eq!(faces.to_string(), "nothing is seen on the way to the left or the near face: no map");
        let doubt = |miss: f64| {
            Note::detailed(Kind::CheckMatrix, &[Detail::MissesLight, Detail::Transposed], &[("miss", miss)])
        };
        let texts = [
            (0.37, "0.37"),
            (1.0, "1"),
            (0.5, "0.5"),
            (12.3, "12"),
            (123.0, "1.2e+02"),
            (1.04e-5, "1e-05"),
            (f64::NAN, "nan"),
        ];
        for (miss, text) in texts {
            assert!(
                doubt(miss).reason().contains(&format!("by {text} (0 expected); its transpose is one")),
                "{}",
                doubt(miss)
            );
            assert_eq!(doubt(miss), doubt(miss));
        }
    }
}
