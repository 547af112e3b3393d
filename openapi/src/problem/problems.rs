//! Everything that is wrong with one request.

use super::detail::{Detail, MAX_DETAILS};
use super::reason;

/// Reasons of a request that the schemas allow: it is at odds with itself, with names that no one goes by now or that
/// others have, and so is no bad request but a conflict.
const CONFLICTS: [&str; 5] = [
    reason::INCONSISTENT,
    reason::UNKNOWN_PRIOR,
    reason::UNKNOWN_ENVIRONMENT,
    reason::BUILT_IN,
    reason::NAME_TAKEN,
];

/// Everything that is wrong with what was sent, never nothing where it is returned as an error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Problems {
    details: Vec<Detail>,
    count: usize,
    /// Whether a schema says no, rather than the rest of what was sent or of what there is.
    breaks_schema: bool,
}

impl Problems {
    /// The first [`MAX_DETAILS`] of them.
    pub fn details(&self) -> &[Detail] {
        &self.details
    }

    /// The same, for whoever goes on with them.
    pub(super) fn into_details(self) -> Vec<Detail> {
        self.details
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The HTTP status code to send: 400 where the schemas of the contract say no, 409 where they say yes and what was
    /// sent is at odds with itself or with the names that there are.
    pub fn http_status(&self) -> u16 {
        if self.breaks_schema { 400 } else { 409 }
    }

    pub(crate) fn add(&mut self, detail: Detail) {
        self.count += 1;
        self.breaks_schema |= !CONFLICTS.contains(&detail.reason.as_str());
        if self.details.len() < MAX_DETAILS {
            self.details.push(detail);
        }
    }
}

impl From<Detail> for Problems {
    fn from(detail: Detail) -> Self {
        let mut problems = Self::default();
        problems.add(detail);
        problems
    }
}

impl std::fmt::Display for Problems {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(first) = self.details.first() else { return f.write_str("no problem") };
        write!(f, "{}: {first}", first.reason)?;
        match self.count {
            0 | 1 => Ok(()),
            count => write!(f, " (and {} more)", count - 1),
        }
    }
}

impl std::error::Error for Problems {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Problem;
    use serde_json::Value;

    #[test]
    fn what_the_schemas_allow_is_a_conflict() {
        let of = |reasons: &[&str]| {
            let mut problems = Problems::default();
            reasons.iter().for_each(|it| problems.add(Detail::new(*it, "f", Value::Null, "r")));
            problems.http_status()
        };
        assert_eq!(of(&[reason::INCONSISTENT, reason::UNKNOWN_PRIOR]), 409);
        assert_eq!(of(&[reason::INCONSISTENT, reason::OUT_OF_RANGE]), 400);
        assert_eq!(Problems::from(Detail::new(reason::MALFORMED, "", 0, "r")).http_status(), 400);
        // Whatever the first hundred are.
        let mut many = vec![reason::INCONSISTENT; MAX_DETAILS];
        many.push(reason::NOT_FINITE);
        assert_eq!(of(&many), 400);
    }

    #[test]
    fn details_are_limited_and_the_message_counts_them_all() {
        let mut problems = Problems::default();
        for index in 0..250 {
            problems.add(Detail::new(reason::NOT_FINITE, format!("a[{index}]"), Value::Null, "r"));
        }
        let problem = Problem::from(problems);
        assert_eq!(problem.details.len(), MAX_DETAILS);
        assert!(problem.message.ends_with("(and 249 more)"));
    }
}
