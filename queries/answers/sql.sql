-- name: functions-that-read
SELECT function_name FROM duckdb_functions()
WHERE function_type = 'table_macro' OR (function_type = 'table'
    AND (function_name LIKE 'duckdb\_%' ESCAPE '\' OR function_name LIKE 'pragma\_%' ESCAPE '\'))
