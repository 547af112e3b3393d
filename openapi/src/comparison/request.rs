//! What one asks of a comparison.

use super::spec::{self, Scenario};
use crate::body;
use crate::check::{Check, Validate};
use crate::checked::Checked;
use crate::problem::{Problems, reason};
use crate::robot::MAX_INTEGER;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// What is asked of a comparison. Everything may be left out.
///
/// ```
/// use umwelt_api::comparison::Request;
/// let request = Request::read(br#"{"methods": ["statistic", "bayesian/20"], "trials": 100}"#)?;
/// assert_eq!(request.trials, Some(100));
///
/// let problems = Request::read(br#"{"trials": 1, "seeds": 7, "methods": []}"#).unwrap_err();
/// let fields: Vec<_> = problems.details().iter().map(|detail| detail.field.as_str()).collect();
/// assert_eq!(fields, ["seeds", "methods", "trials"]);
/// # Ok::<(), umwelt_api::Problems>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = ComparisonRequest)]
pub struct Request {
    /// What is driven, and in which environments; null for `thesis`.
    pub scenario: Option<Scenario>,
    /// Who is compared, each once: a method such as `bayesian` for all its numbers of slots, or one of them as
    /// `bayesian/20`; null for all. What is wrong with one is told with the names that there are.
    pub methods: Option<Vec<String>>,
    /// Trials of each contender in each environment; null for 1000. Contenders, environments and trials multiply to at
    /// most 200 000 episodes.
    pub trials: Option<u64>,
    /// Of everything random: the same seed gives the same report; null for 1.
    pub seed: Option<u64>,
    /// The name of the prior of the contender `bayesian`, one of `GET /v1/priors`; null or `thesis` for the thesis's,
    /// evolved with as many slots (`thesis`, `thesis-20`).
    pub prior: Option<String>,
}

impl Validate for Request {
    /// What is left out is in range. Which methods and priors there are is asked elsewhere: others may know more.
    fn check(&self, check: &mut Check) {
        let methods = self.methods.as_deref();
        let count = methods.map_or(*spec::METHODS.start(), <[String]>::len);
        check.length("methods", count, spec::METHODS);
        let methods = methods.unwrap_or_default();
        check.each_once("methods");
        for (index, method) in methods.iter().enumerate() {
            check.one_of(&format!("methods[{index}]"), &spec::KNOWN_METHODS);
            if methods[..index].contains(method) {
                let field = format!("methods[{index}]");
                check.report(reason::REPEATED, &field, method.as_str(), "name it once");
            }
        }
        for (name, value, range) in
            [("trials", self.trials, spec::TRIALS), ("seed", self.seed, 0..=MAX_INTEGER)]
        {
            check.integer(name, value.unwrap_or(*range.start()), range);
        }
        if let Some(prior) = &self.prior {
            check.id("prior", prior);
        }
    }
}

impl Request {
    /// Reads the body of a POST; which methods and priors there are is not asked.
    ///
    /// # Errors
    /// Every problem of it: unknown fields, values out of range, methods that stand twice.
    pub fn read(json: &[u8]) -> Result<Checked<Self>, Problems> {
        body::read_shared(json)
    }

    /// The name of the prior of the contender `bayesian`, where that is compared.
    pub fn prior_name(&self) -> &str {
        self.prior.as_deref().unwrap_or(spec::DEFAULT_PRIOR)
    }
}
