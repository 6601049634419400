"""Parts: circuits on wires with a clock, one file each.

A part knows no chip and no world. Whoever owns the world turns its knobs (`Ping.see`,
`Whisker.touch`, `Photocell.light`); each file says what its part leaves out.
"""
