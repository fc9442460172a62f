//! Lines of Abaqus input files: keyword lines with their parameters, and data lines.
//!
//! Case does not matter, nor do blanks outside quotation marks. Keywords and parameters may be abbreviated. A
//! keyword line that ends with a comma goes on in the next one, if that begins with a letter as parameters do:
//! data lines of nodes, elements and instances begin with numbers, and may stand below a comma too many.
//!
//! Source: "Abaqus Analysis User's Guide", "Input syntax rules".

use crate::error::Format;
use crate::text::{Line, Lines, number};

/// Abaqus input file in refusals.
pub(crate) static INP: Format = Format {
    name: "INP",
    remedy: "save the nodes and elements of solids or surfaces in one file, each body as a part",
};

/// Minimum length of an abbreviated keyword: below, some are those of several keywords that are read here.
const MIN_ABBREVIATION: usize = 4;

/// Line that is no comment, of a keyword together with those by which it goes on.
#[derive(Debug)]
pub(crate) enum InpLine<'a> {
    Keyword(Keyword<'a>),
    Data(Line<'a>),
}

/// Lines of an Abaqus input file without its comments and blank lines.
#[derive(Clone, Debug)]
pub(crate) struct InpLines<'a> {
    lines: Lines<'a>,
}

/// Keyword with its parameters.
#[derive(Debug)]
pub(crate) struct Keyword<'a> {
    /// First line.
    pub(crate) line: Line<'a>,
    /// Keyword in upper case without blanks.
    pub(crate) name: String,
    /// Parameters in upper case without blanks, with their values, empty where they have none.
    parameters: Vec<[String; 2]>,
}

impl<'a> InpLines<'a> {
    pub(crate) fn new(lines: Lines<'a>) -> Self {
        Self { lines }
    }

    /// Returns the lines that are not read yet.
    pub(crate) fn rest(&self) -> &Lines<'a> {
        &self.lines
    }

    /// Reads the lines by which a keyword goes on.
    fn keyword(&mut self, line: Line<'a>) -> Keyword<'a> {
        let mut text = line.text.trim_ascii().to_vec();
        while text.ends_with(b",") {
            let mut ahead = self.lines.clone();
            let Some(next) = next_content(&mut ahead) else { break };
            let next = next.text.trim_ascii();
            if !next[0].is_ascii_alphabetic() {
                break;
            }
            text.extend(next);
            self.lines = ahead;
        }
        Keyword::parse(line, &text)
    }
}

impl<'a> Iterator for InpLines<'a> {
    type Item = InpLine<'a>;

    fn next(&mut self) -> Option<InpLine<'a>> {
        let line = next_content(&mut self.lines)?;
        let is_keyword = line.text.trim_ascii_start().starts_with(b"*");
        Some(if is_keyword { InpLine::Keyword(self.keyword(line)) } else { InpLine::Data(line) })
    }
}

/// Returns the next line that is neither blank nor a comment.
fn next_content<'a>(lines: &mut Lines<'a>) -> Option<Line<'a>> {
    lines.find(|line| {
        let text = line.text.trim_ascii();
        !text.is_empty() && !text.starts_with(b"**")
    })
}

impl<'a> Keyword<'a> {
    /// Parses the text of a keyword, which begins with a star.
    fn parse(line: Line<'a>, text: &[u8]) -> Self {
        let in_latin_1 = || text.iter().copied().map(char::from).collect();
        let text = std::str::from_utf8(text).map_or_else(|_| in_latin_1(), str::to_owned);

        // Commas in quotation marks are of a value.
        let mut is_quoted = false;
        let mut fields = text.split(|character: char| {
            is_quoted ^= character == '"';
            character == ',' && !is_quoted
        });
        let name = fields.next().unwrap_or_default();
        let name = without_blanks(name.strip_prefix('*').unwrap_or(name)).to_ascii_uppercase();
        let parameters = fields.map(|field| field.split_once('=').unwrap_or((field, "")));
        let parameters = parameters
            .map(|(key, value)| [without_blanks(key).to_ascii_uppercase(), unquoted(value)]);
        Self { line, name, parameters: parameters.collect() }
    }

    /// Returns true if this is a keyword, in full or abbreviated.
    pub(crate) fn is(&self, full: &str) -> bool {
        self.name == full || (self.name.len() >= MIN_ABBREVIATION && full.starts_with(&self.name))
    }

