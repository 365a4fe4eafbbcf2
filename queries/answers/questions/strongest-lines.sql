-- At which frequency does each narrow-band spectrum peak, and how far does the peak stand above the spectrum's mean density?
-- $contribution = 'dynamic': dynamic, quasi-static or total
WITH peaks AS (
    SELECT series_id, arg_max(frequency_hz, value) AS frequency_hz, max(value) AS density, avg(value) AS mean_density
    FROM psd_lines WHERE series_id IN (FROM (SELECT series_id FROM series WHERE contribution = $contribution)) GROUP BY series_id
)
SELECT soil, speed_kmh, approach, receiver, offset_m, averaging, round(frequency_hz, 3) AS peak_hz,
    round(decibel(density / mean_density), 1) AS peak_over_mean_db
FROM peaks JOIN series USING (series_id) JOIN cases USING (case_id)
ORDER BY soil, speed_kmh, approach, receiver DESC, offset_m, averaging
