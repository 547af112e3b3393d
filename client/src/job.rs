//! What evolutions and comparisons have in common: they are created under a key, and what they show is text.

use crate::call::Call;
use crate::client::Client;
use crate::error::Error;
use reqwest::{Method, Url};
use serde::Serialize;
use serde::de::DeserializeOwned;
use tower::util::rng::{HasherRng, Rng};
use umwelt_api::IdempotencyKey;

/// An idempotency key that nobody else has: 128 random bits.
///
/// # Panics
/// Never: hexadecimal digits are a key.
pub fn fresh_key() -> IdempotencyKey {
    let mut random = HasherRng::new();
    let key = format!("{:016x}{:016x}", random.next_u64(), random.next_u64());
    key.parse().expect("hexadecimal digits are visible ASCII")
}

impl Client {
    /// Creates what `request` asks for, once for each `key`; without one a [`fresh_key`] is taken.
    pub(crate) async fn create<T: DeserializeOwned>(
        &self,
        url: Url,
        request: &impl Serialize,
        key: Option<&IdempotencyKey>,
    ) -> Result<T, Error> {
        let call = self.call(Method::POST, url).with_json(request)?;
        let idempotency_key = Some(key.cloned().unwrap_or_else(fresh_key));
        self.typed(Call { idempotency_key, ..call }).await
    }

    /// The text at `url`. One that `is_right` does not take for what was asked is refused as no `kind`.
    pub(crate) async fn text(
        &self,
        url: Url,
        accept: &'static str,
        kind: &str,
        is_right: impl Fn(&str) -> bool,
    ) -> Result<String, Error> {
        let call = Call { accept, ..self.call(Method::GET, url) };
        let what = call.what.clone();
        let bytes = self.bytes(call).await?;
        let text = std::str::from_utf8(&bytes).ok().filter(|text| is_right(text));
        text.map(str::to_owned).ok_or_else(|| Error::Protocol {
            what: what.as_ref().into(),
            why: format!("the answer is no {kind}"),
        })
    }

    /// The figure at `url`, as SVG.
    pub(crate) async fn svg(&self, url: Url) -> Result<String, Error> {
        self.text(url, "image/svg+xml", "SVG", |text| text.contains("<svg")).await
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use umwelt_api::{comparison, evolution};

    #[test]
    fn fresh_keys_are_all_different() {
        let keys: BTreeSet<_> = (0..1000).map(|_| fresh_key()).collect();
        assert_eq!(keys.len(), 1000);
    }

    #[test]
    fn every_figure_is_svg() {
        assert_eq!(evolution::Figure::MEDIA_TYPE, "image/svg+xml");
        assert_eq!(comparison::Figure::MEDIA_TYPE, "image/svg+xml");
    }
}
