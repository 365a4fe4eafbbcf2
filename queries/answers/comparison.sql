-- name: two-runs
SELECT first.case_id, {columns}, first.level_db AS a_level_db, second.level_db AS b_level_db,
    CASE WHEN first.level_db + second.level_db IS NOT NULL
        THEN decibel(first.mean_square / second.mean_square) END AS difference_db
FROM {first} AS first JOIN {second} AS second ON {same}
WHERE first.offset_m IS NOT DISTINCT FROM second.offset_m
