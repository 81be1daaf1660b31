"""One compiled entry for each kind of world: exactly the stages that it calls for."""
