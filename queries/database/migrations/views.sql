-- Views and macros of results.duckdb, made anew when a file is written by a version that has others. What a view's columns
-- mean stands in comments.toml. Those named run_… show every run; the others show each case by the newest run that asked for it.

CREATE MACRO decibel(ratio) AS CASE WHEN isfinite(ratio) AND ratio > 0 THEN 10 * log10(ratio) END;
COMMENT ON MACRO decibel IS 'Ten times the decimal logarithm of a ratio of mean squares, dB; NULL unless positive and finite';

CREATE MACRO place(quantity, receiver) AS CASE WHEN quantity = 'wheel_rail_force' THEN 'force' ELSE receiver END;
COMMENT ON MACRO place IS 'What may be averaged: force (of all axles), rail or ground (at all offsets); two places are never pooled';

CREATE VIEW current_cases AS
SELECT run_cases.case_id, arg_max(runs.run_id, runs.sequence) AS run_id
FROM run_cases JOIN runs USING (run_id) GROUP BY run_cases.case_id;

CREATE VIEW run_units AS
SELECT run_id, source, case_id, approach, unit_id, scope FROM case_units JOIN runs USING (run_id);

CREATE VIEW current_units AS
SELECT run_id, source, case_id, approach, unit_id, scope FROM run_units JOIN current_cases USING (run_id, case_id);

CREATE VIEW named_cases AS
SELECT cases.rowid AS place, case_id, soil, track, train, unevenness, speed_kmh, train_id
FROM cases JOIN current_cases USING (case_id) JOIN runs USING (run_id)
QUALIFY row_number() OVER (PARTITION BY soil, track, train, unevenness, speed_kmh ORDER BY sequence DESC, cases.rowid DESC) = 1;

CREATE VIEW missing AS
SELECT current_units.run_id, case_id, soil, track, train, unevenness, speed_kmh, approach, scope, current_units.unit_id, failures.kind, failures.error
FROM current_units JOIN cases USING (case_id)
LEFT JOIN failures ON failures.source = current_units.source AND failures.unit_id = current_units.unit_id
WHERE failures.unit_id IS NOT NULL
    OR NOT EXISTS (FROM units WHERE units.source = current_units.source AND units.unit_id = current_units.unit_id);

CREATE VIEW case_parameters AS
WITH lowest AS (SELECT soil_id, min(shear_speed_m_s) AS lowest_shear_speed_m_s FROM soil_layers GROUP BY soil_id),
loads AS (SELECT train_id, avg(axle_load_n) AS mean_axle_load_n FROM axles GROUP BY train_id)
SELECT case_id, cases.soil, cases.track, cases.train, cases.unevenness, speed_kmh, speed_kmh / 3.6 AS speed_m_s,
    top.thickness_m, top.shear_speed_m_s, top.dilatational_speed_m_s, top.density_kg_m3, top.loss_factor, top.rayleigh_speed_m_s,
    speed_kmh / 3.6 / top.rayleigh_speed_m_s AS speed_over_rayleigh_speed, lowest_shear_speed_m_s, soils.layers,
    tracks.form AS track_form, rail_bending_stiffness_n_m2, rail_mass_kg_m, pad_stiffness_n_m2, sleeper_mass_kg_m,
    ballast.stiffness_n_m2 AS ballast_stiffness_n_m2, contact_width_m,
    trains.vehicles, trains.axles, trains.length_m AS train_length_m, mean_axle_load_n, unevenness.form AS unevenness_form
FROM cases
LEFT JOIN soils USING (soil_id) LEFT JOIN lowest USING (soil_id)
LEFT JOIN soil_layers AS top ON top.soil_id = cases.soil_id AND top.layer = 1
LEFT JOIN tracks USING (track_id)
LEFT JOIN track_layers AS ballast ON ballast.track_id = cases.track_id AND ballast.layer = 1
LEFT JOIN trains USING (train_id) LEFT JOIN loads USING (train_id)
LEFT JOIN unevenness USING (unevenness_id);

-- Names come last: a case that has two has a row for each in every view that shows names.
CREATE VIEW case_levels AS
SELECT run_id, case_id, approach, contribution, quantity, receiver, offset_m, averaging, band_hz, mean_square, extrapolated_share,
    CASE quantity WHEN 'wheel_rail_force' THEN 1.0 ELSE 1e-9 END AS reference_value,
    CASE WHEN peak_mean_square IS NULL OR mean_square >= 1e-20 * peak_mean_square
        THEN decibel(CASE quantity WHEN 'wheel_rail_force' THEN mean_square ELSE mean_square * 1e18 END) END AS level_db
