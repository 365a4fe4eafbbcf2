"""Speed on this machine, beside what a user could run instead and what the machine could do at most."""
