-- Views and macros of results.duckdb, made anew with every snapshot. All of them show the newest run of each case.

CREATE MACRO decibel(ratio) AS CASE WHEN isfinite(ratio) AND ratio > 0 THEN 10 * log10(ratio) END;
COMMENT ON MACRO decibel IS 'Ten times the decimal logarithm of a ratio of mean squares, dB; NULL unless positive and finite';

CREATE VIEW current_cases AS
SELECT run_cases.case_id, arg_max(runs.run_id, runs.sequence) AS run_id
FROM run_cases JOIN runs USING (run_id) GROUP BY run_cases.case_id;
COMMENT ON VIEW current_cases IS 'The newest run that asked for each case';
COMMENT ON COLUMN current_cases.case_id IS 'Case, see cases';
COMMENT ON COLUMN current_cases.run_id IS 'Newest run that asked for it, see runs';

CREATE VIEW current_units AS
SELECT current_cases.run_id, case_id, approach, unit_id, scope
FROM current_cases JOIN case_units USING (run_id, case_id);
COMMENT ON VIEW current_units IS 'Units that the newest run of each case needs';
COMMENT ON COLUMN current_units.run_id IS 'Newest run that asked for the case, see runs';
COMMENT ON COLUMN current_units.case_id IS 'Case, see cases';
COMMENT ON COLUMN current_units.approach IS 'Approach of the prediction';
COMMENT ON COLUMN current_units.unit_id IS 'Unit, see units; without a row there it is missing';
COMMENT ON COLUMN current_units.scope IS 'What the unit depends on: ground (shared by every speed), speed, or case';

CREATE VIEW missing AS
SELECT current_units.run_id, case_id, soil, track, train, unevenness, speed_kmh, approach, scope, current_units.unit_id, failures.kind, failures.error
FROM current_units JOIN cases USING (case_id) LEFT JOIN failures ON failures.unit_id = current_units.unit_id
WHERE NOT EXISTS (FROM units WHERE units.unit_id = current_units.unit_id) OR failures.unit_id IS NOT NULL;
COMMENT ON VIEW missing IS 'Units that are needed and not there, with the error where one was recorded';
COMMENT ON COLUMN missing.run_id IS 'Newest run that asked for the case, see runs';
COMMENT ON COLUMN missing.case_id IS 'Case, see cases';
COMMENT ON COLUMN missing.soil IS 'Name of the soil';
COMMENT ON COLUMN missing.track IS 'Name of the track';
COMMENT ON COLUMN missing.train IS 'Name of the train';
COMMENT ON COLUMN missing.unevenness IS 'Name of the unevenness';
COMMENT ON COLUMN missing.speed_kmh IS 'Train speed, km/h';
COMMENT ON COLUMN missing.approach IS 'Approach that needs the unit';
COMMENT ON COLUMN missing.scope IS 'What the unit depends on: ground, speed or case';
COMMENT ON COLUMN missing.unit_id IS 'Unit that is missing';
COMMENT ON COLUMN missing.kind IS 'Kind of unit, where it failed';
COMMENT ON COLUMN missing.error IS 'Error, where it failed; NULL where it was never tried';

CREATE VIEW levels AS
SELECT current_units.run_id, bands.case_id, soil, track, train, unevenness, speed_kmh, bands.approach, contribution, quantity,
    receiver, offset_m, averaging, band_hz, mean_square, extrapolated_share,
    CASE quantity WHEN 'wheel_rail_force' THEN 1.0 ELSE 1e-9 END AS reference_value,
    decibel(CASE quantity WHEN 'wheel_rail_force' THEN mean_square ELSE mean_square * 1e18 END) AS level_db
