-- name: levels
SELECT case_id, approach, receiver, offset_m, list(band_hz ORDER BY band_hz), list(level_db ORDER BY band_hz),
    list(coalesce(extrapolated_share, 0) ORDER BY band_hz)
FROM case_levels SEMI JOIN current_cases USING (run_id, case_id)
WHERE list_contains($1, case_id) AND list_contains($2, receiver) AND contribution = 'dynamic' AND averaging = 'line'
GROUP BY ALL

-- name: unevenness
SELECT wavelength_m, decibel(mean_square_m2 * 1e12) AS level, extrapolated_share FROM unevenness_bands
WHERE unevenness = $1 ORDER BY wavelength_m

-- name: receptance
-- Trains with other distances between axles have units of their own: one value per frequency.
SELECT speed_kmh, frequency_hz, arg_min(receptance_re, unit_id) AS re, arg_min(receptance_im, unit_id) AS im
FROM receptances, (SELECT min(band_hz) * 10 ** -0.05 AS lowest, max(band_hz) * 10 ** 0.05 AS highest FROM bands)
WHERE soil = $1 AND track = $2 AND list_contains($3, speed_kmh) AND frequency_hz > 0
    AND coalesce(frequency_hz BETWEEN lowest AND highest, true)
GROUP BY speed_kmh, frequency_hz ORDER BY frequency_hz

-- name: rail-series
SELECT case_id, approach, min(series_id)
FROM series JOIN current_units USING (source, unit_id, case_id, approach)
WHERE list_contains($1, case_id) AND receiver = 'rail' AND contribution = 'dynamic' AND averaging = 'line'
GROUP BY case_id, approach

-- name: lines
SELECT frequency_hz, value FROM psd_lines WHERE series_id = $1 ORDER BY frequency_hz

-- name: errors
SELECT soil, {by}, band_hz, avg(abs(error_db)) FROM accuracy
WHERE list_contains($1, soil) AND approach = $2 AND receiver = 'ground' AND contribution = 'dynamic'
GROUP BY ALL ORDER BY ALL

-- name: costs
SELECT approach, cpu_s, mean_absolute_error_db FROM tradeoff WHERE contribution = 'dynamic' AND place = $1
UNION ALL
SELECT approach, cpu_s, 0 FROM runtime WHERE approach = reference AND missing_units = 0
