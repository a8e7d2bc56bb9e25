//! Errors in an assembly, with their location and remedy.

use nailnoise_documents::{Place, nearest};

/// An error in the text of an assembly.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}, line {}: {path}{fault}{changes}", at.file(), at.line(), path = shown(path))]
pub struct AssemblyError {
    /// Full name of the field or block; empty for the complete file.
    pub path: String,
    /// What is wrong.
    pub fault: Fault,
    /// Location.
    pub at: Box<Place>,
    /// Changes, in files closer to the design, to blocks that contribute to the fault.
    pub changes: Box<Changes>,
}

/// A field, block or key of a file that replaces one of the assembly that the file changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Its full name.
    pub path: String,
    /// Location.
    pub at: Box<Place>,
}

/// Changes, shown as the end of a message.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Changes(pub Vec<Change>);

impl std::fmt::Display for Changes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, Change { path, at }) in self.0.iter().enumerate() {
            let introduction = if index == 0 { "; changed at" } else { " and at" };
            write!(f, "{introduction} {}, line {}, by `{path}`", at.file(), at.line())?;
        }
        Ok(())
    }
}

fn shown(path: &str) -> String {
    if path.is_empty() {
        String::new()
    } else {
        format!("`{path}` ")
    }
}

impl AssemblyError {
    /// The remedy; empty if the message suffices.
    pub fn help(&self) -> String {
        self.fault.help()
    }
}

