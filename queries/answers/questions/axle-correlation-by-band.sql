-- What does the correlation between axles do in each one-third octave? Correlated minus uncorrelated moving roughness.
-- $contribution = 'dynamic': dynamic or total
SELECT quantity, receiver, offset_m, round(band_hz, 2) AS band_hz, count(*) AS cases,
    round(avg(difference_db), 2) AS mean_effect_db, round(min(difference_db), 2) AS smallest_effect_db,
    round(max(difference_db), 2) AS largest_effect_db
FROM compare('moving-roughness', 'moving-roughness-uncorrelated') AS pair
WHERE contribution = $contribution AND averaging = 'line'
    AND receiver IN ('axle-1', 'axle-2', 'rail', 'ground')
GROUP BY quantity, receiver, offset_m, pair.band_hz ORDER BY quantity DESC, receiver DESC, offset_m, pair.band_hz
