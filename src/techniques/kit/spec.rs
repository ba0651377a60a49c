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
    /// The text of one technique.
    Technique,
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

/// The depths that place a warp: a parameter of every warp, whose technique need not look at it.
pub const RANGE: ParamSpec = ParamSpec {
    name: "range",
    unit: "",
    default: Default::Choice("seen"),
    kind: Kind::Choice(&["seen", "body"]),
    doc: "depths that place the warp: those of the visible surfaces that face the light (seen), or of the part of the scene's \
          box inside the camera's frustum, most of it air (body)",
};

/// What a map must hold ([`Holds`](super::settings::Holds), [`Tightening`](crate::fit::Tightening)): a parameter of every
/// warp, whose technique need not look at it.
pub const FIT: ParamSpec = ParamSpec {
    name: "fit",
    unit: "",
    default: Default::Choice("shadow"),
    kind: Kind::Choice(&["shadow", "seen", "exact", "receivers", "intersection", "none"]),
    doc: "what the map must hold: visible receivers in shadow and their neighbours, as outside a map all is lit (shadow); \
          all visible receivers (seen); or, without samples, the boxes of all instances in the view and the casters above \
          them (exact), the same with all casters' depth (receivers), only where anything is cast on anything \
          (intersection), or all that the view's body holds (none)",
};

/// Room around samples: a parameter of every warp, whose technique need not look at it.
pub const MARGIN: ParamSpec = ParamSpec {
    name: "margin",
    unit: "texels",
    default: Default::Number(1.0),
    kind: Kind::Number { min: 0.0, max: 1e6 },
    doc: "room around the samples that fit=seen and fit=shadow keep, for receivers that no sample shows",
};

/// Room around samples for maps that are held: a parameter of every warp, whose technique need not look at it.
pub const SLACK: ParamSpec = ParamSpec {
    name: "slack",
    unit: "",
    default: Default::Number(1.0),
    kind: Kind::Number { min: 1.0, max: 2.0 },
    doc: "factor by which the map is larger, along each side, than what the samples of fit=seen and fit=shadow span in it, for \
          maps that are held while the camera moves; above 1 it also reaches to the far end of the scene",
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
