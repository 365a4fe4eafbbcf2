"""The compiled functions of `railvib.soil`: they take arrays as they come and check nothing."""
