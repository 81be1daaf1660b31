"""Where to look next: settings along a front, values along an axis, effects that a scene does not need."""
