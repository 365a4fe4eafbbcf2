-- In which one-third octaves is an approach furthest from the reference, and where does the largest error occur?
-- $contribution = 'dynamic': dynamic, quasi-static or total
SELECT approach, quantity, place(quantity, receiver) AS place, round(band_hz, 2) AS band_hz, count(*) AS values,
    round(avg(error_db), 2) AS mean_error_db, round(avg(abs(error_db)), 2) AS mean_absolute_error_db,
    round(arg_max(error_db, abs(error_db)), 2) AS largest_error_db,
    arg_max(soil, abs(error_db)) AS soil, arg_max(speed_kmh, abs(error_db)) AS speed_kmh,
    arg_max(receiver, abs(error_db)) AS receiver, arg_max({'at': offset_m}, abs(error_db)).at AS offset_m
FROM accuracy WHERE contribution = $contribution
GROUP BY approach, quantity, place, accuracy.band_hz ORDER BY approach, quantity, place, accuracy.band_hz
