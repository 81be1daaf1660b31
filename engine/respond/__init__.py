"""How contacts answer: soft constraints, sequential impulses, exact laws, events."""
