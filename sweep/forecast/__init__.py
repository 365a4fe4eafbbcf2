"""What a run will take: rates of this machine, amounts of work, memory and disk."""
