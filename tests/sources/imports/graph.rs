//! Which file names what of which other, and what is wrong with that: circles and arrows upward.

use std::collections::{BTreeMap, BTreeSet};

/// Who names what of whom: from a file to a file, with the names.
#[derive(Debug, Default)]
pub struct Graph {
    edges: BTreeMap<(String, String), BTreeSet<String>>,
}

impl Graph {
    /// `from` names `name`, which `to` defines. What a file names of itself is no edge.
    pub fn add(&mut self, from: &str, to: &str, name: &str) {
        if from != to {
            let edge = (from.to_owned(), to.to_owned());
            self.edges.entry(edge).or_default().insert(name.to_owned());
        }
    }

    /// Takes in all edges of `other`.
    pub fn merge(&mut self, other: Self) {
        for (edge, names) in other.edges {
            self.edges.entry(edge).or_default().extend(names);
        }
    }

    /// How many edges there are.
    pub fn len(&self) -> usize {
        self.edges.len()
    }

    /// Every edge with the names that it stands for.
    pub fn edges(&self) -> impl Iterator<Item = (&str, &str, &BTreeSet<String>)> {
        self.edges.iter().map(|((from, to), names)| (from.as_str(), to.as_str(), names))
    }

    /// The files that reach each other, by groups of two and more: the strongly connected components.
    pub fn circles(&self) -> Vec<Vec<&str>> {
        let mut next: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for (from, to, _) in self.edges() {
            next.entry(from).or_default().push(to);
            next.entry(to).or_default();
        }
        let reached: BTreeMap<&str, BTreeSet<&str>> =
            next.keys().map(|&file| (file, reached_from(file, &next))).collect();
        let mut grouped = BTreeSet::new();
        let mut circles = Vec::new();
        for (&file, there) in &reached {
            let circle: Vec<&str> =
                there.iter().copied().filter(|other| reached[other].contains(file)).collect();
            if circle.len() > 1 && grouped.insert(circle[0]) {
                circles.push(circle);
            }
        }
        circles
    }

    /// The edges between the files of one circle, one line each: what to look at.
    pub fn between(&self, circle: &[&str]) -> String {
        let inside =
            self.edges().filter(|(from, to, _)| circle.contains(from) && circle.contains(to));
        inside.map(|(from, to, names)| line(from, to, names)).collect()
    }
}

/// One edge as a line of a report.
pub fn line(from: &str, to: &str, names: &BTreeSet<String>) -> String {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    format!("    {from} -> {to}: {}\n", names.join(", "))
}

/// The files that `file` reaches by one edge or more.
fn reached_from<'a>(file: &'a str, next: &BTreeMap<&'a str, Vec<&'a str>>) -> BTreeSet<&'a str> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![file]);
    while let Some(file) = open.pop() {
        open.extend(next[file].iter().filter(|&&to| reached.insert(to)));
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(edges: &[(&str, &str)]) -> Graph {
        let mut graph = Graph::default();
        for (from, to) in edges {
            graph.add(from, to, "x");
        }
        graph
    }

    #[test]
    fn a_tree_and_a_diamond_have_no_circle() {
        let diamond = graph(&[("a", "b"), ("a", "c"), ("b", "d"), ("c", "d"), ("d", "e")]);
        assert_eq!((diamond.circles(), diamond.len()), (Vec::<Vec<&str>>::new(), 5));
        assert!(graph(&[("a", "a")]).circles().is_empty(), "a file may name what is its own");
    }

    #[test]
    fn two_circles_that_do_not_touch_are_two_and_those_that_do_are_one() {
        let two = graph(&[("a", "b"), ("b", "a"), ("b", "c"), ("c", "d"), ("d", "e"), ("e", "c")]);
        assert_eq!(two.circles(), [vec!["a", "b"], vec!["c", "d", "e"]]);
        let one = graph(&[("a", "b"), ("b", "a"), ("b", "c"), ("c", "b"), ("x", "a")]);
        assert_eq!(one.circles(), [vec!["a", "b", "c"]]);
        assert_eq!(one.between(&["a", "b"]), "    a -> b: x\n    b -> a: x\n");
    }
}
