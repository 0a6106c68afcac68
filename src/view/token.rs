//! The token that every request must carry.

use std::fmt::Write;

/// A secret of this run of the program: 256 random bits of the system, in hexadecimal.
pub(super) struct Token(String);

impl Token {
    /// A new token.
    ///
    /// # Errors
    /// If the system has no random numbers.
    pub fn random() -> Result<Token, getrandom::Error> {
        let mut bytes = [0; 32];
        getrandom::fill(&mut bytes)?;
        Ok(Token(hexadecimal(&bytes)))
    }

    /// The token as it appears in an address.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Whether `given` is the token. The time does not depend on the position of the first
    /// difference.
    pub fn is(&self, given: &str) -> bool {
        let differ = self.0.bytes().zip(given.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
        given.len() == self.0.len() && differ == 0
    }
}

/// A random word that allows the scripts and styles of one page, and no others.
///
/// # Errors
/// As [`Token::random`].
pub(super) fn nonce() -> Result<String, getrandom::Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)?;
    Ok(hexadecimal(&bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, b| {
        let _ = write!(text, "{b:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_itself_and_no_other() {
        let (one, other) = (Token::random().unwrap(), Token::random().unwrap());
        assert_eq!(one.text().len(), 64);
        assert!(one.is(one.text()));
        for wrong in ["", other.text(), &one.text()[1..], &format!("{}0", one.text())] {
            assert!(!one.is(wrong), "{wrong}");
        }
    }
}
