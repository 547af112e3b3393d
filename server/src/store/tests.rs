//! The rules of a store, held against both of them: what one does differently is found here.

use super::*;
use umwelt_core::controller::settings::{Prior, Settings};
use umwelt_core::controller::task::Task;
use umwelt_core::controller::{Controller, Saved};
use umwelt_core::geometry::Point;

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
    Record {
        settings,
        prior: Some("weak".into()),
        task,
        stopped: revision.is_multiple_of(3),
        revision,
    }
}

/// What a robot of that record may have learned, another thing for each `deliveries`.
pub(crate) fn saved(record: &Record, deliveries: u64) -> Saved {
    let mut controller = Controller::new(record.settings);
    if let Some(task) = record.task.clone() {
        controller.set_task(task);
    }
    for sequence in 0..deliveries {
        controller.late(&umwelt_core::exchange::Request {
            sequence,
            connection: 0,
            sent: 1.0,
            observations: Default::default(),
            deliveries: std::iter::once(umwelt_core::exchange::Delivery {
                sequence,
                loop_delay: 0.1 + 0.01 * sequence as f64,
            })
            .collect(),
            playing: None,
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

pub(crate) fn evolution(number: u64, body: &str) -> StoredEvolution {
    let id = format!("evolution-{number}");
    StoredEvolution { id, number, finished: number.is_multiple_of(2), body: body.into() }
}

fn prior(name: &str, source: PriorSource) -> StoredPrior {
    let note = Some("a \"note\" with ü".to_owned());
    StoredPrior { name: name.into(), prior: Prior::default(), note, source }
}

fn environment(name: &str, body: &str) -> StoredEnvironment {
    StoredEnvironment { name: name.into(), body: body.into() }
}

/// A commit of each kind of change, in an order in which they meet each other.
fn all_kinds() -> Vec<Vec<Change>> {
    let generation = |evolution: &str, index, body: &str| Change::PutGeneration {
        evolution: evolution.into(),
        index,
        body: body.into(),
    };
    let checkpoint = |evolution: &str, body: &str| Change::PutCheckpoint {
        evolution: evolution.into(),
        body: body.into(),
    };
    let champion = PriorSource::Evolution {
        evolution: "evolution-1".into(),
        seed: u64::MAX,
        optimizer: "genetic".into(),
        fitness: 0.1 + 0.2,
    };
    vec![
        vec![put_robot("b", 1), put_posterior("b", 1, 3), put_robot("a", 2)],
        vec![put_posterior("a", 2, 1), put_posterior("nobody", 2, 1)],
        vec![
            Change::PutPrior(prior("evolved", champion)),
            Change::PutPrior(prior("c", PriorSource::Put)),
        ],
        vec![
            Change::PutEnvironment(environment("wet", "{}")),
            Change::PutEnvironment(environment("ice", "[1]")),
        ],
        vec![
            Change::PutEvolution(evolution(1, "one")),
            generation("evolution-1", 0, "g0"),
            checkpoint("evolution-1", "c0"),
        ],
        vec![
            generation("evolution-1", 2, "g2"),
            generation("evolution-1", 1, "g1"),
            checkpoint("evolution-1", "c2"),
        ],
        vec![generation("nowhere", 0, "lost"), checkpoint("nowhere", "lost")],
        vec![
            Change::PutEvolution(evolution(10, "ten")),
            checkpoint("evolution-10", "c"),
            generation("evolution-10", 0, "g"),
        ],
        vec![Change::PutEvolution(evolution(1, "one again"))],
        vec![
            Change::DeleteCheckpoint("evolution-1".into()),
            generation("evolution-1", 1, "g1 again"),
        ],
        vec![put_robot("a", 4), put_posterior("a", 2, 9)],
        vec![Change::PutRobot(id("b"), Box::new(Record { stopped: true, ..record(1) }))],
        vec![
            Change::DeletePrior("c".into()),
            Change::DeleteEnvironment("wet".into()),
            Change::PutEnvironment(environment("ice", "2")),
        ],
        vec![Change::DeleteEvolution("evolution-10".into()), Change::DeleteRobot(id("nobody"))],
        vec![Change::PutEvolution(evolution(3, "three"))],
        vec![],
    ]
}

#[test]
fn both_stores_keep_the_same() {
    let read = |store: &dyn Store| {
        let of = |id| (store.generations(id, 0, 9).unwrap(), store.checkpoint(id).unwrap());
        (store.load().unwrap(), of("evolution-1"), of("evolution-10"))
    };
    let [(_, memory, _), (_, sqlite, _directory)] = stores().try_into().ok().unwrap();
    for changes in all_kinds() {
        memory.commit(changes.clone()).unwrap();
        sqlite.commit(changes.clone()).unwrap();
        assert_eq!(read(&*sqlite), read(&*memory), "after {changes:?}");
    }
    // And it is what was meant, not twice the same mistake.
    let (contents, (generations, checkpoint), of_ten) = read(&*sqlite);
    let names: Vec<_> = contents.robots.iter().map(|robot| robot.id.as_str()).collect();
    assert_eq!(names, ["a", "b"]);
    assert_eq!((&contents.robots[0].record, &contents.robots[0].saved), (&record(4), &None));
    assert_eq!(contents.robots[1].saved, Some(saved(&record(1), 3)), "a stop forgets nothing");
    assert!(contents.robots[1].record.stopped);
    assert_eq!(contents.environments, [environment("ice", "2")]);
    assert_eq!(contents.priors.len(), 1);
    assert_eq!(contents.evolutions, [evolution(1, "one again"), evolution(3, "three")]);
    assert_eq!(contents.last_evolution, 10, "a number never comes back");
    let bodies: Vec<_> = generations.iter().map(|generation| generation.body.as_str()).collect();
    assert_eq!(bodies, ["g0", "g1 again", "g2"]);
    assert_eq!((checkpoint, of_ten), (None, (vec![], None)));
}

#[test]
fn generations_come_in_pages() {
    for (name, store, _directory) in stores() {
        let put = |index| Change::PutGeneration {
            evolution: "evolution-1".into(),
            index,
            body: format!("{index}"),
        };
        let first = Change::PutEvolution(evolution(1, ""));
        store.commit(std::iter::once(first).chain((0..10).map(put)).collect()).unwrap();
        let page = |from, limit| -> Vec<usize> {
            let page = store.generations("evolution-1", from, limit).unwrap();
            page.into_iter().map(|generation| generation.index).collect()
        };
        assert_eq!(page(0, 3), [0, 1, 2], "{name}");
        assert_eq!(page(8, 3), [8, 9], "{name}");
        assert_eq!(page(10, 3), [0; 0], "{name}");
        assert_eq!(page(2, usize::MAX).len(), 8, "{name}");
        assert_eq!(store.generations("evolution-2", 0, 3).unwrap(), [], "{name}");
    }
}

/// The bug to fear: what was learned for one task is taken up in another one.
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
