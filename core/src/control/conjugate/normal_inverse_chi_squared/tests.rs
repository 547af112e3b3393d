use super::*;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rv::data::DataOrSuffStat;
use rv::dist::{Gaussian, NormalInvChiSquared};
use rv::traits::ConjugatePrior;

fn golden_prior() -> NormalInverseChiSquared {
    NormalInverseChiSquared::new(0.0, 1.0, 2.0, 2.0).unwrap()
}

fn after(prior: NormalInverseChiSquared, data: &[f64]) -> NormalInverseChiSquared {
    data.iter().fold(prior, |belief, &x| belief.update(x))
}

fn oracle(belief: NormalInverseChiSquared) -> NormalInvChiSquared {
    NormalInvChiSquared::new(belief.mu, belief.k, belief.r, belief.s / belief.r).unwrap()
}

fn belief() -> impl Strategy<Value = NormalInverseChiSquared> {
    (-2.0..2.0f64, 0.1..20.0f64, 0.5..30.0f64, 0.01..20.0f64)
        .prop_map(|(mu, k, r, s)| NormalInverseChiSquared::new(mu, k, r, s).unwrap())
}

fn data() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-5.0..5.0f64, 1..30)
}

fn same(a: NormalInverseChiSquared, b: NormalInverseChiSquared) -> bool {
    [(a.mu, b.mu), (a.k, b.k), (a.r, b.r), (a.s, b.s)]
        .into_iter()
        .all(|(a, b)| (a - b).abs() <= 1e-8 * b.abs().max(1.0))
}

#[test]
fn the_golden_numbers() {
    let posterior = after(golden_prior(), &[1.0, 2.0, 4.0]);
    assert!((posterior.mu - 1.75).abs() < 1e-14);
    assert_eq!((posterior.k, posterior.r), (4.0, 5.0));
    assert!((posterior.s / posterior.r - 2.15).abs() < 1e-14);
    assert!((posterior.ln_predictive(0.7) - -1.699_487_784_434_09).abs() < 1e-13);
    assert!((golden_prior().ln_evidence(posterior) - -7.369_676_344_735_36).abs() < 1e-13);
}

#[test]
fn moments_are_those_of_the_formulas_and_exist_above_two_degrees_only() {
    let belief = NormalInverseChiSquared::new(0.0, 4.0, 5.0, 6.0).unwrap();
    assert_eq!(belief.expected_variance(), Some(2.0));
    assert_eq!(belief.mean_variance(), Some(0.5));
    assert_eq!(belief.predictive_sd(), Some(2.5_f64.sqrt()));
    assert_eq!(golden_prior().expected_variance(), None);
    assert_eq!(golden_prior().mean_variance(), None);
    assert_eq!(golden_prior().predictive_sd(), None);
}

#[test]
fn parameters_outside_the_domain_are_named() {
    let new = NormalInverseChiSquared::new;
    assert_eq!(new(f64::INFINITY, 1.0, 1.0, 1.0), Err(ConjugateError::MuNotFinite(f64::INFINITY)));
    assert_eq!(new(0.0, 0.0, 1.0, 1.0), Err(ConjugateError::KNotPositive(0.0)));
    assert_eq!(new(0.0, 1.0, -1.0, 1.0), Err(ConjugateError::RNotPositive(-1.0)));
    assert_eq!(new(0.0, 1.0, 1.0, 0.0), Err(ConjugateError::SNotPositive(0.0)));
    assert!(new(0.0, f64::NAN, 1.0, 1.0).is_err());
    let message = ConjugateError::KNotPositive(-2.5).to_string();
    assert_eq!(message, "k must be positive and finite, not -2.5");
}