FROM bands
JOIN current_units ON current_units.unit_id = bands.unit_id AND current_units.case_id = bands.case_id AND current_units.approach = bands.approach
JOIN cases ON cases.case_id = bands.case_id;
COMMENT ON VIEW levels IS 'Levels in one-third octaves, a row per case, approach, receiver and band';
COMMENT ON COLUMN levels.run_id IS 'Newest run that asked for the case, see runs';
COMMENT ON COLUMN levels.case_id IS 'Case, see cases';
COMMENT ON COLUMN levels.soil IS 'Name of the soil';
COMMENT ON COLUMN levels.track IS 'Name of the track';
COMMENT ON COLUMN levels.train IS 'Name of the train';
COMMENT ON COLUMN levels.unevenness IS 'Name of the unevenness';
COMMENT ON COLUMN levels.speed_kmh IS 'Train speed, km/h';
COMMENT ON COLUMN levels.approach IS 'Approach of the prediction';
COMMENT ON COLUMN levels.contribution IS 'dynamic, quasi-static or total';
COMMENT ON COLUMN levels.quantity IS 'wheel_rail_force or velocity';
COMMENT ON COLUMN levels.receiver IS 'axle-1 (leads) to axle-M, rail or ground';
COMMENT ON COLUMN levels.offset_m IS 'Distance of a ground receiver from the track centre, m; NULL elsewhere';
COMMENT ON COLUMN levels.averaging IS 'line: over the whole line; train: over the length of the train';
COMMENT ON COLUMN levels.band_hz IS 'Exact midband frequency 10^(n/10), Hz';
COMMENT ON COLUMN levels.mean_square IS 'Mean square in the band: (m/s)^2 for velocity, N^2 for wheel_rail_force';
COMMENT ON COLUMN levels.extrapolated_share IS 'Share (0 to 1) of the unevenness behind this band that lies outside its form''s range of validity';
COMMENT ON COLUMN levels.reference_value IS 'Reference of the level: 1e-9 m/s for velocity (ISO 1683), 1 N for wheel_rail_force';
COMMENT ON COLUMN levels.level_db IS 'Level, dB re reference_value; NULL where the mean square is zero';

CREATE VIEW psd AS
SELECT case_id, approach, contribution, quantity, receiver, offset_m, averaging, frequency_hz, value, run_id, model_version, unit_id
FROM psd_lines JOIN series USING (series_id);
COMMENT ON VIEW psd IS 'One-sided narrow-band power spectral densities; which ones are here follows from output.narrow_band of the study, all are in the store';
COMMENT ON COLUMN psd.case_id IS 'Case, see cases';
COMMENT ON COLUMN psd.approach IS 'Approach of the prediction';
COMMENT ON COLUMN psd.contribution IS 'dynamic, quasi-static or total';
COMMENT ON COLUMN psd.quantity IS 'wheel_rail_force or velocity';
COMMENT ON COLUMN psd.receiver IS 'axle-1 (leads) to axle-M, rail or ground';
COMMENT ON COLUMN psd.offset_m IS 'Distance of a ground receiver from the track centre, m; NULL elsewhere';
COMMENT ON COLUMN psd.averaging IS 'line: over the whole line; train: over the length of the train';
COMMENT ON COLUMN psd.frequency_hz IS 'Frequency, Hz';
COMMENT ON COLUMN psd.value IS 'One-sided density: (m/s)^2/Hz for velocity, N^2/Hz for wheel_rail_force';
COMMENT ON COLUMN psd.run_id IS 'Run that computed it, see runs';
COMMENT ON COLUMN psd.model_version IS 'Version of the physical model';
COMMENT ON COLUMN psd.unit_id IS 'Unit it comes from, see units';

CREATE VIEW accuracy AS
SELECT approach.run_id, approach.case_id, approach.soil, approach.track, approach.train, approach.unevenness, approach.speed_kmh,
    approach.approach, runs.reference, approach.contribution, approach.quantity, approach.receiver, approach.offset_m,
    approach.band_hz, approach.level_db, reference.level_db AS reference_level_db,
    decibel(approach.mean_square / reference.mean_square) AS error_db, approach.extrapolated_share
FROM levels AS approach
JOIN runs ON runs.run_id = approach.run_id
JOIN levels AS reference ON reference.approach = runs.reference AND reference.run_id = approach.run_id
    AND reference.case_id = approach.case_id AND reference.contribution = approach.contribution
    AND reference.quantity = approach.quantity AND reference.receiver = approach.receiver
    AND reference.offset_m IS NOT DISTINCT FROM approach.offset_m AND reference.averaging = approach.averaging
    AND reference.band_hz = approach.band_hz
WHERE approach.approach <> runs.reference AND approach.averaging = 'line'
    AND approach.level_db IS NOT NULL AND reference.level_db IS NOT NULL;
