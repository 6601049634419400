"""Evidence that the firmware decides as the simulator does."""