FROM (SELECT * EXCLUDE run_id FROM bands) JOIN run_units USING (source, unit_id, case_id, approach);

CREATE VIEW run_levels AS
SELECT run_id, case_id, soil, track, train, unevenness, speed_kmh, approach, contribution, quantity, receiver, offset_m, averaging,
    band_hz, mean_square, extrapolated_share, reference_value, level_db
FROM case_levels JOIN cases USING (case_id);

CREATE VIEW levels AS
SELECT run_levels.* FROM run_levels SEMI JOIN current_cases USING (run_id, case_id);

CREATE VIEW psd AS
SELECT case_id, approach, contribution, quantity, receiver, offset_m, averaging, frequency_hz, value, run_id, model_version, unit_id, source
FROM psd_lines JOIN series USING (series_id);

CREATE VIEW run_accuracy AS
SELECT approach.run_id, approach.case_id, soil, track, train, unevenness, speed_kmh, approach.approach, runs.reference, approach.contribution,
    approach.quantity, approach.receiver, approach.offset_m, approach.band_hz, approach.level_db,
    reference.level_db AS reference_level_db, decibel(approach.mean_square / reference.mean_square) AS error_db, approach.extrapolated_share
FROM case_levels AS approach
JOIN runs ON runs.run_id = approach.run_id
JOIN case_levels AS reference ON reference.approach = runs.reference AND reference.run_id = approach.run_id
    AND reference.case_id = approach.case_id AND reference.contribution = approach.contribution
    AND reference.quantity = approach.quantity AND reference.receiver = approach.receiver
    AND reference.offset_m IS NOT DISTINCT FROM approach.offset_m AND reference.averaging = approach.averaging
    AND reference.band_hz = approach.band_hz
JOIN cases ON cases.case_id = approach.case_id
WHERE approach.approach <> runs.reference AND approach.averaging = 'line'
    AND approach.level_db IS NOT NULL AND reference.level_db IS NOT NULL;

CREATE VIEW accuracy AS
SELECT run_accuracy.* FROM run_accuracy SEMI JOIN current_cases USING (run_id, case_id);

CREATE VIEW costs AS
SELECT current_units.run_id, case_id, approach, scope, unit_costs.kind, stage, sum(wall_s) AS wall_s, sum(cpu_s) AS cpu_s,
    sum(evaluations)::BIGINT AS evaluations, sum(kernel_calls)::BIGINT AS kernel_calls, max(peak_rss_bytes) AS peak_rss_bytes,
    sum(bytes_written)::BIGINT AS bytes_written, count(DISTINCT unit_id) AS units,
    string_agg(DISTINCT worker, ', ' ORDER BY worker) AS worker, max(attempt) AS attempt
FROM current_units JOIN unit_costs USING (source, unit_id)
GROUP BY current_units.run_id, case_id, approach, scope, unit_costs.kind, stage;

