//! Where the server is.

use crate::error::Error;
use reqwest::Url;

/// The address of a server: `http://host:port`, perhaps with a path in front of `/v1`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Address(Url);

impl Address {
    /// Reads an address.
    ///
    /// # Errors
    /// Where it is none, or of a scheme that this client does not speak.
    pub(crate) fn read(text: &str) -> Result<Self, Error> {
        // What stands before an @ may be a secret.
        let shown = text.rsplit_once('@').map_or(text, |(_, rest)| rest);
        let refused = |why: &str| Error::BadCall {
            what: format!("using {shown} as server").into(),
            why: format!("{why}; use an address like http://127.0.0.1:8080"),
        };
        let url = Url::parse(text).map_err(|error| refused(&error.to_string()))?;
        match url.scheme() {
            "http" => {}
            "https" => {
                return Err(refused("this client has no TLS of its own, put a tunnel in front"));
            }
            _ => return Err(refused("it does not begin with http://")),
        }
        if !url.username().is_empty() || url.password().is_some() {
            return Err(refused(
                "it has a name or a password, a token goes into --token-file FILE",
            ));
        }
        if url.query().is_some() || url.fragment().is_some() {
            return Err(refused("it has a query or a fragment"));
        }
        Ok(Self(url))
    }

    /// The URL of a resource, by the parts of its path.
    pub(crate) fn at(&self, path: &[&str]) -> Url {
        let mut url = self.0.clone();
        // An http URL always has a path.
        if let Ok(mut segments) = url.path_segments_mut() {
            segments.pop_if_empty().extend(path);
        }
        url
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resources_stand_below_the_address() {
        for (address, url) in [
            ("http://h:1", "http://h:1/v1/robots/a"),
            ("http://h:1/", "http://h:1/v1/robots/a"),
            ("http://[::1]:1/lab", "http://[::1]:1/lab/v1/robots/a"),
            ("http://h/lab/", "http://h/lab/v1/robots/a"),
        ] {
            let address = Address::read(address).unwrap();
            assert_eq!(address.at(&["v1", "robots", "a"]).as_str(), url);
        }
    }

    #[test]
    fn what_is_no_address_is_refused_with_an_example() {
        for text in [
            "",
            "127.0.0.1:8080",
            "localhost:8080",
            "ftp://h",
            "https://h",
            "http://",
            "http://h/?a=b",
            "http://hunter2@h",
            "http://:hunter2@h",
            "http://a:hunter2@h/lab",
            "https://a:hunter2@h",
            "http://a:hunter2@",
        ] {
            let error = Address::read(text).unwrap_err();
            assert!(matches!(error, Error::BadCall { .. }));
            assert!(!error.to_string().contains("hunter2"), "{error}");
            assert!(
                error.to_string().ends_with("use an address like http://127.0.0.1:8080"),
                "{error}"
            );
        }
    }
}
