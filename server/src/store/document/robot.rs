//! A robot as it is kept, and what it has learned.

use super::{Form, Unfit, Unreadable, former};
use crate::store::{Record, Told};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use umwelt_api::{Checked, robot, task};
use umwelt_core::controller::Saved;
use umwelt_core::settings::Settings;

/// How robots are kept. Version 1 had core's names, version 2 said not what was said, in version 3 a drive of which nothing
/// was said followed at once, in version 4 the method was `bayesian` where none was said.
pub(crate) const FORM: Form = Form {
    is_within: false,
    upgrades: &[former::robot, former::same, former::lag, former::method],
    base: include_str!("base/robot.json"),
};

#[derive(Serialize, Deserialize)]
struct Content {
    settings: robot::Spec,
    /// What the prior was when it was given, by name or by itself.
    prior: robot::Prior,
    /// What of the settings was said; null where that is all of them.
    said: Option<robot::Description>,
    task: Option<task::Spec>,
    stopped: bool,
}

/// The body of a robot.
pub(crate) fn of_record(record: &Record) -> Result<String, Unfit> {
    let unfit = Unfit { what: "a robot" };
    let Record { told: Told { settings, prior, said }, task, stopped, .. } = record;
    let content = Content {
        settings: robot::Spec::from_core(settings, prior.as_deref()),
        prior: settings.prior.into(),
        said: Some(said.clone()),
        task: task.as_ref().map(task::Spec::from),
        stopped: *stopped,
    };
    let Ok(body) = FORM.write(&content) else { return Err(unfit) };
    let is_exact = self::record(&body, record.revision).is_ok_and(|read| read == *record);
    if is_exact { Ok(body) } else { Err(unfit) }
}

/// Fields that came after it was kept what was said.
const LATER: [&str; 3] = ["drive.kind", "drive.turn_by_speed_s_per_m", "drive.sideways_m_per_rad"];

/// What was said of a robot of which that was not kept: every field that there was then.
fn all_of_then(settings: &robot::Spec) -> robot::Description {
    let all = robot::Description::from(settings);
    let mut patch = robot::Patch::default();
    LATER.iter().for_each(|path| patch.set(path, Value::Null));
    robot::Description::read(&all.patched(&patch)).map_or(all, Checked::into_inner)
}

/// The robot of a body.
pub(crate) fn record(body: &str, revision: u64) -> Result<Record, Unreadable> {
    FORM.read_with(body, |mut content| {
        // Of a prior without a name, the values beside it count.
        if content["settings"]["prior"].is_object() {
            content["settings"]["prior"] = content["prior"].clone();
        }
        let content: Content = serde_json::from_value(content).map_err(|it| it.to_string())?;
        let Content { settings, prior, said, task, stopped } = content;
        let values = prior.convert().map_err(|error| error.to_string())?;
        let said = said.unwrap_or_else(|| all_of_then(&settings));
        Ok::<_, String>(Record {
            told: Told {
                settings: said.identify(settings.convert(values)),
                prior: settings.prior.name().map(str::to_owned),
                said,
            },
            task: task.map(|task| task.convert()),
            stopped,
            revision,
        })
    })
}

/// The settings of a controller that are kept with its prior in them, not by name.
pub(crate) fn controller(spec: &robot::Spec) -> Result<Settings, String> {
    match &spec.prior {
        robot::PriorChoice::Inline(prior) => {
            Ok(spec.convert(prior.convert().map_err(|error| error.to_string())?))
        }
        robot::PriorChoice::Named(name) => Err(format!("the prior {name} without its values")),
    }
}

/// The body of what a robot has learned; its version stands beside it.
pub(crate) fn of_saved(saved: &Saved) -> Result<String, Unfit> {
    serde_json::to_string(saved).map_err(|_| Unfit { what: "what a robot has learned" })
}

/// What a robot has learned, of the version of this program.
pub(crate) fn saved(body: &str) -> Result<Saved, serde_json::Error> {
    serde_json::from_str(body)
}
