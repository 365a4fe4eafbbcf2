-- name: number-runs
UPDATE runs SET sequence = ordered.place
FROM (SELECT run_id, row_number() OVER (ORDER BY started NULLS FIRST, run_id) AS place FROM runs) AS ordered
WHERE runs.run_id = ordered.run_id

-- name: drop-lines
DELETE FROM psd_lines
WHERE series_id IN (SELECT series_id FROM series WHERE source = $1 AND list_contains($2, unit_id))

-- name: digest
SELECT md5(string_agg(row::VARCHAR, chr(10) ORDER BY row::VARCHAR)) FROM ({query}) AS row
