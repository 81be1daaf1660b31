"""The zoo: robots that packages of the index bring along, each put to every engine."""
