"""What a world is told: bodies, shapes, joints and surfaces, each checked when it is made."""
