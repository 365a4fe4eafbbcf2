-- name: columns
SELECT table_name, column_name, data_type, comment FROM duckdb_columns()
WHERE NOT internal AND database_name = 'results' AND list_contains($1, table_name)
ORDER BY table_name, column_index
