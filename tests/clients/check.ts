// What a client does that openapi-ts made of the contract, against a server: `node check.js URL`.

import assert from 'node:assert/strict';
import { client } from './umwelt/client.gen';
import type { Event } from './umwelt/types.gen';
import {
  evolutionEvents, evolutionFigure, getRobot, putRobot, robotEvents, submitEvolution,
} from './umwelt/sdk.gen';

async function check(): Promise<void> {
  client.setConfig({ baseUrl: process.argv[2] });

  const robot = await putRobot({ path: { robot: 'ts-1' }, body: { horizon_slots: 3 } });
  assert.equal(robot.data?.spec.horizon_slots, 3);
  const missing = await getRobot({ path: { robot: 'ts-2' } });
  assert.equal(missing.error?.error.details?.[0]?.reason, 'NO_SUCH_RESOURCE');

  const submitted = await submitEvolution({
    body: {
      preset: 'quick', population: 10, elites: 1, generations: 2, trials: 1, selection_trials: 10,
      report_trials: 10, environments: ['normal'],
    },
  });
  const evolution = submitted.data!.evolution;
  const followed = await evolutionEvents({ path: { evolution } });
  const generations: number[] = [];
  for await (const event of followed.stream) {
    if (typeof event === 'object' && event.type === 'generation') generations.push(event.id);
    if (typeof event === 'object' && event.type === 'state' && event.state === 'succeeded') break;
  }
  assert.deepEqual(generations, [1, 2]);
  const figure = await evolutionFigure({ path: { evolution, figure: 'deviation' }, parseAs: 'text' });
  assert.match(String(figure.data).slice(0, 500), /<svg/);

  const events = await robotEvents({ path: { robot: 'ts-1' }, headers: { 'Last-Event-ID': 0 } });
  for await (const event of events.stream) {
    const { type } = event as Event;
    if (type === 'registered') break;
    assert.equal(type, 'missed');
  }
  console.log('typescript: robots, errors, figures and events work');
}

check().then(() => process.exit(0), (error) => { console.error(error); process.exit(1); });
