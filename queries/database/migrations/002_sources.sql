-- Results of several run directories in one file, what a run was planned to take and took, and speeds of Rayleigh waves.

CREATE TABLE sources (source INTEGER NOT NULL, directory VARCHAR NOT NULL, fingerprint VARCHAR);
COMMENT ON TABLE sources IS 'Run directories that the rows come from';
COMMENT ON COLUMN sources.source IS 'Number of the run directory';
COMMENT ON COLUMN sources.directory IS 'Its path: seen from the folder of this file where it lies in it, else absolute';
COMMENT ON COLUMN sources.fingerprint IS 'sha256 over its records and runs when they were read; an unchanged one need not be read again';
INSERT INTO sources SELECT 1, '.', NULL WHERE EXISTS (FROM runs);

ALTER TABLE snapshot DROP COLUMN fingerprint;
ALTER TABLE ingested ADD COLUMN source INTEGER DEFAULT 1;
ALTER TABLE runs ADD COLUMN source INTEGER DEFAULT 1;
ALTER TABLE units ADD COLUMN source INTEGER DEFAULT 1;
ALTER TABLE unit_costs ADD COLUMN source INTEGER DEFAULT 1;
ALTER TABLE series ADD COLUMN source INTEGER DEFAULT 1;
ALTER TABLE bands ADD COLUMN source INTEGER DEFAULT 1;
ALTER TABLE receptances ADD COLUMN source INTEGER DEFAULT 1;
ALTER TABLE failures ADD COLUMN source INTEGER DEFAULT 1;
COMMENT ON COLUMN ingested.source IS 'Run directory, see sources';
COMMENT ON COLUMN runs.source IS 'Run directory, see sources';
COMMENT ON COLUMN units.source IS 'Run directory, see sources; two directories may have computed the same unit';
COMMENT ON COLUMN unit_costs.source IS 'Run directory, see sources';
COMMENT ON COLUMN series.source IS 'Run directory, see sources';
COMMENT ON COLUMN bands.source IS 'Run directory, see sources';
COMMENT ON COLUMN receptances.source IS 'Run directory, see sources';
COMMENT ON COLUMN failures.source IS 'Run directory, see sources';

ALTER TABLE runs ADD COLUMN planned_tasks INTEGER;
ALTER TABLE runs ADD COLUMN planned_bytes BIGINT;
ALTER TABLE runs ADD COLUMN planned_peak_memory_bytes BIGINT;
ALTER TABLE runs ADD COLUMN planned_cpu_s DOUBLE;
ALTER TABLE runs ADD COLUMN planned_pilot_s DOUBLE;
ALTER TABLE runs ADD COLUMN measured_tasks INTEGER;
ALTER TABLE runs ADD COLUMN measured_task_starts INTEGER;
ALTER TABLE runs ADD COLUMN measured_bytes BIGINT;
ALTER TABLE runs ADD COLUMN measured_peak_memory_bytes BIGINT;
ALTER TABLE runs ADD COLUMN measured_cpu_s DOUBLE;
ALTER TABLE runs ADD COLUMN measured_wall_s DOUBLE;
COMMENT ON COLUMN runs.planned_tasks IS 'Tasks that the plan counted; NULL in runs of versions that did not say, as in all columns of plans and measurements';
COMMENT ON COLUMN runs.planned_bytes IS 'Bytes that the plan expected in the store';
COMMENT ON COLUMN runs.planned_peak_memory_bytes IS 'Largest memory of one worker process that the plan expected, byte';
COMMENT ON COLUMN runs.planned_cpu_s IS 'Processor time that the plan expected from its pilot, s';
COMMENT ON COLUMN runs.planned_pilot_s IS 'Time that the pilot itself took, s';
COMMENT ON COLUMN runs.measured_tasks IS 'Tasks that were carried out';
COMMENT ON COLUMN runs.measured_task_starts IS 'Starts of tasks; more than measured_tasks where some were tried again';
COMMENT ON COLUMN runs.measured_bytes IS 'Bytes written to the store';
COMMENT ON COLUMN runs.measured_peak_memory_bytes IS 'Largest memory of one worker process, byte';
COMMENT ON COLUMN runs.measured_cpu_s IS 'Processor time of all tasks, s';
COMMENT ON COLUMN runs.measured_wall_s IS 'Elapsed time of the run, s';

ALTER TABLE soil_layers ADD COLUMN rayleigh_speed_m_s DOUBLE;
COMMENT ON COLUMN soil_layers.rayleigh_speed_m_s IS 'Speed of Rayleigh waves on a half-space of this layer''s material, m/s; NULL in runs of versions that did not say';
