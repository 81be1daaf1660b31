"""What is to be run: studies and their trials, the plug-ins that they call, and what an answer rests on."""