/// A problem of an assembly.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The file is not valid TOML.
    #[error("{0}")]
    Syntax(String),
    /// The file of a base assembly cannot be read.
    #[error("names the assembly \"{name}\", which cannot be read: {reason}")]
    Unreadable {
        /// Name as given.
        name: String,
        /// Message of the file system.
        reason: String,
        /// Names of built-in assemblies.
        known: Vec<String>,
    },
    /// A value is given for a key that is neither declared nor a standard one.
    #[error("is not a key of the assembly")]
    Undeclared {
        /// Full name of the key.
        key: String,
        /// Declared keys.
        known: Vec<String>,
    },
    /// Unknown field.
    #[error("is not a field of {}", with_article(owner))]
    UnknownField {
        /// Family or table.
        owner: String,
        /// Name as given.
        name: String,
        /// Known fields.
        known: Vec<String>,
    },
    /// A required field is missing.
    #[error("has no field `{field}`")]
    Missing {
        /// Absent field.
        field: String,
        /// Example of the field.
        example: String,
    },
    /// A value has the wrong kind.
    #[error("is {found}, expected {expected}")]
    Kind {
        /// Kind found.
        found: String,
        /// Kind expected.
        expected: String,
    },
    /// A value has the wrong dimension.
    #[error("is {found}, expected {expected}")]
    Dimension {
        /// Dimension found.
        found: String,
        /// Dimension expected.
        expected: String,
        /// Units of the expected dimension.
        units: String,
    },
    /// A text is not a quantity.
    #[error("is \"{text}\": {problem}")]
    Literal {
        /// Text as given.
        text: String,
        /// Reason.
        problem: String,
        /// Units of the expected dimension.
        units: String,
    },
    /// A value is outside the domain of its field.
    #[error("is {value}, allowed is {allowed}")]
    Domain {
        /// Value \[SI\].
        value: f64,
        /// Domain in words.
        allowed: String,
    },
    /// A formula cannot be parsed or evaluated.
    #[error("cannot evaluate \"{formula}\": {problem}")]
    Formula {
        /// Formula.
        formula: String,
        /// Reason.
        problem: String,
        /// Remedy; may be empty.
        help: String,
    },
    /// A name does not refer to anything.
    #[error("names \"{name}\", which is not a known {wanted}")]
    UnknownName {
        /// Name as given.
        name: String,
        /// Kind of object expected.
        wanted: String,
        /// Names that exist.
        known: Vec<String>,
    },
    /// A reference to a block that is switched off by its `if`.
    #[error("refers to \"{name}\", which its `if` switches off")]
    SwitchedOff {
        /// Block.
        name: String,
    },
    /// A trigger, motor or latch waits for an unknown word.
    #[error("waits for \"{word}\", which no block logs")]
    UnknownWord {
        /// Word as given.
        word: String,
        /// Words that exist.
        known: Vec<String>,
    },
    /// A word of a block is given instead of the event that occurs with it.
    #[error("names \"{word}\", which is not an event")]
    WordForEvent {
        /// Text as given.
        word: String,
        /// Words of the block.
        known: Vec<String>,
    },
    /// A text gives a word of a block instead of a time.
    #[error("is \"{word}\", which is not a time")]
    WordForTime {
        /// Text as given.
        word: String,
        /// Words of the block.
        known: Vec<String>,
    },
    /// Words of a block are given instead of a condition.
    #[error("is \"{word}\", which is not a condition")]
    WordForCondition {
        /// Text as given.
        word: String,
        /// Words of the block.
        known: Vec<String>,
    },
    /// A text gives words instead of an expression over channels.
    #[error("is \"{words}\", which is not an expression")]
    WordsForExpression {
        /// Text as given.
        words: String,
        /// Channels of the block.
        channels: Vec<String>,
    },
    /// Two blocks have the same name.
    #[error("has the name of {}", with_article(other))]
    DuplicateName {
        /// Family of the other block.
        other: String,
    },
    /// A name contains characters other than lower-case letters, digits and underscores.
    #[error("is not a name of a block")]
    BadName,
    /// A name already has a meaning in formulas.
    #[error("has a name with a meaning of its own in formulas")]
    Reserved,
    /// A declared key is a standard one, and its domain is already defined.
    #[error("declares a key that every assembly has, {allowed}")]
    StandardKey {
        /// Its domain in words.
        allowed: String,
    },
    /// Two fields exclude each other.
    #[error("has more than one of {}", fields.join(", "))]
    Exclusive {
        /// Fields found.
        fields: Vec<String>,
    },
    /// A text is not one of the allowed words.
    #[error("is \"{found}\", which is none of {}", words.join(", "))]
    Word {
        /// Text as given.
        found: String,
        /// Words.
        words: Vec<String>,
    },
    /// An opening names a restriction of a passage that has only one.
    #[error("is \"{found}\", but \"{passage}\" has a single restriction, without a name")]
    SingleRestriction {
        /// Text as given.
        found: String,
        /// Passage of the opening.
        passage: String,
    },
    /// An opening has another area than its restriction.
    #[error("gives {:.2} mm2, but the restriction has {:.2} mm2", 1e6 * found, 1e6 * restriction)]
    OpeningArea {
        /// Area of the opening \[m2\].
        found: f64,
        /// Constant area of the restriction \[m2\].
        restriction: f64,
    },
    /// A passage connects a space to itself.
    #[error("leads from \"{space}\" back to itself")]
    SelfLoop {
        /// Space.
        space: String,
    },
    /// Names refer to each other in a cycle.
    #[error("refers to itself: {}", names.join(" -> "))]
    Circle {
        /// Names in order.
        names: Vec<String>,
    },
    /// The atmosphere is missing.
    #[error("has no reservoir \"atmosphere\"")]
    NoAtmosphere,
    /// A uniform pressure on the faces of a body has a resultant.
    #[error(
        "the faces of body \"{body}\" do not balance: {:.1} mm2 push down, {:.1} mm2 up; {:.1} mm2 feel no pressure",
        down * 1e6, up * 1e6, (down - up).abs() * 1e6
    )]
    Unbalanced {
        /// Body.
        body: String,
        /// Area that pushes down \[m2\].
        down: f64,
        /// Area that pushes up \[m2\].
        up: f64,
    },
    /// A face shrinks a volume to nothing.
    #[error("shrinks to {:.3} cm3 with \"{body}\" at {:.3} mm", volume * 1e6, travel * 1e3)]
    Collapse {
        /// Smallest volume \[m3\].
        volume: f64,
        /// Body.
        body: String,
        /// Travel \[m\].
        travel: f64,
    },
    /// Nothing can change a volume.
    #[error("has no passage and no face: nothing can change it")]
    Isolated,
    /// A passage discharges into the atmosphere without making noise.
    #[error("blows into the atmosphere without an opening")]
    Unheard,
    /// The loads on a body do not add up to the force on it.
    #[error("the loads on \"{body}\" do not add up to the force on it without its weight: {}", differences.join("; "))]
    LoadSum {
        /// Body.
        body: String,
        /// Forces that are missing or counted twice.
        differences: Vec<String>,
        /// Terms that correct it; empty if no term does.
        remedies: Vec<String>,
    },
    /// Two openings make the noise of one passage.
    #[error("makes the noise of \"{passage}\", as the opening \"{other}\" does")]
    TwoOpenings {
        /// Passage.
        passage: String,
        /// The other opening.
        other: String,
    },
    /// A body starts deep inside a stop.
    #[error("starts {:.3} mm inside the stop \"{stop}\", which stores {energy:.0} J", overlap * 1e3)]
    InsideStop {
        /// Contact.
        stop: String,
        /// Overlap at the start \[m\].
        overlap: f64,
        /// Energy of the contact \[J\].
        energy: f64,
    },
    /// A body drives two fasteners.
    #[error("names \"{driver}\", which drives \"{other}\" already")]
    TwoFasteners {
        /// Driver.
        driver: String,
        /// The other fastener.
        other: String,
    },
    /// A driver starts beyond the head of its fastener.
    #[error("has its head {:.3} mm above the start of \"{driver}\", which never strikes it", beyond * 1e3)]
    PastHead {
        /// Driver.
        driver: String,
        /// Distance from the head \[m\].
        beyond: f64,
    },
    /// A spring is compressed beyond the range of its law.
    #[error(
        "is compressed by {:.3} mm at the stop \"{stop}\", its law is valid to {:.3} mm",
        compression * 1e3,
        limit * 1e3
    )]
    SpringLimit {
        /// Contact.
        stop: String,
        /// Compression there \[m\].
        compression: f64,
        /// Largest compression of the law \[m\].
        limit: f64,
    },
    /// Two open seats connect a supply to the atmosphere.
    #[error(
        "and \"{other}\" are open together from {:.3} to {:.3} mm of \"{}\": {reservoir} blows into atmosphere",
        travels.from * 1e3, travels.to * 1e3, travels.body
    )]
    OpenTogether {
        /// The other passage.
        other: String,
        /// Where both are open.
        travels: Box<Travels>,
        /// Reservoir that is emptied.
        reservoir: String,
    },
}

