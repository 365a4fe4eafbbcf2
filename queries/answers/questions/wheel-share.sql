-- Which share of the dynamic mean square comes from wheels out of round, in each one-third octave?
WITH energy AS (
    SELECT train, approach, quantity, receiver, offset_m, band_hz, case_id,
        sum(mean_square) FILTER (contribution = 'wheels') AS wheels, sum(mean_square) FILTER (contribution = 'dynamic') AS dynamic
    FROM levels WHERE averaging = 'line' AND (quantity = 'velocity' OR receiver = 'axle-1') GROUP BY ALL
)
SELECT train, approach, quantity, receiver, offset_m, round(band_hz, 2) AS band_hz, round(avg(wheels / dynamic), 6) AS wheel_share,
    round(avg(decibel(dynamic / (dynamic - wheels))), 2) AS wheels_add_db
FROM energy WHERE wheels IS NOT NULL AND dynamic > wheels
GROUP BY train, approach, quantity, receiver, offset_m, energy.band_hz
ORDER BY train, approach, quantity DESC, receiver DESC, offset_m, energy.band_hz