COMMENT ON VIEW accuracy IS 'Error of each approach against the reference of the study, averaged over the line: level of the approach minus level of the reference. A case without reference has no row';
COMMENT ON COLUMN accuracy.run_id IS 'Newest run that asked for the case, see runs';
COMMENT ON COLUMN accuracy.case_id IS 'Case, see cases';
COMMENT ON COLUMN accuracy.soil IS 'Name of the soil';
COMMENT ON COLUMN accuracy.track IS 'Name of the track';
COMMENT ON COLUMN accuracy.train IS 'Name of the train';
COMMENT ON COLUMN accuracy.unevenness IS 'Name of the unevenness';
COMMENT ON COLUMN accuracy.speed_kmh IS 'Train speed, km/h';
COMMENT ON COLUMN accuracy.approach IS 'Approach of the prediction';
COMMENT ON COLUMN accuracy.reference IS 'Approach it is compared with';
COMMENT ON COLUMN accuracy.contribution IS 'dynamic, quasi-static or total';
COMMENT ON COLUMN accuracy.quantity IS 'wheel_rail_force or velocity';
COMMENT ON COLUMN accuracy.receiver IS 'axle-1 (leads) to axle-M, rail or ground';
COMMENT ON COLUMN accuracy.offset_m IS 'Distance of a ground receiver from the track centre, m; NULL elsewhere';
COMMENT ON COLUMN accuracy.band_hz IS 'Exact midband frequency 10^(n/10), Hz';
COMMENT ON COLUMN accuracy.level_db IS 'Level of the approach, dB re 1e-9 m/s for velocity, re 1 N for wheel_rail_force';
COMMENT ON COLUMN accuracy.reference_level_db IS 'Level of the reference, dB re 1e-9 m/s for velocity, re 1 N for wheel_rail_force';
COMMENT ON COLUMN accuracy.error_db IS 'Approach minus reference, dB; positive where the approach predicts more than the reference';
COMMENT ON COLUMN accuracy.extrapolated_share IS 'Share (0 to 1) of the unevenness behind this band that lies outside its form''s range of validity';

CREATE VIEW costs AS
SELECT current_units.run_id, case_id, approach, scope, unit_costs.kind, stage, sum(wall_s) AS wall_s, sum(cpu_s) AS cpu_s,
    sum(evaluations)::BIGINT AS evaluations, sum(kernel_calls)::BIGINT AS kernel_calls, max(peak_rss_bytes) AS peak_rss_bytes,
    sum(bytes_written)::BIGINT AS bytes_written, count(DISTINCT unit_id) AS units,
    string_agg(DISTINCT worker, ', ' ORDER BY worker) AS worker, max(attempt) AS attempt
FROM current_units JOIN unit_costs USING (unit_id)
GROUP BY current_units.run_id, case_id, approach, scope, unit_costs.kind, stage;
COMMENT ON VIEW costs IS 'Cost of each stage, charged in full to every case and approach that needs it: sums over cases or approaches count shared work more than once';
COMMENT ON COLUMN costs.run_id IS 'Newest run that asked for the case, see runs';
COMMENT ON COLUMN costs.case_id IS 'Case, see cases';
COMMENT ON COLUMN costs.approach IS 'Approach that is charged';
COMMENT ON COLUMN costs.scope IS 'What the work depends on: ground (shared by every speed), speed, or case';
COMMENT ON COLUMN costs.kind IS 'Kind of unit';
COMMENT ON COLUMN costs.stage IS 'Stage of the computation';
COMMENT ON COLUMN costs.wall_s IS 'Elapsed time, summed over units, s';
COMMENT ON COLUMN costs.cpu_s IS 'Processor time, summed over units, s';
COMMENT ON COLUMN costs.evaluations IS 'Values of a transfer function computed, one per frequency and wavenumber';
COMMENT ON COLUMN costs.kernel_calls IS 'Calls of compiled kernels';
COMMENT ON COLUMN costs.peak_rss_bytes IS 'Largest resident memory of a worker, byte';
COMMENT ON COLUMN costs.bytes_written IS 'Written to the store, byte';
COMMENT ON COLUMN costs.units IS 'Units of work';
COMMENT ON COLUMN costs.worker IS 'Workers that computed them';
COMMENT ON COLUMN costs.attempt IS 'Largest number of attempts of a unit';

