-- name: receivers
SELECT DISTINCT case_id, receiver, offset_m FROM bands JOIN current_units USING (source, unit_id, case_id, approach)

-- name: receptances
SELECT DISTINCT soil, track, speed_kmh FROM receptances ORDER BY ALL

-- name: with-lines
SELECT DISTINCT case_id FROM series JOIN current_units USING (source, unit_id, case_id, approach)
WHERE receiver = 'rail'

-- name: vehicle-lengths
SELECT length_m, count(*) FROM vehicles
WHERE train_id = (SELECT train_id FROM named_cases WHERE case_id = $1 LIMIT 1)
GROUP BY length_m ORDER BY count(*) DESC, length_m

-- name: compared-on-ground
SELECT DISTINCT approach FROM accuracy WHERE receiver = 'ground'
