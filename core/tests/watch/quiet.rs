//! In ordinary driving the watch says nothing.

#[path = "../../examples/watch_false_alarms/driving.rs"]
mod driving;

use umwelt_core::comparison::SCENARIOS;

/// Ten minutes of simulated driving in each scenario, on other seeds than the example's.
#[test]
fn ordinary_driving_raises_no_alarm() {
    for scenario in SCENARIOS {
        let said = driving::drive(scenario, 600.0, 1000);
        assert!(said.alarms.is_empty() && said.remarks.is_empty(), "{scenario}: {said:?}");
        assert!(said.driven >= 600.0 && said.arrived == said.episodes, "{scenario}: {said:?}");
    }
}