CREATE VIEW runtime AS
WITH unit AS (
    SELECT unit_id, sum(wall_s) AS wall_s, sum(cpu_s) AS cpu_s, sum(evaluations) AS evaluations,
        sum(kernel_calls) AS kernel_calls, max(peak_rss_bytes) AS peak_rss_bytes, any_value(host_class) AS host_class
    FROM unit_costs GROUP BY unit_id
), charged AS (
    SELECT current_units.run_id, case_id, approach,
        CASE WHEN count(DISTINCT unit.host_class) = 1 THEN any_value(unit.host_class) END AS host_class,
        count(*) FILTER (unit.unit_id IS NULL) AS missing_units,
        sum(wall_s) AS wall_s, sum(cpu_s) AS cpu_s, sum(evaluations)::BIGINT AS evaluations, sum(kernel_calls)::BIGINT AS kernel_calls,
        max(peak_rss_bytes) AS peak_rss_bytes,
        coalesce(sum(wall_s) FILTER (scope IN ('speed', 'case')), 0) AS marginal_speed_wall_s,
        coalesce(sum(cpu_s) FILTER (scope IN ('speed', 'case')), 0) AS marginal_speed_cpu_s,
        coalesce(sum(evaluations) FILTER (scope IN ('speed', 'case')), 0)::BIGINT AS marginal_speed_evaluations
    FROM current_units LEFT JOIN unit USING (unit_id)
    GROUP BY current_units.run_id, case_id, approach
)
SELECT charged.run_id, case_id, soil, track, train, unevenness, speed_kmh, charged.approach, charged.host_class, charged.missing_units,
    charged.wall_s, charged.cpu_s, charged.evaluations, charged.kernel_calls, charged.peak_rss_bytes,
    charged.marginal_speed_wall_s, charged.marginal_speed_cpu_s, charged.marginal_speed_evaluations, runs.reference,
    CASE WHEN charged.missing_units + reference.missing_units = 0 AND charged.host_class = reference.host_class AND charged.cpu_s > 0
        THEN reference.cpu_s / charged.cpu_s END AS speed_up,
    CASE WHEN charged.missing_units + reference.missing_units = 0 AND charged.host_class = reference.host_class AND charged.marginal_speed_cpu_s > 0
        THEN reference.marginal_speed_cpu_s / charged.marginal_speed_cpu_s END AS marginal_speed_up
FROM charged
JOIN cases USING (case_id)
JOIN runs ON runs.run_id = charged.run_id
LEFT JOIN charged AS reference
    ON reference.run_id = charged.run_id AND reference.case_id = charged.case_id AND reference.approach = runs.reference;
COMMENT ON VIEW runtime IS 'Cost of each case and approach; work that several share is charged to each of them in full';
COMMENT ON COLUMN runtime.run_id IS 'Newest run that asked for the case, see runs';
COMMENT ON COLUMN runtime.case_id IS 'Case, see cases';
COMMENT ON COLUMN runtime.soil IS 'Name of the soil';
COMMENT ON COLUMN runtime.track IS 'Name of the track';
COMMENT ON COLUMN runtime.train IS 'Name of the train';
COMMENT ON COLUMN runtime.unevenness IS 'Name of the unevenness';
COMMENT ON COLUMN runtime.speed_kmh IS 'Train speed, km/h';
COMMENT ON COLUMN runtime.approach IS 'Approach that is charged';
COMMENT ON COLUMN runtime.host_class IS 'Kind of machine; NULL where several took part';
COMMENT ON COLUMN runtime.missing_units IS 'Units without a recorded cost, so that the sums are too small; 0 when complete';
COMMENT ON COLUMN runtime.wall_s IS 'Elapsed time, summed over units of work, s';
COMMENT ON COLUMN runtime.cpu_s IS 'Processor time, s';
COMMENT ON COLUMN runtime.evaluations IS 'Values of a transfer function computed, one per frequency and wavenumber';
COMMENT ON COLUMN runtime.kernel_calls IS 'Calls of compiled kernels';
COMMENT ON COLUMN runtime.peak_rss_bytes IS 'Largest resident memory of a worker, byte';
COMMENT ON COLUMN runtime.marginal_speed_wall_s IS 'Elapsed time that one more speed adds, s';
COMMENT ON COLUMN runtime.marginal_speed_cpu_s IS 'Processor time that one more speed adds, s';
COMMENT ON COLUMN runtime.marginal_speed_evaluations IS 'Values of a transfer function that one more speed adds';
COMMENT ON COLUMN runtime.reference IS 'Approach it is compared with';
COMMENT ON COLUMN runtime.speed_up IS 'Processor time of the reference over that of the approach, a ratio; NULL unless both are complete and from one kind of machine';
COMMENT ON COLUMN runtime.marginal_speed_up IS 'The same ratio for one more speed';

