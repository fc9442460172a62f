//! Names that are spelled alike.

/// Maximum number of names that an error suggests.
const MAX_SUGGESTIONS: usize = 3;

/// Lists the names that are spelled most like a given one, nearest first.
pub(super) fn nearest<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    // Equal distances are in the order of the alphabet.
    let mut ranked: Vec<(usize, &str)> =
        names.map(|other| (edit_distance(name, other), other)).collect();
    ranked.sort_unstable();
    ranked.truncate(MAX_SUGGESTIONS);
    ranked.into_iter().map(|(_, other)| other).collect()
}

/// Computes the Levenshtein distance of two names, without regard to case: the number of letters
/// to insert, remove or replace.
fn edit_distance(a: &str, b: &str) -> usize {
    let [a, b] = [a, b].map(|name| name.to_lowercase().chars().collect::<Vec<char>>());

    // Distances of the letters of `a` so far from each beginning of `b`.
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, other) in b.iter().enumerate() {
            // The last letter is replaced or kept, removed, or inserted.
            let replaced = diagonal + usize::from(letter != other);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_count_letters() {
        let cases = [
            ("femur", "femur", 0),
            ("Femur", "femur", 0),
            ("godo2", "godo1", 1),
            ("femr", "femur", 1),
            ("", "tibia", 5),
            ("kitten", "sitting", 3),
        ];
        for (a, b, expected) in cases {
            assert_eq!(edit_distance(a, b), expected, "{a} {b}");
            assert_eq!(edit_distance(b, a), expected, "{b} {a}");
        }
    }

    #[test]
    fn the_nearest_names_come_first() {
        let bodies = ["pelvis", "patella", "tibia", "femur_left", "femur"];
        assert_eq!(nearest("femurr", bodies.into_iter()), ["femur", "femur_left", "pelvis"]);
    }
}
