-- Which cases exceed a value of a passage's metric, such as KB_Fmax, by which approach, and by how much?
-- $value = 0.1: value that is exceeded, in the unit of the metric: 1 for KB, m/s for velocities, m/s^1.75 for vdv
-- $metric = 'kb-f-max': kb-f-max, v-max-fast, v-max-slow, ppv, vdv, or third-octave-max-fast and the band
-- $statistic = 'q0.95': mean, expected, or a quantile of the study
-- $receiver = 'ground': ground or rail
SELECT soil, track, train, unevenness, speed_kmh, approach, receiver, offset_m, metric, statistic, value, unit,
    round(20 * log10(value / $value), 1) AS above_db
FROM passages
WHERE receiver = $receiver AND metric = $metric AND statistic = $statistic AND value > $value
ORDER BY above_db DESC, soil, speed_kmh, approach, offset_m
