//! A page of Markdown, as far as links, headings, tables and code blocks go.

use std::collections::{BTreeMap, BTreeSet};

/// A block of code.
pub struct Fence {
    /// What stands behind the opening mark.
    pub language: String,
    pub text: String,
}

/// What is read of a page.
#[derive(Default)]
pub struct Page {
    /// Targets of links and pictures, code left out.
    pub links: Vec<String>,
    /// Anchors of the headings, as the web shows them.
    pub anchors: BTreeSet<String>,
    pub fences: Vec<Fence>,
    /// What stands between backticks.
    pub code: Vec<String>,
    /// The first cell of each row of a table.
    pub first_cells: Vec<String>,
}

impl Page {
    pub fn new(text: &str) -> Self {
        let (mut page, mut headings) = (Self::default(), BTreeMap::new());
        let mut open: Option<Fence> = None;
        for line in text.lines() {
            if let Some(language) = line.trim_start().strip_prefix("```") {
                match open.take() {
                    Some(fence) => page.fences.push(fence),
                    None => {
                        let language = language.trim().to_owned();
                        open = Some(Fence { language, text: String::new() });
                    }
                }
            } else if let Some(fence) = &mut open {
                fence.text.push_str(line);
                fence.text.push('\n');
            } else if !line.starts_with("    ") {
                page.line(line, &mut headings);
            }
        }
        assert!(open.is_none(), "a block of code does not end: {text:.80}");
        page
    }

    fn line(&mut self, line: &str, headings: &mut BTreeMap<String, usize>) {
        let heading = line.trim_start_matches('#');
        if heading.len() < line.len() && heading.starts_with(' ') {
            let anchor = anchor(heading.trim());
            let seen = headings.entry(anchor.clone()).or_default();
            self.anchors.insert(match *seen {
                0 => anchor,
                again => format!("{anchor}-{again}"),
            });
            *seen += 1;
        }
        if let Some(row) = line.strip_prefix('|') {
            self.first_cells.push(row.split('|').next().unwrap_or_default().trim().to_owned());
        }
        let (text, code): (Vec<_>, Vec<_>) =
            line.split('`').enumerate().partition(|(place, _)| place % 2 == 0);
        self.code.extend(code.into_iter().map(|(_, code)| code.to_owned()));
        self.links.extend(links(&text.into_iter().map(|(_, text)| text).collect::<String>()));
    }
}

/// The targets of `[text](target)`, of pictures too, and of `src="target"`.
fn links(line: &str) -> Vec<String> {
    let inline = line.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    let inline = inline.filter_map(|(target, _)| target.split_whitespace().next());
    let pictures = line.split("src=\"").skip(1).filter_map(|rest| rest.split_once('"'));
    inline.chain(pictures.map(|(target, _)| target)).map(str::to_owned).collect()
}

/// The anchor of a heading: small letters, digits, hyphens and underscores; a hyphen for each space.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter_map(|letter| match letter {
        ' ' => Some('-'),
        '-' | '_' => Some(letter),
        letter if letter.is_alphanumeric() => Some(letter),
        _ => None,
    });
    kept.flat_map(char::to_lowercase).collect()
}

#[test]
fn what_a_page_has() {
    let text = "# `PUT /v1`: a, b\n[one](a.md#x) `[no](b.md)` ![p](c.svg \"t\")\n```sh\n[no](d.md)\n```\n\
        | eq. 1 | [two](e.md) |\n# A\n# A\n";
    let page = Page::new(text);
    assert_eq!(page.links, ["a.md#x", "c.svg", "e.md"]);
    assert_eq!(
        page.anchors.iter().map(String::as_str).collect::<Vec<_>>(),
        ["a", "a-1", "put-v1-a-b"]
    );
    assert_eq!(page.code, ["PUT /v1", "[no](b.md)"]);
    assert_eq!((page.fences.len(), page.fences[0].language.as_str()), (1, "sh"));
    assert_eq!(page.first_cells, ["eq. 1"]);
}