CREATE VIEW run_runtime AS
WITH unit AS (
    SELECT source, unit_id, sum(wall_s) AS wall_s, sum(cpu_s) AS cpu_s, sum(evaluations) AS evaluations,
        sum(kernel_calls) AS kernel_calls, max(peak_rss_bytes) AS peak_rss_bytes, any_value(host_class) AS host_class
    FROM unit_costs GROUP BY source, unit_id
), charged AS (
    SELECT run_units.run_id, case_id, approach,
        CASE WHEN count(DISTINCT unit.host_class) = 1 THEN any_value(unit.host_class) END AS host_class,
        count(*) FILTER (unit.unit_id IS NULL) AS missing_units,
        sum(wall_s) AS wall_s, sum(cpu_s) AS cpu_s, sum(evaluations)::BIGINT AS evaluations, sum(kernel_calls)::BIGINT AS kernel_calls,
        max(peak_rss_bytes) AS peak_rss_bytes,
        coalesce(sum(wall_s) FILTER (scope IN ('speed', 'case')), 0) AS marginal_speed_wall_s,
        coalesce(sum(cpu_s) FILTER (scope IN ('speed', 'case')), 0) AS marginal_speed_cpu_s,
        coalesce(sum(evaluations) FILTER (scope IN ('speed', 'case')), 0)::BIGINT AS marginal_speed_evaluations
    FROM run_units LEFT JOIN unit USING (source, unit_id)
    GROUP BY run_units.run_id, case_id, approach
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

CREATE VIEW runtime AS
SELECT run_runtime.* FROM run_runtime SEMI JOIN current_cases USING (run_id, case_id);

CREATE VIEW tradeoff AS
SELECT run_id, case_id, soil, track, train, unevenness, speed_kmh, approach, runtime.reference, contribution, quantity,
    place(quantity, receiver) AS place, avg(error_db) AS mean_error_db, avg(abs(error_db)) AS mean_absolute_error_db,
    max(abs(error_db)) AS largest_absolute_error_db, any_value(wall_s) AS wall_s, any_value(cpu_s) AS cpu_s,
    any_value(evaluations) AS evaluations, any_value(marginal_speed_cpu_s) AS marginal_speed_cpu_s, any_value(speed_up) AS speed_up
FROM accuracy JOIN runtime USING (run_id, case_id, soil, track, train, unevenness, speed_kmh, approach)
GROUP BY ALL;

CREATE MACRO compare(a, b) AS TABLE
SELECT first.run_id, first.case_id, soil, track, train, unevenness, speed_kmh, first.contribution, first.quantity, first.receiver,
    first.offset_m, first.averaging, first.band_hz, first.level_db AS a_level_db, second.level_db AS b_level_db,
    CASE WHEN first.level_db + second.level_db IS NOT NULL THEN decibel(first.mean_square / second.mean_square) END AS difference_db
FROM (FROM case_levels SEMI JOIN current_cases USING (run_id, case_id)) AS first
JOIN case_levels AS second ON second.run_id = first.run_id AND second.case_id = first.case_id AND second.contribution = first.contribution
    AND second.quantity = first.quantity AND second.receiver = first.receiver
    AND second.offset_m IS NOT DISTINCT FROM first.offset_m AND second.averaging = first.averaging AND second.band_hz = first.band_hz
JOIN cases ON cases.case_id = first.case_id
WHERE first.approach = a AND second.approach = b;
COMMENT ON MACRO TABLE compare IS 'Levels of approach a beside those of approach b per case, receiver and band; difference_db is a minus b, dB';

CREATE MACRO compare_runs(a, b) AS TABLE
SELECT first.soil, first.track, first.train, first.unevenness, first.speed_kmh, first.approach, first.contribution,
    first.quantity, first.receiver, first.offset_m, first.averaging, first.band_hz, first.level_db AS a_level_db,
    second.level_db AS b_level_db, CASE WHEN first.level_db + second.level_db IS NOT NULL THEN decibel(first.mean_square / second.mean_square) END AS difference_db
FROM run_levels AS first
JOIN run_levels AS second ON second.soil = first.soil AND second.track = first.track AND second.train = first.train
    AND second.unevenness = first.unevenness AND second.speed_kmh = first.speed_kmh AND second.approach = first.approach
    AND second.contribution = first.contribution AND second.quantity = first.quantity AND second.receiver = first.receiver
    AND second.offset_m IS NOT DISTINCT FROM first.offset_m AND second.averaging = first.averaging AND second.band_hz = first.band_hz
WHERE first.run_id = a AND second.run_id = b;
COMMENT ON MACRO TABLE compare_runs IS 'Levels of run a beside those of run b for cases and approaches of the same names; difference_db is a minus b, dB';

CREATE VIEW passages AS
SELECT current_units.run_id, case_id, soil, track, train, unevenness, speed_kmh, approach, receiver, offset_m, component, metric, statistic, value, unit
FROM (SELECT * EXCLUDE run_id FROM passage_levels) JOIN current_units USING (source, unit_id, case_id, approach) JOIN cases USING (case_id);

CREATE VIEW passage_accuracy AS
SELECT approach.run_id, approach.case_id, approach.soil, approach.track, approach.train, approach.unevenness, approach.speed_kmh, approach.approach,
    runs.reference, approach.receiver, approach.offset_m, approach.component, approach.metric, approach.statistic, approach.value,
    reference.value AS reference_value, 2 * decibel(approach.value / reference.value) AS error_db, approach.unit
FROM passages AS approach
JOIN runs ON runs.run_id = approach.run_id
JOIN passages AS reference ON reference.approach = runs.reference AND reference.run_id = approach.run_id
    AND reference.case_id = approach.case_id AND reference.soil = approach.soil AND reference.track = approach.track
    AND reference.train = approach.train AND reference.unevenness = approach.unevenness AND reference.speed_kmh = approach.speed_kmh
    AND reference.receiver = approach.receiver AND reference.offset_m IS NOT DISTINCT FROM approach.offset_m
    AND reference.component = approach.component AND reference.metric = approach.metric AND reference.statistic = approach.statistic
WHERE approach.approach <> runs.reference;
