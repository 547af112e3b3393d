//! The secret that a request must carry, and the file that holds it.

use crate::resource::failure::Failure;
use axum::http::{HeaderMap, header};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use umwelt_api::problem::{Detail, Status, reason};
use umwelt_api::{MAX_TOKEN, Token};

/// Most bytes of a file that are read: a token and white space around it.
const MAX_FILE: u64 = 4 * MAX_TOKEN as u64;

/// Reads the token in `file`, and warns in the log where everybody on this machine can read it too.
///
/// # Errors
/// What is wrong with the file, without what it holds.
pub fn read_token(file: &Path) -> Result<Token, String> {
    let wrong = |why: &dyn std::fmt::Display| {
        format!(
            "the token file {}: {why}; head -c 32 /dev/urandom | base64 makes one",
            file.display()
        )
    };
    let mut text = String::new();
    let opened = File::open(file).map_err(|error| wrong(&error))?;
    if is_open_to_others(&opened) {
        tracing::warn!(file = %file.display(), "everybody on this machine can read the token: chmod 600");
    }
    opened.take(MAX_FILE).read_to_string(&mut text).map_err(|error| wrong(&error))?;
    text.parse().map_err(|error| wrong(&error))
}

#[cfg(unix)]
fn is_open_to_others(file: &File) -> bool {
    use std::os::unix::fs::PermissionsExt;
    /// Any permission for those who are neither the owner nor in the group.
    const OTHERS: u32 = 0o007;
    file.metadata().is_ok_and(|metadata| metadata.permissions().mode() & OTHERS != 0)
}

#[cfg(not(unix))]
fn is_open_to_others(_: &File) -> bool {
    false
}

/// Lets through who presents the token, once, as `Authorization: Bearer`.
///
/// # Errors
/// UNAUTHENTICATED.
pub(super) fn check(token: &Token, headers: &HeaderMap) -> Result<(), Failure> {
    let mut given = headers.get_all(header::AUTHORIZATION).iter();
    let (first, more) = (given.next(), given.next());
    let bearer = first.filter(|_| more.is_none()).and_then(|value| bearer(value.as_bytes()));
    match bearer {
        Some(presented) if token.is(presented) => Ok(()),
        Some(_) => Err(refused(reason::TOKEN_WRONG, "this is not the token of this server")),
        None => Err(refused(reason::TOKEN_MISSING, "this server wants a token")),
    }
}

/// What stands behind `Bearer`; the scheme is no matter of case.
fn bearer(value: &[u8]) -> Option<&[u8]> {
    const SCHEME: &[u8] = b"bearer ";
    let (scheme, rest) = value.split_at_checked(SCHEME.len())?;
    scheme.eq_ignore_ascii_case(SCHEME).then(|| rest.trim_ascii())
}

/// The value stays unsaid: it may be a secret of another server.
fn refused(reason: &str, message: &str) -> Failure {
    let remedy = "send Authorization: Bearer and the server's token; umwelt and umwelt-agent take it by --token-file FILE \
                  or UMWELT_TOKEN_FILE";
    Failure::new(Status::Unauthenticated, message).with(Detail::new(
        reason,
        "Authorization",
        (),
        remedy,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::response::IntoResponse;

    const SECRET: &str = "0123456789abcdef";

    fn said(values: &[&str]) -> Result<(), u16> {
        let mut headers = HeaderMap::new();
        for value in values {
            headers.append(header::AUTHORIZATION, value.parse().unwrap());
        }
        check(&SECRET.parse().unwrap(), &headers)
            .map_err(|failure| failure.into_response().status().as_u16())
    }

    #[test]
    fn the_token_is_presented_once_as_bearer() {
        for good in
            ["Bearer 0123456789abcdef", "bearer 0123456789abcdef", "BEARER   0123456789abcdef"]
        {
            assert_eq!(said(&[good]), Ok(()), "{good}");
        }
        for wrong in [
            "Bearer 0123456789abcdeF",
            "Bearer 0123456789abcde",
            "Bearer 0123456789abcdef0",
            "Bearer 0123456789abcdef, Bearer 0123456789abcdef",
            "Bearer ",
            "Bearer",
            "Basic 0123456789abcdef",
            "0123456789abcdef",
            "",
        ] {
            assert_eq!(said(&[wrong]), Err(401), "{wrong}");
        }
        assert_eq!(said(&[]), Err(401));
        assert_eq!(said(&["Bearer 0123456789abcdef", "Bearer 0123456789abcdef"]), Err(401));
    }

    #[test]
    fn a_file_holds_one_token_and_what_it_holds_is_never_repeated() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("token");
        let read = |text: &[u8]| {
            std::fs::write(&file, text).unwrap();
            read_token(&file)
        };
        assert_eq!(read(b"  0123456789abcdef\r\n"), Ok(SECRET.parse().unwrap()));
        for wrong in
            [&b""[..], b"hunter2", b"hunter2 is no token at all", b"hunter2\xff", &[b'h'; 5000]]
        {
            let said = read(wrong).unwrap_err();
            assert!(!said.contains("hunter2") && said.contains("token"), "{said}");
        }
        std::fs::remove_file(&file).unwrap();
        assert!(read_token(&file).unwrap_err().contains("No such file"));
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_everybody_can_read_is_noticed() {
        use std::os::unix::fs::PermissionsExt;
        let file = tempfile::NamedTempFile::new().unwrap();
        for (mode, is_open) in [(0o600, false), (0o640, false), (0o644, true), (0o602, true)] {
            file.as_file().set_permissions(std::fs::Permissions::from_mode(mode)).unwrap();
            assert_eq!(is_open_to_others(file.as_file()), is_open, "{mode:o}");
        }
    }
}
