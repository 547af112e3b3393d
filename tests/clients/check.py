"""What a client does that openapi-python-client made of the contract, against a server: `check.py URL`."""

import json
import sys
import time

from umwelt import Client
from umwelt.api.events import robot_events
from umwelt.api.evolutions import evolution_events, evolution_figure, get_evolution, submit_evolution
from umwelt.api.robots import get_robot, list_robots, put_robot
from umwelt.models import ErrorBody, EventMissed, EventRegistered, EvolutionEventGeneration
from umwelt.models import EvolutionEventState, EvolutionRequest, RobotSpecRequest

client = Client(base_url=sys.argv[1], timeout=60)

robot = put_robot.sync("py-1", client=client, body=RobotSpecRequest(horizon_slots=3))
assert robot.spec.horizon_slots == 3 and robot.state == "never", robot
assert [it.robot for it in list_robots.sync(client=client).robots] == ["py-1"]
missing = get_robot.sync("py-2", client=client)
assert isinstance(missing, ErrorBody), missing
assert missing.error.details[0].reason == "NO_SUCH_RESOURCE", missing

request = EvolutionRequest(preset="quick", population=10, elites=1, generations=2, trials=1,
                           selection_trials=10, report_trials=10, environments=["normal"])
name = submit_evolution.sync(client=client, body=request).evolution
# The stream ends with the evolution: its text comes whole.
text = evolution_events.sync(name, client=client)
events = [json.loads(line[5:]) for line in text.splitlines() if line.startswith("data:")]
kinds = {"generation": EvolutionEventGeneration, "state": EvolutionEventState}
events = [kinds[event["type"]].from_dict(event) for event in events]
assert [it.id for it in events if isinstance(it, EvolutionEventGeneration)] == [1, 2], events
while (evolution := get_evolution.sync(name, client=client)).state == "running":
    time.sleep(0.1)
assert evolution.state == "succeeded", evolution
figure = evolution_figure.sync(name, "deviation", client=client)
assert b"<svg" in figure.payload.read()[:500]

# A robot's stream does not end: it is read event by event, from the request that the client makes.
with client.get_httpx_client().stream(**robot_events._get_kwargs("py-1", last_event_id=0)) as stream:
    data = (json.loads(line[5:]) for line in stream.iter_lines() if line.startswith("data:"))
    assert EventMissed.from_dict(next(data)).robot is None
    assert EventRegistered.from_dict(next(data)).robot == "py-1"
print("python: robots, errors, figures and events work")
