//! Values of techniques' settings.

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A real number.
    Number(f64),
    /// A whole number.
    Integer(i64),
    /// On or off.
    Flag(bool),
    /// One of a few words, or the text of one or several techniques.
    Choice(String),
    /// A list of numbers.
    Numbers(Vec<f64>),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(x) => write!(f, "{x}"),
            Self::Integer(i) => write!(f, "{i}"),
            Self::Flag(b) => write!(f, "{b}"),
            Self::Choice(word) => write!(f, "{word:?}"),
            Self::Numbers(list) => {
                let texts: Vec<String> = list.iter().map(f64::to_string).collect();
                write!(f, "({})", texts.join(", "))
            }
        }
    }
}
