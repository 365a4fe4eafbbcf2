-- name: runs
SELECT run_id, study, started, finished, exit_status, host, host_class, threads, model_version, versions
FROM runs ORDER BY sequence

-- name: measured
SELECT run_id, measured_tasks, planned_cpu_s, measured_cpu_s, measured_wall_s, planned_bytes / 1e6, measured_bytes / 1e6,
    planned_peak_memory_bytes / 1e6, measured_peak_memory_bytes / 1e6
FROM runs ORDER BY sequence

-- name: row-counts
SELECT (SELECT count(*) FROM cases), (SELECT count(*) FROM bands), (SELECT count(*) FROM psd_lines),
    (SELECT count(*) FROM failures)

-- name: soils
SELECT soil, layer, thickness_m, shear_speed_m_s, dilatational_speed_m_s, rayleigh_speed_m_s, density_kg_m3, loss_factor
FROM soil_layers ORDER BY soil, soil_id, layer

-- name: failures
SELECT kind, unit_id, attempt, worker, error FROM failures ORDER BY kind, unit_id
