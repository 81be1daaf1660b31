"""Pictures of scenes for pages: solids met by parallel rays, lit by a sun, on a ground that lets the page through."""
