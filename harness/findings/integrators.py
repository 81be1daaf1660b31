"""What integrators are called in a sentence and in a table."""

_NAMES = {
    "euler": "Euler",
    "semi_implicit_euler": "semi-implicit Euler",
    "explicit_euler": "explicit Euler",
    "velocity_verlet": "velocity Verlet",
    "rk4": "Runge-Kutta of order 4",
    "splitting_4": "splitting of order 4",
    "splitting_8": "splitting of order 8",
    "dormand_prince": "Dormand-Prince",
}


def called(name: str) -> str:
    """'semi-implicit Euler' for 'semi_implicit_euler'; one that has no other name goes by its own."""
    return _NAMES.get(name) or name.replace("_", " ")
