"""What BUTTON does with its workspace. Ref: S2 p. 137, 138.

The byte's encoding is not documented; ours (choice): 0 while the button is up, else how many
executions away the next repeat is; 255 stays 255 where none comes.
"""


def button(pressed: bool, delay: int, rate: int, work: int, target: int) -> tuple[int, bool]:
    """Return the new workspace, and whether the program goes to the label.

    With `target` 0 it goes there each time that nothing is to be done. Ref: S9 1.8 p. 250 (its
    example goes to a label "unless" the button was pressed).

    Args:
        pressed: the pin has the level of a button that is down.
        delay: executions from the press to the first repeat; 0 for neither debounce nor
            repeat, 255 for no repeat.
        rate: executions from one repeat to the next.
        work: the workspace.
        target: 1 goes to the label when the button acts, 0 when it does not.

    >>> button(True, 2, 5, 0, 1), button(True, 2, 5, 2, 1), button(True, 2, 5, 1, 1)
    ((2, True), (1, False), (5, True))
    """
    if delay == 0:
        return work, pressed == bool(target)
    if not pressed:
        return 0, target == 0
    if work == 0:
        return delay, target == 1
    if delay == 255:
        return 255, target == 0
    if work > 1:
        return work - 1, target == 0
    return max(rate, 1), target == 1
