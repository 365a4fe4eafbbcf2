"""The results in DuckDB: its schema, and how stored records and arrays get into it."""
