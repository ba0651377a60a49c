//! How a technique declares itself. Python keywords, sliders, the command line and the documentation's table read this.

#[cfg(doc)]
use crate::parameterization::Value;

/// Which values a parameter takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A number between two, both included.
    Number {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// A whole number between two, both included.
    Integer {
        /// Smallest.
        min: i64,
        /// Largest.
        max: i64,
    },
    /// On or off.
    Flag,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// One of these words, or a number between two.
    ChoiceOrNumber {
        /// The words.
        words: &'static [&'static str],
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// A list of numbers in parentheses, or one of these words.
    Numbers {
        /// The words.
        words: &'static [&'static str],
        /// Fewest and most numbers.
        count: [usize; 2],
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// One technique or several, as [`techniques_of`](crate::techniques::techniques_of) reads them.
    Techniques,
}

/// The default of a parameter; [`Value`] without the heap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Default {
    /// See [`Value::Number`].
    Number(f64),
    /// See [`Value::Integer`].
    Integer(i64),
    /// See [`Value::Flag`].
    Flag(bool),
    /// See [`Value::Choice`].
    Choice(&'static str),
}

/// One parameter, declared once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParamSpec {
    /// Keyword.
    pub name: &'static str,
    /// Unit, "" for none.
    pub unit: &'static str,
    /// Value where none is given.
    pub default: Default,
    /// Range.
    pub kind: Kind,
    /// One line.
    pub doc: &'static str,
}

/// How closely a map is cut to receivers and casters ([`Tightening`](crate::fit::Tightening)): the last parameter of every
/// warp, whose technique need not look at it.
pub const FIT: ParamSpec = ParamSpec {
    name: "fit",
    unit: "",
    default: Default::Choice("exact"),
    kind: Kind::Choice(&["exact", "receivers", "intersection", "none"]),
    doc: "how closely the map is cut: to receivers and the casters above them (exact), to receivers and all casters' depth \
          (receivers), to where anything is cast on anything (intersection), or not to what is in the view (none)",
};

/// Which lights a technique serves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LightSupport {
    /// Directional lights.
    pub directional: bool,
    /// Spot lights.
    pub spot: bool,
    /// Point lights.
    pub point: bool,
}

/// A technique's self-description.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spec {
    /// Name in the registry.
    pub name: &'static str,
    /// For people.
    pub title: &'static str,
    /// Authors, year, section.
    pub source: &'static str,
    /// The lights it serves.
    pub lights: LightSupport,
    /// Its parameters.
    pub params: &'static [ParamSpec],
}
