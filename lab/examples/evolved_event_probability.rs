//! The experiment from which the thesis starts (its eq. 1-2): a Beta prior for the late-packet rate evolves, and
//! predicts fresh links better than samples alone.
//!
//! `cargo run --release -p umwelt-lab --example evolved_event_probability`

#![allow(clippy::print_stdout, reason = "an example prints")]

use umwelt_core::conjugate::{BetaBernoulli, ConjugateError};
use umwelt_lab::evolution::event_probability::Experiment;

fn main() -> Result<(), ConjugateError> {
    println!(
        "Links whose late-packet rates are drawn from Beta(2, 38), 5 % in the mean; 100 individuals, 60 generations."
    );
    println!("Root mean squared error of the predicted rate over 20 000 fresh links:\n");
    println!(
        "| packets seen | samples alone | uniform prior | evolved prior | nature's prior | evolved alpha, beta |"
    );
    println!("|--:|--:|--:|--:|--:|---|");
    for packets in [1, 5, 10, 20, 45, 100] {
        let experiment = Experiment {
            nature: BetaBernoulli::new(2.0, 38.0)?,
            links: 100,
            packets,
            population: 100,
            generations: 60,
            seed: 1,
        };
        let evolved = experiment.evolve(|_, _| {});
        let errors = experiment.errors(&evolved, 20_000);
        let [samples, uniform, of_evolved, nature] =
            [errors.samples, errors.uniform, errors.evolved, errors.nature].map(f64::sqrt);
        println!(
            "| {packets} | {samples:.4} | {uniform:.4} | {of_evolved:.4} | {nature:.4} | {:.2}, {:.1} |",
            evolved.alpha(),
            evolved.beta()
        );
    }
    Ok(())
}
