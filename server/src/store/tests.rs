//! The rules of a store, held against both of them: what one does differently is found here.

use super::*;
use umwelt_api::prior::Source;
use umwelt_api::robot::{Description, Spec};
use umwelt_core::controller::{Controller, Saved};
use umwelt_core::geometry::Point;
use umwelt_core::settings::{Prior, Settings};
use umwelt_core::task::Task;
use umwelt_core::time::RobotTime;

/// The store under test with what it needs as long as it lives.
fn stores() -> Vec<(&'static str, Box<dyn Store>, Option<tempfile::TempDir>)> {
    let directory = tempfile::tempdir().unwrap();
    let sqlite = SqliteStore::open(directory.path()).unwrap();
    vec![
        ("memory", Box::new(MemoryStore::default()), None),
        ("sqlite", Box::new(sqlite), Some(directory)),
    ]
}

pub(crate) fn id(name: &str) -> RobotId {
    name.parse().unwrap()
}

pub(crate) fn record(revision: u64) -> Record {
    let settings = Settings { slots: 1 + revision as usize % 20, ..Settings::default() };
    let waypoints = vec![Point::new(0.1, -0.3), Point::new(1.0 / 3.0, 2.0)];
    let task = (revision % 2 == 1).then(|| Task { waypoints, ..Task::thesis() });
    let said = Description::from(&Spec::from_core(&settings, Some("weak")));
    Record {
        told: Told { settings, prior: Some("weak".into()), said },
        task,
        stopped: revision.is_multiple_of(3),
        revision,
    }
}

/// What a robot of that record may have learned, another thing for each `deliveries`.
pub(crate) fn saved(record: &Record, deliveries: u64) -> Saved {
    let mut controller = Controller::new(record.told.settings);
    if let Some(task) = record.task.clone() {
        controller.set_task(task);
    }
    for sequence in 0..deliveries {
        controller.late(&umwelt_core::exchange::Request {
            sequence,
            connection: 0,
            sent: RobotTime::new(1.0),
            observations: Default::default(),
            deliveries: std::iter::once(umwelt_core::exchange::Delivery {
                sequence,
                loop_delay: 0.1 + 0.01 * sequence as f64,
            })
            .collect(),
            playing: None,
            limits: Default::default(),
        });
    }
    controller.saved()
}

fn put_robot(name: &str, revision: u64) -> Change {
    Change::PutRobot(id(name), Box::new(record(revision)))
}

fn put_posterior(name: &str, revision: u64, deliveries: u64) -> Change {
    let saved = saved(&record(revision), deliveries);
    Change::PutPosterior(id(name), Box::new(Posterior { revision, saved }))
}

pub(crate) fn id_of(kind: StoredKind, number: u64) -> JobId {
    JobId { kind, number }
}

pub(crate) fn job(id: JobId, body: &str) -> StoredJob {
    StoredJob { id, finished: id.number.is_multiple_of(2), body: body.into() }
}

pub(crate) fn evolution(number: u64, body: &str) -> StoredJob {
    job(id_of(StoredKind::Evolution, number), body)
}

fn prior(name: &str, source: Source) -> StoredPrior {
    let note = Some("a \"note\" with ü".to_owned());
    StoredPrior { name: name.into(), prior: Prior::default(), note, source }
}

fn environment(name: &str, body: &str) -> StoredEnvironment {
    StoredEnvironment { name: name.into(), body: body.into() }
}

/// A commit of each kind of change, in an order in which they meet each other.
pub(crate) fn all_kinds() -> Vec<Vec<Change>> {
    let part = |job, index, body: &str| Change::PutPart { job, index, body: body.into() };
    let checkpoint = |job, body: &str| Change::PutCheckpoint { job, body: body.into() };
    let [one, ten, nowhere] = [1, 10, 99].map(|number| id_of(StoredKind::Evolution, number));
    let compared = id_of(StoredKind::Comparison, 10);
    let champion = Source::Evolution {
        evolution: "evolution-1".parse().unwrap(),
        seed: u64::MAX,
        optimizer: umwelt_api::evolution::Optimizer::Genetic,
        fitness: Some(0.1 + 0.2),
    };
    vec![
        vec![put_robot("b", 1), put_posterior("b", 1, 3), put_robot("a", 2)],
        vec![put_posterior("a", 2, 1), put_posterior("nobody", 2, 1)],
        vec![
            Change::PutPrior(prior("evolved", champion)),
            Change::PutPrior(prior("c", Source::Put)),
        ],
        vec![
            Change::PutEnvironment(environment("wet", "{}")),
            Change::PutEnvironment(environment("ice", "[1]")),
        ],
        vec![Change::PutJob(job(one, "one")), part(one, 0, "g0"), checkpoint(one, "c0")],
        vec![part(one, 2, "g2"), part(one, 1, "g1"), checkpoint(one, "c2")],
        vec![part(nowhere, 0, "lost"), checkpoint(nowhere, "lost")],
        vec![Change::PutJob(job(ten, "ten")), checkpoint(ten, "c"), part(ten, 0, "g")],
        // Of the same number, and another one all the same.
        vec![
            Change::PutJob(job(compared, "compared")),
            checkpoint(compared, "d"),
            part(compared, 0, "d0"),
        ],
        vec![Change::PutJob(job(one, "one again"))],
        vec![Change::DeleteCheckpoint(one), part(one, 1, "g1 again")],
        vec![put_robot("a", 4), put_posterior("a", 2, 9)],
        vec![Change::PutRobot(id("b"), Box::new(Record { stopped: true, ..record(1) }))],
        vec![
            Change::DeletePrior("c".into()),
            Change::DeleteEnvironment("wet".into()),
            Change::PutEnvironment(environment("ice", "2")),
        ],
        vec![Change::DeleteJob(ten), Change::DeleteRobot(id("nobody"))],
        vec![Change::PutJob(evolution(3, "three"))],
        vec![],
    ]
}

