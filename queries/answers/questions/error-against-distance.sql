-- How does the error on the ground change with the distance from the track?
-- $contribution = 'dynamic': dynamic, quasi-static or total
SELECT approach, soil, offset_m, count(*) AS values, round(avg(error_db), 2) AS mean_error_db,
    round(avg(abs(error_db)), 2) AS mean_absolute_error_db, round(max(abs(error_db)), 2) AS largest_absolute_error_db
FROM accuracy WHERE contribution = $contribution AND receiver = 'ground'
GROUP BY approach, soil, offset_m ORDER BY approach, soil, offset_m
