"""Draw pictures and bars as terminal characters and escape sequences."""
