//! The laws of simulated environments.

use super::within;
use crate::evolution::{ENVIRONMENTS, Fitness, TrainingEnvironment};
use crate::wire::training::{built_in, environment};
use proptest::prelude::*;
use proptest::sample::select;
use umwelt_api::Checked;
use umwelt_api::training;
use umwelt_core::link::{
    LatePackets, LinkModel, Outage, PRESETS, Rtt, RttTrace, SENSOR_DELAY, Silences,
};
use umwelt_core::plant::{SLIP_PRESETS, Slip, SlipChannel};

fn slip() -> impl Strategy<Value = Slip> {
    let channel = || {
        (within(training::SLIP_MEAN), within(training::SLIP_SD))
            .prop_map(|(mean, sd)| SlipChannel::new(mean, sd).unwrap())
    };
    let preset = select(SLIP_PRESETS.to_vec()).prop_map(|name| Slip::preset(name).unwrap());
    let any = (channel(), channel(), channel(), channel())
        .prop_map(|(forward, lateral, turn, drift)| Slip { forward, lateral, turn, drift });
    prop_oneof![preset, any]
}

fn link() -> impl Strategy<Value = LinkModel> {
    let rtt = prop_oneof![
        within(training::DELAY).prop_map(Rtt::Constant),
        (0.001..1.0f64, 1.0..60.0f64).prop_map(|(median, p99)| Rtt::Lognormal { median, p99 }),
        prop::collection::vec((0.001..9.0f64, within(training::DELAY)), 1..9).prop_map(|rows| {
            let mut now = 0.0;
            let rows = rows.into_iter().map(|(later, rtt)| {
                now += later;
                (now, rtt)
            });
            Rtt::Trace(RttTrace::new(rows.collect()).unwrap())
        }),
    ];
    let late = (0.0..0.5f64, 0.0..0.9f64, within(training::DELAY)).prop_map(
        |(probability, after_late, extra)| LatePackets { probability, after_late, extra },
    );
    let outages = prop::collection::vec((0.0..9.0f64, 0.0..9.0f64), 0..9).prop_map(|list| {
        let mut end = 0.0;
        let outages = list.into_iter().map(|(wait, duration)| {
            let outage = Outage { start: end + wait, duration };
            end = outage.start + duration;
            outage
        });
        outages.collect::<Vec<_>>()
    });
    let silences = (0.0..0.1f64, 0.1..1.0f64, 1.0..10.0f64)
        .prop_map(|(rate, shortest, longest)| Silences { rate, shortest, longest });
    let any = (rtt, late, outages, silences, any::<bool>()).prop_map(
        |(rtt, late, outages, silences, in_order)| LinkModel {
            sensor_delay: SENSOR_DELAY,
            rtt,
            late,
            outages,
            silences,
            in_order,
        },
    );
    let preset = select(PRESETS.to_vec()).prop_map(|name| LinkModel::preset(name).unwrap());
    prop_oneof![preset, any]
}

proptest! {
    #[test]
    fn a_simulated_environment_survives_the_wire(slip in slip(), link in link(), weight in within(training::WEIGHT), bad in any::<bool>()) {
        let fitness = if bad { Fitness::Bad } else { Fitness::Normal };
        let lab = TrainingEnvironment { name: "a".to_owned(), slip, link, fitness, weight };
        let spec = training::Spec::from(&lab);
        let read = training::Spec::read(&serde_json::to_vec(&spec).unwrap()).unwrap();
        prop_assert_eq!(environment(&read, &"a".parse().unwrap()), lab);
        let shown = training::Environment::new("a".parse().unwrap(), spec.clone(), false, "1");
        prop_assert_eq!(shown.to_spec(), spec);
    }
}

#[test]
fn what_is_built_in_can_be_put_under_another_name() {
    for name in ENVIRONMENTS {
        let lab = TrainingEnvironment::preset(name).unwrap();
        let spec = training::Spec::from(&lab);
        let checked = Checked::new(spec).unwrap();
        assert_eq!(environment(&checked, &name.parse().unwrap()), lab, "{name}");
    }
    assert_eq!(built_in("moon").unwrap_err(), ENVIRONMENTS);
}
