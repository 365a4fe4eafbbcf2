-- How does the error on the ground grow as the train's speed approaches the Rayleigh speed of the ground's top layer?
-- $contribution = 'dynamic': dynamic, quasi-static or total
SELECT approach, round(speed_over_rayleigh_speed, 3) AS speed_over_rayleigh_speed, soil, speed_kmh,
    count(*) AS values, round(avg(error_db), 2) AS mean_error_db, round(avg(abs(error_db)), 2) AS mean_absolute_error_db,
    round(max(abs(error_db)), 2) AS largest_absolute_error_db
FROM accuracy JOIN case_parameters USING (case_id, soil, track, train, unevenness, speed_kmh)
WHERE contribution = $contribution AND receiver = 'ground'
GROUP BY approach, case_parameters.speed_over_rayleigh_speed, soil, speed_kmh
ORDER BY approach, case_parameters.speed_over_rayleigh_speed NULLS LAST, soil, speed_kmh
