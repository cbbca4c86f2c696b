//! The looks of an atom.

use std::collections::HashMap;
use std::sync::LazyLock;

use crate::scene::Color;

/// An element's appearance.
#[derive(Clone, Copy)]
pub(super) struct Element {
    /// Van der Waals radius, ångström.
    pub radius: f64,
    /// Colour.
    pub color: Color,
}

/// All elements with a known radius, by symbol.
static ELEMENTS: LazyLock<HashMap<[u8; 2], Element>> = LazyLock::new(|| {
    let element = |line: &str| {
        let [symbol, radius, color] = line.split(' ').collect::<Vec<_>>().try_into().ok()?;
        let color = Color::parse(color)?;
        Some((key(symbol)?, Element { radius: radius.parse().ok()?, color }))
    };
    TABLE.lines().filter_map(element).collect()
});

/// Returns the element of a symbol in any case: `Cl`, `CL` and `cl` are chlorine. A number and a charge after it are left out:
/// `C1` is carbon, `Na+` is sodium.
pub(super) fn element(symbol: &str) -> Option<Element> {
    let symbol = symbol.trim_end_matches(['+', '-']).trim_end_matches(|c: char| c.is_ascii_digit());
    ELEMENTS.get(&key(symbol.trim_end_matches(['+', '-']))?).copied()
}

/// Whether the label of a file's first atom shows that the others are elements: a number is a type, not an element.
pub(super) fn is_label_of_elements(label: &str) -> bool {
    label.trim().parse::<f64>().is_err()
}

/// Labels in capital letters that are both an element and an atom of an amino acid: the element's name, and the atom's, after
/// the nomenclature of the Protein Data Bank.
const ATOM_NAMES: [(&str, &str, &str); 8] = [
    ("CA", "calcium", "the Cα atom"),
    ("CD", "cadmium", "the Cδ atom"),
    ("CE", "cerium", "the Cε atom"),
    ("HE", "helium", "an Hε atom"),
    ("HG", "mercury", "an Hγ atom"),
    ("HO", "holmium", "an H atom"),
    ("ND", "neodymium", "an Nδ atom"),
    ("NE", "neon", "an Nε atom"),
];

/// Returns the names of the element and of the atom of an amino acid if a label may be both.
pub(super) fn also_an_atom_name(label: &str) -> Option<(&'static str, &'static str)> {
    let found = ATOM_NAMES.iter().find(|(name, ..)| *name == label);
    found.map(|&(_, element, atom)| (element, atom))
}

fn key(symbol: &str) -> Option<[u8; 2]> {
    match *symbol.as_bytes() {
        [one] => Some([one.to_ascii_uppercase(), b' ']),
        [first, second] => Some([first.to_ascii_uppercase(), second.to_ascii_lowercase()]),
        _ => None,
    }
}

/// An element a line: symbol, van der Waals radius in ångström, sRGB colour.
///
/// Radii: S. Alvarez, "A cartography of the van der Waals territories", Dalton Trans. 42 (2013),
/// 8617–8636, table 1, from distances in crystals. It has all elements up to einsteinium but Pm, Po,
/// At, Rn, Fr and Ra. The older ones of Bondi (1964), known for 38 elements, differ by some
/// hundredths for C, N and O, and by much more for metals.
///
/// Colours: the CPK colours as Jmol extended them to all elements.
const TABLE: &str = include_str!("elements.txt");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_line_is_an_element_of_its_own() {
        assert_eq!((TABLE.lines().count(), ELEMENTS.len()), (93, 93));
        for (label, symbol) in [("C1", "C"), ("Na+", "Na"), ("Fe3+", "Fe"), ("Cl-1", "Cl")] {
            assert_eq!(element(label).unwrap().radius, element(symbol).unwrap().radius, "{label}");
        }
        assert!(["", "1", "+", "OW", "XX"].into_iter().all(|label| element(label).is_none()));
        let gold = element("AU").unwrap();
        assert_eq!((gold.radius, gold.color), (2.32, Color::from_srgb8([0xff, 0xd1, 0x23])));
    }
}