#[test]
fn a_sample_that_cannot_have_been_seen_is_not_retracted() {
    let belief = NormalInverseChiSquared::new(0.0, 3.0, 4.0, 1.0).unwrap();
    assert!(matches!(belief.retract(10.0), Err(ConjugateError::SNotPositive(_))));
    let belief = NormalInverseChiSquared::new(0.0, 1.0, 4.0, 1.0).unwrap();
    assert_eq!(belief.retract(0.0), Err(ConjugateError::KNotPositive(0.0)));
    let belief = NormalInverseChiSquared::new(0.0, 3.0, 1.0, 1.0).unwrap();
    assert_eq!(belief.retract(0.0), Err(ConjugateError::RNotPositive(0.0)));
}

#[test]
fn deserialising_goes_through_the_check() {
    let text = serde_json::to_string(&golden_prior()).unwrap();
    assert_eq!(text, r#"{"mu":0.0,"k":1.0,"r":2.0,"s":2.0}"#);
    let back: NormalInverseChiSquared = serde_json::from_str(&text).unwrap();
    assert_eq!(back, golden_prior());
    let error =
        serde_json::from_str::<NormalInverseChiSquared>(r#"{"mu":0.0,"k":1.0,"r":2.0,"s":-2.0}"#);
    assert!(error.unwrap_err().to_string().contains("s must be positive"));
}

proptest! {
    #[test]
    fn the_posterior_is_that_of_the_sufficient_statistics(prior in belief(), data in data()) {
        // Thesis eq. 35-38, corrected: n samples at once.
        let n = data.len() as f64;
        let mean = data.iter().sum::<f64>() / n;
        let squares: f64 = data.iter().map(|x| (x - mean) * (x - mean)).sum();
        let k = prior.k + n;
        let at_once = NormalInverseChiSquared {
            mu: (prior.k * prior.mu + n * mean) / k,
            k,
            r: prior.r + n,
            s: prior.s + squares + prior.k * n / k * (prior.mu - mean) * (prior.mu - mean),
        };
        prop_assert!(same(after(prior, &data), at_once));
    }

    #[test]
    fn the_posterior_agrees_with_rv(prior in belief(), data in data()) {
        let stat = DataOrSuffStat::<f64, Gaussian>::Data(&data);
        let expected = oracle(prior).posterior(stat);
        let (mu, k, r, scale) = expected.params();
        let expected = NormalInverseChiSquared { mu, k, r, s: r * scale };
        prop_assert!(same(after(prior, &data), expected));
    }

    #[test]
    fn predictive_and_evidence_agree_with_rv(prior in belief(), data in data(), x in -9.0..9.0f64) {
        let stat = || DataOrSuffStat::<f64, Gaussian>::Data(&data);
        let posterior = after(prior, &data);
        let ln_predictive = oracle(prior).ln_pp(&x, stat());
        prop_assert!((posterior.ln_predictive(x) - ln_predictive).abs() < 1e-8);
        let ln_evidence = oracle(prior).ln_m(stat());
        prop_assert!((prior.ln_evidence(posterior) - ln_evidence).abs() < 1e-8);
    }

    #[test]
    fn many_samples_at_once_are_one_after_another(prior in belief(), data in data(), m in 0.1..3.0_f64) {
        let mut all = SampleStatistics::default();
        data.iter().for_each(|&x| all.add(x, m));
        let one_by_one = data.iter().fold(prior, |it, &x| it.update_weighted(x, m));
        let at_once = prior.update_all(&all);
        for (one, other) in [
            (one_by_one.mu(), at_once.mu()),
            (one_by_one.k(), at_once.k()),
            (one_by_one.r(), at_once.r()),
            (one_by_one.s(), at_once.s()),
        ] {
            prop_assert!((one - other).abs() <= 1e-9 * (1.0 + one.abs()), "{one} {other}");
        }
    }

    #[test]
    fn the_order_of_updates_does_not_matter(prior in belief(), data in data()) {
        let reversed: Vec<f64> = data.iter().rev().copied().collect();
        prop_assert!(same(after(prior, &data), after(prior, &reversed)));
    }

    #[test]
    fn the_weight_of_one_is_the_plain_update(prior in belief(), x in -5.0..5.0f64) {
        prop_assert_eq!(prior.update_weighted(x, 1.0), prior.update(x));
    }

    #[test]
    fn two_half_weights_move_the_mean_like_one_sample(prior in belief(), x in -5.0..5.0f64) {
        let (halves, whole) = (prior.update_weighted(x, 0.5).update_weighted(x, 0.5), prior.update(x));
        let expected = NormalInverseChiSquared { r: whole.r + 1.0, ..whole };
        prop_assert!(same(halves, expected));
    }

    #[test]
    fn retract_undoes_update(prior in belief(), x in -5.0..5.0f64, m in 0.05..2.0f64) {
        prop_assert!(same(prior.update(x).retract(x).unwrap(), prior));
        prop_assert!(same(prior.update_weighted(x, m).retract_weighted(x, m).unwrap(), prior));
    }

    #[test]
    fn the_predictive_integrates_to_one(prior in belief()) {
        // Even steps in asinh of the standardised place: the tails of half a degree of freedom are long.
        let (scale, end, steps) = (prior.predictive_scale_squared().sqrt(), 60.0, 8000);
        let width = 2.0 * end / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|step| -end + width * (f64::from(step) + 0.5))
            .map(|y| (prior.ln_predictive(prior.mu + scale * y.sinh())).exp() * scale * y.cosh() * width)
            .sum();
        prop_assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }

    #[test]
    fn the_evidence_is_the_product_of_predictives(prior in belief(), data in data()) {
        let (mut belief, mut naive) = (prior, 0.0);
        for &x in &data {
            naive += belief.ln_predictive(x);
            belief = belief.update(x);
        }
        prop_assert!((prior.ln_evidence(belief) - naive).abs() < 1e-8);
    }

    #[test]
    fn intervals_hold_their_level(prior in belief(), level in 0.1..0.99f64) {
        let (low, high) = prior.predictive_interval(level);
        // Naive: the midpoint rule over the density, even steps in asinh.
        let scale = prior.predictive_scale_squared().sqrt();
        let (end, steps) = (((high - prior.mu) / scale).asinh(), 20_000);
        let width = 2.0 * end / f64::from(steps);
        let mass: f64 = (0..steps)
            .map(|step| -end + width * (f64::from(step) + 0.5))
            .map(|y| (prior.ln_predictive(prior.mu + scale * y.sinh())).exp() * scale * y.cosh() * width)
            .sum();
        prop_assert!((mass - level).abs() < 1e-5, "{mass} {level}");
        prop_assert!((low + high - 2.0 * prior.mu).abs() < 1e-6 * (high - low));
        // The mean's interval is the predictive's, narrower by sqrt(k + 1).
        let (from, to) = prior.mean_interval(level);
        prop_assert!(((to - from) * (prior.k + 1.0).sqrt() / (high - low) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn moments_are_those_of_draws() {
    // 200 000 draws at r = 12: standard errors are about 0.2 % of E[sigma^2] and 0.4 % of Var(mean).
    let belief = NormalInverseChiSquared::new(0.5, 3.0, 12.0, 6.0).unwrap();
    let (mut rng, chi_squared) = (Pcg64Mcg::seed_from_u64(3), ChiSquared::new(12.0).unwrap());
    let (mut variances, mut squares, draws) = (0.0, 0.0, 200_000);
    for _ in 0..draws {
        let variance = belief.s / chi_squared.sample(&mut rng);
        let z: f64 = StandardNormal.sample(&mut rng);
        variances += variance;
        squares += z * z * variance / belief.k;
    }
    let (expected, of_mean) = (variances / f64::from(draws), squares / f64::from(draws));
    assert!((expected / belief.expected_variance().unwrap() - 1.0).abs() < 0.01);
    assert!((of_mean / belief.mean_variance().unwrap() - 1.0).abs() < 0.02);
}
