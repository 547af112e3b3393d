use super::*;
use crate::comparison::ComparisonSettings;
use umwelt_core::controller::Controller;
use umwelt_core::controller::compensation::{
    Compensation, DelayModel, PathFollower, PoseEstimator,
};
use umwelt_core::episode::{Outcome, Scenario};

/// The thesis's trip over its normal link.
fn scenario(settings: impl Fn(&Settings) -> Settings, slots: usize) -> Scenario {
    let thesis = ComparisonSettings::scenario("thesis").unwrap();
    let environment = &thesis.environments[0];
    Scenario {
        settings: Settings { slots, ..settings(&thesis.controller) },
        plant: environment.plant,
        link: environment.link.clone(),
        task: thesis.task,
        start: thesis.start,
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: 240.0,
    }
}

/// Drives a few seeds, each twice.
fn drive<E: PoseEstimator, D: DelayModel, F: PathFollower>(
    scenario: &Scenario,
    peer: impl Fn(&Settings) -> Compensation<E, D, F>,
) -> Vec<Outcome> {
    let run = |seed| {
        let controller = Controller::with(scenario.settings, peer(&scenario.settings));
        scenario.drive(controller, seed, |_, _| {}).unwrap().0
    };
    let outcomes: Vec<_> = (0..3).map(run).collect();
    let again: Vec<_> = (0..3).map(run).collect();
    assert_eq!(outcomes, again);
    outcomes
}

fn all_arrive(outcomes: &[Outcome], deviation: f64) {
    for outcome in outcomes {
        assert!(outcome.arrived && outcome.max_deviation < deviation, "{outcome:?}");
    }
}

#[test]
fn the_filter_arrives() {
    let peer = EkfTuning::default();
    let scenario = scenario(|settings| peer.settings(settings), EkfPacket::SLOTS);
    all_arrive(&drive(&scenario, |settings| peer.compensation(settings)), 0.015);
}

#[test]
fn sliding_mode_arrives() {
    let peer = SlidingTuning::default();
    let scenario = scenario(|settings| peer.settings(settings), 1);
    all_arrive(&drive(&scenario, |settings| peer.compensation(settings)), 0.015);
}

#[test]
fn the_gaussian_process_arrives() {
    let peer = GpMpcTuning::default();
    let scenario = scenario(|settings| peer.settings(settings), 1);
    all_arrive(&drive(&scenario, |settings| peer.compensation(settings)), 0.015);
}

#[test]
fn those_who_do_not_predict_or_do_not_wait_arrive_too() {
    let stale = StaleTuning::default();
    let stops = scenario(|settings| stale.settings(settings), 1);
    all_arrive(&drive(&stops, |_| stale.compensation()), 0.03);
    let naive = scenario(without_identification, 1);
    all_arrive(&drive(&naive, |_| NoCompensation::compensation()), 0.05);
}
