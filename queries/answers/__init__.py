"""What is asked of the results: comparisons, SQL, shipped questions, summaries and exports."""
