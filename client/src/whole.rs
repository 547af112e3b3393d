//! Whole lists: all pages of one, and what of it cannot be read, asked for once.

use crate::client::Client;
use crate::error::Error;
use futures_util::stream::TryStreamExt;
use serde::de::DeserializeOwned;
use umwelt_api::job::{JobKind, JobPage};
use umwelt_api::page::{MAX_PAGE_SIZE, PageQuery};
use umwelt_api::{prior, robot, training};

/// A page of a list, which takes in the pages behind it.
pub trait List: DeserializeOwned + Default + Send + 'static {
    /// Where the list is, below `/v1`.
    const PATH: &'static str;

    /// Items of a page that is asked for.
    const PAGE_SIZE: u64 = MAX_PAGE_SIZE;

    /// Where the next page begins.
    fn next_page_token(&mut self) -> &mut Option<String>;

    /// Takes in what the next page has.
    fn append(&mut self, next: Self);
}

impl Client {
    /// The whole of a list, or what of it is in one state. What the server cannot read is in it, where no state is asked
    /// for.
    ///
    /// # Errors
    /// Whatever [`Error`] tells.
    pub async fn whole<L: List>(&self, state: Option<&str>) -> Result<L, Error> {
        let (page_size, state) = (Some(L::PAGE_SIZE), state.map(str::to_owned));
        let query = PageQuery { page_size, page_token: None, state };
        let split = |mut page: L| {
            let next = page.next_page_token().take();
            (vec![page], next)
        };
        let pages = self.all(self.at(&["v1", L::PATH]), query, String::as_str, split);
        let append = async |mut whole: L, page| {
            whole.append(page);
            Ok(whole)
        };
        pages.try_fold(L::default(), append).await
    }
}

impl<K: JobKind> List for JobPage<K> {
    const PATH: &'static str = K::LIST;
    const PAGE_SIZE: u64 = K::PAGE_SIZE;

    fn next_page_token(&mut self) -> &mut Option<String> {
        &mut self.next_page_token
    }

    fn append(&mut self, next: Self) {
        self.jobs.extend(next.jobs);
        self.unreadable.extend(next.unreadable);
    }
}

impl List for robot::Page {
    const PATH: &'static str = "robots";
    const PAGE_SIZE: u64 = robot::MAX_PAGE_SIZE;

    fn next_page_token(&mut self) -> &mut Option<String> {
        &mut self.next_page_token
    }

    fn append(&mut self, next: Self) {
        self.robots.extend(next.robots);
        self.unreadable.extend(next.unreadable);
    }
}

impl List for prior::Page {
    const PATH: &'static str = "priors";

    fn next_page_token(&mut self) -> &mut Option<String> {
        &mut self.next_page_token
    }

    fn append(&mut self, next: Self) {
        self.priors.extend(next.priors);
        self.unreadable.extend(next.unreadable);
    }
}

impl List for training::Page {
    const PATH: &'static str = "environments";
    const PAGE_SIZE: u64 = training::MAX_PAGE_SIZE;

    fn next_page_token(&mut self) -> &mut Option<String> {
        &mut self.next_page_token
    }

    fn append(&mut self, next: Self) {
        self.environments.extend(next.environments);
        self.unreadable.extend(next.unreadable);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_server::{Server, json};
    use hyper::StatusCode;

    /// Guards against a list that is asked for twice, once for its items and once for what cannot be read.
    #[tokio::test]
    async fn a_whole_list_asks_each_page_once() {
        let server = Server::start(|request| async move {
            let unreadable = |name| {
                format!(r#"[{{"name": "{name}", "written_by": null, "why": "w", "remedy": "r"}}]"#)
            };
            let page = match request.uri().query() {
                Some("page_size=500&state=s") => {
                    format!(
                        r#"{{"priors": [], "unreadable": {}, "next_page_token": "t"}}"#,
                        unreadable("a")
                    )
                }
                Some("page_size=500&page_token=t&state=s") => {
                    format!(
                        r#"{{"priors": [], "unreadable": {}, "next_page_token": null}}"#,
                        unreadable("b")
                    )
                }
                other => panic!("{other:?} is asked for"),
            };
            json(StatusCode::OK, &page)
        })
        .await;
        let client = Client::new(&server.url).unwrap();
        let whole: prior::Page = client.whole(Some("s")).await.unwrap();
        let names: Vec<_> = whole.unreadable.iter().map(|it| it.name.as_str()).collect();
        assert_eq!((names, whole.next_page_token), (vec!["a", "b"], None));
        assert_eq!(server.requests(), 2);
    }
}
