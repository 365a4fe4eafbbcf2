-- name: page-series
SELECT series_id, page_cases.number AS case_number, contribution,
    (page_approaches.number * $1 + page_contributions.number) * $2 + page_receivers.number AS spectrum
FROM series JOIN current_units USING (source, unit_id, case_id, approach) JOIN page_cases USING (case_id)
JOIN page_approaches USING (approach) JOIN page_contributions USING (contribution)
JOIN page_receivers ON page_receivers.quantity = series.quantity AND page_receivers.receiver = series.receiver
    AND page_receivers.offset_m IS NOT DISTINCT FROM series.offset_m
WHERE averaging = 'line' AND series.receiver IN ('rail', 'ground', 'axle-1', 'axle-2')

-- name: page-grids
SELECT case_number, min(frequency_hz) AS first, max(frequency_hz) AS last, count(*) AS lines
FROM psd_lines
JOIN (SELECT case_number, min(series_id) AS series_id FROM page_series GROUP BY case_number) USING (series_id)
WHERE frequency_hz > 0 GROUP BY case_number

-- name: counts
SELECT (SELECT count(*) FROM page_series), (SELECT count(*) FROM page_series WHERE contribution = 'dynamic'),
    (SELECT coalesce(max(lines), 0) FROM page_grids), (SELECT count(*) FROM page_grids)

-- name: series
SELECT case_number, spectrum, series_id, first, last FROM page_series JOIN page_grids USING (case_number)
WHERE contribution = 'dynamic' OR NOT $1 ORDER BY case_number, spectrum

-- name: scales
SELECT CASE WHEN quantity = 'wheel_rail_force' THEN 1.0 ELSE 1e18 END AS scale FROM page_receivers ORDER BY number

-- name: lines
SELECT series_id, frequency_hz, value FROM psd_lines WHERE series_id BETWEEN $1 AND $2
