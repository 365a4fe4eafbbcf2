-- name: receiver
CASE place(quantity, receiver) WHEN 'force' THEN 'force, all axles'
    WHEN 'ground' THEN 'ground at ' || printf('%g', offset_m) || ' m' ELSE receiver END

-- name: errors
WITH pair AS ({rows})
SELECT {keys} avg(difference_db), avg(abs(difference_db)), arg_max(difference_db, abs(difference_db)),
    arg_max(band_hz, abs(difference_db)), count(*),
    min(CASE place(quantity, receiver) WHEN 'force' THEN -2 WHEN 'ground' THEN abs(offset_m) ELSE -1 END) AS distance
FROM pair
WHERE averaging = 'line' AND contribution = $contribution AND difference_db IS NOT NULL AND {condition}
{group}

-- name: places
SELECT DISTINCT place(quantity, receiver) FROM ({rows})

-- name: compared-cases
SELECT count(DISTINCT (case_id, soil, track, train, unevenness)) FROM ({rows})
WHERE averaging = 'line' AND contribution = $contribution
