-- How far is each approach off the reference in a passage's metric, such as KB_Fmax?
-- $metric = 'kb-f-max': kb-f-max, v-max-fast, v-max-slow, ppv, vdv, or third-octave-max-fast and the band
-- $statistic = 'q0.5': mean, expected, or a quantile of the study
SELECT approach, reference, receiver, offset_m, metric, statistic, count(*) AS cases, round(avg(error_db), 2) AS mean_error_db,
    round(min(error_db), 2) AS smallest_error_db, round(max(error_db), 2) AS largest_error_db
FROM passage_accuracy
WHERE metric = $metric AND statistic = $statistic
GROUP BY ALL ORDER BY approach, receiver DESC, offset_m
