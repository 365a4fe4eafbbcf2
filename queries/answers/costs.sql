-- name: per-case
SELECT {keys} approach, sum(missing_units), avg(evaluations), avg(cpu_s), avg(wall_s), avg(speed_up),
    avg(marginal_speed_cpu_s), avg(marginal_speed_up)
FROM runtime GROUP BY {keys} approach

-- name: two-runs
SELECT first.approach, count(*), avg(first.evaluations), avg(second.evaluations), avg(first.cpu_s), avg(second.cpu_s),
    CASE WHEN bool_and(coalesce(first.host_class = second.host_class, false)) THEN avg(second.cpu_s) / avg(first.cpu_s) END
FROM {first} AS first JOIN {second} AS second ON {same}
GROUP BY first.approach

-- name: mean-per-approach
SELECT approach, avg(cpu_s), avg(speed_up), avg(marginal_speed_cpu_s), avg(marginal_speed_up) FROM runtime GROUP BY approach
