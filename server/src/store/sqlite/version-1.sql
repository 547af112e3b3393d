-- Single numbers: the highest number that an evolution ever had, and one that is written to see whether it can be.
CREATE TABLE numbers (name TEXT PRIMARY KEY, value INTEGER NOT NULL) STRICT, WITHOUT ROWID;
INSERT INTO numbers VALUES ('last_evolution', 0), ('probe', 0);

CREATE TABLE robots (id TEXT PRIMARY KEY, revision INTEGER NOT NULL, body TEXT NOT NULL) STRICT;

-- version: that of core's saved state.
CREATE TABLE posteriors (
    robot TEXT PRIMARY KEY REFERENCES robots (id) ON DELETE CASCADE,
    version INTEGER NOT NULL,
    body TEXT NOT NULL
) STRICT;

CREATE TABLE priors (name TEXT PRIMARY KEY, body TEXT NOT NULL) STRICT;

CREATE TABLE environments (name TEXT PRIMARY KEY, body TEXT NOT NULL) STRICT;

CREATE TABLE evolutions (
    id TEXT PRIMARY KEY,
    number INTEGER NOT NULL,
    finished INTEGER NOT NULL,
    body TEXT NOT NULL
) STRICT;

-- "position" is the index of the generation.
CREATE TABLE generations (
    evolution TEXT NOT NULL REFERENCES evolutions (id) ON DELETE CASCADE,
    position INTEGER NOT NULL,
    body TEXT NOT NULL,
    PRIMARY KEY (evolution, position)
) STRICT, WITHOUT ROWID;

CREATE TABLE checkpoints (
    evolution TEXT PRIMARY KEY REFERENCES evolutions (id) ON DELETE CASCADE,
    body TEXT NOT NULL
) STRICT;
