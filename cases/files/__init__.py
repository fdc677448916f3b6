"""Files, folders, command lines and interrupts: what knows no scene."""
