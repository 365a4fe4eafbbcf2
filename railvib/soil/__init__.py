"""The layered half-space: its flexibility, rational fits of it, and what follows from them in closed form."""
