//! The shared secret of a server and of all who may use it.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;
use subtle::ConstantTimeEq;

/// Shortest token in bytes: 16 random hexadecimal digits are 64 bits, out of reach for whoever guesses over a network.
pub const MIN_TOKEN: usize = 16;

/// Longest token in bytes: any hash fits, and the header of a request stays small.
pub const MAX_TOKEN: usize = 256;

/// A secret of 16 to 256 letters, digits and `-._~+/=`, the characters of a bearer token. It is never shown:
/// `Debug` hides it and there is no `Display`.
///
/// ```
/// use umwelt_api::Token;
/// let token: Token = " 5f2c0b7e9d1a4c38\n".parse().unwrap();
/// assert!(token.is(b"5f2c0b7e9d1a4c38") && !token.is(b"5f2c0b7e9d1a4c39"));
/// assert_eq!(format!("{token:?}"), "Token(..)");
/// ```
#[derive(Clone)]
pub struct Token(Arc<str>);

/// A text that is no token. It does not repeat the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidToken {
    /// Too short or too long, in bytes.
    #[error("a token has {MIN_TOKEN} to {MAX_TOKEN} characters, not {0}")]
    Length(usize),
    /// A character that a header cannot carry as part of a token.
    #[error("a token is one word of letters, digits and -._~+/=")]
    Character,
}

impl Token {
    /// Whether `presented` is this secret. How long it takes does not depend on where the two differ, only on
    /// whether they are of one length.
    pub fn is(&self, presented: &[u8]) -> bool {
        self.0.as_bytes().ct_eq(presented).into()
    }

    /// The secret, to be sent. Never log or print it.
    pub fn secret(&self) -> &str {
        &self.0
    }
}

impl FromStr for Token {
    type Err = InvalidToken;

    /// White space around it does not count: files end in a newline.
    fn from_str(text: &str) -> Result<Self, InvalidToken> {
        let text = text.trim();
        let is_allowed = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~+/=".contains(&byte);
        if !text.bytes().all(is_allowed) {
            return Err(InvalidToken::Character);
        }
        if !(MIN_TOKEN..=MAX_TOKEN).contains(&text.len()) {
            return Err(InvalidToken::Length(text.len()));
        }
        Ok(Self(text.into()))
    }
}

impl PartialEq for Token {
    fn eq(&self, other: &Self) -> bool {
        self.is(other.0.as_bytes())
    }
}

impl Eq for Token {}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(..)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECRET: &str = "abcDEF0189-._~+/=";

    #[test]
    fn a_token_is_one_word_of_a_header() {
        for good in [SECRET, " abcDEF0189-._~+/=\r\n", &"x".repeat(256)] {
            assert_eq!(good.parse::<Token>().unwrap().secret(), good.trim());
        }
        for bad in ["", " ", "short", &"x".repeat(257)] {
            let length = InvalidToken::Length(bad.trim().len());
            assert_eq!(bad.parse::<Token>(), Err(length), "{bad:?}");
        }
        for bad in [
            "two words of a token",
            "abcdefghijklmnop\nq",
            "abcdefghijklmnopä",
            "\"abcdefghijklmnop\"",
        ] {
            assert_eq!(bad.parse::<Token>(), Err(InvalidToken::Character), "{bad:?}");
        }
    }

    #[test]
    fn only_the_whole_secret_is_the_secret() {
        let token: Token = SECRET.parse().unwrap();
        assert!(token.is(SECRET.as_bytes()));
        for other in
            ["", "a", &SECRET[1..], &SECRET[..16], &format!("{SECRET}="), &SECRET.to_lowercase()]
        {
            assert!(!token.is(other.as_bytes()), "{other}");
        }
    }

    /// Guards against: the secret in a log, by way of a `Debug` of what holds it.
    #[test]
    fn nothing_shows_it() {
        let token: Token = SECRET.parse().unwrap();
        assert!(!format!("{token:?} {:#?}", Some(&token)).contains(SECRET));
        let wrong = format!("{SECRET} {SECRET}").parse::<Token>().unwrap_err();
        assert!(!format!("{wrong} {wrong:?}").contains(SECRET));
    }
}
