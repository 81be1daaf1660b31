"""What a metric is called in sentences and headings: its name says the quantity first and how it is summed up last."""

ADJECTIVES = {
    "max": "largest",
    "min": "smallest",
    "final": "final",
    "staggered": "staggered",
    "rms": "rms",
    "mean": "mean",
    "median": "median",
}
"""How a number is drawn from a series, by the last words of a name."""
SPELT = {"iou": "IoU", "imu": "IMU", "rms": "rms", "painleve": "Painlevé"}
"""Words that are no plain English."""
LONGEST = 80


def metric_title(name: str) -> str:
    """'largest position error' of 'position_error_max'; a second measurement of one metric keeps its number: 'creep (2)'."""
    quantity, _, again = name[:LONGEST].partition(" #")
    words = quantity.split("_")
    before: list[str] = []
    while len(words) > 1 and words[-1] in ADJECTIVES:
        before.append(ADJECTIVES[words.pop()])
    title = " ".join([*before, *(SPELT.get(word, word) for word in words)])
    return f"{title} ({again})" if again else title
