-- Which approach gives the smallest error for its cost? Pareto: no other approach of the case is both cheaper and closer.
-- $quantity = 'velocity': velocity or wheel_rail_force
-- $place = 'ground': where the velocity is compared, ground or rail
WITH points AS (
    SELECT case_id, soil, track, train, unevenness, speed_kmh, approach, mean_absolute_error_db, largest_absolute_error_db, cpu_s
    FROM tradeoff
    WHERE contribution = 'dynamic' AND quantity = $quantity AND ($quantity <> 'velocity' OR place = $place)
    UNION ALL  -- the reference itself, without error
    SELECT case_id, soil, track, train, unevenness, speed_kmh, approach, 0, 0, cpu_s FROM runtime WHERE approach = reference
        AND EXISTS (FROM accuracy WHERE accuracy.case_id = runtime.case_id)
)
SELECT soil, speed_kmh, track, train, unevenness, approach, round(cpu_s, 3) AS cpu_s,
    round(mean_absolute_error_db, 2) AS mean_absolute_error_db, round(largest_absolute_error_db, 2) AS largest_absolute_error_db,
    NOT EXISTS (
        FROM points AS other WHERE other.case_id = points.case_id AND other.cpu_s <= points.cpu_s
            AND other.mean_absolute_error_db <= points.mean_absolute_error_db
            AND (other.cpu_s < points.cpu_s OR other.mean_absolute_error_db < points.mean_absolute_error_db)
    ) AS pareto
FROM points ORDER BY soil, speed_kmh, track, train, unevenness, points.cpu_s
