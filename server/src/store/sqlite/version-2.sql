-- Evolutions are one kind of job: what was theirs alone is for every kind.
-- "kind" and "number" make an id: 'evolution' and 12 are evolution-12.
CREATE TABLE jobs (
    kind TEXT NOT NULL,
    number INTEGER NOT NULL,
    finished INTEGER NOT NULL,
    body TEXT NOT NULL,
    PRIMARY KEY (kind, number)
) STRICT;

-- "position" is the index of the part: of the generation of an evolution.
CREATE TABLE parts (
    kind TEXT NOT NULL,
    number INTEGER NOT NULL,
    position INTEGER NOT NULL,
    body TEXT NOT NULL,
    PRIMARY KEY (kind, number, position),
    FOREIGN KEY (kind, number) REFERENCES jobs (kind, number) ON DELETE CASCADE
) STRICT;

CREATE TABLE job_checkpoints (
    kind TEXT NOT NULL,
    number INTEGER NOT NULL,
    body TEXT NOT NULL,
    PRIMARY KEY (kind, number),
    FOREIGN KEY (kind, number) REFERENCES jobs (kind, number) ON DELETE CASCADE
) STRICT;

-- The highest number that a job of each kind ever had.
CREATE TABLE last_numbers (kind TEXT PRIMARY KEY, number INTEGER NOT NULL) STRICT, WITHOUT ROWID;

INSERT INTO jobs SELECT 'evolution', number, finished, body FROM evolutions;
INSERT INTO parts
    SELECT 'evolution', number, position, generations.body
    FROM generations JOIN evolutions ON id = evolution;
INSERT INTO job_checkpoints
    SELECT 'evolution', number, checkpoints.body FROM checkpoints JOIN evolutions ON id = evolution;
INSERT INTO last_numbers SELECT 'evolution', value FROM numbers WHERE name = 'last_evolution' AND value > 0;

DELETE FROM numbers WHERE name = 'last_evolution';
DROP TABLE generations;
DROP TABLE checkpoints;
DROP TABLE evolutions;
ALTER TABLE job_checkpoints RENAME TO checkpoints;
