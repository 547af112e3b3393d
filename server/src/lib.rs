//! The controller server of Umwelt: robots, tasks, steps, stops, environments and events over HTTP.
//!
//! One task per robot owns its controller and its session with the agent (`fleet::robot`), on threads that do nothing
//! else, so that no computation holds up connections, stops or health; requests reach it through a bounded queue, and
//! what it shows goes out through a `watch`, so that a reader never waits for a robot and a slow robot never slows
//! another. What must outlive the process goes through the [`Store`].
//!
//! ```no_run
//! # async fn example() -> std::io::Result<()> {
//! use umwelt_server::{Config, Server};
//! let server = Server::bind(Config { listen: ([127, 0, 0, 1], 0).into(), ..Config::default() }).await?;
//! println!("listening on http://{}", server.local_addr());
//! let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
//! let running = tokio::spawn(server.run(async { stopped.await.unwrap_or_default() }));
//! // ... robots drive ...
//! drop(stop);
//! running.await??;
//! # Ok(())
//! # }
//! ```
//!
//! The rooms, each of which names those below it and none above:
//! 1. `program`: the process, its settings, the server put together,
//! 2. `http`: everything that knows HTTP,
//! 3. `jobs`: what runs in the background,
//! 4. `fleet`: the robots,
//! 5. `library`: priors and simulated environments by name,
//! 6. `store`: what outlives the process,
//! 7. `resource`: what all resources have, versions, conditions and failures.
//!
//! Architecture invariants: nothing here plans or identifies, that is core's; nothing here names a wire field,
//! that is the contract's; nothing below `http` knows HTTP but for the codes of the contract; no request waits for
//! another robot's task; steps never touch the store.

mod fleet;
mod http;
mod jobs;
mod library;
pub mod program;
mod resource;
pub mod store;

pub use http::guard::{HostName, Origin, read_token};
pub use program::config::Config;
pub use program::serve::Server;
pub use store::Store;
pub use umwelt_lab::offline;
pub use umwelt_lab::pool::Priority;
