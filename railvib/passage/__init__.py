"""The passage of a train as a random process in time, and the levels that engineers report of it."""
