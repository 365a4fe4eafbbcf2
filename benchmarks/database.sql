-- Tables of benchmarks.duckdb, which is rebuilt from the JSON files after every benchmark.

CREATE TABLE benchmarks (
    benchmark VARCHAR PRIMARY KEY, started TIMESTAMP, finished TIMESTAMP, size VARCHAR, host VARCHAR, host_class VARCHAR,
    processors INTEGER, load_before DOUBLE, load_after DOUBLE, git_commit VARCHAR, model_version VARCHAR, versions JSON,
    operations_per_s DOUBLE, divisions_per_s DOUBLE, roots_per_s DOUBLE
);
COMMENT ON TABLE benchmarks IS 'One row per run of the benchmark';
COMMENT ON COLUMN benchmarks.benchmark IS 'Name of its file';
COMMENT ON COLUMN benchmarks.started IS 'Start, UTC';
COMMENT ON COLUMN benchmarks.finished IS 'End, UTC';
COMMENT ON COLUMN benchmarks.size IS 'How much was measured: full or quick';
COMMENT ON COLUMN benchmarks.host IS 'Name of the machine';
COMMENT ON COLUMN benchmarks.host_class IS 'Kind of machine; times are compared within one kind only';
COMMENT ON COLUMN benchmarks.processors IS 'Number of processors';
COMMENT ON COLUMN benchmarks.load_before IS 'Mean number of running processes over the minute before';
COMMENT ON COLUMN benchmarks.load_after IS 'Mean number of running processes over the last minute';
COMMENT ON COLUMN benchmarks.git_commit IS 'Commit that was measured; -dirty where the source was changed';
COMMENT ON COLUMN benchmarks.model_version IS 'Version of the physical model';
COMMENT ON COLUMN benchmarks.versions IS 'Versions of the software, JSON';
COMMENT ON COLUMN benchmarks.operations_per_s IS 'Multiplications and additions per second and core, measured';
COMMENT ON COLUMN benchmarks.divisions_per_s IS 'Divisions per second and core, measured';
COMMENT ON COLUMN benchmarks.roots_per_s IS 'Square roots per second and core, measured';

CREATE TABLE figures (
    benchmark VARCHAR REFERENCES benchmarks (benchmark), section VARCHAR, item VARCHAR, "case" VARCHAR, quantity VARCHAR,
    unit VARCHAR, samples DOUBLE[], median DOUBLE, lower_quartile DOUBLE, upper_quartile DOUBLE, at_least DOUBLE,
    at_most DOUBLE, holds BOOLEAN
);
COMMENT ON TABLE figures IS 'One row per measured or derived quantity';
COMMENT ON COLUMN figures.benchmark IS 'Run of the benchmark, see benchmarks';
COMMENT ON COLUMN figures.section IS 'Part of the benchmark: kernel, transfer, study or growth';
COMMENT ON COLUMN figures.item IS 'What was measured';
COMMENT ON COLUMN figures."case" IS 'Under which conditions';
COMMENT ON COLUMN figures.quantity IS 'Which quantity of it';
COMMENT ON COLUMN figures.unit IS 'Unit of the samples';
COMMENT ON COLUMN figures.samples IS 'Values, one per repetition';
COMMENT ON COLUMN figures.median IS 'Median of the samples';
COMMENT ON COLUMN figures.lower_quartile IS 'A quarter of the samples lies below';
COMMENT ON COLUMN figures.upper_quartile IS 'A quarter of the samples lies above';
COMMENT ON COLUMN figures.at_least IS 'Target: the median is at least this';
COMMENT ON COLUMN figures.at_most IS 'Target: the median is at most this';
COMMENT ON COLUMN figures.holds IS 'Whether the median meets the target; NULL without a target';
