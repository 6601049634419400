"""The simulated arena: the world step, the batch kernel and single episodes."""