#[test]
fn both_stores_keep_the_same() {
    let read = |store: &dyn Store| {
        let of = |kind, number| {
            let id = id_of(kind, number);
            (store.parts(id, 0, 9).unwrap(), store.checkpoint(id).unwrap())
        };
        let [one, ten] = [1, 10].map(|number| of(StoredKind::Evolution, number));
        (store.load().unwrap(), one, ten, of(StoredKind::Comparison, 10))
    };
    let [(_, memory, _), (_, sqlite, _directory)] = stores().try_into().ok().unwrap();
    for changes in all_kinds() {
        memory.commit(changes.clone()).unwrap();
        sqlite.commit(changes.clone()).unwrap();
        assert_eq!(read(&*sqlite), read(&*memory), "after {changes:?}");
    }
    // And it is what was meant, not twice the same mistake.
    let (contents, (parts, checkpoint), of_ten, of_comparison) = read(&*sqlite);
    let names: Vec<_> = contents.robots.iter().map(|robot| robot.id.as_str()).collect();
    assert_eq!(names, ["a", "b"]);
    assert_eq!((&contents.robots[0].record, &contents.robots[0].saved), (&record(4), &None));
    assert_eq!(contents.robots[1].saved, Some(saved(&record(1), 3)), "a stop forgets nothing");
    assert!(contents.robots[1].record.stopped);
    assert_eq!(contents.environments, [environment("ice", "2")]);
    assert_eq!(contents.priors.len(), 1);
    let compared = job(id_of(StoredKind::Comparison, 10), "compared");
    assert_eq!(contents.jobs, [evolution(1, "one again"), evolution(3, "three"), compared]);
    let last = StoredKind::ALL.map(|kind| contents.last_number(kind));
    assert_eq!(last, [10, 10], "a number never comes back");
    let bodies: Vec<_> = parts.iter().map(|part| part.body.as_str()).collect();
    assert_eq!(bodies, ["g0", "g1 again", "g2"]);
    assert_eq!((checkpoint, of_ten), (None, (vec![], None)));
    let left = (vec![Part { index: 0, body: "d0".into() }], Some("d".into()));
    assert_eq!(of_comparison, left, "what ends an evolution ends no comparison");
}

#[test]
fn parts_come_in_pages() {
    for (name, store, _directory) in stores() {
        let [job, other] = [1, 2].map(|number| id_of(StoredKind::Evolution, number));
        let put = |index| Change::PutPart { job, index, body: format!("{index}") };
        let first = Change::PutJob(evolution(1, ""));
        store.commit(std::iter::once(first).chain((0..10).map(put)).collect()).unwrap();
        let page = |from, limit| -> Vec<usize> {
            let page = store.parts(job, from, limit).unwrap();
            page.into_iter().map(|part| part.index).collect()
        };
        assert_eq!(page(0, 3), [0, 1, 2], "{name}");
        assert_eq!(page(8, 3), [8, 9], "{name}");
        assert_eq!(page(10, 3), [0; 0], "{name}");
        assert_eq!(page(2, usize::MAX).len(), 8, "{name}");
        assert_eq!(store.parts(other, 0, 3).unwrap(), [], "{name}");
    }
}

/// Guards against: what was learned for one task is taken up in another one.
#[test]
fn what_was_learned_goes_with_its_revision() {
    for (name, store, _directory) in stores() {
        let learned = || store.load().unwrap().robots.remove(0).saved;
        store.commit(vec![put_robot("r", 1), put_posterior("r", 1, 2)]).unwrap();
        assert!(learned().is_some(), "{name}");
        store.commit(vec![put_posterior("r", 2, 3)]).unwrap();
        assert_eq!(learned(), Some(saved(&record(1), 2)), "{name}: of a revision to come");
        store.commit(vec![put_robot("r", 2)]).unwrap();
        assert_eq!(learned(), None, "{name}: of the one before");
        store.commit(vec![put_posterior("r", 1, 4)]).unwrap();
        assert_eq!(learned(), None, "{name}: one that comes late");
        store.commit(vec![put_posterior("r", 2, 5), Change::DeleteRobot(id("r"))]).unwrap();
        store.commit(vec![put_robot("r", 2)]).unwrap();
        assert_eq!(learned(), None, "{name}: of a robot that was removed");
    }
}
