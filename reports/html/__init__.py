"""From pages to files: templates, policy, pictures drawn beside, and the report as a whole."""
