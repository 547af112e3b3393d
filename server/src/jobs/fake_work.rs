//! Lab's work without robots among the jobs of the server: the kind with which tests show what all kinds share.

use super::record::UPGRADES;
use super::work::Work;
use crate::store::StoredKind;
use crate::store::document::Form;
pub(crate) use umwelt_lab::fake_work::{FakeSettings, FakeWork};

impl Work for FakeWork {
    const KIND: StoredKind = StoredKind::Counting;
    const FORM: &'static Form = &Form { is_within: true, upgrades: UPGRADES, base: "{}" };
    type Spec = FakeSettings;
    type Own = ();
    type Services = ();

    fn spec(settings: &FakeSettings) -> FakeSettings {
        *settings
    }

    fn settings_of(settings: &FakeSettings) -> Result<FakeSettings, String> {
        Ok(*settings)
    }
}