/// A range of travel of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Travels {
    /// The body.
    pub body: String,
    /// Start \[m\].
    pub from: f64,
    /// End \[m\].
    pub to: f64,
}

impl Fault {
    /// The remedy.
    fn help(&self) -> String {
        match self {
            Self::Syntax(_) => "correct the syntax at this place".to_owned(),
            Self::Unreadable { known, .. } => {
                format!(
                    "name a file relative to this one, or a built-in assembly: {}",
                    known.join(", ")
                )
            }
            Self::Undeclared { key, known } => {
                let near = nearest(known.iter().map(String::as_str), key);
                let near = near.map_or_else(String::new, |near| format!("did you mean `{near}`? "));
                let (group, key) = key.rsplit_once('.').unwrap_or(("", key));
                format!("{near}an own key is declared, as [keys.{group}] {key} = {{ domain = \"1 .. 100 mm\" }}")
            }
            Self::UnknownField { name, known, .. } => choose(name, known, "the fields are"),
            Self::Missing { example, .. } => format!("add it, as {example}"),
            Self::Kind { expected, .. } => format!("give {expected}"),
            Self::Dimension { units, .. } => format!("give a value in {units}"),
            Self::Literal { text, units, .. } => {
                let text = text.trim();
                let begins = text.starts_with(|first: char| first.is_alphabetic() || first == '(');
                let is_formula = begins && text.contains(['.', '+', '-', '*', '/', '(']);
                let example = if is_formula {
                    format!(", as \"={text}\"")
                } else {
                    String::new()
                };
                format!("give a number with a unit ({units}), or a formula that begins with \"=\"{example}")
            }
            Self::Domain { .. } => "correct the value or its unit".to_owned(),
            Self::Formula { help, .. } => help.clone(),
            Self::UnknownName { name, known, .. } => choose(name, known, "there are:"),
            Self::SwitchedOff { name } => format!("give this block the same `if` as \"{name}\""),
            Self::UnknownWord { known, .. } if known.is_empty() => logged(known),
            Self::UnknownWord { word, known } => choose(word, known, "there are:"),
            Self::WordForEvent { word, known } => {
                let near = nearest(known.iter().map(String::as_str), word).or(known.first().map(String::as_str));
                let example = near.map_or_else(String::new, |near| format!(", as hit = {{ becomes = \"{near}\" }}"));
                format!(
                    "it takes the name of an event: add one to [cycle.event]{example}; {}",
                    logged(known)
                )
            }
            Self::WordForTime { word, known } => {
                let near = nearest(known.iter().map(String::as_str), word).or(known.first().map(String::as_str));
                let word = near.unwrap_or_default();
                format!("give a time, as \"5 ms\", or replace it by becomes = \"{word}\"")
            }
            Self::WordForCondition { known, .. } if known.is_empty() => logged(known),
            Self::WordForCondition { word, known } => {
                let near = nearest(known.iter().map(String::as_str), word).or(known.first().map(String::as_str));
                format!(
                    "give a condition, as \"piston.travel > 1 mm\"; the event of a word has becomes = \"{}\" \
                     instead; {}",
                    near.unwrap_or_default(),
                    logged(known)
                )
            }
            Self::WordsForExpression { channels, .. } => {
                format!(
                    "give an expression; the channels of the block are {}",
                    channels.join(", ")
                )
            }
            Self::DuplicateName { .. } => "rename one of them; channels are named by their block".to_owned(),
            Self::BadName => "use lower-case letters, digits and underscores, a letter first".to_owned(),
            Self::Reserved => "choose another name than ground, key, pi, and, or, not".to_owned(),
            Self::StandardKey { .. } => {
                "remove the declaration: formulas may use the key as it is; or choose another name".to_owned()
            }
            Self::Exclusive { .. } => {
                "leave one of them; `replace = true` drops the fields of the assembly that this one changes".to_owned()
            }
            Self::Word { found, words } => choose(found, words, "choose one of"),
            Self::SingleRestriction { .. } => {
                "leave it out; `restriction = false` in your opening drops that of the assembly which you change"
                    .to_owned()
            }
            Self::OpeningArea { .. } => {
                "leave out `area` and `diameter`: an opening has the constant area of its restriction; with `count`, \
                 `diameter` is that of one of several equal holes"
                    .to_owned()
            }
            Self::SelfLoop { .. } => "name two different spaces or bodies".to_owned(),
            Self::TwoOpenings { .. } => {
                "remove one of them; `count` is the number of equal holes of an opening".to_owned()
            }
            Self::InsideStop { .. } => {
                "let it start outside the stop, or rest on it as start = { rest_on = \"NAME\" }".to_owned()
            }
            Self::TwoFasteners { .. } => {
                "describe both as one fastener, with the sum of their masses and resistances, or give each a driver"
                    .to_owned()
            }
            Self::PastHead { driver, .. } => format!("increase `head_at`, or let \"{driver}\" start above it"),
            Self::Circle { .. } => "break the circle: one of them must be given by other quantities".to_owned(),
            Self::NoAtmosphere => {
                "add it, as [cycle.reservoir.atmosphere] with pressure = \"101.325 kPa\" and temperature = \"20 degC\""
                    .to_owned()
            }
            Self::Unbalanced { .. } => {
                "add a face to \"atmosphere\", or set `unbalanced = true` on the body".to_owned()
            }
            Self::Collapse { .. } => "increase `dead` or move the stop".to_owned(),
            Self::Isolated => "connect it by a passage or a face, or remove it".to_owned(),
            Self::Unheard => "add an entry of [cycle.opening] for it, or set `silent = true`".to_owned(),
            Self::LoadSum { remedies, body, .. } if remedies.is_empty() => {
                format!("remove from [cycle.load.{body}] what exerts no force on \"{body}\"; count each force once")
            }
            Self::LoadSum { remedies, body, .. } => {
                format!("add {} to a surface of [cycle.load.{body}]", remedies.join(", "))
            }
            Self::SpringLimit { .. } => {
                "reduce the preload, move the stop, or give a law for the whole travel".to_owned()
            }
            Self::OpenTogether { .. } => "move one `at` so that one seat shuts before the other opens".to_owned(),
        }
    }
}

/// A noun with its indefinite article.
pub(super) fn with_article(noun: &str) -> String {
    let article = if noun.starts_with(['a', 'e', 'i', 'o']) {
        "an"
    } else {
        "a"
    };
    format!("{article} {noun}")
}

/// The words of a block, as a statement.
fn logged(known: &[String]) -> String {
    match known {
        [] => "this block logs no words; give a condition, as \"piston.travel > 1 mm\"".to_owned(),
        _ => format!("the words of the block are {}", known.join(", ")),
    }
}

/// "did you mean X? there are: A, B".
fn choose(name: &str, known: &[String], introduction: &str) -> String {
    let near = nearest(known.iter().map(String::as_str), name);
    let near = near.map_or_else(String::new, |near| format!("did you mean \"{near}\"? "));
    if known.is_empty() {
        return "there is none: add one, or remove this reference".to_owned();
    }
    format!("{near}{introduction} {}", known.join(", "))
}