    /// Returns true if this is one of some keywords.
    pub(crate) fn is_any(&self, keywords: &[&str]) -> bool {
        keywords.iter().any(|keyword| self.is(keyword))
    }

    /// Returns true if it has a parameter, with a value or without.
    pub(crate) fn has(&self, parameter: &str) -> bool {
        self.values(parameter).next().is_some()
    }

    /// Returns the value of a parameter, where it has one.
    pub(crate) fn value(&self, parameter: &str) -> Option<&str> {
        self.values(parameter).next().filter(|value| !value.is_empty())
    }

    /// Returns the values of a parameter, in full or abbreviated.
    fn values(&self, parameter: &str) -> impl Iterator<Item = &str> {
        let is_same = move |key: &str| !key.is_empty() && parameter.starts_with(key);
        let parameters = self.parameters.iter();
        parameters.filter(move |[key, _]| is_same(key)).map(|[_, value]| value.as_str())
    }
}

/// Returns the value of a parameter without its quotation marks, or else without blanks.
fn unquoted(value: &str) -> String {
    match value.trim().strip_prefix('"') {
        Some(quoted) => quoted.split('"').next().unwrap_or_default().to_owned(),
        None => without_blanks(value),
    }
}

fn without_blanks(text: &str) -> String {
    text.chars().filter(|character| !character.is_whitespace()).collect()
}

/// Returns the number in a field of a data line: exponents may be Fortran's, and a blank field is 0.
pub(crate) fn real(field: &[u8]) -> Option<f64> {
    if field.is_empty() {
        return Some(0.0);
    }
    match field.iter().position(|byte| byte.eq_ignore_ascii_case(&b'D')) {
        Some(exponent) => number(&[&field[..exponent], b"e", &field[exponent + 1..]].concat()),
        None => number(field),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keyword(text: &[u8]) -> Keyword<'_> {
        match InpLines::new(Lines::new(text)).next() {
            Some(InpLine::Keyword(keyword)) => keyword,
            other => panic!("no keyword: {other:?}"),
        }
    }

    #[test]
    fn names_are_read_from_keyword_lines() {
        for (line, expected) in [
            ("*Part, name=Femur", Some("Femur")),
            ("* PART , NAME = left femur ", Some("leftfemur")),
            ("*Part, name=\"left, femur = 2\"", Some("left, femur = 2")),
            ("*Instance, part=\"name=x\", name=\"a b\"", Some("a b")),
            ("*Instance, part=p, surname=x", None),
            ("*Part, name=", None),
            ("*Part, name=\"\"", None),
            ("*Part, name", None),
            ("*Part, =x", None),
            ("*Part, nam=x", Some("x")),
            ("*Part,\r\n** comment\n\n name=x,\n", Some("x")),
            ("*Part,\n1, name=x", None),
        ] {
            assert_eq!(keyword(line.as_bytes()).value("NAME"), expected, "{line}");
        }
        assert_eq!(keyword(b"*Part, name=F\xe9mur").value("NAME"), Some("F\u{e9}mur"));
    }

    #[test]
    fn keywords_may_be_abbreviated() {
        for (line, full, expected) in [
            ("*End part", "ENDPART", true),
            ("*elem, type=S3", "ELEMENT", true),
            ("*Elem ent", "ELEMENT", true),
            ("*Element Output", "ELEMENT", false),
            ("*El print", "ELEMENT", false),
            ("*Nod", "NODE", false),
            ("*", "NODE", false),
        ] {
            assert_eq!(keyword(line.as_bytes()).is(full), expected, "{line}");
        }
    }

    #[test]
    fn a_comma_ends_a_line_that_goes_on_or_not() {
        let text =
            b"*Instance, name=a,\n part=b,\n\n1., 2., 3.\n*Node,\n1, 0., 0., 0.\n*Element,\n\
            *Node\n*Part,";
        let lines = InpLines::new(Lines::new(text)).map(|line| match line {
            InpLine::Keyword(keyword) => (keyword.line.number, keyword.name),
            InpLine::Data(line) => (line.number, String::new()),
        });
        let expected = [
            (1, "INSTANCE"),
            (4, ""),
            (5, "NODE"),
            (6, ""),
            (7, "ELEMENT"),
            (8, "NODE"),
            (9, "PART"),
        ];
        let expected = expected.map(|(number, name)| (number, name.to_owned()));
        assert_eq!(lines.collect::<Vec<_>>(), expected);
    }
}
