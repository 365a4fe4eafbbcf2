"""The rail under moving and standing loads, and the wheel–rail forces of a train."""
