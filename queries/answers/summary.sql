-- name: missing
SELECT approach, count(DISTINCT (case_id, soil, track, train, unevenness)), any_value(error)
FROM missing GROUP BY approach ORDER BY approach

-- name: extrapolated
WITH shares AS (
    SELECT unevenness, speed_kmh, list(DISTINCT band_hz ORDER BY band_hz) FILTER (extrapolated_share > 0.5) AS bands,
        list(DISTINCT band_hz ORDER BY band_hz) AS every
    FROM levels WHERE averaging = 'line' GROUP BY ALL
)
SELECT unevenness, list(speed_kmh ORDER BY speed_kmh), bands, every
FROM shares WHERE bands IS NOT NULL GROUP BY unevenness, bands, every ORDER BY unevenness, min(speed_kmh)

-- name: by-place-and-band
SELECT place(quantity, receiver) AS place, band_hz, avg(abs(difference_db)), count(*)
FROM ({rows}) WHERE averaging = 'line' AND contribution = $contribution AND difference_db IS NOT NULL
GROUP BY place, band_hz ORDER BY band_hz DESC
