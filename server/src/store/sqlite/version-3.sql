-- Every row has a checksum over its table's name and all its columns (checksum.rs). Rows that were there get theirs now.
ALTER TABLE numbers ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;
ALTER TABLE robots ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;
ALTER TABLE posteriors ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;
ALTER TABLE priors ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;
ALTER TABLE environments ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;
ALTER TABLE parts ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;
ALTER TABLE checkpoints ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;
ALTER TABLE last_numbers ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;

UPDATE numbers SET checksum = row_checksum('numbers', name, value);
UPDATE robots SET checksum = row_checksum('robots', id, revision, body);
UPDATE posteriors SET checksum = row_checksum('posteriors', robot, version, body);
UPDATE priors SET checksum = row_checksum('priors', name, body);
UPDATE environments SET checksum = row_checksum('environments', name, body);
UPDATE jobs SET checksum = row_checksum('jobs', kind, number, finished, body);
UPDATE parts SET checksum = row_checksum('parts', kind, number, position, body);
UPDATE checkpoints SET checksum = row_checksum('checkpoints', kind, number, body);
UPDATE last_numbers SET checksum = row_checksum('last_numbers', kind, number);
