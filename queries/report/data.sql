-- name: page-cases
SELECT case_id, soil, track, train, unevenness, speed_kmh, (row_number() OVER (ORDER BY place) - 1)::INTEGER AS number
FROM named_cases

-- name: page-receivers
SELECT quantity, receiver, offset_m, (row_number() OVER (
    ORDER BY quantity = 'wheel_rail_force', CASE receiver WHEN 'rail' THEN 0 WHEN 'ground' THEN 1 ELSE 2 END, abs(offset_m),
    offset_m, try_cast(replace(receiver, 'axle-', '') AS INTEGER), receiver) - 1)::INTEGER AS number
FROM (SELECT DISTINCT quantity, receiver, offset_m FROM bands)

-- name: page-bands
SELECT band_hz, (row_number() OVER (ORDER BY band_hz) - 1)::INTEGER AS number FROM (SELECT DISTINCT band_hz FROM bands)

-- name: page-approaches
SELECT unnest($1) AS approach, generate_subscripts($1, 1)::INTEGER - 1 AS number

-- name: page-contributions
SELECT unnest($1) AS contribution, generate_subscripts($1, 1)::INTEGER - 1 AS number

-- name: levels
SELECT (((page_cases.number * $1 + page_approaches.number) * $2 + page_contributions.number) * $3
    + page_receivers.number)::BIGINT * $4 + page_bands.number AS place, level_db
FROM case_levels SEMI JOIN current_cases USING (run_id, case_id)
JOIN page_cases USING (case_id) JOIN page_approaches USING (approach) JOIN page_contributions USING (contribution)
JOIN page_bands USING (band_hz)
JOIN page_receivers ON page_receivers.quantity = case_levels.quantity AND page_receivers.receiver = case_levels.receiver
    AND page_receivers.offset_m IS NOT DISTINCT FROM case_levels.offset_m
WHERE averaging = 'line' AND level_db IS NOT NULL

-- name: extrapolated
SELECT page_cases.number, list(DISTINCT page_bands.number ORDER BY page_bands.number)
FROM case_levels SEMI JOIN current_cases USING (run_id, case_id)
JOIN page_cases USING (case_id) JOIN page_bands USING (band_hz)
WHERE averaging = 'line' AND extrapolated_share > 0.5 GROUP BY page_cases.number

-- name: receptances
-- Trains with other distances between axles have units of their own: one value per frequency.
WITH ends AS (SELECT min(band_hz) * 10 ** -0.05 AS lowest, max(band_hz) * 10 ** 0.05 AS highest FROM page_bands),
single AS (
    SELECT soil, track, speed_kmh, frequency_hz, arg_min(receptance_re, unit_id) AS re, arg_min(receptance_im, unit_id) AS im
    FROM receptances, ends
    WHERE frequency_hz > 0 AND coalesce(frequency_hz BETWEEN lowest AND highest, true) GROUP BY ALL
)
SELECT soil, track, speed_kmh, list(frequency_hz ORDER BY frequency_hz), list(re ORDER BY frequency_hz), list(im ORDER BY frequency_hz)
FROM single GROUP BY ALL ORDER BY ALL

-- name: unevenness
SELECT unevenness, list(wavelength_m ORDER BY wavelength_m), list(decibel(mean_square_m2 * 1e12) ORDER BY wavelength_m),
    list(coalesce(extrapolated_share, 0) ORDER BY wavelength_m)
FROM unevenness_bands GROUP BY unevenness, unevenness_id ORDER BY unevenness

-- name: costs
SELECT page_cases.number, page_approaches.number, missing_units = 0, cpu_s, marginal_speed_cpu_s, evaluations
FROM runtime JOIN page_cases USING (case_id, soil, track, train, unevenness) JOIN page_approaches USING (approach)
ORDER BY ALL

-- name: trains
SELECT vehicles.train, length_m, axle_spacing_m, count(*)
FROM vehicles SEMI JOIN named_cases USING (train_id)
GROUP BY ALL ORDER BY vehicles.train, count(*) DESC, length_m
