-- name: has-versions
SELECT 1 FROM duckdb_tables()
WHERE database_name = current_database() AND table_name = 'schema_version'

-- name: views
SELECT view_name FROM duckdb_views() WHERE NOT internal AND database_name = current_database()

-- name: macros
SELECT DISTINCT function_name, function_type FROM duckdb_functions()
WHERE NOT internal AND database_name = current_database() AND function_type LIKE '%macro'

-- name: columns-of-views
SELECT view_name, NULL FROM duckdb_views() WHERE NOT internal AND database_name = current_database()
UNION ALL
SELECT table_name, column_name FROM duckdb_columns()
WHERE NOT internal AND database_name = current_database()
    AND table_name IN (SELECT view_name FROM duckdb_views())
