-- Which share of the total mean square is quasi-static, at the rail and by distance on the ground?
WITH energy AS (
    SELECT soil, speed_kmh, approach, receiver, offset_m, case_id,
        sum(mean_square) FILTER (contribution = 'quasi-static') AS quasi_static, sum(mean_square) FILTER (contribution = 'total') AS total
    FROM levels WHERE quantity = 'velocity' AND averaging = 'line' GROUP BY ALL
)
SELECT soil, speed_kmh, approach, receiver, offset_m, round(avg(quasi_static / total), 6) AS quasi_static_share,
    round(avg(decibel(quasi_static / total)), 1) AS quasi_static_over_total_db
FROM energy WHERE quasi_static IS NOT NULL AND total > 0
GROUP BY ALL ORDER BY soil, speed_kmh, approach, receiver DESC, offset_m
