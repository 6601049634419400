"""The wire to a chip: ports, their locks, and what is said on them below any program."""
