-- Which cases exceed a level at a receiver, by which approach, and by how much?
-- $level_db = 80.0: level that is exceeded, dB re 1e-9 m/s for velocity, re 1 N for wheel_rail_force
-- $receiver = 'ground': ground, rail or axle-1 and so on
-- $contribution = 'total': dynamic, quasi-static or total
SELECT soil, track, train, unevenness, speed_kmh, approach, receiver, offset_m, count(*) AS bands_above,
    round(arg_max(band_hz, level_db), 2) AS highest_band_hz, round(max(level_db), 1) AS highest_level_db,
    round(max(level_db) - $level_db, 1) AS above_db
FROM levels
WHERE receiver = $receiver AND contribution = $contribution AND averaging = 'line' AND level_db > $level_db
GROUP BY ALL ORDER BY above_db DESC, soil, speed_kmh, approach, offset_m
