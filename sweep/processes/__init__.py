"""Processes of this machine: forked from one that has loaded everything, and ended with their parent."""
