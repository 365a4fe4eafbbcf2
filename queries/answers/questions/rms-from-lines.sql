-- What is the effective value of each narrow-band spectrum, and how far is it from the sum of its one-third octaves?
-- $contribution = 'dynamic': dynamic, quasi-static or total
WITH lines AS (
    SELECT series_id, sum(value) * (max(frequency_hz) - min(frequency_hz)) / (count(*) - 1) AS mean_square
    FROM psd_lines WHERE series_id IN (SELECT series_id FROM series WHERE contribution = $contribution)
    GROUP BY series_id HAVING count(*) > 1
), octaves AS (
    SELECT source, unit_id, case_id, approach, contribution, quantity, receiver, offset_m, averaging, sum(mean_square) AS mean_square
    FROM bands WHERE contribution = $contribution GROUP BY ALL
)
SELECT soil, speed_kmh, series.approach, series.receiver, series.offset_m, series.averaging, series.quantity,
    sqrt(lines.mean_square) AS effective_value, round(decibel(lines.mean_square / octaves.mean_square), 2) AS lines_over_bands_db
FROM lines JOIN series USING (series_id) JOIN cases USING (case_id)
JOIN octaves ON octaves.source = series.source AND octaves.unit_id = series.unit_id AND octaves.case_id = series.case_id
    AND octaves.approach = series.approach AND octaves.contribution = series.contribution AND octaves.quantity = series.quantity
    AND octaves.receiver = series.receiver AND octaves.offset_m IS NOT DISTINCT FROM series.offset_m
    AND octaves.averaging = series.averaging
ORDER BY soil, speed_kmh, series.approach, series.receiver DESC, series.offset_m, series.averaging
