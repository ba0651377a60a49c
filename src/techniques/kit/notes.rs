//! What there is to say of several maps, each thing once: equal notes become one with the maps it is about, and of notes
//! that differ in their numbers alone one is left, with the range of each number.

/// How a note begins that says where a placed light's map begins.
pub(super) const INSIDE_A_BOX: &str = "the light is inside a mesh's box";

/// The note of a map that begins too late for casters next to the light.
pub(super) fn begins_late(distance: f64) -> String {
    format!("{INSIDE_A_BOX}: what is nearer to it than {distance:.4} casts no shadow")
}

/// The notes of maps, each map's in its own order, as notes of all of them.
pub(super) fn gathered<'a>(of_maps: impl ExactSizeIterator<Item = &'a [String]>) -> Vec<String> {
    let count = of_maps.len();
    let mut groups: Vec<(Vec<usize>, Vec<&str>)> = Vec::new();
    for (map, notes) in of_maps.enumerate() {
        for note in notes {
            match groups.iter_mut().find(|(_, notes)| same_words(notes[0], note)) {
                Some((maps, notes)) => {
                    if maps.last() != Some(&map) {
                        maps.push(map);
                    }
                    notes.push(note);
                }
                None => groups.push((vec![map], vec![note])),
            }
        }
    }
    groups.into_iter().map(|(maps, notes)| said(&maps, &notes, count)).collect()
}

/// One note for all of a group.
fn said(maps: &[usize], notes: &[&str], count: usize) -> String {
    if notes[0].starts_with(INSIDE_A_BOX) {
        // Nobody knows in which map a caster next to the light is: the largest distance is what to go by.
        let farthest = notes.iter().fold(notes[0], |a, b| if largest(b) > largest(a) { b } else { a });
        let everywhere = maps.len() == count && notes.iter().all(|note| *note == farthest);
        return if everywhere { farthest.to_string() } else { farthest.replace("casts no", "may cast no") };
    }
    let columns: Vec<Vec<Word>> = notes.iter().map(|note| words(note).collect()).collect();
    let word = |i: usize| {
        let ends = columns.iter().map(|column| column[i]).fold([columns[0][i]; 2], |[least, most], word| {
            [
                if number(word) < number(least) { word } else { least },
                if number(word) > number(most) { word } else { most },
            ]
        });
        match ends {
            [Word::Number(a, least, _), Word::Number(b, most, after)] if a < b => format!("{least} to {most}{after}"),
            [Word::Number(_, text, after), _] => format!("{text}{after}"),
            [Word::Text(text), _] => text.to_string(),
        }
    };
    which(maps, count) + &(0..columns[0].len()).map(word).collect::<Vec<_>>().join(" ")
}

/// The number of a word; 0 of text.
fn number(word: Word) -> f64 {
    if let Word::Number(value, ..) = word { value } else { 0.0 }
}

/// The largest number of a note.
fn largest(note: &str) -> f64 {
    words(note).map(number).fold(0.0, f64::max)
}

/// The maps that a note is about, counted from 1; nothing where it is about all of `count`.
fn which(maps: &[usize], count: usize) -> String {
    if maps.len() == count {
        return String::new();
    }
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

/// A word of a note as its number and what follows that, or as text.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Word<'a> {
    Number(f64, &'a str, &'a str),
    Text(&'a str),
}

/// The words of a note.
fn words(note: &str) -> impl Iterator<Item = Word<'_>> {
    note.split(' ').map(|word| {
        let number = word.trim_end_matches([',', ':', ';', ')']);
        let looks_like_one = number.starts_with(|c: char| c == '-' || c.is_ascii_digit());
        match number.parse() {
            Ok(value) if looks_like_one => Word::Number(value, number, &word[number.len()..]),
            _ => Word::Text(word),
        }
    })
}

/// Whether two notes differ in numbers at most.
fn same_words(a: &str, b: &str) -> bool {
    let same = |pair: (Word, Word)| match pair {
        (Word::Number(_, _, after), Word::Number(_, _, after_other)) => after == after_other,
        (word, other) => word == other,
    };
    a == b || words(a).count() == words(b).count() && words(a).zip(words(b)).all(same)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(maps: &[&[&str]]) -> Vec<String> {
        let owned: Vec<Vec<String>> = maps.iter().map(|notes| notes.iter().map(|n| n.to_string()).collect()).collect();
        gathered(owned.iter().map(Vec::as_slice))
    }

    #[test]
    fn equal_notes_are_one_with_the_maps_counted_from_one() {
        assert_eq!(of(&[&["dark"], &[], &["dark"]]), ["maps 1, 3: dark"]);
        assert_eq!(of(&[&["dark"], &["dark"], &["dark"]]), ["dark"], "all of them need no list");
        assert_eq!(
            of(&[&["dark"], &["dark"], &["dark"], &[], &["dark", "small"]]),
            ["maps 1 to 3, 5: dark", "map 5: small"]
        );
        assert_eq!(of(&[&[], &["dark"]]), ["map 2: dark"]);
        assert_eq!(of(&[&["dark", "dark"], &[]]), ["map 1: dark"]);
        assert!(of(&[&[], &[]]).is_empty());
    }

    #[test]
    fn notes_that_differ_in_a_number_are_one_with_its_range() {
        let raised = |given: &str, least: &str| format!("slide {given} raised to {least}, the least for x2");
        let (a, b) = (raised("1e-3", "0.5"), raised("1e-3", "0.25"));
        assert_eq!(of(&[&[&a], &[&b], &[]]), ["maps 1, 2: slide 1e-3 raised to 0.25 to 0.5, the least for x2"]);
        assert_eq!(of(&[&["at x2"], &["at x3"]]), ["map 1: at x2", "map 2: at x3"], "a word is not a number");
        assert_eq!(of(&[&["10 texels"], &["9 texels"]]), ["9 to 10 texels"], "by value, not as text");
        assert_eq!(of(&[&["from -2"], &["from 1.5e-7"]]), ["from -2 to 1.5e-7"]);
    }

    #[test]
    fn the_largest_distance_to_a_light_in_a_box_is_told_of_all_maps() {
        let (near, far) = (begins_late(0.125), begins_late(2.5));
        let told = of(&[&[&near], &[&far], &[]]);
        assert_eq!(told, [far.replace("casts no", "may cast no")]);
        assert!(told[0].contains("2.5000 may cast no shadow"), "{told:?}");
        assert_eq!(of(&[&[&far], &[&far]]), [far.as_str()]);
    }
}
