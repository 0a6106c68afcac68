//! The path and the query of a request.

use std::collections::BTreeMap;

/// Path and query of a request: `/api/plot?log=a%20b.csv`.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Query {
    /// The path.
    pub path: String,
    /// The decoded pairs after the question mark; the last one counts if a name is repeated.
    pairs: BTreeMap<String, String>,
}

impl Query {
    pub fn of(url: &str) -> Query {
        let (path, query) = url.split_once('?').unwrap_or((url, ""));
        let pair = |pair: &str| {
            let (name, value) = pair.split_once('=').unwrap_or((pair, ""));
            (decoded(name), decoded(value))
        };
        let pairs = query.split('&').filter(|p| !p.is_empty()).map(pair).collect();
        Query { path: path.to_string(), pairs }
    }

    /// The value of a name; empty if absent.
    pub fn value(&self, name: &str) -> &str {
        self.pairs.get(name).map_or("", String::as_str)
    }
}

/// Decodes `%20` and `+` as blanks; an invalid code stays unchanged, invalid UTF-8 becomes a
/// replacement character.
fn decoded(text: &str) -> String {
    let (mut bytes, mut rest) = (Vec::new(), text.as_bytes());
    while let Some((first, more)) = rest.split_first() {
        let code = more.get(..2).and_then(|two| std::str::from_utf8(two).ok());
        let code = code.filter(|two| two.bytes().all(|b| b.is_ascii_hexdigit()));
        match (first, code.and_then(|two| u8::from_str_radix(two, 16).ok())) {
            (b'%', Some(byte)) => {
                bytes.push(byte);
                rest = &more[2..];
            }
            (b'+', _) => {
                bytes.push(b' ');
                rest = more;
            }
            (other, _) => {
                bytes.push(*other);
                rest = more;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_are_taken_apart_and_decoded() {
        let query = Query::of("/api/plot?log=r%C3%BCck+weg%201.csv&channel=u&&empty");
        assert_eq!(query.path, "/api/plot");
        assert_eq!((query.value("log"), query.value("channel")), ("rück weg 1.csv", "u"));
        assert_eq!((query.value("empty"), query.value("absent")), ("", ""));
        assert_eq!(Query::of("/?a=%zz%4").value("a"), "%zz%4");
    }
}