CREATE VIEW tradeoff AS
SELECT runtime.run_id, runtime.case_id, runtime.soil, runtime.track, runtime.train, runtime.unevenness, runtime.speed_kmh,
    runtime.approach, runtime.reference, contribution, quantity, avg(error_db) AS mean_error_db,
    avg(abs(error_db)) AS mean_absolute_error_db, max(abs(error_db)) AS largest_absolute_error_db,
    any_value(wall_s) AS wall_s, any_value(cpu_s) AS cpu_s, any_value(evaluations) AS evaluations,
    any_value(marginal_speed_cpu_s) AS marginal_speed_cpu_s, any_value(speed_up) AS speed_up
FROM accuracy JOIN runtime ON runtime.run_id = accuracy.run_id AND runtime.case_id = accuracy.case_id AND runtime.approach = accuracy.approach
GROUP BY ALL;
COMMENT ON VIEW tradeoff IS 'Error of each case and approach, over receivers and bands, beside its cost';
COMMENT ON COLUMN tradeoff.run_id IS 'Newest run that asked for the case, see runs';
COMMENT ON COLUMN tradeoff.case_id IS 'Case, see cases';
COMMENT ON COLUMN tradeoff.soil IS 'Name of the soil';
COMMENT ON COLUMN tradeoff.track IS 'Name of the track';
COMMENT ON COLUMN tradeoff.train IS 'Name of the train';
COMMENT ON COLUMN tradeoff.unevenness IS 'Name of the unevenness';
COMMENT ON COLUMN tradeoff.speed_kmh IS 'Train speed, km/h';
COMMENT ON COLUMN tradeoff.approach IS 'Approach of the prediction';
COMMENT ON COLUMN tradeoff.reference IS 'Approach it is compared with';
COMMENT ON COLUMN tradeoff.contribution IS 'dynamic, quasi-static or total';
COMMENT ON COLUMN tradeoff.quantity IS 'wheel_rail_force or velocity';
COMMENT ON COLUMN tradeoff.mean_error_db IS 'Mean of approach minus reference, dB';
COMMENT ON COLUMN tradeoff.mean_absolute_error_db IS 'Mean size of approach minus reference, dB';
COMMENT ON COLUMN tradeoff.largest_absolute_error_db IS 'Largest size of approach minus reference, dB';
COMMENT ON COLUMN tradeoff.wall_s IS 'Elapsed time, summed over units of work, s';
COMMENT ON COLUMN tradeoff.cpu_s IS 'Processor time, s';
COMMENT ON COLUMN tradeoff.evaluations IS 'Values of a transfer function computed, one per frequency and wavenumber';
COMMENT ON COLUMN tradeoff.marginal_speed_cpu_s IS 'Processor time that one more speed adds, s';
COMMENT ON COLUMN tradeoff.speed_up IS 'Processor time of the reference over that of the approach, a ratio';

CREATE MACRO compare(a, b) AS TABLE
SELECT first.run_id, first.case_id, first.soil, first.track, first.train, first.unevenness, first.speed_kmh, first.contribution,
    first.quantity, first.receiver, first.offset_m, first.averaging, first.band_hz, first.level_db AS a_level_db,
    second.level_db AS b_level_db, decibel(first.mean_square / second.mean_square) AS difference_db
FROM levels AS first
JOIN levels AS second ON second.run_id = first.run_id AND second.case_id = first.case_id AND second.contribution = first.contribution
    AND second.quantity = first.quantity AND second.receiver = first.receiver
    AND second.offset_m IS NOT DISTINCT FROM first.offset_m AND second.averaging = first.averaging AND second.band_hz = first.band_hz
WHERE first.approach = a AND second.approach = b;
COMMENT ON MACRO TABLE compare IS 'Levels of approach a beside those of approach b per case, receiver and band; difference_db is a minus b, dB';
