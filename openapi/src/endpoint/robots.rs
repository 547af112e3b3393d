//! Robots, their tasks, the hot path, the stop, what is identified, and what happens.

use super::{Answer, Endpoint, Operation, Paged, Scope, delete, get, patch, post, put};
use crate::page::{DEFAULT_PAGE_SIZE, ID_TOKEN, MAX_PAGE_SIZE};
use crate::{environment, event, robot, step, stop, task};

endpoints! {
    /// Describe a robot
    PUT_ROBOT: Endpoint<robot::Description, robot::Robot> = put("put_robot", "/v1/robots/{robot}")
        .tag("robots")
        .about("Creates it or replaces all that was said: what is left out is default again, or follows from the rest. The task is kept; what was learned is kept unless method, prior or drift changed.")
        .conditional()
        .takes::<robot::Description>()
        .gives(&[(200, "It was described anew"), (201, "It was described for the first time")])
        .fails(&[400, 409]);
    /// Change parts of what was said about a robot
    PATCH_ROBOT: Endpoint<robot::Patch, robot::Robot> = patch("patch_robot", "/v1/robots/{robot}")
        .tag("robots")
        .about("A JSON merge patch (RFC 7396), as `application/merge-patch+json` or `application/json`: what it has replaces what was said, null takes it back; `prior` and `predictor` are replaced as a whole. Task and what was learned are kept as with PUT.")
        .conditional()
        .takes::<robot::Patch>()
        .gives(&[(200, "It was changed")])
        .fails(&[400, 404, 409]);
    /// Show a robot
    GET_ROBOT: Endpoint<(), robot::Robot> = get("get_robot", "/v1/robots/{robot}")
        .tag("robots")
        .gives(&[(200, "The robot as it is now")])
        .fails(&[400, 404]);
    /// Remove a robot
    DELETE_ROBOT: Endpoint = delete("delete_robot", "/v1/robots/{robot}")
        .tag("robots")
        .about("With its task and what was learned. Its agent gets NOT_FOUND and the robot ramps to rest by itself.")
        .conditional()
        .answers(Answer::Nothing("It is gone"))
        .fails(&[400, 404, 409]);
    /// List robots
    LIST_ROBOTS: Endpoint<(), robot::Page> = get("list_robots", "/v1/robots")
        .tag("robots")
        .about("In the order of their ids.")
        .paged(Paged { max: MAX_PAGE_SIZE, default: DEFAULT_PAGE_SIZE, token: ID_TOKEN })
        .by_state::<robot::State>("Only robots in this state")
        .gives(&[(200, "Some of the robots")])
        .fails(&[400]);

    /// Set the task of a robot
    PUT_TASK: Endpoint<task::Spec, task::Task> = put("put_task", "/v1/robots/{robot}/task")
        .tag("tasks")
        .about("Replaces the one before; begins with the next step. The very task that the robot has already goes on as it is, arrived or not, with the same `etag`: to have it driven again, DELETE it first.")
        .conditional()
        .takes::<task::Spec>()
        .gives(&[(200, "It replaced another, or is the one that there was"), (201, "It was set")])
        .fails(&[400, 404, 409]);
    /// Show the task of a robot and its progress
    GET_TASK: Endpoint<(), task::Task> = get("get_task", "/v1/robots/{robot}/task")
        .tag("tasks")
        .gives(&[(200, "The task and how far it has got")])
        .fails(&[400, 404]);
    /// Cancel the task of a robot
    DELETE_TASK: Endpoint = delete("delete_task", "/v1/robots/{robot}/task")
        .tag("tasks")
        .about("The robot ramps to rest.")
        .conditional()
        .answers(Answer::Nothing("There is no task any more"))
        .fails(&[400, 404, 409]);

    /// Send observations, get a horizon
    STEP: Endpoint<step::Request, step::Reply> = post("step", "/v1/robots/{robot}/step")
        .tag("control")
        .scope(Scope::Robot)
        .about("Idempotent on (robot, epoch, sequence): a repeat gets the same answer, a late one the newest horizon. A superseded epoch gets ABORTED.")
        .takes::<step::Request>()
        .gives(&[(200, "What to play")])
        .fails(&[400, 404, 409, 429, 503]);
    /// Stop a robot until it is resumed
    STOP_ROBOT: Endpoint<(), stop::Stop> = post("stop_robot", "/v1/robots/{robot}/stop")
        .tag("control")
        .about("Acts on the next exchange; the task is kept.")
        .gives(&[(200, "It is told to rest")])
        .fails(&[400, 404]);
    /// Let a stopped robot go on
    RESUME_ROBOT: Endpoint<(), stop::Stop> = post("resume_robot", "/v1/robots/{robot}/resume")
        .tag("control")
        .about("Of stops and resumes the last to arrive holds: one that a stop has overtaken has no effect.")
        .gives(&[(200, "It is told to go on")])
        .fails(&[400, 404, 409, 503]);
    /// Stop all robots until they are resumed
    STOP_ALL: Endpoint<(), stop::StopAll> = post("stop_all", "/v1/stop")
        .tag("control")
        .gives(&[(200, "All are told to rest")])
        .fails(&[503]);
    /// Let all stopped robots go on
    RESUME_ALL: Endpoint<(), stop::StopAll> = post("resume_all", "/v1/resume")
        .tag("control")
        .gives(&[(200, "All are told to go on")])
        .fails(&[503]);

    /// Show what is identified
    GET_ENVIRONMENT: Endpoint<(), environment::Environment> =
        get("get_environment", "/v1/robots/{robot}/environment")
        .tag("environments")
        .gives(&[(200, "The identified environment")])
        .fails(&[400, 404]);
    /// Forget what was learned
    RESET_ENVIRONMENT: Endpoint<(), environment::Environment> =
        post("reset_environment", "/v1/robots/{robot}/environment/reset")
        .tag("environments")
        .about("Back to the prior.")
        .gives(&[(200, "The environment as the prior has it")])
        .fails(&[400, 404]);

    /// Follow a robot
    ROBOT_EVENTS: Endpoint<(), event::Event> = get("robot_events", "/v1/robots/{robot}/events")
        .tag("events")
        .about("Resumes behind the event named in `Last-Event-ID`; where some of those since are forgotten, the first event says `missed`.")
        .streams()
        .fails(&[400, 404, 429]);
    /// Follow all robots
    EVENTS: Endpoint<(), event::Event> = get("events", "/v1/events")
        .tag("events")
        .about("Resumes behind the event named in `Last-Event-ID`; where some of those since are forgotten, the first event says `missed`.")
        .streams()
        .fails(&[400, 429]);
}
