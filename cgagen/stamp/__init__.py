"""Facts of the BASIC Stamp 2 family: no time, no I/O, standard library only."""
